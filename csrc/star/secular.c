/* Roots of the secular equation, which convert between a star and its modes without a dense matrix. The distance
 * of each root from the nearest pole has full relative accuracy. The use of this distance follows LAPACK (dlaed4);
 * the iteration is Newton's method guarded by bisection. */
#include "star/secular.h"

#include <float.h>
#include <math.h>

/* Largest number of iterations: bisection alone may go through all powers of two of a double. */
enum { MOST_ITERATIONS = 2200 };

/* Finds s and its derivative at origin + offset. The distances of the poles from the origin are formed first, so
 * that they keep their digits. */
static void secular_evaluate(const aoi_secular *s, double origin, double offset, double *value,
                             double *slope)
{
    double sum = 0.0, sum_of_squares = 0.0;
    for (size_t j = 0; j < s->n; j++) {
        const double inverse = 1.0 / ((s->pole[j] - origin) - offset);
        const double term = s->weight[j] * inverse;
        sum += term;
        sum_of_squares += term * inverse;
    }
    if (s->power == 0) {
        *value = s->constant + s->linear + sum;
        *slope = sum_of_squares;
    } else {
        const double x = origin + offset;
        *value = s->constant + x * (s->linear + sum);
        *slope = s->linear + sum + x * sum_of_squares;
    }
}

/* Finds the offset in (low, high) from the origin at which s, which rises, is zero. scaled = 1: s is multiplied by
 * the offset, which removes the pole at offset 0 and makes the function nearly straight for Newton's method. */
static int find_offset(const aoi_secular *s, double origin, double low, double high, int scaled,
                       double *offset)
{
    double x = 0.5 * (low + high);
    for (int i = 0; i < MOST_ITERATIONS; i++) {
        double value, slope;
        secular_evaluate(s, origin, x, &value, &slope);
        if (isnan(value)) {
            return AOI_ERROR_NOT_FINITE;
        }
        if (value == 0.0) {
            *offset = x;
            return AOI_OK;
        }
        if (value < 0.0) {
            low = x;
        } else {
            high = x;
        }
        const double change = scaled ? -x * value / (value + x * slope) : -value / slope;
        double next = x + change;
        if (!(next > low && next < high)) {
            next = 0.5 * (low + high);
        }
        const double moved = fabs(next - x);
        x = next;
        if (moved <= 2.0 * DBL_EPSILON * fabs(x)) {
            *offset = x;
            return AOI_OK;
        }
    }
    return AOI_ERROR_NO_CONVERGENCE;
}

int aoi_secular_root(const aoi_secular *s, ptrdiff_t gap, double ceiling, size_t *nearest,
                     double *offset)
{
    const ptrdiff_t last = (ptrdiff_t)s->n - 1;
    if (gap < -1 || gap > last) {
        return AOI_ERROR_ARGUMENT;
    }
    const double left = gap < 0 ? 0.0 : s->pole[gap];
    const double right = gap == last ? ceiling : s->pole[gap + 1];
    if (!(right > left)) {
        return AOI_ERROR_ARGUMENT;
    }
    if (!(right - left < DBL_MAX / 4.0)) { /* the sum of both ends must be finite  */
        return AOI_ERROR_NOT_FINITE;
    }
    double value, slope;
    const double half = 0.5 * (right - left);
    secular_evaluate(s, left, half, &value, &slope);
    if (gap == last || value >= 0.0) { /* the last gap has no pole at its upper end */
        *nearest = gap < 0 ? s->n : (size_t)gap;
        return find_offset(s, left, 0.0, gap == last ? right - left : half, gap >= 0, offset);
    }
    *nearest = (size_t)(gap + 1);
    return find_offset(s, right, -half, 0.0, 1, offset);
}
