/* The secular equation, whose roots are eigenfrequencies or antiresonances squared. */
#ifndef AOI_STAR_SECULAR_H
#define AOI_STAR_SECULAR_H

#include "aoimpact.h"

/* A function of x = omega^2 with n poles, s(x) = constant + x^power (linear + sum_j weight_j / (pole_j - x)), with
 * weights > 0, poles ascending and distinct, and power 0 or 1. It is the receptance of a body (power 0) or minus
 * the dynamic stiffness of a star (power 1), and rises from pole to pole. */
typedef struct aoi_secular {
    size_t n;
    const double *pole, *weight;
    double constant, linear;
    int power;
} aoi_secular;

/* Finds the root of s between pole_gap and pole_gap+1 (0 <= gap < n-1), below the first pole (gap = -1, down to x
 * = 0) or above the last (gap = n-1, up to ceiling), by Newton's method guarded by bisection. The root is
 * pole[nearest] + offset, where nearest = n means a pole at 0: the offset is accurate also next to a pole, where x
 * itself has lost its digits. */
int aoi_secular_root(const aoi_secular *s, ptrdiff_t gap, double ceiling, size_t *nearest,
                     double *offset);

#endif
