/* Laws with powers of the indentation, elastic or damped by the rate. */
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

static double linear_energy(const aoi_law *law, const double *memory, double indentation)
{
    (void)memory;
    return indentation > 0.0 ? 0.5 * law->parameter[0] * indentation * indentation : 0.0;
}

/* hunt_crossley: k, chi, n. F = k d^n (1 + chi rate): K. H. Hunt, F. R. E. Crossley, J. Appl. Mech. 42 (1975)
 * 440-445. Negative forces are returned as they are: the force is negative where the bodies part faster than
 * 1/chi. power: k, n, without chi. */
static void hunt_crossley_force(const aoi_law *law, const double *memory, int piece,
                                double indentation, double rate, aoi_law_value *value)
{
    const double n = law->parameter[2], d = indentation > 0.0 ? indentation : 0.0;
    const double slope = d > 0.0 ? law->parameter[0] * aoi_law_power(d, n) : 0.0;
    const double chi = law->depends_on_rate ? law->parameter[1] : 0.0, factor = chi > 0.0 ? 1.0 + chi * rate : 1.0;
    (void)memory;
    (void)piece;
    value->force = slope * d * factor;
    value->stiffness = n * slope * factor;
    value->damping = chi > 0.0 ? slope * d * chi : 0.0; /* 0 if chi is 0, also if the force is infinite */
}

static double hunt_crossley_potential(const aoi_law *law, const double *memory, double indentation)
{
    const double n = law->parameter[2], d = indentation;
    (void)memory;
    return d > 0.0 ? law->parameter[0] * aoi_law_power(d, n) * d * d / (n + 1.0) : 0.0;
}

static void power_prepare(aoi_law *law)
{
    law->parameter[2] = law->parameter[1];
    law->parameter[1] = 0.0;
}

/* tsuji: k, g. F = k d^(3/2) + g d^(1/4) rate, g = alpha sqrt(m k): Y. Tsuji, T. Tanaka, T. Ishida,
 * Powder Technology 71 (1992) 239-250. */
static void tsuji_force(const aoi_law *law, const double *memory, int piece, double indentation,
                        double rate, aoi_law_value *value)
{
    const double k = law->parameter[0], g = law->parameter[1], d = indentation;
    (void)memory;
    (void)piece;
    value->force = value->stiffness = value->damping = 0.0;
    if (d > 0.0) {
        const double root = sqrt(d), damping = g * sqrt(root);
        value->force = k * root * d + damping * rate;
        value->stiffness = 1.5 * k * root + 0.25 * damping / d * rate;
        value->damping = damping;
    }
}

/* kuwabara_kono: k, A. F = k (d^(3/2) + 3/2 A d^(1/2) rate): G. Kuwabara, K. Kono, Jpn. J. Appl.
 * Phys. 26 (1987) 1230-1233. */
static void kuwabara_kono_force(const aoi_law *law, const double *memory, int piece,
                                double indentation, double rate, aoi_law_value *value)
{
    const double k = law->parameter[0], lag = law->parameter[1] * rate, d = indentation;
    (void)memory;
    (void)piece;
    value->force = value->stiffness = value->damping = 0.0;
    if (d > 0.0) {
        const double root = sqrt(d);
        value->force = k * root * (d + 1.5 * lag);
        value->stiffness = 1.5 * k * (root + 0.5 * lag / root);
        value->damping = 1.5 * k * law->parameter[1] * root;
    }
}

/* kelvin_voigt, kelvin_voigt_pulling: k, c. F = k d + c rate; negative forces are replaced by zero in the first
 * law, and act until d = 0 in the second. linear: k, without c. */
static void kelvin_voigt_force(const aoi_law *law, const double *memory, int piece,
                               double indentation, double rate, aoi_law_value *value)
{
    (void)memory;
    (void)piece;
    value->force = law->parameter[0] * indentation + (law->depends_on_rate ? law->parameter[1] * rate : 0.0);
    value->stiffness = law->parameter[0];
    value->damping = law->parameter[1];
}

const aoi_law_kind aoi_laws_power[] = {
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
     {.force = hunt_crossley_force, .potential = hunt_crossley_potential},
     power_prepare},
    {"linear",
     1,
     {AOI_POSITIVE},
     {HUGE_VAL},
     {.force = kelvin_voigt_force, .potential = linear_energy},
     NULL},
    {"hunt_crossley",
     3,
     {AOI_POSITIVE, 0.0, 1.0},
     {HUGE_VAL, HUGE_VAL, HUGE_VAL},
     {.force = hunt_crossley_force, .potential = hunt_crossley_potential, .depends_on_rate = 1},
     NULL},
    {"tsuji",
     2,
     {AOI_POSITIVE, 0.0},
     {HUGE_VAL, HUGE_VAL},
     {.force = tsuji_force, .potential = aoi_law_three_halves_energy, .depends_on_rate = 1},
     NULL},
    {"kuwabara_kono",
     2,
     {AOI_POSITIVE, 0.0},
     {HUGE_VAL, HUGE_VAL},
     {.force = kuwabara_kono_force, .potential = aoi_law_three_halves_energy, .depends_on_rate = 1},
     NULL},
    {"kelvin_voigt",
     2,
     {AOI_POSITIVE, 0.0},
     {HUGE_VAL, HUGE_VAL},
     {.force = kelvin_voigt_force, .potential = linear_energy, .depends_on_rate = 1},
     NULL},
    {"kelvin_voigt_pulling",
     2,
     {AOI_POSITIVE, 0.0},
     {HUGE_VAL, HUGE_VAL},
     {.force = kelvin_voigt_force,
      .potential = linear_energy,
      .depends_on_rate = 1,
      .pulls = 1},
     NULL},
};
const size_t aoi_laws_power_count = sizeof aoi_laws_power / sizeof aoi_laws_power[0];
