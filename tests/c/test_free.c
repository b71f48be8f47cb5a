/* Free free motion: its closed form, and that no touch is stepped over, however briefly it lasts. */
#include "plant.h"
#include "law/law.h"
#include "motion/free.h"
#include "motion/modes.h"
#include "motion/radau.h"

enum { STRIDES = 1000000 };

/* The first two bodies of a plant, about to move freely. */
static aoi_free_pair pair_of(plant *p, double gap)
{
    lay_out(p);
    return (aoi_free_pair){{&p->body[0], &p->body[1]}, {0, 0}, gap,
                        {p->x, p->x + p->system.first[1]}, {p->v, p->v + p->system.first[1]}, 0.0, NULL};
}

static int next_touch(aoi_free_pair *pair, double limit)
{
    int touches = -1;
    CHECK(aoi_free_pair_next_touch(pair, limit, STRIDES, &touches) == AOI_OK, "the search ends");
    return touches;
}

static double indentation_of(const aoi_free_pair *pair)
{
    double of[AOI_DERIVATIVES + 1];
    aoi_free_pair_motion(pair, AOI_DERIVATIVES, of);
    return of[0];
}

/* A mass that gravity pulls towards a wall. */
static plant thrown(double velocity, double gravity)
{
    plant p = {.bodies = 0};
    part *ball = add_rigid(&p, 0.3, velocity);
    ball->pulled = 1;
    ball->gravity[0] = gravity;
    add_wall(&p);
    return p;
}

static void a_thrown_ball_lands_where_it_must(void)
{
    /* delta = -h + v t + g t^2 / 2 */
    plant p = thrown(3.0, 9.81);
    aoi_free_pair pair = pair_of(&p, 2.0);
    CHECK(next_touch(&pair, 10.0) == 1, "it lands");
    CHECK(near(pair.time, (sqrt(9.0 + 2.0 * 9.81 * 2.0) - 3.0) / 9.81, 1e-14), "when: %.17g", pair.time);
    CHECK(near(p.v[0], 3.0 + 9.81 * pair.time, 1e-14), "how fast");
}

static void a_ball_thrown_up_comes_back(void)
{
    plant p = thrown(-3.0, 9.81); /* away from contact at delta = 0 */
    aoi_free_pair pair = pair_of(&p, 0.0);
    CHECK(next_touch(&pair, 10.0) == 1, "it comes back");
    CHECK(near(pair.time, 6.0 / 9.81, 1e-13), "after 2 v / g: %.17g", pair.time);
}

/* The rounding of bodies that move on together is no rate at which they part. */
static void a_ball_beside_the_wall_is_pressed_at_once(void)
{
    for (int rising = 0; rising < 2; rising++) {
        plant p = thrown(-1e-17, rising ? 0.0 : 3000.0);
        part *ball = &p.part[0];
        if (rising) {
            ball->load_count = 2;
            ball->load_time[1] = 1e-3;
            ball->load_force[1] = 1e4;
        }
        ball->x[0] = 1e-6;
        aoi_free_pair pair = pair_of(&p, 1e-6);
        CHECK(next_touch(&pair, 1e-5) == 1, "it is pressed");
        CHECK(pair.time < 1e-8, "at once: %.17g", pair.time);
    }
}

/* A body comes as far as a height, by so little as margin or more, and no farther; when, to how much. */
static void comes_as_far_as(plant thrown_body, double height, double margin, double limit, double when, double within)
{
    for (int above = 0; above < 2; above++) {
        plant p = thrown_body;
        aoi_free_pair pair = pair_of(&p, height * (above ? 1.0 - margin : 1.0 + margin));
        CHECK(next_touch(&pair, limit) == above, "top and gap %g m differ by %g", height, margin);
        CHECK(above ? near(pair.time, when, within) : pair.time == limit, "at %.17g", pair.time);
    }
}

/* A mass of 1 kg before a wall. */
static plant swinging(double velocity, double omega, double decay, double load)
{
    plant p = {.bodies = 0};
    part *bob = add_rigid(&p, 1.0, velocity);
    bob->omega[0] = omega;
    bob->damped = decay > 0.0;
    bob->decay[0] = decay;
    bob->load_count = load > 0.0;
    bob->load_force[0] = load;
    add_wall(&p);
    return p;
}

