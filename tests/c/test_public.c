/* The public header by itself: an AO model as a body in modes, both integrators on one system, intervals of
 * contact. */
#include "aoimpact.h"
#include "check.h"

#include <stdlib.h>
#include <string.h>

enum { SPRINGS = 3, ROWS = 400, STEPS = 20000 };

/* At an angular frequency: what the star's coordinates do under a unit force, and what its modes say. */
static void star_is_its_modes_at(const aoi_star *star, const aoi_modes *body, double w)
{
    double receptance, momentum, by_modes = 0.0, centre = 0.0;
    aoi_star_receptance(star, 1, &w, &receptance);
    momentum = star->m0 * receptance;
    for (size_t i = 0; i < star->n; i++) {
        const double own = star->k[i] / star->m[i];
        momentum += star->m[i] * receptance * own / (own - w * w);
    }
    for (size_t j = 0; j < body->n; j++) {
        const double swing = body->push[j] / (body->omega[j] * body->omega[j] - w * w);
        by_modes += body->shape[j] * swing;
        centre += body->centre[j] * swing;
    }
    by_modes += body->residual ? body->residual[0] : 0.0;
    CHECK(near(by_modes, receptance, 1e-9), "w %g: %g, not %g", w, by_modes, receptance);
    CHECK(near(centre * aoi_star_static_mass(star), momentum, 1e-8), "w %g: centre of mass", w);
}

static void a_star_is_a_body_in_its_modes(void)
{
    const double m[SPRINGS] = {0.5, 0.2, 0.1}, k[SPRINGS] = {1e4, 4e4, 1e5};
    for (int i = 0; i < 4; i++) {
        const aoi_star star = {SPRINGS, i % 2 ? 0.3 : 0.0, i / 2 ? 2e4 : 0.0, m, k};
        void *memory = malloc(aoi_star_modes_size(&star));
        aoi_modes body;
        CHECK(aoi_star_modes(&star, memory, &body) == AOI_OK, "star %d", i);
        CHECK(body.n == (i % 2 ? SPRINGS + 1 : SPRINGS) && body.ports == 1, "star %d: its modes", i);
        for (double w = 37.0; w < 2000.0; w *= 1.7) {
            star_is_its_modes_at(&star, &body, w);
        }
        free(memory);
    }
    const aoi_star nothing = {0, 0.0, 0.0, NULL, NULL}, hollow = {2, 1.0, 0.0, m, NULL};
    CHECK(aoi_star_check(&hollow) == AOI_ERROR_ARGUMENT, "oscillators without springs");
    double room[20];
    aoi_modes body;
    CHECK(aoi_star_modes_size(&nothing) <= sizeof room, "room for it");
    CHECK(aoi_star_modes(&nothing, room, &body) != AOI_OK, "no mass at all");
}

/* A ball (not mass-normalised), pushed and under gravity, over a damped oscillator that is constrained. */
typedef struct drop {
    double zero, shape, mobility, mass, gravity, omega, decay, time[3], force[3], v[2];
    aoi_modes body[2];
    aoi_law law;
    aoi_contact contact;
    size_t links[20];
    aoi_system system;
    aoi_start start;
} drop;

static void make_drop(drop *d, double decay, double rise)
{
    const double k = 1e6;
    *d = (drop){.shape = 1.0, .mobility = 2.0, .mass = 0.5, .gravity = 9.81, .omega = 900.0, .decay = decay,
                .time = {0.0, 0.01, 0.02}, .force = {0.0, rise, 0.0}, .v = {1.0, 0.0}};
    const aoi_modes ball = {.n = 1, .ports = 1, .omega = &d->zero, .shape = &d->shape, .push = &d->mobility,
                            .gravity = &d->gravity, .inertia = &d->mass, .centre = &d->shape,
                            .load = {3, d->time, d->force}};
    const aoi_modes spring = {.n = 1, .ports = 1, .omega = &d->omega, .decay = &d->decay, .shape = &d->shape,
                              .push = &d->shape, .centre = &d->shape};
    d->body[0] = ball;
    d->body[1] = spring;
    CHECK(aoi_law_create(&d->law, "linear", 1, &k) == AOI_OK, "law");
    d->contact = (aoi_contact){{0, 1}, {0, 0}, 1e-3, &d->law, NULL, NULL};
    d->system = (aoi_system){.body_count = 2, .contact_count = 1, .body = d->body, .contact = &d->contact};
    d->start = (aoi_start){.v = d->v};
    CHECK(aoi_system_size(&d->system) <= sizeof d->links, "room");
    CHECK(aoi_system_link(&d->system, d->links) == AOI_OK, "linked");
}

