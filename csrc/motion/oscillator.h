/* Motion of one mode in closed form, and the integrals of polynomial forces on it. */
#ifndef AOI_MOTION_OSCILLATOR_H
#define AOI_MOTION_OSCILLATOR_H

#include "aoimpact.h"

/* Motion of x'' + 2 decay x' + omega^2 x = f after a time, from rest. impulse: response to a unit impulse; rate:
 * its derivative; step, ramp: its first and second integrals, which are the responses to f = 1 and f = t. With x0,
 * v0 at the start and f = load + slope t:
 *   x = x0 + v0 impulse + (load - omega^2 x0) step + slope ramp,
 *   x' = v0 rate + (load - omega^2 x0) impulse + slope step. */
typedef struct aoi_motion {
    double impulse, rate, step, ramp;
} aoi_motion;

/* Sets `motion` for any omega, decay >= 0 (both 0: a free mass) and time >= 0. No digits are lost for short times. */
void aoi_oscillator_motion(double omega, double decay, double time, aoi_motion *motion);

/* Computes the integrals over x in [0, 1] of the impulse response of aoi_motion, and of its rate, at the time h (1
 * - x), times the shifted Legendre polynomials P_0 .. P_(count-1) of x; count <= AOI_NODES, h > 0. */
void aoi_oscillator_integrals(double omega, double decay, double h, size_t count, double *impulse,
                              double *rate);

/* Computes e^(-z/2) i_l(z/2) for l < count and complex z != 0 with real part >= 0. These are the integrals of
 * e^(-z(1-x)) P_l(x) over x in [0, 1]. */
void aoi_bessel_exponential(double real, double imaginary, size_t count, double *re, double *im);

#endif
