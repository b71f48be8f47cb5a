/* A rational Krylov subspace of a body, fitted to how it is struck: M-orthonormal vectors, grown one
 * solve with K + s^2 M at a time from the contact functionals. */
#include "linear/krylov.h"
#include "linear/sparse.h"
#include "linear/vector.h"
#include "linear/work.h"

#include <math.h>

/* A new vector that keeps less than this of its length across the others is their rounding. */
static const double BREAKDOWN = 1e-11;

/* ||f - A x|| / ||f|| beyond which the solver has not solved: three times what an iterative one may
 * leave. */
static const double MOST_RESIDUAL = 3e-3;

/* Where across the others more than this is left of a vector, one more pass changes no digit. */
static const double NO_CANCELLATION = 0.5;

/* A pass that takes off less than this share changes no digit of M x. */
static const double NOTHING = 1e-13;

/* Columns that a product with K is made of at once. */
enum { TOGETHER = 4 };

static void copy(size_t n, const double *from, double *to)
{
    for (size_t i = 0; i < n; i++) {
        to[i] = from[i];
    }
}

size_t aoi_krylov_work_size(size_t n, size_t capacity)
{
    return aoi_plus(aoi_times(TOGETHER, n), capacity);
}

/* Right-hand side of the next solve: a contact functional, then M times each vector in turn. With one
 * port that is left there by the last one. */
static void next_load(const aoi_krylov *space)
{
    const size_t n = space->K.n, turn = space->next;
    if (turn < space->port_count) {
        copy(n, space->b + turn * n, space->load);
    } else if (space->port_count > 1) {
        const size_t source = space->given_count + turn - space->port_count;
        aoi_sparse_multiply(&space->M, space->basis + source * n, space->load);
    }
}

/* x = A^-1 load, with its residual looked at; kx = K x, mx = M x. */
static int solve_checked(const aoi_krylov *space, double *x, double *kx, double *mx)
{
    const size_t n = space->K.n;
    const double *f = space->load;
    double residual = 0.0, load = 0.0;
    copy(n, f, x);
    if (space->solver.solve(space->solver.data, x, kx, mx) != 0) {
        return AOI_ERROR_SOLVER;
    }
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

/* Takes off x what the columns have of it, by mx = M x (classical Gram-Schmidt). taken: the M-norm of
 * that. */
static int take_off(const aoi_krylov *space, const double *mx, double *x, double *coefficient,
                    double *taken)
{
    const size_t n = space->K.n;
    for (size_t j = 0; j < space->count; j++) {
        coefficient[j] = aoi_vector_dot(n, space->basis + j * n, mx);
        if (aoi_work_stops(space->pause)) {
            return AOI_ERROR_STOPPED;
        }
    }
    for (size_t j = 0; j < space->count; j++) {
        aoi_vector_add(n, -coefficient[j], space->basis + j * n, x);
        if (aoi_work_stops(space->pause)) {
            return AOI_ERROR_STOPPED;
        }
    }
    *taken = sqrt(aoi_vector_dot(space->count, coefficient, coefficient));
    return AOI_OK;
}

/* Makes x M-orthogonal to the count vectors before it, and of M-norm 1; mx = M x in and out. Passes
 * go on until one takes nothing off. left: 0 where nothing but rounding is. */
static int orthonormalise(const aoi_krylov *space, double *x, double *mx, double *coefficient,
                          int *left)
{
    *left = 0;
    const size_t n = space->K.n;
    double length = sqrt(aoi_vector_dot(n, x, mx));
    const double least = BREAKDOWN * length;
    for (double before = INFINITY; length < NO_CANCELLATION * before;) {
        double taken;
        if (!(length > least)) {
            return AOI_OK;
        }
        before = length;
        if (take_off(space, mx, x, coefficient, &taken) != AOI_OK) {
            return AOI_ERROR_STOPPED;
        }
        if (taken > NOTHING * length) {
            aoi_sparse_multiply(&space->M, x, mx);
            length = sqrt(aoi_vector_dot(n, x, mx));
        }
    }
    if (!(length > least)) {
        return AOI_OK;
    }
    for (size_t i = 0; i < n; i++) {
        x[i] /= length;
        mx[i] /= length;
    }
    *left = 1;
    /* Where hardly any mass moves, the vector may have left the range of numbers. */
    return aoi_vector_is_finite(n, x) ? AOI_OK : AOI_ERROR_NOT_FINITE;
}

/* The rows and columns of V^T K V from column first on; rigid motions have no elastic force. */
static int project_stiffness(const aoi_krylov *space, size_t first)
{
    const size_t n = space->K.n;
    double *kv = space->work;
    for (; first < space->count; first += TOGETHER) {
        const size_t left = space->count - first, width = left < TOGETHER ? left : TOGETHER;
        aoi_sparse_multiply_each(&space->K, width, space->basis + first * n, kv);
        for (size_t i = first; i < first + width; i++) {
            for (size_t j = 0; j <= i; j++) {
                const double *v = space->basis + j * n, *force = kv + (i - first) * n;
                const double entry = j < space->rigid_count ? 0.0 : aoi_vector_dot(n, v, force);
                space->stiffness[i * space->capacity + j] = entry;
                space->stiffness[j * space->capacity + i] = entry;
                if (aoi_work_stops(space->pause)) {
                    return AOI_ERROR_STOPPED;
                }
            }
        }
    }
    return AOI_OK;
}

/* One solve more, and what is new of it as one more column. */
static int add_column(aoi_krylov *space)
{
    const size_t n = space->K.n;
    double *kx = space->work, *mx = kx + n, *coefficient = kx + TOGETHER * n;
    double *x = space->basis + space->count * n;
    next_load(space);
    const int status = solve_checked(space, x, kx, mx);
    if (status != AOI_OK) {
        return status;
    }
    space->next++;
    int left;
    const int whole = orthonormalise(space, x, mx, coefficient, &left);
    if (whole == AOI_OK && left) {
        copy(n, mx, space->load);
        space->count++;
    }
    return whole;
}

int aoi_krylov_extend(aoi_krylov *space, size_t wanted)
{
    const size_t first = space->count;
    int status = AOI_OK;
    if (space->M.n != space->K.n || wanted > space->capacity || first < space->given_count ||
        space->given_count < space->rigid_count) {
        return AOI_ERROR_ARGUMENT;
    }
    while (status == AOI_OK && space->count < wanted &&
           space->given_count + space->next < space->port_count + space->count) {
        status = add_column(space);
    }
    const int projected = project_stiffness(space, first);
    return status != AOI_OK ? status : projected;
}
