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

/* Infinities and NaN are part of the interface, and sums are ordered with care. */
#if defined(__FAST_MATH__) || defined(_M_FP_FAST) ||                                                \
    (defined(__FINITE_MATH_ONLY__) && __FINITE_MATH_ONLY__)
#error "aoimpact needs IEEE arithmetic: compile without -ffast-math, -Ofast, -ffinite-math-only, /fp:fast"
#endif

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
    AOI_ERROR_TOO_LONG,       /* the run needs more rows than the caller has room for              */
    AOI_ERROR_PATCH,          /* the contact has grown wider than the patch whose law it is        */
    AOI_ERROR_LAW,            /* the contact law gave NaN                                          */
    AOI_ERROR_LAW_JUMPS,      /* less a patch's compliance the law has no force: its own jumps     */
    AOI_ERROR_STOPPED         /* the caller's pause said so                                        */
} aoi_status;

/* By which the caller is heard while work takes long: ask(data), at least every few milliseconds. Where it
 * returns anything but 0, the function returns AOI_ERROR_STOPPED. ask may be NULL, and so may a pointer to
 * a pause: then nobody is asked. */
typedef struct aoi_pause {
    int (*ask)(void *data);
    void *data;
} aoi_pause;

/* ------------------------------------------------------------------------- vectors: vector.c */

/* x^T y of n doubles. */
double aoi_vector_dot(size_t n, const double *x, const double *y);

/* y += factor x, n doubles, not overlapping. */
void aoi_vector_add(size_t n, double factor, const double *x, double *y);

/* Whether none of n doubles is infinite or NaN. */
int aoi_vector_is_finite(size_t n, const double *x);

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

/* y = A x for each of count vectors, which stand one after the other: four at a time share one pass
 * through A. Each comes out as by itself, bit for bit. */
void aoi_sparse_multiply_each(const aoi_sparse *matrix, size_t count, const double *x, double *y);

/* x^T A x without work space. */
double aoi_sparse_quadratic(const aoi_sparse *matrix, const double *x);

/* A linear solver seen by the core: solve() overwrites x (n doubles: right-hand side in, solution
 * out) and returns 0, or anything else for a failure. data is passed through untouched. */
typedef struct aoi_solver {
    int (*solve)(void *data, double *x);
    void *data;
} aoi_solver;

/* A linear solver of K + s^2 M that has looked at its residual f - K x - s^2 M x: as aoi_solver, and
 * it leaves K x in kx and M x in mx, n doubles each. */
typedef struct aoi_residual_solver {
    int (*solve)(void *data, double *x, double *kx, double *mx);
    void *data;
} aoi_residual_solver;

/* Factors of a symmetric positive definite matrix, P A P^T = L D L^T: L unit lower triangular by
 * compressed columns WITHOUT its diagonal, rows of a column ascending; D the n pivots, all
 * positive; row i of A is row place[i] of P A P^T. Columns of like pattern stand in panels, which
 * are swept together: panel p is columns panel[p] .. panel[p+1]-1, panel[panel_count] = n. work: n
 * doubles. An aoi_factors is one thread's. pause: or NULL. */
typedef struct aoi_factors {
    size_t n;
    const int32_t *start, *rows;
    const double *values, *pivots;
    const int32_t *place;
    const int32_t *panel;
    size_t panel_count;
    double *work;
    const aoi_pause *pause;
} aoi_factors;

/* Finds the widest panels: runs of columns of which each has the rows of the next, and the next
 * itself. panel: room for n+1 in, panel_count+1 out. The indices must be sound. */
size_t aoi_factors_find_panels(size_t n, const int32_t *start, const int32_t *rows, int32_t *panel);

/* Checks indices, places and panels, and that the pivots are positive (AOI_ERROR_NOT_POSITIVE: A was
 * not definite). Overwrites work. */
int aoi_factors_check(const aoi_factors *factors, size_t stored_count);

/* x <- A^-1 x by two triangular sweeps; data is an aoi_factors: it fits aoi_solver.solve. */
int aoi_factors_solve(void *data, double *x);

/* ------------------------------------------------------------- multigrid: blocks.c, aggregate.c */

/* A symmetric matrix of n x n blocks of size x size, in single precision: it only ever helps a solver
 * that checks in double. Row i has the blocks indices[p], values[size^2 p ...] (by rows) for
 * start[i] <= p < start[i+1]. inverse: of each diagonal block, n size^2 values. */
enum { AOI_BLOCKS_WIDEST = 6 };
typedef struct aoi_blocks {
    size_t n, size;
    const int32_t *start, *indices;
    const float *values, *inverse;
} aoi_blocks;

/* Checks that an aoi_blocks of stored_count blocks can be read safely, and is of a size that is
 * dealt with (1 ... AOI_BLOCKS_WIDEST). */
int aoi_blocks_check(const aoi_blocks *matrix, size_t stored_count);

/* r -= A x; x and r of n size floats, not overlapping. */
void aoi_blocks_subtract(const aoi_blocks *matrix, const float *x, float *r);

/* Improves x, for which r = f - A x, by Chebyshev steps that damp the eigenvalues of D^-1 A from low
 * to high, 0 < low < high < inf, with D the diagonal blocks. With finish, r is f - A x again on return;
 * without, it is one product with A behind. work: 2 n size floats. */
int aoi_blocks_smooth(const aoi_blocks *matrix, size_t steps, double low, double high, int finish,
                      float *x, float *r, float *work);

/* Puts neighbouring nodes of a graph together (Vanek, Mandel and Brezina, Computing 56, 1996): nodes
 * whose neighbours are all still free make an aggregate with them, those left over join one beside
 * them. The graph has the edges indices[p] of node i for start[i] <= p < start[i+1], each in both
 * directions, which must be sound. aggregate: n numbers out, from 0 on. Returns how many there are. */
size_t aoi_graph_aggregate(size_t n, const int32_t *start, const int32_t *indices,
                           int32_t *aggregate);

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

/* --------------------------------------------- a basis that fits the blow: krylov.c, after section 2 */

