/* What happens to contacts within a step: they touch, let go, turn, or leave a piece of their law. */
#include "adaptive/adaptive.h"
#include "adaptive/run.h"
#include "adaptive/step.h"
#include "law/law.h"
#include "motion/flight.h"
#include "motion/polynomial.h"
#include "motion/radau.h"
#include "motion/stages.h"
#include "collocation/collocation.h"

#include <float.h>
#include <math.h>

/* How well events are hit, as a share of rtol, and the rounding of an indentation from the bodies'
 * places. */
static const double EVENT_SHARE = 0.01, PLACE_ROUNDING = 8.0;

/* A contact dozes off within this share of what it wakes up at. */
static const double DOZING = 0.1;

/* In steps over which bodies come no further than this share of their deepest, what does not touch at once does not
 * touch. */
static const double SHORTEST = 1e-2;

double aoi_event_tolerance(const aoi_adaptive *run, double scale)
{
    return fmax(EVENT_SHARE * run->rtol, 4.0 * DBL_EPSILON) * scale;
}

/* Whether a quantity falls below zero, and where. Ending within tolerance below zero, without having been
 * lower before, it falls at the end; else the step is to end where it will be there. */
static int falls_below(const double *values, double tolerance, double *place)
{
    double coefficient[AOI_STAGES + 1];
    int early = 0;
    for (size_t i = 1; i < AOI_STAGES; i++) {
        early = early || values[i] < -tolerance;
    }
    if (!early && !(values[AOI_STAGES] < 0.0)) {
        return 0;
    }
    *place = 1.0;
    if (early || values[AOI_STAGES] < -tolerance) {
        aoi_legendre_fit(values, coefficient);
        (void)aoi_legendre_falls(values, coefficient, -0.5 * tolerance, place);
    }
    return 1;
}

void aoi_step_note_event(double place, int kind, aoi_contact_state *contact, aoi_attempt *attempt)
{
    if (place < contact->event_place) {
        contact->event_place = place;
        contact->event = kind;
    }
    attempt->place = place < attempt->place ? place : attempt->place;
}

/* The same where a quantity falls. */
static void falls(const double *values, double tolerance, int kind, aoi_contact_state *contact,
                  aoi_attempt *attempt)
{
    double place;
    if (falls_below(values, tolerance, &place)) {
        aoi_step_note_event(place, kind, contact, attempt);
    }
}

/* Whether a node is the lowest about, so that a dip beside it may be as deep as what it rises to a neighbour. */
static int may_dip(const double *values, double depth)
{
    for (size_t i = 1; i <= AOI_STAGES; i++) {
        const double next = i < AOI_STAGES ? values[i + 1] : values[i];
        const double higher = fmax(values[i - 1], next) - values[i];
        if (values[i] <= values[i - 1] && values[i] <= next && values[i] < higher - depth) {
            return 1;
        }
    }
    return 0;
}

/* The same for a distance from an end, or a force, that may have been passed and come back to between
 * two nodes. Only a step that is good enough says so. */
static void leaves(const double *values, double tolerance, int kind, aoi_contact_state *contact,
                   aoi_attempt *attempt)
{
    double coefficient[AOI_STAGES + 1], place;
    falls(values, tolerance, kind, contact, attempt);
    if (contact->event == kind || !(attempt->growth >= 1.0) || !may_dip(values, tolerance)) {
        return;
    }
    aoi_legendre_fit(values, coefficient);
    if (aoi_legendre_dips(coefficient, -tolerance, -0.5 * tolerance, &place)) {
        aoi_step_note_event(place, kind, contact, attempt);
    }
}

/* start and AOI_STAGES nodes of factor * value + shift. */
static void line_up(double start, const double *nodes, double factor, double shift, double *values)
{
    values[0] = factor * start + shift;
    for (size_t i = 0; i < AOI_STAGES; i++) {
        values[i + 1] = factor * nodes[i] + shift;
    }
}

