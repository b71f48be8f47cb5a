/* Polynomials over a step. */
#ifndef AOI_MOTION_POLYNOMIAL_H
#define AOI_MOTION_POLYNOMIAL_H

#include "law/law.h"

/* Sum of a series of count shifted Legendre coefficients at 0 <= at <= 1 (or a little outside), and
 * its derivative with respect to at; count <= AOI_NODES + 1. */
double aoi_legendre_evaluate(size_t count, const double *coefficient, double at, double *slope);

/* Values of a series of count <= AOI_NODES + 1 coefficients at AOI_NODES or AOI_EDGE_CHECKS places. */
void aoi_legendre_at_points(size_t count, const double *coefficient, size_t points, const double *place, double *values);

/* Values of a series of AOI_NODES coefficients at the nodes of the part from `from` to from + length. */
void aoi_legendre_at_nodes(const double *coefficient, double from, double length, double *values);

/* Value of a series of AOI_NODES coefficients at the start, where P_k is (-1)^k. */
static inline double aoi_legendre_at_start(const double *coefficient)
{
    double even = 0.0, odd = 0.0;
    for (size_t k = 0; k < AOI_NODES; k += 2) {
        even += coefficient[k];
        odd += coefficient[k + 1];
    }
    return even - odd;
}

/* Sets `derivative` to the count coefficients of a series' derivative. derivative may be the same array as
 * coefficient. */
void aoi_legendre_derive(size_t count, const double *coefficient, double *derivative);

/* AOI_NODES + 1 coefficients from the values at the start and the nodes. */
void aoi_legendre_fit(double start, const double *nodes, double *coefficient);

/* Legendre coefficients of the polynomial through the nodes. */
void aoi_nodes_to_legendre(const double *nodes, double *legendre);

/* Values of the polynomial through the nodes at the nodes of the part of the step up to place; part may be nodes. */
void aoi_nodes_on_part(const double *nodes, double place, double *part);

/* The polynomial through the nodes, extrapolated to the start. */
double aoi_nodes_at_start(const double *nodes);

/* The first place in (0, 1] at which a polynomial falls to a level that lies below its value at the
 * start, as far as its values at the nodes show; returns 0 where it does not. values: at the start
 * and the nodes. */
int aoi_legendre_falls(const double *values, const double *coefficient, double level, double *place);

/* Place and value of the largest maximum of a polynomial inside (0, 1). Returns 1 if there is one. */
int aoi_legendre_top(size_t count, const double *coefficient, double *place, double *value);

/* Finds the place at which a polynomial of AOI_NODES + 1 coefficients falls to a level before its lowest minimum in
 * (0, 1), also between nodes. Returns 1 if the minimum is below depth (<= level), else 0. */
int aoi_legendre_dips(const double *coefficient, double depth, double level, double *place);

#endif
