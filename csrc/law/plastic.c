/* thornton: k, yield force. An elastic-plastic contact: C. Thornton, J. Appl. Mech. 64 (1997)
 * 383-386. Hertz's law up to the yield force, then a straight line with its slope there (the pressure
 * stays at its limit over a growing core); unloading and reloading from the deepest point d*, F* as
 * Hertz on the radius that has been flattened, R_p = R k d*^(3/2) / F*, up to which
 *   F = F* ((d - d_p) / (d* - d_p))^(3/2),   d* - d_p = F* / (k d*^(1/2)). */
#include "law/kinds.h"

#include <math.h>

enum { STIFFNESS, YIELD_FORCE, YIELD, SLOPE }; /* parameters; YIELD: the indentation */
enum { DEEPEST, RESIDUAL };                    /* memory; both zero while all was elastic */
enum { ELASTIC, PLASTIC, UNLOADING };          /* pieces */

static void thornton_prepare(aoi_law *law)
{
    double *p = law->parameter;
    p[YIELD] = cbrt(p[YIELD_FORCE] / p[STIFFNESS]);
    p[YIELD] *= p[YIELD];
    p[SLOPE] = p[YIELD] > 0.0 ? 1.5 * p[STIFFNESS] * sqrt(p[YIELD]) : HUGE_VAL; /* refused */
}

static double plastic_force(const aoi_law *law, double d)
{
    return law->parameter[YIELD_FORCE] + law->parameter[SLOPE] * (d - law->parameter[YIELD]);
}

/* d* - d_p of a deepest indentation past yield. */
static double recovered(const aoi_law *law, double deepest)
{
    return plastic_force(law, deepest) / (law->parameter[STIFFNESS] * sqrt(deepest));
}

static void thornton_force(const aoi_law *law, const double *memory, int piece, double indentation,
                           double rate, aoi_law_value *value)
{
    const double d = indentation > 0.0 ? indentation : 0.0;
    (void)rate;
    value->damping = 0.0;
    if (piece == PLASTIC) {
        value->force = plastic_force(law, indentation);
        value->stiffness = law->parameter[SLOPE];
    } else if (piece == ELASTIC) {
        const double root = sqrt(d);
        value->force = law->parameter[STIFFNESS] * root * d;
        value->stiffness = 1.5 * law->parameter[STIFFNESS] * root;
    } else {
        /* From the deepest point, which is exact: after an impact far past yield almost all remains. */
        const double reach = recovered(law, memory[DEEPEST]), past = reach - (memory[DEEPEST] - d);
        const double share = past > 0.0 ? past / reach : 0.0, root = sqrt(share);
        const double top = plastic_force(law, memory[DEEPEST]);
        value->force = top * root * share;
        value->stiffness = 1.5 * top * root / reach;
    }
}

static int thornton_piece(const aoi_law *law, const double *memory, double indentation, int rising,
                          double *low, double *high)
{
    const double yield = law->parameter[YIELD], deepest = memory[DEEPEST];
    const double end = deepest > yield ? deepest : yield;
    if (indentation > end || (indentation == end && rising)) {
        *low = end;
        *high = HUGE_VAL;
        return PLASTIC;
    }
    *low = -HUGE_VAL;
    *high = end;
    return deepest > yield ? UNLOADING : ELASTIC;
}

static void thornton_remember(const aoi_law *law, double indentation, double rate, double *memory)
{
    (void)rate;
    if (indentation > law->parameter[YIELD] && indentation > memory[DEEPEST]) {
        memory[DEEPEST] = indentation;
        memory[RESIDUAL] = indentation - recovered(law, indentation);
    }
}

static double thornton_rest(const aoi_law *law, const double *memory)
{
    (void)law;
    return memory[RESIDUAL];
}

static double thornton_potential(const aoi_law *law, const double *memory, double indentation)
{
    const double d = indentation, yield = law->parameter[YIELD];
    const double deepest = d > memory[DEEPEST] ? d : memory[DEEPEST];
    if (d <= memory[RESIDUAL]) {
        return 0.0;
    }
    if (deepest <= yield) {
        return 0.4 * law->parameter[STIFFNESS] * d * d * sqrt(d);
    }
    const double reach = recovered(law, deepest);
    const double past = reach - (deepest - d), share = past > 0.0 ? past / reach : 0.0;
    return 0.4 * plastic_force(law, deepest) * reach * share * share * sqrt(share);
}

const aoi_law_kind aoi_law_thornton = {"thornton",
                                       2,
                                       {AOI_POSITIVE, AOI_POSITIVE},
                                       {HUGE_VAL, HUGE_VAL},
                                       {.force = thornton_force,
                                        .potential = thornton_potential,
                                        .piece = thornton_piece,
                                        .remember = thornton_remember,
                                        .rest = thornton_rest,
                                        .turns = 1},
                                       thornton_prepare};
