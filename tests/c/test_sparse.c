/* Sparse matrices and their factors against the chain of n equal springs, whose eigenvectors,
 * inverse and factors are known in closed form; and against dense elimination. */
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

/* L D L^T of any dense symmetric matrix, in the core's layout, its panels as wide as they go. */
typedef struct factored {
    int32_t start[MOST + 1], rows[MOST * MOST], place[MOST], panel[MOST + 1];
    double values[MOST * MOST], pivots[MOST], work[MOST];
    aoi_factors factors;
} factored;

static void factored_make(factored *f, int32_t n, double a[MOST][MOST], const int32_t *place)
{
    static double p[MOST][MOST];
    for (int32_t i = 0; i < n; i++) {
        f->place[i] = place[i];
        for (int32_t j = 0; j < n; j++) {
            p[place[i]][place[j]] = a[i][j];
        }
    }
    int32_t stored = 0;
    for (int32_t j = 0; j < n; j++) {
        f->start[j] = stored;
        f->pivots[j] = p[j][j];
        for (int32_t i = j + 1; i < n; i++) {
            const double l = p[i][j] / p[j][j];
            for (int32_t k = j + 1; k < n; k++) {
                p[i][k] -= l * p[j][k];
            }
            if (l != 0.0) {
                f->rows[stored] = i;
                f->values[stored++] = l;
            }
        }
    }
    f->start[n] = stored;
    const size_t panels = aoi_factors_find_panels((size_t)n, f->start, f->rows, f->panel);
    f->factors = (aoi_factors){(size_t)n, f->start, f->rows, f->values, f->pivots,
                               f->place,  f->panel, panels,  f->work, NULL};
}

static void chain_under_its_own_weight_is_a_parabola(void)
{
    static double a[MOST][MOST];
    static factored f;
    int32_t place[MOST];
    double x[MOST];
    for (int32_t n = 1; n <= MOST; n += n < 8 ? 1 : 13) {
        memset(a, 0, sizeof a);
        for (int32_t i = 0; i < n; i++) {
            a[i][i] = 2.0;
            if (i > 0) {
                a[i][i - 1] = a[i - 1][i] = -1.0;
            }
        }
        for (int order = 0; order < 3; order++) {
            for (int32_t i = 0; i < n; i++) {
                place[i] = order == 0 ? i : order == 1 ? n - 1 - i : (i % 2 ? i / 2 : (n + i) / 2);
                x[i] = 1.0;
            }
            factored_make(&f, n, a, place);
            CHECK(aoi_factors_check(&f.factors, (size_t)f.start[n]) == AOI_OK, "n = %d", (int)n);
            CHECK(order > 0 || near(f.pivots[n - 1], (n + 1.0) / n, 1e-13),
                  "last pivot of the chain is (n+1)/n, not %g", f.pivots[n - 1]);
            CHECK(aoi_factors_solve(&f.factors, x) == AOI_OK, "n = %d", (int)n);
            double worst = 0.0;
            for (int32_t i = 0; i < n; i++) {
                worst = fmax(worst, fabs(x[i] / (0.5 * (i + 1) * (n - i)) - 1.0));
            }
            CHECK(worst < 1e-13, "deflection i(n+1-i)/2 of %d springs, order %d: off by %g", (int)n, order,
                  worst);
        }
    }
}

