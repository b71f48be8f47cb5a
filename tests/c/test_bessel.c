/* The integrals of sine and cosine against Legendre polynomials, by what ties neighbours together; with quadrature
 * test_oscillator.c compares them. */
#include "check.h"
#include "motion/lanes.h"
#include "motion/oscillator.h"

enum { COUNT = 8 };

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

/* ------------------------------------------------------------------------- complex arguments */

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
    exponentials_of_any_size_are_numbers();
    recurrence_holds_over_twelve_decades();
    sines_of_many_turns_are_sines();
    return check_report();
}
