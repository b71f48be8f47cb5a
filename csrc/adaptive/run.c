/* The adaptive run: contact by collocation in steps of base 2^(-level/8), free motion in closed form, and what
 * makes the one follow the other. */
#include "adaptive/row.h"
#include "adaptive/run.h"
#include "linear/work.h"
#include "law/law.h"
#include "model/system.h"
#include "motion/energy.h"
#include "motion/free.h"
#include "motion/modes.h"
#include "motion/response.h"
#include "collocation/collocation.h"

#include <float.h>
#include <math.h>

enum {
    LEAST_RISE = 2, /* of levels at once */
    MOST_TRIMS = 12,
    MOST_IDLE = 1000
};

/* An event closer to the start than this share of the step happens at the start. */
static const double AT_START = 1e-9;

/* Beside a contact, bodies that move freely and ring are looked at so many steps ahead. */
static const double STEPS_AHEAD = 64.0;

/* A rest of a step shorter than this share of it is taken along: over it rates are noise. */
static const double SLIVER = 1e-6;

/* After a failure steps are shorter by this at most and at least. */
static const double LEAST_SHRINKAGE = 0.06, MOST_SHRINKAGE = 0.85;

/* And by this at least where the event that a step was cut short for was none. */
static const double NOT_THERE = 0.5;

/* After a success they are longer by 2^(LEAST_RISE/AOI_LEVELS) at least. Tables of new lengths cost so many steps
 * for each mode of the largest body. */
static const double WORTH_IT = 1.18, TABLE_COST = 1.0;

/* A step worse than this is so far off that its events are not to be trusted. */
static const double TRUSTED = 0.1;

int aoi_is_at_start(const aoi_adaptive *run, double after, double h)
{
    return after < fmax(AT_START, aoi_event_tolerance(run, 1.0)) * h || !(run->elapsed + after > run->elapsed);
}

/* The length of a step of the run's level. */
static double step_of_level(const aoi_adaptive *run)
{
    return run->base * exp2(-(double)run->level / AOI_LEVELS);
}

/* ------------------------------------------------------------------------------ work space */

static size_t tables_of(const aoi_modes *body) { return body->n > 1 ? AOI_TABLES : 1; }

/* Whether a force depends on the rate, or a contact has no mass. */
static int is_quick(const aoi_system *system)
{
    for (size_t c = 0; c < system->contact_count; c++) {
        if (system->contact[c].law->depends_on_rate ||
            aoi_system_residual(system, c) > 0.0) {
            return 1;
        }
    }
    return 0;
}

size_t aoi_adaptive_room(const aoi_system *system)
{
    if (!system->first) {
        return 0;
    }
    return AOI_TRACK_FIXED + system->contact_count * AOI_TRACK_CONTACT_SIZE +
           AOI_TRACK_STATE * system->body_count + 2 * system->first[system->body_count];
}

