/* Newmark's rule on finite elements: the two-mass star written as matrices is the same body,
 * whether seen through a unit vector or a scaled functional; a bar of many elements against its own
 * modes. */
#include "check.h"

#include <string.h>

enum { MOST = 40 };

/* A chain of n masses on springs k between them and k_first at the start, with its factors of
 * M + beta dt^2 K, tridiagonal: L has one entry a column. */
typedef struct chain_body {
    aoi_full full;
    aoi_factors factors;
    aoi_body body;
    int32_t start[MOST + 1], indices[3 * MOST], m_start[MOST + 1], m_indices[MOST];
    int32_t l_start[MOST + 1], l_rows[MOST], place[MOST], panel[MOST + 1];
    double k_values[3 * MOST], m_values[MOST], l_values[MOST], pivots[MOST];
    double b[MOST], centre[MOST], u0[MOST], v0[MOST], work[6 * MOST];
} chain_body;

static void chain_body_fill(chain_body *c, int32_t n, double k_first, const double *k,
                            const double *m)
{
    int32_t stored = 0;
    double total = 0.0;
    memset(c, 0, sizeof *c);
    for (int32_t i = 0; i < n; i++) {
        const double before = i == 0 ? k_first : k[i - 1], after = i < n - 1 ? k[i] : 0.0;
        c->start[i] = stored;
        if (i > 0) {
            c->indices[stored] = i - 1;
            c->k_values[stored++] = -before;
        }
        c->indices[stored] = i;
        c->k_values[stored++] = before + after;
        if (i < n - 1) {
            c->indices[stored] = i + 1;
            c->k_values[stored++] = -after;
        }
        c->m_start[i] = c->m_indices[i] = c->place[i] = i;
        c->m_values[i] = m[i];
        total += m[i];
    }
    c->start[n] = stored;
    c->m_start[n] = n;
    for (int32_t i = 0; i < n; i++) {
        c->centre[i] = m[i] / total;
    }
    c->full.K = (aoi_sparse){(size_t)n, c->start, c->indices, c->k_values};
    c->full.M = (aoi_sparse){(size_t)n, c->m_start, c->m_indices, c->m_values};
    c->full.b = c->b;
    c->full.solver = (aoi_solver){aoi_factors_solve, &c->factors};
}

static void chain_body_factorise(chain_body *c, aoi_newmark rule, const double *k, double k_first)
{
    const int32_t n = (int32_t)c->full.K.n;
    const double reach = rule.beta * rule.dt * rule.dt;
    for (int32_t i = 0; i < n; i++) {
        const double before = i == 0 ? k_first : k[i - 1], after = i < n - 1 ? k[i] : 0.0;
        c->pivots[i] = c->m_values[i] + reach * (before + after);
        if (i > 0) {
            c->l_values[i - 1] = -reach * before / c->pivots[i - 1];
            c->pivots[i] -= c->l_values[i - 1] * c->l_values[i - 1] * c->pivots[i - 1];
            c->l_rows[i - 1] = i;
        }
        c->l_start[i + 1] = i < n - 1 ? i + 1 : i;
    }
    const size_t panels = aoi_factors_find_panels((size_t)n, c->l_start, c->l_rows, c->panel);
    c->factors = (aoi_factors){(size_t)n, c->l_start, c->l_rows, c->l_values,       c->pivots,
                               c->place,  c->panel,   panels,    c->work + 5 * MOST};
    CHECK(aoi_factors_check(&c->factors, (size_t)(n - 1)) == AOI_OK, "factors of a chain of %d",
          (int)n);
}

static int chain_body_start(chain_body *c, aoi_newmark rule)
{
    CHECK(aoi_body_full_size(c->full.K.n) <= 5 * MOST, "room to work in");
    return aoi_body_start_full(&c->body, &c->full, &rule, c->centre, c->u0, c->v0, c->work);
}

static const double M_STAR[] = {0.3}, K_STAR[] = {4e8};

/* One oscillator on a contact mass: m0, k0 and (m, k) are a chain of two masses, struck at the
 * first. */
