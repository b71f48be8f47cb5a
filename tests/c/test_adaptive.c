/* The adaptive run: closed forms, conserved quantities and Runge and Kutta's method, over the whole range
 * of tolerances, for one contact and for many. */
#include "plant.h"
#include "motion/modes.h"
#include "adaptive/row.h"

/* int_0^1 dx / sqrt(1 - x^(n+1)) by tanh-sinh quadrature. */
static double half_duration(double n)
{
    double sum = 0.0;
    for (int i = -400; i <= 400; i++) {
        const double t = 0.01 * i, s = 0.5 * PI * sinh(t);
        const double left = 1.0 / (1.0 + exp(2.0 * s)); /* 1 - x, without cancellation */
        const double weight = 0.01 * 0.5 * PI * cosh(t) * 0.5 / (cosh(s) * cosh(s));
        sum += weight / sqrt(-expm1((n + 1.0) * log1p(-left)));
    }
    return sum;
}

static void rigid_bodies_collide_in_closed_form(void)
{
    const double exponents[] = {1.0, 1.5, 2.0, 3.0};
    for (size_t e = 0; e < 4; e++) {
        for (int tolerance = 3; tolerance <= 11; tolerance += 2) {
            const double n = exponents[e], k = 1e7, m[] = {0.4, 1.2}, mass = 0.3, velocity = 2.0;
            const double rtol = pow(10.0, -tolerance), gap = 1e-4;
            const double deepest = pow((n + 1.0) * mass * velocity * velocity / (2.0 * k), 1.0 / (n + 1.0));
            const double duration = 2.0 * deepest / velocity * half_duration(n);
            const aoi_law law = law_named("power", 2, k, n, 0.0);
            plant p = {.bodies = 0};
            add_rigid(&p, m[0], 1.6);
            add_rigid(&p, m[1], -0.4);
            join_rigid(&p, 0, 1, gap, &law);
            must_go(&p, rtol, gap / velocity + 2.0 * duration);
            CHECK(near(aoi_adaptive_peak(p.run, 0).force, k * pow(deepest, n), rtol), "n %g, rtol %g: peak", n, rtol);
            CHECK(near(aoi_adaptive_peak(p.run, 0).impulse, 2.0 * mass * velocity, rtol), "n %g, rtol %g: impulse", n, rtol);
            CHECK(fabs(aoi_adaptive_peak(p.run, 0).time - gap / velocity - duration / 2.0) < 3.0 * sqrt(rtol) * duration,
                  "n %g, rtol %g: peak after half the contact", n, rtol);
            CHECK(near(p.v[0] - p.v[1], -velocity, rtol), "n %g, rtol %g: rebound", n, rtol);
            CHECK(near(m[0] * p.v[0] + m[1] * p.v[1], m[0] * 1.6 - m[1] * 0.4, 1e-10), "momentum");
            CHECK(near(moment_of(&p, 0, AOI_TRACK_BEGINS), gap / velocity, 1e-13), "touch");
            const double let_go = moment_of(&p, 0, AOI_TRACK_ENDS) - gap / velocity;
            CHECK(near(let_go, duration, rtol), "n %g, rtol %g: duration %.12g", n, rtol, let_go);
            release(&p);
        }
    }
}

/* A ball on a wall: from its touch on it is known how deep it will go, 2/5 k d^(5/2) = m v^2 / 2. Each step hands on
 * the law's force. The end of the contact is foreseen, so that few steps are taken, and hardly one in vain. */
static void steps_are_few_and_hand_on_the_force_of_the_law(void)
{
    const double mass = 0.1, k = 1e9, speed[] = {1e-15, 1e-13, 1e-3, 1.0, 10.0};
    const aoi_law law = hertz(k);
    for (size_t i = 0; i < sizeof speed / sizeof *speed; i++) {
        const double v = speed[i], depth = pow(1.25 * mass * v * v / k, 0.4), end = 10.0 * depth / v;
        plant p = ball_on_wall(mass, v, &law);
        int status = begin(&p, 1e-4, end);
        while (status == AOI_OK && p.run->time < end) {
            const aoi_adaptive_contact *of = p.run->contact;
            aoi_law_value value;
            make_room(&p, p.track.rows + 1);
            status = aoi_adaptive_run(p.run, &p.track);
            aoi_law_push(&law, of->memory, of->closed.start, of->closed.rate, &value);
            CHECK(near(of->closed.force, value.force, 1e-9), "%g m/s: %g N, not %g", v, of->closed.force, value.force);
            CHECK(!of->is_closed || near(of->scales.indentation, depth, 0.03), "%g m/s: %g m, not %g", v,
                  of->scales.indentation, depth);
        }
        CHECK(status == AOI_OK && p.run->steps <= 5 && p.run->rejected <= 1, "%g m/s: %d, %zu steps, %zu in vain", v,
              status, p.run->steps, p.run->rejected);
        release(&p);
    }
}

/* Hunt and Crossley: m v dv = -k d^n (1 + chi v) dd, hence d^(n+1) = (n+1) m/k (v0 - v - log((1 + chi v0)/(1 + chi
 * v))/chi)/chi. The force is no polynomial of time at its start, and largest in one of the first four steps. */
static void a_damped_force_is_right_at_its_start(void)
{
    const double mass = 1e-3, k = 1e6, n = 1.2;
    for (double chi = 2.0; chi < 2.2; chi *= 1.004) {
        const aoi_law law = law_named("hunt_crossley", 3, k, chi, n);
        double peak = 0.0;
        for (double v = 1.0; v > 0.0; v -= 1e-4) {
            const double lost = (1.0 - v - log((1.0 + chi) / (1.0 + chi * v)) / chi) / chi;
            peak = fmax(peak, k * pow((n + 1.0) * mass / k * lost, n / (n + 1.0)) * (1.0 + chi * v));
        }
        for (double rtol = 1e-3; rtol > 5e-7; rtol *= 0.1) {
            plant p = ball_on_wall(mass, 1.0, &law);
            must_go(&p, rtol, 0.02);
            CHECK(near(aoi_adaptive_peak(p.run, 0).force, peak, rtol), "chi %g, rtol %g: %.9g N, not %.9g", chi, rtol,
                  aoi_adaptive_peak(p.run, 0).force, peak);
            release(&p);
        }
    }
}

