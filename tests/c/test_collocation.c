/* One step of contact: contacts solved together are what each is alone, forces between bodies balance,
 * and errors fall with the order that the method has. */
#include "numeric.h"
#include "plant.h"
#include "linear/vector.h"
#include "law/law.h"
#include "motion/modes.h"
#include "motion/polynomial.h"
#include "motion/radau.h"
#include "motion/response.h"
#include "collocation/collocation.h"

enum { MOST_WORK = 200000 };

/* All contacts closed, at the beginning of a step of length h from the plant's start, solved. */
static int solve_at_edge(plant *p, double h, size_t span, int with_rates, enum aoi_edge edge)
{
    static double work[MOST_WORK];
    CHECK(aoi_collocation_size(p->contacts, span) <= MOST_WORK, "room");
    for (size_t b = 0; b < p->bodies; b++) {
        double *block = p->work + b * 20000;
        CHECK(aoi_response_size(&p->body[b], p->body[b].ports) < 20000, "room");
        aoi_response_make(&p->response[b], &p->body[b], NULL, h, with_rates, block);
    }
    for (size_t c = 0; c < p->contacts; c++) {
        const aoi_contact *contact = &p->contact[c];
        double rate = 0.0, start = -contact->gap;
        aoi_contact_step *entry = &p->entry[c];
        *entry = (aoi_contact_step){.contact = c, .piece = 0, .edge = edge};
        for (int side = 0; side < 2; side++) {
            const double sign = side == 0 ? 1.0 : -1.0;
            const size_t b = contact->body[side];
            start += sign * displacement_of(p, b, contact->port[side], p->x);
            rate += sign * displacement_of(p, b, contact->port[side], p->v);
        }
        for (size_t i = 0; i < AOI_NODES; i++) {
            entry->homogeneous[i] = start;
        }
        for (int side = 0; side < 2; side++) {
            const size_t b = contact->body[side], at = p->system.first[b];
            aoi_response_homogeneous(&p->response[b], &p->body[b], contact->port[side],
                                     side == 0 ? 1.0 : -1.0, 0.0, p->x + at, p->v + at, NULL,
                                     entry->homogeneous, entry->homogeneous_rate);
        }
        entry->start = start;
        entry->start_rate = rate;
        entry->scale = fabs(start);
        for (size_t i = 0; i < AOI_NODES; i++) {
            entry->indentation[i] = entry->homogeneous[i];
            entry->rate[i] = entry->homogeneous_rate[i];
            entry->scale = fmax(entry->scale, fabs(entry->homogeneous[i]));
        }
    }
    return aoi_collocation_solve(&p->system, p->response, h, p->contacts, span, p->entry, work);
}

static int solve(plant *p, double h, size_t span, int with_rates)
{
    return solve_at_edge(p, h, span, with_rates, AOI_EDGE_NONE);
}

/* A plant with room for responses. */
static void prepare(plant *p)
{
    CHECK(lay_out(p) == AOI_OK, "a sound system");
    p->work = malloc(MOST_BODIES * 20000 * sizeof(double));
}

/* The forces of the solved step on the ports of a body. */
static void forces_on(const plant *p, size_t b, double *force)
{
    memset(force, 0, MOST_PORTS * AOI_NODES * sizeof *force);
    for (size_t c = 0; c < p->contacts; c++) {
        for (int side = 0; side < 2; side++) {
            if (p->contact[c].body[side] == b) {
                aoi_vector_add(AOI_NODES, side == 0 ? -1.0 : 1.0, p->entry[c].force,
                               force + p->contact[c].port[side] * AOI_NODES);
            }
        }
    }
}

/* All bodies to the end of the step. */
static void take_step(plant *p)
{
    for (size_t b = 0; b < p->bodies; b++) {
        double force[MOST_PORTS * AOI_NODES];
        forces_on(p, b, force);
        aoi_response_propagate(&p->response[b], &p->body[b], 0.0, force, p->x + p->system.first[b],
                               p->v + p->system.first[b]);
    }
}

/* What the law makes of the indentations is the force, and what the bodies make of the forces is the
 * indentation. */
