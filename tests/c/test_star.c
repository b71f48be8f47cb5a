/* The star of Fig. 2: its receptance, energies and modes against closed forms, and there and back.
 */
#include "chain.h"
#include "star/secular.h"

static void bad_stars_are_named(void)
{
    double m[] = {1.0, 2.0}, k[] = {3.0, 4.0};
    const double nan = (double)NAN, inf = (double)INFINITY;
    aoi_star star = {2, 1.0, 0.0, m, k};
    const aoi_star rigid = {0, 1.0, 0.0, NULL, NULL}, wall = {0, inf, 0.0, NULL, NULL};
    const aoi_star massless = {2, 0.0, 0.0, m, k}, nothing = {0, 0.0, 5.0, NULL, NULL};
    CHECK(aoi_star_check(&star) == AOI_OK, "a star");
    CHECK(aoi_star_check(&rigid) == AOI_OK, "a rigid mass");
    CHECK(aoi_star_check(&wall) == AOI_OK, "a wall");
    CHECK(aoi_star_check(&massless) == AOI_OK, "no residual mass");
    CHECK(aoi_star_check(&nothing) == AOI_ERROR_NOT_POSITIVE, "no mass at all");
    const struct {
        double *where;
        double value;
        int status;
    } broken[] = {
        {&star.m0, nan, AOI_ERROR_NOT_FINITE},       {&star.m0, inf, AOI_ERROR_NOT_FINITE},
        {&star.m0, -1e-300, AOI_ERROR_NOT_POSITIVE}, {&star.m0, -inf, AOI_ERROR_NOT_FINITE},
        {&star.k0, nan, AOI_ERROR_NOT_FINITE},       {&star.k0, inf, AOI_ERROR_NOT_FINITE},
        {&star.k0, -1.0, AOI_ERROR_NOT_POSITIVE},    {&m[1], nan, AOI_ERROR_NOT_FINITE},
        {&m[1], inf, AOI_ERROR_NOT_FINITE},          {&m[1], 0.0, AOI_ERROR_NOT_POSITIVE},
        {&m[0], -1.0, AOI_ERROR_NOT_POSITIVE},       {&k[0], nan, AOI_ERROR_NOT_FINITE},
        {&k[1], inf, AOI_ERROR_NOT_FINITE},          {&k[1], 0.0, AOI_ERROR_NOT_POSITIVE},
        {&k[0], -1.0, AOI_ERROR_NOT_POSITIVE},
    };
    for (size_t i = 0; i < sizeof broken / sizeof broken[0]; i++) {
        double omega2[3], r[3], work[2];
        size_t modes = 99;
        const double was = *broken[i].where;
        *broken[i].where = broken[i].value;
        CHECK(aoi_star_check(&star) == broken[i].status, "case %zu, value %g", i, broken[i].value);
        CHECK(aoi_star_to_modal(&star, omega2, r, &modes, work, NULL) == broken[i].status && modes == 99,
              "no modes of a bad star, case %zu", i);
        *broken[i].where = was;
    }
}

static void receptance_of_one_oscillator(void)
{
    const double m[] = {2.0}, k[] = {8.0}, omega[] = {0.0, 1.0, 2.0, 4.0};
    const aoi_star constrained = {1, 1.0, 3.0, m, k}, free_star = {1, 1.0, 0.0, m, k};
    double u[4];
    /* k0 - w^2 m0 - m w^2 4/(4 - w^2) */
    aoi_star_receptance(&constrained, 4, omega, u);
    CHECK(near(u[0], 1.0 / 3.0, 1e-16), "static compliance 1/k0, not %g", u[0]);
    CHECK(near(u[1], 1.0 / (3.0 - 1.0 - 8.0 / 3.0), 1e-15), "at w = 1, not %g", u[1]);
    CHECK(u[2] == 0.0, "an antiresonance at w^2 = k/m, not %g", u[2]);
    CHECK(near(u[3], 1.0 / (3.0 - 16.0 + 2.0 * 16.0 * 4.0 / 12.0), 1e-15), "at w = 4, not %g", u[3]);
    aoi_star_receptance(&free_star, 1, omega, u);
    CHECK(isinf(u[0]), "a free body gives way without end, not %g", u[0]);
    const aoi_star rigid = {0, 2.0, 0.0, NULL, NULL}, wall = {0, (double)INFINITY, 0.0, NULL, NULL};
    aoi_star_receptance(&rigid, 1, omega + 2, u);
    CHECK(near(u[0], -1.0 / 8.0, 1e-16), "a rigid mass: -1/(m w^2), not %g", u[0]);
    aoi_star_receptance(&wall, 4, omega, u);
    CHECK(u[0] == 0.0 && u[3] == 0.0, "a wall does not move");
}