/* The piece of the law that a contact is on, or would be if it were not slack. */
static int piece_of(const aoi_law *law, const aoi_stage *stage)
{
    double low, high;
    return stage->piece != AOI_SLACK
               ? stage->piece
               : aoi_law_piece(law, stage->memory, stage->start, stage->start_rate > 0.0, &low, &high);
}

/* Where the law's own force, which is cut at zero, changes its sign. */
static void force_events(aoi_adaptive *run, const aoi_stage *stage, aoi_attempt *attempt)
{
    aoi_contact_state *contact = &run->contact[stage->joint];
    const aoi_law *law = aoi_step_law(run, stage);
    const int piece = piece_of(law, stage);
    double force[AOI_STAGES], values[AOI_STAGES + 1], largest = 0.0;
    aoi_law_value value;
    for (size_t i = 0; i < AOI_STAGES; i++) {
        aoi_law_force(law, stage->memory, piece, stage->indentation[i], stage->rate[i], &value);
        force[i] = value.force;
        largest = fmax(largest, fabs(value.force));
    }
    const double tolerance = aoi_event_tolerance(run, aoi_step_force_scale(run, stage, largest));
    int kind = AOI_EVENT_SLACKEN;
    if (stage->piece == AOI_SLACK) {
        aoi_law_force(law, stage->memory, piece, stage->start, stage->start_rate, &value);
        line_up(fmin(value.force, 0.0), force, -1.0, 0.0, values);
        kind = AOI_EVENT_TIGHTEN;
    } else {
        line_up(fmax(stage->start_force, 0.0), force, 1.0, 0.0, values);
    }
    if (aoi_joint_bends(run, stage->joint)) {
        /* A rate may jump there, and the force with it: it has fallen already, to the error of the step before, or
         * the nodes say where it comes from. */
        if (values[1] < -tolerance && values[0] <= run->rtol * fmax(run->force_scale, largest)) {
            aoi_step_note_event(0.0, kind, contact, attempt);
            return;
        }
        values[0] = values[1] < -tolerance ? values[0] : aoi_stages_at_start(values + 1);
    }
    leaves(values, tolerance, kind, contact, attempt);
}

/* What is left to rise before a turn is below the tolerance: it turns where it is, since steps as short as
 * that would see rates that are rounding. */
static void turn_now(const aoi_stage *stage, double tolerance, aoi_contact_state *contact,
                     aoi_attempt *attempt)
{
    if (contact->event == AOI_EVENT_TURN && contact->event_place < 1.0 &&
        stage->start_rate * contact->event_place * attempt->h <= tolerance) {
        contact->event_place = attempt->place = 0.0;
    }
}

/* Whether a contact at a place without mass has let go but for rounding: steps as short as what is left of it would
 * see rates that are rounding. */
static int is_over(const aoi_adaptive *run, const aoi_stage *stage, double rest, double tolerance)
{
    const aoi_contact_state *contact = &run->contact[stage->joint];
    const double least = aoi_event_tolerance(run, aoi_step_force_scale(run, stage, 0.0));
    return aoi_joint_bends(run, stage->joint) && !contact->begins && stage->start - rest <= tolerance &&
           stage->start_rate < 0.0 && stage->indentation[0] - rest < stage->start - rest &&
           fmax(fabs(stage->start_force), aoi_step_force(stage)) <= least;
}

/* Whether a contact that has just touched a place without mass is none: others move that away from the first, as the
 * shortest steps show. reach: how far the bodies come in the step. */
static int is_none(const aoi_adaptive *run, const aoi_stage *stage, double reach, double scale)
{
    return run->contact[stage->joint].begins && aoi_joint_bends(run, stage->joint) &&
           stage->indentation[0] < stage->start && stage->indentation[AOI_STAGES - 1] < stage->start &&
           stage->start_force <= 0.0 && reach <= SHORTEST * scale;
}

