/* One impact of two bodies, reduced to a few numbers. */
#ifndef AOI_TRACK_BRIEF_H
#define AOI_TRACK_BRIEF_H

#include "aoimpact.h"

/* Results of one impact of two bodies. */
typedef struct aoi_brief {
    double touches, lasting; /* touches: number of contact intervals; lasting: 1 if the run ends in contact, else 0 */
    double peak_force, peak_time, impulse; /* peak force, N; its time, s; impulse of all touches, N s */
    double start, end;  /* start of the first touch and end of the last one, s; 0 if there is none */
    /* velocities of both centres of mass, m/s, at the end of the last touch or, if there is none, of the run */
    double velocity[2];
} aoi_brief;

/* aoi_brief_run: runs a linked system of two bodies and one contact to a tolerance, and reduces the run to an
 * aoi_brief. aoi_brief_size: size of its memory, in bytes.
 *   rows    capacity of the run's track, in rows
 *   memory  aoi_brief_size bytes, overwritten
 * Errors as for aoi_adaptive_start and aoi_adaptive_finish; AOI_ERROR_NOT_FINITE if a velocity overflows. */
size_t aoi_brief_size(const aoi_system *system, size_t rows);
int aoi_brief_run(const aoi_system *system, const aoi_start *start, double rtol, double end, size_t rows,
                  void *memory, aoi_brief *brief);

#endif
