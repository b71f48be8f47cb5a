/* An impact in a few numbers. */
#ifndef AOI_TRACK_BRIEF_H
#define AOI_TRACK_BRIEF_H

#include "aoimpact.h"

/* What many impacts are compared by. */
typedef struct aoi_brief {
    double touches, lasting; /* how many; 1 if the record ends in contact, else 0 */
    double peak_force, peak_time, impulse;
    double start, end;  /* of the first touch, and of the last; 0 without any                    */
    double velocity[2]; /* of the centres of mass when the last touch ends; without any, at the end */
} aoi_brief;

/* Makes an adaptive run of a linked system of two bodies and one contact, in a track of so many rows at most,
 * and sums it up. memory: aoi_brief_size bytes, overwritten. Errors as aoi_adaptive_start and
 * aoi_adaptive_finish. */
size_t aoi_brief_size(const aoi_system *system, size_t rows);
int aoi_brief_run(const aoi_system *system, const aoi_start *start, double rtol, double end, size_t rows,
                  void *memory, aoi_brief *brief);

#endif
