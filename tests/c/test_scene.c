/* Two bodies and their contact, known in closed form: half sines of linear springs, a mass behind a spring;
 * second order in dt; momentum; and that nothing, from the lightest touch to an absurd step, makes a step fail. */
#include "body.h"
#include "model/coupled.h"

enum { STEPS = 40000, OSCILLATORS = 28 };

static const aoi_star WALL = {0, (double)INFINITY, 0.0, NULL, NULL};

typedef struct run {
    world world;
    aoi_law law;
    aoi_rule rule;
    double record[ROWS][STEPS + 1];
} run;

static run one, two;

/* Everything but the law: velocities of projectile and target, all rows wanted. */
static void run_make(run *r, const aoi_star *projectile, const aoi_star *target, aoi_rule rule,
                     double velocity, double target_velocity)
{
    drop();
    memset(&r->world, 0, sizeof r->world);
    (void)add_star(&r->world, projectile, velocity, 0.0, NULL, NULL);
    (void)add_star(&r->world, target, target_velocity, 0.0, NULL, NULL);
    add_contact(&r->world, 0, 1, 0, &r->law, 0.0);
    r->rule = rule;
}

static void run_law(run *r, const char *name, double k)
{
    CHECK(aoi_law_create(&r->law, name, 1, &k) == AOI_OK, "%s(%g)", name, k);
}

static int run_start(run *r) { return world_start(&r->world, r->rule, STEPS + 1, r->record[0]); }

static int run_all(run *r, size_t steps)
{
    size_t done = 0;
    int status = run_start(r);
    if (status == AOI_OK) {
        status = aoi_newmark_run(r->world.run, steps, &done);
    }
    CHECK(status != AOI_OK || done == steps, "all steps done");
    return status;
}

static const aoi_rule AVERAGE = {1e-6, 0.25, 0.5};

static aoi_rule average(double dt) { return (aoi_rule){dt, 0.25, 0.5}; }

static double *row_of(run *r, int body, int which)
{
    return r->record[BODIES + OF_BODY * body + which];
}

/* A spring k between undeformed bodies: F = K V/w sin(w t) with K the stiffness of all springs in
 * series. Newmark's amplitude is exact and its period longer by (w dt)^2/12, so that at the end of
 * the half sine the force is off by pi times that. */
static double half_sine_error(const aoi_star *projectile, const aoi_star *target, double w, double series, int steps)
{
    const double dt = PI / w / steps, velocity = 2.0, peak = series * velocity / w;
    double worst = 0.0;
    run_make(&one, projectile, target, average(dt), velocity, 0.0);
    CHECK(run_all(&one, (size_t)steps) == AOI_OK, "half sine in %d steps", steps);
    for (int j = 0; j < steps - 2; j++) {
        worst = fmax(worst, fabs(one.record[FORCE][j] / peak - sin(w * dt * j)));
    }
    return worst;
}

static void half_sines_are_met_to_second_order(void)
{
    const double m = 0.02, behind_m = 1.3, behind_k = 3e7, k = 1e7;
    const double series = k * behind_k / (k + behind_k);
    const aoi_star mass = {0, m, 0.0, NULL, NULL}, other = {0, 3.0 * m, 0.0, NULL, NULL};
    const aoi_star sprung = {1, 0.0, 0.0, &behind_m, &behind_k};
    const struct {
        const aoi_star *projectile, *target;
        double w, series;
        const char *what;
    } cases[] = {
        {&mass, &WALL, sqrt(k / m), k, "a mass against a wall"},
        {&mass, &other, sqrt(k / (0.75 * m)), k, "two masses"},
        {&sprung, &WALL, sqrt(series / behind_m), series,
         "a mass behind a spring, no mass at the contact"},
    };
    run_law(&one, "linear", k);
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        double error[3];
        for (int level = 0; level < 3; level++) {
            error[level] = half_sine_error(cases[i].projectile, cases[i].target, cases[i].w,
                                           cases[i].series, 100 << level);
        }
        CHECK(near(error[0], PI * PI * PI / 12e4, 0.05), "%s: the force is off by %g", cases[i].what, error[0]);
        CHECK(fabs(error[0] / error[1] - 4.0) < 0.2 && fabs(error[1] / error[2] - 4.0) < 0.1,
              "%s: halving dt quarters the error: %g, %g, %g", cases[i].what, error[0], error[1],
              error[2]);
    }
}