static void check_solution(const plant *p, double h, const char *what)
{
    for (size_t c = 0; c < p->contacts; c++) {
        const aoi_contact *contact = &p->contact[c];
        const aoi_contact_step *entry = &p->entry[c];
        for (size_t i = 0; i < AOI_NODES; i++) {
            aoi_law_value value;
            aoi_law_force(contact->law, NULL, 0, entry->indentation[i], entry->rate[i], &value);
            CHECK(near(entry->force[i], value.force, 1e-13), "%s: contact %zu, node %zu: the law", what, c, i);
            double indentation = -contact->gap, rate = 0.0;
            for (int side = 0; side < 2; side++) {
                const size_t b = contact->body[side], n = p->part[b].n;
                double x[MOST_MODES], v[MOST_MODES], force[MOST_PORTS * AOI_NODES], u, du;
                memcpy(x, p->x + p->system.first[b], n * sizeof(double));
                memcpy(v, p->v + p->system.first[b], n * sizeof(double));
                forces_on(p, b, force);
                aoi_response_carry(&p->body[b], 0.0, h, force, aoi_radau_node[i], x, v);
                aoi_modes_port(&p->body[b], contact->port[side], x, v, &u, &du);
                for (size_t q = 0; p->body[b].residual && q < p->body[b].ports; q++) {
                    u += p->body[b].residual[contact->port[side] * p->body[b].ports + q] *
                         force[q * AOI_NODES + i];
                }
                indentation += side == 0 ? u : -u;
                rate += side == 0 ? du : -du;
            }
            CHECK(fabs(entry->indentation[i] - indentation) < 1e-13 * entry->scale,
                  "%s: contact %zu, node %zu: %.16g, not %.16g", what, c, i, entry->indentation[i],
                  indentation);
            if (contact->law->depends_on_rate) {
                CHECK(fabs(entry->rate[i] - rate) < 1e-12, "%s: contact %zu, node %zu: rate", what, c, i);
            }
        }
    }
}

/* A row of ringing bodies pressed together, each but the ends in two contacts. */
static void make_row(plant *p, const aoi_law *law, int massless)
{
    uint64_t seed = 31;
    for (size_t b = 0; b < 4; b++) {
        part *of = add_ringing(p, 4, 2, 0.5 + 0.1 * (double)b, 3e5, 1.0 - 0.6 * (double)b, &seed);
        of->massless = massless;
        of->residual[0] = of->residual[3] = 2e-9;
        of->residual[1] = of->residual[2] = -5e-10;
        if (b > 0) {
            join(p, b - 1, 1, b, 0, -1e-5, law);
        }
    }
}

static void contacts_that_share_bodies_are_solved_together(void)
{
    const aoi_law elastic = hertz(1e9), viscous = law_named("hunt_crossley", 3, 1e9, 0.3, 1.5);
    for (int kind = 0; kind < 4; kind++) {
        plant p = {.bodies = 0};
        make_row(&p, kind % 2 ? &viscous : &elastic, 0);
        if (kind >= 2) { /* in another order, so that those that share a body are two apart */
            const aoi_contact kept = p.contact[1];
            p.contact[1] = p.contact[2];
            p.contact[2] = kept;
        }
        prepare(&p);
        CHECK(solve(&p, 2e-5, kind >= 2 ? 2 : 1, kind % 2) == AOI_OK, "solved");
        check_solution(&p, 2e-5, "a row");
        free(p.work);
    }
}

static void massless_contacts_share_their_compliance(void)
{
    const aoi_law law = hertz(1e9);
    plant p = {.bodies = 0};
    make_row(&p, &law, 1);
    prepare(&p);
    CHECK(solve(&p, 2e-5, 1, 0) == AOI_OK, "solved");
    check_solution(&p, 2e-5, "massless");
    free(p.work);
}

/* Over a step of h, then two of h/2, and so on, of a linear contact of two bodies: the exact end is a
 * sine. Radau's end is of order 15. */
