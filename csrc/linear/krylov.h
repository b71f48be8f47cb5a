/* A Krylov basis of a body for its contact functionals. Dense matrices by columns. */
#ifndef AOI_LINEAR_KRYLOV_H
#define AOI_LINEAR_KRYLOV_H

#include "linear/sparse.h"

/* A rational Krylov subspace of a body for port_count contact functionals: with A = K + s^2 M, the
 * vectors A^-1 b, then A^-1 M v of each of them in turn, made M-orthonormal. Its Galerkin model has
 * the body's receptance at the frequency i s, and as many derivatives of it there as there were
 * solves, twice over where there is one port. s2 and solver (of A) may change between calls: several
 * shifts in one space.
 *   b          n x port_count. Where the body has rigid motions R, they must be in the basis and out of
 *              b: b - M R R^T b. The space is then as good for the smallest s.
 *   basis      n x capacity; its first rigid_count columns are R, M-orthonormal, set by the caller,
 *              and stay. 1 + the vectors wanted are enough for one port.
 *   stiffness  V^T K V, capacity x capacity; V^T M V is 1. Rows and columns of R must be zero.
 *   given      given_count columns, rigid_count or more, are there before the first solve. Those
 *              beyond R are any motions that the model is to have, M-orthonormal and with their
 *              stiffness, such as static modes: grown so themselves, with s2 = 0 and each b by itself.
 *              A zero column with zero stiffness reserves a slot.
 *   count      columns so far: given_count at the start. next: solves so far, 0 at the start.
 *   solver     of A; it leaves the products that its residual is made of: they are not made twice.
 *   load       n doubles, kept from call to call: with one port M times the last column, once solved.
 *   work       aoi_krylov_work_size doubles.
 *   pause      called between two products of vectors, or NULL.
 */
typedef struct aoi_krylov {
    aoi_sparse K, M;
    double s2;
    aoi_residual_solver solver;
    size_t port_count, rigid_count, given_count, capacity;
    const double *b;
    double *basis, *stiffness, *load, *work;
    size_t count, next;
    const aoi_pause *pause;
} aoi_krylov;

size_t aoi_krylov_work_size(size_t n, size_t capacity);

/* Grows the basis to wanted <= capacity columns, a solve for each, or to where it is invariant: b
 * excites no more (breakdown); then count stays below wanted for good. A vector that is a combination
 * of the others is left out and its successors with it. What was grown before is kept, so a larger
 * order costs one solve. On an error (AOI_ERROR_SOLVER where the solver failed or its residual is
 * above 0.003) the columns up to count are sound. */
int aoi_krylov_extend(aoi_krylov *space, size_t wanted);

#endif
