/* Newmark's rule on natural modes: a star and its modes are one body, damped, loaded and all; two
 * ports answer each other alike; a residual compliance is a spring; the ledger closes. */
#include "body.h"
#include "linear/vector.h"
#include "star/receptance.h"
#include "newmark/body.h"

#include <string.h>

enum { MOST = 12, PORTS = 2, WORK = 6 * MOST + 2 * PORTS + 2 * PORTS * PORTS };

static const aoi_rule AVERAGE = {1e-6, 0.25, 0.5};

typedef struct modes {
    double omega[MOST], decay[MOST], participation[PORTS * MOST], residual[PORTS * PORTS];
    double u[MOST], v[MOST], centre[MOST], gravity[MOST], work[WORK];
    aoi_modes modal;
    aoi_body body;
} modes;

static void set_modal(modes *m, size_t n, size_t ports, int with_residual)
{
    m->modal = (aoi_modes){.n = n, .ports = ports, .omega = m->omega, .decay = m->decay};
    m->modal.shape = m->modal.push = m->participation;
    m->modal.residual = with_residual ? m->residual : NULL;
    m->modal.centre = m->centre;
}

static void modes_random(modes *m, size_t n, size_t ports, uint64_t *seed)
{
    memset(m, 0, sizeof *m);
    for (size_t j = 0; j < n; j++) {
        m->omega[j] = j == 0 ? 0.0 : decades(seed, 3.0, 6.0);
        m->decay[j] = 0.1 * m->omega[j] * uniform(seed);
        m->u[j] = 1e-6 * uniform(seed);
        m->v[j] = uniform(seed) - 0.5;
        m->centre[j] = uniform(seed);
        m->gravity[j] = 10.0 * (uniform(seed) - 0.5);
        for (size_t p = 0; p < ports; p++) {
            m->participation[p * n + j] = 2.0 * (uniform(seed) - 0.5);
        }
    }
    set_modal(m, n, ports, 1);
}

static int modes_start(modes *m, const aoi_rule *rule, int with_gravity)
{
    const aoi_body_start begin = {m->u, m->v, NULL, NULL, NULL};
    m->modal.gravity = with_gravity ? m->gravity : NULL;
    CHECK(aoi_body_modal_size(m->modal.n, m->modal.ports) <= WORK, "room to work in");
    for (size_t i = 0; i < WORK; i++) {
        m->work[i] = NAN; /* what a caller hands over is anything */
    }
    return aoi_body_start_modal(&m->body, &m->modal, rule, &begin, m->work);
}

/* The star of three oscillators and its natural modes, under a force, gravity and Rayleigh's damping:
 * in exact arithmetic the rule does not depend on the coordinates. */
