/* What the integrators ask of a system, beside what everybody may. */
#ifndef AOI_MODEL_SYSTEM_H
#define AOI_MODEL_SYSTEM_H

#include "aoimpact.h"

/* Modes of the body that has most; 1 without bodies. */
size_t aoi_system_most_modes(const aoi_system *system);

/* The residual compliance between the bodies of a joint, m/N. */
double aoi_system_residual(const aoi_system *system, size_t joint);

#endif
