/* One step of contact. The forces are polynomials through the Radau nodes, whose effect on the bodies is exact.
 * Their nodal values are found by Newton's method, for all contacts of the step together. */
#include "collocation/collocation.h"
#include "collocation/newton.h"
#include "collocation/sliding.h"
#include "linear/vector.h"
#include "linear/work.h"
#include "law/law.h"
#include "motion/polynomial.h"
#include "motion/radau.h"
#include "motion/response.h"
#include "motion/nodes.h"

#include <float.h>
#include <math.h>
#include <string.h>

enum { SQUARE = AOI_NODES * AOI_NODES };

size_t aoi_collocation_size(size_t count, size_t span)
{
    const size_t rows = aoi_times(count, AOI_NODES), width = aoi_times(2 * AOI_NODES, span + 1);
    return aoi_plus(aoi_times(aoi_times(count, 2 * span + 1), 2 * SQUARE), aoi_times(rows, width));
}

/* Adds the influence of the force of entry `other` on the indentation and rate of entry `one`, through the bodies
 * that both share. A positive influence is a reduction of indentation or rate. */
static void add_coupling(const aoi_system *system, const aoi_response *response, double h,
                         const aoi_contact_step *one, const aoi_contact_step *other, double *displacement, double *rate)
{
    const aoi_contact *of = &system->contact[one->contact], *by = &system->contact[other->contact];
    for (int i = 0; i < 4; i++) {
        const int a = i / 2, c = i % 2;
        if (of->body[a] != by->body[c]) {
            continue;
        }
        const aoi_modes *body = &system->body[of->body[a]];
        const aoi_response *answer = &response[of->body[a]];
        const double sign = a == c ? 1.0 : -1.0;
        const size_t port = of->port[a] + one->axis, from = by->port[c] + other->axis;
        const size_t at = aoi_response_at(answer, port, from);
        const double residual = body->residual ? sign * body->residual[port * body->ports + from] : 0.0;
        for (size_t k = 0; k < SQUARE; k++) {
            displacement[k] += sign * answer->influence[at + k];
            if (rate) {
                rate[k] += sign * answer->influence_rate[at + k];
            }
        }
        aoi_newton_add_residual(residual, h, displacement, rate);
    }
}

/* Influences of all forces on the indentations (displacement) and rates of all entries. Block (s, t), stored by
 * columns, is the influence of force t on entry s and has the index s * blocks + t + span - s. blocks: blocks per
 * entry. */
typedef struct couplings {
    size_t count, span, blocks;
    double *displacement, *rate;
} couplings;

static const double *block_of(const couplings *of, const double *values, size_t s, size_t t)
{
    return values + (s * of->blocks + t + of->span - s) * SQUARE;
}

static size_t first_of(const couplings *of, size_t s) { return s > of->span ? s - of->span : 0; }

static size_t last_of(const couplings *of, size_t s)
{
    return s + of->span < of->count ? s + of->span : of->count - 1;
}

static void couple(const aoi_system *system, const aoi_response *response, double h,
                   const aoi_contact_step *entry, couplings *of)
{
    const size_t size = of->count * of->blocks * SQUARE * sizeof(double);
    memset(of->displacement, 0, size);
    if (of->rate) {
        memset(of->rate, 0, size);
    }
    for (size_t s = 0; s < of->count; s++) {
        for (size_t t = first_of(of, s); t <= last_of(of, s); t++) {
            const size_t at = (size_t)(block_of(of, of->displacement, s, t) - of->displacement);
            add_coupling(system, response, h, &entry[s], &entry[t], of->displacement + at,
                         of->rate ? of->rate + at : NULL);
        }
    }
}

/* Adds to a matrix a block of the couplings, multiplied by a slope of the law (by) at the points where the law is
 * evaluated. */
static void add_block(enum aoi_edge edge, const double *by, const double *block, size_t stride,
                      double *matrix)
{
    for (size_t q = 0; q < AOI_NODES; q++) {
        double column[AOI_NODES];
        aoi_collocation_weigh(edge, by, block + q * AOI_NODES, column);
        for (size_t i = 0; i < AOI_NODES; i++) {
            matrix[i * stride + q] += column[i];
        }
    }
}

/* Newton's equations for the forces, (1 + stiffness A + damping B) F = f + stiffness (delta_h - delta) + damping
 * (rate_h - rate), where F and f do not contain the constant forces, and h marks the homogeneous motion. Later
 * iterations solve for the changes of the forces, with the same matrix and the right-hand side f - F. The
 * influences A and B are nearly Volterra operators: pivots are near or above one. */
typedef struct equations {
    size_t n, half, stride;
    double *band, *matrix; /* element (i, j) is matrix[i * stride + j] */
    double *right;         /* right-hand side, then solution           */
} equations;

/* Lays out the arrays of the equations from `work` on, the part of the work space after the couplings. */
static equations lay_out(size_t count, size_t span, double *work)
{
    const size_t n = count * AOI_NODES, half = AOI_NODES * (span + 1) - 1;
    return (equations){n, half, 2 * half, work, work + half, work + n * (2 * half + 1)};
}

