/* Section 2 of the paper on bodies whose anti-oscillators are known in closed form: chains of equal
 * masses and springs, a rigid bar struck off its centre; and the algebra of the constraint. */
#include "chain.h"
#include "linear/vector.h"
#include "star/reduce.h"

#include <string.h>

/* Deflection of a chain constrained at both ends: k0 is that of its two parts side by side. */
static void held_chain_is_two_springs(void)
{
    enum { N = 9 };
    double b[N], x[N], stiffness;
    for (int at = 0; at < N; at++) {
        for (int scale = 1; scale <= 2; scale++) {
            const double near_end = at + 1.0, far_end = N - at;
            for (int i = 0; i < N; i++) {
                b[i] = i == at ? scale : 0.0;
                x[i] = scale * (i <= at ? (i + 1.0) * far_end : (N - i) * near_end) / (N + 1.0);
            }
            CHECK(aoi_static_constrained(N, b, x, &stiffness) == AOI_OK, "struck at %d", at);
            CHECK(near(stiffness, (1.0 / near_end + 1.0 / far_end) / (scale * scale), 1e-14),
                  "k0 of springs 1/%g and 1/%g, not %g", near_end, far_end, stiffness);
            CHECK(near(aoi_vector_dot(N, b, x), 1.0, 1e-15),
                  "the static mode has b phi = 1, eq. (3)");
        }
    }
}

static void static_mode_of_no_held_body(void)
{
    double b[2] = {0.0, 0.0}, x[2] = {1.0, 2.0}, stiffness;
    CHECK(aoi_static_constrained(2, b, x, &stiffness) == AOI_ERROR_UNREACHED, "b = 0");
    CHECK(aoi_static_constrained(0, NULL, NULL, &stiffness) == AOI_ERROR_UNREACHED, "no dofs");
    b[0] = 1.0;
    x[0] = -1.0;
    CHECK(aoi_static_constrained(2, b, x, &stiffness) == AOI_ERROR_NOT_POSITIVE,
          "it moves against the force");
    x[0] = 0.0;
    CHECK(aoi_static_constrained(2, b, x, &stiffness) == AOI_ERROR_NOT_POSITIVE, "it does not move");
    x[0] = (double)NAN;
    CHECK(aoi_static_constrained(2, b, x, &stiffness) == AOI_ERROR_NOT_FINITE, "x is NaN");
    x[0] = (double)INFINITY;
    CHECK(aoi_static_constrained(2, b, x, &stiffness) == AOI_ERROR_NOT_FINITE, "x is infinite");
}

/* A rigid bar of mass M and inertia J struck at distance d has the mass 1 / (1/M + d^2/J), and its
 * point at distance y moves by (1/M + d y/J) times that. */
static void struck_bar_has_its_effective_mass(void)
{
    enum { N = 11 };
    double rigid[2 * N], b[N], phi[N], mass, inertia = 0.0;
    for (int i = 0; i < N; i++) {
        inertia += square(i - 5.0);
    }
    for (int i = 0; i < N; i++) {
        rigid[i] = 1.0 / sqrt((double)N);
        rigid[N + i] = (i - 5.0) / sqrt(inertia);
    }
    for (int at = 0; at < N; at++) {
        const double d = at - 5.0, wanted = 1.0 / (1.0 / N + d * d / inertia);
        double worst = 0.0;
        memset(b, 0, sizeof b);
        b[at] = 1.0;
        CHECK(aoi_static_free(N, 2, rigid, b, phi, &mass) == AOI_OK, "struck at %d", at);
        CHECK(near(mass, wanted, 1e-14), "effective mass at %g: %.17g, not %.17g", d, wanted, mass);
        for (int i = 0; i < N; i++) {
            worst = fmax(worst, fabs(phi[i] - wanted * (1.0 / N + d * (i - 5.0) / inertia)));
        }
        CHECK(worst < 1e-14, "the bar turns about its centre of percussion, off by %g", worst);
    }
    /* A couple of forces moves the bar's ends against each other: the translation does not feel it.
     */
    memset(b, 0, sizeof b);
    b[0] = -1.0;
    b[N - 1] = 1.0;
    CHECK(aoi_static_free(N, 1, rigid, b, phi, &mass) == AOI_ERROR_UNREACHED,
          "a couple does not reach the translation");
    CHECK(aoi_static_free(N, 0, rigid, b, phi, &mass) == AOI_ERROR_UNREACHED, "no rigid modes");
    CHECK(aoi_static_free(N, 2, rigid, b, phi, &mass) == AOI_OK, "it reaches the rotation");
    CHECK(near(mass, inertia / 100.0, 1e-14), "with J / (2 d)^2");
    b[3] = (double)NAN;
    CHECK(aoi_static_free(N, 2, rigid, b, phi, &mass) == AOI_ERROR_NOT_FINITE, "b has a NaN");
}

