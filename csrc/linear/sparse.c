/* Sparse symmetric matrices and their factors: what the finite-element body needs in every step.
 * The factors come from a library; only the triangular sweeps are here, because they are the inner
 * loop of the full model and must run without leaving C. */
#include "linear/sparse.h"
#include "linear/work.h"

#include <string.h>

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

/* True if column j has the rows of column j+1, and j+1 itself. */
static int continues(const int32_t *start, const int32_t *rows, size_t j)
{
    const int32_t begin = start[j], middle = start[j + 1];
    const int32_t count = middle - begin;
    if (count != start[j + 2] - middle + 1 || rows[begin] != (int32_t)j + 1) {
        return 0;
    }
    return memcmp(rows + begin + 1, rows + middle, (size_t)(count - 1) * sizeof *rows) == 0;
}

size_t aoi_factors_find_panels(size_t n, const int32_t *start, const int32_t *rows, int32_t *panel)
{
    size_t count = 0;
    panel[0] = 0;
    for (size_t j = 0; j < n; j++) {
        if (j + 1 == n || !continues(start, rows, j)) {
            panel[++count] = (int32_t)j + 1;
        }
    }
    return count;
}

static int panels_are_sound(const aoi_factors *factors)
{
    const int32_t *panel = factors->panel;
    if (panel[0] != 0 || (size_t)panel[factors->panel_count] != factors->n) {
        return 0;
    }
    for (size_t p = 0; p < factors->panel_count; p++) {
        if (panel[p + 1] <= panel[p] || (size_t)panel[p + 1] > factors->n) {
            return 0;
        }
        for (size_t j = (size_t)panel[p]; j + 1 < (size_t)panel[p + 1]; j++) {
            if (!continues(factors->start, factors->rows, j)) {
                return 0;
            }
        }
    }
    return 1;
}

/* True if each row has a place of its own. */
static int places_are_sound(const aoi_factors *factors)
{
    double *taken = factors->work;
    memset(taken, 0, factors->n * sizeof *taken);
    for (size_t i = 0; i < factors->n; i++) {
        const int32_t place = factors->place[i];
        if (place < 0 || (size_t)place >= factors->n || taken[place] != 0.0) {
            return 0;
        }
        taken[place] = 1.0;
    }
    return 1;
}

int aoi_factors_check(const aoi_factors *factors, size_t stored_count)
{
    const size_t n = factors->n;
    if (!starts_are_sound(n, factors->start, stored_count) || !places_are_sound(factors)) {
        return AOI_ERROR_ARGUMENT;
    }
    for (size_t j = 0; j < n; j++) {
        for (int32_t p = factors->start[j]; p < factors->start[j + 1]; p++) {
            if (factors->rows[p] <= (int32_t)j || (size_t)factors->rows[p] >= n) {
                return AOI_ERROR_ARGUMENT;
            }
        }
    }
    if (!panels_are_sound(factors)) {
        return AOI_ERROR_ARGUMENT;
    }
    for (size_t j = 0; j < n; j++) {
        if (!(factors->pivots[j] > 0.0)) {
            return AOI_ERROR_NOT_POSITIVE;
        }
    }
    return AOI_OK;
}

/* Up to four neighbouring columns of a panel: where their values for the shared rows begin. */
typedef struct strip {
    const double *column[4];
    const int32_t *rows;
    size_t row_count, width;
} strip;

/* The strip of columns first .. first+width-1 and the rows below the last of them. */
static strip strip_at(const aoi_factors *factors, size_t first, size_t width)
{
    const size_t last = first + width - 1;
    strip cut = {{NULL, NULL, NULL, NULL}, factors->rows + factors->start[last], 0, width};
    cut.row_count = (size_t)(factors->start[last + 1] - factors->start[last]);
    for (size_t c = 0; c < width; c++) {
        cut.column[c] = factors->values + factors->start[first + c] + (width - 1 - c);
    }
    return cut;
}

static void strip_down(const strip *cut, const double *x_of_columns, double *x)
{
    const double *v0 = cut->column[0], *v1 = cut->column[1], *v2 = cut->column[2];
    const double *v3 = cut->column[3], *y = x_of_columns;
    const int32_t *rows = cut->rows;
    const size_t n = cut->row_count;
    if (cut->width == 4) {
        for (size_t i = 0; i < n; i++) {
            x[rows[i]] -= (v0[i] * y[0] + v1[i] * y[1]) + (v2[i] * y[2] + v3[i] * y[3]);
        }
    } else if (cut->width == 3) {
        for (size_t i = 0; i < n; i++) {
            x[rows[i]] -= v0[i] * y[0] + v1[i] * y[1] + v2[i] * y[2];
        }
    } else if (cut->width == 2) {
        for (size_t i = 0; i < n; i++) {
            x[rows[i]] -= v0[i] * y[0] + v1[i] * y[1];
        }
    } else {
        for (size_t i = 0; i < n; i++) {
            x[rows[i]] -= v0[i] * y[0];
        }
    }
}

