/* Newton's method for the forces of a step: those parts that are the same for one contact and for several, namely
 * the evaluation of the law, the right-hand side and the end of the iteration. */
#include "collocation/collocation.h"
#include "collocation/newton.h"
#include "collocation/sliding.h"
#include "law/law.h"
#include "motion/radau.h"
#include "motion/nodes.h"

#include <math.h>
#include <string.h>

enum { MOST_ITERATIONS = 25 };

/* Friction is found on two paths. Up to this relative change of an indentation in an iteration, the difference
 * between the forces of the two paths is kept from an earlier iteration, since it is small and changes little. */
static const double FAR_OFF = 1e-2;

/* Predicted next change, relative to the indentation's scale, at which the iteration ends: half a rounding error.
 * With an unchanged matrix, the next change is predicted as the last change times the ratio of the last two.
 * Measured: a third costs 1.1 % more work, three times as much 0.4 %. */
static const double NEXT_CHANGE = 5e-17;

int aoi_collocation_wants_rates(const aoi_system *system, size_t count, const aoi_contact_step *entry)
{
    for (size_t s = 0; s < count; s++) {
        const aoi_law *law = system->contact[entry[s].contact].law;
        if (law->depends_on_rate || law->turns) {
            return 1;
        }
    }
    return 0;
}

/* Interpolates values at the start and the nodes to the quadrature points of an edge. points may be the same array
 * as nodes. */
static void reach(enum aoi_edge edge, double start, const double *nodes, double *points)
{
    aoi_nodes_multiply_from(start, &aoi_radau_indentation_at_edge[edge][0][0], nodes, points);
}

/* Evaluates the law at the nodes, or at the quadrature points of an edge. */
static void evaluate(const aoi_law *law, const aoi_contact_step *entry, int with_rates, aoi_law_values *of)
{
    double at_points[AOI_NODES], rates_there[AOI_NODES];
    const double *indentation = entry->indentation, *rate = entry->rate;
    if (entry->piece == AOI_SLACK || entry->sliding) {
        *of = (aoi_law_values){{0.0}, {0.0}, {0.0}};
        if (entry->piece != AOI_SLACK) { /* forces found by aoi_sliding_evaluate */
            memcpy(of->force, entry->sliding->force[entry->axis], sizeof of->force);
        }
        return;
    }
    if (entry->edge != AOI_EDGE_NONE) {
        reach(entry->edge, entry->start, entry->indentation, at_points);
        indentation = at_points;
    }
    if (entry->edge != AOI_EDGE_NONE && with_rates) {
        reach(entry->edge, entry->start_rate, entry->rate, rates_there);
        rate = rates_there;
    }
    aoi_law_forces(law, entry->memory, entry->piece, indentation, rate, of);
}

void aoi_collocation_weigh(enum aoi_edge edge, const double *by, const double *column, double *to)
{
    double there[AOI_NODES];
    if (edge != AOI_EDGE_NONE) {
        reach(edge, 0.0, column, there);
        column = there;
    }
    for (size_t i = 0; i < AOI_NODES; i++) {
        to[i] = by[i] * column[i];
    }
    if (edge != AOI_EDGE_NONE) {
        aoi_edge_project(edge, to, to);
    }
}

void aoi_newton_add_residual(double residual, double h, double *displacement, double *rate)
{
    for (size_t q = 0; q < AOI_NODES && residual != 0.0; q++) {
        displacement[q * AOI_NODES + q] += residual;
        if (rate) {
            aoi_nodes_add(residual / h, aoi_radau_slope_at_node[q + 1], rate + q * AOI_NODES);
        }
    }
}