/* Rounding alone, as it comes out of r = R^T b for a b that moves no rigid mode, is no reach. */
static void rounding_reaches_nothing(void)
{
    enum { N = 1000 };
    double rigid[N], b[N], phi[N], mass, sum = 0.0;
    uint64_t seed = 3;
    for (int i = 0; i < N; i++) {
        rigid[i] = 1.0 / sqrt((double)N);
        b[i] = uniform(&seed);
        sum += b[i];
    }
    for (int i = 0; i < N; i++) {
        b[i] -= sum / N;
    }
    CHECK(aoi_static_free(N, 1, rigid, b, phi, &mass) == AOI_ERROR_UNREACHED,
          "sum of b is rounding");
    b[0] += 1e-4;
    CHECK(aoi_static_free(N, 1, rigid, b, phi, &mass) == AOI_OK, "a net force of 1e-4 is not");
    CHECK(near(mass, N * 1e8, 1e-8), "it feels the whole mass, %.17g", mass);
}

static void constrained_solution_keeps_the_constraint(void)
{
    enum { N = 20 };
    double a[N], b[N], f[N], x[N], z[N];
    uint64_t seed = 11;
    for (int trial = 0; trial < 50; trial++) {
        const double softness = decades(&seed, -12.0, 12.0),
                     along = trial % 2 ? 1e9 / softness : 0.0;
        for (int i = 0; i < N; i++) {
            a[i] = decades(&seed, -1.0, 1.0);
            b[i] = softness * (uniform(&seed) - 0.5);
            f[i] = uniform(&seed) - 0.5 +
                   along * b[i]; /* most of it may be taken up by the constraint */
            x[i] = f[i] / a[i];
            z[i] = b[i] / a[i];
        }
        CHECK(aoi_constraint_project(N, b, z, x) == AOI_OK, "trial %d", trial);
        const double size = sqrt(aoi_vector_dot(N, b, b) * aoi_vector_dot(N, x, x));
        CHECK(fabs(aoi_vector_dot(N, b, x)) < 1e-15 * size, "b x = 0, not %g of |b||x|",
              aoi_vector_dot(N, b, x) / size);
        double mu = 0.0, worst = 0.0;
        for (int i = 0; i < N; i++) {
            mu += b[i] * (f[i] - a[i] * x[i]) / aoi_vector_dot(N, b, b);
        }
        for (int i = 0; i < N; i++) {
            worst = fmax(worst, fabs(a[i] * x[i] + mu * b[i] - f[i]));
        }
        CHECK(worst < 1e-13 * (1.0 + fabs(along) * softness),
              "the constraint's force is along b, off by %g", worst);
    }
    memset(b, 0, sizeof b);
    CHECK(aoi_constraint_project(N, b, z, x) == AOI_ERROR_NOT_POSITIVE, "b = 0");
    b[0] = -1.0;
    z[0] = 1.0;
    CHECK(aoi_constraint_project(N, b, z, x) == AOI_ERROR_NOT_POSITIVE,
          "A is not positive definite");
    z[0] = (double)NAN;
    CHECK(aoi_constraint_project(N, b, z, x) == AOI_ERROR_NOT_POSITIVE, "z is NaN");
}

