/* Newmark's rule on natural modes: two ports answer each other alike; a residual compliance is a spring; the ledger
 * closes. */
#include "body.h"
#include "linear/vector.h"

enum { MOST = 12, PORTS = 2, ROWS_OF_TWO = AOI_BODY_ROWS + AOI_PORT_ROWS * PORTS };

static const aoi_rule AVERAGE = {1e-6, 0.25, 0.5};

/* One body in random modes. */
typedef struct modes {
    double omega[MOST], decay[MOST], participation[PORTS * MOST], residual[PORTS * PORTS];
    double u[MOST], v[MOST], centre[MOST], gravity[MOST];
    world world;
} modes;

static void set_modal(modes *m, size_t n, size_t ports, int with_residual, int with_gravity)
{
    const aoi_modes body = {.n = n, .ports = ports, .omega = m->omega, .decay = m->decay, .shape = m->participation,
                            .push = m->participation, .residual = with_residual ? m->residual : NULL,
                            .gravity = with_gravity ? m->gravity : NULL, .centre = m->centre};
    memset(&m->world, 0, sizeof m->world);
    (void)add_body(&m->world, body, m->u, m->v);
    by_hand(&m->world);
}

static void modes_random(modes *m, size_t n, size_t ports, uint64_t *seed)
{
    memset(m, 0, sizeof *m);
    for (size_t j = 0; j < n; j++) {
        m->omega[j] = j == 0 ? 0.0 : decades(seed, 3.0, 6.0);
        for (size_t i = j; i > 0 && m->omega[i] < m->omega[i - 1]; i--) {
            const double higher = m->omega[i - 1];
            m->omega[i - 1] = m->omega[i];
            m->omega[i] = higher;
        }
        m->u[j] = 1e-6 * uniform(seed);
        m->v[j] = uniform(seed) - 0.5;
        m->centre[j] = uniform(seed);
        m->gravity[j] = 10.0 * (uniform(seed) - 0.5);
        for (size_t p = 0; p < ports; p++) {
            m->participation[p * n + j] = 2.0 * (uniform(seed) - 0.5);
        }
    }
    for (size_t j = 0; j < n; j++) {
        m->decay[j] = 0.1 * m->omega[j] * uniform(seed);
    }
    set_modal(m, n, ports, 1, 1);
}

/* The last column of a body with two ports. */
static void look(const modes *m, double *row)
{
    for (size_t i = 0; i < ROWS_OF_TWO; i++) {
        row[i] = row_of_body(&m->world, 0, i)[m->world.at];
    }
}

static void push_both(modes *m, const double *force, double *row)
{
    memcpy(m->world.push, force, PORTS * sizeof *force);
    CHECK(step_on(&m->world) == AOI_OK, "a step");
    look(m, row);
}

/* A force on one port moves the other as the other's would move the first. */
static void ports_are_reciprocal(void)
{
    static modes m;
    double moved[PORTS][PORTS], row[ROWS_OF_TWO];
    for (int p = 0; p < PORTS; p++) {
        uint64_t seed = 3;
        const double force[PORTS] = {p == 0 ? 1e3 : 0.0, p == 1 ? 1e3 : 0.0};
        modes_random(&m, MOST, PORTS, &seed);
        memset(m.u, 0, sizeof m.u);
        memset(m.v, 0, sizeof m.v);
        m.residual[0] = 3e-9;
        m.residual[1] = m.residual[2] = 1e-9;
        m.residual[3] = 2e-9;
        set_modal(&m, MOST, PORTS, 1, 0);
        CHECK(world_start(&m.world, AVERAGE, 51, NULL) == AOI_OK, "two ports");
        for (int j = 0; j < 50; j++) {
            push_both(&m, force, row);
        }
        moved[p][0] = row[AOI_BODY_ROWS];
        moved[p][1] = row[AOI_BODY_ROWS + AOI_PORT_ROWS];
    }
    CHECK(near(moved[0][1], moved[1][0], 1e-12) && moved[0][1] != 0.0, "reciprocal: %g, %g", moved[0][1], moved[1][0]);
    drop();
}

/* Energy put in by forces on both ports and by gravity is in motion, strain or lost, to rounding. */
static void the_ledger_closes(void)
{
    static modes m;
    uint64_t seed = 9;
    double row[ROWS_OF_TWO], worst = 0.0;
    modes_random(&m, MOST, PORTS, &seed);
    m.residual[0] = m.residual[3] = 2e-9;
    CHECK(world_start(&m.world, AVERAGE, 2001, NULL) == AOI_OK, "start");
    look(&m, row);
    CHECK(near(row[AOI_BODY_ROWS], aoi_vector_dot(MOST, m.participation, m.u), 1e-12),
          "nothing has bent it before a force is there");
    const double start = row[AOI_BODY_KINETIC] + row[AOI_BODY_ELASTIC];
    for (int j = 1; j <= 2000; j++) {
        const double force[PORTS] = {1e3 * cos(0.01 * j), -500.0 * cos(0.02 * j)};
        push_both(&m, force, row);
        const double now = row[AOI_BODY_KINETIC] + row[AOI_BODY_ELASTIC] + row[AOI_BODY_DISSIPATED];
        worst = fmax(worst, fabs(now - row[AOI_BODY_WORK] - start) / (fabs(row[AOI_BODY_WORK]) + start));
    }
    CHECK(worst < 1e-12, "off by %g", worst);
    drop();
}