static void the_end_of_a_step_is_of_order_fifteen(void)
{
    const aoi_law law = linear(4.0);
    double before = 0.0;
    for (int halved = 0; halved < 3; halved++) {
        const double h = ldexp(3.0, -halved), omega = 2.0; /* of k / m, m = 1 against a wall */
        double x = 0.4, v = 0.7;
        plant p = ball_on_wall(1.0, v, &law);
        p.part[0].x[0] = x;
        prepare(&p);
        CHECK(solve(&p, h, 0, 0) == AOI_OK, "solved");
        take_step(&p);
        const double exact = x * cos(omega * h) + v / omega * sin(omega * h);
        const double error = fabs(p.x[0] - exact);
        /* One step's own error is an order higher. */
        CHECK(halved == 0 || error < before / pow(2.0, 14.0) || error < 1e-14,
              "h %g: error %g, before %g", h, error, before);
        CHECK(halved > 0 || (error > 1e-8 && error < 1e-1), "h %g: error %g is not rounding", h, error);
        before = error;
        free(p.work);
    }
}

/* The estimates are near what they estimate: under Hertz's law what a step hands on, and under a linear
 * one, whose defect Radau's nodes leave without effect, how far the motion within the step is off. */
static void the_estimate_is_the_error(void)
{
    const aoi_law law = hertz(4.0);
    const double lengths[] = {1.0, 1.4, 1.8}; /* of a contact of 3.2 s */
    for (int i = 0; i < 3; i++) {
        double x[ALL_MODES], v[ALL_MODES];
        const double h = lengths[i];
        plant p = ball_on_wall(1.0, 1.0, &law);
        p.part[0].x[0] = 0.1;
        runge_kutta(&p, h, 4000, x, v);
        prepare(&p);
        CHECK(solve(&p, h, 0, 0) == AOI_OK, "solved");
        aoi_collocation_error estimate;
        aoi_collocation_estimate(&p.system, p.response, h, &p.entry[0], &estimate);
        take_step(&p);
        const double error = fabs(p.v[0] - v[0]), off = fabs(p.x[0] - x[0]);
        /* The defect's impulse does not yet know that the law answers to its own error. */
        CHECK(fabs(estimate.impulse) > 0.2 * error && fabs(estimate.impulse) < 5.0 * error,
              "h %g: impulse off by %g, estimated %g", h, error, estimate.impulse);
        CHECK(fabs(estimate.indentation) > 0.2 * off && fabs(estimate.indentation) < 5.0 * (off + h * error),
              "h %g: place off by %g, estimated %g", h, off, estimate.indentation);
        free(p.work);
    }
}

/* The time from touch to a depth, or from there to the release, of a mass on a wall under Hertz's law: the
 * series of int dx / sqrt(v^2 - 0.8 k x^(5/2) / m), v: velocity at touch. */
static double way_in(double k, double m, double v, double depth)
{
    const double e = 0.8 * k * pow(depth, 2.5) / (m * v * v);
    double factor = 1.0, sum = 1.0;
    for (int j = 1; j < 200; j++) {
        factor *= e * (2.0 * j - 1.0) / (2.0 * j);
        sum += factor / (2.5 * j + 1.0);
    }
    return depth / v * sum;
}

/* A step that begins at the touch, or ends at the release, is as right as others: the closed form in
 * place and velocity. Through the nodes alone it would not be, by far. */
