/* Contacts that feel each other through the bodies between them: whatever the masses, the step, the
 * laws and the place to start from, the equations hold at the end; a force within a law's jump holds
 * its bodies just touching; and equal contacts on one rigid body share what they carry. */
#include "check.h"
#include "linear/vector.h"
#include "model/coupled.h"

#include <string.h>

enum { MOST = 40, MOST_BAND = 6, WIDTH = 2 * MOST_BAND + 1 };

static const aoi_rule STEP = {.dt = 1e-6};

typedef struct equations {
    aoi_coupled e;
    aoi_contact_state contact[MOST];
    aoi_law law[MOST];
    double compliance[MOST * WIDTH], rate_compliance[MOST * WIDTH];
    double free[MOST], rate_free[MOST], indentation[MOST], rate[MOST], force[MOST];
    double work[MOST * 40];
} equations;

static equations q;

static void make(size_t count, size_t band)
{
    memset(&q, 0, sizeof q);
    q.e = (aoi_coupled){count,  band,          q.compliance, q.rate_compliance, q.free, q.rate_free,
                        q.indentation, q.rate, q.force,      q.work,
                        0};
    CHECK(aoi_coupled_size(count, band) <= sizeof q.work / sizeof q.work[0], "room to work in");
    for (size_t i = 0; i < count; i++) {
        q.contact[i].law = &q.law[i];
        q.contact[i].indentation = q.contact[i].last_indentation = -1.0;
    }
}

static double *entry(double *matrix, size_t i, size_t j)
{
    return &matrix[i * (2 * q.e.band + 1) + q.e.band + j - i];
}

/* A row of masses, contact i between masses i and i+1: what one of them gives way is taken from the
 * contacts on both of its sides. A massless one's rate is its displacement over dt. */
static void couple_row(const double *mass, double dt, const int *massless)
{
    for (size_t b = 0; b <= q.e.count; b++) {
        const double gives = 0.25 * dt * dt / mass[b];
        const double rate = gives * (massless[b] ? 1.0 : 2.0) / dt;
        for (int one = 0; one < 2; one++) {
            for (int other = 0; other < 2; other++) {
                const size_t i = b - (size_t)one, j = b - (size_t)other;
                if (i < q.e.count && j < q.e.count) {
                    const double sign = i == j ? 1.0 : -1.0;
                    *entry(q.compliance, i, j) += sign * gives;
                    *entry(q.rate_compliance, i, j) += sign * rate;
                }
            }
        }
    }
}

/* One body touched in many places: a random positive definite matrix, full within the band. */
static void couple_all(uint64_t *seed, double scale, double dt)
{
    const size_t n = q.e.count;
    double shape[MOST_BAND + 1][2 * MOST_BAND + 2];
    for (size_t i = 0; i < n; i++) {
        for (size_t j = 0; j < 2 * n; j++) {
            shape[i][j] = uniform(seed) - 0.5;
        }
    }
    for (size_t i = 0; i < n; i++) {
        for (size_t j = 0; j < n; j++) {
            const double sum = aoi_vector_dot(2 * n, shape[i], shape[j]) * scale;
            *entry(q.compliance, i, j) = sum;
            *entry(q.rate_compliance, i, j) = 2.0 * sum / dt;
        }
    }
}

static const struct {
    const char *name;
    size_t count;
    double parameter[3];
} laws[] = {{"hertz", 1, {1e10}},
            {"linear", 1, {1e7}},
            {"power", 2, {1e13, 3.0}},
            {"hunt_crossley", 3, {1e10, 0.3, 1.5}},
            {"kelvin_voigt", 2, {1e7, 1e3}},
            {"tsuji", 2, {1e10, 2e3}},
            {"kuwabara_kono", 2, {1e10, 1e-5}},
            {"kelvin_voigt_pulling", 2, {1e7, 1e3}}};
enum { LAWS = sizeof laws / sizeof laws[0] };

static void set_law(size_t i, size_t which, double scale)
{
    double parameter[3];
    memcpy(parameter, laws[which].parameter, sizeof parameter);
    parameter[0] *= scale;
    CHECK(aoi_law_create(&q.law[i], laws[which].name, laws[which].count, parameter) == AOI_OK, "%s", laws[which].name);
}

