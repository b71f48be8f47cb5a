/* Open contacts of bodies under force, and whether they touch within a step. The displacement due to contact
 * forces is split into a polynomial and free oscillations. The search for a touch in free.c, which misses none,
 * then covers all of the motion. */
#include "adaptive/run.h"
#include "adaptive/step.h"
#include "law/law.h"
#include "motion/free.h"
#include "motion/path.h"
#include "motion/radau.h"
#include "motion/response.h"
#include "motion/nodes.h"
#include "collocation/collocation.h"

#include <math.h>

/* Factor on the length of the next trial if the search for a touch took more than AOI_LOOKS_IN_STEP evaluations.
 * Measured: from 0.2 to 0.8 one of 267 runs changes, its error and work do not. */
static const double SHORTER = 0.5;

/* Moves the free oscillations that the contact forces excite in fast modes out of a port's displacement, given at
 * the start and the nodes, into the modes' free motion x, v. */
static void split_off(const aoi_adaptive *run, size_t b, size_t port, double sign, double h, double *x,
                      double *v, double *values)
{
    const aoi_modes *body = &run->system->body[b];
    const aoi_response *response = &run->response[b];
    for (size_t j = body->n; j-- > 0 && body->omega[j] * h > AOI_PATH_FAST;) {
        const double share = sign * body->shape[port * body->n + j];
        const double squared = body->omega[j] * body->omega[j];
        const double decay = body->decay ? body->decay[j] : 0.0;
        const size_t at = j * AOI_NODES;
        double here, rate;
        if (share == 0.0 || !aoi_path_rings(body->omega[j], decay, h) ||
            !aoi_step_path(run, b, j, h, 0, &here, &rate)) {
            continue;
        }
        x[j] -= here;
        v[j] -= rate;
        values[0] += share * here;
        for (size_t i = 0; i < AOI_NODES; i++) {
            values[i + 1] += share * (here * (1.0 - squared * response->step[at + i]) +
                                      rate * response->impulse[at + i]);
        }
    }
}

/* Adds the displacement of a port under the contact forces of the step, at the nodes, to an indentation. */
static void add_forced(const aoi_adaptive *run, size_t b, size_t port, double sign, double *indentation)
{
    const aoi_modes *body = &run->system->body[b];
    const aoi_response *response = &run->response[b];
    if (run->crowded) {
        const double *moved = aoi_crowd_motion(run->system, run->closed_count, run->collocation);
        for (size_t j = 0; j < body->n; j++) {
            aoi_nodes_add(-sign * body->shape[port * body->n + j], moved + (run->system->first[b] + j) * AOI_NODES,
                          indentation);
        }
    }
    for (size_t k = 0; !run->crowded && k < response->columns.count; k++) {
        const size_t by = response->columns.port ? response->columns.port[k] : k;
        const double *force = run->port_force + (run->system->first_port[b] + by) * AOI_NODES;
        double displacement[AOI_NODES];
        aoi_nodes_multiply(response->influence + aoi_response_at(response, port, by), force, displacement);
        aoi_nodes_add(sign, displacement, indentation);
        if (body->residual) {
            aoi_nodes_add(sign * body->residual[port * body->ports + by], force, indentation);
        }
    }
    for (size_t by = 0; run->crowded && body->residual && by < body->ports; by++) {
        const double *force = run->port_force + (run->system->first_port[b] + by) * AOI_NODES;
        aoi_nodes_add(sign * body->residual[port * body->ports + by], force, indentation);
    }
}

/* Sets `pair` to copies of both bodies' states, with a polynomial fitted over the step to the indentation due to
 * contact forces. forced: memory for the polynomial. */
static void take_pair(aoi_adaptive *run, size_t c, double h, aoi_free_pair *pair, aoi_forced *forced)
{
    const aoi_contact *of = &run->system->contact[c];
    double values[AOI_NODES + 1] = {-aoi_contact_bent(run, c, 0)};
    double *copy = run->free_state[0];
    aoi_pair_now(run, c, pair);
    for (int side = 0; side < 2; side++) {
        const size_t b = of->body[side], n = run->system->body[b].n;
        const double sign = side == 0 ? 1.0 : -1.0;
        aoi_body_copy(run, b, copy);
        pair->x[side] = copy;
        pair->v[side] = copy + n;
        copy += 2 * n;
        if (run->body[b].engaged == AOI_UNDER_FORCE) {
            add_forced(run, b, of->port[side], sign, values + 1);
            split_off(run, b, of->port[side], sign, h, pair->x[side], pair->v[side], values);
        }
    }
    aoi_forced_fit(pair->time, h, values, forced);
    pair->forced = forced;
}

/* An open contact touches only when its indentation exceeds the tolerance. */
void aoi_step_open_events(aoi_adaptive *run, aoi_contact_step *entry, aoi_attempt *attempt)
{
    aoi_adaptive_contact *contact = &run->contact[entry->contact];
    const double tolerance = aoi_touch_tolerance(run, entry), now = aoi_run_now(run);
    const double rest = aoi_law_rest(aoi_step_law(run, entry), contact->memory);
    const double slack = fmax(0.5 * tolerance, contact->flight.slack);
    double start[2], then[2];
    int touches;
    aoi_free_pair pair;
    aoi_forced forced;
    take_pair(run, entry->contact, attempt->h, &pair, &forced);
    pair.gap += rest + slack;
    aoi_free_pair_motion(&pair, 1, start);
    const size_t most = 1 + AOI_LOOKS_IN_STEP / (pair.body[0]->n + pair.body[1]->n);
    if (aoi_free_pair_next_touch(&pair, now + attempt->h, most, &touches) != AOI_OK) {
        attempt->growth = fmin(attempt->growth, SHORTER);
        return;
    }
    if (!touches) {
        return;
    }
    const double after = pair.time - now, left = attempt->h - after;
    /* Bodies side by side touch at the start, whichever sign rounding gives their rate; otherwise their touch
     * would be found only when they overlap by the tolerance. */
    if (aoi_is_at_start(run, after, attempt->h) ||
        (start[1] * attempt->h >= -tolerance && start[0] + slack >= -2.0 * tolerance &&
         !aoi_contact_has_residual(run, entry->contact))) {
        attempt->closed = 1;
        contact->event = AOI_EVENT_TOUCH;
        aoi_contact_close(run, entry->contact);
        return;
    }
    aoi_free_pair_motion(&pair, 1, then);
    aoi_step_note_event(then[1] * left <= tolerance ? 1.0 : after / attempt->h, AOI_EVENT_TOUCH, contact,
                        attempt);
}