static void steps_at_the_edges_of_a_contact_are_right(void)
{
    const double k = 3.0, m = 2.0, v = 1.5;
    const aoi_law law = hertz(k);
    const double reach = pow(1.25 * m * v * v / k, 0.4);
    for (int end = 0; end < 2; end++) {
        const double depth = 0.08 * reach, h = way_in(k, m, v, depth);
        const double inner = sqrt(v * v - 0.8 * k * pow(depth, 2.5) / m);
        double error[2];
        for (int plain = 0; plain < 2; plain++) {
            plant p = ball_on_wall(m, end ? -inner : v, &law);
            p.part[0].x[0] = end ? depth : 0.0;
            prepare(&p);
            const enum aoi_edge edge = end ? AOI_EDGE_END : AOI_EDGE_START;
            CHECK(solve_at_edge(&p, h, 0, 0, plain ? AOI_EDGE_NONE : edge) == AOI_OK, "solved");
            aoi_collocation_error estimate;
            aoi_collocation_estimate(&p.system, p.response, h, &p.entry[0], &estimate);
            take_step(&p);
            error[plain] = fmax(fabs(p.v[0] - (end ? -v : inner)) / v, fabs(p.x[0] - (end ? 0.0 : depth)) / reach);
            CHECK(estimate.tail < 1e-7 * reach, "the motion is followed: %g", estimate.tail);
            CHECK(fabs(estimate.impulse) < 10.0 * fmax(error[plain], 1e-14) * m * v, "impulse %g, error %g",
                  estimate.impulse, error[plain]);
            free(p.work);
        }
        CHECK(error[0] < 1e-12 && error[1] > 1e3 * error[0], "edge %d: off by %g, else by %g", end, error[0], error[1]);
    }
}

static void the_tail_is_the_error_within_the_step(void)
{
    const aoi_law law = linear(4.0);
    const double lengths[] = {1.0, 2.0, 3.0};
    for (int i = 0; i < 3; i++) {
        const double h = lengths[i], x = 0.4, v = 0.7;
        plant p = ball_on_wall(1.0, v, &law);
        p.part[0].x[0] = x;
        prepare(&p);
        CHECK(solve(&p, h, 0, 0) == AOI_OK, "solved");
        aoi_collocation_error estimate;
        aoi_collocation_estimate(&p.system, p.response, h, &p.entry[0], &estimate);
        double worst = 0.0;
        for (int k = 0; k <= 100; k++) {
            double slope;
            const double t = 0.01 * k * h;
            const double ours = aoi_legendre_evaluate(AOI_NODES + 1, p.entry[0].legendre, 0.01 * k, &slope);
            worst = fmax(worst, fabs(ours - x * cos(2.0 * t) - v / 2.0 * sin(2.0 * t)));
        }
        CHECK(estimate.tail > worst && estimate.tail < 100.0 * worst,
              "h %g: within the step off by %g, tail %g", h, worst, estimate.tail);
        free(p.work);
    }
}

/* Impulse and work of the step are momentum and energy of the bodies. */
static void impulse_and_work_are_momentum_and_energy(void)
{
    const aoi_law law = hertz(1e9);
    const double m[] = {0.7, 1.1}, v[] = {2.0, -1.0}, h = 8e-6;
    plant p = {.bodies = 0};
    add_rigid(&p, m[0], v[0]);
    add_rigid(&p, m[1], v[1]);
    join_rigid(&p, 0, 1, -2e-5, &law);
    prepare(&p);
    CHECK(solve(&p, h, 0, 0) == AOI_OK, "solved");
    const double impulse = aoi_collocation_impulse(&p.entry[0], h);
    aoi_legendre_fit(p.entry[0].start, p.entry[0].indentation, p.entry[0].legendre);
    const double work = aoi_collocation_work(p.entry[0].legendre, p.entry[0].force, 1.0);
    take_step(&p);
    double lost = 0.0;
    for (int b = 0; b < 2; b++) {
        CHECK(near(m[b] * (v[b] - p.v[b]), b == 0 ? impulse : -impulse, 1e-11), "momentum of %d", b);
        lost += 0.5 * m[b] * (v[b] * v[b] - p.v[b] * p.v[b]);
    }
    CHECK(near(work, lost, 1e-9), "work %.15g, kinetic energy lost %.15g", work, lost);
    CHECK(near(work, 0.4e9 * (pow(p.entry[0].indentation[AOI_NODES - 1], 2.5) - pow(2e-5, 2.5)), 1e-9),
          "and stored in the law");
    free(p.work);
}

int main(void)
{
    contacts_that_share_bodies_are_solved_together();
    massless_contacts_share_their_compliance();
    the_end_of_a_step_is_of_order_fifteen();
    the_estimate_is_the_error();
    steps_at_the_edges_of_a_contact_are_right();
    the_tail_is_the_error_within_the_step();
    impulse_and_work_are_momentum_and_energy();
    return check_report();
}
