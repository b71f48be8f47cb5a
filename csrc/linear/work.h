/* The caller's work space, dealt out array by array, and the caller's pause. */
#ifndef AOIMPACT_WORK_H
#define AOIMPACT_WORK_H

#include "aoimpact.h"

/* Whether the caller wants what takes long to end. */
static inline int aoi_work_stops(const aoi_pause *pause)
{
    return pause && pause->ask && pause->ask(pause->data) != 0;
}

static inline double *aoi_work_take(double **work, size_t count)
{
    double *taken = *work;
    *work += count;
    return taken;
}

#endif
