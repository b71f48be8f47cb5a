/* Check of a track that does not come from a run of this process, before it is read. */
#include "collocation/collocation.h"
#include "adaptive/row.h"
#include "model/system.h"

#include <math.h>

/* Converts a value of a track to an integer. Returns 0 unless the value is an integer from 0 to limit - 1. */
static int number_below(double value, size_t limit, size_t *number)
{
    *number = 0;
    if (!(value >= 0.0 && value < (double)limit)) {
        return 0;
    }
    *number = (size_t)value;
    return (double)*number == value;
}

/* True if a contact of a row can be read. */
static int contact_is_sound(const aoi_system *system, const double *of)
{
    size_t c, edge, piece;
    if (!number_below(of[AOI_TRACK_CONTACT], system->contact_count, &c) ||
        !number_below(of[AOI_TRACK_EDGE], AOI_EDGE_NONE + 1, &edge)) {
        return 0;
    }
    const aoi_law *law = system->contact[c].law;
    /* a slack contact has no force and no edge, and its law is not evaluated */
    if (of[AOI_TRACK_PIECE] == AOI_SLACK) {
        return edge == AOI_EDGE_NONE && !system->contact[c].friction;
    }
    return number_below(of[AOI_TRACK_PIECE], law->table_count > 0 ? law->table_count : INT32_MAX, &piece);
}

/* Returns the index at which the row that begins at index `at` ends; 0 if the row is not inside the track or
 * refers to a body or contact that is not in the system. */
static size_t end_of_row(const aoi_system *system, const aoi_track *track, size_t at)
{
    const double *values = track->values, *row = values + at;
    size_t bodies, contacts, b, end = at + AOI_TRACK_FIXED;
    if (track->used - at < AOI_TRACK_FIXED || !isfinite(row[AOI_TRACK_START]) ||
        !isfinite(row[AOI_TRACK_LENGTH])) {
        return 0;
    }
    if (!number_below(row[AOI_TRACK_BODIES], system->body_count + 1, &bodies) ||
        !number_below(row[AOI_TRACK_CONTACTS], system->contact_count + 1, &contacts) ||
        (contacts > 0 && !(row[AOI_TRACK_LENGTH] > 0.0))) {
        return 0;
    }
    for (; bodies > 0; bodies--) {
        if (end == track->used || !number_below(values[end + AOI_TRACK_BODY], system->body_count, &b) ||
            track->used - end < AOI_TRACK_STATE + 2 * system->body[b].n) {
            return 0;
        }
        end += AOI_TRACK_STATE + 2 * system->body[b].n;
    }
    for (; contacts > 0; contacts--) {
        if (track->used - end < AOI_TRACK_CONTACT_SIZE || !contact_is_sound(system, values + end)) {
            return 0;
        }
        const size_t size = aoi_row_contact_size(&system->contact[(size_t)values[end + AOI_TRACK_CONTACT]]);
        if (track->used - end < size) {
            return 0;
        }
        end += size;
    }
    return end;
}

int aoi_track_check(const aoi_system *system, const aoi_track *track)
{
    if (!aoi_system_is_plain(system)) {
        return AOI_ERROR_ARGUMENT;
    }
    size_t end = 0;
    double time = -HUGE_VAL;
    for (size_t row = 0; row < track->rows; row++) {
        if (track->row[row] != end) {
            return AOI_ERROR_ARGUMENT;
        }
        const double *here = track->values + end;
        end = end_of_row(system, track, end);
        if (end == 0 || here[AOI_TRACK_START] < time) {
            return AOI_ERROR_ARGUMENT;
        }
        time = here[AOI_TRACK_START];
    }
    return track->rows > 0 && end == track->used ? AOI_OK : AOI_ERROR_ARGUMENT;
}
