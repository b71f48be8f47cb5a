/* A rational Krylov subspace of a body, fitted to how it is struck: M-orthonormal vectors, grown one
 * solve with K + s^2 M at a time from the contact functionals. */
#include "aoimpact.h"

#include <math.h>

/* A new vector that keeps less than this of its length across the others is their rounding. */
static const double BREAKDOWN = 1e-11;

/* ||f - A x|| / ||f|| beyond which the solver has not solved. */
static const double MOST_RESIDUAL = 1e-5;

/* Where across the others more than this is left of a vector, one more pass changes no digit. */
static const double NO_CANCELLATION = 0.5;

size_t aoi_krylov_work_size(size_t n, size_t capacity)
{
    return 3 * n + capacity;
}

/* Right-hand side of the next solve: a contact functional, then M times each vector in turn. */
static void next_load(const aoi_krylov *space, double *f)
{
    const size_t n = space->K.n;
    if (space->next < space->port_count) {
        for (size_t i = 0; i < n; i++) {
            f[i] = space->b[space->next * n + i];
        }
        return;
    }
    const size_t source = space->given_count + space->next - space->port_count;
    aoi_sparse_multiply(&space->M, space->basis + source * n, f);
}

/* x = A^-1 f, with its residual looked at; mx = M x. kx: n doubles of work. */
static int solve_checked(const aoi_krylov *space, const double *f, double *x, double *kx, double *mx)
{
    const size_t n = space->K.n;
    double residual = 0.0, load = 0.0;
    for (size_t i = 0; i < n; i++) {
        x[i] = f[i];
    }
    if (space->solver.solve(space->solver.data, x) != 0) {
        return AOI_ERROR_SOLVER;
    }
    aoi_sparse_multiply(&space->K, x, kx);
    aoi_sparse_multiply(&space->M, x, mx);
    for (size_t i = 0; i < n; i++) {
        const double left = f[i] - kx[i] - space->s2 * mx[i];
        residual += left * left;
        load += f[i] * f[i];
    }
    if (!isfinite(residual)) {
        return AOI_ERROR_NOT_FINITE;
    }
    return residual <= MOST_RESIDUAL * MOST_RESIDUAL * load ? AOI_OK : AOI_ERROR_SOLVER;
}

/* Makes x M-orthogonal to the count vectors before it, and of M-norm 1; mx = M x in and out. All
 * coefficients of a pass come from one M x (classical Gram-Schmidt); passes go on until one takes
 * nothing off. Returns 0 where nothing but rounding is left. */
static int orthonormalise(const aoi_krylov *space, double *x, double *mx, double *coefficient)
{
    const size_t n = space->K.n;
    double length = sqrt(aoi_vector_dot(n, x, mx));
    const double least = BREAKDOWN * length;
    for (double before = INFINITY; length < NO_CANCELLATION * before;) {
        if (!(length > least)) {
            return 0;
        }
        before = length;
        for (size_t j = 0; j < space->count; j++) {
            coefficient[j] = aoi_vector_dot(n, space->basis + j * n, mx);
        }
        for (size_t j = 0; j < space->count; j++) {
            aoi_vector_add(n, -coefficient[j], space->basis + j * n, x);
        }
        aoi_sparse_multiply(&space->M, x, mx);
        length = sqrt(aoi_vector_dot(n, x, mx));
    }
    if (!(length > least)) {
        return 0;
    }
    for (size_t i = 0; i < n; i++) {
        x[i] /= length;
    }
    return 1;
}

/* The new vector's row and column of V^T K V; rigid motions have no elastic force. */
static void project_stiffness(const aoi_krylov *space, const double *x, double *kx)
{
    const size_t n = space->K.n, last = space->count;
    aoi_sparse_multiply(&space->K, x, kx);
    for (size_t j = 0; j <= last; j++) {
        const double *v = space->basis + j * n;
        const double entry = j < space->rigid_count ? 0.0 : aoi_vector_dot(n, v, kx);
        space->stiffness[last * space->capacity + j] = entry;
        space->stiffness[j * space->capacity + last] = entry;
    }
}

int aoi_krylov_extend(aoi_krylov *space, size_t wanted)
{
    const size_t n = space->K.n;
    double *f = space->work, *kx = f + n, *mx = kx + n, *coefficient = mx + n;
    if (space->M.n != n || wanted > space->capacity || space->count < space->given_count ||
        space->given_count < space->rigid_count) {
        return AOI_ERROR_ARGUMENT;
    }
    while (space->count < wanted &&
           space->given_count + space->next < space->port_count + space->count) {
        double *x = space->basis + space->count * n;
        next_load(space, f);
        const int status = solve_checked(space, f, x, kx, mx);
        if (status != AOI_OK) {
            return status;
        }
        space->next++;
        if (orthonormalise(space, x, mx, coefficient)) {
            project_stiffness(space, x, kx);
            space->count++;
        }
    }
    return AOI_OK;
}
