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

/* --------------------------------------------------------------------------------- AO models */

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

/* ------------------------------------------------------------------------------ contact laws */

enum { AOI_LAW_PARAMETERS = 8, AOI_LAW_MEMORY = 2, AOI_LAW_NOTE = 3 };

typedef struct aoi_law aoi_law;
struct aoi_law_values; /* the core's own: law/law.h */

/* A law's answer: force [N], d force / d indentation [N/m], d force / d rate [N s/m]. */
typedef struct aoi_law_value {
    double force, stiffness, damping;
} aoi_law_value;

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
    /* NULL, or force at some places at once, for a law without pieces and memory: the core's own. */
    void (*together)(const aoi_law *law, const double *indentation, const double *rate,
                     struct aoi_law_values *values);
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

/* As law->potential, of the total indentation: less the c F^2/2 that is the bodies' own. Past the
 * limit of a law with a compliance, where it has no meaning, it grows on as over a straight line. */
double aoi_law_potential(const aoi_law *law, const double *memory, double indentation);

/* --------------------------------------------------------------------------- bodies in modes */

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

/* ----------------------------------------------------------------------------------- systems */

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

/* AOI_ERROR_ARGUMENT where numbers are not finite, frequencies or load times do not ascend, decays are
 * negative, a joint names a body or port that is not there, or one body twice, or has no usable law, where
 * first and first_port are not the sums of the bodies' n and ports, or first_joint (which may be NULL) and
 * joint_of not as aoi_system_link makes them. O(all arrays). */
int aoi_system_check(const aoi_system *system);

/* ----------------------------------------------------------------------------------- records */

/* Rows of a record, one value a step, the initial state first: for each contact force [N],
 * indentation [m], elastic [J], dissipated [J] (work of the force less elastic; zero for a law that
 * has neither rate nor memory); then for each body what enum aoi_body_row says, its work being that
 * of loads and gravity since the start. */
enum { AOI_CONTACT_ROWS = 4 };

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

#ifdef __cplusplus
}
#endif
#endif
