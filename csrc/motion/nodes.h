/* Operations on values at the nodes of a step, in loops of constant length. Matrices are stored by columns, so
 * that compilers vectorise over rows. */
#ifndef AOI_NODES_H
#define AOI_NODES_H

#include "law/law.h"

/* Adds factor * x to y. */
static inline void aoi_nodes_add(double factor, const double *restrict x, double *restrict y)
{
    for (size_t i = 0; i < AOI_NODES; i++) {
        y[i] += factor * x[i];
    }
}

/* Sets y to the product of a matrix, given by its columns, and x; y may be x. */
void aoi_nodes_multiply(const double *column, const double *x, double *y);

/* Sets y to the product of a matrix of AOI_NODES + 1 columns and the values of a polynomial at the start (start)
 * and at the nodes (nodes). */
void aoi_nodes_multiply_from(double start, const double *column, const double *nodes, double *y);

/* Inverts a matrix of AOI_NODES rows, stored by rows or by columns, in place and without pivoting. Its pivots must
 * be near or above 1. */
void aoi_nodes_invert(double *matrix);

static inline double aoi_nodes_dot(const double *x, const double *y)
{
    double even = 0.0, odd = 0.0;
    for (size_t k = 0; k < AOI_NODES; k += 2) {
        even += x[k] * y[k];
        odd += x[k + 1] * y[k + 1];
    }
    return even + odd;
}

/* Returns the largest of `largest` and the values at the nodes. NaN are ignored. */
static inline double aoi_nodes_largest(double largest, const double *values)
{
    for (size_t i = 0; i < AOI_NODES; i++) {
        largest = values[i] > largest ? values[i] : largest;
    }
    return largest;
}

#endif