/* A rational Krylov subspace of a body seen at port_count contact functionals: with A = K + s^2 M, the
 * vectors A^-1 b, then A^-1 M v of each of them in turn, made M-orthonormal. Its Galerkin model has
 * the body's receptance at the frequency i s, and as many derivatives of it there as there were
 * solves, twice over where there is one port. s2 and solver (of A) may change between calls: several
 * shifts in one space.
 *   b          n x port_count. Where the body has rigid motions R, they must be in the basis and out of
 *              b: b - M R R^T b. The space is then as good for the smallest s.
 *   basis      n x capacity; its first rigid_count columns are R, M-orthonormal, set by the caller,
 *              and stay. 1 + the vectors wanted are enough for one port.
 *   stiffness  V^T K V, capacity x capacity; V^T M V is 1. Rows and columns of R must be zero.
 *   given      given_count columns, rigid_count or more, are there before the first solve. Those
 *              beyond R are any motions that the model is to have, M-orthonormal and with their
 *              stiffness, such as static modes: grown so themselves, with s2 = 0 and each b by itself.
 *              Such a column may be zero, with zero stiffness: a place kept for a motion to come.
 *   count      columns so far: given_count at the start. next: solves so far, 0 at the start.
 *   solver     of A; it leaves the products that its residual is made of: they are not made twice.
 *   load       n doubles, kept from call to call: with one port M times the last column, once solved.
 *   work       aoi_krylov_work_size doubles.
 *   pause      asked between two products of vectors, or NULL.
 */
typedef struct aoi_krylov {
    aoi_sparse K, M;
    double s2;
    aoi_residual_solver solver;
    size_t port_count, rigid_count, given_count, capacity;
    const double *b;
    double *basis, *stiffness, *load, *work;
    size_t count, next;
    const aoi_pause *pause;
} aoi_krylov;

size_t aoi_krylov_work_size(size_t n, size_t capacity);

/* Grows the basis to wanted <= capacity columns, a solve for each, or to where it is invariant: b
 * excites no more (breakdown); then count stays below wanted for good. A vector that is a combination
 * of the others is left out and its successors with it. What was grown before is kept, so a larger
 * order costs one solve. On an error (AOI_ERROR_SOLVER where the solver failed or its residual is
 * above 1e-5) the columns up to count are sound. */
int aoi_krylov_extend(aoi_krylov *space, size_t wanted);

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
 * receptance is sum_j r_j^2 / (omega2_j - w^2). mode_count: n+1, or n where m0 is zero. work: n.
 * AOI_ERROR_NOT_FINITE also where a k_i/m_i or a mode leaves the range of numbers. */
int aoi_star_to_modal(const aoi_star *star, double *omega2, double *participation,
                      size_t *mode_count, double *work, const aoi_pause *pause);

/* The star of a modal model of count >= 1 modes with ascending, distinct omega2 >= 0 and weights
 * r_j^2 > 0: its antiresonances by the secular equation. Out: m0, k0 and count-1 oscillators in
 * ascending frequency (m, k). The inverse of aoi_star_to_modal. */
int aoi_star_from_modal(size_t count, const double *omega2, const double *weight, double *m0,
                        double *k0, double *m, double *k, const aoi_pause *pause);

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

/* ------------------------------------------------------------- contact laws: law/ */

enum { AOI_LAW_PARAMETERS = 8, AOI_LAW_MEMORY = 2, AOI_LAW_NOTE = 3 };

/* At how many places in time a step of an adaptive run asks a law. */
enum { AOI_STAGES = 8 };

typedef struct aoi_law aoi_law;

/* A law's answer: force [N], d force / d indentation [N/m], d force / d rate [N s/m]. */
typedef struct aoi_law_value {
    double force, stiffness, damping;
} aoi_law_value;

/* Those at the nodes of a step. */
typedef struct aoi_law_values {
    double force[AOI_STAGES], stiffness[AOI_STAGES], damping[AOI_STAGES];
} aoi_law_values;

/* A law written by the caller, as functions of indentation > 0 [m] and rate [m/s]: its force [N],
 * stiffness [N/m], damping [N s/m] and potential [J] (rate 0). given says which there are: the
 * force, and of the others what differences and quadrature are not to stand in for. They are C
 * functions, or all go through call, with data, and which one. */
enum aoi_user_function {
    AOI_USER_FORCE = 0,
    AOI_USER_STIFFNESS,
    AOI_USER_DAMPING,
    AOI_USER_POTENTIAL,
    AOI_USER_FUNCTIONS
};
typedef struct aoi_user_law {
    double (*function[AOI_USER_FUNCTIONS])(double indentation, double rate);
    double (*call)(void *data, int which, double indentation, double rate);
    void *data;
    int given[AOI_USER_FUNCTIONS];
} aoi_user_law;

/* A contact law: what it is made of. Whoever integrates takes it through aoi_law_push or
 * aoi_law_piece and aoi_law_force, which take account of compliance; memory is AOI_LAW_MEMORY
 * doubles of one contact, all zero while it has never been touched (and may be NULL for a law whose
 * remember is NULL). A caller may fill in a law of his own: force and potential, the rest zero,
 * limit HUGE_VAL. */
struct aoi_law {
    /* The law on one of its smooth pieces, and a little beyond the ends of the piece, smoothly
     * continued where that is possible; not cut at zero. */
    void (*force)(const aoi_law *law, const double *memory, int piece, double indentation,
                  double rate, aoi_law_value *value);
    /* The elastic energy that unloading from there would give back, J. */
    double (*potential)(const aoi_law *law, const double *memory, double indentation);
    /* NULL: piece 0 is all. Else the piece on which the motion goes on from an indentation, upward
     * (rising) or downward, and its ends low < high; -+HUGE_VAL where there is none. */
    int (*piece)(const aoi_law *law, const double *memory, double indentation, int rising,
                 double *low, double *high);
    /* NULL: no memory. Else what a contact keeps after it has been at this indentation. */
    void (*remember)(const aoi_law *law, double indentation, double rate, double *memory);
    /* NULL, or the force alone, where that is cheaper than with its derivatives. */
    double (*alone)(const aoi_law *law, double indentation, double rate);
    /* NULL, or force at AOI_STAGES places at once, for a law without pieces and memory. */
    void (*together)(const aoi_law *law, const double *indentation, const double *rate,
                     aoi_law_values *values);
    /* NULL: 0. Else the indentation at and below which there is no force. */
    double (*rest)(const aoi_law *law, const double *memory);
    double parameter[AOI_LAW_PARAMETERS]; /* as the law's own paragraph in csrc/law says */
    double compliance;   /* c >= 0 [m/N] taken out: F = law(indentation + c F, rate)             */
    double limit;        /* deepest indentation at which that stands at rest: see aoi_law_stands  */
    int depends_on_rate; /* the force depends on the rate                                        */
    int turns;           /* loading and unloading differ: a step must end where the rate turns   */
    int pulls;           /* negative forces are meant; the contact ends at rest only             */
    const double *table; /* tabulated law: 4 rows of table_count, see aoi_law_create_table       */
    size_t table_count;
    aoi_user_law user;   /* the caller's law                                                     */
    double *note;        /* NULL, or AOI_LAW_NOTE doubles: indentation and rate where the law gave
                            no force, and the status that says why                               */
};

