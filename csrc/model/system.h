/* Properties of a system for the integrators, beside the public ones. */
#ifndef AOI_MODEL_SYSTEM_H
#define AOI_MODEL_SYSTEM_H

#include "aoimpact.h"

/* Whether it is linked, and all bodies are in modes. */
int aoi_system_is_modal(const aoi_system *system);

/* Modes of the body that has most; 1 without bodies. */
size_t aoi_system_most_modes(const aoi_system *system);

/* Reduction of the indentation of a contact per unit force of another, or of its own, by residual compliances, m/N. */
double aoi_system_residual(const aoi_system *system, size_t c, size_t by);

/* The largest distance between contacts (in their order) that share a body. */
size_t aoi_system_span(const aoi_system *system);

#endif
