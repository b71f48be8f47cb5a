/* The contact equations of a scene, coupled through the bodies that contacts share.
 *
 * With the forces of the other contacts given, each contact has a scalar equation. Its indentation without its own
 * force is z = free - sum of the other contacts' C F (its rate w likewise), and equation.c finds its force F(z,
 * w), also for laws with kinks and jumps. The remaining equations,
 *   z_i = free_i - sum_(j not i) C_ij F_j(z_j, w_j),
 * are solved by Newton's method for all contacts at once. Their functions are Lipschitz continuous: F rises with z
 * by no more than 1/C_ii, however steep the law. With the stiffness k and the damping c of the laws,
 *   dF = a dz + b dw,  a = k/(1 + k C_ii + c Cr_ii),  b = c/(1 + k C_ii + c Cr_ii),
 * and a = 1/C_ii, b = 0 where a jump of the law holds the bodies at rest. Newton's equations (1 + a C' + b Cr') dF
 * = -(a R + b S), with the residuals R of z and S of w, and C' and Cr' without their diagonals, need no pivoting.
 * A step is shortened until the residual decreases. If no length does this, contacts are solved in turn
 * (Gauss-Seidel), which always decreases the residual, though slowly. If that is too slow, a few steps are taken
 * at full length: if only one of two rigid contacts at a place can be closed, these steps find out which, although
 * the residual rises on the way.
 *
 * A contact with friction has three equations, solved together in oblique.c, and a 3 x 3 matrix a = dF/dz. */
#include "model/coupled.h"
#include "linear/vector.h"
#include "linear/work.h"
#include "law/equation.h"
#include "law/law.h"

#include <float.h>
#include <math.h>
#include <string.h>

/* FIRST_STEPS, MOST_STEPS: largest numbers of Newton steps in the first attempt, and in later attempts.
 * MOST_HALVINGS: largest number of halvings of a step. SWEEPS: number of sweeps over the contacts if no halving
 * helps. Tried with a third and three times the value: 5 runs by Newmark's rule change, by a relative 2e-12;
 * MOST_STEPS changes none. */
enum { FIRST_STEPS = 20, MOST_STEPS = 500, MOST_HALVINGS = 6, SWEEPS = 4 };

/* Relative tolerance of the last attempt, for equations that amplify rounding errors (dashpots too stiff for the
 * step). Without this attempt one of 400 scenes by Newmark's rule, of 2 000 steps, finds no solution. */
static const double ROUGH = 1e-9;

/* Factor on the slopes a, b in Newton's matrix, in the second attempt. Almost rigid dashpots have the slope 1/C,
 * with which the matrix of two of them at one place would be singular. Measured, on 400 scenes with a dashpot and
 * a contact across a gap at one place under a sudden load: 1 - 1e-8 and 1 - 1e-6 solve all, 1 - 1e-4 leaves 15
 * unsolved, 1 - 1e-2 and 1 leave 64. */
static const double YIELD = 1.0 - 1e-6;

/* The error of an indentation is relative to at least this share of the largest indentation. Tried with a third
 * and three times the value: 2 runs change, by a relative 1e-14. */
static const double SHARE = 1e-6;

/* Largest ratio of the terms of a law's force to the force itself at which the force's digits are trusted: above
 * it, cancellation loses digits. Tried with a third and three times the value: 15 runs change, by a relative
 * 7e-13. */
static const double CANCELS = 16.0;

/* An iterate: for each contact its indentation and rate without its own force, the solution of its equation, the
 * slopes of its force and its residuals. After the last iteration indentation and force are the solution. */
typedef struct iterate {
    double *unloaded, *unloaded_rate; /* z and w of the equations above */
    double *indentation, *force;
    double *of_place, *of_rate; /* slopes a and b */
    double *off, *rate_off;     /* residuals R and S */
} iterate;

