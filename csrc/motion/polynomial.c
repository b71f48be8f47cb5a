/* Polynomials over one step, in shifted Legendre polynomials: values, positions where they fall below a level, and
 * maxima. */
#include "motion/polynomial.h"
#include "motion/radau.h"
#include "motion/nodes.h"
#include "law/law.h"

#include <float.h>
#include <math.h>
#include <string.h>

/* Coefficients (2k+1)/(k+1) and k/(k+1) of the recurrence of P_(k+1), (k+1) P_(k+1) = (2k+1) xi P_k - k P_(k-1).
 * With these coefficients the chain of dependent operations is short: one product and one difference per
 * degree. */
static const double of_last[AOI_NODES + 1] = {1.0,     3.0 / 2,  5.0 / 3,  7.0 / 4, 9.0 / 5,
                                               11.0 / 6, 13.0 / 7, 15.0 / 8, 17.0 / 9};
static const double of_one_before[AOI_NODES + 1] = {0.0,     1.0 / 2, 2.0 / 3, 3.0 / 4, 4.0 / 5,
                                                     5.0 / 6, 6.0 / 7, 7.0 / 8, 8.0 / 9};

double aoi_legendre_evaluate(size_t count, const double *coefficient, double at, double *slope)
{
    const double xi = 2.0 * at - 1.0;
    double before = 1.0, here = xi, slope_before = 0.0, slope_here = 2.0;
    double value = coefficient[0];
    *slope = 0.0;
    for (size_t k = 1; k < count; k++) {
        value += coefficient[k] * here;
        *slope += coefficient[k] * slope_here;
        const double next = (of_last[k] * xi) * here - of_one_before[k] * before;
        const double slope_next = slope_before + (4.0 * (double)k + 2.0) * here;
        before = here;
        here = next;
        slope_before = slope_here;
        slope_here = slope_next;
    }
    return value;
}

/* Evaluates a series by Clenshaw's recurrence at a constant number of points, so that compilers vectorise over the
 * points. */
static inline void at_points(size_t count, const double *restrict coefficient, size_t points,
                             const double *restrict place, double *restrict values)
{
    double xi[AOI_EDGE_CHECKS], after[AOI_EDGE_CHECKS], here[AOI_EDGE_CHECKS];
    for (size_t i = 0; i < points; i++) {
        xi[i] = 2.0 * place[i] - 1.0;
        after[i] = 0.0;
        here[i] = coefficient[count - 1];
    }
    for (size_t k = count - 1; k-- > 0;) {
        const double by_next = of_last[k], by_after = of_one_before[k + 1], own = coefficient[k];
        for (size_t i = 0; i < points; i++) {
            const double sum = own + (by_next * xi[i]) * here[i] - by_after * after[i];
            after[i] = here[i];
            here[i] = sum;
        }
    }
    memcpy(values, here, points * sizeof *values);
}

void aoi_legendre_at_points(size_t count, const double *coefficient, size_t points, const double *place, double *values)
{
    if (points == AOI_NODES) {
        at_points(count, coefficient, AOI_NODES, place, values);
    } else {
        at_points(count, coefficient, AOI_EDGE_CHECKS, place, values);
    }
}

void aoi_legendre_at_nodes(const double *coefficient, double from, double length, double *values)
{
    double place[AOI_NODES];
    for (size_t i = 0; i < AOI_NODES; i++) {
        place[i] = from + length * aoi_radau_node[i];
    }
    at_points(AOI_NODES, coefficient, AOI_NODES, place, values);
}

/* By the relation P_k' = 2 ((2k-1) P_(k-1) + (2k-5) P_(k-3) + ...) on [0, 1]. */
void aoi_legendre_derive(size_t count, const double *coefficient, double *derivative)
{
    double above[2] = {0.0, 0.0}; /* sums of the coefficients above k, of even and of odd degree */
    for (size_t k = count; k-- > 0;) {
        const double own = coefficient[k];
        derivative[k] = 2.0 * (2.0 * (double)k + 1.0) * above[(k + 1) % 2];
        above[k % 2] += own;
    }
}

void aoi_nodes_to_legendre(const double *nodes, double *legendre)
{
    for (size_t k = 0; k < AOI_NODES; k++) {
        legendre[k] = aoi_nodes_dot(aoi_radau_to_legendre[k], nodes);
    }
}

void aoi_nodes_on_part(const double *nodes, double place, double *part)
{
    double legendre[AOI_NODES];
    aoi_nodes_to_legendre(nodes, legendre);
    aoi_legendre_at_nodes(legendre, 0.0, place, part);
}

double aoi_nodes_at_start(const double *nodes)
{
    double legendre[AOI_NODES];
    aoi_nodes_to_legendre(nodes, legendre);
    return aoi_legendre_at_start(legendre);
}

void aoi_legendre_fit(double start, const double *nodes, double *coefficient)
{
    aoi_nodes_to_legendre(nodes, coefficient);
    coefficient[AOI_NODES] = 0.5 * (start - aoi_legendre_at_start(coefficient));
    coefficient[AOI_NODES - 1] -= coefficient[AOI_NODES]; /* P_8 - P_7 is 0 at the nodes, and 2 at the start */
}