/* A mass too heavy for the contact to matter, slowed by a: d = (1 - v^2) / 2a, in one step, with the peak of d^(3/2)
 * (1 + chi v) between its nodes, where 4 chi v^2 + 3 v = chi. */
static void a_contact_that_hardly_moves_its_bodies_has_its_peak(void)
{
    const double chi = 0.3, a = 2000.0, v = (sqrt(9.0 + 16.0 * chi * chi) - 3.0) / (8.0 * chi);
    const double peak = pow((1.0 - v * v) / (2.0 * a), 1.5) * (1.0 + chi * v);
    const aoi_law law = law_named("hunt_crossley", 3, 1.0, chi, 1.5);
    plant p = ball_on_wall(1e9, 1.0, &law);
    p.part[0].pulled = 1;
    p.part[0].gravity[0] = -a;
    must_go(&p, 1e-3, 4.0 / a);
    CHECK(near(aoi_adaptive_peak(p.run, 0).force, peak, 1e-3), "%.10g N", aoi_adaptive_peak(p.run, 0).force);
    release(&p);
}

/* Pressed by a load that fades: its peak is the start's. */
static void a_pressed_body_that_is_let_go_has_its_peak_at_the_start(void)
{
    const double load = 100.0, k = 1e8;
    const aoi_law law = hertz(k);
    plant p = ball_on_wall(1.0, 0.0, &law);
    part *ball = &p.part[0];
    ball->x[0] = pow(load / k, 2.0 / 3.0);
    ball->load_count = 2;
    ball->load_time[1] = 1e-3;
    ball->load_force[0] = load;
    must_go(&p, 1e-3, 2e-3);
    const aoi_peak peak = aoi_adaptive_peak(p.run, 0);
    CHECK(near(peak.force, load, 1e-12) && peak.time == 0.0, "%.15g N at %g s", peak.force, peak.time);
    release(&p);
}

/* m d'' + c d' + k d = 0 that pulls until d is 0 again, after pi / omega_d. Near critical damping the bodies hardly
 * move then. */
static void a_slow_end_is_when_the_indentation_is_zero(void)
{
    const double k = 70.0, mass = 2e-4, share = 0.96, end = PI / sqrt(k / mass * (1.0 - share * share));
    const aoi_law law = law_named("kelvin_voigt_pulling", 2, k, 2.0 * share * sqrt(k * mass), 0.0);
    for (double rtol = 1e-4; rtol > 5e-9; rtol *= 1e-2) {
        aoi_interval work[1], interval[1] = {{0}};
        plant p = ball_on_wall(mass, 6.0, &law);
        must_go(&p, rtol, 1.2 * end);
        CHECK(aoi_track_intervals(&p.system, &p.track, 1.2 * end, work, 1, interval) == 1, "one contact");
        CHECK(near(interval[0].end, end, rtol), "rtol %g: ends at %.12g, not %.12g", rtol, interval[0].end, end);
        release(&p);
    }
}

/* A mass on a spring for 1000 and a quarter periods ends in the middle at full speed: rounding errors of equal steps do
 * not add up. */
static void what_shakes_keeps_in_time(void)
{
    const double k = 1e6, mass = 0.1, rest = 1e-6, omega = sqrt(k / mass);
    const aoi_law law = linear(k);
    plant p = ball_on_wall(mass, 0.0, &law);
    p.part[0].pulled = 1;
    p.part[0].gravity[0] = rest * k / mass;
    p.part[0].x[0] = 1.5 * rest;
    must_go(&p, 1e-11, 1000.25 * 2.0 * PI / omega);
    CHECK(fabs(p.x[0] - rest) < 1e-11 * rest && near(p.v[0], -0.5 * rest * omega, 1e-11), "at %.15g", p.x[0] / rest);
    release(&p);
}

/* A tip on a spring and a mass, against a wall: their displacements, then their velocities. */
typedef struct ringer {
    const aoi_law *law;
    double tip, mass, k;
} ringer;

static double push_at(const aoi_law *law, const double *state)
{
    aoi_law_value value;
    aoi_law_push(law, NULL, state[0], state[2], &value);
    return value.force;
}

static void ringer_slopes(const void *data, double time, const double *state, double *slope)
{
    const ringer *of = data;
    const double spring = of->k * (state[1] - state[0]);
    (void)time;
    slope[0] = state[2];
    slope[1] = state[3];
    slope[2] = (spring - push_at(of->law, state)) / of->tip;
    slope[3] = -spring / of->mass;
}

/* How often it begins to press, by Runge and Kutta's method. */
static int presses(const ringer *of, double v, double end)
{
    enum { STEPS = 40000 };
    double state[4] = {0.0, 0.0, v, v};
    int count = 0, pressing = 0;
    for (int i = 0; i < STEPS; i++) {
        const int before = pressing;
        pressing = push_at(of->law, state) > 0.0;
        count += pressing && !before;
        runge_kutta_step(ringer_slopes, of, 4, end / STEPS * i, end / STEPS, state);
    }
    return count;
}

