/* The caller's work space, dealt out array by array. */
#ifndef AOIMPACT_WORK_H
#define AOIMPACT_WORK_H

#include <stddef.h>

static inline double *aoi_work_take(double **work, size_t count)
{
    double *taken = *work;
    *work += count;
    return taken;
}

#endif