/* The last column of a run by Newmark's rule; the work on both bodies and what they and the law hold balance. */
static void newmark_column(const drop *d, double end, double *column)
{
    const aoi_system *system = &d->system;
    const aoi_rule rule = {end / STEPS, 0.25, 0.5};
    const size_t rows = aoi_record_rows(system), columns = STEPS + 1;
    double *record = malloc(rows * columns * sizeof(double));
    aoi_newmark *run = malloc(aoi_newmark_size(system));
    size_t done = 0;
    memset(run, 0xA5, aoi_newmark_size(system));
    CHECK(aoi_newmark_start(run, system, &rule, &d->start, 1, record, columns) == AOI_OK, "it starts");
    for (size_t last = 0; last < columns; last += STEPS / 4) {
        CHECK(aoi_newmark_run(run, last, &done) == AOI_OK && done == last, "in four parts");
    }
    done = 0;
    CHECK(aoi_newmark_run(run, columns, &done) == AOI_ERROR_ARGUMENT && done == STEPS, "no further than the record");
    for (size_t i = 0; i < rows; i++) {
        column[i] = record[i * columns + STEPS];
    }
    free(record);
    free(run);
}

static void adaptive_column(const drop *d, double end, double *column)
{
    double values[ROWS * 60];
    size_t row[ROWS];
    aoi_track track = {.values = values, .row = row, .capacity = ROWS * 60, .row_capacity = ROWS};
    aoi_adaptive *run = malloc(aoi_adaptive_size(&d->system));
    aoi_sampler *sampler = malloc(aoi_sampler_size(&d->system));
    memset(run, 0xA5, aoi_adaptive_size(&d->system));
    CHECK(aoi_adaptive_start(run, &d->system, &d->start, 1e-9, end) == AOI_OK, "it starts");
    CHECK(aoi_adaptive_finish(run, &track) == AOI_OK, "it runs");
    CHECK(aoi_adaptive_progress(run).time == end, "to its end");
    CHECK(aoi_sampler_start(sampler, &d->system, &track) == AOI_OK, "it is read");
    aoi_sampler_column(sampler, end, 1, column, 1);
    free(run);
    free(sampler);
}

static double energy_of(const double *column)
{
    double sum = column[AOI_CONTACT_ELASTIC] + column[AOI_CONTACT_DISSIPATED];
    for (size_t b = 0; b < 2; b++) {
        const double *body = column + AOI_CONTACT_ROWS + b * (AOI_BODY_ROWS + AOI_PORT_ROWS);
        sum += body[AOI_BODY_KINETIC] + body[AOI_BODY_ELASTIC] + body[AOI_BODY_DISSIPATED] - body[AOI_BODY_WORK];
    }
    return sum;
}

static void both_integrators_move_one_system_alike(void)
{
    const double end = 0.02;
    double fixed[4 + 2 * 8], adaptive[4 + 2 * 8];
    drop d;
    make_drop(&d, 30.0, 200.0);
    CHECK(aoi_record_rows(&d.system) == sizeof fixed / sizeof fixed[0], "rows");
    newmark_column(&d, end, fixed);
    adaptive_column(&d, end, adaptive);
    CHECK(near(energy_of(fixed), 0.25, 1e-6) && near(energy_of(adaptive), 0.25, 1e-8), "m v^2 / 2: %.9g, %.9g",
          energy_of(fixed), energy_of(adaptive));
    for (size_t i = 0; i < sizeof fixed / sizeof fixed[0]; i++) {
        CHECK(fabs(fixed[i] - adaptive[i]) <= 1e-4 * fabs(adaptive[i]) + 1e-9, "row %zu: %g and %g", i, fixed[i],
              adaptive[i]);
    }
    CHECK(fabs(adaptive[AOI_CONTACT_ROWS + AOI_BODY_WORK]) > 0.01, "loads and gravity work");
}