typedef struct newton {
    const aoi_coupled *e;
    const aoi_contact_state *contact;
    size_t width;
    double deepest; /* largest indentation, by find_deepest, m */
    double ended;    /* adhesive contacts whose last indentation is at most this have separated, m */
    double rounding; /* relative error at which an equation counts as solved */
    size_t failed;   /* index of the equation solved last */
    double yield;    /* factor on the slopes in the matrix; if it is below 1, steps are not shortened */
    iterate now, trial;
    double *size, *rate_size; /* sums of the magnitudes of the terms of R and S */
    double *matrix, *change; /* Newton's matrix; its solution, the changes of the forces */
    double *move, *rate_move; /* changes of z and w in a full Newton step */
} newton;

enum { VECTORS = 20 };

size_t aoi_coupled_size(size_t count, size_t band)
{
    return count > 1 ? aoi_times(aoi_plus(VECTORS + 1, aoi_times(2, band)), count) : 0;
}

static void lay_out(newton *s, const aoi_coupled *e, const aoi_contact_state *contact, double *work)
{
    *s = (newton){.e = e, .contact = contact, .width = 2 * e->band + 1};
    iterate *now = &s->now, *trial = &s->trial;
    double **part[] = {&now->unloaded,   &now->unloaded_rate,   &now->of_place,   &now->of_rate,
                       &now->off,        &now->rate_off,        &trial->unloaded, &trial->unloaded_rate,
                       &trial->of_place, &trial->of_rate,       &trial->off,      &trial->rate_off,
                       &trial->force,    &trial->indentation,   &s->size,         &s->rate_size,
                       &s->change,       &s->move,              &s->rate_move};
    now->indentation = e->indentation;
    now->force = e->force;
    for (size_t i = 0; i < sizeof part / sizeof *part; i++) {
        *part[i] = aoi_work_take(&work, e->count);
    }
    s->matrix = work;
}

/* Columns of row i: first_of(i) to last_of(i) - 1. The element in column j has the index i * width + band + j - i. */
static size_t first_of(const aoi_coupled *e, size_t i) { return i > e->band ? i - e->band : 0; }

static size_t last_of(const aoi_coupled *e, size_t i)
{
    return i + e->band < e->count ? i + e->band + 1 : e->count;
}

static const double *row_of(const aoi_coupled *e, const double *matrix, size_t i)
{
    return matrix + (i * (2 * e->band + 1) + e->band) - i; /* indexed by the number of the column */
}

/* Returns the index of the first equation of the contact that equation i belongs to. */
static size_t begin_of(const aoi_contact_state *contact, size_t i) { return i - contact[i].axis; }

static size_t size_of(const aoi_contact_state *contact) { return contact->rubbing ? 3 : 1; }

/* Returns row i of a matrix times x, without the columns of the contact itself. size: set to the sum of the terms'
 * magnitudes. */
static inline double neighbours(const aoi_coupled *e, const aoi_contact_state *contact, const double *matrix, size_t i,
                         const double *x, double *size)
{
    const double *row = row_of(e, matrix, i);
    const size_t begin = begin_of(contact, i), own = size_of(&contact[i]);
    double sum = 0.0;
    *size = 0.0;
    for (size_t j = first_of(e, i); j < begin; j++) {
        sum += row[j] * x[j];
        *size += fabs(row[j] * x[j]);
    }
    for (size_t j = begin + own, last = last_of(e, i); j < last; j++) {
        sum += row[j] * x[j];
        *size += fabs(row[j] * x[j]);
    }
    return sum;
}

static double own(const aoi_coupled *e, const double *matrix, size_t i)
{
    return row_of(e, matrix, i)[i];
}

