/* The one equation of a step: solved to rounding wherever the search starts, for compliances and
 * stiffnesses of any size, and for laws of the caller's with kinks, plateaus and damping. */
#include "check.h"
#include "law/equation.h"

static const double DT = 1e-6;

static aoi_law power_law(double k, double n)
{
    const double parameter[] = {k, n};
    aoi_law law;
    CHECK(aoi_law_create(&law, "power", 2, parameter) == AOI_OK, "power law %g, %g", k, n);
    return law;
}

/* Starts of the search: right, nearly right, absurd. */
static double guess_number(int i, double x, double free_end)
{
    const double guesses[] = {0.0,
                              -1.0,
                              x,
                              x * (1.0 + 1e-9),
                              0.999 * x,
                              1.001 * x,
                              1e-10 * x,
                              free_end,
                              0.5 * free_end,
                              1e3 * free_end,
                              DBL_MIN,
                              (double)NAN,
                              (double)INFINITY,
                              -(double)INFINITY};
    return i < (int)(sizeof guesses / sizeof guesses[0]) ? guesses[i] : (double)NAN;
}

enum { GUESSES = 14 };

/* From the indentation x the equation is made, then solved back. compliance k x^(n-1) = stiff. */
static void solves(double n, double x, double stiff)
{
    const double k = 1.0 / pow(x, n - 1.0);
    const aoi_law law = power_law(k, n);
    aoi_law_value value;
    aoi_law_push(&law, NULL, x, 0.0, &value);
    const double free_end = x + stiff * value.force;
    for (int i = 0; i < GUESSES; i++) {
        const aoi_contact_equation equation = {free_end, stiff, 1.0, stiff / DT,
                                               guess_number(i, x, free_end)};
        double force = -1.0, indentation = -1.0;
        const int status = aoi_contact_solve(&law, NULL, &equation, &force, &indentation);
        CHECK(status == AOI_OK, "n %g, x %g, compliance k %g, guess %d: status %d", n, x, stiff, i, status);
        CHECK(near(indentation, x, 5.0 * DBL_EPSILON), "n %g: %.17g, not %.17g", n, indentation, x);
        CHECK(near(force, value.force, (8.0 + 5.0 * n) * DBL_EPSILON),
              "n %g, x %g, compliance k %g, guess %d: force off by %g", n, x, stiff, i,
              force / value.force - 1.0);
        aoi_law_value there;
        aoi_law_push(&law, NULL, indentation, 0.0, &there);
        CHECK(force == there.force, "the force is the law's at the indentation given");
        CHECK(fabs(indentation + stiff * force - free_end) <= 8.0 * DBL_EPSILON * free_end,
              "n %g, x %g, compliance k %g: the equation holds to rounding", n, x, stiff);
    }
}

static void power_laws_of_any_size(void)
{
    const double exponents[] = {1.0, 1.5, 3.0, 10.0};
    for (size_t e = 0; e < sizeof exponents / sizeof exponents[0]; e++) {
        for (int size = -15; size <= 3; size += 3) {
            for (int stiff = -20; stiff <= 20; stiff += 2) {
                solves(exponents[e], 1.7 * pow(10.0, size), 3.3 * pow(10.0, stiff));
            }
        }
    }
}

static void no_contact_no_force(void)
{
    const aoi_law law = power_law(1e10, 1.5);
    const double apart[] = {0.0, -0.0, -SMALLEST, -1e-6, -1e300};
    for (size_t i = 0; i < sizeof apart / sizeof apart[0]; i++) {
        const aoi_contact_equation equation = {apart[i], 1e-6, -3.0, 1.0, 1.0};
        double force = 5.0, x = 5.0;
        CHECK(aoi_contact_solve(&law, NULL, &equation, &force, &x) == AOI_OK && force == 0.0 && x == apart[i],
              "%g m apart", apart[i]);
    }
    /* The lightest touch there is, and an indentation that nothing resists. */
    const double light[] = {SMALLEST, DBL_MIN, 1e-300, 1e-160};
    for (size_t i = 0; i < sizeof light / sizeof light[0]; i++) {
        const aoi_contact_equation equation = {light[i], 1e-6, 1.0, 1.0, 0.0};
        double force = -1.0, x = -1.0;
        CHECK(aoi_contact_solve(&law, NULL, &equation, &force, &x) == AOI_OK, "touch of %g m", light[i]);
        CHECK(force >= 0.0 && x >= 0.0 && x <= light[i], "force %g at %g m", force, x);
    }
}

