/* Smoothing in multigrid: Chebyshev steps on a matrix of small blocks, preconditioned by its
 * diagonal blocks (Saad, Iterative Methods for Sparse Linear Systems, 2nd ed., algorithm 12.1;
 * Adams, Brezina, Hu and Tuminaro, J. Comput. Phys. 188, 2003). Most of a solution's time is
 * spent in row_product: hence single precision, and one copy of it for each size of block. */
#include "linear/multigrid.h"
#include "linear/sparse.h"

#include <math.h>

int aoi_blocks_check(const aoi_blocks *matrix, size_t stored_count)
{
    const aoi_sparse pattern = {matrix->n, matrix->start, matrix->indices, NULL};
    if (matrix->size < 1 || matrix->size > AOI_BLOCKS_WIDEST) {
        return AOI_ERROR_ARGUMENT;
    }
    return aoi_sparse_check(&pattern, stored_count);
}

/* Row i of A times x for blocks of 3 x 3, by nine sums: each addition waits for the one before it in
 * its own chain, and three chains of three a block would wait three times as long. */
static inline void row_product_3(const aoi_blocks *matrix, size_t i, const float *x, float *product)
{
    float sum[9] = {0.0f};
    for (int32_t p = matrix->start[i]; p < matrix->start[i + 1]; p++) {
        const float *block = matrix->values + 9 * (size_t)p;
        const float *part = x + 3 * (size_t)matrix->indices[p];
        for (size_t k = 0; k < 9; k++) {
            sum[k] += block[k] * part[k % 3];
        }
    }
    for (size_t r = 0; r < 3; r++) {
        product[r] = sum[3 * r] + sum[3 * r + 1] + sum[3 * r + 2];
    }
}

static inline void row_product_any(const aoi_blocks *matrix, size_t b, size_t i, const float *x,
                               float *product)
{
    float sum[AOI_BLOCKS_WIDEST] = {0.0f};
    for (int32_t p = matrix->start[i]; p < matrix->start[i + 1]; p++) {
        const float *block = matrix->values + b * b * (size_t)p;
        const float *part = x + b * (size_t)matrix->indices[p];
        for (size_t r = 0; r < b; r++) {
            for (size_t c = 0; c < b; c++) {
                sum[r] += block[b * r + c] * part[c];
            }
        }
    }
    for (size_t r = 0; r < b; r++) {
        product[r] = sum[r];
    }
}

/* Row i of A times x. b is the size of a block: a constant wherever speed matters. The sums are
 * local, for the compiler to know that nothing else is written through them. */
static inline void row_product(const aoi_blocks *matrix, size_t b, size_t i, const float *x,
                               float *product)
{
    if (b == 3) {
        row_product_3(matrix, i, x, product);
    } else {
        row_product_any(matrix, b, i, x, product);
    }
}

static inline void subtract_row(const aoi_blocks *matrix, size_t b, size_t i, const float *x,
                                float *r)
{
    float product[AOI_BLOCKS_WIDEST];
    row_product(matrix, b, i, x, product);
    for (size_t k = 0; k < b; k++) {
        r[b * i + k] -= product[k];
    }
}

void aoi_blocks_subtract(const aoi_blocks *matrix, const float *x, float *r)
{
    for (size_t i = 0; i < matrix->n; i++) {
        switch (matrix->size) {
        case 3:
            subtract_row(matrix, 3, i, x, r);
            break;
        case 6:
            subtract_row(matrix, 6, i, x, r);
            break;
        default:
            subtract_row(matrix, matrix->size, i, x, r);
        }
    }
}

