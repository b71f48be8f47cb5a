/* Response of a linear body over one step to forces that are polynomials in time. It is exact, so
 * that a stiff oscillator that is not excited needs no short step. */
#include "motion/lanes.h"
#include "motion/modes.h"
#include "motion/polynomial.h"
#include "motion/radau.h"
#include "motion/response.h"
#include "motion/nodes.h"
#include "linear/vector.h"
#include "linear/work.h"
#include "law/law.h"

#include <float.h>
#include <math.h>
#include <string.h>

enum { SQUARE = AOI_NODES * AOI_NODES, OF_PAIR = AOI_RADAU_MOMENTS + 2 * AOI_NODES };

/* Phase angle of a mode up to a node, rad, up to which the modes' sines are summed as power series, all modes
 * together; for larger angles Bessel functions are used. */
static const double SERIES_LIMIT = 3.0;

/* A term of the series that is smaller than this, relative to the first term, is left out with all later ones. */
static const double NOTHING = 1e-18;

static size_t pairs_for(const aoi_modes *body, size_t columns)
{
    return columns == AOI_BY_MODES ? body->n : aoi_times(body->ports, columns);
}

size_t aoi_response_size(const aoi_modes *body, size_t columns)
{
    const size_t pairs = aoi_times(pairs_for(body, columns), 2 * SQUARE + OF_PAIR);
    return aoi_plus(aoi_plus(aoi_times(6 * AOI_NODES, body->n), pairs), aoi_times(body->ports, AOI_NODES));
}

/* Returns the number of pairs for which influences are computed. A pair is a port, which gives the shapes of the
 * modes, and a column, which gives their pushes; with AOI_BY_MODES it is a mode with itself. */
static size_t pairs_of(const aoi_response *response, const aoi_modes *body)
{
    return pairs_for(body, response->columns.count);
}

static const double OF_MODE[AOI_LANES][AOI_LANES] = {
    {1.0, 0.0, 0.0, 0.0}, {0.0, 1.0, 0.0, 0.0}, {0.0, 0.0, 1.0, 0.0}, {0.0, 0.0, 0.0, 1.0}};

static const double *shape_of(const aoi_response *response, const aoi_modes *body, size_t pair, size_t j)
{
    const size_t columns = response->columns.count;
    return columns == AOI_BY_MODES ? OF_MODE[pair - j] : body->shape + pair / columns * body->n + j;
}

static const double *push_of(const aoi_response *response, const aoi_modes *body, size_t pair, size_t j)
{
    const size_t columns = response->columns.count;
    if (columns == AOI_BY_MODES) {
        return OF_MODE[pair - j];
    }
    const size_t column = pair % columns;
    return body->push + (response->columns.port ? response->columns.port[column] : column) * body->n + j;
}

/* first_pair, last_pair: range of the pairs to which modes j .. j + 3 contribute; last_pair is not included. */
static size_t first_pair(const aoi_response *response, size_t j)
{
    return response->columns.count == AOI_BY_MODES ? j : 0;
}

static size_t last_pair(const aoi_response *response, const aoi_modes *body, size_t j)
{
    return response->columns.count == AOI_BY_MODES ? j + aoi_lanes_count(body, j) : pairs_of(response, body);
}

static double decay_of(const aoi_modes *body, size_t j)
{
    return body->decay ? body->decay[j] : 0.0;
}

/* True if the power series is used for a mode up to a node. It is more accurate there than Bessel functions. */
static int is_slow(const aoi_modes *body, size_t j, double h, size_t node)
{
    return body->omega[j] * (h * aoi_radau_node[node]) <= SERIES_LIMIT && decay_of(body, j) == 0.0;
}

/* Adds the powers of -z^2 of four modes, times their weights, to the moments, up to the term of the series that is
 * negligible even for the largest angle. Returns the number of powers. */
static size_t add_powers(const double *weight, const double *square, double largest, double *moments)
{
    double power[AOI_LANES], reached = 1.0;
    size_t m = 0;
    memcpy(power, weight, sizeof power);
    for (; m < AOI_RADAU_MOMENTS && reached * aoi_radau_series[2 * m][0] > NOTHING; m++) {
        moments[m] += aoi_lanes_sum(power);
        for (size_t i = 0; i < AOI_LANES; i++) {
            power[i] *= -square[i];
        }
        reached *= largest;
    }
    return m;
}

