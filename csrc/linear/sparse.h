/* Sparse symmetric matrices, linear solvers as the core sees them, and factors. */
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

/* Factors of a symmetric positive definite matrix, P A P^T = L D L^T: L unit lower triangular by
 * compressed columns WITHOUT its diagonal, rows of a column ascending; D the n pivots, all
 * positive; row i of A is row place[i] of P A P^T. Columns of like pattern stand in panels, which
 * are swept together: panel p is columns panel[p] .. panel[p+1]-1, panel[panel_count] = n. work: n
 * doubles. An aoi_factors is one thread's. pause: or NULL. */
typedef struct aoi_factors {
    size_t n;
    const int32_t *start, *rows;
    const double *values, *pivots;
    const int32_t *place;
    const int32_t *panel;
    size_t panel_count;
    double *work;
    const aoi_pause *pause;
} aoi_factors;

/* Finds the widest panels: runs of columns of which each has the rows of the next, and the next
 * itself. panel: room for n+1 in, panel_count+1 out. The indices must be sound. */
size_t aoi_factors_find_panels(size_t n, const int32_t *start, const int32_t *rows, int32_t *panel);

/* Checks indices, places and panels, and that the pivots are positive (AOI_ERROR_NOT_POSITIVE: A was
 * not definite). Overwrites work. */
int aoi_factors_check(const aoi_factors *factors, size_t stored_count);

/* x <- A^-1 x by two triangular sweeps; data is an aoi_factors: it fits aoi_solver.solve. */
int aoi_factors_solve(void *data, double *x);

#endif
