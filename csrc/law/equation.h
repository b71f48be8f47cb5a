/* The contact equation: the one nonlinear equation of a step. */
#ifndef AOI_LAW_EQUATION_H
#define AOI_LAW_EQUATION_H

#include "aoimpact.h"

/* What linear bodies leave to be solved at the end of a step: indentation = indentation_free -
 * compliance F and rate = rate_free - rate_compliance F, with F the law's force of the two. guess:
 * where to look for the indentation first (any value); for a law that pulls, above rest where the
 * bodies have been in contact so far. */
typedef struct aoi_contact_equation {
    double indentation_free, compliance;
    double rate_free, rate_compliance;
    double guess;
} aoi_contact_equation;

/* Solves it: Newton on the indentation, kept inside the bracket (rest, indentation_free] by
 * bisection, to rounding; force 0 where indentation_free <= rest (for a law that pulls: where it
 * would no longer hold). The law may jump at rest. If the force just above rest
 * already exceeds what the balance needs, the solution is indentation = rest with the force taken from
 * the balance. memory: the contact's, as everywhere. AOI_ERROR_LAW where the law gives NaN. */
int aoi_contact_solve(const aoi_law *law, const double *memory,
                      const aoi_contact_equation *equation, double *force, double *indentation);

#endif
