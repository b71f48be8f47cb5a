/* The contact laws: a table of names, each with its force, its elastic energy and its parameters. */
#include "aoimpact.h"

#include <math.h>
#include <string.h>

/* hertz: k. F = k d^(3/2), eqs. (13)-(15). A square root is ten times cheaper than pow. */
static void hertz_force(const aoi_law *law, double indentation, double rate, aoi_law_value *value)
{
    const double d = indentation > 0.0 ? indentation : 0.0, root = sqrt(d);
    (void)rate;
    value->force = law->parameter[0] * root * d;
    value->stiffness = 1.5 * law->parameter[0] * root;
    value->damping = 0.0;
}

static double hertz_potential(const aoi_law *law, double indentation)
{
    const double d = indentation > 0.0 ? indentation : 0.0;
    return 0.4 * law->parameter[0] * d * d * sqrt(d);
}

/* power: k, n. F = k d^n. */
static void power_force(const aoi_law *law, double indentation, double rate, aoi_law_value *value)
{
    (void)rate;
    value->force = value->stiffness = value->damping = 0.0;
    if (indentation > 0.0) {
        const double slope = law->parameter[0] * pow(indentation, law->parameter[1] - 1.0);
        value->force = slope * indentation;
        value->stiffness = law->parameter[1] * slope;
    }
}

static double power_potential(const aoi_law *law, double indentation)
{
    const double n = law->parameter[1];
    return indentation > 0.0 ? law->parameter[0] * pow(indentation, n + 1.0) / (n + 1.0) : 0.0;
}

/* linear: k. F = k d. */
static void linear_force(const aoi_law *law, double indentation, double rate, aoi_law_value *value)
{
    const double d = indentation > 0.0 ? indentation : 0.0;
    (void)rate;
    value->force = law->parameter[0] * d;
    value->stiffness = d > 0.0 ? law->parameter[0] : 0.0;
    value->damping = 0.0;
}

static double linear_potential(const aoi_law *law, double indentation)
{
    return indentation > 0.0 ? 0.5 * law->parameter[0] * indentation * indentation : 0.0;
}

static const struct {
    const char *name;
    size_t count;
    void (*force)(const aoi_law *, double, double, aoi_law_value *);
    double (*potential)(const aoi_law *, double);
    double least[AOI_LAW_PARAMETERS]; /* parameters must be positive, and at least this */
} laws[] = {
    {"hertz", 1, hertz_force, hertz_potential, {0.0}},
    {"power", 2, power_force, power_potential, {0.0, 1.0}},
    {"linear", 1, linear_force, linear_potential, {0.0}},
};

int aoi_law_create(aoi_law *law, const char *name, size_t count, const double *parameter)
{
    for (size_t i = 0; i < sizeof laws / sizeof laws[0]; i++) {
        if (strcmp(name, laws[i].name) != 0) {
            continue;
        }
        if (count != laws[i].count) {
            return AOI_ERROR_ARGUMENT;
        }
        for (size_t j = 0; j < count; j++) {
            if (!isfinite(parameter[j]) || !(parameter[j] > 0.0) ||
                parameter[j] < laws[i].least[j]) {
                return AOI_ERROR_ARGUMENT;
            }
            law->parameter[j] = parameter[j];
        }
        law->force = laws[i].force;
        law->potential = laws[i].potential;
        return AOI_OK;
    }
    return AOI_ERROR_ARGUMENT;
}
