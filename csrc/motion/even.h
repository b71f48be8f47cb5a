/* Free motion at times that follow each other evenly: how modes move from one to the next is computed once. */
#ifndef AOI_EVEN_H
#define AOI_EVEN_H

#include "aoimpact.h"
#include "motion/lanes.h"

/* What four modes do in a spacing, and what acts on them. */
typedef struct aoi_even_lanes {
    aoi_motions by;
    double spring[AOI_LANES], damping[AOI_LANES], gravity[AOI_LANES];
} aoi_even_lanes;

/* Set to 0 but for the arrays of aoi_even_size each, and the time: NaN before the first. */
typedef struct aoi_even {
    aoi_even_lanes *lanes;
    double (*x)[AOI_LANES], (*v)[AOI_LANES]; /* at the last time */
    double time, spacing, fastest;
    size_t left; /* how often x, v may yet follow from those before */
    int made;    /* the lanes are those of the spacing              */
} aoi_even;

static inline size_t aoi_even_size(const aoi_modes *body) { return (body->n + AOI_LANES - 1) / AOI_LANES; }

/* The free motion of a body without loads from time `from` on, when it has the state x0 (x, v: 2 n), at a time. Times
 * that follow each other evenly take the state from one to the next, and anew from x0 so often that rounding stays
 * below 1e-14 of a mode's amplitude. */
void aoi_even_state(aoi_even *even, const aoi_modes *body, double from, const double *x0, double time,
                    double *state);

#endif
