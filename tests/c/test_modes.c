/* A body in its modes under gravity and loads: closed forms, and Runge and Kutta's method. */
#include "plant.h"
#include "motion/energy.h"
#include "motion/free.h"
#include "motion/modes.h"

/* A load of 0 until 1 s, 6 N from 2 s to 3 s, a jump to -3 N there, which it keeps. */
static part *add_loaded(plant *p)
{
    part *ball = add_rigid(p, 2.0, 0.0);
    const double time[] = {1.0, 2.0, 3.0, 3.0}, force[] = {0.0, 6.0, 6.0, -3.0};
    ball->load_count = 4;
    memcpy(ball->load_time, time, sizeof time);
    memcpy(ball->load_force, force, sizeof force);
    return ball;
}

static void loads_run_straight_and_bend_where_they_say(void)
{
    plant p = {.bodies = 0};
    add_loaded(&p);
    lay_out(&p);
    const double at[] = {-5.0, 0.999, 1.0, 1.25, 2.0, 2.7, 3.0, 99.0};
    const double force[] = {0.0, 0.0, 0.0, 1.5, 6.0, 6.0, -3.0, -3.0};
    const double slope[] = {0.0, 0.0, 6.0, 6.0, 0.0, 0.0, 0.0, 0.0};
    const double bend[] = {1.0, 1.0, 2.0, 2.0, 3.0, 3.0, HUGE_VAL, HUGE_VAL};
    for (int i = 0; i < 8; i++) {
        double f, s, load, rise;
        aoi_modes_load(p.body, 0, at[i], &f, &s);
        CHECK(near(f, force[i], 1e-15) && near(s, slope[i], 1e-15), "t %g: %g N, %g N/s", at[i], f, s);
        aoi_modes_drive(p.body, 0, at[i], &load, &rise);
        CHECK(near(load, force[i] / 2.0, 1e-15) && near(rise, slope[i] / 2.0, 1e-15),
              "t %g: f = m a", at[i]);
        CHECK(aoi_modes_next_bend(p.body, at[i]) == bend[i], "t %g: it bends next at %g", at[i], bend[i]);
    }
    p.body[0].load.count = 0;
    double f = 1.0, s = 1.0;
    aoi_modes_load(p.body, 0, 1.5, &f, &s);
    CHECK(f == 0.0 && s == 0.0 && aoi_modes_next_bend(p.body, 0.0) == HUGE_VAL, "no load");
}

static void a_loaded_mass_flies_by_the_integrals_of_its_load(void)
{
    plant p = {.bodies = 0};
    part *ball = add_loaded(&p);
    ball->pulled = 1;
    ball->gravity[0] = -9.81;
    lay_out(&p);
    double x = 1.0, v = 2.0;
    aoi_modes_advance(p.body, 0.0, 5.0, &x, &v);
    /* int F dt = 3 + 6 - 6 = 3 N s; its own integral: 1, then 3 + 3, then 9 t - 1.5 t^2 over 2 s. */
    CHECK(near(v, 2.0 - 9.81 * 5.0 + 3.0 / 2.0, 1e-14), "momentum: %.16g", v);
    CHECK(near(x, 1.0 + 10.0 - 0.5 * 9.81 * 25.0 + (1.0 + 6.0 + 18.0 - 6.0) / 2.0, 1e-14),
          "place: %.16g", x);
    double there = x, speed = v;
    aoi_modes_advance(p.body, 5.0, 5.0, &x, &v);
    CHECK(x == there && v == speed, "no time, no motion");
}

/* Damped modes, two ports with loads of their own, gravity. */
static void free_motion_is_that_of_runge_and_kutta(void)
{
    uint64_t seed = 8;
    plant p = {.bodies = 0};
    part *body = add_ringing(&p, 6, 2, 3.0, 30.0, 1.0, &seed);
    const double time[] = {0.25, 0.5, 1.0}, force[] = {0.0, 1.0, 5.0, -2.0, 1.0, 3.0};
    body->load_count = 3;
    memcpy(body->load_time, time, sizeof time);
    memcpy(body->load_force, force, sizeof force);
    body->damped = body->pulled = 1;
    for (size_t j = 0; j < body->n; j++) {
        body->decay[j] = 12.0 * (double)j; /* from free to overdamped */
        body->gravity[j] = 2.0 - (double)j;
        body->x[j] = 0.01 * (double)j;
    }
    body->omega[1] = 3.0;
    double x[ALL_MODES], v[ALL_MODES];
    runge_kutta(&p, 1.5, 12000, x, v); /* the bends are at steps' ends */
    aoi_modes_advance(p.body, 0.0, 1.5, p.x, p.v);
    for (size_t j = 0; j < body->n; j++) {
        CHECK(fabs(p.x[j] - x[j]) < 1e-11, "mode %zu: %.15g, not %.15g", j, p.x[j], x[j]);
        CHECK(fabs(p.v[j] - v[j]) < 1e-10, "mode %zu: velocity %.15g, not %.15g", j, p.v[j], v[j]);
    }
    double displacement, velocity, sum = 0.0, rate = 0.0;
    aoi_modes_port(p.body, 1, x, v, &displacement, &velocity);
    for (size_t j = 0; j < body->n; j++) {
        sum += body->shape[body->n + j] * x[j];
        rate += body->shape[body->n + j] * v[j];
    }
    CHECK(near(displacement, sum, 1e-14) && near(velocity, rate, 1e-14), "the second port");
}

