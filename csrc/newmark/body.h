/* Private to newmark/: a body that Newmark's rule takes through time, section 3.1 of the paper. */
#ifndef AOI_NEWMARK_BODY_H
#define AOI_NEWMARK_BODY_H

#include "linear/work.h"

/* One step of a rule: u = p + reach a' and v = q + correct_v a', with a' the new acceleration and the predictors
 * p = u + dt (v + predict_u a), q = v + predict_v a; reach = dt correct_u. */
typedef struct aoi_rule_step {
    double dt, predict_u, predict_v, correct_u, correct_v, reach;
} aoi_rule_step;

/* Prepares the steps of a rule. AOI_ERROR_ARGUMENT for an invalid rule, or where dt^2 leaves the
 * range of numbers. */
int aoi_rule_prepare(const aoi_rule *rule, aoi_rule_step *step);

enum { AOI_STEPPED_OWN = 3, AOI_PLAIN_SEEN = 4 };

/* A body that is advanced in steps. */
typedef struct aoi_stepped {
    const aoi_modes *model;
    const struct aoi_stepped_kind *kind;
    const aoi_rule_step *step;
    double *x, *v, *a;                    /* [n]: coordinates, rates, accelerations                  */
    double *free_a;                       /* [n]: the next acceleration without forces at the ports  */
    double *gain;                         /* [ports][n]: next acceleration per unit port force      */
    double *before;                       /* [n]: rates before the step of a damped body, else NULL  */
    double *own[AOI_STEPPED_OWN];         /* [n] each: arrays that the kind of body defines          */
    double *seen;                         /* [n][AOI_PLAIN_SEEN]: weights, modal.c                   */
    /* [ports][ports]: displacements and velocities of the ports at the end of a step, per unit force at that time */
    double *compliance, *rate_compliance;
    double dissipated;                    /* energy lost since the start, J                          */
    double centre[2];                     /* displacement and rate of the centre of mass, without the
                                             residual                                                */
    /* number of coordinates up to the last that moves the centre */
    size_t centre_count;
    int plain;                            /* 1: modes without damping and gravity, one port: modal.c */
    int moved;                            /* 1: x and v of a plain body are out of date              */
    double port_rate, port_a, reached;    /* plain body: of its port, and below of its centre of mass */
    double centre_rate, centre_a, centre_reached;
} aoi_stepped;

/* The functions that differ between bodies in modes and bodies in finite elements. */
typedef struct aoi_stepped_kind {
    /* sets gain, own, and before to NULL if undamped */
    int (*prepare)(aoi_stepped *body);
    /* sets a at the start, under the forces in free_a */
    int (*begin)(aoi_stepped *body);
    int (*accelerate)(aoi_stepped *body);            /* sets free_a by the predictors in x and v        */
    /* power of dashpots at the rates in before, W */
    double (*power)(const aoi_stepped *body);
    void (*observe)(const aoi_stepped *body, double *row, size_t stride); /* energies and gravity's work,
                                                                             without the residual       */
} aoi_stepped_kind;

extern const aoi_stepped_kind aoi_stepped_modal, aoi_stepped_full;

/* Steps of a plain body: the start, and prediction and correction of a step. seen: 1: x and v are
 * needed at its end. */
void aoi_plain_start(aoi_stepped *body);
void aoi_plain_predict(aoi_stepped *body, double *displacement, double *velocity);
void aoi_plain_correct(aoi_stepped *body, double force, int seen);

/* Lays out the arrays, without x and v. */
void aoi_stepped_lay_out(aoi_stepped *body, const aoi_modes *model, aoi_memory *memory);

/* Makes a body ready for steps by a rule, which it keeps; x and v are set. AOI_ERROR_NOT_FINITE where a compliance leaves
 * the range of numbers; and the kind's errors. */
int aoi_stepped_start(aoi_stepped *body, const aoi_rule_step *step);

/* Finds the accelerations at the start under a force at each port. */
int aoi_stepped_begin(aoi_stepped *body, const double *force);

/* Steps of a body that is not plain. aoi_stepped_predict advances it to the end of a step without forces at the
 * ports, and gives the displacements and velocities of the ports there, without the deflection of the residual
 * compliance. aoi_stepped_correct adds the forces at the end of the step. */
int aoi_stepped_predict(aoi_stepped *body, double *displacement, double *velocity);
void aoi_stepped_correct(aoi_stepped *body, const double *force);

/* Brings x and v up to the end of the last step. */
void aoi_stepped_settle(aoi_stepped *body);

/* Deflection of port p by its residual compliance under forces on all ports, m. */
double aoi_stepped_residual(const aoi_stepped *body, size_t p, const double *force);

/* Writes the rows of enum aoi_body_row, stride apart, the energies only if they are wanted. force, force_before:
 * forces on the ports, now and one step before, N. */
void aoi_stepped_observe(const aoi_stepped *body, const double *force, const double *force_before, int energies,
                         double *row, size_t stride);

#endif