/* Sets the matrix rows of one entry. With friction, the entry's force depends on the indentation and both slides
 * of the contact. */
static void set_rows(const couplings *of, const aoi_contact_step *entry, size_t s, const aoi_law_values *law,
                     const equations *to)
{
    const aoi_sliding *sliding = entry[s].sliding;
    const size_t axis = entry[s].axis, begin = s - axis, end = begin + (sliding ? 3 : 1);
    double *rows = to->matrix + s * AOI_NODES * to->stride;
    for (size_t r = begin; r < end; r++) {
        const double *by = sliding ? sliding->by[axis][r - begin] : law->stiffness;
        for (size_t t = first_of(of, r > s ? r : s), last = last_of(of, r < s ? r : s); t <= last; t++) {
            double *block = rows + t * AOI_NODES;
            add_block(entry[s].edge, by, block_of(of, of->displacement, r, t), to->stride, block);
            if (of->rate && !sliding) {
                add_block(entry[s].edge, law->damping, block_of(of, of->rate, s, t), to->stride, block);
            }
        }
    }
    for (size_t i = 0; i < AOI_NODES; i++) {
        rows[i * to->stride + s * AOI_NODES + i] += 1.0;
    }
}

/* Sets the right-hand sides, and the matrix if it is to be renewed. Returns 1, or 0 if the equations of friction
 * have no solution. */
static int set_equations(const aoi_system *system, const couplings *of, const aoi_contact_step *entry,
                          const aoi_newton *newton, const equations *to)
{
    if (newton->renew) {
        memset(to->band, 0, to->n * (2 * to->half + 1) * sizeof(double));
    }
    for (size_t s = 0; s < of->count; s++) {
        aoi_law_values law;
        if (!aoi_newton_law(system, newton, &entry[s], of->rate != NULL, &law)) {
            return 0;
        }
        if (newton->renew) {
            set_rows(of, entry, s, &law, to);
        }
        for (size_t i = 0; i < AOI_NODES; i++) {
            to->right[s * AOI_NODES + i] = law.force[i];
        }
    }
    return 1;
}

/* Sets `answer` to the reduction of entry s's indentation (values: of->displacement) or rate (of->rate) at the
 * nodes due to all contact forces. */
static void effect_of(const couplings *of, const double *values, size_t s, const double *force,
                      double *answer)
{
    memset(answer, 0, AOI_NODES * sizeof *answer);
    for (size_t t = first_of(of, s); t <= last_of(of, s); t++) {
        double share[AOI_NODES];
        aoi_nodes_multiply(block_of(of, values, s, t), force + t * AOI_NODES, share);
        aoi_nodes_add(1.0, share, answer);
    }
}

/* Updates the forces by their changes `by`, and indentations and rates accordingly. first = 1: forces are the
 * constant forces plus `by`. Returns the largest change of an indentation relative to its scale. */
static double update(const couplings *of, const double *by, int first, aoi_contact_step *entry)
{
    double largest = 0.0, answer[AOI_NODES], rate_answer[AOI_NODES];
    for (size_t s = 0; s < of->count; s++) {
        effect_of(of, of->displacement, s, by, answer);
        if (of->rate) {
            effect_of(of, of->rate, s, by, rate_answer);
        }
        largest = aoi_newton_take(&entry[s], first, by + s * AOI_NODES, answer, of->rate ? rate_answer : NULL, largest);
    }
    return largest;
}

int aoi_collocation_solve(const aoi_system *system, const aoi_response *response, double h,
                          size_t count, size_t span, aoi_contact_step *entry, double *work)
{
    if (count > 0 && response[system->contact[entry->contact].body[0]].columns.count == AOI_BY_MODES) {
        return aoi_crowd_solve(system, response, h, count, entry, work);
    }
    if (count == 1) { /* without friction, since a contact with friction has three entries */
        return aoi_collocation_solve_one(system, response, h, entry);
    }
    const size_t blocks = 2 * span + 1, size = count * blocks * SQUARE;
    const int with_rates = aoi_collocation_wants_rates(system, count, entry);
    couplings of = {count, span, blocks, work, with_rates ? work + size : NULL};
    const equations to = lay_out(count, span, work + 2 * size);
    aoi_newton newton = aoi_newton_begin(count, entry);
    double change;
    couple(system, response, h, entry, &of);
    do {
        if (!set_equations(system, &of, entry, &newton, &to)) {
            return AOI_ERROR_NO_CONVERGENCE;
        }
        if (newton.renew) {
            (void)aoi_band_factorise(to.n, to.half, to.band);
        }
        aoi_band_substitute(to.n, to.half, to.band, to.right);
        change = update(&of, to.right, newton.iteration == 0, entry);
        if (aoi_newton_done(&newton, change)) {
            return AOI_OK;
        }
    } while (aoi_newton_goes_on(&newton, change));
    return AOI_ERROR_NO_CONVERGENCE;
}

