/* What a body does over one step under polynomial forces: against Duhamel's integral by quadrature, from
 * modes that hardly move to modes that turn many times within the step. */
#include "numeric.h"
#include "plant.h"
#include "law/law.h"
#include "motion/modes.h"
#include "motion/oscillator.h"
#include "motion/radau.h"
#include "motion/response.h"

enum { PANELS = 250 };

/* A body of two ports with slow and fast modes, damped or not, under gravity and loads that rise. */
static void furnish(plant *p, int damped, int driven)
{
    uint64_t seed = 21;
    part *body = add_ringing(p, 7, 2, 1.7, 1.0, 0.3, &seed);
    const double omega[] = {0.0, 0.01, 0.6, 2.7, 3.3, 17.0, 60.0};
    const double decay[] = {0.0, 0.02, 0.6, 9.0, 0.01, 1.0, 30.0}; /* up to over- and just critical */
    memcpy(body->omega, omega, sizeof omega);
    memcpy(body->decay, decay, sizeof decay);
    body->damped = damped;
    for (size_t j = 0; j < body->n; j++) {
        body->push[j] *= 0.5 + 0.2 * (double)j; /* shape and push need not agree */
        body->gravity[j] = 0.4 - 0.1 * (double)j;
        body->x[j] = 0.02 * (double)(j % 3);
        body->v[j] = 0.1 * (double)(j % 4);
    }
    body->pulled = driven;
    body->load_count = driven ? 2 : 0;
    const double time[] = {-1.0, 5.0}, force[] = {0.0, 2.0, 3.0, -4.0};
    memcpy(body->load_time, time, sizeof time);
    memcpy(body->load_force, force, sizeof force);
    lay_out(p);
}

/* A polynomial force, by its values at the nodes, and none at the other port. */
static void choose_forces(uint64_t *seed, size_t port, double *force)
{
    for (size_t k = 0; k < 2 * AOI_NODES; k++) {
        force[k] = k / AOI_NODES == port || port > 1 ? 2.0 * uniform(seed) - 0.5 : 0.0;
    }
}

/* To a share of the step h: free free motion (test_free.c), and Duhamel's integral of what the forces did. */
static void by_duhamel(const plant *p, double h, const double *force, double place, double *x, double *v)
{
    const part *of = &p->part[0];
    const double end = place * h, length = end / PANELS;
    aoi_modes_advance(p->body, 0.0, end, x, v);
    for (int k = 0; k < PANELS * GAUSS; k++) {
        const double t = length * (k / GAUSS + GAUSS_AT[k % GAUSS]);
        const double weight = length * GAUSS_WEIGHT[k % GAUSS];
        const double f[2] = {through_nodes(force, t / h), through_nodes(force + AOI_NODES, t / h)};
        for (size_t j = 0; j < of->n; j++) {
            const double push = of->push[j] * f[0] + of->push[of->n + j] * f[1];
            aoi_motion m;
            aoi_oscillator_motion(of->omega[j], of->damped ? of->decay[j] : 0.0, end - t, &m);
            x[j] += weight * push * m.impulse;
            v[j] += weight * push * m.rate;
        }
    }
}

static double port_of(const plant *p, size_t port, const double *x)
{
    return displacement_of(p, 0, port, x);
}

static void a_step_ends_where_duhamel_says(void)
{
    uint64_t seed = 6;
    for (int kind = 0; kind < 4; kind++) {
        plant p = {.bodies = 0};
        double force[2 * AOI_NODES];
        furnish(&p, kind % 2, kind / 2);
        choose_forces(&seed, 2, force);
        const double h = 1.3;
        aoi_response response;
        double *block = malloc(aoi_response_size(p.body, p.body->ports) * sizeof(double));
        aoi_response_make(&response, p.body, NULL, h, 1, block);
        double x[MOST_MODES], v[MOST_MODES];
        memcpy(x, p.x, sizeof x);
        memcpy(v, p.v, sizeof v);
        by_duhamel(&p, h, force, 1.0, x, v);
        aoi_response_propagate(&response, p.body, 0.0, force, p.x, p.v);
        for (size_t j = 0; j < p.part[0].n; j++) {
            CHECK(fabs(p.x[j] - x[j]) < 1e-14, "kind %d, mode %zu: %.14g, not %.14g", kind, j, p.x[j], x[j]);
            CHECK(fabs(p.v[j] - v[j]) < 1e-13, "kind %d, mode %zu: velocity %.14g, not %.14g", kind, j, p.v[j], v[j]);
        }
        free(block);
    }
}

static void a_push_reaches_any_place_within_the_step(void)
{
    uint64_t seed = 7;
    const double places[] = {1e-3, 0.2, 0.77, 1.0};
    for (int damped = 0; damped < 2; damped++) {
        for (int i = 0; i < 4; i++) {
            plant p = {.bodies = 0};
            double force[2 * AOI_NODES], x[MOST_MODES], v[MOST_MODES];
            furnish(&p, damped, 1);
            choose_forces(&seed, 2, force);
            memcpy(x, p.x, sizeof x);
            memcpy(v, p.v, sizeof v);
            const double h = 1.3;
            by_duhamel(&p, h, force, places[i], x, v);
            aoi_response_carry(p.body, 0.0, h, force, places[i], p.x, p.v);
            for (size_t j = 0; j < p.part[0].n; j++) {
                CHECK(fabs(p.x[j] - x[j]) < 1e-14, "to %g, mode %zu", places[i], j);
                CHECK(fabs(p.v[j] - v[j]) < 1e-13, "to %g, mode %zu: velocity", places[i], j);
            }
        }
    }
}

