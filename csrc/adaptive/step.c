/* A trial step of an adaptive run: the motion without contact forces, a first guess, the forces by collocation, and
 * then their errors (step_error.c) and events (step_events.c, step_open.c). */
#include "adaptive/run.h"
#include "adaptive/step.h"
#include "law/law.h"
#include "model/system.h"
#include "motion/free.h"
#include "motion/polynomial.h"
#include "motion/radau.h"
#include "motion/response.h"
#include "motion/nodes.h"
#include "collocation/collocation.h"

#include <math.h>
#include <string.h>

/* A step counts as ending at an edge, the end of a contact force, if the predicted separation is closer to its end
 * than this share of its length. Measured: from 0.03 to 0.3 work changes by 0.3 %. */
static const double EDGE_WIDTH = 0.1;

/* Least scale that changes of an indentation in Newton's method are divided by, as a share of the largest
 * indentation. Measured: from 1e-12 to 1e-3 errors and work are the same. */
static const double NEWTON_SHARE = 1e-6;

/* The value that replaces NEWTON_SHARE at residual compliances. These couple contacts, so that each indentation
 * has the rounding error of the largest. Tried with a third and three times the value: 12 runs change, by a
 * relative 2e-12. */
static const double MASSLESS_NEWTON_SHARE = 1e-3;

static int are_equal(const double *one, const double *other, size_t count)
{
    return one == other || (one && other && memcmp(one, other, count * sizeof *one) == 0);
}

/* True if two bodies have the same response, as is common in scenes that use one model several times. */
static int are_alike(const aoi_adaptive *run, size_t first, size_t second)
{
    const aoi_modes *one = &run->system->body[first], *other = &run->system->body[second];
    return !run->body[first].columns.of && one->n == other->n && one->ports == other->ports &&
           (one->load.count > 0) == (other->load.count > 0) &&
           are_equal(one->omega, other->omega, one->n) && are_equal(one->decay, other->decay, one->n) &&
           are_equal(one->shape, other->shape, one->ports * one->n) &&
           are_equal(one->push, other->push, one->ports * one->n);
}

/* Provides the tables of responses of a body for this step; new tables replace those that were not used for the
 * longest time. */
static void make_response(aoi_adaptive *run, size_t b, double h, int level, int with_rates)
{
    aoi_adaptive_body *body = &run->body[b];
    const aoi_modes *modes = &run->system->body[b];
    size_t oldest = 0;
    for (size_t i = 0; i < body->table_count; i++) {
        if (body->table_use[i] > 0 && body->table_level[i] == level && level != AOI_NO_LEVEL &&
            body->table[i].has_rates >= with_rates) {
            body->table_use[i] = ++run->uses;
            run->response[b] = body->table[i];
            return;
        }
        oldest = body->table_use[i] < body->table_use[oldest] ? i : oldest;
    }
    double *block = body->block + oldest * body->table_size;
    aoi_response_make(&body->table[oldest], modes, &body->columns, h, with_rates, block);
    body->table_level[oldest] = level;
    body->table_use[oldest] = ++run->uses;
    run->response[b] = body->table[oldest];
}

/* Sums, on each port, the contact forces on residual compliances, which the homogeneous motion of a step holds
 * constant. Returns whether any of them is not zero. */
static int gather_constant(aoi_adaptive *run)
{
    const aoi_system *system = run->system;
    int some = 0;
    for (size_t i = 0; i < run->closed.count; i++) {
        some = some || run->contact[run->closed.at[i]].massless.bending != 0.0;
    }
    if (some) {
        memset(run->port_force, 0, system->first_port[system->body_count] * sizeof *run->port_force);
    }
    for (size_t i = 0; i < 2 * run->closed.count && some; i++) {
        const size_t c = run->closed.at[i / 2], b = system->contact[c].body[i % 2];
        run->port_force[system->first_port[b] + system->contact[c].port[i % 2]] +=
            (i % 2 == 0 ? -1.0 : 1.0) * run->contact[c].massless.bending;
    }
    return some;
}