/* An indentation knows of residual compliance under loads. */
static void a_load_bends_what_no_mode_has(void)
{
    plant p = {.bodies = 0};
    part *ball = add_loaded(&p);
    ball->massless = 1;
    ball->residual[0] = 0.125;
    add_wall(&p);
    lay_out(&p);
    aoi_free_pair pair = {{&p.body[0], &p.body[1]}, {0, 0}, 0.25, {p.x, p.x + 1}, {p.v, p.v + 1}, 1.5, NULL};
    double indentation, rate, acceleration;
    p.x[0] = 1.0;
    aoi_free_pair_indentation(&pair, &indentation, &rate, &acceleration);
    CHECK(near(indentation, 1.0 - 0.25 + 0.125 * 3.0, 1e-15), "x - gap + R f: %g", indentation);
    CHECK(near(rate, 0.125 * 6.0, 1e-15), "R f': %g", rate);
    CHECK(near(acceleration, 3.0 / 2.0, 1e-15), "f / m: %g", acceleration);
    const double decay = 0.25;
    p.body[0].decay = &decay;
    p.v[0] = 3.0;
    aoi_free_pair_indentation(&pair, &indentation, &rate, &acceleration);
    CHECK(near(acceleration, 3.0 / 2.0 - 2.0 * 0.25 * 3.0, 1e-15), "less 2 sigma v: %g", acceleration);
}

static void energy_is_kinetic_elastic_and_residual(void)
{
    uint64_t seed = 4;
    plant p = {.bodies = 0};
    part *body = add_ringing(&p, 3, 2, 2.0, 10.0, 0.0, &seed);
    const double residual[] = {2.0, 0.5, 0.5, 1.0}, force[] = {3.0, -1.0};
    body->massless = 1;
    memcpy(body->residual, residual, sizeof residual);
    lay_out(&p);
    const double x[] = {7.0, 1.0, 2.0}, v[] = {1.0, 2.0, 3.0};
    double kinetic, elastic;
    aoi_modes_energy(p.body, x, v, NULL, &kinetic, &elastic);
    CHECK(near(kinetic, 7.0, 1e-15), "v^2 / 2");
    CHECK(near(elastic, 0.5 * (25.0 + 400.0), 1e-15), "(omega x)^2 / 2");
    aoi_modes_energy(p.body, x, v, force, &kinetic, &elastic);
    CHECK(near(elastic, 0.5 * (25.0 + 400.0) + 0.5 * (18.0 - 3.0 + 1.0), 1e-15), "f R f / 2");
}

/* More modes than are taken at once, with inertias of their own or without. */
static void energies_are_sums_over_the_modes(void)
{
    enum { MANY = 7 };
    double omega[MANY], inertia[MANY], x[MANY], v[MANY];
    uint64_t seed = 9;
    for (size_t j = 0; j < MANY; j++) {
        omega[j] = decades(&seed, 0.0, 2.0);
        inertia[j] = decades(&seed, -1.0, 1.0);
        x[j] = uniform(&seed) - 0.5;
        v[j] = 10.0 * (uniform(&seed) - 0.5);
    }
    for (int own = 0; own < 2; own++) {
        const aoi_modes body = {.n = MANY, .omega = omega, .inertia = own ? inertia : NULL};
        double kinetic, elastic, moving = 0.0, strained = 0.0;
        aoi_modes_energy(&body, x, v, NULL, &kinetic, &elastic);
        for (size_t j = 0; j < MANY; j++) {
            moving += 0.5 * (own ? inertia[j] : 1.0) * v[j] * v[j];
            strained += 0.5 * (own ? inertia[j] : 1.0) * pow(omega[j] * x[j], 2.0);
        }
        CHECK(near(kinetic, moving, 1e-14) && near(elastic, strained, 1e-14), "%g J and %g J, not %g J and %g J",
              kinetic, elastic, moving, strained);
    }
}

int main(void)
{
    loads_run_straight_and_bend_where_they_say();
    a_loaded_mass_flies_by_the_integrals_of_its_load();
    free_motion_is_that_of_runge_and_kutta();
    a_load_bends_what_no_mode_has();
    energy_is_kinetic_elastic_and_residual();
    energies_are_sums_over_the_modes();
    return check_report();
}
