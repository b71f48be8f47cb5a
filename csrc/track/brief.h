/* An impact in a few numbers. */
#ifndef AOI_TRACK_BRIEF_H
#define AOI_TRACK_BRIEF_H

#include "track/sampler.h"
#include "adaptive/adaptive.h"

/* What many impacts are compared by. */
typedef struct aoi_brief {
    double peak_force, peak_time, impulse;
    double start, end;  /* of the first touch, and of the last; 0 without any                    */
    double velocity[2]; /* of the centres of mass when the last touch ends; without any, at the end */
    size_t touches;
    int lasting; /* the record ends in contact */
} aoi_brief;

/* Makes a run of two bodies and one joint from its beginning to its end, and sums it up. run: as for
 * aoi_adaptive_start. track, index: room for capacity doubles and most rows, overwritten. sampler: its
 * places and work. record: aoi_sampler_rows doubles, overwritten. Errors as aoi_adaptive_run, and
 * AOI_ERROR_TOO_LONG where the track has no room for the run. */
int aoi_brief_run(aoi_adaptive *run, size_t capacity, size_t most, double *track, size_t *index,
                  aoi_sampler *sampler, double *record, aoi_brief *brief);

#endif