/* A step far too large runs deep into the other body, where a steep law's force overflows. */
static void too_deep_for_the_law(void)
{
    const double exponents[] = {1.5, 10.0, 50.0, 100.0};
    for (size_t i = 0; i < sizeof exponents / sizeof exponents[0]; i++) {
        for (double free_end = 1.0; free_end < 1e40; free_end *= 1e8) {
            const aoi_law law = power_law(1e10, exponents[i]);
            const aoi_contact_equation equation = {free_end, 1e-3, 1.0, 1.0, -1.0};
            double force = 0.0, x = 0.0;
            const int status = aoi_contact_solve(&law, NULL, &equation, &force, &x);
            CHECK(status == AOI_OK, "n %g from %g m: status %d", exponents[i], free_end, status);
            CHECK(fabs(x + 1e-3 * force - free_end) <= 2.0 * exponents[i] * DBL_EPSILON * free_end,
                  "n %g from %g m: force %g", exponents[i], free_end, force);
        }
    }
}

/* Laws of the caller's own. */
static void bilinear(const aoi_law *law, const double *memory, int piece, double d, double rate, aoi_law_value *value)
{
    (void)memory;
    (void)piece;
    const double knee = law->parameter[0], past = d > knee ? d - knee : 0.0;
    (void)rate;
    value->force = d > 0.0 ? d + 1e6 * past : 0.0;
    value->stiffness = d > knee ? 1.0 + 1e6 : 1.0;
    value->damping = 0.0;
}

static void plateau(const aoi_law *law, const double *memory, int piece, double d, double rate, aoi_law_value *value)
{
    (void)memory;
    (void)piece;
    const double top = law->parameter[0];
    (void)rate;
    value->force = d <= 0.0 ? 0.0 : d < top ? d : top;
    value->stiffness = d > 0.0 && d < top ? 1.0 : 0.0;
    value->damping = 0.0;
}

/* Rises and falls again: a shell that snaps through. */
static void snap(const aoi_law *law, const double *memory, int piece, double d, double rate, aoi_law_value *value)
{
    (void)memory;
    (void)piece;
    (void)law;
    (void)rate;
    value->force = d > 0.0 ? d * exp(-d) : 0.0;
    value->stiffness = d > 0.0 ? (1.0 - d) * exp(-d) : 0.0;
    value->damping = 0.0;
}

static double excess(const aoi_law *law, const aoi_contact_equation *e, double x)
{
    const double slope = e->compliance > 0.0 ? e->rate_compliance / e->compliance : 0.0;
    aoi_law_value value;
    aoi_law_push(law, NULL, x, e->rate_free + slope * (x - e->indentation_free), &value);
    return x - e->indentation_free + e->compliance * value.force;
}

/* The equation holds to the rounding of its terms, or turns over within the rounding of x (a damped
 * law may rise from nothing to more than is needed from one number to the next). */
static int is_root(const aoi_law *law, const aoi_contact_equation *e, double x)
{
    const double reach = 8.0 * DBL_EPSILON * x;
    return fabs(excess(law, e, x)) <= 8.0 * DBL_EPSILON * e->indentation_free ||
           excess(law, e, x - reach) * excess(law, e, x + reach) <= 0.0;
}

