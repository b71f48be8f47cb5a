/* One step of contact: the forces as polynomials through the Radau nodes, their effect on the bodies
 * exact, Newton on their values, all contacts of the step together. */
#include "radau.h"

#include <float.h>
#include <math.h>

enum { MOST_ITERATIONS = 25, SQUARE = AOI_STAGES * AOI_STAGES };

/* Newton has converged at this change of the indentation relative to its scale, or at the second where
 * changes no longer shrink: rounding. */
static const double CONVERGED = 1e-15, ROUNDING = 1e-12;

/* Converging quadratically: the next change will be below rounding. */
static const double QUADRATIC = 0.01, NEXT_CHANGE = 1e-16;

/* aoi_vector_dot of a length that the compiler knows. */
static inline double dot_of_stages(const double *x, const double *y)
{
    double even = 0.0, odd = 0.0;
    for (size_t k = 0; k < AOI_STAGES; k += 2) {
        even += x[k] * y[k];
        odd += x[k + 1] * y[k + 1];
    }
    return even + odd;
}

/* Whether the rates are wanted: by a law, or to see them turn. */
static int wants_rates(const aoi_system *system, const aoi_stage *stage, size_t count)
{
    for (size_t s = 0; s < count; s++) {
        const aoi_law *law = system->joint[stage[s].joint].law;
        if (law->depends_on_rate || law->turns) {
            return 1;
        }
    }
    return 0;
}

/* Blocks of a row of contacts: those up to span away on either side. */
static size_t blocks_of(size_t count, size_t span)
{
    return count == 1 ? 1 : 2 * span + 1;
}

static size_t half_width(size_t count, size_t span)
{
    return count == 1 ? AOI_STAGES - 1 : AOI_STAGES * (span + 1) - 1;
}

size_t aoi_collocation_size(size_t count, size_t span)
{
    const size_t rows = count * AOI_STAGES, width = 2 * half_width(count, span) + 1;
    return 2 * count * blocks_of(count, span) * SQUARE + rows * width + rows;
}

/* Adds what contact t's force does to contact s (with a minus sign) by way of the bodies they share. */
static void add_coupling(const aoi_system *system, const aoi_response *response, double h, size_t s,
                         size_t t, double *displacement, double *rate)
{
    const aoi_joint *of = &system->joint[s], *by = &system->joint[t];
    for (int i = 0; i < 4; i++) {
        const int a = i / 2, c = i % 2;
        if (of->body[a] != by->body[c]) {
            continue;
        }
        const aoi_modes *body = &system->body[of->body[a]];
        const aoi_response *answer = &response[of->body[a]];
        const double sign = a == c ? 1.0 : -1.0;
        const size_t pair = of->port[a] * body->ports + by->port[c];
        const double residual = body->residual ? sign * body->residual[pair] : 0.0;
        for (size_t k = 0; k < SQUARE; k++) {
            displacement[k] += sign * answer->influence[pair * SQUARE + k];
            if (rate) {
                rate[k] += sign * answer->influence_rate[pair * SQUARE + k];
            }
        }
        for (size_t k = 0; k < AOI_STAGES && residual != 0.0; k++) {
            displacement[k * AOI_STAGES + k] += residual;
            for (size_t q = 0; q < AOI_STAGES && rate; q++) {
                rate[k * AOI_STAGES + q] += residual / h * aoi_radau_slope_at_node[k][q + 1];
            }
        }
    }
}

/* All couplings: block (s, t) at s * blocks + t + span - s. */
typedef struct couplings {
    size_t count, span, blocks;
    double *displacement, *rate;
} couplings;

static const double *block_of(const couplings *of, const double *values, size_t s, size_t t)
{
    return values + (s * of->blocks + (of->blocks == 1 ? 0 : t + of->span - s)) * SQUARE;
}

static size_t first_of(const couplings *of, size_t s) { return s > of->span ? s - of->span : 0; }

static size_t last_of(const couplings *of, size_t s)
{
    return s + of->span < of->count ? s + of->span : of->count - 1;
}

static void couple(const aoi_system *system, const aoi_response *response, double h,
                   const aoi_stage *stage, couplings *of)
{
    const size_t size = of->count * of->blocks * SQUARE;
    for (size_t k = 0; k < size; k++) {
        of->displacement[k] = 0.0;
    }
    for (size_t k = 0; of->rate && k < size; k++) {
        of->rate[k] = 0.0;
    }
    for (size_t s = 0; s < of->count; s++) {
        for (size_t t = first_of(of, s); t <= last_of(of, s); t++) {
            const size_t at = (size_t)(block_of(of, of->displacement, s, t) - of->displacement);
            add_coupling(system, response, h, stage[s].joint, stage[t].joint, of->displacement + at,
                         of->rate ? of->rate + at : NULL);
        }
    }
}