static double largest(const double *row, size_t count)
{
    double most = 0.0;
    for (size_t j = 0; j < count; j++) {
        most = fmax(most, row[j]);
    }
    return most;
}

/* Force on one is force on the other, and what a force does to a centre of mass it does by its mean
 * over the step: momentum and impulse agree to rounding, whatever else the step gets wrong. */
static void momentum_is_kept_and_impulse_is_its_change(void)
{
    static random_star a, b;
    random_star_make(&a, 3, &(uint64_t){5}, -1.0, 1e-4, 0.0);
    random_star_make(&b, OSCILLATORS, &(uint64_t){6}, -1.0, 1e-3, 0.0);
    const double mass_a = aoi_star_static_mass(&a.star), mass_b = aoi_star_static_mass(&b.star);
    for (double dt = 1e-8; dt < 2e-5; dt *= 10.0) {
        double worst = 0.0, impulse = 0.0, off = 0.0;
        run_make(&one, &a.star, &b.star, average(dt), 1.0, 0.0);
        run_law(&one, "hertz", 1e10);
        CHECK(run_all(&one, STEPS) == AOI_OK, "dt %g", dt);
        for (int j = 0; j <= STEPS; j++) {
            const double p_a = mass_a * row_of(&one, 0, AOI_BODY_CENTRE_VELOCITY)[j], p_b = mass_b * row_of(&one, 1, AOI_BODY_CENTRE_VELOCITY)[j];
            worst = fmax(worst, fabs((p_a + p_b) / mass_a - 1.0));
            impulse += j == 0
                    ? 0.0
                    : 0.5 * dt * (one.record[FORCE][j] + one.record[FORCE][j - 1]);
            off = fmax(off, fabs(p_b - impulse) / mass_a);
        }
        CHECK(largest(one.record[FORCE], STEPS) > 0.0 && impulse > 0.1 * mass_a, "they hit");
        CHECK(worst < 1e-12, "dt %g: momentum changes by %g", dt, worst);
        CHECK(off < 1e-12, "dt %g: impulse and momentum differ by %g", dt, off);
    }
}

static void record_is_what_was_asked_for(void)
{
    static random_star a, b;
    const size_t steps = 3000;
    random_star_make(&a, 5, &(uint64_t){9}, -1.0, 1e-3, 0.0);
    random_star_make(&b, 8, &(uint64_t){10}, -1.0, 1e-3, 1e6);
    run_law(&one, "hertz", 1e10);
    run_law(&two, "hertz", 1e10);
    run_make(&one, &a.star, &b.star, AVERAGE, 1.0, 0.0);
    CHECK(run_all(&one, steps) == AOI_OK, "all rows");
    run_make(&two, &a.star, &b.star, AVERAGE, 1.0, 0.0);
    two.world.lean = 1;
    for (int i = 0; i < ROWS; i++) {
        for (size_t j = 0; j <= steps + 1; j++) {
            two.record[i][j] = 77.0;
        }
    }
    CHECK(run_all(&two, steps) == AOI_OK, "without energies");
    for (int i = 0; i < ROWS; i++) {
        const double *wanted = one.record[i], *got = two.record[i];
        const int of_body = i < BODIES ? 0 : (i - BODIES) % OF_BODY;
        const int energy = i == STORED || i == LOST || (of_body >= AOI_BODY_KINETIC && of_body < AOI_BODY_ROWS);
        CHECK(energy || memcmp(wanted, got, (steps + 1) * sizeof *got) == 0, "row %d", i);
        CHECK(!energy || (got[0] == 77.0 && got[steps] == 77.0), "row %d is left alone", i);
        CHECK(got[steps + 1] == 77.0, "nothing is written to row %d beyond the last step", i);
    }
    run_make(&two, &a.star, &b.star, AVERAGE, 1.0, 0.0);
    size_t done = 0;
    CHECK(run_start(&two) == AOI_OK, "in pieces");
    for (size_t piece = 1; done < steps; piece = 3 * piece + 1) {
        const size_t last = done + piece < steps ? done + piece : steps;
        CHECK(aoi_newmark_run(two.world.run, last, &done) == AOI_OK && done == last, "piece");
    }
    for (int i = 0; i < ROWS; i++) {
        CHECK(memcmp(one.record[i], two.record[i], (steps + 1) * sizeof(double)) == 0, "row %d in pieces", i);
    }
}