void aoi_step_closed_events(aoi_adaptive *run, const aoi_stage *stage, aoi_attempt *attempt)
{
    const aoi_law *law = aoi_step_law(run, stage);
    aoi_contact_state *contact = &run->contact[stage->joint];
    const double touch = aoi_law_rest(law, stage->memory); /* or, to its tolerance, where it began */
    const double rest = contact->begins ? fmin(touch, stage->start) : touch;
    const double scale = aoi_step_scale(run, stage, aoi_step_indentation(stage));
    const double tolerance = aoi_event_tolerance(run, scale);
    double values[AOI_STAGES + 1];
    line_up(stage->start, stage->indentation, 1.0, -rest, values);
    if (is_over(run, stage, rest, tolerance)) {
        contact->slack = tolerance; /* or it would touch again where it is */
        aoi_step_note_event(0.0, AOI_EVENT_OPEN, contact, attempt);
        return;
    }
    if (stage->start - touch <= tolerance && is_none(run, stage, attempt->h * contact->rate_scale, scale)) {
        contact->slack = tolerance;
        aoi_step_note_event(0.0, AOI_EVENT_OPEN, contact, attempt);
        return;
    }
    leaves(values, tolerance, AOI_EVENT_OPEN, contact, attempt);
    if (law->depends_on_rate && !law->pulls) {
        force_events(run, stage, attempt);
    }
    if (stage->piece != AOI_SLACK && contact->high < HUGE_VAL) {
        line_up(stage->start, stage->indentation, -1.0, contact->high, values);
        leaves(values, tolerance, AOI_EVENT_ABOVE, contact, attempt);
    }
    if (stage->piece != AOI_SLACK && contact->low > rest) {
        line_up(stage->start, stage->indentation, 1.0, -contact->low, values);
        leaves(values, tolerance, AOI_EVENT_BELOW, contact, attempt);
    }
    if (law->turns && stage->piece != AOI_SLACK && contact->start_rate > 0.0) {
        const double slow = EVENT_SHARE * run->rtol * contact->rate_scale;
        line_up(stage->start_rate, stage->rate, 1.0, 0.0, values);
        leaves(values, slow, AOI_EVENT_TURN, contact, attempt);
        turn_now(stage, tolerance, contact, attempt);
    }
}

/* The rounding of an indentation that is a difference of places. */
static double rounding_of(const aoi_flight *pair)
{
    double size = fabs(pair->gap);
    for (int side = 0; side < 2; side++) {
        const aoi_modes *body = pair->body[side];
        for (size_t j = 0; j < body->n; j++) {
            size += fabs(body->shape[pair->port[side] * body->n + j] * pair->x[side][j]);
        }
    }
    return PLACE_ROUNDING * DBL_EPSILON * size;
}

double aoi_touch_tolerance(aoi_adaptive *run, const aoi_stage *stage)
{
    aoi_flight pair;
    aoi_pair_now(run, stage->joint, &pair);
    return fmax(EVENT_SHARE * run->rtol * aoi_step_scale(run, stage, 0.0), rounding_of(&pair));
}

/* Behind a wave bodies go on side by side, with overlaps and velocities that are rounding. A force that
 * would not change the last digit of the contact's impulse if it lasted to the end of the run has ended:
 * else all that has ever been passed would be solved for in every step. */
void aoi_step_doze(aoi_adaptive *run, const aoi_stage *stage, aoi_attempt *attempt)
{
    aoi_contact_state *contact = &run->contact[stage->joint];
    const double left = run->end - aoi_run_now(run);
    double force = fabs(stage->start_force);
    for (size_t i = 0; i < AOI_STAGES; i++) {
        force = fabs(stage->force[i]) > force ? fabs(stage->force[i]) : force;
    }
    if (contact->event != AOI_EVENT_NONE || contact->begins || stage->piece == AOI_SLACK ||
        !(force * left <= DBL_EPSILON * contact->impulse)) {
        return;
    }
    const double tolerance = aoi_touch_tolerance(run, stage);
    const double rest = aoi_law_rest(aoi_step_law(run, stage), stage->memory);
    if (!(aoi_step_indentation(stage) - rest <= DOZING * tolerance)) {
        return;
    }
    contact->event = AOI_EVENT_OPEN;
    contact->event_place = 1.0;
    contact->slack = 0.5 * tolerance;
    attempt->place = fmin(attempt->place, 1.0);
}