static void reflector_check(size_t n, const double *b, const char *what)
{
    double h[16];
    CHECK(aoi_constraint_reflector(n, b, h) == AOI_OK, "%s", what);
    CHECK(near(aoi_vector_dot(n, h, h), 2.0, 4e-16 * (double)n), "%s: h h = 2", what);
    const double hb = aoi_vector_dot(n, h, b), norm = sqrt(aoi_vector_dot(n, b, b));
    for (size_t i = 0; i < n; i++) {
        const double image = b[i] - h[i] * hb;
        CHECK(fabs(i == 0 ? fabs(image) - norm : image) < 4e-16 * (double)n * norm,
              "%s: reflected b has entry %zu = %g", what, i, image);
    }
}

static void reflection_takes_b_to_the_first_axis(void)
{
    const double along[] = {2.0, 0.0, 0.0}, against[] = {-2.0, 0.0, 0.0},
                 across[] = {0.0, 3.0, -4.0};
    const double nearly[] = {1.0, 1e-9, -1e-17}, tiny[] = {1e-120, -2e-120}, one[] = {-5.0};
    const double small_first[] = {1e-20, 1.0};
    reflector_check(3, along, "b along e_1");
    reflector_check(3, against, "b against e_1");
    reflector_check(3, across, "b across e_1");
    reflector_check(3, nearly, "b nearly along e_1");
    reflector_check(2, tiny, "a tiny b");
    reflector_check(1, one, "one dof");
    reflector_check(2, small_first, "a first entry that rounding loses");
    double h[2], b[2] = {0.0, 0.0};
    CHECK(aoi_constraint_reflector(2, b, h) == AOI_ERROR_UNREACHED, "b = 0");
    CHECK(aoi_constraint_reflector(0, NULL, NULL) == AOI_ERROR_UNREACHED, "no dofs");
    b[1] = (double)NAN;
    CHECK(aoi_constraint_reflector(2, b, h) == AOI_ERROR_NOT_FINITE, "b is NaN");
    b[1] = 1e200;
    CHECK(aoi_constraint_reflector(2, b, h) == AOI_ERROR_NOT_FINITE, "b b overflows");
}

static void congruence_is_the_dense_product(void)
{
    enum { N = 8 };
    double a[N * N], was[N * N], h[N], b[N], q[N][N], work[N];
    uint64_t seed = 5;
    for (int i = 0; i < N; i++) {
        b[i] = uniform(&seed) - 0.5;
        for (int j = 0; j <= i; j++) {
            a[i * N + j] = a[j * N + i] = uniform(&seed) - 0.5;
        }
    }
    memcpy(was, a, sizeof a);
    aoi_constraint_reflector(N, b, h);
    for (int i = 0; i < N; i++) {
        for (int j = 0; j < N; j++) {
            q[i][j] = (i == j) - h[i] * h[j];
        }
    }
    aoi_constraint_congruence(N, h, a, work);
    double worst = 0.0, skew = 0.0;
    for (int i = 0; i < N; i++) {
        for (int j = 0; j < N; j++) {
            double product = 0.0;
            for (int k = 0; k < N; k++) {
                for (int l = 0; l < N; l++) {
                    product += q[i][k] * was[k * N + l] * q[l][j];
                }
            }
            worst = fmax(worst, fabs(a[i * N + j] - product));
            skew = fmax(skew, fabs(a[i * N + j] - a[j * N + i]));
        }
    }
    CHECK(worst < 2e-15, "H A H entry by entry, off by %g", worst);
    CHECK(skew < 1e-15, "symmetric stays symmetric, off by %g", skew);
    aoi_constraint_congruence(N, h, a, work);
    for (int i = 0; i < N * N; i++) {
        CHECK(fabs(a[i] - was[i]) < 4e-15, "a reflection undoes itself, entry %d", i);
    }
}