/* Finds the slopes a and b of contact i at its solution. */
static void find_slopes(const newton *s, iterate *at, size_t i)
{
    const aoi_coupled *e = s->e;
    const aoi_contact_state *contact = &s->contact[i];
    const double compliance = own(e, e->compliance, i), rate = own(e, e->rate_compliance, i);
    const double rest = aoi_law_rest(contact->law, contact->memory);
    const double speed = at->unloaded_rate[i] - rate * at->force[i];
    aoi_law_value value = {0.0, 0.0, 0.0};
    if (at->indentation[i] == rest && at->force[i] != 0.0) {
        at->of_place[i] = 1.0 / compliance;
        at->of_rate[i] = 0.0;
        return;
    }
    if (at->force[i] != 0.0) {
        /* The slopes are those of the law without its cut at zero: rounding of the damping term may make a
         * positive force negative, which the cut would set to zero, with zero slopes. */
        double low, high;
        const int piece = aoi_law_piece(contact->law, contact->memory, at->indentation[i], speed > 0.0, &low, &high);
        aoi_law_force(contact->law, contact->memory, piece, at->indentation[i], speed, &value);
        /* A negative slope, with which the matrix would need pivoting, is replaced by zero; the Newton step is
         * then approximate. */
        value.stiffness = fmax(value.stiffness, 0.0);
        value.damping = fmax(value.damping, 0.0);
    }
    const double whole = 1.0 + value.stiffness * compliance + value.damping * rate;
    const double terms = value.stiffness * fabs(at->indentation[i]) +
                         value.damping * (fabs(at->unloaded_rate[i]) + fabs(rate * at->force[i]));
    if (whole > 2.0 && terms > CANCELS * fabs(at->force[i])) {
        /* If the law's force is a small difference of large terms, the force computed from the compliance has more
         * digits. */
        at->force[i] = (at->unloaded[i] - at->indentation[i]) / compliance;
    }
    at->of_place[i] = isfinite(whole) ? value.stiffness / whole : 1.0 / compliance;
    at->of_rate[i] = isfinite(whole) ? value.damping / whole : 0.0;
}

/* Solves the equations i to i + 2 of a contact with friction. free: indentation and slides without the contact's
 * own force; place: guess of indentation and slides on entry, their solution on return. */
static int solve_three(const aoi_coupled *e, aoi_rubbing *rubbing, size_t i, const double free[3], double rate_free,
                       double place[3], double force[3])
{
    aoi_oblique_equation equation = {.rate_free = rate_free};
    for (size_t k = 0; k < 3; k++) {
        equation.free[k] = free[k];
        equation.guess[k] = place[k];
        equation.rate_compliance[k] = row_of(e, e->rate_compliance, i)[i + k];
        memcpy(equation.compliance[k], row_of(e, e->compliance, i + k) + i, sizeof equation.compliance[k]);
    }
    const int status = aoi_rub_solve(&rubbing->rub, &rubbing->state, &equation, &rubbing->found);
    if (status == AOI_OK) {
        memcpy(place, rubbing->found.place, sizeof rubbing->found.place);
        memcpy(force, rubbing->found.force, sizeof rubbing->found.force);
    }
    return status;
}

/* Solves the equation of contact i alone, starting from its present indentation. */
static int solve_one(newton *s, iterate *at, size_t i)
{
    s->failed = i;
    const aoi_coupled *e = s->e;
    const aoi_contact_state *contact = &s->contact[i];
    if (contact->rubbing) {
        const int status = contact->axis > 0 ? AOI_OK
                                             : solve_three(e, contact->rubbing, i, at->unloaded + i, at->unloaded_rate[i],
                                                           at->indentation + i, at->force + i);
        at->of_rate[i] = contact->axis > 0 ? 0.0 : fmax(contact->rubbing->found.by_rate[0], 0.0);
        return status;
    }
    /* An adhesive contact may have two solutions, closed and open. It stays closed if it was closed before. */
    const double pulled = contact->indentation > s->ended ? contact->indentation
                                                          : aoi_law_rest(contact->law, contact->memory);
    const aoi_contact_equation equation = {
        at->unloaded[i], own(e, e->compliance, i), at->unloaded_rate[i], own(e, e->rate_compliance, i),
        contact->law->pulls ? pulled : at->indentation[i]};
    const int status = aoi_contact_solve(contact->law, contact->memory, &equation, &at->force[i],
                                         &at->indentation[i]);
    if (status == AOI_OK) {
        find_slopes(s, at, i);
    }
    return status;
}