/* While bodies part, a tip that rings makes a law that may not pull come back for moments. */
static void comes_back(double tip, double mass, double k, double v, double end, const aoi_law *law)
{
    const double sum = tip + mass;
    const int wanted = presses(&(ringer){law, tip, mass, k}, v, end);
    CHECK(wanted > 3, "a tip of %g kg presses %d times", tip, wanted);
    for (double rtol = 1e-4; rtol > 1e-12; rtol *= 0.3) {
        plant p = ball_on_wall(sum, v, law);
        part *ball = &p.part[0];
        ball->n = 2;
        ball->omega[1] = sqrt(k * sum / (tip * mass));
        ball->shape[1] = mass / sum; /* of the spring's stretch */
        ball->push[1] = 1.0 / tip;
        ball->inertia[1] = tip * mass / sum;
        must_go(&p, rtol, end);
        int count = 0;
        for (size_t r = 0; r < p.track.rows; r++) {
            const double *row = p.track.values + p.track.row[r];
            const double *of = row + (size_t)row[AOI_TRACK_SIZE] - AOI_TRACK_CONTACT_SIZE;
            count += row[AOI_TRACK_CONTACTS] > 0.0 && of[AOI_TRACK_BEGINS] > 0.0;
        }
        CHECK(count == wanted, "tip %g, rtol %g: it presses %d times, not %d", tip, rtol, count, wanted);
        release(&p);
    }
}

static void a_force_that_comes_back_is_seen(void)
{
    const aoi_law soon = law_named("hunt_crossley", 3, 1.47e10, 208.0, 1.5);
    const aoi_law later = law_named("hunt_crossley", 3, 5.158e9, 9.41, 1.5);
    comes_back(1.15e-4, 0.535, 2.72e7, 0.0071, 1e-3, &soon);
    comes_back(3.488e-4, 0.1218, 7.24e7, 0.9128, 4.772e-4, &later);
}

/* A record that ends long before the force does anything to the mass: d = v t, F = k d^n, and the impulse is
 * to be right to itself, not to what there is to stop. */
static void a_short_record_has_its_own_scale(void)
{
    const double mass = 2.0, k = 1e6, v = 1.0, end = 1e-9;
    for (double n = 1.1; n < 3.5; n += 0.3) {
        for (double rtol = 1e-3; rtol > 1e-10; rtol *= 0.1) {
            const aoi_law law = law_named("power", 2, k, n, 0.0);
            plant p = ball_on_wall(mass, v, &law);
            part *ball = &p.part[0];
            ball->massless = 1; /* so that no edge helps */
            ball->residual[0] = 1e-17;
            must_go(&p, rtol, end);
            const double force = k * pow(v * end, n), impulse = force * end / (n + 1.0);
            CHECK(near(aoi_adaptive_peak(p.run, 0).force, force, rtol), "n %g, rtol %g: force %.12g, not %.12g", n, rtol,
                  aoi_adaptive_peak(p.run, 0).force, force);
            CHECK(near(aoi_adaptive_peak(p.run, 0).impulse, impulse, rtol), "n %g, rtol %g: impulse %.12g, not %.12g", n, rtol,
                  aoi_adaptive_peak(p.run, 0).impulse, impulse);
            release(&p);
        }
    }
}

/* The same motion by Runge and Kutta's method; x, v of a body hold at its own time, from which it flies on. */
static void moves_as_by_runge_kutta(plant *p, double rtol, double end, size_t steps, double place, double speed,
                                    const char *what)
{
    double x[ALL_MODES], v[ALL_MODES];
    runge_kutta(p, end, steps, x, v);
    must_go(p, rtol, end);
    for (size_t b = 0; b < p->bodies; b++) {
        const size_t at = p->system.first[b];
        aoi_modes_advance(&p->body[b], p->run->body[b].time, p->run->end, p->x + at, p->v + at);
    }
    for (size_t j = 0; j < p->system.first[p->bodies]; j++) {
        CHECK(fabs(p->x[j] - x[j]) < place, "%s, mode %zu: %.14g, not %.14g", what, j, p->x[j], x[j]);
        CHECK(fabs(p->v[j] - v[j]) < speed, "%s, mode %zu: velocity %.14g, not %.14g", what, j, p->v[j], v[j]);
    }
}

/* Balls in a row, with a gap or without: waves pass through Hertz's law and a spring to a contact whose force depends
 * on the rate, where a force begins like a high power of time. */
static void a_wave_passes_along_a_row(void)
{
    const aoi_law law[] = {hertz(1e6), linear(3e5), law_named("kelvin_voigt", 2, 4e5, 60.0, 0.0)};
    for (int apart = 0; apart < 2; apart++) {
        plant p = {.bodies = 0};
        for (size_t b = 0; b < 4; b++) {
            add_rigid(&p, 1.0, b == 0 ? 1.0 : 0.0);
        }
        for (size_t b = 0; b < 3; b++) {
            join_rigid(&p, b, b + 1, apart && b == 1 ? 1e-4 : 0.0, &law[b]);
        }
        moves_as_by_runge_kutta(&p, 1e-9, 0.02, 60000, 1e-11, 2e-9, apart ? "a wave across a gap" : "a wave");
        release(&p);
    }
}

/* What is pulled away parts from the light body before it, by less than the rounding of places, until a wave
 * comes. */
static void a_wave_catches_up_with_what_parts(void)
{
    const aoi_law first = hertz(1e9), last = law_named("kelvin_voigt", 2, 5e7, 50.0, 0.0);
    const double mass[] = {0.2, 1e-3, 0.07}, end = 3e-5;
    for (double rtol = 1e-7; rtol > 1e-9; rtol *= 0.1) {
        plant p = {.bodies = 0};
        for (int b = 0; b < 3; b++) {
            add_rigid(&p, mass[b], b == 0 ? 2.0 : 0.0);
        }
        p.part[2].pulled = 1;
        p.part[2].gravity[0] = 10.0; /* a force */
        join_rigid(&p, 0, 1, 0.0, &first);
        join_rigid(&p, 1, 2, 0.0, &last);
        moves_as_by_runge_kutta(&p, rtol, end, 100000, 2.0 * rtol * end, 2.0 * rtol, "a wave that catches up");
        release(&p);
    }
}

/* A mass that hits a body in its first mode, and by a share of it in a fast second one, with which the port beside a
 * wall moves; with the first, too, or not. */
