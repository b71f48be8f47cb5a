/* Contacts with friction in the rows of a track. */
#include "adaptive/row.h"
#include "collocation/collocation.h"
#include "motion/nodes.h"
#include "motion/polynomial.h"
#include "motion/radau.h"

#include <math.h>
#include <string.h>

static const double *tangent_of(const double *of, size_t i)
{
    return of + AOI_TRACK_TANGENTS + i * AOI_TRACK_TANGENT_SIZE;
}

/* A polynomial through its values at the nodes. */
static double at_place(const double *nodes, double place)
{
    double legendre[AOI_NODES], slope;
    for (size_t k = 0; k < AOI_NODES; k++) {
        legendre[k] = aoi_nodes_dot(aoi_radau_to_legendre[k], nodes);
    }
    return aoi_legendre_evaluate(AOI_NODES, legendre, place, &slope);
}

/* Friction by its ratio to the normal force, which is the law's: at an edge forces are no polynomials, and where all
 * springs slip the ratio is Coulomb's. What a polynomial of the ratio has beyond that is its error. The compliance that
 * is taken out acts as one of the normal force alone. */
void aoi_row_rub(const aoi_contact *contact, const double *of, double place, double force[3], double *bent)
{
    const double *coupled = contact->compliance;
    const int at_start = of[AOI_TRACK_EDGE] == AOI_EDGE_NONE && !(place > 0.0) && of[AOI_TRACK_START_FORCE] > 0.0;
    double share[2], slope;
    const double bodies = aoi_legendre_evaluate(AOI_NODES + 1, of + AOI_TRACK_INDENTATION, place, &slope);
    aoi_law law = *contact->law;
    aoi_law_value value;
    for (size_t i = 0; i < 2; i++) {
        const double *tangent = tangent_of(of, i);
        share[i] = at_start ? tangent[AOI_TRACK_TANGENT_START] / of[AOI_TRACK_START_FORCE]
                            : at_place(tangent + AOI_TRACK_TANGENT_SHARE, place);
    }
    const double size = hypot(share[0], share[1]), most = contact->friction->mu;
    for (size_t i = 0; i < 2; i++) {
        share[i] *= size > most ? most / size : 1.0;
        law.compliance += coupled ? coupled[1 + i] * share[i] : 0.0;
    }
    aoi_law_force(&law, NULL, (int)of[AOI_TRACK_PIECE], bodies, 0.0, &value);
    force[0] = fmax(value.force, 0.0);
    force[1] = share[0] * force[0];
    force[2] = share[1] * force[0];
    *bent = law.compliance * force[0];
}

void aoi_row_forces(const aoi_contact *contact, const double *of, double place, double force[3][AOI_NODES])
{
    const enum aoi_edge edge = (enum aoi_edge)of[AOI_TRACK_EDGE];
    const double *whole[3] = {of + AOI_TRACK_FORCE, tangent_of(of, 0) + AOI_TRACK_TANGENT_FORCE,
                              tangent_of(of, 1) + AOI_TRACK_TANGENT_FORCE};
    for (size_t k = 0; k < AOI_NODES && place < 1.0 && edge != AOI_EDGE_NONE; k++) {
        double here[3], bent;
        aoi_row_rub(contact, of, place * aoi_radau_edge_point[edge][k], here, &bent);
        for (size_t i = 0; i < 3; i++) {
            force[i][k] = here[i];
        }
    }
    for (size_t i = 0; i < 3; i++) {
        if (!(place < 1.0)) {
            memcpy(force[i], whole[i], sizeof force[i]);
        } else if (edge != AOI_EDGE_NONE) {
            aoi_edge_project(edge, force[i], force[i]);
        } else {
            for (size_t k = 0; k < AOI_NODES; k++) {
                force[i][k] = at_place(whole[i], place * aoi_radau_node[k]);
            }
        }
    }
}

double aoi_row_slide_work(const aoi_contact *contact, const double *of, double place)
{
    double force[3][AOI_NODES], normal[AOI_NODES], work = 0.0, slope;
    aoi_row_forces(contact, of, place, force);
    for (size_t k = 0; k < AOI_NODES; k++) {
        normal[k] = aoi_nodes_dot(aoi_radau_to_legendre[k], force[0]); /* on the part */
    }
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

/* Linear between values before, at the nodes or the points of an edge, and at the end, but from what is given at low and at
 * high (NaN: as after it and before it). */
static double interpolated(const double *of, int first, double place, double low, double from, double high, double to)
{
    const enum aoi_edge edge = (enum aoi_edge)of[AOI_TRACK_EDGE];
    const double *points = edge == AOI_EDGE_NONE ? aoi_radau_node : aoi_radau_edge_point[edge];
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
        from = NAN; /* all that slips sticks at once */
    }
    if (slips) {
        return 0.0;
    }
    const int ends = i < AOI_SLIP_CHANGES && change[i] < 1.0;
    return interpolated(of, AOI_TRACK_STUCK, place, low, from, ends ? change[i] : 1.0,
                        ends ? 0.0 : of[AOI_TRACK_STUCK + AOI_NODES + 1]);
}
