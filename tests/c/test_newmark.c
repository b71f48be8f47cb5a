/* Newmark's rule on a star against what it does in closed form: an oscillator stepped with gamma =
 * 1/2 turns by a fixed angle a step, a star is the same as its dense matrices, the average
 * acceleration keeps energy and momentum. */
#include "body.h"

enum { MOST = 64 };

static const aoi_rule AVERAGE = {1e-6, 0.25, 0.5};

/* An undeformed star, all of it moving with velocity but the contact mass, which has had an impact and
 * is faster. */
static void start_damped(world *w, const aoi_star *star, aoi_rule rule, double velocity, double kick, size_t steps,
                         const double *damping, const double *gravity)
{
    memset(w, 0, sizeof *w);
    (void)add_star(w, star, velocity, kick, damping, gravity);
    by_hand(w);
    const int status = world_start(w, rule, steps + 1, NULL);
    CHECK(status == AOI_OK, "a star of %zu starts, status %d", star->n, status);
}

static void start_with_impulse(world *w, const aoi_star *star, aoi_rule rule, double velocity, double kick, size_t steps)
{
    start_damped(w, star, rule, velocity, kick, steps, NULL, NULL);
}

static void start(world *w, const aoi_star *star, aoi_rule rule, double velocity, size_t steps)
{
    start_with_impulse(w, star, rule, velocity, 0.0, steps);
}

/* A mass on its ground spring: u_j = u_1 sin(j a)/sin(a) with u_1 = h V/(1 + beta W), W = (w h)^2
 * and tan^2(a/2) = W/4/(1 + (beta - 1/4) W): exact for any beta at gamma = 1/2. */
static void oscillator_turns_by_a_fixed_angle(double beta, double step_angle)
{
    const double k = 5e7, m = 0.2, w2 = k / m, h = step_angle / sqrt(w2), velocity = 3.0;
    const double big = w2 * h * h, first = h * velocity / (1.0 + beta * big);
    const double angle = 2.0 * atan(sqrt(0.25 * big / (1.0 + (beta - 0.25) * big)));
    const aoi_star star = {0, m, k, NULL, NULL};
    world s;
    double worst = 0.0;
    start(&s, &star, (aoi_rule){h, beta, 0.5}, velocity, 2000);
    for (int j = 1; j <= 2000; j++) {
        const observation seen = step(&s, 0.0);
        worst = fmax(worst, fabs(seen.displacement - first * sin(j * angle) / sin(angle)) * sin(angle) / first);
    }
    CHECK(worst < 2000.0 * 8.0 * DBL_EPSILON * (step_angle + 1.0 / step_angle),
          "beta %g, w h = %g: off by %g", beta, step_angle, worst);
}

/* gamma > 1/2 damps: over a step the determinant of the map is (1 + (beta - gamma + 1/2) W)/(1 +
 * beta W) for an oscillator; here by the peaks of u over whole turns. */
static void numerical_damping_is_newmarks(void)
{
    const double gamma = 0.6, beta = 0.3025, big = 0.04, h = 1e-5;
    const aoi_star star = {0, 1.0, big / (h * h), NULL, NULL};
    const double determinant = (1.0 + (beta - gamma + 0.5) * big) / (1.0 + beta * big);
    const double trace = (2.0 - (gamma + 0.5 - 2.0 * beta) * big) / (1.0 + beta * big);
    world s;
    double u[3] = {0.0, 0.0, 0.0};
    start(&s, &star, (aoi_rule){h, beta, gamma}, 1.0, 500);
    u[1] = step(&s, 0.0).displacement;
    for (int j = 2; j < 500; j++) {
        u[2] = step(&s, 0.0).displacement;
        /* Newmark's recurrence in displacements alone. */
        CHECK(fabs(u[2] - trace * u[1] + determinant * u[0]) < 1e-14 * h * 10.0,
              "step %d: off by %g h", j, (u[2] - trace * u[1] + determinant * u[0]) / h);
        u[0] = u[1];
        u[1] = u[2];
    }
}

/* The same rule on the dense matrices, straight from its definition and with no elimination by
 * hand. */
typedef struct dense {
    size_t size;
    double m[MOST], k[MOST][MOST], u[MOST], v[MOST], a[MOST];
    double alpha, beta, g[MOST]; /* Rayleigh's damping, a constant force */
} dense;

static void dense_make(dense *d, const aoi_star *star, double velocity)
{
    memset(d, 0, sizeof *d);
    d->size = star->n + 1;
    d->m[0] = star->m0;
    d->k[0][0] = star->k0;
    d->v[0] = velocity;
    for (size_t i = 1; i < d->size; i++) {
        d->m[i] = star->m[i - 1];
        d->k[i][i] = star->k[i - 1];
        d->k[0][i] = d->k[i][0] = -star->k[i - 1];
        d->k[0][0] += star->k[i - 1];
        d->v[i] = velocity;
    }
}