static void star_and_its_matrices_are_one_body(double k0, aoi_newmark rule, double scale)
{
    static chain_body c;
    const aoi_star star = {1, 0.02, k0, M_STAR, K_STAR};
    const double masses[] = {0.02, 0.3}, centre[] = {0.02 / 0.32, 0.3 / 0.32};
    double u0[] = {0.0, 0.0}, v0[] = {1.5, 1.5}, work[16];
    aoi_body of_star;
    chain_body_fill(&c, 2, k0, K_STAR, masses);
    chain_body_factorise(&c, rule, K_STAR, k0);
    c.b[0] = scale;
    c.v0[0] = c.v0[1] = 1.5;
    CHECK(chain_body_start(&c, rule) == AOI_OK, "finite elements start");
    CHECK(aoi_body_start_star(&of_star, &star, &rule, centre, u0, v0, work) == AOI_OK,
          "the star starts");
    CHECK(near(c.body.compliance, scale * scale * of_star.compliance, 1e-14), "one compliance");
    CHECK(near(c.body.rate_compliance, scale * scale * of_star.rate_compliance, 1e-14), "and rate");
    double size = 0.0, speed = 0.0, worst = 0.0, worst_speed = 0.0, worst_energy = 0.0;
    for (int j = 0; j < 2000; j++) {
        aoi_observation a, b;
        double u, v;
        const double force = 3e4 * sin(0.01 * j);
        CHECK(of_star.predict(&of_star, &u, &v) == AOI_OK, "predict the star");
        of_star.correct(&of_star, force);
        of_star.observe(&of_star, 1, &a);
        CHECK(c.body.predict(&c.body, &u, &v) == AOI_OK, "predict the matrices");
        c.body.correct(&c.body, force / scale);
        c.body.observe(&c.body, 1, &b);
        size = fmax(size, fabs(a.displacement));
        speed = fmax(speed, fabs(a.velocity));
        worst = fmax(worst, fmax(fabs(b.displacement / scale - a.displacement),
                                 fabs(b.centre_displacement - a.centre_displacement)));
        worst_speed = fmax(worst_speed, fmax(fabs(b.velocity / scale - a.velocity),
                                             fabs(b.centre_velocity - a.centre_velocity)));
        const double energy = a.kinetic + a.elastic;
        worst_energy = fmax(worst_energy, fabs(b.kinetic - a.kinetic) / energy);
        /* u K u of a body that flies loses what its stretches are smaller than its places. */
        worst_energy = fmax(worst_energy, fabs(b.elastic - a.elastic) / energy);
    }
    CHECK(worst < 1e-12 * size && worst_speed < 1e-11 * speed,
          "k0 %g, scale %g: off by %g m of %g, %g m/s of %g", k0, scale, worst, size, worst_speed,
          speed);
    CHECK(worst_energy < 1e-9, "k0 %g: energies differ by %g", k0, worst_energy);
}

enum { RECORDED = 400 };

