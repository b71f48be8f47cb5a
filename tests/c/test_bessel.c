/* The integrals of sine and cosine against Legendre polynomials: by quadrature, by recurrence, and
 * across the places where the way of computing them changes. */
#include "check.h"

enum { COUNT = 8, POINTS = 4000 };

static double legendre(size_t l, double x)
{
    double before = 1.0, here = 2.0 * x - 1.0;
    if (l == 0) {
        return 1.0;
    }
    for (size_t k = 1; k < l; k++) {
        const double kd = (double)k;
        const double next = ((2.0 * kd + 1.0) * (2.0 * x - 1.0) * here - kd * before) / (kd + 1.0);
        before = here;
        here = next;
    }
    return here;
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
        aoi_bessel_trigonometric(z[i], COUNT, sine, cosine);
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
        aoi_bessel_trigonometric(z, COUNT, sine, cosine);
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
    aoi_bessel_trigonometric(z, COUNT, sine, cosine);
    for (size_t l = 0; l < COUNT; l++) {
        CHECK(near(hypot(sine[l], cosine[l]), lead, 1e-14), "l %zu: the leading term", l);
        lead *= y / (2.0 * (double)l + 3.0);
    }
}

int main(void)
{
    agrees_with_quadrature();
    recurrence_holds_over_twelve_decades();
    small_arguments_keep_their_digits();
    return check_report();
}