static void dense_step(dense *d, aoi_rule rule, double force)
{
    static double a[MOST][MOST], rhs[MOST];
    const double h = rule.dt, reach = rule.beta * h * h + d->beta * rule.gamma * h;
    for (size_t i = 0; i < d->size; i++) {
        d->u[i] += h * d->v[i] + h * h * (0.5 - rule.beta) * d->a[i];
        d->v[i] += h * (1.0 - rule.gamma) * d->a[i];
    }
    for (size_t i = 0; i < d->size; i++) {
        rhs[i] = (i == 0 ? force : 0.0) + d->g[i] - d->alpha * d->m[i] * d->v[i];
        for (size_t j = 0; j < d->size; j++) {
            const double mass = i == j ? d->m[i] * (1.0 + d->alpha * rule.gamma * h) : 0.0;
            a[i][j] = reach * d->k[i][j] + mass;
            rhs[i] -= d->k[i][j] * (d->u[j] + d->beta * d->v[j]);
        }
    }
    for (size_t p = 0; p < d->size; p++) {
        for (size_t i = p + 1; i < d->size; i++) {
            const double factor = a[i][p] / a[p][p];
            for (size_t j = p; j < d->size; j++) {
                a[i][j] -= factor * a[p][j];
            }
            rhs[i] -= factor * rhs[p];
        }
    }
    for (size_t p = d->size; p-- > 0;) {
        for (size_t j = p + 1; j < d->size; j++) {
            rhs[p] -= a[p][j] * rhs[j];
        }
        rhs[p] /= a[p][p];
        d->a[p] = rhs[p];
        d->u[p] += rule.beta * h * h * rhs[p];
        d->v[p] += h * rule.gamma * rhs[p];
    }
}

static void centre_weights(const dense *d, double *weights)
{
    double mass = 0.0;
    for (size_t i = 0; i < d->size; i++) {
        mass += d->m[i];
    }
    for (size_t i = 0; i < d->size; i++) {
        weights[i] = d->m[i] / mass;
    }
}

/* Damping, a random constant force on each coordinate, and the accelerations at the start, where the star
 * moves at 1 m/s, undeformed. */
static void dense_load(dense *d, const double *damping, double k0, uint64_t *seed, double *gravity)
{
    d->alpha = damping[0];
    d->beta = damping[1];
    for (size_t i = 0; i < d->size; i++) {
        gravity[i] = d->g[i] = damping[0] + damping[1] > 0.0 ? 1e3 * (uniform(seed) - 0.3) : 0.0;
        d->a[i] = d->g[i] / d->m[i] - damping[0];
    }
    d->a[0] -= damping[1] * k0 / d->m[0];
}

static double weighted(size_t n, const double *weight, const double *x)
{
    double sum = 0.0;
    for (size_t i = 0; i < n; i++) {
        sum += weight[i] * x[i];
    }
    return sum;
}

/* With dashpots or without, under gravity, from an accelerated start; what the dashpots take is what is missing of the
 * energy, to rounding, with the average acceleration. */
static void star_moves_as_its_matrices(size_t n, double k0, aoi_rule rule, const double *damping)
{
    static dense d;
    random_star r;
    world s;
    uint64_t seed = n + 300;
    double gravity[MOST], weights[MOST], worst = 0.0, size = 0.0, drift = 0.0, lost = 0.0, work = 0.0, u = 0.0;
    random_star_make(&r, n, &seed, 0.0, 0.05, k0);
    dense_make(&d, &r.star, 1.0);
    centre_weights(&d, weights);
    dense_load(&d, damping, k0, &seed, gravity);
    const int free = damping[0] + damping[1] == 0.0; /* of damping and gravity: the plain body of modal.c */
    start_damped(&s, &r.star, rule, 1.0, 0.0, 300, free ? NULL : damping, free ? NULL : gravity);
    const observation first = observe(&s, 0);
    double before = 0.0;
    for (int j = 0; j < 300; j++) {
        const double force = 1e5 * sin(0.05 * (j + 1));
        const observation seen = step(&s, force);
        dense_step(&d, rule, force);
        const double centre = weighted(n + 1, weights, d.u);
        size = fmax(size, fabs(d.u[0]));
        worst = fmax(worst, fmax(fabs(seen.displacement - d.u[0]), fabs(seen.centre_displacement - centre)));
        work += 0.5 * (force + before) * (seen.displacement - u);
        before = force;
        u = seen.displacement;
        lost = seen.dissipated;
        drift = fmax(drift, fabs(seen.kinetic + seen.elastic + lost - seen.work - (first.kinetic + first.elastic)) /
                                (fabs(work) + first.kinetic));
    }
    const aoi_progress end = aoi_newmark_progress(s.run);
    aoi_modes modes; /* by mass, as star_shape takes them */
    CHECK(aoi_star_modes(&r.star, keep(aoi_star_modes_size(&r.star)), &modes) == AOI_OK, "modes");
    for (size_t i = 0; i <= n; i++) {
        double place = 0.0;
        for (size_t j = 0; j <= n; j++) {
            place += star_shape(&r.star, &modes, i, j) / modes.shape[j] * end.x[j];
        }
        CHECK(fabs(place - d.u[i]) < 1e-10 * size, "coordinate %zu of %zu", i, n);
    }
    CHECK(worst < 1e-11 * size, "%zu oscillators, alpha %g, beta %g: %g off the dense matrices", n,
          damping[0], damping[1], worst / size);
    CHECK((lost > 0.0) == !free, "dashpots take energy");
    CHECK(free || rule.gamma != 0.5 || rule.beta != 0.25 || drift < 1e-12, "the ledger is off by %g", drift);
}

