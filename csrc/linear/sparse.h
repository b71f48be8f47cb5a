/* Sparse symmetric matrices. */
#ifndef AOI_LINEAR_SPARSE_H
#define AOI_LINEAR_SPARSE_H

#include "aoimpact.h"

/* Checks that an aoi_sparse of stored_count entries can be read safely: start rises from 0 to
 * stored_count, indices lie in 0..n-1. AOI_ERROR_ARGUMENT where they do not. */
int aoi_sparse_check(const aoi_sparse *matrix, size_t stored_count);

/* y = A x; x and y of n doubles, not overlapping. */
void aoi_sparse_multiply(const aoi_sparse *matrix, const double *x, double *y);

/* x^T A x without work space. */
double aoi_sparse_quadratic(const aoi_sparse *matrix, const double *x);

#endif
