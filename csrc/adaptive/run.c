/* The adaptive run: collocation in steps of length base 2^(-level/8) while a contact is closed, and free motion in
 * closed form otherwise. This file chooses between the two. closing.c sets the length of the first step; the
 * lengths of later steps follow from the errors that step_error.c finds. */
#include "adaptive/row.h"
#include "adaptive/run.h"
#include "linear/vector.h"
#include "linear/work.h"
#include "law/law.h"
#include "model/load.h"
#include "model/system.h"
#include "motion/energy.h"
#include "motion/free.h"
#include "motion/modes.h"
#include "motion/response.h"
#include "collocation/collocation.h"

#include <float.h>
#include <math.h>
#include <string.h>

/* LEAST_RISE: least number of levels by which the step length grows. MOST_TRIMS: how often one step may be cut
 * short for an event; MOST_IDLE: how often a run may loop without a step. Both prevent endless loops. Tried with a
 * third and three times either value: no run changes. */
enum {
    LEAST_RISE = 2,
    MOST_TRIMS = 12,
    MOST_IDLE = 1000
};

/* While a contact is closed, bodies in free motion are searched for a touch up to this number of steps ahead.
 * Measured: 21 costs 0.2 % more work, 192 saves none. */
static const double STEPS_AHEAD = 64.0;

/* Least factor on the step length after a rejected step. Measured: from 0.02 to 0.18 work changes by 0.5 %. */
static const double LEAST_SHRINKAGE = 0.06;

/* Largest factor on the step length after a step was cut short for an event that did not occur in the shortened
 * step. The same factor is taken if the step was cut MOST_TRIMS times, or if its event is at its start and changes
 * nothing. Measured: as the largest factor, 0.17 costs 1.1 % more work and 0.83 saves none; as the factor, from
 * 0.13 to 1.2 no run changes. */
static const double UNCONFIRMED = 0.5;

/* Least growth of the step length that the error of a step must allow for the events in that step to be used.
 * Below it the error is too large, and the events are ignored. Measured: from 0.03 to 0.3 work changes by 0.3
 * %. */
static const double TRUSTED = 0.1;

/* ------------------------------------------------------------------------------ work space */

/* True if forces may change faster than indentations: a law depends on the rate, or a contact point is massless
 * (has a residual compliance). */
static int is_quick(const aoi_system *system)
{
    for (size_t c = 0; c < system->contact_count; c++) {
        if (system->contact[c].law->depends_on_rate ||
            aoi_system_residual(system, c, c) > 0.0) {
            return 1;
        }
    }
    return 0;
}

/* Returns the number of contacts with friction. */
static size_t rubbing_of(const aoi_system *system)
{
    return (aoi_system_forces(system) - system->contact_count) / 2;
}

size_t aoi_adaptive_room(const aoi_system *system)
{
    if (!system->first) {
        return 0;
    }
    size_t room = AOI_TRACK_FIXED + AOI_TRACK_STATE * system->body_count + 2 * system->first[system->body_count];
    for (size_t c = 0; c < system->contact_count; c++) {
        room += aoi_row_contact_size(&system->contact[c]);
    }
    return room;
}

/* Returns the size of the work space of the collocation, which the balance of massless contact points also uses. */
static size_t work_size(const aoi_adaptive *run, const aoi_system *system)
{
    const size_t size = run->crowded ? aoi_crowd_size(system) : aoi_collocation_size(aoi_system_forces(system), run->span);
    const size_t balance = aoi_system_bends(system) ? aoi_balance_size(system->contact_count, run->span) : 0;
    return balance > size ? balance : size;
}

/* Lists the ports of body b that have contacts, in ascending order. */
static void list_columns(const aoi_system *system, size_t b, aoi_columns *columns)
{
    const size_t ports = system->body[b].ports;
    memset(columns->of, 0, ports * sizeof *columns->of);
    for (size_t i = system->first_contact[b]; i < system->first_contact[b + 1]; i++) {
        const aoi_contact *contact = &system->contact[system->contact_of[i]];
        for (size_t axis = 0; axis < aoi_contact_forces(contact); axis++) {
            columns->of[contact->port[contact->body[1] == b] + axis] = 1;
        }
    }
    columns->count = 0;
    for (size_t p = 0; p < ports; p++) {
        if (columns->of[p]) {
            columns->of[p] = columns->count;
            columns->port[columns->count++] = p;
        }
    }
}

