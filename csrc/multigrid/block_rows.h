/* Subtracts A x from r, for some rows of a symmetric matrix A of blocks. This file is included once for each
 * precision: REAL is its type, and OF(x) a name of its own. Vectors have aoi_four_width numbers per node, except
 * the vectors that spread reads and gather writes. */
#include "multigrid/four.h"
#include "multigrid/multigrid.h"

#ifndef REAL
#define REAL float
#define OF(x) aoi_single_##x
#endif

static void OF(spread)(const aoi_blocks *matrix, aoi_part part, const REAL *x, REAL *wide)
{
    const size_t b = matrix->size, width = aoi_four_width(b);
    for (size_t row = part.begin; row < part.end; row++) {
        const size_t i = (size_t)matrix->order[row];
        for (size_t k = 0; k < width; k++) {
            wide[width * i + k] = k < b ? x[b * i + k] : 0;
        }
    }
}

static void OF(gather)(const aoi_blocks *matrix, aoi_part part, const REAL *wide, REAL *x)
{
    const size_t b = matrix->size, width = aoi_four_width(b);
    for (size_t row = part.begin; row < part.end; row++) {
        const size_t i = (size_t)matrix->order[row];
        for (size_t k = 0; k < b; k++) {
            x[b * i + k] = wide[width * i + k];
        }
    }
}

/* Subtracts a block times x from r: r_i -= B x_j. */
static inline void OF(along)(size_t b, const REAL *block, const REAL *x, REAL *r)
{
    for (size_t k = 0; k < b; k++) {
        REAL sum = 0;
        for (size_t c = 0; c < b; c++) {
            sum += block[b * k + c] * x[c];
        }
        r[k] -= sum;
    }
}

/* Subtracts a transposed block times x from r: r_j -= B^T x_i. */
static inline void OF(across)(size_t b, const REAL *block, const REAL *x, REAL *r)
{
    for (size_t c = 0; c < b; c++) {
        for (size_t k = 0; k < b; k++) {
            r[k] -= block[b * c + k] * x[c];
        }
    }
}

/* Subtracts the products with the 3 x 3 blocks of a row, except the diagonal block, whose index is `diagonal`.
 * Blocks before the diagonal act on row i alone; blocks after the diagonal also act on column i, transposed. Each
 * row of a block is read together with the number that follows it, which exists because the last block of all is a
 * diagonal one. */
static inline void OF(others_3)(const aoi_blocks *matrix, const REAL *values, size_t row, size_t diagonal,
                                const REAL *x, REAL *r)
{
    const size_t i = (size_t)matrix->order[row];
    const OF(four) x0 = OF(fill)(x[4 * i]), x1 = OF(fill)(x[4 * i + 1]), x2 = OF(fill)(x[4 * i + 2]);
    OF(four) sum[3] = {OF(fill)(0), OF(fill)(0), OF(fill)(0)};
    for (size_t p = (size_t)matrix->start[row]; p < diagonal; p++) {
        const OF(four) part = OF(load)(x + 4 * (size_t)matrix->indices[p]);
        for (size_t k = 0; k < 3; k++) {
            sum[k] = OF(plus)(sum[k], OF(load)(values + 9 * p + 3 * k), part);
        }
    }
    for (size_t p = diagonal + 1; p < (size_t)matrix->start[row + 1]; p++) {
        const size_t j = 4 * (size_t)matrix->indices[p];
        const OF(four) part = OF(load)(x + j), other = OF(load)(r + j);
        const OF(four) b0 = OF(load)(values + 9 * p), b1 = OF(load)(values + 9 * p + 3),
                       b2 = OF(load)(values + 9 * p + 6);
        sum[0] = OF(plus)(sum[0], b0, part);
        sum[1] = OF(plus)(sum[1], b1, part);
        sum[2] = OF(plus)(sum[2], b2, part);
        OF(store)(OF(minus)(OF(minus)(OF(minus)(other, b0, x0), b1, x1), b2, x2), r + j);
    }
    for (size_t k = 0; k < 3; k++) {
        REAL terms[4];
        OF(store)(sum[k], terms);
        r[4 * i + k] -= terms[0] + terms[1] + terms[2];
    }
}

/* Subtracts A_ij x_j from r_i for all stored blocks j of row i, and A_ji x_i from r_j for the blocks after the
 * diagonal. r_i is then complete, since the rows before row i have already subtracted their part. b: block size, a
 * compile-time constant where speed matters. */
static inline void OF(row)(const aoi_blocks *matrix, const REAL *values, size_t b, size_t row,
                           const REAL *x, REAL *r)
{
    const size_t i = (size_t)matrix->order[row], width = aoi_four_width(b);
    size_t diagonal = (size_t)matrix->start[row];
    while ((size_t)matrix->indices[diagonal] != i) {
        diagonal++;
    }
    OF(along)(b, values + b * b * diagonal, x + width * i, r + width * i);
    if (b == 3) {
        OF(others_3)(matrix, values, row, diagonal, x, r);
        return;
    }
    for (size_t p = (size_t)matrix->start[row]; p < diagonal; p++) {
        OF(along)(b, values + b * b * p, x + width * (size_t)matrix->indices[p], r + width * i);
    }
    for (size_t p = diagonal + 1; p < (size_t)matrix->start[row + 1]; p++) {
        const size_t j = (size_t)matrix->indices[p];
        OF(along)(b, values + b * b * p, x + width * j, r + width * i);
        OF(across)(b, values + b * b * p, x + width * i, r + width * j);
    }
}

static void OF(rows)(const aoi_blocks *matrix, aoi_part part, const REAL *values, const REAL *x, REAL *r)
{
    for (size_t row = part.begin; row < part.end; row++) {
        switch (matrix->size) {
        case 3:
            OF(row)(matrix, values, 3, row, x, r);
            break;
        case 6:
            OF(row)(matrix, values, 6, row, x, r);
            break;
        default:
            OF(row)(matrix, values, matrix->size, row, x, r);
        }
    }
}
