/* Bodies that rub, in fixed steps: balls with spin on a wall, blocks on slopes, several contacts at once; against closed
 * forms, Maw's curve and what motion keeps. */
#include "rub.h"

static aoi_rule steps_of(double dt) { return (aoi_rule){dt, 0.25, 0.5}; }

static double row_at(const world *w, size_t row) { return w->record[row * w->columns + w->at]; }

static void run(world *w, size_t columns)
{
    while (w->at + 1 < columns && step_on(w) == AOI_OK) {
    }
    CHECK(w->at + 1 == columns, "%zu steps", w->at);
}

/* The ball's contact point along t1 after an impact with psi, in units of mu v E/G, before it (Maw, Barber and Fawcett). */
static double psi_after(double psi, size_t steps, pair *p)
{
    const double mu = 0.1, unit = mu * FAST / RATIO, velocity[3] = {FAST, psi * unit * 0.6, psi * unit * 0.8};
    const double dt = 1.1 * hertz_time(MASS, K, FAST) / (double)steps;
    rub(p, "hertz", K, mu);
    meet_wall(p, RADIUS, velocity, NULL);
    CHECK(world_start(&p->w, steps_of(dt), steps + 1, NULL) == AOI_OK, "it starts");
    run(&p->w, steps + 1);
    const aoi_progress end = aoi_newmark_progress(p->w.run);
    const double t1 = end.v[1] + RADIUS * end.v[3], t2 = end.v[2] + RADIUS * end.v[4];
    CHECK(fabs(0.8 * t1 - 0.6 * t2) < 1e-9 * FAST, "along the line of the motion");
    CHECK(fabs(end.v[1] - 0.4 * RADIUS * end.v[3] - 0.6 * psi * unit) < 1e-12 * FAST, "angular momentum about the point");
    return (0.6 * t1 + 0.8 * t2) / unit;
}

/* Rings on a half-space, extrapolated (tests/maw.py), of nu = 0.3: chi = 1.75 ratio = 1.441. Beyond 4 chi all slips. */
static void balls_rebound_as_maws(void)
{
    pair p;
    const double chi = 1.75 * RATIO;
    const double before[] = {0.2, 1.0, 1.5, 3.0, 4.5}, after[] = {0.0362, -0.0597, -0.4281, -1.3798, -1.2178};
    for (size_t i = 0; i < 5; i++) {
        const double found = psi_after(before[i], 400, &p);
        CHECK(fabs(found - after[i]) < 2e-3 * fmax(1.0, before[i]), "psi %g: %.5f, not %.5f", before[i], found, after[i]);
        drop();
    }
    for (size_t i = 0; i < 2; i++) {
        const double psi = i ? 5.0 * chi : 9.0 * chi, found = psi_after(psi, 12800, &p);
        CHECK(fabs(found - (psi - 4.0 * chi)) < 1e-6 * psi, "gross slip: %.9f, not %.9f", found, psi - 4.0 * chi);
        drop();
    }
}

