/* Elastic-plastic contacts: Hertz's law up to the yield force; then each law's own curve, which ends in a straight
 * line; from the largest indentation d*, with force F*, unloading and reloading by Hertz's law of a flattened
 * sphere,
 *   F = F* ((d - d_p) / (d* - d_p))^(3/2).
 *
 * thornton: k, yield force. C. Thornton, J. Appl. Mech. 64 (1997) 383-386. The line starts at yield with the slope
 * there (the pressure stays at its limit over a growing core), d* - d_p = F* / (k d*^(1/2)).
 *
 * elastic_plastic: k, yield force, slope s = 2 pi R p0. M. R. Brake, Int. J. Solids Struct. 49 (2012) 3129-3141:
 * fully plastic from d_f = (s/(2 k))^2 on, where Hertz's mean pressure is the hardness p0, on the line
 * F = s (d - d_f/2); between yield and d_f Hermite's cubic, which meets both curves with their slopes. For d* up
 * to d_r, d_p = d* (1 - w^(-0.28)) (1 - w^(-0.69)) by I. Etsion, Y. Kligerman, Y. Kadin, Int. J. Solids Struct. 42
 * (2005) 3716-3729, w being the ratio of d* to the indentation of yield. Beyond d_r, the recovery d* - d_p is
 * proportional to F*^(1/2), as for a flattened sphere with F = pi p0 a^2. At d_r both have the same slope: with
 * m = d ln(d* - d_p)/d ln d* and d ln F/d ln d = 2 d/(2 d - d_f), d_r = m d_f/(2 m - 1), about 1.6 d_f. If d_r
 * were d_f, the share of the work that is returned would increase there. */
#include "law/kinds.h"

#include <math.h>

/* Parameters of the laws. YIELD: indentation of yield; FULL, FULL_FORCE: indentation and force at which the
 * straight line begins; SQUARE, CUBIC: coefficients of the cubic; FITTED: d_r. */
enum { STIFFNESS, YIELD_FORCE, SLOPE, YIELD, FULL, FULL_FORCE, SQUARE, CUBIC, FITTED };
enum { DEEPEST, REACH };                    /* memory: d* and d* - d_p; both zero while all deformation was elastic */
enum { ELASTIC, MIXED, PLASTIC, UNLOADING }; /* pieces of the laws */

/* Least ratio of FULL to YIELD. If the hardness is less than about 1.25 times the pressure of yield, the recovery
 * at d_f exceeds 5/6 of d_f, and unloading would return more energy than loading takes. */
static const double LEAST_FULL = 3.5;

/* Returns (d* - d_p)/d* by Etsion, Kligerman and Kadin. w: ratio of d* to the indentation of yield; power: set to
 * the exponent m with which d* - d_p ~ d*^m near this d*. */
static double fitted(double w, double *power)
{
    const double first = pow(w, -0.28), second = pow(w, -0.69), own = first + second - first * second;
    *power = 1.0 - (0.28 * first + 0.69 * second - 0.97 * first * second) / own;
    return own;
}

static void thornton_prepare(aoi_law *law)
{
    double *p = law->parameter;
    p[YIELD] = cbrt(p[YIELD_FORCE] / p[STIFFNESS]);
    p[YIELD] *= p[YIELD];
    /* if not finite, the law is refused */
    p[SLOPE] = p[YIELD] > 0.0 ? 1.5 * p[STIFFNESS] * sqrt(p[YIELD]) : HUGE_VAL;
    p[FULL] = p[YIELD];
    p[FULL_FORCE] = p[YIELD_FORCE];
}

static void elastic_plastic_prepare(aoi_law *law)
{
    double *p = law->parameter;
    const double slope = p[SLOPE], root = 0.5 * slope / p[STIFFNESS];
    thornton_prepare(law);
    const double start = p[SLOPE], length = root * root - p[YIELD];
    p[SLOPE] = slope;
    p[FULL] = root * root >= LEAST_FULL * p[YIELD] ? root * root : HUGE_VAL; /* if not finite, the law is refused */
    p[FULL_FORCE] = 0.5 * slope * p[FULL];
    const double rise = (p[FULL_FORCE] - p[YIELD_FORCE]) / length;
    p[SQUARE] = (3.0 * rise - 2.0 * start - slope) / length;
    p[CUBIC] = (start + slope - 2.0 * rise) / (length * length);
    p[FITTED] = p[FULL];
    for (int i = 0; i < 30; i++) { /* each iteration adds a digit, since the exponent hardly changes */
        double power;
        fitted(p[FITTED] / p[YIELD], &power);
        p[FITTED] = p[FULL] * power / (2.0 * power - 1.0);
    }
}