static void homogeneous(aoi_adaptive *run, aoi_contact_step *entry, int with_rates, int pressed)
{
    const aoi_contact *contact = &run->system->contact[entry->contact];
    for (size_t i = 0; i < AOI_NODES; i++) {
        entry->homogeneous[i] = entry->start;
        entry->homogeneous_rate[i] = 0.0;
    }
    for (int side = 0; side < 2; side++) {
        const size_t b = contact->body[side], at = run->system->first[b];
        aoi_response_homogeneous(&run->response[b], &run->system->body[b], contact->port[side] + entry->axis,
                                 side == 0 ? 1.0 : -1.0, aoi_run_now(run), run->x + at, run->v + at,
                                 pressed ? run->port_force + run->system->first_port[b] : NULL, entry->homogeneous,
                                 with_rates ? entry->homogeneous_rate : NULL);
    }
}

/* Sets `values` to the polynomial of the last step, extrapolated to the nodes of a step of length h, s. rate: set
 * to the polynomial's slopes at the nodes, per second; or NULL. */
static void extrapolate(const double *last, double last_length, double h, double *values, double *rate)
{
    for (size_t i = 0; i < AOI_NODES; i++) {
        double slope;
        values[i] = aoi_legendre_evaluate(AOI_NODES + 1, last, 1.0 + aoi_radau_node[i] * (h / last_length), &slope);
        if (rate) {
            rate[i] = slope / last_length;
        }
    }
}

/* Sets a first guess of an indentation: the polynomial of the last step, extrapolated, or, if that is smaller, the
 * motion without contact force, an upper bound. At a massless contact point the guess is linear instead, since
 * without force the point would jump far from the solution under a stiff law, and other contacts may press on it. */
static void guess(const aoi_adaptive_contact *contact, double h, double usual, int with_rates, int massless,
                  aoi_contact_step *entry)
{
    const int known = contact->closed.last_length > 0.0 && h <= 2.0 * contact->closed.last_length;
    double drawn_on[AOI_NODES], rate[AOI_NODES], largest = 0.0;
    if (known) {
        extrapolate(contact->closed.last, contact->closed.last_length, h, drawn_on, with_rates ? rate : NULL);
    }
    for (size_t i = 0; i < AOI_NODES && massless && !known; i++) { /* linear guess */
        drawn_on[i] = contact->closed.start + h * aoi_radau_node[i] * contact->closed.rate;
        rate[i] = contact->closed.rate;
    }
    for (size_t i = 0; i < AOI_NODES; i++) {
        const int shallower = massless || (known && drawn_on[i] < entry->homogeneous[i]);
        entry->indentation[i] = shallower ? drawn_on[i] : entry->homogeneous[i];
        entry->rate[i] = shallower && with_rates ? rate[i] : entry->homogeneous_rate[i];
        largest = fabs(entry->indentation[i]) > largest ? fabs(entry->indentation[i]) : largest;
    }
    entry->scale = fmax(largest, (massless ? MASSLESS_NEWTON_SHARE : NEWTON_SHARE) * usual);
}

/* Sets a first guess of a slide: the polynomial of the last step, extrapolated, or the motion without contact
 * forces. The scale of the slide is the larger of the largest possible stretch of a spring and the slide itself. */
static void guess_slide(const aoi_adaptive_contact *contact, double h, double usual, aoi_contact_step *entry)
{
    const aoi_friction *friction = &entry->sliding->rub.friction;
    const double stretch = friction->mu / friction->ratio;
    double largest = 0.0;
    memcpy(entry->indentation, entry->homogeneous, sizeof entry->indentation);
    memcpy(entry->rate, entry->homogeneous_rate, sizeof entry->rate);
    if (contact->closed.last_length > 0.0 && h <= 2.0 * contact->closed.last_length) {
        extrapolate(entry->sliding->last[entry->axis - 1], contact->closed.last_length, h, entry->indentation, NULL);
    }
    for (size_t i = 0; i < AOI_NODES; i++) {
        largest = fmax(largest, fabs(entry->indentation[i] - entry->start));
    }
    entry->scale = fmax(fmax(largest, stretch * contact->scales.indentation), NEWTON_SHARE * usual);
}