/* Lays out a body's tables of responses, which have columns only for ports with contacts. */
static void lay_out_body(const aoi_adaptive *run, const aoi_system *system, size_t b, aoi_memory *memory,
                         aoi_adaptive_body *body)
{
    const aoi_modes *modes = &system->body[b];
    const size_t tables = modes->n > 1 ? AOI_TABLES : 1, ports = modes->ports;
    size_t *of = aoi_memory_numbers(memory, run->crowded ? 0 : ports), count = 0;
    size_t *port = aoi_memory_numbers(memory, run->crowded ? 0 : ports);
    for (size_t i = system->first_contact[b]; i < system->first_contact[b + 1]; i++) {
        count += aoi_contact_forces(&system->contact[system->contact_of[i]]);
    }
    const int some = count < ports && !run->crowded;
    const size_t columns = run->crowded ? AOI_BY_MODES : some ? count : ports, size = aoi_response_size(modes, columns);
    double *block = aoi_memory_doubles(memory, aoi_times(tables, size));
    if (!body) {
        return;
    }
    *body = (aoi_adaptive_body){.block = block, .table_count = tables, .table_size = size};
    body->columns = (aoi_columns){columns, some ? port : NULL, some ? of : NULL};
    if (some) {
        list_columns(system, b, &body->columns);
    }
}

/* Number of springs reserved per contact with friction: two arrays for each of its paths, and two for the trial
 * path. */
enum { OF_SLIDING = 2 * (AOI_PATHS + 1) * AOI_SPRINGS };

/* Lays out the arrays of a run behind its struct, in `block`; if block is NULL, only the bytes are counted.
 * Returns their number. */
static size_t lay_out(aoi_adaptive *run, const aoi_system *system, void *block)
{
    const size_t bodies = system->body_count, contacts = system->contact_count;
    aoi_memory memory = {block, 0};
    (void)aoi_memory_take(&memory, 1, sizeof *run);
    run->body = aoi_memory_take(&memory, bodies, sizeof *run->body);
    run->contact = aoi_memory_take(&memory, contacts, sizeof *run->contact);
    run->entry = aoi_memory_take(&memory, aoi_system_forces(system), sizeof *run->entry);
    run->response = aoi_memory_take(&memory, bodies, sizeof *run->response);
    run->balanced = aoi_memory_take(&memory, contacts, sizeof *run->balanced);
    run->engaged.at = aoi_memory_numbers(&memory, bodies);
    run->changed.at = aoi_memory_numbers(&memory, bodies);
    run->closed.at = aoi_memory_numbers(&memory, contacts);
    run->watched[0].at = aoi_memory_numbers(&memory, contacts);
    run->watched[1].at = aoi_memory_numbers(&memory, contacts);
    run->x = aoi_memory_doubles(&memory, system->first[bodies]);
    run->v = aoi_memory_doubles(&memory, system->first[bodies]);
    run->free_state[0] = aoi_memory_doubles(&memory, 4 * aoi_system_most_modes(system));
    run->free_state[1] = aoi_memory_doubles(&memory, 4 * aoi_system_most_modes(system));
    run->scratch = aoi_memory_doubles(&memory, 2 * aoi_system_most_modes(system));
    run->port_force = aoi_memory_doubles(&memory, system->first_port[bodies] * AOI_NODES);
    run->port_series = aoi_memory_doubles(&memory, system->first_port[bodies] * AOI_NODES);
    run->collocation = aoi_memory_doubles(&memory, work_size(run, system));
    for (size_t b = 0; b < bodies; b++) {
        lay_out_body(run, system, b, &memory, block ? &run->body[b] : NULL);
    }
    const size_t rubbing = rubbing_of(system);
    run->sliding = aoi_memory_take(&memory, rubbing, sizeof *run->sliding);
    run->spring = aoi_memory_take(&memory, aoi_times(rubbing, OF_SLIDING), sizeof *run->spring);
    return memory.used;
}