/* Error of energy and the order at which it goes; momentum along and about is kept by two balls. */
static void what_motion_keeps(void)
{
    const double one[3] = {1.5, 0.6, -0.3}, other[3] = {-0.5, 0.1, 0.2};
    double last = 0.0;
    for (size_t i = 0; i < 3; i++) {
        const size_t steps = (size_t)400 << (2 * i);
        pair p;
        rub(&p, "hertz", K, 0.3);
        const size_t first = add_ball(&p.w, RADIUS, one, NULL);
        join(&p, first, add_ball(&p.w, -RADIUS, other, NULL));
        CHECK(world_start(&p.w, steps_of(1.1 * hertz_time(0.5 * MASS, K, FAST) / (double)steps), steps + 1, NULL) == AOI_OK, "start");
        const double before = energy_of(&p.w, p.w.record + p.w.at, p.w.columns);
        run(&p.w, steps + 1);
        const aoi_progress end = aoi_newmark_progress(p.w.run);
        const double *a = end.v, *b = end.v + 5, error = fabs(energy_of(&p.w, p.w.record + p.w.at, p.w.columns) - before) / before;
        for (size_t j = 0; j < 3; j++) {
            CHECK(fabs(a[j] + b[j] - one[j] - other[j]) < 1e-9, "momentum %zu", j);
        }
        for (size_t j = 1; j < 3; j++) { /* about the contact point: the orbital and both spins */
            CHECK(fabs(a[j] - one[j] - 0.4 * RADIUS * a[j + 2]) < 1e-9, "angular momentum of the first");
            CHECK(fabs(b[j] - other[j] + 0.4 * RADIUS * b[j + 2]) < 1e-9, "and of the second");
        }
        CHECK(i == 0 || error < last / 8.0 || error < 1e-9, "energy: %g after %g", error, last);
        CHECK(row_at(&p.w, AOI_CONTACT_FRICTION) > 0.01 * before, "friction takes energy");
        last = error;
        drop();
    }
    CHECK(last < 1e-5, "energy is off by %g", last);
}

/* Started at rest with its stretched spring, a block below the angle of friction stays, wherever it touches; above it,
 * it slides down. */
static void blocks_rest_on_slopes(void)
{
    for (int slips = 0; slips < 2; slips++) {
        const double mu = 0.3, down[3] = {10.0, (slips ? 1.5 : 0.9) * mu * 10.0, 0.0}, still[3] = {0.0, 0.0, 0.0};
        const double k = 1e6, dt = 1e-5;
        pair p;
        rub(&p, "linear", k, mu);
        meet_wall(&p, 0.0, still, down);
        p.w.contact[0].gap = 1e-4;
        p.w.x[0][0] = p.w.contact[0].gap + MASS * down[0] / k;
        p.w.x[0][1] = slips ? 0.0 : MASS * down[1] / (RATIO * k);
        CHECK(world_start(&p.w, steps_of(dt), 2001, NULL) == AOI_OK, "start");
        run(&p.w, 2001);
        const aoi_progress end = aoi_newmark_progress(p.w.run);
        if (slips) {
            const double gained = end.v[1] - row_of_body(&p.w, 0, AOI_BODY_ROWS + AOI_PORT_ROWS + 1)[1000];
            CHECK(near(gained, (down[1] - mu * down[0]) * 1000 * dt, 1e-6), "slides: %g", gained);
        } else {
            CHECK(fabs(end.v[1]) < 1e-12 && near(row_at(&p.w, AOI_CONTACT_TANGENTIAL), MASS * down[1], 1e-9), "rests");
            CHECK(row_at(&p.w, AOI_CONTACT_STUCK) == 1.0 && fabs(row_at(&p.w, AOI_CONTACT_FRICTION)) < 1e-15, "sticks");
        }
        drop();
    }
}

/* Two contacts side by side on one body, each on a soft place of its own, are one of twice the stiffness and half the
 * compliance. */
static void two_contacts_share_a_body(void)
{
    const double velocity[3] = {FAST, 0.5, 0.2}, dt = 1e-7, c = 0.2 / (K * sqrt(1e-4));
    double end[2][3], soft[2][9];
    for (size_t i = 0; i < 9; i++) { /* its directions are coupled */
        soft[1][i] = c * (i % 4 == 0 ? 1.0 : i % 2 == 1 ? 0.3 : 0.1);
        soft[0][i] = 0.5 * soft[1][i];
    }
    for (size_t twice = 0; twice < 2; twice++) {
        pair p;
        rub(&p, "hertz", twice ? K : 2.0 * K, 0.2);
        const size_t ball = add_ball(&p.w, 0.0, velocity, NULL);
        join(&p, ball, add_wall(&p.w));
        if (twice) { /* on the same place of the same body */
            join(&p, ball, add_wall(&p.w));
        }
        for (size_t b = 1; b <= 1 + twice; b++) {
            p.w.body[b].residual = soft[twice];
        }
        CHECK(world_start(&p.w, steps_of(dt), 2001, NULL) == AOI_OK, "start");
        run(&p.w, 2001);
        memcpy(end[twice], aoi_newmark_progress(p.w.run).v, sizeof end[twice]);
        drop();
    }
    for (size_t j = 0; j < 3; j++) {
        CHECK(near(end[1][j], end[0][j], 1e-9), "velocity %zu: %.15g, not %.15g", j, end[1][j], end[0][j]);
    }
}