/* From a touch of 1 um/s to 1 km/s, from steps that resolve everything to steps of a second, from
 * specks to trains: no step fails, no force pulls. */
static void no_step_fails(void)
{
    static random_star target;
    uint64_t seed = 12;
    int failures = 0, pulls = 0, endless = 0;
    for (int trial = 0; trial < 1500; trial++) {
        const aoi_star mass = {0, decades(&seed, -6.0, 6.0), 0.0, NULL, NULL};
        const aoi_rule rule = {decades(&seed, -12.0, 0.0), trial % 3 ? 0.25 : 0.3025,
                                  trial % 3 ? 0.5 : 0.6};
        const double m0 = trial % 5 ? decades(&seed, -9.0, 2.0) : 0.0;
        random_star_make(&target, 1 + (size_t)trial % 28, &(uint64_t){seed}, -1.0, m0,
                         trial % 2 ? decades(&seed, 2.0, 9.0) : 0.0);
        run_make(&one, &mass, trial % 7 ? &target.star : &WALL, rule, decades(&seed, -6.0, 3.0), 0.0);
        run_law(&one, trial % 4 ? "hertz" : "linear", decades(&seed, 4.0, 15.0));
        one.world.contact[0].gap = trial % 11 ? 0.0 : decades(&seed, -9.0, 0.0);
        failures += run_all(&one, 300) != AOI_OK;
        for (int j = 0; j <= 300; j++) {
            pulls += one.record[FORCE][j] < 0.0;
            for (int i = 0; i < ROWS; i++) {
                endless += !isfinite(one.record[i][j]);
            }
        }
    }
    CHECK(failures == 0, "%d of 1500 runs failed", failures);
    CHECK(pulls == 0, "%d forces pull", pulls);
    CHECK(endless == 0, "%d numbers are not finite", endless);
}

/* It leaves the restitution e with c V (1 + e) = ln((1 + c V)/(1 - c e V)), whatever k and the
 * masses (integrate v dv/(1 + c v) = -k/m d^(3/2) dd from touch to parting); so the rate that the
 * law is given is that of the two bodies against each other. */
static void damped_contact_has_its_restitution(void)
{
    const aoi_star mass = {0, 0.02, 0.0, NULL, NULL}, other = {0, 0.05, 0.0, NULL, NULL};
    const double c = 0.3, velocity = 2.0, moving = -5.0;
    run_make(&one, &mass, &other, average(5e-9), moving + velocity, moving);
    CHECK(aoi_law_create(&one.law, "hunt_crossley", 3, (double[]){1e10, c, 1.5}) == AOI_OK, "a damped law");
    CHECK(run_all(&one, STEPS) == AOI_OK, "damped");
    CHECK(one.record[FORCE][STEPS] == 0.0, "they have parted");
    const double e = (row_of(&one, 1, VELOCITY)[STEPS] - row_of(&one, 0, VELOCITY)[STEPS]) / velocity;
    CHECK(e > 0.3 && e < 0.9, "restitution %g", e);
    double energy[2] = {0.0, 0.0};
    for (int b = 0; b < 2; b++) {
        energy[0] += row_of(&one, b, AOI_BODY_KINETIC)[0];
        energy[1] += row_of(&one, b, AOI_BODY_KINETIC)[STEPS];
    }
    CHECK(near(one.record[LOST][STEPS], energy[0] - energy[1], 1e-11),
          "what is lost is what is missing: %.15g", one.record[LOST][STEPS]);
    const double left = c * velocity * (1.0 + e),
                 right = log((1.0 + c * velocity) / (1.0 - c * e * velocity));
    CHECK(near(left, right, 1e-6), "restitution %g: %.9g and %.9g", e, left, right);
}

