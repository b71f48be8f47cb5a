/* Newmark's rule on finite elements: the two-mass star written as matrices is the same body,
 * whether seen through a unit vector or a scaled functional; a bar of many elements against its own
 * modes. */
#include "body.h"
#include "linear/sparse.h"
#include "linear/vector.h"
#include "newmark/body.h"
#include "newmark/scene.h"

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
    double b[MOST], centre[MOST], u0[MOST], v0[MOST], work[8 * MOST + 2];
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
    c->full.ports = 1;
    c->full.solver = (aoi_solver){aoi_factors_solve, &c->factors};
}

static void chain_body_factorise(chain_body *c, aoi_rule rule, const double *k, double k_first)
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
                               c->place,  c->panel,   panels,    c->work + 7 * MOST + 2, NULL};
    CHECK(aoi_factors_check(&c->factors, (size_t)(n - 1)) == AOI_OK, "factors of a chain of %d",
          (int)n);
}

static int chain_body_start(chain_body *c, aoi_rule rule)
{
    CHECK(aoi_body_full_size(c->full.K.n, 1) <= 7 * MOST + 2, "room to work in");
    const aoi_body_start begin = {c->u0, c->v0, c->centre, NULL, NULL};
    const int status = aoi_body_start_full(&c->body, &c->full, &rule, &begin, c->work);
    return status == AOI_OK ? begin_freely(&c->body) : status;
}

static const double M_STAR[] = {0.3}, K_STAR[] = {4e8};

/* One oscillator on a contact mass: m0, k0 and (m, k) are a chain of two masses, struck at the
 * first. */