/* Sets `value` to force and stiffness of loading at indentation d, on a piece of the law. */
static void load(const aoi_law *law, int piece, double d, aoi_law_value *value)
{
    const double *p = law->parameter;
    if (piece == PLASTIC) {
        value->force = p[FULL_FORCE] + p[SLOPE] * (d - p[FULL]);
        value->stiffness = p[SLOPE];
    } else if (piece == MIXED) {
        const double x = d - p[YIELD], start = 1.5 * p[STIFFNESS] * sqrt(p[YIELD]);
        value->force = p[YIELD_FORCE] + x * (start + x * (p[SQUARE] + x * p[CUBIC]));
        value->stiffness = start + x * (2.0 * p[SQUARE] + x * 3.0 * p[CUBIC]);
    } else {
        const double past = d > 0.0 ? d : 0.0, root = sqrt(past);
        value->force = p[STIFFNESS] * root * past;
        value->stiffness = 1.5 * p[STIFFNESS] * root;
    }
}

/* Returns the force of loading at an indentation beyond yield, N. */
static double top_force(const aoi_law *law, double deepest)
{
    aoi_law_value top;
    load(law, deepest < law->parameter[FULL] ? MIXED : PLASTIC, deepest, &top);
    return top.force;
}

/* Returns d* - d_p for a deepest indentation d* beyond yield, m. */
static double recovered(const aoi_law *law, double deepest)
{
    const double *p = law->parameter;
    if (p[FULL] > p[YIELD]) {
        const double end = fmin(deepest, p[FITTED]);
        double power;
        const double own = end * fitted(end / p[YIELD], &power);
        return deepest > end ? own * sqrt(top_force(law, deepest) / top_force(law, end)) : own;
    }
    return top_force(law, deepest) / (p[STIFFNESS] * sqrt(deepest));
}

static void plastic_force(const aoi_law *law, const double *memory, int piece, double indentation,
                          double rate, aoi_law_value *value)
{
    (void)rate;
    value->damping = 0.0;
    if (piece != UNLOADING) {
        load(law, piece, indentation, value);
        return;
    }
    /* d - d_p is computed as (d* - d_p) - (d* - d), from the stored d* - d_p: far beyond yield d_p is almost as
     * large as d, and subtracting it would lose digits. */
    const double reach = memory[REACH];
    const double past = reach - (memory[DEEPEST] - (indentation > 0.0 ? indentation : 0.0));
    const double share = past > 0.0 ? past / reach : 0.0, root = sqrt(share);
    const double top = top_force(law, memory[DEEPEST]);
    value->force = top * root * share;
    value->stiffness = 1.5 * top * root / reach;
}

static int plastic_piece(const aoi_law *law, const double *memory, double indentation, int rising,
                         double *low, double *high)
{
    const double yield = law->parameter[YIELD], full = law->parameter[FULL];
    const double deepest = memory[DEEPEST], end = deepest > yield ? deepest : yield;
    if (indentation < end || (indentation == end && !rising)) {
        *low = -HUGE_VAL;
        *high = end;
        return deepest > yield ? UNLOADING : ELASTIC;
    }
    if (end < full && (indentation < full || (indentation == full && !rising))) {
        *low = end;
        *high = full;
        return MIXED;
    }
    *low = fmax(end, full);
    *high = HUGE_VAL;
    return PLASTIC;
}

static void plastic_remember(const aoi_law *law, double indentation, double rate, double *memory)
{
    (void)rate;
    if (indentation > law->parameter[YIELD] && indentation > memory[DEEPEST]) {
        memory[DEEPEST] = indentation;
        memory[REACH] = recovered(law, indentation);
    }
}

static double plastic_rest(const aoi_law *law, const double *memory)
{
    (void)law;
    return memory[DEEPEST] - memory[REACH];
}

static double plastic_potential(const aoi_law *law, const double *memory, double indentation)
{
    const double d = indentation, yield = law->parameter[YIELD];
    const double deepest = d > memory[DEEPEST] ? d : memory[DEEPEST];
    if (d <= plastic_rest(law, memory)) {
        return 0.0;
    }
    if (deepest <= yield) {
        return 0.4 * law->parameter[STIFFNESS] * d * d * sqrt(d);
    }
    const double reach = recovered(law, deepest);
    const double past = reach - (deepest - d), share = past > 0.0 ? past / reach : 0.0;
    return 0.4 * top_force(law, deepest) * reach * share * share * sqrt(share);
}

#define PLASTIC_LAW                                                                                \
    {                                                                                              \
        .force = plastic_force, .potential = plastic_potential, .piece = plastic_piece,            \
        .remember = plastic_remember, .rest = plastic_rest, .turns = 1                             \
    }

const aoi_law_kind aoi_laws_plastic[] = {
    {"thornton", 2, {AOI_POSITIVE, AOI_POSITIVE}, {HUGE_VAL, HUGE_VAL}, PLASTIC_LAW, thornton_prepare},
    {"elastic_plastic",
     3,
     {AOI_POSITIVE, AOI_POSITIVE, AOI_POSITIVE},
     {HUGE_VAL, HUGE_VAL, HUGE_VAL},
     PLASTIC_LAW,
     elastic_plastic_prepare},
};
const size_t aoi_laws_plastic_count = sizeof aoi_laws_plastic / sizeof aoi_laws_plastic[0];
