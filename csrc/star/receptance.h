/* The receptance of a body in modes. */
#ifndef AOI_STAR_RECEPTANCE_H
#define AOI_STAR_RECEPTANCE_H

#include "aoimpact.h"

/* u/f at a port, as real and imaginary part, for count angular frequencies: sum_j weight_j / (omega_j^2
 * - w^2 + 2 i decay_j w) + residual; weight_j = participation_j^2. */
void aoi_modal_receptance(size_t n, const double *omega, const double *decay, const double *weight,
                          double residual, size_t count, const double *frequency, double *real,
                          double *imaginary);

#endif
