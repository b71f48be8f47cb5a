/* Smoothing on T (x) S, with T the chain of springs tridiag(-1, 2, -1), whose eigenvectors are sines,
 * and S = 1 + ones: what Chebyshev steps leave of each eigenvector is known in closed form. */
#include "check.h"
#include "multigrid/multigrid.h"

enum { NODES = 20, STORED = 3 * NODES, WIDEST = AOI_BLOCKS_WIDEST, PARTS = 3 };
enum { WORK = AOI_BLOCKS_WORK * NODES * (WIDEST + 1) };

typedef struct chain {
    int32_t order[NODES], start[NODES + 1], indices[STORED];
    float values[STORED * WIDEST * WIDEST], inverse[NODES * WIDEST * WIDEST];
    aoi_blocks matrix;
    size_t stored, count;
    aoi_part parts[PARTS];
} chain;

static void chain_store(chain *c, int32_t i, int32_t j)
{
    const size_t size = c->matrix.size;
    for (size_t k = 0; k < size * size; k++) {
        const float entry = k % (size + 1) == 0 ? 2.0f : 1.0f; /* of S */
        c->values[size * size * c->stored + k] = i == j ? 2.0f * entry : -entry;
    }
    c->indices[c->stored++] = j;
}

/* Rows beside each other, as slabs of a mesh have them, but for some that stand in the next part. */
static size_t part_of(size_t count, int32_t i)
{
    const size_t slab = (size_t)i * count / NODES;
    return i % 7 == 5 ? (slab + 1) % count : slab;
}

static void chain_make(chain *c, size_t size, size_t count)
{
    int32_t rows = 0;
    *c = (chain){.matrix = {NODES, size, c->order, c->start, c->indices, c->values, c->inverse},
                 .count = count};
    for (size_t part = 0; part < count; part++) {
        c->parts[part].begin = (size_t)rows;
        for (int32_t i = 0; i < NODES; i++) {
            if (part_of(count, i) != part) {
                continue;
            }
            c->start[rows] = (int32_t)c->stored;
            c->order[rows++] = i;
            for (int32_t j = i - 1; j <= i + 1; j += 2) {
                if (j >= 0 && j < NODES && part_of(count, j) != part) {
                    chain_store(c, i, j);
                }
            }
            chain_store(c, i, i);
            if (i + 1 < NODES && part_of(count, i + 1) == part) {
                chain_store(c, i, i + 1);
            }
        }
        c->parts[part].end = (size_t)rows;
    }
    c->start[NODES] = (int32_t)c->stored;
    for (size_t k = 0; k < NODES * size * size; k++) { /* (1 + ones)^-1 = 1 - ones/(1 + size) */
        const double off = -1.0 / (1.0 + (double)size);
        c->inverse[k] = (float)(0.5 * (k % (size * size) % (size + 1) == 0 ? 1.0 + off : off));
    }
}

/* Parts of odd stages from the last one on: their order does not matter. */
static aoi_part turn(const chain *c, size_t stage, size_t part)
{
    return c->parts[stage % 2 ? c->count - 1 - part : part];
}

static void subtract(const chain *c, const float *x, float *r, float *work)
{
    for (int stage = 0; stage < 2; stage++) {
        for (size_t part = 0; part < c->count; part++) {
            aoi_blocks_subtract(&c->matrix, turn(c, (size_t)stage, part), stage, x, r, work);
        }
    }
}

static int smooth(const chain *c, size_t steps, double low, double high, int finish, float *x, float *r, float *work)
{
    int status = AOI_OK;
    for (size_t stage = 0; stage <= steps; stage++) {
        for (size_t part = 0; part < c->count && status == AOI_OK; part++) {
            status = aoi_blocks_smooth(&c->matrix, turn(c, stage, part), stage, steps, low, high, finish, x, r, work);
        }
    }
    return status;
}

static int sound(const chain *c)
{
    for (size_t part = 0; part < c->count; part++) {
        if (aoi_blocks_check(&c->matrix, c->parts[part], c->stored) != AOI_OK) {
            return 0;
        }
    }
    return 1;
}

/* Mode (k, ones) has the eigenvalue (2 - 2 cos) (1 + size); (k, 1 -1 0 ...) has 2 - 2 cos. */
static void mode(float *x, size_t size, int k, int alternating)
{
    for (size_t i = 0; i < NODES * size; i++) {
        const double shape = alternating ? (i % size == 0) - (double)(i % size == 1) : 1.0;
        x[i] = (float)(shape * sin(k * PI * (double)(i / size + 1) / (NODES + 1)));
    }
}

static double farthest(size_t count, const float *x, double factor, const float *y)
{
    double worst = 0.0;
    for (size_t i = 0; i < count; i++) {
        worst = fmax(worst, fabs(x[i] - factor * y[i]));
    }
    return worst;
}

