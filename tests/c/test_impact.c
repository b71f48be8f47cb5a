/* Impacts known in closed form: half sines of linear springs, Hertz's rigid pair, a mass behind a
 * spring; second order in dt; momentum, symmetry, the frame of reference; and that nothing, from
 * the lightest touch to an absurd step, makes a step fail. */
#include "check.h"

#include <string.h>

enum { STEPS = 40000, OSCILLATORS = 28 };

static const aoi_star WALL = {0, (double)INFINITY, 0.0, NULL, NULL};

typedef struct player {
    aoi_body body;
    double u0[OSCILLATORS + 1], v0[OSCILLATORS + 1], centre[OSCILLATORS + 1];
    double work[5 * OSCILLATORS + 3];
} player;

typedef struct run {
    player projectile, target;
    aoi_law law;
    aoi_impact impact;
    double record[AOI_ROW_COUNT][STEPS + 1], *row[AOI_ROW_COUNT];
} run;

static run one, two;

static void player_start(player *p, const aoi_star *star, aoi_newmark rule, double velocity)
{
    const double total = aoi_star_static_mass(star);
    for (size_t i = 0; i <= star->n; i++) {
        p->u0[i] = 0.0;
        p->v0[i] = velocity;
        p->centre[i] = isinf(total) ? 1.0 : (i == 0 ? star->m0 : star->m[i - 1]) / total;
    }
    const int status = aoi_body_start_star(&p->body, star, &rule, p->centre, p->u0, p->v0, p->work);
    CHECK(status == AOI_OK, "a star of %zu starts, status %d", star->n, status);
}

/* Everything but the law: velocities of projectile and target, all rows wanted. */
static void run_make(run *r, const aoi_star *projectile, const aoi_star *target, aoi_newmark rule,
                     double velocity, double target_velocity)
{
    player_start(&r->projectile, projectile, rule, velocity);
    player_start(&r->target, target, rule, target_velocity);
    for (int i = 0; i < AOI_ROW_COUNT; i++) {
        r->row[i] = r->record[i];
    }
    r->impact = (aoi_impact){&r->projectile.body, &r->target.body, &r->law, 0.0, 0.0, 0.0};
}

static void run_law(run *r, const char *name, double k)
{
    CHECK(aoi_law_create(&r->law, name, 1, &k) == AOI_OK, "%s(%g)", name, k);
}

static int run_all(run *r, size_t steps)
{
    size_t done = 0;
    int status = aoi_impact_start(&r->impact, r->row);
    if (status == AOI_OK) {
        status = aoi_impact_run(&r->impact, r->row, 1, steps, &done);
    }
    CHECK(status != AOI_OK || done == steps, "all steps done");
    return status;
}

static const aoi_newmark AVERAGE = {1e-6, 0.25, 0.5};

static aoi_newmark average(double dt) { return (aoi_newmark){dt, 0.25, 0.5}; }