/* Whether contact i's equations hold: its force is the law's, or lies within its jump at touch. */
static int holds(size_t i)
{
    double given = 0.0, rate = 0.0, size = fabs(q.free[i]) + fabs(q.indentation[i]), sizes = 0.0;
    double deepest = 0.0, uncertain = 0.0; /* by what the rounding of a rate does to a force */
    for (size_t j = 0; j < q.e.count; j++) {
        deepest = fmax(deepest, fabs(q.free[j]));
        if (i <= j + q.e.band && j <= i + q.e.band) {
            given += *entry(q.compliance, i, j) * q.force[j];
            rate += *entry(q.rate_compliance, i, j) * q.force[j];
            size += fabs(*entry(q.compliance, i, j) * q.force[j]);
            sizes += fabs(*entry(q.rate_compliance, i, j) * q.force[j]);
            aoi_law_value there;
            aoi_law_push(&q.law[j], q.contact[j].memory, q.indentation[j], q.rate[j], &there);
            uncertain += fabs(*entry(q.compliance, i, j) * there.damping * q.rate_free[j]);
        }
    }
    const double enough = 64.0 * DBL_EPSILON * fmax(size + uncertain, 1e-5 * deepest);
    const double expected_rate = q.rate_free[i] - rate;
    if (!(fabs(q.indentation[i] - q.free[i] + given) <= enough) ||
        !(fabs(q.rate[i] - expected_rate) <= 1e-9 * (fabs(q.rate_free[i]) + sizes))) {
        return 0;
    }
    aoi_law_value value, before, after;
    aoi_law_push(&q.law[i], q.contact[i].memory, q.indentation[i], q.rate[i], &value);
    if (fabs(value.force - q.force[i]) <= 1e-9 * fabs(q.force[i])) {
        return 1;
    }
    aoi_law_push(&q.law[i], q.contact[i].memory, q.indentation[i] - enough, q.rate[i], &before);
    aoi_law_push(&q.law[i], q.contact[i].memory, q.indentation[i] + enough + DBL_MIN, q.rate[i], &after);
    return before.force <= q.force[i] && q.force[i] <= after.force * (1.0 + 1e-9);
}

/* Random indentations without force, and what the last steps leave as a guess. */
static void throw_together(uint64_t *seed, double depth)
{
    for (size_t i = 0; i < q.e.count; i++) {
        q.free[i] = depth * decades(seed, -3.0, 0.0) * (uniform(seed) < 0.6 ? 1.0 : -1.0);
        q.rate_free[i] = 2.0 * (uniform(seed) - 0.3) * depth / STEP.dt;
        q.contact[i].indentation = q.free[i] * (2.0 * uniform(seed) - 0.5);
        q.contact[i].last_indentation = q.contact[i].indentation * uniform(seed);
    }
}

static void rows_of_any_masses(size_t first_law, size_t last_law)
{
    uint64_t seed = 3 + first_law;
    int failures = 0, wrong = 0, trials = 0;
    for (int trial = 0; trial < 1500; trial++) {
        const size_t n = 2 + (size_t)trial % (MOST - 1);
        const double dt = decades(&seed, -9.0, -1.0);
        double mass[MOST + 1];
        int massless[MOST + 1];
        make(n, 1);
        for (size_t b = 0; b <= n; b++) {
            mass[b] = decades(&seed, -3.0, 2.0);
            massless[b] = uniform(&seed) < 0.1;
        }
        couple_row(mass, dt, massless);
        for (size_t i = 0; i < n; i++) {
            set_law(i, first_law + (size_t)(uniform(&seed) * (double)(last_law - first_law)),
                    decades(&seed, -1.0, 1.0));
        }
        throw_together(&seed, decades(&seed, -9.0, 3.0) * dt);
        const int status = aoi_coupled_solve(&q.e, q.contact);
        failures += status != AOI_OK;
        for (size_t i = 0; status == AOI_OK && i < n; i++) {
            wrong += !holds(i);
            trials++;
        }
    }
    CHECK(failures == 0, "%s..: %d of 1500 rows not solved", laws[first_law].name, failures);
    CHECK(wrong == 0, "%s..: %d of %d contacts do not hold", laws[first_law].name, wrong, trials);
}

static void bodies_touched_in_many_places(size_t first_law, size_t last_law)
{
    uint64_t seed = 5 + first_law;
    int failures = 0, wrong = 0;
    for (int trial = 0; trial < 1500; trial++) {
        const size_t n = 2 + (size_t)trial % (MOST_BAND);
        const double dt = decades(&seed, -9.0, -3.0);
        make(n, n - 1);
        couple_all(&seed, dt * dt / decades(&seed, -2.0, 1.0), dt);
        for (size_t i = 0; i < n; i++) {
            set_law(i, first_law + (size_t)(uniform(&seed) * (double)(last_law - first_law)), 1.0);
        }
        throw_together(&seed, decades(&seed, -6.0, 2.0) * dt);
        const int status = aoi_coupled_solve(&q.e, q.contact);
        failures += status != AOI_OK;
        for (size_t i = 0; status == AOI_OK && i < n; i++) {
            wrong += !holds(i);
        }
    }
    CHECK(failures == 0, "%s..: %d of 1500 bodies not solved", laws[first_law].name, failures);
    CHECK(wrong == 0, "%s..: %d contacts do not hold", laws[first_law].name, wrong);
}

