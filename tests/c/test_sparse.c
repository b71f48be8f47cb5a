/* Sparse matrices against the chain of n equal springs, whose eigenvectors are known in closed form. */
#include "check.h"
#include "linear/sparse.h"

#include <stdlib.h>
#include <string.h>

enum { MOST = 60 };

/* The chain's stiffness tridiag(-1, 2, -1): held at both ends. */
typedef struct chain {
    int32_t start[MOST + 1], indices[3 * MOST];
    double values[3 * MOST];
    aoi_sparse matrix;
    size_t stored;
} chain;

static void chain_make(chain *c, int32_t n)
{
    int32_t stored = 0;
    for (int32_t i = 0; i < n; i++) {
        c->start[i] = stored;
        for (int32_t j = i > 0 ? i - 1 : 0; j <= i + 1 && j < n; j++) {
            c->indices[stored] = j;
            c->values[stored++] = i == j ? 2.0 : -1.0;
        }
    }
    c->start[n] = stored;
    c->stored = (size_t)stored;
    c->matrix = (aoi_sparse){(size_t)n, c->start, c->indices, c->values};
}

static void chain_has_its_eigenvectors(void)
{
    chain c;
    double x[MOST], y[MOST];
    for (int32_t n = 1; n <= MOST; n++) {
        chain_make(&c, n);
        CHECK(aoi_sparse_check(&c.matrix, c.stored) == AOI_OK, "a chain of %d springs", (int)n);
        for (int mode = 1; mode <= n; mode++) {
            const double angle = mode * PI / (n + 1), eigenvalue = 2.0 - 2.0 * cos(angle);
            double worst = 0.0;
            for (int i = 0; i < n; i++) {
                x[i] = sin(angle * (i + 1));
            }
            aoi_sparse_multiply(&c.matrix, x, y);
            for (int i = 0; i < n; i++) {
                worst = fmax(worst, fabs(y[i] - eigenvalue * x[i]));
            }
            const double rounding =
                4.0 * DBL_EPSILON * angle * (n + 1); /* of the sine's argument */
            CHECK(worst < rounding, "mode %d of %d: K x = omega2 x, off by %g", mode, (int)n,
                  worst);
            const double energy = aoi_sparse_quadratic(&c.matrix, x);
            CHECK(fabs(energy - eigenvalue * 0.5 * (n + 1)) < 1e-13 * (n + 1),
                  "mode %d of %d: x K x = omega2 x.x, %g", mode, (int)n, energy);
        }
    }
}

/* Rows of 0, 1, 2, ... 6 entries: every remainder of the unrolled loop, an empty row included. */
static void rows_of_any_length(void)
{
    enum { N = 7 };
    int32_t start[N + 1] = {0}, indices[N * N];
    double values[N * N], x[N], y[N];
    int32_t stored = 0;
    for (int32_t i = 0; i < N; i++) {
        for (int32_t j = 0; j < i; j++) {
            indices[stored] = j;
            values[stored++] = 1.0;
        }
        start[i + 1] = stored;
        x[i] = i + 1.0;
    }
    const aoi_sparse lower = {N, start, indices, values};
    CHECK(aoi_sparse_check(&lower, (size_t)stored) == AOI_OK, "rows of 0 to 6 entries");
    aoi_sparse_multiply(&lower, x, y);
    for (int i = 0; i < N; i++) {
        CHECK(y[i] == 0.5 * i * (i + 1), "row of %d ones", i);
    }
}

static void unreadable_matrices_are_refused(void)
{
    chain c;
    const int32_t n = 5;
    const struct {
        int32_t *where;
        int32_t value;
        const char *what;
    } broken[] = {
        {&c.start[0], 1, "first row does not start at 0"},
        {&c.start[2], 1, "row starts fall"},
        {&c.start[2], 1000, "a row start beyond the entries"},
        {&c.start[5], -1, "negative end"},
        {&c.start[5], 12, "end short of the entries"},
        {&c.start[5], 14, "end beyond the entries"},
        {&c.start[1], INT32_MIN, "most negative start"},
        {&c.indices[4], -1, "negative column"},
        {&c.indices[4], 5, "column n"},
        {&c.indices[12], INT32_MAX, "largest column"},
    };
    for (size_t i = 0; i < sizeof broken / sizeof broken[0]; i++) {
        chain_make(&c, n);
        *broken[i].where = broken[i].value;
        CHECK(aoi_sparse_check(&c.matrix, c.stored) == AOI_ERROR_ARGUMENT, "%s", broken[i].what);
    }
    chain_make(&c, n);
    CHECK(aoi_sparse_check(&c.matrix, c.stored + 1) == AOI_ERROR_ARGUMENT, "one entry too many");
    const int32_t zero = 0;
    const aoi_sparse empty = {0, &zero, NULL, NULL};
    CHECK(aoi_sparse_check(&empty, 0) == AOI_OK, "the empty matrix");
    CHECK(aoi_sparse_quadratic(&empty, NULL) == 0.0, "energy of nothing");
}

int main(void)
{
    chain_has_its_eigenvectors();
    rows_of_any_length();
    unreadable_matrices_are_refused();
    return check_report();
}
