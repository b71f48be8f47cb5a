/* Sines, cosines and spherical Bessel functions (Abramowitz and Stegun, 10.1) of four modes at a time. */
#include "motion/lanes.h"
#include "motion/oscillator.h"

#include <math.h>

/* Small number added to each angle, so that no angle is 0 and sin(x)/x is defined. Angles above 1e-19 stay
 * unchanged. Its powers up to the seventh, times any coefficient of a series below, are normal numbers: processors
 * take a hundred times as long for subnormal numbers, and each free body has an angle of 0. */
static const double LEAST = 1e-36;

/* 1.5 * 2^52: adding a number to it rounds the number to an integer. */
static const double ROUNDER = 6755399441055744.0;

/* Largest angle, about 2^31 quarter turns, for which its reduction by pi/2 in four parts is exact enough. */
static const double FARTHEST = 3e9;

/* pi/2 as the sum of four parts. The products of the first two with an integer below 2^31 are exact (W. J. Cody
 * and W. Waite, Software Manual for the Elementary Functions, 1980). */
static const double QUARTER[4] = {1.570796012878418, 3.139164164167596e-07, 6.223371969669989e-14,
                                  2.0222662487959506e-21};
static const double QUARTERS = 0.6366197723675814; /* 2/pi */

/* Taylor coefficients for angles up to pi/4, where the terms left out are below 1e-18. */
enum { TAYLOR = 8 };
static const double OF_SINE[TAYLOR] = {
    -1.0 / 6.0,         1.0 / 120.0,         -1.0 / 5040.0,          1.0 / 362880.0,
    -1.0 / 39916800.0, 1.0 / 6227020800.0, -1.0 / 1307674368000.0, 1.0 / 355687428096000.0};
static const double OF_COSINE[TAYLOR] = {
    -1.0 / 2.0,       1.0 / 24.0,         -1.0 / 720.0,         1.0 / 40320.0,
    -1.0 / 3628800.0, 1.0 / 479001600.0, -1.0 / 87178291200.0, 1.0 / 20922789888000.0};

/* Computes sines and cosines without branches: x = r + k pi/2 with |r| <= pi/4 and k in -2 .. 2, whole turns left
 * out; then sin(k pi/2) = k (2 - |k|) and cos(k pi/2) = 1 - |k|. */
static void sines(const double *restrict x, double *restrict sine, double *restrict cosine)
{
    for (size_t i = 0; i < AOI_LANES; i++) {
        const double n = (x[i] * QUARTERS + ROUNDER) - ROUNDER;
        const double k = n - 4.0 * ((0.25 * n + ROUNDER) - ROUNDER);
        const double near = ((x[i] - n * QUARTER[0]) - n * QUARTER[1]) - n * QUARTER[2];
        const double r = near - n * QUARTER[3], z = r * r;
        double s = OF_SINE[TAYLOR - 1], c = OF_COSINE[TAYLOR - 1];
        for (size_t j = TAYLOR - 1; j-- > 0;) {
            s = OF_SINE[j] + z * s;
            c = OF_COSINE[j] + z * c;
        }
        s = r + r * (z * s);
        c = 1.0 + z * c;
        const double to_cosine = k * (2.0 - fabs(k)), to_sine = 1.0 - fabs(k);
        sine[i] = s * to_sine + c * to_cosine;
        cosine[i] = c * to_sine - s * to_cosine;
    }
    for (size_t i = 0; i < AOI_LANES; i++) {
        if (!(x[i] <= FARTHEST)) {
            sine[i] = sin(x[i]);
            cosine[i] = cos(x[i]);
        }
    }
}

void aoi_turn_make(const double *omega, double time, aoi_turn *turn)
{
    turn->time = time;
    for (size_t i = 0; i < AOI_LANES; i++) {
        turn->half[i] = 0.5 * omega[i] * time + LEAST;
    }
    sines(turn->half, turn->sine, turn->cosine);
}

void aoi_turn_motions(const aoi_turn *turn, aoi_motions *motions)
{
    const double time = turn->time, square = 0.5 * time * time;
    for (size_t i = 0; i < AOI_LANES; i++) {
        const double sine = turn->sine[i], sinc = sine / turn->half[i];
        motions->impulse[i] = time * sinc * turn->cosine[i];
        motions->rate[i] = 1.0 - 2.0 * sine * sine;
        motions->step[i] = square * sinc * sinc;
    }
}

/* ------------------------------------------------------------------------------------- integrals */

/* Argument up to which the Bessel functions follow from two series by the downward recurrence, and above which the
 * upward recurrence is used: each is stable there. */
static const double UPWARD_FROM = 6.0;

/* Coefficients for l = 7 and 6 of the series j_l(y) / y^l = sum over k of
 * (-y^2/2)^k / (k! (2l+1)!! (2l+3) (2l+5) .. (2l+2k+1)). */
