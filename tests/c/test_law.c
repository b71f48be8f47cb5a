/* The contact laws: their formulas, what belongs together, and what cannot be. */
#include "check.h"
#include "law/kinds.h"
#include "law/law.h"

#include <string.h>

/* How many parameters a law has; none of a name that is not among them. */
static size_t count_of(const char *name)
{
    for (size_t i = 0; i < aoi_laws_power_count; i++) {
        if (strcmp(aoi_laws_power[i].name, name) == 0) {
            return aoi_laws_power[i].count;
        }
    }
    return 0;
}

/* An elastic law; one of a single parameter leaves out the second. */
static aoi_law law_of(const char *name, double first, double second)
{
    const double parameter[] = {first, second};
    aoi_law law;
    const int status = aoi_law_create(&law, name, count_of(name), parameter);
    CHECK(status == AOI_OK, "%s(%g, %g)", name, first, second);
    return law;
}

static double force_of(const aoi_law *law, double indentation)
{
    aoi_law_value value;
    aoi_law_push(law, NULL, indentation, 0.0, &value);
    return value.force;
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
        {"thornton", 1, {1.0, 1.0}}, {"thornton", 2, {1.0, 0.0}},
        {"tsuji", 2, {1.0, -1e-300}}, {"kelvin_voigt", 2, {0.0, 1.0}},
        {"power", 2, {0.0, 2.0}},   {"power", 2, {nan, 2.0}},
    };
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++) {
        aoi_law law;
        CHECK(aoi_law_create(&law, bad[i].name, bad[i].count, bad[i].parameter) == AOI_ERROR_ARGUMENT,
              "%s of %zu parameters %g, %g", bad[i].name, bad[i].count, bad[i].parameter[0],
              bad[i].parameter[1]);
    }
}

/* One law of every kind, some with a compliance. */
typedef struct named {
    const char *name;
    size_t count;
    double parameter[3];
    double compliance;
} named;

static const named every[] = {
    {"hertz", 1, {1e10}, 0.0},
    {"power", 2, {1e11, 1.7}, 0.0},
    {"linear", 1, {3e7}, 0.0},
    {"hunt_crossley", 3, {1e10, 0.4, 1.5}, 0.0},
    {"hunt_crossley", 3, {1e11, 0.4, 1.7}, 0.0},
    {"tsuji", 2, {1e10, 3e3}, 0.0},
    {"kuwabara_kono", 2, {1e10, 2e-6}, 0.0},
    {"kelvin_voigt", 2, {3e7, 200.0}, 0.0},
    {"kelvin_voigt_pulling", 2, {3e7, 200.0}, 0.0},
    {"thornton", 2, {1e10, 100.0}, 0.0},
    {"elastic_plastic", 3, {1e10, 100.0, 1e8}, 0.0},
    {"yang_sun", 3, {1e10, 4e-6, 0.0}, 0.0},
    {"yang_sun", 3, {1e10, 4e-6, 0.1}, 0.0},
    {"hertz", 1, {1e10}, 2e-9},
    {"hunt_crossley", 3, {1e10, 0.4, 1.5}, 2e-9},
    {"tsuji", 2, {1e10, 3e3}, 2e-9},
    {"kelvin_voigt", 2, {3e7, 200.0}, 2e-9},
    {"thornton", 2, {1e10, 100.0}, 2e-9},
    {"elastic_plastic", 3, {1e10, 100.0, 1e8}, 2e-9},
    {"yang_sun", 3, {1e10, 4e-6, 0.0}, 2e-9},
    {"hertz", 1, {1e10}, -5e-9},
    {"hunt_crossley", 3, {1e10, 0.4, 1.5}, -5e-9},
    {"tsuji", 2, {1e10, 3e3}, -5e-9},
    {"kelvin_voigt", 2, {3e7, 200.0}, -5e-9},
    {"thornton", 2, {1e10, 100.0}, -5e-9},
    {"elastic_plastic", 3, {1e10, 100.0, 1e8}, -5e-9},
    {"yang_sun", 3, {1e10, 4e-6, 0.0}, -5e-9},
};
enum { EVERY = sizeof every / sizeof every[0] };

static aoi_law law_at(size_t i)
{
    aoi_law law;
    CHECK(aoi_law_create(&law, every[i].name, every[i].count, every[i].parameter) == AOI_OK, "%s", every[i].name);
    law.compliance = every[i].compliance;
    return law;
}

/* The first of them that has this name and this compliance. */
static aoi_law law_among(const char *name, double compliance)
{
    size_t i = 0;
    while (i + 1 < EVERY && (strcmp(every[i].name, name) != 0 || every[i].compliance != compliance)) {
        i++;
    }
    CHECK(strcmp(every[i].name, name) == 0, "%s is among them", name);
    return law_at(i);
}

