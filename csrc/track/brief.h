/* One impact of two bodies in a few numbers. */
#ifndef AOI_TRACK_BRIEF_H
#define AOI_TRACK_BRIEF_H

#include "aoimpact.h"

/* Results of one impact of two bodies. */
typedef struct aoi_brief {
    double touches, lasting; /* number of touches; 1 if the run ends in contact, else 0 */
    double peak_force, peak_time, impulse; /* N; s; N s, of all touches */
    double start, end;  /* start of the first touch and end of the last, s; 0 if there is none   */
    /* velocities of the centres of mass after the last touch, or at the run's end without one, m/s */
    double velocity[2];
} aoi_brief;

/* Runs a linked system of two bodies and one contact to a tolerance, and sums it up.
 *   rows    capacity of its track
 *   memory  aoi_brief_size bytes, overwritten
 * Errors as of aoi_adaptive_start and aoi_adaptive_finish. */
size_t aoi_brief_size(const aoi_system *system, size_t rows);
int aoi_brief_run(const aoi_system *system, const aoi_start *start, double rtol, double end, size_t rows,
                  void *memory, aoi_brief *brief);

#endif