static void laws_with_kinks_and_damping(void)
{
    static const struct {
        const char *name;
        void (*force)(const aoi_law *, const double *, int, double, double, aoi_law_value *);
        double parameter;
    } laws[] = {{"bilinear", bilinear, 0.3}, {"plateau", plateau, 0.2}, {"snap-through", snap, 0.0}, {"hunt_crossley", NULL, 0.0}};
    uint64_t seed = 4;
    for (size_t l = 0; l < sizeof laws / sizeof laws[0]; l++) {
        aoi_law law = {.force = laws[l].force, .parameter = {laws[l].parameter}, .limit = HUGE_VAL};
        CHECK(law.force || aoi_law_create(&law, laws[l].name, 3, (double[]){1e3, 0.4, 1.5}) == AOI_OK, "damped");
        int failures = 0, wrong = 0;
        for (int i = 0; i < 20000; i++) {
            const double free_end = decades(&seed, -8.0, 1.0),
                         compliance = decades(&seed, -8.0, 3.0);
            const aoi_contact_equation equation = {
                free_end, compliance, 4.0 * (uniform(&seed) - 0.5), i % 2 ? compliance / DT : 0.0,
                free_end * uniform(&seed)};
            double force = 0.0, x = 0.0;
            failures += aoi_contact_solve(&law, NULL, &equation, &force, &x) != AOI_OK;
            wrong += !is_root(&law, &equation, x);
        }
        CHECK(failures == 0, "%s: %d of 20000 not solved", laws[l].name, failures);
        CHECK(wrong == 0, "%s: %d of 20000 equations do not hold", laws[l].name, wrong);
    }
}

static aoi_law dashpot(const char *name, double k, double c)
{
    const double parameter[] = {k, c};
    aoi_law law;
    CHECK(aoi_law_create(&law, name, 2, parameter) == AOI_OK, "%s %g, %g", name, k, c);
    return law;
}

/* A spring and a dashpot: linear, but for the jump at touch. What the dashpot gives there at once, if
 * more than is needed, holds the bodies just touching. */
static void a_jump_at_touch_is_solved(void)
{
    uint64_t seed = 21;
    int held = 0, pressed = 0;
    for (int i = 0; i < 20000; i++) {
        const double k = decades(&seed, 2.0, 8.0), c = decades(&seed, -2.0, 6.0);
        const double compliance = decades(&seed, -12.0, -4.0), dt = decades(&seed, -8.0, -2.0);
        const double free_end = decades(&seed, -9.0, -2.0), rate = 4.0 * uniform(&seed) * free_end / dt;
        const aoi_law law = dashpot("kelvin_voigt", k, c);
        const aoi_contact_equation equation = {free_end, compliance, rate, 2.0 * compliance / dt,
                                               free_end * (2.0 * uniform(&seed) - 0.5)};
        const double at_touch = rate - 2.0 / dt * free_end; /* rate if the bodies only just touch */
        double force = -1.0, x = -1.0;
        CHECK(aoi_contact_solve(&law, NULL, &equation, &force, &x) == AOI_OK, "equation %d", i);
        if (at_touch > 0.0 && compliance * c * at_touch >= free_end) {
            held++;
            CHECK(x == 0.0 && near(force, free_end / compliance, 4.0 * DBL_EPSILON),
                  "held by %g N, not %g", force, free_end / compliance);
        } else {
            /* x (1 + C (k + 2 c/dt)) = free_end - C c at_touch, unless the force is cut at zero */
            const double root = (free_end - compliance * c * at_touch) /
                                (1.0 + compliance * (k + 2.0 * c / dt));
            const double expected = root < free_end ? root : free_end;
            const double uncertain = compliance * c * rate /
                                     (1.0 + compliance * (k + 2.0 * c / dt));
            pressed++;
            CHECK(fabs(x - expected) <= 16.0 * DBL_EPSILON * (expected + uncertain + free_end),
                  "%g, not %g", x, expected);
            CHECK(force >= 0.0, "it does not pull");
        }
    }
    CHECK(held > 1000 && pressed > 1000, "%d held, %d pressed", held, pressed);
}

/* A dashpot that may pull holds bodies that have touched until they are apart; those that have not
 * pass by. */