/* Returns the edge of a contact in a step of length h: AOI_EDGE_START if its force begins at the start,
 * AOI_EDGE_END if its force ends near the end, else AOI_EDGE_NONE. */
static enum aoi_edge edge_of(const aoi_adaptive *run, size_t c, double h)
{
    const aoi_adaptive_contact *contact = &run->contact[c];
    if (!contact->is_closed || contact->closed.piece == AOI_SLACK || aoi_contact_has_residual(run, c)) {
        return AOI_EDGE_NONE;
    }
    if (contact->closed.begins) { /* the start is an edge only if the force rises from zero at the touch */
        return contact->closed.force == 0.0 ? AOI_EDGE_START : AOI_EDGE_NONE;
    }
    const double left = aoi_release_after(run, 2.0 * h);
    return fabs(left - h) <= EDGE_WIDTH * h ? AOI_EDGE_END : AOI_EDGE_NONE;
}

/* Fills the entry of a closed contact for a step of length h, with a guess of the solution. pressed: return value
 * of gather_constant. */
static void begin_entry(aoi_adaptive *run, size_t s, double h, int with_rates, int pressed)
{
    aoi_contact_step *entry = &run->entry[s];
    aoi_adaptive_contact *contact = &run->contact[entry->contact];
    const int massless = aoi_contact_has_residual(run, entry->contact);
    if (massless) {
        contact->closed.start = aoi_contact_place(run, entry->contact);
    }
    entry->constant = contact->massless.bending;
    entry->memory = contact->memory;
    entry->piece = contact->closed.piece;
    entry->edge = edge_of(run, entry->contact, h);
    entry->start_force = contact->closed.force;
    entry->start = contact->closed.start;
    entry->start_rate = contact->closed.rate;
    if (entry->axis > 0) {
        entry->start = entry->sliding->slide[entry->axis - 1];
        entry->start_force = aoi_sliding_force(entry->sliding, entry->axis);
        entry->start_rate = 0.0;
    }
    homogeneous(run, entry, with_rates, pressed);
    if (entry->axis > 0) {
        guess_slide(contact, h, run->indentation_scale, entry);
    } else {
        guess(contact, h, run->indentation_scale, with_rates, massless, entry);
    }
}

/* Finds the forces in this step on the ports of all bodies that take part, and their Legendre coefficients. */
static void gather_forces(aoi_adaptive *run, double h)
{
    const aoi_system *system = run->system;
    for (size_t i = 0; i < run->engaged.count; i++) {
        const size_t b = run->engaged.at[i];
        double *force = run->port_force + system->first_port[b] * AOI_NODES;
        memset(force, 0, system->body[b].ports * AOI_NODES * sizeof *force);
    }
    for (size_t s = 0; s < run->closed_count; s++) {
        const aoi_contact *contact = &system->contact[run->entry[s].contact];
        for (int side = 0; side < 2; side++) {
            const size_t port =
                run->system->first_port[contact->body[side]] + contact->port[side] + run->entry[s].axis;
            aoi_nodes_add(side == 0 ? -1.0 : 1.0, run->entry[s].force,
                           run->port_force + port * AOI_NODES);
        }
    }
    for (size_t i = 0; i < run->engaged.count; i++) {
        const size_t b = run->engaged.at[i], at = system->first_port[b] * AOI_NODES;
        aoi_step_series(&system->body[b], run->port_force + at, h, run->port_series + at);
    }
}

