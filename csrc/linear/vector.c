/* The vector operations that everything dense is made of. */
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
