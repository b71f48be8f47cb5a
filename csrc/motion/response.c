/* What a linear body does over one step under forces that are polynomials in time. Nothing linear is
 * discretised, so a stiff oscillator that nobody excites asks for no short step. */
#include "motion/modes.h"
#include "motion/oscillator.h"
#include "motion/polynomial.h"
#include "motion/radau.h"
#include "motion/response.h"
#include "motion/nodes.h"
#include "linear/vector.h"
#include "law/law.h"

#include <float.h>
#include <math.h>

enum { SQUARE = AOI_NODES * AOI_NODES, OF_PAIR = AOI_RADAU_MOMENTS + 2 * AOI_NODES };

/* Below this, sin is summed by its series, over all modes at once; above, by Bessel functions. */
static const double SERIES_LIMIT = 3.0;

/* Powers of a mode below this share of its weight add nothing. */
static const double NOTHING = 1e-40;

size_t aoi_response_size(const aoi_modes *body)
{
    const size_t pairs = body->ports * body->ports;
    return 6 * AOI_NODES * body->n + pairs * (2 * SQUARE + OF_PAIR) + body->ports * AOI_NODES;
}

static double decay_of(const aoi_modes *body, size_t j)
{
    return body->decay ? body->decay[j] : 0.0;
}

/* Mode j in the sums of node i: powers of -z^2, or integrals against Legendre polynomials on the part
 * of the step up to the node. Returns how many moments it reaches. */
static size_t add_mode(const aoi_modes *body, size_t j, double h, size_t i, double *scratch)
{
    const double z = body->omega[j] * h, part = h * aoi_radau_node[i];
    const size_t pairs = body->ports * body->ports;
    if (body->omega[j] * part <= SERIES_LIMIT && decay_of(body, j) == 0.0) {
        double power = 1.0;
        size_t m = 0;
        for (; m < AOI_RADAU_MOMENTS && fabs(power) > NOTHING; m++) {
            for (size_t pair = 0; pair < pairs; pair++) {
                const size_t p = pair / body->ports, q = pair % body->ports;
                scratch[pair * OF_PAIR + m] +=
                    power * body->shape[p * body->n + j] * body->push[q * body->n + j];
            }
            power *= -z * z;
        }
        return m;
    }
    double impulse[AOI_NODES], rate[AOI_NODES];
    aoi_oscillator_integrals(body->omega[j], decay_of(body, j), part, AOI_NODES, impulse, rate);
    for (size_t pair = 0; pair < pairs; pair++) {
        const size_t p = pair / body->ports, q = pair % body->ports;
        const double weight =
            part * body->shape[p * body->n + j] * body->push[q * body->n + j];
        double *of_pair = scratch + pair * OF_PAIR + AOI_RADAU_MOMENTS;
        for (size_t l = 0; l < AOI_NODES; l++) {
            of_pair[l] += weight * impulse[l];
            of_pair[AOI_NODES + l] += weight * rate[l];
        }
    }
    return 0;
}

/* From the sums of node i to row i of the influence of one pair of ports. */
static void influence_row(const double *moments, size_t used, const double *by_legendre, double scale,
                          const double moment[AOI_RADAU_MOMENTS][AOI_NODES][AOI_NODES], size_t i,
                          int has_fast, double *row)
{
    double sum[AOI_NODES] = {0.0};
    for (size_t m = 0; m < used; m++) {
        aoi_nodes_add(moments[m], moment[m][i], sum);
    }
    for (size_t k = 0; k < AOI_NODES; k++) {
        row[k] = sum[k] * scale;
    }
    for (size_t q = 0; q < AOI_NODES && has_fast; q++) {
        double on_whole = 0.0;
        for (size_t l = 0; l <= q; l++) {
            on_whole += aoi_radau_shrink[i][q][l] * by_legendre[l];
        }
        aoi_nodes_add(on_whole, aoi_radau_to_legendre[q], row);
    }
}

/* One mass that nothing holds: the most common body, and the cheapest. */
static int is_free_mass(const aoi_modes *body)
{
    return body->n == 1 && body->omega[0] == 0.0 && decay_of(body, 0) == 0.0;
}

/* Row i of an influence, whose columns lie side by side in memory. */
static void put_row(const double *row, size_t i, double *influence)
{
    for (size_t k = 0; k < AOI_NODES; k++) {
        influence[k * AOI_NODES + i] = row[k];
    }
}

