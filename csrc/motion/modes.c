/* A linear body in its natural modes, under loads that run straight between given times. */
#include "motion/modes.h"
#include "motion/oscillator.h"
#include "linear/vector.h"
#include "model/load.h"

#include <math.h>

double aoi_modes_next_bend(const aoi_modes *body, double time)
{
    return aoi_load_next_bend(&body->load, time);
}

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

/* Over a time in which no load bends. */
static void advance_straight(const aoi_modes *body, double from, double time, double *x, double *v)
{
    aoi_load_span at = {NULL, NULL, 0.0, 1.0};
    if (body->load.count > 0) {
        at = aoi_load_at(&body->load, body->ports, from);
    }
    for (size_t j = 0; j < body->n; j++) {
        const double omega = body->omega[j];
        double load, slope;
        aoi_motion motion;
        aoi_oscillator_motion(omega, body->decay ? body->decay[j] : 0.0, time, &motion);
        drive_of(body, body->load.count > 0 ? &at : NULL, j, &load, &slope);
        load -= omega * omega * x[j];
        const double v0 = v[j];
        x[j] += v0 * motion.impulse + load * motion.step + slope * motion.ramp;
        v[j] = v0 * motion.rate + load * motion.impulse + slope * motion.step;
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
