/* Second methods for the tests: Legendre polynomials by their recurrence, Gauss's quadrature, and the
 * polynomial through the Radau nodes by Lagrange's formula. */
#ifndef AOIMPACT_TEST_NUMERIC_H
#define AOIMPACT_TEST_NUMERIC_H

#include "check.h"
#include "law/law.h"
#include "motion/radau.h"

/* The shifted Legendre polynomial P_l on [0, 1]. */
static inline double legendre(size_t l, double x)
{
    double before = 1.0, here = 2.0 * x - 1.0;
    if (l == 0) {
        return 1.0;
    }
    for (size_t k = 1; k < l; k++) {
        const double kd = (double)k;
        const double next = ((2.0 * kd + 1.0) * (2.0 * x - 1.0) * here - kd * before) / (kd + 1.0);
        before = here;
        here = next;
    }
    return here;
}

/* Gauss's rule with five points on (0, 1). */
enum { GAUSS = 5 };
static const double GAUSS_AT[GAUSS] = {0.046910077030668004, 0.23076534494715845, 0.5,
                                       0.76923465505284155, 0.95308992296933200};
static const double GAUSS_WEIGHT[GAUSS] = {0.11846344252809454, 0.23931433524968324,
                                           0.28444444444444444, 0.23931433524968324,
                                           0.11846344252809454};

/* The integral over [from, to] in that many panels. */
static inline double integral(double (*f)(const void *data, double x), const void *data, double from,
                              double to, int panels)
{
    double sum = 0.0;
    const double length = (to - from) / panels;
    for (int i = 0; i < panels; i++) {
        for (int g = 0; g < GAUSS; g++) {
            sum += GAUSS_WEIGHT[g] * f(data, from + length * (i + GAUSS_AT[g]));
        }
    }
    return length * sum;
}

/* At x, the polynomial of least degree with these values at the Radau nodes. */
static inline double through_nodes(const double *values, double x)
{
    double sum = 0.0;
    for (size_t i = 0; i < AOI_NODES; i++) {
        double cardinal = 1.0;
        for (size_t k = 0; k < AOI_NODES; k++) {
            if (k != i) {
                cardinal *= (x - aoi_radau_node[k]) / (aoi_radau_node[i] - aoi_radau_node[k]);
            }
        }
        sum += values[i] * cardinal;
    }
    return sum;
}

#endif
