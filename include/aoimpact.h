/* aoimpact: the anti-oscillator model of a body at its point of contact, and impacts in time.
 *
 * This header is the interface for C programs, and its specification. examples/impact.c shows contacts without friction,
 * examples/friction.c a contact with friction of a body that turns. `make -C csrc` makes build/core/libaoimpact.a and
 * libaoimpact.so. "Paper" is E. Jacquelin, "On the rigid projectile model for low velocity impacts"; equation numbers
 * refer to it.
 *
 * A system of bodies and contacts is described once (aoi_modes, aoi_law, aoi_contact, aoi_system) and linked; runs
 * in fixed steps (aoi_newmark) or to a tolerance (aoi_adaptive) take it as it is. The output of an adaptive run
 * (aoi_track) can be read at any time (aoi_sampler), and gives the intervals of contact (aoi_track_intervals).
 *
 * What the Python package adds: finite elements and their reduction, damped AO models as bodies, the compliance of
 * patches for a law, starts at rest under load, estimates of errors by more runs. An adaptive run here gives no such
 * estimate: from a contact's second touch on, errors grow with each touch. Another run, with a tenth of rtol, shows them.
 *
 * Rules that hold for every function
 *   Memory    The caller owns all memory. Nothing here allocates, frees, or keeps a pointer after it returns,
 *             except inside an object that the caller made, for as long as it uses it. The size functions say
 *             how many bytes an object needs, aligned as malloc's are.
 *   Threads   There are no globals. A linked system, its laws and its bodies are only read: any number of threads
 *             may share them, but for a law with a note or with functions of the caller's. A run and a sampler
 *             are for one thread at a time.
 *   Units     SI: m, kg, s, N, J, rad/s; omega2 is an angular frequency squared, (rad/s)^2.
 *   Returns   AOI_OK (0), or one of the codes below: the outputs are not to be used then.
 *   Systems   Functions that need a linked system return AOI_ERROR_ARGUMENT (sizes: 0) for an unlinked one.
 *   Arrays    Contiguous doubles; matrices by rows, [rows][columns].
 *   Pointers  May be NULL only where their paragraph says so, or when the array has length 0.
 */
#ifndef AOIMPACT_H
#define AOIMPACT_H

#include <float.h>
#include <stddef.h>
#include <stdint.h>

/* Infinities and NaN are part of the interface, and the order of sums matters. */
#if defined(__FAST_MATH__) || defined(_M_FP_FAST) ||                                                \
    (defined(__FINITE_MATH_ONLY__) && __FINITE_MATH_ONLY__)
#error "aoimpact needs IEEE arithmetic: compile without -ffast-math, -Ofast, -ffinite-math-only, /fp:fast"
#endif

/* Each operation must be rounded to double. In x87 registers it is not, and results would be wrong. */
#if defined(FLT_EVAL_METHOD) && FLT_EVAL_METHOD != 0
#error "aoimpact needs doubles that are evaluated as doubles: compile with -msse2 -mfpmath=sse, not for the x87"
#endif