/* Average acceleration keeps the energy of a linear system: 1e5 steps of free vibration, of bodies
 * held and of bodies that meanwhile move freely a tenth of a metre. */
static void energy_is_kept(size_t n, double k0, double h)
{
    random_star r;
    world s;
    uint64_t seed = 17 + n;
    random_star_make(&r, n, &seed, 0.0, 0.02, k0);
    start_with_impulse(&s, &r.star, (aoi_rule){h, 0.25, 0.5}, 1.0, 5.0, 100000);
    observation seen = observe(&s, 0);
    const double energy = seen.kinetic + seen.elastic;
    double worst = 0.0, stored = 0.0;
    for (int j = 0; j < 100000; j++) {
        seen = step(&s, 0.0);
        worst = fmax(worst, fabs((seen.kinetic + seen.elastic) / energy - 1.0));
        stored = fmax(stored, seen.elastic / energy);
    }
    CHECK(stored > 1e-3, "it vibrates, %g of the energy in springs", stored);
    CHECK(worst < 1e-12, "%zu oscillators, step %g: energy off by %g", n, h, worst);
}

/* Without m0 a constant force holds its springs at f/k beyond their masses: one oscillator. */
static void massless_contact_is_statics(void)
{
    const double m = 2.0, k = 8e6, h = 1e-5, force = 3.0;
    const aoi_star star = {1, 0.0, 0.0, &m, &k};
    world s;
    start(&s, &star, (aoi_rule){h, 0.25, 0.5}, 0.0, 1000);
    for (int j = 1; j <= 1000; j++) {
        const observation seen = step(&s, force);
        const double mass_at = 0.5 * force / m * h * h * (j * (j - 1.0) + 0.5);
        CHECK(near(seen.centre_displacement, mass_at, 1e-12), "the mass falls freely, step %d", j);
        CHECK(near(seen.displacement, mass_at + force / k, 1e-12), "the contact leads by f/k, step %d", j);
    }
    /* k0 alone beside it: the force is shared, at rest f/k0. */
    start(&s, &star, (aoi_rule){h, 0.25, 0.5}, 1.0, 1);
    const observation seen = step(&s, 0.0);
    CHECK(near(seen.displacement, h, 1e-14) && near(seen.velocity, 1.0, 1e-14), "free motion at 1 m/s");
}

