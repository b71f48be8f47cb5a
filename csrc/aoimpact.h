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
    AOI_ERROR_SOLVER,         /* the caller's linear solver reported a failure                     */
    AOI_ERROR_TOLERANCE,      /* even the shortest step does not meet the tolerance                */
    AOI_ERROR_TOO_LONG        /* the run needs more rows than the caller has room for              */
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

/* ------------------------------------------- exact linear response: relative.c, bessel.c, flight.c */

/* Two linear bodies between which one contact force F acts, as modes of the indentation
 *   delta = sum_j x_j - (residual[0] + residual[1]) F - gap,
 *   x_j'' + omega_j^2 x_j = load_j - weight_j F,
 * x_j being the share of mode j in delta (the target's with a minus sign) and weight_j = r_j^2 >= 0
 * the square of its participation (0: a wall, that moves on whatever happens). The projectile's modes come first, n_projectile of n. load
 * [m/s^2] is only read where omega is zero (elsewhere it is a shift of x); residual [m/N] is the
 * compliance left of the projectile and the target where their contact mass is zero. */
typedef struct aoi_relative {
    size_t n, n_projectile;
    const double *omega, *weight, *load;
    double residual[2];
    double gap;
} aoi_relative;

/* delta and its rate without force. x, v: the modes' shares and their rates, n each. */
void aoi_relative_indentation(const aoi_relative *relative, const double *x, const double *v,
                              double *indentation, double *rate);

/* Takes x, v through a time without force, in place: closed form. */
void aoi_relative_fly(const aoi_relative *relative, double time, double *x, double *v);

/* Flies (x, v change) until the bodies touch, but not beyond limit: gives the time flown, and
 * whether they touch then (delta = 0, rising). Never steps over a touch: each stride is the root of
 * a quadratic that bounds delta from above, high frequencies by their amplitude, low ones by their
 * acceleration. order: n indices of the modes by ascending omega. AOI_ERROR_NO_CONVERGENCE after
 * most strides (a gap that neither opens nor closes). */
int aoi_relative_next_touch(const aoi_relative *relative, const size_t *order, double limit,
                            size_t most, double *x, double *v, double *flown, int *touches);

/* i^-l e^(iz/2) j_l(z/2) for l < count, as sine (imaginary) and cosine (real) parts: the integrals of
 * sin z(1-x) and cos z(1-x) against the shifted Legendre polynomials on [0, 1]. z > 0, 2 <= count <= 16. */
void aoi_bessel_trigonometric(double z, size_t count, double *sine, double *cosine);

/* ------------------------------------------------------- collocation on the force: collocation.c */

enum { AOI_STAGES = 8 };

/* The response of an aoi_relative to a force that is a polynomial over one step of length h, given
 * by its values at the AOI_STAGES Radau nodes: exact, whatever omega h. */
typedef struct aoi_collocation {
    double h;
    double influence[AOI_STAGES][AOI_STAGES]; /* -d delta(node) / d F(node)                     */
    double defect[AOI_STAGES]; /* of a force error at the extra points: delta at the step's end */
    double *cosine, *sine; /* [stage][n]: cos(omega c h) - 1, sin(omega c h) / omega         */
    double *to_x, *to_v;   /* [stage][n]: integrals of sine and cosine against l_stage       */
} aoi_collocation;

/* Doubles of the block behind the four arrays. */
size_t aoi_collocation_size(size_t n);

/* Fills the tables of a step of length h > 0; block as above, kept. */
void aoi_collocation_make(aoi_collocation *step, const aoi_relative *relative, double h,
                          double *block);

/* The indentation without force at the nodes. start: what it is at the start of the step; the modes
 * only give its change, since their sum has the rounding of the bodies' places. */
void aoi_collocation_homogeneous(const aoi_collocation *step, const aoi_relative *relative,
                                 double start, const double *x, const double *v,
                                 double *indentation);

/* Solves delta = homogeneous - influence F, F = law(delta) at the nodes by Newton's method, to
 * 1e-13 of scale. indentation: a guess in, the solution out; force out.
 * AOI_ERROR_NO_CONVERGENCE where the guess was too far: take a shorter step. */
int aoi_collocation_solve(const aoi_collocation *step, const aoi_law *law,
                          const double *homogeneous, double scale, double *indentation,
                          double *force);

/* Takes x, v to the end of the step under the force. */
void aoi_collocation_propagate(const aoi_collocation *step, const aoi_relative *relative,
                               const double *force, double *x, double *v);

/* A guess of the indentation: the last step's polynomial (length last_length > 0) drawn on, where it
 * reaches, or the motion without force; never deeper than that. */
void aoi_collocation_guess(const aoi_collocation *step, double last_length, const double *last,
                           const double *homogeneous, double *indentation);