/* Contacts far from the one that touches stay as they are, to the last bit. */
static void what_is_not_touched_is_left_alone(void)
{
    double mass[MOST + 1];
    int massless[MOST + 1] = {0};
    make(MOST, 1);
    for (size_t b = 0; b <= MOST; b++) {
        mass[b] = 0.1;
    }
    couple_row(mass, STEP.dt, massless);
    for (size_t i = 0; i < MOST; i++) {
        set_law(i, 0, 1.0);
        q.free[i] = i == 20 ? 1e-6 : -1e-7;
    }
    CHECK(aoi_coupled_solve(&q.e, q.contact) == AOI_OK, "one of forty touches");
    for (size_t i = 0; i < MOST; i++) {
        const size_t away = i > 20 ? i - 20 : 20 - i;
        CHECK((q.force[i] > 0.0) == (away == 0), "force on contact %zu: %g", i, q.force[i]);
        CHECK(away < 2 || q.indentation[i] == -1e-7, "contact %zu has not moved", i);
    }
    const double gives = 0.25 * STEP.dt * STEP.dt / 0.1;
    CHECK(near(q.indentation[20], 1e-6 - 2.0 * gives * q.force[20], 1e-14), "the one that does");
    CHECK(near(q.indentation[19], -1e-7 + gives * q.force[20], 1e-13), "its neighbour");
}

/* Balls that touch at rest, and a step so long that the push on the first goes through all of them:
 * contacts that would not touch by themselves carry it on. */
static void a_push_goes_through_the_whole_row(void)
{
    double mass[MOST + 1];
    int massless[MOST + 1] = {0};
    make(MOST, 1);
    for (size_t b = 0; b <= MOST; b++) {
        mass[b] = 0.1;
    }
    couple_row(mass, 1.0, massless);
    for (size_t i = 0; i < MOST; i++) {
        set_law(i, 1, 1.0);
        q.free[i] = i == 0 ? 1e-3 : 0.0;
        q.contact[i].indentation = q.contact[i].last_indentation = 0.0;
    }
    CHECK(aoi_coupled_solve(&q.e, q.contact) == AOI_OK, "a long step");
    for (size_t i = 0; i < MOST; i++) {
        CHECK(holds(i) && q.force[i] > 0.0, "contact %zu carries %g N", i, q.force[i]);
        CHECK(i == 0 || q.force[i] < q.force[i - 1], "each less than the one before");
    }
}

/* A dashpot that is stiffer than the step can resolve stops both of its bodies: no indentation, and
 * the force that it takes. */
static void a_jump_holds_its_bodies_just_touching(void)
{
    const double mass[] = {1.0, 1.0, 1.0}, dt = 1e-3;
    const int massless[] = {0, 0, 0};
    make(2, 1);
    couple_row(mass, dt, massless);
    for (size_t i = 0; i < 2; i++) {
        const double stiff[] = {1e4, 1e9};
        CHECK(aoi_law_create(&q.law[i], "kelvin_voigt", 2, stiff) == AOI_OK, "a dashpot");
        q.free[i] = i == 0 ? 1e-3 : -1e-3;
        q.rate_free[i] = i == 0 ? 3.0 : 0.0;
    }
    CHECK(aoi_coupled_solve(&q.e, q.contact) == AOI_OK, "a stop");
    CHECK(q.indentation[0] == 0.0 && near(q.force[0], 1e-3 / (0.5 * dt * dt), 1e-13),
          "indentation %g, force %g", q.indentation[0], q.force[0]);
    CHECK(q.force[1] == 0.0 && q.indentation[1] < 0.0, "the other contact stays open");
}

/* One body on two dashpots, the first of which has pulled. To hold on, d_0 = -1.8 - C (F_0 + F_1) > 0, the body would have
 * to go on at d_1' = 3.5 - (2 C / dt) (F_0 + F_1) > 7, for which F_1 > 700 N, while F_0 > 10 (-4 + 3.6) = -4 N: their sum
 * is not negative. So the pull ends, and the second alone stops the body where it touches. */
