/* Friction of an elastic contact: closed forms of Cattaneo, Mindlin and Deresiewicz, Coulomb's law, one spring alone. */
#include "check.h"
#include "aoimpact.h"

enum { ROOM = 200 };

static const double K = 1.0878566e10, DEEP = 2e-6, MU = 0.3, RATIO = 0.82;

typedef struct contact {
    aoi_law law;
    aoi_friction friction;
    aoi_friction_state state;
    aoi_stretch spring[ROOM], spare[ROOM];
    int status; /* of the last move */
} contact;

/* Bodies that are just about to touch. */
static void begin(contact *c, const char *name, double mu, double precision, size_t room)
{
    CHECK(aoi_law_create(&c->law, name, 1, &K) == AOI_OK, "the law %s", name);
    CHECK(aoi_friction_create(&c->friction, &c->law, mu, RATIO, precision) == AOI_OK, "friction %g", mu);
    const aoi_friction_state none = {room, 0, c->spring, c->spare, 0.0, 0.0, 0.0};
    c->state = none;
}

static double normal(const contact *c, double depth)
{
    aoi_law_value value;
    aoi_law_push(&c->law, NULL, depth, 0.0, &value);
    return value.force;
}

static double energy_of(const contact *c, double depth)
{
    return depth > 0.0 ? aoi_law_potential(&c->law, NULL, depth) : 0.0;
}

/* Moves on, and gives what is there then. */
static aoi_friction_value go(contact *c, double depth, double x, double y)
{
    const double slide[2] = {x, y};
    aoi_friction_value value;
    c->status = aoi_friction_refine(&c->friction, &c->state, depth, 1.0, slide);
    aoi_friction_try(&c->friction, &c->state, depth, 1.0, slide, &value);
    c->status = c->status == AOI_OK ? aoi_friction_move(&c->friction, &c->state, depth, 1.0, slide) : c->status;
    return value;
}

/* Cattaneo's loading by a slide at constant indentation: T = mu (F(d) - F(d - u/slope)). */
static double cattaneo(const contact *c, double slide)
{
    return MU * (normal(c, DEEP) - normal(c, DEEP - slide * RATIO / MU));
}

static void a_loop_is_that_of_mindlin_and_deresiewicz(void)
{
    const double largest = MU / RATIO * DEEP;
    for (double share = 0.05; share < 1.0; share += 0.05) {
        contact c;
        begin(&c, "hertz", MU, 1e-4, 8);
        (void)go(&c, DEEP, 0.0, 0.0);
        /* along a direction that is not an axis */
        const double u = share * largest, x = u * 0.8, y = u * 0.6;
        const double loaded = cattaneo(&c, u), most = MU * normal(&c, DEEP);
        aoi_friction_value value = go(&c, DEEP, x, y);
        CHECK(near(value.force[0], 0.8 * loaded, 1e-13) && near(value.force[1], 0.6 * loaded, 1e-13),
              "loading by %g", share);
        CHECK(near(value.stuck, DEEP - u * RATIO / MU, 1e-12), "slip to a depth, %g", share);
        for (int i = 1; i <= 8; i++) {
            value = go(&c, DEEP, -x / 4.0, -y / 4.0);
            const double back = loaded - 2.0 * cattaneo(&c, u * i / 8.0);
            CHECK(fabs(value.force[0] - 0.8 * back) < 2e-13 * most, "unloading from %g, %d/8", share, i);
        }
        for (int i = 1; i <= 8; i++) {
            value = go(&c, DEEP, x / 4.0, y / 4.0);
            const double again = -loaded + 2.0 * cattaneo(&c, u * i / 8.0);
            CHECK(fabs(value.force[1] - 0.6 * again) < 2e-13 * most, "loading again to %g, %d/8", share, i);
        }
        /* A loop within the loop leaves no trace once it is closed. */
        (void)go(&c, DEEP, -x, -y);
        (void)go(&c, DEEP, 0.5 * x, 0.5 * y);
        (void)go(&c, DEEP, -0.5 * x, -0.5 * y);
        value = go(&c, DEEP, -x, -y);
        CHECK(near(value.force[0], -0.8 * loaded, 1e-12), "a closed inner loop, %g", share);
    }
}