static void products_have_the_eigenvectors(size_t parts)
{
    chain c;
    float x[NODES * WIDEST], r[NODES * WIDEST], work[WORK];
    for (size_t size = 1; size <= WIDEST; size++) {
        chain_make(&c, size, parts);
        CHECK(sound(&c), "blocks of %d", (int)size);
        for (int k = 1; k <= NODES; k++) {
            for (int alternating = 0; alternating < (size > 1 ? 2 : 1); alternating++) {
                const double value = 2.0 - 2.0 * cos(k * PI / (NODES + 1));
                const double eigenvalue = alternating ? value : value * (1.0 + (double)size);
                mode(x, size, k, alternating);
                mode(r, size, k, alternating);
                subtract(&c, x, r, work);
                CHECK(farthest(NODES * size, r, 1.0 - eigenvalue, x) < 2e-6 * (1.0 + (double)size),
                      "blocks of %d, mode %d: x - A x", (int)size, k);
            }
        }
    }
}

/* Against the sum over all entries, with blocks that are not symmetric and columns far and near. */
static void blocks_left_of_the_diagonal_are_those_right_of_it_transposed(void)
{
    static const int32_t start[] = {0, 3, 5, 7, 9, 10}, indices[] = {0, 2, 4, 1, 2, 2, 3, 3, 4, 4};
    static const int32_t order[] = {0, 1, 2, 3, 4};
    static const aoi_part all = {0, 5};
    enum { ROWS = 5, BLOCKS = 10 };
    double values[BLOCKS * WIDEST * WIDEST], x[ROWS * WIDEST], y[ROWS * WIDEST], work[WORK];
    float single[BLOCKS * WIDEST * WIDEST], x_single[ROWS * WIDEST], r[ROWS * WIDEST], work_single[WORK];
    for (size_t b = 1; b <= WIDEST; b++) {
        const aoi_blocks matrix = {ROWS, b, order, start, indices, single, NULL};
        double exact[ROWS * WIDEST] = {0.0};
        for (size_t k = 0; k < ROWS * b; k++) {
            x[k] = x_single[k] = (float)sin(1.0 + (double)k);
            r[k] = 0.0f;
        }
        for (size_t i = 0; i < ROWS; i++) {
            for (size_t p = (size_t)start[i]; p < (size_t)start[i + 1]; p++) {
                const size_t j = (size_t)indices[p];
                for (size_t k = 0; k < b * b; k++) {
                    const size_t turned = i == j ? b * (k % b) + k / b : k;
                    const double entry = sin((double)(k < turned ? k : turned) + 9.0 * (double)p);
                    values[b * b * p + k] = single[b * b * p + k] = (float)entry;
                    exact[b * i + k / b] += (float)entry * x[b * j + k % b];
                    exact[b * j + k % b] += i == j ? 0.0 : (float)entry * x[b * i + k / b];
                }
            }
        }
        CHECK(aoi_blocks_check(&matrix, all, BLOCKS) == AOI_OK, "blocks of %d", (int)b);
        for (int stage = 0; stage < 2; stage++) {
            aoi_blocks_multiply(&matrix, all, stage, values, x, y, work);
            aoi_blocks_subtract(&matrix, all, stage, x_single, r, work_single);
        }
        for (size_t k = 0; k < ROWS * b; k++) {
            CHECK(fabs(y[k] - exact[k]) < 1e-14, "blocks of %d, row %d", (int)b, (int)k);
            CHECK(fabs(r[k] + exact[k]) < 5e-6, "blocks of %d, row %d, single", (int)b, (int)k);
        }
    }
}

static double chebyshev(size_t degree, double x)
{
    double before = 1.0, now = x;
    for (size_t k = 1; k < degree; k++) {
        const double next = 2.0 * x * now - before;
        before = now;
        now = next;
    }
    return now;
}

/* For f = 0 the iterate is the error: it shrinks by T_k((theta - lambda)/delta) / T_k(theta/delta),
 * with lambda of D^-1 A, here 1 - cos. */