/* A ball that bounces under gravity on a linear spring at rest: g downward is + here, and the wall is below. */
static void intervals_of_a_bouncing_ball(void)
{
    const double k = 1e6, g = 9.81, v = 1.0, m = 0.5, w = sqrt(k / m), flown = 2.0 * v / g;
    const double deflection = g / (w * w), swing = 2.0 * (PI - atan2(v / w, deflection)) / w; /* under gravity */
    double values[ROWS * 60];
    size_t row[ROWS];
    aoi_track track = {.values = values, .row = row, .capacity = ROWS * 60, .row_capacity = ROWS};
    drop d;
    make_drop(&d, 0.0, 0.0);
    d.mobility = 1.0 / m;
    d.contact.gap = 0.0;
    double still = 0.0;
    d.body[1].push = &still; /* a wall */
    d.body[1].omega = &still;
    const double end = 2.0 * (flown + swing) + 0.3 * swing;
    aoi_adaptive *run = malloc(aoi_adaptive_size(&d.system));
    CHECK(aoi_adaptive_start(run, &d.system, &d.start, 1e-9, end) == AOI_OK, "it starts");
    CHECK(aoi_adaptive_finish(run, &track) == AOI_OK, "it runs");
    aoi_interval work[1], found[4];
    CHECK(aoi_track_intervals(&d.system, &track, end, work, 0, NULL) == 3, "counted");
    CHECK(aoi_track_intervals(&d.system, &track, end, work, 4, found) == 3, "found");
    for (int i = 0; i < 3; i++) {
        const double start = i * (flown + swing), stop = i < 2 ? start + swing : end;
        CHECK(found[i].contact == 0 && found[i].lasts == (i == 2), "contact %d", i);
        CHECK(fabs(found[i].start - start) < 1e-8 && fabs(found[i].end - stop) < 1e-8, "%d: %.9g to %.9g", i,
              found[i].start, found[i].end);
        CHECK(near(found[i].rate, v, 1e-8), "%d: touches at %g m/s", i, found[i].rate);
        const double impulse = 2.0 * m * v + m * g * swing;
        CHECK(i == 2 || near(found[i].impulse, impulse, 1e-8), "%d: impulse %g", i, found[i].impulse);
        CHECK(near(found[i].pace, found[i].rate * (found[i].end - found[i].start) / found[i].deepest, 1e-14),
              "%d: pace", i);
        CHECK(found[i].deepest <= (deflection + hypot(deflection, v / w)) * (1.0 + 1e-9), "%d: depth", i);
    }
    CHECK(near(aoi_adaptive_peak(run, 0).force, k * (deflection + hypot(deflection, v / w)), 1e-8), "its peak");
    free(run);
}

/* Two bodies of 1 kg meet at 1 m/s, at once or after a flight; one may bend at once where it is touched, which takes
 * from the indentation's rate as soon as there is a force. */
static void a_contact_begins_at_the_rate_of_approach(void)
{
    const char *const laws[] = {"hertz", "linear", "tsuji", "kelvin_voigt"};
    const double k[] = {1e10, 100.0}, residual = 1e-9, gaps[] = {0.0, 1e-4};
    for (int i = 0; i < 16; i++) {
        double values[ROWS * 60];
        size_t row[ROWS];
        aoi_track track = {.values = values, .row = row, .capacity = ROWS * 60, .row_capacity = ROWS};
        aoi_interval work[1], found[1];
        drop d;
        make_drop(&d, 0.0, 0.0);
        d.mobility = 1.0;
        d.gravity = d.omega = 0.0;
        d.body[1].residual = i / 8 ? &residual : NULL;
        d.contact.gap = gaps[i / 4 % 2];
        CHECK(aoi_law_create(&d.law, laws[i % 4], 1 + (i % 4 > 1), k) == AOI_OK, "law");
        aoi_adaptive *run = malloc(aoi_adaptive_size(&d.system));
        CHECK(aoi_adaptive_start(run, &d.system, &d.start, 1e-8, 3e-4) == AOI_OK, "it starts");
        CHECK(aoi_adaptive_finish(run, &track) == AOI_OK, "it runs");
        CHECK(aoi_track_intervals(&d.system, &track, 3e-4, work, 1, found) == 1, "case %d: one contact", i);
        CHECK(near(found[0].rate, 1.0, 1e-14), "case %d: at %.17g m/s", i, found[0].rate);
        free(run);
    }
}

