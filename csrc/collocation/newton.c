/* Newton's method for the forces of a step, as far as it is the same for one contact and for several: the law at the
 * nodes or at the points of an edge, the right-hand side, and when the iteration ends. */
#include "collocation/collocation.h"
#include "collocation/newton.h"
#include "collocation/sliding.h"
#include "law/law.h"
#include "motion/radau.h"
#include "motion/nodes.h"

#include <math.h>
#include <string.h>

enum { MOST_ITERATIONS = 25 };

/* The matrix is kept as long as a change is smaller than the one before by this: to make and invert it anew costs
 * about three iterations with the old one, each of which gains more than a digit. Measured: 0.017 costs 0.3 % more
 * work, 0.15 costs 0.1 %. */
static const double KEPT = 0.05;

/* The two paths of friction differ little, and their difference changes less: after a smaller change it is kept. */
static const double FAR_OFF = 1e-2;

/* With the matrix of the change before, the error falls by twice the ratio of the last changes: the next change would
 * be half a rounding. Measured: a third costs 1.1 % more work, three times as much 0.4 %. */
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

void aoi_edge_reach(enum aoi_edge edge, double start, const double *nodes, double *points)
{
    aoi_nodes_multiply_from(start, &aoi_radau_indentation_at_edge[edge][0][0], nodes, points);
}

void aoi_edge_project(enum aoi_edge edge, const double *points, double *nodes)
{
    aoi_nodes_multiply(&aoi_radau_edge_projection[edge][0][0], points, nodes);
}

void aoi_collocation_evaluate(const aoi_law *law, const aoi_contact_step *entry, int with_rates,
                         aoi_law_values *of)
{
    double at_points[AOI_NODES], rates_there[AOI_NODES];
    const double *indentation = entry->indentation, *rate = entry->rate;
    if (entry->piece == AOI_SLACK) {
        *of = (aoi_law_values){{0.0}, {0.0}, {0.0}};
        return;
    }
    if (entry->sliding) { /* as found for all three entries of the contact */
        *of = (aoi_law_values){{0.0}, {0.0}, {0.0}};
        memcpy(of->force, entry->sliding->force[entry->axis], sizeof of->force);
        return;
    }
    if (entry->edge != AOI_EDGE_NONE) {
        aoi_edge_reach(entry->edge, entry->start, entry->indentation, at_points);
        indentation = at_points;
    }
    if (entry->edge != AOI_EDGE_NONE && with_rates) {
        aoi_edge_reach(entry->edge, entry->start_rate, entry->rate, rates_there);
        rate = rates_there;
    }
    aoi_law_forces(law, entry->memory, entry->piece, indentation, rate, of);
}

void aoi_collocation_weigh(enum aoi_edge edge, const double *by, const double *column, double *to)
{
    double there[AOI_NODES];
    if (edge != AOI_EDGE_NONE) {
        aoi_edge_reach(edge, 0.0, column, there);
        column = there;
    }
    for (size_t i = 0; i < AOI_NODES; i++) {
        to[i] = by[i] * column[i];
    }
    if (edge != AOI_EDGE_NONE) {
        aoi_edge_project(edge, to, to);
    }
}

/* Adds factor times (aim - values), interpolated to the points where the law is evaluated. */
static void add_lack(const aoi_contact_step *entry, const double *aim, const double *values,
                     const double *factor, double *to)
{
    double lack[AOI_NODES], at_points[AOI_NODES];
    for (size_t i = 0; i < AOI_NODES; i++) {
        lack[i] = at_points[i] = aim[i] - values[i];
    }
    if (entry->edge != AOI_EDGE_NONE) {
        aoi_edge_reach(entry->edge, 0.0, lack, at_points);
    }
    for (size_t k = 0; k < AOI_NODES; k++) {
        to[k] += factor[k] * at_points[k];
    }
}

/* The same with friction, whose force depends on all three places of its contact. */
static void add_sliding_lack(const aoi_contact_step *entry, double *to)
{
    for (size_t i = 0; i < 3; i++) {
        const aoi_contact_step *of = entry - entry->axis + i;
        add_lack(of, of->homogeneous, of->indentation, entry->sliding->by[entry->axis][i], to);
    }
}

void aoi_collocation_aim(const aoi_contact_step *entry, int first, int with_rates, aoi_law_values *law)
{
    if (first && entry->sliding) {
        add_sliding_lack(entry, law->force);
    } else if (first) {
        add_lack(entry, entry->homogeneous, entry->indentation, law->stiffness, law->force);
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

int aoi_newton_nears(const aoi_newton *newton)
{
    return newton->iteration == 1 || (newton->iteration > 1 && newton->before > FAR_OFF);
}

int aoi_newton_goes_on(const aoi_newton *newton, double change)
{
    return isfinite(change) && newton->iteration < MOST_ITERATIONS;
}

int aoi_newton_done(aoi_newton *newton, double change)
{
    const int first = newton->iteration++ == 0;
    const double ratio = change / newton->before;
    newton->renew = !first && !(ratio < KEPT);
    newton->before = change;
    if (first && newton->slides) {
        return 0;
    }
    return change <= newton->enough || (change <= AOI_COLLOCATION_ROUNDING && ratio >= 0.5) ||
           (!first && ratio < KEPT && ratio * change <= NEXT_CHANGE);
}