/* What a loop dissipates: the integral of its force, by the potential of the law. */
static void a_loop_dissipates_its_area(void)
{
    contact c;
    begin(&c, "hertz", MU, 1e-4, 16);
    (void)go(&c, DEEP, 0.0, 0.0);
    const double slope = MU / RATIO, u = 0.7 * slope * DEEP;
    (void)go(&c, DEEP, u, 0.0);
    const double stored = aoi_friction_energy(&c.friction, &c.state);
    const double work = MU * (u * normal(&c, DEEP) - slope * (energy_of(&c, DEEP) - energy_of(&c, DEEP - u / slope)));
    CHECK(stored > 0.0 && stored < work, "part of the work is stored");
    (void)go(&c, DEEP, -2.0 * u, 0.0);
    CHECK(near(aoi_friction_energy(&c.friction, &c.state), stored, 1e-12), "as much is stored at the other end");
    /* K. L. Johnson, Contact Mechanics, section 7.4: a cycle between the forces -T and T. */
    const double P = normal(&c, DEEP), T = cattaneo(&c, u), q = T / (MU * P), stiffness = RATIO * 1.5 * P / DEEP;
    const double cycle = 7.2 * MU * MU * P * P / stiffness *
                         (1.0 - pow(1.0 - q, 5.0 / 3.0) - 5.0 * q / 6.0 * (1.0 + pow(1.0 - q, 2.0 / 3.0)));
    double done = 0.0, before = -T;
    enum { STEPS = 4000 };
    for (int i = 0; i < STEPS; i++) {
        const double force = go(&c, DEEP, 2.0 * u / STEPS, 0.0).force[0];
        done += 0.5 * (force + before) * 2.0 * u / STEPS;
        before = force;
    }
    CHECK(near(2.0 * done, cycle, 1e-6), "the work of a cycle, %g of %g J", 2.0 * done, cycle);
    CHECK(near(aoi_friction_energy(&c.friction, &c.state), stored, 1e-9), "as much is stored again");
}

static void all_slips_with_coulombs_force(void)
{
    contact c;
    begin(&c, "hertz", MU, 1e-4, 16);
    for (int i = 1; i <= 20; i++) {
        const double depth = DEEP * sin(PI * i / 21.0);
        const aoi_friction_value value = go(&c, depth, 3.0 * DEEP, -4.0 * DEEP);
        CHECK(near(value.force[0], 0.6 * MU * normal(&c, depth), 1e-13) &&
                  near(value.force[1], -0.8 * MU * normal(&c, depth), 1e-13), "sliding at %g m", depth);
        CHECK(value.stuck == 0.0, "nothing sticks");
        CHECK(c.state.count <= 3, "one straight curve of %zu springs", c.state.count);
    }
}

/* A slide of any size, down to 1e-10 of Coulomb's bound, is the same in its own scale: all but the rim sticks. */
static void small_slides_are_as_exact_as_large_ones(void)
{
    double wanted[3] = {0.0, 0.0, 0.0};
    for (double size = 1e-4; size > 5e-11; size *= 0.01) {
        contact c;
        begin(&c, "hertz", MU, 1e-4, ROOM);
        const double unit = size * MU / RATIO * DEEP;
        aoi_friction_value value = {.stuck = 0.0};
        for (int i = 1; i <= 60; i++) {
            value = go(&c, DEEP * sin(PI * i / 64.0), unit * cos(PI * i / 50.0) / 60.0, 0.0);
            CHECK(c.status == AOI_OK, "room for %zu springs", c.state.count);
            if (i % 20 == 0) {
                const double found = value.force[0] / size, *of = &wanted[i / 20 - 1];
                wanted[i / 20 - 1] = size == 1e-4 ? found : *of;
                CHECK(fabs(found - *of) < 1e-4 * fabs(wanted[0]), "%g: %g at step %d, not %g", size, found, i, *of);
            }
        }
    }
}

