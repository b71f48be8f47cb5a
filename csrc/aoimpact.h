/* aoimpact: the anti-oscillator model of a body at its point of contact, and impacts in time.
 *
 * This header is the whole public interface of the C core, and its specification. "Paper" is
 * E. Jacquelin, "On the rigid projectile model for low velocity impacts"; equation numbers are its.
 *
 * Rules that hold for every function
 *   Memory    The caller owns all memory. Nothing here allocates, frees, or keeps a pointer after
 *             it returns, except inside an object that the caller made, for as long as it uses it.
 *             Work space is asked for by the size functions beside each object.
 *   State     There are no globals. Objects may be used from several threads, one thread each.
 *   Units     SI: m, kg, s, N, J, rad/s; omega2 is an angular frequency squared, (rad/s)^2.
 *   Returns   AOI_OK (0) or one of the codes below; then the outputs are not to be used.
 *   Arrays    Contiguous doubles; dense matrices by columns (Fortran order) unless said otherwise.
 */
#ifndef AOIMPACT_H
#define AOIMPACT_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef enum aoi_status {
    AOI_OK = 0,
    AOI_ERROR_ARGUMENT,       /* a size, sign or parameter that the function's paragraph excludes */
    AOI_ERROR_NOT_FINITE,     /* an infinity or NaN came up where none may be                     */
    AOI_ERROR_NOT_POSITIVE,   /* a pivot, mass or stiffness that must be positive is not           */
    AOI_ERROR_NO_CONVERGENCE, /* an iteration reached its limit                                    */
    AOI_ERROR_UNREACHED,      /* the contact functional does not move the body at all              */
    AOI_ERROR_SOLVER          /* the caller's linear solver reported a failure                     */
} aoi_status;

/* ------------------------------------------------------------------------- vectors: vector.c */

/* x^T y of n doubles. */
double aoi_vector_dot(size_t n, const double *x, const double *y);

/* y += factor x, n doubles, not overlapping. */
void aoi_vector_add(size_t n, double factor, const double *x, double *y);

/* ------------------------------------------------------------------ sparse matrices: sparse.c */

/* A symmetric n x n matrix by compressed rows, all entries stored (both triangles): row i has
 * indices[p], values[p] for start[i] <= p < start[i+1]. The arrays belong to the caller. */
typedef struct aoi_sparse {
    size_t n;
    const int32_t *start, *indices;
    const double *values;
} aoi_sparse;

/* Checks that an aoi_sparse of stored_count entries can be read safely: start rises from 0 to
 * stored_count, indices lie in 0..n-1. AOI_ERROR_ARGUMENT where they do not. */
int aoi_sparse_check(const aoi_sparse *matrix, size_t stored_count);

/* y = A x; x and y of n doubles, not overlapping. */
void aoi_sparse_multiply(const aoi_sparse *matrix, const double *x, double *y);

/* x^T A x without work space. */
double aoi_sparse_quadratic(const aoi_sparse *matrix, const double *x);

/* A linear solver seen by the core: solve() overwrites x (n doubles: right-hand side in, solution
 * out) and returns 0, or anything else for a failure. data is passed through untouched. */
typedef struct aoi_solver {
    int (*solve)(void *data, double *x);
    void *data;
} aoi_solver;

/* Factors of a symmetric positive definite matrix, P A P^T = L D L^T: L unit lower triangular by
 * compressed columns WITHOUT its diagonal, rows of a column ascending; D the n pivots, all
 * positive; row i of A is row place[i] of P A P^T. Columns of like pattern stand in panels, which
 * are swept together: panel p is columns panel[p] .. panel[p+1]-1, panel[panel_count] = n. work: n
 * doubles. An aoi_factors is one thread's. */
typedef struct aoi_factors {
    size_t n;
    const int32_t *start, *rows;
    const double *values, *pivots;
    const int32_t *place;
    const int32_t *panel;
    size_t panel_count;
    double *work;
} aoi_factors;

/* Finds the widest panels: runs of columns of which each has the rows of the next, and the next
 * itself. panel: room for n+1 in, panel_count+1 out. The indices must be sound. */
size_t aoi_factors_find_panels(size_t n, const int32_t *start, const int32_t *rows, int32_t *panel);