/* A mass on two springs against two walls, squeezed between them from the start: it stays; pushed, it swings with w^2 = 2 k/m,
 * of which the rule makes the phase 2 atan(w dt/2) a step. */
static void preload_is_held(void)
{
    const aoi_star ball = {0, 0.1, 0.0, NULL, NULL};
    const double k = 1e6, squeeze = 1e-5, dt = 1e-4, w = sqrt(2.0 * k / 0.1), phase = 2.0 * atan(0.5 * w * dt);
    world *held = &one.world;
    run_law(&one, "linear", k);
    for (int pushed = 0; pushed < 2; pushed++) {
        const double push = 1e-3 * pushed;
        drop();
        memset(held, 0, sizeof *held);
        (void)add_star(held, &WALL, 0.0, 0.0, NULL, NULL);
        (void)add_star(held, &ball, push, 0.0, NULL, NULL);
        (void)add_star(held, &WALL, 0.0, 0.0, NULL, NULL);
        add_contact(held, 0, 1, 0, &one.law, -squeeze);
        add_contact(held, 1, 2, 0, &one.law, -squeeze);
        CHECK(world_start(held, average(dt), 1001, NULL) == AOI_OK, "squeezed");
        for (int j = 1; j <= 1000; j++) {
            CHECK(step_on(held) == AOI_OK, "step %d", j);
            const double at = observe(held, 1).displacement;
            CHECK(fabs(at - push / w * sin(phase * j)) <= 1e-9 * push / w, "at %g m", at);
        }
    }
}

/* Loads: a mass under a force that rises, holds and stops, by its integral; the work is what it has in motion. */
static void loads_do_their_work(void)
{
    const aoi_star ball = {0, 0.5, 0.0, NULL, NULL};
    const double dt = 1.0 / 4096.0;
    const double times[] = {0.0625, 0.125, 0.25, 0.25, 0.375}, forces[] = {3.0, 6.0, 6.0, 2.0, 2.5};
    run_make(&one, &ball, &WALL, average(dt), 0.0, 0.0);
    run_law(&one, "linear", 1e6);
    one.world.contact[0].gap = 1e3;
    one.world.body[0].load = (aoi_load){5, times, forces};
    CHECK(run_all(&one, 2048) == AOI_OK, "loaded");
    /* The rule takes the mean over each step: exact but for the step in which the load stops. */
    const double impulse = 1.0 * 0.0625 + 2.5 * 0.0625 + 4.0 * 0.125 - 0.5 * dt * 4.0 +
                           0.25 * 0.125 + 0.5 * 0.125 + 2.0 * 0.5;
    CHECK(near(row_of(&one, 0, VELOCITY)[2048], impulse / 0.5, 1e-13), "velocity %.15g",
          row_of(&one, 0, VELOCITY)[2048]);
    for (size_t j = 0; j <= 2048; j++) {
        CHECK(fabs(row_of(&one, 0, AOI_BODY_KINETIC)[j] - row_of(&one, 0, AOI_BODY_WORK)[j]) <
                  1e-12 * (1.0 + row_of(&one, 0, AOI_BODY_WORK)[j]),
              "what went in is in motion, step %zu", j);
    }
    CHECK(near(row_of(&one, 0, VELOCITY)[1], dt * 3.0 / 0.5, 1e-14), "it starts with the force there is");
}

/* A ball under gravity on a spring: it falls, is caught, and hangs about its place of rest. */
static void gravity_is_a_constant_force(void)
{
    const aoi_star ball = {0, 0.2, 0.0, NULL, NULL};
    const double g = 9.81, gap = 1e-3, dt = 1e-6, force = 0.2 * g, above = 3e-4;
    run_make(&one, &ball, &WALL, average(dt), 0.0, 0.0);
    run_law(&one, "linear", 1e5);
    one.world.contact[0].gap = gap - above;
    one.world.x[0][0] = -above;
    one.world.body[0].gravity = &g;
    const size_t fall = (size_t)(sqrt(2.0 * gap / g) / dt), steps = fall + 8000;
    CHECK(run_all(&one, steps) == AOI_OK, "runs");
    const double *place = row_of(&one, 0, DISPLACEMENT), *work = row_of(&one, 0, AOI_BODY_WORK);
    for (size_t j = 1; j <= steps; j++) {
        const double t = dt * (double)j, x = place[j] + above;
        const double fallen = 0.5 * g * t * t, rounding = 1e-16; /* of places some 1e-4 m off */
        CHECK(t > dt * (double)fall || fabs(x - fallen) < 1e-9 * fallen + rounding, "free fall at %g s", t);
        const double energy = one.record[STORED][j] + one.record[LOST][j] + row_of(&one, 0, AOI_BODY_KINETIC)[j];
        CHECK(fabs(work[j] - force * x) < force * (1e-12 * x + rounding) && fabs(energy - work[j]) < 1e-4 * force * gap,
              "the ledger at %g s", t);
    }
}

