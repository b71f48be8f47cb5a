/* Smoothing in multigrid: Chebyshev steps on a matrix of small blocks, preconditioned by its diagonal blocks (Saad,
 * Iterative Methods for Sparse Linear Systems, 2nd ed., algorithm 12.1; Adams, Brezina, Hu and Tuminaro, J. Comput.
 * Phys. 188, 2003). Most of the time is spent reading the matrix from memory: hence single precision, mostly one
 * triangle only, and several threads. */
#include "multigrid/four.h"
#include "multigrid/multigrid.h"
#include "linear/sparse.h"

#include <math.h>
#include <string.h>

#define REAL float
#define OF(x) aoi_single_##x
#include "multigrid/block_rows.h"
#undef REAL
#undef OF
#define REAL double
#define OF(x) aoi_exact_##x
#include "multigrid/block_rows.h"

/* Returns the index of a row's diagonal block, or stored_count if the row is invalid. */
static size_t find_diagonal(const aoi_blocks *matrix, size_t row, size_t stored_count)
{
    const int32_t i = matrix->order[row], n = (int32_t)matrix->n, *indices = matrix->indices;
    int32_t p = matrix->start[row];
    const int32_t end = matrix->start[row + 1];
    int wrong = i < 0 || i >= n || p < 0 || (size_t)end > stored_count;
    for (; !wrong && p < end && indices[p] != i; p++) {
        wrong = indices[p] < 0 || indices[p] >= n;
    }
    if (wrong || p >= end) {
        return stored_count;
    }
    for (int32_t q = p + 1; q < end; q++) {
        wrong |= (indices[q] <= i) | (indices[q] >= n);
    }
    return wrong ? stored_count : (size_t)p;
}

int aoi_blocks_check(const aoi_blocks *matrix, aoi_part part, size_t stored_count)
{
    if (matrix->size < 1 || matrix->size > AOI_BLOCKS_WIDEST || part.begin > part.end ||
        part.end > matrix->n) {
        return AOI_ERROR_ARGUMENT;
    }
    for (size_t row = part.begin; row < part.end; row++) {
        const size_t diagonal = find_diagonal(matrix, row, stored_count);
        if (diagonal == stored_count || (row + 1 == matrix->n && diagonal + 1 != stored_count)) {
            return AOI_ERROR_ARGUMENT;
        }
    }
    return AOI_OK;
}

void aoi_blocks_subtract(const aoi_blocks *matrix, aoi_part part, int stage, const float *x, float *r,
                         float *work)
{
    float *wide = work + aoi_four_width(matrix->size) * matrix->n;
    if (stage == 0) {
        aoi_single_spread(matrix, part, r, work);
        aoi_single_spread(matrix, part, x, wide);
    } else {
        aoi_single_rows(matrix, part, matrix->values, wide, work);
        aoi_single_gather(matrix, part, work, r);
    }
}

/* Changes the sign of y in a part of the rows. */
static void negate(const aoi_blocks *matrix, aoi_part part, double *y)
{
    for (size_t row = part.begin; row < part.end; row++) {
        double *of = y + matrix->size * (size_t)matrix->order[row];
        for (size_t k = 0; k < matrix->size; k++) {
            of[k] = -of[k];
        }
    }
}

void aoi_blocks_multiply(const aoi_blocks *matrix, aoi_part part, int stage, const double *values,
                         const double *x, double *y, double *work)
{
    double *wide = work + aoi_four_width(matrix->size) * matrix->n;
    if (stage == 0) {
        aoi_exact_spread(matrix, part, x, wide);
        return;
    }
    for (size_t row = part.begin; row < part.end; row++) {
        const size_t width = aoi_four_width(matrix->size);
        memset(work + width * (size_t)matrix->order[row], 0, width * sizeof *work);
    }
    aoi_exact_rows(matrix, part, values, wide, work);
    aoi_exact_gather(matrix, part, work, y);
    negate(matrix, part, y);
}

/* A Chebyshev step: next = keep d + add D^-1 (r - A d) and x += next, where r is replaced by r - A d. The d of
 * other rows is read, so that next must be another vector. One pass through A suffices: each row of r is complete
 * after its turn. x has no padding. */