enum { TERMS = 18 };
static const double OF_LAST[2][TERMS] = {
    {4.9333382666716e-07, -1.450981843138706e-08, 1.9091866357088235e-10, -1.5152274886577965e-12,
     8.23493200357498e-15, -3.2939728014299924e-17, 1.0166582720462939e-19, -2.504084413907128e-22,
     5.04855728610308e-25, -8.499254690409227e-28, 1.2141792414870322e-30, -1.491620689787509e-33,
     1.593611848063578e-36, -1.494945448464895e-39, 1.2416490435754942e-42, -9.197400322781438e-46,
     6.115292767806807e-49, -3.6706439182513845e-52},
    {7.4000074000074e-06, -2.4666691333358e-07, 3.627454607846765e-09, -3.181977726181373e-11,
     1.8940343608222457e-13, -8.234932003574981e-16, 2.7449773345249934e-18, -7.26184480033067e-21,
     1.565052758691955e-23, -2.8047540478350445e-26, 4.249627345204613e-29, -5.518996552213784e-32,
     6.215086207447954e-35, -6.129276338706069e-38, 5.339090887374625e-41, -4.138830145251647e-44,
     2.8741876008691994e-47, -1.7986155199431785e-50}};

typedef double bessel[AOI_NODES][AOI_LANES];

/* Computes j_l(y) by the downward recurrence of g_l = j_l / y^l: g_(l-1) = (2l+1) g_l - y^2 g_(l+1). */
static void downward(const double *y, bessel value)
{
    double z[AOI_LANES], power[AOI_LANES];
    for (size_t i = 0; i < AOI_LANES; i++) {
        z[i] = y[i] < UPWARD_FROM ? y[i] * y[i] : 0.0; /* larger arguments are left to upward() */
        power[i] = 1.0;
    }
    for (size_t first = 0; first < 2; first++) {
        double *of = value[AOI_NODES - 1 - first];
        for (size_t i = 0; i < AOI_LANES; i++) {
            of[i] = OF_LAST[first][TERMS - 1];
        }
        for (size_t k = TERMS - 1; k-- > 0;) {
            for (size_t i = 0; i < AOI_LANES; i++) {
                of[i] = OF_LAST[first][k] + z[i] * of[i];
            }
        }
    }
    for (size_t l = AOI_NODES - 2; l > 0; l--) {
        const double odd = 2.0 * (double)l + 1.0;
        for (size_t i = 0; i < AOI_LANES; i++) {
            value[l - 1][i] = odd * value[l][i] - z[i] * value[l + 1][i];
        }
    }
    for (size_t l = 1; l < AOI_NODES; l++) {
        for (size_t i = 0; i < AOI_LANES; i++) {
            power[i] *= y[i];
            value[l][i] *= power[i];
        }
    }
}

/* Computes j_l(y) by the upward recurrence j_(l+1) = (2l+1)/y j_l - j_(l-1). */
static void upward(const aoi_turn *turn, bessel value)
{
    double inverse[AOI_LANES];
    for (size_t i = 0; i < AOI_LANES; i++) {
        inverse[i] = 1.0 / turn->half[i];
        value[0][i] = turn->sine[i] * inverse[i];
        value[1][i] = (value[0][i] - turn->cosine[i]) * inverse[i];
    }
    for (size_t l = 1; l + 1 < AOI_NODES; l++) {
        const double odd = 2.0 * (double)l + 1.0;
        for (size_t i = 0; i < AOI_LANES; i++) {
            value[l + 1][i] = odd * inverse[i] * value[l][i] - value[l - 1][i];
        }
    }
}

static void spherical_bessel(const aoi_turn *turn, bessel value)
{
    size_t slow = 0;
    for (size_t i = 0; i < AOI_LANES; i++) {
        slow += turn->half[i] < UPWARD_FROM;
    }
    if (slow == AOI_LANES) {
        downward(turn->half, value);
        return;
    }
    upward(turn, value);
    if (slow > 0) {
        bessel other;
        downward(turn->half, other);
        for (size_t l = 0; l < AOI_NODES; l++) {
            for (size_t i = 0; i < AOI_LANES; i++) {
                value[l][i] = turn->half[i] < UPWARD_FROM ? other[l][i] : value[l][i];
            }
        }
    }
}

/* The integrals of e^(iz(1-x)) P_l(x) over [0, 1], z = 2y, are (-i)^l e^(iy) j_l(y); (-i)^l takes four values in
 * turn. */
void aoi_turn_integrals(const aoi_turn *turn, aoi_integrals *integrals)
{
    bessel value;
    double share[AOI_LANES];
    spherical_bessel(turn, value);
    for (size_t i = 0; i < AOI_LANES; i++) {
        share[i] = 0.5 * turn->time / turn->half[i]; /* 1/omega, and finite without a spring */
    }
    for (size_t l = 0; l < AOI_NODES; l++) {
        const double *imaginary = l % 2 ? turn->cosine : turn->sine;
        const double *real = l % 2 ? turn->sine : turn->cosine;
        const double sign = l % 4 < 2 ? 1.0 : -1.0, other = l % 2 ? -sign : sign;
        for (size_t i = 0; i < AOI_LANES; i++) {
            integrals->impulse[l][i] = other * (imaginary[i] * value[l][i]) * share[i];
            integrals->rate[l][i] = sign * (real[i] * value[l][i]);
        }
    }
}