static void dense_matrices_solve_as_elimination_does(void)
{
    static double a[MOST][MOST], root[MOST][MOST];
    static factored f;
    uint64_t seed = 7;
    int32_t place[MOST];
    double x[MOST], wanted[MOST];
    for (int32_t n = 1; n <= 40; n += 3) {
        for (int32_t i = 0; i < n; i++) {
            wanted[i] = 2.0 * uniform(&seed) - 1.0;
            place[i] = (int32_t)((7 * i + 3) % n);
            for (int32_t j = 0; j < n; j++) {
                root[i][j] = 2.0 * uniform(&seed) - 1.0;
            }
        }
        if (n % 7 == 0) {
            for (int32_t i = 0; i < n; i++) {
                place[i] = n - 1 - i;
            }
        }
        for (int32_t i = 0; i < n; i++) {
            x[i] = 0.0;
            for (int32_t j = 0; j < n; j++) {
                a[i][j] = i == j ? (double)n : 0.0;
                for (int32_t k = 0; k < n; k++) {
                    a[i][j] += root[i][k] * root[j][k];
                }
                x[i] += a[i][j] * wanted[j];
            }
        }
        factored_make(&f, n, a, place);
        CHECK(aoi_factors_check(&f.factors, (size_t)f.start[n]) == AOI_OK, "n = %d", (int)n);
        aoi_factors_solve(&f.factors, x);
        double worst = 0.0;
        for (int32_t i = 0; i < n; i++) {
            worst = fmax(worst, fabs(x[i] - wanted[i]));
        }
        CHECK(worst < 1e-13, "n = %d: A^-1 A x = x, off by %g", (int)n, worst);
    }
}

/* The chain's factor has one entry a column: only its last two columns are of like pattern. */
static void panels_are_found_where_patterns_are_alike(void)
{
    const int32_t start[] = {0, 1, 2, 3, 4, 4}, rows[] = {1, 2, 3, 4};
    const int32_t apart[] = {0, 1, 2, 2, 2}, far_rows[] = {2, 3};
    int32_t panel[6];
    CHECK(aoi_factors_find_panels(5, start, rows, panel) == 4 && panel[3] == 3 && panel[4] == 5,
          "a chain of five: its last two masses");
    CHECK(aoi_factors_find_panels(4, apart, far_rows, panel) == 4, "no neighbours at all");
    CHECK(aoi_factors_find_panels(0, start, rows, panel) == 0 && panel[0] == 0, "nothing");
}

static void panels_that_do_not_fit_are_refused(void)
{
    static double a[MOST][MOST];
    static factored f;
    const int32_t n = 6, place[] = {0, 1, 2, 3, 4, 5};
    const int32_t bad[][4] = {/* panel_count, then panel[1], [2], [3] */
                              {0, 6, 6, 6}, {1, 5, 6, 6},        {1, 7, 6, 6},      {2, 0, 6, 6},
                              {2, 6, 6, 6}, {2, -1, 6, 6},       {2, 100000, 6, 6}, {3, 4, 3, 6},
                              {2, 7, 6, 6}, {2, INT32_MAX, 6, 6}};
    for (int32_t i = 0; i < n; i++) {
        for (int32_t j = 0; j < n; j++) {
            a[i][j] = i == j ? 10.0 : 1.0;
        }
    }
    const size_t bytes = (size_t)(n + 1) * sizeof(int32_t);
    int32_t *exact = malloc(bytes);
    if (!exact) {
        CHECK(0, "no memory");
        return;
    }
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++) {
        factored_make(&f, n, a, place);
        memcpy(exact, f.start, bytes); /* a read past its end is caught */
        f.factors.start = exact;
        f.factors.panel_count = (size_t)bad[i][0];
        memcpy(f.panel + 1, bad[i] + 1, 3 * sizeof(int32_t));
        CHECK(aoi_factors_check(&f.factors, (size_t)f.start[n]) == AOI_ERROR_ARGUMENT,
              "%d panels to %d, %d, %d", (int)bad[i][0], (int)bad[i][1], (int)bad[i][2],
              (int)bad[i][3]);
    }
    free(exact);
    factored_make(&f, n, a, place);
    f.panel[0] = 1;
    CHECK(aoi_factors_check(&f.factors, (size_t)f.start[n]) == AOI_ERROR_ARGUMENT,
          "not from column 0");
    for (int32_t i = 0; i < n; i++) { /* a chain: no two columns alike but the last */
        for (int32_t j = 0; j < n; j++) {
            a[i][j] = i == j ? 3.0 : i == j + 1 || j == i + 1 ? -1.0 : 0.0;
        }
    }
    factored_make(&f, n, a, place);
    f.factors.panel_count = 1;
    f.panel[1] = n;
    CHECK(aoi_factors_check(&f.factors, (size_t)f.start[n]) == AOI_ERROR_ARGUMENT,
          "columns of different patterns are no panel");
}