/* Adds to the moments of all pairs the modes among j .. j + 3 that are slow up to node i, but not up to the next
 * node. Nodes are taken from the last to the first, so that moments only grow. Returns the number of moments. */
static size_t add_slow(const aoi_response *response, const aoi_modes *body, size_t j, size_t i)
{
    const double h = response->h, node = aoi_radau_node[i];
    double square[AOI_LANES] = {0.0}, largest = 0.0;
    int joins[AOI_LANES] = {0}, any = 0;
    for (size_t lane = 0; lane < aoi_lanes_count(body, j); lane++) {
        joins[lane] = is_slow(body, j + lane, h, i) &&
                      (i + 1 == AOI_NODES || !is_slow(body, j + lane, h, i + 1));
        if (joins[lane]) {
            const double z = body->omega[j + lane] * h;
            square[lane] = z * z;
            largest = fmax(largest, z * node * (z * node));
            any = 1;
        }
    }
    size_t used = 0;
    for (size_t pair = first_pair(response, j), last = last_pair(response, body, j); any && pair < last; pair++) {
        const double *shape = shape_of(response, body, pair, j), *push = push_of(response, body, pair, j);
        double weight[AOI_LANES] = {0.0};
        for (size_t lane = 0; lane < AOI_LANES; lane++) {
            if (joins[lane]) {
                weight[lane] = shape[lane] * push[lane];
            }
        }
        used = add_powers(weight, square, largest, response->scratch + pair * OF_PAIR);
    }
    return used;
}

/* Adds the modes among j .. j + 3 that are fast up to node i to the integrals against Legendre polynomials on the
 * part of the step up to that node. */
static void add_fast(const aoi_response *response, const aoi_modes *body, size_t j, size_t i,
                     const aoi_integrals *of)
{
    const double h = response->h, part = h * aoi_radau_node[i];
    for (size_t pair = first_pair(response, j), last = last_pair(response, body, j); pair < last; pair++) {
        const double *shape = shape_of(response, body, pair, j), *push = push_of(response, body, pair, j);
        double *sums = response->scratch + pair * OF_PAIR + AOI_RADAU_MOMENTS;
        double weight[AOI_LANES] = {0.0};
        for (size_t lane = 0; lane < aoi_lanes_count(body, j); lane++) {
            weight[lane] = is_slow(body, j + lane, h, i)
                               ? 0.0
                               : part * shape[lane] * push[lane];
        }
        for (size_t l = 0; l < AOI_NODES; l++) {
            double impulse[AOI_LANES], rate[AOI_LANES];
            for (size_t lane = 0; lane < AOI_LANES; lane++) {
                impulse[lane] = weight[lane] * of->impulse[l][lane];
                rate[lane] = weight[lane] * of->rate[l][lane];
            }
            sums[l] += aoi_lanes_sum(impulse);
            sums[AOI_NODES + l] += aoi_lanes_sum(rate);
        }
    }
}

/* Adds the slow modes to the integrals up to node i, by their moments. With z = omega h and c the node, the sum is
 *   sum_m (-z^2)^m h^2 c^(2m+2) int_0^1 (1-t)^(2m+1)/(2m+1)! P_l(t) dt,
 * and for the rates, with h c^(2m+1) and (1-t)^(2m)/(2m)! instead. */
static void add_series(const aoi_response *response, const double *moments, size_t used, size_t i, double *sums)
{
    const double part = response->h * aoi_radau_node[i], square = aoi_radau_node[i] * aoi_radau_node[i];
    double scale = part;
    for (size_t m = 0; m < used; m++, scale *= square) {
        const double of = scale * moments[m];
        aoi_nodes_add(of * part, aoi_radau_series[2 * m + 1], sums);
        if (response->has_rates) {
            aoi_nodes_add(of, aoi_radau_series[2 * m], sums + AOI_NODES);
        }
    }
}

/* Converts the integrals against the first Legendre polynomials, up to node i, to row i of an influence, which is
 * stored by columns. */