static void laws_at_a_rate_follow_their_formulas(void)
{
    const double k = 1e10, v = 0.7;
    for (double d = 1e-9; d < 1e-3; d *= 3.1) {
        aoi_law_value value;
        const double root = sqrt(d), hertz = k * d * root;
        const struct {
            const char *law;
            double force, stiffness, damping;
        } wanted[] = {
            {"hertz", hertz, 1.5 * hertz / d, 0.0},
            {"power", 1e11 * pow(d, 1.7), 1.7e11 * pow(d, 0.7), 0.0},
            {"linear", 3e7 * d, 3e7, 0.0},
            {"hunt_crossley", hertz * (1.0 + 0.4 * v), 1.5 * hertz / d * (1.0 + 0.4 * v), 0.4 * hertz},
            {"tsuji", hertz + 3e3 * sqrt(root) * v, 1.5 * hertz / d + 750.0 / (root * sqrt(root)) * v,
             3e3 * sqrt(root)},
            {"kuwabara_kono", k * (d * root + 3e-6 * root * v), 1.5 * k * (root + 1e-6 * v / root),
             3e-6 * k * root},
            {"kelvin_voigt", 3e7 * d + 200.0 * v, 3e7, 200.0},
        };
        for (size_t i = 0; i < sizeof wanted / sizeof wanted[0]; i++) {
            const aoi_law law = law_among(wanted[i].law, 0.0);
            aoi_law_push(&law, NULL, d, v, &value);
            CHECK(near(value.force, wanted[i].force, 1e-14), "%s at %g m", wanted[i].law, d);
            CHECK(near(value.stiffness, wanted[i].stiffness, 1e-14), "%s: stiffness at %g m", wanted[i].law, d);
            CHECK(near(value.damping, wanted[i].damping, 1e-14), "%s: damping at %g m", wanted[i].law, d);
            CHECK((law.depends_on_rate != 0) == (wanted[i].damping != 0.0), "%s depends on the rate: %d",
                  wanted[i].law, law.depends_on_rate);
        }
    }
}

/* F = law(d + c F), whatever the law. */
static void compliance_is_taken_out(void)
{
    uint64_t seed = 3;
    for (size_t i = 0; i < EVERY; i++) {
        if (every[i].compliance == 0.0) {
            continue;
        }
        const aoi_law law = law_at(i);
        aoi_law plain = law;
        plain.compliance = 0.0;
        for (int trial = 0; trial < 300; trial++) {
            double memory[AOI_LAW_MEMORY] = {0.0};
            if (trial % 2) {
                aoi_law_remember(&law, decades(&seed, -6.0, -5.0), 1.0, memory);
            }
            const double d = decades(&seed, -8.0, -5.0), v = 1.5 * uniform(&seed) - 0.7;
            aoi_law_value value, own;
            aoi_law_push(&law, memory, d, v, &value);
            const double inside = d + law.compliance * value.force;
            aoi_law_push(&plain, memory, inside, v, &own);
            if (law.compliance < 0.0 && fabs(inside) < 1e-12 * d) { /* less than a dashpot's */
                continue;
            }
            CHECK(near(value.force, own.force, 1e-12), "%s at %g m: %.17g, %.17g", every[i].name, d,
                  value.force, own.force);
            const double give = 1.0 - law.compliance * own.stiffness;
            CHECK(near(value.stiffness, own.stiffness / give, 1e-10), "%s: stiffness", every[i].name);
            CHECK(near(value.damping, own.damping / give, 1e-10), "%s: damping", every[i].name);
        }
    }
}

/* Beyond where anything is left of the law it goes on as a line, so that an iteration finds back. */
static void beyond_its_limit_a_law_is_a_line(void)
{
    aoi_law law = law_of("hertz", 1e10, 0.0);
    law.compliance = 3e-8;
    double slope = 0.0, before = 0.0;
    for (double d = 1e-8; d < 1.0; d *= 1.01) {
        aoi_law_value value;
        aoi_law_push(&law, NULL, d, 0.0, &value);
        CHECK(value.force > before && value.stiffness >= slope * (1.0 - 1e-12), "at %g m", d);
        if (d > 1e-4) { /* far along the line */
            CHECK(near(value.force - before, slope * (d - d / 1.01), 1e-9), "straight at %g m", d);
        }
        before = value.force;
        slope = value.stiffness;
    }
    const double bend = 0.95 / (1.5 * 1e10 * law.compliance); /* its root */
    CHECK(near(slope, 20.0 * 1.5e10 * bend, 1e-9), "20 times as stiff: %g", slope);
}

/* At a rate a damped law is steeper: what stands is the law itself, F = k d^1.5 (1 + chi v) at d + c F,
 * and where it no longer does, more than that is left of the patch's share. */
static void a_damped_law_stands_less_deep(void)
{
    const double parameter[] = {1e10, 30.0, 1.5}, c = 2e-9;
    size_t standing = 0, count = 0;
    aoi_law law;
    CHECK(aoi_law_create(&law, "hunt_crossley", 3, parameter) == AOI_OK, "a law");
    law.compliance = c;
    for (double d = 1e-8; d < 1e-2; d *= 1.07) {
        for (double v = 0.0; v < 10.0; v += 0.7) {
            aoi_law_value value;
            aoi_law_push(&law, NULL, d, v, &value);
            const double own = d + c * value.force, k = 1e10 * (1.0 + 30.0 * v);
            const int right = near(value.force, k * own * sqrt(own), 1e-10);
            const int steep = c * 1.5 * k * sqrt(own) >= 0.95 * (1.0 - 1e-9);
            const int stands = aoi_law_stands(&law, NULL, d, v);
            CHECK(stands == (right && !steep), "at %g m, %g m/s: %d %d", d, v, right, steep);
            standing += stands != 0;
            count++;
        }
    }
    CHECK(standing > count / 10 && standing < count * 9 / 10, "some of either: %zu of %zu", standing, count);
    law.limit = 1e-6;
    CHECK(!aoi_law_stands(&law, NULL, 2e-6, 0.0) && aoi_law_stands(&law, NULL, 5e-7, 0.0), "its limit");
}