/* The influence of a free mass on all nodes: double integrals of the force. */
static void influence_of_mass(aoi_response *response, const aoi_modes *body)
{
    const double h = response->h;
    for (size_t pair = 0; pair < body->ports * body->ports; pair++) {
        const double weight = body->shape[pair / body->ports] * body->push[pair % body->ports];
        double *of = response->influence + pair * SQUARE;
        double *of_rate = response->influence_rate + pair * SQUARE;
        for (size_t k = 0; k < SQUARE; k++) {
            const size_t i = k % AOI_NODES, q = k / AOI_NODES;
            of[k] = h * h * weight * aoi_radau_moment[0][i][q];
            of_rate[k] = response->has_rates ? h * weight * aoi_radau_rate_moment[0][i][q] : 0.0;
        }
    }
}

static void influence_at_node(aoi_response *response, const aoi_modes *body, size_t i)
{
    const double h = response->h;
    const size_t pairs = body->ports * body->ports;
    size_t used = 0;
    int has_fast = 0;
    for (size_t k = 0; k < pairs * OF_PAIR; k++) {
        response->scratch[k] = 0.0;
    }
    for (size_t j = 0; j < body->n; j++) {
        const size_t reached = add_mode(body, j, h, i, response->scratch);
        used = reached > used ? reached : used;
        has_fast = has_fast || reached == 0;
    }
    for (size_t pair = 0; pair < pairs; pair++) {
        const double *sums = response->scratch + pair * OF_PAIR;
        const double *by_legendre = sums + AOI_RADAU_MOMENTS;
        double row[AOI_NODES];
        influence_row(sums, used, by_legendre, h * h, aoi_radau_moment, i, has_fast, row);
        put_row(row, i, response->influence + pair * SQUARE);
        if (response->has_rates) {
            influence_row(sums, used, by_legendre + AOI_NODES, h, aoi_radau_rate_moment, i, has_fast,
                          row);
            put_row(row, i, response->influence_rate + pair * SQUARE);
        }
    }
}

/* Column j of the tables: a mode's motion to the nodes, and what forces do to it. */
static void mode_tables(aoi_response *response, const aoi_modes *body, size_t j)
{
    const double h = response->h, omega = body->omega[j], decay = decay_of(body, j);
    double impulse[AOI_NODES], rate[AOI_NODES];
    const int is_free = omega == 0.0 && decay == 0.0;
    for (size_t i = 0; i < AOI_NODES; i++) {
        aoi_motion motion;
        aoi_oscillator_motion(omega, decay, h * aoi_radau_node[i], &motion);
        response->impulse[j * AOI_NODES + i] = motion.impulse;
        response->rate[j * AOI_NODES + i] = motion.rate;
        response->step[j * AOI_NODES + i] = motion.step;
        response->ramp[j * AOI_NODES + i] = motion.ramp;
    }
    for (size_t k = 0; k < AOI_NODES && is_free; k++) { /* the last node is the step's end */
        response->to_x[j * AOI_NODES + k] = h * h * aoi_radau_moment[0][AOI_NODES - 1][k];
        response->to_v[j * AOI_NODES + k] = h * aoi_radau_rate_moment[0][AOI_NODES - 1][k];
    }
    if (is_free) {
        return;
    }
    aoi_oscillator_integrals(omega, decay, h, AOI_NODES, impulse, rate);
    for (size_t q = 0; q < AOI_NODES; q++) {
        impulse[q] *= h;
        rate[q] *= h;
    }
    aoi_nodes_multiply(&aoi_radau_to_legendre[0][0], impulse, response->to_x + j * AOI_NODES);
    aoi_nodes_multiply(&aoi_radau_to_legendre[0][0], rate, response->to_v + j * AOI_NODES);
}

void aoi_response_make(aoi_response *response, const aoi_modes *body, double h, int with_rates,
                       double *block)
{
    const size_t size = AOI_NODES * body->n, pairs = body->ports * body->ports;
    response->h = h;
    response->has_rates = with_rates;
    response->impulse = block;
    response->rate = block + size;
    response->step = block + 2 * size;
    response->ramp = block + 3 * size;
    response->to_x = block + 4 * size;
    response->to_v = block + 5 * size;
    response->influence = block + 6 * size;
    response->influence_rate = response->influence + pairs * SQUARE;
    response->scratch = response->influence_rate + pairs * SQUARE;
    response->answer = response->scratch + pairs * OF_PAIR;
    if (is_free_mass(body)) {
        influence_of_mass(response, body);
    }
    for (size_t i = 0; i < AOI_NODES && !is_free_mass(body); i++) {
        influence_at_node(response, body, i);
    }
    for (size_t j = 0; j < body->n; j++) {
        mode_tables(response, body, j);
    }
    for (size_t k = 0; k < body->ports * AOI_NODES; k++) {
        const size_t p = k / AOI_NODES * body->n, i = k % AOI_NODES;
        response->answer[k] = 0.0;
        for (size_t j = 0; j < body->n; j++) {
            response->answer[k] +=
                body->shape[p + j] * body->push[p + j] * response->impulse[j * AOI_NODES + i];
        }
    }
}

