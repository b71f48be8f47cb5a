/* Solution of the contact equation of a step. All else in a step is linear, so that the Newton-Raphson iteration
 * of the paper's section 3.1 reduces to this one equation, whatever the number of degrees of freedom. */
#include "law/equation.h"
#include "law/law.h"

#include <float.h>
#include <math.h>

/* FEW_ITERATIONS: number of iterations after which a residual within rounding suffices. MOST_ITERATIONS: limit.
 * Newton's method takes few iterations from a good guess; far above the root of a law of power n, each iteration
 * reduces the distance to the root only by 1/n of this distance. Tried: FEW_ITERATIONS = 17 changes 1 run by
 * Newmark's rule, by 2e-12, and 150 none. */
enum { FEW_ITERATIONS = 50, MOST_ITERATIONS = 2000 };

/* Largest ratio of the terms of a force to the force itself at which the force's digits are trusted: above it,
 * cancellation loses digits. Tried with a third and three times the value: 12 runs by Newmark's rule change, by a
 * relative 7e-13. */
static const double CANCELS = 16.0;

typedef struct search {
    const aoi_law *law;
    const double *memory;
    const aoi_contact_equation *equation;
    double rate_per_indentation, rest;
} search;

static double rate_at(const search *s, double x)
{
    const aoi_contact_equation *e = s->equation;
    return e->rate_free + s->rate_per_indentation * (x - e->indentation_free);
}

/* Returns the residual of the contact equation at indentation x, m; positive if x is too large. */
static double excess_at(const search *s, double x, aoi_law_value *value)
{
    const aoi_contact_equation *e = s->equation;
    aoi_law_push(s->law, s->memory, x, rate_at(s, x), value);
    return x - e->indentation_free + e->compliance * value->force;
}

/* Returns the rounding error of the residual of excess_at, m. The residual is inaccurate if x is far below the
 * free indentation, or if a damper has almost stopped the bodies. */
static double rounding_at(const search *s, const aoi_law_value *value)
{
    const aoi_contact_equation *e = s->equation;
    const double stopped = e->compliance * value->damping * e->rate_free;
    return 4.0 * DBL_EPSILON * (fabs(e->indentation_free) + fabs(stopped));
}

/* Returns the force at indentation x, N, without its derivatives. */
static double force_at(const search *s, double x)
{
    return aoi_law_push_only(s->law, s->memory, x, rate_at(s, x));
}

/* Handles a rate-dependent force that jumps at the touch to more than is needed to stop the bodies: the solution
 * is then indentation = rest, with the force that holds the bodies there. Returns 1 if this state, or no contact,
 * is the solution. */
static int ends_at_rest(const search *s, double *force, double *indentation)
{
    const aoi_contact_equation *e = s->equation;
    const double above = fmax(s->rest * (1.0 + 2.0 * DBL_EPSILON), s->rest + DBL_MIN);
    if (!(e->compliance > 0.0) ||
        !(above - e->indentation_free + e->compliance * force_at(s, above) >= 0.0)) {
        return 0;
    }
    if (e->indentation_free > s->rest) {
        *force = (e->indentation_free - s->rest) / e->compliance;
        *indentation = s->rest;
    }
    return 1;
}

/* Returns an upper bound of the solution, m: the free indentation, or a larger one for a law that pulls. */
static double upper_end(const search *s)
{
    const aoi_contact_equation *e = s->equation;
    double high = e->indentation_free;
    if (s->law->pulls) {
        aoi_law_value value;
        high = high > s->rest ? high : fmin(e->guess, DBL_MAX / 4.0);
        while (excess_at(s, high, &value) < 0.0 && high < DBL_MAX / 4.0) {
            high = s->rest + 2.0 * (high - s->rest);
        }
    }
    return high;
}

/* Returns the force at the solution x, N. If it is a small difference of large terms, one of which depends on the
 * rate, the force is taken from the contact equation: the law's force has a larger error, due to the rounding of
 * x. */