/* Laws that yield over cycles of growing depth: the cycle's loss is the area between its branches,
 * what is stored comes back, and pieces meet. */
static void plastic_contact_remembers(void)
{
    for (size_t i = 0; i < 4; i++) {
        aoi_law law = law_among(i % 2 ? "thornton" : "elastic_plastic", 0.0);
        law.compliance = i < 2 ? 0.0 : 2e-9;
        double memory[AOI_LAW_MEMORY] = {0.0}, given = 0.0;
        for (double top = 1e-6; top < 2e-5; top *= 1.7) {
            enum { PARTS = 4000 };
            double taken = 0.0, low, high;
            aoi_law_value at_top, back;
            const double rest = aoi_law_rest(&law, memory);
            for (int j = 0; j < PARTS; j++) {
                aoi_law_push(&law, memory, rest + (top - rest) * (j + 0.5) / PARTS, 1.0, &at_top);
                taken += at_top.force * (top - rest) / PARTS;
            }
            aoi_law_push(&law, memory, top, 1.0, &at_top);
            aoi_law_remember(&law, top, 1.0, memory);
            const int loading = aoi_law_piece(&law, memory, top, 1, &low, &high);
            CHECK(low <= top * (1.0 + 1e-12) && high > top, "rising from the deepest point: new ground");
            const int unloading = aoi_law_piece(&law, memory, top, 0, &low, &high);
            CHECK(near(high, top, 1e-12) || at_top.force < 100.0, "it ends where it was deepest");
            CHECK((unloading == loading) == (at_top.force < 100.0), "another branch past yield");
            aoi_law_force(&law, memory, unloading, top, -1.0, &back);
            CHECK(near(back.force, at_top.force, 1e-12), "both branches meet: %g, %g", back.force, at_top.force);
            const double stored = aoi_law_potential(&law, memory, top), left = aoi_law_rest(&law, memory);
            double returned = 0.0;
            for (int j = 0; j < PARTS; j++) {
                aoi_law_push(&law, memory, left + (top - left) * (j + 0.5) / PARTS, -1.0, &back);
                returned += back.force * (top - left) / PARTS;
            }
            CHECK(near(returned, stored, 1e-5), "stored %g, returned %g", stored, returned);
            CHECK(returned <= taken * (1.0 + 1e-5), "no energy gained");
            CHECK(left >= rest && (left > 0.0) == (at_top.force > 100.0), "residual indentation %g", left);
            aoi_law_push(&law, memory, left, -1.0, &back);
            CHECK(back.force == 0.0, "no force at rest");
            given += taken - returned;
        }
        CHECK(given > 0.0, "the cycles cost %g J", given);
    }
}

/* From the deepest D: F(D), D - d_p = F(D)/(k D^(1/2)), F = F(D) ((d - d_p)/(D - d_p))^(3/2). */
static void plastic_unloading_is_thorntons(void)
{
    const aoi_law law = law_among("thornton", 0.0);
    const double k = 1e10, yield = pow(100.0 / k, 2.0 / 3.0), deepest = 4.0 * yield;
    const double top = 100.0 + 1.5 * k * sqrt(yield) * 3.0 * yield;
    const double reach = top / (k * sqrt(deepest));
    double memory[AOI_LAW_MEMORY] = {0.0};
    aoi_law_remember(&law, deepest, 0.0, memory);
    CHECK(near(aoi_law_rest(&law, memory), deepest - reach, 1e-13), "residual indentation");
    for (double share = 0.01; share < 1.0; share += 0.07) {
        aoi_law_value value;
        aoi_law_push(&law, memory, deepest - reach + share * reach, -1.0, &value);
        CHECK(near(value.force, top * pow(share, 1.5), 1e-12), "at %g of the way", share);
        CHECK(near(value.stiffness, 1.5 * value.force / (share * reach), 1e-12), "its slope");
    }
    aoi_law_remember(&law, 0.9 * deepest, 0.0, memory);
    CHECK(near(aoi_law_rest(&law, memory), deepest - reach, 1e-13), "a smaller load changes nothing");
    /* The curvature is that of the flattened radius: k_p = k (R_p/R)^(1/2), R_p/R = k D^(3/2)/F(D). */
    const double flattened = k * sqrt(k * pow(deepest, 1.5) / top);
    CHECK(near(top, flattened * pow(reach, 1.5), 1e-13), "Hertz on the flattened radius");
}

/* Brake's three regimes: the line of full plasticity; between yield and there the cubic of Hermite. The
 * residual indentation by Etsion, Kligerman and Kadin, and by Johnson where all is plastic. */
