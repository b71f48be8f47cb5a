/* Two bodies and their contact, known in closed form: half sines of linear springs, Hertz's rigid
 * pair, a mass behind a spring; second order in dt; momentum, symmetry, the frame of reference; and
 * that nothing, from the lightest touch to an absurd step, makes a step fail. */
#include "body.h"
#include "viscous.h"
#include "model/coupled.h"
#include "newmark/body.h"
#include "newmark/scene.h"

#include <string.h>

enum { STEPS = 40000, OSCILLATORS = 28 };

static const aoi_star WALL = {0, (double)INFINITY, 0.0, NULL, NULL};

typedef struct star_body {
    aoi_body body;
    double u0[OSCILLATORS + 1], v0[OSCILLATORS + 1], centre[OSCILLATORS + 1];
    double work[7 * OSCILLATORS + 5];
} star_body;

typedef struct run {
    star_body projectile, target;
    aoi_law law;
    pair pair;
    double record[ROWS][STEPS + 1];
} run;

static run one, two;

static void star_body_start(star_body *p, const aoi_star *star, aoi_rule rule, double velocity)
{
    const double total = aoi_star_static_mass(star);
    for (size_t i = 0; i <= star->n; i++) {
        p->u0[i] = 0.0;
        p->v0[i] = velocity;
        p->centre[i] = isinf(total) ? 1.0 : (i == 0 ? star->m0 : star->m[i - 1]) / total;
    }
    const aoi_body_start start = {p->u0, p->v0, p->centre, NULL, NULL};
    const int status = aoi_body_start_star(&p->body, star, NULL, &rule, &start, p->work);
    CHECK(status == AOI_OK, "a star of %zu starts, status %d", star->n, status);
}

/* Everything but the law: velocities of projectile and target, all rows wanted. */
static void run_make(run *r, const aoi_star *projectile, const aoi_star *target, aoi_rule rule,
                     double velocity, double target_velocity)
{
    star_body_start(&r->projectile, projectile, rule, velocity);
    star_body_start(&r->target, target, rule, target_velocity);
    pair_make(&r->pair, &r->projectile.body, &r->target.body, &r->law, 0.0);
    r->pair.scene.dt = rule.dt;
}

static void run_law(run *r, const char *name, double k)
{
    CHECK(aoi_law_create(&r->law, name, 1, &k) == AOI_OK, "%s(%g)", name, k);
}

static int run_start(run *r) { return aoi_scene_start(&r->pair.scene, r->record[0], STEPS + 1); }

static int run_on(run *r, size_t first, size_t last, size_t *done)
{
    return aoi_scene_run(&r->pair.scene, r->record[0], STEPS + 1, first, last, done);
}