/* Makes the law of that name from count parameters, k in N/m^n:
 *   hertz: k; power: k, n >= 1; linear: k;
 *   hunt_crossley: k, chi [s/m], n >= 1; tsuji: k, alpha sqrt(m k) [N s/m^(5/4)]; kuwabara_kono: k,
 *   A [s]; kelvin_voigt and kelvin_voigt_pulling: k, c [N s/m];
 *   thornton: k, yield force [N].
 * k and the yield force are positive, what damps is not negative. The formulas stand in csrc/law.
 * AOI_ERROR_ARGUMENT for an unknown name, a wrong count or a value out of range, or where
 * what follows from them is. */
int aoi_law_create(aoi_law *law, const char *name, size_t count, const double *parameter);

/* A law through count >= 2 knots: cubics between them, a straight line past the last, which is the
 * law's limit. table: indentations (ascending, from 0), forces (from 0, never falling), slopes there,
 * and energies (the integral of the cubics), count each; the caller's, for as long as the law is
 * used. AOI_ERROR_ARGUMENT where these do not hold. */
int aoi_law_create_table(aoi_law *law, size_t count, const double *table);

/* The caller's law. AOI_ERROR_ARGUMENT where the force or a function said to be given is missing. */
int aoi_law_create_user(aoi_law *law, const aoi_user_law *user, int depends_on_rate, int pulls);

/* AOI_ERROR_ARGUMENT where a law cannot be used: without force or potential, with a compliance that is
 * negative or not finite, with a limit that is not positive. */
int aoi_law_check(const aoi_law *law);

/* The force itself, for fixed steps and plots: on the piece of this indentation and direction; zero
 * at and below rest; cut at zero unless the law pulls. A NaN (of a caller's law) goes through. */
void aoi_law_push(const aoi_law *law, const double *memory, double indentation, double rate,
                  aoi_law_value *value);

/* The force of aoi_law_push, which is cheaper where the derivatives are taken by differences. */
double aoi_law_push_only(const aoi_law *law, const double *memory, double indentation, double rate);

/* Whether that force is the law's: 0 deeper than the law's limit, and where compliance and rate leave
 * no more than the straight line that aoi_law_push then draws on (at a rate, dF/dd may reach 1/c before
 * the limit). Whoever integrates then stops with AOI_ERROR_PATCH. */
int aoi_law_stands(const aoi_law *law, const double *memory, double indentation, double rate);

/* As law->piece, of total indentations (compliance or not), for every law. AOI_NO_PIECE where its
 * pieces do not go on to there: aoi_law_force gives NaN for it. */
enum { AOI_NO_PIECE = -2 };
int aoi_law_piece(const aoi_law *law, const double *memory, double indentation, int rising,
                  double *low, double *high);

/* As law->force on a given piece, of the total indentation: solves d - c F(d) = indentation for the
 * law's own d, to rounding. Where c dF/dd comes near 1, so that no law is left, it goes on as a
 * straight line: that is beyond limit, and only for an iteration on its way. NaN, and a note of
 * AOI_ERROR_LAW_JUMPS, where the law's force falls from one value to another and no d is between. */
void aoi_law_force(const aoi_law *law, const double *memory, int piece, double indentation,
                   double rate, aoi_law_value *value);

/* The same at AOI_STAGES places. */
void aoi_law_forces(const aoi_law *law, const double *memory, int piece, const double *indentation,
                    const double *rate, aoi_law_values *values);

/* As law->potential, of the total indentation: less the c F^2/2 that is the bodies' own. Past the
 * limit of a law with a compliance, where it has no meaning, it grows on as over a straight line. */
double aoi_law_potential(const aoi_law *law, const double *memory, double indentation);

/* As law->rest, 0 for a law without. The force is zero there, so compliance plays no part. */
double aoi_law_rest(const aoi_law *law, const double *memory);

/* As law->remember, of the total indentation; nothing for a law without memory. To be called at the
 * end of every accepted step, and where the rate turns. */
void aoi_law_remember(const aoi_law *law, double indentation, double rate, double *memory);

/* --------------------------------------------------------------- the contact equation: contact.c */

/* What linear bodies leave to be solved at the end of a step: indentation = indentation_free -
 * compliance F and rate = rate_free - rate_compliance F, with F the law's force of the two. guess:
 * where to look for the indentation first (any value); for a law that pulls, above rest where the
 * bodies have been in contact so far. */
typedef struct aoi_contact_equation {
    double indentation_free, compliance;
    double rate_free, rate_compliance;
    double guess;
} aoi_contact_equation;

/* Solves it: Newton on the indentation, kept inside the bracket (rest, indentation_free] by
 * bisection, to rounding; force 0 where indentation_free <= rest (for a law that pulls: where it
 * would no longer hold). Converges for every law that is continuous but at rest: where its force
 * there at once, by the rate, is more than is needed, the indentation is rest and the force what is
 * needed. memory: the contact's, as everywhere. AOI_ERROR_LAW where the law gives NaN. */
int aoi_contact_solve(const aoi_law *law, const double *memory,
                      const aoi_contact_equation *equation, double *force, double *indentation);

/* -------------------------------- contacts that feel each other through bodies: coupled.c */

/* One contact of a scene. The caller sets the first block; delta = u_a - u_b - gap of the ports a, b
 * of two bodies, and its force F presses a back and b forward. The rest is its state. */
typedef struct aoi_contact {
    size_t body[2], port[2];
    const aoi_law *law;
    double gap;

    size_t at[2];                    /* its ports among those of the scene                     */
    double force, indentation, rate; /* at the end of the last step                            */
    double last_indentation;         /* a step before                                          */
    double work, start_energy;       /* of F on delta so far; stored in the law at the start   */
    double memory[AOI_LAW_MEMORY];
} aoi_contact;

/* The contact equations of a step: delta = free - compliance F and rate = rate_free -
 * rate_compliance F, with each F its own law's force. The matrices are count x (2 band + 1) by rows,
 * row i holding the columns i-band .. i+band: contacts that share a body are at most band apart.
 * indentation, rate, force: count doubles each, the solution. work: aoi_coupled_size doubles. */