static void full_plasticity_is_brakes(void)
{
    const aoi_law law = law_among("elastic_plastic", 0.0);
    const double k = 1e10, slope = 1e8, yield = pow(100.0 / k, 2.0 / 3.0), full = pow(slope / (2.0 * k), 2.0);
    double memory[AOI_LAW_MEMORY] = {0.0}, low, high;
    aoi_law_value at, next;
    for (double d = full; d < 1.0; d *= 3.0) {
        aoi_law_push(&law, memory, d, 1.0, &at);
        CHECK(near(at.force, slope * (d - 0.5 * full), 1e-14) && at.stiffness == slope, "plastic at %g m", d);
    }
    for (int end = 0; end < 2; end++) {
        const int below = aoi_law_piece(&law, memory, 0.9 * (end ? full : yield), 0, &low, &high);
        const double d = high;
        CHECK(near(d, end ? full : yield, 1e-14), "a piece ends at %g m", d);
        CHECK(aoi_law_piece(&law, memory, d, 0, &low, &high) == below, "from above it ends there, too");
        const int above = aoi_law_piece(&law, memory, d, 1, &low, &high);
        CHECK(above != below, "another begins at %g m", d);
        aoi_law_force(&law, memory, below, d, 1.0, &at);
        aoi_law_force(&law, memory, above, d, 1.0, &next);
        CHECK(near(at.force, next.force, 1e-13) && near(at.stiffness, next.stiffness, 1e-12), "smooth at %g m", d);
    }
    CHECK(near(at.force, k * pow(full, 1.5), 1e-13), "full plasticity begins on Hertz's curve");
    const double middle = 0.5 * (yield + full), start = 1.5 * k * sqrt(yield);
    aoi_law_push(&law, memory, middle, 1.0, &at);
    const double mean = 0.5 * (100.0 + 0.5 * slope * full);
    CHECK(near(at.force, mean + (full - yield) * (start - slope) / 8.0, 1e-13), "Hermite's cubic in the middle");
    /* From where on, both have the same slope. */
    double low_end = full, high_end = 2.0 * full;
    for (int i = 0; i < 60; i++) {
        const double d = 0.5 * (low_end + high_end), h = 1e-6;
        const double less = 1.0 - (1.0 - pow(d * (1.0 - h) / yield, -0.28)) * (1.0 - pow(d * (1.0 - h) / yield, -0.69));
        const double more = 1.0 - (1.0 - pow(d * (1.0 + h) / yield, -0.28)) * (1.0 - pow(d * (1.0 + h) / yield, -0.69));
        const double power = 1.0 + log(more / less) / (2.0 * h);
        *(power < d / (2.0 * d - full) ? &low_end : &high_end) = d;
    }
    const double fitted = low_end;
    for (double w = 1.0001; w < 1e9; w *= 7.0) {
        memory[0] = memory[1] = 0.0;
        aoi_law_remember(&law, w * yield, 1.0, memory);
        /* Far past full plasticity the recovery goes as the root of the force, which is 1e8 (d - full/2). */
        const double v = fmin(w, fitted / yield), own = 1.0 - (1.0 - pow(v, -0.28)) * (1.0 - pow(v, -0.69));
        const double past = w > v ? sqrt((2.0 * w * yield - full) / (2.0 * fitted - full)) : 1.0;
        const double rest = w * yield - v * yield * own * past;
        CHECK(fabs(aoi_law_rest(&law, memory) - rest) < 1e-14 * w * yield, "residual indentation at %g y", w);
        aoi_law_push(&law, memory, w * yield - 0.36 * (w * yield - rest), -1.0, &at);
        aoi_law_force(&law, memory, aoi_law_piece(&law, memory, w * yield, 1, &low, &high), w * yield, 1.0, &next);
        CHECK(near(at.force, 0.512 * next.force, 1e-10 * w), "back by Hertz's power"); /* 0.64^1.5 */
    }
    const double soft[] = {k, 100.0, 7e7};
    aoi_law refused;
    CHECK(aoi_law_create(&refused, "elastic_plastic", 3, soft) == AOI_ERROR_ARGUMENT, "plastic before it yields");
}

/* Yang and Sun's powers: 3/2 in, 5/2 out, 3/2 in again once the bodies have parted. */
static void laminates_are_yang_and_suns(void)
{
    const double k = 1e10, critical = 4e-6, deepest = 2e-5, top = k * deepest * sqrt(deepest);
    for (int linear = 0; linear < 2; linear++) {
        const double parameter[] = {k, critical, linear ? 0.1 : 0.0};
        double memory[AOI_LAW_MEMORY] = {0.0};
        aoi_law law;
        aoi_law_value at;
        CHECK(aoi_law_create(&law, "yang_sun", 3, parameter) == AOI_OK, "made");
        aoi_law_push(&law, memory, deepest, 1.0, &at);
        CHECK(near(at.force, top, 1e-14), "loading");
        aoi_law_remember(&law, deepest, 1.0, memory);
        const double rest = linear ? 0.1 * (deepest - critical) : deepest * (1.0 - pow(critical / deepest, 0.4));
        const double reach = deepest - rest;
        CHECK(near(aoi_law_rest(&law, memory), rest, 1e-13), "permanent indentation");
        for (double share = 0.1; share < 1.0; share += 0.2) { /* and as it goes, it comes back */
            aoi_law_push(&law, memory, rest + share * reach, share < 0.5 ? 1.0 : -1.0, &at);
            CHECK(near(at.force, top * pow(share, 2.5), 1e-12), "unloading at %g", share);
            CHECK(near(at.stiffness, 2.5 * at.force / (share * reach), 1e-12), "its slope");
            CHECK(near(aoi_law_potential(&law, memory, rest + share * reach), at.force * share * reach / 3.5, 1e-12),
                  "what it gives back");
            aoi_law_remember(&law, rest + share * reach, -1.0, memory);
        }
        aoi_law_remember(&law, rest, -1.0, memory); /* parted */
        aoi_law_push(&law, memory, rest + 0.6 * reach, 1.0, &at);
        CHECK(near(at.force, top * pow(0.6, 1.5), 1e-12), "reloading");
        CHECK(near(at.stiffness, 1.5 * at.force / (0.6 * reach), 1e-12), "its slope");
        aoi_law_remember(&law, rest + 0.6 * reach, 1.0, memory);
        aoi_law_push(&law, memory, rest + 0.3 * reach, -1.0, &at);
        CHECK(near(at.force, top * pow(0.6, 1.5) * pow(0.5, 2.5), 1e-12), "unloading from there");
        CHECK(near(aoi_law_rest(&law, memory), rest, 1e-13), "a smaller load leaves the dent as it is");
        memory[0] = memory[1] = 0.0;
        aoi_law_remember(&law, 0.9 * critical, 1.0, memory);
        CHECK(aoi_law_rest(&law, memory) == 0.0, "no dent up to the critical indentation");
    }
    const double odd[] = {k, critical, 1.1};
    aoi_law refused;
    CHECK(aoi_law_create(&refused, "yang_sun", 3, odd) == AOI_ERROR_ARGUMENT, "a dent deeper than the indentation");
}

