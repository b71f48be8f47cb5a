/* Evaluation of the contacts in the rows of a track. */
#include "adaptive/row.h"
#include "collocation/collocation.h"
#include "motion/nodes.h"
#include "motion/polynomial.h"
#include "motion/radau.h"

#include <math.h>
#include <string.h>

/* Nodes closer than this to a change between sticking and slipping, as a share of the row, are left out of the
 * interpolation of stretches: over so short a distance, the difference between the stretches at the node and at
 * the change is mostly their error. */
static const double BESIDE = 0.02;

static const double *tangent_of(const double *of, size_t i)
{
    return of + AOI_TRACK_TANGENTS + i * AOI_TRACK_TANGENT_SIZE;
}

/* Stretches as in enum aoi_row_friction along both tangents, m, at positions (place) in a row, 0 to 1. */
typedef struct stretches {
    size_t count;
    double place[AOI_NODES + 2], stretch[2][AOI_NODES + 2];
} stretches;

static void add_stretch(stretches *to, double place, const double *of, int which)
{
    to->place[to->count] = place;
    to->stretch[0][to->count] = tangent_of(of, 0)[which];
    to->stretch[1][to->count] = tangent_of(of, 1)[which];
    to->count++;
}

/* Finds the stretches in the part of a row that contains a position and lies between two changes of slip: at the
 * ends of the part and at the nodes inside. Returns 1 if all springs slip in that part. */
static int stretches_about(const double *of, double place, stretches *found)
{
    const double *change = of + AOI_TRACK_CHANGES;
    int i = 0;
    while (i < AOI_SLIP_CHANGES && change[i] <= place) {
        i++;
    }
    const int ends = i < AOI_SLIP_CHANGES && change[i] <= 1.0;
    const double low = i > 0 ? change[i - 1] : 0.0, high = ends ? change[i] : 1.0;
    found->count = 0;
    add_stretch(found, low, of, i > 0 ? AOI_TRACK_TANGENT_CHANGES + i - 1 : AOI_TRACK_TANGENT_STRETCH);
    for (int k = 0; k < AOI_NODES; k++) {
        const double node = aoi_radau_node[k];
        if (node > low + (i > 0 ? BESIDE : 0.0) && (ends ? node < high - BESIDE : 1)) {
            add_stretch(found, node, of, AOI_TRACK_TANGENT_STRETCH + 1 + k);
        }
    }
    if (ends) {
        add_stretch(found, high, of, AOI_TRACK_TANGENT_CHANGES + i);
    }
    return (of[AOI_TRACK_SLIPS] != 0.0) != (i % 2 != 0);
}

/* The normal force is that of the law. Friction is the normal force times a ratio: mu where all springs slip,
 * otherwise the row's stretch divided by the indentation. The stretch has corners where slip begins or ends;
 * between these it is interpolated by Lagrange's polynomial and limited to mu times the indentation. With this
 * ratio, the compliance taken out of the law can be written as a compliance for the normal force alone. */
void aoi_row_rub(const aoi_contact *contact, const double *of, double place, double force[3], double *bent)
{
    const double *coupled = contact->compliance;
    double share[2] = {0.0, 0.0}, slope;
    const double bodies = aoi_legendre_evaluate(AOI_NODES + 1, of + AOI_TRACK_INDENTATION, place, &slope);
    const double bound = contact->friction->mu * fmax(bodies, 0.0);
    aoi_law law = *contact->law;
    aoi_law_value value;
    stretches known;
    const int slips = stretches_about(of, place, &known);
    for (size_t k = 0; k < known.count; k++) {
        double above = 1.0, below = 1.0;
        for (size_t j = 0; j < known.count; j++) {
            above *= j == k ? 1.0 : place - known.place[j];
            below *= j == k ? 1.0 : known.place[k] - known.place[j];
        }
        share[0] += known.stretch[0][k] * (above / below);
        share[1] += known.stretch[1][k] * (above / below);
    }
    const double size = hypot(share[0], share[1]), most = slips ? size : fmax(size, bound);
    for (size_t i = 0; i < 2; i++) {
        share[i] = most > 0.0 ? contact->friction->mu * (share[i] / most) : 0.0;
        law.compliance += coupled ? coupled[1 + i] * share[i] : 0.0;
    }
    aoi_law_force(&law, NULL, (int)of[AOI_TRACK_PIECE], bodies, 0.0, &value);
    force[0] = fmax(value.force, 0.0);
    force[1] = share[0] * force[0];
    force[2] = share[1] * force[0];
    *bent = law.compliance * force[0];
}

/* Sets `force` to the normal and, with friction, both tangential forces at a position (0 to 1) of a row of length
 * h, N. */
