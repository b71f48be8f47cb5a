/* Operations on polynomials over a step. */
#ifndef AOI_MOTION_POLYNOMIAL_H
#define AOI_MOTION_POLYNOMIAL_H

#include "law/law.h"

/* Returns the sum of a series of count shifted Legendre coefficients at 0 <= at <= 1 (or a little outside), and
 * sets `slope` to its derivative with respect to at; count <= AOI_NODES + 1. */
double aoi_legendre_evaluate(size_t count, const double *coefficient, double at, double *slope);

/* Evaluates a series of count <= AOI_NODES + 1 coefficients at AOI_NODES or AOI_EDGE_CHECKS positions (place). */
void aoi_legendre_at_points(size_t count, const double *coefficient, size_t points, const double *place, double *values);

/* Evaluates a series of AOI_NODES coefficients at the nodes of the part of a step from `from` to from + length. */
void aoi_legendre_at_nodes(const double *coefficient, double from, double length, double *values);

/* Returns the value of a series of AOI_NODES coefficients at the start, where P_k is (-1)^k. */
static inline double aoi_legendre_at_start(const double *coefficient)
{
    double even = 0.0, odd = 0.0;
    for (size_t k = 0; k < AOI_NODES; k += 2) {
        even += coefficient[k];
        odd += coefficient[k + 1];
    }
    return even - odd;
}

/* Sets `derivative` to the count coefficients of the derivative of a series; it may be the same array as
 * coefficient. */
void aoi_legendre_derive(size_t count, const double *coefficient, double *derivative);

/* Finds the AOI_NODES + 1 Legendre coefficients of the polynomial with given values at the start and the nodes. */
void aoi_legendre_fit(double start, const double *nodes, double *coefficient);

/* Finds the AOI_NODES Legendre coefficients of the polynomial with given values at the nodes. */
void aoi_nodes_to_legendre(const double *nodes, double *legendre);

/* Sets `part` to the values of the polynomial through the nodal values, at the nodes of the part of the step up to
 * `place`; part may be the same array as nodes. */
void aoi_nodes_on_part(const double *nodes, double place, double *part);

/* Returns the value at the start of the polynomial through the nodal values. */
double aoi_nodes_at_start(const double *nodes);

/* Finds the first position in (0, 1] at which a polynomial falls below a level that lies below its value at the
 * start. Returns 1, or 0 if no value at a node is below the level. values: at the start and the nodes. */
int aoi_legendre_falls(const double *values, const double *coefficient, double level, double *place);

/* Finds position and value of the largest maximum of a polynomial inside (0, 1). Returns 1, or 0 if there is none. */
int aoi_legendre_top(size_t count, const double *coefficient, double *place, double *value);

/* Finds the position at which a polynomial of AOI_NODES + 1 coefficients falls to a level before its lowest
 * minimum in (0, 1), also between nodes. Returns 1 if the minimum is below depth (<= level), else 0. */
int aoi_legendre_dips(const double *coefficient, double depth, double level, double *place);

#endif
