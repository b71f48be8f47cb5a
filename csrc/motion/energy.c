/* Energies of a body in modes, and the work of loads and damping on it. */
#include "motion/energy.h"
#include "motion/modes.h"
#include "motion/path.h"
#include "motion/polynomial.h"
#include "motion/radau.h"
#include "motion/nodes.h"
#include "linear/vector.h"
#include "law/law.h"
#include "model/modes.h"

#include <math.h>
#include <string.h>

void aoi_modes_energy(const aoi_modes *body, const double *x, const double *v, const double *force,
                      double *kinetic, double *elastic)
{
    *kinetic = 0.5 * aoi_vector_squares(body->n, body->inertia, NULL, v);
    *elastic = 0.5 * aoi_vector_squares(body->n, body->inertia, body->omega, x);
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

static double gravity_work(const aoi_modes *body, const double *x0, const double *x1)
{
    double work = 0.0;
    for (size_t j = 0; body->gravity && j < body->n; j++) {
        work += aoi_modes_inertia(body, j) * body->gravity[j] * (x1[j] - x0[j]);
    }
    return work;
}

/* Returns the work of constant loads, J: the sum over the ports of the load at a time, times the displacement of
 * the port due to the modes' coordinates x. */
static double loaded(const aoi_modes *body, double time, const double *x)
{
    double work = 0.0;
    for (size_t p = 0; body->load.count > 0 && p < body->ports; p++) {
        double force, slope;
        aoi_modes_load(body, p, time, &force, &slope);
        work += force * aoi_vector_dot(body->n, body->shape + p * body->n, x);
    }
    return work;
}

static int loads_rise(const aoi_modes *body, double time)
{
    for (size_t p = 0; body->load.count > 0 && p < body->ports; p++) {
        double force, slope;
        aoi_modes_load(body, p, time, &force, &slope);
        if (slope != 0.0) {
            return 1;
        }
    }
    return 0;
}

/* Returns the energy that loads f store in the residual compliance R over a time in which no load bends, J: the
 * integral of f^T R f'. */
static double residual_work(const aoi_modes *body, double from, double to)
{
    const double length = to - from;
    double work = 0.0;
    for (size_t k = 0; body->residual && body->load.count > 0 && k < body->ports * body->ports; k++) {
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
    for (size_t k = 0; body->residual && body->load.count > 0 && k < body->ports * body->ports; k++) {
        double load, other, rise;
        aoi_modes_load(body, k / body->ports, time, &load, &rise);
        aoi_modes_load(body, k % body->ports, time, &other, &rise);
        work += load * body->residual[k] * (force[k % body->ports] - other);
    }
    return work;
}

/* ---------------------------------------------------------------------------------- in free motion */

/* Returns the slope in time of the loads' force on mode j: the sum over the ports of load slope times shape. */
static double rise_on(const aoi_modes *body, size_t j, double time)
{
    double sum = 0.0;
    for (size_t p = 0; body->load.count > 0 && p < body->ports; p++) {
        double load, slope;
        aoi_modes_load(body, p, time, &load, &slope);
        sum += slope * body->shape[p * body->n + j];
    }
    return sum;
}

/* Returns the motion of a mode under gravity and loads that are linear in time. force: set to the Legendre
 * coefficients of the acceleration due to both. */
static aoi_path path_of(const aoi_modes *body, size_t j, double from, double length, double x, double v,
                        double *force)
{
    double load, slope;
    aoi_modes_drive(body, j, from, &load, &slope);
    memset(force, 0, AOI_NODES * sizeof *force);
    force[1] = 0.5 * slope * length;
    force[0] = load + force[1];
    return (aoi_path){body->omega[j], body->decay ? body->decay[j] : 0.0, length, x, v, 1.0, force, 1};
}

/* Returns the work of the loads on the modes over a time in which no load bends, J; advances x, v to the end of
 * that time. */
static double rising_work(const aoi_modes *body, double from, double to, double *x, double *v)
{
    double work = 0.0;
    for (size_t j = 0; j < body->n; j++) {
        const double rise = rise_on(body, j, from);
        double force[AOI_NODES], squared, moment;
        if (rise != 0.0) {
            const aoi_path path = path_of(body, j, from, to - from, x[j], v[j], force);
            aoi_path_integrals(&path, &squared, &moment);
            work += rise * moment;
        }
    }
    work -= loaded(body, from, x);
    aoi_modes_advance(body, from, to, x, v);
    return work + loaded(body, from, x);
}

/* Returns the work of the loads on the modes over any time, J: the sum of rising_work from bend to bend. */
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

void aoi_modes_free_work(const aoi_modes *body, double from, double to, const double *x0,
                           const double *v0, const double *x1, const double *v1, double *scratch,
                           double *work, double *dissipated)
{
    const int changing = loads_rise(body, from) || aoi_modes_next_bend(body, from) < to;
    const double gained = changing || body->decay ? energy_of(body, x1, v1) - energy_of(body, x0, v0) : 0.0;
    if (!changing) {
        *work = gravity_work(body, x0, x1) + loaded(body, from, x1) - loaded(body, from, x0);
    } else if (!body->decay) {
        *work = gained; /* without damping, the work equals the energy gained              */
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

/* Integrals over a part of a step, J. lost: energy dissipated by damping; rising: work of the change of the loads
 * since the start of the step. */
typedef struct step_integrals {
    double lost, rising;
} step_integrals;

/* Adds the contribution of mode j to the integrals. */
static void add_mode(const aoi_modes *body, size_t j, double from, double h, double place,
                     const double *force, double x, double v, step_integrals *sum)
{
    const double rise = rise_on(body, j, from), decay = body->decay ? body->decay[j] : 0.0;
    double push[AOI_NODES] = {0.0}, pushed[AOI_NODES], whole[AOI_NODES], squared, moment;
    if (rise == 0.0 && decay == 0.0) {
        return;
    }
    aoi_path path = path_of(body, j, from, h, x, v, whole);
    path.place = place;
    path.straight = 0;
    for (size_t p = 0; p < body->ports; p++) {
        aoi_nodes_add(body->push[p * body->n + j], force + p * AOI_NODES, push);
    }
    aoi_nodes_to_legendre(push, pushed);
    aoi_nodes_add(1.0, pushed, whole);
    aoi_path_integrals(&path, &squared, &moment);
    sum->lost += 2.0 * decay * aoi_modes_inertia(body, j) * squared;
    sum->rising += rise * moment;
}

/* Returns the integral over time of the slopes of the loads times the deflection of the residual compliance under
 * the contact forces, J. */
static double bent_by(const aoi_modes *body, double from, double h, double place, const double *force)
{
    double sum = 0.0;
    for (size_t k = 0; body->residual && body->load.count > 0 && k < body->ports * body->ports; k++) {
        const double *by = force + k % body->ports * AOI_NODES;
        double load, slope, part[AOI_NODES];
        aoi_modes_load(body, k / body->ports, from, &load, &slope);
        aoi_nodes_on_part(by, place, part);
        sum += place * h * slope * body->residual[k] * aoi_nodes_dot(aoi_radau_to_legendre[0], part);
    }
    return sum;
}

void aoi_modes_step_work(const aoi_modes *body, double from, double h, double place,
                         const double *force, const double *x0, const double *v0, const double *x1,
                         double *work, double *dissipated)
{
    step_integrals sum = {0.0, 0.0};
    for (size_t j = 0; j < body->n && (body->decay || loads_rise(body, from)); j++) {
        add_mode(body, j, from, h, place, force, x0[j], v0[j], &sum);
    }
    *work = gravity_work(body, x0, x1) + loaded(body, from, x1) - loaded(body, from, x0) + sum.rising +
            residual_work(body, from, from + place * h) - bent_by(body, from, h, place, force);
    *dissipated = sum.lost;
}