/* The state is what goes in, and what a run from there would have gone on with; with and without energies. */
static void state_can_be_taken_up_again(double m0)
{
    random_star r;
    world one, two, lean;
    uint64_t seed = 41;
    random_star_make(&r, 6, &seed, 0.0, m0, 1e6);
    start_with_impulse(&one, &r.star, AVERAGE, 1.0, m0 > 0.0 ? 2.0 : 0.0, 400);
    const size_t bytes = one.body[0].n * sizeof(double);
    aoi_progress at = aoi_newmark_progress(one.run);
    CHECK(memcmp(at.x, one.x[0], bytes) == 0 && memcmp(at.v, one.v[0], bytes) == 0, "the initial state");
    lean = one;
    lean.lean = 1;
    CHECK(world_start(&lean, AVERAGE, 201, NULL) == AOI_OK, "without energies");
    for (int j = 0; j < 200; j++) {
        (void)step(&one, 0.0);
        (void)step(&lean, 0.0);
    }
    at = aoi_newmark_progress(one.run);
    CHECK(at.steps == 200 && near(at.time, 200e-6, 1e-14), "after 200 steps");
    const aoi_progress other = aoi_newmark_progress(lean.run);
    double fastest = 0.0, apart = 0.0;
    for (size_t j = 0; j < one.body[0].n; j++) {
        fastest = fmax(fastest, fabs(at.v[j]));
        apart = fmax(apart, fabs(at.v[j] - other.v[j]));
    }
    CHECK(apart < 1e-11 * fastest, "m0 = %g: the rates without energies differ by %g", m0, apart / fastest);
    two = one;
    memcpy(two.x[0], at.x, bytes);
    memcpy(two.v[0], at.v, bytes);
    CHECK(world_start(&two, AVERAGE, 201, NULL) == AOI_OK, "on");
    double worst = 0.0, size = 0.0;
    for (int j = 0; j < 200; j++) {
        const observation a = step(&one, 0.0), b = step(&two, 0.0);
        worst = fmax(worst, fmax(fabs(a.displacement - b.displacement),
                                 fabs(a.centre_displacement - b.centre_displacement)));
        size = fmax(size, fabs(a.displacement));
    }
    CHECK(worst < 1e-11 * size, "m0 = %g: the second half differs by %g", m0, worst / size);
}

static void rules_that_cannot_be(void)
{
    const double nan = (double)NAN, inf = (double)INFINITY;
    const aoi_rule bad[] = {{0.0, 0.25, 0.5},  {-1e-6, 0.25, 0.5}, {nan, 0.25, 0.5},   {inf, 0.25, 0.5},
                            {1e-6, 0.0, 0.5},  {1e-6, -0.1, 0.5},  {1e-6, nan, 0.5},   {1e-6, 0.25, 0.49},
                            {1e-6, 0.25, nan}, {1e200, 0.25, 0.5}, {1e-200, 0.25, 0.5}};
    const aoi_star mass = {0, 1.0, 0.0, NULL, NULL};
    world s;
    double record[8] = {77.0};
    start(&s, &mass, AVERAGE, 1.0, 1);
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++) {
        CHECK(aoi_newmark_start(s.run, &s.system, &bad[i], &s.start, 1, record, 1) == AOI_ERROR_ARGUMENT &&
                  record[0] == 77.0,
              "dt %g, beta %g, gamma %g", bad[i].dt, bad[i].beta, bad[i].gamma);
    }
}

int main(void)
{
    const double betas[] = {0.25, 1.0 / 6.0, 1.0 / 12.0, 0.4};
    for (size_t i = 0; i < 4; i++) {
        oscillator_turns_by_a_fixed_angle(betas[i], 0.01);
        oscillator_turns_by_a_fixed_angle(betas[i], 0.5);
        oscillator_turns_by_a_fixed_angle(betas[i], 1.7);
        drop();
    }
    oscillator_turns_by_a_fixed_angle(0.25, 1e3);
    numerical_damping_is_newmarks();
    const double undamped[] = {0.0, 0.0};
    const aoi_rule rules[] = {{1e-6, 0.25, 0.5}, {2e-7, 1.0 / 6.0, 0.5}, {2e-6, 0.3025, 0.6}};
    for (size_t i = 0; i < 3; i++) {
        for (size_t n = 0; n <= 28; n += n < 9 ? 1 : 19) {
            star_moves_as_its_matrices(n, 0.0, rules[i], undamped);
            star_moves_as_its_matrices(n, 1e8, rules[i], undamped);
            drop();
        }
    }
    const double dampings[][2] = {{3e3, 0.0}, {0.0, 2e-7}, {5e2, 1e-6}};
    for (size_t i = 0; i < 3; i++) {
        for (size_t n = 0; n <= 28; n += n < 5 ? 1 : 23) {
            star_moves_as_its_matrices(n, 0.0, rules[i], dampings[0]);
            star_moves_as_its_matrices(n, 1e8, rules[i], dampings[0]);
            star_moves_as_its_matrices(n, 1e8, rules[i], dampings[1]);
            star_moves_as_its_matrices(n, 1e8, rules[i], dampings[2]);
            drop();
        }
    }
    for (size_t n = 1; n <= 28; n += 9) {
        for (double h = 1e-8; h < 2e-6; h *= 10.0) {
            energy_is_kept(n, 0.0, h);
            energy_is_kept(n, 1e9, h);
            drop();
        }
    }
    massless_contact_is_statics();
    state_can_be_taken_up_again(0.03);
    state_can_be_taken_up_again(0.0);
    rules_that_cannot_be();
    drop();
    return check_report();
}