/* Deals out memory behind the run itself, which is only counted where block is NULL. */
static size_t lay_out(aoi_adaptive *run, const aoi_system *system, void *block)
{
    const size_t bodies = system->body_count, contacts = system->contact_count;
    aoi_memory memory = {block, 0};
    (void)aoi_memory_take(&memory, 1, sizeof *run);
    run->body = aoi_memory_take(&memory, bodies, sizeof *run->body);
    run->contact = aoi_memory_take(&memory, contacts, sizeof *run->contact);
    run->entry = aoi_memory_take(&memory, contacts, sizeof *run->entry);
    run->response = aoi_memory_take(&memory, bodies, sizeof *run->response);
    run->balanced = aoi_memory_take(&memory, contacts, sizeof *run->balanced);
    run->engaged.at = aoi_memory_numbers(&memory, bodies);
    run->changed.at = aoi_memory_numbers(&memory, bodies);
    run->closed.at = aoi_memory_numbers(&memory, contacts);
    run->watched[0].at = aoi_memory_numbers(&memory, contacts);
    run->watched[1].at = aoi_memory_numbers(&memory, contacts);
    run->x = aoi_memory_doubles(&memory, system->first[bodies]);
    run->v = aoi_memory_doubles(&memory, system->first[bodies]);
    run->flight[0] = aoi_memory_doubles(&memory, 4 * aoi_system_most_modes(system));
    run->flight[1] = aoi_memory_doubles(&memory, 4 * aoi_system_most_modes(system));
    run->scratch = aoi_memory_doubles(&memory, 2 * aoi_system_most_modes(system));
    run->port_force = aoi_memory_doubles(&memory, system->first_port[bodies] * AOI_NODES);
    run->port_slope = aoi_memory_doubles(&memory, system->first_port[bodies] * AOI_NODES);
    run->collocation = aoi_memory_doubles(&memory, aoi_collocation_size(contacts, run->span));
    for (size_t b = 0; b < bodies; b++) {
        const size_t tables = tables_of(&system->body[b]);
        double *tabled = aoi_memory_doubles(&memory, tables * aoi_response_size(&system->body[b]));
        if (block) {
            run->body[b] = (aoi_adaptive_body){.block = tabled, .table_count = tables};
        }
    }
    return memory.used;
}

size_t aoi_adaptive_size(const aoi_system *system)
{
    if (!system->first) {
        return 0;
    }
    aoi_adaptive counted = {.span = aoi_system_span(system)};
    return lay_out(&counted, system, NULL);
}

/* -------------------------------------------------------------------------------- the start */

/* Bodies that press on each other from the start. */
static void start_closed(aoi_adaptive *run, size_t c)
{
    aoi_adaptive_contact *contact = &run->contact[c];
    const aoi_contact *of = &run->system->contact[c];
    const double delta = contact->start;
    aoi_law_value value;
    aoi_law_remember(of->law, delta, 0.0, contact->memory);
    aoi_contact_close(run, c);
    contact->start = delta;
    aoi_law_force(of->law, contact->memory, contact->piece, delta, contact->start_rate, &value);
    contact->force = value.force;
    aoi_contact_note_peak(run, c);
    const double time = 1.0 / sqrt(value.stiffness * contact->mobility);
    contact->indentation_scale = fmax(contact->indentation_scale, delta);
    contact->impulse_scale = fmax(contact->impulse_scale, value.force * time);
    if (isfinite(time) && time > 0.0 && run->base == 0.0) {
        run->base = 3.0 * time;
        run->level = 0;
    }
    run->indentation_scale = fmax(run->indentation_scale, contact->indentation_scale);
    run->impulse_scale = fmax(run->impulse_scale, contact->impulse_scale);
}

/* What loads and contacts that press from the start have bent already is no work of this run. */
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
                (side == 0 ? -1.0 : 1.0) * run->contact[c].force;
        }
    }
    for (size_t b = 0; b < system->body_count; b++) {
        run->body[b].work =
            -aoi_modes_bent_work(&system->body[b], run->time, force + system->first_port[b]);
    }
}

static void begin_bodies(aoi_adaptive *run)
{
    for (size_t b = 0; b < run->system->body_count; b++) {
        run->body[b].time = run->time;
        aoi_body_note_change(run, b);
    }
}

static int begin_contacts(aoi_adaptive *run)
{
    for (size_t c = 0; c < run->system->contact_count; c++) {
        run->contact[c] = (aoi_adaptive_contact){.low = -HUGE_VAL, .high = HUGE_VAL, .free_until = -HUGE_VAL};
        run->contact[c].peak_time = run->time;
    }
    const int status = aoi_balance_at_start(run);
    aoi_watch_begin(run);
    for (size_t c = 0; c < run->system->contact_count && status == AOI_OK; c++) {
        if (run->contact[c].start > 0.0) {
            start_closed(run, c);
        } else {
            aoi_watch_add(run, c);
        }
    }
    return status;
}

/* Copies the modes at the start; 0 where they are no numbers. */
static int take_state(const double *from, size_t count, double *to)
{
    for (size_t j = 0; j < count; j++) {
        to[j] = from ? from[j] : 0.0;
        if (!isfinite(to[j])) {
            return 0;
        }
    }
    return 1;
}

