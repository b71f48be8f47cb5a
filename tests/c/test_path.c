/* What damping takes and what rising loads do along a motion, however often a mode turns meanwhile: against
 * quadrature along the exact motion, and closed forms. */
#include "numeric.h"
#include "plant.h"
#include "law/law.h"
#include "motion/energy.h"
#include "motion/modes.h"
#include "motion/path.h"
#include "motion/polynomial.h"
#include "motion/radau.h"
#include "motion/response.h"
#include "motion/nodes.h"

/* One mode under a force on its port. */
static part *add_mode(plant *p, double omega, double decay)
{
    part *made = add_rigid(p, 0.7, 0.0);
    made->omega[0] = omega;
    made->decay[0] = decay;
    made->damped = 1;
    return made;
}

/* The integral of v^2 from the start of a step of length h to a place of it, by Gauss's rule in panels of less than a
 * period. */
static double squared_speed(const aoi_modes *body, double h, double place, const double *force, double x, double v)
{
    const double turns = place * h * (body->omega[0] + body->decay[0]);
    const size_t panels = 40 + (size_t)(0.8 * turns);
    double sum = 0.0;
    for (size_t i = 0; i < panels; i++) {
        for (int g = 0; g < GAUSS; g++) {
            const double at = place * ((double)i + GAUSS_AT[g]) / (double)panels;
            double there = x, speed = v;
            aoi_response_carry(body, 0.0, h, force, at, &there, &speed);
            sum += GAUSS_WEIGHT[g] * speed * speed;
        }
    }
    return place * h / (double)panels * sum;
}

/* Slow modes and fast ones, which swing freely beside what the force does to them; h is 1 ms. */
static void damping_takes_its_power_along_the_motion(void)
{
    const double h = 1e-3, turns[] = {0.0, 0.5, 1.49, 1.51, 3.0, 30.0, 1000.0, 1e5}, places[] = {1.0, 0.37};
    const double damped[] = {1e-4, 0.3, 1.4, 4.0}, within[] = {1e-10, 1e-10, 1e-10, 2e-8};
    uint64_t seed = 29;
    for (size_t i = 0; i < 32; i++) {
        const double omega = turns[i % 8] / h, decay = damped[i / 8] / h;
        plant p = {.bodies = 0};
        part *of = add_mode(&p, omega, decay);
        double force[AOI_NODES];
        const double phase = 2.0 * PI * uniform(&seed);
        for (size_t k = 0; k < AOI_NODES; k++) { /* as smooth as a step's */
            force[k] = 1.0 + cos(phase + aoi_radau_node[k]);
        }
        /* As large as the force makes it. */
        of->x[0] = (2.0 * uniform(&seed) - 1.0) / (of->inertia[0] * (omega * omega + 1.0 / (h * h)));
        of->v[0] = (2.0 * uniform(&seed) - 1.0) / (of->inertia[0] * (omega + 1.0 / h));
        lay_out(&p);
        const int most = turns[i % 8] < 1e4 ? 2 : i / 8 == 1; /* quadrature takes long */
        for (int part_of = 0; part_of < most; part_of++) {
            const double place = places[part_of], x0 = p.x[0], v0 = p.v[0];
            const double wanted = 2.0 * decay * of->inertia[0] * squared_speed(p.body, h, place, force, x0, v0);
            double x1 = x0, v1 = v0, work, lost;
            aoi_response_carry(p.body, 0.0, h, force, place, &x1, &v1);
            aoi_modes_step_work(p.body, 0.0, h, place, force, &x0, &v0, &x1, &work, &lost);
            CHECK(near(lost, wanted, within[i / 8]), "omega h %g, decay h %g, to %g: %.12g J lost, not %.12g (%g)",
                  turns[i % 8], damped[i / 8], place, lost, wanted, lost / wanted - 1.0);
            CHECK(work == 0.0, "neither gravity nor a load");
        }
    }
}

/* A damped oscillator under a load r t from rest: x = x_0 + (r / k) t less a free swing. The work is F x less the
 * integral of r x, which the equation of motion gives. */