static void a_star_and_its_modes_are_one_body(double k0, aoi_rule rule, aoi_rayleigh damping)
{
    static modes m;
    const double mass[] = {0.1, 0.02, 0.3}, k[] = {1e8, 6e7, 4e9};
    const aoi_star star = {3, 0.05, k0, mass, k};
    double omega2[4], r[4], spare[3], work[32], g[] = {3.0, -2.0, 1.0, 5.0};
    double rest[4] = {0.0}, moving[] = {1.0, 1.0, 1.0, 1.0}, centre[] = {0.05, 0.1, 0.02, 0.3};
    size_t count;
    aoi_body body;
    const aoi_body_start begin = {rest, moving, centre, g, NULL};
    CHECK(aoi_body_start_star(&body, &star, &damping, &rule, &begin, work) == AOI_OK, "a star");
    CHECK(aoi_star_to_modal(&star, omega2, r, &count, spare, NULL) == AOI_OK && count == 4, "its modes");
    memset(&m, 0, sizeof m);
    for (size_t j = 0; j < 4; j++) {
        double total = 0.0;
        m.omega[j] = sqrt(omega2[j]);
        m.decay[j] = 0.5 * (damping.alpha + damping.beta * omega2[j]);
        m.participation[j] = r[j];
        for (size_t i = 0; i <= 3; i++) { /* the mode's shape on coordinate i */
            const double shape =
                i == 0 ? r[j] : r[j] * (k[i - 1] / mass[i - 1]) /
                                    (k[i - 1] / mass[i - 1] - omega2[j]);
            total += (i == 0 ? star.m0 : mass[i - 1]) * shape;
            m.gravity[j] += shape * g[i];
            m.centre[j] += shape * centre[i];
        }
        m.v[j] = total;
    }
    set_modal(&m, 4, 1, 0);
    CHECK(modes_start(&m, &rule, 1) == AOI_OK, "they start");
    CHECK(near(*m.body.compliance, *body.compliance, 1e-12) &&
              near(*m.body.rate_compliance, *body.rate_compliance, 1e-12),
          "one compliance");
    const double push = 1e3;
    CHECK(body.begin(&body, &push) == AOI_OK && m.body.begin(&m.body, &push) == AOI_OK, "begin");
    double worst = 0.0, size = 0.0;
    for (int j = 1; j <= 500; j++) {
        const double force = 1e3 * cos(0.03 * j);
        CHECK(step_with(&body, force) == AOI_OK && step_with(&m.body, force) == AOI_OK, "a step");
        const observation a = observe(&body), b = observe(&m.body);
        const double energy = a.kinetic + a.elastic + a.dissipated;
        size = fmax(size, fabs(a.displacement));
        worst = fmax(worst, fabs(a.displacement - b.displacement));
        worst = fmax(worst, fabs(a.centre_displacement - b.centre_displacement));
        CHECK(fabs(a.velocity - b.velocity) < 1e-8, "velocity");
        CHECK(fabs(a.kinetic - b.kinetic) + fabs(a.elastic - b.elastic) +
                      fabs(a.dissipated - b.dissipated) + fabs(a.work - b.work) <
                  1e-8 * energy,
              "the ledgers differ at step %d", j);
    }
    CHECK(worst < 1e-10 * size, "k0 %g: off by %g of %g", k0, worst, size);
}

/* A force on one port moves the other as the other's would move the first, and by the compliance. */
static void ports_are_reciprocal(void)
{
    static modes m;
    uint64_t seed = 3;
    modes_random(&m, MOST, PORTS, &seed);
    m.residual[0] = 3e-9;
    m.residual[1] = m.residual[2] = 1e-9;
    m.residual[3] = 2e-9;
    CHECK(modes_start(&m, &AVERAGE, 1) == AOI_OK, "two ports");
    const double none[PORTS] = {0.0};
    CHECK(m.body.begin(&m.body, none) == AOI_OK, "begin");
    CHECK(near(m.body.compliance[1], m.body.compliance[2], 1e-14), "reciprocal");
    for (int j = 0; j < 50; j++) {
        const double force[PORTS] = {1e3 * uniform(&seed), -1e3 * uniform(&seed)};
        double u[PORTS], v[PORTS], row[AOI_BODY_ROWS + AOI_PORT_ROWS * PORTS];
        CHECK(m.body.predict(&m.body, u, v) == AOI_OK, "predict");
        m.body.correct(&m.body, force);
        m.body.observe(&m.body, 1, row, 1);
        for (size_t p = 0; p < PORTS; p++) {
            const double *c = m.body.compliance + PORTS * p;
            const double *rate = m.body.rate_compliance + PORTS * p;
            const double wanted = u[p] + c[0] * force[0] + c[1] * force[1];
            CHECK(fabs(row[AOI_BODY_ROWS + 2 * p] - wanted) < 1e-12 * (fabs(u[p]) + 1e-6),
                  "port %zu at %g, not %g", p, row[AOI_BODY_ROWS + 2 * p], wanted);
            CHECK(near(row[AOI_BODY_ROWS + 2 * p + 1],
                       v[p] + rate[0] * force[0] + rate[1] * force[1], 1e-10),
                  "its velocity");
        }
    }
}