size_t aoi_adaptive_size(const aoi_system *system)
{
    if (!system->first) {
        return 0;
    }
    aoi_adaptive counted = {.span = aoi_system_span(system), .crowded = aoi_crowd_pays(system)};
    return lay_out(&counted, system, NULL);
}

/* -------------------------------------------------------------------------------- the start */

/* Closes a contact whose bodies press on each other at the start. */
static int start_closed(aoi_adaptive *run, size_t c)
{
    aoi_adaptive_contact *contact = &run->contact[c];
    const aoi_contact *of = &run->system->contact[c];
    const double delta = contact->closed.start;
    aoi_law_value value;
    aoi_law_remember(of->law, delta, 0.0, contact->memory);
    aoi_contact_close(run, c);
    contact->closed.start = delta;
    aoi_law_force(of->law, contact->memory, contact->closed.piece, delta, contact->closed.rate, &value);
    contact->closed.force = value.force;
    if (contact->sliding) {
        const double place[3] = {delta, aoi_contact_slide(run, c, 1), aoi_contact_slide(run, c, 2)};
        const int status = aoi_sliding_begin(contact->sliding, place);
        if (status != AOI_OK) {
            run->failed = c;
            return status;
        }
        contact->closed.force = aoi_sliding_force(contact->sliding, 0);
    }
    aoi_contact_note_peak(run, c, contact->closed.force, 0.0);
    const double time = 1.0 / sqrt(value.stiffness * contact->scales.mobility);
    contact->scales.indentation = fmax(contact->scales.indentation, delta);
    contact->scales.impulse = fmax(contact->scales.impulse, value.force * time);
    if (isfinite(time) && time > 0.0 && run->base == 0.0) {
        run->base = 3.0 * time;
        run->level = 0;
    }
    run->indentation_scale = fmax(run->indentation_scale, contact->scales.indentation);
    run->impulse_scale = fmax(run->impulse_scale, contact->scales.impulse);
    return AOI_OK;
}

/* Starts the recorded work of each body at minus aoi_modes_bent_work, which dense output adds at every time: the
 * work that loads have done before the start, on deflections of residual compliances under contact forces, is not
 * recorded. */
static void start_ledger(aoi_adaptive *run)
{
    const aoi_system *system = run->system;
    double *force = run->port_force, rise;
    for (size_t b = 0; b < system->body_count; b++) {
        for (size_t p = 0; p < system->body[b].ports; p++) {
            aoi_modes_load(&system->body[b], p, run->time, &force[system->first_port[b] + p], &rise);
        }
    }
    for (size_t c = 0; c < system->contact_count; c++) {
        for (int side = 0; side < 2; side++) {
            const aoi_contact *contact = &system->contact[c];
            force[system->first_port[contact->body[side]] + contact->port[side]] +=
                (side == 0 ? -1.0 : 1.0) * run->contact[c].closed.force;
        }
    }
    for (size_t b = 0; b < system->body_count; b++) {
        run->body[b].work = -aoi_modes_bent_work(&system->body[b], run->time, force + system->first_port[b]);
    }
}

/* Sets the time of the next halt, at which all bodies are advanced: until then, each load has at most
 * AOI_MOST_BENDS bends divided by the number of modes. */
static void set_halt(aoi_adaptive *run)
{
    const aoi_system *system = run->system;
    double modes = (double)system->first[system->body_count];
    for (size_t c = 0; c < system->contact_count; c++) {
        for (int side = 0; side < 2; side++) {
            modes += (double)system->body[system->contact[c].body[side]].n;
        }
    }
    const size_t share = (size_t)(AOI_MOST_BENDS / fmax(modes, 1.0)); /* at least 1, since there may be no modes */
    run->halt = HUGE_VAL;
    for (size_t b = 0; b < system->body_count; b++) {
        const double bend = aoi_load_later_bend(&system->body[b].load, aoi_run_now(run), share);
        run->halt = fmin(run->halt, bend);
    }
}

/* FINEST_CURVE: smallest value of the precision of a curve of stretches, at which the curve takes 1000 springs;
 * otherwise the precision is the smaller of the contact's own and rtol. WITHIN_STEP: factor on this precision for
 * the paths within a step. NEWTON_SHARE: ratio of the tolerance of Newton's method to rtol. */
