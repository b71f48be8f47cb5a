/* Integrals of exponentials times Legendre polynomials, by modified spherical Bessel functions of complex
 * arguments (Abramowitz and Stegun, 10.1.14 and 10.2). Each function is computed in the direction in which its
 * recurrence is stable. */
#include "motion/oscillator.h"

#include <float.h>
#include <math.h>

enum { MOST = 16, MARGIN = 48, SERIES_TERMS = 14 };

/* Modulus of the argument from which on the upward recurrence loses at most one digit at the orders used. */
static const double UPWARD_FROM = 20.0;

typedef struct complex_number {
    double re, im;
} complex_number;

static complex_number times(complex_number a, complex_number b)
{
    return (complex_number){a.re * b.re - a.im * b.im, a.re * b.im + a.im * b.re};
}

static complex_number over(complex_number a, complex_number b)
{
    const double size = b.re * b.re + b.im * b.im;
    return (complex_number){(a.re * b.re + a.im * b.im) / size, (a.im * b.re - a.re * b.im) / size};
}

static complex_number scaled(complex_number a, double factor)
{
    return (complex_number){factor * a.re, factor * a.im};
}

static complex_number sum(complex_number a, complex_number b)
{
    return (complex_number){a.re + b.re, a.im + b.im};
}

/* Returns the number of terms of the series of i_0(y), down to the square of the machine precision: the real part
 * of the sum may be smaller than the imaginary part by a factor as small as rounding, or the reverse. More terms
 * would only take time, most of all if they underflow. */
static int terms_of(complex_number square)
{
    const double size = hypot(square.re, square.im);
    int count = 1;
    for (double term = 1.0; count < SERIES_TERMS && term > DBL_EPSILON * DBL_EPSILON; count++) {
        term *= size / (2.0 * count * (2.0 * count + 1.0));
    }
    return count;
}

/* Computes e^-y i_l(y) for l < count by its power series, for |y| < 1. left: e^-y. */
static void exponential_series(complex_number y, complex_number left, size_t count,
                               complex_number *value)
{
    const complex_number square = times(y, y);
    const int terms = terms_of(square);
    complex_number lead = left;
    for (size_t l = 0; l < count; l++) {
        complex_number term = lead, total = lead;
        for (int k = 1; k < terms; k++) {
            term = scaled(times(term, square), 1.0 / (2.0 * k * (2.0 * (double)l + 2.0 * k + 1.0)));
            total = sum(total, term);
        }
        value[l] = total;
        lead = scaled(times(lead, y), 1.0 / (2.0 * (double)l + 3.0));
    }
}

/* Computes e^-y i_l(y) by Miller's algorithm: the recurrence i_(l-1) = i_(l+1) + (2l+1)/y i_l runs downward from
 * large l, and the result is scaled to the given i_0 or i_1, whichever is larger. */
static void exponential_downward(complex_number y, complex_number i0, complex_number i1,
                                 size_t count, complex_number *value)
{
    /* The start value may grow by a factor of 113!! without overflow, and its square does not underflow. */
    complex_number above = {0.0, 0.0}, here = {1e-60, 0.0};
    const complex_number inverse = over((complex_number){1.0, 0.0}, y);
    for (size_t l = count + MARGIN; l > 0; l--) {
        const complex_number below = sum(above, scaled(times(inverse, here), 2.0 * (double)l + 1.0));
        above = here;
        here = below;
        if (l - 1 < count) {
            value[l - 1] = here;
        }
    }
    const int first = hypot(i0.re, i0.im) > hypot(i1.re, i1.im);
    const complex_number factor = first ? over(i0, value[0]) : over(i1, value[1]);
    for (size_t l = 0; l < count; l++) {
        value[l] = times(value[l], factor);
    }
}

void aoi_bessel_exponential(double real, double imaginary, size_t count, double *re, double *im)
{
    const complex_number y = {0.5 * real, 0.5 * imaginary};
    const double size = hypot(y.re, y.im), left = exp(-real);
    /* e^-2y */
    const complex_number twice = {left * cos(imaginary), -left * sin(imaginary)};
    complex_number value[MOST] = {{0.0, 0.0}};
    if (size < 1.0) {
        const double half_left = exp(-y.re);
        exponential_series(y, (complex_number){half_left * cos(y.im), -half_left * sin(y.im)}, count,
                           value);
    } else {
        const complex_number one = {1.0, 0.0};
        const complex_number i0 = scaled(over(sum(one, scaled(twice, -1.0)), y), 0.5);
        const complex_number i1 = over(sum(scaled(sum(one, twice), 0.5), scaled(i0, -1.0)), y);
        if (size < UPWARD_FROM) {
            exponential_downward(y, i0, i1, count, value);
        } else {
            value[0] = i0;
            value[1] = i1;
            for (size_t l = 1; l + 1 < count; l++) {
                value[l + 1] = sum(value[l - 1],
                                   scaled(over(value[l], y), -(2.0 * (double)l + 1.0)));
            }
        }
    }
    for (size_t l = 0; l < count; l++) {
        re[l] = value[l].re;
        im[l] = value[l].im;
    }
}