static plant struck_beside_a_wall(const aoi_law *law, double amplitude, double ringing, double felt, double moved)
{
    const double mass = 10.0;
    plant p = {.bodies = 0};
    add_rigid(&p, 1.0, 1.0);
    part *body = &p.part[p.bodies++];
    *body = (part){.n = 2, .ports = 2};
    body->omega[1] = 2e6;
    body->shape[0] = 1.0;
    body->shape[1] = felt; /* the mode where it is struck */
    body->shape[2] = moved;
    body->shape[3] = 1.0;
    body->inertia[0] = mass;
    body->inertia[1] = ringing;
    body->centre[0] = 1.0;
    for (size_t q = 0; q < 2; q++) {
        for (size_t j = 0; j < 2; j++) {
            body->push[2 * q + j] = body->shape[2 * q + j] / body->inertia[j];
        }
    }
    body->x[1] = amplitude;
    add_wall(&p);
    join(&p, 0, 0, 1, 0, 0.0, law);
    return p;
}

/* When the second port first comes to a place, by a dense look at a run in which nothing is there; -1: never. */
static double first_crossing(plant *p, double rtol, double end, double place, int looks)
{
    double state[4], before = 0.0;
    must_go(p, rtol, end);
    CHECK(open_sampler(p) == AOI_OK, "sampled");
    for (int i = 1; i <= looks; i++) {
        const double time = end * i / looks;
        aoi_sampler_state(p->sampler, time, 1, state);
        const double over = p->part[1].shape[2] * state[0] + state[1] - place;
        if (over >= 0.0) {
            return time - end / looks * over / (over - before);
        }
        before = over;
    }
    return -1.0;
}

/* A fast mode touches a wall for less than any step of the contact that goes on beside it: by its free oscillation,
 * or by that which the contact's force sets off. */
static void a_touch_beside_a_contact_is_not_stepped_over(void)
{
    const aoi_law first[] = {hertz(1e9), law_named("kelvin_voigt", 2, 1e8, 4e3, 0.0)}, wall = hertz(1e2);
    const double end = 4e-4, amplitude[] = {2e-5, 0.0}, mass[] = {1.0, 1e-8}, felt[] = {0.0, 1e-5};
    const double moved[] = {1.0, 0.0}, gap[] = {2.1e-5, 2.6e-6}, period = PI * 1e-6;
    for (int forced = 0; forced < 2; forced++) {
        plant alone =
            struck_beside_a_wall(&first[forced], amplitude[forced], mass[forced], felt[forced], moved[forced]);
        const double wanted = first_crossing(&alone, 1e-11, end, gap[forced], 40000);
        CHECK(wanted > 5.0 * period, "it comes to the wall late: at %g", wanted);
        for (double rtol = 1e-4; rtol > 5e-13; rtol *= 1e-2) {
            plant p =
                struck_beside_a_wall(&first[forced], amplitude[forced], mass[forced], felt[forced], moved[forced]);
            join(&p, 1, 1, 2, 0, gap[forced], &wall);
            must_go(&p, rtol, end);
            const double found = moment_of(&p, 1, AOI_TRACK_BEGINS);
            CHECK(fabs(found - wanted) < 5e-3 * period, "forced %d, rtol %g: touch at %.12g, not %.12g", forced,
                  rtol, found, wanted);
            release(&p);
        }
        release(&alone);
    }
}

/* A crest of 1e-6 less than the gap never touches, one of 1e-6 more does. */
static void a_crest_beside_a_contact_touches_or_does_not(void)
{
    const aoi_law first = hertz(1e9), wall = hertz(1e2);
    const double crest = 2e-5;
    for (int above = 0; above < 2; above++) {
        plant p = struck_beside_a_wall(&first, 0.0, 1.0, 0.0, 0.0);
        p.part[1].v[1] = crest * p.part[1].omega[1];
        join(&p, 1, 1, 2, 0, crest * (above ? 1.0 - 1e-6 : 1.0 + 1e-6), &wall);
        must_go(&p, 1e-8, 2e-4);
        const double touch = moment_of(&p, 1, AOI_TRACK_BEGINS), quarter = 0.5 * PI / p.part[1].omega[1];
        CHECK((touch >= 0.0) == above && (aoi_adaptive_peak(p.run, 1).impulse > 0.0) == above, "above %d: touch at %g", above, touch);
        CHECK(!above || near(touch, quarter, 2e-3), "at its crest: %g, not %g", touch, quarter);
        release(&p);
    }
}

static double deepest_asked;

static double saturating(double indentation, double rate)
{
    const double high = pow(indentation, 8.0);
    (void)rate;
    deepest_asked = fmax(deepest_asked, indentation);
    return 1e3 * high / (high + 1e-40);
}

/* A caller's law that saturates is not asked where the motion does not lead, however steady and strong the push. */
static void a_law_is_asked_no_deeper_than_the_motion_may_lead(void)
{
    aoi_user_law user = {.given = {1, 0, 0, 0}};
    user.function[AOI_USER_FORCE] = saturating;
    for (double push = 450.0; push < 1e4; push *= 1.5) {
        for (int rises = 0; rises < 2; rises++) {
            const double end = rises ? 1e-3 : 2e-3;
            aoi_law law;
            CHECK(aoi_law_create_user(&law, &user, 0, 0) == AOI_OK, "made");
            plant p = ball_on_wall(1.0, 0.0, &law);
            part *ball = &p.part[0];
            ball->load_count = 2;
            ball->load_time[1] = end;
            ball->load_force[0] = rises ? 0.0 : push;
            ball->load_force[1] = push;
            deepest_asked = 0.0;
            must_go(&p, 1e-6, end);
            const double free = push * end * end * (rises ? 1.0 / 6.0 : 0.5); /* without the law */
            CHECK(deepest_asked <= (rises ? 3.0 : 1.0) * free * 1.01, "%g N, rises %d: asked at %g m, goes to %g m",
                  push, rises, deepest_asked, p.x[0]);
            release(&p);
        }
    }
}

