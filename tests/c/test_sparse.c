/* Sparse matrices that cannot be read. What these are multiplied by test_full.c compares with natural modes. */
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
    unreadable_matrices_are_refused();
    return check_report();
}
