/* The state of a run and the operations on it that the other files share: the time, the advance of a body to this
 * time, the indentation of a contact, and the tolerance of an event. */
#include "adaptive/run.h"
#include "adaptive/step.h"
#include "law/law.h"
#include "model/modes.h"
#include "model/system.h"
#include "motion/energy.h"
#include "motion/free.h"
#include "motion/modes.h"

#include <float.h>
#include <math.h>
#include <string.h>

/* EVENT_SHARE: tolerance of events as a share of rtol; see ../README.md. PLACE_ROUNDING: rounding error of an
 * indentation, which is a difference of sums over modes, in units of machine precision times the sum of the terms'
 * magnitudes. Measured: from 3 to 24 no run changes. Tried with a third and three times the value: 7 runs change,
 * by a relative 2e-11. */
static const double EVENT_SHARE = 0.01, PLACE_ROUNDING = 8.0;

/* ----------------------------------------------------------------------------------------- time */

double aoi_run_now(const aoi_adaptive *run) { return run->origin + run->elapsed; }

size_t aoi_run_forces(const aoi_adaptive *run)
{
    size_t count = run->closed.count;
    for (size_t i = 0; i < run->closed.count && aoi_system_rubs(run->system); i++) {
        count += aoi_contact_forces(&run->system->contact[run->closed.at[i]]) - 1;
    }
    return count;
}

double aoi_run_step(const aoi_adaptive *run)
{
    return run->base * exp2(-(double)run->level / AOI_LEVELS);
}

int aoi_is_at_start(const aoi_adaptive *run, double after, double h)
{
    return after < fmax(AOI_AT_START, aoi_event_tolerance(run, 1.0)) * h || !(run->elapsed + after > run->elapsed);
}

/* --------------------------------------------------------------------------------------- bodies */

/* Adds the work and the dissipated energy of a body's free motion, from its last state to the given time and
 * state, to its totals. */
static void account(aoi_adaptive *run, size_t b, double time, const double *x, const double *v)
{
    const aoi_modes *body = &run->system->body[b];
    const size_t at = run->system->first[b];
    double work, dissipated;
    if (aoi_body_has_ledger(body)) {
        aoi_modes_free_work(body, run->body[b].time, time, run->x + at, run->v + at, x, v,
                              run->free_state[0], &work, &dissipated);
        run->body[b].work += work;
        run->body[b].dissipated += dissipated;
    }
}

void aoi_body_copy(const aoi_adaptive *run, size_t b, double *state)
{
    const size_t n = run->system->body[b].n, at = run->system->first[b];
    memcpy(state, run->x + at, n * sizeof *state);
    memcpy(state + n, run->v + at, n * sizeof *state);
}

void aoi_body_take(aoi_adaptive *run, size_t b, const double *state)
{
    const size_t n = run->system->body[b].n, at = run->system->first[b];
    account(run, b, aoi_run_now(run), state, state + n);
    memcpy(run->x + at, state, n * sizeof *state);
    memcpy(run->v + at, state + n, n * sizeof *state);
    run->body[b].time = aoi_run_now(run);
}

void aoi_body_bring(aoi_adaptive *run, size_t b)
{
    const double now = aoi_run_now(run);
    if (run->body[b].time < now) {
        aoi_body_copy(run, b, run->scratch);
        aoi_modes_advance(&run->system->body[b], run->body[b].time, now, run->scratch,
                          run->scratch + run->system->body[b].n);
        aoi_body_take(run, b, run->scratch);
    }
}

void aoi_body_engage(aoi_adaptive *run, size_t b, int how)
{
    aoi_adaptive_body *body = &run->body[b];
    if (how > AOI_WATCHED && !aoi_modes_can_move(&run->system->body[b])) {
        how = AOI_WATCHED;
    }
    if (body->engaged == AOI_FREE_MOTION) {
        run->engaged.at[run->engaged.count++] = b;
    }
    body->engaged = how > body->engaged ? how : body->engaged;
    aoi_body_bring(run, b);
}

void aoi_body_note_change(aoi_adaptive *run, size_t b)
{
    if (!run->body[b].changed) {
        run->body[b].changed = 1;
        run->changed.at[run->changed.count++] = b;
    }
}

void aoi_pair_now(const aoi_adaptive *run, size_t c, aoi_free_pair *pair)
{
    const aoi_contact *of = &run->system->contact[c];
    for (int side = 0; side < 2; side++) {
        const size_t at = run->system->first[of->body[side]];
        pair->body[side] = &run->system->body[of->body[side]];
        pair->port[side] = of->port[side];
        pair->x[side] = run->x + at;
        pair->v[side] = run->v + at;
    }
    pair->gap = of->gap;
    pair->time = aoi_run_now(run);
    pair->forced = NULL;
}

/* ------------------------------------------------------------------------------------- contacts */

/* Contact forces deflect the residual compliance of both bodies, which reduces the indentation. closed.start
 * includes this reduction; the motion without contact forces does not. */
