/* One impact of two bodies, reduced to a few numbers for studies of many impacts. Its track is not kept. */
#include "track/brief.h"
#include "linear/work.h"

#include <math.h>

/* Objects that a run needs, in one block of memory. */
typedef struct parts {
    aoi_adaptive *run;
    aoi_sampler *sampler;
    aoi_track track;
    aoi_interval *interval;
    double *record;
} parts;

static parts lay_out(const aoi_system *system, size_t rows, void *block, size_t *size)
{
    aoi_memory memory = {block, 0};
    parts made = {.track = {.row_capacity = rows}};
    made.track.capacity = aoi_times(rows, aoi_adaptive_room(system));
    made.run = aoi_memory_take(&memory, 1, aoi_adaptive_size(system));
    made.sampler = aoi_memory_take(&memory, 1, aoi_sampler_size(system));
    made.record = aoi_memory_doubles(&memory, aoi_record_rows(system));
    made.interval = aoi_memory_take(&memory, rows + 1, sizeof *made.interval);
    made.track.row = aoi_memory_numbers(&memory, rows);
    made.track.values = aoi_memory_doubles(&memory, made.track.capacity);
    *size = memory.used;
    return made;
}

size_t aoi_brief_size(const aoi_system *system, size_t rows)
{
    size_t size;
    (void)lay_out(system, rows, NULL, &size);
    return size;
}

static void find_touches(const aoi_system *system, const parts *of, size_t rows, double end, aoi_brief *brief)
{
    const aoi_interval *interval = of->interval + 1;
    const size_t count = aoi_track_intervals(system, &of->track, end, of->interval, rows, of->interval + 1);
    brief->touches = (double)count;
    brief->start = count > 0 ? interval[0].start : 0.0;
    brief->end = count > 0 ? fmin(interval[count - 1].end, end) : 0.0;
    brief->lasting = count > 0 && interval[count - 1].lasts;
}

/* Finds the velocities of both centres of mass at a time, m/s. */
static int find_velocities(const aoi_system *system, const parts *of, double time, double *velocity)
{
    const int status = aoi_sampler_start(of->sampler, system, &of->track);
    if (status != AOI_OK) {
        return status;
    }
    aoi_sampler_column(of->sampler, time, 0, of->record, 1);
    for (size_t b = 0; b < 2; b++) {
        velocity[b] = of->record[aoi_record_body(system, b) + AOI_BODY_CENTRE_VELOCITY];
    }
    return isfinite(velocity[0]) && isfinite(velocity[1]) ? AOI_OK : AOI_ERROR_NOT_FINITE;
}

int aoi_brief_run(const aoi_system *system, const aoi_start *start, double rtol, double end, size_t rows,
                  void *memory, aoi_brief *brief)
{
    if (!system->first || system->body_count != 2 || system->contact_count != 1) {
        return AOI_ERROR_ARGUMENT;
    }
    size_t size;
    parts of = lay_out(system, rows, memory, &size);
    const aoi_law *law = system->contact[0].law;
    if (law->note) { /* an earlier run with the same law may have left a note */
        law->note[0] = (double)NAN;
    }
    int status = aoi_adaptive_start(of.run, system, start, rtol, end);
    status = status == AOI_OK ? aoi_adaptive_finish(of.run, &of.track) : status;
    if (status != AOI_OK) {
        return status;
    }
    const aoi_peak peak = aoi_adaptive_peak(of.run, 0);
    find_touches(system, &of, rows, end, brief);
    brief->peak_force = peak.force;
    brief->peak_time = peak.time;
    brief->impulse = peak.impulse;
    return find_velocities(system, &of, brief->touches > 0.0 ? brief->end : end, brief->velocity);
}