/* As row_product_3, in double. */
static inline void exact_row_product_3(const aoi_blocks *matrix, const double *values, size_t i,
                                       const double *x, double *product)
{
    double sum[9] = {0.0};
    for (int32_t p = matrix->start[i]; p < matrix->start[i + 1]; p++) {
        const double *block = values + 9 * (size_t)p;
        const double *part = x + 3 * (size_t)matrix->indices[p];
        for (size_t k = 0; k < 9; k++) {
            sum[k] += block[k] * part[k % 3];
        }
    }
    for (size_t r = 0; r < 3; r++) {
        product[r] = sum[3 * r] + sum[3 * r + 1] + sum[3 * r + 2];
    }
}

static inline void exact_row_product(const aoi_blocks *matrix, const double *values, size_t i,
                                     const double *x, double *product)
{
    const size_t b = matrix->size;
    for (size_t r = 0; r < b; r++) {
        double sum = 0.0;
        for (int32_t p = matrix->start[i]; p < matrix->start[i + 1]; p++) {
            const double *row = values + b * (b * (size_t)p + r);
            const double *part = x + b * (size_t)matrix->indices[p];
            for (size_t c = 0; c < b; c++) {
                sum += row[c] * part[c];
            }
        }
        product[r] = sum;
    }
}

void aoi_blocks_multiply(const aoi_blocks *matrix, const double *values, const double *x, double *y)
{
    for (size_t i = 0; i < matrix->n; i++) {
        if (matrix->size == 3) {
            exact_row_product_3(matrix, values, i, x, y + 3 * i);
        } else {
            exact_row_product(matrix, values, i, x, y + matrix->size * i);
        }
    }
}

/* One step: next = keep d + add D^-1 (r - A d), with r - A d left in r, and x += next. d of other
 * rows is read, so that next has to be another vector. */
typedef struct chebyshev {
    float keep, add;
    const float *d;
    float *next, *x, *r;
} chebyshev;

static inline void step_row(const aoi_blocks *matrix, size_t b, size_t i, const chebyshev *step)
{
    const float *inverse = matrix->inverse + b * b * i;
    float residual[AOI_BLOCKS_WIDEST];
    row_product(matrix, b, i, step->d, residual);
    for (size_t k = 0; k < b; k++) {
        residual[k] = step->r[b * i + k] - residual[k];
        step->r[b * i + k] = residual[k];
    }
    for (size_t k = 0; k < b; k++) {
        float change = 0.0f;
        for (size_t c = 0; c < b; c++) {
            change += inverse[b * k + c] * residual[c];
        }
        change = step->keep * step->d[b * i + k] + step->add * change;
        step->next[b * i + k] = change;
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
static void first_step(const aoi_blocks *matrix, float add, float *d, float *x, const float *r)
{
    const size_t b = matrix->size;
    for (size_t i = 0; i < matrix->n; i++) {
        for (size_t k = 0; k < b; k++) {
            const float *row = matrix->inverse + b * (b * i + k);
            float change = 0.0f;
            for (size_t c = 0; c < b; c++) {
                change += row[c] * r[b * i + c];
            }
            d[b * i + k] = add * change;
            x[b * i + k] += add * change;
        }
    }
}

int aoi_blocks_smooth(const aoi_blocks *matrix, size_t steps, double low, double high, int finish,
                      float *x, float *r, float *work)
{
    const double middle = 0.5 * (high + low), half = 0.5 * (high - low);
    float *d = work, *next = work + matrix->size * matrix->n;
    double rho = half / middle;
    if (!(low > 0.0 && high > low && high < HUGE_VAL) || steps < 1) {
        return AOI_ERROR_ARGUMENT;
    }
    first_step(matrix, (float)(1.0 / middle), d, x, r);
    for (size_t k = 1; k < steps; k++) {
        const double rho_next = 1.0 / (2.0 * middle / half - rho);
        const float keep = (float)(rho_next * rho), add = (float)(2.0 * rho_next / half);
        take_step(matrix, &(chebyshev){keep, add, d, next, x, r});
        float *swapped = d;
        d = next;
        next = swapped;
        rho = rho_next;
    }
    if (finish) {
        aoi_blocks_subtract(matrix, d, r);
    }
    return AOI_OK;
}
