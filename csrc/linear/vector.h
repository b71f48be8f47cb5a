/* Vectors of doubles. */
#ifndef AOI_LINEAR_VECTOR_H
#define AOI_LINEAR_VECTOR_H

#include "aoimpact.h"

/* x^T y of n doubles. */
double aoi_vector_dot(size_t n, const double *x, const double *y);

/* Sum of weight (factor x)^2; weight and factor may be NULL, for ones. */
double aoi_vector_squares(size_t n, const double *weight, const double *factor, const double *x);

/* y += factor x, n doubles, not overlapping. */
void aoi_vector_add(size_t n, double factor, const double *x, double *y);

/* True if none of n doubles is infinite or NaN. */
int aoi_vector_is_finite(size_t n, const double *x);

/* Copies n doubles, or zeros where from is NULL; true if all are finite. */
int aoi_vector_take(size_t n, const double *from, double *to);

/* Gauss's elimination without pivoting of an n x n matrix by rows of 2 band + 1 doubles, row i with the columns i - band ..
 * i + band: leaves factors left of the diagonal, and the inverse pivots on it. True if all pivots are positive numbers. */
int aoi_band_factorise(size_t n, size_t band, double *matrix);

/* Replaces the right-hand side x by the solution, with a matrix factorised as above. */
void aoi_band_substitute(size_t n, size_t band, const double *matrix, double *x);

#endif
