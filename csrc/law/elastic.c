/* Laws without loss: the force is a power of the indentation. */
#include "law/kinds.h"
#include "law/law.h"

#include <math.h>

/* hertz: k. F = k d^(3/2), eqs. (13)-(15). */
static inline void hertz_at(double k, double indentation, double *force, double *stiffness)
{
    const double d = indentation > 0.0 ? indentation : 0.0, root = sqrt(d);
    *force = k * root * d;
    *stiffness = 1.5 * k * root;
}

static void hertz_force(const aoi_law *law, const double *memory, int piece, double indentation,
                        double rate, aoi_law_value *value)
{
    (void)memory;
    (void)piece;
    (void)rate;
    hertz_at(law->parameter[0], indentation, &value->force, &value->stiffness);
    value->damping = 0.0;
}

static void hertz_together(const aoi_law *law, const double *indentation, const double *rate,
                           aoi_law_values *values)
{
    const double k = law->parameter[0];
    (void)rate;
    for (size_t i = 0; i < AOI_NODES; i++) {
        hertz_at(k, indentation[i], &values->force[i], &values->stiffness[i]);
        values->damping[i] = 0.0;
    }
}

double aoi_law_three_halves_energy(const aoi_law *law, const double *memory, double indentation)
{
    const double d = indentation > 0.0 ? indentation : 0.0;
    (void)memory;
    return 0.4 * law->parameter[0] * d * d * sqrt(d);
}

/* power: k, n. F = k d^n. */
static void power_force(const aoi_law *law, const double *memory, int piece, double indentation,
                        double rate, aoi_law_value *value)
{
    (void)memory;
    (void)piece;
    (void)rate;
    value->force = value->stiffness = value->damping = 0.0;
    if (indentation > 0.0) {
        const double n = law->parameter[1];
        const double slope = law->parameter[0] * aoi_law_power(indentation, n);
        value->force = slope * indentation;
        value->stiffness = n * slope;
    }
}

static double power_potential(const aoi_law *law, const double *memory, double indentation)
{
    const double n = law->parameter[1], d = indentation;
    (void)memory;
    return d > 0.0 ? law->parameter[0] * aoi_law_power(d, n) * d * d / (n + 1.0) : 0.0;
}

/* linear: k. F = k d. */
static void linear_force(const aoi_law *law, const double *memory, int piece, double indentation,
                         double rate, aoi_law_value *value)
{
    (void)memory;
    (void)piece;
    (void)rate;
    value->force = law->parameter[0] * indentation;
    value->stiffness = law->parameter[0];
    value->damping = 0.0;
}

double aoi_law_linear_energy(const aoi_law *law, const double *memory, double indentation)
{
    (void)memory;
    return indentation > 0.0 ? 0.5 * law->parameter[0] * indentation * indentation : 0.0;
}

const aoi_law_kind aoi_laws_elastic[] = {
    {"hertz",
     1,
     {AOI_POSITIVE},
     {HUGE_VAL},
     {.force = hertz_force, .potential = aoi_law_three_halves_energy, .together = hertz_together},
     NULL},
    {"power",
     2,
     {AOI_POSITIVE, 1.0},
     {HUGE_VAL, HUGE_VAL},
     {.force = power_force, .potential = power_potential},
     NULL},
    {"linear",
     1,
     {AOI_POSITIVE},
     {HUGE_VAL},
     {.force = linear_force, .potential = aoi_law_linear_energy},
     NULL},
};
const size_t aoi_laws_elastic_count = sizeof aoi_laws_elastic / sizeof aoi_laws_elastic[0];