/* Returns the value of a polynomial minus a level; with of_slope = 1 its slope instead. */
static double value_at(size_t count, const double *coefficient, int of_slope, double level, double at)
{
    double slope;
    const double value = aoi_legendre_evaluate(count, coefficient, at, &slope);
    return of_slope ? slope : value - level;
}

/* Returns a zero of value_at between two positions at which its signs differ, by the secant method (Illinois
 * variant). */
static double zero_between(size_t count, const double *coefficient, int of_slope, double level,
                           double low, double high)
{
    double value_low = value_at(count, coefficient, of_slope, level, low);
    double value_high = value_at(count, coefficient, of_slope, level, high);
    if ((value_low > 0.0) == (value_high > 0.0)) { /* the change of sign is lost in rounding */
        return fabs(value_low) < fabs(value_high) ? low : high;
    }
    int side = 0;
    for (int i = 0; i < 60 && high - low > DBL_EPSILON && value_high != value_low; i++) {
        const double at = low - value_low * (high - low) / (value_high - value_low);
        const double value = value_at(count, coefficient, of_slope, level, at);
        if (value == 0.0) {
            return at;
        }
        if ((value > 0.0) == (value_low > 0.0)) {
            low = at;
            value_low = value;
            value_high *= side == 1 ? 0.5 : 1.0;
            side = 1;
        } else {
            high = at;
            value_high = value;
            value_low *= side == 2 ? 0.5 : 1.0;
            side = 2;
        }
    }
    return fabs(value_low) < fabs(value_high) ? low : high;
}

int aoi_legendre_falls(const double *values, const double *coefficient, double level, double *place)
{
    for (size_t i = 1; i <= AOI_NODES; i++) {
        if (values[i] < level) {
            *place = zero_between(AOI_NODES + 1, coefficient, 0, level,
                                  i > 1 ? aoi_radau_node[i - 2] : 0.0, aoi_radau_node[i - 1]);
            return 1;
        }
    }
    return 0;
}

/* Finds the derivative of a series of count coefficients, and the values of the derivative at the start and the
 * nodes. */
static void derive(size_t count, const double *coefficient, double *derived, double *values)
{
    memset(derived, 0, (AOI_NODES + 1) * sizeof *derived);
    aoi_legendre_derive(count, coefficient, derived);
    values[0] = aoi_legendre_at_start(derived);
    aoi_legendre_at_nodes(derived, 0.0, 1.0, values + 1);
}

int aoi_legendre_top(size_t count, const double *coefficient, double *place, double *value)
{
    double slope[AOI_NODES + 1], bend[AOI_NODES + 1], derived[AOI_NODES + 1], twice[AOI_NODES + 1], ignored, rest = 0.0;
    int found = 0;
    for (size_t k = 2; k < count; k++) { /* |P_k'| <= k (k+1) on [0, 1] */
        rest += fabs(coefficient[k]) * 0.5 * (double)(k * (k + 1));
    }
    if (fabs(coefficient[1]) > rest) {
        return 0; /* the polynomial is monotonic */
    }
    derive(count, coefficient, derived, slope);
    derive(count, derived, twice, bend);
    for (size_t i = 0; i < AOI_NODES; i++) {
        double from = i > 0 ? aoi_radau_node[i - 1] : 0.0, to = aoi_radau_node[i];
        int rises = slope[i] > 0.0, falls = slope[i + 1] <= 0.0;
        if (rises != falls && (bend[i] > 0.0) == falls && (bend[i + 1] > 0.0) == rises) {
            /* The slope has an extremum nearest to zero in this interval: if its sign changes there, a maximum and
             * a minimum lie side by side. */
            const double middle = zero_between(count, derived, 1, 0.0, from, to);
            const int up = aoi_legendre_evaluate(count, derived, middle, &ignored) > 0.0;
            from = up ? middle : from;
            to = up ? to : middle;
            rises = rises || up;
            falls = falls || !up;
        }
        if (rises && falls) {
            const double at = zero_between(count, coefficient, 1, 0.0, from, to);
            const double here = aoi_legendre_evaluate(count, coefficient, at, &ignored);
            if (!found || here > *value) {
                *value = here;
                *place = at;
                found = 1;
            }
        }
    }
    return found;
}

int aoi_legendre_dips(const double *coefficient, double depth, double level, double *place)
{
    double turned[AOI_NODES + 1], bottom = 0.0, value = 0.0, slope;
    for (size_t k = 0; k <= AOI_NODES; k++) {
        turned[k] = -coefficient[k];
    }
    if (!aoi_legendre_top(AOI_NODES + 1, turned, &bottom, &value) || !(-value < depth)) {
        return 0;
    }
    double before = 0.0;
    for (size_t i = 0; i < AOI_NODES && aoi_radau_node[i] < bottom; i++) {
        before = aoi_radau_node[i];
    }
    if (!(aoi_legendre_evaluate(AOI_NODES + 1, coefficient, before, &slope) > level)) {
        return 0;
    }
    *place = zero_between(AOI_NODES + 1, coefficient, 0, level, before, bottom);
    return 1;
}