static double *row_of(run *r, int body, int which)
{
    return r->record[AOI_ROW_BODY + 6 * body + which];
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
        worst = fmax(worst, fabs(one.record[AOI_ROW_FORCE][j] / peak - sin(w * dt * j)));
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
        const double peak = largest(one.record[AOI_ROW_FORCE], STEPS + 1);
        CHECK(near(peak, k * deepest * sqrt(deepest), 1e-7), "peak %.12g at %g m/s", peak,
              velocity);
        CHECK(velocity != 1.0 || near(peak, 1001.536, 5e-7), "the paper's rigid pair: %.9g N",
              peak);
        CHECK(near(largest(one.record[AOI_ROW_INDENTATION], STEPS + 1), deepest, 1e-7),
              "indentation");
        CHECK(near(largest(one.record[AOI_ROW_CONTACT_ENERGY], STEPS + 1),
                   0.25 * m * velocity * velocity, 1e-6),
              "a quarter of m V^2 is stored at the deepest point");
        size_t touching = 0;
        while (touching < STEPS && one.record[AOI_ROW_FORCE][touching + 1] > 0.0) {
            touching++;
        }
        const double lasts = 2.9432751 * deepest / velocity;
        CHECK(fabs((double)touching * dt - lasts) < 1.5 * dt || lasts > STEPS * dt, "lasts %.9g s",
              (double)touching * dt);
        CHECK(lasts > STEPS * dt || (fabs(row_of(&one, 0, 1)[STEPS]) < 1e-6 * velocity &&
                                     near(row_of(&one, 1, 1)[STEPS], velocity, 1e-6)),
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
    const double peak = largest(one.record[AOI_ROW_FORCE], STEPS + 1);
    CHECK(near(peak, 814.3692123467, 2e-6), "peak force %.12g N", peak);
    size_t j = 1;
    const double *d = one.record[AOI_ROW_INDENTATION];
    while (j < STEPS && d[j + 1] > 0.0) {
        j++;
    }
    const double apart = dt * ((double)j + d[j] / (d[j] - d[j + 1]));
    CHECK(near(apart, 70.7428420013e-6, 2e-6), "first apart after %.12g us", apart * 1e6);
}

/* Hunt and Crossley's law, F = k d^(3/2) (1 + c rate), as a caller may write one. */
static void hunt_crossley(const aoi_law *law, double d, double rate, aoi_law_value *value)
{
    const double k = law->parameter[0], c = law->parameter[1], root = d > 0.0 ? sqrt(d) : 0.0;
    const double factor = 1.0 + c * rate;
    value->force = factor > 0.0 ? k * root * d * factor : 0.0;
    value->stiffness = factor > 0.0 ? 1.5 * k * root * factor : 0.0;
    value->damping = factor > 0.0 ? k * root * d * c : 0.0;
}

static double no_potential(const aoi_law *law, double d)
{
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
    one.law = (aoi_law){hunt_crossley, no_potential, {1e10, c}};
    CHECK(run_all(&one, STEPS) == AOI_OK, "damped");
    CHECK(one.record[AOI_ROW_FORCE][STEPS] == 0.0, "they have parted");
    const double e = (row_of(&one, 1, 1)[STEPS] - row_of(&one, 0, 1)[STEPS]) / velocity;
    CHECK(e > 0.3 && e < 0.9, "restitution %g", e);
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
            const double p_a = mass_a * row_of(&one, 0, 3)[j], p_b = mass_b * row_of(&one, 1, 3)[j];
            worst = fmax(worst, fabs((p_a + p_b) / mass_a - 1.0));
            impulse +=
                j == 0
                    ? 0.0
                    : 0.5 * dt * (one.record[AOI_ROW_FORCE][j] + one.record[AOI_ROW_FORCE][j - 1]);
            off = fmax(off, fabs(p_b - impulse) / mass_a);
        }
        CHECK(largest(one.record[AOI_ROW_FORCE], STEPS) > 0.0 && impulse > 0.1 * mass_a,
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
    const double peak = largest(one.record[AOI_ROW_FORCE], steps);
    const double *force = one.record[AOI_ROW_FORCE];
    CHECK(peak > 10.0, "they hit, %g N", peak);
    run_make(&two, &b.star, &a.star, average(1e-7), 1.0, 0.0);
    CHECK(run_all(&two, steps) == AOI_OK, "b hits a");
    double off = largest_difference(force, two.record[AOI_ROW_FORCE], steps) / peak;
    CHECK(off < 1e-10, "who moves does not matter, off by %g", off);
    run_make(&two, &a.star, &b.star, average(1e-7), -9.0, -10.0);
    CHECK(run_all(&two, steps) == AOI_OK, "both move");
    off = largest_difference(force, two.record[AOI_ROW_FORCE], steps) / peak;
    CHECK(off < 1e-9, "a common velocity does not matter, off by %g", off);
    heavier_and_stiffer(&a, 10.0);
    heavier_and_stiffer(&b, 10.0);
    run_law(&two, "hertz", 1e11);
    run_make(&two, &a.star, &b.star, average(1e-7), 1.0, 0.0);
    CHECK(run_all(&two, steps) == AOI_OK, "ten times heavier and stiffer");
    for (size_t j = 0; j < steps; j++) {
        two.record[AOI_ROW_FORCE][j] *= 0.1;
    }
    off = largest_difference(force, two.record[AOI_ROW_FORCE], steps) / peak;
    CHECK(off < 1e-10, "ten times everything is ten times the force, off by %g", off);
}

static void gap_is_crossed_first(void)
{
    const aoi_star mass = {0, 0.1, 0.0, NULL, NULL};
    const double dt = 1.0 / 1048576.0, velocity = 2.0, gap = 100.5 * velocity * dt;
    run_make(&one, &mass, &WALL, average(dt), velocity, 0.0);
    run_law(&one, "hertz", 1e9);
    one.impact.gap = gap;
    CHECK(run_all(&one, 200) == AOI_OK, "with a gap");
    for (int j = 0; j <= 100; j++) {
        CHECK(one.record[AOI_ROW_FORCE][j] == 0.0, "no force before the touch, step %d", j);
        CHECK(one.record[AOI_ROW_INDENTATION][j] == velocity * dt * j - gap,
              "the distance to go, step %d", j);
    }
    CHECK(one.record[AOI_ROW_FORCE][101] > 0.0, "the touch is at step 101");
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
    for (int only = -1; only < AOI_ROW_COUNT; only++) {
        run_make(&two, &a.star, &b.star, AVERAGE, 1.0, 0.0);
        for (int i = 0; i < AOI_ROW_COUNT; i++) {
            for (size_t j = 0; j <= steps + 1; j++) {
                two.record[i][j] = 77.0;
            }
            two.row[i] = i == only ? two.record[i] : NULL;
        }
        CHECK(run_all(&two, steps) == AOI_OK, "row %d alone", only);
        for (int i = 0; i < AOI_ROW_COUNT; i++) {
            const double *wanted = one.record[i], *got = two.record[i];
            CHECK(i != only || memcmp(wanted, got, (steps + 1) * sizeof *got) == 0,
                  "row %d alone is the same", i);
            CHECK(got[steps + 1] == 77.0 && (i == only || (got[0] == 77.0 && got[steps] == 77.0)),
                  "nothing is written to row %d but what was asked for, with row %d", i, only);
        }
    }
    run_make(&two, &a.star, &b.star, AVERAGE, 1.0, 0.0);
    size_t done = 0;
    CHECK(aoi_impact_start(&two.impact, two.row) == AOI_OK, "in pieces");
    for (size_t piece = 1; done < steps; piece = 3 * piece + 1) {
        const size_t last = done + piece < steps ? done + piece : steps;
        CHECK(aoi_impact_run(&two.impact, two.row, done + 1, last, &done) == AOI_OK && done == last,
              "piece");
    }
    for (int i = 0; i < AOI_ROW_COUNT; i++) {
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
        const aoi_newmark rule = {decades(&seed, -12.0, 0.0), trial % 3 ? 0.25 : 0.3025,
                                  trial % 3 ? 0.5 : 0.6};
        const double m0 = trial % 5 ? decades(&seed, -9.0, 2.0) : 0.0;
        random_star_make(&target, 1 + (size_t)trial % 28, seed, m0,
                         trial % 2 ? decades(&seed, 2.0, 9.0) : 0.0);
        run_make(&one, &mass, trial % 7 ? &target.star : &WALL, rule, decades(&seed, -6.0, 3.0),
                 0.0);
        run_law(&one, trial % 4 ? "hertz" : "linear", decades(&seed, 4.0, 15.0));
        one.impact.gap = trial % 11 ? 0.0 : decades(&seed, -9.0, 0.0);
        failures += run_all(&one, 300) != AOI_OK;
        for (int j = 0; j <= 300; j++) {
            pulls += one.record[AOI_ROW_FORCE][j] < 0.0;
            for (int i = 0; i < AOI_ROW_COUNT; i++) {
                endless += !isfinite(one.record[i][j]);
            }
        }
    }
    CHECK(failures == 0, "%d of 1500 runs failed", failures);
    CHECK(pulls == 0, "%d forces pull", pulls);
    CHECK(endless == 0, "%d numbers are not finite", endless);
}

/* A body that fails, for what the run says then. */
static int predict_or_fail(aoi_body *body, double *displacement, double *velocity)
{
    *displacement = *velocity = 0.0;
    return (body->scratch[0] -= 1.0) < 0.0 ? AOI_ERROR_SOLVER : AOI_OK;
}

static void correct_nothing(aoi_body *body, double force)
{
    (void)body;
    (void)force;
}

static void observe_nothing(const aoi_body *body, int energies, aoi_observation *seen)
{
    (void)body;
    (void)energies;
    (void)seen;
}

static void failures_say_where(void)
{
    const aoi_star mass = {0, 0.1, 0.0, NULL, NULL};
    aoi_body failing = {predict_or_fail,
                        correct_nothing,
                        observe_nothing,
                        NULL,
                        1e-9,
                        1e-3,
                        NULL,
                        NULL,
                        NULL,
                        {4.0}};
    size_t done = 99;
    run_make(&one, &mass, &mass, AVERAGE, 1.0, 0.0);
    run_law(&one, "hertz", 1e10);
    one.impact.target = &failing;
    CHECK(aoi_impact_start(&one.impact, one.row) == AOI_OK, "it starts");
    CHECK(aoi_impact_run(&one.impact, one.row, 1, 10, &done) == AOI_ERROR_SOLVER && done == 4,
          "four steps before the solver fails, not %zu", done);
    run_make(&one, &mass, &mass, AVERAGE, (double)NAN, 0.0);
    CHECK(aoi_impact_start(&one.impact, one.row) == AOI_OK, "it starts");
    CHECK(aoi_impact_run(&one.impact, one.row, 1, 10, &done) == AOI_ERROR_NOT_FINITE && done == 0,
          "a velocity that is no number");
    const double bad_gap[] = {-1e-9, (double)NAN, (double)INFINITY, -(double)INFINITY};
    for (size_t i = 0; i < 4; i++) {
        run_make(&one, &mass, &mass, AVERAGE, 1.0, 0.0);
        one.impact.gap = bad_gap[i];
        one.record[0][0] = 77.0;
        CHECK(aoi_impact_start(&one.impact, one.row) == AOI_ERROR_ARGUMENT &&
                  one.record[0][0] == 77.0,
              "gap %g", bad_gap[i]);
    }
    run_make(&one, &WALL, &WALL, AVERAGE, 0.0, 0.0);
    CHECK(aoi_impact_start(&one.impact, one.row) == AOI_ERROR_NOT_POSITIVE, "wall against wall");
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
    failures_say_where();
    return check_report();
}
