/* Events of closed contacts within a step: they separate, become slack, turn, or leave a piece of their law. */
#include "adaptive/run.h"
#include "adaptive/step.h"
#include "law/law.h"
#include "motion/free.h"
#include "motion/polynomial.h"
#include "motion/radau.h"
#include "motion/nodes.h"
#include "collocation/collocation.h"

#include <float.h>
#include <math.h>

/* A contact with a negligible force is opened only if its indentation is at most this share of the tolerance of a
 * touch. The contact then stays open up to half that tolerance, so that it does not close at once. Tried with a
 * third and three times the value: no run changes. */
static const double SKIP_SHARE = 0.1;

/* True if a function of time falls below zero in the step; sets `place` to the position (0 to 1). If the function
 * is within the tolerance below zero at the end and never lower, the position is the end. Otherwise the position
 * is where the function is half the tolerance below zero. */
static int falls_below(const double *values, double tolerance, double *place)
{
    double coefficient[AOI_NODES + 1];
    int early = 0;
    for (size_t i = 1; i < AOI_NODES; i++) {
        early = early || values[i] < -tolerance;
    }
    if (!early && !(values[AOI_NODES] < 0.0)) {
        return 0;
    }
    *place = 1.0;
    if (early || values[AOI_NODES] < -tolerance) {
        aoi_legendre_fit(values[0], values + 1, coefficient);
        (void)aoi_legendre_falls(values, coefficient, -0.5 * tolerance, place);
    }
    return 1;
}

/* Notes an event of the given kind where a function of time, given at the start and the nodes, falls below zero. */
static void falls(const double *values, double tolerance, int kind, aoi_adaptive_contact *contact,
                  aoi_attempt *attempt)
{
    double place;
    if (falls_below(values, tolerance, &place)) {
        aoi_step_note_event(place, kind, contact, attempt);
    }
}

/* True if the function may have a minimum below -depth beside a node: the node is a local minimum, and the rise to
 * a neighbour exceeds the height of the node's value above -depth. */
static int may_dip(const double *values, double depth)
{
    for (size_t i = 1; i <= AOI_NODES; i++) {
        const double next = i < AOI_NODES ? values[i + 1] : values[i];
        const double higher = fmax(values[i - 1], next) - values[i];
        if (values[i] <= values[i - 1] && values[i] <= next && values[i] < higher - depth) {
            return 1;
        }
    }
    return 0;
}

/* Notes an event where a function of time falls below zero, also if it does so only between two nodes. The space
 * between nodes is searched only in a step whose error is within the tolerance. */
static void leaves(const double *values, double tolerance, int kind, aoi_adaptive_contact *contact,
                   aoi_attempt *attempt)
{
    double coefficient[AOI_NODES + 1], place;
    falls(values, tolerance, kind, contact, attempt);
    if (contact->event == kind || !(attempt->growth >= 1.0) || !may_dip(values, tolerance)) {
        return;
    }
    aoi_legendre_fit(values[0], values + 1, coefficient);
    if (aoi_legendre_dips(coefficient, -tolerance, -0.5 * tolerance, &place)) {
        aoi_step_note_event(place, kind, contact, attempt);
    }
}

/* Sets values to factor * value + shift, at the start and the AOI_NODES nodes. */
static void line_up(double start, const double *nodes, double factor, double shift, double *values)
{
    values[0] = factor * start + shift;
    for (size_t i = 0; i < AOI_NODES; i++) {
        values[i + 1] = factor * nodes[i] + shift;
    }
}

/* Notes an event where the law's force, before its cut at zero, changes its sign. */
static void force_events(aoi_adaptive *run, const aoi_contact_step *entry, aoi_attempt *attempt)
{
    aoi_adaptive_contact *contact = &run->contact[entry->contact];
    const aoi_law *law = aoi_step_law(run, entry);
    const int piece = aoi_step_piece(law, entry);
    double force[AOI_NODES], values[AOI_NODES + 1], largest = 0.0;
    aoi_law_value value;
    for (size_t i = 0; i < AOI_NODES; i++) {
        aoi_law_force(law, entry->memory, piece, entry->indentation[i], entry->rate[i], &value);
        force[i] = value.force;
        largest = fmax(largest, fabs(value.force));
    }
    const double tolerance = aoi_event_tolerance(run, aoi_step_force_scale(run, entry, largest));
    int kind = AOI_EVENT_SLACKEN;
    if (entry->piece == AOI_SLACK) {
        aoi_law_force(law, entry->memory, piece, entry->start, entry->start_rate, &value);
        line_up(fmin(value.force, 0.0), force, -1.0, 0.0, values);
        kind = AOI_EVENT_TIGHTEN;
    } else {
        line_up(fmax(entry->start_force, 0.0), force, 1.0, 0.0, values);
    }
    if (aoi_contact_has_residual(run, entry->contact)) {
        /* The rate, and with it the force, may jump at the start. If the force has fallen to zero there, within
         * the error of the last step, the event is at the start. Otherwise the force at the start is extrapolated
         * from the nodes. */
        if (values[1] < -tolerance && values[0] <= run->rtol * fmax(run->force_scale, largest)) {
            aoi_step_note_event(0.0, kind, contact, attempt);
            return;
        }
        values[0] = values[1] < -tolerance ? values[0] : aoi_nodes_at_start(values + 1);
    }
    leaves(values, tolerance, kind, contact, attempt);
}

/* Moves the event AOI_EVENT_TURN to the start of a step if the indentation would grow by less than the tolerance
 * before that event: in shorter steps, rates are dominated by rounding. */