int aoi_adaptive_start(aoi_adaptive *run, const aoi_system *system, const aoi_start *start, double rtol,
                       double end)
{
    if (!system->first || !(rtol > 0.0 && rtol < 1.0) || !(end > 0.0) || !isfinite(end)) {
        return AOI_ERROR_ARGUMENT;
    }
    const size_t modes = aoi_system_most_modes(system), all = system->first[system->body_count];
    *run = (aoi_adaptive){.system = system, .rtol = rtol, .end = end, .rested = start->rested};
    run->span = aoi_system_span(system);
    run->row_size = aoi_adaptive_room(system);
    run->grain = modes > 1 && is_quick(system) ? AOI_LEVELS : 1;
    run->table_cost = modes > 1 ? TABLE_COST * (double)modes : 0.0;
    (void)lay_out(run, system, run);
    if (!take_state(start->x, all, run->x) || !take_state(start->v, all, run->v)) {
        return AOI_ERROR_NOT_FINITE;
    }
    begin_bodies(run);
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
    const aoi_adaptive_contact *of = &run->contact[contact];
    return (aoi_peak){of->peak_force, of->peak_time, of->impulse};
}

/* ---------------------------------------------------------------------------------- free motion */

/* A body without oscillations: one look sees its free motion to the end. */
static int is_simple(const aoi_modes *body) { return body->n == 1 && body->omega[0] == 0.0; }

/* Looks when the bodies of a watched contact touch, up to limit, on copies of their states. */
static int look_ahead(aoi_adaptive *run, size_t c, double limit, double *copy)
{
    const aoi_system *system = run->system;
    aoi_adaptive_contact *contact = &run->contact[c];
    const aoi_contact *of = &system->contact[c];
    const double now = aoi_run_now(run);
    aoi_free_pair pair;
    aoi_watch_remove(run, c);
    aoi_pair_now(run, c, &pair);
    pair.gap += aoi_law_rest(of->law, contact->memory) + contact->slack;
    for (int side = 0; side < 2; side++) {
        const size_t b = of->body[side], n = system->body[b].n, first = system->first[b];
        for (size_t j = 0; j < n; j++) {
            copy[j] = run->x[first + j];
            copy[n + j] = run->v[first + j];
        }
        aoi_modes_advance(&system->body[b], run->body[b].time, now, copy, copy + n);
        pair.x[side] = copy;
        pair.v[side] = copy + n;
        copy += 2 * n;
    }
    limit = is_simple(pair.body[0]) && is_simple(pair.body[1]) ? run->end : limit;
    const size_t most = 1 + AOI_MOST_LOOKS / (pair.body[0]->n + pair.body[1]->n);
    const int status = aoi_free_pair_next_touch(&pair, limit, most, &contact->touches);
    contact->free_until = pair.time;
    aoi_watch_add(run, c);
    if (status == AOI_ERROR_NO_CONVERGENCE && pair.time > now) {
        return AOI_OK; /* so far at least */
    }
    run->failed = status != AOI_OK ? c : run->failed;
    return status;
}

/* The bodies of a contact as look_ahead has left them, at the time now. */
static void land(aoi_adaptive *run, size_t c, const double *copy)
{
    const aoi_system *system = run->system;
    for (int side = 0; side < 2; side++) {
        const size_t b = system->contact[c].body[side];
        const size_t n = system->body[b].n, first = system->first[b];
        aoi_body_account(run, b, aoi_run_now(run), copy, copy + n);
        for (size_t j = 0; j < n; j++) {
            run->x[first + j] = copy[j];
            run->v[first + j] = copy[n + j];
        }
        run->body[b].time = aoi_run_now(run);
        copy += 2 * n;
    }
}

/* Nothing touches: on to the first touch of all, or to the end; or, where that takes long to find, as far as it is
 * certain that nothing does. */
