/* Bodies that rub, to a tolerance: balls with spin and blocks, several contacts at once; against closed forms, Maw's curve,
 * what motion keeps, and fixed steps. */
#include "rub.h"

enum { TRACK = 400000, TRACK_ROWS = 4000 };

/* A run to its end, its track, and the record at its end. */
typedef struct outcome {
    aoi_adaptive *run;
    aoi_track track;
    aoi_sampler *sampler;
    aoi_progress end;
} outcome;

static int start(pair *p, double rtol, double end, outcome *o)
{
    memset(o, 0, sizeof *o);
    const int status = world_start(&p->w, (aoi_rule){end, 0.25, 0.5}, 1, NULL); /* which links the system */
    if (status != AOI_OK) {
        return status;
    }
    o->run = keep(aoi_adaptive_size(&p->w.system));
    o->track = (aoi_track){.values = keep(TRACK * sizeof(double)), .row = keep(TRACK_ROWS * sizeof(size_t)),
                           .capacity = TRACK, .row_capacity = TRACK_ROWS};
    return aoi_adaptive_start(o->run, &p->w.system, &p->w.start, rtol, end);
}

static outcome run(pair *p, double rtol, double end)
{
    outcome o;
    CHECK(start(p, rtol, end, &o) == AOI_OK, "it starts");
    const int status = aoi_adaptive_finish(o.run, &o.track);
    CHECK(status == AOI_OK, "rtol %g: %s at %g of %g", rtol, aoi_status_text(status), aoi_adaptive_progress(o.run).time, end);
    CHECK(aoi_track_check(&p->w.system, &o.track) == AOI_OK, "a sound track");
    o.end = aoi_adaptive_progress(o.run);
    o.sampler = keep(aoi_sampler_size(&p->w.system));
    CHECK(aoi_sampler_start(o.sampler, &p->w.system, &o.track) == AOI_OK, "dense output");
    return o;
}

/* How the same motion ends by Newmark's rule. */
static aoi_progress by_fixed_steps(pair *p, double end, size_t steps)
{
    CHECK(world_start(&p->w, (aoi_rule){end / (double)steps, 0.25, 0.5}, steps + 1, NULL) == AOI_OK, "fixed steps");
    while (p->w.at < steps && step_on(&p->w) == AOI_OK) {
    }
    return aoi_newmark_progress(p->w.run);
}

static double *column(pair *p, const outcome *o, double time)
{
    double *record = keep(aoi_record_rows(&p->w.system) * sizeof *record);
    aoi_sampler_column(o->sampler, time, 1, record, 1);
    return record;
}

/* The ball's contact point along its line after an impact with psi, in units of mu v E/G, before it. */
static double psi_after(double psi, double rtol)
{
    const double mu = 0.1, unit = mu * FAST / RATIO, velocity[3] = {FAST, psi * unit * 0.6, psi * unit * 0.8};
    pair p;
    rub(&p, "hertz", K, mu);
    meet_wall(&p, RADIUS, velocity, NULL);
    const outcome o = run(&p, rtol, 1.1 * hertz_time(MASS, K, FAST));
    const double t1 = o.end.v[1] + RADIUS * o.end.v[3], t2 = o.end.v[2] + RADIUS * o.end.v[4];
    CHECK(fabs(0.8 * t1 - 0.6 * t2) < 1e-12 * FAST, "along the line of the motion");
    CHECK(fabs(o.end.v[1] - 0.4 * RADIUS * o.end.v[3] - 0.6 * psi * unit) < 1e-14 * FAST, "angular momentum about the point");
    CHECK(near(o.end.v[0], -FAST, 1e-7), "normal restitution");
    drop();
    return (0.6 * t1 + 0.8 * t2) / unit;
}

/* Rings on a half-space, extrapolated (tests/maw.py), of nu = 0.3: chi = 1.75 ratio. Beyond 4 chi all slips, which is
 * exact. Between tolerances the change is below the larger one. */
static void balls_rebound_as_maws(void)
{
    const double chi = 1.75 * RATIO;
    const double before[] = {0.2, 1.0, 1.5, 3.0, 4.5}, after[] = {0.0362, -0.0597, -0.4281, -1.3798, -1.2178};
    for (size_t i = 0; i < 5; i++) {
        const double rough = psi_after(before[i], 1e-4), good = psi_after(before[i], 1e-6), best = psi_after(before[i], 1e-8);
        CHECK(fabs(best - after[i]) < 2e-3 * fmax(1.0, before[i]), "psi %g: %.5f, not %.5f", before[i], best, after[i]);
        CHECK(fabs(rough - best) < 1e-4 && fabs(good - best) < 1e-5, "psi %g: off by %g and %g", before[i], rough - best, good - best);
    }
    for (double psi = 4.01 * chi; psi < 30.0; psi *= 2.0) {
        const double found = psi_after(psi, 1e-8);
        CHECK(fabs(found - (psi - 4.0 * chi)) < 1e-9 * psi, "gross slip: %.12f, not %.12f", found, psi - 4.0 * chi);
    }
}

