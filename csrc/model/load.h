/* The loads on a body, at a time. */
#ifndef AOI_MODEL_LOAD_H
#define AOI_MODEL_LOAD_H

#include "aoimpact.h"

/* The two times of a load between which a time lies, and their forces: the same where the load is constant. */
typedef struct aoi_load_span {
    const double *here, *next;
    double into, length;
} aoi_load_span;

/* The span of a load on so many ports, with count > 0; just after the time where the load jumps. */
aoi_load_span aoi_load_at(const aoi_load *load, size_t ports, double time);

/* The time after another at which it bends for the next time but so many; infinite where there is none. */
double aoi_load_later_bend(const aoi_load *load, double time, size_t skipped);

/* True if times ascend (equal neighbours may be) and all numbers are finite. */
int aoi_load_is_sound(const aoi_load *load, size_t ports);

#endif
