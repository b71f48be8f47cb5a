/* Private to adaptive/: declarations that the files of one step share: step.c (the trial step), step_parts.c (its
 * bodies and contacts), step_error.c, step_events.c, step_end.c (the state at the end) and step_row.c (the row). */
#ifndef AOI_STEP_H
#define AOI_STEP_H

#include "adaptive/run.h"
#include "law/law.h"
#include "motion/nodes.h"
#include "collocation/collocation.h"

#include <math.h>

/* Least ratio of the scales of a contact to the largest ones of the other closed contacts: no higher accuracy is
 * promised for small contacts (aoimpact/integrate/settings.py). */
static const double LESSER_SHARE = 0.01;

/* Least ratio of the largest force at a node to a possible peak between nodes. Measured: from 0.7 to 0.97 work
 * changes by 0.3 %. */
static const double NEAR_PEAK = 0.9;

static inline const aoi_law *aoi_step_law(const aoi_adaptive *run, const aoi_contact_step *entry)
{
    return run->system->contact[entry->contact].law;
}

/* Largest indentation of an entry, at the start and the nodes of the step. */
static inline double aoi_step_indentation(const aoi_contact_step *entry)
{
    return aoi_nodes_largest(entry->start, entry->indentation);
}

/* Indentation scale of a contact: its largest so far, or a small share of the other contacts' scale. */
static inline double aoi_step_scale(const aoi_adaptive *run, const aoi_contact_step *entry, double largest)
{
    return fmax(fmax(run->contact[entry->contact].scales.indentation, largest),
                LESSER_SHARE * run->indentation_scale);
}

/* Largest force of an entry at the nodes of the step. */
static inline double aoi_step_force(const aoi_contact_step *entry)
{
    return aoi_nodes_largest(0.0, entry->force);
}

/* True if the step's largest force, at a node or beside it, may be the contact's largest so far. */
static inline int aoi_step_may_peak(const aoi_adaptive_contact *contact, const aoi_contact_step *entry)
{
    return aoi_step_force(entry) >= NEAR_PEAK * contact->ledger.peak.force;
}

/* Force scale of a contact: its largest force so far, or expected at its touch, or a small share of the other contacts'
 * scale. A contact that a wave or a load has just reached has a force that starts like a power of time: relative to its
 * own force alone, its error would be the same in the shortest step. */
static inline double aoi_step_force_scale(const aoi_adaptive *run, const aoi_contact_step *entry, double largest)
{
    const aoi_adaptive_contact *contact = &run->contact[entry->contact];
    return fmax(fmax(contact->ledger.peak.force, contact->scales.force), fmax(largest, LESSER_SHARE * run->force_scale));
}

static inline void aoi_step_law_at_end(const aoi_law *law, const aoi_contact_step *entry,
                                       aoi_law_value *value)
{
    const int end = AOI_NODES - 1;
    aoi_law_force(law, entry->memory, entry->piece, entry->indentation[end], entry->rate[end], value);
}

/* True if a residual compliance lies between the bodies of a contact: the rate of its indentation changes at once
 * where the force begins or ends. */
static inline int aoi_contact_has_residual(const aoi_adaptive *run, size_t c)
{
    const size_t *body = run->system->contact[c].body;
    return run->system->body[body[0]].residual != NULL || run->system->body[body[1]].residual != NULL;
}

/* True if gravity or loads do work on a body, or damping dissipates energy in it. */
static inline int aoi_body_has_ledger(const aoi_modes *body)
{
    return body->gravity || body->decay || body->load.count > 0;
}

/* Factor by which the error of this contact would allow the step to be longer. Sets its Legendre series, and notes the
 * length that an edge allows. */
double aoi_step_growth(aoi_adaptive *run, aoi_contact_step *entry, double h);

/* Notes the first event of a closed contact. */
void aoi_step_closed_events(aoi_adaptive *run, const aoi_contact_step *entry, aoi_attempt *attempt);

/* Opens a closed contact whose force is below rounding. */
void aoi_step_skip(aoi_adaptive *run, const aoi_contact_step *entry, aoi_attempt *attempt);

/* Notes an event of a contact at a place of the step, if it is the contact's first. */
void aoi_step_note_event(double place, int kind, aoi_adaptive_contact *contact, aoi_attempt *attempt);

/* Tolerance of the indentation at which a contact touches, not below rounding, m. */
double aoi_touch_tolerance(aoi_adaptive *run, const aoi_contact_step *entry);

/* Legendre coefficients of the forces on a body's ports in a step of length h, given at the nodes; left unset for a
 * body without a mode that rings in the step. */
void aoi_step_series(const aoi_modes *body, const double *force, double h, double *series);

/* Initial value and velocity of the polynomial motion of mode j of a body under the step's forces and, if loaded,
 * under loads and gravity. For oscillating modes; returns whether any of these forces acts on the mode. */
int aoi_step_path(const aoi_adaptive *run, size_t b, size_t j, double h, int loaded, double *x, double *v);

/* Factor, at most `growth`, by which the step could be longer while unresolved free oscillations about the modes'
 * polynomial motions change a closed contact's force by at most `most`, N. Below 1 the step itself is too long. */
double aoi_step_ring_growth(const aoi_adaptive *run, const aoi_contact_step *entry, double h, double growth,
                            double most);

/* The piece of the law at the start of the step. For a slack contact: the piece for its indentation and rate. */
int aoi_step_piece(const aoi_law *law, const aoi_contact_step *entry);

/* Notes where in the step an open contact of a body under force touches; closes the contact if it touches at the
 * start. */
void aoi_step_open_events(aoi_adaptive *run, aoi_contact_step *entry, aoi_attempt *attempt);

#endif
