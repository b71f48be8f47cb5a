/* Two bodies in free motion, and when they touch. */
#ifndef AOI_MOTION_FREE_H
#define AOI_MOTION_FREE_H

#include "law/law.h"

/* A polynomial in time that adds to an indentation over one step: its shifted Legendre coefficients and those
 * of its first three derivatives, and a bound of its second. */
enum { AOI_DERIVATIVES = 3 };
typedef struct aoi_forced {
    double from, length;
    double series[AOI_DERIVATIVES + 1][AOI_NODES + 1];
    double bend;
} aoi_forced;

/* Sets `forced` to the polynomial with the given AOI_NODES + 1 values, at the start and the nodes of a step. */
void aoi_forced_fit(double from, double length, const double *values, aoi_forced *forced);

/* Two bodies in free motion, with their own copies of x and v (n each) at the same time, and a
 * contact between them. forced: NULL, or the contribution of a step's contact forces to its
 * indentation; then limit is at most the end of that step. */
typedef struct aoi_free_pair {
    const aoi_modes *body[2];
    size_t port[2];
    double gap;
    double *x[2], *v[2];
    double time;
    const aoi_forced *forced;
} aoi_free_pair;

/* The contact's indentation without contact force, and its derivatives up to the order `most`, 1 or AOI_DERIVATIVES.
 * The third derivative is the leading term for bodies that touch at rest while a load rises from zero. */
void aoi_free_pair_motion(const aoi_free_pair *pair, int most, double *of);

/* Advances both bodies in free motion (in place) until they touch, but not beyond limit; touches:
 * whether they touch then (indentation 0, about to rise). It misses no touch: each stride is the
 * root of a quadratic that bounds the indentation from above, high frequencies by their amplitude,
 * low ones by their acceleration. AOI_ERROR_NO_CONVERGENCE after `most` strides (a gap that neither
 * opens nor closes). */
int aoi_free_pair_next_touch(aoi_free_pair *pair, double limit, size_t most, int *touches);

#endif
