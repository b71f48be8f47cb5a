/* Newmark's rule on finite elements: a row of masses against its own modes, damped or not; bodies and solvers that are
 * refused. */
#include "body.h"

enum { MOST = 6 };

/* A chain of n masses on springs k between them and k_first at the start, and the factors of its tridiagonal matrix:
 * L has one entry a column. */
typedef struct chain_body {
    aoi_full full;
    world world;
    int32_t start[MOST + 1], indices[3 * MOST], m_start[MOST + 1], m_indices[MOST];
    double k_values[3 * MOST], m_values[MOST], l_values[MOST], pivots[MOST];
    double b[MOST], centre[MOST], u0[MOST], v0[MOST];
} chain_body;

/* x <- A^-1 x by two sweeps. */
static int sweep(void *data, double *x)
{
    const chain_body *c = data;
    const size_t n = c->full.K.n;
    for (size_t i = 1; i < n; i++) {
        x[i] -= c->l_values[i - 1] * x[i - 1];
    }
    for (size_t i = n; i-- > 0;) {
        x[i] = x[i] / c->pivots[i] - (i + 1 < n ? c->l_values[i] * x[i + 1] : 0.0);
    }
    return 0;
}

static void chain_body_fill(chain_body *c, int32_t n, double k_first, const double *k, const double *m)
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
        c->m_start[i] = c->m_indices[i] = i;
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
    c->full.solver = (aoi_solver){sweep, c};
}

static aoi_modes chain_body_model(const chain_body *c)
{
    return (aoi_modes){.n = c->full.K.n, .ports = 1, .shape = c->b, .push = c->b, .centre = c->centre, .full = &c->full};
}

static int chain_body_start(chain_body *c, aoi_rule rule, size_t steps)
{
    memset(&c->world, 0, sizeof c->world);
    (void)add_body(&c->world, chain_body_model(c), c->u0, c->v0);
    by_hand(&c->world);
    return world_start(&c->world, rule, steps + 1, NULL);
}

enum { ROW = 6, TWO = 2, TWO_ROWS = AOI_BODY_ROWS + AOI_PORT_ROWS * TWO };

typedef struct row_motion {
    double g[ROW], v[ROW], centre[ROW]; /* gravity, velocities at the start, the centre of mass */
} row_motion;

/* A row of masses on springs between walls, touched at two places, whose functionals it writes. */
static void row_make(chain_body *c, aoi_rule rule, const double *damping, double *ports_b)
{
    double k[ROW], m[ROW];
    for (int i = 0; i < ROW; i++) {
        k[i] = m[i] = 1.0;
    }
    chain_body_fill(c, ROW, 1.0, k, m);
    c->k_values[c->start[ROW] - 1] += 1.0; /* a spring behind the last, too */
    const double of_mass = 1.0 + damping[0] * rule.gamma * rule.dt;
    const double reach = rule.dt * rule.gamma * damping[1] + rule.beta * rule.dt * rule.dt;
    for (int i = 0; i < ROW; i++) { /* L D L^T of the tridiagonal matrix */
        c->pivots[i] = of_mass + 2.0 * reach;
        if (i > 0) {
            c->l_values[i - 1] = -reach / c->pivots[i - 1];
            c->pivots[i] += reach * c->l_values[i - 1];
        }
    }
    ports_b[1] = ports_b[ROW + 4] = 1.0;
    ports_b[ROW + 5] = -0.5;
    c->full.alpha = damping[0];
    c->full.beta = damping[1];
}

/* The same row in its modes, which are sines. */
static aoi_modes row_modes(const chain_body *c, const double *b, const row_motion *nodes, row_motion *modes)
{
    static double omega[ROW], decay[ROW], r[TWO * ROW];
    const double damping[] = {c->full.alpha, c->full.beta};
    for (int j = 0; j < ROW; j++) {
        const double angle = PI * (j + 1) / (ROW + 1), norm = sqrt(2.0 / (ROW + 1));
        omega[j] = 2.0 * sin(0.5 * angle);
        decay[j] = 0.5 * (damping[0] + damping[1] * omega[j] * omega[j]);
        modes->g[j] = modes->v[j] = modes->centre[j] = r[j] = r[ROW + j] = 0.0;
        for (int i = 0; i < ROW; i++) {
            const double shape = norm * sin(angle * (i + 1));
            modes->g[j] += shape * nodes->g[i];
            modes->v[j] += shape * nodes->v[i];
            modes->centre[j] += shape * nodes->centre[i];
            r[j] += shape * b[i];
            r[ROW + j] += shape * b[ROW + i];
        }
    }
    return (aoi_modes){.n = ROW, .ports = TWO, .omega = omega, .decay = decay, .shape = r, .push = r,
                       .gravity = modes->g, .centre = modes->centre};
}

