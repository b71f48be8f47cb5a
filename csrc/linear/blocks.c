/* Smoothing in multigrid: Chebyshev steps on a matrix of small blocks, preconditioned by its
 * diagonal blocks (Saad, Iterative Methods for Sparse Linear Systems, 2nd ed., algorithm 12.1;
 * Adams, Brezina, Hu and Tuminaro, J. Comput. Phys. 188, 2003). What takes the time is to read the
 * matrix from memory: hence single precision, and only one of its triangles. */
#include "linear/four.h"
#include "linear/multigrid.h"
#include "linear/sparse.h"

#include <math.h>
#include <string.h>

#define REAL float
#define OF(x) aoi_single_##x
#include "linear/block_rows.h"
#undef REAL
#undef OF
#define REAL double
#define OF(x) aoi_exact_##x
#include "linear/block_rows.h"

int aoi_blocks_check(const aoi_blocks *matrix, size_t stored_count)
{
    const aoi_sparse pattern = {matrix->n, matrix->start, matrix->indices, NULL};
    if (matrix->size < 1 || matrix->size > AOI_BLOCKS_WIDEST ||
        aoi_sparse_check(&pattern, stored_count) != AOI_OK) {
        return AOI_ERROR_ARGUMENT;
    }
    for (size_t i = 0; i < matrix->n; i++) {
        const int32_t diagonal = matrix->start[i], end = matrix->start[i + 1];
        if (diagonal == end || (size_t)matrix->indices[diagonal] != i) {
            return AOI_ERROR_ARGUMENT;
        }
        for (int32_t p = diagonal + 1; p < end; p++) {
            if ((size_t)matrix->indices[p] <= i) {
                return AOI_ERROR_ARGUMENT;
            }
        }
    }
    return AOI_OK;
}

void aoi_blocks_subtract(const aoi_blocks *matrix, const float *x, float *r, float *work)
{
    float *wide = work + aoi_four_width(matrix->size) * matrix->n;
    aoi_single_spread(matrix, r, work);
    aoi_single_spread(matrix, x, wide);
    aoi_single_rows(matrix, matrix->values, wide, work);
    aoi_single_gather(matrix, work, r);
}

void aoi_blocks_multiply(const aoi_blocks *matrix, const double *values, const double *x, double *y,
                         double *work)
{
    const size_t length = aoi_four_width(matrix->size) * matrix->n;
    memset(work, 0, length * sizeof *work);
    aoi_exact_spread(matrix, x, work + length);
    aoi_exact_rows(matrix, values, work + length, work);
    aoi_exact_gather(matrix, work, y);
    for (size_t k = 0; k < matrix->size * matrix->n; k++) {
        y[k] = -y[k];
    }
}

/* One step: next = keep d + add D^-1 (r - A d), with r - A d left in r, and x += next. d of other
 * rows is read, so that next has to be another vector. One pass through A does it: each row of r is
 * complete when its turn is over. x has no fourth floats. */
typedef struct chebyshev {
    float keep, add;
    const float *d;
    float *next, *x, *r;
} chebyshev;

/* sum_c D^-1_kc r_c of node i. */
static inline float by_inverse(const aoi_blocks *matrix, size_t b, size_t i, size_t k, const float *r)
{
    const float *row = matrix->inverse + b * (b * i + k);
    float sum = 0.0f;
    for (size_t c = 0; c < b; c++) {
        sum += row[c] * r[aoi_four_width(b) * i + c];
    }
    return sum;
}

static inline void step_row(const aoi_blocks *matrix, size_t b, size_t i, const chebyshev *step)
{
    const size_t at = aoi_four_width(b) * i;
    aoi_single_row(matrix, matrix->values, b, i, step->d, step->r);
    for (size_t k = 0; k < b; k++) {
        const float change =
            step->keep * step->d[at + k] + step->add * by_inverse(matrix, b, i, k, step->r);
        step->next[at + k] = change;
        step->x[b * i + k] += change;
    }
}

static void take_step(const aoi_blocks *matrix, const chebyshev *step)
{
    for (size_t i = 0; i < matrix->n; i++) {
        switch (matrix->size) {
        case 3:
            step_row(matrix, 3, i, step);
            break;
        case 6:
            step_row(matrix, 6, i, step);
            break;
        default:
            step_row(matrix, matrix->size, i, step);
        }
    }
}

/* d = add D^-1 r, x += d. */
static inline void start_row(const aoi_blocks *matrix, size_t b, size_t i, float add, float *d,
                             float *x, const float *r)
{
    for (size_t k = 0; k < b; k++) {
        const float change = add * by_inverse(matrix, b, i, k, r);
        d[aoi_four_width(b) * i + k] = change;
        x[b * i + k] += change;
    }
}

static void first_step(const aoi_blocks *matrix, float add, float *d, float *x, const float *r)
{
    for (size_t i = 0; i < matrix->n; i++) {
        if (matrix->size == 3) {
            start_row(matrix, 3, i, add, d, x, r);
        } else {
            start_row(matrix, matrix->size, i, add, d, x, r);
        }
    }
}

int aoi_blocks_smooth(const aoi_blocks *matrix, size_t steps, double low, double high, int finish,
                      float *x, float *r, float *work)
{
    const size_t length = aoi_four_width(matrix->size) * matrix->n;
    const double middle = 0.5 * (high + low), half = 0.5 * (high - low);
    float *wide = work, *d = work + length, *next = work + 2 * length;
    double rho = half / middle;
    if (!(low > 0.0 && high > low && high < HUGE_VAL) || steps < 1) {
        return AOI_ERROR_ARGUMENT;
    }
    aoi_single_spread(matrix, r, wide);
    memset(d, 0, 2 * length * sizeof *d); /* the fourth floats are read */
    first_step(matrix, (float)(1.0 / middle), d, x, wide);
    for (size_t k = 1; k < steps; k++) {
        const double rho_next = 1.0 / (2.0 * middle / half - rho);
        const float keep = (float)(rho_next * rho), add = (float)(2.0 * rho_next / half);
        take_step(matrix, &(chebyshev){keep, add, d, next, x, wide});
        float *swapped = d;
        d = next;
        next = swapped;
        rho = rho_next;
    }
    if (finish) {
        aoi_single_rows(matrix, matrix->values, d, wide);
    }
    aoi_single_gather(matrix, wide, r);
    return AOI_OK;
}