/* Gauss without pivoting within a band: I + influence diag(stiffness), with influence nearly a
 * Volterra operator, has pivots near or above one. Element (i, j) is matrix[i * stride + j]. */
static inline void eliminate(size_t n, size_t half, size_t stride, double *matrix,
                             double *right)
{
    for (size_t k = 0; k < n; k++) {
        const double inverse = 1.0 / matrix[k * stride + k];
        const size_t last = k + half < n ? k + half : n - 1;
        const double *pivot_row = matrix + k * stride;
        for (size_t i = k + 1; i <= last; i++) {
            double *row = matrix + i * stride;
            const double factor = row[k] * inverse;
            for (size_t q = k + 1; q <= last; q++) {
                row[q] -= factor * pivot_row[q];
            }
            right[i] -= factor * right[k];
        }
        matrix[k * stride + k] = inverse;
    }
    /* The newest entry last, and no division: each step waits for one product of the step before. */
    for (size_t k = n; k-- > 0;) {
        double sum = right[k];
        for (size_t q = k + half < n ? k + half : n - 1; q > k; q--) {
            sum -= matrix[k * stride + q] * right[q];
        }
        right[k] = sum * matrix[k * stride + k];
    }
}

/* Row (s, i) of Newton's equations for the forces:
 * F + stiffness (A F) + damping (B F) = f + stiffness (delta_h - delta) + damping (rate_h - rate). */
static double newton_row(const couplings *of, const aoi_stage *stage, size_t s, size_t i,
                         const aoi_law_value *value, double *row)
{
    const aoi_stage *here = &stage[s];
    for (size_t t = first_of(of, s); t <= last_of(of, s); t++) {
        const double *a = block_of(of, of->displacement, s, t) + i * AOI_STAGES;
        for (size_t k = 0; k < AOI_STAGES; k++) {
            row[t * AOI_STAGES + k] = value->stiffness * a[k];
        }
        if (of->rate) {
            const double *b = block_of(of, of->rate, s, t) + i * AOI_STAGES;
            for (size_t k = 0; k < AOI_STAGES; k++) {
                row[t * AOI_STAGES + k] += value->damping * b[k];
            }
        }
    }
    row[s * AOI_STAGES + i] += 1.0;
    double right = value->force + value->stiffness * (here->homogeneous[i] - here->indentation[i]);
    if (of->rate) {
        right += value->damping * (here->homogeneous_rate[i] - here->rate[i]);
    }
    return right;
}

/* From the forces (in right) to indentations and rates; the largest change relative to scale. */
static double update(const couplings *of, const double *right, aoi_stage *stage)
{
    double largest = 0.0;
    for (size_t s = 0; s < of->count; s++) {
        for (size_t i = 0; i < AOI_STAGES; i++) {
            double indentation = 0.0, rate = 0.0;
            for (size_t t = first_of(of, s); t <= last_of(of, s); t++) {
                const double *a = block_of(of, of->displacement, s, t) + i * AOI_STAGES;
                indentation += dot_of_stages(a, right + t * AOI_STAGES);
                if (of->rate) {
                    const double *b = block_of(of, of->rate, s, t) + i * AOI_STAGES;
                    rate += dot_of_stages(b, right + t * AOI_STAGES);
                }
            }
            const double next = stage[s].homogeneous[i] - indentation;
            const double change = fabs(next - stage[s].indentation[i]) / stage[s].scale;
            largest = change <= largest ? largest : change; /* NaN, too, is large */
            stage[s].indentation[i] = next;
            if (of->rate) {
                stage[s].rate[i] = stage[s].homogeneous_rate[i] - rate;
            }
        }
    }
    return largest;
}

static void law_at(const aoi_system *system, const aoi_stage *stage, size_t i, aoi_law_value *value)
{
    if (stage->piece == AOI_SLACK) {
        *value = (aoi_law_value){0.0, 0.0, 0.0};
        return;
    }
    const aoi_law *law = system->joint[stage->joint].law;
    aoi_law_force(law, stage->memory, stage->piece, stage->indentation[i], stage->rate[i], value);
}

static double newton(const aoi_system *system, const couplings *of, aoi_stage *stage, double *matrix,
                     double *right)
{
    const size_t n = of->count * AOI_STAGES, half = half_width(of->count, of->span);
    const size_t width = of->count == 1 ? AOI_STAGES : 2 * half + 1;
    double *origin = of->count == 1 ? matrix : matrix + half;
    const size_t stride = of->count == 1 ? AOI_STAGES : width - 1;
    for (size_t k = 0; of->count > 1 && k < n * width; k++) {
        matrix[k] = 0.0;
    }
    for (size_t s = 0; s < of->count; s++) {
        for (size_t i = 0; i < AOI_STAGES; i++) {
            const size_t row = s * AOI_STAGES + i;
            aoi_law_value value;
            law_at(system, &stage[s], i, &value);
            right[row] = newton_row(of, stage, s, i, &value, origin + row * stride);
        }
    }
    if (of->count == 1) { /* sizes that the compiler knows */
        eliminate(AOI_STAGES, AOI_STAGES - 1, AOI_STAGES, origin, right);
    } else {
        eliminate(n, half, stride, origin, right);
    }
    return update(of, right, stage);
}