static void unusable_factors_are_refused(void)
{
    static double a[MOST][MOST];
    static factored f;
    const int32_t n = 4, place[] = {0, 1, 2, 3};
    for (int32_t i = 0; i < n; i++) {
        for (int32_t j = 0; j < n; j++) {
            a[i][j] = i == j ? 4.0 : 1.0;
        }
    }
    const struct {
        int32_t *where;
        int32_t value;
        const char *what;
    } broken[] = {
        {&f.rows[0], 0, "an entry on the diagonal"},
        {&f.rows[3], 0, "an entry above it"},
        {&f.rows[2], 4, "row n"},
        {&f.rows[2], -1, "negative row"},
        {&f.place[1], 4, "place n"},
        {&f.place[1], -1, "negative place"},
        {&f.place[1], place[0], "a place for two"},
        {&f.start[0], 1, "does not start at 0"},
        {&f.start[2], 2, "starts fall"},
        {&f.start[4], 7, "beyond the entries"},
    };
    for (size_t i = 0; i < sizeof broken / sizeof broken[0]; i++) {
        factored_make(&f, n, a, place);
        f.factors.panel_count = 4; /* a column each, so that panels have nothing to object to */
        for (int32_t j = 0; j <= n; j++) {
            f.panel[j] = j;
        }
        *broken[i].where = broken[i].value;
        CHECK(aoi_factors_check(&f.factors, 6) == AOI_ERROR_ARGUMENT, "%s", broken[i].what);
    }
    const double pivots[] = {0.0, -1.0, (double)NAN};
    for (size_t i = 0; i < 3; i++) {
        factored_make(&f, n, a, place);
        f.pivots[2] = pivots[i];
        CHECK(aoi_factors_check(&f.factors, 6) == AOI_ERROR_NOT_POSITIVE, "pivot %g", pivots[i]);
    }
}

/* A dense matrix is one panel, whatever its width leaves over when swept four columns at a time;
 * cut into any other panels it has the same inverse. */
static void panels_do_not_change_the_solution(void)
{
    static double a[MOST][MOST];
    static factored f;
    uint64_t seed = 21;
    int32_t place[MOST];
    double x[MOST];
    for (int32_t n = 1; n <= 23; n++) {
        /* min(i, j): a rod's compliance, whose solution to a load at its end is a unit there. */
        for (int32_t i = 0; i < n; i++) {
            place[i] = i;
            for (int32_t j = 0; j < n; j++) {
                a[i][j] = 1.0 + (i < j ? i : j);
            }
        }
        factored_make(&f, n, a, place);
        CHECK(f.factors.panel_count == 1 && f.panel[1] == n, "a dense matrix is one panel");
        for (int cut = 0; cut < 6; cut++) {
            for (int32_t i = 0; i < n; i++) {
                x[i] = i + 1.0;
            }
            aoi_factors_solve(&f.factors, x);
            double worst = fabs(x[n - 1] - 1.0);
            for (int32_t i = 0; i + 1 < n; i++) {
                worst = fmax(worst, fabs(x[i]));
            }
            CHECK(worst < 1e-13, "%d columns in %zu panels: off by %g", (int)n,
                  f.factors.panel_count, worst);
            f.factors.panel_count = 0;
            for (int32_t j = 1; j <= n; j++) {
                if (j == n || cut == 0 || uniform(&seed) < 0.15 * cut) {
                    f.panel[++f.factors.panel_count] = j;
                }
            }
            CHECK(aoi_factors_check(&f.factors, (size_t)f.start[n]) == AOI_OK, "cut %d of %d", cut,
                  (int)n);
        }
    }
}

int main(void)
{
    chain_has_its_eigenvectors();
    rows_of_any_length();
    unreadable_matrices_are_refused();
    chain_under_its_own_weight_is_a_parabola();
    dense_matrices_solve_as_elimination_does();
    panels_are_found_where_patterns_are_alike();
    panels_that_do_not_fit_are_refused();
    unusable_factors_are_refused();
    panels_do_not_change_the_solution();
    return check_report();
}