void aoi_newton_invert(enum aoi_edge edge, const double *stiffness, const double *damping, const double *displacement,
                       const double *rate, double *inverse)
{
    for (size_t q = 0; q < AOI_NODES; q++) {
        const size_t at = q * AOI_NODES;
        double by_rate[AOI_NODES];
        aoi_collocation_weigh(edge, stiffness, displacement + at, inverse + at);
        if (rate) {
            aoi_collocation_weigh(edge, damping, rate + at, by_rate);
            aoi_nodes_add(1.0, by_rate, inverse + at);
        }
        inverse[at + q] += 1.0;
    }
    /* pivots are near or above 1, as in many.c; the inverse is stored by columns as well */
    aoi_nodes_invert(inverse);
}

/* Adds factor times (aim - values), interpolated to the points where the law is evaluated, to `to`. */
static void add_lack(const aoi_contact_step *entry, const double *aim, const double *values,
                     const double *factor, double *to)
{
    double lack[AOI_NODES], at_points[AOI_NODES];
    for (size_t i = 0; i < AOI_NODES; i++) {
        lack[i] = at_points[i] = aim[i] - values[i];
    }
    if (entry->edge != AOI_EDGE_NONE) {
        reach(entry->edge, 0.0, lack, at_points);
    }
    for (size_t k = 0; k < AOI_NODES; k++) {
        to[k] += factor[k] * at_points[k];
    }
}

/* Replaces the law's force by the right-hand side of Newton's equations, for the first or a later iteration. */
static void aim(const aoi_contact_step *entry, int first, int with_rates, aoi_law_values *law)
{
    /* friction also depends on the slides */
    for (size_t r = 0, axes = entry->sliding ? 3 : 1; first && r < axes; r++) {
        const aoi_contact_step *of = entry - entry->axis + r;
        const double *by = entry->sliding ? entry->sliding->by[entry->axis][r] : law->stiffness;
        add_lack(of, of->homogeneous, of->indentation, by, law->force);
    }
    if (first && with_rates) {
        add_lack(entry, entry->homogeneous_rate, entry->rate, law->damping, law->force);
    }
    if (entry->edge != AOI_EDGE_NONE) {
        aoi_edge_project(entry->edge, law->force, law->force);
    }
    for (size_t i = 0; i < AOI_NODES; i++) {
        law->force[i] -= first ? entry->constant : entry->force[i];
    }
}

/* Returns 1 if both paths of friction are to be followed, to find anew the difference between their forces: in
 * iteration 1, and in later iterations after a large change. */
static int nears(const aoi_newton *newton)
{
    return newton->iteration == 1 || (newton->iteration > 1 && newton->before > FAR_OFF);
}

int aoi_newton_law(const aoi_system *system, const aoi_newton *newton, const aoi_contact_step *entry, int with_rates,
                   aoi_law_values *law)
{
    if (entry->sliding && entry->axis == 0 &&
        aoi_sliding_evaluate(entry->sliding, entry, nears(newton)) != AOI_OK) {
        return 0;
    }
    evaluate(system->contact[entry->contact].law, entry, with_rates, law);
    aim(entry, newton->iteration == 0, with_rates, law);
    return 1;
}

aoi_newton aoi_newton_begin(size_t count, const aoi_contact_step *entry)
{
    aoi_newton newton = {0, 1, HUGE_VAL, 1e-15, 0};
    for (size_t s = 0; s < count; s++) {
        newton.slides = newton.slides || entry[s].sliding;
        newton.enough = entry[s].sliding ? fmax(newton.enough, entry[s].sliding->enough) : newton.enough;
    }
    return newton;
}

int aoi_newton_goes_on(const aoi_newton *newton, double change)
{
    return isfinite(change) && newton->iteration < MOST_ITERATIONS;
}

int aoi_newton_done(aoi_newton *newton, double change)
{
    const int first = newton->iteration++ == 0;
    const double ratio = change / newton->before;
    newton->renew = !first && !(ratio < AOI_NEWTON_KEPT);
    newton->before = change;
    if (first && newton->slides) {
        return 0;
    }
    return change <= newton->enough || (change <= AOI_COLLOCATION_ROUNDING && ratio >= 0.5) ||
           (!first && ratio < AOI_NEWTON_KEPT && ratio * change <= NEXT_CHANGE);
}