/* A rigid mass on Hertz's law against the two: every row of the two records is the same. */
static void same_impact_on_both(double k0)
{
    static chain_body c;
    static double record[2][AOI_ROW_COUNT][RECORDED + 1];
    const aoi_star star = {1, 0.02, k0, M_STAR, K_STAR}, ball = {0, 0.05, 0.0, NULL, NULL};
    const aoi_newmark rule = {5e-7, 0.25, 0.5};
    const double masses[] = {0.02, 0.3}, centre[] = {0.02 / 0.32, 0.3 / 0.32}, own = 1.0;
    const double rest[] = {0.0, 0.0}, speed = 3.0, hertz = 1e10;
    aoi_law law;
    CHECK(aoi_law_create(&law, "hertz", 1, &hertz) == AOI_OK, "Hertz");
    for (int full = 0; full < 2; full++) {
        double work[16], ball_work[8], *row[AOI_ROW_COUNT];
        aoi_body target, projectile;
        size_t done;
        CHECK(aoi_body_start_star(&projectile, &ball, &rule, &own, rest, &speed, ball_work) ==
                  AOI_OK,
              "ball");
        CHECK(aoi_body_start_star(&target, &star, &rule, centre, rest, rest, work) == AOI_OK,
              "star");
        chain_body_fill(&c, 2, k0, K_STAR, masses);
        chain_body_factorise(&c, rule, K_STAR, k0);
        c.b[0] = 1.0;
        CHECK(chain_body_start(&c, rule) == AOI_OK, "finite elements");
        for (int i = 0; i < AOI_ROW_COUNT; i++) {
            row[i] = record[full][i];
        }
        aoi_impact impact = {&projectile, full ? &c.body : &target, &law, 0.0, 0.0, 0.0};
        CHECK(aoi_impact_start(&impact, row) == AOI_OK, "starts");
        CHECK(aoi_impact_run(&impact, row, 1, RECORDED, &done) == AOI_OK && done == RECORDED,
              "runs");
    }
    for (int i = 0; i < AOI_ROW_COUNT; i++) {
        double worst = 0.0, size = 0.0;
        for (int j = 0; j <= RECORDED; j++) {
            worst = fmax(worst, fabs(record[0][i][j] - record[1][i][j]));
            size = fmax(size, fabs(record[0][i][j]));
        }
        CHECK(worst <= 1e-11 * size, "k0 %g, row %d: the records differ by %g of %g", k0, i, worst,
              size);
    }
    CHECK(record[0][AOI_ROW_FORCE][1] > 0.0 && record[0][AOI_ROW_FORCE][RECORDED] == 0.0,
          "hit and parted");
}

/* A chain in one of its modes keeps its shape and turns by Newmark's angle each step. */
static void mode_keeps_its_shape(int32_t n, int mode)
{
    static chain_body c;
    double k[MOST] = {0.0}, m[MOST] = {0.0};
    const double angle = (2 * mode - 1) * PI / (2 * n + 1),
                 w2 = 4.0 * sin(0.5 * angle) * sin(0.5 * angle);
    const aoi_newmark rule = {0.4, 0.25, 0.5};
    for (int32_t i = 0; i < n; i++) {
        k[i] = m[i] = 1.0;
    }
    chain_body_fill(&c, n, 1.0, k, m);
    chain_body_factorise(&c, rule, k, 1.0);
    double norm = 0.0;
    for (int32_t i = 0; i < n; i++) {
        c.b[i] = sin(angle * (i + 1)); /* a functional spread over the whole body */
        c.v0[i] = c.b[i];
        norm += c.b[i] * c.b[i];
    }
    CHECK(chain_body_start(&c, rule) == AOI_OK, "a chain of %d", (int)n);
    CHECK(near(c.body.compliance, 0.25 * 0.16 * norm / (1.0 + 0.25 * 0.16 * w2), 1e-13),
          "compliance of a mode: beta h^2/(1 + beta h^2 w^2) b b");
    const double big = w2 * 0.16, step_angle = 2.0 * atan(0.5 * sqrt(big));
    const double first = 0.4 / (1.0 + 0.25 * big);
    double worst = 0.0, energy_off = 0.0;
    for (int j = 1; j <= 500; j++) {
        double u, v;
        aoi_observation seen;
        c.body.predict(&c.body, &u, &v);
        c.body.correct(&c.body, 0.0);
        c.body.observe(&c.body, 1, &seen);
        const double wanted = norm * first * sin(j * step_angle) / sin(step_angle);
        worst = fmax(worst, fabs(seen.displacement - wanted));
        energy_off = fmax(energy_off, fabs((seen.kinetic + seen.elastic) / (0.5 * norm) - 1.0));
    }
    CHECK(worst < 1e-12 * norm / sqrt(w2), "mode %d of %d: off by %g", mode, (int)n, worst);
    CHECK(energy_off < 1e-13, "mode %d of %d: energy off by %g", mode, (int)n, energy_off);
    double u[MOST], v[MOST];
    c.body.copy_state(&c.body, u, v);
    const double scale_u = aoi_vector_dot((size_t)n, c.b, u) / norm;
    const double scale_v = aoi_vector_dot((size_t)n, c.b, v) / norm;
    for (int32_t i = 0; i < n; i++) {
        CHECK(fabs(u[i] - scale_u * c.b[i]) < 1e-13 / sqrt(w2) &&
                  fabs(v[i] - scale_v * c.b[i]) < 1e-13,
              "mode %d of %d keeps its shape at %d", mode, (int)n, (int)i);
    }
}