/* Ringing, damped bodies with two ports, loads and gravity; contacts come and go. */
static void a_row_of_ringing_bodies(void)
{
    uint64_t seed = 17;
    const aoi_law law = law_named("power", 2, 2e4, 2.0, 0.0);
    plant p = {.bodies = 0};
    for (size_t b = 0; b < 4; b++) {
        part *of = add_ringing(&p, 3, 2, 1.0, 60.0, b == 0 ? 1.0 : 0.0, &seed);
        of->damped = of->pulled = 1;
        of->load_count = 2;
        of->load_time[0] = 0.0;
        of->load_time[1] = 0.25;
        of->load_force[2] = 0.1 * (double)b;
        for (size_t j = 0; j < of->n; j++) {
            of->decay[j] = 0.3 * (double)j;
            of->gravity[j] = j == 0 ? 0.2 : 0.0;
        }
        if (b > 0) {
            join(&p, b - 1, 1, b, 0, b == 1 ? 0.0 : 1e-3, &law);
        }
    }
    moves_as_by_runge_kutta(&p, 1e-10, 0.5, 20000, 2e-10, 1e-8, "row");
    CHECK(aoi_adaptive_peak(p.run, 2).impulse > 0.0, "the impact has been transmitted: %g N s", aoi_adaptive_peak(p.run, 2).impulse);
    release(&p);
}

/* A body whose first mode does not feel its contacts: they still feel each other by the others. */
static void contacts_meet_by_any_mode(void)
{
    uint64_t seed = 5;
    const aoi_law law = law_named("power", 2, 2e4, 2.0, 0.0);
    plant p = {.bodies = 0};
    add_rigid(&p, 1.0, 1.0);
    part *rocker = add_ringing(&p, 3, 2, 1.0, 40.0, 0.0, &seed);
    rocker->omega[0] = 1.0;
    rocker->shape[0] = rocker->push[0] = 0.0; /* a node of it */
    add_rigid(&p, 1.0, -0.8);
    join(&p, 0, 0, 1, 0, 0.0, &law);
    join(&p, 1, 1, 2, 0, 0.0, &law);
    moves_as_by_runge_kutta(&p, 1e-10, 0.4, 20000, 2e-10, 1e-8, "rocker");
    release(&p);
}

static double not_a_number(double indentation, double rate)
{
    (void)rate;
    return indentation > 5e-5 ? NAN : 1e7 * indentation;
}

static void a_law_that_fails_is_named(void)
{
    double note[AOI_LAW_NOTE] = {NAN, NAN};
    aoi_user_law user = {.given = {1, 0, 0, 0}};
    user.function[AOI_USER_FORCE] = not_a_number;
    aoi_law law, sound = linear(1e7);
    CHECK(aoi_law_create_user(&law, &user, 0, 0) == AOI_OK, "made");
    law.note = note;
    plant p = {.bodies = 0};
    add_rigid(&p, 1.0, 0.1);
    add_wall(&p);
    add_rigid(&p, 1.0, 1.0);
    join_rigid(&p, 0, 1, 0.0, &sound);
    join_rigid(&p, 2, 1, 0.0, &law);
    CHECK(go(&p, 1e-8, 1.0) == AOI_ERROR_LAW, "the law's failure");
    CHECK(aoi_adaptive_progress(p.run).failed == 1 && near(note[0], 5e-5, 1e-5), "which, and where: %g m", note[0]);
    release(&p);
}

/* Nothing slows it: the indentation is the speed times the time, past the force of yield. */
static void a_body_of_any_mass_runs_up_the_law(void)
{
    const double k = 1e10, end = 1e-4, parameter[] = {k, 1.0}, yield = pow(1.0 / k, 2.0 / 3.0);
    aoi_law law;
    CHECK(aoi_law_create(&law, "thornton", 2, parameter) == AOI_OK, "made");
    for (double mass = 1e12; mass < 1e200; mass *= 1e30) {
        plant p = ball_on_wall(mass, 1.0, &law);
        must_go(&p, 1e-8, end);
        const double force = 1.0 + 1.5 * k * sqrt(yield) * (end - yield);
        CHECK(near(aoi_adaptive_peak(p.run, 0).force, force, 1e-8), "%g kg: %.12g N, not %.12g", mass,
              aoi_adaptive_peak(p.run, 0).force, force);
        release(&p);
    }
}

static void a_patch_has_its_limit(void)
{
    const double k = 1e7, v = 1.0, deepest = pow(2.5 * v * v / (2.0 * k), 0.4);
    for (int i = 0; i < 4; i++) { /* by so little as lies between the nodes of a step, too */
        const int within = i % 2;
        const double margin = i < 2 ? 1e-3 : 1e-6;
        aoi_law law = hertz(k);
        law.limit = deepest * (within ? 1.0 + margin : 1.0 - margin);
        plant p = ball_on_wall(1.0, v, &law);
        CHECK(go(&p, 1e-8, 0.1) == (within ? AOI_OK : AOI_ERROR_PATCH), "limit against deepest, margin %g", margin);
        release(&p);
    }
}

/* A ball on a free body that rings, on a spring k from the touch on: in closed form, as long as it lasts. What rings
 * presses them together at the touch, with an acceleration far beyond what the contact will see. */
typedef struct rung {
    double root[2], cosine[2], sine[2]; /* the indentation is sum cosine cos root t + sine sin root t */
} rung;

enum { BALL = 1, FREE = 10, FELT = 1 }; /* kg: the ball, the body, and what rings of it */

