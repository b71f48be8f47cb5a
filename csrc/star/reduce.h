/* From the matrices of a body to its anti-oscillators: section 2 of the paper. Dense matrices by
 * columns. */
#ifndef AOI_STAR_REDUCE_H
#define AOI_STAR_REDUCE_H

#include "aoimpact.h"

/* Static mode of a constrained body, eqs. (2), (3), (11). In: b, the contact functional (u = b^T X), and
 * x = K^-1 b, n doubles each. Out: x becomes phi_st = K^-1 b / (b^T K^-1 b), so b^T phi_st = 1;
 * stiffness gets k0 = 1 / (b^T K^-1 b). AOI_ERROR_UNREACHED if b is zero, AOI_ERROR_NOT_POSITIVE if
 * b^T K^-1 b <= 0 (K is no stiffness of a constrained body). */
int aoi_static_constrained(size_t n, const double *b, double *x, double *stiffness);

/* Static mode of a free body: the rigid-body motion that b excites, phi_st = R r / (r^T r) with
 * R (n x rigid_count, M-orthonormal) and r = R^T b. Its mass is 1 / (r^T r) and its k0 is zero. The
 * rest of the rigid motion is M-orthogonal to it, and the contact does not excite it.
 * AOI_ERROR_UNREACHED if r is zero to rounding: b then excites no rigid motion. */
int aoi_static_free(size_t n, size_t rigid_count, const double *rigid, const double *b,
                    double *phi_st, double *mass);

/* Inverse iteration on the constraint modes' space b^T phi = 0: given x = A^-1 f and z = A^-1 b with
 * A symmetric positive definite (e.g. K + s^2 M), overwrites x by the solution of A x + mu b = f,
 * b^T x = 0. n doubles each. AOI_ERROR_NOT_POSITIVE if b^T z <= 0. */
int aoi_constraint_project(size_t n, const double *b, const double *z, double *x);

/* The Householder vector h (n doubles, h^T h = 2) with (I - h h^T) b = -+|b| e_1, by which the
 * space b^T phi = 0 becomes "first entry zero". AOI_ERROR_UNREACHED if b is zero. */
int aoi_constraint_reflector(size_t n, const double *b, double *h);

/* A <- (I - h h^T) A (I - h h^T) for a symmetric dense A (n x n); its rows and columns 1..n-1 are
 * then A on the space b^T phi = 0. work: n doubles. */
void aoi_constraint_congruence(size_t n, const double *h, double *a, double *work);

#endif
