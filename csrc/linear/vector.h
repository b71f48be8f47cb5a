/* Vectors of doubles. */
#ifndef AOI_LINEAR_VECTOR_H
#define AOI_LINEAR_VECTOR_H

#include "aoimpact.h"

/* Returns x^T y, for vectors of n doubles. */
double aoi_vector_dot(size_t n, const double *x, const double *y);

/* Returns the sum of weight (factor x)^2 over n components; weight and factor may be NULL, for ones. */
double aoi_vector_squares(size_t n, const double *weight, const double *factor, const double *x);

/* Adds factor * x to y; both have n doubles and do not overlap. */
void aoi_vector_add(size_t n, double factor, const double *x, double *y);

/* True if none of n doubles is infinite or NaN. */
int aoi_vector_is_finite(size_t n, const double *x);

/* Copies n doubles, or zeros if from is NULL. Returns whether all are finite. */
int aoi_vector_take(size_t n, const double *from, double *to);

/* Factorises an n x n band matrix by Gaussian elimination without pivoting. Row i has 2 band + 1 doubles, the
 * columns i - band .. i + band. The factors replace the elements left of the diagonal, and the inverse pivots
 * replace the diagonal. Returns whether all pivots are positive numbers. */
int aoi_band_factorise(size_t n, size_t band, double *matrix);

/* Replaces the right-hand side x by the solution, for a matrix factorised by aoi_band_factorise. */
void aoi_band_substitute(size_t n, size_t band, const double *matrix, double *x);

#endif