/* Eqs. (6), (9), (10), (12) from the constraint modes of a chain, against the closed forms. All the
 * anti-oscillators leave m0 = 1/(b M^-1 b), here the struck mass itself, and k0 + sum k_i = K_bb.
 */
static void chain_becomes_its_star(int n, int constrained)
{
    static double phi[CHAIN_MOST * CHAIN_MOST], omega2[CHAIN_MOST], modal_mass[CHAIN_MOST];
    static double static_mode[CHAIN_MOST], c[CHAIN_MOST], m[CHAIN_MOST], k[CHAIN_MOST];
    static int32_t of[CHAIN_MOST];
    static chain exact;
    const size_t dofs = (size_t)n, count = dofs - 1;
    aoi_star star;
    chain_make(&exact, n, constrained);
    for (int i = 0; i < n; i++) {
        static_mode[i] = constrained ? (i + 1.0) / n : 1.0;
    }
    for (int j = 1; j < n; j++) {
        const double angle = chain_antiresonance_angle(n, constrained, j), norm = j % 2 ? 3.0 : -1e-3;
        double *mode = phi + (size_t)(j - 1) * dofs;
        for (int i = 0; i < n; i++) {
            mode[i] =
                i == n - 1 ? 0.0 : norm * (constrained ? sin(angle * (i + 1)) : cos(angle * (i + 0.5)));
        }
        omega2[j - 1] = square(2.0 * sin(0.5 * angle));
        modal_mass[j - 1] = aoi_vector_dot(dofs, mode, mode);
    }
    const int status = aoi_star_from_constraint_modes(dofs, count, static_mode, static_mode, exact.star.k0, phi, phi,
                                                      omega2, &star, m, k, c, of);
    CHECK(status == AOI_OK && star.n == count && star.k0 == exact.star.k0, "chain of %d", n);
    double stiffness = star.k0;
    for (size_t j = 0; j < count; j++) {
        const double allowed =
            1e-14 * n * n; /* the mode's sum with phi_st loses up to its own size */
        CHECK(near(m[j], exact.m[j], allowed), "m_%zu of %d is %g, not %g", j + 1, n, exact.m[j],
              m[j]);
        CHECK(near(k[j], exact.k[j], allowed), "k_%zu of %d is %g, not %g", j + 1, n, exact.k[j],
              k[j]);
        CHECK(near(c[j] * c[j] * modal_mass[j], m[j], 1e-14), "m = c^2 phi M phi, eq. (9)");
        CHECK(of[j] == (int32_t)j, "mode %zu is an oscillator of its own", j);
        stiffness += k[j];
    }
    CHECK(fabs(star.m0 - 1.0) < 1e-14 * n * n, "m0 is the struck mass, not %.17g", star.m0);
    CHECK(near(stiffness, 1.0, 1e-14 * n), "springs at the struck mass: 1, not %.17g", stiffness);
}

/* Two equal masses on equal springs beside the struck mass of 2 kg, free to move apart, and a third that the contact does
 * not move: the first two are one oscillator. */
