/* Motion of a mode under a polynomial force: a polynomial particular solution and a free oscillation about it. The
 * energy dissipated by damping and the work of a rising load are integrals over this motion, exact for any number
 * of periods. */
#include "motion/oscillator.h"
#include "motion/path.h"
#include "motion/polynomial.h"
#include "motion/radau.h"
#include "motion/nodes.h"
#include "law/law.h"

#include <math.h>
#include <string.h>

void aoi_path_follow(double omega, double decay, double h, const double *f, double *x, double *v)
{
    /* sums of the coefficients above k, of even and of odd degree */
    double above[2] = {0.0, 0.0}, slope_above[2] = {0.0, 0.0};
    for (size_t k = AOI_NODES; k-- > 0;) {
        const double weight = 2.0 * (2.0 * (double)k + 1.0);
        const double bend = weight * slope_above[(k + 1) % 2] / h;
        v[k] = weight * above[(k + 1) % 2] / h;
        x[k] = (f[k] - 2.0 * decay * v[k] - bend) / (omega * omega);
        above[k % 2] += x[k];
        slope_above[k % 2] += v[k];
    }
}

/* Finds the Legendre coefficients of the v that solves v' + 2 decay v = f, for a force f that is linear in time. */
static void follow_free(double decay, double h, const double *f, double *v)
{
    memset(v, 0, AOI_NODES * sizeof *v);
    v[1] = f[1] / (2.0 * decay);
    v[0] = (f[0] - 2.0 * v[1] / h) / (2.0 * decay);
}

/* Value of decay times time above which v decays so fast that v^2 is not close to a polynomial. */
static const double STRONG = 0.1;

/* Finds the velocity of the polynomial solution at the nodes of the part, and the state x, v at the start of the
 * oscillation about that solution. Returns 0 if no polynomial solution is used. */
static int along(const aoi_path *path, double *velocity, double *x, double *v)
{
    double place[AOI_NODES], rate[AOI_NODES];
    *x = path->x;
    *v = path->v;
    /* under a force linear in time no digits are lost, whatever the damping */
    const double decay = path->straight ? 0.0 : path->decay;
    if (aoi_path_rings(path->omega, decay, path->h)) {
        aoi_path_follow(path->omega, path->decay, path->h, path->force, place, rate);
        *x -= aoi_legendre_at_start(place);
    } else if (path->omega == 0.0 && path->straight && 2.0 * path->decay * path->h > AOI_PATH_FAST) {
        follow_free(path->decay, path->h, path->force, rate);
    } else {
        return 0; /* the mode is too slow to be split, or overdamped */
    }
    *v -= aoi_legendre_at_start(rate);
    aoi_legendre_at_nodes(rate, 0.0, path->place, velocity);
    return 1;
}

/* Finds displacement and velocity at a position in the part of the path up to path->place; share: 0 to 1. */
static void state_at(const aoi_path *path, double share, double *x, double *v)
{
    double values[AOI_NODES], legendre[AOI_NODES], impulse[AOI_NODES], rate[AOI_NODES];
    const double part = path->place * share, time = part * path->h;
    const double pull = path->omega * path->omega * path->x;
    aoi_motion motion;
    /* the force at the nodes of the interval from the path's start to the position */
    aoi_legendre_at_nodes(path->force, 0.0, part, values);
    aoi_nodes_to_legendre(values, legendre);
    aoi_oscillator_motion(path->omega, path->decay, time, &motion);
    aoi_oscillator_integrals(path->omega, path->decay, time, AOI_NODES, impulse, rate);
    *x = path->x + path->v * motion.impulse - pull * motion.step;
    *v = path->v * motion.rate - pull * motion.impulse;
    for (size_t k = 0; k < AOI_NODES; k++) {
        const double of = time * legendre[k];
        *x += of * impulse[k];
        *v += of * rate[k];
    }
}

/* Finds the integrals by quadrature. If damping is strong, the integral of v^2 follows from the mode's energy
 * balance instead: the force does little work on motion that decays at once. The energy dissipated is 2 decay
 * times the integral, and its error is the rounding error of the mode's energy. */
static void by_quadrature(const aoi_path *path, double *squared, double *moment)
{
    const double time = path->place * path->h;
    double x = path->x, v = path->v, work = 0.0, slope;
    *squared = *moment = 0.0;
    for (size_t i = 0; i < AOI_NODES; i++) { /* the last node is the end of the part */
        const double weight = aoi_radau_to_legendre[0][i] * time;
        state_at(path, aoi_radau_node[i], &x, &v);
        *squared += weight * v * v;
        *moment += weight * time * aoi_radau_node[i] * v;
        work += weight * v *
                aoi_legendre_evaluate(AOI_NODES, path->force, path->place * aoi_radau_node[i], &slope);
    }
    if (path->decay * time > STRONG) {
        const double before = path->v * path->v + path->omega * path->omega * path->x * path->x;
        const double kept = v * v + path->omega * path->omega * x * x - before;
        *squared = (work - 0.5 * kept) / (2.0 * path->decay);
    }
}

/* Adds to both integrals the contributions of the oscillation that starts from x, v: terms with its velocity
 * alone, and products of its velocity with that of the polynomial solution. */
static void add_oscillation(const aoi_path *path, const double *velocity, double x, double v,
                            double *squared, double *moment)
{
    const double time = path->place * path->h, pull = path->omega * path->omega * x;
    double impulse[AOI_NODES], rate[AOI_NODES], sign = 1.0;
    aoi_motion motion;
    aoi_oscillator_motion(path->omega, path->decay, time, &motion);
    aoi_oscillator_integrals(path->omega, path->decay, time, AOI_NODES, impulse, rate);
    /* the sign alternates since the integrals run back from the end */
    for (size_t k = 0; k < AOI_NODES; k++, sign = -sign) {
        const double of = sign * time * (v * rate[k] - pull * impulse[k]);
        *squared += 2.0 * of * aoi_nodes_dot(aoi_radau_to_legendre[k], velocity);
        *moment += k < 2 ? 0.5 * time * of : 0.0; /* t = time (P_0 + P_1) / 2 */
    }
    if (path->decay > 0.0) {
        const double later = v * motion.rate - pull * motion.impulse;
        const double apart = path->omega * (x + v * motion.impulse - pull * motion.step);
        const double lost = v * v - later * later + pull * x - apart * apart;
        *squared += 0.25 * lost / path->decay;
    }
}

void aoi_path_integrals(const aoi_path *path, double *squared, double *moment)
{
    const double time = path->place * path->h;
    double velocity[AOI_NODES], x, v;
    if (!along(path, velocity, &x, &v)) {
        by_quadrature(path, squared, moment);
        return;
    }
    *squared = *moment = 0.0;
    for (size_t i = 0; i < AOI_NODES; i++) {
        const double weight = aoi_radau_to_legendre[0][i] * time;
        *squared += weight * velocity[i] * velocity[i];
        *moment += weight * time * aoi_radau_node[i] * velocity[i];
    }
    add_oscillation(path, velocity, x, v, squared, moment);
}
