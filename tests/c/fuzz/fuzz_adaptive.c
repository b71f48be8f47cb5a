/* Adaptive runs, their tracks sampled, and briefs. */
#include "system.h"
#include "linear/vector.h"
#include "adaptive/adaptive.h"
#include "adaptive/row.h"
#include "track/brief.h"
#include "track/sampler.h"

/* Rows follow each other in time, and all is finite. */
static void look_at_track(const double *track, const size_t *index, size_t used, size_t rows, double end)
{
    REQUIRE(aoi_vector_is_finite(used, track));
    for (size_t r = 0; r < rows; r++) {
        const double *row = track + index[r];
        REQUIRE(row[AOI_TRACK_START] >= (r > 0 ? track[index[r - 1]] : 0.0));
        REQUIRE(row[AOI_TRACK_START] <= end && row[AOI_TRACK_LENGTH] >= 0.0);
    }
}

static void look_at_contacts(const aoi_adaptive *run)
{
    for (size_t c = 0; c < run->system->joint_count; c++) {
        const aoi_contact_state *contact = &run->contact[c];
        REQUIRE(isfinite(contact->peak_force) && isfinite(contact->impulse));
        REQUIRE(contact->peak_time >= 0.0 && contact->peak_time <= run->end);
    }
}

static void sample(input *in, const aoi_adaptive *run, const double *track, size_t used,
                   const size_t *index, size_t rows)
{
    const aoi_system *system = run->system;
    aoi_sampler sampler = take_sampler(in, system);
    double *record = take_room(in, aoi_sampler_rows(system)), *state = take_room(in, 2 * system->first[1]);
    double *forces = take_room(in, system->joint_count);
    sampler.track = track;
    sampler.size = used;
    sampler.index = index;
    sampler.rows = rows;
    REQUIRE(aoi_sampler_start(&sampler) == AOI_OK);
    for (size_t i = 0; i <= 8; i++) {
        const double time = run->time * (double)i / 8.0;
        aoi_sampler_column(&sampler, time, take_byte(in) & 1, record, 1);
        aoi_sampler_forces(&sampler, time, forces, 1);
        aoi_sampler_state(&sampler, time, 0, state);
        for (size_t c = 0; c < system->joint_count; c++) {
            REQUIRE(!isnan(record[AOI_CONTACT_ROWS * c]) && forces[c] == record[AOI_CONTACT_ROWS * c]);
            REQUIRE(forces[c] >= 0.0 || system->joint[c].law->pulls);
        }
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    input in = open_input(data, size);
    aoi_system system;
    if (take_system(&in, 2, &system) == AOI_OK) {
        aoi_adaptive run = take_run(&in, &system);
        const size_t capacity = MOST_TRACK_ROWS * run.row_size;
        double *track = take_room(&in, capacity);
        size_t *index = take_bytes(&in, MOST_TRACK_ROWS, sizeof *index), used = 0, rows = 0;
        if (system.body_count == 2 && system.joint_count == 1 && (take_byte(&in) & 1)) {
            aoi_sampler sampler = take_sampler(&in, &system);
            aoi_brief brief;
            if (aoi_brief_run(&run, capacity, MOST_TRACK_ROWS, track, index, &sampler,
                              take_room(&in, aoi_sampler_rows(&system)), &brief) == AOI_OK) {
                REQUIRE(isfinite(brief.peak_force) && isfinite(brief.impulse));
                REQUIRE(isfinite(brief.velocity[0]) && isfinite(brief.velocity[1]));
                REQUIRE(brief.start <= brief.end && brief.end <= run.end);
            }
        } else if (aoi_adaptive_start(&run) == AOI_OK &&
                   aoi_adaptive_run(&run, capacity, MOST_TRACK_ROWS, track, index, &used, &rows) == AOI_OK &&
                   rows > 0) {
            look_at_track(track, index, used, rows, run.end);
            look_at_contacts(&run);
            sample(&in, &run, track, used, index, rows);
        }
    }
    close_input(&in);
    return 0;
}
