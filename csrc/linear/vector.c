/* Operations on vectors, and elimination in a band matrix. */
#include "linear/vector.h"

#include <math.h>

double aoi_vector_dot(size_t n, const double *x, const double *y)
{
    double sum[4] = {0.0, 0.0, 0.0, 0.0};
    size_t i = 0;
    for (; i + 4 <= n; i += 4) {
        for (size_t lane = 0; lane < 4; lane++) {
            sum[lane] += x[i + lane] * y[i + lane];
        }
    }
    for (; i < n; i++) {
        sum[0] += x[i] * y[i];
    }
    return (sum[0] + sum[1]) + (sum[2] + sum[3]);
}

double aoi_vector_squares(size_t n, const double *weight, const double *factor, const double *x)
{
    static const double ones[4] = {1.0, 1.0, 1.0, 1.0};
    const double *by = weight ? weight : ones, *of = factor ? factor : ones;
    const size_t next = weight ? 4 : 0, after = factor ? 4 : 0;
    double sum[4] = {0.0, 0.0, 0.0, 0.0};
    size_t j = 0;
    for (; j + 4 <= n; j += 4, by += next, of += after) {
        for (size_t lane = 0; lane < 4; lane++) {
            const double term = of[lane] * x[j + lane];
            sum[lane] += by[lane] * term * term;
        }
    }
    for (size_t lane = 0; j < n; j++, lane++) {
        const double term = of[lane] * x[j];
        sum[lane] += by[lane] * term * term;
    }
    return (sum[0] + sum[1]) + (sum[2] + sum[3]);
}

void aoi_vector_add(size_t n, double factor, const double *x, double *y)
{
    for (size_t i = 0; i < n; i++) {
        y[i] += factor * x[i];
    }
}

int aoi_vector_is_finite(size_t n, const double *x)
{
    for (size_t i = 0; i < n; i++) {
        if (!isfinite(x[i])) {
            return 0;
        }
    }
    return 1;
}

int aoi_vector_take(size_t n, const double *from, double *to)
{
    for (size_t i = 0; i < n; i++) {
        to[i] = from ? from[i] : 0.0;
    }
    return aoi_vector_is_finite(n, to);
}

int aoi_band_factorise(size_t n, size_t band, double *matrix)
{
    const size_t stride = 2 * band; /* element (i, j) is matrix[i * stride + j] */
    int sound = 1;
    matrix += band;
    for (size_t k = 0; k < n; k++) {
        const double *pivot_row = matrix + k * stride;
        const double pivot = pivot_row[k], inverse = 1.0 / pivot;
        const size_t last = k + band < n ? k + band : n - 1;
        sound = sound && pivot > 0.0 && isfinite(pivot);
        for (size_t i = k + 1; i <= last; i++) {
            double *row = matrix + i * stride;
            const double factor = row[k] * inverse;
            for (size_t q = k + 1; q <= last && factor != 0.0; q++) {
                row[q] -= factor * pivot_row[q];
            }
            row[k] = factor;
        }
        matrix[k * stride + k] = inverse;
    }
    return sound;
}

void aoi_band_substitute(size_t n, size_t band, const double *matrix, double *x)
{
    const size_t stride = 2 * band;
    matrix += band;
    for (size_t k = 1; k < n; k++) {
        double sum = x[k];
        for (size_t q = k > band ? k - band : 0; q < k; q++) {
            sum -= matrix[k * stride + q] * x[q];
        }
        x[k] = sum;
    }
    /* The last component found is used last, and nothing is divided: each step then waits for only one product of
     * the step before. */
    for (size_t k = n; k-- > 0;) {
        double sum = x[k];
        for (size_t q = k + band < n ? k + band : n - 1; q > k; q--) {
            sum -= matrix[k * stride + q] * x[q];
        }
        x[k] = sum * matrix[k * stride + k];
    }
}
