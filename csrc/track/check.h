/* Private to track/: whether a track can be read. */
#ifndef AOI_TRACK_CHECK_H
#define AOI_TRACK_CHECK_H

#include "aoimpact.h"

/* Rows follow each other without holes and make up the track, do not go back in time, and name only what is in the
 * system, which is linked. */
int aoi_track_is_sound(const aoi_system *system, const aoi_track *track);

#endif