static void what_pulls_lets_go_at_rest(void)
{
    const aoi_law law = dashpot("kelvin_voigt_pulling", 1e4, 1e2);
    const double dt = 1e-4, compliance = 1e-7;
    double force, x;
    /* Drawn apart to -1e-6 m at -1 m/s without force; the dashpot holds 1e2 N/(m/s) against it. */
    const aoi_contact_equation touching = {-1e-6, compliance, -1.0, 2.0 * compliance / dt, 1e-6};
    const aoi_contact_equation apart = {-1e-6, compliance, -1.0, 2.0 * compliance / dt, -1e-6};
    const double slope = 1.0 + compliance * (1e4 + 2e2 / dt);
    const double root = (-1e-6 - compliance * 1e2 * (-1.0 + 2e-6 / dt)) / slope;
    CHECK(aoi_contact_solve(&law, NULL, &touching, &force, &x) == AOI_OK, "touching");
    CHECK(near(x, root, 1e-12) && near(force, (-1e-6 - root) / compliance, 1e-12) && force < 0.0,
          "held back at %g by %g N", x, force);
    CHECK(aoi_contact_solve(&law, NULL, &apart, &force, &x) == AOI_OK && force == 0.0 && x == -1e-6, "apart");
    const aoi_contact_equation gone = {-1e-3, compliance, -1.0, 2.0 * compliance / dt, 1e-6};
    CHECK(aoi_contact_solve(&law, NULL, &gone, &force, &x) == AOI_OK && force == 0.0 && x == -1e-3,
          "too far to be held");
}

static void what_is_not_finite_is_said(void)
{
    const aoi_law law = power_law(1e10, 1.5);
    const double bad[] = {(double)NAN, (double)INFINITY, -(double)INFINITY};
    for (size_t i = 0; i < 3; i++) {
        const aoi_contact_equation place = {bad[i], 1e-6, 0.0, 1.0, 0.0};
        const aoi_contact_equation rate = {1e-6, 1e-6, bad[i], 1.0, 0.0};
        double force, x;
        CHECK(aoi_contact_solve(&law, NULL, &place, &force, &x) == AOI_ERROR_NOT_FINITE, "indentation %g", bad[i]);
        CHECK(aoi_contact_solve(&law, NULL, &rate, &force, &x) == AOI_ERROR_NOT_FINITE, "rate %g", bad[i]);
    }
    const aoi_contact_equation compliance = {1e-6, (double)NAN, 0.0, 1.0, 0.0};
    double force, x;
    CHECK(aoi_contact_solve(&law, NULL, &compliance, &force, &x) == AOI_ERROR_NOT_FINITE, "compliance NaN");
}

static double linear_law(double d, double rate) { return 2.0 * d + 0.0 * rate; }
static double endless_slope(double d, double rate) { return (double)INFINITY + 0.0 * (d + rate); }

static void an_infinite_slope_ends_no_search(void)
{
    const aoi_user_law user = {.function = {linear_law, endless_slope}, .given = {1, 1}};
    aoi_law law;
    CHECK(aoi_law_create_user(&law, &user, 0, 0) == AOI_OK, "a caller's law");
    for (int i = 0; i < GUESSES; i++) {
        const aoi_contact_equation equation = {3.0, 0.25, 0.0, 0.0, guess_number(i, 2.0, 3.0)};
        double force = -1.0, indentation = -1.0;
        CHECK(aoi_contact_solve(&law, NULL, &equation, &force, &indentation) == AOI_OK, "guess %d", i);
        CHECK(near(indentation, 2.0, 1e-14) && force == 2.0 * indentation, "guess %d: %.17g", i, indentation);
    }
}