/* Below the angle of friction a growing force sticks all over, and can be taken back (Mindlin and Deresiewicz). */
static void an_oblique_force_within_the_angle_of_friction_sticks(void)
{
    contact c;
    begin(&c, "hertz", MU, 1e-4, 16);
    const double slope = 0.9 * MU / RATIO;
    for (int i = 1; i <= 40; i++) {
        const int up = i <= 20;
        const double depth = DEEP * (up ? i : 40 - i) / 20.0, slide = (up ? 1.0 : -1.0) * slope * DEEP / 20.0;
        const aoi_friction_value value = go(&c, depth, slide, 0.0);
        CHECK(fabs(value.force[0] - RATIO * slope * normal(&c, depth)) < 1e-12 * normal(&c, DEEP), "at %g m", depth);
        CHECK(fabs(aoi_friction_energy(&c.friction, &c.state) - RATIO * slope * slope * energy_of(&c, depth)) <
                  1e-12 * energy_of(&c, DEEP), "energy at %g m", depth);
    }
    CHECK(c.state.count == 0, "apart");
}

/* A tangential load after a normal one, and a larger normal load then: less is needed to hold the same slip. Coulomb's
 * bound grows everywhere, so that all sticks, with Mindlin's stiffness. */
static void a_growing_normal_force_stops_slip(void)
{
    contact c;
    begin(&c, "hertz", MU, 1e-4, 16);
    (void)go(&c, DEEP, 0.0, 0.0);
    const double u = 0.5 * MU / RATIO * DEEP;
    const double held = go(&c, DEEP, u, 0.0).force[0];
    const aoi_friction_value value = go(&c, 1.5 * DEEP, 0.0, 0.0);
    CHECK(near(value.force[0], held, 1e-13) && value.stuck == 1.5 * DEEP, "held as it was");
    const double small = 1e-6 * u, more = go(&c, 1.5 * DEEP, small, 0.0).force[0] - held;
    CHECK(near(more / small, RATIO * 1.5 * K * sqrt(1.5 * DEEP), 1e-5), "Mindlin's stiffness");
}

/* A linear law has one spring, which turns as dn/dt = (I - n n) u/r: by small steps of the rates themselves. */
static void a_spring_turns_towards_the_slide(void)
{
    const struct {
        double end, x, y;
    } paths[] = {{1.0, 0.3, 1.0}, {1.3, -0.4, 0.9}, {0.6, 0.2, 0.7}, {0.4, -0.3, 0.02}, {1.0, -2.5, 0.4}};
    for (size_t i = 0; i < sizeof paths / sizeof paths[0]; i++) {
        contact c;
        begin(&c, "linear", MU, 1e-4, 16);
        const double slope = MU / RATIO, unit = slope * DEEP;
        (void)go(&c, DEEP, 0.9 * unit, 0.0);
        const double x = paths[i].x * unit, y = paths[i].y * unit, end = paths[i].end * DEEP;
        double s[2] = {0.9 * unit, 0.0};
        enum { STEPS = 2000000 };
        for (int step = 1; step <= STEPS; step++) {
            const double bound = slope * (DEEP + (end - DEEP) * step / STEPS);
            s[0] += x / STEPS;
            s[1] += y / STEPS;
            const double size = hypot(s[0], s[1]), back = size > bound ? bound / size : 1.0;
            s[0] *= back;
            s[1] *= back;
        }
        const aoi_friction_value value = go(&c, end, x, y);
        const double found[2] = {value.force[0] / (RATIO * K), value.force[1] / (RATIO * K)};
        CHECK(fabs(found[0] - s[0]) < 4e-6 * unit && fabs(found[1] - s[1]) < 4e-6 * unit,
              "path %zu: %g, %g and %g, %g", i, found[0] / unit, found[1] / unit, s[0] / unit, s[1] / unit);
    }
}

/* All slips along one direction, then across it by u: the spring of depth x turns by tan(angle/2) = exp(-u/r). Two springs
 * stand for the contact before, and others are put between. */