static rung ring_on(double k, double omega, double amplitude)
{
    /* y: ball less rigid motion less gap, x: what rings; y'' = -a (y - x), x'' = -omega^2 x + b (y - x) */
    const double a = k * (1.0 / BALL + 1.0 / FREE), b = k / FELT, c = omega * omega + b;
    const double half = 0.5 * (c - a), split = hypot(half, sqrt(a * b));
    const double high = 0.5 * (c + a) + split, low = a * omega * omega / high;
    const double y[2] = {amplitude, 1.0}, x[2] = {amplitude, 0.0}; /* displacement and velocity at the start */
    const double square[2] = {low, high};
    double share[2][2];
    /* In each mode y - x is d, with y = a d / square: two equations for the two shares d of either. */
    for (int i = 0; i < 2; i++) {
        const double all = y[i] - x[i];
        share[i][0] = (y[i] - a / high * all) / (a / low - a / high);
        share[i][1] = all - share[i][0];
    }
    rung of;
    for (int m = 0; m < 2; m++) {
        of.root[m] = sqrt(square[m]);
        of.cosine[m] = share[0][m];
        of.sine[m] = share[1][m] / of.root[m];
    }
    return of;
}

static double rung_at(const rung *of, double time)
{
    double sum = 0.0;
    for (int m = 0; m < 2; m++) {
        sum += of->cosine[m] * cos(of->root[m] * time) + of->sine[m] * sin(of->root[m] * time);
    }
    return sum;
}

/* The integral from the start. */
static double rung_sum(const rung *of, double time)
{
    double sum = 0.0;
    for (int m = 0; m < 2; m++) {
        sum += (of->cosine[m] * sin(of->root[m] * time) + of->sine[m] * (1.0 - cos(of->root[m] * time))) / of->root[m];
    }
    return sum;
}

/* When the slow mode, a sine, has come to an angle. */
static double rung_time(const rung *of, double angle)
{
    return (angle - atan2(of->cosine[0], of->sine[0])) / of->root[0];
}

/* The amplitude of what rings, as a share of the slow mode's. */
static double rung_share(const rung *of)
{
    return hypot(of->cosine[1], of->sine[1]) / hypot(of->cosine[0], of->sine[0]);
}

/* From one look at it to the next: thirty in a period of what rings. */
static double rung_stride(const rung *of) { return 2.0 * PI / (30.0 * of->root[1]); }

/* Where it is back at zero, not before the slow mode is as small as what rings. */
static double rung_end(const rung *of)
{
    double low = rung_time(of, PI - asin(rung_share(of))), high = low;
    while (rung_at(of, high) > 0.0) {
        low = high;
        high += rung_stride(of);
    }
    while (high - low > 1e-15 * high) {
        const double middle = 0.5 * (low + high);
        *(rung_at(of, middle) > 0.0 ? &low : &high) = middle;
    }
    return low;
}

/* Its largest value, which is where the slow mode is below its own by twice what rings at most; by a parabola. */
static double rung_top(const rung *of)
{
    const double stride = rung_stride(of), reach = acos(1.0 - 2.0 * rung_share(of));
    double top = 0.0, time = rung_time(of, 0.5 * PI - reach);
    double before = rung_at(of, time - stride), here = rung_at(of, time);
    for (const double last = rung_time(of, 0.5 * PI + reach); time < last + stride; time += stride) {
        const double next = rung_at(of, time + stride), bend = before - 2.0 * here + next;
        if (here >= before && here >= next) {
            const double at = time + 0.5 * stride * (before - next) / bend;
            const double slope = (rung_at(of, at + 0.1 * stride) - rung_at(of, at - 0.1 * stride)) / (0.2 * stride);
            top = fmax(top, rung_at(of, at - slope * stride * stride / bend));
        }
        before = here;
        here = next;
    }
    return top;
}

static plant rung_plant(const aoi_law *law, double omega, double amplitude)
{
    plant p = {.bodies = 0};
    add_rigid(&p, BALL, 1.0);
    part *body = add_rigid(&p, FREE, 0.0);
    body->n = 2;
    body->omega[1] = omega;
    body->shape[1] = 1.0;
    body->push[1] = 1.0 / FELT;
    body->inertia[1] = FELT;
    body->x[1] = amplitude;
    join_rigid(&p, 0, 1, -amplitude, law); /* they touch */
    return p;
}

/* However often it turns in a step that the rest of the motion would allow, what rings is in the force as far as the
 * tolerance goes, and a limit just below its top is seen. */
static void what_rings_in_a_contact_is_in_its_force(void)
{
    const double k = 1.6e7, depth = sqrt(10.0 / 11.0 / k);
    uint64_t seed = 7;
    for (int i = 0; i < 600; i++) {
        const double turns = 30.0 * pow(1300.0, uniform(&seed)), rtol = pow(10.0, -3.0 - 6.3 * uniform(&seed));
        /* of any size, or a few times rtol */
        const double draw = uniform(&seed), share = i % 2 ? 1e-6 * pow(2e5, draw) : rtol * (2.0 + 4.0 * draw);
        if (share * turns > 0.5) {
            continue; /* it would touch again after the end */
        }
        const double omega = turns * sqrt(1.1 * k), amplitude = share * depth;
        const rung of = ring_on(k, omega, amplitude);
        const double top = rung_top(&of), end = rung_end(&of), impulse = k * rung_sum(&of, end);
        aoi_law law = linear(k);
        plant p = rung_plant(&law, omega, amplitude);
        must_go(&p, rtol, 1.05 * end);
        const aoi_peak peak = aoi_adaptive_peak(p.run, 0);
        const double off[] = {peak.force / (k * top) - 1.0, peak.impulse / impulse - 1.0,
                              moment_of(&p, 0, AOI_TRACK_ENDS) / end - 1.0};
        for (int q = 0; q < 3; q++) {
            CHECK(fabs(off[q]) < 2.0 * rtol, "%g turns of %g, rtol %g: quantity %d off by %g", turns, share, rtol, q,
                  off[q]);
        }
        release(&p);
        law.limit = top * (1.0 - 3.0 * rtol); /* between the smooth top and the true one, if share > 3 rtol */
        plant deep = rung_plant(&law, omega, amplitude);
        CHECK(go(&deep, rtol, end) == AOI_ERROR_PATCH, "%g turns of %g, rtol %g: past the limit", turns, share, rtol);
        release(&deep);
    }
}

