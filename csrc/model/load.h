/* The loads on the ports of a body at a time. */
#ifndef AOI_MODEL_LOAD_H
#define AOI_MODEL_LOAD_H

#include "aoimpact.h"

/* The interval of a load that contains a time. here, next: forces on the ports at its start and end (the same
 * where the load is constant), N; into, length: time since the start of the interval, and length of the interval,
 * s. */
typedef struct aoi_load_span {
    const double *here, *next;
    double into, length;
} aoi_load_span;

/* Returns the interval of a load (count > 0) that contains a time; at a jump of the load, the interval after it.
 * ports: number of ports. */
aoi_load_span aoi_load_at(const aoi_load *load, size_t ports, double time);

/* Returns the time of the bend (one of the load's times) that follows the next `skipped` bends after `time`, s;
 * HUGE_VAL if there is none. */
double aoi_load_later_bend(const aoi_load *load, double time, size_t skipped);

/* True if times ascend (equal neighbours are allowed) and all numbers are finite. */
int aoi_load_is_sound(const aoi_load *load, size_t ports);

#endif
