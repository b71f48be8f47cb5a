/* The one nonlinear equation of a step. Everything else in a step is linear, so Newton-Raphson of
 * the paper's section 3.1 reduces to it whatever the number of degrees of freedom. */
#include "aoimpact.h"

#include <float.h>
#include <math.h>

/* A few from a near guess; far above the root of a steep law, Newton only takes off a share 1/n. */
enum { MOST_ITERATIONS = 2000 };

int aoi_contact_solve(const aoi_law *law, const aoi_contact_equation *equation, double *force,
                      double *indentation)
{
    const double free_end = equation->indentation_free, compliance = equation->compliance;
    if (!isfinite(free_end) || !isfinite(equation->rate_free)) {
        return AOI_ERROR_NOT_FINITE;
    }
    *force = 0.0;
    *indentation = free_end;
    if (free_end <= 0.0) {
        return AOI_OK;
    }
    const double rate_per_indentation =
        compliance > 0.0 ? equation->rate_compliance / compliance : 0.0;
    double low = 0.0, high = free_end;
    double x = equation->guess > low && equation->guess < high ? equation->guess : high;
    for (int i = 0; i < MOST_ITERATIONS; i++) {
        aoi_law_value value;
        law->force(law, x, equation->rate_free + rate_per_indentation * (x - free_end), &value);
        const double excess = x - free_end + compliance * value.force;
        const double slope =
            1.0 + compliance * (value.stiffness + value.damping * rate_per_indentation);
        if (isnan(excess)) { /* infinite is merely too deep */
            return AOI_ERROR_NOT_FINITE;
        }
        if (excess > 0.0) {
            high = x;
        } else {
            low = x;
        }
        const double newton = excess / slope;
        double next = x - newton;
        /* Strictly inside, or Newton could jump from end to end of the bracket for ever. */
        if (!(fabs(newton) <= 4.0 * DBL_EPSILON * x || (next > low && next < high))) {
            next = 0.5 * (low + high);
        }
        const double moved = fabs(next - x);
        x = next;
        if (moved <= 4.0 * DBL_EPSILON * x || excess == 0.0) {
            law->force(law, x, equation->rate_free + rate_per_indentation * (x - free_end), &value);
            *force = value.force;
            *indentation = x;
            return AOI_OK;
        }
    }
    return AOI_ERROR_NO_CONVERGENCE;
}
