/* The contact equations of a step, for contacts that are coupled through bodies. */
#ifndef AOI_MODEL_COUPLED_H
#define AOI_MODEL_COUPLED_H

#include "law/oblique.h"

#include <float.h>

/* Relative rounding error of a sum of a few terms. */
#define AOI_COUPLED_ROUNDING (16.0 * DBL_EPSILON)

/* Friction of a contact in a run with fixed steps.
 *   state, depth  the springs, and the contact's own indentation (m), at the end of the last step
 *   guess         guess of the contact's own indentation at the end of this step, and of its own slides in this step
 *   found         solution of the contact's equations at the end of this step
 *   work          work of friction on the slide so far, J
 *   start_energy  energy of the stretches at the start, J */
typedef struct aoi_rubbing {
    aoi_rub rub;
    aoi_friction_state state;
    double depth, guess[3];
    aoi_oblique_solution found;
    double work, start_energy;
} aoi_rubbing;

/* A contact in the coupled equations: its law, and its state at the end of the last step. A contact with friction
 * has three of these, for its normal and two tangents. */
typedef struct aoi_contact_state {
    const aoi_law *law;
    aoi_rubbing *rubbing;            /* NULL: without friction                                 */
    size_t axis;                     /* 0 along the normal, 1 and 2 the tangents               */
    double from;                     /* gap; for a tangent, displacement at which the slide of this step begins, m */
    /* for Newmark's rule: indices of the ports of both bodies, among the ports of all bodies */
    size_t port[2];
    size_t contact;                  /* index of the contact in the system                     */
    /* in adaptive/balance.c: 1 if the contact may have a force in the equilibrium after an event; the forces of
     * the others are set to zero */
    int acts;
    double force, indentation, rate; /* at the end of the last step                            */
    double last_indentation;         /* the indentation one step before                        */
    double work, start_energy;       /* work of the force so far; energy in the law at the start, J */
    double memory[AOI_LAW_MEMORY];
} aoi_contact_state;

/* The contact equations of a step: delta = free - compliance F and rate = rate_free - rate_compliance F, where
 * each F is the force of its law. A contact with friction has three equations, whose delta are the indentation and
 * the slides since the last step.
 *   compliance, rate_compliance   count x (2 band + 1) by rows; row i has the columns i - band to i + band,
 *                                 where band is the largest distance between two equations of one body
 *   free, rate_free               count: indentations and rates without contact forces
 *   indentation, rate, force      count: the solution
 *   work                          aoi_coupled_size doubles
 *   failed                        set to the index of the equation whose law gave an error */
typedef struct aoi_coupled {
    size_t count, band;
    double *compliance, *rate_compliance;
    double *free, *rate_free;
    double *indentation, *rate, *force;
    double *work;
    size_t failed;
} aoi_coupled;

size_t aoi_coupled_size(size_t count, size_t band);

/* Solves the coupled contact equations by Newton's method for all contacts at once, with a banded elimination
 * (cost linear in count). If this does not converge, contacts are solved in turn. A single contact is left to
 * aoi_contact_solve, whose errors are returned. contact: laws, memories and last indentations. */
int aoi_coupled_solve(aoi_coupled *equations, const aoi_contact_state *contact);

#endif