/* Checks indices and panels, and that the pivots are positive (AOI_ERROR_NOT_POSITIVE: A was not
 * definite). */
int aoi_factors_check(const aoi_factors *factors, size_t stored_count);

/* x <- A^-1 x by two triangular sweeps; data is an aoi_factors: it fits aoi_solver.solve. */
int aoi_factors_solve(void *data, double *x);

/* -------------------------------------------------- from matrices to a star: reduce.c, section 2 */

/* Static mode of a held body, eqs. (2), (3), (11). In: b, the contact functional (u = b^T X), and
 * x = K^-1 b, n doubles each. Out: x becomes phi_st = K^-1 b / (b^T K^-1 b), so b^T phi_st = 1;
 * stiffness gets k0 = 1 / (b^T K^-1 b). AOI_ERROR_UNREACHED if b is zero, AOI_ERROR_NOT_POSITIVE if
 * b^T K^-1 b <= 0 (K is no stiffness of a held body). */
int aoi_static_held(size_t n, const double *b, double *x, double *stiffness);

/* Static mode of a free body: the rigid-body motion that b excites, phi_st = R r / (r^T r) with
 * R (n x rigid_count, M-orthonormal) and r = R^T b. Its mass is 1 / (r^T r) and its k0 is zero. The
 * rest of the rigid motion is M-orthogonal to it and never feels the contact.
 * AOI_ERROR_UNREACHED if r is zero to rounding: seen from b the body is then held. */
int aoi_static_free(size_t n, size_t rigid_count, const double *rigid, const double *b,
                    double *phi_st, double *mass);

/* Inverse iteration on the constraint modes' space b^T phi = 0: given x = A^-1 f and z = A^-1 b with
 * A symmetric positive definite (e.g. K + s^2 M), overwrites x by the solution of A x + mu b = f,
 * b^T x = 0. n doubles each. AOI_ERROR_NOT_POSITIVE if b^T z <= 0. */
int aoi_constraint_project(size_t n, const double *b, const double *z, double *x);

/* The Householder vector h (n doubles, h^T h = 2) with (I - h h^T) b = -+|b| e_1, by which the
 * space b^T phi = 0 becomes "first entry zero". AOI_ERROR_UNREACHED if b is zero. */
int aoi_constraint_reflector(size_t n, const double *b, double *h);

/* A <- (I - h h^T) A (I - h h^T) for a symmetric dense A (n x n); its rows and columns 1..n-1 are
 * then A on the space b^T phi = 0. work: n doubles. */
void aoi_constraint_congruence(size_t n, const double *h, double *a, double *work);

/* Eqs. (6), (9), (12) for count constraint modes. In: phi (n x count), any norm, each column's
 * omega2 > 0 and modal_mass phi^T M phi > 0, and m_phi_st = M phi_st. Out, per column: c_i in
 * coefficient, m_i in mass, k_i = omega2_i m_i in stiffness. */
int aoi_oscillators_project(size_t n, size_t count, const double *phi, const double *modal_mass,
                            const double *omega2, const double *m_phi_st, double *coefficient,
                            double *mass, double *stiffness);

/* --------------------------------------------------------- the star: star.c, secular.c, Fig. 2 */

/* The AO model: contact mass m0 >= 0 on a ground spring k0 >= 0, and n oscillators (m_i, k_i > 0)
 * hung on the contact mass. n = 0 is a rigid mass; m0 = infinity (n = 0) a fixed wall. */
typedef struct aoi_star {
    size_t n;
    double m0, k0;
    const double *m, *k;
} aoi_star;

/* AOI_OK for a star as above with some mass in it, or what is wrong with it. */
int aoi_star_check(const aoi_star *star);

/* m_st = m0 + sum of m_i, eq. (10). */
double aoi_star_static_mass(const aoi_star *star);

/* Receptance u/f at the contact coordinate, real, for count angular frequencies:
 * 1 / (k0 - w^2 m0 - sum_i m_i w^2 w_i^2 / (w_i^2 - w^2)); infinite on a resonance (and at w = 0 of
 * a free star), zero on an antiresonance. */
void aoi_star_receptance(const aoi_star *star, size_t count, const double *omega,
                         double *receptance);