/* Returns the largest force of the closed contacts, so far, in this step or expected, N; 0 if only one is closed. */
static double force_scale_of(const aoi_adaptive *run)
{
    double largest = 0.0;
    for (size_t s = 0; s < run->closed_count && run->closed_count > 1; s++) {
        const aoi_adaptive_contact *contact = &run->contact[run->entry[s].contact];
        largest = fmax(largest, fmax(contact->ledger.peak.force, aoi_step_force(&run->entry[s])));
        largest = fmax(largest, contact->scales.force);
    }
    return largest;
}

/* True if a step whose friction has too large an error contains a corner of friction, where slip begins or ends;
 * the step must then end at the corner. A corner closer than sqrt(rtol) to an end of the step is left inside,
 * since its error is of second order in that distance. */
static int ends_at_corner(aoi_adaptive *run, size_t s, aoi_attempt *attempt)
{
    const aoi_contact_step *normal = &run->entry[s - run->entry[s].axis];
    const double near = sqrt(run->rtol), place = aoi_sliding_corner(normal->sliding, normal, near);
    if (!(place < 1.0 - near)) {
        return 0;
    }
    attempt->place = fmin(attempt->place, place);
    attempt->corner = 1;
    return 1;
}

void aoi_step_try(aoi_adaptive *run, double h, int level, aoi_attempt *attempt)
{
    const int with_rates = aoi_collocation_wants_rates(run->system, run->closed_count, run->entry);
    *attempt = (aoi_attempt){.h = h, .place = 2.0};
    for (size_t i = 0; i < run->engaged.count; i++) {
        const size_t b = run->engaged.at[i], before = i > 0 ? run->engaged.at[i - 1] : b;
        if (i > 0 && are_alike(run, before, b)) {
            run->response[b] = run->response[before];
        } else {
            make_response(run, b, h, level, with_rates);
        }
    }
    const int pressed = gather_constant(run);
    for (size_t s = 0; s < run->entry_count; s++) {
        run->contact[run->entry[s].contact].event = AOI_EVENT_NONE;
        run->contact[run->entry[s].contact].event_place = HUGE_VAL;
        if (s < run->closed_count) {
            run->contact[run->entry[s].contact].flight.slack = 0.0;
            begin_entry(run, s, h, with_rates, pressed);
        }
    }
    for (size_t s = 0; s < run->closed_count; s++) {
        if (run->entry[s].sliding && run->entry[s].axis == 0) {
            aoi_sliding_prepare(run->entry[s].sliding, &run->entry[s]);
        }
    }
    const size_t most = run->closed_count - (run->closed_count > 0), span = run->span < most ? run->span : most;
    if (aoi_collocation_solve(run->system, run->response, h, run->closed_count, span, run->entry, run->collocation) !=
        AOI_OK) {
        return;
    }
    for (size_t s = 0; s < run->closed_count && with_rates; s++) {
        if (aoi_contact_has_residual(run, run->entry[s].contact)) {
            run->entry[s].start_rate = aoi_nodes_at_start(run->entry[s].rate);
        }
    }
    gather_forces(run, h);
    run->force_scale = force_scale_of(run);
    attempt->growth = HUGE_VAL;
    for (size_t s = 0; s < run->closed_count; s++) {
        if (run->entry[s].sliding && run->entry[s].axis == 0 &&
            aoi_sliding_check(run->entry[s].sliding, &run->entry[s]) != AOI_OK) {
            attempt->growth = 0.0;
            return;
        }
        double growth = aoi_step_growth(run, &run->entry[s], h);
        if (run->entry[s].axis > 0 && growth < 1.0 && ends_at_corner(run, s, attempt)) {
            growth = 1.0;
        }
        attempt->growth = growth < attempt->growth ? growth : attempt->growth;
        if (run->entry[s].axis == 0) {
            aoi_step_closed_events(run, &run->entry[s], attempt);
            aoi_step_skip(run, &run->entry[s], attempt);
        }
    }
    for (size_t s = run->closed_count; s < run->entry_count; s++) {
        aoi_step_open_events(run, &run->entry[s], attempt);
    }
}