static int run_all(run *r, size_t steps)
{
    size_t done = 0;
    int status = run_start(r);
    if (status == AOI_OK) {
        status = run_on(r, 1, steps, &done);
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
static double half_sine_error(const aoi_star *projectile, const aoi_star *target, double w,
                              double series, int steps)
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
        CHECK(near(error[0], PI * PI * PI / 12e4, 0.05), "%s: the force is off by %g",
              cases[i].what, error[0]);
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

/* Hertz: all the kinetic energy of the relative motion is in 2/5 k d^(5/2) at the deepest point,
 * the contact lasts 2.9432751 d/V, and equal masses exchange their velocities. */
static void rigid_spheres_follow_hertz(void)
{
    const double k = 1.0878566e10, m = 0.0326725636, dt = 2e-9;
    const aoi_star sphere = {0, m, 0.0, NULL, NULL};
    for (double velocity = 0.25; velocity < 5.0; velocity *= 4.0) {
        const double deepest = pow(1.25 * 0.5 * m * velocity * velocity / k, 0.4);
        run_make(&one, &sphere, &sphere, average(dt), velocity, 0.0);
        run_law(&one, "hertz", k);
        CHECK(run_all(&one, STEPS) == AOI_OK, "spheres at %g m/s", velocity);
        const double peak = largest(one.record[FORCE], STEPS + 1);
        CHECK(near(peak, k * deepest * sqrt(deepest), 1e-7), "peak %.12g at %g m/s", peak,
              velocity);
        CHECK(velocity != 1.0 || near(peak, 1001.536, 5e-7), "the paper's rigid pair: %.9g N",
              peak);
        CHECK(near(largest(one.record[INDENTATION], STEPS + 1), deepest, 1e-7),
              "indentation");
        CHECK(near(largest(one.record[STORED], STEPS + 1),
                   0.25 * m * velocity * velocity, 1e-6),
              "a quarter of m V^2 is stored at the deepest point");
        size_t touching = 0;
        while (touching < STEPS && one.record[FORCE][touching + 1] > 0.0) {
            touching++;
        }
        const double lasts = 2.9432751 * deepest / velocity;
        CHECK(fabs((double)touching * dt - lasts) < 1.5 * dt || lasts > STEPS * dt, "lasts %.9g s",
              (double)touching * dt);
        CHECK(lasts > STEPS * dt || (fabs(row_of(&one, 0, VELOCITY)[STEPS]) < 1e-6 * velocity &&
                                     near(row_of(&one, 1, VELOCITY)[STEPS], velocity, 1e-6)),
              "equal masses exchange their velocities");
    }
}

/* One anti-oscillator each, with the paper's k1 and 0.1 % of the mass at the contact: values from
 * an integration to twelve digits by others' codes. */
static void pair_with_one_oscillator_each(void)
{
    const double mass = 0.0326725636, m[] = {0.999 * mass}, k1[] = {275.7e6}, dt = 2e-9;
    const aoi_star sphere = {1, 0.001 * mass, 0.0, m, k1};
    run_make(&one, &sphere, &sphere, average(dt), 1.0, 0.0);
    run_law(&one, "hertz", 1.0878566e10);
    CHECK(run_all(&one, STEPS) == AOI_OK, "the pair");
    const double peak = largest(one.record[FORCE], STEPS + 1);
    CHECK(near(peak, 814.3692123467, 2e-6), "peak force %.12g N", peak);
    size_t j = 1;
    const double *d = one.record[INDENTATION];
    while (j < STEPS && d[j + 1] > 0.0) {
        j++;
    }
    const double apart = dt * ((double)j + d[j] / (d[j] - d[j + 1]));
    CHECK(near(apart, 70.7428420013e-6, 2e-6), "first apart after %.12g us", apart * 1e6);
}

static double no_potential(const aoi_law *law, const double *memory, double d)
{
    (void)memory;
    (void)law;
    return 0.0 * d;
}

/* It leaves the restitution e with c V (1 + e) = ln((1 + c V)/(1 - c e V)), whatever k and the
 * masses (integrate v dv/(1 + c v) = -k/m d^(3/2) dd from touch to parting); so the rate that the
 * law is given is that of the two bodies against each other. */
static void damped_contact_has_its_restitution(void)
{
    const aoi_star mass = {0, 0.02, 0.0, NULL, NULL}, other = {0, 0.05, 0.0, NULL, NULL};
    const double c = 0.3, velocity = 2.0, moving = -5.0;
    run_make(&one, &mass, &other, average(5e-9), moving + velocity, moving);
    one.law = (aoi_law){.force = hunt_crossley,
                        .potential = no_potential,
                        .depends_on_rate = 1,
                        .parameter = {1e10, c},
                        .limit = HUGE_VAL};
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

typedef struct random_star {
    double m[OSCILLATORS], k[OSCILLATORS];
    aoi_star star;
} random_star;

static void random_star_make(random_star *r, size_t n, uint64_t seed, double m0, double k0)
{
    for (size_t i = 0; i < n; i++) {
        r->m[i] = decades(&seed, -3.0, -1.0);
        r->k[i] = r->m[i] * decades(&seed, 8.0, 12.0);
    }
    r->star = (aoi_star){n, m0, k0, r->m, r->k};
}

/* Force on one is force on the other, and what a force does to a centre of mass it does by its mean
 * over the step: momentum and impulse agree to rounding, whatever else the step gets wrong. */
static void momentum_is_kept_and_impulse_is_its_change(void)
{
    static random_star a, b;
    random_star_make(&a, 3, 5, 1e-4, 0.0);
    random_star_make(&b, OSCILLATORS, 6, 1e-3, 0.0);
    const double mass_a = aoi_star_static_mass(&a.star), mass_b = aoi_star_static_mass(&b.star);
    for (double dt = 1e-8; dt < 2e-5; dt *= 10.0) {
        double worst = 0.0, impulse = 0.0, off = 0.0;
        run_make(&one, &a.star, &b.star, average(dt), 1.0, 0.0);
        run_law(&one, "hertz", 1e10);
        CHECK(run_all(&one, STEPS) == AOI_OK, "dt %g", dt);
        for (int j = 0; j <= STEPS; j++) {
            const double p_a = mass_a * row_of(&one, 0, AOI_BODY_CENTRE_VELOCITY)[j], p_b = mass_b * row_of(&one, 1, AOI_BODY_CENTRE_VELOCITY)[j];
            worst = fmax(worst, fabs((p_a + p_b) / mass_a - 1.0));
            impulse +=
                j == 0
                    ? 0.0
                    : 0.5 * dt * (one.record[FORCE][j] + one.record[FORCE][j - 1]);
            off = fmax(off, fabs(p_b - impulse) / mass_a);
        }
        CHECK(largest(one.record[FORCE], STEPS) > 0.0 && impulse > 0.1 * mass_a,
              "they hit");
        CHECK(worst < 1e-12, "dt %g: momentum changes by %g", dt, worst);
        CHECK(off < 1e-12, "dt %g: impulse and momentum differ by %g", dt, off);
    }
}

static void heavier_and_stiffer(random_star *r, double times)
{
    r->star.m0 *= times;
    r->star.k0 *= times;
    for (size_t i = 0; i < r->star.n; i++) {
        r->m[i] *= times;
        r->k[i] *= times;
    }
}

static double largest_difference(const double *a, const double *b, size_t count)
{
    double worst = 0.0;
    for (size_t j = 0; j < count; j++) {
        worst = fmax(worst, fabs(a[j] - b[j]));
    }
    return worst;
}

/* Who is called projectile, and from where one looks, makes no difference to the force. */
static void frame_of_reference_is_free(void)
{
    static random_star a, b;
    const size_t steps = 5000;
    random_star_make(&a, 3, 7, 1e-3, 0.0);
    random_star_make(&b, 9, 8, 1e-3, 0.0);
    run_law(&one, "hertz", 1e10);
    run_law(&two, "hertz", 1e10);
    run_make(&one, &a.star, &b.star, average(1e-7), 1.0, 0.0);
    CHECK(run_all(&one, steps) == AOI_OK, "a hits b");
    const double peak = largest(one.record[FORCE], steps);
    const double *force = one.record[FORCE];
    CHECK(peak > 10.0, "they hit, %g N", peak);
    run_make(&two, &b.star, &a.star, average(1e-7), 1.0, 0.0);
    CHECK(run_all(&two, steps) == AOI_OK, "b hits a");
    double off = largest_difference(force, two.record[FORCE], steps) / peak;
    CHECK(off < 1e-10, "who moves does not matter, off by %g", off);
    run_make(&two, &a.star, &b.star, average(1e-7), -9.0, -10.0);
    CHECK(run_all(&two, steps) == AOI_OK, "both move");
    off = largest_difference(force, two.record[FORCE], steps) / peak;
    CHECK(off < 1e-9, "a common velocity does not matter, off by %g", off);
    heavier_and_stiffer(&a, 10.0);
    heavier_and_stiffer(&b, 10.0);
    run_law(&two, "hertz", 1e11);
    run_make(&two, &a.star, &b.star, average(1e-7), 1.0, 0.0);
    CHECK(run_all(&two, steps) == AOI_OK, "ten times heavier and stiffer");
    for (size_t j = 0; j < steps; j++) {
        two.record[FORCE][j] *= 0.1;
    }
    off = largest_difference(force, two.record[FORCE], steps) / peak;
    CHECK(off < 1e-10, "ten times everything is ten times the force, off by %g", off);
}

static void gap_is_crossed_first(void)
{
    const aoi_star mass = {0, 0.1, 0.0, NULL, NULL};
    const double dt = 1.0 / 1048576.0, velocity = 2.0, gap = 100.5 * velocity * dt;
    run_make(&one, &mass, &WALL, average(dt), velocity, 0.0);
    run_law(&one, "hertz", 1e9);
    one.pair.contact.gap = gap;
    CHECK(run_all(&one, 200) == AOI_OK, "with a gap");
    for (int j = 0; j <= 100; j++) {
        CHECK(one.record[FORCE][j] == 0.0, "no force before the touch, step %d", j);
        CHECK(one.record[INDENTATION][j] == velocity * dt * j - gap,
              "the distance to go, step %d", j);
    }
    CHECK(one.record[FORCE][101] > 0.0, "the touch is at step 101");
}

static void record_is_what_was_asked_for(void)
{
    static random_star a, b;
    const size_t steps = 3000;
    random_star_make(&a, 5, 9, 1e-3, 0.0);
    random_star_make(&b, 8, 10, 1e-3, 1e6);
    run_law(&one, "hertz", 1e10);
    run_law(&two, "hertz", 1e10);
    run_make(&one, &a.star, &b.star, AVERAGE, 1.0, 0.0);
    CHECK(run_all(&one, steps) == AOI_OK, "all rows");
    run_make(&two, &a.star, &b.star, AVERAGE, 1.0, 0.0);
    two.pair.scene.energies = 0;
    for (int i = 0; i < ROWS; i++) {
        for (size_t j = 0; j <= steps + 1; j++) {
            two.record[i][j] = 77.0;
        }
    }
    CHECK(run_all(&two, steps) == AOI_OK, "without energies");
    for (int i = 0; i < ROWS; i++) {
        const double *wanted = one.record[i], *got = two.record[i];
        const int of_body = i < BODIES ? 0 : (i - BODIES) % OF_BODY;
        const int energy =
            i == STORED || i == LOST || (of_body >= AOI_BODY_KINETIC && of_body < AOI_BODY_ROWS);
        CHECK(energy || memcmp(wanted, got, (steps + 1) * sizeof *got) == 0, "row %d", i);
        CHECK(!energy || (got[0] == 77.0 && got[steps] == 77.0), "row %d is left alone", i);
        CHECK(got[steps + 1] == 77.0, "nothing is written to row %d beyond the last step", i);
    }
    run_make(&two, &a.star, &b.star, AVERAGE, 1.0, 0.0);
    size_t done = 0;
    CHECK(run_start(&two) == AOI_OK, "in pieces");
    for (size_t piece = 1; done < steps; piece = 3 * piece + 1) {
        const size_t last = done + piece < steps ? done + piece : steps;
        CHECK(run_on(&two, done + 1, last, &done) == AOI_OK && done == last,
              "piece");
    }
    for (int i = 0; i < ROWS; i++) {
        CHECK(memcmp(one.record[i], two.record[i], (steps + 1) * sizeof(double)) == 0,
              "row %d in pieces", i);
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
        random_star_make(&target, 1 + (size_t)trial % 28, seed, m0,
                         trial % 2 ? decades(&seed, 2.0, 9.0) : 0.0);
        run_make(&one, &mass, trial % 7 ? &target.star : &WALL, rule, decades(&seed, -6.0, 3.0),
                 0.0);
        run_law(&one, trial % 4 ? "hertz" : "linear", decades(&seed, 4.0, 15.0));
        one.pair.contact.gap = trial % 11 ? 0.0 : decades(&seed, -9.0, 0.0);
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

/* A row of equal masses, contact i between masses i and i+1. */
enum { BALLS = 30, ROW_STEPS = 3000, ROW_ROWS = 4 * (BALLS - 1) + 8 * BALLS };

static struct row {
    aoi_star star[BALLS];
    aoi_body body[BALLS], *bodies[BALLS];
    aoi_contact contact[BALLS];
    aoi_law law[BALLS];
    aoi_scene scene;
    size_t first_port[BALLS + 1];
    double u0[BALLS], v0[BALLS], body_work[BALLS][8], work[20000];
    double record[ROW_ROWS][ROW_STEPS + 1];
} row;

static void row_make(size_t balls, aoi_rule rule, const double *mass, double velocity)
{
    static const double own = 1.0;
    memset(&row.scene, 0, sizeof row.scene);
    for (size_t i = 0; i < balls; i++) {
        row.star[i] = (aoi_star){0, mass[i], 0.0, NULL, NULL};
        row.u0[i] = 0.0;
        row.v0[i] = i == 0 ? velocity : 0.0;
        row.bodies[i] = &row.body[i];
        row.contact[i] = (aoi_contact){.body = {i, i + 1}, .law = &row.law[i]};
        const aoi_body_start start = {&row.u0[i], &row.v0[i], &own, NULL, NULL};
        CHECK(aoi_body_start_star(&row.body[i], &row.star[i], NULL, &rule, &start,
                                  row.body_work[i]) == AOI_OK,
              "ball %zu", i);
    }
    row.scene = (aoi_scene){.body_count = balls,
                            .contact_count = balls - 1,
                            .body = row.bodies,
                            .contact = row.contact,
                            .dt = rule.dt,
                            .energies = 1,
                            .memory = row.work,
                            .first_port = row.first_port};
    CHECK(aoi_scene_size(&row.scene) <= sizeof row.work, "room for a row");
}

static int row_run(size_t steps)
{
    size_t done = 0;
    const int status = aoi_scene_start(&row.scene, row.record[0], ROW_STEPS + 1);
    return status != AOI_OK ? status
                            : aoi_scene_run(&row.scene, row.record[0], ROW_STEPS + 1, 1, steps, &done);
}

static const double *row_row(size_t ball, size_t which)
{
    return row.record[4 * row.scene.contact_count + 8 * ball + which];
}

static double row_momentum(const double *mass, size_t step)
{
    double sum = 0.0;
    for (size_t i = 0; i < row.scene.body_count; i++) {
        sum += mass[i] * row_row(i, AOI_BODY_CENTRE_VELOCITY)[step];
    }
    return sum;
}

static double row_energy(size_t step)
{
    double sum = 0.0;
    for (size_t i = 0; i < row.scene.body_count; i++) {
        sum += row_row(i, AOI_BODY_KINETIC)[step];
    }
    for (size_t c = 0; c < row.scene.contact_count; c++) {
        sum += row.record[4 * c + STORED][step] + row.record[4 * c + LOST][step];
    }
    return sum;
}

/* Momentum goes down a row of balls and none is lost; energy only to the rule's second order, and not
 * at all where the springs between them are linear and in contact throughout. */
static void a_row_of_balls_keeps_its_momentum(void)
{
    double mass[BALLS], drift[2];
    for (size_t i = 0; i < BALLS; i++) {
        mass[i] = 0.02 + 0.01 * (i % 3);
    }
    for (int level = 0; level < 2; level++) {
        const double hertz = 1e10;
        double worst = 0.0;
        row_make(BALLS, average(6e-7 / (level + 1)), mass, 1.0);
        for (size_t i = 0; i < BALLS; i++) {
            CHECK(aoi_law_create(&row.law[i], "hertz", 1, &hertz) == AOI_OK, "Hertz");
        }
        CHECK(row_run(ROW_STEPS) == AOI_OK, "a row of %d", BALLS);
        drift[level] = 0.0;
        for (size_t j = 0; j <= ROW_STEPS; j++) {
            worst = fmax(worst, fabs(row_momentum(mass, j) / mass[0] - 1.0));
        }
        for (size_t j = 0; j <= ROW_STEPS / 2 * (size_t)(level + 1); j++) {
            drift[level] = fmax(drift[level], fabs(row_energy(j) / row_energy(0) - 1.0));
        }
        CHECK(worst < 1e-12, "momentum off by %g", worst);
    }
    CHECK(drift[0] < 1e-3 && drift[0] / drift[1] > 3.0, "energy off by %g, %g", drift[0], drift[1]);
    CHECK(largest(row_row(6, VELOCITY), ROW_STEPS) > 0.1,
          "the wave has come to ball 6");
}

/* Rows of any masses and laws, steps from short to absurd: none fails, none pulls, all momentum stays. */
static void no_step_of_a_row_fails(void)
{
    static const struct {
        const char *name;
        size_t count;
        double parameter[3];
    } laws[] = {{"hertz", 1, {1e10}},
                {"linear", 1, {1e7}},
                {"hunt_crossley", 3, {1e10, 0.3, 1.5}},
                {"kelvin_voigt", 2, {1e7, 1e3}},
                {"tsuji", 2, {1e10, 2e3}},
                {"kuwabara_kono", 2, {1e10, 1e-5}}};
    uint64_t seed = 31;
    int failures = 0, pulls = 0;
    double worst = 0.0, gains = 0.0;
    for (int trial = 0; trial < 120; trial++) {
        const size_t balls = 3 + (size_t)trial % (BALLS - 2), steps = 150;
        double mass[BALLS];
        for (size_t i = 0; i < balls; i++) {
            mass[i] = decades(&seed, -3.0, 0.0);
        }
        const double velocity = decades(&seed, -6.0, 3.0);
        row_make(balls, average(decades(&seed, -8.0, 0.0)), mass, velocity);
        for (size_t i = 0; i < balls; i++) {
            const size_t which = (size_t)(uniform(&seed) * 6.0);
            CHECK(aoi_law_create(&row.law[i], laws[which].name, laws[which].count,
                                 laws[which].parameter) == AOI_OK,
                  "%s", laws[which].name);
            row.contact[i].gap = uniform(&seed) < 0.3 ? decades(&seed, -9.0, -3.0) : 0.0;
        }
        const int status = row_run(steps);
        failures += status != AOI_OK;
        for (size_t j = 0; status == AOI_OK && j <= steps; j++) {
            double size = 0.0;
            for (size_t i = 0; i < balls; i++) {
                size += mass[i] * fabs(row_row(i, AOI_BODY_CENTRE_VELOCITY)[j]);
            }
            worst = fmax(worst, fabs(row_momentum(mass, j) - mass[0] * velocity) / size);
            for (size_t c = 0; c + 1 < balls; c++) {
                pulls += row.record[4 * c + FORCE][j] < 0.0;
            }
        }
        gains += status == AOI_OK && !isfinite(row_energy(steps));
    }
    CHECK(failures == 0, "%d of 120 rows failed", failures);
    CHECK(pulls == 0 && gains == 0.0, "%d forces pull", pulls);
    CHECK(worst < 1e-10, "momentum off by %g", worst);
}

/* A mass on two springs against two walls, squeezed between them from the start: it stays, and with
 * a push it swings by w^2 = 2 k/m, all of its energy accounted for. */
static void preload_is_held(void)
{
    const double mass[] = {(double)INFINITY, 0.1, (double)INFINITY}, k = 1e6, squeeze = 1e-5;
    row_make(3, average(1e-6), mass, 0.0);
    for (size_t i = 0; i < 2; i++) {
        CHECK(aoi_law_create(&row.law[i], "linear", 1, &k) == AOI_OK, "a spring");
        row.contact[i].gap = -squeeze;
    }
    CHECK(row_run(500) == AOI_OK, "squeezed");
    CHECK(row.record[FORCE][0] == k * squeeze && row.record[FORCE][500] == k * squeeze &&
              row_row(1, DISPLACEMENT)[500] == 0.0,
          "it stays as it is");
    row_make(3, average(1e-6), mass, 0.0);
    const aoi_rule rule = average(1e-6);
    const double push = 1e-3, own = 1.0;
    const aoi_body_start start = {&row.u0[1], &push, &own, NULL, NULL};
    CHECK(aoi_body_start_star(&row.body[1], &row.star[1], NULL, &rule, &start, row.body_work[1]) ==
              AOI_OK,
          "pushed");
    row.contact[0].gap = row.contact[1].gap = -squeeze;
    CHECK(row_run(ROW_STEPS) == AOI_OK, "swinging");
    double worst = 0.0, drift = 0.0;
    const double w = sqrt(2.0 * k / 0.1);
    for (size_t j = 0; j <= ROW_STEPS; j++) {
        worst = fmax(worst, fabs(row_row(1, DISPLACEMENT)[j] - push / w * sin(w * 1e-6 * (double)j)));
        drift = fmax(drift, fabs(row_energy(j) / row_energy(0) - 1.0));
    }
    CHECK(worst < 2e-5 * push / w * w * 1e-6 * ROW_STEPS, "off the sine by %g of %g", worst, push / w);
    CHECK(drift < 1e-12, "energy off by %g", drift);
}

/* The same under a force that rises: what it does is in motion and in the springs, to rounding. */
static void loads_on_pressed_bodies_do_their_work(void)
{
    const double mass[] = {(double)INFINITY, 0.1, (double)INFINITY}, k = 1e6, squeeze = 1e-5;
    const double times[] = {0.0, 1e-3}, forces[] = {2.0, 5.0};
    const aoi_scene_load load = {1, 0, 1, {2, times, forces}};
    double drift = 0.0;
    row_make(3, average(1e-6), mass, 0.0);
    for (size_t i = 0; i < 2; i++) {
        CHECK(aoi_law_create(&row.law[i], "linear", 1, &k) == AOI_OK, "a spring");
        row.contact[i].gap = -squeeze;
    }
    row.scene.load = &load;
    row.scene.load_count = 1;
    CHECK(row_run(ROW_STEPS) == AOI_OK, "loaded");
    for (size_t j = 0; j <= ROW_STEPS; j++) {
        const double energy = row_energy(j) - row_row(1, AOI_BODY_WORK)[j];
        drift = fmax(drift, fabs(energy / row_energy(0) - 1.0));
    }
    CHECK(row_row(1, AOI_BODY_WORK)[ROW_STEPS] > 1e-6, "it works");
    CHECK(drift < 1e-12, "the ledger is off by %g", drift);
}

/* Loads: a mass under a force that rises, holds and stops, by its integral; two loads add up; the
 * work is what it has in motion. */
static void loads_do_their_work(void)
{
    const double mass[] = {0.5, (double)INFINITY}, dt = 1.0 / 4096.0;
    const double times[] = {0.0625, 0.125, 0.25, 0.25, 0.375}, forces[] = {1.0, 4.0, 4.0, 0.0, 0.5};
    const double constant[] = {2.0}, whenever[] = {77.0};
    const aoi_scene_load loads[] = {{0, 0, 1, {5, times, forces}}, {0, 0, 1, {1, whenever, constant}}};
    const double k = 1e6;
    row_make(2, average(dt), mass, 0.0);
    CHECK(aoi_law_create(&row.law[0], "linear", 1, &k) == AOI_OK, "a spring far away");
    row.contact[0].gap = 1e3;
    row.scene.load = loads;
    row.scene.load_count = 2;
    CHECK(row_run(2048) == AOI_OK, "loaded");
    /* The rule takes the mean over each step: exact but for the step in which the load stops. */
    const double impulse = 1.0 * 0.0625 + 2.5 * 0.0625 + 4.0 * 0.125 - 0.5 * dt * 4.0 +
                           0.25 * 0.125 + 0.5 * 0.125 + 2.0 * 0.5;
    CHECK(near(row_row(0, VELOCITY)[2048], impulse / 0.5, 1e-13), "velocity %.15g",
          row_row(0, VELOCITY)[2048]);
    for (size_t j = 0; j <= 2048; j++) {
        CHECK(fabs(row_row(0, AOI_BODY_KINETIC)[j] - row_row(0, AOI_BODY_WORK)[j]) <
                  1e-12 * (1.0 + row_row(0, AOI_BODY_WORK)[j]),
              "what went in is in motion, step %zu", j);
    }
    CHECK(near(row_row(0, VELOCITY)[1], dt * 3.0 / 0.5, 1e-14), "it starts with the force there is");
}

/* A ball under gravity on a spring: it falls, is caught, and hangs about its place of rest. */
static void gravity_is_a_constant_force(void)
{
    const double mass[] = {0.2, (double)INFINITY}, k = 1e5, g = 9.81, gap = 1e-3, dt = 1e-6;
    const double force = mass[0] * g, own = 1.0;
    const aoi_rule rule = average(dt);
    const double above = 3e-4;
    row_make(2, rule, mass, 0.0);
    CHECK(aoi_law_create(&row.law[0], "linear", 1, &k) == AOI_OK, "a spring");
    row.contact[0].gap = gap - above;
    row.u0[0] = -above;
    const aoi_body_start start = {&row.u0[0], &row.v0[0], &own, &force, NULL};
    CHECK(aoi_body_start_star(&row.body[0], &row.star[0], NULL, &rule, &start, row.body_work[0]) ==
              AOI_OK,
          "a ball");
    row.scene.dt = dt;
    const size_t fall = (size_t)(sqrt(2.0 * gap / g) / dt);
    size_t done;
    CHECK(aoi_scene_start(&row.scene, row.record[0], ROW_STEPS + 1) == AOI_OK, "starts");
    for (size_t first = 1; first < fall + 8000; first += ROW_STEPS) {
        CHECK(aoi_scene_run(&row.scene, row.record[0], ROW_STEPS + 1, 1, ROW_STEPS, &done) == AOI_OK,
              "runs");
        for (size_t j = 1; j <= ROW_STEPS; j++) {
            const double t = dt * (double)(first - 1 + j), x = row_row(0, DISPLACEMENT)[j] + above;
            const double fallen = 0.5 * g * t * t, rounding = 1e-16; /* of places some 1e-4 m off */
            CHECK(t > dt * (double)fall || fabs(x - fallen) < 1e-9 * fallen + rounding,
                  "free fall at %g s", t);
            const double energy = row_energy(j), work = row_row(0, AOI_BODY_WORK)[j];
            CHECK(fabs(work - force * x) < force * (1e-12 * x + rounding) &&
                      fabs(energy - work) < 1e-4 * force * gap,
                  "the ledger at %g s", t);
        }
    }
}

/* A body that fails, for what the run says then. */
static int predict_or_fail(aoi_body *body, double *displacement, double *velocity)
{
    *displacement = *velocity = 0.0;
    return (body->scratch[0] -= 1.0) < 0.0 ? AOI_ERROR_SOLVER : AOI_OK;
}

static void correct_nothing(aoi_body *body, const double *force)
{
    (void)body;
    (void)force;
}

static int begin_nothing(aoi_body *body, const double *force)
{
    correct_nothing(body, force);
    return AOI_OK;
}

static void observe_nothing(const aoi_body *body, int energies, double *shown, size_t stride)
{
    (void)body;
    (void)energies;
    for (size_t i = 0; i < OF_BODY; i++) {
        shown[i * stride] = 0.0;
    }
}

static void failures_say_where(void)
{
    const aoi_star mass = {0, 0.1, 0.0, NULL, NULL};
    const double compliance = 1e-9, rate_compliance = 1e-3;
    aoi_body failing = {.begin = begin_nothing,
                        .predict = predict_or_fail,
                        .correct = correct_nothing,
                        .observe = observe_nothing,
                        .ports = 1,
                        .compliance = &compliance,
                        .rate_compliance = &rate_compliance,
                        .scratch = {4.0}};
    size_t done = 99;
    run_make(&one, &mass, &mass, AVERAGE, 1.0, 0.0);
    run_law(&one, "hertz", 1e10);
    one.pair.body[1] = &failing;
    CHECK(run_start(&one) == AOI_OK, "it starts");
    CHECK(run_on(&one, 1, 10, &done) == AOI_ERROR_SOLVER && done == 4,
          "four steps before the solver fails, not %zu", done);
    run_make(&one, &mass, &mass, AVERAGE, (double)NAN, 0.0);
    CHECK(run_start(&one) == AOI_OK, "it starts");
    CHECK(run_on(&one, 1, 10, &done) == AOI_ERROR_NOT_FINITE && done == 0,
          "a velocity that is no number");
    const double bad_gap[] = {(double)NAN, (double)INFINITY, -(double)INFINITY};
    for (size_t i = 0; i < 3; i++) {
        run_make(&one, &mass, &mass, AVERAGE, 1.0, 0.0);
        one.pair.contact.gap = bad_gap[i];
        one.record[0][0] = 77.0;
        CHECK(run_start(&one) == AOI_ERROR_ARGUMENT &&
                  one.record[0][0] == 77.0,
              "gap %g", bad_gap[i]);
    }
    run_make(&one, &WALL, &WALL, AVERAGE, 0.0, 0.0);
    CHECK(run_start(&one) == AOI_ERROR_NOT_POSITIVE, "wall against wall");
}

/* Sizes whose products are beyond size_t are more than malloc gives, not what is left of them. */
static void no_size_wraps(void)
{
    const size_t many = (size_t)1 << (4 * sizeof(size_t)), most = SIZE_MAX / 2;
    CHECK(aoi_scene_most(2, 2, many, many) == most, "as many contacts on one body");
    CHECK(aoi_scene_most(2, many * (many / 16), 1, 1) == most, "and ports");
    CHECK(aoi_coupled_size(many, many) == most, "of their equations");
    CHECK(aoi_body_modal_size(1, many) >= most, "ports of a body in modes");
    CHECK(aoi_body_full_size(1, many) >= most, "and of a whole one");
}

/* A scene is checked before anything of it is used. */
static void what_is_no_scene_is_refused(void)
{
    const aoi_star mass = {0, 0.1, 0.0, NULL, NULL};
    double time[] = {0.0, 1.0, 2.0}, force[] = {0.0, 1.0, 0.0};
    const aoi_scene_load load = {.ports = 1, .load = {3, time, force}};
    run_make(&one, &mass, &mass, AVERAGE, 1.0, 0.0);
    run_law(&one, "hertz", 1e10);
    aoi_scene *scene = &one.pair.scene;
    scene->dt = 1e-6;
    scene->load = &load;
    scene->load_count = 1;
    CHECK(aoi_scene_check(scene) == AOI_OK, "sound");
    double *const numbers[] = {&time[1], &time[1], &time[1], &force[2], &force[0], &scene->dt, &scene->dt};
    const double values[] = {3.0, -1.0, (double)NAN, (double)NAN, (double)INFINITY, 0.0, (double)NAN};
    for (size_t i = 0; i < 7; i++) {
        const double kept = *numbers[i];
        *numbers[i] = values[i];
        CHECK(aoi_scene_check(scene) == AOI_ERROR_ARGUMENT, "case %zu", i);
        *numbers[i] = kept;
    }
    aoi_law bad = *one.pair.contact.law;
    bad.compliance = (double)NAN;
    one.pair.contact.law = &bad;
    CHECK(aoi_scene_check(scene) == AOI_ERROR_ARGUMENT, "a law that cannot be used");
    run_make(&one, &mass, &mass, AVERAGE, 1.0, 0.0);
    run_law(&one, "hertz", 1e300);
    one.pair.contact.gap = -1e10;
    CHECK(run_start(&one) == AOI_ERROR_NOT_FINITE, "a force beyond the range of numbers at the start");
}

int main(void)
{
    half_sines_are_met_to_second_order();
    rigid_spheres_follow_hertz();
    pair_with_one_oscillator_each();
    damped_contact_has_its_restitution();
    momentum_is_kept_and_impulse_is_its_change();
    frame_of_reference_is_free();
    gap_is_crossed_first();
    record_is_what_was_asked_for();
    no_step_fails();
    a_row_of_balls_keeps_its_momentum();
    no_step_of_a_row_fails();
    preload_is_held();
    loads_on_pressed_bodies_do_their_work();
    loads_do_their_work();
    gravity_is_a_constant_force();
    failures_say_where();
    no_size_wraps();
    what_is_no_scene_is_refused();
    return check_report();
}