static const double FINEST_CURVE = 4e-6, WITHIN_STEP = 0.01, NEWTON_SHARE = 1e-2;

static void begin_sliding(const aoi_adaptive *run, const aoi_contact *of, aoi_sliding *sliding, aoi_stretch *spring)
{
    *sliding = (aoi_sliding){.rub = aoi_rub_of(of)};
    sliding->rub.friction.precision = fmax(fmin(of->friction->precision, run->rtol), FINEST_CURVE);
    sliding->exact = sliding->rub.friction;
    sliding->exact.precision *= WITHIN_STEP;
    sliding->enough = NEWTON_SHARE * run->rtol;
    for (size_t p = 0; p <= AOI_PATHS; p++, spring += 2 * AOI_SPRINGS) {
        aoi_slide_path *path = p < AOI_PATHS ? &sliding->path[p] : &sliding->trial;
        path->springs = (aoi_friction_state){AOI_SPRINGS, 0, spring, spring + AOI_SPRINGS, 0.0, 0.0, 0.0};
    }
    aoi_sliding_touch(sliding);
}

static int begin_contacts(aoi_adaptive *run)
{
    size_t rubbing = 0;
    for (size_t c = 0; c < run->system->contact_count; c++) {
        run->contact[c] = (aoi_adaptive_contact){.flight = {.until = -HUGE_VAL}, .ledger = {{0.0, run->time, 0.0}, 0.0, 0.0}};
        if (run->system->contact[c].friction) {
            run->contact[c].sliding = &run->sliding[rubbing];
            begin_sliding(run, &run->system->contact[c], &run->sliding[rubbing], run->spring + OF_SLIDING * rubbing);
            rubbing++;
        }
    }
    int status = aoi_balance_at_start(run);
    aoi_watch_begin(run);
    for (size_t c = 0; c < run->system->contact_count && status == AOI_OK; c++) {
        if (run->contact[c].closed.start > 0.0) {
            status = start_closed(run, c);
        } else {
            aoi_watch_add(run, c);
        }
    }
    return status;
}

/* Returns 1 if the law of a contact with friction depends on the rate. */
static int is_damped(const aoi_system *system)
{
    for (size_t c = 0; c < system->contact_count; c++) {
        if (system->contact[c].friction && system->contact[c].law->depends_on_rate) {
            return 1;
        }
    }
    return 0;
}

int aoi_adaptive_start(aoi_adaptive *run, const aoi_system *system, const aoi_start *start, double rtol,
                       double end)
{
    if (system->first && aoi_system_rubs(system) && (aoi_system_bends(system) || is_damped(system))) {
        return AOI_ERROR_FRICTION;
    }
    if (!aoi_system_is_plain(system) || !(rtol > 0.0 && rtol < 1.0) || !(end > 0.0) || !isfinite(end)) {
        return AOI_ERROR_ARGUMENT;
    }
    const size_t modes = aoi_system_most_modes(system), all = system->first[system->body_count];
    *run = (aoi_adaptive){.system = system, .rtol = rtol, .end = end, .rested = start->rested, .failed = SIZE_MAX,
                          .span = aoi_system_span(system), .crowded = aoi_crowd_pays(system)};
    run->row_size = aoi_adaptive_room(system);
    run->grain = modes > 1 && is_quick(system) ? AOI_LEVELS : 1;
    /* with friction, the tables cost far less than a step */
    run->table_cost = modes > 1 && !aoi_system_rubs(system) ? (double)modes : 0.0;
    (void)lay_out(run, system, run);
    if (!aoi_vector_take(all, start->x, run->x) || !aoi_vector_take(all, start->v, run->v)) {
        return AOI_ERROR_NOT_FINITE;
    }
    for (size_t b = 0; b < system->body_count; b++) {
        run->body[b].time = run->time;
        aoi_body_note_change(run, b);
    }
    set_halt(run);
    const int status = begin_contacts(run);
    start_ledger(run);
    return status;
}

aoi_progress aoi_adaptive_progress(const aoi_adaptive *run)
{
    return (aoi_progress){run->time, run->steps, run->rejected, run->failed, run->x, run->v};
}

