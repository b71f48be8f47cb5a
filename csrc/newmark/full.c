/* Newmark's rule on the finite-element model itself (section 3.1): M (1 + alpha gamma dt) + K (beta
 * dt^2 + beta gamma dt) is factorised once by the caller; a step is one product with K (and one with M
 * where alpha is not zero) and one back-substitution, and the forces at the ports enter through the
 * responses to unit forces, which are kept. Displacements are formed as in star.c, with no rounded
 * dt^2. */
#include "newmark/body.h"
#include "linear/sparse.h"
#include "linear/vector.h"
#include "linear/work.h"

#include <math.h>
#include <string.h>

enum { LOST };

/* Conjugate gradients with a consistent mass matrix, scaled by its diagonal, take some tens. */
enum { MOST_ITERATIONS = 1000 };

static const double CONVERGED = 1e-15;

/* state: u, v, a, the free acceleration, three vectors to work with; the accelerations to a unit force at
 * each port; compliance, rate compliance. */
enum { U, V, A, FREE_A, SPARE, SECOND, THIRD, UNIT };

size_t aoi_body_full_size(size_t n, size_t ports) 
{
    return aoi_plus(aoi_times(UNIT + ports, n), aoi_times(2 * ports, ports));
}

static const aoi_full *full_of(const aoi_body *body) { return body->model; }

static double *part(const aoi_body *body, size_t which)
{
    return body->state + which * full_of(body)->K.n;
}

static int is_damped(const aoi_full *full)
{
    return full->damping.alpha != 0.0 || full->damping.beta != 0.0;
}

/* out = gravity - K (u + beta v) - alpha M v; spare is overwritten. */
static void forces_within(const aoi_body *body, const double *u, const double *v, double *spare,
                          double *out)
{
    const aoi_full *full = full_of(body);
    const size_t n = full->K.n;
    const double alpha = full->damping.alpha, beta = full->damping.beta;
    if (beta != 0.0) {
        for (size_t i = 0; i < n; i++) {
            spare[i] = u[i] + beta * v[i];
        }
        u = spare;
    }
    aoi_sparse_multiply(&full->K, u, out);
    for (size_t i = 0; i < n; i++) {
        out[i] = body->gravity ? body->gravity[i] - out[i] : -out[i];
    }
    if (alpha != 0.0) {
        aoi_sparse_multiply(&full->M, v, spare);
        aoi_vector_add(n, -alpha, spare, out);
    }
}

static int full_predict(aoi_body *body, double *displacement, double *velocity)
{
    const aoi_full *full = full_of(body);
    const aoi_rule_step *step = &body->step;
    const size_t n = full->K.n;
    double *u = part(body, U), *v = part(body, V), *a = part(body, A), *free_a = part(body, FREE_A);
    if (aoi_work_stops(full->pause)) {
        return AOI_ERROR_STOPPED;
    }
    if (is_damped(full)) {
        memcpy(part(body, SECOND), v, n * sizeof(double));
    }
    for (size_t i = 0; i < n; i++) {
        u[i] += step->dt * (v[i] + step->predict_u * a[i]);
        v[i] += step->predict_v * a[i];
    }
    forces_within(body, u, v, part(body, SPARE), free_a);
    if (full->solver.solve(full->solver.data, free_a) != 0) {
        return AOI_ERROR_SOLVER;
    }
    for (size_t p = 0; p < full->ports; p++) {
        const double *b = full->b + p * n, reached = aoi_vector_dot(n, b, free_a);
        displacement[p] = aoi_vector_dot(n, b, u) + step->reach * reached;
        velocity[p] = aoi_vector_dot(n, b, v) + step->correct_v * reached;
    }
    return AOI_OK;
}

