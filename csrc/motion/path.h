/* How a mode moves over a time under a force that is a polynomial in it (path.c). */
#ifndef AOI_PATH_H
#define AOI_PATH_H

#include "aoimpact.h"

/* The motion of a mode that turns by more than this (rad) in a step is a polynomial particular solution plus a free
 * oscillation; that of a slower one is a polynomial of the degree of a step's to 1e-9 of what its force does. Overdamped
 * modes do not oscillate and are resolved by the nodes. */
#define AOI_PATH_FAST 1.5
static inline int aoi_path_rings(double omega, double decay, double h)
{
    return omega * h > AOI_PATH_FAST && decay <= omega;
}

/* The polynomial that solves x'' + 2 decay x' + omega^2 x = f over a time h, omega > 0, and its rate v. f, x, v: AOI_NODES
 * Legendre coefficients. Under strong damping (decay > omega) digits are lost unless f runs straight. */
void aoi_path_follow(double omega, double decay, double h, const double *f, double *x, double *v);

/* A mode from x, v on under a force f as above, which may run straight; how far of h it is looked at (0 .. 1). */
typedef struct aoi_path {
    double omega, decay, h, x, v, place;
    const double *force;
    int straight;
} aoi_path;

/* The integrals of v^2 and of t v over that part. */
void aoi_path_integrals(const aoi_path *path, double *squared, double *moment);

#endif
