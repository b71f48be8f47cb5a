/* A step with one contact, the most common case: the equations of many.c, of constant size, and by columns. */
#include "collocation/collocation.h"
#include "collocation/newton.h"
#include "law/law.h"
#include "motion/radau.h"
#include "motion/response.h"
#include "motion/nodes.h"

#include <math.h>

enum { SQUARE = AOI_NODES * AOI_NODES };

/* Influence of a force at node q on indentation and rate at node i, at q * AOI_NODES + i; and the inverse of Newton's
 * matrix, likewise. */
typedef struct single {
    int with_rates;
    double displacement[SQUARE], rate[SQUARE], inverse[SQUARE];
} single;

/* Adds the residual compliance of the two bodies to the influences. */
static void add_residual(double residual, double h, single *of)
{
    for (size_t q = 0; q < AOI_NODES && residual != 0.0; q++) {
        of->displacement[q * AOI_NODES + q] += residual;
        if (of->with_rates) {
            aoi_nodes_add(residual / h, aoi_radau_slope_at_node[q + 1], of->rate + q * AOI_NODES);
        }
    }
}

static void couple(const aoi_system *system, const aoi_response *response, double h,
                   const aoi_contact_step *entry, single *of)
{
    const aoi_contact *contact = &system->contact[entry->contact];
    const aoi_response *answer[2];
    size_t at[2];
    double residual = 0.0;
    of->with_rates = aoi_collocation_wants_rates(system, 1, entry);
    for (int side = 0; side < 2; side++) {
        const aoi_modes *body = &system->body[contact->body[side]];
        answer[side] = &response[contact->body[side]];
        at[side] = aoi_response_at(answer[side], contact->port[side], contact->port[side]);
        residual += body->residual ? body->residual[contact->port[side] * (body->ports + 1)] : 0.0;
    }
    const double *one = answer[0]->influence + at[0];
    const double *other = answer[1]->influence + at[1];
    for (size_t k = 0; k < SQUARE; k++) {
        of->displacement[k] = one[k] + other[k];
    }
    one = answer[0]->influence_rate + at[0];
    other = answer[1]->influence_rate + at[1];
    for (size_t k = 0; k < SQUARE && of->with_rates; k++) {
        of->rate[k] = one[k] + other[k];
    }
    add_residual(residual, h, of);
}

/* The inverse of 1 + stiffness A + damping B. */
static void renew(const aoi_contact_step *entry, const aoi_law_values *law, single *of)
{
    for (size_t q = 0; q < AOI_NODES; q++) {
        const size_t at = q * AOI_NODES;
        double by_rate[AOI_NODES];
        aoi_collocation_weigh(entry->edge, law->stiffness, of->displacement + at, of->inverse + at);
        if (of->with_rates) {
            aoi_collocation_weigh(entry->edge, law->damping, of->rate + at, by_rate);
            aoi_nodes_add(1.0, by_rate, of->inverse + at);
        }
        of->inverse[at + q] += 1.0;
    }
    aoi_nodes_invert(of->inverse); /* pivots as in many.c; the inverse has columns likewise */
}

/* From a change of the forces (the first: from the constant one) to that of indentation and rate. Returns the
 * largest relative to scale. */
static double move(const single *of, const double *by, int first, aoi_contact_step *entry)
{
    const double inverse = 1.0 / entry->scale;
    double answer[AOI_NODES], largest = 0.0;
    aoi_nodes_multiply(of->displacement, by, answer);
    for (size_t i = 0; i < AOI_NODES; i++) {
        const double next = (first ? entry->homogeneous[i] : entry->indentation[i]) - answer[i];
        const double change = fabs(next - entry->indentation[i]) * inverse;
        largest = change <= largest ? largest : change; /* NaN, too, is large */
        entry->indentation[i] = next;
        entry->force[i] = (first ? entry->constant : entry->force[i]) + by[i];
    }
    if (of->with_rates) {
        aoi_nodes_multiply(of->rate, by, answer);
        for (size_t i = 0; i < AOI_NODES; i++) {
            entry->rate[i] = (first ? entry->homogeneous_rate[i] : entry->rate[i]) - answer[i];
        }
    }
    return largest;
}

int aoi_collocation_solve_one(const aoi_system *system, const aoi_response *response, double h,
                              aoi_contact_step *entry)
{
    const aoi_law *law = system->contact[entry->contact].law;
    aoi_newton newton = aoi_newton_begin();
    double change;
    single of;
    couple(system, response, h, entry, &of);
    do {
        const int first = newton.iteration == 0;
        double by[AOI_NODES];
        aoi_law_values values;
        aoi_collocation_evaluate(law, entry, of.with_rates, &values);
        if (newton.renew) {
            renew(entry, &values, &of);
        }
        aoi_collocation_aim(entry, first, of.with_rates, &values);
        aoi_nodes_multiply(of.inverse, values.force, by);
        change = move(&of, by, first, entry);
        if (aoi_newton_done(&newton, change)) {
            return AOI_OK;
        }
    } while (aoi_newton_goes_on(&newton, change));
    return AOI_ERROR_NO_CONVERGENCE;
}
