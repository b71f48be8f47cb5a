/* Private to collocation/: Newton's method, newton.c, as many.c (all contacts of a step) and one.c (a single one) use
 * it. */
#ifndef AOI_COLLOCATION_H
#define AOI_COLLOCATION_H

#include "collocation/collocation.h"
#include "law/law.h"
#include "motion/response.h"

#include <math.h>

/* State of Newton's method. */
typedef struct aoi_newton {
    int iteration;
    int renew;     /* the matrix is to be recomputed */
    double before; /* the last change */
    double enough; /* change at which it has converged */
    int slides;    /* with friction */
} aoi_newton;

/* 1 if the iteration is near enough for the difference of two paths of friction to be found, and not so near that it
 * has been. */
int aoi_newton_nears(const aoi_newton *newton);

/* The beginning of an iteration. It has converged at this change of the indentation relative to its scale, or at
 * AOI_COLLOCATION_ROUNDING where changes no longer shrink. */
static inline aoi_newton aoi_newton_begin(void) { return (aoi_newton){0, 1, HUGE_VAL, 1e-15, 0}; }

/* Notes a change of the indentation, relative to its scale. Returns whether the iteration has converged. */
int aoi_newton_done(aoi_newton *newton, double change);

/* True if the iteration can still converge. */
int aoi_newton_goes_on(const aoi_newton *newton, double change);

/* Evaluates the law at the nodes, or at the points of an edge. */
void aoi_collocation_evaluate(const aoi_law *law, const aoi_contact_step *entry, int with_rates,
                         aoi_law_values *of);

/* Interpolates nodal values to the edge's quadrature points. The output may alias the input. */
void aoi_edge_reach(enum aoi_edge edge, double start, const double *nodes, double *points);

/* A column of a coupling, times a derivative of the law at the points where that is evaluated. */
void aoi_collocation_weigh(enum aoi_edge edge, const double *by, const double *column, double *to);

/* The right-hand side of the first iteration in place of the law's force, or of later ones. */
void aoi_collocation_aim(const aoi_contact_step *entry, int first, int with_rates, aoi_law_values *law);

/* aoi_collocation_solve where there is one contact. */
int aoi_collocation_solve_one(const aoi_system *system, const aoi_response *response, double h,
                              aoi_contact_step *entry);

#endif
