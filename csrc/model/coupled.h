/* The contact equations of a step, of contacts that are coupled through bodies. */
#ifndef AOI_MODEL_COUPLED_H
#define AOI_MODEL_COUPLED_H

#include "law/oblique.h"

#include <float.h>

/* Relative rounding of a sum of a few terms. */
#define AOI_COUPLED_ROUNDING (16.0 * DBL_EPSILON)

/* Friction in a contact: its state and the contact's own indentation at the end of the last step. guess is the own place at
 * the end of this one, an indentation and two slides since the last, and found what the equations then give. */
typedef struct aoi_rubbing {
    aoi_rub rub;
    aoi_friction_state state;
    double depth, guess[3];
    aoi_oblique_solution found;
    double work, start_energy; /* of friction on the slide so far; of the stretches at the start */
} aoi_rubbing;

/* A contact for these equations: its law, and its state at the end of the last step. One with friction has three of
 * them, for its normal and two tangents. */
typedef struct aoi_contact_state {
    const aoi_law *law;
    aoi_rubbing *rubbing;            /* NULL: without friction                                 */
    size_t axis;                     /* 0, or 1 and 2 along the tangents                       */
    double from;                     /* the gap, or where the slide of this step begins        */
    size_t port[2];                  /* with fixed steps: its ports among those of all         */
    size_t contact;                  /* in a balance: its number, and whether it has a force   */
    int acts;                        /* while indentations are found                           */
    double force, indentation, rate; /* at the end of the last step                            */
    double last_indentation;         /* a step before                                          */
    double work, start_energy;       /* of F on delta so far; stored in the law at the start   */
    double memory[AOI_LAW_MEMORY];
} aoi_contact_state;

/* The contact equations of a step: delta = free - compliance F and rate = rate_free -
 * rate_compliance F, with each F its own law's force; with friction of three delta that are its own place, the slides
 * since the last step. The matrices are count x (2 band + 1) by rows,
 * row i holding the columns i-band .. i+band: contacts that share a body are at most band apart.
 * indentation, rate, force: count doubles each, the solution. work: aoi_coupled_size doubles. failed: set where a law gives
 * an error, the equation that it has. */
typedef struct aoi_coupled {
    size_t count, band;
    double *compliance, *rate_compliance;
    double *free, *rate_free;
    double *indentation, *rate, *force;
    double *work;
    size_t failed;
} aoi_coupled;

size_t aoi_coupled_size(size_t count, size_t band);

/* Solves them. contact: their laws, memories and last indentations. Newton's method on all of them at
 * once, with a banded elimination (cost linear in count); where that does not converge, contact by
 * contact with aoi_contact_solve. One contact is that alone. Errors as there. */
int aoi_coupled_solve(aoi_coupled *equations, const aoi_contact_state *contact);

#endif
