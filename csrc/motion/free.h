/* Two bodies in free motion, and the search for their next touch. */
#ifndef AOI_MOTION_FREE_H
#define AOI_MOTION_FREE_H

#include "law/law.h"

/* A polynomial in time that is added to an indentation over one step: its shifted Legendre coefficients and those
 * of its first three derivatives, and a bound (bend) of its second derivative. */
enum { AOI_DERIVATIVES = 3 };
typedef struct aoi_forced {
    double from, length;
    double series[AOI_DERIVATIVES + 1][AOI_NODES + 1];
    double bend;
} aoi_forced;

/* Sets `forced` to the polynomial with the given values at the start and the AOI_NODES nodes of a step. */
void aoi_forced_fit(double from, double length, const double *values, aoi_forced *forced);

/* Two bodies in free motion, with their own copies of x and v (n each) at the same time, and a contact between
 * them. forced: the part of the indentation that a step's contact forces add, or NULL. With such a part, no search
 * may go beyond the end of that step. */
typedef struct aoi_free_pair {
    const aoi_modes *body[2];
    size_t port[2];
    double gap;
    double *x[2], *v[2];
    double time;
    const aoi_forced *forced;
} aoi_free_pair;

/* Sets `of` to the contact's indentation without contact force and its derivatives with respect to time, up to the
 * order `most`, 1 or AOI_DERIVATIVES. For bodies that touch at rest while a load rises from zero, the third
 * derivative is the leading term. */
void aoi_free_pair_motion(const aoi_free_pair *pair, int most, double *of);

/* Advances both bodies in free motion (in place) until they touch, at most to the time `limit`. touches: set to 1
 * if they then touch (indentation 0, about to rise), else 0. No touch is missed: each stride is the root of a
 * quadratic that bounds the indentation from above, with high frequencies bounded by their amplitude and low ones
 * by their acceleration. Returns AOI_ERROR_NO_CONVERGENCE after `most` strides (a gap that neither opens nor
 * closes). */
int aoi_free_pair_next_touch(aoi_free_pair *pair, double limit, size_t most, int *touches);

#endif