double aoi_contact_bent(const aoi_adaptive *run, size_t c, int rates)
{
    const aoi_contact *of = &run->system->contact[c];
    double sum = 0.0;
    for (int side = 0; side < 2; side++) {
        const aoi_modes *body = &run->system->body[of->body[side]];
        const size_t end = body->residual ? run->system->first_contact[of->body[side] + 1] : 0;
        for (size_t i = run->system->first_contact[of->body[side]]; i < end; i++) {
            const size_t joint_by = run->system->contact_of[i];
            const aoi_contact *by = &run->system->contact[joint_by];
            const int other = by->body[1] == of->body[side];
            const double compliance = body->residual[of->port[side] * body->ports + by->port[other]];
            const aoi_adaptive_contact *contact = &run->contact[joint_by];
            sum += (side == other ? 1.0 : -1.0) * compliance *
                   (rates ? contact->massless.force_rate : contact->massless.bending);
        }
    }
    return sum;
}

double aoi_contact_free(const aoi_adaptive *run, size_t c, double *rate)
{
    double of[2];
    aoi_free_pair pair;
    aoi_pair_now(run, c, &pair);
    aoi_free_pair_motion(&pair, 1, of);
    *rate = of[1];
    return of[0];
}

double aoi_contact_place(const aoi_adaptive *run, size_t c)
{
    double rate;
    return aoi_contact_free(run, c, &rate) - aoi_contact_bent(run, c, 0);
}

double aoi_contact_slide(const aoi_adaptive *run, size_t c, size_t axis)
{
    const aoi_contact *of = &run->system->contact[c];
    double slide[2], rate;
    for (int side = 0; side < 2; side++) {
        const size_t at = run->system->first[of->body[side]];
        aoi_modes_port(&run->system->body[of->body[side]], of->port[side] + axis, run->x + at, run->v + at, &slide[side],
                       &rate);
    }
    return slide[0] - slide[1];
}

void aoi_contact_note_peak(aoi_adaptive *run, size_t c, double force, double after)
{
    aoi_adaptive_contact *contact = &run->contact[c];
    if (force > contact->ledger.peak.force) {
        contact->ledger.peak.force = force;
        contact->ledger.peak.time = fmin(aoi_run_now(run) + after, run->end);
    }
}

void aoi_contact_take_piece(const aoi_law *law, aoi_adaptive_contact *contact, double indentation, int rising)
{
    aoi_closed *now = &contact->closed;
    now->piece = aoi_law_piece(law, contact->memory, indentation, rising, &now->low, &now->high);
}

void aoi_contact_press_again(const aoi_law *law, aoi_adaptive_contact *contact)
{
    contact->closed.begins = 1;
    contact->closed.touch_rate = contact->closed.rate;
    contact->closed.last_length = 0.0;
    aoi_contact_take_piece(law, contact, contact->closed.start, contact->closed.rate > 0.0);
}

void aoi_contact_open(aoi_adaptive *run, size_t c)
{
    size_t at = 0;
    while (run->closed.at[at] != c) {
        at++;
    }
    run->closed.count--;
    for (; at < run->closed.count; at++) {
        run->closed.at[at] = run->closed.at[at + 1];
    }
    aoi_adaptive_contact *contact = &run->contact[c];
    const aoi_law *law = run->system->contact[c].law;
    contact->is_closed = contact->flight.touches = 0;
    contact->flight.until = aoi_run_now(run);
    contact->closed.force = contact->massless.bending = contact->massless.force_rate = 0.0;
    /* tells the law that the bodies have parted */
    aoi_law_remember(law, aoi_law_rest(law, contact->memory), -1.0, contact->memory);
}

/* --------------------------------------------------------------------------------------- events */

double aoi_event_tolerance(const aoi_adaptive *run, double scale)
{
    return fmax(EVENT_SHARE * run->rtol, 4.0 * DBL_EPSILON) * scale;
}

/* Returns the rounding error of an indentation, a difference of sums over modes, m. */
static double rounding_of(const aoi_free_pair *pair)
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

double aoi_touch_tolerance(aoi_adaptive *run, const aoi_contact_step *entry)
{
    aoi_free_pair pair;
    aoi_pair_now(run, entry->contact, &pair);
    return fmax(EVENT_SHARE * run->rtol * aoi_step_scale(run, entry, 0.0), rounding_of(&pair));
}

void aoi_step_note_event(double place, int kind, aoi_adaptive_contact *contact, aoi_attempt *attempt)
{
    if (place < contact->event_place) {
        contact->event_place = place;
        contact->event = kind;
    }
    attempt->place = place < attempt->place ? place : attempt->place;
}

int aoi_step_piece(const aoi_law *law, const aoi_contact_step *entry)
{
    double low, high;
    return entry->piece != AOI_SLACK
               ? entry->piece
               : aoi_law_piece(law, entry->memory, entry->start, entry->start_rate > 0.0, &low, &high);
}