static void star_of_a_chain_responds_like_the_chain(int n, int constrained)
{
    static chain c;
    chain_make(&c, n, constrained);
    double total = constrained ? (n + 1.0) * (2.0 * n + 1.0) / (6.0 * n) : n;
    CHECK(near(aoi_star_static_mass(&c.star), total, 1e-14 * n), "static mass of %d is %g", n, total);
    for (double omega = 0.013; omega < 3.0; omega += 0.0717) {
        double u;
        const double wanted = chain_receptance(n, constrained, omega);
        aoi_star_receptance(&c.star, 1, &omega, &u);
        /* The mean of |u| is about 1: near a resonance only 1/u can be compared. */
        CHECK(near(u, wanted, 1e-9) || fabs(1.0 / u - 1.0 / wanted) < 1e-11 * n,
              "chain of %d at w = %g: %.17g, not %.17g", n, omega, u, wanted);
    }
}

static void star_of_a_chain_has_its_modes(int n, int constrained)
{
    static chain c;
    static double omega2[CHAIN_MOST], r[CHAIN_MOST], m[CHAIN_MOST], k[CHAIN_MOST];
    size_t modes = 0;
    double m0, k0;
    chain_make(&c, n, constrained);
    CHECK(aoi_star_to_modal(&c.star, omega2, r, &modes, m, NULL) == AOI_OK, "chain of %d", n);
    CHECK(modes == (size_t)n, "n+1 modes, not %zu", modes);
    for (int j = 0; j < n; j++) {
        CHECK(fabs(omega2[j] - c.omega2[j]) < 4e-15 * n, "mode %d of %d: omega2 %.17g, not %.17g",
              j, n, omega2[j], c.omega2[j]);
        CHECK(fabs(r[j] * r[j] - c.weight[j]) < 2e-14, "mode %d of %d: r^2 %.17g, not %.17g", j, n,
              r[j] * r[j], c.weight[j]);
    }
    CHECK(constrained || omega2[0] == 0.0, "the rigid mode of a free chain is exactly zero");
    CHECK(aoi_star_from_modal((size_t)n, c.omega2, c.weight, &m0, &k0, m, k, NULL) == AOI_OK, "and back");
    CHECK(near(m0, 1.0, 1e-14) && near(k0, c.star.k0, 1e-14 * n),
          "m0 = 1, k0 = %g, not %.17g, %.17g", c.star.k0, m0, k0);
    for (int j = 0; j < n - 1; j++) {
        CHECK(fabs(m[j] - c.m[j]) < 1e-13 * c.m[0] && fabs(k[j] - c.k[j]) < 2e-14,
              "oscillator %d of %d: %.17g kg, not %.17g", j, n, m[j], c.m[j]);
    }
}

typedef struct random_star {
    double m[CHAIN_MOST], k[CHAIN_MOST];
    aoi_star star;
} random_star;

/* Masses over eight decades, frequencies over five, well apart. */
static void random_star_make(random_star *s, size_t n, uint64_t *seed, int constrained)
{
    for (size_t i = 0; i < n; i++) {
        s->m[i] = decades(seed, -8.0, 0.0);
        s->k[i] = s->m[i] * pow(10.0, 5.0 + 10.0 * ((double)i + 0.9 * uniform(seed)) / (double)n);
    }
    const double m0 = decades(seed, -6.0, 0.0);
    s->star = (aoi_star){n, m0, constrained ? decades(seed, 2.0, 9.0) : 0.0, s->m, s->k};
}