static void a_sliding_contact_turns_spring_by_spring(void)
{
    const double slope = MU / RATIO;
    for (double share = 0.02; share < 3.0; share *= 3.0) {
        const double u = share * slope * DEEP;
        double sum[2] = {0.0, 0.0};
        enum { PARTS = 20000 }; /* even in the root of the depth, where dK is even: the midpoint rule */
        for (int i = 0; i < PARTS; i++) {
            const double root = (i + 0.5) / PARTS, r = slope * DEEP * (1.0 - root * root);
            const double angle = 2.0 * atan(exp(-u / r));
            sum[0] += r * sin(angle) / PARTS;
            sum[1] += r * cos(angle) / PARTS;
        }
        for (double precision = 1e-2; precision > 2e-4; precision *= 0.2) {
            contact c;
            begin(&c, "hertz", MU, precision, ROOM);
            (void)go(&c, DEEP, 5.0 * slope * DEEP, 0.0);
            CHECK(c.state.count == 2, "one straight curve");
            const aoi_friction_value value = go(&c, DEEP, 0.0, u);
            const double stiffness = RATIO * 1.5 * K * sqrt(DEEP), most = MU * normal(&c, DEEP);
            const double off = hypot(value.force[0] - stiffness * sum[0], value.force[1] - stiffness * sum[1]) / most;
            CHECK(off < precision, "turned by %g: off by %g with precision %g", share, off, precision);
        }
    }
}

static void derivatives_are_those_of_the_force(void)
{
    uint64_t seed = 5;
    for (int i = 0; i < 300; i++) {
        contact c;
        begin(&c, i % 3 ? "hertz" : "linear", MU, 1e-3, ROOM);
        const double unit = MU / RATIO * DEEP;
        const int straight = i % 2;
        for (int turn = 0; turn < 6; turn++) {
            const double to = DEEP * (0.2 + uniform(&seed)), x = unit * (uniform(&seed) - 0.5);
            (void)go(&c, to, x, straight ? 0.0 : unit * (uniform(&seed) - 0.5));
        }
        const double depth = DEEP * (0.2 + uniform(&seed)), h = 1e-7 * unit;
        const double slide[2] = {unit * (uniform(&seed) - 0.5), straight ? 0.0 : unit * (uniform(&seed) - 0.5)};
        aoi_friction_value at, low, high;
        aoi_friction_try(&c.friction, &c.state, depth, 1.0, slide, &at);
        const double stiff = RATIO * 1.5 * normal(&c, DEEP) / DEEP;
        for (int j = 0; j < 3; j++) {
            const double x = j == 0 ? h : 0.0, y = j == 1 ? h : 0.0, z = j == 2 ? h : 0.0;
            const double less[2] = {slide[0] - x, slide[1] - y}, more[2] = {slide[0] + x, slide[1] + y};
            aoi_friction_try(&c.friction, &c.state, depth - z, 1.0, less, &low);
            aoi_friction_try(&c.friction, &c.state, depth + z, 1.0, more, &high);
            for (int k = 0; k < 2; k++) {
                const double slope = (high.force[k] - low.force[k]) / (2.0 * h);
                const double found = j < 2 ? at.by_slide[k][j] : at.by_indentation[k];
                /* How a turn depends on the indentation is left out. */
                CHECK(fabs(slope - found) < (j < 2 || straight ? 2e-5 : 0.1) * stiff,
                      "case %d: d T%d / d x%d is %g, not %g", i, k, j, slope / stiff, found / stiff);
            }
        }
    }
}

/* Any motion, in little room: nothing is written beyond it, the force is within Coulomb's bound, and a state that finds
 * no room stays as it is. */
