/* Bodies that Newmark's rule takes through time: section 3.1 of the paper. */
#ifndef AOI_NEWMARK_BODY_H
#define AOI_NEWMARK_BODY_H

#include "linear/sparse.h"

/* What a rule does in one step, u = p + reach a' and v = q + correct_v a' with the predictors p = u +
 * dt (v + predict_u a), q = v + predict_v a; reach = dt correct_u. */
typedef struct aoi_rule_step {
    double dt, predict_u, predict_v, correct_u, correct_v, reach;
} aoi_rule_step;

/* AOI_ERROR_ARGUMENT where the rule is none, or dt^2 leaves the range of numbers. */
int aoi_rule_prepare(const aoi_rule *rule, aoi_rule_step *step);

/* Rayleigh's damping: C = alpha M + beta K; alpha [1/s] and beta [s] >= 0. On a star: dashpots
 * alpha m_i to the ground and beta k_i beside each spring. */
typedef struct aoi_rayleigh {
    double alpha, beta;
} aoi_rayleigh;

/* How a body starts. u, v: its coordinates' initial values; centre: their weights in the centre of
 * mass; gravity: a constant force on each [N], or NULL; force: what has bent the residual compliance of a
 * body in modes [N], then how fast that changes [N/s], 2 ports in all, or NULL: nothing. All are kept by
 * the body but u, v and force. */
typedef struct aoi_body_start {
    const double *u, *v, *centre, *gravity, *force;
} aoi_body_start;

/* A linear body with one or more ports (contact functionals) that a rule takes through time. begin()
 * finds the accelerations of the initial state under a force [N] at each port. predict() moves the
 * body to the end of the step without forces at the ports and gives their displacements and
 * velocities there; correct() adds forces: displacements change by compliance times them, velocities
 * by rate_compliance times them (both ports x ports). One predict() then one correct() is a step.
 * observe() writes what enum aoi_body_row says, stride apart; the four in J only where energies is
 * not zero. */
typedef struct aoi_body aoi_body;
struct aoi_body {
    int (*begin)(aoi_body *body, const double *force);
    int (*predict)(aoi_body *body, double *displacement, double *velocity);
    void (*correct)(aoi_body *body, const double *force);
    void (*observe)(const aoi_body *body, int energies, double *row, size_t stride);
    void (*copy_state)(const aoi_body *body, double *u, double *v); /* all coordinates, velocities */
    size_t ports;
    const double *compliance, *rate_compliance;
    const void *model;              /* the aoi_star, aoi_modes or aoi_full                    */
    const double *centre, *gravity; /* of aoi_body_start                                      */
    double *state;                  /* the work space given at the start, laid out by the body */
    aoi_rule_step step;
    double scratch[16]; /* the body's own constants and sums                      */
};

/* Doubles of work space for aoi_body_start_star. Coordinates are n+1, the contact's first; one port. */
size_t aoi_body_star_size(size_t n);

/* A star about to step by rule, O(n) a step. damping: NULL for none; a damped star needs m0 > 0.
 * Without m0 the contact is stepped as the algebraic equation that it is. Everything but start itself
 * must outlive the body. */
int aoi_body_start_star(aoi_body *body, const aoi_star *star, const aoi_rayleigh *damping,
                        const aoi_rule *rule, const aoi_body_start *start, double *work);

/* Doubles of work space for aoi_body_start_modal. Coordinates are the n modes. */
size_t aoi_body_modal_size(size_t n, size_t ports);

/* As aoi_body_start_star, but gravity and centre are those of the modes. The residual's velocity is its
 * displacement's change over the step. The load is the scene's. */
int aoi_body_start_modal(aoi_body *body, const aoi_modes *modes, const aoi_rule *rule,
                         const aoi_body_start *start, double *work);

/* A finite-element body: K, M (n x n) and C by damping, contact functionals b ([ports][n]), and a
 * solver of (1 + alpha gamma dt) M + (beta' dt^2 + beta gamma dt) K, beta' being the rule's. pause: called
 * while begin() solves with M, or NULL. */
typedef struct aoi_full {
    aoi_sparse K, M;
    const double *b;
    size_t ports;
    aoi_rayleigh damping;
    aoi_solver solver;
    const aoi_pause *pause;
} aoi_full;

/* Doubles of work space for aoi_body_start_full. */
size_t aoi_body_full_size(size_t n, size_t ports);

/* As aoi_body_start_star, for finite elements: one solve for each port here, one a step. begin() solves
 * with M by conjugate gradients; rows without mass get no acceleration. */
int aoi_body_start_full(aoi_body *body, const aoi_full *full, const aoi_rule *rule,
                        const aoi_body_start *start, double *work);

#endif