/* The load's own share through the residual compliance. */
static void residual_share(const aoi_modes *body, size_t port, double sign, double time, double h,
                           double *displacement, double *rate)
{
    for (size_t q = 0; body->residual && body->load.count > 0 && q < body->ports; q++) {
        const double compliance = sign * body->residual[port * body->ports + q];
        double force, slope;
        aoi_modes_load(body, q, time, &force, &slope);
        for (size_t i = 0; i < AOI_NODES; i++) {
            displacement[i] += compliance * slope * h * aoi_radau_node[i];
            if (rate) {
                rate[i] += compliance * slope;
            }
        }
    }
}

void aoi_response_homogeneous(const aoi_response *response, const aoi_modes *body, size_t port,
                              double sign, double time, const double *x, const double *v,
                              double *displacement, double *rate)
{
    const size_t n = body->n;
    const double *shape = body->shape + port * n;
    const int driven = body->gravity || body->load.count > 0;
    for (size_t j = 0; j < n; j++) {
        const double omega = body->omega[j], share = sign * shape[j];
        double load = 0.0, slope = 0.0;
        if (driven) {
            aoi_modes_drive(body, j, time, &load, &slope);
        }
        const double pull = share * (load - omega * omega * x[j]), speed = share * v[j];
        slope *= share;
        const size_t at = j * AOI_NODES;
        aoi_nodes_add(pull, response->step + at, displacement);
        aoi_nodes_add(speed, response->impulse + at, displacement);
        if (slope != 0.0) {
            aoi_nodes_add(slope, response->ramp + at, displacement);
        }
        for (size_t i = 0; i < AOI_NODES && rate; i++) {
            rate[i] += pull * response->impulse[at + i] + speed * response->rate[at + i] +
                       slope * response->step[at + i];
        }
    }
    residual_share(body, port, sign, time, response->h, displacement, rate);
}

void aoi_response_propagate(const aoi_response *response, const aoi_modes *body, double time,
                            const double *force, double *x, double *v)
{
    const size_t n = body->n;
    const int driven = body->gravity || body->load.count > 0;
    for (size_t j = 0; j < n; j++) {
        const double omega = body->omega[j], v0 = v[j];
        double push = 0.0, kick = 0.0, load = 0.0, slope = 0.0;
        for (size_t p = 0; p < body->ports; p++) {
            const double *by = force + p * AOI_NODES, of = body->push[p * n + j];
            push += of * aoi_nodes_dot(response->to_x + j * AOI_NODES, by);
            kick += of * aoi_nodes_dot(response->to_v + j * AOI_NODES, by);
        }
        if (driven) {
            aoi_modes_drive(body, j, time, &load, &slope);
        }
        const double pull = load - omega * omega * x[j];
        const size_t end = j * AOI_NODES + AOI_NODES - 1;
        x[j] += v0 * response->impulse[end] + pull * response->step[end] +
                slope * response->ramp[end] + push;
        v[j] = v0 * response->rate[end] + pull * response->impulse[end] +
               slope * response->step[end] + kick;
    }
}

/* Legendre coefficients, on the part of a step up to place, of a polynomial given at its nodes. */
static void on_part(const double *force, double place, double *legendre)
{
    double whole[AOI_NODES], shrunk[AOI_NODES];
    for (size_t k = 0; k < AOI_NODES; k++) {
        whole[k] = aoi_vector_dot(AOI_NODES, aoi_radau_to_legendre[k], force);
    }
    for (size_t i = 0; i < AOI_NODES; i++) {
        double slope;
        shrunk[i] = aoi_legendre_evaluate(AOI_NODES, whole, place * aoi_radau_node[i], &slope);
    }
    for (size_t k = 0; k < AOI_NODES; k++) {
        legendre[k] = aoi_vector_dot(AOI_NODES, aoi_radau_to_legendre[k], shrunk);
    }
}

void aoi_response_push(const aoi_modes *body, double h, const double *force, double place, double *x,
                       double *v)
{
    const double length = place * h;
    for (size_t p = 0; p < body->ports; p++) {
        double legendre[AOI_NODES];
        on_part(force + p * AOI_NODES, place, legendre);
        for (size_t j = 0; j < body->n; j++) {
            double impulse[AOI_NODES], rate[AOI_NODES];
            const double push = length * body->push[p * body->n + j];
            aoi_oscillator_integrals(body->omega[j], decay_of(body, j), length, AOI_NODES, impulse,
                                     rate);
            x[j] += push * aoi_vector_dot(AOI_NODES, impulse, legendre);
            v[j] += push * aoi_vector_dot(AOI_NODES, rate, legendre);
        }
    }
}