static int solve_each(newton *s, iterate *at)
{
    int status = AOI_OK;
    for (size_t i = 0; i < s->e->count && status == AOI_OK; i++) {
        status = solve_one(s, at, i);
    }
    return status;
}

/* Finds the residuals R (off) and S (rate_off) of contact i, and the sums of the magnitudes of their terms. */
static void find_off(const newton *s, iterate *at, size_t i)
{
    const aoi_coupled *e = s->e;
    double size, rate_size;
    at->off[i] = at->unloaded[i] - e->free[i] + neighbours(e, s->contact, e->compliance, i, at->force, &size);
    at->rate_off[i] = at->unloaded_rate[i] - e->rate_free[i] +
                      neighbours(e, s->contact, e->rate_compliance, i, at->force, &rate_size);
    s->size[i] = fabs(e->free[i]) + size;
    s->rate_size[i] = fabs(e->rate_free[i]) + rate_size;
}

/* Returns the error in indentation i (matrix: compliance) or rate i (matrix: rate compliance) that the rounding
 * errors of all rates cause through the forces of damped laws. */
static double uncertainty(const newton *s, const iterate *at, const double *matrix, size_t i)
{
    const double *row = row_of(s->e, matrix, i);
    double sum = 0.0;
    for (size_t j = first_of(s->e, i), last = last_of(s->e, i); j < last; j++) {
        sum += fabs(row[j]) * at->of_rate[j] * s->rate_size[j];
    }
    return sum;
}

/* Returns the part of all residuals above their rounding errors, as an energy, J; zero if all equations are
 * solved. */
static double find_merit(const newton *s, iterate *at)
{
    const aoi_coupled *e = s->e;
    double merit = 0.0, damped = 0.0;
    for (size_t i = 0; i < e->count; i++) {
        find_off(s, at, i);
        damped += at->of_rate[i];
    }
    for (size_t i = 0; i < e->count; i++) {
        double size = s->size[i], rate_size = s->rate_size[i];
        if (damped > 0.0) {
            size += uncertainty(s, at, e->compliance, i);
            rate_size += uncertainty(s, at, e->rate_compliance, i);
        }
        const double enough = s->rounding * fmax(size, SHARE * s->deepest);
        const double beyond = fabs(at->off[i]) - enough; /* NaN stays NaN */
        const double rate_beyond = fabs(at->rate_off[i]) - s->rounding * rate_size;
        const double compliance = own(e, e->compliance, i);
        const double of_rate = rate_beyond <= 0.0 ? 0.0 : compliance * at->of_rate[i] * rate_beyond;
        merit += ((beyond <= 0.0 ? 0.0 : beyond * beyond) + of_rate * of_rate) / compliance;
    }
    return merit;
}

/* Fills row i of Newton's matrix, and its right-hand side, for a contact with friction. */
static void fill_row(const newton *s, size_t i, const aoi_oblique_solution *found, size_t axis)
{
    const aoi_coupled *e = s->e;
    const size_t begin = i - axis;
    const double *by_free = found->by_free[axis], by_rate = found->by_rate[axis];
    const double *rates = row_of(e, e->rate_compliance, begin);
    double *row = s->matrix + i * s->width;
    memset(row, 0, s->width * sizeof *row);
    s->change[i] = -by_rate * s->now.rate_off[begin];
    for (size_t k = 0; k < 3; k++) {
        const double *compliance = row_of(e, e->compliance, begin + k);
        s->change[i] -= by_free[k] * s->now.off[begin + k];
        for (size_t j = first_of(e, begin + 2), last = last_of(e, begin); j < last; j++) {
            const double by = by_free[k] * compliance[j] + (k == 0 ? by_rate * rates[j] : 0.0);
            row[e->band + j - i] += j - begin < 3 ? 0.0 : s->yield * by;
        }
    }
    row[e->band] = 1.0;
}