aoi_peak aoi_adaptive_peak(const aoi_adaptive *run, size_t contact)
{
    return run->contact[contact].ledger.peak;
}

/* ---------------------------------------------------------------------------------- free motion */

/* True if a body is rigid. Its free motion is then a polynomial, so that one search for a touch covers the time up
 * to the run's end. */
static int is_simple(const aoi_modes *body) { return body->n == 1 && body->omega[0] == 0.0; }

/* Finds when the bodies of a watched contact touch, up to the time `limit`, and sets flight.until and
 * flight.touches. copy: set to the states of both bodies at flight.until. */
static int look_ahead(aoi_adaptive *run, size_t c, double limit, double *copy)
{
    const aoi_system *system = run->system;
    aoi_adaptive_contact *contact = &run->contact[c];
    const aoi_contact *of = &system->contact[c];
    const double now = aoi_run_now(run);
    aoi_free_pair pair;
    aoi_watch_remove(run, c);
    aoi_pair_now(run, c, &pair);
    pair.gap += aoi_law_rest(of->law, contact->memory) + contact->flight.slack;
    for (int side = 0; side < 2; side++) {
        const size_t b = of->body[side], n = system->body[b].n;
        aoi_body_copy(run, b, copy);
        aoi_modes_advance(&system->body[b], run->body[b].time, now, copy, copy + n);
        pair.x[side] = copy;
        pair.v[side] = copy + n;
        copy += 2 * n;
    }
    if (is_simple(pair.body[0]) && is_simple(pair.body[1])) {
        limit = fmin(run->end, fmax(limit, run->halt));
    }
    const size_t most = 1 + AOI_MOST_LOOKS / (pair.body[0]->n + pair.body[1]->n);
    const int status = aoi_free_pair_next_touch(&pair, limit, most, &contact->flight.touches);
    contact->flight.until = pair.time;
    aoi_watch_add(run, c);
    if (status == AOI_ERROR_NO_CONVERGENCE && pair.time > now) {
        return AOI_OK; /* no touch before pair.time; the search goes on from there later */
    }
    run->failed = status != AOI_OK ? c : run->failed;
    return status;
}

/* Sets the states of a contact's two bodies to the copies that look_ahead has advanced to the present time. */
static void land(aoi_adaptive *run, size_t c, const double *copy)
{
    for (int side = 0; side < 2; side++) {
        const size_t b = run->system->contact[c].body[side];
        aoi_body_take(run, b, copy);
        copy += 2 * run->system->body[b].n;
    }
}

/* Advances a run without closed contacts to the first touch of any contact, or to the run's end. If the search for
 * a touch takes too long, the run advances to the latest time before which no touch is possible. */
static int move_freely(aoi_adaptive *run)
{
    size_t c, landed = run->system->contact_count;
    aoi_step_release(run);
    double best = aoi_watch_first(run, 1, fmin(run->end, run->halt), &c);
    for (aoi_watch_first(run, 0, best, &c); c < run->system->contact_count;
         aoi_watch_first(run, 0, best, &c)) {
        const int status = look_ahead(run, c, best, run->free_state[0]);
        if (status != AOI_OK) {
            return status;
        }
        if (run->contact[c].flight.touches && run->contact[c].flight.until < best) {
            double *kept = run->free_state[0];
            run->free_state[0] = run->free_state[1];
            run->free_state[1] = kept;
            landed = c;
            best = run->contact[c].flight.until;
        } else if (!run->contact[c].flight.touches) {
            best = fmin(best, run->contact[c].flight.until);
        }
    }
    run->origin = run->time = best;
    run->elapsed = run->left_off = 0.0;
    (void)aoi_watch_first(run, 1, run->end, &c);
    if (c < run->system->contact_count && run->contact[c].flight.until <= best) {
        if (c == landed) {
            land(run, c, run->free_state[1]);
        }
        if (run->base > 0.0) {
            /* the coarsest level, which the estimate for the closing contact refines */
            run->level = AOI_HIGHEST_LEVEL;
        }
        run->indentation_scale = run->impulse_scale = 0.0;
        aoi_contact_close(run, c);
    }
    return AOI_OK;
}

/* Advances all bodies to the present time. If no contact is closed, all bodies are written to a row, from which
 * dense output starts. */