static inline void put_row(const double *sums, size_t count, size_t i, double *influence)
{
    double row[AOI_NODES] = {0.0};
    for (size_t l = 0; l < count; l++) {
        aoi_nodes_add(sums[l], aoi_radau_on_part[i][l], row);
    }
    for (size_t k = 0; k < AOI_NODES; k++) {
        influence[k * AOI_NODES + i] = row[k];
    }
}

/* True if a body is a single free mass, the most common body, whose response is the cheapest. */
static int is_free_mass(const aoi_modes *body)
{
    return body->n == 1 && body->omega[0] == 0.0 && decay_of(body, 0) == 0.0;
}

/* Fills the tables of a free mass with double integrals of the force: int_0^1 (1-t) P_l(t) dt = 1/2, -1/6, 0, 0,
 * ... */
static void free_mass(aoi_response *response, const aoi_modes *body)
{
    const double h = response->h;
    for (size_t i = 0; i < AOI_NODES; i++) {
        const double time = h * aoi_radau_node[i];
        response->impulse[i] = time;
        response->rate[i] = 1.0;
        response->step[i] = 0.5 * time * time;
        response->ramp[i] = time * time * time / 6.0;
        response->to_v[i] = h * aoi_radau_on_part[AOI_NODES - 1][0][i];
        response->to_x[i] = 0.5 * h * response->to_v[i] - h * h / 6.0 * aoi_radau_on_part[AOI_NODES - 1][1][i];
        for (size_t pair = 0; pair < pairs_of(response, body); pair++) {
            const double weight = *shape_of(response, body, pair, 0) * *push_of(response, body, pair, 0);
            const double once = weight * time, twice[2] = {0.5 * once * time, -once * time / 6.0};
            put_row(twice, 2, i, response->influence + pair * SQUARE);
            if (response->has_rates) {
                put_row(&once, 1, i, response->influence_rate + pair * SQUARE);
            }
        }
    }
}

/* Stores the motion of modes j .. j + 3 up to node i in the tables. */
static void put_motions(aoi_response *response, const aoi_modes *body, size_t j, size_t i,
                        const aoi_motions *of)
{
    for (size_t lane = 0; lane < aoi_lanes_count(body, j); lane++) {
        const size_t at = (j + lane) * AOI_NODES + i;
        response->impulse[at] = of->impulse[lane];
        response->rate[at] = of->rate[lane];
        response->step[at] = of->step[lane];
        response->ramp[at] = body->load.count > 0 ? of->ramp[lane] : 0.0;
    }
}

/* Stores the effect of forces on modes j .. j + 3 over the whole step, whose end is the last node. */
static void put_integrals(aoi_response *response, const aoi_modes *body, size_t j,
                          const aoi_integrals *of)
{
    for (size_t lane = 0; lane < aoi_lanes_count(body, j); lane++) {
        double impulse[AOI_NODES], rate[AOI_NODES];
        for (size_t q = 0; q < AOI_NODES; q++) {
            impulse[q] = response->h * of->impulse[q][lane];
            rate[q] = response->h * of->rate[q][lane];
        }
        const size_t at = (j + lane) * AOI_NODES;
        aoi_nodes_multiply(&aoi_radau_to_legendre[0][0], impulse, response->to_x + at);
        aoi_nodes_multiply(&aoi_radau_to_legendre[0][0], rate, response->to_v + at);
    }
}

/* Fills the tables and the integrals of all modes at node i. used: raised to the number of moments that the slow
 * modes need. */
static void modes_at_node(aoi_response *response, const aoi_modes *body, size_t i, size_t *used)
{
    const double h = response->h;
    for (size_t j = 0; j < body->n; j += AOI_LANES) {
        int fast = 0;
        aoi_motions motions;
        aoi_integrals integrals;
        for (size_t lane = 0; lane < aoi_lanes_count(body, j); lane++) {
            fast = fast || !is_slow(body, j + lane, h, i);
        }
        const int is_end = i == AOI_NODES - 1, integrate = fast || is_end;
        aoi_lanes_of(body, j, h * aoi_radau_node[i], &motions, integrate ? &integrals : NULL);
        put_motions(response, body, j, i, &motions);
        if (is_end) {
            put_integrals(response, body, j, &integrals);
        }
        if (fast) {
            add_fast(response, body, j, i, &integrals);
        }
        const size_t reached = add_slow(response, body, j, i);
        *used = reached > *used ? reached : *used;
    }
}

