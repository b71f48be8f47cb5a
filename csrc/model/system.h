/* Properties of a system that the integrators need, in addition to the public ones. */
#ifndef AOI_MODEL_SYSTEM_H
#define AOI_MODEL_SYSTEM_H

#include "aoimpact.h"

/* True if a system is linked and no body is given by matrices. */
int aoi_system_is_plain(const aoi_system *system);

/* Returns the largest number of modes of a body; at least 1. */
size_t aoi_system_most_modes(const aoi_system *system);

/* Returns the number of a contact's forces: 1, or 3 with friction. */
static inline size_t aoi_contact_forces(const aoi_contact *contact) { return contact->friction ? 3 : 1; }

/* Returns the number of forces of all contacts of a linked system. */
static inline size_t aoi_system_forces(const aoi_system *system)
{
    return system->first_force[system->contact_count];
}

/* True if any contact of a linked system has friction. */
static inline int aoi_system_rubs(const aoi_system *system)
{
    return aoi_system_forces(system) > system->contact_count;
}

/* True if any body has a residual compliance. */
int aoi_system_bends(const aoi_system *system);

/* Returns the reduction of the indentation of contact c due to residual compliances, per unit force of the contact
 * `by`, m/N. */
double aoi_system_residual(const aoi_system *system, size_t c, size_t by);

/* Returns the half bandwidth of the contact equations: the largest difference between the indices of two forces on
 * one body or of one contact. */
size_t aoi_system_span(const aoi_system *system);

#endif
