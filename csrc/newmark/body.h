/* Private to newmark/: a body that Newmark's rule advances in time (section 3.1 of the paper). */
#ifndef AOI_NEWMARK_BODY_H
#define AOI_NEWMARK_BODY_H

#include "linear/work.h"

/* Coefficients of one step of a rule: u = p + reach a' and v = q + correct_v a', with the new acceleration a' and
 * the predictors p = u + dt (v + predict_u a), q = v + predict_v a; reach = dt correct_u. */
typedef struct aoi_rule_step {
    double dt, predict_u, predict_v, correct_u, correct_v, reach;
} aoi_rule_step;

/* Sets the coefficients of a rule's step. Returns AOI_ERROR_ARGUMENT for an invalid rule, or if dt^2 overflows or
 * underflows. */
int aoi_rule_prepare(const aoi_rule *rule, aoi_rule_step *step);

enum { AOI_STEPPED_OWN = 3, AOI_PLAIN_SEEN = 4 };

/* A body that is advanced in steps of Newmark's rule. */
typedef struct aoi_stepped {
    const aoi_modes *model;
    const struct aoi_stepped_kind *kind;
    const aoi_rule_step *step;
    double *x, *v, *a;                    /* [n]: coordinates, rates, accelerations                  */
    double *free_a;                       /* [n]: the next acceleration without forces at the ports  */
    double *gain;                         /* [ports][n]: next acceleration per unit force on a port */
    double *before;                       /* [n]: rates before the step, for a damped body; else NULL */
    double *own[AOI_STEPPED_OWN];         /* [n] each: arrays whose meaning depends on the kind of body */
    double *seen;                         /* [n][AOI_PLAIN_SEEN]: weights of a plain body's sums, modal.c */
    /* [ports][ports]: displacements and velocities of the ports at the end of a step, per unit force at that time */
    double *compliance, *rate_compliance;
    double dissipated;                    /* energy lost since the start, J                          */
    /* displacement and rate of the centre of mass, without the deflection of the residual compliance */
    double centre[2];
    /* number of coordinates, up to the last one that moves the centre */
    size_t centre_count;
    /* 1: plain body (in modes, without damping and gravity, with one port: modal.c) */
    int plain;
    int moved;                            /* 1: x and v of a plain body are out of date              */
    /* plain body: predicted rate and acceleration of its port without a force on it, and the port's acceleration
     * per unit force; below the same for its centre of mass */
    double port_rate, port_a, reached;
    double centre_rate, centre_a, centre_reached;
} aoi_stepped;

/* The functions that differ between bodies in modes and bodies in finite elements. */
typedef struct aoi_stepped_kind {
    /* sets gain and own; sets before to NULL if the body is undamped */
    int (*prepare)(aoi_stepped *body);
    /* sets a at the start, under the forces in free_a */
    int (*begin)(aoi_stepped *body);
    int (*accelerate)(aoi_stepped *body);            /* sets free_a from the predictors in x and v      */
    /* returns the power dissipated by damping at the rates in `before`, W */
    double (*power)(const aoi_stepped *body);
    /* writes energies and gravity's work, without the residual compliance */
    void (*observe)(const aoi_stepped *body, double *row, size_t stride);
} aoi_stepped_kind;

extern const aoi_stepped_kind aoi_stepped_modal, aoi_stepped_full;

/* Steps of a plain body: the start, and the prediction and correction of a step. seen = 1: x and v are needed at
 * the step's end. */
void aoi_plain_start(aoi_stepped *body);
void aoi_plain_predict(aoi_stepped *body, double *displacement, double *velocity);
void aoi_plain_correct(aoi_stepped *body, double force, int seen);

/* Lays out the arrays of a body, except x and v. */
void aoi_stepped_lay_out(aoi_stepped *body, const aoi_modes *model, aoi_memory *memory);

/* Prepares a body, whose x and v are set, for steps of a rule; the body keeps the pointer to `step`. Returns
 * AOI_ERROR_NOT_FINITE if a compliance overflows, AOI_ERROR_NOT_POSITIVE, or an error of the body's kind. */
int aoi_stepped_start(aoi_stepped *body, const aoi_rule_step *step);

/* Finds the accelerations at the start, under the given forces on the ports. */
int aoi_stepped_begin(aoi_stepped *body, const double *force);

/* Steps of a body that is not plain. aoi_stepped_predict advances the body to the end of a step without forces on
 * the ports. It finds the displacements and velocities of the ports there, without the deflection of the residual
 * compliance. aoi_stepped_correct adds the effect of the forces at the end of the step. */
int aoi_stepped_predict(aoi_stepped *body, double *displacement, double *velocity);
void aoi_stepped_correct(aoi_stepped *body, const double *force);

/* Brings x and v of a body up to date, at the end of the last step. */
void aoi_stepped_settle(aoi_stepped *body);

/* Returns the deflection of port p due to its residual compliance, under forces on all ports, m. */
double aoi_stepped_residual(const aoi_stepped *body, size_t p, const double *force);

/* Writes the rows of enum aoi_body_row to `row`, `stride` doubles apart; those of energies only if energies = 1.
 * force, force_before: forces on the ports now and one step before, N. */
void aoi_stepped_observe(const aoi_stepped *body, const double *force, const double *force_before, int energies,
                         double *row, size_t stride);

#endif