static void fill_matrix(const newton *s)
{
    const aoi_coupled *e = s->e;
    for (size_t i = 0; i < e->count; i++) {
        if (s->contact[i].rubbing) {
            fill_row(s, i, &s->contact[i].rubbing->found, s->contact[i].axis);
            continue;
        }
        const double *compliance = e->compliance + i * s->width;
        const double *rates = e->rate_compliance + i * s->width;
        const double a = s->yield * s->now.of_place[i], b = s->yield * s->now.of_rate[i];
        double *row = s->matrix + i * s->width;
        for (size_t j = 0; j < s->width; j++) {
            row[j] = a * compliance[j] + b * rates[j];
        }
        row[e->band] = 1.0;
        s->change[i] = -(s->now.of_place[i] * s->now.off[i] + s->now.of_rate[i] * s->now.rate_off[i]);
    }
}

static void find_moves(const newton *s)
{
    const aoi_coupled *e = s->e;
    double size;
    for (size_t i = 0; i < e->count; i++) {
        s->move[i] = -s->now.off[i] - neighbours(e, s->contact, e->compliance, i, s->change, &size);
        s->rate_move[i] = -s->now.rate_off[i] - neighbours(e, s->contact, e->rate_compliance, i, s->change, &size);
    }
}

static int find_trial(newton *s, double share, double *merit)
{
    const aoi_coupled *e = s->e;
    for (size_t i = 0; i < e->count; i++) {
        const double give = s->move[i] - own(e, e->compliance, i) * s->change[i];
        s->trial.unloaded[i] = s->now.unloaded[i] + share * s->move[i];
        s->trial.unloaded_rate[i] = s->now.unloaded_rate[i] + share * s->rate_move[i];
        s->trial.indentation[i] = s->now.indentation[i] + share * give; /* guess of the search for the solution */
    }
    const int status = solve_each(s, &s->trial);
    *merit = status == AOI_OK ? find_merit(s, &s->trial) : 0.0;
    return status;
}

/* Makes the trial the present iterate. Indentations and forces are copied, so that they stay in the caller's
 * arrays. */
static void accept(newton *s)
{
    const size_t bytes = s->e->count * sizeof(double);
    const iterate last = s->now;
    memcpy(last.indentation, s->trial.indentation, bytes);
    memcpy(last.force, s->trial.force, bytes);
    s->now = s->trial;
    s->now.indentation = last.indentation;
    s->now.force = last.force;
    const iterate spare = s->trial;
    s->trial = last;
    s->trial.indentation = spare.indentation;
    s->trial.force = spare.force;
}

/* Takes a Newton step, which is shortened until the residual decreases. nearer: set to 1 if the step was taken. */
static int newton_step(newton *s, double *merit, int *nearer)
{
    int status = AOI_OK;
    double share = 1.0, after = HUGE_VAL;
    *nearer = 0;
    fill_matrix(s);
    if (!aoi_band_factorise(s->e->count, s->e->band, s->matrix)) {
        return AOI_OK;
    }
    aoi_band_substitute(s->e->count, s->e->band, s->matrix, s->change);
    find_moves(s);
    for (int i = 0; i < MOST_HALVINGS && !*nearer && status == AOI_OK; i++, share *= 0.5) {
        status = find_trial(s, share, &after);
        *nearer = status == AOI_OK &&
                  (s->yield < 1.0 ? after < HUGE_VAL : after <= (1.0 - 0.1 * share) * *merit);
    }
    if (*nearer) {
        accept(s);
        *merit = after;
    }
    return status;
}

/* Sets z and w of equation i for given forces. */
static void free_of_others(const newton *s, size_t i, const double *force)
{
    const aoi_coupled *e = s->e;
    double size;
    s->now.unloaded[i] = e->free[i] - neighbours(e, s->contact, e->compliance, i, force, &size);
    s->now.unloaded_rate[i] = e->rate_free[i] - neighbours(e, s->contact, e->rate_compliance, i, force, &size);
}