static void there_and_back(size_t n, uint64_t *seed, int constrained)
{
    static random_star s;
    static double omega2[CHAIN_MOST], r[CHAIN_MOST], weight[CHAIN_MOST], m[CHAIN_MOST],
        k[CHAIN_MOST];
    size_t modes;
    double m0, k0, worst = 0.0;
    random_star_make(&s, n, seed, constrained);
    CHECK(aoi_star_to_modal(&s.star, omega2, r, &modes, m, NULL) == AOI_OK, "%zu oscillators", n);
    int interlaced = 1, positive = 1;
    double inverse_mass = 0.0, compliance = 0.0;
    for (size_t j = 0; j <= n; j++) {
        weight[j] = r[j] * r[j];
        inverse_mass += weight[j];
        compliance += weight[j] / omega2[j];
        positive = positive && r[j] > 0.0;
        /* Not strictly: where an oscillator weighs nothing a mode rounds to its antiresonance. */
        interlaced = interlaced && (j == 0 || omega2[j] >= s.k[j - 1] / s.m[j - 1]) &&
                     (j == n || omega2[j] <= s.k[j] / s.m[j]);
    }
    CHECK(positive && interlaced, "resonance, antiresonance, resonance ... of %zu", n);
    CHECK(near(inverse_mass, 1.0 / s.star.m0, 1e-13), "sum r^2 = 1/m0, not %.17g", inverse_mass);
    CHECK(!constrained || near(compliance, 1.0 / s.star.k0, 1e-13), "sum r^2/omega2 = 1/k0, not %.17g", compliance);
    CHECK(aoi_star_from_modal(n + 1, omega2, weight, &m0, &k0, m, k, NULL) == AOI_OK, "back");
    CHECK(near(m0, s.star.m0, 1e-12) && near(k0, s.star.k0, 1e-12), "m0, k0 come back");
    for (size_t i = 0; i < n; i++) {
        worst = fmax(worst, fmax(fabs(m[i] / s.m[i] - 1.0), fabs(k[i] / s.k[i] - 1.0)));
    }
    CHECK(worst < 1e-12, "%zu oscillators come back, off by %g", n, worst);
}

static void lone_masses_and_their_modes(void)
{
    const double weight[] = {0.25, 0.25}, omega2[] = {9.0, 16.0};
    const aoi_star rigid = {0, 4.0, 0.0, NULL, NULL}, sprung = {0, 4.0, 36.0, NULL, NULL};
    const aoi_star wall = {0, (double)INFINITY, 0.0, NULL, NULL};
    double found[2], r[2], m0, k0, m, k;
    size_t modes;
    CHECK(aoi_star_to_modal(&rigid, found, r, &modes, NULL, NULL) == AOI_OK && modes == 1, "a rigid mass");
    CHECK(found[0] == 0.0 && r[0] == 0.5, "moves as one: 0 and 1/sqrt(m)");
    CHECK(aoi_star_to_modal(&sprung, found, r, &modes, NULL, NULL) == AOI_OK && modes == 1, "on a spring");
    CHECK(found[0] == 9.0 && r[0] == 0.5, "k/m and 1/sqrt(m)");
    CHECK(aoi_star_to_modal(&wall, found, r, &modes, NULL, NULL) == AOI_ERROR_ARGUMENT, "a wall has no modes");
    CHECK(aoi_star_from_modal(1, omega2, weight, &m0, &k0, NULL, NULL, NULL) == AOI_OK, "one mode");
    CHECK(m0 == 4.0 && near(k0, 36.0, 1e-15), "is a mass on a spring");
    CHECK(aoi_star_from_modal(2, omega2, weight, &m0, &k0, &m, &k, NULL) == AOI_OK, "two modes of 4 kg");
    /* The antiresonance lies midway, k/m = 12.5; m0 = 2; m k from the slope there. */
    CHECK(m0 == 2.0 && near(k0, 1.0 / (0.25 / 9.0 + 0.25 / 16.0), 1e-15), "m0 and k0 of two modes");
    CHECK(near(k, 3.5 * 3.5 / (0.5 * 12.5), 1e-14) && near(k / m, 12.5, 1e-14), "its oscillator: %g", k);
}

