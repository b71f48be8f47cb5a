/* Motion of a mode over a time, under a force that is a polynomial in time. */
#ifndef AOI_PATH_H
#define AOI_PATH_H

#include "aoimpact.h"

/* Phase advance of a mode in a step, rad, above which its motion is split into a polynomial particular solution
 * and a free oscillation. The motion of a slower mode is a polynomial of the degree used in a step, within 1e-9 of
 * the mode's response to the force. Overdamped modes do not oscillate and are resolved by the nodes. */
#define AOI_PATH_FAST 1.5
static inline int aoi_path_rings(double omega, double decay, double h)
{
    return omega * h > AOI_PATH_FAST && decay <= omega;
}

/* Finds the polynomial x that solves x'' + 2 decay x' + omega^2 x = f over a time h, omega > 0, and its rate v. f,
 * x, v: AOI_NODES Legendre coefficients. For decay > omega digits are lost unless f is linear in time. */
void aoi_path_follow(double omega, double decay, double h, const double *f, double *x, double *v);

/* Motion of a mode from the state x, v over a time h. force: AOI_NODES Legendre coefficients; straight: 1 if the
 * force is linear in time; place: share of h that the integrals cover (0 .. 1). */
typedef struct aoi_path {
    double omega, decay, h, x, v, place;
    const double *force;
    int straight;
} aoi_path;

/* Finds the integrals over time of v^2 (squared) and of t v (moment), over the part of the path up to `place`. */
void aoi_path_integrals(const aoi_path *path, double *squared, double *moment);

#endif
