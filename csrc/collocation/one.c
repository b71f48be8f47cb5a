/* A step with one contact, the most common case: the equations of many.c with matrices of constant size, stored by
 * columns. */
#include "collocation/collocation.h"
#include "collocation/newton.h"
#include "law/law.h"
#include "motion/radau.h"
#include "motion/response.h"
#include "motion/nodes.h"

#include <math.h>

enum { SQUARE = AOI_NODES * AOI_NODES };

/* Matrices of the contact: influences of the force at node q on indentation and rate at node i, and the inverse of
 * Newton's matrix. Element (i, q) has the index q * AOI_NODES + i. */
typedef struct single {
    int with_rates;
    double displacement[SQUARE], rate[SQUARE], inverse[SQUARE];
} single;

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
    aoi_newton_add_residual(residual, h, of->displacement, of->with_rates ? of->rate : NULL);
}

int aoi_collocation_solve_one(const aoi_system *system, const aoi_response *response, double h,
                              aoi_contact_step *entry)
{
    aoi_newton newton = aoi_newton_begin(1, entry);
    double change;
    single of;
    couple(system, response, h, entry, &of);
    do {
        const int first = newton.iteration == 0;
        double by[AOI_NODES], answer[AOI_NODES], rate_answer[AOI_NODES];
        aoi_law_values values;
        (void)aoi_newton_law(system, &newton, entry, of.with_rates, &values);
        if (newton.renew) {
            aoi_newton_invert(entry->edge, values.stiffness, values.damping, of.displacement, of.with_rates ? of.rate : NULL,
                              of.inverse);
        }
        aoi_nodes_multiply(of.inverse, values.force, by);
        aoi_nodes_multiply(of.displacement, by, answer);
        if (of.with_rates) {
            aoi_nodes_multiply(of.rate, by, rate_answer);
        }
        change = aoi_newton_take(entry, first, by, answer, of.with_rates ? rate_answer : NULL, 0.0);
        if (aoi_newton_done(&newton, change)) {
            return AOI_OK;
        }
    } while (aoi_newton_goes_on(&newton, change));
    return AOI_ERROR_NO_CONVERGENCE;
}
