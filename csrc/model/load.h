/* A load: a force on a port that runs straight between given times. */
#ifndef AOI_MODEL_LOAD_H
#define AOI_MODEL_LOAD_H

#include "aoimpact.h"

/* A force on a port that runs straight between times (ascending; of two equal ones the later counts)
 * and is constant before the first and after the last. force: count >= 1 values. next: state. */
typedef struct aoi_load {
    size_t body, port, count;
    const double *time, *force;
    size_t next;
} aoi_load;

/* The force at a time not before the one of the last call. */
double aoi_load_at(aoi_load *load, double time);

#endif
