/* Newmark's rule for a finite-element model (section 3.1). The caller factorises M (1 + alpha gamma dt) + K
 * (beta_N dt^2 + beta gamma dt) once, with beta_N and gamma of the rule. A step takes one product with K (also one
 * with M if alpha is not zero) and one back-substitution. The forces on the ports act through the responses to
 * unit forces, which are kept. */
#include "newmark/body.h"
#include "linear/sparse.h"
#include "linear/vector.h"

#include <math.h>
#include <string.h>

/* Largest number of iterations of conjugate gradients, of which a consistent mass matrix scaled by its diagonal
 * takes some tens. */
enum { MOST_ITERATIONS = 1000 };

static const double CONVERGED = 1e-15;

/* Adds gravity - K (u + beta v) - alpha M v to `out`; spare and product are overwritten. */
static void add_forces_within(const aoi_stepped *body, double *spare, double *product, double *out)
{
    const aoi_full *full = body->model->full;
    const size_t n = body->model->n;
    const double *u = body->x, *v = body->v, alpha = full->alpha, beta = full->beta;
    if (beta != 0.0) {
        for (size_t i = 0; i < n; i++) {
            spare[i] = u[i] + beta * v[i];
        }
        u = spare;
    }
    aoi_sparse_multiply(&full->K, u, product);
    aoi_vector_add(n, -1.0, product, out);
    if (body->model->gravity) {
        aoi_vector_add(n, 1.0, body->model->gravity, out);
    }
    if (alpha != 0.0) {
        aoi_sparse_multiply(&full->M, v, product);
        aoi_vector_add(n, -alpha, product, out);
    }
}

static int full_prepare(aoi_stepped *body)
{
    const aoi_modes *model = body->model;
    const aoi_full *full = model->full;
    for (size_t p = 0; p < model->ports; p++) {
        double *gain = body->gain + p * model->n;
        memcpy(gain, model->push + p * model->n, model->n * sizeof(double));
        if (full->solver.solve(full->solver.data, gain) != 0) {
            return AOI_ERROR_SOLVER;
        }
    }
    if (full->alpha == 0.0 && full->beta == 0.0) {
        body->before = NULL;
    }
    return AOI_OK;
}

static int full_accelerate(aoi_stepped *body)
{
    const aoi_full *full = body->model->full;
    if (aoi_work_stops(full->pause)) {
        return AOI_ERROR_STOPPED;
    }
    memset(body->free_a, 0, body->model->n * sizeof(double));
    add_forces_within(body, body->own[0], body->own[1], body->free_a);
    return full->solver.solve(full->solver.data, body->free_a) == 0 ? AOI_OK : AOI_ERROR_SOLVER;
}

static double full_power(const aoi_stepped *body)
{
    const aoi_full *full = body->model->full;
    double power = full->alpha != 0.0 ? full->alpha * aoi_sparse_quadratic(&full->M, body->before) : 0.0;
    power += full->beta != 0.0 ? full->beta * aoi_sparse_quadratic(&full->K, body->before) : 0.0;
    return power;
}

static void full_observe(const aoi_stepped *body, double *row, size_t stride)
{
    const aoi_modes *model = body->model;
    row[AOI_BODY_KINETIC * stride] = 0.5 * aoi_sparse_quadratic(&model->full->M, body->v);
    row[AOI_BODY_ELASTIC * stride] = 0.5 * aoi_sparse_quadratic(&model->full->K, body->x);
    row[AOI_BODY_WORK * stride] = model->gravity ? aoi_vector_dot(model->n, model->gravity, body->x) : 0.0;
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

/* Sets z to r divided by the diagonal of M, and to 0 where the diagonal is not positive. Returns r^T z. */
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

/* Finds the accelerations at the start; degrees of freedom without mass get zero. */
static int full_begin(aoi_stepped *body)
{
    const aoi_full *full = body->model->full;
    add_forces_within(body, body->own[0], body->own[1], body->free_a);
    return solve_mass(&full->M, full->pause, body->free_a, body->own[0], body->own[1], body->own[2], body->a);
}

const aoi_stepped_kind aoi_stepped_full = {full_prepare, full_begin, full_accelerate, full_power, full_observe};
