/* Sparse symmetric matrices. */
#ifndef AOI_LINEAR_SPARSE_H
#define AOI_LINEAR_SPARSE_H

#include "aoimpact.h"

/* Checks that an aoi_sparse with stored_count entries can be read safely: start rises from 0 to stored_count, and
 * indices lie in 0..n-1. Returns AOI_ERROR_ARGUMENT otherwise. */
int aoi_sparse_check(const aoi_sparse *matrix, size_t stored_count);

/* Sets y to A x; x and y have n doubles and do not overlap. */
void aoi_sparse_multiply(const aoi_sparse *matrix, const double *x, double *y);

/* Returns x^T A x, without work space. */
double aoi_sparse_quadratic(const aoi_sparse *matrix, const double *x);

#endif