/* What the dashpots take of the rates before and after the step. */
static void full_lose(aoi_body *body)
{
    const aoi_full *full = full_of(body);
    double *twice_v = part(body, SECOND), power = 0.0;
    aoi_vector_add(full->K.n, 1.0, part(body, V), twice_v);
    if (full->damping.alpha != 0.0) {
        power += full->damping.alpha * aoi_sparse_quadratic(&full->M, twice_v);
    }
    if (full->damping.beta != 0.0) {
        power += full->damping.beta * aoi_sparse_quadratic(&full->K, twice_v);
    }
    body->scratch[LOST] += 0.25 * body->step.dt * power;
}

static void full_correct(aoi_body *body, const double *force)
{
    const aoi_full *full = full_of(body);
    const aoi_rule_step *step = &body->step;
    const size_t n = full->K.n;
    double *u = part(body, U), *v = part(body, V), *a = part(body, A);
    const double *free_a = part(body, FREE_A), *unit_a = part(body, UNIT), first = force[0];
    for (size_t i = 0; i < n; i++) {
        a[i] = free_a[i] + first * unit_a[i];
    }
    for (size_t p = 1; p < full->ports; p++) {
        aoi_vector_add(n, force[p], unit_a + p * n, a);
    }
    for (size_t i = 0; i < n; i++) {
        v[i] += step->correct_v * a[i];
        u[i] += step->dt * (step->correct_u * a[i]);
    }
    if (is_damped(full)) {
        full_lose(body);
    }
}

static void full_observe(const aoi_body *body, int energies, double *row, size_t stride)
{
    const aoi_full *full = full_of(body);
    const size_t n = full->K.n;
    const double *u = part(body, U), *v = part(body, V);
    row[AOI_BODY_CENTRE * stride] = aoi_vector_dot(n, body->centre, u);
    row[AOI_BODY_CENTRE_VELOCITY * stride] = aoi_vector_dot(n, body->centre, v);
    for (size_t p = 0; p < full->ports; p++) {
        double *port = row + (AOI_BODY_ROWS + AOI_PORT_ROWS * p) * stride;
        port[0] = aoi_vector_dot(n, full->b + p * n, u);
        port[stride] = aoi_vector_dot(n, full->b + p * n, v);
    }
    if (energies) {
        row[AOI_BODY_KINETIC * stride] = 0.5 * aoi_sparse_quadratic(&full->M, v);
        row[AOI_BODY_ELASTIC * stride] = 0.5 * aoi_sparse_quadratic(&full->K, u);
        row[AOI_BODY_DISSIPATED * stride] = body->scratch[LOST];
        row[AOI_BODY_WORK * stride] = body->gravity ? aoi_vector_dot(n, body->gravity, u) : 0.0;
    }
}

static void full_copy_state(const aoi_body *body, double *u, double *v)
{
    const size_t bytes = full_of(body)->K.n * sizeof(double);
    memcpy(u, part(body, U), bytes);
    memcpy(v, part(body, V), bytes);
}

static void take_diagonal(const aoi_sparse *matrix, double *diagonal)
{
    for (size_t i = 0; i < matrix->n; i++) {
        diagonal[i] = 0.0;
        for (int32_t p = matrix->start[i]; p < matrix->start[i + 1]; p++) {
            diagonal[i] += (size_t)matrix->indices[p] == i ? matrix->values[p] : 0.0;
        }
    }
}

/* z = r over the diagonal of M, 0 where that is not positive; returns r^T z. */
static double scaled_by_mass(size_t n, const double *diagonal, const double *r, double *z)
{
    double sum = 0.0;
    for (size_t i = 0; i < n; i++) {
        z[i] = diagonal[i] > 0.0 ? r[i] / diagonal[i] : 0.0;
        sum += r[i] * z[i];
    }
    return sum;
}