static void steps_damp_as_chebyshev_polynomials(size_t parts)
{
    const double low = 0.25, high = 2.1, middle = 0.5 * (low + high), half = 0.5 * (high - low);
    chain c;
    float x[NODES * WIDEST], before[NODES * WIDEST], r[NODES * WIDEST], exact[NODES * WIDEST];
    float work[WORK];
    for (size_t size = 1; size <= WIDEST; size++) {
        const size_t n = NODES * size;
        chain_make(&c, size, parts);
        for (size_t steps = 1; steps <= 5; steps++) {
            for (int k = 1; k <= NODES; k += 3) {
                const double value = 1.0 - cos(k * PI / (NODES + 1));
                const double left = chebyshev(steps, (middle - value) / half) /
                                    chebyshev(steps, middle / half);
                mode(x, size, k, 0);
                mode(before, size, k, 0);
                for (size_t i = 0; i < n; i++) {
                    r[i] = 0.0f;
                }
                subtract(&c, x, r, work);
                CHECK(smooth(&c, steps, low, high, 1, x, r, work) == AOI_OK, "%d steps", (int)steps);
                CHECK(farthest(n, x, left, before) < 1e-5, "blocks of %d, %d steps: mode %d, by %g",
                      (int)size, (int)steps, k, left);
                for (size_t i = 0; i < n; i++) {
                    exact[i] = 0.0f;
                }
                subtract(&c, x, exact, work);
                CHECK(farthest(n, r, 1.0, exact) < 2e-5, "finished: r = f - A x");
            }
        }
    }
}

static void unfinished_smoothing_does_the_same_to_x(void)
{
    chain c;
    float x[3 * NODES], y[3 * NODES], r[3 * NODES], s[3 * NODES], work[WORK];
    chain_make(&c, 3, 1);
    for (size_t i = 0; i < 3 * NODES; i++) {
        x[i] = y[i] = 0.0f;
        r[i] = s[i] = (float)sin((double)i);
    }
    smooth(&c, 3, 0.2, 2.0, 1, x, r, work);
    smooth(&c, 3, 0.2, 2.0, 0, y, s, work);
    CHECK(farthest(3 * NODES, x, 1.0, y) == 0.0, "x with and without the last residual");
    CHECK(farthest(3 * NODES, r, 1.0, s) > 0.0, "the residual is one product behind");
}

static void what_is_no_interval_is_refused(void)
{
    chain c;
    float x[NODES] = {0.0f}, r[NODES] = {0.0f}, work[WORK];
    chain_make(&c, 1, 1);
    CHECK(smooth(&c, 3, 0.0, 2.0, 1, x, r, work) == AOI_ERROR_ARGUMENT, "low 0");
    CHECK(smooth(&c, 3, 2.0, 2.0, 1, x, r, work) == AOI_ERROR_ARGUMENT, "empty");
    CHECK(smooth(&c, 0, 1.0, 2.0, 1, x, r, work) == AOI_ERROR_ARGUMENT, "no step");
    CHECK(aoi_blocks_smooth(&c.matrix, c.parts[0], 4, 3, 1.0, 2.0, 1, x, r, work) == AOI_ERROR_ARGUMENT,
          "no such stage");
}

static void what_cannot_be_read_is_refused(void)
{
    chain c;
    chain_make(&c, 1, 1);
    CHECK(sound(&c), "whole");
    c.matrix.size = WIDEST + 1;
    CHECK(!sound(&c), "too wide a block");
    c.matrix.size = 0;
    CHECK(!sound(&c), "no block");
    c.matrix.size = 1;
    c.parts[0].end = NODES + 1;
    CHECK(!sound(&c), "a row that is not there");
    c.parts[0] = (aoi_part){3, 2};
    CHECK(!sound(&c), "an end before the beginning");
    c.parts[0] = (aoi_part){0, NODES};
    c.order[3] = NODES;
    CHECK(!sound(&c), "a number of a row that is not there");
    c.order[3] = -1;
    CHECK(!sound(&c), "a negative number of a row");
    c.order[3] = 3;
    c.start[NODES] = (int32_t)c.stored + 1;
    CHECK(!sound(&c), "a row that ends behind all blocks");
    c.start[NODES] = (int32_t)c.stored;
    c.start[0] = -1;
    CHECK(!sound(&c), "a row that begins before all blocks");
    c.start[0] = 0;
    c.indices[5] = NODES;
    CHECK(!sound(&c), "a column that is not there");
    c.indices[5] = -1;
    CHECK(!sound(&c), "a negative column");
    c.indices[5] = 1;
    CHECK(!sound(&c), "a block left of the diagonal, behind it");
    c.indices[5] = 2;
    CHECK(!sound(&c), "the diagonal twice");
    c.indices[5] = 3;
    CHECK(sound(&c), "as it was");
    c.indices[4] = 3;
    CHECK(!sound(&c), "a row without a diagonal");
    c.indices[4] = 2;
    c.stored++;
    CHECK(!sound(&c), "a block behind the last diagonal one");
}

int main(void)
{
    for (size_t parts = 1; parts <= PARTS; parts++) {
        products_have_the_eigenvectors(parts);
        steps_damp_as_chebyshev_polynomials(parts);
    }
    blocks_left_of_the_diagonal_are_those_right_of_it_transposed();
    unfinished_smoothing_does_the_same_to_x();
    what_is_no_interval_is_refused();
    what_cannot_be_read_is_refused();
    return check_report();
}