/* All its masses at V: of a free star the contact, of any the centre of mass. */
static void a_star_moves_as_a_whole(void)
{
    const double m[SPRINGS] = {0.5, 0.2, 0.1}, k[SPRINGS] = {1e4, 4e4, 1e5}, speed = 3.0;
    for (int i = 0; i < 4; i++) {
        const aoi_star star = {SPRINGS, i % 2 ? 0.3 : 0.0, i / 2 ? 2e4 : 0.0, m, k};
        void *memory = malloc(aoi_star_modes_size(&star));
        aoi_modes body;
        double contact = 0.0, centre = 0.0, twice_energy = 0.0;
        CHECK(aoi_star_modes(&star, memory, &body) == AOI_OK, "star %d", i);
        for (size_t j = 0; j < body.n; j++) {
            const double v = speed * aoi_star_static_mass(&star) * body.centre[j];
            contact += body.shape[j] * v;
            centre += body.centre[j] * v;
            twice_energy += v * v;
        }
        CHECK(near(centre, speed, 1e-12), "star %d: centre of mass at %g m/s", i, centre);
        CHECK(near(twice_energy, aoi_star_static_mass(&star) * speed * speed, 1e-12), "star %d: m V^2", i);
        CHECK(near(contact, speed, 1e-12) || (star.m0 == 0.0 && star.k0 > 0.0), "star %d: %g m/s", i, contact);
        free(memory);
    }
}

static void what_is_not_linked_is_refused(void)
{
    const double k = 1e6;
    double omega = 0.0, shape = 1.0;
    aoi_law law;
    CHECK(aoi_law_create(&law, "linear", 1, &k) == AOI_OK, "law");
    const aoi_modes ball = {.n = 1, .ports = 1, .omega = &omega, .shape = &shape, .push = &shape, .centre = &shape};
    const aoi_modes balls[] = {ball, ball};
    const aoi_contact wrong = {.body = {0, 5}, .law = &law};
    aoi_system system = {.body_count = 2, .contact_count = 1, .body = balls, .contact = &wrong};
    const aoi_rule rule = {1e-6, 0.25, 0.5};
    const aoi_start start = {.rested = 0};
    aoi_track track = {.capacity = 0};
    size_t links[20];
    double room[8];
    CHECK(aoi_system_size(&system) <= sizeof links, "room for links");
    CHECK(aoi_system_link(&system, links) == AOI_ERROR_ARGUMENT, "a body that is not there");
    CHECK(aoi_adaptive_size(&system) == 0 && aoi_adaptive_room(&system) == 0, "no adaptive run");
    CHECK(aoi_newmark_size(&system) == 0 && aoi_sampler_size(&system) == 0, "no fixed steps, no output");
    CHECK(aoi_record_rows(&system) == 0 && aoi_record_contact(&system, 1) == 0 && aoi_record_body(&system, 1) == 0,
          "no record");
    CHECK(aoi_adaptive_start((aoi_adaptive *)room, &system, &start, 1e-6, 1.0) == AOI_ERROR_ARGUMENT, "adaptive");
    CHECK(aoi_newmark_start((aoi_newmark *)room, &system, &rule, &start, 0, room, 8) == AOI_ERROR_ARGUMENT, "steps");
    CHECK(aoi_sampler_start((aoi_sampler *)room, &system, &track) == AOI_ERROR_ARGUMENT, "dense output");
    CHECK(aoi_track_check(&system, &track) == AOI_ERROR_ARGUMENT, "a track of it");
}

/* Both integrators refuse a start that is no number; fixed steps one at rest of a body that is bent at once, by forces
 * that only the other finds. */