static void a_rising_load_works_over_many_periods(void)
{
    const double omega = 2e4, rate = 3.0;
    for (int i = 0; i < 3; i++) {
        const double decay = 0.5 * i, periods = i == 0 ? 50.25 : 1e5 + 0.25, end = periods * 2.0 * PI / omega;
        plant p = {.bodies = 0};
        part *of = add_mode(&p, omega, decay);
        const double mass = of->inertia[0], stiffness = mass * omega * omega;
        of->load_count = 2;
        of->load_time[1] = 2.0 * end;
        of->load_force[1] = rate * 2.0 * end;
        lay_out(&p);
        const double lag = 2.0 * decay / (omega * omega), swing = sqrt(omega * omega - decay * decay);
        /* a cos + b sin, from x = v = 0 */
        const double a = rate / stiffness * lag, b = (decay * a - rate / stiffness) / swing;
        const double left = exp(-decay * end);
        const double cosine = cos(swing * end), sine = sin(swing * end);
        const double x = rate / stiffness * (end - lag) + left * (a * cosine + b * sine);
        const double v = rate / stiffness + left * ((b * swing - decay * a) * cosine - (a * swing + decay * b) * sine);
        const double moment = (0.5 * rate * end * end - mass * v - 2.0 * decay * mass * x) / stiffness;
        const double wanted = rate * end * x - rate * moment;
        double x1 = 0.0, v1 = 0.0, scratch[2], work, lost;
        const double x0 = 0.0, v0 = 0.0;
        aoi_modes_advance(p.body, 0.0, end, &x1, &v1);
        CHECK(fabs(x1 - x) < 1e-9 * x && fabs(v1 - v) < 1e-7 * rate / stiffness, "the motion: %.15g, %.15g", x1, x);
        aoi_modes_free_work(p.body, 0.0, end, &x0, &v0, &x1, &v1, scratch, &work, &lost);
        CHECK(near(work, wanted, 1e-9), "decay %g: %.15g J, not %.15g", decay, work, wanted);
        const double energy = 0.5 * mass * v * v + 0.5 * stiffness * x * x;
        CHECK(fabs(lost - (wanted - energy)) < 1e-10 * wanted && lost >= -1e-14 * wanted, "decay %g: %g J lost",
              decay, lost);
        release(&p);
    }
}

/* A body that rings, damped, while it is struck: what it has lost grows, and with it the balance closes. */
static void losses_grow_and_the_balance_closes(void)
{
    const double mass[] = {10.0, 1.0}, k = 1e9, contact = 3.2145 * pow(100.0 / 121.0 / (k * k), 0.2);
    for (double turns = 3.0; turns < 5e3; turns *= 10.0) {
        for (int rings = 0; rings < 2; rings++) {
            const double omega = 2.0 * PI * turns / contact, end = 1.3 * contact, rtol = 1e-4;
            const aoi_law law = hertz(k);
            plant p = {.bodies = 0};
            double record[64], first = 0.0, lost = 0.0;
            add_rigid(&p, 1.0, 1.0);
            part *body = add_rigid(&p, mass[0], 0.0);
            body->n = 2;
            body->damped = 1;
            body->omega[1] = omega;
            body->decay[1] = 0.01 * omega;
            body->shape[1] = 1.0;
            body->push[1] = 1.0 / mass[1];
            body->inertia[1] = mass[1];
            body->x[1] = rings ? 3e-5 / turns : 0.0;
            join_rigid(&p, 0, 1, 0.0, &law);
            must_go(&p, rtol, end);
            CHECK(open_sampler(&p) == AOI_OK, "sampled");
            for (int i = 0; i <= 300; i++) {
                aoi_sampler_column(p.sampler, end * i / 300.0, 1, record, 1);
                const double *of = record + AOI_CONTACT_ROWS + AOI_BODY_ROWS + AOI_PORT_ROWS;
                const double *ball = record + AOI_CONTACT_ROWS;
                const double all = record[2] + record[3] + ball[AOI_BODY_KINETIC] + of[AOI_BODY_KINETIC] +
                                   of[AOI_BODY_ELASTIC] + of[AOI_BODY_DISSIPATED];
                first = i == 0 ? all : first;
                CHECK(near(all, first, rtol), "%g periods, rings %d: balance off by %g at %d", turns, rings,
                      all / first - 1.0, i);
                CHECK(of[AOI_BODY_DISSIPATED] >= lost - 1e-9 * first, "%g periods, rings %d: %g J come back", turns,
                      rings, lost - of[AOI_BODY_DISSIPATED]);
                lost = of[AOI_BODY_DISSIPATED];
            }
            CHECK(lost > 0.0, "something is lost");
            release(&p);
        }
    }
}

static void a_path_obeys_the_equation_of_motion(void)
{
    uint64_t seed = 31;
    for (int i = 0; i < 200; i++) {
        const double h = 1e-3, omega = (8.0 + 100.0 * uniform(&seed)) / h, decay = uniform(&seed) * omega;
        double force[AOI_NODES], series[AOI_NODES], path[AOI_NODES], rate[AOI_NODES], slope, bend;
        for (size_t k = 0; k < AOI_NODES; k++) {
            force[k] = cos(0.01 * i + aoi_radau_node[k]);
        }
        aoi_nodes_to_legendre(force, series);
        aoi_path_follow(omega, decay, h, series, path, rate);
        const double at = uniform(&seed), x = aoi_legendre_evaluate(AOI_NODES, path, at, &slope);
        const double v = aoi_legendre_evaluate(AOI_NODES, rate, at, &bend);
        CHECK(near(v, slope / h, 1e-12) || fabs(v) < 1e-9 / omega, "omega h %g: %g, not %g", omega * h, v, slope / h);
        const double f = bend / h + 2.0 * decay * v + omega * omega * x;
        CHECK(fabs(f - through_nodes(force, at)) < 1e-13, "omega h %g: %g", omega * h, f - through_nodes(force, at));
    }
}

int main(void)
{
    damping_takes_its_power_along_the_motion();
    a_rising_load_works_over_many_periods();
    losses_grow_and_the_balance_closes();
    a_path_obeys_the_equation_of_motion();
    return check_report();
}
