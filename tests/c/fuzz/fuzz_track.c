/* Tracks made of any numbers: what the sampler's check lets through can be read. */
#include "system.h"
#include "adaptive/row.h"

static double take_entry(input *in, size_t limit)
{
    return take_byte(in) > 245 ? take_any(in) : (double)take_below(in, limit);
}

static size_t write_contact(input *in, const aoi_system *system, double *of)
{
    const double contact = take_entry(in, system->contact_count);
    size_t size = AOI_TRACK_CONTACT_SIZE;
    if (contact >= 0.0 && contact < (double)system->contact_count) {
        size = aoi_row_contact_size(&system->contact[(size_t)contact]);
    }
    for (size_t i = 0; i < size; i++) {
        of[i] = take_signed(in);
    }
    of[AOI_TRACK_CONTACT] = contact;
    of[AOI_TRACK_BEGINS] = take_entry(in, 2);
    of[AOI_TRACK_ENDS] = take_entry(in, 2);
    of[AOI_TRACK_EDGE] = take_entry(in, 3);
    of[AOI_TRACK_PIECE] = take_entry(in, 5) - 1.0;
    return size;
}

/* The first row has all bodies, in order. */
static size_t write_row(input *in, const aoi_system *system, int is_first, double time, double *row)
{
    const size_t bodies = is_first ? system->body_count : take_below(in, system->body_count + 1);
    const size_t contacts = take_below(in, system->contact_count + 1);
    double *of = row + AOI_TRACK_FIXED;
    row[AOI_TRACK_START] = take_byte(in) > 250 ? take_any(in) : time;
    row[AOI_TRACK_LENGTH] = take_byte(in) > 250 ? take_any(in) : take_positive(in);
    row[AOI_TRACK_BODIES] = take_byte(in) > 250 ? take_any(in) : (double)bodies;
    row[AOI_TRACK_CONTACTS] = take_byte(in) > 250 ? take_any(in) : (double)contacts;
    row[AOI_TRACK_SIZE] = take_any(in);
    for (size_t i = 0; i < bodies; i++) {
        const size_t b = is_first ? i : take_below(in, system->body_count);
        const size_t length = AOI_TRACK_STATE + 2 * system->body[b].n;
        for (size_t j = 1; j < length; j++) {
            of[j] = take_signed(in);
        }
        of[0] = take_byte(in) > 250 ? take_any(in) : (double)b;
        of += length;
    }
    for (size_t i = 0; i < contacts; i++) {
        of += write_contact(in, system, of);
    }
    return (size_t)(of - row);
}

static void read_track(input *in, const aoi_system *system, const double *track, size_t used,
                       size_t *index, size_t rows, double until)
{
    aoi_sampler *sampler = take_sampler(in, system);
    double *exact = take_room(in, used), *record = take_room(in, aoi_record_rows(system));
    double *forces = take_room(in, system->contact_count), *state = take_room(in, 2 * system->first[1]);
    memcpy(exact, track, used * sizeof(double));
    (void)spoil(in, exact, used);
    const aoi_track read = {.values = exact, .row = index, .used = used, .rows = rows};
    if (aoi_track_check(system, &read) != AOI_OK || aoi_sampler_start(sampler, system, &read) != AOI_OK) {
        return;
    }
    (void)aoi_track_slips(system, &read, 0, NULL);
    for (int i = 0; i <= 6; i++) {
        const double time = i < 6 ? until * i / 5.0 : take_any(in);
        aoi_sampler_column(sampler, time, take_byte(in) & 1, record, 1);
        aoi_sampler_forces(sampler, time, forces, 1);
        aoi_sampler_state(sampler, time, 0, state);
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    input in = open_input(data, size);
    aoi_system system;
    if (take_system(&in, 2, &system) == AOI_OK) {
        enum { ROWS = 4 };
        size_t row_size = aoi_adaptive_room(&system), used = 0;
        size_t *index = take_bytes(&in, ROWS, sizeof *index);
        /* A row may name a body more than once, and a contact. */
        row_size += system.contact_count * AOI_TRACK_FRICTION_SIZE;
        for (size_t b = 0; b < system.body_count; b++) {
            row_size += system.body_count * (AOI_TRACK_STATE + 2 * (size_t)MOST_MODES);
        }
        double *track = take_room(&in, ROWS * row_size), time = 0.0;
        const size_t rows = take_between(&in, 1, ROWS);
        for (size_t r = 0; r < rows; r++, time += take_positive(&in)) {
            index[r] = used;
            used += write_row(&in, &system, r == 0, time, track + used);
        }
        if (take_byte(&in) > 250) {
            index[take_below(&in, rows)] += take_byte(&in);
        }
        read_track(&in, &system, track, used, index, rows, time);
    }
    close_input(&in);
    return 0;
}