/* Solves M x = r by conjugate gradients; r, p, z and diagonal are overwritten. */
static int solve_mass(const aoi_sparse *M, const aoi_pause *pause, double *r, double *p, double *z,
                      double *diagonal, double *x)
{
    const size_t n = M->n;
    take_diagonal(M, diagonal);
    double size = scaled_by_mass(n, diagonal, r, z);
    const double enough = CONVERGED * CONVERGED * size;
    memset(x, 0, n * sizeof(double));
    memset(p, 0, n * sizeof(double));
    for (int i = 0; i < MOST_ITERATIONS; i++) {
        if (!(size > enough)) {
            return isfinite(size) ? AOI_OK : AOI_ERROR_NOT_FINITE;
        }
        if (aoi_work_stops(pause)) {
            return AOI_ERROR_STOPPED;
        }
        aoi_vector_add(n, 1.0, z, p);
        aoi_sparse_multiply(M, p, z);
        const double share = size / aoi_vector_dot(n, p, z);
        aoi_vector_add(n, share, p, x);
        aoi_vector_add(n, -share, z, r);
        const double before = size;
        size = scaled_by_mass(n, diagonal, r, z);
        for (size_t j = 0; j < n; j++) {
            p[j] *= size / before;
        }
    }
    return AOI_ERROR_NO_CONVERGENCE;
}

static int full_begin(aoi_body *body, const double *force)
{
    const aoi_full *full = full_of(body);
    double *r = part(body, FREE_A);
    forces_within(body, part(body, U), part(body, V), part(body, SPARE), r);
    for (size_t p = 0; p < full->ports; p++) {
        aoi_vector_add(full->K.n, force[p], full->b + p * full->K.n, r);
    }
    return solve_mass(&full->M, full->pause, r, part(body, SPARE), part(body, SECOND), part(body, THIRD), part(body, A));
}

/* The responses to unit forces, and the compliances that they make. */
static int full_prepare_ports(const aoi_body *body, double *compliance, double *rate_compliance)
{
    const aoi_full *full = full_of(body);
    const size_t n = full->K.n, ports = full->ports;
    for (size_t p = 0; p < ports; p++) {
        double *unit_a = part(body, UNIT + p);
        memcpy(unit_a, full->b + p * n, n * sizeof(double));
        if (full->solver.solve(full->solver.data, unit_a) != 0) {
            return AOI_ERROR_SOLVER;
        }
        for (size_t q = 0; q < ports; q++) {
            const double reached = aoi_vector_dot(n, full->b + q * n, unit_a);
            const double far = body->step.reach * reached, fast = body->step.correct_v * reached;
            if (!isfinite(far) || !isfinite(fast)) {
                return AOI_ERROR_NOT_FINITE;
            }
            if (q == p && !(reached > 0.0)) {
                return AOI_ERROR_NOT_POSITIVE;
            }
            compliance[p * ports + q] = far;
            rate_compliance[p * ports + q] = fast;
        }
    }
    return AOI_OK;
}

int aoi_body_start_full(aoi_body *body, const aoi_full *full, const aoi_rule *rule,
                        const aoi_body_start *start, double *work)
{
    const size_t n = full->K.n, ports = full->ports;
    aoi_rule_step step;
    const int status = aoi_rule_prepare(rule, &step);
    if (status != AOI_OK) {
        return status;
    }
    if (ports < 1 || full->M.n != n || !(full->damping.alpha >= 0.0) ||
        !(full->damping.beta >= 0.0) || !isfinite(full->damping.alpha + full->damping.beta)) {
        return AOI_ERROR_ARGUMENT;
    }
    double *compliance = work + (UNIT + ports) * n, *rate_compliance = compliance + ports * ports;
    *body = (aoi_body){full_begin,      full_predict,  full_correct,   full_observe,
                       full_copy_state, ports,         compliance,     rate_compliance,
                       full,            start->centre, start->gravity, work,
                       step,            {0}};
    memcpy(part(body, U), start->u, n * sizeof(double));
    memcpy(part(body, V), start->v, n * sizeof(double));
    return full_prepare_ports(body, compliance, rate_compliance);
}
