/* Private to adaptive/: declarations shared by the files that compute a step: step.c (the trial step),
 * step_parts.c (its bodies and contacts), step_error.c, step_events.c, step_end.c (the state at the end) and
 * step_row.c (the row). */
#ifndef AOI_STEP_H
#define AOI_STEP_H

#include "adaptive/run.h"
#include "law/law.h"
#include "motion/nodes.h"
#include "collocation/collocation.h"

#include <math.h>

/* Least scale of a contact, as a share of the largest scale of the other closed contacts: no higher accuracy is
 * promised for small contacts (aoimpact/integrate/settings.py). */
static const double LESSER_SHARE = 0.01;

/* A step may contain a contact's peak force if its largest force at a node is at least this share of the contact's
 * largest force so far. Measured: from 0.7 to 0.97 work changes by 0.3 %. */
static const double NEAR_PEAK = 0.9;

static inline const aoi_law *aoi_step_law(const aoi_adaptive *run, const aoi_contact_step *entry)
{
    return run->system->contact[entry->contact].law;
}

/* Returns the largest indentation (or slide) of an entry at the start and the nodes of the step, m. */
static inline double aoi_step_indentation(const aoi_contact_step *entry)
{
    return aoi_nodes_largest(entry->start, entry->indentation);
}

/* Returns the indentation scale of a contact, m: the largest of its indentation so far, `largest`, and
 * LESSER_SHARE times the largest scale of the closed contacts. */
static inline double aoi_step_scale(const aoi_adaptive *run, const aoi_contact_step *entry, double largest)
{
    return fmax(fmax(run->contact[entry->contact].scales.indentation, largest),
                LESSER_SHARE * run->indentation_scale);
}

/* Returns the largest force of an entry at the nodes of the step, N. */
static inline double aoi_step_force(const aoi_contact_step *entry)
{
    return aoi_nodes_largest(0.0, entry->force);
}

/* True if the contact's peak force may lie in this step, at a node or between two nodes. */
static inline int aoi_step_may_peak(const aoi_adaptive_contact *contact, const aoi_contact_step *entry)
{
    return aoi_step_force(entry) >= NEAR_PEAK * contact->ledger.peak.force;
}

/* Returns the force scale of a contact, N: the largest of its force so far, the force expected at its touch,
 * `largest`, and LESSER_SHARE times the largest force of the closed contacts. LESSER_SHARE matters where a wave or
 * a load has just reached the contact: its force starts like a power of time, and an error relative to this force
 * alone would not decrease with the step length. */
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

/* True if one of a contact's bodies has a residual compliance. Then the rate of the indentation jumps where the
 * force begins or ends. */
static inline int aoi_contact_has_residual(const aoi_adaptive *run, size_t c)
{
    const size_t *body = run->system->contact[c].body;
    return run->system->body[body[0]].residual != NULL || run->system->body[body[1]].residual != NULL;
}

/* True if work or dissipation must be recorded for a body: gravity or loads act on it, or it has damping. */
static inline int aoi_body_has_ledger(const aoi_modes *body)
{
    return body->gravity || body->decay || body->load.count > 0;
}

/* Returns the factor by which the errors of this contact would allow the step to be longer. Sets the entry's
 * Legendre series and, in a step with an edge, closed.edge, the length that its error allows the contact's last
 * step. */
double aoi_step_growth(aoi_adaptive *run, aoi_contact_step *entry, double h);

/* Finds the events of a closed contact in the step, and notes the first one. */
void aoi_step_closed_events(aoi_adaptive *run, const aoi_contact_step *entry, aoi_attempt *attempt);

/* Opens a closed contact whose force is negligible. */
void aoi_step_skip(aoi_adaptive *run, const aoi_contact_step *entry, aoi_attempt *attempt);

/* Notes an event of a contact at a position of the step (place), unless an earlier one of this contact is noted. */
void aoi_step_note_event(double place, int kind, aoi_adaptive_contact *contact, aoi_attempt *attempt);

/* Returns the tolerance of the indentation at which a contact touches, at least its rounding error, m. */
double aoi_touch_tolerance(aoi_adaptive *run, const aoi_contact_step *entry);

/* Sets `series` to the Legendre coefficients of the forces on a body's ports in a step of length h, given at the
 * nodes. For a body without modes that are fast in this step (AOI_PATH_FAST), nothing is set. */
void aoi_step_series(const aoi_modes *body, const double *force, double h, double *series);

/* Finds the initial value x and velocity v of the polynomial particular motion of mode j of a body under the
 * step's forces and, if `loaded`, under loads and gravity. Only for oscillating modes. Returns whether any of
 * these forces acts on the mode. */
int aoi_step_path(const aoi_adaptive *run, size_t b, size_t j, double h, int loaded, double *x, double *v);

/* Returns the factor, at most `growth`, by which the step could be longer while free oscillations that the nodes
 * do not resolve change a closed contact's force by at most `most`, N. A factor below 1 means that the step itself
 * is too long. */
double aoi_step_ring_growth(const aoi_adaptive *run, const aoi_contact_step *entry, double h, double growth,
                            double most);

/* Returns the piece of the law at the start of the step; for a slack contact, the piece for its indentation and
 * rate. */
int aoi_step_piece(const aoi_law *law, const aoi_contact_step *entry);

/* Notes where in the step an open contact of a body under force touches. If it touches at the start, the contact
 * is closed. */
void aoi_step_open_events(aoi_adaptive *run, aoi_contact_step *entry, aoi_attempt *attempt);

#endif
