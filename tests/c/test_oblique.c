/* The contact equation with friction: what a step of linear bodies, coupled or not, leaves to be solved. */
#include "check.h"
#include "law/oblique.h"

enum { ROOM = 100 };

static const double K = 1.0878566e10, DEEP = 2e-6, RATIO = 0.82;

typedef struct contact {
    aoi_law law;
    aoi_friction friction;
    aoi_friction_state state;
    aoi_stretch spring[ROOM], spare[ROOM];
} contact;

static void begin(contact *c, const char *name, double mu)
{
    CHECK(aoi_law_create(&c->law, name, 1, &K) == AOI_OK, "the law %s", name);
    CHECK(aoi_friction_create(&c->friction, &c->law, mu, RATIO, 1e-3) == AOI_OK, "friction %g", mu);
    const aoi_friction_state none = {ROOM, 0, c->spring, c->spare, 0.0, 0.0, 0.0};
    c->state = none;
}

static int solve(const contact *c, const aoi_oblique_equation *e, double force[3], double place[3])
{
    aoi_oblique_solution found;
    const int status = aoi_oblique_solve(&c->friction, &c->state, e, &found);
    for (int i = 0; i < 3 && status == AOI_OK; i++) {
        force[i] = found.force[i];
        place[i] = found.place[i];
    }
    return status;
}

/* A linear law whose one spring sticks: linear algebra. */
static void what_sticks_is_linear(void)
{
    contact c;
    begin(&c, "linear", 10.0);
    const double soft = 0.5 / K;
    const aoi_oblique_equation e = {{DEEP, 0.3 * DEEP, -0.2 * DEEP},
                                    {{soft, 0.1 * soft, 0.0}, {0.1 * soft, soft, 0.2 * soft}, {0.0, 0.2 * soft, soft}},
                                    {DEEP, 0.0, 0.0}, 0.0, {0.0, 0.0, 0.0}};
    double force[3], place[3];
    CHECK(solve(&c, &e, force, place) == AOI_OK, "solved");
    CHECK(near(force[0], K * place[0], 1e-13), "the law");
    CHECK(near(force[1], RATIO * K * place[1], 1e-13) && near(force[2], RATIO * K * place[2], 1e-13), "the spring");
    for (int i = 0; i < 3; i++) {
        double sum = place[i];
        for (int j = 0; j < 3; j++) {
            sum += e.compliance[i][j] * force[j];
        }
        CHECK(fabs(sum - e.free[i]) < 1e-14 * DEEP, "row %d of the equation", i);
    }
    aoi_oblique_solution found;
    CHECK(aoi_oblique_solve(&c.friction, &c.state, &e, &found) == AOI_OK, "again");
    for (int i = 0; i < 3; i++) { /* on a linear law force = by_free free */
        const double sum = found.by_free[i][0] * e.free[0] + found.by_free[i][1] * e.free[1] + found.by_free[i][2] * e.free[2];
        CHECK(near(sum, force[i], 1e-12), "force %d by the free place", i);
    }
}

/* Sliding far, without coupling: the normal equation alone, then mu times its force. */
static void what_slides_is_coulombs(void)
{
    contact c;
    begin(&c, "hertz", 0.3);
    const double soft = DEEP / (K * DEEP * sqrt(DEEP));
    const aoi_oblique_equation e = {{2.0 * DEEP, 8.0 * DEEP, -6.0 * DEEP},
                                    {{soft, 0.0, 0.0}, {0.0, soft, 0.0}, {0.0, 0.0, soft}}, {DEEP, 0.0, 0.0}, 0.0, {0.0, 0.0, 0.0}};
    double force[3], place[3];
    CHECK(solve(&c, &e, force, place) == AOI_OK, "solved");
    CHECK(near(place[0], DEEP, 1e-13), "2 d - d = d by Hertz's law");
    CHECK(near(force[1], 0.8 * 0.3 * force[0], 1e-12) && near(force[2], -0.6 * 0.3 * force[0], 1e-12), "sliding");
}

static void what_parts_has_no_force(void)
{
    contact c;
    begin(&c, "hertz", 0.3);
    const double soft = 1.0 / (K * sqrt(DEEP));
    const aoi_oblique_equation e = {{-DEEP, DEEP, DEEP}, {{soft, 0.0, 0.0}, {0.0, soft, 0.0}, {0.0, 0.0, soft}},
                                    {DEEP, 0.0, 0.0}, 0.0, {0.0, 0.0, 0.0}};
    double force[3], place[3];
    CHECK(solve(&c, &e, force, place) == AOI_OK, "solved");
    CHECK(force[0] == 0.0 && force[1] == 0.0 && force[2] == 0.0 && near(place[0], -DEEP, 1e-13), "apart");
}