/* Fills the tables of the modes, and the influence of the forces at all nodes on each node. */
static void fill(aoi_response *response, const aoi_modes *body)
{
    const size_t pairs = pairs_of(response, body);
    size_t used = 0;
    memset(response->scratch, 0, pairs * OF_PAIR * sizeof(double));
    for (size_t i = AOI_NODES; i-- > 0;) {
        modes_at_node(response, body, i, &used);
        for (size_t pair = 0; pair < pairs; pair++) {
            double *moments = response->scratch + pair * OF_PAIR, *sums = moments + AOI_RADAU_MOMENTS;
            add_series(response, moments, used, i, sums);
            put_row(sums, AOI_NODES, i, response->influence + pair * SQUARE);
            if (response->has_rates) {
                put_row(sums + AOI_NODES, AOI_NODES, i, response->influence_rate + pair * SQUARE);
            }
            memset(sums, 0, 2 * AOI_NODES * sizeof *sums);
        }
    }
}

void aoi_response_make(aoi_response *response, const aoi_modes *body, const aoi_columns *columns, double h,
                       int with_rates, double *block)
{
    response->columns = columns ? *columns : (aoi_columns){body->ports, NULL, NULL};
    const size_t size = AOI_NODES * body->n, pairs = pairs_of(response, body);
    response->h = h;
    response->has_rates = with_rates;
    double **of_modes[] = {&response->impulse, &response->rate, &response->step,
                           &response->ramp,    &response->to_x, &response->to_v};
    for (size_t i = 0; i < sizeof of_modes / sizeof *of_modes; i++, block += size) {
        *of_modes[i] = block;
    }
    response->influence = block;
    response->influence_rate = response->influence + pairs * SQUARE;
    response->scratch = response->influence_rate + pairs * SQUARE;
    response->impulse_response = response->scratch + pairs * OF_PAIR;
    if (is_free_mass(body)) {
        free_mass(response, body);
    } else {
        fill(response, body);
    }
    for (size_t k = 0; k < body->ports * AOI_NODES; k++) {
        const size_t p = k / AOI_NODES * body->n, i = k % AOI_NODES;
        response->impulse_response[k] = 0.0;
        for (size_t j = 0; j < body->n; j++) {
            response->impulse_response[k] +=
                body->shape[p + j] * body->push[p + j] * response->impulse[j * AOI_NODES + i];
        }
    }
}

/* Adds sign times the deflection (and its rate) of the residual compliance due to the change of the loads since
 * the start of the step. */
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
                              double sign, double time, const double *x, const double *v, const double *force,
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
        for (size_t p = 0; force && p < body->ports; p++) {
            load += body->push[p * n + j] * force[p];
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

void aoi_response_carry(const aoi_modes *body, double from, double h, const double *force,
                        double place, double *x, double *v)
{
    const double time = place * h;
    for (size_t p = 0; p < body->ports; p++) {
        double part[AOI_NODES], legendre[AOI_NODES];
        aoi_nodes_on_part(force + p * AOI_NODES, place, part);
        aoi_nodes_to_legendre(part, legendre);
        for (size_t first = 0; first < body->n; first += AOI_LANES) {
            double by_impulse[AOI_LANES] = {0.0}, by_rate[AOI_LANES] = {0.0};
            aoi_motions motions;
            aoi_integrals of;
            aoi_lanes_of(body, first, time, &motions, &of);
            if (p == 0) {
                aoi_modes_move(body, first, from, &motions, x, v);
            }
            for (size_t l = 0; l < AOI_NODES; l++) {
                for (size_t lane = 0; lane < AOI_LANES; lane++) {
                    by_impulse[lane] += of.impulse[l][lane] * legendre[l];
                    by_rate[lane] += of.rate[l][lane] * legendre[l];
                }
            }
            for (size_t lane = 0; lane < aoi_lanes_count(body, first); lane++) {
                const double push = time * body->push[p * body->n + first + lane];
                x[first + lane] += push * by_impulse[lane];
                v[first + lane] += push * by_rate[lane];
            }
        }
    }
}