static void equal_modes_are_one_oscillator_and_idle_ones_none(void)
{
    const double mass[4] = {2.0, 1.0, 3.0, 5.0}, of_static[4] = {1.0, 1.0, 1.0, 0.0}, m_static[4] = {2.0, 1.0, 3.0, 0.0};
    const double phi[12] = {0.0, 7.0, 0.0, 0.0, 0.0, 0.0, -2.0, 0.0, 0.0, 0.0, 0.0, 1.0};
    const double omega2[3] = {4.0, 4.0, 9.0};
    double m_phi[12], m[3], k[3], c[3];
    int32_t of[3];
    aoi_star star;
    for (size_t i = 0; i < 12; i++) {
        m_phi[i] = mass[i % 4] * phi[i];
    }
    CHECK(aoi_star_from_constraint_modes(4, 3, of_static, m_static, 0.0, phi, m_phi, omega2, &star, m, k, c, of) ==
              AOI_OK,
          "a star");
    CHECK(star.n == 1 && near(star.m0, 2.0, 1e-15) && star.k0 == 0.0, "%zu oscillators on %g kg", star.n, star.m0);
    CHECK(near(star.m[0], 4.0, 1e-15) && near(star.k[0], 16.0, 1e-15), "4 kg at 2 rad/s");
    CHECK(near(c[0], 1.0 / 7.0, 1e-15) && near(c[1], -0.5, 1e-15) && c[2] == 0.0, "eq. (9)");
    CHECK(of[0] == 0 && of[1] == 0 && of[2] == -1, "which is part of which");
}

static void oscillators_that_cannot_be(void)
{
    double phi[4] = {1.0, 0.0, 0.0, 1.0}, m_phi[4] = {1.0, 0.0, 0.0, 1.0}, omega2[2] = {1.0, 2.0}, ones[2] = {1.0, 1.0};
    double c[2], m[2], k[2], k0 = 0.0;
    int32_t of[2];
    aoi_star star;
    const struct {
        double *where;
        double value;
        int status;
    } bad[] = {
        {&omega2[0], 0.0, AOI_ERROR_NOT_POSITIVE},  {&omega2[0], -1.0, AOI_ERROR_NOT_POSITIVE},
        {&omega2[0], 3.0, AOI_ERROR_ARGUMENT},      {&omega2[1], (double)NAN, AOI_ERROR_NOT_FINITE},
        {&m_phi[0], -1.0, AOI_ERROR_NOT_POSITIVE},  {&phi[0], HUGE_VAL, AOI_ERROR_NOT_FINITE},
        {&ones[0], -1.0, AOI_OK},                   {&ones[0], (double)NAN, AOI_ERROR_NOT_FINITE},
        {&k0, -1.0, AOI_ERROR_NOT_POSITIVE},
    };
    CHECK(aoi_star_from_constraint_modes(2, 0, ones, ones, 0.0, NULL, NULL, NULL, &star, NULL, NULL, NULL, NULL) ==
                  AOI_OK &&
              star.n == 0 && star.m0 == 2.0,
          "a rigid mass");
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++) {
        const double was = *bad[i].where;
        *bad[i].where = bad[i].value;
        CHECK(aoi_star_from_constraint_modes(2, 2, ones, ones, k0, phi, m_phi, omega2, &star, m, k, c, of) ==
                  bad[i].status,
              "case %zu", i);
        *bad[i].where = was;
    }
    /* Two masses of 1.69e308 kg are numbers; what they leave of the static mass is not. */
    double large[4] = {1.3e154, 0.0, 0.0, 1.3e154}, small[4] = {1.0 / 1.3e154, 0.0, 0.0, 1.0 / 1.3e154};
    double slow[2] = {0.25, 0.5};
    CHECK(aoi_star_from_constraint_modes(2, 2, ones, ones, k0, large, small, slow, &star, m, k, c, of) ==
              AOI_ERROR_NOT_FINITE,
          "masses without end");
}

int main(void)
{
    held_chain_is_two_springs();
    static_mode_of_no_held_body();
    struck_bar_has_its_effective_mass();
    rounding_reaches_nothing();
    constrained_solution_keeps_the_constraint();
    reflection_takes_b_to_the_first_axis();
    congruence_is_the_dense_product();
    for (int n = 2; n <= 60; n += n < 8 ? 1 : 13) {
        chain_becomes_its_star(n, 0);
        chain_becomes_its_star(n, 1);
    }
    equal_modes_are_one_oscillator_and_idle_ones_none();
    oscillators_that_cannot_be();
    return check_report();
}
