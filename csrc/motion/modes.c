/* A linear body in its natural modes, under loads that are linear between given times. */
#include "motion/modes.h"
#include "motion/lanes.h"
#include "motion/oscillator.h"
#include "linear/vector.h"
#include "model/load.h"

#include <math.h>
#include <string.h>

static void load_of(const aoi_load_span *at, size_t port, double *force, double *slope)
{
    *slope = (at->next[port] - at->here[port]) / at->length;
    *force = at->here[port] + *slope * at->into;
}

void aoi_modes_load(const aoi_modes *body, size_t port, double time, double *force, double *slope)
{
    *force = *slope = 0.0;
    if (body->load.count > 0) {
        const aoi_load_span at = aoi_load_at(&body->load, body->ports, time);
        load_of(&at, port, force, slope);
    }
}

static void drive_of(const aoi_modes *body, const aoi_load_span *at, size_t j, double *load, double *slope)
{
    *load = body->gravity ? body->gravity[j] : 0.0;
    *slope = 0.0;
    for (size_t p = 0; at && p < body->ports; p++) {
        double force, rise;
        load_of(at, p, &force, &rise);
        *load += body->push[p * body->n + j] * force;
        *slope += body->push[p * body->n + j] * rise;
    }
}

void aoi_modes_drive(const aoi_modes *body, size_t j, double time, double *load, double *slope)
{
    if (body->load.count > 0) {
        const aoi_load_span at = aoi_load_at(&body->load, body->ports, time);
        drive_of(body, &at, j, load, slope);
    } else {
        drive_of(body, NULL, j, load, slope);
    }
}

static void move(const aoi_modes *body, const aoi_load_span *at, size_t first, const aoi_motions *by,
                 double *x, double *v)
{
    const size_t count = aoi_lanes_count(body, first);
    double omega[AOI_LANES], x0[AOI_LANES], v0[AOI_LANES], load[AOI_LANES] = {0.0};
    double slope[AOI_LANES] = {0.0};
    aoi_lanes_take(body->omega + first, count, omega);
    aoi_lanes_take(x + first, count, x0);
    aoi_lanes_take(v + first, count, v0);
    for (size_t i = 0; (at || body->gravity) && i < count; i++) {
        drive_of(body, at, first + i, &load[i], &slope[i]);
    }
    for (size_t i = 0; i < AOI_LANES; i++) {
        const double pull = load[i] - omega[i] * omega[i] * x0[i], speed = v0[i];
        x0[i] += speed * by->impulse[i] + pull * by->step[i];
        v0[i] = speed * by->rate[i] + pull * by->impulse[i];
    }
    for (size_t i = 0; at && i < count; i++) {
        x0[i] += slope[i] * by->ramp[i];
        v0[i] += slope[i] * by->step[i];
    }
    aoi_lanes_put(x0, count, x + first);
    aoi_lanes_put(v0, count, v + first);
}

void aoi_modes_move(const aoi_modes *body, size_t first, double from, const aoi_motions *by, double *x,
                    double *v)
{
    if (body->load.count > 0) {
        const aoi_load_span at = aoi_load_at(&body->load, body->ports, from);
        move(body, &at, first, by, x, v);
    } else {
        move(body, NULL, first, by, x, v);
    }
}

/* Advances x, v over a time in which no load bends. */
static void advance_straight(const aoi_modes *body, double from, double time, double *x, double *v)
{
    for (size_t first = 0; first < body->n; first += AOI_LANES) {
        aoi_motions motions;
        aoi_lanes_of(body, first, time, &motions, NULL);
        aoi_modes_move(body, first, from, &motions, x, v);
    }
}

void aoi_modes_advance(const aoi_modes *body, double from, double to, double *x, double *v)
{
    while (from < to) {
        const double bend = aoi_modes_next_bend(body, from), next = bend < to ? bend : to;
        advance_straight(body, from, next - from, x, v);
        from = next;
    }
}

void aoi_modes_port(const aoi_modes *body, size_t port, const double *x, const double *v,
                    double *displacement, double *velocity)
{
    const double *shape = body->shape + port * body->n;
    *displacement = aoi_vector_dot(body->n, shape, x);
    *velocity = aoi_vector_dot(body->n, shape, v);
}

/* Computes the result of aoi_lanes_of, for damped modes or modes under a load. */
static void one_by_one(const aoi_modes *body, size_t first, double time, aoi_motions *motions,
                       aoi_integrals *integrals)
{
    /* lanes without a mode have zero weight, but must be finite */
    memset(motions, 0, sizeof *motions);
    if (integrals) {
        memset(integrals, 0, sizeof *integrals);
    }
    for (size_t i = 0; i < aoi_lanes_count(body, first); i++) {
        const double omega = body->omega[first + i], decay = body->decay ? body->decay[first + i] : 0.0;
        double impulse[AOI_NODES], rate[AOI_NODES];
        aoi_motion motion;
        aoi_oscillator_motion(omega, decay, time, &motion);
        motions->impulse[i] = motion.impulse;
        motions->rate[i] = motion.rate;
        motions->step[i] = motion.step;
        motions->ramp[i] = motion.ramp;
        if (integrals) {
            aoi_oscillator_integrals(omega, decay, time, AOI_NODES, impulse, rate);
            for (size_t l = 0; l < AOI_NODES; l++) {
                integrals->impulse[l][i] = impulse[l];
                integrals->rate[l][i] = rate[l];
            }
        }
    }
}

void aoi_lanes_of(const aoi_modes *body, size_t first, double time, aoi_motions *motions,
                  aoi_integrals *integrals)
{
    if (body->decay || body->load.count > 0) {
        one_by_one(body, first, time, motions, integrals);
        return;
    }
    double omega[AOI_LANES];
    aoi_turn turn;
    aoi_lanes_take(body->omega + first, aoi_lanes_count(body, first), omega);
    aoi_turn_make(omega, time, &turn);
    aoi_turn_motions(&turn, motions);
    if (integrals) {
        aoi_turn_integrals(&turn, integrals);
    }
}