#ifdef __cplusplus
extern "C" {
#endif

#define AOI_VERSION "0.1.0"

/* Marks the functions that a shared library exports; its other symbols are hidden. */
#if defined(_WIN32)
#define AOI_API
#else
#define AOI_API __attribute__((visibility("default")))
#endif

typedef enum aoi_status {
    AOI_OK = 0,
    AOI_ERROR_ARGUMENT,       /* an argument that the function's description excludes             */
    AOI_ERROR_NOT_FINITE,     /* an infinity or NaN that is not allowed                           */
    AOI_ERROR_NOT_POSITIVE,   /* a pivot, mass or stiffness that must be positive is not           */
    AOI_ERROR_NO_CONVERGENCE, /* an iteration reached its limit                                    */
    AOI_ERROR_SOLVER,         /* the caller's linear solver reported a failure                     */
    AOI_ERROR_TOLERANCE,      /* even the shortest step does not meet the tolerance                */
    AOI_ERROR_TOO_LONG,       /* the run needs more rows than the caller has room for              */
    AOI_ERROR_PATCH,          /* an indentation exceeds the limit of its law: of its patch or table */
    AOI_ERROR_LAW,            /* the contact law gave NaN                                          */
    /* with its compliance taken out, the law has no force at this indentation: its own force drops */
    AOI_ERROR_LAW_JUMPS,
    AOI_ERROR_STOPPED,        /* the caller's pause returned nonzero                               */
    /* friction with a law that has a memory or adhesion; in an adaptive run also with a damped law or a residual
     * compliance */
    AOI_ERROR_FRICTION,
    AOI_ERROR_SPRINGS         /* a contact with friction needs more springs than there is room for  */
} aoi_status;

/* Returns AOI_VERSION of the library that is linked. */
AOI_API const char *aoi_version(void);

/* Returns the text of a status: a constant string, never NULL. */
AOI_API const char *aoi_status_text(int status);

/* A callback of the caller: long computations call ask(data) at least every few milliseconds, and return
 * AOI_ERROR_STOPPED if it returns anything but 0. No callback is made if ask, or the pointer to an aoi_pause, is
 * NULL. */
typedef struct aoi_pause {
    int (*ask)(void *data);
    void *data;
} aoi_pause;

/* --------------------------------------------------------------------------------- AO models */

/* The AO model: a contact mass m0 >= 0 on a ground spring k0 >= 0, and n oscillators (m_i, k_i > 0) attached to
 * the contact mass. With n = 0 it is a rigid mass, with n = 0 and m0 = infinity a fixed wall. */
typedef struct aoi_star {
    size_t n;
    double m0, k0;
    const double *m, *k;
} aoi_star;

/* Checks a star. Returns AOI_OK if it meets the conditions of aoi_star and has some mass, AOI_ERROR_ARGUMENT without
 * m or k, AOI_ERROR_NOT_FINITE or AOI_ERROR_NOT_POSITIVE. The order of the oscillators is not checked:
 * aoi_star_to_modal and aoi_star_modes need k_i/m_i ascending and distinct, and return AOI_ERROR_ARGUMENT otherwise. */
AOI_API int aoi_star_check(const aoi_star *star);

/* Returns the static mass m_st = m0 + sum of m_i, eq. (10), kg. */
AOI_API double aoi_star_static_mass(const aoi_star *star);

/* Computes the receptance u/f at the contact coordinate, 1 / (k0 - w^2 m0 - sum_i m_i w^2 w_i^2 / (w_i^2 - w^2)):
 * infinite at a resonance (and at w = 0 of a free star), zero at an antiresonance.
 *   count       number of frequencies
 *   omega       count: angular frequencies w, rad/s
 * Out:
 *   receptance  count: real, m/N */
AOI_API void aoi_star_receptance(const aoi_star *star, size_t count, const double *omega,
                                 double *receptance);

/* Computes the energies of a star.
 *   u, v     n + 1: coordinates and their rates, the contact's first
 * Out:
 *   kinetic  1/2 sum m v^2, J; 0 for a wall
 *   elastic  1/2 k0 u0^2 + 1/2 sum k (u0 - u_i)^2, J */
AOI_API void aoi_star_energy(const aoi_star *star, const double *u, const double *v, double *kinetic,
                             double *elastic);

/* Computes the star's natural modes, mass-normalised: its receptance is sum_j r_j^2 / (omega2_j - w^2).
 *   star           with oscillators in ascending, distinct k_i/m_i
 *   work           n
 *   pause          or NULL
 * Out:
 *   omega2         n + 1: ascending, (rad/s)^2
 *   participation  n + 1: r_j = b^T phi_j > 0, 1/sqrt(kg)
 *   mode_count     number of modes: n + 1, or n if m0 is zero
 * AOI_ERROR_NOT_FINITE also if a k_i/m_i or a value of a mode overflows or underflows. */
AOI_API int aoi_star_to_modal(const aoi_star *star, double *omega2, double *participation,
                              size_t *mode_count, double *work, const aoi_pause *pause);

/* Computes the star of a modal model, whose antiresonances are roots of the secular equation. The inverse of
 * aoi_star_to_modal.
 *   count   number of modes, >= 1
 *   omega2  count: ascending and distinct, >= 0
 *   weight  count: r_j^2 > 0
 *   pause   or NULL
 * Out:
 *   m0, k0  contact mass and ground spring
 *   m, k    count - 1: the oscillators, in ascending frequency */
AOI_API int aoi_star_from_modal(size_t count, const double *omega2, const double *weight, double *m0,
                                double *k0, double *m, double *k, const aoi_pause *pause);

/* Finds the AO model of a body from its constraint modes: K phi + mu b = omega2 M phi with b^T phi = 0, where b is
 * the contact functional, u = b^T X, and mu the force that holds u at zero. Eqs. (6), (9), (10), (12). Modes of
 * equal frequency are combined in one oscillator; a mode without mass gives none. A residual mass within rounding
 * is set to zero. If all modes of K and M are known, aoi_star_from_modal is simpler, with weight = (b^T
 * phi)^2/(phi^T M phi).
 *   n            degrees of freedom
 *   count        number of modes; all n - 1, or fewer
 *   phi_st       n: static mode, with b^T phi_st = 1, eqs. (2), (3)
 *   m_phi_st     n: M phi_st
 *   k0           static stiffness, eq. (11); 0 for a free body
 *   phi          count x n, mode after mode: M-orthogonal, of any norm
 *   m_phi        count x n: M phi
 *   omega2       count: ascending
 * Out:
 *   star         m0, k0 and the oscillators, ascending in frequency; m and k below
 *   m, k         count: their masses and stiffnesses
 *   coefficient  count: c_i of each mode, eq. (9); 0 for a mode without mass
 *   oscillator   count: index of the oscillator that contains each mode; -1 for none
 * AOI_ERROR_ARGUMENT if omega2 does not ascend, AOI_ERROR_NOT_POSITIVE if a mode with mass has no stiffness or
 * phi_st has no mass, AOI_ERROR_NOT_FINITE. */
AOI_API int aoi_star_from_constraint_modes(size_t n, size_t count, const double *phi_st, const double *m_phi_st,
                                           double k0, const double *phi, const double *m_phi, const double *omega2,
                                           aoi_star *star, double *m, double *k, double *coefficient,
                                           int32_t *oscillator);

/* ------------------------------------------------------------------------------ contact laws */

enum { AOI_LAW_PARAMETERS = 9, AOI_LAW_MEMORY = 2, AOI_LAW_NOTE = 3 };

typedef struct aoi_law aoi_law;
struct aoi_law_values; /* private to the core */

/* Value of a law: force [N], d force / d indentation [N/m], d force / d rate [N s/m]. */
typedef struct aoi_law_value {
    double force, stiffness, damping;
} aoi_law_value;

/* A law written by the caller, as functions of indentation > 0 [m] and rate [m/s]: its force [N], stiffness [N/m],
 * damping [N s/m] and potential [J] (rate 0). given[i] is nonzero for each function supplied. The force is
 * required; a missing derivative is replaced by a finite difference, a missing potential by quadrature. The
 * functions are C functions, or all are called through `call`, with data and the number of the function. */
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

/* A contact law. A caller gets one from a function below, and may then set its compliance, limit and note. Or the
 * caller fills in a new law: force and potential, limit = HUGE_VAL, further members as needed, and zero for the
 * rest. Both integrators read all members. A caller that integrates on its own gets the force by aoi_law_push.
 *
 * memory is an array of AOI_LAW_MEMORY doubles for one contact, all zero until its first touch. It may be NULL for
 * a law whose remember is NULL. */
struct aoi_law {
    /* Sets value to the law on one of its smooth pieces, without replacing negative forces by zero. Slightly
     * beyond the ends of the piece the law is continued, smoothly if possible. */
    void (*force)(const aoi_law *law, const double *memory, int piece, double indentation,
                  double rate, aoi_law_value *value);
    /* Returns the elastic energy that unloading from this indentation gives back, J. */
    double (*potential)(const aoi_law *law, const double *memory, double indentation);
    /* NULL: the law has one piece, number 0. Else returns the piece on which the motion goes on from an
     * indentation, upward (rising) or downward, and its ends low < high; an end that does not exist is -HUGE_VAL
     * or HUGE_VAL. */
    int (*piece)(const aoi_law *law, const double *memory, double indentation, int rising,
                 double *low, double *high);
    /* NULL: no memory. Else updates the memory of a contact that has been at this indentation: called at the end
     * of a step, and where the rate changes its sign. */
    void (*remember)(const aoi_law *law, double indentation, double rate, double *memory);
    /* NULL, or returns the force alone, if that is cheaper than the force with its derivatives. */
    double (*alone)(const aoi_law *law, double indentation, double rate);
    /* NULL: rest is 0. Else returns rest, the indentation at and below which there is no force. */
    double (*rest)(const aoi_law *law, const double *memory);
    /* parameters of aoi_law_create, and values derived from them; or the caller's */
    double parameter[AOI_LAW_PARAMETERS];
    /* c [m/N] taken out of the law: F = law(indentation + c F, rate); c < 0: in series with the law */
    double compliance;
    double limit;        /* largest indentation for which the law holds at rate 0: a run that goes
                            deeper ends with AOI_ERROR_PATCH. With a compliance c, the caller
                            sets it to where c times the law's stiffness comes near 1, if any    */
    int depends_on_rate; /* the force depends on the rate                                        */
    int turns;           /* loading and unloading differ: a step must end where the rate changes its sign */
    int pulls;           /* adhesion: negative forces act, and a contact ends only at `rest`     */
    double *note;        /* NULL, or AOI_LAW_NOTE doubles, the first NaN before a run: indentation
                            and rate where the law gave no force, and the status that says why   */

    /* Private to the core, and zero in a law of the caller's: forces at several indentations at once, a table, a
     * user's law. */
    void (*together)(const aoi_law *law, const double *indentation, const double *rate,
                     struct aoi_law_values *values);
    const double *table;
    size_t table_count;
    aoi_user_law user;
};

/* Makes the law of that name from count parameters, k in N/m^n. Names, parameters, and the force at an indentation
 * d and rate v:
 *   hertz: k                         k d^(3/2)
 *   power: k, n >= 1                 k d^n
 *   linear: k                        k d
 *   hunt_crossley: k, chi, n >= 1    k d^n (1 + chi v), chi in s/m
 *   tsuji: k, g                      k d^(3/2) + g d^(1/4) v, g = alpha sqrt(m k) in N s/m^(5/4)
 *   kuwabara_kono: k, A              k (d^(3/2) + 3/2 A d^(1/2) v), A in s
 *   kelvin_voigt: k, c               k d + c v, c in N s/m
 *   kelvin_voigt_pulling: k, c       the same, also where it is negative
 *   thornton: k, yield force         k d^(3/2) up to the yield force, then a straight line with the slope there.
 *                                    Unloading from the largest indentation D, with force F, and reloading up to D:
 *                                    F ((d - p)/(D - p))^(3/2), D - p = F/(k D^(1/2))
 *   elastic_plastic: k, yield force, slope
 *                                    k d^(3/2) up to the yield force, at d = y; slope (d - f/2) from f on, where
 *                                    f = (slope/(2 k))^2 is at least 3.5 y; between, the cubic that meets both with
 *                                    their slopes. Unloading as thornton, p = D (1 - (y/D)^0.28) (1 - (y/D)^0.69)
 *   yang_sun: k, critical, beta      k d^(3/2). Unloading from the largest indentation D, with force F:
 *                                    F ((d - p)/(D - p))^(5/2); reloading from p to D with 3/2 in place of 5/2.
 *                                    p = 0 if D < critical, else D (1 - (critical/D)^(2/5)), or
 *                                    beta (D - critical) if beta is not 0 (at most 1)
 * k, slope, yield force and critical must be positive, damping parameters not negative. AOI_ERROR_ARGUMENT for an
 * unknown name, a wrong count, or a value out of range, given or derived. */
AOI_API int aoi_law_create(aoi_law *law, const char *name, size_t count, const double *parameter);

/* Makes a law from knots: cubics between the knots, and a straight line past the last knot, which is the law's limit.
 *   count  knots, >= 2
 *   table  4 x count, the caller's for as long as the law is used: indentations (ascending, from 0),
 *          forces (from 0, never falling), slopes there, and energies (the integral of the cubics)
 * AOI_ERROR_ARGUMENT if the table does not meet these conditions. */
AOI_API int aoi_law_create_table(aoi_law *law, size_t count, const double *table);

/* Makes the caller's law.
 *   user             copied
 *   depends_on_rate  1: the force depends on the rate
 *   pulls            1: adhesion, negative forces act
 * AOI_ERROR_ARGUMENT if the force, or a function with a nonzero `given`, is missing. */
AOI_API int aoi_law_create_user(aoi_law *law, const aoi_user_law *user, int depends_on_rate, int pulls);

/* Checks a law. Returns AOI_ERROR_ARGUMENT if it cannot be used: it is NULL, lacks force or potential, or has a
 * compliance that is not finite or a limit that is not positive. */
AOI_API int aoi_law_check(const aoi_law *law);

/* Gives the force of a law and its derivatives, as runs in fixed steps use them: zero at and below rest and,
 * unless the law pulls, where the force would be negative.
 *   memory       AOI_LAW_MEMORY, or NULL for a law without memory
 *   indentation  m
 *   rate         m/s; its sign also tells loading from unloading
 * Out:
 *   value        NaN if the caller's law gives NaN or the indentation is NaN */
AOI_API void aoi_law_push(const aoi_law *law, const double *memory, double indentation, double rate,
                          aoi_law_value *value);

/* Returns the potential as law->potential, but at the total indentation, J. The energy c F^2/2, which is stored in
 * the bodies, is not included. Beyond the limit of a law with a compliance the energy has no meaning: it is that
 * of a force on the straight line that continues the law. */
AOI_API double aoi_law_potential(const aoi_law *law, const double *memory, double indentation);

/* ------------------------------------------------------------------------------------ friction */

/* Coulomb's friction in an elastic contact, which sticks in its middle and slips at its rim (Cattaneo, Mindlin).
 * In the method of dimensionality reduction (Popov and Hess) the contact is a row of springs. The spring of depth
 * x is touched when the indentation d exceeds x. With K = dF/dd, its normal stiffness is dK(x). Its normal force
 * is (d - x) dK, its tangential force at the stretch s is ratio s dK, and the stretch is limited by |s| <=
 * mu/ratio (d - x):
 *     force = ratio * integral of s(x) dK(x) over 0 <= x <= d.
 * This is exact for a Hertzian contact of two like materials, except for the small component of the slip across
 * the force. For unlike materials Dundurs' constant is neglected: friction does not change the normal force.
 * Another elastic law has the springs of its own K; a linear law has one. A rate-dependent law has the springs of
 * its K at rate 0, and the force of the rate is distributed over them in proportion: share = F/F(rate 0) raises
 * Coulomb's bound to mu/ratio share (d - x). For an elastic law share is 1. */
typedef struct aoi_friction {
    aoi_law law;      /* normal law as a function of its own indentation, without compliance        */
    double mu, ratio; /* coefficient of friction; ratio of tangential to normal stiffness, Mindlin's G / E
                         of the pair: 2 (1 - nu)/(2 - nu) for like materials                       */
    double precision; /* error of the piecewise linear curve of stretch against depth, relative to the
                         largest stretch since the touch */
} aoi_friction;

/* Makes the friction of a law, whose compliance and limit are not used. For a law with a compliance, the functions
 * below take the contact's own indentation and slide, which are those of the bodies plus compliance times force.
 *   law        copied; it must have no memory and no adhesion, and unload as it loads
 *   mu         >= 0, at most 1e140 times the ratio
 *   ratio      > 0
 *   precision  in (0, 0.1]; 1e-4 is usual
 * AOI_ERROR_FRICTION for another law, AOI_ERROR_ARGUMENT for other numbers. */
AOI_API int aoi_friction_create(aoi_friction *friction, const aoi_law *law, double mu, double ratio, double precision);

/* A point of the curve of stretch against depth, which is straight between two points: the stretch of the spring
 * at a depth along both tangents, m, and force and stiffness of the normal law at that depth. */
typedef struct aoi_stretch {
    double depth, along[2];
    double force, stiffness;
} aoi_stretch;

/* Memory of one contact with friction: the stretches of its springs, in order of depth from 0 to the indentation,
 * where the stretch is 0. If the bodies are apart there are no springs (count = 0). The caller sets room, at least
 * 8, two arrays of that length, count = 0, and the initial indentation, not above 0. From then on only the
 * functions below write to it, which do not check again what they have written. An impact takes about
 * 2/sqrt(precision) springs. */
typedef struct aoi_friction_state {
    size_t room, count;
    aoi_stretch *spring, *spare;
    double indentation;
    double reach, share; /* reach: largest stretch since the touch, m; share: F/F(rate 0), as above */
} aoi_friction_state;

/* Friction at the end of a path on which the first body slides relative to the second. The force acts on the second
 * body; its opposite acts on the first. */
typedef struct aoi_friction_value {
    double force[2];         /* friction along both tangents, N                                     */
    double by_slide[2][2];   /* d force / d slide, N/m                                              */
    double by_indentation[2]; /* d force / d indentation, N/m                                      */
    double by_share[2];      /* d force / d share, N                                                */
    /* depth within which springs stick, m: the indentation where all stick, 0 where all slip */
    double stuck;
    double terms;            /* scale of the rounding error of the force, N                         */
} aoi_friction_value;

/* Computes the friction after a straight path from the state to an indentation, m, and a share, with a slide, m. The
 * state is not changed. The result is exact for paths along one line, reversals included. Where directions turn,
 * each spring turns exactly, and the force has the precision of the curve. by_indentation neglects the effect of the
 * indentation on the turning. */
AOI_API void aoi_friction_try(const aoi_friction *friction, const aoi_friction_state *state, double indentation,
                              double share, const double slide[2], aoi_friction_value *value);

/* Adds springs to the state where a path as in aoi_friction_try turns neighbouring springs by different angles;
 * the force does not change. Should be called once in a step, with a guess of the step's end: aoi_friction_try is
 * then smooth in this step. AOI_ERROR_SPRINGS if there is no room. */
AOI_API int aoi_friction_refine(const aoi_friction *friction, aoi_friction_state *state, double indentation,
                                double share, const double slide[2]);

/* Moves the state along a path as in aoi_friction_try, and removes springs that the precision does not require.
 * AOI_ERROR_SPRINGS, with the state unchanged, if there is no room for the remaining springs. */
AOI_API int aoi_friction_move(const aoi_friction *friction, aoi_friction_state *state, double indentation,
                              double share, const double slide[2]);

/* Returns the energy stored in the stretches, J. The rest of the work of friction has been dissipated. */
AOI_API double aoi_friction_energy(const aoi_friction *friction, const aoi_friction_state *state);

/* ----------------------------------------------------------------- what there is: the model */

/* Forces on the ports of a body, linear between times: force[i][p] is the force on port p at time[i], N; it is
 * constant before the first time and after the last. Times ascend; two equal times make a jump, at which the later
 * force counts. count = 0: no load. */
typedef struct aoi_load {
    size_t count;
    const double *time, *force;
} aoi_load;

/* A symmetric n x n matrix by compressed rows, both triangles stored: row i has indices[p], values[p] for
 * start[i] <= p < start[i+1], with 0 <= indices[p] < n. */
typedef struct aoi_sparse {
    size_t n;
    const int32_t *start;   /* [n + 1]      */
    const int32_t *indices; /* [start[n]]   */
    const double *values;   /* [start[n]]   */
} aoi_sparse;

/* A linear solver of the caller's. solve(data, x) replaces the right-hand side x, n doubles, by the solution, and
 * returns 0; any other value means failure. */
typedef struct aoi_solver {
    int (*solve)(void *data, double *x);
    void *data;
} aoi_solver;

/* The matrices of a finite-element body, M x'' + (alpha M + beta K) x' + K x = f, for Newmark's rule. */
typedef struct aoi_full {
    aoi_sparse K, M;
    double alpha, beta;     /* Rayleigh's damping, 1/s and s, not negative                           */
    /* solves with (1 + alpha gamma dt) M + (beta_N dt^2 + beta gamma dt) K, where dt, beta_N and gamma are those
     * of the rule */
    aoi_solver solver;
    const aoi_pause *pause; /* or NULL: asked at each step, and while a run starts                   */
} aoi_full;

/* A body with ports (its contact functionals) in natural modes, with f_p the contact forces plus
 * the load:
 *   x_j'' + 2 decay_j x_j' + omega_j^2 x_j = gravity_j + sum_p push[p][j] f_p,
 *   u_p = sum_j shape[p][j] x_j + sum_q residual[p][q] f_q.
 * The scale of x_j is free; for mass-normalised modes shape = push = participation, and inertia may
 * be NULL. A wall has one mode with shape 1, push 0 and inertia 0, whose motion forces do not
 * change. decay, residual, gravity and centre_residual may be NULL (zero).
 *
 * With full, the coordinates x are the body's degrees of freedom instead: shape = push are the
 * contact functionals, gravity is a force [N], and omega, decay, residual, inertia and
 * centre_residual are NULL. Only Newmark's rule takes such a body. */
typedef struct aoi_modes {
    size_t n, ports;
    const double *omega;           /* [n]: angular frequencies of the modes, ascending, rad/s */
    const double *decay;           /* [n]: decay rates of the modes, 1/s             */
    /* [ports][n]: displacement of a port per x_j; acceleration of x_j per force on a port */
    const double *shape, *push;
    const double *residual;        /* [ports][ports]: residual compliance, symmetric, m/N */
    const double *gravity;         /* [n]: acceleration of x_j due to gravity        */
    const double *inertia;         /* [n]: mode j has the kinetic energy inertia_j v_j^2 / 2; NULL: 1 */
    const double *centre;          /* [n]: displacement of the centre of mass per x_j; required */
    const double *centre_residual; /* [ports]: further displacement of the centre of mass per force on a port, m/N */
    aoi_load load;
    const aoi_full *full;          /* NULL, or the body's matrices                   */
} aoi_modes;

/* Makes the body of an AO model, without damping, gravity and loads: one port, n + 1 modes (or fewer). memory:
 * aoi_star_modes_size bytes, which the body keeps. Errors as aoi_star_check and aoi_star_to_modal. If the body moves
 * as a whole at the velocity V, its modes have the rates v_j = V m_st centre[j], with the static mass m_st; the mode
 * of a wall has the rate V. */
AOI_API size_t aoi_star_modes_size(const aoi_star *star);
AOI_API int aoi_star_modes(const aoi_star *star, void *memory, aoi_modes *body);

/* Makes a body of three ports, for friction, from an AO model for each of the directions (normal, t1, t2): the
 * motion along one due to a force along another is neglected. The centre of mass moves along the normal. memory and
 * errors as for aoi_star_modes; at a velocity V its modes have the rates V m_st centre[j], with m_st of the first
 * star. */
AOI_API size_t aoi_star_modes_of_three_size(const aoi_star star[3]);
AOI_API int aoi_star_modes_of_three(const aoi_star star[3], void *memory, aoi_modes *body);

/* A rigid body that turns: its mass, its moments of inertia about normal, t1 and t2, which are
 * principal axes, and the arm from the centre of mass to its contact. Six modes, whose rates are
 * the velocity and the angular velocity, and three ports. memory: AOI_RIGID_ROOM doubles, which the
 * body keeps. AOI_ERROR_ARGUMENT unless all are finite, mass and moments positive.
 *
 * The axes, which are those of both bodies of a contact, must be right-handed, t2 = normal x t1:
 * the contact moves by velocity + angular velocity x arm. The normal points from the first body of
 * the contact to the second. A ball of radius r has the arm (r, 0, 0) as the first, (-r, 0, 0) as
 * the second. examples/friction.c has a contact of such a ball with friction. */
typedef struct aoi_rigid {
    double mass, inertia[3], arm[3]; /* kg, kg m^2, m */
} aoi_rigid;
enum { AOI_RIGID_ROOM = 54 };
AOI_API int aoi_rigid_modes(const aoi_rigid *rigid, double *memory, aoi_modes *body);

/* A contact between ports of two bodies: indentation = u_first - u_second - gap. Its force presses the first body
 * back and the second forward.
 *
 * With friction a contact has three forces. The ports port[i], port[i] + 1 and port[i] + 2 of a body are its
 * normal and two tangents, with axes as for aoi_rigid. Slides are u_first - u_second along the tangents. Friction
 * holds the first body back and pulls the second along. Springs are not stretched at a touch. Bodies that overlap
 * at t = 0 are taken to have moved straight from indentation and slides 0 to their state at t = 0. */
typedef struct aoi_contact {
    size_t body[2], port[2];
    double gap;
    const aoi_law *law;
    const aoi_friction *friction; /* made from the contact's law; NULL: no friction                          */
    /* with friction, [3][3] m/N: the compliance taken out, in the axes normal, t1, t2; [0][0] is law->compliance.
     * NULL: law->compliance alone */
    const double *compliance;
} aoi_contact;

/* Bodies and contacts, which both integrators take and never change. The caller sets the first block, and the
 * second to zero, which aoi_system_link then fills in; afterwards neither may change. In arrays of all bodies,
 * body b has the modes first[b] .. first[b+1]-1 and the ports first_port[b] .. first_port[b+1]-1; its contacts are
 * contact_of[i] for first_contact[b] <= i < first_contact[b+1], ascending. In arrays of the forces of all
 * contacts, contact c has first_force[c] .. first_force[c+1]-1: one force, or three with friction. */
typedef struct aoi_system {
    /* at_once has no effect: any number of contacts may be closed at once */
    size_t body_count, contact_count, at_once;
    const aoi_modes *body;
    const aoi_contact *contact;

    const size_t *first, *first_port, *first_contact, *contact_of, *first_force;
} aoi_system;

/* Checks the system and links it. memory: aoi_system_size bytes, which the system keeps. AOI_ERROR_NOT_POSITIVE
 * for a contact at which nothing can deform or move, as between two walls. AOI_ERROR_ARGUMENT if an array is
 * missing, numbers are not finite, frequencies or load times do not ascend, decays or inertias are negative, a
 * residual is not symmetric or would return more work than it takes, or a contact names a body or port that does
 * not exist, or one body twice, or has no usable law, or friction that aoi_friction_create has not made of that
 * law. After an error the system is not linked, even if it was before. */
AOI_API size_t aoi_system_size(const aoi_system *system);
AOI_API int aoi_system_link(aoi_system *system, void *memory);

/* --------------------------------------------------------------------- what is seen: a record */

/* A record is a matrix by rows, with one column per time. It has four rows for each contact, or eight with
 * friction, then for each body the rows of aoi_body_row and two for each of its ports. The energy that a law has
 * dissipated is the work of its force minus the energy stored, and zero for a law that has neither a rate nor a
 * memory; the energy that friction has dissipated is its work minus the energy of the stretches. */
enum aoi_contact_row {
    AOI_CONTACT_FORCE = 0,   /* normal force, N  */
    AOI_CONTACT_INDENTATION, /* indentation, m   */
    AOI_CONTACT_ELASTIC,     /* elastic energy of the law and, with friction, of the stretches, J */
    AOI_CONTACT_DISSIPATED,  /* energy dissipated by the law since the start, J */
    AOI_CONTACT_ROWS,
    /* With friction; these rows are always written: */
    AOI_CONTACT_TANGENTIAL = AOI_CONTACT_ROWS, /* two rows: friction along the tangents, N          */
    AOI_CONTACT_FRICTION = AOI_CONTACT_TANGENTIAL + 2, /* energy dissipated by friction since the start, J */
    AOI_CONTACT_STUCK, /* share of the indentation up to which springs stick: 0 where all slip       */
    AOI_FRICTION_ROWS
};
enum aoi_body_row {
    AOI_BODY_CENTRE = 0,      /* displacement of the centre of mass, m          */
    AOI_BODY_CENTRE_VELOCITY, /* velocity of the centre of mass, m/s            */
    AOI_BODY_KINETIC,         /* kinetic energy, J                              */
    AOI_BODY_ELASTIC,         /* elastic energy, J                              */
    AOI_BODY_DISSIPATED,      /* energy dissipated by damping since the start, J */
    AOI_BODY_WORK,            /* work of loads and gravity since the start, J   */
    AOI_BODY_ROWS,            /* number of these rows; displacement and velocity of each port follow */
    AOI_PORT_ROWS = 2
};

/* Return the number of rows of a linked system's record, the first row of a contact, and the first row of a body. */
AOI_API size_t aoi_record_rows(const aoi_system *system);
AOI_API size_t aoi_record_contact(const aoi_system *system, size_t contact);
AOI_API size_t aoi_record_body(const aoi_system *system, size_t body);

/* ------------------------------------------------------------------------- how a run begins */

/* State of the bodies at t = 0. Copied by the run.
 *   x, v         [first[body_count]]: coordinates of all bodies and their rates; NULL: zero
 *   rested       1: the bodies have come to rest under loads and contacts; 0: loads and contacts set in at
 *                t = 0. It has an effect only with a residual compliance, which deflects at once
 *   force        [first_force[contact_count]], for Newmark's rule: the contact forces just after t = 0, N;
 *                NULL: those that the laws give at x and v. Given forces, together with the loads, deflect
 *                a residual compliance; it starts undeflected if force is NULL. An adaptive run finds the
 *                forces itself
 *   force_rate   as force: their rates, N/s; NULL: zero */
typedef struct aoi_start {
    const double *x, *v;
    int rested;
    const double *force, *force_rate;
} aoi_start;

/* ------------------------------------------------- fixed steps: Newmark's rule, section 3.1 */

/* Parameters of Newmark's rule: dt > 0, beta > 0, gamma >= 1/2. beta = 1/4, gamma = 1/2 is the
 * average-acceleration rule. */
typedef struct aoi_rule {
    double dt, beta, gamma;
} aoi_rule;

/* A run in steps of dt, in memory of the caller: aoi_newmark_size bytes, aligned as by malloc. */
typedef struct aoi_newmark aoi_newmark;
AOI_API size_t aoi_newmark_size(const aoi_system *system); /* of a linked system */

/* Sets a run of a linked system to its beginning and writes column 0 of the record.
 *   run       aoi_newmark_size(system) bytes
 *   energies  0: the energies' rows of the record are not written
 *   record    aoi_record_rows(system) x columns, the caller's for as long as the run
 * AOI_ERROR_ARGUMENT for an invalid rule, or where a body with a residual compliance has come to rest and start->force
 * is NULL; AOI_ERROR_NOT_FINITE for x, v or forces; of a full body also AOI_ERROR_SOLVER, AOI_ERROR_STOPPED and
 * AOI_ERROR_NOT_POSITIVE (the solver's matrix is not positive definite). */
AOI_API int aoi_newmark_start(aoi_newmark *run, const aoi_system *system, const aoi_rule *rule,
                              const aoi_start *start, int energies, double *record, size_t columns);

/* Advances a run to column `last` (< columns), which is at the time last * dt. done: set to the last column
 * written; after an error, the step after this column has failed. AOI_ERROR_ARGUMENT if there is no such column,
 * AOI_ERROR_LAW if a law gives no number, AOI_ERROR_PATCH if an indentation exceeds the limit of its law. A run
 * that has failed cannot go on. */
AOI_API int aoi_newmark_run(aoi_newmark *run, size_t last, size_t *done);

/* State of a run: its time, the numbers of steps made and rejected, the contact in which AOI_ERROR_PATCH,
 * AOI_ERROR_LAW or AOI_ERROR_SPRINGS occurred (SIZE_MAX: none, or not known), and the coordinates of all bodies
 * and their rates. In an adaptive run, x and v hold at that time only after the run has reached its end. */
typedef struct aoi_progress {
    double time;
    size_t steps, rejected, failed;
    const double *x, *v;
} aoi_progress;
AOI_API aoi_progress aoi_newmark_progress(const aoi_newmark *run);

/* ------------------------------------------------------------ a tolerance instead of a step */

/* Output of an adaptive run, to be read by aoi_sampler and aoi_track_intervals. It consists of rows of values;
 * each row is a step of contact, or a time from which bodies move freely. The caller sets the first block: arrays
 * for capacity values and row_capacity rows, and used and rows to zero. */
typedef struct aoi_track {
    double *values;
    size_t *row; /* index at which each row begins */
    size_t capacity, row_capacity;

    size_t used, rows;
} aoi_track;

/* A run to a relative tolerance rtol of peak force, contact times, impulse and velocities, in memory of the
 * caller: aoi_adaptive_size bytes, aligned as by malloc. Bodies that overlap at the start are in contact from the
 * start. The cost of a step depends only on the bodies that take part in that step. */
typedef struct aoi_adaptive aoi_adaptive;
AOI_API size_t aoi_adaptive_size(const aoi_system *system); /* of a linked system */

/* Sets a run of a linked system to its beginning.
 *   run     aoi_adaptive_size(system) bytes
 *   start   copied
 *   rtol    in (0, 1); a tolerance below some 1e-13 is not reached, due to rounding
 *   end     s, > 0
 * AOI_ERROR_ARGUMENT for other numbers or a full body, AOI_ERROR_FRICTION for friction with a damped law or in a
 * system with a residual compliance, AOI_ERROR_NOT_FINITE for x, v. */
AOI_API int aoi_adaptive_start(aoi_adaptive *run, const aoi_system *system, const aoi_start *start,
                               double rtol, double end);

/* Advances a run to its end. It returns earlier if the track has no room for a row, or if the search for a touch
 * takes more than some 0.1 s: if progress.time < end, the caller enlarges the track if it is full and calls again.
 * AOI_ERROR_TOLERANCE if even the shortest step does not meet rtol; AOI_ERROR_LAW if the cause is a law with a
 * note that gives no number; AOI_ERROR_PATCH if an indentation exceeds the limit of its law; AOI_ERROR_SPRINGS. A
 * run that has failed cannot go on. */
AOI_API int aoi_adaptive_run(aoi_adaptive *run, aoi_track *track);

/* Returns the number of free values that the track needs for any row of a run of a linked system. */
AOI_API size_t aoi_adaptive_room(const aoi_system *system);

/* Makes a track twice as large or, if it has no capacity, allocates it, by resize, which is realloc or works like
 * it. room: aoi_adaptive_room. AOI_ERROR_TOO_LONG if resize returns NULL; the content of the track is then
 * unchanged. The caller frees values and row. */
AOI_API int aoi_track_grow(aoi_track *track, size_t room, void *(*resize)(void *memory, size_t bytes));

/* Advances a run to its end as aoi_adaptive_run; AOI_ERROR_TOO_LONG if the track has no room for it. */
AOI_API int aoi_adaptive_finish(aoi_adaptive *run, aoi_track *track);

AOI_API aoi_progress aoi_adaptive_progress(const aoi_adaptive *run);

/* A contact in a run so far: its largest force, N, the time of that force, s, and the integral of the force, N s. */
typedef struct aoi_peak {
    double force, time, impulse;
} aoi_peak;
AOI_API aoi_peak aoi_adaptive_peak(const aoi_adaptive *run, size_t contact);

/* ----------------------------------------------------------------------------- dense output */

/* Checks a track, for example one from a file; a track that a run has written need not be checked.
 * AOI_ERROR_ARGUMENT if it cannot be read: it is incomplete, refers to bodies or contacts that are not in the
 * system, has contacts in a row of no length, or rows that go back in time. */
AOI_API int aoi_track_check(const aoi_system *system, const aoi_track *track);

/* A reader of a track at any times, in memory of the caller: aoi_sampler_size bytes, aligned as by malloc. */
typedef struct aoi_sampler aoi_sampler;
AOI_API size_t aoi_sampler_size(const aoi_system *system); /* of a linked system */

/* Sets a sampler to the beginning of a track, to which it keeps a pointer. A run of this system must have written
 * the track, or aoi_track_check accepted it. AOI_ERROR_ARGUMENT if its first row does not contain all bodies. */
AOI_API int aoi_sampler_start(aoi_sampler *sampler, const aoi_system *system, const aoi_track *track);

/* The next three functions take times that ascend from one call to the next. In free motion, evenly spaced times
 * cost least; the state at such a time agrees with that of a single call within 1e-14 of each mode's amplitude.
 * Elsewhere the two are bit-identical.
 *
 * Writes a column of the record.
 *   time      s
 *   energies  0: the rows of energies are not written
 * Out:
 *   record    value i of aoi_record_rows(system) goes to record[i * stride] */
AOI_API void aoi_sampler_column(aoi_sampler *sampler, double time, int energies, double *record,
                                size_t stride);

/* Writes the contact forces at a time, N: the force of contact c goes to force[c * stride]. It costs much less
 * than a column, since no body is moved. */
AOI_API void aoi_sampler_forces(aoi_sampler *sampler, double time, double *force, size_t stride);

/* Writes coordinates and rates of one body at a time. Out:
 *   state  2 n: x, then v */
AOI_API void aoi_sampler_state(aoi_sampler *sampler, double time, size_t body, double *state);

/* A contact interval.
 *   start, end  s; lasts = 1: the record ends in this contact
 *   impulse     impulse of the contact force, N s
 *   rate        rate of the indentation at the start, before the contact force changed the rate, m/s
 *   deepest     largest indentation at the end of one of its steps, m
 *   pace        rate (end - start)/deepest; 0 if deepest is not above 0 */
typedef struct aoi_interval {
    size_t contact;
    double start, end, impulse, rate, deepest, pace;
    int lasts;
} aoi_interval;

/* Finds the contact intervals of a track (as for aoi_sampler_start) that start before `end`, ordered by their
 * ends. The first `capacity` of them are written, and the number of all is returned. work: [contact_count]. */
AOI_API size_t aoi_track_intervals(const aoi_system *system, const aoi_track *track, double end,
                                   aoi_interval *work, size_t capacity, aoi_interval *interval);

/* A phase of a contact with friction, from `time`, s, to the next phase of this contact or its end: all springs
 * slip (slips = 1), or some stick (0). */
typedef struct aoi_slip {
    size_t contact;
    double time;
    int slips;
} aoi_slip;

/* Finds the phases of slip of a track's contacts with friction, in order of time: one at the start of each row,
 * which may repeat the one before, and one at each change, as accurate as the motion. The first `capacity` of them
 * are written, and the number of all is returned. */
AOI_API size_t aoi_track_slips(const aoi_system *system, const aoi_track *track, size_t capacity, aoi_slip *slip);

#ifdef __cplusplus
}
#endif
#endif