static void any_motion_keeps_to_coulomb_and_to_the_room(void)
{
    uint64_t seed = 23;
    int full = 0;
    for (int i = 0; i < 200; i++) {
        contact c;
        const size_t room = 8 + (size_t)(uniform(&seed) * 40.0);
        begin(&c, i % 4 ? "hertz" : "linear", MU, decades(&seed, -8.0, -1.0), room);
        const double unit = MU / RATIO * DEEP, size = decades(&seed, -3.0, 1.0);
        double depth = 0.0;
        for (int step = 0; step < 400; step++) {
            depth += 0.2 * size * DEEP * (uniform(&seed) - 0.45);
            depth = depth > 1.2 * DEEP ? DEEP : depth < -0.1 * DEEP ? 0.01 * DEEP : depth;
            const double dx = size * unit * (uniform(&seed) - 0.5), dy = size * unit * (uniform(&seed) - 0.5);
            const aoi_friction_value value = go(&c, depth, dx, dy);
            const double most = MU * normal(&c, depth);
            CHECK(hypot(value.force[0], value.force[1]) <= most * (1.0 + 1e-9), "%g of Coulomb's force",
                  hypot(value.force[0], value.force[1]) / most);
            CHECK(c.state.count <= room && (c.state.count == 0) == !(c.state.indentation > 0.0), "%zu springs",
                  c.state.count);
            CHECK(aoi_friction_energy(&c.friction, &c.state) >= -1e-12 * most * unit, "energy");
            CHECK(c.status == AOI_OK ? c.state.indentation == depth : c.status == AOI_ERROR_SPRINGS, "moved");
            if (c.status != AOI_OK) {
                full++;
                c.state.count = 0;
                c.state.indentation = 0.0;
            }
        }
    }
    CHECK(full > 100, "%d times without room", full);
}

/* Numbers at the ends of their range end nothing but in numbers. */
static void extreme_numbers_do_no_harm(void)
{
    const double sizes[] = {SMALLEST, 1e-310, 1e-160, 1e-20, 1e20, 1e160, DBL_MAX, HUGE_VAL, (double)NAN};
    enum { SIZES = sizeof sizes / sizeof sizes[0] };
    for (size_t i = 0; i < (size_t)SIZES * SIZES * SIZES; i++) {
        const double a = sizes[i % SIZES], b = sizes[i / SIZES % SIZES], d = sizes[i / SIZES / SIZES];
        contact c;
        begin(&c, "hertz", MU, 1e-4, 8);
        (void)go(&c, DEEP, 0.1 * DEEP, 0.0);
        (void)go(&c, d, a, b);
        (void)go(&c, DEEP, -a, a);
        (void)go(&c, d, b, -a);
        (void)go(&c, 0.5 * d, b, a);
        CHECK(c.state.count <= 8, "%zu springs", c.state.count);
    }
}

/* What the work of the force leaves over the stored energy has been dissipated: never less than before, in any motion. */
static void friction_only_dissipates(void)
{
    uint64_t seed = 31;
    for (int i = 0; i < 30; i++) {
        contact c;
        begin(&c, i % 3 ? "hertz" : "linear", MU, 1e-4, ROOM);
        const double unit = MU / RATIO * DEEP, scale = MU * normal(&c, DEEP) * unit;
        const int straight = i % 2;
        double depth = 0.0, force[2] = {0.0, 0.0}, dissipated = 0.0;
        for (int leg = 0; leg < 8; leg++) {
            enum { PARTS = 300 };
            const double to = DEEP * uniform(&seed), x = unit * (2.0 * uniform(&seed) - 1.0) / PARTS;
            const double y = straight ? 0.0 : unit * (2.0 * uniform(&seed) - 1.0) / PARTS;
            double lost = aoi_friction_energy(&c.friction, &c.state);
            for (int part = 1; part <= PARTS; part++) {
                const aoi_friction_value value = go(&c, depth + (to - depth) * part / PARTS, x, y);
                lost += 0.5 * ((value.force[0] + force[0]) * x + (value.force[1] + force[1]) * y);
                force[0] = value.force[0];
                force[1] = value.force[1];
            }
            depth = to;
            lost -= aoi_friction_energy(&c.friction, &c.state);
            CHECK(lost > -1e-5 * scale, "motion %d, leg %d: %g of the scale", i, leg, lost / scale);
            dissipated += lost;
        }
        CHECK(dissipated > 0.1 * scale, "much has been dissipated: %g", dissipated / scale);
    }
}

static void remember_nothing(const aoi_law *law, double indentation, double rate, double *memory)
{
    (void)law;
    (void)indentation;
    (void)rate;
    (void)memory;
}

