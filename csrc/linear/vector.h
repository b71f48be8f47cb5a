/* Vectors of doubles. */
#ifndef AOI_LINEAR_VECTOR_H
#define AOI_LINEAR_VECTOR_H

#include "aoimpact.h"

/* x^T y of n doubles. */
double aoi_vector_dot(size_t n, const double *x, const double *y);

/* y += factor x, n doubles, not overlapping. */
void aoi_vector_add(size_t n, double factor, const double *x, double *y);

/* True if none of n doubles is infinite or NaN. */
int aoi_vector_is_finite(size_t n, const double *x);

#endif
