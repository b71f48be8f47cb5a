/* Integrals of sines and cosines against Legendre polynomials: spherical Bessel functions
 * (Abramowitz and Stegun, 10.1.14), each computed in the direction in which it is stable. */
#include "aoimpact.h"

#include <float.h>
#include <math.h>

enum { MOST = 16, MARGIN = 24, SERIES_TERMS = 14 };

/* y^l / (2l+1)!! (1 - y^2/2/(2l+3) + ...): for y < 1, where the recurrences lose digits. */
static void series(double y, size_t count, double *bessel)
{
    double lead = 1.0;
    for (size_t l = 0; l < count; l++) {
        double term = lead, sum = lead;
        for (int k = 1; k < SERIES_TERMS; k++) {
            term *= -y * y / (2.0 * k * (2.0 * (double)l + 2.0 * k + 1.0));
            sum += term;
        }
        bessel[l] = sum;
        lead *= y / (2.0 * (double)l + 3.0);
    }
}

/* Miller: downward from far above, scaled by whichever of j_0, j_1 is not near a zero. */
static void downward(double y, double j0, double j1, size_t count, double *bessel)
{
    double above = 0.0, here = 1e-250;
    for (size_t l = count + MARGIN; l > 0; l--) {
        const double below = (2.0 * (double)l + 1.0) / y * here - above;
        above = here;
        here = below;
        if (l - 1 < count) {
            bessel[l - 1] = here;
        }
    }
    const double scale = fabs(j0) > fabs(j1) ? j0 / bessel[0] : j1 / bessel[1];
    for (size_t l = 0; l < count; l++) {
        bessel[l] *= scale;
    }
}

static void spherical_bessel(double y, double sine, double cosine, size_t count, double *bessel)
{
    const double j0 = sine / y, j1 = (j0 - cosine) / y;
    if (y < 1.0) {
        series(y, count, bessel);
    } else if (y <= (double)count) {
        downward(y, j0, j1, count, bessel);
    } else {
        bessel[0] = j0;
        bessel[1] = j1;
        for (size_t l = 1; l + 1 < count; l++) {
            bessel[l + 1] = (2.0 * (double)l + 1.0) / y * bessel[l] - bessel[l - 1];
        }
    }
}

void aoi_bessel_trigonometric(double z, size_t count, double *sine, double *cosine)
{
    const double y = 0.5 * z, s = sin(y), c = cos(y);
    double bessel[MOST] = {0.0};
    spherical_bessel(y, s, c, count, bessel);
    /* e^(iy) (-i)^l goes round through four quarters. */
    const double real[4] = {c, s, -c, -s}, imaginary[4] = {s, -c, -s, c};
    for (size_t l = 0; l < count; l++) {
        sine[l] = imaginary[l % 4] * bessel[l];
        cosine[l] = real[l % 4] * bessel[l];
    }
}