static double force_found(const search *s, double x)
{
    const aoi_contact_equation *e = s->equation;
    if (!s->law->depends_on_rate || !(e->compliance > 0.0)) {
        return force_at(s, x);
    }
    aoi_law_value value;
    (void)excess_at(s, x, &value);
    const double slope = value.stiffness + value.damping * s->rate_per_indentation;
    const double by_equation = (e->indentation_free - x) / e->compliance;
    const double rates = fabs(e->rate_free) + fabs(e->rate_compliance * by_equation);
    const double terms = fabs(value.stiffness * x) + fabs(value.damping) * rates;
    return e->compliance * slope > 1.0 && terms > CANCELS * fabs(by_equation) ? by_equation
                                                                              : value.force;
}

/* Finds the root between low and high by Newton's method, with bisection where an iterate would lie outside the
 * bracket. */
static int find_root(const search *s, double low, double high, double *force, double *indentation)
{
    const aoi_contact_equation *e = s->equation;
    double x = e->guess > low && e->guess < high ? e->guess : high;
    for (int i = 0; i < MOST_ITERATIONS; i++) {
        aoi_law_value value;
        const double excess = excess_at(s, x, &value);
        const double slope = 1.0 + e->compliance * (value.stiffness +
                                                    value.damping * s->rate_per_indentation);
        if (isnan(excess)) { /* an infinite residual only means that x is too deep */
            return isnan(value.force) ? AOI_ERROR_LAW : AOI_ERROR_NOT_FINITE;
        }
        if (excess > 0.0) {
            high = x;
        } else {
            low = x;
        }
        /* With an infinite slope any guess would pass as the root: bisect instead. */
        const double newton = isinf(slope) && excess != 0.0 ? HUGE_VAL : excess / slope;
        const double enough = 4.0 * DBL_EPSILON * x;
        double next = x - newton;
        /* The next iterate must lie strictly inside: otherwise Newton's method could jump from end to end of the
         * bracket for ever. */
        if (!(fabs(newton) <= enough || (next > low && next < high))) {
            next = 0.5 * (low + high);
        }
        const int there = fabs(newton) <= enough || fabs(next - x) <= enough || excess == 0.0 ||
                          (i >= FEW_ITERATIONS && fabs(excess) <= rounding_at(s, &value));
        x = next;
        if (there) {
            /* A force that falls with the rate may lead past the motion without force, by a rounding error. */
            *indentation = next > e->indentation_free && !s->law->pulls ? e->indentation_free : next;
            *force = force_found(s, *indentation);
            return AOI_OK;
        }
    }
    return AOI_ERROR_NO_CONVERGENCE;
}

int aoi_contact_solve(const aoi_law *law, const double *memory,
                      const aoi_contact_equation *equation, double *force, double *indentation)
{
    const double free_end = equation->indentation_free, compliance = equation->compliance;
    const double rest = law->rest ? aoi_law_rest(law, memory) : 0.0;
    if (!isfinite(free_end) || !isfinite(equation->rate_free) || !isfinite(compliance) ||
        !isfinite(equation->rate_compliance)) {
        return AOI_ERROR_NOT_FINITE;
    }
    if (compliance < 0.0 || equation->rate_compliance < 0.0) {
        return AOI_ERROR_ARGUMENT;
    }
    *force = 0.0;
    *indentation = free_end;
    if (free_end <= rest && !(law->pulls && equation->guess > rest)) {
        return AOI_OK;
    }
    const search s = {law, memory, equation,
                      compliance > 0.0 ? equation->rate_compliance / compliance : 0.0, rest};
    if (!((law->depends_on_rate || law->pulls) && ends_at_rest(&s, force, indentation))) {
        const int status = find_root(&s, rest, upper_end(&s), force, indentation);
        if (status != AOI_OK) {
            return status;
        }
    }
    /* The search ends at an indentation at which the law has not been evaluated before. */
    if (isnan(*force)) {
        return AOI_ERROR_LAW;
    }
    return isfinite(*force) && isfinite(*indentation) ? AOI_OK : AOI_ERROR_NOT_FINITE;
}