/* Energy put in by forces on both ports and by gravity is in motion, strain or lost, to rounding. */
static void the_ledger_closes(void)
{
    static modes m;
    uint64_t seed = 9;
    double before[PORTS] = {0.0, 0.0}, row[AOI_BODY_ROWS + AOI_PORT_ROWS * PORTS];
    double last[AOI_BODY_ROWS + AOI_PORT_ROWS * PORTS], work = 0.0, worst = 0.0;
    modes_random(&m, MOST, PORTS, &seed);
    m.residual[0] = m.residual[3] = 2e-9;
    CHECK(modes_start(&m, &AVERAGE, 1) == AOI_OK, "start");
    m.body.observe(&m.body, 1, last, 1);
    CHECK(near(last[AOI_BODY_ROWS], aoi_vector_dot(MOST, m.participation, m.u), 1e-12),
          "nothing has bent it before a force is there");
    CHECK(m.body.begin(&m.body, before) == AOI_OK, "go");
    m.body.observe(&m.body, 1, last, 1);
    const double start = last[AOI_BODY_KINETIC] + last[AOI_BODY_ELASTIC] - last[AOI_BODY_WORK];
    for (int j = 1; j <= 2000; j++) {
        const double force[PORTS] = {1e3 * cos(0.01 * j), -500.0 * cos(0.02 * j)};
        double u[PORTS], v[PORTS];
        CHECK(m.body.predict(&m.body, u, v) == AOI_OK, "predict");
        m.body.correct(&m.body, force);
        m.body.observe(&m.body, 1, row, 1);
        for (size_t p = 0; p < PORTS; p++) {
            const size_t at = AOI_BODY_ROWS + AOI_PORT_ROWS * p;
            work += 0.5 * (force[p] + before[p]) * (row[at] - last[at]);
        }
        memcpy(before, force, sizeof force);
        memcpy(last, row, sizeof row);
        const double now = row[AOI_BODY_KINETIC] + row[AOI_BODY_ELASTIC] +
                           row[AOI_BODY_DISSIPATED] - row[AOI_BODY_WORK];
        worst = fmax(worst, fabs(now - work - start) / (fabs(work) + start));
    }
    CHECK(worst < 1e-12, "off by %g", worst);
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
        set_modal(&m, 1, 1, 0);
        CHECK(modes_start(&m, &rule, 0) == AOI_OK && begin_freely(&m.body) == AOI_OK, "a mode");
        for (int j = 1; j <= steps; j++) {
            CHECK(step_with(&m.body, slope * rule.dt * j) == AOI_OK, "a step");
        }
        const double fast = sqrt(w * w - s * s), decayed = exp(-s * duration);
        const double late = slope / (w * w) * (duration - 2.0 * s / (w * w));
        const double swing = slope / (w * w) * 2.0 * s / (w * w);
        const double rate = (slope / (w * w) - s * swing) / fast;
        const double exact =
            late + decayed * (swing * cos(fast * duration) - rate * sin(fast * duration));
        error[level] = observe(&m.body).displacement - exact;
    }
    CHECK(fabs(error[0] / error[1] - 4.0) < 0.1 && fabs(error[1] / error[2] - 4.0) < 0.05,
          "halving dt quarters the error: %g, %g, %g", error[0], error[1], error[2]);
}

/* The receptance of a damped oscillator, and what becomes of it without damping. */
static void receptance_is_the_oscillators(void)
{
    const double omega = 300.0, decay[] = {40.0, 0.0}, weight = 2.0, residual = 1e-7;
    const double at[] = {0.0, 100.0, 300.0, 1e4};
    for (size_t i = 0; i < 4; i++) {
        const double w = at[i], d = 2.0 * decay[0] * w, k = omega * omega - w * w;
        double re, im;
        aoi_modal_receptance(1, &omega, decay, &weight, residual, 1, &w, &re, &im);
        CHECK(near(re, residual + weight * k / (k * k + d * d), 1e-13), "real part at %g", w);
        CHECK(near(im, -weight * d / (k * k + d * d), 1e-13), "imaginary part at %g", w);
    }
    double re, im;
    aoi_modal_receptance(1, &omega, decay + 1, &weight, 0.0, 1, &at[2], &re, &im);
    CHECK(isinf(re) && im == 0.0, "infinite on an undamped resonance");
}