/* The first place in (0, 1] of a step that starts in contact where the indentation, of these Legendre
 * coefficients, goes to zero or below: bodies let go. Returns how often it changes sign between the nodes; 0 leaves place alone. */
int aoi_collocation_release(const double *indentation, const double *legendre, double *place);

/* Where in (0, 1) the indentation has its largest maximum, if it has one inside. Returns 1 then. */
int aoi_collocation_deepest(const double *legendre, double *place, double *indentation);

/* int F dt over the step. */
double aoi_collocation_impulse(const aoi_collocation *step, const double *force);

/* Adds what the force did from the start of the step up to place (0 .. 1) to x, v, which have flown
 * freely to there. */
void aoi_collocation_push(double h, const aoi_relative *relative, const double *force, double place,
                          double *x, double *v);

/* What the collocation solution leaves undone: the law's force minus the polynomial's between the
 * nodes gives the leading error of the impulse and of delta at the end of the step; tail is the last two Legendre coefficients' share of delta. legendre: AOI_STAGES+1 coefficients of
 * delta out. start: delta at the start of the step. */
typedef struct aoi_collocation_error {
    double impulse, indentation, tail;
} aoi_collocation_error;
void aoi_collocation_estimate(const aoi_collocation *step, const aoi_law *law, double start,
                              const double *indentation, const double *force, double *legendre,
                              aoi_collocation_error *error);

/* A polynomial of count shifted Legendre coefficients at 0 <= at <= 1 (or a little outside), and its
 * derivative with respect to at. */
double aoi_legendre_evaluate(size_t count, const double *coefficient, double at, double *slope);

/* -------------------------------------------------- a tolerance instead of a step: adaptive.c */

/* One row of a track, the dense record of an adaptive run: a flight (no force) or a step of contact.
 * AOI_TRACK_FIXED + 2n doubles: when it starts, how long it lasts, whether it is a contact (1.0) or a
 * flight (0.0), when within it the bodies let go (negative: they do not), the force at the Radau
 * nodes, the Legendre coefficients of the indentation, then x and v at its start. */
enum aoi_track {
    AOI_TRACK_START = 0,
    AOI_TRACK_LENGTH,
    AOI_TRACK_CONTACT,
    AOI_TRACK_RELEASE,
    AOI_TRACK_FORCE,
    AOI_TRACK_INDENTATION = AOI_TRACK_FORCE + AOI_STAGES,
    AOI_TRACK_FIXED = AOI_TRACK_INDENTATION + AOI_STAGES + 1
};

enum { AOI_TABLES = 12 };

/* A run to a relative tolerance rtol of peak force, contact times, impulse and velocities. The caller
 * sets the first block (x, v: n modes' shares and rates at time; order: their indices by ascending
 * omega; block: AOI_TABLES aoi_collocation_size(n) doubles) and calls aoi_adaptive_start. */
typedef struct aoi_adaptive {
    const aoi_relative *relative;
    const aoi_law *law;
    double rtol, time, end;
    double *x, *v, *block;
    const size_t *order;

    int in_contact, level; /* steps are base 2^-level long */
    double base, indentation_scale, impulse_scale;
    double touched, elapsed;      /* time is their sum in contact: short steps of a late contact */
    double start, without_force; /* delta now, and what it would be without F: residual F more */
    double peak_force, peak_time, impulse;
    double last_length, last[AOI_STAGES + 1]; /* the last step's indentation, to guess the next */
    aoi_collocation table[AOI_TABLES];
    int table_level[AOI_TABLES];
    size_t table_use[AOI_TABLES], uses;
    size_t steps, rejected;
} aoi_adaptive;

/* Sets the rest of the run to its beginning. */
int aoi_adaptive_start(aoi_adaptive *run);

/* Goes on until time >= end, or capacity rows of the track are written (rows says how many; call
 * again with more). AOI_ERROR_TOLERANCE where even the shortest step does not meet rtol. */
int aoi_adaptive_run(aoi_adaptive *run, size_t capacity, double *track, size_t *rows);

/* ---------------------------------------------------------------------- dense output: track.c */

/* How x and v make the centres of mass: centre[j] times x_j, and of the residual compliance. */
typedef struct aoi_centres {
    const double *weight;
    double residual[2];
} aoi_centres;

/* The record (rows of enum aoi_row, NULL where not wanted) at count ascending times within the
 * track. work: 2n doubles. */
int aoi_track_sample(const aoi_relative *relative, const aoi_law *law, const aoi_centres *centres,
                     size_t rows, const double *track, size_t count, const double *times,
                     double *const *row, double *work);

#ifdef __cplusplus
}
#endif
#endif
