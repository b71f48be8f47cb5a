/* Section 2 of the paper on bodies whose anti-oscillators are known in closed form: chains of equal
 * masses and springs. */
#include "chain.h"
#include "linear/vector.h"
#include "aoimpact.h"

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
            mode[i] = i == n - 1 ? 0.0 : norm * (constrained ? sin(angle * (i + 1)) : cos(angle * (i + 0.5)));
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
        CHECK(near(m[j], exact.m[j], allowed), "m_%zu of %d is %g, not %g", j + 1, n, exact.m[j], m[j]);
        CHECK(near(k[j], exact.k[j], allowed), "k_%zu of %d is %g, not %g", j + 1, n, exact.k[j], k[j]);
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
                  AOI_OK && star.n == 0 && star.m0 == 2.0,
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
    for (int n = 2; n <= 60; n += n < 8 ? 1 : 13) {
        chain_becomes_its_star(n, 0);
        chain_becomes_its_star(n, 1);
    }
    equal_modes_are_one_oscillator_and_idle_ones_none();
    oscillators_that_cannot_be();
    return check_report();
}