/* Makes a symmetric Gauss-Seidel sweep: solves the equations of all contacts in turn, forwards and backwards. */
static int sweep(newton *s, double *merit)
{
    const aoi_coupled *e = s->e;
    int status = AOI_OK;
    for (size_t k = 0; k < 2 * e->count && status == AOI_OK; k++) {
        const size_t i = k < e->count ? k : 2 * e->count - 1 - k;
        for (size_t j = i; s->contact[i].axis == 0 && j < i + size_of(&s->contact[i]); j++) {
            free_of_others(s, j, s->now.force);
        }
        status = solve_one(s, &s->now, i);
    }
    *merit = find_merit(s, &s->now);
    return status;
}

/* Solves the equations from the present forces and indentations, in at most most_steps steps. */
static int solve_from_here(newton *s, int most_steps)
{
    for (size_t i = 0; i < s->e->count; i++) {
        free_of_others(s, i, s->e->force);
    }
    int status = solve_each(s, &s->now);
    double merit = find_merit(s, &s->now);
    for (int step = 0; status == AOI_OK && merit > 0.0; step++) {
        int nearer = 0;
        if (step == most_steps) {
            return AOI_ERROR_NO_CONVERGENCE;
        }
        status = newton_step(s, &merit, &nearer);
        for (int i = 0; i < SWEEPS && !nearer && status == AOI_OK; i++) {
            status = sweep(s, &merit);
        }
    }
    return status == AOI_OK && !(merit == 0.0) ? AOI_ERROR_NOT_FINITE : status;
}

/* Opens the adhesive contact with the least indentation; returns 0 if no such contact is left. The force of an
 * adhesive contact ends with a jump. If the contact is coupled to others, its equation alone may then have no
 * consistent state, neither closed nor open, although all equations together have a solution with the contact
 * open. */
static int end_next(newton *s)
{
    double next = HUGE_VAL;
    for (size_t i = 0; i < s->e->count; i++) {
        const aoi_contact_state *contact = &s->contact[i];
        if (contact->law->pulls && contact->indentation > s->ended &&
            contact->indentation > aoi_law_rest(contact->law, contact->memory)) {
            next = fmin(next, contact->indentation);
        }
    }
    s->ended = next < HUGE_VAL ? next : s->ended;
    return next < HUGE_VAL;
}

static int has_failed(int status) { return status == AOI_ERROR_NO_CONVERGENCE || status == AOI_ERROR_NOT_FINITE; }

/* Solves the equations from zero contact forces, to the relative tolerance `rounding`, in at most most_steps
 * steps. */
static int solve_from_apart(newton *s, double rounding, int most_steps)
{
    const aoi_coupled *e = s->e;
    for (size_t i = 0; i < e->count; i++) {
        e->indentation[i] = e->free[i];
        e->force[i] = 0.0;
    }
    s->rounding = rounding;
    return solve_from_here(s, most_steps);
}

static int solve_all(newton *s)
{
    const aoi_coupled *e = s->e;
    int status = solve_from_here(s, FIRST_STEPS);
    if (has_failed(status)) { /* second attempt, without the guess */
        s->yield = YIELD;
        status = solve_from_apart(s, AOI_COUPLED_ROUNDING, FIRST_STEPS);
        s->yield = 1.0;
    }
    status = has_failed(status) ? solve_from_apart(s, AOI_COUPLED_ROUNDING, MOST_STEPS) : status;
    status = has_failed(status) ? solve_from_apart(s, ROUGH, MOST_STEPS) : status;
    while (has_failed(status) && end_next(s)) {
        status = solve_from_apart(s, AOI_COUPLED_ROUNDING, MOST_STEPS);
    }
    for (size_t i = 0; i < e->count; i++) {
        e->rate[i] = s->now.unloaded_rate[i] - own(e, e->rate_compliance, i) * e->force[i];
    }
    return status;
}

