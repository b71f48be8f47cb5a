/* The integrals of sine and cosine against Legendre polynomials: by quadrature, by recurrence, and
 * across the places where the way of computing them changes. */
#include "numeric.h"
#include "motion/lanes.h"
#include "motion/oscillator.h"

#include <fenv.h>

enum { COUNT = 8, HIGHEST = 16, POINTS = 4000 };

/* The integrals of sin z(1-x) and cos z(1-x). */
static void trigonometric(double z, double sine[COUNT], double cosine[COUNT])
{
    const double omega[AOI_LANES] = {0.0, z, 2.0 * z, 1e6}; /* the neighbours change nothing */
    aoi_turn turn;
    aoi_integrals of;
    aoi_turn_make(omega, 1.0, &turn);
    aoi_turn_integrals(&turn, &of);
    for (size_t l = 0; l < COUNT; l++) {
        sine[l] = z * of.impulse[l][1];
        cosine[l] = of.rate[l][1];
    }
}

/* Simpson's rule for int_0^1 f(z (1-x)) P_l(x) dx. */
static double by_quadrature(double (*f)(double), double z, size_t l)
{
    double sum = 0.0;
    for (int i = 0; i <= POINTS; i++) {
        const double x = (double)i / POINTS;
        const double weight = i == 0 || i == POINTS ? 1.0 : (i % 2 ? 4.0 : 2.0);
        sum += weight * f(z * (1.0 - x)) * legendre(l, x);
    }
    return sum / (3.0 * POINTS);
}

static void agrees_with_quadrature(void)
{
    const double z[] = {1e-3, 0.5, 1.9, 2.0, 2.1, 5.0, 15.9, 16.1, 30.0, 60.0};
    for (size_t i = 0; i < sizeof z / sizeof z[0]; i++) {
        double sine[COUNT], cosine[COUNT];
        trigonometric(z[i], sine, cosine);
        for (size_t l = 0; l < COUNT; l++) {
            const double s = by_quadrature(sin, z[i], l), c = by_quadrature(cos, z[i], l);
            CHECK(fabs(sine[l] - s) < 2e-9, "z %g, l %zu: sine %g, not %g", z[i], l, sine[l], s);
            CHECK(fabs(cosine[l] - c) < 2e-9, "z %g, l %zu: cosine %g, not %g", z[i], l, cosine[l], c);
        }
    }
}

/* j_l' = j_(l-1) - (l+1)/y j_l ties neighbours together; here by the modulus of the pair. */
static void recurrence_holds_over_twelve_decades(void)
{
    for (int i = -48; i <= 24; i++) {
        const double z = 2.0 * pow(10.0, 0.25 * i), y = 0.5 * z;
        double sine[COUNT], cosine[COUNT], bessel[COUNT];
        trigonometric(z, sine, cosine);
        for (size_t l = 0; l < COUNT; l++) {
            bessel[l] = hypot(sine[l], cosine[l]);
        }
        CHECK(near(bessel[0], fabs(sin(y) / y), 1e-14), "z %g: j_0", z);
        for (size_t l = 1; l + 1 < COUNT; l++) {
            /* y (j_(l-1) + j_(l+1)) = (2l+1) j_l, up to the signs that hypot has taken away. */
            const double sum = bessel[l - 1] + bessel[l + 1];
            const double difference = fabs(bessel[l - 1] - bessel[l + 1]);
            const double wanted = (2.0 * (double)l + 1.0) / y * bessel[l];
            const double scale = bessel[l - 1] + bessel[l + 1];
            CHECK(fabs(sum - wanted) < 1e-12 * scale || fabs(difference - wanted) < 1e-12 * scale,
                  "z %g, l %zu: %g or %g, not %g", z, l, sum, difference, wanted);
        }
    }
}

/* For small z, j_l ~ y^l / (2l+1)!!: relative accuracy far below what a sum could keep. */
static void small_arguments_keep_their_digits(void)
{
    const double z = 2e-8, y = 1e-8;
    double sine[COUNT], cosine[COUNT], lead = 1.0;
    trigonometric(z, sine, cosine);
    for (size_t l = 0; l < COUNT; l++) {
        CHECK(near(hypot(sine[l], cosine[l]), lead, 1e-14), "l %zu: the leading term", l);
        lead *= y / (2.0 * (double)l + 3.0);
    }
}