/* Damped, and under gravity. */
static void two_ports_of_a_damped_row_are_those_of_its_modes(aoi_rule rule, double alpha, double beta)
{
    static chain_body c;
    static double b[TWO * ROW];
    const double damping[] = {alpha, beta};
    double zero[ROW] = {0.0}, still = 0.0;
    const double own = 1.0, none = 0.0, k = 1.0, force[] = {-0.3, 0.2};
    row_motion nodes, modes;
    world both[2];
    aoi_law law;
    CHECK(aoi_law_create(&law, "linear", 1, &k) == AOI_OK, "a spring");
    row_make(&c, rule, damping, b);
    for (int i = 0; i < ROW; i++) {
        nodes.g[i] = 0.01 * (i - 2);
        nodes.v[i] = 0.1 * i;
        nodes.centre[i] = c.centre[i];
    }
    const aoi_modes models[] = {{.n = ROW, .ports = TWO, .shape = b, .push = b, .gravity = nodes.g,
                                 .centre = nodes.centre, .full = &c.full},
                                row_modes(&c, b, &nodes, &modes)};
    const aoi_modes far = {.n = 1, .ports = 1, .omega = &none, .shape = &own, .push = &own, .centre = &own};
    for (int i = 0; i < 2; i++) {
        memset(&both[i], 0, sizeof both[i]);
        (void)add_body(&both[i], models[i], zero, i == 0 ? nodes.v : modes.v);
        for (size_t p = 0; p < TWO; p++) { /* what presses at the start, though it is too far to touch */
            const size_t body = add_body(&both[i], far, &still, &still);
            both[i].contact[both[i].system.contact_count++] = (aoi_contact){{0, body}, {p, 0}, 1e9, &law, NULL, NULL};
        }
        both[i].start.force = force;
        by_hand(&both[i]);
        CHECK(world_start(&both[i], rule, 201, NULL) == AOI_OK, "starts");
    }
    for (int step = 1; step <= 200; step++) {
        for (int i = 0; i < 2; i++) {
            both[i].push[0] = 0.3 * cos(0.1 * step);
            both[i].push[1] = -0.2 * cos(0.07 * step);
            CHECK(step_on(&both[i]) == AOI_OK, "a step");
        }
        for (size_t i = 0; i < TWO_ROWS; i++) {
            const double one = row_of_body(&both[0], 0, i)[step], other = row_of_body(&both[1], 0, i)[step];
            CHECK(fabs(one - other) < 1e-11, "row %zu of step %d: %g and %g", i, step, one, other);
        }
    }
    drop();
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
    const double masses[] = {0.02, 0.3}, spring[] = {4e8};
    const aoi_rule rule = {1e-6, 0.25, 0.5}, far = {1e60, 0.25, 0.5};
    double factor;
    const struct {
        const char *what;
        double lie, b;
        const aoi_rule *rule;
        int status;
    } lies[] = {{"a body that comes towards the force", -1.0, 1.0, &rule, AOI_ERROR_NOT_POSITIVE},
                {"a solver that returns NaN", (double)NAN, 1.0, &rule, AOI_ERROR_NOT_FINITE},
                {"a step of infinite reach", 1e200, 1.0, &far, AOI_ERROR_NOT_FINITE},
                {"a contact that touches nothing", 1.0, 0.0, &rule, AOI_ERROR_NOT_POSITIVE}};
    chain_body_fill(&c, 2, 0.0, spring, masses);
    c.b[0] = 1.0;
    int calls_left = 0;
    c.full.solver = (aoi_solver){solver_that_fails, &calls_left};
    CHECK(chain_body_start(&c, rule, 4) == AOI_ERROR_SOLVER, "the solver fails at once");
    calls_left = 3;
    CHECK(chain_body_start(&c, rule, 4) == AOI_OK, "the solver works three times");
    size_t done;
    CHECK(aoi_newmark_run(c.world.run, 4, &done) == AOI_ERROR_SOLVER && done == 2, "and then fails");
    c.full.solver = (aoi_solver){solver_that_lies, &factor};
    for (size_t i = 0; i < sizeof lies / sizeof *lies; i++) {
        factor = lies[i].lie;
        c.b[0] = lies[i].b;
        CHECK(chain_body_start(&c, *lies[i].rule, 1) == lies[i].status, "%s", lies[i].what);
    }
    c.b[0] = factor = 1.0;
    aoi_modes wrong[7];
    aoi_full matrices[7];
    for (size_t i = 0; i < 7; i++) {
        matrices[i] = c.full;
        wrong[i] = chain_body_model(&c);
        wrong[i].full = &matrices[i];
    }
    wrong[0].omega = masses;
    wrong[1].residual = masses;
    matrices[2].K.n = 1;
    matrices[3].M.n = 1;
    matrices[4].alpha = -1.0;
    matrices[5].beta = (double)INFINITY;
    matrices[6].solver.solve = NULL;
    for (size_t i = 0; i < 7; i++) {
        memset(&c.world, 0, sizeof c.world);
        (void)add_body(&c.world, wrong[i], c.u0, c.v0);
        CHECK(world_start(&c.world, rule, 1, NULL) == AOI_ERROR_ARGUMENT, "body %zu", i);
    }
    CHECK(chain_body_start(&c, rule, 1) == AOI_OK, "none of these");
    void *run = keep(aoi_adaptive_size(&c.world.system));
    CHECK(aoi_adaptive_start(run, &c.world.system, &c.world.start, 1e-6, 1.0) == AOI_ERROR_ARGUMENT, "only in fixed steps");
    drop();
}

int main(void)
{
    const aoi_rule fine = {1e-6, 0.25, 0.5}, coarse = {0.2, 0.25, 0.5}, damped = {0.1, 0.3025, 0.6};
    two_ports_of_a_damped_row_are_those_of_its_modes(fine, 0.0, 0.0);
    two_ports_of_a_damped_row_are_those_of_its_modes(coarse, 0.1, 0.0);
    two_ports_of_a_damped_row_are_those_of_its_modes(coarse, 0.0, 0.2);
    two_ports_of_a_damped_row_are_those_of_its_modes(damped, 0.05, 0.1);
    bad_bodies_and_solvers();
    return check_report();
}
