/* Adaptive runs, their tracks sampled, and briefs. */
#include "system.h"
#include "linear/vector.h"
#include "adaptive/row.h"
#include "adaptive/run.h"
#include "track/brief.h"

/* Rows follow each other in time, and all is finite. */
static void look_at_track(const aoi_track *track, double end)
{
    REQUIRE(aoi_vector_is_finite(track->used, track->values));
    for (size_t r = 0; r < track->rows; r++) {
        const double *row = track->values + track->row[r];
        REQUIRE(row[AOI_TRACK_START] >= (r > 0 ? track->values[track->row[r - 1]] : 0.0));
        REQUIRE(row[AOI_TRACK_START] <= end && row[AOI_TRACK_LENGTH] >= 0.0);
    }
}

static void look_at_contacts(input *in, const aoi_system *system, const aoi_adaptive *run,
                             const aoi_track *track, double end)
{
    aoi_interval *work = take_bytes(in, system->contact_count, sizeof *work);
    const size_t count = aoi_track_intervals(system, track, end, work, 0, NULL);
    aoi_interval *interval = take_bytes(in, count, sizeof *interval);
    REQUIRE(aoi_track_intervals(system, track, end, work, count, interval) == count);
    for (size_t i = 0; i < count; i++) {
        REQUIRE(interval[i].contact < system->contact_count && interval[i].start <= interval[i].end);
        REQUIRE(isfinite(interval[i].impulse) && isfinite(interval[i].pace));
    }
    const size_t slips = aoi_track_slips(system, track, 0, NULL);
    aoi_slip *slip = take_bytes(in, slips, sizeof *slip);
    REQUIRE(aoi_track_slips(system, track, slips, slip) == slips);
    for (size_t i = 0; i < slips; i++) {
        REQUIRE(slip[i].contact < system->contact_count && system->contact[slip[i].contact].friction);
        REQUIRE(slip[i].time >= (i > 0 && system->contact_count == 1 ? slip[i - 1].time : 0.0));
        REQUIRE(slip[i].slips == 0 || slip[i].slips == 1);
    }
    for (size_t c = 0; c < system->contact_count; c++) {
        const aoi_peak peak = aoi_adaptive_peak(run, c);
        REQUIRE(isfinite(peak.force) && isfinite(peak.impulse));
        REQUIRE(peak.time >= 0.0 && peak.time <= end);
    }
}

static void sample(input *in, const aoi_system *system, const aoi_track *track, double end)
{
    aoi_sampler *sampler = take_sampler(in, system);
    double *record = take_room(in, aoi_record_rows(system)), *state = take_room(in, 2 * system->first[1]);
    double *forces = take_room(in, system->contact_count);
    REQUIRE(aoi_sampler_start(sampler, system, track) == AOI_OK);
    for (size_t i = 0; i <= 8; i++) {
        const double time = end * (double)i / 8.0;
        aoi_sampler_column(sampler, time, take_byte(in) & 1, record, 1);
        aoi_sampler_forces(sampler, time, forces, 1);
        aoi_sampler_state(sampler, time, 0, state);
        for (size_t c = 0; c < system->contact_count; c++) {
            const double force = record[aoi_record_contact(system, c)];
            REQUIRE(!isnan(force) && forces[c] == force);
            REQUIRE(forces[c] >= 0.0 || system->contact[c].law->pulls);
        }
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    input in = open_input(data, size);
    aoi_system system;
    if (take_system(&in, 2, &system) == AOI_OK) {
        double rtol, end;
        aoi_start start;
        take_start(&in, &system, &start, &rtol, &end);
        if (system.body_count == 2 && system.contact_count == 1 && (take_byte(&in) & 1)) {
            aoi_brief brief;
            void *memory = take_bytes(&in, 1, aoi_brief_size(&system, MOST_TRACK_ROWS));
            if (aoi_brief_run(&system, &start, rtol, end, MOST_TRACK_ROWS, memory, &brief) == AOI_OK) {
                REQUIRE(isfinite(brief.peak_force) && isfinite(brief.impulse));
                REQUIRE(isfinite(brief.velocity[0]) && isfinite(brief.velocity[1]));
                REQUIRE(brief.start <= brief.end && brief.end <= end);
            }
        } else {
            aoi_adaptive *run = take_bytes(&in, 1, aoi_adaptive_size(&system));
            aoi_track track = {.row_capacity = MOST_TRACK_ROWS};
            track.capacity = MOST_TRACK_ROWS * aoi_adaptive_room(&system);
            track.values = take_room(&in, track.capacity);
            track.row = take_bytes(&in, MOST_TRACK_ROWS, sizeof *track.row);
            if (aoi_adaptive_start(run, &system, &start, rtol, end) == AOI_OK &&
                aoi_adaptive_run(run, &track) == AOI_OK && track.rows > 0) {
                const double until = aoi_adaptive_progress(run).time;
                look_at_track(&track, end);
                look_at_contacts(&in, &system, run, &track, end);
                sample(&in, &system, &track, until);
            }
        }
    }
    close_input(&in);
    return 0;
}