typedef struct aoi_coupled {
    size_t count, band;
    double *compliance, *rate_compliance;
    double *free, *rate_free;
    double *indentation, *rate, *force;
    double *work;
} aoi_coupled;

size_t aoi_coupled_size(size_t count, size_t band);

/* Solves them. contact: their laws, memories and last indentations. Newton's method on all of them at
 * once, with a banded elimination (cost linear in count); where that leaves the way, contact by
 * contact with aoi_contact_solve. One contact is that alone. Errors as there. */
int aoi_coupled_solve(aoi_coupled *equations, const aoi_contact *contact);

/* -------------------------------- Newmark's rule: newmark/, section 3.1 */

/* dt > 0, beta > 0, gamma >= 1/2; beta = 1/4, gamma = 1/2 is the average-acceleration rule. */
typedef struct aoi_newmark {
    double dt, beta, gamma;
} aoi_newmark;

/* What a rule does in one step, u = p + reach a' and v = q + correct_v a' with the predictors p = u +
 * dt (v + predict_u a), q = v + predict_v a; reach = dt correct_u. */
typedef struct aoi_newmark_step {
    double dt, predict_u, predict_v, correct_u, correct_v, reach;
} aoi_newmark_step;

/* AOI_ERROR_ARGUMENT where the rule is none, or dt^2 leaves the range of numbers. */
int aoi_newmark_prepare(const aoi_newmark *rule, aoi_newmark_step *step);

/* Rayleigh's damping: C = alpha M + beta K; alpha [1/s] and beta [s] >= 0. On a star: dashpots
 * alpha m_i to the ground and beta k_i beside each spring. */
typedef struct aoi_rayleigh {
    double alpha, beta;
} aoi_rayleigh;

/* How a body starts. u, v: its coordinates' initial values; centre: their weights in the centre of
 * mass; gravity: a constant force on each [N], or NULL; force: what has bent the residual compliance of a
 * body in modes [N], then how fast that changes [N/s], 2 ports in all, or NULL: nothing. All are kept by
 * the body but u, v and force. */
typedef struct aoi_start {
    const double *u, *v, *centre, *gravity, *force;
} aoi_start;

/* What a body shows at the end of a step, in this order: displacement and velocity of its centre of
 * mass; kinetic and elastic energy, what damping took so far (the rule's own sum, dt/4 (v + v')^T C
 * (v + v') each step) and the work of gravity from u = 0 on, in J; displacement and velocity of each
 * port. */
enum aoi_body_row {
    AOI_BODY_CENTRE = 0,
    AOI_BODY_CENTRE_VELOCITY,
    AOI_BODY_KINETIC,
    AOI_BODY_ELASTIC,
    AOI_BODY_DISSIPATED,
    AOI_BODY_WORK,
    AOI_BODY_ROWS,
    AOI_PORT_ROWS = 2
};

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
    const void *model;              /* the aoi_star, aoi_modal or aoi_full                    */
    const double *centre, *gravity; /* of aoi_start                                           */
    double *state;                  /* the work space given at the start, laid out by the body */
    aoi_newmark_step step;
    double scratch[16]; /* the body's own constants and sums                      */
};

/* Doubles of work space for aoi_body_start_star. Coordinates are n+1, the contact's first; one port. */
size_t aoi_body_star_size(size_t n);

/* A star about to step by rule, O(n) a step. damping: NULL for none; a damped star needs m0 > 0.
 * Without m0 the contact is stepped as the algebraic equation that it is. Everything but start itself
 * must outlive the body. */
int aoi_body_start_star(aoi_body *body, const aoi_star *star, const aoi_rayleigh *damping,
                        const aoi_newmark *rule, const aoi_start *start, double *work);

/* A body in its natural modes, mass-normalised: x_j'' + 2 decay_j x_j' + omega_j^2 x_j = sum_p
 * participation[p][j] f_p, u_p = sum_j participation[p][j] x_j + sum_q residual[p][q] f_q. decay and
 * residual (symmetric, m/N) may be NULL: zero. */
typedef struct aoi_modal {
    size_t n, ports;
    const double *omega, *decay;
    const double *participation; /* [ports][n]     */
    const double *residual;      /* [ports][ports] */
} aoi_modal;

/* Doubles of work space for aoi_body_start_modal. Coordinates are the n modes. */
size_t aoi_body_modal_size(size_t n, size_t ports);

/* As aoi_body_start_star. The residual's velocity is its displacement's change over the step. */
int aoi_body_start_modal(aoi_body *body, const aoi_modal *modal, const aoi_newmark *rule,
                         const aoi_start *start, double *work);

/* u/f at a port, as real and imaginary part, for count angular frequencies: sum_j weight_j / (omega_j^2
 * - w^2 + 2 i decay_j w) + residual; weight_j = participation_j^2. */
void aoi_modal_receptance(size_t n, const double *omega, const double *decay, const double *weight,
                          double residual, size_t count, const double *frequency, double *real,
                          double *imaginary);

/* A finite-element body: K, M (n x n) and C by damping, contact functionals b ([ports][n]), and a
 * solver of (1 + alpha gamma dt) M + (beta' dt^2 + beta gamma dt) K, beta' being the rule's. pause: asked
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
int aoi_body_start_full(aoi_body *body, const aoi_full *full, const aoi_newmark *rule,
                        const aoi_start *start, double *work);

/* ------------------------------------------------- bodies, contacts and loads in time: scene.c */

/* Rows of a record, one value a step, the initial state first: for each contact force [N],
 * indentation [m], elastic [J], dissipated [J] (work of the force less elastic; zero for a law that
 * has neither rate nor memory); then for each body what enum aoi_body_row says, its work being that
 * of loads and gravity since the start. */
enum { AOI_CONTACT_ROWS = 4 };

/* A force on a port that runs straight between times (ascending; of two equal ones the later counts)
 * and is constant before the first and after the last. force: count >= 1 values. next: state. */
typedef struct aoi_load {
    size_t body, port, count;
    const double *time, *force;
    size_t next;
} aoi_load;

/* The force at a time not before the one of the last call. */
double aoi_load_at(aoi_load *load, double time);

/* The caller sets the first block: bodies started by one rule with step dt, contacts, loads, whether
 * energies are recorded (their rows are left alone otherwise); start_force: the contact forces at the
 * start [N], or NULL: what the laws give, which is wrong where a contact point without mass meets a law
 * that depends on the rate; work: aoi_scene_size(scene) doubles, first_port: body_count + 1. */
