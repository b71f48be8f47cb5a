/* Distribution of the caller's memory to arrays, and the caller's pause. */
#ifndef AOI_LINEAR_WORK_H
#define AOI_LINEAR_WORK_H

#include "aoimpact.h"

/* True if the caller wants a long computation to end. */
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

/* Value returned for sizes that would overflow: larger than any memory, so that malloc fails. */
#define AOI_TOO_MUCH (SIZE_MAX / 2)

static inline size_t aoi_times(size_t one, size_t other)
{
    return other > 0 && one > AOI_TOO_MUCH / other ? AOI_TOO_MUCH : one * other;
}

static inline size_t aoi_plus(size_t one, size_t other)
{
    return one < AOI_TOO_MUCH && other < AOI_TOO_MUCH - one ? one + other : AOI_TOO_MUCH;
}

/* A block of memory, aligned as by malloc, and the number of bytes used. If block is NULL only the size is
 * counted, and all arrays are NULL. */
typedef struct aoi_memory {
    char *block;
    size_t used;
} aoi_memory;

enum { AOI_ALIGNMENT = 16 };

static inline void *aoi_memory_take(aoi_memory *memory, size_t count, size_t size)
{
    char *taken = memory->block ? memory->block + memory->used : NULL;
    const size_t bytes = aoi_times(count, size) + AOI_ALIGNMENT - 1;
    memory->used = aoi_plus(memory->used, bytes / AOI_ALIGNMENT * AOI_ALIGNMENT);
    return taken;
}

static inline double *aoi_memory_doubles(aoi_memory *memory, size_t count)
{
    return aoi_memory_take(memory, count, sizeof(double));
}

static inline size_t *aoi_memory_numbers(aoi_memory *memory, size_t count)
{
    return aoi_memory_take(memory, count, sizeof(size_t));
}

#endif
