/* The loads on a body, at a time. */
#ifndef AOI_MODEL_LOAD_H
#define AOI_MODEL_LOAD_H

#include "aoimpact.h"

/* Interval of a load that contains a time: forces on the ports at its start and end (the same where
 * the load is constant), time since its start and its length, s. */
typedef struct aoi_load_span {
    const double *here, *next;
    double into, length;
} aoi_load_span;

/* Span of a load with count > 0 at a time; at a jump of the load, the span after it. ports: number. */
aoi_load_span aoi_load_at(const aoi_load *load, size_t ports, double time);

/* Time of the load's next bend after `time` if the first `skipped` bends are left out, s; HUGE_VAL: none. */
double aoi_load_later_bend(const aoi_load *load, double time, size_t skipped);

/* True if times ascend (equal neighbours are allowed) and all numbers are finite. */
int aoi_load_is_sound(const aoi_load *load, size_t ports);

#endif