/* A compliance taken out is one that a body does not have: a residual of it at the ports, taken out again, is nothing. */
static void what_is_taken_out_is_not_there(void)
{
    const double velocity[3] = {FAST, 0.5, 0.2}, c = 0.2 / (K * sqrt(1e-4)), out[9] = {c, 0.1 * c, 0, 0.1 * c, c, 0, 0, 0, c};
    double end[2][3], stored[2], seen[3];
    for (size_t given = 0; given < 2; given++) {
        pair p;
        rub(&p, "hertz", K, 0.2);
        meet_wall(&p, RADIUS, velocity, NULL);
        if (given) {
            p.law.compliance = c;
            p.w.contact[0].compliance = out;
            p.w.body[1].residual = out;
        }
        CHECK(world_start(&p.w, steps_of(1e-7), 1001, NULL) == AOI_OK, "start");
        run(&p.w, 301);
        const size_t wall = aoi_record_body(&p.w.system, 1);
        for (size_t i = 0; i < 3; i++) {
            seen[i] = row_at(&p.w, i < 2 ? i : AOI_CONTACT_TANGENTIAL);
        }
        stored[given] = row_at(&p.w, AOI_CONTACT_ELASTIC) + row_at(&p.w, wall + AOI_BODY_ELASTIC);
        run(&p.w, 1001);
        memcpy(end[given], aoi_newmark_progress(p.w.run).v, sizeof end[given]);
        drop();
    }
    CHECK(near(seen[0], K * pow(seen[1] + c * seen[0] + 0.1 * c * seen[2], 1.5), 1e-12), "the law's own indentation");
    CHECK(near(stored[1], stored[0], 1e-10), "energy stored: %g and %g", stored[1], stored[0]);
    for (size_t j = 0; j < 3; j++) {
        CHECK(near(end[1][j], end[0][j], 1e-9), "velocity %zu: %.15g, not %.15g", j, end[1][j], end[0][j]);
    }
}

static void what_cannot_rub_is_refused(void)
{
    const double velocity[3] = {FAST, 0.0, 0.0}, wrong[9] = {1e-9}, nan[9] = {0.0, (double)NAN};
    pair p;
    rub(&p, "hertz", K, 0.2);
    meet_wall(&p, RADIUS, velocity, NULL);
    p.w.contact[0].port[0] = 1;
    CHECK(world_start(&p.w, steps_of(1e-7), 2, NULL) == AOI_ERROR_ARGUMENT, "a port short");
    p.w.contact[0].port[0] = 0;
    p.w.contact[0].compliance = wrong;
    CHECK(world_start(&p.w, steps_of(1e-7), 2, NULL) == AOI_ERROR_ARGUMENT, "another compliance than the law's");
    p.w.contact[0].compliance = nan;
    CHECK(world_start(&p.w, steps_of(1e-7), 2, NULL) == AOI_ERROR_ARGUMENT, "a compliance that is no number");
    p.w.contact[0].compliance = NULL;
    CHECK(world_start(&p.w, steps_of(1e-7), 2, NULL) == AOI_OK, "a sound one");
    CHECK(aoi_record_rows(&p.w.system) == AOI_FRICTION_ROWS + 2 * (AOI_BODY_ROWS + 3 * AOI_PORT_ROWS), "rows");
    drop();
}

int main(void)
{
    balls_rebound_as_maws();
    what_motion_keeps();
    blocks_rest_on_slopes();
    two_contacts_share_a_body();
    what_is_taken_out_is_not_there();
    what_cannot_rub_is_refused();
    return check_report();
}
