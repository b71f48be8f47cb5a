/* The contacts and bodies that take part in a step. Each body is first advanced to the time of the run. */
#include "adaptive/run.h"
#include "adaptive/step.h"
#include "model/modes.h"
#include "motion/energy.h"
#include "motion/free.h"
#include "motion/modes.h"

#include <math.h>

double aoi_run_now(const aoi_adaptive *run) { return run->origin + run->elapsed; }

void aoi_body_account(aoi_adaptive *run, size_t b, double time, const double *x, const double *v)
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

void aoi_body_bring(aoi_adaptive *run, size_t b)
{
    aoi_adaptive_body *body = &run->body[b];
    const size_t at = run->system->first[b];
    const double now = aoi_run_now(run);
    if (body->time < now) {
        const size_t n = run->system->body[b].n;
        for (size_t j = 0; j < n; j++) {
            run->scratch[j] = run->x[at + j];
            run->scratch[n + j] = run->v[at + j];
        }
        aoi_modes_advance(&run->system->body[b], body->time, now, run->scratch, run->scratch + n);
        aoi_body_account(run, b, now, run->scratch, run->scratch + n);
        for (size_t j = 0; j < n; j++) {
            run->x[at + j] = run->scratch[j];
            run->v[at + j] = run->scratch[n + j];
        }
        body->time = now;
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

void aoi_step_release(aoi_adaptive *run)
{
    for (size_t i = 0; i < run->engaged.count; i++) {
        run->body[run->engaged.at[i]].engaged = AOI_FREE_MOTION;
    }
    for (size_t s = 0; s < run->entry_count; s++) {
        if (!run->contact[run->entry[s].contact].closed) {
            aoi_watch_add(run, run->entry[s].contact);
        }
    }
    run->engaged.count = run->closed_count = run->entry_count = 0;
}

/* Adds the open contacts of a body under force to the step: their searches for a touch assumed free motion. */
static void bring_along(aoi_adaptive *run, size_t b)
{
    const aoi_system *system = run->system;
    for (size_t i = system->first_contact[b]; i < system->first_contact[b + 1]; i++) {
        const size_t c = system->contact_of[i];
        if (aoi_watch_remove(run, c)) {
            run->entry[run->entry_count++].contact = c;
            run->contact[c].free_until = -HUGE_VAL;
            run->contact[c].touches = 0;
            aoi_body_engage(run, system->contact[c].body[0], AOI_WATCHED);
            aoi_body_engage(run, system->contact[c].body[1], AOI_WATCHED);
        }
    }
}

void aoi_step_prepare(aoi_adaptive *run)
{
    aoi_step_release(run);
    for (size_t i = 0; i < run->closed.count; i++) {
        const size_t c = run->closed.at[i];
        run->entry[i].contact = c;
        aoi_body_engage(run, run->system->contact[c].body[0], AOI_UNDER_FORCE);
        aoi_body_engage(run, run->system->contact[c].body[1], AOI_UNDER_FORCE);
    }
    run->closed_count = run->entry_count = run->closed.count;
    const size_t count = run->engaged.count; /* only the bodies of closed contacts: bring_along adds others */
    for (size_t i = 0; i < count; i++) {
        if (run->body[run->engaged.at[i]].engaged == AOI_UNDER_FORCE) {
            bring_along(run, run->engaged.at[i]);
        }
    }
}