/* Far past yield what springs back is lost beside the depth, but not the force. */
static void plastic_unloading_starts_from_the_force_there_was(void)
{
    for (double yield_force = 1.0; yield_force > 1e-70; yield_force *= 1e-7) {
        const double parameter[] = {1e10, yield_force}, deepest = 1e-5;
        double memory[AOI_LAW_MEMORY] = {0.0}, low, high;
        aoi_law law;
        aoi_law_value up, down;
        CHECK(aoi_law_create(&law, "thornton", 2, parameter) == AOI_OK, "made");
        aoi_law_push(&law, memory, deepest, 1.0, &up);
        aoi_law_remember(&law, deepest, 0.0, memory);
        const int piece = aoi_law_piece(&law, memory, deepest, 0, &low, &high);
        aoi_law_force(&law, memory, piece, deepest, -1.0, &down);
        CHECK(near(down.force, up.force, 1e-14) && isfinite(down.stiffness),
              "yield at %g N: %g N up, %g N down", yield_force, up.force, down.force);
    }
}

/* A table of d^3 with exact slopes is that cubic. */
static void tables_are_hermite_cubics(void)
{
    enum { KNOTS = 5 };
    double table[4 * KNOTS];
    const double knot[KNOTS] = {0.0, 0.1, 0.25, 0.3, 1.0};
    for (int i = 0; i < KNOTS; i++) {
        table[i] = knot[i];
        table[KNOTS + i] = knot[i] * knot[i] * knot[i];
        table[2 * KNOTS + i] = 3.0 * knot[i] * knot[i];
        table[3 * KNOTS + i] = 0.25 * knot[i] * knot[i] * knot[i] * knot[i];
    }
    aoi_law law;
    CHECK(aoi_law_create_table(&law, KNOTS, table) == AOI_OK && law.limit == 1.0, "a table");
    for (double d = 0.003; d < 1.0; d += 0.0137) {
        aoi_law_value value;
        double low, high;
        aoi_law_push(&law, NULL, d, 0.0, &value);
        CHECK(near(value.force, d * d * d, 1e-12), "at %g", d);
        CHECK(near(value.stiffness, 3.0 * d * d, 1e-12), "slope at %g", d);
        CHECK(near(aoi_law_potential(&law, NULL, d), 0.25 * d * d * d * d, 1e-12), "energy at %g", d);
        const int piece = aoi_law_piece(&law, NULL, d, 1, &low, &high);
        CHECK(low < d && d < high && (piece == 0 || low == knot[piece]) && high == knot[piece + 1],
              "the piece of %g", d);
    }
    for (int i = 1; i < KNOTS; i++) {
        double low, high;
        CHECK(aoi_law_piece(&law, NULL, knot[i], 0, &low, &high) == i - 1 && high == knot[i], "down");
        CHECK(aoi_law_piece(&law, NULL, knot[i], 1, &low, &high) == i && low == knot[i], "up");
    }
    aoi_law_value value;
    for (int i = 1; i < KNOTS - 1; i++) { /* the forces beside a piece do not turn */
        const double d = knot[i], further = 10.0;
        aoi_law_force(&law, NULL, i, d - further, 0.0, &value);
        CHECK(near(value.force, d * d * (d - 3.0 * further), 1e-12), "below piece %d", i);
        CHECK(near(value.stiffness, 3.0 * d * d, 1e-12), "its slope");
        aoi_law_force(&law, NULL, i - 1, d + further, 0.0, &value);
        CHECK(near(value.force, d * d * (d + 3.0 * further), 1e-12), "above piece %d", i - 1);
    }
    aoi_law_push(&law, NULL, 3.0, 0.0, &value);
    CHECK(near(value.force, 7.0, 1e-14) && near(value.stiffness, 3.0, 1e-14), "a line past the end");
    table[KNOTS + 2] = 0.0;
    CHECK(aoi_law_create_table(&law, KNOTS, table) == AOI_ERROR_ARGUMENT, "falls");
    table[KNOTS + 2] = 0.015625;
    table[2] = 0.1;
    CHECK(aoi_law_create_table(&law, KNOTS, table) == AOI_ERROR_ARGUMENT, "stands still");
    table[2] = (double)NAN;
    CHECK(aoi_law_create_table(&law, KNOTS, table) == AOI_ERROR_ARGUMENT, "NaN");
    CHECK(aoi_law_create_table(&law, 1, knot) == AOI_ERROR_ARGUMENT, "one knot");
    CHECK(aoi_law_create_table(&law, 2, knot + 1) == AOI_ERROR_ARGUMENT, "not from 0");
}