static int move_freely(aoi_adaptive *run)
{
    size_t c, landed = run->system->contact_count;
    aoi_step_release(run);
    double best = aoi_watch_first(run, 1, run->end, &c);
    for (aoi_watch_first(run, 0, best, &c); c < run->system->contact_count;
         aoi_watch_first(run, 0, best, &c)) {
        const int status = look_ahead(run, c, best, run->flight[0]);
        if (status != AOI_OK) {
            return status;
        }
        if (run->contact[c].touches && run->contact[c].free_until < best) {
            double *kept = run->flight[0];
            run->flight[0] = run->flight[1];
            run->flight[1] = kept;
            landed = c;
            best = run->contact[c].free_until;
        } else if (!run->contact[c].touches) {
            best = fmin(best, run->contact[c].free_until);
        }
    }
    run->origin = run->time = best;
    run->elapsed = run->left_off = 0.0;
    (void)aoi_watch_first(run, 1, run->end, &c);
    if (c < run->system->contact_count && run->contact[c].free_until <= best) {
        if (c == landed) {
            land(run, c, run->flight[1]);
        }
        if (run->base > 0.0) {
            run->level = AOI_HIGHEST_LEVEL; /* the contact itself says how fine */
        }
        run->indentation_scale = run->impulse_scale = 0.0;
        aoi_contact_close(run, c);
    }
    return AOI_OK;
}

/* ------------------------------------------------------------------------- a step of contact */

/* Closes contacts of bodies in free motion whose time has come, and finds out how long the others are
 * certain not to touch. */
static int watch_free_pairs(aoi_adaptive *run)
{
    const size_t none = run->system->contact_count;
    const double now = aoi_run_now(run), step = step_of_level(run);
    const double rounding = 4.0 * DBL_EPSILON * now;
    const double due = fmin(nextafter(now + rounding, HUGE_VAL), run->end);
    const double ahead = fmax(now + STEPS_AHEAD * step, now + 2.0 * rounding);
    size_t c;
    for (aoi_watch_first(run, 0, due, &c); c < none; aoi_watch_first(run, 0, due, &c)) {
        const int status = look_ahead(run, c, fmin(run->end, ahead), run->flight[0]);
        if (status != AOI_OK) {
            return status;
        }
    }
    for (aoi_watch_first(run, 1, due, &c); c < none; aoi_watch_first(run, 1, due, &c)) {
        aoi_contact_close(run, c);
    }
    run->horizon = aoi_watch_first(run, 1, aoi_watch_first(run, 0, run->end, &c), &c);
    return AOI_OK;
}

/* Lists who takes part; how long the step may be at most. */
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
            run->unbalanced = 0;
        }
    } while (run->closed_count != run->closed.count);
    const double now = aoi_run_now(run);
    double stop = run->horizon;
    for (size_t i = 0; i < run->engaged.count; i++) {
        stop = fmin(stop, aoi_modes_next_bend(&run->system->body[run->engaged.at[i]], now));
    }
    if (stop < run->end && stop - now <= 4.0 * DBL_EPSILON * stop) {
        run->elapsed += 8.0 * DBL_EPSILON * stop; /* as good as there */
        return prepare(run, limit);
    }
    *limit = stop - now;
    return AOI_OK;
}

/* Takes the level of a step at most so long; in any case a finer one. */
static void refine(aoi_adaptive *run, double h)
{
    const int level = aoi_level_from(run, AOI_LEVELS * log2(run->base / h));
    run->level = level > run->level ? level : aoi_level_from(run, run->level + 1);
    run->saved = 0.0;
}

/* Takes a coarser level where that is not likely to fail: at once where steps are to be twice as long, else
 * when it would have saved what its tables cost, since a contact may well go on for as long as it has. */
