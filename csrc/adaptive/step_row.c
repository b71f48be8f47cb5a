/* A step's row of the track. */
#include "adaptive/row.h"
#include "adaptive/run.h"
#include "law/law.h"
#include "collocation/collocation.h"

static size_t write_body(const aoi_adaptive *run, size_t b, double *row)
{
    const size_t n = run->system->body[b].n, first = run->system->first[b];
    row[AOI_TRACK_BODY] = (double)b;
    row[AOI_TRACK_BODY_WORK] = run->body[b].work;
    row[AOI_TRACK_BODY_LOST] = run->body[b].dissipated;
    for (size_t j = 0; j < n; j++) {
        row[AOI_TRACK_STATE + j] = run->x[first + j];
        row[AOI_TRACK_STATE + n + j] = run->v[first + j];
    }
    return AOI_TRACK_STATE + 2 * n;
}

static void write_contact(const aoi_adaptive_contact *contact, const aoi_contact_step *entry, double *of)
{
    const int ends = contact->event == AOI_EVENT_OPEN || contact->event == AOI_EVENT_SLACKEN;
    of[AOI_TRACK_CONTACT] = (double)entry->contact;
    of[AOI_TRACK_BEGINS] = contact->begins && entry->piece != AOI_SLACK;
    of[AOI_TRACK_ENDS] = ends && entry->piece != AOI_SLACK;
    of[AOI_TRACK_EDGE] = entry->edge;
    of[AOI_TRACK_PIECE] = entry->piece;
    of[AOI_TRACK_WORK] = contact->work;
    of[AOI_TRACK_LOST] = 0.0;
    of[AOI_TRACK_RATE] = contact->touch_rate;
    of[AOI_TRACK_START_FORCE] = contact->force;
    for (size_t i = 0; i < AOI_LAW_MEMORY; i++) {
        of[AOI_TRACK_MEMORY + i] = contact->memory[i];
    }
    for (size_t i = 0; i < AOI_NODES; i++) {
        of[AOI_TRACK_FORCE + i] = entry->force[i];
    }
    for (size_t i = 0; i <= AOI_NODES; i++) {
        of[AOI_TRACK_INDENTATION + i] = entry->legendre[i];
    }
}

size_t aoi_step_write(aoi_adaptive *run, double h, size_t contacts, double *row)
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
    for (size_t s = 0; s < contacts; s++, at += AOI_TRACK_CONTACT_SIZE) {
        write_contact(&run->contact[run->entry[s].contact], &run->entry[s], row + at);
    }
    row[AOI_TRACK_START] = aoi_run_now(run);
    row[AOI_TRACK_LENGTH] = h;
    row[AOI_TRACK_BODIES] = (double)bodies;
    row[AOI_TRACK_CONTACTS] = (double)contacts;
    row[AOI_TRACK_SIZE] = (double)at;
    return at;
}
