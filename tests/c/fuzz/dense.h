/* Chains of masses and springs as sparse matrices, and a direct solver of K + s^2 M and its kin, for the
 * harnesses of what works on matrices. */
#ifndef AOIMPACT_FUZZ_DENSE_H
#define AOIMPACT_FUZZ_DENSE_H

#include "fuzz.h"
#include "linear/sparse.h"

/* A tridiagonal matrix: springs between neighbours and to the ground, as a stiffness matrix has them. */
static inline aoi_sparse take_chain(input *in, size_t n, const double *spring, const double *ground)
{
    int32_t *start = take_bytes(in, n + 1, sizeof *start), *indices = take_bytes(in, 3 * n, sizeof *indices);
    double *values = take_room(in, 3 * n);
    int32_t p = 0;
    for (size_t i = 0; i < n; i++) {
        const double below = i > 0 ? spring[i - 1] : 0.0, above = i + 1 < n ? spring[i] : 0.0;
        if (i > 0) {
            indices[p] = (int32_t)i - 1;
            values[p++] = -below;
        }
        indices[p] = (int32_t)i;
        values[p++] = below + above + ground[i];
        if (i + 1 < n) {
            indices[p] = (int32_t)i + 1;
            values[p++] = -above;
        }
        start[i + 1] = p;
    }
    return (aoi_sparse){n, start, indices, values};
}

/* of_k K + of_m M by elimination; fails as asked for, or lies. */
typedef struct chain_solver {
    const aoi_sparse *K, *M;
    double of_k, of_m;
    unsigned calls, fails_at, lies_at;
    double lie, *diagonal;
} chain_solver;

static inline double entry(const aoi_sparse *a, size_t i, size_t j)
{
    for (int32_t p = a->start[i]; p < a->start[i + 1]; p++) {
        if ((size_t)a->indices[p] == j) {
            return a->values[p];
        }
    }
    return 0.0;
}

static inline int chain_solve(void *data, double *x)
{
    chain_solver *s = data;
    const size_t n = s->K->n;
    if (++s->calls == s->fails_at) {
        return 1;
    }
    for (size_t i = 0; i < n; i++) {
        s->diagonal[i] = s->of_k * entry(s->K, i, i) + s->of_m * entry(s->M, i, i);
        if (i > 0) {
            const double off = s->of_k * entry(s->K, i, i - 1) + s->of_m * entry(s->M, i, i - 1);
            const double factor = off / s->diagonal[i - 1];
            s->diagonal[i] -= factor * off;
            x[i] -= factor * x[i - 1];
        }
    }
    for (size_t i = n; i-- > 0;) {
        const double off = i + 1 < n ? s->of_k * entry(s->K, i, i + 1) + s->of_m * entry(s->M, i, i + 1) : 0.0;
        x[i] = (x[i] - (i + 1 < n ? off * x[i + 1] : 0.0)) / s->diagonal[i];
    }
    if (s->calls == s->lies_at && n > 0) {
        x[s->calls % n] = s->lie;
    }
    return 0;
}

static inline chain_solver take_solver(input *in, const aoi_sparse *K, const aoi_sparse *M, double of_k, double of_m)
{
    chain_solver s = {.K = K, .M = M, .of_k = of_k, .of_m = of_m, .diagonal = take_room(in, K->n)};
    if (take_byte(in) > 230) {
        s.fails_at = take_byte(in) % 16;
    }
    if (take_byte(in) > 230) {
        s.lies_at = take_byte(in) % 16;
        s.lie = take_any(in);
    }
    return s;
}

#endif