static void what_cannot_be_is_refused(void)
{
    static modes m;
    uint64_t seed = 5;
    modes_random(&m, 3, 1, &seed);
    m.decay[1] = -1.0;
    CHECK(modes_start(&m, &AVERAGE, 0) == AOI_ERROR_ARGUMENT, "negative damping");
    modes_random(&m, 3, 1, &seed);
    m.omega[2] = (double)NAN;
    CHECK(modes_start(&m, &AVERAGE, 0) == AOI_ERROR_ARGUMENT, "a frequency of NaN");
    modes_random(&m, 3, 1, &seed);
    m.participation[1] = (double)INFINITY;
    CHECK(modes_start(&m, &AVERAGE, 0) == AOI_ERROR_NOT_FINITE, "infinite participation");
    modes_random(&m, 3, 1, &seed);
    CHECK(modes_start(&m, &(aoi_rule){0.0, 0.25, 0.5}, 0) == AOI_ERROR_ARGUMENT, "no step");
    m.modal.ports = 0;
    CHECK(modes_start(&m, &AVERAGE, 0) == AOI_ERROR_ARGUMENT, "no port");
}

/* u = R f before the first step, under the forces that the body starts with. */
static void what_presses_at_the_start_has_bent_the_residual(void)
{
    static modes m;
    const double f[] = {100.0, -40.0, 2e6, -3e6}, none[PORTS] = {0.0, 0.0}; /* N, then N/s */
    double row[AOI_BODY_ROWS + PORTS * AOI_PORT_ROWS];
    memset(&m, 0, sizeof m);
    m.residual[0] = 3e-7;
    m.residual[1] = m.residual[2] = 1e-7;
    m.residual[3] = 2e-7;
    set_modal(&m, 1, PORTS, 1);
    const aoi_body_start begin = {m.u, m.v, NULL, NULL, f};
    CHECK(aoi_body_start_modal(&m.body, &m.modal, &AVERAGE, &begin, m.work) == AOI_OK, "starts");
    m.body.observe(&m.body, 0, row, 1);
    for (size_t p = 0; p < PORTS; p++) {
        const double wanted = m.residual[2 * p] * f[0] + m.residual[2 * p + 1] * f[1];
        CHECK(near(row[AOI_BODY_ROWS + AOI_PORT_ROWS * p], wanted, 1e-15), "port %zu", p);
        const double rate = m.residual[2 * p] * f[2] + m.residual[2 * p + 1] * f[3];
        CHECK(near(row[AOI_BODY_ROWS + AOI_PORT_ROWS * p + 1], rate, 1e-9), "rate of port %zu", p);
    }
    CHECK(m.body.begin(&m.body, none) == AOI_OK, "begins");
    const double place = row[AOI_BODY_ROWS];
    m.body.observe(&m.body, 0, row, 1);
    CHECK(row[AOI_BODY_ROWS] == place, "it is where the state says, whatever the forces are now");
}

int main(void)
{
    const aoi_rule rules[] = {{1e-6, 0.25, 0.5}, {3e-6, 0.3025, 0.6}};
    for (size_t i = 0; i < 2; i++) {
        a_star_and_its_modes_are_one_body(0.0, rules[i], (aoi_rayleigh){0.0, 0.0});
        a_star_and_its_modes_are_one_body(0.0, rules[i], (aoi_rayleigh){100.0, 1e-7});
        a_star_and_its_modes_are_one_body(1e7, rules[i], (aoi_rayleigh){0.0, 1e-6});
    }
    ports_are_reciprocal();
    the_ledger_closes();
    a_ramp_is_followed_to_second_order();
    receptance_is_the_oscillators();
    what_presses_at_the_start_has_bent_the_residual();
    what_cannot_be_is_refused();
    return check_report();
}
