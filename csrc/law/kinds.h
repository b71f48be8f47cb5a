/* Private to law/: the kinds of contact laws, in tables from which law.c creates laws by name. */
#ifndef AOI_LAW_KINDS_H
#define AOI_LAW_KINDS_H

#include "aoimpact.h"

#include <float.h>
#include <math.h>

/* Lower bound of a parameter that must be greater than zero. The least positive number is not used for it, since
 * it may be flushed to zero. */
#define AOI_POSITIVE (-1.0)

/* A kind of law. Each of its `count` parameters must be finite and lie between its `least` and `most`. */
typedef struct aoi_law_kind {
    const char *name;
    size_t count;
    double least[AOI_LAW_PARAMETERS], most[AOI_LAW_PARAMETERS];
    aoi_law law;                   /* functions and flags of a law of this kind         */
    void (*prepare)(aoi_law *law); /* sets parameters that follow from the others; or NULL     */
} aoi_law_kind;

extern const aoi_law_kind aoi_laws_power[];
extern const size_t aoi_laws_power_count;
extern const aoi_law_kind aoi_laws_plastic[];
extern const size_t aoi_laws_plastic_count;
extern const aoi_law_kind aoi_law_yang_sun;

/* Returns the potential of a law whose elastic force is k d^(3/2), J; k is the first parameter. */
double aoi_law_three_halves_energy(const aoi_law *law, const double *memory, double indentation);

/* Returns d^(n-1) for d > 0. The usual exponents need at most a square root, which is ten times faster than pow. */
static inline double aoi_law_power(double d, double n)
{
    if (n == 1.5) {
        return sqrt(d);
    }
    return n == 1.0 ? 1.0 : n == 2.0 ? d : pow(d, n - 1.0);
}

#endif
