/* One mode in closed form, from free to overdamped: against the exponential of its equation's matrix,
 * and its integrals against quadrature. */
#include "numeric.h"
#include "motion/oscillator.h"

#include <string.h>

enum { SIZE = 4, TERMS = 24 };

/* In units of the time: d/dt (x, x', f, f') = A (x, x', f, f'). */
static void multiply(long double a[SIZE][SIZE], long double b[SIZE][SIZE], long double out[SIZE][SIZE])
{
    long double product[SIZE][SIZE];
    for (int i = 0; i < SIZE; i++) {
        for (int j = 0; j < SIZE; j++) {
            product[i][j] = 0.0L;
            for (int k = 0; k < SIZE; k++) {
                product[i][j] += a[i][k] * b[k][j];
            }
        }
    }
    memcpy(out, product, sizeof product);
}

/* e^A by its series where A is small, then squared as often as it was halved. */
static void exponential(double w, double s, long double out[SIZE][SIZE])
{
    long double a[SIZE][SIZE] = {{0.0L}}, term[SIZE][SIZE] = {{0.0L}};
    int halvings = 0;
    long double size = 1.0L + (long double)w * w + 2.0L * s;
    for (; size > 0.125L; size /= 2.0L) {
        halvings++;
    }
    const long double share = ldexpl(1.0L, -halvings);
    a[0][1] = a[1][2] = a[2][3] = share;
    a[1][0] = -(long double)w * w * share;
    a[1][1] = -2.0L * s * share;
    for (int i = 0; i < SIZE; i++) {
        for (int j = 0; j < SIZE; j++) {
            out[i][j] = term[i][j] = i == j;
        }
    }
    for (int k = 1; k < TERMS; k++) {
        multiply(term, a, term);
        for (int i = 0; i < SIZE * SIZE; i++) {
            term[i / SIZE][i % SIZE] /= k;
            out[i / SIZE][i % SIZE] += term[i / SIZE][i % SIZE];
        }
    }
    for (int k = 0; k < halvings; k++) {
        multiply(out, out, out);
    }
}

static void agrees(double omega, double decay, double time, double tolerance)
{
    long double e[SIZE][SIZE];
    aoi_motion ours;
    exponential(omega * time, decay * time, e);
    aoi_oscillator_motion(omega, decay, time, &ours);
    const double impulse = (double)e[0][1], rate = (double)e[1][1];
    const double step = (double)e[0][2], ramp = (double)e[0][3];
    /* Digits that a change of omega by its last bit would move are not asked for. */
    const double turned = 4e-16 * omega * time;
    CHECK(fabs(ours.impulse / time - impulse) <= tolerance * fabs(impulse) + turned / (1.0 + omega * time),
          "w t %g, s t %g: impulse %.16g, not %.16g", omega * time, decay * time, ours.impulse / time,
          impulse);
    CHECK(fabs(ours.rate - rate) <= tolerance * fabs(rate) + turned + 1e-16,
          "w t %g, s t %g: rate %.16g, not %.16g", omega * time, decay * time, ours.rate, rate);
    CHECK(near(ours.step / (time * time), step, tolerance + turned),
          "w t %g, s t %g: step %.16g, not %.16g", omega * time, decay * time,
          ours.step / (time * time), step);
    CHECK(near(ours.ramp / (time * time * time), ramp, tolerance + turned),
          "w t %g, s t %g: ramp %.16g, not %.16g", omega * time, decay * time,
          ours.ramp / (time * time * time), ramp);
}

static void every_regime_follows_its_equation(void)
{
    const double times[] = {1e-6, 0.3, 7.0};
    for (int t = 0; t < 3; t++) {
        for (int i = -8; i <= 3; i++) {
            const double w = pow(10.0, i);
            agrees(w / times[t], 0.0, times[t], 2e-14);
            for (int j = -10; j <= 3; j++) {
                agrees(w / times[t], pow(10.0, j) / times[t], times[t], 1e-12);
            }
        }
        for (int j = -8; j <= 3; j++) {
            agrees(0.0, pow(10.0, j) / times[t], times[t], 1e-12);
        }
    }
}

static void nearly_critical_damping_is_no_cliff(void)
{
    const double off[] = {-1e-3, -1e-6, -1e-9, -1e-13, 0.0, 1e-13, 1e-9, 1e-6, 1e-3};
    for (int i = -3; i <= 1; i++) {
        for (size_t k = 0; k < sizeof off / sizeof off[0]; k++) {
            const double w = 2.0 * pow(10.0, i);
            agrees(w, w * (1.0 + off[k]), 1.0, 1e-12);
        }
    }
}