/* OK means numbers, and an equation that holds. */
static void what_is_solved_is_solved(void)
{
    const double inf = (double)INFINITY, nan = (double)NAN;
    const double k_chi_n[] = {2.99283e-06, 380145.0, 4.99939}, k_c[] = {1e6, 10.0};
    aoi_law damped, pulling;
    CHECK(aoi_law_create(&damped, "hunt_crossley", 3, k_chi_n) == AOI_OK &&
              aoi_law_create(&pulling, "kelvin_voigt_pulling", 2, k_c) == AOI_OK,
          "laws");
    const struct {
        const aoi_law *law;
        aoi_contact_equation equation;
        int status;
    } bad[] = {{&damped, {1.0, -1.0, 0.0, 1.0, 0.0}, AOI_ERROR_ARGUMENT},
               {&damped, {1.0, 1.0, 0.0, -1.0, 0.0}, AOI_ERROR_ARGUMENT},
               {&damped, {1.0, nan, 0.0, 1.0, 0.0}, AOI_ERROR_NOT_FINITE},
               {&damped, {1.0, 1.0, 0.0, inf, 0.0}, AOI_ERROR_NOT_FINITE},
               {&damped, {1e100, 0.0, 0.0, 0.0, 0.0}, AOI_ERROR_NOT_FINITE}};
    double force, x;
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++) {
        const int status = aoi_contact_solve(bad[i].law, NULL, &bad[i].equation, &force, &x);
        CHECK(status == bad[i].status, "case %zu: status %d, force %g at %g", i, status, force, x);
    }
    const aoi_contact_equation far = {-1e-3, 1e-9, 0.0, 1e-3, inf};
    const int status = aoi_contact_solve(&pulling, NULL, &far, &force, &x);
    CHECK(status != AOI_OK || (isfinite(force) && isfinite(x)), "a guess that is no place");
    const aoi_contact_equation stiff = {914880.04819806351, 1e-6, 0.0, 1e-6, 0.0};
    CHECK(aoi_contact_solve(&damped, NULL, &stiff, &force, &x) == AOI_OK && force > 0.0 &&
              fabs(x + 1e-6 * force - stiff.indentation_free) <= DBL_EPSILON * x,
          "a force far below its terms: %g N at %.17g m", force, x);
    const aoi_contact_equation rigid = {1e-3, 0.0, 1.0, 0.0, 0.0};
    aoi_law_value value;
    aoi_law_push(&damped, NULL, 1e-3, 1.0, &value);
    CHECK(aoi_contact_solve(&damped, NULL, &rigid, &force, &x) == AOI_OK && x == 1e-3 && force == value.force,
          "bodies that do not give way");
}

/* A force that falls with the rate of parting, a d |rate|. */
static void either_way(const aoi_law *law, const double *memory, int piece, double d, double rate, aoi_law_value *value)
{
    (void)memory;
    (void)piece;
    const double a = d > 0.0 ? law->parameter[0] : 0.0;
    *value = (aoi_law_value){a * d * fabs(rate), a * fabs(rate), rate < 0.0 ? -a * d : a * d};
}

/* Bodies that a force presses apart are no deeper than without it, to the last bit. */
static void no_force_leads_past_the_motion_without_it(void)
{
    const aoi_law law = {.force = either_way, .parameter = {50.0}, .limit = HUGE_VAL, .depends_on_rate = 1};
    uint64_t seed = 11;
    for (int i = 0; i < 2000; i++) {
        const double deep = 30.0 + uniform(&seed), compliance = 1e-4 * uniform(&seed), rate = -1e-5 * uniform(&seed);
        const aoi_contact_equation e = {deep, compliance, rate, 1e9 * compliance * uniform(&seed), 1.4 * deep};
        double force, x;
        CHECK(aoi_contact_solve(&law, NULL, &e, &force, &x) == AOI_OK && force >= 0.0 && x <= deep, "case %d", i);
    }
}

/* The rate that a damper leaves has lost its first digits: the search ends where rounding does. */
static void a_damper_that_stops_nearly_all_is_solved(void)
{
    const double parameter[] = {1e6, 3000.0}, compliance = 1e-4;
    aoi_law law;
    CHECK(aoi_law_create(&law, "kelvin_voigt", 2, parameter) == AOI_OK, "a dashpot");
    for (int j = 1; j <= 2000; j++) {
        const double step = 1e-7, free_end = step * j, rate = free_end / step;
        for (int i = 0; i < 6; i++) {
            const aoi_contact_equation equation = {free_end, compliance, rate, compliance / step,
                                                   free_end * pow(10.0, -i)};
            double force = -1.0, x = -1.0;
            const int status = aoi_contact_solve(&law, NULL, &equation, &force, &x);
            CHECK(status == AOI_OK, "step %d, guess %d: status %d", j, i, status);
            CHECK(fabs(x + compliance * force - free_end) < 1e-15 * (free_end + 0.3 * rate),
                  "the equation holds to the rate's rounding");
        }
    }
}

int main(void)
{
    power_laws_of_any_size();
    no_contact_no_force();
    too_deep_for_the_law();
    laws_with_kinks_and_damping();
    a_jump_at_touch_is_solved();
    what_pulls_lets_go_at_rest();
    what_is_not_finite_is_said();
    an_infinite_slope_ends_no_search();
    what_is_solved_is_solved();
    no_force_leads_past_the_motion_without_it();
    a_damper_that_stops_nearly_all_is_solved();
    return check_report();
}
