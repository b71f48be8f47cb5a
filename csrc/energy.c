/* Where a body's energy is, and what loads and damping have done to it. */
#include "radau.h"

#include <math.h>

void aoi_modes_energy(const aoi_modes *body, const double *x, const double *v, const double *force,
                      double *kinetic, double *elastic)
{
    *kinetic = *elastic = 0.0;
    for (size_t j = 0; j < body->n; j++) {
        const double omega_x = body->omega[j] * x[j];
        *kinetic += 0.5 * body->inertia[j] * v[j] * v[j];
        *elastic += 0.5 * body->inertia[j] * omega_x * omega_x;
    }
    for (size_t k = 0; force && body->residual && k < body->ports * body->ports; k++) {
        *elastic +=
            0.5 * force[k / body->ports] * body->residual[k] * force[k % body->ports];
    }
}

static double energy_of(const aoi_modes *body, const double *x, const double *v)
{
    double kinetic, elastic;
    aoi_modes_energy(body, x, v, NULL, &kinetic, &elastic);
    return kinetic + elastic;
}

enum { MOST_PANELS = 4096 };

static double gravity_work(const aoi_modes *body, const double *x0, const double *x1)
{
    double work = 0.0;
    for (size_t j = 0; body->gravity && j < body->n; j++) {
        work += body->inertia[j] * body->gravity[j] * (x1[j] - x0[j]);
    }
    return work;
}

/* Work on the modes of loads that have the values of one time: force times displacement. */
static double steady_work(const aoi_modes *body, double time, const double *x0, const double *x1)
{
    double work = 0.0;
    for (size_t p = 0; body->load_count > 0 && p < body->ports; p++) {
        const double *shape = body->shape + p * body->n;
        double force, slope;
        aoi_modes_load(body, p, time, &force, &slope);
        work += force * (aoi_vector_dot(body->n, shape, x1) - aoi_vector_dot(body->n, shape, x0));
    }
    return work;
}

static int loads_rise(const aoi_modes *body, double time)
{
    for (size_t p = 0; body->load_count > 0 && p < body->ports; p++) {
        double force, slope;
        aoi_modes_load(body, p, time, &force, &slope);
        if (slope != 0.0) {
            return 1;
        }
    }
    return 0;
}

/* f^T R f' of loads that do not bend meanwhile: what they store in the residual compliance. */
static double residual_work(const aoi_modes *body, double from, double to)
{
    const double length = to - from;
    double work = 0.0;
    for (size_t k = 0; body->residual && body->load_count > 0 && k < body->ports * body->ports; k++) {
        double force, rise, other, other_rise;
        aoi_modes_load(body, k / body->ports, from, &force, &rise);
        aoi_modes_load(body, k % body->ports, from, &other, &other_rise);
        work += body->residual[k] * other_rise * (force * length + 0.5 * rise * length * length);
    }
    return work;
}

double aoi_modes_bent_work(const aoi_modes *body, double time, const double *force)
{
    double work = 0.0;
    for (size_t k = 0; body->residual && body->load_count > 0 && k < body->ports * body->ports; k++) {
        double load, other, rise;
        aoi_modes_load(body, k / body->ports, time, &load, &rise);
        aoi_modes_load(body, k % body->ports, time, &other, &rise);
        work += load * body->residual[k] * (force[k % body->ports] - other);
    }
    return work;
}

double aoi_system_snap(const aoi_system *system, size_t joint, double force)
{
    return 0.5 * aoi_system_residual(system, joint) * force * force;
}

/* ---------------------------------------------------------------------------------- in flight */

/* Work on the modes of rising loads over a stretch in which they do not bend: quadrature over its
 * oscillations. x, v are taken to its end. */
static double rising_work(const aoi_modes *body, double from, double to, double *x, double *v)
{
    const double turns = body->omega[body->n - 1] * (to - from) / 4.0;
    const size_t panels = 1 + (size_t)fmin(turns, MOST_PANELS);
    const double length = (to - from) / (double)panels;
    double work = 0.0;
    for (size_t panel = 0; panel < panels; panel++) {
        double place = 0.0;
        const double start = from + (double)panel * length;
        for (size_t i = 0; i < AOI_STAGES; i++) {
            const double here = start + length * place, next = start + length * aoi_radau_node[i];
            aoi_modes_fly(body, here, next, x, v);
            place = aoi_radau_node[i];
            for (size_t p = 0; p < body->ports; p++) {
                double displacement, velocity, load, slope;
                aoi_modes_port(body, p, x, v, &displacement, &velocity);
                aoi_modes_load(body, p, from, &load, &slope);
                work += aoi_radau_to_legendre[0][i] * length * velocity *
                        (load + slope * (next - from));
            }
        }
    }
    return work;
}