static void star_and_its_matrices_are_one_body(double k0, aoi_rule rule, double scale)
{
    static chain_body c;
    const aoi_star star = {1, 0.02, k0, M_STAR, K_STAR};
    const double masses[] = {0.02, 0.3}, centre[] = {0.02 / 0.32, 0.3 / 0.32};
    const double u0[] = {0.0, 0.0}, v0[] = {1.5, 1.5};
    const aoi_body_start begin = {u0, v0, centre, NULL, NULL};
    double work[16];
    aoi_body of_star;
    chain_body_fill(&c, 2, k0, K_STAR, masses);
    chain_body_factorise(&c, rule, K_STAR, k0);
    c.b[0] = scale;
    c.v0[0] = c.v0[1] = 1.5;
    CHECK(chain_body_start(&c, rule) == AOI_OK, "finite elements start");
    CHECK(aoi_body_start_star(&of_star, &star, NULL, &rule, &begin, work) == AOI_OK &&
              begin_freely(&of_star) == AOI_OK,
          "the star starts");
    CHECK(near(*c.body.compliance, scale * scale * *of_star.compliance, 1e-14), "one compliance");
    CHECK(near(*c.body.rate_compliance, scale * scale * *of_star.rate_compliance, 1e-14), "and rate");
    double size = 0.0, speed = 0.0, worst = 0.0, worst_speed = 0.0, worst_energy = 0.0;
    for (int j = 0; j < 2000; j++) {
        const double force = 3e4 * sin(0.01 * j);
        CHECK(step_with(&of_star, force) == AOI_OK, "step the star");
        CHECK(step_with(&c.body, force / scale) == AOI_OK, "step the matrices");
        const observation a = observe(&of_star), b = observe(&c.body);
        size = fmax(size, fabs(a.displacement));
        speed = fmax(speed, fabs(a.velocity));
        worst = fmax(worst, fmax(fabs(b.displacement / scale - a.displacement),
                                 fabs(b.centre_displacement - a.centre_displacement)));
        worst_speed = fmax(worst_speed, fmax(fabs(b.velocity / scale - a.velocity),
                                             fabs(b.centre_velocity - a.centre_velocity)));
        const double energy = a.kinetic + a.elastic;
        worst_energy = fmax(worst_energy, fabs(b.kinetic - a.kinetic) / energy);
        /* u K u of a body that moves freely loses what its stretches are smaller than its places. */
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
    static double record[2][ROWS][RECORDED + 1];
    static pair both;
    const aoi_star star = {1, 0.02, k0, M_STAR, K_STAR}, ball = {0, 0.05, 0.0, NULL, NULL};
    const aoi_rule rule = {5e-7, 0.25, 0.5};
    const double masses[] = {0.02, 0.3}, centre[] = {0.02 / 0.32, 0.3 / 0.32}, own = 1.0;
    const double rest[] = {0.0, 0.0}, speed = 3.0, hertz = 1e10;
    aoi_law law;
    CHECK(aoi_law_create(&law, "hertz", 1, &hertz) == AOI_OK, "Hertz");
    for (int full = 0; full < 2; full++) {
        double work[16], ball_work[8];
        aoi_body target, projectile;
        size_t done;
        const aoi_body_start moving = {rest, &speed, &own, NULL, NULL}, still = {rest, rest, centre, NULL, NULL};
        CHECK(aoi_body_start_star(&projectile, &ball, NULL, &rule, &moving, ball_work) == AOI_OK,
              "ball");
        CHECK(aoi_body_start_star(&target, &star, NULL, &rule, &still, work) == AOI_OK, "star");
        chain_body_fill(&c, 2, k0, K_STAR, masses);
        chain_body_factorise(&c, rule, K_STAR, k0);
        c.b[0] = 1.0;
        CHECK(chain_body_start(&c, rule) == AOI_OK, "finite elements");
        pair_make(&both, &projectile, full ? &c.body : &target, &law, 0.0);
        both.scene.dt = rule.dt;
        double *out = &record[full][0][0];
        CHECK(aoi_scene_start(&both.scene, out, RECORDED + 1) == AOI_OK, "starts");
        CHECK(aoi_scene_run(&both.scene, out, RECORDED + 1, 1, RECORDED, &done) == AOI_OK &&
                  done == RECORDED,
              "runs");
    }
    for (int i = 0; i < ROWS; i++) {
        double worst = 0.0, size = 0.0;
        for (int j = 0; j <= RECORDED; j++) {
            worst = fmax(worst, fabs(record[0][i][j] - record[1][i][j]));
            size = fmax(size, fabs(record[0][i][j]));
        }
        CHECK(worst <= 1e-11 * size, "k0 %g, row %d: the records differ by %g of %g", k0, i, worst,
              size);
    }
    CHECK(record[0][FORCE][1] > 0.0 && record[0][FORCE][RECORDED] == 0.0,
          "hit and parted");
}

/* A chain in one of its modes keeps its shape and turns by Newmark's angle each step. */
static void mode_keeps_its_shape(int32_t n, int mode)
{
    static chain_body c;
    double k[MOST] = {0.0}, m[MOST] = {0.0};
    const double angle = (2 * mode - 1) * PI / (2 * n + 1),
                 w2 = 4.0 * sin(0.5 * angle) * sin(0.5 * angle);
    const aoi_rule rule = {0.4, 0.25, 0.5};
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
    CHECK(near(*c.body.compliance, 0.25 * 0.16 * norm / (1.0 + 0.25 * 0.16 * w2), 1e-13),
          "compliance of a mode: beta h^2/(1 + beta h^2 w^2) b b");
    const double big = w2 * 0.16, step_angle = 2.0 * atan(0.5 * sqrt(big));
    const double first = 0.4 / (1.0 + 0.25 * big);
    double worst = 0.0, energy_off = 0.0;
    for (int j = 1; j <= 500; j++) {
        step_with(&c.body, 0.0);
        const observation seen = observe(&c.body);
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

enum { ROW = 6, TWO = 2, TWO_ROWS = AOI_BODY_ROWS + AOI_PORT_ROWS * TWO };

typedef struct row_motion {
    double g[ROW], v[ROW], centre[ROW]; /* gravity, velocities at the start, the centre of mass */
} row_motion;

/* A row of masses on springs between walls, touched at two places. work: of doubles for a panel. */
static void row_make(chain_body *c, aoi_rule rule, aoi_rayleigh damping, double *work)
{
    static double ports_b[TWO * ROW];
    double k[ROW], m[ROW];
    for (int i = 0; i < ROW; i++) {
        k[i] = m[i] = 1.0;
    }
    chain_body_fill(c, ROW, 1.0, k, m);
    c->k_values[c->start[ROW] - 1] += 1.0; /* a spring behind the last, too */
    const double of_mass = 1.0 + damping.alpha * rule.gamma * rule.dt;
    const double reach = rule.dt * rule.gamma * damping.beta + rule.beta * rule.dt * rule.dt;
    for (int i = 0; i < ROW; i++) { /* L D L^T of the tridiagonal matrix */
        c->pivots[i] = of_mass + 2.0 * reach;
        if (i > 0) {
            c->l_values[i - 1] = -reach / c->pivots[i - 1];
            c->pivots[i] += reach * c->l_values[i - 1];
            c->l_rows[i - 1] = i;
        }
        c->l_start[i + 1] = i < ROW - 1 ? i + 1 : i;
    }
    const size_t panels = aoi_factors_find_panels(ROW, c->l_start, c->l_rows, c->panel);
    c->factors = (aoi_factors){ROW,      c->l_start, c->l_rows, c->l_values, c->pivots,
                               c->place, c->panel,   panels,    work, NULL};
    ports_b[1] = ports_b[ROW + 4] = 1.0;
    ports_b[ROW + 5] = -0.5;
    c->full.b = ports_b;
    c->full.ports = TWO;
    c->full.damping = damping;
}

/* The same row in its modes, which are sines. */
static aoi_modes row_modes(const chain_body *c, const row_motion *nodes, row_motion *modes)
{
    static double omega[ROW], decay[ROW], r[TWO * ROW];
    const aoi_rayleigh damping = c->full.damping;
    for (int j = 0; j < ROW; j++) {
        const double angle = PI * (j + 1) / (ROW + 1), norm = sqrt(2.0 / (ROW + 1));
        omega[j] = 2.0 * sin(0.5 * angle);
        decay[j] = 0.5 * (damping.alpha + damping.beta * omega[j] * omega[j]);
        modes->g[j] = modes->v[j] = modes->centre[j] = r[j] = r[ROW + j] = 0.0;
        for (int i = 0; i < ROW; i++) {
            const double shape = norm * sin(angle * (i + 1));
            modes->g[j] += shape * nodes->g[i];
            modes->v[j] += shape * nodes->v[i];
            modes->centre[j] += shape * nodes->centre[i];
            r[j] += shape * c->full.b[i];
            r[ROW + j] += shape * c->full.b[ROW + i];
        }
    }
    return (aoi_modes){.n = ROW, .ports = TWO, .omega = omega, .decay = decay, .shape = r, .push = r,
                       .gravity = modes->g, .centre = modes->centre};
}

/* Damped, and under gravity. */
static void two_ports_of_a_damped_row_are_those_of_its_modes(aoi_rule rule, aoi_rayleigh damping)
{
    static chain_body c;
    static double work[10 * ROW + 2 * TWO * TWO], modal_work[6 * ROW + 12];
    const double zero[ROW] = {0.0};
    row_motion nodes, modes;
    row_make(&c, rule, damping, work + 8 * ROW + 8);
    for (int i = 0; i < ROW; i++) {
        nodes.g[i] = 0.01 * (i - 2);
        nodes.v[i] = 0.1 * i;
        nodes.centre[i] = c.centre[i];
    }
    const aoi_modes modal = row_modes(&c, &nodes, &modes);
    const aoi_body_start begin = {zero, nodes.v, nodes.centre, nodes.g, NULL};
    const aoi_body_start modal_begin = {zero, modes.v, NULL, NULL, NULL};
    aoi_body in_modes;
    CHECK(aoi_body_start_full(&c.body, &c.full, &rule, &begin, work) == AOI_OK, "finite elements");
    CHECK(aoi_body_start_modal(&in_modes, &modal, &rule, &modal_begin, modal_work) == AOI_OK,
          "modes");
    const double at_start[TWO] = {0.3, -0.2};
    CHECK(c.body.begin(&c.body, at_start) == AOI_OK && in_modes.begin(&in_modes, at_start) == AOI_OK,
          "begin");
    for (int i = 0; i < TWO * TWO; i++) {
        CHECK(fabs(c.body.compliance[i] - in_modes.compliance[i]) < 1e-14 * *c.body.compliance,
              "compliance %d", i);
    }
    for (int step = 1; step <= 200; step++) {
        const double force[TWO] = {0.3 * cos(0.1 * step), -0.2 * cos(0.07 * step)};
        double u[TWO], w[TWO], a[TWO_ROWS], b[TWO_ROWS];
        aoi_body *both[] = {&c.body, &in_modes};
        for (int i = 0; i < 2; i++) {
            CHECK(both[i]->predict(both[i], u, w) == AOI_OK, "predict");
            both[i]->correct(both[i], force);
            both[i]->observe(both[i], 1, i == 0 ? a : b, 1);
        }
        for (int i = 0; i < TWO_ROWS; i++) {
            CHECK(fabs(a[i] - b[i]) < 1e-11, "row %d of step %d: %g and %g", i, step, a[i], b[i]);
        }
    }
}

/* K u = b f: loaded so, a body at rest stays at rest, and let go it starts with a = -M^-1 b f. */
static void a_body_in_equilibrium_stays(void)
{
    static chain_body c;
    const aoi_rule rule = {0.05, 0.25, 0.5};
    double k[MOST], m[MOST], force = 2.0;
    for (int i = 0; i < 8; i++) {
        k[i] = 1.0;
        m[i] = 1.0 + 0.5 * i;
    }
    chain_body_fill(&c, 8, 1.0, k, m);
    chain_body_factorise(&c, rule, k, 1.0);
    c.b[7] = 1.0;
    for (int i = 0; i < 8; i++) {
        c.u0[i] = force * (i + 1);
    }
    CHECK(chain_body_start(&c, rule) == AOI_OK && c.body.begin(&c.body, &force) == AOI_OK, "loaded");
    for (int j = 0; j < 100; j++) {
        CHECK(step_with(&c.body, force) == AOI_OK, "a step");
    }
    CHECK(near(observe(&c.body).displacement, 16.0, 1e-13), "it has not moved");
    CHECK(fabs(observe(&c.body).velocity) < 1e-13, "nor does it move");
    CHECK(chain_body_start(&c, rule) == AOI_OK && step_with(&c.body, 0.0) == AOI_OK, "let go");
    /* The last mass alone is pulled back by force / m at first. */
    const double first = -force / m[7] * 0.05;
    CHECK(near(observe(&c.body).velocity, first, 1e-3), "it starts at once, %g",
          observe(&c.body).velocity / first);
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
    const aoi_rule rule = {1e-6, 0.25, 0.5};
    const aoi_rule bad[] = {{0.0, 0.25, 0.5},         {-1.0, 0.25, 0.5},
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
    const aoi_rule far = {1e60, 0.25, 0.5};
    factor = 1e200;
    CHECK(chain_body_start(&c, far) == AOI_ERROR_NOT_FINITE, "a step of infinite reach");
    factor = 1.0;
    c.b[0] = 0.0;
    CHECK(chain_body_start(&c, rule) == AOI_ERROR_NOT_POSITIVE, "a contact that touches nothing");
}

int main(void)
{
    const aoi_rule rules[] = {{1e-6, 0.25, 0.5}, {2e-6, 1.0 / 6.0, 0.5}, {3e-6, 0.3025, 0.6}};
    for (size_t i = 0; i < 3; i++) {
        for (int constrained = 0; constrained < 2; constrained++) {
            star_and_its_matrices_are_one_body(constrained ? 1e7 : 0.0, rules[i], 1.0);
            star_and_its_matrices_are_one_body(constrained ? 1e7 : 0.0, rules[i], -2.5);
        }
    }
    same_impact_on_both(0.0);
    same_impact_on_both(1e8);
    for (int32_t n = 1; n <= MOST; n = 2 * n + 1) {
        for (int mode = 1; mode <= n; mode += 1 + n / 3) {
            mode_keeps_its_shape(n, mode);
        }
    }
    two_ports_of_a_damped_row_are_those_of_its_modes(rules[0], (aoi_rayleigh){0.0, 0.0});
    const aoi_rule coarse = {0.2, 0.25, 0.5}, damped = {0.1, 0.3025, 0.6};
    two_ports_of_a_damped_row_are_those_of_its_modes(coarse, (aoi_rayleigh){0.1, 0.0});
    two_ports_of_a_damped_row_are_those_of_its_modes(coarse, (aoi_rayleigh){0.0, 0.2});
    two_ports_of_a_damped_row_are_those_of_its_modes(damped, (aoi_rayleigh){0.05, 0.1});
    a_body_in_equilibrium_stays();
    bad_bodies_and_solvers();
    return check_report();
}
