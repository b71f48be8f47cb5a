/* Private to adaptive/: what the files of one step share: step.c (the attempt), step_parts.c (who takes
 * part), step_error.c, step_events.c, step_end.c (what is left behind) and step_row.c (the record). */
#ifndef AOI_STEP_H
#define AOI_STEP_H

#include "adaptive/run.h"
#include "law/law.h"
#include "motion/nodes.h"
#include "collocation/collocation.h"

#include <math.h>

/* A contact need not be more exact than this share of the largest beside it. */
static const double LESSER_SHARE = 0.01;

/* A peak between nodes may be so much above the largest force at one. */
static const double NEAR_PEAK = 0.9;

static inline const aoi_law *aoi_step_law(const aoi_adaptive *run, const aoi_contact_step *entry)
{
    return run->system->contact[entry->contact].law;
}

/* The largest indentation, at the start and the nodes. */
static inline double aoi_step_indentation(const aoi_contact_step *entry)
{
    return aoi_nodes_largest(entry->start, entry->indentation);
}

/* What counts as large for a contact: what it has seen, or a small share of what the others have. */
static inline double aoi_step_scale(const aoi_adaptive *run, const aoi_contact_step *entry, double largest)
{
    return fmax(fmax(run->contact[entry->contact].indentation_scale, largest),
                LESSER_SHARE * run->indentation_scale);
}

/* The largest force at the nodes. */
static inline double aoi_step_force(const aoi_contact_step *entry)
{
    return aoi_nodes_largest(0.0, entry->force);
}

/* Whether that may be the largest of the contact so far, at a node or beside it. */
static inline int aoi_step_may_peak(const aoi_adaptive_contact *contact, const aoi_contact_step *entry)
{
    return aoi_step_force(entry) >= NEAR_PEAK * contact->peak_force;
}

/* What counts as large for its force: what it has seen, or a small share of what the others press with. A
 * contact that a wave has only just reached starts like a power of time: beside its own force alone it would
 * look the same in the shortest step. */
static inline double aoi_step_force_scale(const aoi_adaptive *run, const aoi_contact_step *entry, double largest)
{
    return fmax(fmax(run->contact[entry->contact].peak_force, largest), LESSER_SHARE * run->force_scale);
}

static inline void aoi_step_law_at_end(const aoi_law *law, const aoi_contact_step *entry,
                                       aoi_law_value *value)
{
    const int end = AOI_NODES - 1;
    aoi_law_force(law, entry->memory, entry->piece, entry->indentation[end], entry->rate[end], value);
}

/* Whether a residual compliance lies between the bodies of a contact: its velocity changes at once where
 * the force begins or ends. */
static inline int aoi_contact_has_residual(const aoi_adaptive *run, size_t c)
{
    const size_t *body = run->system->contact[c].body;
    return run->system->body[body[0]].residual != NULL || run->system->body[body[1]].residual != NULL;
}

/* Whether work is done on a body, or lost in it, besides that of contacts. */
static inline int aoi_body_has_ledger(const aoi_modes *body)
{
    return body->gravity || body->decay || body->load.count > 0;
}

/* By how much the step could be longer, as far as this contact goes. Sets its Legendre series, and notes
 * the length that an edge allows. */
double aoi_step_growth(aoi_adaptive *run, aoi_contact_step *entry, double h);

/* Notes what happens first to a closed contact. */
void aoi_step_closed_events(aoi_adaptive *run, const aoi_contact_step *entry, aoi_attempt *attempt);

/* Ends a closed contact whose force is rounding. */
void aoi_step_skip(aoi_adaptive *run, const aoi_contact_step *entry, aoi_attempt *attempt);

/* Takes note of what happens to a contact at a place, if that is its first event. */
void aoi_step_note_event(double place, int kind, aoi_adaptive_contact *contact, aoi_attempt *attempt);

/* A contact at rounding from a touch: within so much of it nothing happens. */
double aoi_touch_tolerance(aoi_adaptive *run, const aoi_contact_step *entry);

/* Derivatives at the start, with respect to the share of a step of length h, of the forces on a body's ports: nodes
 * in, as many out; not for a body of which no mode rings in the step. */
void aoi_step_slopes(const aoi_modes *body, const double *force, double h, double *slopes);

/* Where the polynomial begins along which the step's forces, and if asked the loads and gravity, move mode j of a
 * body, and its velocity there. For modes that ring; returns whether anything moves it. */
int aoi_step_path(const aoi_adaptive *run, size_t b, size_t j, double h, int loaded, double *x, double *v);

/* By how much the step could be longer, up to a growth, until what free oscillations about these polynomials make of
 * a closed contact's force, and no step of that length would see, may come to most, N. Below 1: too long as it is. */
double aoi_step_ring_growth(const aoi_adaptive *run, const aoi_contact_step *entry, double h, double growth, double most);

/* The piece of its law that a closed contact is on, or would be if it were not slack. */
int aoi_step_piece(const aoi_law *law, const aoi_contact_step *entry);

/* Whether an open contact beside closed ones touches; closes it where that is at the start. */
void aoi_step_open_events(aoi_adaptive *run, aoi_contact_step *entry, aoi_attempt *attempt);

#endif