static void halt(aoi_adaptive *run)
{
    for (size_t b = 0; b < run->system->body_count; b++) {
        aoi_body_bring(run, b);
        if (run->closed.count == 0) {
            aoi_body_note_change(run, b);
        }
    }
    set_halt(run);
}

/* ------------------------------------------------------------------------- a step of contact */

/* Closes the contacts of bodies in free motion that touch now, and finds a time before which no other contact of
 * bodies in free motion closes. */
static int watch_free_pairs(aoi_adaptive *run)
{
    const size_t none = run->system->contact_count;
    const double now = aoi_run_now(run), step = aoi_run_step(run);
    const double rounding = 4.0 * DBL_EPSILON * now;
    const double ahead = fmax(now + STEPS_AHEAD * step, now + 2.0 * rounding);
    size_t c;
    if (now >= run->halt) {
        halt(run);
    }
    const double stop = fmin(run->end, run->halt), due = fmin(nextafter(now + rounding, HUGE_VAL), stop);
    for (aoi_watch_first(run, 0, due, &c); c < none; aoi_watch_first(run, 0, due, &c)) {
        const int status = look_ahead(run, c, fmin(stop, ahead), run->free_state[0]);
        if (status != AOI_OK) {
            return status;
        }
    }
    for (aoi_watch_first(run, 1, due, &c); c < none; aoi_watch_first(run, 1, due, &c)) {
        aoi_contact_close(run, c);
    }
    run->horizon = aoi_watch_first(run, 1, aoi_watch_first(run, 0, stop, &c), &c);
    return AOI_OK;
}

/* Lists the contacts and bodies of the next step, and sets `limit` to the largest length of the step, s. */
static int prepare(aoi_adaptive *run, double *limit)
{
    do {
        aoi_step_prepare(run);
        const int status = watch_free_pairs(run);
        if (status != AOI_OK) {
            return status;
        }
        if (run->unbalanced) {
            aoi_balance_at_once(run, 0);
            /* the balance may have raised forces, so that their peak may be at the present time */
            for (size_t i = 0; i < run->closed.count; i++) {
                aoi_contact_note_peak(run, run->closed.at[i], run->contact[run->closed.at[i]].closed.force, 0.0);
            }
            run->unbalanced = 0;
        }
    } while (run->closed_count != aoi_run_forces(run));
    const double now = aoi_run_now(run);
    double stop = run->horizon;
    for (size_t i = 0; i < run->engaged.count; i++) {
        stop = fmin(stop, aoi_modes_next_bend(&run->system->body[run->engaged.at[i]], now));
    }
    if (stop < run->end && stop - now <= 4.0 * DBL_EPSILON * stop) {
        /* a kink of a load is at the present time within rounding: step past it */
        run->elapsed += 8.0 * DBL_EPSILON * stop;
        return prepare(run, limit);
    }
    *limit = stop - now;
    return AOI_OK;
}

/* Sets the level to that of a step of length h or less, and at least one level finer than the present one. */
static void refine(aoi_adaptive *run, double h)
{
    const int level = aoi_level_from(run, AOI_LEVELS * log2(run->base / h));
    run->level = level > run->level ? level : aoi_level_from(run, run->level + 1);
    run->saved = 0.0;
}

/* Takes a coarser level, of longer steps, if the error allows the step length to grow by the factor `growth`. A
 * step at least twice as long is taken at once. A smaller increase waits until the number of steps that it would
 * have saved so far equals the cost of new tables, in units of a step's cost. */
static void coarsen(aoi_adaptive *run, double growth)
{
    const double longer = AOI_LEVELS * log2(fmin(growth, AOI_MOST_GROWTH));
    const int level = aoi_level_from(run, run->level - longer), rise = run->level - level;
    if (rise < LEAST_RISE || level < AOI_HIGHEST_LEVEL) {
        return;
    }
    run->saved += 1.0 - exp2(-(double)rise / AOI_LEVELS);
    if (rise >= AOI_LEVELS || run->saved >= run->table_cost) {
        run->level = level;
        run->saved = 0.0;
    }
}

/* Discards the events noted in a step that will be tried again, except the closing of contacts, which has been
 * carried out. */