static int solver_that_fails(void *data, double *x)
{
    int *calls_left = data;
    (void)x;
    return --*calls_left < 0;
}

static int solver_that_lies(void *data, double *x)
{
    const double *factor = data;
    x[0] *= *factor;
    x[1] *= *factor;
    return 0;
}

static void bad_bodies_and_solvers(void)
{
    static chain_body c;
    const double masses[] = {0.02, 0.3};
    const aoi_newmark rule = {1e-6, 0.25, 0.5};
    const aoi_newmark bad[] = {{0.0, 0.25, 0.5},         {-1.0, 0.25, 0.5},
                               {(double)NAN, 0.25, 0.5}, {(double)INFINITY, 0.25, 0.5},
                               {1e-6, 0.0, 0.5},         {1e-6, 0.25, 0.4},
                               {1e-6, (double)NAN, 0.5}, {1e-6, 0.25, (double)NAN}};
    chain_body_fill(&c, 2, 0.0, K_STAR, masses);
    chain_body_factorise(&c, rule, K_STAR, 0.0);
    c.b[0] = 1.0;
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++) {
        c.work[0] = 77.0;
        CHECK(chain_body_start(&c, bad[i]) == AOI_ERROR_ARGUMENT && c.work[0] == 77.0,
              "dt %g, beta %g, gamma %g", bad[i].dt, bad[i].beta, bad[i].gamma);
    }
    int calls_left = 0;
    c.full.solver = (aoi_solver){solver_that_fails, &calls_left};
    CHECK(chain_body_start(&c, rule) == AOI_ERROR_SOLVER, "the solver fails at once");
    calls_left = 3;
    CHECK(chain_body_start(&c, rule) == AOI_OK, "the solver works three times");
    double u, v;
    CHECK(c.body.predict(&c.body, &u, &v) == AOI_OK && c.body.predict(&c.body, &u, &v) == AOI_OK,
          "twice");
    CHECK(c.body.predict(&c.body, &u, &v) == AOI_ERROR_SOLVER, "and then fails");
    double factor = -1.0;
    c.full.solver = (aoi_solver){solver_that_lies, &factor};
    CHECK(chain_body_start(&c, rule) == AOI_ERROR_NOT_POSITIVE,
          "a body that comes towards the force");
    factor = (double)NAN;
    CHECK(chain_body_start(&c, rule) == AOI_ERROR_NOT_FINITE, "a solver that returns NaN");
    factor = 1.0;
    c.b[0] = 0.0;
    CHECK(chain_body_start(&c, rule) == AOI_ERROR_NOT_POSITIVE, "a contact that touches nothing");
}

int main(void)
{
    const aoi_newmark rules[] = {{1e-6, 0.25, 0.5}, {2e-6, 1.0 / 6.0, 0.5}, {3e-6, 0.3025, 0.6}};
    for (size_t i = 0; i < 3; i++) {
        for (int held = 0; held < 2; held++) {
            star_and_its_matrices_are_one_body(held ? 1e7 : 0.0, rules[i], 1.0);
            star_and_its_matrices_are_one_body(held ? 1e7 : 0.0, rules[i], -2.5);
        }
    }
    same_impact_on_both(0.0);
    same_impact_on_both(1e8);
    for (int32_t n = 1; n <= MOST; n = 2 * n + 1) {
        for (int mode = 1; mode <= n; mode += 1 + n / 3) {
            mode_keeps_its_shape(n, mode);
        }
    }
    bad_bodies_and_solvers();
    return check_report();
}
