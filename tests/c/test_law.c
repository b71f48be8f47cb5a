/* The contact laws: their formulas, what belongs together, and what cannot be. */
#include "check.h"

#include <string.h>

static aoi_law law_of(const char *name, double first, double second)
{
    const double parameter[] = {first, second};
    aoi_law law;
    const int status = aoi_law_create(&law, name, strcmp(name, "power") == 0 ? 2 : 1, parameter);
    CHECK(status == AOI_OK, "%s(%g, %g)", name, first, second);
    return law;
}

static double force_of(const aoi_law *law, double indentation)
{
    aoi_law_value value;
    law->force(law, indentation, 0.0, &value);
    return value.force;
}

static void forces_follow_their_formulas(void)
{
    const double k = 1.0878566e10;
    const aoi_law hertz = law_of("hertz", k, 0.0), linear = law_of("linear", k, 0.0);
    const aoi_law square_law = law_of("power", k, 2.0);
    for (double d = 1e-15; d < 1e3; d *= 3.7) {
        CHECK(near(force_of(&hertz, d), k * d * sqrt(d), 4e-16), "Hertz at %g m", d);
        CHECK(near(force_of(&linear, d), k * d, 2e-16), "linear at %g m", d);
        CHECK(near(force_of(&square_law, d), k * d * d, 8e-16), "square at %g m", d);
        CHECK(near(hertz.potential(&hertz, d), 0.4 * k * d * d * sqrt(d), 8e-16), "2/5 k d^(5/2)");
        CHECK(near(linear.potential(&linear, d), 0.5 * k * d * d, 8e-16), "1/2 k d^2");
        CHECK(near(square_law.potential(&square_law, d), k * d * d * d / 3.0, 8e-16), "1/3 k d^3");
    }
}

/* The power law with Hertz's exponent, or with 1, is the other law. */
static void laws_of_one_exponent_agree(void)
{
    const double k = 3e9;
    const struct {
        aoi_law one, other;
    } same[] = {{law_of("hertz", k, 0.0), law_of("power", k, 1.5)},
                {law_of("linear", k, 0.0), law_of("power", k, 1.0)}};
    for (size_t i = 0; i < 2; i++) {
        for (double d = 1e-12; d < 10.0; d *= 5.3) {
            aoi_law_value a, b;
            same[i].one.force(&same[i].one, d, 0.0, &a);
            same[i].other.force(&same[i].other, d, 0.0, &b);
            CHECK(near(a.force, b.force, 1e-15) && near(a.stiffness, b.stiffness, 1e-15),
                  "force and stiffness of pair %zu at %g m", i, d);
            CHECK(near(same[i].one.potential(&same[i].one, d),
                       same[i].other.potential(&same[i].other, d), 1e-15),
                  "energy of pair %zu at %g m", i, d);
        }
    }
}

/* d force / d indentation = n F / d, and the rate plays no part. */
static void stiffness_is_the_slope(void)
{
    const struct {
        const char *name;
        double n;
    } laws[] = {{"hertz", 1.5}, {"linear", 1.0}, {"power", 1.0}, {"power", 1.5}, {"power", 7.25}};
    for (size_t i = 0; i < sizeof laws / sizeof laws[0]; i++) {
        const aoi_law law = law_of(laws[i].name, 2.0, laws[i].n);
        for (double d = 1e-9; d < 100.0; d *= 11.0) {
            aoi_law_value value, moving;
            law.force(&law, d, 0.0, &value);
            law.force(&law, d, -123.0, &moving);
            CHECK(near(value.stiffness, laws[i].n * value.force / d, 1e-15), "%s at %g m",
                  laws[i].name, d);
            CHECK(value.damping == 0.0 && moving.damping == 0.0, "no damping");
            CHECK(moving.force == value.force && moving.stiffness == value.stiffness,
                  "whatever the rate");
        }
    }
}

static void no_force_without_contact(void)
{
    const double apart[] = {0.0, -0.0, -SMALLEST, -1e-9, -1.0, -1e300};
    const aoi_law laws[] = {law_of("hertz", 1e10, 0.0), law_of("linear", 1e10, 0.0),
                            law_of("power", 1e10, 1.0), law_of("power", 1e10, 3.0)};
    for (size_t i = 0; i < sizeof laws / sizeof laws[0]; i++) {
        for (size_t j = 0; j < sizeof apart / sizeof apart[0]; j++) {
            aoi_law_value value;
            laws[i].force(&laws[i], apart[j], -5.0, &value);
            CHECK(value.force == 0.0 && value.damping == 0.0, "law %zu pulls at %g m", i, apart[j]);
            CHECK(laws[i].potential(&laws[i], apart[j]) == 0.0, "law %zu stores at %g m", i,
                  apart[j]);
        }
    }
}

static void laws_that_cannot_be(void)
{
    const double nan = (double)NAN, inf = (double)INFINITY;
    const struct {
        const char *name;
        size_t count;
        double parameter[2];
    } bad[] = {
        {"hooke", 1, {1.0, 1.0}},   {"", 1, {1.0, 1.0}},          {"Hertz", 1, {1.0, 1.0}},
        {"hertz", 0, {1.0, 1.0}},   {"hertz", 2, {1.0, 1.0}},     {"power", 1, {1.0, 1.0}},
        {"power", 3, {1.0, 1.0}},   {"linear", 1000, {1.0, 1.0}}, {"hertz", 1, {0.0, 1.0}},
        {"hertz", 1, {-1.0, 1.0}},  {"hertz", 1, {nan, 1.0}},     {"hertz", 1, {inf, 1.0}},
        {"linear", 1, {-0.0, 1.0}}, {"linear", 1, {-inf, 1.0}},   {"power", 2, {1.0, 0.999}},
        {"power", 2, {1.0, nan}},   {"power", 2, {1.0, inf}},     {"power", 2, {1.0, -2.0}},
        {"power", 2, {0.0, 2.0}},   {"power", 2, {nan, 2.0}},
    };
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++) {
        aoi_law law;
        CHECK(aoi_law_create(&law, bad[i].name, bad[i].count, bad[i].parameter) ==
                  AOI_ERROR_ARGUMENT,
              "%s of %zu parameters %g, %g", bad[i].name, bad[i].count, bad[i].parameter[0],
              bad[i].parameter[1]);
    }
}

int main(void)
{
    forces_follow_their_formulas();
    laws_of_one_exponent_agree();
    stiffness_is_the_slope();
    no_force_without_contact();
    laws_that_cannot_be();
    return check_report();
}