static double cubic_law(double d, double rate) { return d * d * d * (2.0 + rate); }
static double cubic_law_stiffness(double d, double rate) { return 3.0 * d * d * (2.0 + rate); }
static double nan_law(double d, double rate) { return d > 1.0 ? (double)NAN : d + 0.0 * rate; }

static void callers_laws(void)
{
    aoi_user_law user = {.function = {cubic_law}, .given = {1}};
    aoi_law law, known, still, broken;
    CHECK(aoi_law_create_user(&law, &user, 1, 0) == AOI_OK, "by differences");
    CHECK(aoi_law_create_user(&still, &user, 0, 0) == AOI_OK, "that promises not to look at the rate");
    user.function[AOI_USER_STIFFNESS] = cubic_law_stiffness;
    user.given[AOI_USER_STIFFNESS] = 1;
    CHECK(aoi_law_create_user(&known, &user, 1, 0) == AOI_OK, "with its derivative");
    for (double d = 1e-6; d < 10.0; d *= 4.1) {
        aoi_law_value value, same;
        aoi_law_push(&law, NULL, d, 0.5, &value);
        aoi_law_push(&known, NULL, d, 0.5, &same);
        CHECK(near(value.force, 2.5 * d * d * d, 1e-15) && value.force == same.force, "force at %g", d);
        CHECK(near(value.stiffness, 7.5 * d * d, 1e-7), "stiffness by differences at %g", d);
        CHECK(near(same.stiffness, 7.5 * d * d, 1e-15), "stiffness as given at %g", d);
        CHECK(near(value.damping, d * d * d, 1e-9), "damping by differences at %g", d);
        CHECK(near(aoi_law_potential(&law, NULL, d), 0.5 * d * d * d * d, 1e-14), "energy at %g", d);
        aoi_law_push(&law, NULL, d, 0.0, &value);
        CHECK(near(value.damping, d * d * d, 1e-6), "damping at rest, at %g", d);
        aoi_law_push(&still, NULL, d, 0.5, &value);
        CHECK(value.damping == 0.0 && !still.depends_on_rate, "no damping asked for");
    }
    double note[AOI_LAW_NOTE] = {0.0};
    aoi_law_value value;
    user = (aoi_user_law){.function = {nan_law}, .given = {1}};
    CHECK(aoi_law_create_user(&broken, &user, 1, 0) == AOI_OK, "a law that breaks");
    broken.note = note;
    aoi_law_push(&broken, NULL, 1.5, -2.0, &value);
    CHECK(isnan(value.force) && note[0] == 1.5 && note[1] == -2.0 && note[2] == AOI_ERROR_LAW,
          "NaN is noted with its state");
    user.given[AOI_USER_DAMPING] = 1;
    CHECK(aoi_law_create_user(&broken, &user, 1, 0) == AOI_ERROR_ARGUMENT, "said, but not given");
    user = (aoi_user_law){.given = {0}};
    CHECK(aoi_law_create_user(&broken, &user, 1, 0) == AOI_ERROR_ARGUMENT, "no force");
}

/* At 1 it falls from 1 to 0.2: with a compliance of 0.5, from 0.5 to 0.9 no force goes with it. */
static double falling_law(double d, double rate) { return (d < 1.0 ? d : 0.2 * d) + 0.0 * rate; }
/* Right to eight digits; the others are noise. */
static double noisy_law(double d, double rate)
{
    return d * sqrt(d) * (1.0 + 1e-8 * sin(1e17 * d)) + 0.0 * rate;
}
static double smooth_slope(double d, double rate) { return 1.5 * sqrt(d) + 0.0 * rate; }

static aoi_law within_patch(double (*force)(double, double), double compliance, double *note)
{
    const aoi_user_law user = {.function = {force}, .given = {1}};
    aoi_law law;
    CHECK(aoi_law_create_user(&law, &user, 0, 0) == AOI_OK, "a caller's law");
    law.compliance = compliance;
    law.note = note;
    return law;
}

static void a_law_that_falls_has_no_force_within_a_patch(void)
{
    double note[AOI_LAW_NOTE] = {0.0};
    const aoi_law law = within_patch(falling_law, 0.5, note);
    CHECK(near(force_of(&law, 0.4), 0.8, 1e-12), "before its fall");
    CHECK(near(force_of(&law, 1.8), 0.4, 1e-12), "after it");
    CHECK(note[2] == 0.0, "nothing to note");
    for (double d = 0.52; d < 0.9; d += 0.05) {
        CHECK(isnan(force_of(&law, d)) && note[0] == d && note[2] == AOI_ERROR_LAW_JUMPS, "at %g", d);
        note[2] = 0.0;
        CHECK(isnan(aoi_law_potential(&law, NULL, d)) && note[2] == AOI_ERROR_LAW_JUMPS, "nor an energy at %g", d);
    }
}

/* On the way out g d^(1/4) rate outweighs the rest at small d: the law's own indentation is then next
 * to nothing beside the total one, and c F is all of that. */