static void forget_events(aoi_adaptive *run)
{
    for (size_t s = 0; s < run->entry_count; s++) {
        aoi_adaptive_contact *contact = &run->contact[run->entry[s].contact];
        contact->event = contact->event == AOI_EVENT_TOUCH ? AOI_EVENT_TOUCH : AOI_EVENT_NONE;
    }
}

/* Handles a step that is not accepted: applies the events at its start, ends it earlier, or takes a finer level. */
static int go_back(aoi_adaptive *run, const aoi_attempt *attempt, double *trim, int *trims,
                   double *limit)
{
    double growth = attempt->growth;
    if (attempt->closed) {
        forget_events(run);
        return prepare(run, limit);
    }
    if (growth > TRUSTED && attempt->place < 1.0) {
        const double after = attempt->place * attempt->h;
        const double place = fmax(attempt->place, aoi_event_tolerance(run, 1.0));
        const int at_start = aoi_is_at_start(run, after, attempt->h);
        /* a pull-off is applied at the end of a step */
        const int pulls_off = at_start && aoi_step_pulls_off(run, place);
        if (at_start && !pulls_off && aoi_step_at_start(run, place)) {
            return prepare(run, limit);
        }
        if ((!at_start || pulls_off) && (*trims)++ < MOST_TRIMS) {
            *trim = pulls_off ? fmax(after, AOI_AT_START * attempt->h) : after;
            return AOI_OK;
        }
        growth = UNCONFIRMED;
    }
    run->rejected++;
    refine(run, attempt->h * fmax(growth, LEAST_SHRINKAGE));
    *trim = HUGE_VAL;
    return AOI_OK;
}

/* True if a law written by the caller has returned NaN; the number of its contact is then kept in `failed`. */
static int law_fails(aoi_adaptive *run)
{
    for (size_t c = 0; c < run->system->contact_count; c++) {
        const aoi_law *law = run->system->contact[c].law;
        if (law->note && !isnan(law->note[0])) {
            run->failed = c;
            return 1;
        }
    }
    return 0;
}

/* Returns the length of the next step, s, and sets its level. A step that ends at an event or a limit has no
 * level. */
static double step_length(const aoi_adaptive *run, double limit, double trim, int *level)
{
    const double usual = aoi_run_step(run), stop = fmin(limit, trim);
    const double h = trim < HUGE_VAL ? usual : aoi_release_step(run, usual);
    *level = h < usual ? AOI_NO_LEVEL : run->level;
    /* If less than this share of a step would remain before its end point, the step is lengthened to reach that
     * point: in so short a step, rates are dominated by rounding. Measured and tried: from 3e-7 to 3e-6 no run
     * changes. */
    if (stop <= h * (1.0 + 1e-6)) {
        *level = AOI_NO_LEVEL;
        return stop;
    }
    return h;
}

static int contact_step(aoi_adaptive *run, double *row, size_t *size)
{
    double limit, trim = HUGE_VAL, unconfirmed = 0.0;
    int trims = 0, idle = 0;
    if (run->base == 0.0) {
        run->base = run->end - aoi_run_now(run);
        run->level = 10 * AOI_LEVELS;
    }
    int status = prepare(run, &limit);
    while (status == AOI_OK && run->level < AOI_DEEPEST_LEVEL && idle++ < MOST_IDLE) {
        if (run->closed_count == 0) {
            *size = 0;
            return AOI_OK;
        }
        int level;
        const double h = step_length(run, limit, trim, &level);
        if (!(run->elapsed + h > run->elapsed)) {
            break; /* h is below the rounding error of the time */
        }
        aoi_attempt attempt;
        aoi_step_try(run, h, level, &attempt);
        if (attempt.growth >= 1.0 && attempt.place >= 1.0 && !attempt.closed) {
            status = aoi_step_accept(run, &attempt, row, size);
            if (level != AOI_NO_LEVEL) {
                coarsen(run, attempt.growth);
            } else if (trim < HUGE_VAL && attempt.place > 1.0 && unconfirmed > 0.0) {
                refine(run, unconfirmed); /* the step was cut short for an event that did not occur */
            }
            run->time = aoi_run_now(run);
            if (run->end - run->time <= 4.0 * DBL_EPSILON * run->end) {
                run->time = run->end;
            }
            return status;
        }
        unconfirmed = attempt.corner ? 0.0 : h * fmax(fmin(attempt.growth, UNCONFIRMED), LEAST_SHRINKAGE);
        status = go_back(run, &attempt, &trim, &trims, &limit);
    }
    return status != AOI_OK ? status : law_fails(run) ? AOI_ERROR_LAW : AOI_ERROR_TOLERANCE;
}

