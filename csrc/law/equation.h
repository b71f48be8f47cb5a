/* The contact equation, the one nonlinear equation of a step. */
#ifndef AOI_LAW_EQUATION_H
#define AOI_LAW_EQUATION_H

#include "aoimpact.h"

/* The contact equation at the end of a step, with the linear bodies eliminated: indentation = indentation_free -
 * compliance F, rate = rate_free - rate_compliance F and F = law(indentation, rate). guess: first indentation of
 * the search, of any value; for a law that pulls, above rest if the bodies have been in contact so far. */
typedef struct aoi_contact_equation {
    double indentation_free, compliance;
    double rate_free, rate_compliance;
    double guess;
} aoi_contact_equation;

/* Solves the contact equation to rounding, by Newton's method for the indentation, with bisection inside (rest,
 * indentation_free]. The force is 0 if indentation_free <= rest or, for a law that pulls, if the law can no longer
 * hold the bodies together. The law may jump at rest: if its force just above rest exceeds the force that stops
 * the bodies there, the solution is indentation = rest, with the force that stops them. memory: the contact's
 * AOI_LAW_MEMORY doubles. Returns AOI_ERROR_LAW if the law gives NaN. */
int aoi_contact_solve(const aoi_law *law, const double *memory,
                      const aoi_contact_equation *equation, double *force, double *indentation);

#endif