static void a_damper_that_pulls_has_a_force_within_a_patch(void)
{
    const double parameter[] = {1e10, 1e4};
    double note[AOI_LAW_NOTE] = {0.0};
    aoi_law law;
    CHECK(aoi_law_create(&law, "tsuji", 2, parameter) == AOI_OK, "Tsuji's law");
    law.compliance = 1e-9;
    law.note = note;
    for (double d = 1e-14; d < 1e-8; d *= 3.0) {
        aoi_law_value value;
        aoi_law_force(&law, NULL, 0, d, -1.0, &value);
        const double own = d + law.compliance * value.force;
        CHECK(near(value.force, -d / law.compliance, 1e-3) && own < 1e-3 * d, "at %g: %g", d, value.force);
        CHECK(note[2] == 0.0, "nothing to note at %g", d);
    }
}

static void a_law_of_few_digits_has_a_force_within_a_patch(void)
{
    aoi_law law = within_patch(noisy_law, 0.3, NULL);
    law.user.function[AOI_USER_STIFFNESS] = smooth_slope;
    law.user.given[AOI_USER_STIFFNESS] = 1;
    for (double own = 1e-6; own < 1.5; own *= 1.37) {
        CHECK(near(force_of(&law, own - 0.3 * own * sqrt(own)), own * sqrt(own), 1e-5), "at %g", own);
    }
}

/* What a state that is no number makes is none either. */
static void no_number_in_no_number_out(void)
{
    const double nan = (double)NAN, memory[AOI_LAW_MEMORY] = {0.0};
    for (size_t i = 0; i < 2 * EVERY; i++) {
        aoi_law law = law_at(i % EVERY);
        aoi_law_value value;
        law.compliance = i < EVERY ? 0.0 : 1e-12;
        aoi_law_push(&law, memory, nan, 0.1, &value);
        CHECK(isnan(value.force), "%s: %g N", every[i % EVERY].name, value.force);
        CHECK(isnan(aoi_law_push_only(&law, memory, nan, 0.1)), "%s alone", every[i % EVERY].name);
        CHECK(isnan(aoi_law_potential(&law, memory, nan)), "%s stores energy", every[i % EVERY].name);
        aoi_law_push(&law, memory, 1e-6, nan, &value);
        CHECK(isnan(value.force) == law.depends_on_rate, "%s at no rate: %g N", every[i % EVERY].name, value.force);
    }
}

static void what_no_law_is_made_of(void)
{
    aoi_law law;
    const double none = 0.0, least = SMALLEST, soft[] = {1e-300, 1e300}, stiff[] = {1e300, 1e-300};
    CHECK(aoi_law_create(&law, "hertz", 1, &none) == AOI_ERROR_ARGUMENT, "k = 0");
    CHECK(aoi_law_create(&law, "hertz", 1, &least) == AOI_OK, "k > 0, however little");
    CHECK(aoi_law_create(&law, "thornton", 2, soft) == AOI_ERROR_ARGUMENT, "yields at infinity");
    CHECK(aoi_law_create(&law, "thornton", 2, stiff) == AOI_ERROR_ARGUMENT, "yields at 0");
    /* F = 1000 d up to 2 m, energies 500 d^2. */
    double table[] = {0.0, 1.0, 2.0, 0.0, 1e3, 2e3, 1e3, 1e3, 1e3, 0.0, 500.0, 2000.0};
    CHECK(aoi_law_create_table(&law, 3, table) == AOI_OK && aoi_law_check(&law) == AOI_OK, "a line");
    table[10] = 400.0;
    CHECK(aoi_law_create_table(&law, 3, table) == AOI_ERROR_ARGUMENT, "energies that are not the force's integral");
    table[10] = 500.0;
    /* The energies of these are right. */
    const double falls[] = {0.0, 1.0, 2.0, 0.0, 1e3, 500.0, 0.0, 0.0, 0.0, 0.0, 500.0, 1250.0};
    const double stays[] = {0.0, 1.0, 1.0, 0.0, 1e3, 1e3, 1e3, 1e3, 1e3, 0.0, 500.0, 500.0};
    CHECK(aoi_law_create_table(&law, 3, falls) == AOI_ERROR_ARGUMENT, "a force that falls");
    CHECK(aoi_law_create_table(&law, 3, stays) == AOI_ERROR_ARGUMENT, "two forces at one indentation");
    const double nan = (double)NAN, compliance[] = {-HUGE_VAL, nan, HUGE_VAL, 0.0, 0.0, 0.0};
    const double limit[] = {1.0, 1.0, 1.0, 0.0, -1.0, nan};
    for (size_t i = 0; i < 6; i++) {
        CHECK(aoi_law_create_table(&law, 3, table) == AOI_OK, "a line");
        law.compliance = compliance[i];
        law.limit = limit[i];
        CHECK(aoi_law_check(&law) == AOI_ERROR_ARGUMENT, "compliance %g, limit %g", compliance[i], limit[i]);
    }
    law = (aoi_law){.limit = HUGE_VAL};
    CHECK(aoi_law_check(&law) == AOI_ERROR_ARGUMENT, "no force");
    CHECK(aoi_law_check(NULL) == AOI_ERROR_ARGUMENT, "no law");
}

static void spring_of_one(const aoi_law *law, const double *memory, int piece, double d, double rate,
                          aoi_law_value *value)
{
    (void)law;
    (void)memory;
    (void)piece;
    (void)rate;
    *value = (aoi_law_value){d, 1.0, 0.0};
}

static int stuck_piece(const aoi_law *law, const double *memory, double d, int rising, double *low, double *high)
{
    (void)law;
    (void)memory;
    (void)d;
    (void)rising;
    *low = 0.0;
    *high = 1.0;
    return 0;
}