/* v^2 / 2 g; v/omega, after a quarter of a period less the root of what it lacks; damped, v/omega e^(-(sigma/w) atan(w/sigma)),
 * w^2 = omega^2 - sigma^2; under a sudden load twice the deflection at rest, f/(m omega^2); and by drag alone v / (2 sigma). */
static void tops_are_reached_and_not_passed(void)
{
    const double omega = 100.0, decay = 30.0, turn = sqrt(omega * omega - decay * decay);
    const double crest = 100.0 / omega * exp(-decay / turn * atan2(turn, decay));
    comes_as_far_as(thrown(3.0, -9.81), 9.0 / (2.0 * 9.81), 1e-11, 1.0, 3.0 / 9.81, 1e-5);
    comes_as_far_as(swinging(100.0, omega, 0.0, 0.0), 1.0, 1e-12, 1.0, (PI / 2.0 - sqrt(2e-12)) / omega, 1e-7);
    comes_as_far_as(swinging(100.0, omega, decay, 0.0), crest, 1e-12, 1.0, atan2(turn, decay) / turn, 1e-5);
    comes_as_far_as(swinging(0.0, 50.0, 0.0, 5.0), 4e-3, 1e-11, 1.0, PI / 50.0, 1e-5);
    comes_as_far_as(swinging(2.0, 0.0, 4.0, 0.0), 0.25, 1e-9, 100.0, log(1e9) / 8.0, 1e-6);
}

/* From rest at touch, drawn away by gravity. */
static void what_gravity_draws_away_goes(void)
{
    plant p = swinging(0.0, 30.0, 0.0, 0.0);
    p.part[0].pulled = 1;
    p.part[0].gravity[0] = -1.0;
    aoi_free_pair pair = pair_of(&p, 0.0);
    CHECK(next_touch(&pair, 1e-4) == 0 && pair.time == 1e-4, "it goes");
}

/* A load that rises by 6 N/s: v = 3 t^2, x = t^3. */
static void a_load_that_rises_pushes_a_ball_against_the_wall(void)
{
    plant p = {.bodies = 0};
    part *ball = add_rigid(&p, 1.0, 0.0);
    const double time[] = {0.5, 1.5};
    ball->load_count = 2;
    ball->load_time[0] = time[0];
    ball->load_time[1] = time[1];
    ball->load_force[1] = 6.0;
    add_wall(&p);
    aoi_free_pair pair = pair_of(&p, 0.125);
    CHECK(next_touch(&pair, 9.0) == 1, "it touches");
    CHECK(near(pair.time, 1.0, 1e-13), "t^3 = 1/8 after the load began: %.17g", pair.time);
    CHECK(near(p.v[0], 0.75, 1e-13), "3 t^2: %.17g", p.v[0]);
}

/* At touch and at rest, with a load that is nothing yet, the third derivative decides: a force that rises, less
 * what drag takes of the acceleration, and springs of the velocity. */
static void a_load_that_begins_at_touch_presses(void)
{
    for (int pulls = 0; pulls < 2; pulls++) {
        plant p = {.bodies = 0};
        part *ball = add_rigid(&p, 2.0, 0.0);
        ball->load_count = 2;
        ball->load_time[1] = 1.0;
        ball->load_force[1] = pulls ? -6.0 : 6.0;
        add_wall(&p);
        aoi_free_pair pair = pair_of(&p, 0.0);
        double of[AOI_DERIVATIVES + 1];
        aoi_free_pair_motion(&pair, AOI_DERIVATIVES, of);
        CHECK(of[3] == (pulls ? -3.0 : 3.0), "f' / m");
        CHECK(next_touch(&pair, 9.0) == !pulls, "pressed on, or drawn off");
        CHECK(pulls || pair.time == 0.0, "at once");
    }
}

static void the_third_derivative_is_the_slope_of_the_second(void)
{
    const double omega = 50.0, decay = 7.0, x = 3e-3, v = 0.2, f = 4.0, slope = 90.0;
    plant p = {.bodies = 0};
    part *bob = add_rigid(&p, 2.0, v);
    bob->omega[0] = omega;
    bob->damped = 1;
    bob->decay[0] = decay;
    bob->load_count = 2;
    bob->load_time[1] = 1.0;
    bob->load_force[0] = f;
    bob->load_force[1] = f + slope;
    bob->x[0] = x;
    add_wall(&p);
    aoi_free_pair pair = pair_of(&p, 0.0);
    const double a = f / 2.0 - 2.0 * decay * v - omega * omega * x;
    double of[AOI_DERIVATIVES + 1];
    aoi_free_pair_motion(&pair, AOI_DERIVATIVES, of);
    CHECK(near(of[2], a, 1e-14), "of the motion's equation: %.17g", of[2]);
    CHECK(near(of[3], slope / 2.0 - 2.0 * decay * a - omega * omega * v, 1e-14), "%.17g", of[3]);
}

