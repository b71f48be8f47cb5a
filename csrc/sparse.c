/* Sparse symmetric matrices and their factors: what the finite-element body needs in every step.
 * The factors come from a library; only the triangular sweeps are here, because they are the inner
 * loop of the full model and must run without leaving C. */
#include "aoimpact.h"

static int starts_are_sound(size_t n, const int32_t *start, size_t stored_count)
{
    if (start[0] != 0 || (size_t)start[n] != stored_count) {
        return 0;
    }
    for (size_t i = 0; i < n; i++) {
        if (start[i + 1] < start[i]) {
            return 0;
        }
    }
    return 1;
}

int aoi_sparse_check(const aoi_sparse *matrix, size_t stored_count)
{
    if (!starts_are_sound(matrix->n, matrix->start, stored_count)) {
        return AOI_ERROR_ARGUMENT;
    }
    for (size_t p = 0; p < stored_count; p++) {
        if (matrix->indices[p] < 0 || (size_t)matrix->indices[p] >= matrix->n) {
            return AOI_ERROR_ARGUMENT;
        }
    }
    return AOI_OK;
}

static double row_product(const aoi_sparse *matrix, size_t row, const double *x)
{
    const int32_t begin = matrix->start[row], end = matrix->start[row + 1];
    double even = 0.0, odd = 0.0;
    int32_t p = begin;
    for (; p + 1 < end; p += 2) {
        even += matrix->values[p] * x[matrix->indices[p]];
        odd += matrix->values[p + 1] * x[matrix->indices[p + 1]];
    }
    if (p < end) {
        even += matrix->values[p] * x[matrix->indices[p]];
    }
    return even + odd;
}

void aoi_sparse_multiply(const aoi_sparse *matrix, const double *x, double *y)
{
    for (size_t i = 0; i < matrix->n; i++) {
        y[i] = row_product(matrix, i, x);
    }
}

double aoi_sparse_quadratic(const aoi_sparse *matrix, const double *x)
{
    double sum = 0.0;
    for (size_t i = 0; i < matrix->n; i++) {
        sum += x[i] * row_product(matrix, i, x);
    }
    return sum;
}

int aoi_factors_check(const aoi_factors *factors, size_t stored_count)
{
    const size_t n = factors->n;
    if (!starts_are_sound(n, factors->start, stored_count)) {
        return AOI_ERROR_ARGUMENT;
    }
    for (size_t j = 0; j < n; j++) {
        if (factors->place[j] < 0 || (size_t)factors->place[j] >= n) {
            return AOI_ERROR_ARGUMENT;
        }
        for (int32_t p = factors->start[j]; p < factors->start[j + 1]; p++) {
            if (factors->rows[p] <= (int32_t)j || (size_t)factors->rows[p] >= n) {
                return AOI_ERROR_ARGUMENT;
            }
        }
    }
    for (size_t j = 0; j < n; j++) {
        if (!(factors->pivots[j] > 0.0)) {
            return AOI_ERROR_NOT_POSITIVE;
        }
    }
    return AOI_OK;
}

static void sweep_down(const aoi_factors *factors, double *x)
{
    for (size_t j = 0; j < factors->n; j++) {
        const double xj = x[j];
        const int32_t end = factors->start[j + 1];
        for (int32_t p = factors->start[j]; p < end; p++) {
            x[factors->rows[p]] -= factors->values[p] * xj;
        }
    }
}

static void sweep_up(const aoi_factors *factors, double *x)
{
    for (size_t j = factors->n; j-- > 0;) {
        const int32_t end = factors->start[j + 1];
        double even = x[j] / factors->pivots[j], odd = 0.0;
        int32_t p = factors->start[j];
        for (; p + 1 < end; p += 2) {
            even -= factors->values[p] * x[factors->rows[p]];
            odd -= factors->values[p + 1] * x[factors->rows[p + 1]];
        }
        if (p < end) {
            even -= factors->values[p] * x[factors->rows[p]];
        }
        x[j] = even + odd;
    }
}

int aoi_factors_solve(void *data, double *x)
{
    const aoi_factors *factors = data;
    double *permuted = factors->work;
    for (size_t i = 0; i < factors->n; i++) {
        permuted[factors->place[i]] = x[i];
    }
    sweep_down(factors, permuted);
    sweep_up(factors, permuted);
    for (size_t i = 0; i < factors->n; i++) {
        x[i] = permuted[factors->place[i]];
    }
    return AOI_OK;
}
