/* The secular equation. */
#ifndef AOI_STAR_SECULAR_H
#define AOI_STAR_SECULAR_H

#include "aoimpact.h"

/* A function with n poles, s(x) = constant + x^power (linear + sum_j weight_j / (pole_j - x)), with
 * weights > 0, poles ascending and distinct, power 0 or 1: the receptance (0), minus the dynamic
 * stiffness of a star (1). It rises from pole to pole. */
typedef struct aoi_secular {
    size_t n;
    const double *pole, *weight;
    double constant, linear;
    int power;
} aoi_secular;

/* The root of s between pole_gap and pole_gap+1 (0 <= gap < n-1), below the first (gap = -1, down
 * to x = 0) or above the last (gap = n-1, up to ceiling), as pole[nearest] + offset: the offset
 * keeps the relative accuracy that x itself has lost beside a pole. Bisection-guarded Newton. */
int aoi_secular_root(const aoi_secular *s, ptrdiff_t gap, double ceiling, size_t *nearest,
                     double *offset);

#endif