/* Far faster than the load rises, a sprung mass follows it: x = f' t / (m omega^2), but for its ripple. */
static void a_stiff_mass_creeps_up_with_its_load(void)
{
    plant p = {.bodies = 0};
    part *bob = add_rigid(&p, 2.0, 0.0);
    bob->omega[0] = 1e4;
    bob->load_count = 2;
    bob->load_time[1] = 10.0;
    bob->load_force[1] = 1e4;
    bob->v[0] = 1e3 / (2.0 * 1e8); /* no ripple */
    add_wall(&p);
    aoi_free_pair pair = pair_of(&p, 2.5e-5);
    CHECK(next_touch(&pair, 9.0) == 1, "it touches");
    CHECK(near(pair.time, 5.0, 1e-9), "after gap m omega^2 / f': %.17g", pair.time);
}

/* Nor does what no mode has wait: residual compliance R moves with R f'. */
static void residual_compliance_creeps_up_with_its_load(void)
{
    plant p = {.bodies = 0};
    part *held = add_rigid(&p, 2.0, 0.0);
    held->omega[0] = 1e4;
    held->push[0] = 0.0;
    held->massless = 1;
    held->residual[0] = 1e-8;
    held->load_count = 2;
    held->load_time[1] = 10.0;
    held->load_force[1] = 1e4;
    add_wall(&p);
    aoi_free_pair pair = pair_of(&p, 4e-5);
    CHECK(next_touch(&pair, 9.0) == 1 && near(pair.time, 4.0, 1e-12), "after gap / (R f'): %.17g", pair.time);
}

/* Fast small ripples on a slow drift: the first touch lasts a millionth of the record. */
static void a_touch_by_one_ripple_is_not_stepped_over(void)
{
    uint64_t seed = 11;
    for (int run = 0; run < 25; run++) {
        plant p = {.bodies = 0};
        double highest = -1.0, crest = 0.0;
        for (int b = 0; b < 2; b++) { /* both ring */
            part *of = add_ringing(&p, 6, 1, 1.0, 1.0, 0.0, &seed);
            for (size_t j = 1; j < of->n; j++) {
                of->omega[j] = of->omega[j - 1] + decades(&seed, 0.0, 3.0);
                of->v[j] = of->omega[j] * decades(&seed, -4.0, 0.0);
            }
        }
        /* The highest point over a grid far finer than the fastest ripple sets the gap below it. */
        lay_out(&p);
        const double fastest = fmax(p.part[0].omega[5], p.part[1].omega[5]);
        const double end = fmin(3.0, 3e3 / fastest), step = 0.05 / fastest;
        for (double t = 0.0; t < end; t += step) {
            double sum = 0.0;
            for (size_t k = 0; k < 12; k++) {
                const part *of = &p.part[k / 6];
                const double omega = of->omega[k % 6], share = k < 6 ? of->shape[k] : -of->shape[k - 6];
                sum += omega > 0.0 ? share * of->v[k % 6] / omega * sin(omega * t) : 0.0;
            }
            if (sum > highest) {
                highest = sum;
                crest = t;
            }
        }
        aoi_free_pair pair = pair_of(&p, highest * (1.0 - 1e-6));
        CHECK(next_touch(&pair, end) == 1, "run %d: a touch at %g", run, crest);
        CHECK(pair.time <= crest + step, "run %d: no later than the highest crest", run);
        CHECK(fabs(indentation_of(&pair)) < 1e-12, "run %d: touching", run);
    }
}

/* One that has just let go, at zero to rounding, does not touch again at once. */
static void bodies_that_part_are_apart(void)
{
    plant p = thrown(-1e-3, 0.0);
    p.part[0].x[0] = 1e-17;
    p.part[1].x[0] = 1.0;
    p.part[0].x[0] += 1.0;
    aoi_free_pair pair = pair_of(&p, -4e-17);
    CHECK(next_touch(&pair, 1.0) == 0 && pair.time == 1.0, "they part for good");
}

