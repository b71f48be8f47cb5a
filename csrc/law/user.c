/* The law written by the caller: calls of its functions, and finite differences or quadrature in place of those
 * that are not given. */
#include "aoimpact.h"

#include <math.h>

/* Relative steps of one-sided differences, each of which costs one more call. INDENTATION_STEP: eps^(1/2), for
 * eight digits. RATE_STEP: longer, since laws are nearly linear in the rate. LEAST_RATE, m/s: the step of this
 * rate is also used for lower rates, since it must not be 0 at rest. */
static const double INDENTATION_STEP = 1.5e-8, RATE_STEP = 6e-6, LEAST_RATE = 1e-3;

static double ask(const aoi_law *law, int which, double indentation, double rate)
{
    const aoi_user_law *user = &law->user;
    return user->call ? user->call(user->data, which, indentation, rate)
                      : user->function[which](indentation, rate);
}

static void user_force(const aoi_law *law, const double *memory, int piece, double indentation,
                       double rate, aoi_law_value *value)
{
    const double d = indentation;
    (void)memory;
    (void)piece;
    value->force = value->stiffness = value->damping = 0.0;
    if (d <= 0.0) {
        return;
    }
    value->force = ask(law, AOI_USER_FORCE, d, rate);
    if (law->user.given[AOI_USER_STIFFNESS]) {
        value->stiffness = ask(law, AOI_USER_STIFFNESS, d, rate);
    } else {
        const double step = INDENTATION_STEP * d;
        value->stiffness = (ask(law, AOI_USER_FORCE, d + step, rate) - value->force) / step;
    }
    if (law->user.given[AOI_USER_DAMPING]) {
        value->damping = ask(law, AOI_USER_DAMPING, d, rate);
    } else if (law->depends_on_rate) {
        const double step = RATE_STEP * fmax(fabs(rate), LEAST_RATE);
        value->damping = (ask(law, AOI_USER_FORCE, d, rate + step) - value->force) / step;
    }
}

static double user_force_alone(const aoi_law *law, double indentation, double rate)
{
    return ask(law, AOI_USER_FORCE, indentation, rate);
}

/* Gauss's quadrature rule with 16 points: the 8 positive abscissas on (-1, 1), and their weights. */
enum { HALF_RULE = 8 };
static const double ABSCISSA[HALF_RULE] = {
    0.0950125098376374402, 0.281603550779258913, 0.458016777657227386, 0.617876244402643748,
    0.755404408355003034,  0.865631202387831744, 0.944575023073232576, 0.989400934991649933};
static const double WEIGHT[HALF_RULE] = {
    0.189450610455068496,  0.182603415044923589,  0.169156519395002538,  0.149595988816576732,
    0.124628971255533872,  0.0951585116824927848, 0.0622535239386478929, 0.0271524594117540949};

/* Returns the potential, int_0^d F dx, J. With the substitution x = d s^2, powers n/2 of the indentation become
 * polynomials. */
static double user_potential(const aoi_law *law, const double *memory, double indentation)
{
    const double d = indentation;
    double sum = 0.0;
    (void)memory;
    if (d <= 0.0) {
        return 0.0;
    }
    if (law->user.given[AOI_USER_POTENTIAL]) {
        return ask(law, AOI_USER_POTENTIAL, d, 0.0);
    }
    for (int i = 0; i < HALF_RULE; i++) {
        for (int side = -1; side <= 1; side += 2) {
            const double s = 0.5 + 0.5 * side * ABSCISSA[i];
            const double force = ask(law, AOI_USER_FORCE, d * s * s, 0.0);
            if (isnan(force) && law->note) {
                law->note[0] = d * s * s;
                law->note[1] = 0.0;
                law->note[2] = AOI_ERROR_LAW;
            }
            sum += WEIGHT[i] * s * force;
        }
    }
    return d * sum;
}

int aoi_law_create_user(aoi_law *law, const aoi_user_law *user, int depends_on_rate, int pulls)
{
    *law = (aoi_law){.force = user_force, .potential = user_potential, .limit = HUGE_VAL};
    law->alone = user_force_alone;
    law->user = *user;
    law->depends_on_rate = depends_on_rate;
    law->pulls = pulls;
    if (!user->given[AOI_USER_FORCE]) {
        return AOI_ERROR_ARGUMENT;
    }
    for (int i = 0; i < AOI_USER_FUNCTIONS; i++) {
        if (user->given[i] && !user->call && !user->function[i]) {
            return AOI_ERROR_ARGUMENT;
        }
    }
    return AOI_OK;
}