typedef struct aoi_scene {
    size_t body_count, contact_count, load_count;
    aoi_body *const *body;
    aoi_contact *contact;
    aoi_load *load;
    double dt;
    int energies;
    const double *start_force;
    double *work;
    size_t *first_port;

    aoi_coupled coupled;
    double *displacement, *free_displacement, *free_velocity; /* of all ports                  */
    double *push, *load_now, *load_before; /* on all ports; push: of loads and contacts        */
    double *load_work, *gravity_start;     /* of the bodies                                    */
    double *column;                        /* some columns of the record, row by row           */
} aoi_scene;

/* AOI_ERROR_ARGUMENT where a contact or a load names a body or port that is not there, a gap is not
 * finite, a law not usable, a load has no values or times that do not ascend, or no dt > 0 to go by. To
 * be called before the next two. */
int aoi_scene_check(const aoi_scene *scene);

size_t aoi_scene_rows(const aoi_scene *scene);
size_t aoi_scene_size(const aoi_scene *scene);

/* Sets the scene to its beginning, the bodies' accelerations included, and writes column 0. record:
 * aoi_scene_rows(scene) rows of `columns` values. Errors as aoi_scene_check, and
 * AOI_ERROR_NOT_POSITIVE for a contact where nothing can give way. */
int aoi_scene_start(aoi_scene *scene, double *record, size_t columns);

/* Steps on from column first to column last. done gets the last column written; on an error it is the
 * step before the one that failed. May be called again to go on. */
int aoi_scene_run(aoi_scene *scene, double *record, size_t columns, size_t first, size_t last,
                  size_t *done);

/* ------------------------------------------------- exact linear motion: oscillator.c, bessel.c */

/* What x'' + 2 decay x' + omega^2 x = f does in a time from rest: impulse, the response to a unit
 * impulse; rate, its derivative; step and ramp, its first two integrals, the responses to f = 1 and
 * f = t. With x0, v0 at the start and f = load + slope t:
 *   x = x0 + v0 impulse + (load - omega^2 x0) step + slope ramp,
 *   x' = v0 rate + (load - omega^2 x0) impulse + slope step. */
typedef struct aoi_motion {
    double impulse, rate, step, ramp;
} aoi_motion;

/* omega, decay >= 0 in any proportion (0 and 0: a free mass), time >= 0; no digits are lost where the
 * time is short. */
void aoi_oscillator_motion(double omega, double decay, double time, aoi_motion *motion);

/* The integrals over [0, 1] of that impulse response, and of its rate, at h (1 - x) against the shifted
 * Legendre polynomials P_0 .. P_(count-1) of x; count <= AOI_STAGES. h > 0. */
void aoi_oscillator_integrals(double omega, double decay, double h, size_t count, double *impulse,
                              double *rate);

/* i^-l e^(iz/2) j_l(z/2) for l < count, as sine (imaginary) and cosine (real) parts: the integrals of
 * sin z(1-x) and cos z(1-x) against the shifted Legendre polynomials on [0, 1]. z > 0, 2 <= count <= 16. */
void aoi_bessel_trigonometric(double z, size_t count, double *sine, double *cosine);

/* e^(-z/2) i_l(z/2) for l < count and complex z with real part >= 0, z not 0: the integrals of e^(-z(1-x)). */
void aoi_bessel_exponential(double real, double imaginary, size_t count, double *re, double *im);

/* ------------------------------------------------------------ a linear body in modes: modes.c */

/* A body with ports (its contact functionals) in natural modes: x_j'' + 2 decay_j x_j' + omega_j^2 x_j
 * = gravity_j + sum_p push[p][j] f_p, u_p = sum_j shape[p][j] x_j + sum_q residual[p][q] f_q. The scale
 * of x_j is free; for mass-normalised modes shape = push = participation. A wall has one mode with
 * shape 1 and push 0, which moves on whatever happens. decay, residual and gravity may be NULL (zero).
 * f_p is the contact forces plus a load that runs straight between load_time[i] (ascending), where it
 * is load_force[i][p], and is constant before the first and after the last. */
typedef struct aoi_modes {
    size_t n, ports;
    const double *omega; /* n, ascending */
    const double *decay;
    const double *shape, *push; /* [ports][n] */
    const double *residual;     /* [ports][ports] */
    const double *gravity;
    const double *inertia, *centre; /* n: energy inertia v^2 / 2 (0 for a wall); centre of mass */
    const double *centre_residual;  /* ports: its displacement per force, beside the modes'; or NULL */
    size_t load_count;
    const double *load_time, *load_force;
} aoi_modes;

/* The first time after `time` at which a load bends; infinite where there is none. */
double aoi_modes_next_bend(const aoi_modes *body, double time);

/* The load on a port just after a time, N, and its slope, N/s. */
void aoi_modes_load(const aoi_modes *body, size_t port, double time, double *force, double *slope);

/* Acceleration (but for contact forces, decay and spring) of mode j just after a time, and its slope. */
void aoi_modes_drive(const aoi_modes *body, size_t j, double time, double *load, double *slope);

/* Takes x, v (n each) from one time to another without contact forces, in place. */
void aoi_modes_fly(const aoi_modes *body, double from, double to, double *x, double *v);

/* Displacement and velocity of a port, but for the residual compliance's share. */
void aoi_modes_port(const aoi_modes *body, size_t port, const double *x, const double *v,
                    double *displacement, double *velocity);

/* ----------------------------------------- bodies and the contacts between them: model/, motion/ */

/* Contact between ports of two bodies (of the same body twice: not allowed): indentation = u_first -
 * u_second - gap; its force presses the first back and the second forward. */
typedef struct aoi_joint {
    size_t body[2], port[2];
    double gap;
    const aoi_law *law;
} aoi_joint;

/* Bodies and contacts. Body b has the modes first[b] .. first[b+1]-1 of the arrays x, v of all, and of
 * all ports those from first_port[b] to first_port[b+1]-1. Its joints, ascending, are joint_of[i] from
 * i = first_joint[b] to first_joint[b+1]-1: aoi_system_link finds them, for those who run the system. */
typedef struct aoi_system {
    size_t body_count, joint_count;
    const aoi_modes *body;
    const size_t *first, *first_port;
    const aoi_joint *joint;
    const size_t *first_joint, *joint_of;
} aoi_system;

/* Finds the joints of each body. first_joint: body_count + 1, joint_of: 2 joint_count, of the caller, who
 * keeps them. AOI_ERROR_ARGUMENT where a joint names a body that is not there. */