/* The same from bend to bend. */
static double changing_work(const aoi_modes *body, double from, double to, const double *x0,
                            const double *v0, double *scratch)
{
    double work = 0.0;
    for (size_t j = 0; j < body->n; j++) {
        scratch[j] = x0[j];
        scratch[body->n + j] = v0[j];
    }
    for (double at = from; at < to;) {
        const double next = fmin(to, aoi_modes_next_bend(body, at));
        work += rising_work(body, at, next, scratch, scratch + body->n);
        at = next;
    }
    return work;
}

void aoi_modes_flight_work(const aoi_modes *body, double from, double to, const double *x0,
                           const double *v0, const double *x1, const double *v1, double *scratch,
                           double *work, double *dissipated)
{
    const double gained = energy_of(body, x1, v1) - energy_of(body, x0, v0);
    const int changing = loads_rise(body, from) || aoi_modes_next_bend(body, from) < to;
    if (!changing) {
        *work = gravity_work(body, x0, x1) + steady_work(body, from, x0, x1);
    } else if (!body->decay) {
        *work = gained; /* nothing else can be where it comes from */
    } else {
        *work = gravity_work(body, x0, x1) + changing_work(body, from, to, x0, v0, scratch);
    }
    *dissipated = body->decay ? *work - gained : 0.0;
    for (double at = from; body->residual && at < to;) {
        const double next = fmin(to, aoi_modes_next_bend(body, at));
        *work += residual_work(body, at, next);
        at = next;
    }
}

/* -------------------------------------------------------------------------- in a step of contact */

/* Integrals over a part of a step: of contact force times velocity, of what rising loads add to those at
 * the start times velocity, and of f_load'^T R f_contact. */
typedef struct step_integrals {
    double by_contact, rising, bent;
} step_integrals;

/* Adds port p's share at one place, x, v being there. */
static void add_port(const aoi_modes *body, size_t p, double from, double h, double place, double weight,
                     const double *force, const double *x, const double *v, step_integrals *sum)
{
    double legendre[AOI_STAGES], ignored, displacement, velocity, load, slope;
    for (size_t k = 0; k < AOI_STAGES; k++) {
        legendre[k] =
            aoi_vector_dot(AOI_STAGES, aoi_radau_to_legendre[k], force + p * AOI_STAGES);
    }
    const double pressed = aoi_legendre_evaluate(AOI_STAGES, legendre, place, &ignored);
    aoi_modes_port(body, p, x, v, &displacement, &velocity);
    aoi_modes_load(body, p, from, &load, &slope);
    sum->by_contact += weight * velocity * pressed;
    sum->rising += weight * velocity * slope * place * h;
    for (size_t q = 0; body->residual && q < body->ports; q++) {
        aoi_modes_load(body, q, from, &load, &slope);
        sum->bent += weight * slope * body->residual[q * body->ports + p] * pressed;
    }
}

static step_integrals integrate(const aoi_modes *body, double from, double h, double place,
                                const double *force, const double *x0, const double *v0,
                                double *scratch)
{
    step_integrals sum = {0.0, 0.0, 0.0};
    double *x = scratch, *v = scratch + body->n;
    for (size_t i = 0; i < AOI_STAGES; i++) {
        const double part = place * aoi_radau_node[i];
        for (size_t j = 0; j < body->n; j++) {
            x[j] = x0[j];
            v[j] = v0[j];
        }
        aoi_modes_fly(body, from, from + part * h, x, v);
        aoi_response_push(body, h, force, part, x, v);
        for (size_t p = 0; p < body->ports; p++) {
            add_port(body, p, from, h, part, aoi_radau_to_legendre[0][i] * place * h, force, x, v, &sum);
        }
    }
    return sum;
}

void aoi_modes_step_work(const aoi_modes *body, double from, double h, double place,
                         const double *force, const double *x0, const double *v0, const double *x1,
                         const double *v1, double *scratch, double *work, double *dissipated)
{
    step_integrals sum = {0.0, 0.0, 0.0};
    if (body->decay || loads_rise(body, from)) {
        sum = integrate(body, from, h, place, force, x0, v0, scratch);
    }
    *work = gravity_work(body, x0, x1) + steady_work(body, from, x0, x1) + sum.rising;
    *dissipated = body->decay ? *work + sum.by_contact -
                                    (energy_of(body, x1, v1) - energy_of(body, x0, v0))
                              : 0.0;
    *work += residual_work(body, from, from + place * h) - sum.bent;
}
