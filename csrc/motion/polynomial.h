/* Polynomials over a step. */
#ifndef AOI_MOTION_POLYNOMIAL_H
#define AOI_MOTION_POLYNOMIAL_H

#include "aoimpact.h"

/* sum of count shifted Legendre coefficients at 0 <= at <= 1 (or a little outside), and its derivative
 * with respect to at; count <= AOI_NODES + 1. */
double aoi_legendre_evaluate(size_t count, const double *coefficient, double at, double *slope);

/* Values of AOI_NODES coefficients at the nodes of the part up to place. */
void aoi_legendre_at_nodes(const double *coefficient, double place, double *values);

/* Coefficients of the derivative; count of both, in place, too. */
void aoi_legendre_derive(size_t count, const double *coefficient, double *derivative);

/* Coefficients from the values at the start and the nodes (AOI_NODES + 1 in, as many out). */
void aoi_legendre_fit(const double *values, double *coefficient);

/* The first place in (0, 1] at which a polynomial falls to a level that lies below its value at the start,
 * as far as a look at the nodes shows; 0 where it does not. values: at the start and the nodes. */
int aoi_legendre_falls(const double *values, const double *coefficient, double level, double *place);

/* Where in (0, 1) it has its largest maximum, if it has one inside. Returns 1 then. */
int aoi_legendre_top(size_t count, const double *coefficient, double *place, double *value);

/* Where it falls to a level on its way to its least minimum in (0, 1), if that is lower than depth (<= level):
 * what a look at the nodes misses. Returns 1 then. AOI_NODES + 1 coefficients. */
int aoi_legendre_dips(const double *coefficient, double depth, double level, double *place);

#endif