int aoi_system_link(aoi_system *system, size_t *first_joint, size_t *joint_of);

/* Modes of the body that has most; 1 without bodies. */
size_t aoi_system_most_modes(const aoi_system *system);

/* The residual compliance between the bodies of a joint, m/N. */
double aoi_system_residual(const aoi_system *system, size_t joint);

/* AOI_ERROR_ARGUMENT where numbers are not finite, frequencies or load times do not ascend, decays are
 * negative, a joint names a body or port that is not there, or one body twice, or has no usable law, where
 * first and first_port are not the sums of the bodies' n and ports, or first_joint (which may be NULL) and
 * joint_of not as aoi_system_link makes them. O(all arrays). */
int aoi_system_check(const aoi_system *system);

/* A polynomial in time that adds to an indentation over one step: its shifted Legendre coefficients and those
 * of its first three derivatives, and a bound of its second. */
enum { AOI_DERIVATIVES = 3 };
typedef struct aoi_forced {
    double from, length;
    double series[AOI_DERIVATIVES + 1][AOI_STAGES + 1];
    double bend;
} aoi_forced;

/* From the values at the start and the nodes (AOI_STAGES + 1). */
void aoi_forced_fit(double from, double length, const double *values, aoi_forced *forced);

/* Two bodies in flight, x and v at the same time of their own (n each), and one joint of theirs. forced: NULL,
 * or what contact forces of a step make of its indentation; then nothing is asked beyond that step. */
typedef struct aoi_flight {
    const aoi_modes *body[2];
    size_t port[2];
    double gap;
    double *x[2], *v[2];
    double time;
    const aoi_forced *forced;
} aoi_flight;

/* The joint's indentation without contact force, its rate and its acceleration. */
void aoi_flight_indentation(const aoi_flight *pair, double *indentation, double *rate,
                            double *acceleration);

/* The third derivative of the indentation without contact force: what presses bodies together first that
 * touch at rest while a load rises from nothing. */
double aoi_flight_jerk(const aoi_flight *pair);

/* Flies both (in place) until they touch, but not beyond limit; says whether they touch then
 * (indentation 0, about to rise). Never steps over a touch: each stride is the root of a quadratic
 * that bounds the indentation from above, high frequencies by their amplitude, low ones by their
 * acceleration. AOI_ERROR_NO_CONVERGENCE after most strides (a gap that neither opens nor closes). */
int aoi_flight_next_touch(aoi_flight *pair, double limit, size_t most, int *touches);

/* ------------------------------------------------------------- polynomials over a step: polynomial.c */

/* sum of count shifted Legendre coefficients at 0 <= at <= 1 (or a little outside), and its derivative
 * with respect to at; count <= AOI_STAGES + 1. */
double aoi_legendre_evaluate(size_t count, const double *coefficient, double at, double *slope);

/* Coefficients of the derivative; count of both, in place, too. */
void aoi_legendre_derive(size_t count, const double *coefficient, double *derivative);

/* Coefficients from the values at the start and the nodes (AOI_STAGES + 1 in, as many out). */
void aoi_legendre_fit(const double *values, double *coefficient);

/* The first place in (0, 1] at which a polynomial falls to a level that lies below its value at the start,
 * as far as a look at the nodes shows; 0 where it does not. values: at the start and the nodes. */
int aoi_legendre_falls(const double *values, const double *coefficient, double level, double *place);

/* Where in (0, 1) it has its largest maximum, if it has one inside. Returns 1 then. */
int aoi_legendre_top(size_t count, const double *coefficient, double *place, double *value);

/* Where it falls to a level on its way to its least minimum in (0, 1), if that is lower than depth (<= level):
 * what a look at the nodes misses. Returns 1 then. AOI_STAGES + 1 coefficients. */
int aoi_legendre_dips(const double *coefficient, double depth, double level, double *place);

/* ------------------------------------------------- a body's answer over one step: response.c */

/* What a body does over a step of length h under forces that are polynomials, given by their values at
 * the AOI_STAGES Radau nodes: exact, whatever omega h. */
typedef struct aoi_response {
    double h;
    int has_rates;                        /* influence_rate is filled                     */
    double *impulse, *rate, *step, *ramp; /* [n][stage]: aoi_motion at the nodes          */
    double *to_x, *to_v;                  /* [n][stage]: integrals against l_stage        */
    double *influence, *influence_rate;   /* [port][port][stage][stage]: at the first port and the
                                             second stage, of a force at the others */
    double *answer;                       /* [port][stage]: displacement after a unit impulse */
    double *scratch;
} aoi_response;

/* Doubles of the block behind the arrays. */
size_t aoi_response_size(const aoi_modes *body);

/* Fills the tables of a step of length h > 0; block as above, kept. */
void aoi_response_make(aoi_response *response, const aoi_modes *body, double h, int with_rates,
                       double *block);

/* Adds sign times the change of a port's displacement, and its rate (where not NULL), at the nodes, that
 * is due to the state at the start and to the loads; time: of the start. */
void aoi_response_homogeneous(const aoi_response *response, const aoi_modes *body, size_t port,
                              double sign, double time, const double *x, const double *v,
                              double *displacement, double *rate);

/* Takes x, v to the end of the step under force[port][stage] and the loads. */
void aoi_response_propagate(const aoi_response *response, const aoi_modes *body, double time,
                            const double *force, double *x, double *v);

/* Adds what the forces did from the start of a step of length h up to place (0 .. 1) to x, v, which have
 * flown freely to there. */
void aoi_response_push(const aoi_modes *body, double h, const double *force, double place, double *x,
                       double *v);

/* ------------------------------------------------- all contacts over one step: collocation/ */

/* In place of a law's piece: bodies that overlap while the law, which may not pull, gives no force. */
enum { AOI_SLACK = -1 };

/* Where in a step a contact's force begins or ends, like t^(3/2): a polynomial through its values at the
 * nodes would miss part of its impulse, the nearest polynomial does not. */
enum aoi_edge { AOI_EDGE_START = 0, AOI_EDGE_END, AOI_EDGE_NONE };

/* One contact during a step. The caller sets the first block: the piece of the law and its memory; which
 * edge of the contact the step has; indentation, rate and force at the start of the step; what counts as
 * large for the indentation; the motion without contact forces, and a guess of the indentation and its
 * rate. */
