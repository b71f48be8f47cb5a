/* Newmark's rule on natural modes: a residual compliance at the start. What else a body in modes does, test_newmark.c and
 * test_full.c compare with its matrices. */
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

/* The last column of a body with two ports. */
static void look(const modes *m, double *row)
{
    for (size_t i = 0; i < ROWS_OF_TWO; i++) {
        row[i] = row_of_body(&m->world, 0, i)[m->world.at];
    }
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
    what_presses_at_the_start_has_bent_the_residual();
    return check_report();
}
