/* The inner loops of multigrid: smoothing on small blocks, and aggregation. */
#ifndef AOI_LINEAR_MULTIGRID_H
#define AOI_LINEAR_MULTIGRID_H

#include "aoimpact.h"

/* A symmetric matrix of n x n blocks of size x size, in single precision: it only ever helps a solver
 * that checks in double. Its rows come in parts, which threads share out; order has each row once, part
 * by part, ascending in each. Row order[k] has the blocks indices[p], values[size^2 p ...] (by rows)
 * for start[k] <= p < start[k+1]: those in columns of other parts, the diagonal one, then those right
 * of it in its own part. Of its own part those left of the diagonal are not stored. The last block of
 * all is a diagonal one. inverse: of the diagonal block of each row, n size^2 values. The work
 * arrays of the functions below hold AOI_BLOCKS_WORK n (size + 1) numbers. */
enum { AOI_BLOCKS_WIDEST = 6, AOI_BLOCKS_WORK = 3 };
typedef struct aoi_blocks {
    size_t n, size;
    const int32_t *order, *start, *indices;
    const float *values, *inverse;
} aoi_blocks;

/* A part of the rows, order[begin] ... order[end-1]. The functions below work on one part, in stages: every part
 * must have ended a stage before any part begins the next, and must get the same arguments in all stages. Within a
 * stage, parts may run in parallel; the result is bit-identical. */
typedef struct aoi_part {
    size_t begin, end;
} aoi_part;

/* Checks that a part of an aoi_blocks of stored_count blocks can be read safely, that each row has a diagonal block
 * and no block left of it stored behind, and that the block size is 1 ... AOI_BLOCKS_WIDEST. The bounds of parts are
 * not checked: with parts other than those that the order was made for, threads write to the same rows and the
 * results are wrong. */
int aoi_blocks_check(const aoi_blocks *matrix, aoi_part part, size_t stored_count);

/* r -= A x, in stages 0 and 1; x and r of n size floats, not overlapping. work: floats. */
void aoi_blocks_subtract(const aoi_blocks *matrix, aoi_part part, int stage, const float *x, float *r,
                         float *work);

/* y = A x in double precision, in stages 0 and 1, with x and y of n size doubles, not overlapping. values: the
 * entries of A, stored as those of `matrix`, whose values and inverse are not read. work: doubles. */
void aoi_blocks_multiply(const aoi_blocks *matrix, aoi_part part, int stage, const double *values,
                         const double *x, double *y, double *work);

/* Improves x, for which r = f - A x, by Chebyshev steps that damp the eigenvalues of D^-1 A from low to high, 0 <
 * low < high < inf, with D the diagonal blocks; in stages 0 ... steps. finish = 1: r is f - A x after the last
 * stage; 0: r lacks the product of A with the last change of x. work: floats. */
int aoi_blocks_smooth(const aoi_blocks *matrix, aoi_part part, size_t stage, size_t steps, double low,
                      double high, int finish, float *x, float *r, float *work);

/* Aggregates neighbouring nodes of a graph (Vanek, Mandel and Brezina, Computing 56, 1996): nodes whose neighbours
 * are all still free make an aggregate with them; the nodes left over join an aggregate beside them. The graph has
 * the edges indices[p] of node i for start[i] <= p < start[i+1], each in both directions; edges are not checked.
 * aggregate: set to the number of each node's aggregate, from 0 on. Returns the number of aggregates. */
size_t aoi_graph_aggregate(size_t n, const int32_t *start, const int32_t *indices,
                           int32_t *aggregate);

#endif
