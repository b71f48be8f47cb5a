/* Between contacts everything is linear: the closed form, and the next touch found with certainty. */
#include "aoimpact.h"

#include <float.h>
#include <math.h>

void aoi_relative_indentation(const aoi_relative *relative, const double *x, const double *v,
                              double *indentation, double *rate)
{
    double sum = 0.0, rate_sum = 0.0;
    for (size_t j = 0; j < relative->n; j++) {
        sum += x[j];
        rate_sum += v[j];
    }
    *indentation = sum - relative->gap;
    *rate = rate_sum;
}

void aoi_relative_fly(const aoi_relative *relative, double time, double *x, double *v)
{
    for (size_t j = 0; j < relative->n; j++) {
        const double omega = relative->omega[j], x0 = x[j], v0 = v[j];
        if (omega > 0.0) {
            const double c = cos(omega * time), s = sin(omega * time);
            x[j] = c * x0 + s / omega * v0;
            v[j] = c * v0 - omega * s * x0;
        } else {
            x[j] = x0 + time * (v0 + 0.5 * time * relative->load[j]);
            v[j] = v0 + time * relative->load[j];
        }
    }
}

/* The first positive root of c + b t + a t^2, or infinity. With c < 0 that is where it becomes
 * positive; with c = 0 (just let go) where it does so again. */
static double first_root(double c, double b, double a)
{
    if (c > 0.0 || (c == 0.0 && (b > 0.0 || (b == 0.0 && a > 0.0)))) {
        return 0.0;
    }
    if (a == 0.0) {
        return b > 0.0 ? -c / b : HUGE_VAL;
    }
    const double discriminant = b * b - 4.0 * a * c;
    if (discriminant < 0.0) {
        return HUGE_VAL; /* a < 0: its top lies below zero */
    }
    const double q = -0.5 * (b + copysign(sqrt(discriminant), b));
    const double roots[2] = {q / a, q != 0.0 ? c / q : 0.0};
    double first = HUGE_VAL;
    for (int i = 0; i < 2; i++) {
        if (roots[i] > 0.0 && roots[i] < first) {
            first = roots[i];
        }
    }
    return first;
}

/* A time within which the bodies cannot touch: the best over all ways of cutting the modes into slow
 * ones, which keep to their parabola within half their largest acceleration, and fast ones, which
 * stay within their amplitude. */
static double safe_stride(const aoi_relative *relative, const size_t *order, const double *x,
                          const double *v)
{
    double level = -relative->gap, rate = 0.0, bend = 0.0, best = 0.0;
    for (size_t k = 0; k < relative->n; k++) {
        const size_t j = order[k];
        level += relative->omega[j] > 0.0
                     ? hypot(x[j], v[j] / relative->omega[j])
                     : 0.0;
    }
    for (size_t k = 0; k <= relative->n; k++) {
        const size_t j = k < relative->n ? order[k] : 0;
        const int rigid_ahead = k < relative->n && relative->omega[j] == 0.0;
        if (!rigid_ahead) {
            const double stride = first_root(level, rate, bend);
            best = stride > best ? stride : best;
        }
        if (k == relative->n) {
            break;
        }
        const double omega = relative->omega[j];
        const double amplitude = omega > 0.0 ? hypot(x[j], v[j] / omega) : 0.0;
        level += x[j] - amplitude;
        rate += v[j];
        bend += 0.5 * (omega > 0.0 ? omega * omega * amplitude : relative->load[j]);
    }
    return best;
}

int aoi_relative_next_touch(const aoi_relative *relative, const size_t *order, double limit,
                            size_t most, double *x, double *v, double *flown, int *touches)
{
    double scale = relative->gap;
    *flown = 0.0;
    *touches = 0;
    for (size_t j = 0; j < relative->n; j++) {
        scale += fabs(x[j]) + (relative->omega[j] > 0.0 ? fabs(v[j]) / relative->omega[j] : 0.0);
    }
    for (size_t i = 0; i < most; i++) {
        double indentation, rate;
        aoi_relative_indentation(relative, x, v, &indentation, &rate);
        if (rate > 0.0 && indentation >= -4.0 * DBL_EPSILON * scale) {
            *touches = 1;
            return AOI_OK;
        }
        double stride = safe_stride(relative, order, x, v);
        /* At rounding from a touch that does not come, go on by what the rounding is worth. */
        const double least = rate != 0.0 ? DBL_EPSILON * scale / fabs(rate) : 0.0;
        stride = stride > least ? stride : least;
        if (*flown + stride >= limit) {
            aoi_relative_fly(relative, limit - *flown, x, v);
            *flown = limit;
            return AOI_OK;
        }
        aoi_relative_fly(relative, stride, x, v);
        *flown += stride;
    }
    return AOI_ERROR_NO_CONVERGENCE;
}