/* How deep a crest of what rings would go into a ball that goes on as if there were no contact. */
static double crest_at(double omega, double amplitude, double parting, double gap, double time)
{
    return -amplitude * cos(omega * time) - parting * time - gap;
}

/* What rings touches a ball once, with a crest, so softly that nothing heeds the force; the bodies themselves approach
 * or part more slowly. */
static void a_crest_that_is_drawn_back_has_its_own_scale(void)
{
    const double omega = 1e6, amplitude = 2e-4, k = 10.0, speed = 9.5, parting = 20.0;
    const double crest = PI / omega, gap = crest_at(omega, amplitude, parting, 0.0, crest) - 0.1 * amplitude;
    double from = 0.5 * crest, to = 1.5 * crest, left = crest, right = crest, impulse = 0.0, top = 0.0;
    for (int i = 0; i < 60; i++) {
        const double a = 0.5 * (from + left), b = 0.5 * (to + right);
        *(crest_at(omega, amplitude, parting, gap, a) > 0.0 ? &left : &from) = a;
        *(crest_at(omega, amplitude, parting, gap, b) > 0.0 ? &right : &to) = b;
    }
    for (int i = 0; i < 4000; i++) { /* in an angle that takes the ends' roots away */
        const double angle = PI * (i + 0.5) / 4000.0, half = 0.5 * (right - left);
        const double deep = crest_at(omega, amplitude, parting, gap, left + half * (1.0 + cos(angle)));
        impulse += PI / 4000.0 * half * sin(angle) * pow(fmax(deep, 0.0), 1.5);
        top = fmax(top, deep);
    }
    for (double rtol = 1e-3; rtol > 5e-7; rtol *= 0.1) {
        const aoi_law law = hertz(k);
        plant p = rung_plant(&law, omega, amplitude);
        p.part[0].v[0] = speed;
        p.part[1].v[0] = speed + parting;
        p.contact[0].gap = gap;
        must_go(&p, rtol, 1e3 / omega);
        CHECK(near(aoi_adaptive_peak(p.run, 0).impulse, k * impulse, 2.0 * rtol), "rtol %g: %.12g, not %.12g", rtol,
              aoi_adaptive_peak(p.run, 0).impulse, k * impulse);
        CHECK(near(aoi_adaptive_peak(p.run, 0).force, k * pow(top, 1.5), 2.0 * rtol), "rtol %g: the peak", rtol);
        release(&p);
    }
}

/* However little room there is for each piece, the track has the same bits. */
static void a_run_in_pieces_is_the_run(void)
{
    const aoi_law law = hertz(1e6);
    plant p[2] = {{.bodies = 0}, {.bodies = 0}};
    for (int i = 0; i < 2; i++) {
        uint64_t seed = 77;
        for (int b = 0; b < 3; b++) {
            part *of = add_ringing(&p[i], 4, 2, 1.0, 3e3, b == 0 ? 1.0 : 0.0, &seed);
            of->pulled = 1;
            of->gravity[0] = b == 0 ? 9.81 : 0.0;
        }
        join(&p[i], 0, 1, 1, 0, 0.0, &law);
        join(&p[i], 1, 1, 2, 0, 1e-4, &law);
    }
    must_go(&p[0], 1e-8, 0.05);
    CHECK(begin(&p[1], 1e-8, 0.05) == AOI_OK, "it starts");
    make_room(&p[1], p[0].track.rows + 2);
    aoi_track *whole = &p[0].track, *pieces = &p[1].track;
    CHECK(whole->rows > 20, "%zu rows", whole->rows);
    size_t calls = 0, room = aoi_adaptive_room(&p[1].system);
    while (aoi_adaptive_progress(p[1].run).time < 0.05 && calls++ < 100000) {
        const size_t used = pieces->used, rows = pieces->rows;
        pieces->capacity = used + (calls % 3 ? room : 2 * room - 1);
        pieces->row_capacity = rows + (calls % 5 ? 2 : 1);
        CHECK(aoi_adaptive_run(p[1].run, pieces) == AOI_OK, "it goes on");
        CHECK(pieces->used <= pieces->capacity && pieces->rows <= rows + 2, "within its room");
    }
    CHECK(whole->used == pieces->used && memcmp(whole->values, pieces->values, whole->used * sizeof(double)) == 0,
          "the same %zu doubles", whole->used);
    CHECK(whole->rows == pieces->rows && memcmp(whole->row, pieces->row, whole->rows * sizeof(size_t)) == 0,
          "the same %zu rows", whole->rows);
    const size_t used = pieces->used, rows = pieces->rows;
    pieces->capacity = pieces->used;
    CHECK(aoi_adaptive_run(p[1].run, pieces) == AOI_OK && pieces->used == used && pieces->rows == rows,
          "no room, no rows");
    release(&p[0]);
    release(&p[1]);
}

/* Two ringing bodies, equal to each other or of different mass, the second under a rising load or not; alike: all
 * numbers of equal ones are equal, else the second differs by rounding, so that it gets tables of its own. */
static void collide_twins(plant *p, const aoi_law *law, double heavier, int loaded, int alike)
{
    uint64_t seed = 3;
    add_ringing(p, 3, 1, 0.3, 2e5, 1.0, &seed);
    p->part[p->bodies] = p->part[0];
    part *twin = &p->part[p->bodies++];
    for (size_t j = 0; j < twin->n; j++) {
        twin->v[j] = 0.0;
        twin->push[j] /= heavier;
        twin->inertia[j] *= heavier;
    }
    if (loaded) {
        twin->load_count = 2;
        twin->load_time[1] = 1e-3;
        twin->load_force[1] = 1e3;
    }
    if (!alike) {
        twin->omega[1] *= 1.0 + 4e-16;
    }
    join_rigid(p, 0, 1, 0.0, law);
    CHECK(begin(p, 1e-8, 1e-3) == AOI_OK, "it starts");
    CHECK(aoi_adaptive_finish(p->run, &p->track) == AOI_OK, "it runs");
    keep_state(p);
}