/* x'' + 2 s x' + w^2 x = r f with f rising straight, from rest: in closed form, to second order. */
static void a_ramp_is_followed_to_second_order(void)
{
    static modes m;
    const double w = 2e4, s = 3e3, slope = 1e6, duration = 5e-4;
    double error[3];
    for (int level = 0; level < 3; level++) {
        const int steps = 200 << level;
        const aoi_rule rule = {duration / steps, 0.25, 0.5};
        memset(&m, 0, sizeof m);
        m.omega[0] = w;
        m.decay[0] = s;
        m.participation[0] = 1.0;
        set_modal(&m, 1, 1, 0, 0);
        CHECK(world_start(&m.world, rule, (size_t)steps + 1, NULL) == AOI_OK, "a mode");
        for (int j = 1; j <= steps; j++) {
            (void)step(&m.world, slope * rule.dt * j);
        }
        const double fast = sqrt(w * w - s * s), decayed = exp(-s * duration);
        const double late = slope / (w * w) * (duration - 2.0 * s / (w * w));
        const double swing = slope / (w * w) * 2.0 * s / (w * w);
        const double rate = (slope / (w * w) - s * swing) / fast;
        const double exact =
            late + decayed * (swing * cos(fast * duration) - rate * sin(fast * duration));
        error[level] = observe(&m.world, 0).displacement - exact;
    }
    CHECK(fabs(error[0] / error[1] - 4.0) < 0.1 && fabs(error[1] / error[2] - 4.0) < 0.05,
          "halving dt quarters the error: %g, %g, %g", error[0], error[1], error[2]);
}

static void what_cannot_be_is_refused(void)
{
    static modes m;
    const struct {
        const char *what;
        double *at, value;
    } wrong[] = {{"negative damping", &m.decay[1], -1.0},
                 {"a frequency of NaN", &m.omega[2], (double)NAN},
                 {"infinite participation", &m.participation[1], (double)INFINITY}};
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        uint64_t seed = 5;
        modes_random(&m, 3, 1, &seed);
        *wrong[i].at = wrong[i].value;
        CHECK(world_start(&m.world, AVERAGE, 1, NULL) == AOI_ERROR_ARGUMENT, "%s", wrong[i].what);
    }
    uint64_t seed = 5;
    modes_random(&m, 3, 1, &seed);
    m.omega[2] = 1e200;
    CHECK(world_start(&m.world, AVERAGE, 1, NULL) == AOI_ERROR_NOT_FINITE, "a stiffness beyond all numbers");
    m.omega[2] = 1e6;
    CHECK(world_start(&m.world, AVERAGE, 1, NULL) == AOI_OK, "none of these");
    drop();
}

/* u = R f before the first step, under the forces that the body starts with; and so are rates. */
static void what_presses_at_the_start_has_bent_the_residual(void)
{
    static modes m;
    const double k = 1.0, times[] = {0.0, 1.0}, loads[] = {50.0, 0.0, 250.0, 0.0};
    const double force[] = {-50.0, 40.0}, rate[] = {-2e6, 3e6}, own = 1.0, mass = 1.0, zero = 0.0;
    const double f[] = {100.0, -40.0, 2e6 + 200.0, -3e6}; /* N, then N/s: loads less contact forces */
    double row[ROWS_OF_TWO], still = 0.0;
    const aoi_modes ball = {.n = 1, .ports = 1, .omega = &zero, .shape = &own, .push = &mass, .centre = &own};
    aoi_law law;
    CHECK(aoi_law_create(&law, "linear", 1, &k) == AOI_OK, "a spring");
    memset(&m, 0, sizeof m);
    m.residual[0] = 3e-7;
    m.residual[1] = m.residual[2] = 1e-7;
    m.residual[3] = 2e-7;
    set_modal(&m, 1, PORTS, 1, 0);
    m.world.body[0].load = (aoi_load){2, times, loads};
    for (size_t p = 0; p < PORTS; p++) {
        const size_t b = add_body(&m.world, ball, &still, &still);
        m.world.contact[m.world.system.contact_count++] = (aoi_contact){{0, b}, {p, 0}, 1e3, &law, NULL, NULL};
    }
    m.world.start.force = force;
    m.world.start.force_rate = rate;
    m.world.start.rested = 1;
    CHECK(world_start(&m.world, AVERAGE, 1, NULL) == AOI_OK, "starts");
    look(&m, row);
    for (size_t p = 0; p < PORTS; p++) {
        const double wanted = m.residual[2 * p] * f[0] + m.residual[2 * p + 1] * f[1];
        CHECK(near(row[AOI_BODY_ROWS + AOI_PORT_ROWS * p], wanted, 1e-15), "port %zu", p);
        const double moved = m.residual[2 * p] * f[2] + m.residual[2 * p + 1] * f[3];
        CHECK(near(row[AOI_BODY_ROWS + AOI_PORT_ROWS * p + 1], moved, 1e-9), "rate of port %zu", p);
    }
    CHECK(m.world.record[FORCE] == force[0], "and the contact forces are those");
    drop();
}

int main(void)
{
    ports_are_reciprocal();
    the_ledger_closes();
    a_ramp_is_followed_to_second_order();
    what_presses_at_the_start_has_bent_the_residual();
    what_cannot_be_is_refused();
    return check_report();
}