/* Solves the equation of a single contact. Most steps of most runs are without contact and return early. */
static int solve_single(aoi_coupled *e, const aoi_contact_state *contact)
{
    const aoi_law *law = contact->law;
    const double last = contact->indentation, free_end = e->free[0];
    if (free_end <= 0.0 && free_end >= -DBL_MAX && !law->rest && !law->pulls) {
        e->force[0] = 0.0;
        e->indentation[0] = free_end;
        e->rate[0] = e->rate_free[0];
        return AOI_OK;
    }
    const aoi_contact_equation equation = {
        free_end, e->compliance[0], e->rate_free[0], e->rate_compliance[0],
        law->pulls ? last : 2.0 * last - contact->last_indentation};
    const int status = aoi_contact_solve(law, contact->memory, &equation, e->force, e->indentation);
    e->rate[0] = e->rate_free[0] - e->rate_compliance[0] * e->force[0];
    return status;
}

/* -------------------------------------------- segments of neighbouring contacts that touch */

/* Number of band widths by which a segment extends beyond its touching contacts, so that their neighbours can
 * close as well. Tried: from 2 to 12 no run changes. */
enum { REACH = 4 };

/* Returns the largest indentation beyond rest of all contacts, m. For one contact the larger of its indentation
 * without contact forces and, if it had a force, its last indentation counts. */
static double find_deepest(const aoi_coupled *e, const aoi_contact_state *contact)
{
    double deepest = 0.0;
    for (size_t i = 0; i < e->count; i += size_of(&contact[i])) {
        const double rest = aoi_law_rest(contact[i].law, contact[i].memory);
        const double last = contact[i].force != 0.0 ? contact[i].indentation : rest;
        deepest = fmax(deepest, fmax(e->free[i], last) - rest);
    }
    return deepest;
}

/* Returns the largest indentation of a contact that counts as open, m. */
static double open_tolerance(double deepest) { return AOI_COUPLED_ROUNDING * SHARE * deepest; }

/* Marks the contacts that may touch, and sets a guess of their indentations and forces, extrapolated from the last
 * two steps; the force of all other contacts is zero. */
static void guess(const aoi_coupled *e, const aoi_contact_state *contact, double deepest, double *active)
{
    const double least = open_tolerance(deepest);
    for (size_t i = 0; i < e->count; i++) {
        const aoi_contact_state *c = &contact[i];
        const double rest = aoi_law_rest(c->law, c->memory), free_end = e->free[i];
        const double ahead = 2.0 * c->indentation - c->last_indentation;
        if (c->rubbing) {
            const aoi_contact_state *first = c - c->axis;
            active[i] = c->axis > 0 ? active[i - 1]
                                    : free_end > least || c->force * own(e, e->compliance, i) > least;
            e->indentation[i] = first->force != 0.0 ? c->rubbing->guess[c->axis] : free_end;
            e->force[i] = active[i] != 0.0 ? c->force : 0.0;
            e->rate[i] = e->rate_free[i];
            continue;
        }
        const int stays = c->law->pulls && c->indentation > rest;
        active[i] = free_end - rest > least || stays ||
                   fabs(c->force) * own(e, e->compliance, i) > least;
        e->indentation[i] = stays ? c->indentation : free_end;
        e->rate[i] = e->rate_free[i];
        e->force[i] = 0.0;
        if (active[i] != 0.0 && ahead > rest && c->force != 0.0) {
            /* The guess is at most twice the last force, or the force that would keep the bodies at rest. */
            const double most = fmax(2.0 * fabs(c->force), free_end / own(e, e->compliance, i));
            aoi_law_value value;
            aoi_law_push(c->law, c->memory, ahead, c->rate, &value);
            e->indentation[i] = ahead;
            e->force[i] = fabs(value.force) <= most ? value.force : c->force;
        }
    }
}

/* Finds the next segment, from contact `from` on: a range of contacts that may touch, and their neighbours. No two
 * segments are coupled. Returns 0 if there is none. */
