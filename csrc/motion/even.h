/* Free motion at evenly spaced times, with the motion of the modes over the spacing computed only once. */
#ifndef AOI_EVEN_H
#define AOI_EVEN_H

#include "aoimpact.h"
#include "motion/lanes.h"

/* Motion of four modes over the spacing of the times, with their omega^2 (spring), 2 decay (damping) and
 * gravity. */
typedef struct aoi_even_lanes {
    aoi_motions by;
    double spring[AOI_LANES], damping[AOI_LANES], gravity[AOI_LANES];
} aoi_even_lanes;

/* State of the evaluation. Initially time is NaN, the arrays have aoi_even_size elements each, and all other
 * members are 0. */
typedef struct aoi_even {
    aoi_even_lanes *lanes;
    double (*x)[AOI_LANES], (*v)[AOI_LANES]; /* state at the last time */
    double time, spacing, fastest; /* last time and spacing, s; largest omega + 2 decay, 1/s */
    size_t left; /* number of states that may still be computed from the state before */
    int made;    /* 1: lanes hold the motion over `spacing`          */
} aoi_even;

static inline size_t aoi_even_size(const aoi_modes *body) { return (body->n + AOI_LANES - 1) / AOI_LANES; }

/* Sets `state` (x, v: 2 n) to the state of a body without loads at a time, in free motion from the state x0 at the
 * time `from`. At evenly spaced times each state is computed from the last one, and often enough from x0 that
 * rounding stays below 1e-14 of a mode's amplitude. */
void aoi_even_state(aoi_even *even, const aoi_modes *body, double from, const double *x0, double time,
                    double *state);

#endif
