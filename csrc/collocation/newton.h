/* Private to collocation/: the parts of Newton's method that one.c (a step with a single contact), many.c
 * (several) and crowd.c (very many on one body) share, in newton.c. */
#ifndef AOI_NEWTON_H
#define AOI_NEWTON_H

#include "collocation/collocation.h"
#include "law/law.h"
#include "motion/response.h"

#include <math.h>

/* State of Newton's method. */
typedef struct aoi_newton {
    int iteration;
    int renew;     /* 1: the matrix is to be recomputed */
    double before; /* the last relative change of an indentation */
    double enough; /* relative change at which the iteration has converged */
    int slides;    /* 1: an entry has friction */
} aoi_newton;

/* Ratio of the change in an iteration to the change in the iteration before, below which the matrix is kept. A new
 * matrix and its inverse cost as much as about three iterations with the old one, each of which gains more than a
 * digit. Measured: 0.017 costs 0.3 % more work, 0.15 costs 0.1 %. */
#define AOI_NEWTON_KEPT 0.05

/* Returns the initial state of Newton's method. The method converges at a change `enough` of an indentation
 * relative to its scale, or at AOI_COLLOCATION_ROUNDING if changes no longer decrease. */
aoi_newton aoi_newton_begin(size_t count, const aoi_contact_step *entry);

/* Records the largest change of an indentation relative to its scale. Returns whether the iteration has converged. */
int aoi_newton_done(aoi_newton *newton, double change);

/* True if another iteration is useful: the limit of iterations is not reached, and `change`, the last relative
 * change, is finite. */
int aoi_newton_goes_on(const aoi_newton *newton, double change);

/* Multiplies a column of an influence by a slope of the law (by), at the points where the law is evaluated. */
void aoi_collocation_weigh(enum aoi_edge edge, const double *by, const double *column, double *to);

/* Sets the force in `law` to the right-hand side of an iteration, and the slopes to those of the law. Returns 1,
 * or 0 if the equations of friction have no solution. */
int aoi_newton_law(const aoi_system *system, const aoi_newton *newton, const aoi_contact_step *entry, int with_rates,
                   aoi_law_values *law);

/* Adds a residual compliance to the matrices by which a contact's forces at the nodes of a step of length h
 * influence an indentation (displacement) and its rate (rate, or NULL). */
void aoi_newton_add_residual(double residual, double h, double *displacement, double *rate);

/* Sets `inverse` to the inverse of 1 + stiffness A + damping B, with slopes at the points where the law is
 * evaluated. A (displacement) and B (rate, or NULL) are the influences of a contact's force on its own indentation
 * and rate. All matrices are stored by columns. */
void aoi_newton_invert(enum aoi_edge edge, const double *stiffness, const double *damping, const double *displacement,
                       const double *rate, double *inverse);

/* Applies a change `by` of a contact's force (first = 1: from the constant force), and the reductions `answer` of
 * its indentation and `rate_answer` of its rate (or NULL) due to the changes of all contact forces. Returns the
 * larger of `largest` and the largest change of the indentation relative to its scale. */
static inline double aoi_newton_take(aoi_contact_step *entry, int first, const double *by, const double *answer,
                                     const double *rate_answer, double largest)
{
    const double inverse = 1.0 / entry->scale;
    for (size_t i = 0; i < AOI_NODES; i++) {
        const double next = (first ? entry->homogeneous[i] : entry->indentation[i]) - answer[i];
        const double change = fabs(next - entry->indentation[i]) * inverse;
        largest = change <= largest ? largest : change; /* a NaN counts as the largest change */
        entry->indentation[i] = next;
        entry->force[i] = (first ? entry->constant : entry->force[i]) + by[i];
    }
    for (size_t i = 0; i < AOI_NODES && rate_answer; i++) {
        entry->rate[i] = (first ? entry->homogeneous_rate[i] : entry->rate[i]) - rate_answer[i];
    }
    return largest;
}

/* Solves as aoi_collocation_solve, for a single contact. */
int aoi_collocation_solve_one(const aoi_system *system, const aoi_response *response, double h,
                              aoi_contact_step *entry);

/* Solves as aoi_collocation_solve, for a system for which aoi_crowd_pays is true. */
int aoi_crowd_solve(const aoi_system *system, const aoi_response *response, double h, size_t count,
                    aoi_contact_step *entry, double *work);

#endif