/* Two masses that fall from rest, slowed by drag: v = g/(2 sigma) (1 - e^(-2 sigma t)) of each. */
static plant falling(double decay, double other_decay)
{
    const double decays[] = {decay, other_decay};
    plant p = {.bodies = 0};
    for (int i = 0; i < 2; i++) {
        part *ball = add_rigid(&p, 0.1, 0.0);
        ball->pulled = ball->damped = 1;
        ball->gravity[0] = 9.81;
        ball->decay[0] = decays[i];
    }
    return p;
}

static void bodies_that_fall_side_by_side_do_not_press(void)
{
    int touches = -1;
    plant p = falling(35.0, 35.0);
    aoi_free_pair pair = pair_of(&p, 0.0);
    CHECK(aoi_free_pair_next_touch(&pair, 1.0, 100, &touches) == AOI_OK, "in a few strides");
    CHECK(touches == 0 && pair.time == 1.0, "the whole record flown");
}

static double fallen(double decay, double time)
{
    return 9.81 / (2.0 * decay) * (time + expm1(-2.0 * decay * time) / (2.0 * decay));
}

static void the_one_with_less_drag_catches_up(void)
{
    plant p = falling(1.0, 35.0);
    aoi_free_pair pair = pair_of(&p, 0.01);
    CHECK(next_touch(&pair, 1.0) == 1, "it does");
    CHECK(near(fallen(1.0, pair.time) - fallen(35.0, pair.time), 0.01, 1e-12), "when: %.17g", pair.time);
}

/* What contact forces make of an indentation has its share in all derivatives: of a cosine. */
static void a_forced_part_moves_with_the_rest(void)
{
    double values[AOI_NODES + 1] = {0.3};
    for (size_t i = 0; i < AOI_NODES; i++) {
        values[i + 1] = 0.3 * cos(2.0 * aoi_radau_node[i]);
    }
    aoi_forced forced;
    aoi_forced_fit(1.0, 0.5, values, &forced);
    plant p = thrown(0.0, 0.0);
    aoi_free_pair pair = pair_of(&p, 0.1);
    pair.forced = &forced;
    for (int i = 1; i < 10; i++) { /* cos(4 (t - 1)) */
        const double at = 0.2 * i, c = cos(at), s = sin(at);
        const double wanted[] = {0.3 * c - 0.1, -1.2 * s, -4.8 * c, 19.2 * s}, error[] = {1e-7, 1e-5, 1e-3, 0.05};
        double of[AOI_DERIVATIVES + 1];
        pair.time = 1.0 + at / 4.0;
        aoi_free_pair_motion(&pair, AOI_DERIVATIVES, of);
        for (int k = 0; k <= AOI_DERIVATIVES; k++) {
            CHECK(fabs(of[k] - wanted[k]) < error[k], "derivative %d at %g: %g", k, at, of[k]);
        }
        CHECK(fabs(of[2]) <= forced.bend, "no larger than its bound");
    }
}

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
    CHECK(near(x, 1.0 + 10.0 - 0.5 * 9.81 * 25.0 + (1.0 + 6.0 + 18.0 - 6.0) / 2.0, 1e-14), "place: %.16g", x);
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

int main(void)
{
    a_thrown_ball_lands_where_it_must();
    a_ball_thrown_up_comes_back();
    a_ball_beside_the_wall_is_pressed_at_once();
    tops_are_reached_and_not_passed();
    what_gravity_draws_away_goes();
    a_load_that_rises_pushes_a_ball_against_the_wall();
    a_load_that_begins_at_touch_presses();
    a_forced_part_moves_with_the_rest();
    the_third_derivative_is_the_slope_of_the_second();
    a_stiff_mass_creeps_up_with_its_load();
    residual_compliance_creeps_up_with_its_load();
    a_touch_by_one_ripple_is_not_stepped_over();
    bodies_that_part_are_apart();
    bodies_that_fall_side_by_side_do_not_press();
    the_one_with_less_drag_catches_up();
    a_loaded_mass_flies_by_the_integrals_of_its_load();
    free_motion_is_that_of_runge_and_kutta();
    return check_report();
}
