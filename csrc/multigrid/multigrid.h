/* The inner loops of multigrid: smoothing on small blocks, and aggregation. */
#ifndef AOI_LINEAR_MULTIGRID_H
#define AOI_LINEAR_MULTIGRID_H

#include "aoimpact.h"

/* A symmetric matrix of n x n blocks of size x size numbers, in single precision, which suffices since a solver
 * checks its result in double precision. The rows are divided into parts for threads; order has each row once,
 * part by part, ascending in each part. Row order[k] stores the blocks indices[p], values[size^2 p ...] (by rows)
 * for start[k] <= p < start[k+1]: first the blocks in columns of other parts, then the diagonal block, then the
 * blocks right of the diagonal in its own part. Blocks left of the diagonal in its own part are not stored. The
 * last block of all is a diagonal one. inverse: inverse of the diagonal block of each row, n size^2 values. The
 * work arrays of the functions below have AOI_BLOCKS_WORK n (size + 1) numbers. */
enum { AOI_BLOCKS_WIDEST = 6, AOI_BLOCKS_WORK = 3 };
typedef struct aoi_blocks {
    size_t n, size;
    const int32_t *order, *start, *indices;
    const float *values, *inverse;
} aoi_blocks;

/* A part of the rows, order[begin] ... order[end-1]. The functions below work on one part, in stages: all parts
 * must have finished a stage before any part begins the next, and must get the same arguments in all stages.
 * Within a stage, parts may run in parallel; the result is bit-identical. */
typedef struct aoi_part {
    size_t begin, end;
} aoi_part;

/* Checks that a part of an aoi_blocks with stored_count blocks can be read safely: each row has a diagonal block,
 * behind which it stores only blocks right of the diagonal, and the block size is 1 ... AOI_BLOCKS_WIDEST. The
 * bounds of parts are not checked: with other parts than those that the order was made for, threads write to the
 * same rows and the results are wrong. */
int aoi_blocks_check(const aoi_blocks *matrix, aoi_part part, size_t stored_count);

/* Subtracts A x from r, in two stages, 0 and 1; x and r have n size floats and do not overlap. work: floats. */
void aoi_blocks_subtract(const aoi_blocks *matrix, aoi_part part, int stage, const float *x, float *r,
                         float *work);

/* Sets y to A x in double precision, in two stages, 0 and 1; x and y have n size doubles and do not overlap.
 * values: entries of A in double precision, stored as those of `matrix`, whose values and inverse are not read.
 * work: doubles. */
void aoi_blocks_multiply(const aoi_blocks *matrix, aoi_part part, int stage, const double *values,
                         const double *x, double *y, double *work);

/* Improves x, for which r = f - A x, by Chebyshev steps, in stages 0 ... steps. They damp the eigenvalues of D^-1
 * A from low to high, 0 < low < high < inf, with D the diagonal blocks. finish = 1: r is f - A x after the last
 * stage; finish = 0: r lacks the product of A with the last change of x. work: floats. */
int aoi_blocks_smooth(const aoi_blocks *matrix, aoi_part part, size_t stage, size_t steps, double low,
                      double high, int finish, float *x, float *r, float *work);

/* Aggregates neighbouring nodes of a graph (Vanek, Mandel and Brezina, Computing 56, 1996). A node whose
 * neighbours are all free makes an aggregate with them; each node left over joins a neighbouring aggregate. The
 * edges of node i are indices[p] for start[i] <= p < start[i+1], each edge in both directions; edges are not
 * checked. aggregate: set to the number of each node's aggregate, from 0 on. Returns the number of aggregates. */
size_t aoi_graph_aggregate(size_t n, const int32_t *start, const int32_t *indices,
                           int32_t *aggregate);

#endif
