/* Operations on sparse symmetric matrices that a finite-element body needs in every step. */
#include "linear/sparse.h"

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