typedef struct aoi_stage {
    size_t joint;
    const double *memory;
    int piece;
    enum aoi_edge edge;
    double start, start_rate, start_force, scale;
    double homogeneous[AOI_STAGES], homogeneous_rate[AOI_STAGES];
    double indentation[AOI_STAGES], rate[AOI_STAGES];

    double force[AOI_STAGES];
    double legendre[AOI_STAGES + 1]; /* of the indentation */
} aoi_stage;

/* Doubles of work space of aoi_collocation_solve for count contacts of which those that share a body
 * are at most span places apart. */
size_t aoi_collocation_size(size_t count, size_t span);

/* Whether a law of these contacts depends on rates, or has to see them turn. */
int aoi_collocation_wants_rates(const aoi_system *system, size_t count, const aoi_stage *stage);

/* Solves F = law(indentation, rate) of all contacts together by Newton's method, to rounding of each one's
 * scale: F at all nodes, or, at an edge (of bodies without residual compliance), the polynomial nearest to
 * the law's force. indentation, rate: a guess in, the solution out; homogeneous as set. response: by
 * body. AOI_ERROR_NO_CONVERGENCE where the guess was too far: take a shorter step. */
int aoi_collocation_solve(const aoi_system *system, const aoi_response *response, double h,
                          size_t count, size_t span, aoi_stage *stage, double *work);

/* What the solution leaves undone: the law's force minus the polynomial's between the nodes gives the
 * leading error of the impulse and of the indentation at the end of the step; tail says how much the
 * last Legendre coefficients still hold. Fills stage->legendre. */
typedef struct aoi_collocation_error {
    double impulse, indentation, tail;
} aoi_collocation_error;
void aoi_collocation_estimate(const aoi_system *system, const aoi_response *response, double h,
                              aoi_stage *stage, aoi_collocation_error *error);

/* At the nodes of the part of a step up to place (0 .. 1): the polynomial nearest there to the law's force
 * along an indentation given by its Legendre coefficients. What the bodies do within a step with an edge
 * follows from that to the same digits as what they do over all of it. h: of the step. */
void aoi_collocation_on_part(enum aoi_edge edge, const aoi_law *law, const double *memory, int piece,
                             double h, const double *legendre, double place, double *force);

/* int F dt over the step, and int F d(indentation). */
double aoi_collocation_impulse(const aoi_stage *stage, double h);
double aoi_collocation_work(const aoi_stage *stage);

/* ------------------------------------------------- a tolerance instead of a step: adaptive/ */

/* A row of a track, the dense record of an adaptive run: a step of contact, or a moment from which bodies
 * fly freely. First these five; then for each of its bodies its number the work done on it and lost in it
 * before (J), and x, v at the start (3 + 2 n);
 * then for each of its contacts an aoi_track_contact. A body flies from where its last row leaves it. */
enum aoi_track { AOI_TRACK_START = 0, AOI_TRACK_LENGTH, AOI_TRACK_BODIES, AOI_TRACK_CONTACTS,
                 AOI_TRACK_SIZE, AOI_TRACK_FIXED, AOI_TRACK_STATE = 3 };

/* A contact in a row: which; whether its force begins at the row's start and ends at its end (1 or 0);
 * the edge it was solved with; piece, memory, work done on it before (J), indentation and rate at the start;
 * the force at the nodes; the Legendre coefficients of the indentation. One that is in no row any more
 * without having ended, or goes on as AOI_SLACK, has ended where its last row with force does. */
enum aoi_track_contact {
    AOI_TRACK_JOINT = 0,
    AOI_TRACK_BEGINS,
    AOI_TRACK_ENDS,
    AOI_TRACK_EDGE,
    AOI_TRACK_PIECE,
    AOI_TRACK_MEMORY,
    AOI_TRACK_WORK = AOI_TRACK_MEMORY + AOI_LAW_MEMORY,
    AOI_TRACK_LOST,
    AOI_TRACK_FORCE,
    AOI_TRACK_INDENTATION = AOI_TRACK_FORCE + AOI_STAGES,
    AOI_TRACK_CONTACT_SIZE = AOI_TRACK_INDENTATION + AOI_STAGES + 1
};

enum { AOI_TABLES = 12 };

/* What a run knows of a body: since when x, v hold, and the tables of the steps it made last. */
typedef struct aoi_follower {
    double time;
    int engaged; /* in this step: 2 under force, 1 beside such a body, 0 in flight */
    int changed; /* since its last row */
    double work, dissipated;
    double *block;
    size_t table_count;
    aoi_response table[AOI_TABLES];
    int table_level[AOI_TABLES];
    size_t table_use[AOI_TABLES];
} aoi_follower;

/* What a run knows of a contact, and what it has found out about it. */
typedef struct aoi_contact_state {
    int closed, begins, piece;
    double low, high; /* ends of the piece */
    double mobility;  /* of both ports under a sudden force, 1/kg */
    double edge;      /* length of a step that its beginning, so its end, allows; 0: not known */
    double memory[AOI_LAW_MEMORY];
    double start, start_rate, force; /* now, while closed */
    double bending;    /* the force that the residual compliance knows of */
    double force_rate; /* at the end of the last step, where bodies have a residual compliance */
    double indentation_scale, impulse_scale, rate_scale;
    double free_until; /* while open, and both bodies in flight: no touch before */
    int touches;       /* but then */
    size_t place;      /* among the watched ones */
    double slack;      /* while open: so much deeper than rest is no touch yet */
    int event;         /* what happens to it in the step being tried, and where */
    double event_place;
    double last_length, last[AOI_STAGES + 1]; /* the last step's indentation, to guess the next */
    double peak_force, peak_time, impulse, since_touch, work;
} aoi_contact_state;

/* Numbers of bodies or contacts. */
typedef struct aoi_list {
    size_t count, *at;
} aoi_list;

/* A run to a relative tolerance rtol of peak force, contact times, impulse and velocities. The caller
 * sets the first block: a linked system; x, v at time, of all bodies; body, contact, stage and response of
 * body_count, joint_count, joint_count and body_count elements, and balanced of joint_count; work and lists
 * of as many doubles and numbers as aoi_adaptive_size says; and calls aoi_adaptive_start. Bodies that overlap at the start are in
 * contact from the start. What a step costs depends on the bodies that take part in it only. */
