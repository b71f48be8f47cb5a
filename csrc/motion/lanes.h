/* Modes of a body, four at a time, in loops of constant length, which compilers vectorise. The result for a mode
 * does not depend on its neighbours and, for undamped modes, not on the C library's sine. */
#ifndef AOI_LANES_H
#define AOI_LANES_H

#include "aoimpact.h"
#include "law/law.h"

#include <string.h>

enum { AOI_LANES = 4 };

/* Rotation of the phases of AOI_LANES undamped modes in a time: half the phase angles, and their sines and
 * cosines. */
typedef struct aoi_turn {
    double time, half[AOI_LANES], sine[AOI_LANES], cosine[AOI_LANES];
} aoi_turn;

/* The aoi_motion of AOI_LANES modes; ramp is set only on request. */
typedef struct aoi_motions {
    double impulse[AOI_LANES], rate[AOI_LANES], step[AOI_LANES], ramp[AOI_LANES];
} aoi_motions;

/* The integrals of aoi_oscillator_integrals for AOI_LANES modes. */
typedef struct aoi_integrals {
    double impulse[AOI_NODES][AOI_LANES], rate[AOI_NODES][AOI_LANES];
} aoi_integrals;

/* Compute the rotation, motion and integrals of AOI_LANES undamped modes over a time. omega: their angular
 * frequencies, 0 for a mode without a spring. */
void aoi_turn_make(const double *omega, double time, aoi_turn *turn);
void aoi_turn_motions(const aoi_turn *turn, aoi_motions *motions);
void aoi_turn_integrals(const aoi_turn *turn, aoi_integrals *integrals);

/* Returns the number of modes from mode `first` on, at most AOI_LANES. */
static inline size_t aoi_lanes_count(const aoi_modes *body, size_t first)
{
    return body->n - first < AOI_LANES ? body->n - first : AOI_LANES;
}

/* Copies the values of `count` modes to the lanes, and sets the other lanes to 0. */
static inline void aoi_lanes_take(const double *values, size_t count, double *lanes)
{
    if (count == AOI_LANES) { /* a constant length, for the compiler */
        memcpy(lanes, values, AOI_LANES * sizeof *lanes);
        return;
    }
    memset(lanes, 0, AOI_LANES * sizeof *lanes);
    memcpy(lanes, values, count * sizeof *lanes);
}

static inline void aoi_lanes_put(const double *lanes, size_t count, double *values)
{
    if (count == AOI_LANES) {
        memcpy(values, lanes, AOI_LANES * sizeof *lanes);
        return;
    }
    memcpy(values, lanes, count * sizeof *lanes);
}

static inline double aoi_lanes_sum(const double *lanes)
{
    return (lanes[0] + lanes[1]) + (lanes[2] + lanes[3]);
}

#endif