static void modes_that_cannot_be(void)
{
    const double nan = (double)NAN, inf = (double)INFINITY;
    const struct {
        double omega2[2], weight[2];
        int status;
    } bad[] = {
        {{-1.0, 1.0}, {1.0, 1.0}, AOI_ERROR_ARGUMENT},
        {{1.0, 1.0}, {1.0, 1.0}, AOI_ERROR_ARGUMENT},
        {{2.0, 1.0}, {1.0, 1.0}, AOI_ERROR_ARGUMENT},
        {{nan, 1.0}, {1.0, 1.0}, AOI_ERROR_NOT_FINITE},
        {{0.0, nan}, {1.0, 1.0}, AOI_ERROR_NOT_FINITE},
        {{0.0, inf}, {1.0, 1.0}, AOI_ERROR_NOT_FINITE},
        {{0.0, 1.0}, {nan, 1.0}, AOI_ERROR_NOT_FINITE},
        {{0.0, 1.0}, {1.0, nan}, AOI_ERROR_NOT_FINITE},
        {{0.0, 1.0}, {inf, 1.0}, AOI_ERROR_NOT_FINITE},
        {{0.0, 1.0}, {0.0, 1.0}, AOI_ERROR_NOT_POSITIVE},
        {{0.0, 1.0}, {1.0, -1.0}, AOI_ERROR_NOT_POSITIVE},
        {{0.0, 1.0}, {1.0, 0.0}, AOI_ERROR_NOT_POSITIVE},
    };
    double m0 = 7.0, k0 = 7.0, m = 7.0, k = 7.0;
    CHECK(aoi_star_from_modal(0, NULL, NULL, &m0, &k0, &m, &k, NULL) == AOI_ERROR_ARGUMENT, "no modes");
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++) {
        const int status = aoi_star_from_modal(2, bad[i].omega2, bad[i].weight, &m0, &k0, &m, &k, NULL);
        CHECK(status == bad[i].status, "omega2 %g, %g with weights %g, %g: status %d",
              bad[i].omega2[0], bad[i].omega2[1], bad[i].weight[0], bad[i].weight[1], status);
    }
    CHECK(m == 7.0 && k == 7.0, "no oscillator is written");
    CHECK(aoi_star_from_modal(1, &nan, bad[0].weight, &m0, &k0, NULL, NULL, NULL) == AOI_ERROR_NOT_FINITE,
          "one mode of frequency NaN");
    const double close_m[] = {1.0, 1.0}, close_k[] = {4.0, 4.0};
    const aoi_star equal = {2, 1.0, 0.0, close_m, close_k};
    double omega2[3], r[3], work[2];
    size_t modes;
    CHECK(aoi_star_to_modal(&equal, omega2, r, &modes, work, NULL) == AOI_ERROR_ARGUMENT,
          "equal antiresonances are to be merged by the caller");
}

static void energies_of_a_star(void)
{
    const double m[] = {2.0, 3.0}, k[] = {5.0, 7.0}, u[] = {0.1, 0.3, -0.2}, v[] = {1.0, -2.0, 0.5};
    const aoi_star star = {2, 4.0, 11.0, m, k}, wall = {0, (double)INFINITY, 0.0, NULL, NULL};
    double kinetic, elastic;
    aoi_star_energy(&star, u, v, &kinetic, &elastic);
    CHECK(near(kinetic, 0.5 * (4.0 + 2.0 * 4.0 + 3.0 * 0.25), 1e-15), "1/2 sum m v^2, not %g", kinetic);
    CHECK(near(elastic, 0.5 * (11.0 * 0.01 + 5.0 * 0.04 + 7.0 * 0.09), 1e-14),
          "1/2 k0 u0^2 + 1/2 sum k (u0 - u_i)^2, not %g", elastic);
    aoi_star_energy(&wall, u, v, &kinetic, &elastic);
    CHECK(kinetic == 0.0 && elastic == 0.0, "a wall has no energy");
}

static int stop(void *data)
{
    int *asked = data;
    return ++*asked >= 3;
}

