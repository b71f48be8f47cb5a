/* yang_sun: k, critical indentation d_c, beta. Contact law of laminates: S. H. Yang, C. T. Sun, ASTM STP 787
 * (1982) 425-449; T. M. Tan, C. T. Sun, J. Appl. Mech. 52 (1985) 6-12.
 *   loading    F = k d^(3/2), up to the largest indentation d*, with force F*
 *   unloading  F = F1 ((d - d_p) / (d1 - d_p))^(5/2) from the point d1, F1 at which it begins
 *   reloading  F = F* ((d - d_p) / (d* - d_p))^(3/2) once the bodies have parted
 * d_p = 0 up to d* = d_c; beyond, d_p = d* (1 - (d_c/d*)^(2/5)), or beta (d* - d_c) if beta is not 0. The papers
 * do not treat reloading before the bodies have parted: here it follows the unloading curve back to d1, so that no
 * energy is gained. */
#include "law/kinds.h"

#include <math.h>

enum { STIFFNESS, CRITICAL, BETA };
enum { DEEPEST, TOP }; /* memory: d* and d1; both zero before the first touch */
enum { LOADING, RELOADING, UNLOADING };

/* Returns d* - d_p, the recovery from the deepest indentation d*, m. */
static double recovered(const aoi_law *law, double deepest)
{
    const double *p = law->parameter;
    if (deepest <= p[CRITICAL]) {
        return deepest;
    }
    return p[BETA] > 0.0 ? deepest - p[BETA] * (deepest - p[CRITICAL])
                         : deepest * pow(p[CRITICAL] / deepest, 0.4);
}

static double yang_sun_rest(const aoi_law *law, const double *memory)
{
    return memory[DEEPEST] - recovered(law, memory[DEEPEST]);
}

static void yang_sun_force(const aoi_law *law, const double *memory, int piece, double indentation,
                           double rate, aoi_law_value *value)
{
    const double k = law->parameter[STIFFNESS], deepest = memory[DEEPEST];
    const double reach = recovered(law, deepest), top = k * deepest * sqrt(deepest);
    /* d_p is exactly 0 up to the critical indentation. */
    const double rest = deepest - reach, d = indentation > 0.0 ? indentation : 0.0;
    const double share = (d - rest) / reach;
    (void)rate;
    *value = (aoi_law_value){0.0, 0.0, 0.0};
    if (piece == LOADING) {
        value->force = k * d * sqrt(d);
        value->stiffness = 1.5 * k * sqrt(d);
    } else if (piece == RELOADING && share > 0.0) {
        value->force = top * share * sqrt(share);
        value->stiffness = 1.5 * top * sqrt(share) / reach;
    } else if (share > 0.0) { /* y = (d - d_p)/(d1 - d_p) */
        const double first = (memory[TOP] - rest) / reach, y = first > 0.0 ? share / first : 0.0;
        value->force = top * first * sqrt(fmax(first, 0.0)) * y * y * sqrt(y);
        value->stiffness = 2.5 * value->force / (share * reach);
    }
}

static int yang_sun_piece(const aoi_law *law, const double *memory, double indentation, int rising,
                          double *low, double *high)
{
    const double deepest = memory[DEEPEST], top = memory[TOP];
    (void)law;
    if (indentation > deepest || (indentation == deepest && rising)) {
        *low = deepest;
        *high = HUGE_VAL;
        return LOADING;
    }
    if (indentation > top || (indentation == top && rising)) {
        *low = top;
        *high = deepest;
        return RELOADING;
    }
    *low = -HUGE_VAL;
    *high = top;
    return UNLOADING;
}

static void yang_sun_remember(const aoi_law *law, double indentation, double rate, double *memory)
{
    (void)rate;
    if (indentation > memory[DEEPEST]) {
        memory[DEEPEST] = memory[TOP] = indentation;
    } else if (indentation > memory[TOP]) {
        memory[TOP] = indentation;
    } else if (indentation <= yang_sun_rest(law, memory)) {
        memory[TOP] = yang_sun_rest(law, memory);
    }
}

static double yang_sun_potential(const aoi_law *law, const double *memory, double indentation)
{
    const double deepest = fmax(indentation, memory[DEEPEST]), reach = recovered(law, deepest);
    double low, high;
    aoi_law_value value;
    if (indentation <= yang_sun_rest(law, memory)) {
        return 0.0;
    }
    const int piece = yang_sun_piece(law, memory, indentation, 0, &low, &high);
    yang_sun_force(law, memory, piece, indentation, 0.0, &value);
    return value.force * (indentation - (deepest - reach)) / 3.5;
}

const aoi_law_kind aoi_law_yang_sun = {"yang_sun",
                                       3,
                                       {AOI_POSITIVE, AOI_POSITIVE, 0.0},
                                       {HUGE_VAL, HUGE_VAL, 1.0},
                                       {.force = yang_sun_force,
                                        .potential = yang_sun_potential,
                                        .piece = yang_sun_piece,
                                        .remember = yang_sun_remember,
                                        .rest = yang_sun_rest,
                                        .turns = 1},
                                       NULL};