static void a_pull_that_cannot_hold_ends(void)
{
    const double gives = 10.0, dt = 1.0, pulling[] = {10.0, 10.0}, stiff[] = {10.0, 100.0};
    make(2, 1);
    CHECK(aoi_law_create(&q.law[0], "kelvin_voigt_pulling", 2, pulling) == AOI_OK, "a dashpot that pulls");
    CHECK(aoi_law_create(&q.law[1], "kelvin_voigt", 2, stiff) == AOI_OK, "a dashpot that does not");
    for (size_t i = 0; i < 2; i++) {
        for (size_t j = 0; j < 2; j++) {
            *entry(q.compliance, i, j) = gives;
            *entry(q.rate_compliance, i, j) = 2.0 * gives / dt;
        }
        q.free[i] = i == 0 ? -1.8 : 1.4;
        q.rate_free[i] = i == 0 ? -4.0 : 3.5;
        q.contact[i].indentation = q.contact[i].last_indentation = i == 0 ? 0.4 : 1.8;
    }
    CHECK(aoi_coupled_solve(&q.e, q.contact) == AOI_OK, "there is a solution");
    CHECK(q.force[0] == 0.0 && near(q.indentation[0], -1.8 - 1.4, 1e-14), "it has let go: %g N at %g", q.force[0],
          q.indentation[0]);
    CHECK(q.indentation[1] == 0.0 && near(q.force[1], 1.4 / gives, 1e-14), "a stop: %g N at %g", q.force[1],
          q.indentation[1]);
}

static void behind_a_gap(const aoi_law *law, const double *memory, int piece, double d, double rate,
                         aoi_law_value *value)
{
    (void)memory;
    (void)piece;
    (void)rate;
    value->force = d > 1.0 ? law->parameter[0] * (d - 1.0) : 0.0;
    value->stiffness = d > 1.0 ? law->parameter[0] : 0.0;
    value->damping = 0.0;
}

/* F = k (d - 1), d = z - C F: stiff springs end so near the gap that d has few digits of their force. */
static void stiff_forces_behind_a_gap_keep_their_digits(void)
{
    const double k = 1e12, gives = 1.0;
    make(2, 1);
    for (size_t i = 0; i < 2; i++) {
        CHECK(aoi_law_create(&q.law[i], "linear", 1, &k) == AOI_OK, "a spring");
        q.law[i].force = behind_a_gap;
        *entry(q.compliance, i, i) = gives;
        q.free[i] = 1.5 + 0.25 * (double)i;
    }
    CHECK(aoi_coupled_solve(&q.e, q.contact) == AOI_OK, "stiff springs");
    for (size_t i = 0; i < 2; i++) {
        const double expected = k * (q.free[i] - 1.0) / (1.0 + k * gives);
        CHECK(near(q.force[i], expected, 1e-12), "force %.15g, not %.15g", q.force[i], expected);
    }
}

static void spoilt(const aoi_law *law, const double *memory, int piece, double d, double rate, aoi_law_value *value)
{
    (void)law;
    (void)memory;
    (void)piece;
    (void)rate;
    value->force = value->stiffness = value->damping = d > 0.0 ? (double)NAN : 0.0;
}

static void failures_are_named(void)
{
    enum { COUNT = 12, BAD = 10 }; /* BAD: so far from the first contact that its segment does not begin there */
    double mass[COUNT + 1] = {[COUNT] = 1.0};
    const int massless[COUNT + 1] = {0};
    make(COUNT, 1);
    for (size_t i = 0; i < COUNT; i++) {
        mass[i] = 1.0;
        set_law(i, 0, 1.0);
        q.free[i] = -1.0;
    }
    couple_row(mass, 1e-3, massless);
    q.free[0] = (double)NAN;
    CHECK(aoi_coupled_solve(&q.e, q.contact) == AOI_ERROR_NOT_FINITE, "an indentation of NaN");
    q.free[0] = -1.0;
    q.rate_free[1] = (double)INFINITY;
    CHECK(aoi_coupled_solve(&q.e, q.contact) == AOI_ERROR_NOT_FINITE, "an infinite rate");
    q.rate_free[1] = 0.0;
    q.law[BAD].force = spoilt;
    q.free[BAD] = 1e-3;
    CHECK(aoi_coupled_solve(&q.e, q.contact) == AOI_ERROR_LAW && q.e.failed == BAD, "a law that gives NaN");
    q.free[BAD] = -1.0;
    CHECK(aoi_coupled_solve(&q.e, q.contact) == AOI_OK, "which is not asked where bodies are apart");
}

int main(void)
{
    rows_of_any_masses(0, 3);
    rows_of_any_masses(3, 4);
    rows_of_any_masses(4, 5);
    rows_of_any_masses(5, 7);
    rows_of_any_masses(0, 7);
    bodies_touched_in_many_places(0, 3);
    bodies_touched_in_many_places(0, 7);
    what_is_not_touched_is_left_alone();
    a_push_goes_through_the_whole_row();
    a_jump_holds_its_bodies_just_touching();
    a_pull_that_cannot_hold_ends();
    stiff_forces_behind_a_gap_keep_their_digits();
    failures_are_named();
    return check_report();
}
