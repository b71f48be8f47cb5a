/* Newmark's rule on the finite-element model itself (section 3.1): M + beta dt^2 K is factorised
 * once by the caller; a step is one product with K and one back-substitution, and the contact force
 * enters through the response to a unit force, which is kept. Displacements are formed as in
 * newmark.c, with no rounded dt^2. */
#include "aoimpact.h"

#include <math.h>
#include <string.h>

enum { DT, PREDICT_U, PREDICT_V, CORRECT_U, CORRECT_V, REACH };

size_t aoi_body_full_size(size_t n) { return 5 * n; }

static const aoi_full *full_of(const aoi_body *body) { return body->model; }

/* state: u, v, a, the free acceleration, the acceleration to a unit force. */
static double *part(const aoi_body *body, size_t which)
{
    return body->state + which * full_of(body)->K.n;
}

static int full_predict(aoi_body *body, double *displacement, double *velocity)
{
    const aoi_full *full = full_of(body);
    const size_t n = full->K.n;
    const double *c = body->scratch;
    double *u = part(body, 0), *v = part(body, 1), *a = part(body, 2), *free_a = part(body, 3);
    for (size_t i = 0; i < n; i++) {
        u[i] += c[DT] * (v[i] + c[PREDICT_U] * a[i]);
        v[i] += c[PREDICT_V] * a[i];
    }
    aoi_sparse_multiply(&full->K, u, free_a);
    for (size_t i = 0; i < n; i++) {
        free_a[i] = -free_a[i];
    }
    if (full->solver.solve(full->solver.data, free_a) != 0) {
        return AOI_ERROR_SOLVER;
    }
    const double reached = aoi_vector_dot(n, full->b, free_a);
    *displacement = aoi_vector_dot(n, full->b, u) + c[REACH] * reached;
    *velocity = aoi_vector_dot(n, full->b, v) + c[CORRECT_V] * reached;
    return AOI_OK;
}

static void full_correct(aoi_body *body, double force)
{
    const double *c = body->scratch;
    const size_t n = full_of(body)->K.n;
    double *u = part(body, 0), *v = part(body, 1), *a = part(body, 2);
    const double *free_a = part(body, 3), *unit_a = part(body, 4);
    for (size_t i = 0; i < n; i++) {
        a[i] = free_a[i] + force * unit_a[i];
        v[i] += c[CORRECT_V] * a[i];
        u[i] += c[DT] * (c[CORRECT_U] * a[i]);
    }
}

static void full_observe(const aoi_body *body, int energies, aoi_observation *seen)
{
    const aoi_full *full = full_of(body);
    const size_t n = full->K.n;
    const double *u = part(body, 0), *v = part(body, 1);
    seen->displacement = aoi_vector_dot(n, full->b, u);
    seen->velocity = aoi_vector_dot(n, full->b, v);
    seen->centre_displacement = aoi_vector_dot(n, body->centre, u);
    seen->centre_velocity = aoi_vector_dot(n, body->centre, v);
    if (energies) {
        seen->kinetic = 0.5 * aoi_sparse_quadratic(&full->M, v);
        seen->elastic = 0.5 * aoi_sparse_quadratic(&full->K, u);
    }
}

static void full_copy_state(const aoi_body *body, double *u, double *v)
{
    const size_t bytes = full_of(body)->K.n * sizeof(double);
    memcpy(u, part(body, 0), bytes);
    memcpy(v, part(body, 1), bytes);
}

int aoi_body_start_full(aoi_body *body, const aoi_full *full, const aoi_newmark *rule,
                        const double *centre, const double *u0, const double *v0, double *work)
{
    const size_t n = full->K.n;
    const double h = rule->dt;
    if (!(h > 0.0) || !(rule->beta > 0.0) || !(rule->gamma >= 0.5) || !isfinite(h)) {
        return AOI_ERROR_ARGUMENT;
    }
    *body = (aoi_body){full_predict, full_correct, full_observe, full_copy_state, 0.0, 0.0,
                       full,         centre,       work,         {0}};
    double *c = body->scratch, *unit_a = part(body, 4);
    c[DT] = h;
    c[PREDICT_U] = h * (0.5 - rule->beta);
    c[PREDICT_V] = h * (1.0 - rule->gamma);
    c[CORRECT_U] = h * rule->beta;
    c[CORRECT_V] = h * rule->gamma;
    c[REACH] = rule->beta * h * h;
    for (size_t i = 0; i < n; i++) {
        part(body, 0)[i] = u0[i];
        part(body, 1)[i] = v0[i];
        part(body, 2)[i] = 0.0;
        unit_a[i] = full->b[i];
    }
    if (full->solver.solve(full->solver.data, unit_a) != 0) {
        return AOI_ERROR_SOLVER;
    }
    const double reached = aoi_vector_dot(n, full->b, unit_a);
    if (!isfinite(reached)) {
        return AOI_ERROR_NOT_FINITE;
    }
    body->compliance = c[REACH] * reached;
    body->rate_compliance = c[CORRECT_V] * reached;
    return body->compliance > 0.0 ? AOI_OK : AOI_ERROR_NOT_POSITIVE;
}