/* Advances all bodies from their last state to the end of the run in free motion. */
static int advance_all_to_end(aoi_adaptive *run)
{
    const size_t all = run->system->first[run->system->body_count];
    for (size_t b = 0; b < run->system->body_count; b++) {
        const size_t at = run->system->first[b];
        aoi_modes_advance(&run->system->body[b], run->body[b].time, run->end, run->x + at, run->v + at);
        run->body[b].time = run->end;
    }
    return aoi_vector_is_finite(all, run->x) && aoi_vector_is_finite(all, run->v) ? AOI_OK : AOI_ERROR_NOT_FINITE;
}

/* Advances the run by at most one row of its track. idle: number of successive calls in which the time has not
 * advanced. */
static int go_on(aoi_adaptive *run, aoi_track *track, int idle, int *paused)
{
    const double began = run->time, next_halt = run->halt;
    double *row = track->values + track->used, *of;
    size_t size = 0;
    int status = AOI_OK;
    if (idle >= MOST_IDLE) {
        return AOI_ERROR_TOLERANCE;
    }
    if (run->closed.count > 0) {
        status = contact_step(run, row, &size);
        *paused = run->halt > next_halt && run->time > began;
    } else if (run->changed.count > 0) {
        size = aoi_step_write(run, 0.0, 0, row, &of);
    } else if (run->time >= run->halt) {
        halt(run);
    } else {
        status = move_freely(run);
        *paused = run->time < run->end && run->closed.count == 0;
    }
    if (status == AOI_OK && !aoi_vector_is_finite(size, row)) {
        return AOI_ERROR_NOT_FINITE; /* energies may overflow where nothing else does */
    }
    if (status == AOI_OK && size > 0) {
        track->row[track->rows++] = track->used;
        track->used += size;
    }
    return status;
}

int aoi_adaptive_run(aoi_adaptive *run, aoi_track *track)
{
    double before = run->time;
    int status = AOI_OK, paused = 0;
    for (int idle = 0; status == AOI_OK && !paused && run->time < run->end &&
                       track->capacity - track->used >= run->row_size &&
                       track->rows < track->row_capacity;
         idle++) {
        idle = run->time > before ? 0 : idle;
        before = run->time;
        status = go_on(run, track, idle, &paused);
    }
    if (status == AOI_OK && !(run->time < run->end)) {
        status = advance_all_to_end(run);
    }
    return status;
}

/* Initial capacity of a track, in values and in rows; most runs need less. */
enum { FIRST_VALUES = 4096, FIRST_ROWS = 48 };

int aoi_track_grow(aoi_track *track, size_t room, void *(*resize)(void *memory, size_t bytes))
{
    const size_t capacity = track->capacity > 0 ? aoi_times(2, track->capacity) : aoi_plus(room, FIRST_VALUES);
    const size_t rows = track->row_capacity > 0 ? aoi_times(2, track->row_capacity) : FIRST_ROWS;
    double *values = resize(track->values, aoi_times(capacity, sizeof *values));
    track->values = values ? values : track->values;
    size_t *row = values ? resize(track->row, aoi_times(rows, sizeof *row)) : NULL;
    track->row = row ? row : track->row;
    if (!row) {
        return AOI_ERROR_TOO_LONG;
    }
    track->capacity = capacity;
    track->row_capacity = rows;
    return AOI_OK;
}

int aoi_adaptive_finish(aoi_adaptive *run, aoi_track *track)
{
    int status = AOI_OK;
    for (double before = -HUGE_VAL; status == AOI_OK && run->time > before && run->time < run->end;) {
        before = run->time;
        status = aoi_adaptive_run(run, track);
    }
    return status == AOI_OK && run->time < run->end ? AOI_ERROR_TOO_LONG : status;
}