/* Two balls that turn: momentum along and about is kept to rounding, energy to the tolerance; friction only takes, also
 * between steps. Fixed steps agree. */
static void what_motion_keeps(void)
{
    const double one[3] = {1.5, 0.6, -0.3}, other[3] = {-0.5, 0.1, 0.2}, end = 1.1 * hertz_time(0.5 * MASS, K, FAST);
    pair p;
    rub(&p, "hertz", K, 0.3);
    const size_t first = add_ball(&p.w, RADIUS, one, NULL);
    join(&p, first, add_ball(&p.w, -RADIUS, other, NULL));
    const outcome o = run(&p, 1e-9, end);
    const double *a = o.end.v, *b = o.end.v + 5, before = energy_of(&p.w, column(&p, &o, 0.0), 1);
    for (size_t j = 0; j < 3; j++) {
        CHECK(fabs(a[j] + b[j] - one[j] - other[j]) < 1e-14, "momentum %zu", j);
    }
    for (size_t j = 1; j < 3; j++) { /* about the contact point: the orbital and both spins */
        CHECK(fabs(a[j] - one[j] - 0.4 * RADIUS * a[j + 2]) < 1e-14, "angular momentum of the first");
        CHECK(fabs(b[j] - other[j] + 0.4 * RADIUS * b[j + 2]) < 1e-14, "and of the second");
    }
    double taken = 0.0;
    for (size_t i = 0; i <= 400; i++) {
        const double *now = column(&p, &o, end * (double)i / 400.0);
        CHECK(fabs(energy_of(&p.w, now, 1) - before) < 1e-9 * before, "energy: %g at %zu", energy_of(&p.w, now, 1) / before - 1.0, i);
        CHECK(now[AOI_CONTACT_FRICTION] > taken - 1e-7 * before, "friction takes %g, then %g", taken, now[AOI_CONTACT_FRICTION]);
        CHECK(hypot(now[AOI_CONTACT_TANGENTIAL], now[AOI_CONTACT_TANGENTIAL + 1]) <= 0.3 * now[0] * (1.0 + 1e-6), "Coulomb");
        CHECK(now[AOI_CONTACT_STUCK] >= 0.0 && now[AOI_CONTACT_STUCK] <= 1.0, "a share");
        taken = fmax(taken, now[AOI_CONTACT_FRICTION]);
    }
    CHECK(taken > 0.01 * before, "friction takes energy");
    double v[10];
    memcpy(v, a, sizeof v);
    const aoi_progress fixed = by_fixed_steps(&p, end, 20000);
    for (size_t j = 0; j < 10; j++) {
        const double scale = j % 5 < 3 ? FAST : FAST / RADIUS;
        CHECK(fabs(fixed.v[j] - v[j]) < 2e-5 * scale, "fixed steps, %zu", j);
    }
    drop();
}

/* A block on a linear law, pressed by its weight, is kicked and slides to and fro until it sticks; its energy is closed, and
 * fixed steps agree. */
static void a_slider_comes_to_stick(void)
{
    const double down[3] = {400.0, 30.0, 20.0}, velocity[3] = {0.0, 0.4, -0.3}, end = 6e-3;
    pair p;
    rub(&p, "linear", 1e6, 0.2);
    meet_wall(&p, RADIUS, velocity, down);
    p.w.x[0][0] = MASS * down[0] / 1e6;
    const outcome o = run(&p, 1e-8, end);
    const double before = energy_of(&p.w, column(&p, &o, 0.0), 1);
    double x[2];
    memcpy(x, o.end.x + 1, sizeof x);
    for (size_t i = 0; i <= 300; i++) {
        const double *now = column(&p, &o, end * (double)i / 300.0);
        CHECK(fabs(energy_of(&p.w, now, 1) - before) < 1e-9 * before, "energy: %g at %zu", energy_of(&p.w, now, 1) / before - 1.0, i);
    }
    CHECK(column(&p, &o, end)[AOI_CONTACT_FRICTION] > 0.1 * before, "it slid");
    const aoi_progress fixed = by_fixed_steps(&p, end, 12000);
    const double *found = fixed.x + 1;
    CHECK(hypot(found[0] - x[0], found[1] - x[1]) < 1e-3 * hypot(x[0], x[1]), "fixed steps: %g %g, not %g %g", found[0], found[1],
          x[0], x[1]);
    drop();
}

/* Two contacts side by side on one body are one of twice the stiffness. */
static void two_contacts_share_a_body(void)
{
    const double velocity[3] = {FAST, 0.5, 0.2};
    double end[2][5];
    for (size_t twice = 0; twice < 2; twice++) {
        pair p;
        rub(&p, "hertz", twice ? K : 2.0 * K, 0.2);
        const size_t ball = add_ball(&p.w, RADIUS, velocity, NULL);
        for (size_t i = 0; i <= twice; i++) {
            join(&p, ball, add_wall(&p.w));
        }
        memcpy(end[twice], run(&p, 1e-7, 1.2 * hertz_time(MASS, 2.0 * K, FAST)).end.v, sizeof end[twice]);
        drop();
    }
    for (size_t j = 0; j < 5; j++) {
        CHECK(fabs(end[1][j] - end[0][j]) < 1e-6 * (j < 3 ? FAST : FAST / RADIUS), "velocity %zu: %.15g, not %.15g", j, end[1][j],
              end[0][j]);
    }
}