static void coarsen(aoi_adaptive *run, double growth)
{
    if (growth < WORTH_IT) {
        return;
    }
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

/* What has been noted of the step happens later, if at all; but contacts have been closed. */
static void forget_events(aoi_adaptive *run)
{
    for (size_t s = 0; s < run->entry_count; s++) {
        aoi_adaptive_contact *contact = &run->contact[run->entry[s].contact];
        contact->event = contact->event == AOI_EVENT_TOUCH ? AOI_EVENT_TOUCH : AOI_EVENT_NONE;
    }
}

/* What to do after a step that cannot be taken: events at its start, an earlier end, a finer level. */
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
        const int snaps = at_start && aoi_step_snaps(run, place); /* which the end of a step lets happen */
        if (at_start && !snaps && aoi_step_at_start(run, place)) {
            return prepare(run, limit);
        }
        if ((!at_start || snaps) && (*trims)++ < MOST_TRIMS) {
            *trim = snaps ? fmax(after, AT_START * attempt->h) : after;
            return AOI_OK;
        }
        growth = 0.4;
    }
    run->rejected++;
    refine(run, attempt->h * fmin(fmax(growth, LEAST_SHRINKAGE), MOST_SHRINKAGE));
    *trim = HUGE_VAL;
    return AOI_OK;
}

/* Whether a law gives no number where a closed contact is now. */
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

/* The length of the next step, and its level if it has one: none if it ends where something happens. */
static double step_length(const aoi_adaptive *run, double limit, double trim, int *level)
{
    const double usual = step_of_level(run), stop = fmin(limit, trim);
    const double h = trim < HUGE_VAL ? usual : aoi_release_step(run, usual);
    *level = h < usual ? AOI_NO_LEVEL : run->level;
    if (stop <= h * (1.0 + SLIVER)) { /* and no sliver is left over */
        *level = AOI_NO_LEVEL;
        return stop;
    }
    return h;
}

static int contact_step(aoi_adaptive *run, double *row, size_t *size)
{
    double limit, trim = HUGE_VAL, doubted = 0.0;
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
            break; /* shorter than the clock can tell */
        }
        aoi_attempt attempt;
        aoi_step_try(run, h, level, &attempt);
        if (attempt.growth >= 1.0 && attempt.place >= 1.0 && !attempt.closed) {
            status = aoi_step_accept(run, &attempt, row, size);
            if (level != AOI_NO_LEVEL) {
                coarsen(run, attempt.growth);
            } else if (trim < HUGE_VAL && attempt.place > 1.0 && doubted > 0.0) {
                refine(run, doubted); /* what it was cut short for was no event: nor is it to be again */
            }
            run->time = aoi_run_now(run);
            if (run->end - run->time <= 4.0 * DBL_EPSILON * run->end) {
                run->time = run->end;
            }
            return status;
        }
        doubted = h * fmax(fmin(attempt.growth, NOT_THERE), LEAST_SHRINKAGE);
        status = go_back(run, &attempt, &trim, &trims, &limit);
    }
    return status != AOI_OK ? status : law_fails(run) ? AOI_ERROR_LAW : AOI_ERROR_TOLERANCE;
}

/* Bodies that have not been asked for since move on freely to the end. */
static void bring_all_home(aoi_adaptive *run)
{
    for (size_t b = 0; b < run->system->body_count; b++) {
        const size_t at = run->system->first[b];
        aoi_modes_advance(&run->system->body[b], run->body[b].time, run->end, run->x + at, run->v + at);
        run->body[b].time = run->end;
    }
}

/* Goes on by one row at most. idle: how often in turn no time has passed. */
static int go_on(aoi_adaptive *run, aoi_track *track, int idle, int *paused)
{
    double *row = track->values + track->used;
    size_t size = 0;
    int status = AOI_OK;
    if (idle >= MOST_IDLE) {
        return AOI_ERROR_TOLERANCE;
    }
    if (run->closed.count > 0) {
        status = contact_step(run, row, &size);
    } else if (run->changed.count > 0) {
        size = aoi_step_write(run, 0.0, 0, row);
    } else {
        status = move_freely(run);
        *paused = run->time < run->end && run->closed.count == 0;
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
        bring_all_home(run);
    }
    return status;
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