static void bodies_of_one_model_move_as_others_do(void)
{
    const aoi_law law = hertz(1e9);
    for (int i = 0; i < 4; i++) {
        const double heavier = i % 2 == 0 ? 1.0 : 2.0;
        plant one = {.bodies = 0}, two = {.bodies = 0};
        collide_twins(&one, &law, heavier, i / 2, 1);
        collide_twins(&two, &law, heavier, i / 2, 0);
        CHECK(aoi_adaptive_peak(two.run, 0).impulse > 0.0, "they meet");
        for (size_t k = 0; k < one.system.first[2]; k++) {
            CHECK(fabs(one.v[k] - two.v[k]) <= 1e-9 * (1.0 + fabs(one.v[k])), "mode %zu, %g times", k, heavier);
        }
        release(&one);
        release(&two);
    }
}

/* A load's work is F^2 t^2 / 2 m, beyond all numbers, although places and velocities are not; the contact feels none
 * of it. */
static void energies_that_overflow_are_refused(void)
{
    const aoi_law law = hertz(1e6);
    for (int overflows = 0; overflows < 2; overflows++) {
        plant p = {.bodies = 0};
        part *ball = add_rigid(&p, 1.0, 1.0);
        ball->n = ball->ports = 2;
        ball->shape[1] = ball->push[1] = 0.0;
        ball->shape[3] = ball->push[3] = ball->inertia[1] = 1.0;
        ball->load_count = 1;
        ball->load_force[1] = overflows ? 1e200 : 1e100;
        add_wall(&p);
        join_rigid(&p, 0, 1, 1e-3, &law);
        CHECK(go(&p, 1e-6, 0.1) == (overflows ? AOI_ERROR_NOT_FINITE : AOI_OK), "overflows %d", overflows);
        CHECK(isfinite(p.x[1]) && isfinite(p.v[1]), "its motion is a number: %g", p.x[1]);
        release(&p);
    }
}

static void senseless_runs_are_refused(void)
{
    const aoi_law law = hertz(1e6);
    const double rtol[] = {0.0, -1e-6, NAN, 1e-6, 1e-6, 1e-6, 1e-6};
    const double end[] = {1.0, 1.0, 1.0, 0.0, -1.0, NAN, HUGE_VAL};
    for (int i = 0; i < 7; i++) {
        plant p = ball_on_wall(1.0, 1.0, &law);
        CHECK(begin(&p, rtol[i], end[i]) == AOI_ERROR_ARGUMENT, "rtol %g, end %g", rtol[i], end[i]);
        release(&p);
    }
    for (int i = 0; i < 4; i++) {
        plant p = ball_on_wall(1.0, 1.0, &law);
        p.contact[0].body[0] = i == 0 ? 2 : i == 1 ? 1 : 0;
        p.contact[0].port[1] = i == 2 ? 1 : 0;
        p.contact[0].gap = i == 3 ? NAN : 0.0;
        CHECK(lay_out(&p) == AOI_ERROR_ARGUMENT, "contact %d", i);
    }
    for (int i = 0; i < 5; i++) {
        plant p = ball_on_wall(1.0, i == 0 ? NAN : 1.0, &law);
        part *ball = &p.part[0];
        ball->x[0] = i == 1 ? HUGE_VAL : 0.0;
        ball->omega[0] = i == 2 ? NAN : 0.0;
        ball->damped = 1;
        ball->decay[0] = i == 3 ? -1.0 : 0.0;
        ball->push[0] = i == 4 ? NAN : 1.0;
        const int status = begin(&p, 1e-6, 1.0);
        CHECK(status == (i < 2 ? AOI_ERROR_NOT_FINITE : AOI_ERROR_ARGUMENT), "case %d: %d", i, status);
        release(&p);
    }
}

/* No machine has the memory: malloc refuses what these say. */
static void sizes_that_overflow_are_too_large(void)
{
    const size_t many = SIZE_MAX / 3;
    const aoi_modes body = {.n = many, .ports = many};
    CHECK(aoi_response_size(&body, many) >= SIZE_MAX / 2, "tables");
    CHECK(aoi_collocation_size(many, 1) >= SIZE_MAX / 2, "contacts");
    CHECK(aoi_collocation_size(4, many) >= SIZE_MAX / 2, "contacts far apart");
    CHECK(aoi_balance_size(many, many) >= SIZE_MAX / 2, "massless contact points");
}

int main(void)
{
    rigid_bodies_collide_in_closed_form();
    steps_are_few_and_hand_on_the_force_of_the_law();
    a_damped_force_is_right_at_its_start();
    a_contact_that_hardly_moves_its_bodies_has_its_peak();
    a_pressed_body_that_is_let_go_has_its_peak_at_the_start();
    a_slow_end_is_when_the_indentation_is_zero();
    what_shakes_keeps_in_time();
    a_force_that_comes_back_is_seen();
    a_short_record_has_its_own_scale();
    a_wave_passes_along_a_row();
    a_wave_catches_up_with_what_parts();
    a_touch_beside_a_contact_is_not_stepped_over();
    a_crest_beside_a_contact_touches_or_does_not();
    a_law_is_asked_no_deeper_than_the_motion_may_lead();
    a_row_of_ringing_bodies();
    contacts_meet_by_any_mode();
    a_law_that_fails_is_named();
    a_body_of_any_mass_runs_up_the_law();
    a_patch_has_its_limit();
    what_rings_in_a_contact_is_in_its_force();
    a_crest_that_is_drawn_back_has_its_own_scale();
    a_run_in_pieces_is_the_run();
    bodies_of_one_model_move_as_others_do();
    energies_that_overflow_are_refused();
    senseless_runs_are_refused();
    sizes_that_overflow_are_too_large();
    return check_report();
}