static void starts_that_cannot_be(void)
{
    const double nan[2] = {0.0, (double)NAN}, residual = 1e-8;
    const aoi_start starts[] = {{.v = nan}, {.x = nan}};
    const aoi_rule rule = {1e-6, 0.25, 0.5};
    double record[20];
    drop d;
    make_drop(&d, 0.0, 0.0);
    void *fixed = malloc(aoi_newmark_size(&d.system)), *adaptive = malloc(aoi_adaptive_size(&d.system));
    for (int i = 0; i < 2; i++) {
        CHECK(aoi_newmark_start(fixed, &d.system, &rule, &starts[i], 0, record, 1) == AOI_ERROR_NOT_FINITE, "%d", i);
        CHECK(aoi_adaptive_start(adaptive, &d.system, &starts[i], 1e-6, 1.0) == AOI_ERROR_NOT_FINITE, "%d", i);
    }
    d.start.rested = 1;
    CHECK(aoi_newmark_start(fixed, &d.system, &rule, &d.start, 0, record, 1) == AOI_OK, "at rest, and not bent");
    d.body[1].residual = &residual;
    CHECK(aoi_newmark_start(fixed, &d.system, &rule, &d.start, 0, record, 1) == AOI_ERROR_ARGUMENT, "bent at rest");
    d.start.rested = 0;
    CHECK(aoi_newmark_start(fixed, &d.system, &rule, &d.start, 0, record, 1) == AOI_OK, "bent from now on");
    free(fixed);
    free(adaptive);
}

static void every_status_has_words_of_its_own(void)
{
    const char *unknown = aoi_status_text(-1);
    CHECK(strcmp(aoi_status_text(AOI_ERROR_SPRINGS + 1), unknown) == 0, "beyond the last");
    for (int a = AOI_OK; a <= AOI_ERROR_SPRINGS; a++) {
        CHECK(strcmp(aoi_status_text(a), unknown) != 0, "status %d", a);
        for (int b = AOI_OK; b < a; b++) {
            CHECK(strcmp(aoi_status_text(a), aoi_status_text(b)) != 0, "status %d as %d", a, b);
        }
    }
}

static double no_number(double indentation, double rate)
{
    return indentation > 1e-7 ? (double)NAN : 1e9 * indentation + 0.0 * rate;
}

/* Two balls, one with a law that gives no number, strike a third: Newmark's run says which, or none before. */
static void a_run_names_the_contact_that_failed(void)
{
    static const double zero = 0.0, tens[2] = {10.0, 10.0}, v[3] = {0.1, 0.0, 0.0}, k = 1e9;
    const aoi_modes ball = {.n = 1, .ports = 1, .omega = &zero, .shape = tens, .push = tens, .centre = tens};
    aoi_modes body[3] = {ball, ball, ball};
    const aoi_user_law user = {.function = {no_number}, .given = {1}};
    aoi_law law[2];
    body[0].ports = 2;
    CHECK(aoi_law_create(&law[0], "hertz", 1, &k) == AOI_OK && aoi_law_create_user(&law[1], &user, 0, 0) == AOI_OK, "laws");
    for (size_t failing = 0; failing < 2; failing++) {
        const aoi_contact contact[2] = {{{0, 1}, {0, 0}, 0.0, &law[failing == 0], NULL, NULL},
                                        {{0, 2}, {1, 0}, 0.0, &law[failing == 1], NULL, NULL}};
        aoi_system system = {.body_count = 3, .contact_count = 2, .body = body, .contact = contact};
        const aoi_start start = {.v = v};
        const aoi_rule rule = {1e-7, 0.25, 0.5};
        size_t links[40], done;
        double record[2000];
        CHECK(aoi_system_size(&system) <= sizeof links && aoi_system_link(&system, links) == AOI_OK, "linked");
        aoi_newmark *run = malloc(aoi_newmark_size(&system));
        CHECK(aoi_newmark_start(run, &system, &rule, &start, 0, record, 50) == AOI_OK, "it starts");
        CHECK(aoi_newmark_progress(run).failed == SIZE_MAX, "nothing has failed");
        CHECK(aoi_newmark_run(run, 49, &done) == AOI_ERROR_LAW && aoi_newmark_progress(run).failed == failing, "no number");
        free(run);
    }
}