/* Sets `answer` to the displacement at the nodes of one body of a contact relative to the other, after a unit
 * impulse at the start, m/(N s). */
static void impulse_responses(const aoi_response *response, const aoi_contact *contact, size_t axis, double *answer)
{
    const size_t port[2] = {contact->port[0] + axis, contact->port[1] + axis};
    const double *first = response[contact->body[0]].impulse_response + port[0] * AOI_NODES;
    const double *second = response[contact->body[1]].impulse_response + port[1] * AOI_NODES;
    for (size_t i = 0; i < AOI_NODES; i++) {
        answer[i] = first[i] + second[i];
    }
}

/* Sets `beyond` to the law's force minus the value of the force polynomial at the check points, N. */
static void find_beyond(const aoi_law *law, const aoi_contact_step *entry, double *beyond)
{
    const size_t checks = aoi_edge_checks(entry->edge);
    const double *place = aoi_radau_check_point[entry->edge];
    double force[AOI_NODES], rate[AOI_NODES + 1], there[AOI_EDGE_CHECKS], rates[AOI_EDGE_CHECKS] = {0.0};
    aoi_nodes_to_legendre(entry->force, force);
    aoi_legendre_at_points(AOI_NODES, force, checks, place, beyond);
    aoi_legendre_at_points(AOI_NODES + 1, entry->legendre, checks, place, there);
    if (law->depends_on_rate) {
        aoi_legendre_fit(entry->start_rate, entry->rate, rate);
        aoi_legendre_at_points(AOI_NODES + 1, rate, checks, place, rates);
    }
    for (size_t k = 0; k < checks; k++) {
        aoi_law_value value;
        aoi_law_force(law, entry->memory, entry->piece, there[k], rates[k], &value);
        beyond[k] = value.force - beyond[k];
    }
}

/* Adds the errors at the end of a step due to `beyond`, the differences of the force at the check points. The time
 * left in the step at check point k equals the time from its start to node k or, at an edge, to check point k of
 * the opposite edge. answer: displacement at the nodes after a unit impulse at the start, which is interpolated to
 * the check points of an edge. */
static void add_errors(const aoi_contact_step *entry, double h, const double *beyond, const double *answer,
                       aoi_collocation_error *error)
{
    const size_t checks = aoi_edge_checks(entry->edge);
    double series[AOI_NODES + 1], there[AOI_EDGE_CHECKS];
    if (entry->edge != AOI_EDGE_NONE) {
        aoi_legendre_fit(0.0, answer, series);
        aoi_legendre_at_points(AOI_NODES + 1, series, checks, aoi_radau_check_point[AOI_EDGE_END - entry->edge], there);
        answer = there;
    }
    for (size_t k = 0; k < checks; k++) {
        const double weighted = h * aoi_radau_check_weight[entry->edge][k] * beyond[k];
        error->impulse += weighted;
        error->indentation += weighted * answer[k];
    }
}

void aoi_collocation_estimate(const aoi_system *system, const aoi_response *response, double h,
                              aoi_contact_step *entry, aoi_collocation_error *error)
{
    const aoi_contact *contact = &system->contact[entry->contact];
    double answer[AOI_NODES];
    *error = (aoi_collocation_error){0.0, 0.0, 0.0};
    impulse_responses(response, contact, entry->axis, answer);
    aoi_legendre_fit(entry->start, entry->indentation, entry->legendre);
    if (entry->sliding) { /* aoi_sliding_check has set `beyond` */
        add_errors(entry, h, entry->sliding->beyond[entry->axis], answer, error);
    } else if (entry->piece != AOI_SLACK) {
        double beyond[AOI_EDGE_CHECKS];
        find_beyond(contact->law, entry, beyond);
        add_errors(entry, h, beyond, answer, error);
    }
    const double *c = entry->legendre;
    /* A fifth of the preceding coefficient is added, since a coefficient may vanish due to symmetry. */
    const double last = fabs(c[AOI_NODES]) + 0.2 * fabs(c[AOI_NODES - 1]);
    const double before = fabs(c[AOI_NODES - 2]) + 0.2 * fabs(c[AOI_NODES - 3]);
    /* The coefficients left out are assumed to decrease at the rate of the last ones. */
    error->tail = last < before ? last * sqrt(last / before) : last;
}

double aoi_collocation_impulse(const aoi_contact_step *entry, double h)
{
    return h * aoi_nodes_dot(aoi_radau_to_legendre[0], entry->force);
}

double aoi_collocation_work(const double *legendre, const double *force, double place)
{
    double work = 0.0;
    for (size_t i = 0; i < AOI_NODES; i++) {
        double slope;
        (void)aoi_legendre_evaluate(AOI_NODES + 1, legendre, place * aoi_radau_node[i], &slope);
        work += aoi_radau_to_legendre[0][i] * place * force[i] * slope;
    }
    return work;
}