/* A compliance that is taken out, with couplings: as by fixed steps, and energy is kept with it. */
static void what_is_taken_out(void)
{
    const double velocity[3] = {FAST, 0.5, 0.2}, c = 0.2 / (K * sqrt(1e-4));
    const double out[9] = {c, 0.1 * c, 0, 0.1 * c, 1.2 * c, 0.05 * c, 0, 0.05 * c, 0.9 * c};
    const double last = 1.1 * hertz_time(MASS, K, FAST);
    pair p;
    rub(&p, "hertz", K, 0.2);
    meet_wall(&p, RADIUS, velocity, NULL);
    p.law.compliance = c;
    p.w.contact[0].compliance = out;
    const outcome o = run(&p, 1e-9, last);
    const double before = energy_of(&p.w, column(&p, &o, 0.0), 1);
    double v[5];
    memcpy(v, o.end.v, sizeof v);
    for (size_t i = 0; i <= 100; i++) {
        const double *now = column(&p, &o, last * (double)i / 100.0);
        CHECK(fabs(energy_of(&p.w, now, 1) - before) < 1e-8 * before, "energy: %g at %zu", energy_of(&p.w, now, 1) / before - 1.0, i);
    }
    const aoi_progress fixed = by_fixed_steps(&p, last, 20000);
    for (size_t j = 0; j < 5; j++) {
        const double scale = j < 3 ? FAST : FAST / RADIUS;
        CHECK(fabs(fixed.v[j] - v[j]) < 2e-5 * scale, "fixed steps, %zu", j);
    }
    drop();
}

/* Bodies that overlap at the start press and rub by the law's own indentation; one at rest on a slope stays. */
static void overlap_at_the_start(void)
{
    const double k = 1e6, mu = 0.3, down[3] = {10.0, 0.9 * mu * 10.0, 0.0}, still[3] = {0.0, 0.0, 0.0};
    pair p;
    rub(&p, "linear", k, mu);
    meet_wall(&p, 0.0, still, down);
    p.w.x[0][0] = MASS * down[0] / k;
    p.w.x[0][1] = MASS * down[1] / (RATIO * k);
    const outcome o = run(&p, 1e-6, 0.02);
    const double *now = column(&p, &o, 0.02);
    CHECK(fabs(o.end.v[1]) < 1e-12 && near(now[AOI_CONTACT_TANGENTIAL], MASS * down[1], 1e-9), "rests");
    CHECK(near(now[AOI_CONTACT_STUCK], 1.0, 1e-6) && fabs(now[AOI_CONTACT_FRICTION]) < 1e-14, "sticks, %g of it, and takes %g",
          now[AOI_CONTACT_STUCK], now[AOI_CONTACT_FRICTION]);
    drop();
}

/* A gap takes no steps. */
static void a_gap_costs_nothing(void)
{
    const double velocity[3] = {FAST, 0.3, 0.0};
    size_t steps[2];
    double v[2][5];
    for (size_t far = 0; far < 2; far++) {
        pair p;
        rub(&p, "hertz", K, 0.2);
        meet_wall(&p, RADIUS, velocity, NULL);
        p.w.contact[0].gap = far ? 1.0 : 0.0;
        const outcome o = run(&p, 1e-6, 1.0 / FAST * (double)far + 1.1 * hertz_time(MASS, K, FAST));
        steps[far] = o.end.steps;
        memcpy(v[far], o.end.v, sizeof v[far]);
        drop();
    }
    CHECK(steps[1] <= steps[0] + 3 && near(v[1][1], v[0][1], 1e-7) && near(v[1][3], v[0][3], 1e-7), "steps %zu and %zu", steps[0], steps[1]);
}

static void what_cannot_rub_is_refused(void)
{
    const double velocity[3] = {FAST, 0.0, 0.0}, soft[9] = {1e-9, 0, 0, 0, 1e-9, 0, 0, 0, 1e-9};
    outcome o;
    pair p;
    rub(&p, "hertz", K, 0.2);
    meet_wall(&p, RADIUS, velocity, NULL);
    p.w.body[1].residual = soft;
    CHECK(start(&p, 1e-4, 1.0, &o) == AOI_ERROR_FRICTION, "a contact point without mass");
    drop();
}

int main(void)
{
    balls_rebound_as_maws();
    what_motion_keeps();
    a_slider_comes_to_stick();
    two_contacts_share_a_body();
    what_is_taken_out();
    overlap_at_the_start();
    a_gap_costs_nothing();
    what_cannot_rub_is_refused();
    return check_report();
}
