/* Free motion at evenly spaced times: the motion of the modes over the spacing is computed once. */
#ifndef AOI_EVEN_H
#define AOI_EVEN_H

#include "aoimpact.h"
#include "motion/lanes.h"

/* Motion of four modes over the spacing; their omega^2, 2 decay and gravity. */
typedef struct aoi_even_lanes {
    aoi_motions by;
    double spring[AOI_LANES], damping[AOI_LANES], gravity[AOI_LANES];
} aoi_even_lanes;

/* State of the evaluation. Initially all members are 0, except the arrays, of aoi_even_size elements each, and time,
 * which is NaN. */
typedef struct aoi_even {
    aoi_even_lanes *lanes;
    double (*x)[AOI_LANES], (*v)[AOI_LANES]; /* state at the last time */
    double time, spacing, fastest; /* last time; spacing, s; largest omega + 2 decay, 1/s */
    size_t left; /* number of states that may yet be computed from the one before */
    int made;    /* 1: lanes hold the motion over `spacing`          */
} aoi_even;

static inline size_t aoi_even_size(const aoi_modes *body) { return (body->n + AOI_LANES - 1) / AOI_LANES; }

/* Writes the state of a body without loads at a time, in free motion from the state x0 (x, v: 2 n)
 * at the time `from`. At evenly spaced times each state is computed from the one before, and from
 * x0 so often that rounding stays below 1e-14 of a mode's amplitude. */
void aoi_even_state(aoi_even *even, const aoi_modes *body, double from, const double *x0, double time,
                    double *state);

#endif