static int next_segment(const aoi_coupled *e, const aoi_contact_state *contact, const double *active, size_t from,
                        size_t *low, size_t *high)
{
    const size_t beyond = REACH * e->band;
    size_t i = from;
    while (i < e->count && active[i] == 0.0) {
        i++;
    }
    if (i == e->count) {
        return 0;
    }
    *low = begin_of(contact, i > from + beyond ? i - beyond : from);
    size_t last = i;
    for (; i < e->count && i - last <= 2 * beyond + e->band; i++) {
        last = active[i] != 0.0 ? i : last;
    }
    *high = e->count - last > beyond + 1 ? last + beyond + 1 : e->count;
    while (*high < e->count && contact[*high].axis > 0) {
        *high += 1;
    }
    return 1;
}

static int solve_segment(aoi_coupled *e, const aoi_contact_state *contact, size_t low, size_t high,
                         double deepest, double *work)
{
    const size_t width = 2 * e->band + 1;
    const aoi_coupled part = {high - low,
                              e->band,
                              e->compliance + low * width,
                              e->rate_compliance + low * width,
                              e->free + low,
                              e->rate_free + low,
                              e->indentation + low,
                              e->rate + low,
                              e->force + low,
                              NULL,
                              0};
    newton s;
    lay_out(&s, &part, contact + low, work);
    s.deepest = deepest;
    s.ended = -HUGE_VAL;
    s.rounding = AOI_COUPLED_ROUNDING;
    s.yield = 1.0;
    const int status = solve_all(&s);
    e->failed = low + s.failed;
    return status;
}

/* Solves the equations of all segments with active contacts, and marks the contacts in these segments with 2. */
static int solve_active(aoi_coupled *e, const aoi_contact_state *contact, double deepest,
                       double *active)
{
    size_t low, high = 0;
    int status = AOI_OK;
    while (status == AOI_OK && next_segment(e, contact, active, high, &low, &high)) {
        status = solve_segment(e, contact, low, high, deepest, active + e->count);
        for (size_t i = low; i < high; i++) {
            active[i] = 2.0;
        }
    }
    return status;
}

/* Updates the contacts outside the segments, whose forces are zero. Returns whether one of them touches. */
static int activate(const aoi_coupled *e, const aoi_contact_state *contact, double deepest, double *active)
{
    int changed = 0;
    for (size_t i = 0; i < e->count; i++) {
        if (active[i] != 2.0) {
            const double rest = aoi_law_rest(contact[i].law, contact[i].memory);
            /* magnitude of the terms, not used; the contact's own force, which neighbours() omits, is zero */
            double size;
            e->indentation[i] = e->free[i] - neighbours(e, contact, e->compliance, i, e->force, &size);
            e->rate[i] = e->rate_free[i] - neighbours(e, contact, e->rate_compliance, i, e->force, &size);
            active[i] = contact[i].axis > 0 ? active[i - 1]
                                            : e->indentation[i] - rest > open_tolerance(deepest);
            changed = changed || active[i] != 0.0;
        }
    }
    return changed;
}

int aoi_coupled_solve(aoi_coupled *e, const aoi_contact_state *contact)
{
    e->failed = 0;
    if (e->count == 1) {
        return solve_single(e, contact);
    }
    if (e->count == 3 && contact->rubbing) {
        memcpy(e->indentation, contact->force != 0.0 ? contact->rubbing->guess : e->free, 3 * sizeof(double));
        return solve_three(e, contact->rubbing, 0, e->free, e->rate_free[0], e->indentation, e->force);
    }
    for (size_t i = 0; i < e->count; i++) {
        if (!isfinite(e->free[i]) || !isfinite(e->rate_free[i])) {
            return AOI_ERROR_NOT_FINITE;
        }
    }
    double *active = e->work;
    const double deepest = find_deepest(e, contact);
    int status, changed = 1;
    guess(e, contact, deepest, active);
    do {
        status = solve_active(e, contact, deepest, active);
        changed = status == AOI_OK && activate(e, contact, deepest, active);
    } while (changed);
    return status;
}