/* ------------------------------------------------------------------------- complex arguments */

typedef struct argument {
    double real, imaginary;
    size_t l;
    int part;
} argument;

/* e^(-z (1-x)) P_l(x), a part of it. */
static double falling(const void *data, double x)
{
    const argument *z = data;
    const double angle = z->imaginary * (1.0 - x);
    return exp(-z->real * (1.0 - x)) * (z->part ? -sin(angle) : cos(angle)) * legendre(z->l, x);
}

static void exponentials_agree_with_quadrature(void)
{
    const double size[] = {1e-4, 0.3, 1.0, 1.99, 2.01, 3.7, 9.0, 25.0, 39.9, 40.1, 70.0, 300.0};
    for (size_t i = 0; i < sizeof size / sizeof size[0]; i++) {
        for (int turn = -6; turn <= 6; turn++) {
            const int panels = 100 + (int)size[i];
            double re[HIGHEST], im[HIGHEST];
            argument z = {size[i] * cos(PI / 12.0 * turn), size[i] * sin(PI / 12.0 * turn), 0, 0};
            z.real = turn == -6 || turn == 6 ? 0.0 : z.real;
            aoi_bessel_exponential(z.real, z.imaginary, HIGHEST, re, im);
            for (z.l = 0; z.l < HIGHEST; z.l++) {
                z.part = 0;
                const double real = integral(falling, &z, 0.0, 1.0, panels);
                z.part = 1;
                const double imaginary = integral(falling, &z, 0.0, 1.0, panels);
                const double most = z.l < COUNT ? 2e-14 : 1e-12; /* the upward recurrence */
                CHECK(fabs(re[z.l] - real) < most, "z %g + %g i, l %zu: %.15g, not %.15g", z.real,
                      z.imaginary, z.l, re[z.l], real);
                CHECK(fabs(im[z.l] - imaginary) < most, "z %g + %g i, l %zu: %.15g i, not %.15g i",
                      z.real, z.imaginary, z.l, im[z.l], imaginary);
            }
        }
    }
}

/* |P_l| <= 1 and |e^-z| <= 1 bound the integral, from z that do nothing to those that leave nothing. */
static void exponentials_of_any_size_are_numbers(void)
{
    for (int i = -60; i <= 60; i++) {
        for (int turn = 0; turn <= 4; turn++) {
            const double size = pow(10.0, 0.2 * i), angle = PI / 8.0 * turn;
            double re[COUNT], im[COUNT];
            aoi_bessel_exponential(turn == 4 ? 0.0 : size * cos(angle), size * sin(angle), COUNT, re, im);
            for (size_t l = 0; l < COUNT; l++) {
                CHECK(isfinite(re[l]) && isfinite(im[l]), "|z| %g, l %zu: a number", size, l);
                CHECK(hypot(re[l], im[l]) <= 1.0 + 1e-14, "|z| %g, l %zu: no more than 1", size, l);
            }
        }
    }
}

/* Angles of far more turns than a division by pi/2 leaves digits of, in one lane beside small ones. */
static void sines_of_many_turns_are_sines(void)
{
    for (double angle = 1e8; angle < 1e300; angle *= 30.0) {
        const double omega[AOI_LANES] = {1.0, 2.0 * angle, 3.0, 4.0};
        aoi_turn turn;
        aoi_turn_make(omega, 1.0, &turn);
        CHECK(fabs(turn.sine[1] - sin(angle)) < 4e-16 && fabs(turn.cosine[1] - cos(angle)) < 4e-16,
              "%g rad: sine %.16g, not %.16g", angle, turn.sine[1], sin(angle));
        CHECK(near(turn.sine[0], sin(0.5), 4e-16), "beside it: %.16g", turn.sine[0]);
    }
}

int main(void)
{
    exponentials_agree_with_quadrature();
    exponentials_of_any_size_are_numbers();
    agrees_with_quadrature();
    recurrence_holds_over_twelve_decades();
    small_arguments_keep_their_digits();
    sines_of_many_turns_are_sines();
    return check_report();
}
