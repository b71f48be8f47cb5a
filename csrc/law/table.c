/* A law given by points, such as measured ones: Hermite cubics between the knots of the caller's table, one piece
 * each, and a straight line beyond the last knot. */
#include "aoimpact.h"

#include <float.h>
#include <math.h>

/* Relative tolerance of the given energies, in comparison with the integral of the force. */
static const double ENERGY_ROUNDING = 1e-6;

/* Rows of the caller's table. */
static const double *knots(const aoi_law *law) { return law->table; }
static const double *forces(const aoi_law *law) { return law->table + law->table_count; }
static const double *slopes(const aoi_law *law) { return law->table + 2 * law->table_count; }
static const double *energies(const aoi_law *law) { return law->table + 3 * law->table_count; }

/* Returns the index of the knot at which the piece of an indentation begins. At a knot, a rising motion is on the
 * piece above it. */
static int table_piece(const aoi_law *law, const double *memory, double indentation, int rising,
                       double *low, double *high)
{
    const double *d = knots(law);
    size_t first = 0, last = law->table_count;
    (void)memory;
    while (last - first > 1) {
        const size_t middle = first + (last - first) / 2;
        if (d[middle] < indentation || (d[middle] == indentation && rising)) {
            first = middle;
        } else {
            last = middle;
        }
    }
    *low = first > 0 ? d[first] : -HUGE_VAL;
    *high = first + 1 < law->table_count ? d[first + 1] : HUGE_VAL;
    return (int)first;
}

/* Coefficients of Hermite's cubic F_i + x (s_i + x (square + x cubic)), with x measured from the knot. */
typedef struct cubic {
    double force, slope, square, cubic;
} cubic;

static cubic cubic_of(const aoi_law *law, size_t i)
{
    const double *f = forces(law), *s = slopes(law);
    if (i + 1 == law->table_count) {
        return (cubic){f[i], s[i], 0.0, 0.0};
    }
    const double length = knots(law)[i + 1] - knots(law)[i];
    const double rise = (f[i + 1] - f[i]) / length;
    return (cubic){f[i], s[i], (3.0 * rise - 2.0 * s[i] - s[i + 1]) / length,
                   (s[i] + s[i + 1] - 2.0 * rise) / (length * length)};
}

/* Beyond its ends a piece is continued as a straight line, since the cubic would bend back and give a massless
 * contact point more than one equilibrium. */
static void table_force(const aoi_law *law, const double *memory, int piece, double indentation,
                        double rate, aoi_law_value *value)
{
    const cubic c = cubic_of(law, (size_t)piece);
    const double *d = knots(law) + piece;
    const double top = (size_t)piece + 1 < law->table_count ? d[1] : HUGE_VAL;
    const double x = fmin(fmax(indentation, d[0]), top) - d[0], past = indentation - d[0] - x;
    (void)memory;
    (void)rate;
    value->stiffness = c.slope + x * (2.0 * c.square + x * 3.0 * c.cubic);
    value->force = c.force + x * (c.slope + x * (c.square + x * c.cubic)) + past * value->stiffness;
    value->damping = 0.0;
}

static double table_potential(const aoi_law *law, const double *memory, double indentation)
{
    double low, high;
    if (indentation <= 0.0) {
        return 0.0;
    }
    const int piece = table_piece(law, memory, indentation, 0, &low, &high);
    const cubic c = cubic_of(law, (size_t)piece);
    const double x = indentation - knots(law)[piece];
    return energies(law)[piece] +
           x * (c.force + x * (c.slope / 2.0 + x * (c.square / 3.0 + x * c.cubic / 4.0)));
}

/* True if the given energies at the ends of a piece differ by the integral of its cubic, as they must. */
static int energy_is_sound(const aoi_law *law, size_t i)
{
    const double *f = forces(law) + i, *s = slopes(law) + i, *energy = energies(law) + i;
    const double length = knots(law)[i + 1] - knots(law)[i];
    const double gained = 0.5 * length * ((f[0] + f[1]) + length * (s[0] - s[1]) / 6.0);
    return fabs(energy[1] - energy[0] - gained) <= ENERGY_ROUNDING * energy[1] + DBL_MIN;
}

int aoi_law_create_table(aoi_law *law, size_t count, const double *table)
{
    *law = (aoi_law){.force = table_force, .potential = table_potential, .piece = table_piece};
    law->table = table;
    law->table_count = count;
    if (count < 2 || count > INT32_MAX || table[0] != 0.0 || table[count] != 0.0) {
        return AOI_ERROR_ARGUMENT;
    }
    for (size_t i = 0; i < 4 * count; i++) {
        if (!isfinite(table[i]) || table[i] < 0.0) {
            return AOI_ERROR_ARGUMENT;
        }
    }
    for (size_t i = 1; i < count; i++) {
        if (!(table[i] > table[i - 1]) || table[count + i] < table[count + i - 1] ||
            !energy_is_sound(law, i - 1)) {
            return AOI_ERROR_ARGUMENT;
        }
    }
    law->limit = table[count - 1];
    return AOI_OK;
}