static void failures_say_where(void)
{
    const aoi_star mass = {0, 0.1, 0.0, NULL, NULL};
    size_t done = 99;
    run_make(&one, &mass, &mass, AVERAGE, 1.0, 0.0);
    run_law(&one, "hertz", 1e10);
    one.law.limit = 4.5e-6;
    CHECK(run_start(&one) == AOI_OK, "it starts");
    CHECK(aoi_newmark_run(one.world.run, 10, &done) == AOI_ERROR_PATCH && done == 4 &&
              aoi_newmark_progress(one.world.run).failed == 0,
          "four steps before the contact is too deep, not %zu", done);
    const struct {
        const char *what;
        double gap, k, velocity;
        int status;
    } bad[] = {{"no gap", (double)NAN, 1e10, 1.0, AOI_ERROR_ARGUMENT},
               {"an infinite gap", (double)INFINITY, 1e10, 1.0, AOI_ERROR_ARGUMENT},
               {"an infinite overlap", -(double)INFINITY, 1e10, 1.0, AOI_ERROR_ARGUMENT},
               {"a velocity that is no number", 0.0, 1e10, (double)NAN, AOI_ERROR_NOT_FINITE},
               {"a force beyond the range of numbers", -1e10, 1e300, 1.0, AOI_ERROR_NOT_FINITE}};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        run_make(&one, &mass, &mass, AVERAGE, bad[i].velocity, 0.0);
        run_law(&one, "hertz", bad[i].k);
        one.world.contact[0].gap = bad[i].gap;
        one.record[0][0] = 77.0;
        CHECK(run_start(&one) == bad[i].status && one.record[0][0] == 77.0, "%s", bad[i].what);
    }
    run_make(&one, &WALL, &WALL, AVERAGE, 0.0, 0.0);
    CHECK(run_start(&one) == AOI_ERROR_NOT_POSITIVE, "wall against wall");
}

/* Sizes whose products are beyond size_t are more than malloc gives, not what is left of them. */
static void no_size_wraps(void)
{
    const size_t many = (size_t)1 << (4 * sizeof(size_t)), most = SIZE_MAX / 2;
    const aoi_star mass = {0, 0.1, 0.0, NULL, NULL};
    run_make(&one, &mass, &mass, AVERAGE, 1.0, 0.0);
    run_law(&one, "hertz", 1e10);
    CHECK(run_start(&one) == AOI_OK && aoi_newmark_size(&one.world.system) < 20000, "two balls are small");
    one.world.body[0].ports = many;
    CHECK(aoi_newmark_size(&one.world.system) == most, "as many ports");
    one.world.body[0].ports = 1;
    const size_t forces = many * (many / 16), first[2] = {forces, forces + 1}; /* of contacts with friction */
    one.world.system.contact_count = 0;
    one.world.system.first_force = first;
    CHECK(aoi_newmark_size(&one.world.system) == most, "and contacts");
    CHECK(aoi_coupled_size(many, many) == most, "of their equations");
}

int main(void)
{
    half_sines_are_met_to_second_order();
    momentum_is_kept_and_impulse_is_its_change();
    record_is_what_was_asked_for();
    no_step_fails();
    damped_contact_has_its_restitution();
    preload_is_held();
    loads_do_their_work();
    gravity_is_a_constant_force();
    failures_say_where();
    no_size_wraps();
    drop();
    return check_report();
}