static void out_of_range_or_stopped(void)
{
    double omega2[3], r[3], work[2], m0, k0, m_out[2], k_out[2];
    size_t modes;
    const double heavy[] = {1e74}, soft[] = {1e-300}, light[] = {1e-300}, stiff[] = {1e300};
    const aoi_star slow = {1, 0.0, 0.0, heavy, soft}, fast = {1, 1.0, 1.0, light, stiff};
    CHECK(aoi_star_to_modal(&slow, omega2, r, &modes, work, NULL) == AOI_ERROR_NOT_FINITE, "k/m is nothing but zero");
    CHECK(aoi_star_to_modal(&fast, omega2, r, &modes, work, NULL) == AOI_ERROR_NOT_FINITE, "k/m is infinite");
    const double poles[] = {0.0, 1.0}, tiny[] = {SMALLEST, SMALLEST};
    CHECK(aoi_star_from_modal(2, poles, tiny, &m0, &k0, m_out, k_out, NULL) == AOI_ERROR_NOT_FINITE,
          "a mass of 1/5e-324");
    const aoi_secular far = {1, poles, poles + 1, 0.0, 0.0, 0};
    size_t nearest;
    double offset;
    CHECK(aoi_secular_root(&far, 0, DBL_MAX, &nearest, &offset) == AOI_ERROR_NOT_FINITE,
          "no root as far as numbers go");
    const double m[] = {1.0, 1.0}, k[] = {1.0, 2.0}, squares[] = {1.0, 2.0, 3.0, 4.0};
    double weight[] = {1.0, 1.0, 1.0, 1.0}, m3[3], k3[3];
    const aoi_star star = {2, 1.0, 1.0, m, k};
    int asked = 0;
    const aoi_pause pause = {stop, &asked};
    CHECK(aoi_star_to_modal(&star, omega2, r, &modes, work, &pause) == AOI_ERROR_STOPPED && asked == 3,
          "the third mode is not looked for");
    asked = 0;
    CHECK(aoi_star_from_modal(4, squares, weight, &m0, &k0, m3, k3, &pause) == AOI_ERROR_STOPPED && asked == 3,
          "nor the third oscillator");
}

/* Two oscillators whose frequencies and masses are so far apart that their modes' masses, with the contact
 * displaced by 1, are no numbers. */
static void shares_whose_squares_vanish(void)
{
    const double m[] = {1e90, 1e-20}, k[] = {1e-39, 1e60};
    const aoi_star star = {2, 1e-22, 1e74, m, k};
    double omega2[3], r[3], work[2];
    size_t modes;
    CHECK(aoi_star_to_modal(&star, omega2, r, &modes, work, NULL) == AOI_OK && modes == 3, "three modes");
    /* At rest but for the heavy one: the contact moves by k_1 / (k0 + k_1) = 1e-113 of its way. */
    CHECK(near(omega2[0], 1e-129, 1e-13) && near(r[0], 1e-45 * 1e-113, 1e-13), "r of 1e-158, not %g", r[0]);
    CHECK(near(1e-22 * (r[0] * r[0] + r[1] * r[1] + r[2] * r[2]), 1.0, 1e-13), "sum r^2 = 1/m0");
}

int main(void)
{
    uint64_t seed = 2;
    bad_stars_are_named();
    receptance_of_one_oscillator();
    for (int n = 2; n <= 300; n += n < 6 ? 1 : 49) {
        for (int constrained = 0; constrained < 2; constrained++) {
            star_of_a_chain_responds_like_the_chain(n, constrained);
            star_of_a_chain_has_its_modes(n, constrained);
        }
    }
    for (size_t n = 1; n <= 300; n = n * 3 / 2 + 1) {
        for (int constrained = 0; constrained < 2; constrained++) {
            for (int trial = 0; trial < 5; trial++) {
                there_and_back(n, &seed, constrained);
            }
        }
    }
    lone_masses_and_their_modes();
    modes_that_cannot_be();
    energies_of_a_star();
    out_of_range_or_stopped();
    shares_whose_squares_vanish();
    return check_report();
}