/* sum[c] = column c of the strip times x: four products share one fetch of x. */
static void strip_up(const strip *cut, const double *x, double *sum)
{
    const int32_t *rows = cut->rows;
    const double *v0 = cut->column[0], *v1 = v0, *v2 = v0, *v3 = v0;
    double s0 = 0.0, s1 = 0.0, s2 = 0.0, s3 = 0.0;
    if (cut->width > 1) {
        v1 = cut->column[1];
    }
    if (cut->width > 2) {
        v2 = cut->column[2];
    }
    if (cut->width > 3) {
        v3 = cut->column[3];
    }
    for (size_t i = 0; i < cut->row_count; i++) {
        const double xi = x[rows[i]];
        s0 += v0[i] * xi;
        s1 += v1[i] * xi;
        s2 += v2[i] * xi;
        s3 += v3[i] * xi;
    }
    sum[0] = s0;
    sum[1] = s1;
    sum[2] = s2;
    sum[3] = s3;
}

/* Entries between two calls of pause. */
enum { UNASKED = 1 << 20 };

/* True if pause, called once in that many entries, ends the solution; entries: of a panel. */
static int stops(const aoi_factors *factors, size_t p, int64_t *left)
{
    *left -= factors->start[factors->panel[p + 1]] - factors->start[factors->panel[p]] + 1;
    if (*left > 0) {
        return 0;
    }
    *left = UNASKED;
    return aoi_work_stops(factors->pause);
}

/* L^-1 on the columns of a strip among themselves, then on the rows below. */
static int sweep_down(const aoi_factors *factors, double *x)
{
    int64_t left = UNASKED;
    for (size_t p = 0; p < factors->panel_count; p++) {
        const size_t end = (size_t)factors->panel[p + 1];
        if (stops(factors, p, &left)) {
            return AOI_ERROR_STOPPED;
        }
        for (size_t j = (size_t)factors->panel[p]; j < end; j += 4) {
            const size_t width = end - j < 4 ? end - j : 4;
            const strip cut = strip_at(factors, j, width);
            for (size_t c = 0; c + 1 < width; c++) {
                const double *inner = factors->values + factors->start[j + c];
                for (size_t r = c + 1; r < width; r++) {
                    x[j + r] -= inner[r - c - 1] * x[j + c];
                }
            }
            strip_down(&cut, x + j, x);
        }
    }
    return AOI_OK;
}

/* L^-T D^-1, strip by strip from the end. */
static int sweep_up(const aoi_factors *factors, double *x)
{
    int64_t left = UNASKED;
    for (size_t p = factors->panel_count; p-- > 0;) {
        const size_t begin = (size_t)factors->panel[p];
        if (stops(factors, p, &left)) {
            return AOI_ERROR_STOPPED;
        }
        size_t strips = ((size_t)factors->panel[p + 1] - begin + 3) / 4;
        while (strips-- > 0) {
            const size_t j = begin + 4 * strips, end = (size_t)factors->panel[p + 1];
            const size_t width = end - j < 4 ? end - j : 4;
            const strip cut = strip_at(factors, j, width);
            double sum[4];
            strip_up(&cut, x, sum);
            for (size_t c = width; c-- > 0;) {
                const double *inner = factors->values + factors->start[j + c];
                double value = x[j + c] / factors->pivots[j + c] - sum[c];
                for (size_t r = c + 1; r < width; r++) {
                    value -= inner[r - c - 1] * x[j + r];
                }
                x[j + c] = value;
            }
        }
    }
    return AOI_OK;
}

int aoi_factors_solve(void *data, double *x)
{
    const aoi_factors *factors = data;
    double *permuted = factors->work;
    for (size_t i = 0; i < factors->n; i++) {
        permuted[factors->place[i]] = x[i];
    }
    int status = sweep_down(factors, permuted);
    if (status == AOI_OK) {
        status = sweep_up(factors, permuted);
    }
    for (size_t i = 0; i < factors->n; i++) {
        x[i] = permuted[factors->place[i]];
    }
    return status;
}
