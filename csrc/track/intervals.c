/* Contact intervals and phases of slip, from the rows of a track. */
#include "linear/vector.h"
#include "law/law.h"
#include "motion/polynomial.h"
#include "motion/radau.h"
#include "collocation/collocation.h"
#include "adaptive/row.h"

#include <math.h>

/* Least end of a contact's last row, as a share of the end of the record, for which the contact counts as lasting
 * to that end. */
static const double RECORD_END = 1.0 - 1e-14;

/* The intervals found so far, and for each contact its interval that has not ended (lasts = 1), whose end is the
 * end of the contact's last row so far. */
typedef struct search {
    double end;
    aoi_interval *open;
    size_t count, capacity;
    aoi_interval *interval;
} search;

static void close_interval(search *found, aoi_interval *open, double end, int lasts)
{
    open->lasts = 0;
    if (open->start >= found->end) {
        return;
    }
    open->end = end;
    open->pace = open->deepest > 0.0 ? open->rate * (end - open->start) / open->deepest : 0.0;
    if (found->count < found->capacity) {
        found->interval[found->count] = *open;
        found->interval[found->count].lasts = lasts;
    }
    found->count++;
}

static void begin_interval(const double *row, const double *of, aoi_interval *open)
{
    *open = (aoi_interval){.contact = (size_t)of[AOI_TRACK_CONTACT], .start = row[AOI_TRACK_START]};
    open->rate = of[AOI_TRACK_RATE];
    open->lasts = 1;
}

/* Returns the time at which the indentation falls to the law's rest in the last row of a contact, s. The row ends
 * where the indentation is below rest by up to the tolerance of events, which can be much later if bodies separate
 * slowly. */
static double time_of_rest(const aoi_system *system, const double *row, const double *of)
{
    const aoi_law *law = system->contact[(size_t)of[AOI_TRACK_CONTACT]].law;
    const double *series = of + AOI_TRACK_INDENTATION, length = row[AOI_TRACK_LENGTH];
    double slope;
    const double below = aoi_legendre_evaluate(AOI_NODES + 1, series, 1.0, &slope) -
                         aoi_law_rest(law, of + AOI_TRACK_MEMORY);
    const double ago = below < 0.0 && below > slope ? below / slope : 0.0;
    return row[AOI_TRACK_START] + length - ago * length;
}

/* Updates the interval of a contact by one row. If a contact begins or is slack in this row, its interval so far
 * has ended with its previous row. */
static void follow_contact(search *found, const aoi_system *system, const double *row, const double *of)
{
    aoi_interval *open = &found->open[(size_t)of[AOI_TRACK_CONTACT]];
    const int slack = of[AOI_TRACK_PIECE] == AOI_SLACK, begins = of[AOI_TRACK_BEGINS] != 0.0;
    double slope;
    if ((slack || begins) && open->lasts) {
        close_interval(found, open, open->end, 0);
    }
    if (slack) {
        return;
    }
    if (begins) {
        begin_interval(row, of, open);
    }
    open->deepest = fmax(open->deepest, aoi_legendre_evaluate(AOI_NODES + 1, of + AOI_TRACK_INDENTATION, 1.0,
                                                              &slope));
    open->impulse += row[AOI_TRACK_LENGTH] *
                     aoi_vector_dot(AOI_NODES, aoi_radau_to_legendre[0], of + AOI_TRACK_FORCE);
    open->end = row[AOI_TRACK_START] + row[AOI_TRACK_LENGTH];
    if (of[AOI_TRACK_ENDS] != 0.0) { /* the force ends, although bodies may overlap for longer */
        close_interval(found, open, time_of_rest(system, row, of), 0);
    }
}

/* Returns the first contact of a row, whose values follow those of the bodies. */
static const double *first_contact(const aoi_system *system, const double *row)
{
    const double *of = row + AOI_TRACK_FIXED;
    for (size_t i = 0; i < (size_t)row[AOI_TRACK_BODIES]; i++) {
        of += AOI_TRACK_STATE + 2 * system->body[(size_t)of[AOI_TRACK_BODY]].n;
    }
    return of;
}

size_t aoi_track_intervals(const aoi_system *system, const aoi_track *track, double end,
                           aoi_interval *work, size_t capacity, aoi_interval *interval)
{
    search found = {end, work, 0, capacity, interval};
    for (size_t c = 0; c < system->contact_count; c++) {
        work[c] = (aoi_interval){.contact = c};
    }
    for (size_t r = 0; r < track->rows; r++) {
        const double *row = track->values + track->row[r], *of = first_contact(system, row);
        for (size_t i = 0; i < (size_t)row[AOI_TRACK_CONTACTS]; i++) {
            follow_contact(&found, system, row, of);
            of += aoi_row_contact_size(&system->contact[(size_t)of[AOI_TRACK_CONTACT]]);
        }
    }
    for (size_t c = 0; c < system->contact_count; c++) {
        const int lasts = work[c].end >= end * RECORD_END;
        if (work[c].lasts) {
            close_interval(&found, &work[c], lasts ? end : work[c].end, lasts);
        }
    }
    return found.count;
}

size_t aoi_track_slips(const aoi_system *system, const aoi_track *track, size_t capacity, aoi_slip *slip)
{
    size_t count = 0;
    for (size_t r = 0; r < track->rows; r++) {
        const double *row = track->values + track->row[r], *of = first_contact(system, row);
        for (size_t i = 0; i < (size_t)row[AOI_TRACK_CONTACTS]; i++) {
            const aoi_contact *contact = &system->contact[(size_t)of[AOI_TRACK_CONTACT]];
            aoi_slip here = {(size_t)of[AOI_TRACK_CONTACT], row[AOI_TRACK_START], 0};
            for (size_t k = 0; contact->friction && k <= AOI_SLIP_CHANGES; k++) {
                const double place = k > 0 ? of[AOI_TRACK_CHANGES + k - 1] : 0.0;
                if (!(place <= 1.0)) {
                    break;
                }
                here.slips = k > 0 ? !here.slips : of[AOI_TRACK_SLIPS] != 0.0;
                here.time = row[AOI_TRACK_START] + place * row[AOI_TRACK_LENGTH];
                if (count < capacity) {
                    slip[count] = here;
                }
                count++;
            }
            of += aoi_row_contact_size(contact);
        }
    }
    return count;
}