typedef struct chebyshev {
    float keep, add;
    const float *d;
    float *next, *x, *r;
} chebyshev;

/* Returns component k of D^-1 r at node i, sum_c D^-1_kc r_c. */
static inline float by_inverse(const aoi_blocks *matrix, size_t b, size_t i, size_t k, const float *r)
{
    const float *row = matrix->inverse + b * (b * i + k);
    float sum = 0.0f;
    for (size_t c = 0; c < b; c++) {
        sum += row[c] * r[aoi_four_width(b) * i + c];
    }
    return sum;
}

static inline void step_row(const aoi_blocks *matrix, size_t b, size_t row, const chebyshev *step)
{
    const size_t i = (size_t)matrix->order[row], at = aoi_four_width(b) * i;
    aoi_single_row(matrix, matrix->values, b, row, step->d, step->r);
    for (size_t k = 0; k < b; k++) {
        const float change = step->keep * step->d[at + k] + step->add * by_inverse(matrix, b, i, k, step->r);
        step->next[at + k] = change;
        step->x[b * i + k] += change;
    }
}

static void take_step(const aoi_blocks *matrix, aoi_part part, const chebyshev *step)
{
    for (size_t row = part.begin; row < part.end; row++) {
        switch (matrix->size) {
        case 3:
            step_row(matrix, 3, row, step);
            break;
        case 6:
            step_row(matrix, 6, row, step);
            break;
        default:
            step_row(matrix, matrix->size, row, step);
        }
    }
}

/* Makes the first step at a node: d = add D^-1 r, x += d. The fourth floats of d and next are also set, since they
 * will be read. */
static inline void start_row(const aoi_blocks *matrix, size_t b, size_t i, float add, float *d,
                             float *next, float *x, const float *r)
{
    const size_t width = aoi_four_width(b);
    for (size_t k = 0; k < width; k++) {
        const float change = k < b ? add * by_inverse(matrix, b, i, k, r) : 0.0f;
        d[width * i + k] = next[width * i + k] = change;
        if (k < b) {
            x[b * i + k] += change;
        }
    }
}

static void first_step(const aoi_blocks *matrix, aoi_part part, float add, float *d, float *next, float *x,
                       const float *r)
{
    for (size_t row = part.begin; row < part.end; row++) {
        const size_t i = (size_t)matrix->order[row];
        if (matrix->size == 3) {
            start_row(matrix, 3, i, add, d, next, x, r);
        } else {
            start_row(matrix, matrix->size, i, add, d, next, x, r);
        }
    }
}

/* Returns the coefficients of step `stage`, counted from 1, by the recurrence for Chebyshev's rho. */
static chebyshev step_of(size_t stage, double low, double high)
{
    const double middle = 0.5 * (high + low), half = 0.5 * (high - low);
    double rho = half / middle, before = rho;
    for (size_t k = 1; k <= stage; k++) {
        before = rho;
        rho = 1.0 / (2.0 * middle / half - before);
    }
    return (chebyshev){.keep = (float)(rho * before), .add = (float)(2.0 * rho / half)};
}

int aoi_blocks_smooth(const aoi_blocks *matrix, aoi_part part, size_t stage, size_t steps, double low,
                      double high, int finish, float *x, float *r, float *work)
{
    const size_t length = aoi_four_width(matrix->size) * matrix->n;
    float *wide = work, *changes[2] = {work + length, work + 2 * length};
    if (!(low > 0.0 && high > low && high < HUGE_VAL) || steps < 1 || stage > steps) {
        return AOI_ERROR_ARGUMENT;
    }
    if (stage == 0) {
        const float add = (float)(2.0 / (high + low));
        aoi_single_spread(matrix, part, r, wide);
        first_step(matrix, part, add, changes[0], changes[1], x, wide);
        return AOI_OK;
    }
    chebyshev step = step_of(stage, low, high);
    step.d = changes[(stage - 1) % 2];
    step.next = changes[stage % 2];
    step.x = x;
    step.r = wide;
    if (stage < steps) {
        take_step(matrix, part, &step);
        return AOI_OK;
    }
    if (finish) {
        aoi_single_rows(matrix, part, matrix->values, step.d, wide);
    }
    aoi_single_gather(matrix, part, wide, r);
    return AOI_OK;
}