static void a_free_mass_falls(void)
{
    aoi_motion ours;
    aoi_oscillator_motion(0.0, 0.0, 3.0, &ours);
    CHECK(ours.impulse == 3.0 && ours.rate == 1.0, "it keeps its velocity");
    CHECK(near(ours.step, 4.5, 1e-15) && near(ours.ramp, 4.5, 1e-15), "t^2/2 and t^3/6");
    aoi_oscillator_motion(5.0, 2.0, 0.0, &ours);
    CHECK(ours.impulse == 0.0 && ours.rate == 1.0 && ours.step == 0.0 && ours.ramp == 0.0, "no time");
}

/* ---------------------------------------------------------------------------------- integrals */

typedef struct weighted {
    double omega, decay, h;
    size_t l;
    int of_rate;
} weighted;

static double integrand(const void *data, double x)
{
    const weighted *of = data;
    aoi_motion m;
    aoi_oscillator_motion(of->omega, of->decay, of->h * (1.0 - x), &m);
    return (of->of_rate ? m.rate : m.impulse) * legendre(of->l, x);
}

static void integrals_agree(double omega, double decay, double h, double tolerance)
{
    double impulse[AOI_NODES], rate[AOI_NODES];
    aoi_oscillator_integrals(omega, decay, h, AOI_NODES, impulse, rate);
    const int panels = 40 + (int)(2.0 * (omega + decay) * h);
    double scale = 0.0;
    for (size_t l = 0; l < AOI_NODES; l++) {
        weighted of = {omega, decay, h, l, 0};
        const double exact = integral(integrand, &of, 0.0, 1.0, panels);
        of.of_rate = 1;
        const double exact_rate = integral(integrand, &of, 0.0, 1.0, panels);
        scale = fmax(scale, fabs(exact)); /* of the first, which is the mean */
        CHECK(fabs(impulse[l] - exact) <= tolerance * fmax(scale, fabs(exact)),
              "w h %g, s h %g, l %zu: %.15g, not %.15g", omega * h, decay * h, l, impulse[l], exact);
        CHECK(fabs(rate[l] - exact_rate) <= tolerance, "w h %g, s h %g, l %zu: rate %.15g, not %.15g",
              omega * h, decay * h, l, rate[l], exact_rate);
    }
}

static void integrals_are_those_of_the_motion(void)
{
    const double sizes[] = {0.0, 1e-5, 1e-2, 0.7, 1.9, 6.0, 19.0, 45.0};
    const double lengths[] = {1e-4, 2.0};
    for (int h = 0; h < 2; h++) {
        for (int i = 0; i < 8; i++) {
            for (int j = 0; j < 8; j++) {
                integrals_agree(sizes[i] / lengths[h], 0.97 * sizes[j] / lengths[h], lengths[h], 2e-12);
            }
        }
    }
}

static void integrals_of_nearly_critical_damping(void)
{
    const double off[] = {-1e-5, -3e-7, -1e-9, 0.0, 1e-9, 3e-7, 1e-5};
    for (int i = -2; i <= 1; i++) {
        for (size_t k = 0; k < sizeof off / sizeof off[0]; k++) {
            const double w = 3.0 * pow(10.0, i);
            integrals_agree(w, w * (1.0 + off[k]), 1.0, 1e-11);
        }
    }
}

/* With hardly a spring, strong damping and a long time: impulse -> (1 - e^(-w^2 t/(2 s)))/(2 s), whose
 * integral against 1 is known. */
static void slow_creep_keeps_its_digits(void)
{
    const double decay = 1e6, omega = 1.0, h = 1e6, fast = 2.0 * decay;
    const double slow = omega * omega / fast * (1.0 + omega * omega / (fast * fast));
    double impulse[AOI_NODES], rate[AOI_NODES];
    aoi_oscillator_integrals(omega, decay, h, AOI_NODES, impulse, rate);
    const double exact = (-expm1(-slow * h) / (slow * h) - 1.0 / (fast * h)) / (fast - 2.0 * slow);
    CHECK(near(impulse[0], exact, 1e-13), "creep: %.16g, not %.16g", impulse[0], exact);
}

int main(void)
{
    every_regime_follows_its_equation();
    nearly_critical_damping_is_no_cliff();
    a_free_mass_falls();
    integrals_are_those_of_the_motion();
    integrals_of_nearly_critical_damping();
    slow_creep_keeps_its_digits();
    return check_report();
}