/* Kinetic energy 1/2 sum m v^2 (0 for a wall) and elastic energy 1/2 k0 u0^2 + 1/2 sum k (u0-u_i)^2
 * of the coordinates u, v: n+1 doubles each, the contact coordinate first. */
void aoi_star_energy(const aoi_star *star, const double *u, const double *v, double *kinetic,
                     double *elastic);

/* The star's natural modes. In: oscillators in ascending, distinct k_i/m_i. Out: omega2 (n+1,
 * ascending) and participation r_j = b^T phi_j > 0 of the mass-normalised modes (n+1), so that the
 * receptance is sum_j r_j^2 / (omega2_j - w^2). mode_count: n+1, or n where m0 is zero. work: n. */
int aoi_star_to_modal(const aoi_star *star, double *omega2, double *participation,
                      size_t *mode_count, double *work);

/* The star of a modal model of count >= 1 modes with ascending, distinct omega2 >= 0 and weights
 * r_j^2 > 0: its antiresonances by the secular equation. Out: m0, k0 and count-1 oscillators in
 * ascending frequency (m, k). The inverse of aoi_star_to_modal. */
int aoi_star_from_modal(size_t count, const double *omega2, const double *weight, double *m0,
                        double *k0, double *m, double *k);

/* A function with n poles, s(x) = constant + x^power (linear + sum_j weight_j / (pole_j - x)), with
 * weights > 0, poles ascending and distinct, power 0 or 1: the receptance (0), minus the dynamic
 * stiffness of a star (1). It rises from pole to pole. */
typedef struct aoi_secular {
    size_t n;
    const double *pole, *weight;
    double constant, linear;
    int power;
} aoi_secular;

/* The root of s between pole_gap and pole_gap+1 (0 <= gap < n-1), below the first (gap = -1, down
 * to x = 0) or above the last (gap = n-1, up to ceiling), as pole[nearest] + offset: the offset
 * keeps the relative accuracy that x itself has lost beside a pole. Bisection-guarded Newton. */
int aoi_secular_root(const aoi_secular *s, ptrdiff_t gap, double ceiling, size_t *nearest,
                     double *offset);

/* ------------------------------------------------------------------------ contact laws: law.c */

enum { AOI_LAW_PARAMETERS = 8 };

typedef struct aoi_law aoi_law;

/* A law's answer: force [N], d force / d indentation [N/m], d force / d rate [N s/m]. */
typedef struct aoi_law_value {
    double force, stiffness, damping;
} aoi_law_value;

/* F(indentation, rate): zero at and below zero indentation. potential: the elastic energy stored at
 * an indentation. parameter: as the law's own paragraph in law.c says. */
struct aoi_law {
    void (*force)(const aoi_law *law, double indentation, double rate, aoi_law_value *value);
    double (*potential)(const aoi_law *law, double indentation);
    double parameter[AOI_LAW_PARAMETERS];
};

/* Makes the law of that name from count parameters: "hertz" (k), "power" (k, n >= 1), "linear" (k);
 * k in N/m^n, > 0. AOI_ERROR_ARGUMENT for an unknown name, a wrong count or a value out of range. */
int aoi_law_create(aoi_law *law, const char *name, size_t count, const double *parameter);

/* --------------------------------------------------------------- the contact equation: contact.c */

/* What linear bodies leave to be solved at the end of a step: indentation = indentation_free -
 * compliance F and rate = rate_free - rate_compliance F, with F the law's force of the two. guess:
 * where to look for the indentation first (any value). */
typedef struct aoi_contact_equation {
    double indentation_free, compliance;
    double rate_free, rate_compliance;
    double guess;
} aoi_contact_equation;

/* Solves it: Newton on the indentation, kept inside the bracket (0, indentation_free] by bisection,
 * to rounding; force 0 where indentation_free <= 0. Converges for every law whose force is zero at
 * zero indentation and continuous. */
int aoi_contact_solve(const aoi_law *law, const aoi_contact_equation *equation, double *force,
                      double *indentation);

/* ------------------------------------------------- Newmark's rule: newmark.c, full.c, section 3.1 */

