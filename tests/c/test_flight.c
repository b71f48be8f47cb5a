/* Free flight: its closed form, and that no touch is stepped over, however briefly it lasts. */
#include "check.h"

enum { MOST = 40, STRIDES = 1000000 };

typedef struct scene {
    double omega[MOST], weight[MOST], load[MOST], x[MOST], v[MOST];
    size_t order[MOST], n;
    aoi_relative relative;
} scene;

static void finish(scene *s, double gap)
{
    for (size_t j = 0; j < s->n; j++) {
        s->weight[j] = 1.0;
        s->order[j] = j; /* made in order of omega */
    }
    s->relative = (aoi_relative){s->n, s->n, s->omega, s->weight, s->load, {0.0, 0.0}, gap};
}

static int next_touch(scene *s, double limit, double *flown)
{
    int touches = -1;
    const int status = aoi_relative_next_touch(&s->relative, s->order, limit, STRIDES, s->x, s->v,
                                               flown, &touches);
    CHECK(status == AOI_OK, "the search ends");
    return touches;
}

static void a_thrown_ball_lands_where_it_must(void)
{
    /* delta = -h + v t + g t^2 / 2 */
    scene s = {.n = 1};
    double flown;
    s.v[0] = 3.0;
    s.load[0] = 9.81;
    finish(&s, 2.0);
    CHECK(next_touch(&s, 10.0, &flown) == 1, "it lands");
    CHECK(near(flown, (sqrt(9.0 + 2.0 * 9.81 * 2.0) - 3.0) / 9.81, 1e-14), "when: %.17g", flown);
    CHECK(near(s.v[0], 3.0 + 9.81 * flown, 1e-14), "how fast");
}

static void a_ball_thrown_up_comes_back(void)
{
    scene s = {.n = 1};
    double flown;
    s.v[0] = -3.0; /* away from contact at delta = 0 */
    s.load[0] = 9.81;
    finish(&s, 0.0);
    CHECK(next_touch(&s, 10.0, &flown) == 1, "it comes back");
    CHECK(near(flown, 6.0 / 9.81, 1e-13), "after 2 v / g: %.17g", flown);
}

static void a_crest_just_below_the_gap_is_passed_and_just_above_is_hit(void)
{
    for (int above = 0; above < 2; above++) {
        scene s = {.n = 1};
        double flown;
        s.omega[0] = 100.0;
        s.v[0] = 100.0; /* amplitude 1 */
        finish(&s, above ? 1.0 - 1e-12 : 1.0 + 1e-12);
        CHECK(next_touch(&s, 1.0, &flown) == above, "crest and gap differ by 1e-12");
        if (above) {
            CHECK(near(flown, (PI / 2.0 - sqrt(2e-12)) / 100.0, 1e-7), "at the crest: %.17g", flown);
        } else {
            CHECK(flown == 1.0, "the whole record flown");
        }
    }
}

/* Fast small ripples on a slow drift: the first touch lasts a millionth of the record. */
static void a_touch_by_one_ripple_is_not_stepped_over(void)
{
    uint64_t seed = 11;
    for (int run = 0; run < 25; run++) {
        scene s = {.n = 12};
        double flown, highest = -1.0, gap;
        for (size_t j = 1; j < s.n; j++) {
            s.omega[j] = s.omega[j - 1] + decades(&seed, 0.0, 3.0);
            s.v[j] = s.omega[j] * decades(&seed, -4.0, 0.0);
        }
        /* The highest point over a grid far finer than the fastest ripple sets the gap below it. */
        const double end = 3.0, step = 0.05 / s.omega[s.n - 1];
        double crest = 0.0;
        for (double t = 0.0; t < end; t += step) {
            double sum = 0.0;
            for (size_t j = 1; j < s.n; j++) {
                sum += s.v[j] / s.omega[j] * sin(s.omega[j] * t);
            }
            if (sum > highest) {
                highest = sum;
                crest = t;
            }
        }
        gap = highest * (1.0 - 1e-6);
        finish(&s, gap);
        CHECK(next_touch(&s, end, &flown) == 1, "run %d: a touch at %g", run, crest);
        CHECK(flown <= crest + step, "run %d: the first touch is not after the highest crest", run);
        double indentation, rate;
        aoi_relative_indentation(&s.relative, s.x, s.v, &indentation, &rate);
        CHECK(fabs(indentation) < 1e-12 && rate > 0.0, "run %d: touching, and rising", run);
    }
}

static void energy_of_flight_is_constant(void)
{
    scene s = {.n = 5};
    double before = 0.0, after = 0.0;
    for (size_t j = 0; j < s.n; j++) {
        s.omega[j] = pow(10.0, (double)j);
        s.x[j] = 0.1;
        s.v[j] = 0.7;
        before += s.v[j] * s.v[j] + s.omega[j] * s.omega[j] * s.x[j] * s.x[j];
    }
    finish(&s, 0.0);
    for (int i = 0; i < 1000; i++) {
        aoi_relative_fly(&s.relative, 0.123, s.x, s.v);
    }
    for (size_t j = 0; j < s.n; j++) {
        after += s.v[j] * s.v[j] + s.omega[j] * s.omega[j] * s.x[j] * s.x[j];
    }
    CHECK(near(after, before, 1e-12), "energy %.17g, not %.17g", after, before);
}

static void bodies_that_part_for_good_cost_nothing(void)
{
    scene s = {.n = 3};
    double flown;
    s.v[0] = -1.0;
    s.omega[1] = 1e6;
    s.omega[2] = 1e9;
    s.x[1] = s.x[2] = -1e-6;
    finish(&s, 0.0);
    int touches;
    CHECK(aoi_relative_next_touch(&s.relative, s.order, 1e9, 100, s.x, s.v, &flown, &touches) ==
                  AOI_OK &&
              touches == 0 && flown == 1e9,
          "thirty years of flight in a hundred strides");
}

int main(void)
{
    a_thrown_ball_lands_where_it_must();
    a_ball_thrown_up_comes_back();
    a_crest_just_below_the_gap_is_passed_and_just_above_is_hit();
    a_touch_by_one_ripple_is_not_stepped_over();
    energy_of_flight_is_constant();
    bodies_that_part_for_good_cost_nothing();
    return check_report();
}
