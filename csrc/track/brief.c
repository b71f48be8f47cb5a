/* An impact of two bodies in a few numbers, for those who make many: nothing of it is kept. */
#include "track/brief.h"
#include "track/sampler.h"
#include "collocation/collocation.h"
#include "adaptive/adaptive.h"
#include "adaptive/row.h"

#include <math.h>

/* A contact that is in no row any more at this share of the record has ended before. */
static const double RECORD_END = 1.0 - 1e-14;

/* The first place in a row behind its bodies. */
static const double *contact_in(const aoi_system *system, const double *row)
{
    const double *of = row + AOI_TRACK_FIXED;
    for (size_t i = 0; i < (size_t)row[AOI_TRACK_BODIES]; i++) {
        of += AOI_TRACK_STATE + 2 * system->body[(size_t)of[0]].n;
    }
    return of;
}

static void find_touches(const aoi_adaptive *run, size_t rows, const double *track,
                         const size_t *index, aoi_brief *brief)
{
    double until = 0.0;
    int closed = 0;
    brief->touches = 0;
    brief->start = brief->end = 0.0;
    for (size_t r = 0; r < rows; r++) {
        const double *row = track + index[r];
        if (row[AOI_TRACK_CONTACTS] == 0.0) {
            continue;
        }
        const double *of = contact_in(run->system, row);
        if (of[AOI_TRACK_PIECE] == AOI_SLACK) { /* of no force, maybe from its very start on */
            brief->end = closed ? until : brief->end;
            closed = 0;
            continue;
        }
        until = row[AOI_TRACK_START] + row[AOI_TRACK_LENGTH];
        if (of[AOI_TRACK_BEGINS] != 0.0) {
            brief->start = brief->touches == 0 ? row[AOI_TRACK_START] : brief->start;
            brief->touches++;
            closed = 1;
        }
        if (of[AOI_TRACK_ENDS] != 0.0) { /* of the force: bodies may overlap for longer */
            brief->end = until;
            closed = 0;
        }
    }
    brief->lasting = closed && until >= run->end * RECORD_END;
    if (closed) {
        brief->end = brief->lasting ? run->end : until;
    }
    brief->end = brief->end < run->end ? brief->end : run->end;
}

/* Velocities of the centres of mass at a time. */
static int find_velocities(aoi_sampler *sampler, double time, double *record, double *velocity)
{
    const aoi_system *system = sampler->system;
    const int status = aoi_sampler_start(sampler);
    if (status != AOI_OK) {
        return status;
    }
    aoi_sampler_column(sampler, time, 0, record, 1);
    for (size_t b = 0; b < 2; b++) {
        velocity[b] = record[AOI_CONTACT_ROWS + b * AOI_BODY_ROWS + AOI_PORT_ROWS * system->first_port[b] +
                             AOI_BODY_CENTRE_VELOCITY];
    }
    return AOI_OK;
}

int aoi_brief_run(aoi_adaptive *run, size_t capacity, size_t most, double *track, size_t *index,
                  aoi_sampler *sampler, double *record, aoi_brief *brief)
{
    size_t used = 0, rows = 0;
    if (run->system->body_count != 2 || run->system->joint_count != 1) {
        return AOI_ERROR_ARGUMENT;
    }
    const aoi_law *law = run->system->joint[0].law;
    if (law && law->note) { /* not what it was for a run before, of the same law */
        law->note[0] = (double)NAN;
    }
    int status = aoi_adaptive_start(run);
    for (double before = -HUGE_VAL; status == AOI_OK && run->time > before && run->time < run->end;) {
        size_t more = 0, more_rows = 0;
        before = run->time;
        status = aoi_adaptive_run(run, capacity - used, most - rows, track + used, index + rows, &more,
                                  &more_rows);
        for (size_t i = 0; i < more_rows; i++) {
            index[rows + i] += used;
        }
        used += more;
        rows += more_rows;
    }
    if (status != AOI_OK || run->time < run->end) {
        return status != AOI_OK ? status : AOI_ERROR_TOO_LONG;
    }
    find_touches(run, rows, track, index, brief);
    brief->peak_force = run->contact[0].peak_force;
    brief->peak_time = run->contact[0].peak_time;
    brief->impulse = run->contact[0].impulse;
    sampler->system = run->system;
    sampler->track = track;
    sampler->size = used;
    sampler->index = index;
    sampler->rows = rows;
    return find_velocities(sampler, brief->touches > 0 ? brief->end : run->end, record,
                           brief->velocity);
}
