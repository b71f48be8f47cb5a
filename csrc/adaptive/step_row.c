/* Writing of a step's row of the track. */
#include "adaptive/row.h"
#include "adaptive/run.h"
#include "law/law.h"
#include "collocation/collocation.h"
#include "collocation/sliding.h"

#include <string.h>

static size_t write_body(const aoi_adaptive *run, size_t b, double *row)
{
    row[AOI_TRACK_BODY] = (double)b;
    row[AOI_TRACK_BODY_WORK] = run->body[b].work;
    row[AOI_TRACK_BODY_LOST] = run->body[b].dissipated;
    aoi_body_copy(run, b, row + AOI_TRACK_STATE);
    return AOI_TRACK_STATE + 2 * run->system->body[b].n;
}

static void write_contact(const aoi_adaptive_contact *contact, const aoi_contact_step *entry, double *of)
{
    const int ends = contact->event == AOI_EVENT_OPEN || contact->event == AOI_EVENT_SLACKEN;
    of[AOI_TRACK_CONTACT] = (double)entry->contact;
    of[AOI_TRACK_BEGINS] = contact->closed.begins && entry->piece != AOI_SLACK;
    of[AOI_TRACK_ENDS] = ends && entry->piece != AOI_SLACK;
    of[AOI_TRACK_EDGE] = entry->edge;
    of[AOI_TRACK_PIECE] = entry->piece;
    of[AOI_TRACK_WORK] = contact->ledger.work;
    of[AOI_TRACK_LOST] = 0.0;
    of[AOI_TRACK_RATE] = contact->closed.touch_rate;
    of[AOI_TRACK_START_FORCE] = contact->closed.force;
    memcpy(of + AOI_TRACK_MEMORY, contact->memory, sizeof contact->memory);
    memcpy(of + AOI_TRACK_FORCE, entry->force, sizeof entry->force);
    memcpy(of + AOI_TRACK_INDENTATION, entry->legendre, sizeof entry->legendre);
}

/* Writes the friction values of a contact behind its other values, from its three entries at the step's end. */
static void write_friction(aoi_sliding *sliding, const aoi_contact *contact, const aoi_contact_step *entry, double *of)
{
    const int edge = entry->edge != AOI_EDGE_NONE;
    const double *points = aoi_radau_edge_point[entry->edge];
    of[AOI_TRACK_SLIDE_WORK] = sliding->work;
    for (size_t i = 0; i < 2; i++) {
        double *tangent = of + AOI_TRACK_TANGENTS + i * AOI_TRACK_TANGENT_SIZE;
        tangent[AOI_TRACK_TANGENT_START] = entry[1 + i].start_force;
        memcpy(tangent + AOI_TRACK_TANGENT_FORCE, entry[1 + i].force, sizeof entry->force);
        double *stretch = tangent + AOI_TRACK_TANGENT_STRETCH;
        stretch[0] = entry->start_force > 0.0 ? entry[1 + i].start_force / entry->start_force * entry->start : 0.0;
        for (size_t k = 0; k < AOI_NODES; k++) {
            const double pressed = entry->force[k], along = pressed > 0.0 ? entry[1 + i].force[k] / pressed : 0.0;
            stretch[1 + k] = (edge ? sliding->share[i][k] : along) * fmax(entry->indentation[k], 0.0);
        }
        memcpy(tangent + AOI_TRACK_TANGENT_CHANGES, sliding->change_stretch[i], sizeof sliding->change_stretch[i]);
        memcpy(tangent + AOI_TRACK_TANGENT_SLIDE, entry[1 + i].legendre, sizeof entry->legendre);
    }
    of[AOI_TRACK_SLIPS] = sliding->slipped;
    for (size_t i = 0; i < AOI_SLIP_CHANGES; i++) {
        of[AOI_TRACK_CHANGES + i] = i < sliding->changes ? sliding->change_at[i] : 2.0;
    }
    of[AOI_TRACK_DISSIPATED] = sliding->lost;
    of[AOI_TRACK_STUCK] = sliding->stuck;
    for (size_t k = 0; k <= AOI_NODES; k++) {
        const double place = k < AOI_NODES ? points[k] : 1.0;
        sliding->lost = aoi_row_slide_stored(contact, of, place) - sliding->stretched_at[k];
        of[AOI_TRACK_DISSIPATED + 1 + k] = sliding->lost;
        of[AOI_TRACK_STUCK + 1 + k] = sliding->stuck_at[k];
    }
    sliding->stuck = sliding->stuck_at[AOI_NODES];
    sliding->work = aoi_row_slide_work(contact, of, 1.0);
}

size_t aoi_step_write(aoi_adaptive *run, double h, size_t contacts, double *row, double **of)
{
    size_t at = AOI_TRACK_FIXED;
    for (size_t i = 0; contacts > 0 && i < run->engaged.count; i++) {
        if (run->body[run->engaged.at[i]].engaged == AOI_UNDER_FORCE) {
            aoi_body_note_change(run, run->engaged.at[i]);
        }
    }
    const size_t bodies = run->changed.count;
    for (size_t i = 0; i < bodies; i++) {
        at += write_body(run, run->changed.at[i], row + at);
        run->body[run->changed.at[i]].changed = 0;
    }
    run->changed.count = 0;
    *of = row + at;
    size_t written = 0;
    for (size_t s = 0; s < contacts; s += aoi_contact_forces(&run->system->contact[run->entry[s].contact])) {
        const aoi_contact_step *entry = &run->entry[s];
        const aoi_contact *contact = &run->system->contact[entry->contact];
        write_contact(&run->contact[entry->contact], entry, row + at);
        if (entry->sliding) {
            write_friction(entry->sliding, contact, entry, row + at);
        }
        at += aoi_row_contact_size(contact);
        written++;
    }
    row[AOI_TRACK_START] = aoi_run_now(run);
    row[AOI_TRACK_LENGTH] = h;
    row[AOI_TRACK_BODIES] = (double)bodies;
    row[AOI_TRACK_CONTACTS] = (double)written;
    row[AOI_TRACK_SIZE] = (double)at;
    return at;
}