/* The contact of a body that turns moves by v + omega x arm; its modes hold all of its kinetic energy. */
static void a_rigid_body_turns_about_its_centre(void)
{
    const aoi_rigid rigid = {0.3, {1e-4, 2e-4, 5e-4}, {0.02, -0.03, 0.07}};
    const double v[3] = {1.0, -2.0, 0.5}, w[3] = {30.0, -7.0, 11.0}, *r = rigid.arm;
    const double moved[3] = {v[0] + w[1] * r[2] - w[2] * r[1], v[1] + w[2] * r[0] - w[0] * r[2], v[2] + w[0] * r[1] - w[1] * r[0]};
    double memory[AOI_RIGID_ROOM];
    aoi_modes body;
    CHECK(aoi_rigid_modes(&rigid, memory, &body) == AOI_OK && body.n == 6 && body.ports == 3, "a body");
    for (size_t p = 0; p < 3; p++) {
        double sum = 0.0;
        for (size_t j = 0; j < 6; j++) {
            sum += body.shape[p * 6 + j] * (j < 3 ? v[j] : w[j - 3]);
            CHECK(near(body.push[p * 6 + j] * body.inertia[j], body.shape[p * 6 + j], 1e-15), "a force does its work");
        }
        CHECK(near(sum, moved[p], 1e-14), "port %zu: %g", p, sum);
    }
    const aoi_rigid wrong[] = {{-1.0, {1, 1, 1}, {0, 0, 0}}, {1.0, {1, 0, 1}, {0, 0, 0}}, {1.0, {1, 1, 1}, {0, HUGE_VAL, 0}}};
    for (size_t i = 0; i < 3; i++) {
        CHECK(aoi_rigid_modes(&wrong[i], memory, &body) == AOI_ERROR_ARGUMENT, "refused: %zu", i);
    }
}

/* Each port has the receptance of its own star, and none of another's force. */
static void three_stars_are_one_body(void)
{
    const double m[] = {0.4, 0.2, 0.1}, k[] = {2e6, 3e6, 8e6};
    const aoi_star star[3] = {{3, 0.1, 0.0, m, k}, {2, 0.3, 5e4, m, k}, {1, 0.0, 1e5, m, k}};
    void *memory = malloc(aoi_star_modes_of_three_size(star));
    aoi_modes body;
    CHECK(aoi_star_modes_of_three(star, memory, &body) == AOI_OK && body.ports == 3, "a body of %zu modes", body.n);
    for (size_t pair = 0; pair < 9; pair++) {
        const size_t p = pair / 3, q = pair % 3;
        const double at = 700.0;
        double found = body.residual[pair], wanted = 0.0;
        for (size_t j = 0; j < body.n; j++) {
            found += body.shape[p * body.n + j] * body.push[q * body.n + j] / (body.omega[j] * body.omega[j] - at * at);
            CHECK(j == 0 || body.omega[j] >= body.omega[j - 1], "frequencies ascend");
        }
        if (p == q) {
            aoi_star_receptance(&star[p], 1, &at, &wanted);
        }
        CHECK(p == q ? near(found, wanted, 1e-11) : found == 0.0, "ports %zu, %zu: %g, not %g", p, q, found, wanted);
    }
    free(memory);
}

static void *no_memory(void *memory, size_t bytes)
{
    (void)memory;
    return bytes > (size_t)1 << 20 ? NULL : realloc(memory, bytes);
}

static void a_track_grows_as_long_as_there_is_memory(void)
{
    aoi_track track = {.values = NULL};
    CHECK(strcmp(aoi_version(), AOI_VERSION) == 0, "the version is the header's");
    CHECK(aoi_track_grow(&track, 100, no_memory) == AOI_OK && track.capacity >= 100 && track.row_capacity > 0, "a first room");
    track.values[track.capacity - 1] = 7.0;
    while (aoi_track_grow(&track, 100, no_memory) == AOI_OK) {
    }
    const size_t capacity = track.capacity;
    CHECK(capacity > 1000 && capacity * sizeof(double) <= (size_t)1 << 20, "as far as there is memory");
    CHECK(aoi_track_grow(&track, 100, no_memory) == AOI_ERROR_TOO_LONG && track.capacity == capacity, "it stays as it is");
    track.values[capacity - 1] = 7.0;
    free(track.values);
    free(track.row);
}

int main(void)
{
    a_rigid_body_turns_about_its_centre();
    three_stars_are_one_body();
    a_track_grows_as_long_as_there_is_memory();
    a_run_names_the_contact_that_failed();
    a_star_moves_as_a_whole();
    what_is_not_linked_is_refused();
    starts_that_cannot_be();
    every_status_has_words_of_its_own();
    a_star_is_a_body_in_its_modes();
    both_integrators_move_one_system_alike();
    intervals_of_a_bouncing_ball();
    a_contact_begins_at_the_rate_of_approach();
    return check_report();
}