static void pieces_that_go_no_further_are_an_error(void)
{
    double note[AOI_LAW_NOTE] = {0.0}, low, high;
    aoi_law_value value;
    const aoi_law law = {.force = spring_of_one, .piece = stuck_piece, .limit = HUGE_VAL,
                         .compliance = 0.5, .note = note};
    CHECK(aoi_law_piece(&law, NULL, 0.4, 1, &low, &high) == 0 && high == 0.5, "the first piece");
    CHECK(aoi_law_piece(&law, NULL, 0.6, 1, &low, &high) == AOI_NO_PIECE, "there is no other");
    aoi_law_push(&law, NULL, 0.6, 1.0, &value);
    CHECK(isnan(value.force) && note[0] == 0.6 && note[1] == 1.0, "and no force");
    aoi_law plastic = law_among("thornton", 2e-9);
    const double memory[AOI_LAW_MEMORY] = {0.0};
    CHECK(aoi_law_piece(&plastic, memory, HUGE_VAL, 1, &low, &high) >= 0 && high == HUGE_VAL,
          "the last piece holds even the infinite");
}

/* Whoever looks for the depth of an energy finds one. */
static void energy_grows_past_the_limit(void)
{
    for (size_t i = 0; i < EVERY; i++) {
        if (every[i].compliance == 0.0) {
            continue;
        }
        aoi_law law = law_at(i);
        const double memory[AOI_LAW_MEMORY] = {0.0};
        double before = 0.0;
        law.limit = 1e-5;
        for (double d = 1e-7; d < 1e6; d *= 1.1) {
            const double energy = aoi_law_potential(&law, memory, d);
            CHECK(energy > before, "%s stores %g J at %g m", every[i].name, energy, d);
            before = energy;
        }
    }
}

static double pulling_law(double d, double rate) { return d - 1.0 + rate; }

static void the_force_alone_is_the_force(void)
{
    const aoi_user_law user = {.function = {pulling_law}, .given = {1}};
    double note[AOI_LAW_NOTE] = {0.0};
    aoi_law laws[EVERY + 3];
    for (size_t i = 0; i < EVERY; i++) {
        laws[i] = law_at(i);
    }
    for (int pulls = 0; pulls < 2; pulls++) {
        CHECK(aoi_law_create_user(&laws[EVERY + pulls], &user, 1, pulls) == AOI_OK, "made");
    }
    laws[EVERY + 2] = within_patch(cubic_law, 0.1, NULL);
    for (size_t i = 0; i < EVERY + 3; i++) {
        const double memory[AOI_LAW_MEMORY] = {0.0};
        for (double d = -1e-6; d < 2.0; d = d < 1e-9 ? 2.0 * d + 3e-6 : 3.0 * d) {
            aoi_law_value value;
            aoi_law_push(&laws[i], memory, d, -0.2, &value);
            CHECK(aoi_law_push_only(&laws[i], memory, d, -0.2) == value.force, "law %zu at %g", i, d);
        }
    }
    aoi_law broken = within_patch(nan_law, 0.0, note);
    CHECK(isnan(aoi_law_push_only(&broken, NULL, 1.5, 2.0)) && note[0] == 1.5 && note[1] == 2.0 &&
              note[2] == AOI_ERROR_LAW,
          "NaN is noted");
}

/* However far the yield is beyond an indentation, the patch's compliance leaves the elastic piece as it is. */
static void a_far_yield_leaves_the_elastic_piece_alone(void)
{
    const double k = 1e10, d = 6e-5, memory[AOI_LAW_MEMORY] = {0.0};
    for (double yield = 1e-4; yield < 1.0; yield *= 1.3) {
        const double parameter[] = {k, k * yield * sqrt(yield)};
        aoi_law elastic, plastic;
        aoi_law_value wanted, value;
        CHECK(aoi_law_create(&elastic, "hertz", 1, &k) == AOI_OK, "Hertz's law");
        CHECK(aoi_law_create(&plastic, "thornton", 2, parameter) == AOI_OK, "Thornton's");
        elastic.compliance = plastic.compliance = 3e-9; /* dF/dd of some 1e8 N/m */
        aoi_law_push(&elastic, NULL, d, 1.0, &wanted);
        aoi_law_push(&plastic, memory, d, 1.0, &value);
        CHECK(value.force == wanted.force, "yield at %g: %g N, not %g", yield, value.force, wanted.force);
    }
}

int main(void)
{
    laws_that_cannot_be();
    laws_at_a_rate_follow_their_formulas();
    compliance_is_taken_out();
    beyond_its_limit_a_law_is_a_line();
    a_damped_law_stands_less_deep();
    plastic_contact_remembers();
    full_plasticity_is_brakes();
    laminates_are_yang_and_suns();
    plastic_unloading_is_thorntons();
    plastic_unloading_starts_from_the_force_there_was();
    tables_are_hermite_cubics();
    callers_laws();
    a_law_that_falls_has_no_force_within_a_patch();
    a_law_of_few_digits_has_a_force_within_a_patch();
    a_damper_that_pulls_has_a_force_within_a_patch();
    no_number_in_no_number_out();
    what_no_law_is_made_of();
    pieces_that_go_no_further_are_an_error();
    the_force_alone_is_the_force();
    energy_grows_past_the_limit();
    a_far_yield_leaves_the_elastic_piece_alone();
    return check_report();
}