/* Displacement and rate of each port at the nodes: the homogeneous part, and the influence of a force at
 * each of the ports. */
static void ports_move_at_the_nodes_as_the_modes_do(void)
{
    uint64_t seed = 9;
    for (int kind = 0; kind < 4; kind++) {
        for (size_t pushed = 0; pushed < 2; pushed++) {
            plant p = {.bodies = 0};
            double force[2 * AOI_NODES];
            furnish(&p, kind % 2, kind / 2);
            choose_forces(&seed, pushed, force);
            const double h = 1.3;
            aoi_response response;
            double *block = malloc(aoi_response_size(p.body, p.body->ports) * sizeof(double));
            aoi_response_make(&response, p.body, NULL, h, 1, block);
            for (size_t port = 0; port < 2; port++) {
                double moved[AOI_NODES] = {0.0}, rate[AOI_NODES] = {0.0};
                aoi_response_homogeneous(&response, p.body, port, -1.0, 0.0, p.x, p.v, NULL, moved, rate);
                const size_t pair = (port * 2 + pushed) * AOI_NODES * AOI_NODES;
                for (size_t i = 0; i < AOI_NODES; i++) {
                    double x[MOST_MODES], v[MOST_MODES];
                    memcpy(x, p.x, sizeof x);
                    memcpy(v, p.v, sizeof v);
                    by_duhamel(&p, h, force, aoi_radau_node[i], x, v);
                    double u = -moved[i], du = -rate[i];
                    for (size_t k = 0; k < AOI_NODES; k++) {
                        const double f = force[pushed * AOI_NODES + k];
                        u += response.influence[pair + k * AOI_NODES + i] * f;
                        du += response.influence_rate[pair + k * AOI_NODES + i] * f;
                    }
                    CHECK(fabs(u - (port_of(&p, port, x) - port_of(&p, port, p.x))) < 1e-14,
                          "kind %d, force at %zu, port %zu, node %zu", kind, pushed, port, i);
                    CHECK(fabs(du - port_of(&p, port, v)) < 1e-13,
                          "kind %d, force at %zu, port %zu, node %zu: rate", kind, pushed, port, i);
                }
            }
            free(block);
        }
    }
}

/* The influence of a force on a port is the sum of those on the modes, by what each has of both ports. */
static void influences_are_sums_over_the_modes(void)
{
    plant p = {.bodies = 0};
    furnish(&p, 1, 0);
    p.part[0].decay[2] = p.part[0].decay[3] = 0.0; /* slow modes, too */
    const aoi_columns by_modes = {AOI_BY_MODES, NULL, NULL};
    aoi_response whole, apart;
    double *block[2] = {malloc(aoi_response_size(p.body, 2) * sizeof(double)),
                        malloc(aoi_response_size(p.body, AOI_BY_MODES) * sizeof(double))};
    aoi_response_make(&whole, p.body, NULL, 0.9, 1, block[0]);
    aoi_response_make(&apart, p.body, &by_modes, 0.9, 1, block[1]);
    const part *of = &p.part[0];
    for (size_t i = 0; i < 4 * AOI_NODES * AOI_NODES; i++) {
        const size_t pair = i / (AOI_NODES * AOI_NODES), at = i % (AOI_NODES * AOI_NODES);
        double sum = 0.0, rate = 0.0;
        for (size_t j = 0; j < of->n; j++) {
            const double weight = of->shape[pair / 2 * of->n + j] * of->push[pair % 2 * of->n + j];
            sum += weight * apart.influence[j * AOI_NODES * AOI_NODES + at];
            rate += weight * apart.influence_rate[j * AOI_NODES * AOI_NODES + at];
        }
        CHECK(fabs(sum - whole.influence[i]) < 1e-15 && fabs(rate - whole.influence_rate[i]) < 1e-14, "pair %zu", pair);
    }
    free(block[0]);
    free(block[1]);
}

/* A load that rises bends the residual compliance along with it. */
static void a_rising_load_moves_the_residual(void)
{
    plant p = {.bodies = 0};
    furnish(&p, 0, 1);
    const double residual[] = {0.3, 0.1, 0.1, 0.2}, h = 0.5, slopes[] = {0.5, -1.0};
    aoi_response response;
    double *block = malloc(aoi_response_size(p.body, p.body->ports) * sizeof(double));
    aoi_response_make(&response, p.body, NULL, h, 1, block);
    double without[AOI_NODES] = {0.0}, with[AOI_NODES] = {0.0};
    double rate_without[AOI_NODES] = {0.0}, rate_with[AOI_NODES] = {0.0};
    aoi_response_homogeneous(&response, p.body, 1, 1.0, 0.0, p.x, p.v, NULL, without, rate_without);
    aoi_modes massless = p.body[0];
    massless.residual = residual;
    aoi_response_homogeneous(&response, &massless, 1, 1.0, 0.0, p.x, p.v, NULL, with, rate_with);
    const double rate = residual[2] * slopes[0] + residual[3] * slopes[1];
    for (size_t i = 0; i < AOI_NODES; i++) {
        CHECK(fabs(with[i] - without[i] - rate * h * aoi_radau_node[i]) < 1e-15, "R f' t at node %zu", i);
        CHECK(fabs(rate_with[i] - rate_without[i] - rate) < 1e-14, "R f' at node %zu", i);
    }
    free(block);
}

int main(void)
{
    a_step_ends_where_duhamel_says();
    a_push_reaches_any_place_within_the_step();
    ports_move_at_the_nodes_as_the_modes_do();
    influences_are_sums_over_the_modes();
    a_rising_load_moves_the_residual();
    return check_report();
}