typedef struct aoi_adaptive {
    const aoi_system *system;
    double rtol, time, end;
    int rested; /* the bodies have come to rest under loads and contacts; 0: those set in at time */
    double *x, *v;
    aoi_follower *body;
    aoi_contact_state *contact;
    aoi_stage *stage;
    aoi_response *response;
    aoi_contact *balanced; /* contacts at places without mass, while their forces are found */
    double *work;
    size_t *lists;

    aoi_list closed;     /* contacts, ascending                                           */
    aoi_list watched[2]; /* open ones in flight: until when they are free, when they touch */
    aoi_list engaged, changed; /* bodies: in this step; since their last row              */
    size_t span, row_size;
    size_t closed_count, stage_count; /* the stages: closed contacts first, then those beside them */
    int level;                        /* steps are base 2^(-level/8) long */
    int grain;                        /* of which only these multiples are taken  */
    double table_cost, saved;         /* what tables cost, in steps, and what longer ones had saved */
    double base;
    double indentation_scale, impulse_scale; /* the largest of the contacts that are closed */
    double force_scale; /* in the step tried, where more than one is closed; else 0 */
    double origin, elapsed; /* time is their sum: short steps of a late contact */
    double left_off;        /* of elapsed by rounding */
    double horizon;         /* no contact between bodies in flight before */
    int unbalanced;         /* something has happened to a contact since the last step */
    double *flight[2], *scratch, *port_force, *collocation;
    size_t steps, rejected, uses;
    size_t culprit; /* contact in which an error came up */
} aoi_adaptive;

/* Doubles of work, numbers of lists, and the largest row of the track. */
void aoi_adaptive_size(const aoi_system *system, size_t *work, size_t *lists, size_t *row);

/* Sets the rest of the run to its beginning. Errors as aoi_system_check, also where rtol or the duration
 * is not positive; AOI_ERROR_NOT_FINITE for x, v. */
int aoi_adaptive_start(aoi_adaptive *run);

/* Goes on until time >= end, or less than a row's room is left of capacity doubles of track or of most
 * entries of index (where each row starts), or a touch takes more than some .1 s to find; used and rows say how many were written; call again with
 * more. AOI_ERROR_TOLERANCE where even the shortest step does not meet rtol; AOI_ERROR_LAW where a law
 * gives no number; AOI_ERROR_PATCH where contact goes deeper than the law holds. */
int aoi_adaptive_run(aoi_adaptive *run, size_t capacity, size_t most, double *track, size_t *index,
                     size_t *used, size_t *rows);

/* ------------------------------------------------------------ energies: motion/; dense output: track/ */

/* Energies of a body, J. force: of all kinds on its ports, or NULL (the residual compliance stores it). */
void aoi_modes_energy(const aoi_modes *body, const double *x, const double *v, const double *force,
                      double *kinetic, double *elastic);

/* Work of gravity and loads on a body that has gone from x0, v0 to x1, v1 without contact, and what its
 * damping has taken meanwhile, J. scratch: 2n doubles. */
void aoi_modes_flight_work(const aoi_modes *body, double from, double to, const double *x0,
                           const double *v0, const double *x1, const double *v1, double *scratch,
                           double *work, double *dissipated);

/* The same for a part of a step under force[port][stage], from its start to place (0 .. 1) of h; x0, v0:
 * at its start, x1: at place. The work leaves out the change of aoi_modes_bent_work, which knows the forces of
 * both moments. What damping takes is the integral of its power along the motion: the balance of energies, of
 * which it is no part, shows whether that is right. */
void aoi_modes_step_work(const aoi_modes *body, double from, double h, double place,
                         const double *force, const double *x0, const double *v0, const double *x1,
                         double *work, double *dissipated);

/* Loads times what the contact forces of the moment bend the residual compliance at them, J. force: of
 * all kinds on the ports. Their work since a moment without contact has this in it. */
double aoi_modes_bent_work(const aoi_modes *body, double time, const double *force);

/* A track to be sampled, at times that ascend from one call to the next. The caller sets the first block;
 * work: doubles of aoi_sampler_size. */
typedef struct aoi_sampler {
    const aoi_system *system;
    const double *track; /* size */
    const size_t *index; /* rows */
    size_t size, rows;
    size_t *body_row, *body_at;       /* body_count each: the row that holds it, and where */
    size_t *contact_row, *contact_at; /* joint_count each                                  */
    double *work;

    size_t row, most_modes;
    int has_edge; /* a contact of the row was solved with an edge      */
    double part;  /* of the row up to where port_force goes: else 1    */
    double *port_force, *states;
    double *settled; /* work on each contact up to the end of its last row; NaN: not yet asked for */
    double *flown, *booked; /* bodies in flight as they were at the last bend of their loads */
} aoi_sampler;

size_t aoi_sampler_size(const aoi_system *system);

/* To the beginning of the track. AOI_ERROR_ARGUMENT for one that does not start with all bodies, or names
 * what is not in the system, or has contacts in a row of no length, or rows that go back in time, or is not
 * whole; and as aoi_system_check. */
int aoi_sampler_start(aoi_sampler *sampler);

/* Rows of a record, and the column of one time of it: value i goes to record[i * stride]. energies: 0
 * leaves their rows alone. */
size_t aoi_sampler_rows(const aoi_system *system);
void aoi_sampler_column(aoi_sampler *sampler, double time, int energies, double *record,
                        size_t stride);

/* The contact forces at one time, N: that of joint c goes to force[c * stride]. They need no body's motion,
 * which is what a column costs. */
void aoi_sampler_forces(aoi_sampler *sampler, double time, double *force, size_t stride);

/* x, then v, of one body (2n doubles) at that time. */
void aoi_sampler_state(aoi_sampler *sampler, double time, size_t body, double *state);

/* ------------------------------------------------------------- an impact in a few numbers: brief.c */

/* What many impacts are compared by. */
typedef struct aoi_brief {
    double peak_force, peak_time, impulse;
    double start, end;  /* of the first touch, and of the last; 0 without any                    */
    double velocity[2]; /* of the centres of mass when the last touch ends; without any, at the end */
    size_t touches;
    int lasting; /* the record ends in contact */
} aoi_brief;

/* Makes a run of two bodies and one joint from its beginning to its end, and sums it up. run: as for
 * aoi_adaptive_start. track, index: room for capacity doubles and most rows, overwritten. sampler: its
 * places and work. record: aoi_sampler_rows doubles, overwritten. Errors as aoi_adaptive_run, and
 * AOI_ERROR_TOO_LONG where the track has no room for the run. */
int aoi_brief_run(aoi_adaptive *run, size_t capacity, size_t most, double *track, size_t *index,
                  aoi_sampler *sampler, double *record, aoi_brief *brief);

#ifdef __cplusplus
}
#endif
#endif