static void turn_now(const aoi_contact_step *entry, double tolerance, aoi_adaptive_contact *contact,
                     aoi_attempt *attempt)
{
    if (contact->event == AOI_EVENT_TURN && contact->event_place < 1.0 &&
        entry->start_rate * contact->event_place * attempt->h <= tolerance) {
        contact->event_place = attempt->place = 0.0;
    }
}

/* True if a contact at a massless contact point has separated within rounding: in a step as short as the time left
 * to separation, rates are dominated by rounding. */
static int is_over(const aoi_adaptive *run, const aoi_contact_step *entry, double rest, double tolerance)
{
    const aoi_adaptive_contact *contact = &run->contact[entry->contact];
    const double least = aoi_event_tolerance(run, aoi_step_force_scale(run, entry, 0.0));
    return aoi_contact_has_residual(run, entry->contact) && !contact->closed.begins && entry->start - rest <= tolerance &&
           entry->start_rate < 0.0 && entry->indentation[0] - rest < entry->start - rest &&
           fmax(fabs(entry->start_force), aoi_step_force(entry)) <= least;
}

/* True if a contact that has just touched at a massless contact point opens at once because other contacts move
 * that point away. Only very short steps decide this. reach: approach in the step, m; scale: largest indentation,
 * m. */
static int is_none(const aoi_adaptive *run, const aoi_contact_step *entry, double reach, double scale)
{
    return run->contact[entry->contact].closed.begins && aoi_contact_has_residual(run, entry->contact) &&
           entry->indentation[0] < entry->start && entry->indentation[AOI_NODES - 1] < entry->start &&
           /* Largest approach in a step, as a share of the largest indentation, for which a contact without
            * initial force counts as open. Measured and tried: from 0.003 to 0.03 no run changes. */
           entry->start_force <= 0.0 && reach <= 1e-2 * scale;
}

void aoi_step_closed_events(aoi_adaptive *run, const aoi_contact_step *entry, aoi_attempt *attempt)
{
    const aoi_law *law = aoi_step_law(run, entry);
    aoi_adaptive_contact *contact = &run->contact[entry->contact];
    /* a contact that begins may start below rest by up to the tolerance */
    const double touch = aoi_law_rest(law, entry->memory);
    const double rest = contact->closed.begins ? fmin(touch, entry->start) : touch;
    const double scale = aoi_step_scale(run, entry, aoi_step_indentation(entry));
    const double tolerance = aoi_event_tolerance(run, scale);
    double values[AOI_NODES + 1];
    line_up(entry->start, entry->indentation, 1.0, -rest, values);
    if (is_over(run, entry, rest, tolerance)) {
        contact->flight.slack = tolerance; /* without this the contact would touch again at once */
        aoi_step_note_event(0.0, AOI_EVENT_OPEN, contact, attempt);
        return;
    }
    if (entry->start - touch <= tolerance && is_none(run, entry, attempt->h * contact->scales.rate, scale)) {
        contact->flight.slack = tolerance;
        aoi_step_note_event(0.0, AOI_EVENT_OPEN, contact, attempt);
        return;
    }
    leaves(values, tolerance, AOI_EVENT_OPEN, contact, attempt);
    if (law->depends_on_rate && !law->pulls) {
        force_events(run, entry, attempt);
    }
    if (entry->piece != AOI_SLACK && contact->closed.high < HUGE_VAL) {
        line_up(entry->start, entry->indentation, -1.0, contact->closed.high, values);
        leaves(values, tolerance, AOI_EVENT_ABOVE, contact, attempt);
    }
    if (entry->piece != AOI_SLACK && contact->closed.low > rest) {
        line_up(entry->start, entry->indentation, 1.0, -contact->closed.low, values);
        leaves(values, tolerance, AOI_EVENT_BELOW, contact, attempt);
    }
    if (law->turns && entry->piece != AOI_SLACK && contact->closed.rate > 0.0) {
        const double slow = aoi_event_tolerance(run, contact->scales.rate);
        line_up(entry->start_rate, entry->rate, 1.0, 0.0, values);
        leaves(values, slow, AOI_EVENT_TURN, contact, attempt);
        turn_now(entry, tolerance, contact, attempt);
    }
}

/* After a wave has passed, bodies move on side by side, with overlaps and velocities at rounding. A contact is
 * opened if its force, lasting to the end of the run, would not change the last digit of its impulse. Otherwise
 * every contact that the wave has passed would have to be solved in every step. */
void aoi_step_skip(aoi_adaptive *run, const aoi_contact_step *entry, aoi_attempt *attempt)
{
    aoi_adaptive_contact *contact = &run->contact[entry->contact];
    const double left = run->end - aoi_run_now(run);
    double force = fabs(entry->start_force);
    for (size_t i = 0; i < AOI_NODES; i++) {
        force = fabs(entry->force[i]) > force ? fabs(entry->force[i]) : force;
    }
    if (contact->event != AOI_EVENT_NONE || contact->closed.begins || entry->piece == AOI_SLACK ||
        !(force * left <= DBL_EPSILON * contact->ledger.peak.impulse)) {
        return;
    }
    const double tolerance = aoi_touch_tolerance(run, entry);
    const double rest = aoi_law_rest(aoi_step_law(run, entry), entry->memory);
    if (!(aoi_step_indentation(entry) - rest <= SKIP_SHARE * tolerance)) {
        return;
    }
    contact->event = AOI_EVENT_OPEN;
    contact->event_place = 1.0;
    contact->flight.slack = 0.5 * tolerance;
    attempt->place = fmin(attempt->place, 1.0);
}
