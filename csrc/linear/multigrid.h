/* The inner loops of multigrid: smoothing on small blocks, and aggregation. */
#ifndef AOI_LINEAR_MULTIGRID_H
#define AOI_LINEAR_MULTIGRID_H

#include "aoimpact.h"

/* A symmetric matrix of n x n blocks of size x size, in single precision: it only ever helps a solver
 * that checks in double. Row i has the blocks indices[p], values[size^2 p ...] (by rows) for
 * start[i] <= p < start[i+1]: the diagonal one first, then those right of it; those left of it are
 * not stored. inverse: of each diagonal block, n size^2 values. As work the functions below want
 * AOI_BLOCKS_WORK n (size + 1) numbers. */
enum { AOI_BLOCKS_WIDEST = 6, AOI_BLOCKS_WORK = 3 };
typedef struct aoi_blocks {
    size_t n, size;
    const int32_t *start, *indices;
    const float *values, *inverse;
} aoi_blocks;

/* Checks that an aoi_blocks of stored_count blocks can be read safely, has the diagonal first in
 * each row, and is of a size that is dealt with (1 ... AOI_BLOCKS_WIDEST). */
int aoi_blocks_check(const aoi_blocks *matrix, size_t stored_count);

/* r -= A x; x and r of n size floats, not overlapping. work: floats. */
void aoi_blocks_subtract(const aoi_blocks *matrix, const float *x, float *r, float *work);

/* y = A x in double precision, with A's entries by `values`, stored as the matrix's own; x and y of n
 * size doubles, not overlapping. The matrix's values and inverse are not looked at. work: doubles. */
void aoi_blocks_multiply(const aoi_blocks *matrix, const double *values, const double *x, double *y,
                         double *work);

/* Improves x, for which r = f - A x, by Chebyshev steps that damp the eigenvalues of D^-1 A from low
 * to high, 0 < low < high < inf, with D the diagonal blocks. With finish, r is f - A x again on return;
 * without, it is one product with A behind. work: floats. */
int aoi_blocks_smooth(const aoi_blocks *matrix, size_t steps, double low, double high, int finish,
                      float *x, float *r, float *work);

/* Puts neighbouring nodes of a graph together (Vanek, Mandel and Brezina, Computing 56, 1996): nodes
 * whose neighbours are all still free make an aggregate with them, those left over join one beside
 * them. The graph has the edges indices[p] of node i for start[i] <= p < start[i+1], each in both
 * directions, which must be sound. aggregate: n numbers out, from 0 on. Returns how many there are. */
size_t aoi_graph_aggregate(size_t n, const int32_t *start, const int32_t *indices,
                           int32_t *aggregate);

#endif