static void forces_at(const aoi_contact *contact, const double *of, double h, double place, double force[3])
{
    double slope, bent;
    aoi_law_value value;
    if (contact->friction) {
        aoi_row_rub(contact, of, place, force, &bent);
        return;
    }
    const double indentation = aoi_legendre_evaluate(AOI_NODES + 1, of + AOI_TRACK_INDENTATION, place, &slope);
    aoi_law_force(contact->law, of + AOI_TRACK_MEMORY, (int)of[AOI_TRACK_PIECE], indentation, slope / h, &value);
    force[0] = value.force;
}

void aoi_row_forces(const aoi_contact *contact, const double *of, double h, double place, double force[3][AOI_NODES])
{
    const enum aoi_edge edge = (enum aoi_edge)of[AOI_TRACK_EDGE];
    const int anew = place < 1.0 && edge != AOI_EDGE_NONE;
    for (size_t k = 0; k < AOI_NODES && anew; k++) {
        double here[3] = {0.0};
        forces_at(contact, of, h, place * aoi_radau_edge_point[edge][k], here);
        for (size_t i = 0; i < 3; i++) {
            force[i][k] = here[i];
        }
    }
    for (size_t i = 0; i < aoi_contact_forces(contact); i++) {
        const double *whole = i == 0 ? of + AOI_TRACK_FORCE : tangent_of(of, i - 1) + AOI_TRACK_TANGENT_FORCE;
        if (anew) {
            aoi_edge_project(edge, force[i], force[i]);
        } else if (place < 1.0) {
            aoi_nodes_on_part(whole, place, force[i]);
        } else {
            memcpy(force[i], whole, sizeof force[i]);
        }
    }
}

double aoi_row_slide_work(const aoi_contact *contact, const double *of, double place)
{
    double force[3][AOI_NODES], normal[AOI_NODES], work = 0.0, slope;
    /* the law is elastic, so that the row's length (1) has no effect */
    aoi_row_forces(contact, of, 1.0, place, force);
    aoi_nodes_to_legendre(force[0], normal); /* Legendre coefficients of force[0] up to `place` */
    for (size_t k = 0; k < AOI_NODES; k++) {
        const double at = aoi_radau_node[k], weight = aoi_radau_to_legendre[0][k];
        (void)aoi_legendre_evaluate(AOI_NODES, normal, at, &slope);
        const double rise = slope;
        for (size_t i = 0; i < 2; i++) {
            const double c = contact->compliance ? contact->compliance[3 * (1 + i)] : 0.0;
            (void)aoi_legendre_evaluate(AOI_NODES + 1, tangent_of(of, i) + AOI_TRACK_TANGENT_SLIDE, place * at, &slope);
            work += weight * force[1 + i][k] * (place * slope + c * rise);
        }
    }
    return of[AOI_TRACK_SLIDE_WORK] + work;
}

double aoi_row_slide_stored(const aoi_contact *contact, const double *of, double place)
{
    double force[3], bent, stored = aoi_row_slide_work(contact, of, place);
    aoi_row_rub(contact, of, place, force, &bent);
    for (size_t i = 0; i < 4 && contact->compliance; i++) {
        stored += 0.5 * force[1 + i / 2] * contact->compliance[4 + i / 2 * 3 + i % 2] * force[1 + i % 2];
    }
    return stored;
}

/* Returns the value at a position, interpolated linearly between the values at the nodes, or at an edge's
 * quadrature points, and the values `from` at `low` and `to` at `high`. from = NaN: the value is constant from
 * `low` to the next point. */
static double interpolated(const double *of, int first, double place, double low, double from, double high, double to)
{
    const double *points = aoi_radau_edge_point[(enum aoi_edge)of[AOI_TRACK_EDGE]];
    for (size_t k = 0; k < AOI_NODES; k++) {
        const double value = of[first + 1 + (int)k];
        if (points[k] <= place && points[k] > low) {
            low = points[k];
            from = value;
        } else if (points[k] > place && points[k] <= high) {
            high = points[k];
            to = value;
        }
    }
    from = isnan(from) ? to : from;
    return high > low ? from + (to - from) * ((place - low) / (high - low)) : to;
}

double aoi_row_between(const double *of, int first, double place)
{
    return interpolated(of, first, place, 0.0, of[first], 1.0, of[first + AOI_NODES + 1]);
}

double aoi_row_stuck(const double *of, double place)
{
    const double *change = of + AOI_TRACK_CHANGES;
    double low = 0.0, from = of[AOI_TRACK_STUCK];
    int slips = of[AOI_TRACK_SLIPS] != 0.0;
    size_t i = 0;
    for (; i < AOI_SLIP_CHANGES && change[i] <= place; i++) {
        slips = !slips;
        low = change[i];
        from = NAN; /* when slip ends, all springs stick at once */
    }
    if (slips) {
        return 0.0;
    }
    const int ends = i < AOI_SLIP_CHANGES && change[i] < 1.0;
    return interpolated(of, AOI_TRACK_STUCK, place, low, from, ends ? change[i] : 1.0,
                        ends ? 0.0 : of[AOI_TRACK_STUCK + AOI_NODES + 1]);
}