/* dt > 0, beta > 0, gamma >= 1/2; beta = 1/4, gamma = 1/2 is the average-acceleration rule. */
typedef struct aoi_newmark {
    double dt, beta, gamma;
} aoi_newmark;

/* One body, seen by an observer at the end of a step. kinetic and elastic are only computed where
 * they are asked for. */
typedef struct aoi_observation {
    double displacement, velocity;               /* of the contact coordinate  */
    double centre_displacement, centre_velocity; /* of the centre of mass      */
    double kinetic, elastic;                     /* J                          */
} aoi_observation;

/* A linear body that a rule takes through time. predict() moves it to the end of the step without
 * contact force and gives displacement and velocity of its contact coordinate there; correct() adds
 * a force [N] on that coordinate, constant in sign with it: the displacement changes by compliance
 * times it, the velocity by rate_compliance times it. One predict() then one correct() is a step. */
typedef struct aoi_body aoi_body;
struct aoi_body {
    int (*predict)(aoi_body *body, double *displacement, double *velocity);
    void (*correct)(aoi_body *body, double force);
    void (*observe)(const aoi_body *body, int energies, aoi_observation *seen);
    void (*copy_state)(const aoi_body *body, double *u, double *v); /* all coordinates, velocities */
    double compliance, rate_compliance;
    const void *model;    /* the aoi_star or aoi_full                              */
    const double *centre; /* weights of the centre of mass on the coordinates      */
    double *state;        /* the work space given at the start, laid out by the body */
    double scratch[12];   /* the body's own constants                              */
};

/* Doubles of work space for aoi_body_start_star. Coordinates are n+1, the contact's first. */
size_t aoi_body_star_size(size_t n);

/* A star about to step by rule. u0, v0: n+1 initial values each, in equilibrium with no force (or
 * u0 = 0); centre: n+1 weights. Everything must outlive the body. m0 = 0 is stepped as the
 * algebraic equation that it is. */
int aoi_body_start_star(aoi_body *body, const aoi_star *star, const aoi_newmark *rule,
                        const double *centre, const double *u0, const double *v0, double *work);

/* A finite-element body: K, M (n x n), contact functional b and weights of the centre of mass
 * (n doubles), and a solver of M + beta dt^2 K. */
typedef struct aoi_full {
    aoi_sparse K, M;
    const double *b;
    aoi_solver solver;
} aoi_full;

/* Doubles of work space for aoi_body_start_full. */
size_t aoi_body_full_size(size_t n);

/* As aoi_body_start_star, for finite elements: one solve here, one a step. */
int aoi_body_start_full(aoi_body *body, const aoi_full *full, const aoi_newmark *rule,
                        const double *centre, const double *u0, const double *v0, double *work);

/* ------------------------------------------------------------ two bodies in contact: impact.c */

/* Rows of a record: one value a step, the initial state first. */
enum aoi_row {
    AOI_ROW_FORCE = 0,      /* N, >= 0 in compression                                       */
    AOI_ROW_INDENTATION,    /* x_projectile - x_target - gap, m                             */
    AOI_ROW_CONTACT_ENERGY, /* J, stored in the law                                         */
    AOI_ROW_BODY,           /* then the six of aoi_observation: projectile's, then target's */
    AOI_ROW_BODY_COUNT = 6,
    AOI_ROW_COUNT = AOI_ROW_BODY + 2 * AOI_ROW_BODY_COUNT
};

/* A projectile, a target, the law between them and the initial gap >= 0 [m]. The force F presses
 * the projectile back and the target forward. */
typedef struct aoi_impact {
    aoi_body *projectile, *target;
    const aoi_law *law;
    double gap;
    double indentation, last_indentation; /* of the last two steps; aoi_impact_start sets them */
} aoi_impact;

/* Writes the initial state into column 0 of the record. row: AOI_ROW_COUNT pointers, NULL for a row
 * not wanted (energies are not computed where all of a body's rows for them are NULL). */
int aoi_impact_start(aoi_impact *impact, double *const *row);

/* Steps on from column first to column last of the record. done gets the last column written; on an
 * error it is the step before the one that failed. May be called again to go on. */
int aoi_impact_run(aoi_impact *impact, double *const *row, size_t first, size_t last, size_t *done);

#ifdef __cplusplus
}
#endif
#endif
