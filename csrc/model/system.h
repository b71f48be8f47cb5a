/* Properties of a system for the integrators, beside the public ones. */
#ifndef AOI_MODEL_SYSTEM_H
#define AOI_MODEL_SYSTEM_H

#include "aoimpact.h"

/* True if it is linked, and all bodies are in modes. */
int aoi_system_is_plain(const aoi_system *system);

/* Modes of the body that has most; 1 without bodies. */
size_t aoi_system_most_modes(const aoi_system *system);

/* Number of a contact's forces: 1, or with friction 3. */
static inline size_t aoi_contact_forces(const aoi_contact *contact) { return contact->friction ? 3 : 1; }

/* Number of forces of all contacts of a linked system; true if any has friction. */
static inline size_t aoi_system_forces(const aoi_system *system)
{
    return system->first_force[system->contact_count];
}

static inline int aoi_system_rubs(const aoi_system *system)
{
    return aoi_system_forces(system) > system->contact_count;
}

/* True if any body has a residual compliance. */
int aoi_system_bends(const aoi_system *system);

/* Reduction of the indentation of a contact per unit force of another, or of its own, by residual compliances, m/N. */
double aoi_system_residual(const aoi_system *system, size_t c, size_t by);

/* The largest distance between forces (in the order of contacts) on one body, and within a contact. */
size_t aoi_system_span(const aoi_system *system);

#endif