/* Friction is of the law's own indentation, whatever is taken out of the law elsewhere. */
static void the_compliance_of_a_mesh_is_left_out(void)
{
    contact c, d;
    begin(&c, "hertz", MU, 1e-4, 16);
    begin(&d, "hertz", MU, 1e-4, 16);
    d.law.compliance = 0.1 / (1.5 * K * sqrt(DEEP));
    d.law.limit = 0.5 * DEEP;
    CHECK(aoi_friction_create(&d.friction, &d.law, MU, RATIO, 1e-4) == AOI_OK, "a law with a compliance");
    const double u = 0.5 * MU / RATIO * DEEP;
    CHECK(go(&c, DEEP, u, 0.0).force[0] == go(&d, DEEP, u, 0.0).force[0], "the same force");
}

static void what_remembers_or_pulls_is_refused(void)
{
    aoi_law law;
    aoi_friction friction;
    const double damped[] = {K, 0.1}, plastic[] = {K, 100.0};
    CHECK(aoi_law_create(&law, "kelvin_voigt_pulling", 2, damped) == AOI_OK, "a law that pulls");
    CHECK(aoi_friction_create(&friction, &law, MU, RATIO, 1e-4) == AOI_ERROR_FRICTION, "pulls");
    CHECK(aoi_law_create(&law, "thornton", 2, plastic) == AOI_OK, "a plastic law");
    CHECK(aoi_friction_create(&friction, &law, MU, RATIO, 1e-4) == AOI_ERROR_FRICTION, "has a memory");
    CHECK(aoi_law_create(&law, "hertz", 1, &K) == AOI_OK, "Hertz's law");
    law.remember = remember_nothing;
    CHECK(aoi_friction_create(&friction, &law, MU, RATIO, 1e-4) == AOI_ERROR_FRICTION, "a memory of the caller's");
    law.remember = NULL;
    const double wrong[][3] = {{-0.1, RATIO, 1e-4}, {(double)NAN, RATIO, 1e-4}, {MU, 0.0, 1e-4}, {MU, HUGE_VAL, 1e-4},
                               {MU, RATIO, 0.0}, {MU, RATIO, 0.2}, {MU, RATIO, (double)NAN}, {1e150, RATIO, 1e-4},
                               {MU, 1e-150, 1e-4}};
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; i++) {
        const double *w = wrong[i];
        CHECK(aoi_friction_create(&friction, &law, w[0], w[1], w[2]) == AOI_ERROR_ARGUMENT, "%zu", i);
    }
    CHECK(aoi_friction_create(NULL, &law, MU, RATIO, 1e-4) == AOI_ERROR_ARGUMENT, "no place");
    CHECK(aoi_friction_create(&friction, NULL, MU, RATIO, 1e-4) == AOI_ERROR_ARGUMENT, "no law");
}

/* Bodies that are apart touch on their way: only what is left of it then stretches springs. */
static void a_way_that_begins_apart_counts_from_the_touch(void)
{
    const double u = 0.3 * MU / RATIO * DEEP;
    contact near_by, apart;
    begin(&near_by, "hertz", MU, 1e-4, ROOM);
    begin(&apart, "hertz", MU, 1e-4, ROOM);
    apart.state.indentation = -3.0 * DEEP;
    const aoi_friction_value one = go(&near_by, DEEP, u, -0.5 * u), other = go(&apart, DEEP, 4.0 * u, -2.0 * u);
    for (size_t i = 0; i < 2; i++) {
        CHECK(near(one.force[i], other.force[i], 1e-14) && one.force[i] != 0.0, "along %zu: %g", i, other.force[i]);
    }
}

int main(void)
{
    a_way_that_begins_apart_counts_from_the_touch();
    a_loop_is_that_of_mindlin_and_deresiewicz();
    a_loop_dissipates_its_area();
    all_slips_with_coulombs_force();
    small_slides_are_as_exact_as_large_ones();
    an_oblique_force_within_the_angle_of_friction_sticks();
    a_growing_normal_force_stops_slip();
    a_spring_turns_towards_the_slide();
    a_sliding_contact_turns_spring_by_spring();
    derivatives_are_those_of_the_force();
    any_motion_keeps_to_coulomb_and_to_the_room();
    extreme_numbers_do_no_harm();
    friction_only_dissipates();
    the_compliance_of_a_mesh_is_left_out();
    what_remembers_or_pulls_is_refused();
    return check_report();
}