/* A symmetric positive definite matrix whose couplings are at most some half of its diagonal. */
static void coupled(uint64_t *seed, double scale, double c[3][3])
{
    double a[3][3], trace = 0.0;
    for (int i = 0; i < 9; i++) {
        a[i / 3][i % 3] = 2.0 * uniform(seed) - 1.0;
        trace += a[i / 3][i % 3] * a[i / 3][i % 3];
    }
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++) {
            const double dot = a[i][0] * a[j][0] + a[i][1] * a[j][1] + a[i][2] * a[j][2];
            c[i][j] = scale * (0.7 * (i == j) + 0.9 * dot / trace);
        }
    }
}

/* Impacts of bodies that couple all directions, in soft and stiff steps: the equation holds, and Coulomb's law. */
static void any_step_is_solved(void)
{
    uint64_t seed = 7;
    for (int i = 0; i < 3000; i++) {
        contact c;
        const double mu = decades(&seed, -2.0, 0.0), unit = mu / RATIO * DEEP;
        begin(&c, i % 5 ? "hertz" : "linear", mu);
        aoi_oblique_equation e;
        const double stiffness = i % 5 ? 1.5 * K * sqrt(DEEP) : K;
        coupled(&seed, decades(&seed, -3.0, 2.0) / stiffness, e.compliance);
        double rate[3] = {DEEP / 30.0, 0.1 * unit * (uniform(&seed) - 0.5), 0.1 * unit * (uniform(&seed) - 0.5)};
        double force[3] = {0.0, 0.0, 0.0}, place[3] = {0.0, 0.0, 0.0};
        for (int step = 0; step < 30; step++) {
            const double gone = place[0] > 0.0 ? place[0] : 0.0;
            for (int j = 0; j < 3; j++) {
                e.free[j] = (j == 0) * gone + rate[j] * (0.3 + uniform(&seed));
                for (int k = 0; k < 3; k++) {
                    e.free[j] += 0.9 * e.compliance[j][k] * force[k];
                }
                e.guess[j] = (j == 0) * gone + rate[j];
            }
            aoi_friction_refine(&c.friction, &c.state, e.guess[0], 1.0, &e.guess[1]);
            const int status = solve(&c, &e, force, place);
            CHECK(status == AOI_OK, "case %d, step %d: %s", i, step, aoi_status_text(status));
            if (status != AOI_OK) {
                break;
            }
            CHECK(hypot(force[1], force[2]) <= mu * force[0] * (1.0 + 1e-9), "Coulomb's law");
            for (int j = 0; j < 3; j++) {
                double sum = place[j] - e.free[j], terms = DEEP / 30.0;
                for (int k = 0; k < 3; k++) {
                    sum += e.compliance[j][k] * force[k];
                    terms += fabs(e.compliance[j][k] * force[k]);
                }
                CHECK(fabs(sum) < 1e-13 * terms, "case %d, step %d: row %d is off by %g", i, step, j, sum / terms);
            }
            aoi_friction_move(&c.friction, &c.state, place[0], 1.0, &place[1]);
            if (step == 14) {
                rate[0] = -rate[0];
                rate[1] *= uniform(&seed) < 0.5 ? 1.0 : -1.0;
            }
        }
    }
}

static double no_number(double indentation, double rate)
{
    (void)indentation;
    (void)rate;
    return (double)NAN;
}

static void what_is_not_a_number_is_refused(void)
{
    contact c;
    begin(&c, "hertz", 0.3);
    const aoi_oblique_equation e = {{(double)NAN, 0.0, 0.0}, {{1e-9, 0.0, 0.0}, {0.0, 1e-9, 0.0}, {0.0, 0.0, 1e-9}},
                                    {DEEP, 0.0, 0.0}, 0.0, {0.0, 0.0, 0.0}};
    double force[3], place[3];
    CHECK(solve(&c, &e, force, place) == AOI_ERROR_NOT_FINITE, "no number");
    const aoi_user_law user = {{no_number}, NULL, NULL, {1}};
    CHECK(aoi_law_create_user(&c.law, &user, 0, 0) == AOI_OK, "a law of the caller's");
    CHECK(aoi_friction_create(&c.friction, &c.law, 0.3, RATIO, 1e-3) == AOI_OK, "friction of it");
    const aoi_oblique_equation sound = {{DEEP, 0.0, 0.0}, {{1e-9, 0.0, 0.0}, {0.0, 1e-9, 0.0}, {0.0, 0.0, 1e-9}},
                                        {DEEP, 0.0, 0.0}, 0.0, {0.0, 0.0, 0.0}};
    CHECK(solve(&c, &sound, force, place) == AOI_ERROR_LAW, "a law without numbers");
}

int main(void)
{
    what_sticks_is_linear();
    what_slides_is_coulombs();
    what_parts_has_no_force();
    any_step_is_solved();
    what_is_not_a_number_is_refused();
    return check_report();
}
