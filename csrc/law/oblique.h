/* The contact equations of a step with friction, which have three unknowns instead of one. */
#ifndef AOI_LAW_OBLIQUE_H
#define AOI_LAW_OBLIQUE_H

#include "aoimpact.h"

/* The contact equations with friction at the end of a step, with the linear bodies eliminated: place = free -
 * compliance force, along the normal and two tangents. place: the indentation, and the slides since the last
 * friction state; force: normal force and friction; compliance: compliance of the bodies minus the part taken out
 * of the law; guess: first place of the search. The rate of the indentation is rate_free - rate_compliance
 * force. */
typedef struct aoi_oblique_equation {
    double free[3], compliance[3][3];
    double guess[3];
    double rate_free, rate_compliance[3];
} aoi_oblique_equation;

typedef struct aoi_oblique_solution {
    double force[3], place[3];
    double by_free[3][3], by_rate[3]; /* derivatives d force / d free and d force / d rate_free */
    double stuck;         /* depth within which springs stick, m */
    double share, rate;   /* share as in aoi_friction_try; rate of the indentation, m/s */
} aoi_oblique_solution;

/* A contact's friction, and the compliance that has been taken out of its law and springs. */
typedef struct aoi_rub {
    aoi_friction friction;
    double compliance[3][3];
} aoi_rub;

/* Returns the aoi_rub of a contact with friction. */
aoi_rub aoi_rub_of(const aoi_contact *contact);

/* Solves as aoi_oblique_solve, for an equation with the whole compliance of the bodies, from which the part taken
 * out of the law is subtracted here. */
int aoi_rub_solve(const aoi_rub *rub, const aoi_friction_state *state, aoi_oblique_equation *bodies,
                  aoi_oblique_solution *solution);

/* Solves the equations by Newton's method, with steps shortened where the residual would grow. The state is only
 * read. Returns AOI_ERROR_NOT_FINITE, AOI_ERROR_NO_CONVERGENCE, or AOI_ERROR_LAW if the law gives NaN. */
int aoi_oblique_solve(const aoi_friction *friction, const aoi_friction_state *state,
                      const aoi_oblique_equation *equation, aoi_oblique_solution *solution);

#endif