int aoi_collocation_solve(const aoi_system *system, const aoi_response *response, double h,
                          size_t count, size_t span, aoi_stage *stage, double *work)
{
    const size_t blocks = blocks_of(count, span), size = count * blocks * SQUARE;
    const int with_rates = wants_rates(system, stage, count);
    couplings of = {count, count == 1 ? 0 : span, blocks, work, with_rates ? work + size : NULL};
    double *matrix = work + 2 * size;
    double *right = matrix + count * AOI_STAGES * (2 * half_width(count, span) + 1);
    double before = HUGE_VAL;
    couple(system, response, h, stage, &of);
    for (int i = 0; i < MOST_ITERATIONS; i++) {
        const double change = newton(system, &of, stage, matrix, right);
        if (!isfinite(change)) {
            return AOI_ERROR_NO_CONVERGENCE;
        }
        const double ratio = change / before;
        if (change <= CONVERGED || (change <= ROUNDING && ratio >= 0.5) ||
            (i > 0 && ratio < QUADRATIC && ratio * ratio * change <= NEXT_CHANGE)) {
            for (size_t k = 0; k < count * AOI_STAGES; k++) {
                aoi_law_value value;
                law_at(system, &stage[k / AOI_STAGES], k % AOI_STAGES, &value);
                stage[k / AOI_STAGES].force[k % AOI_STAGES] = value.force;
            }
            return AOI_OK;
        }
        before = change;
    }
    return AOI_ERROR_NO_CONVERGENCE;
}

/* The response at node i of both bodies' ports to a unit impulse on the contact. */
static double answer_at(const aoi_response *response, const aoi_joint *joint, size_t i)
{
    return response[joint->body[0]].answer[joint->port[0] * AOI_STAGES + i] +
           response[joint->body[1]].answer[joint->port[1] * AOI_STAGES + i];
}

void aoi_collocation_estimate(const aoi_system *system, const aoi_response *response, double h,
                              aoi_stage *stage, aoi_collocation_error *error)
{
    const aoi_joint *joint = &system->joint[stage->joint];
    const aoi_law *law = joint->law;
    double values[AOI_STAGES + 1] = {stage->start}, rates[AOI_STAGES + 1] = {stage->start_rate};
    *error = (aoi_collocation_error){0.0, 0.0, 0.0};
    for (size_t i = 0; i < AOI_STAGES; i++) {
        values[i + 1] = stage->indentation[i];
        rates[i + 1] = stage->rate[i];
    }
    for (size_t i = 0; i < AOI_STAGES && stage->piece != AOI_SLACK; i++) {
        aoi_law_value value;
        const double *at = aoi_radau_indentation_at_extra[i];
        const double rate = law->depends_on_rate ? aoi_vector_dot(AOI_STAGES + 1, at, rates) : 0.0;
        const double indentation =
            at[AOI_STAGES] * values[AOI_STAGES] + dot_of_stages(at, values);
        aoi_law_force(law, stage->memory, stage->piece, indentation, rate, &value);
        const double defect =
            value.force - dot_of_stages(aoi_radau_force_at_extra[i], stage->force);
        const double weighted = h * aoi_radau_extra_weight[i] * defect;
        error->impulse += weighted;
        error->indentation += answer_at(response, joint, i) * weighted;
    }
    aoi_legendre_fit(values, stage->legendre);
    const double *c = stage->legendre;
    const double last = fabs(c[AOI_STAGES]) + 0.2 * fabs(c[AOI_STAGES - 1]);
    const double before = fabs(c[AOI_STAGES - 2]) + 0.2 * fabs(c[AOI_STAGES - 3]);
    /* The terms left out go on falling as the last ones did. */
    error->tail = last < before ? last * sqrt(last / before) : last;
}

double aoi_collocation_impulse(const aoi_stage *stage, double h)
{
    return h * aoi_vector_dot(AOI_STAGES, aoi_radau_to_legendre[0], stage->force);
}

double aoi_collocation_work(const aoi_stage *stage)
{
    double sum = 0.0;
    for (size_t i = 0; i < AOI_STAGES; i++) {
        double slope = aoi_radau_slope_at_node[i][0] * stage->start;
        for (size_t k = 0; k < AOI_STAGES; k++) {
            slope += aoi_radau_slope_at_node[i][k + 1] * stage->indentation[k];
        }
        sum += aoi_radau_to_legendre[0][i] * stage->force[i] * slope;
    }
    return sum;
}
