/* Sparse matrices, blocks and graphs: what their checks let through can be used. */
#include "fuzz.h"
#include "multigrid/multigrid.h"
#include "linear/sparse.h"

enum { MOST = 7 };

/* n + 1 starts, mostly ascending from 0; stored: the last. */
static int32_t *take_starts(input *in, size_t n, size_t *stored)
{
    int32_t *start = take_bytes(in, n + 1, sizeof *start);
    for (size_t i = 0; i < n; i++) {
        start[i + 1] = start[i] + (int32_t)take_below(in, n + 1);
    }
    *stored = (size_t)start[n];
    if (take_byte(in) > 240) {
        start[take_below(in, n + 1)] = (int32_t)(take_byte(in) << 24 | take_byte(in));
    }
    return start;
}

static int32_t *take_indices(input *in, size_t count, size_t n)
{
    int32_t *of = take_bytes(in, count, sizeof *of);
    for (size_t p = 0; p < count; p++) {
        of[p] = (int32_t)take_below(in, n);
    }
    if (count > 0 && take_byte(in) > 240) {
        of[take_below(in, count)] = (int32_t)(take_byte(in) << 24 | take_byte(in));
    }
    return of;
}

static void of_matrix(input *in)
{
    size_t stored;
    const size_t n = take_below(in, MOST);
    aoi_sparse matrix = {.n = n, .start = take_starts(in, n, &stored)};
    matrix.indices = take_indices(in, stored, n);
    matrix.values = take_array(in, stored, take_any);
    const double *x = take_array(in, n, take_any);
    double *y = take_room(in, n);
    if (aoi_sparse_check(&matrix, stored) != AOI_OK) {
        return;
    }
    aoi_sparse_multiply(&matrix, x, y);
    (void)aoi_sparse_quadratic(&matrix, x);
}

static float *take_floats(input *in, size_t count)
{
    float *of = take_bytes(in, count, sizeof *of);
    for (size_t i = 0; i < count; i++) {
        of[i] = (float)((double)take_byte(in) - 128.0);
    }
    return of;
}

/* In each row a block of any column, the diagonal one, and then what is right of it. */
static void order_rows(size_t n, const int32_t *start, size_t stored, int32_t *order, int32_t *indices)
{
    for (size_t i = 0; i < n; i++) {
        order[i] = (int32_t)i;
        for (int32_t p = start[i]; p >= 0 && (size_t)p < stored && p < start[i + 1]; p++) {
            const int32_t from = p - start[i], last = start[i + 1] - start[i] == 1;
            const int32_t right = (int32_t)i + 1 + (indices[p] & 1);
            indices[p] = from == 1 || last ? (int32_t)i : from == 0 ? indices[p] : right;
        }
    }
}

static void use_blocks(input *in, const aoi_blocks *matrix, size_t stored)
{
    const size_t n = matrix->n, size = matrix->size, room = AOI_BLOCKS_WORK * n * (size + 1);
    const size_t steps = take_below(in, 5), cut = take_below(in, (unsigned)n + 1);
    const aoi_part parts[] = {{0, cut}, {cut, n}};
    double *values = take_room(in, size * size * stored), *exact = take_array(in, n * size, take_any);
    double *product = take_room(in, n * size), *wide = take_room(in, room);
    float *x = take_floats(in, n * size), *r = take_floats(in, n * size), *work = take_floats(in, room);
    const double low = take_byte(in) % 8 ? 0.1 : take_any(in), high = take_byte(in) % 8 ? 2.0 : take_any(in);
    const int finish = take_byte(in) & 1;
    for (size_t call = 0; call < 2 * (steps + 1); call++) {
        const aoi_part part = parts[call % 2];
        const int stage = call / 2 > 0;
        aoi_blocks_multiply(matrix, part, stage, values, exact, product, wide);
        aoi_blocks_subtract(matrix, part, stage, x, r, work);
        (void)aoi_blocks_smooth(matrix, part, call / 2, steps, low, high, finish, x, r, work);
    }
}

static void of_blocks(input *in)
{
    size_t stored;
    const size_t n = take_below(in, 4), size = take_between(in, 1, AOI_BLOCKS_WIDEST);
    aoi_blocks matrix = {.n = n, .size = size, .start = take_starts(in, n, &stored)};
    int32_t *indices = take_indices(in, stored, n), *order = take_indices(in, n, n);
    if (take_byte(in) % 8) {
        order_rows(n, matrix.start, stored, order, indices);
    }
    matrix.order = order;
    matrix.indices = indices;
    matrix.values = take_floats(in, size * size * stored);
    matrix.inverse = take_floats(in, size * size * n);
    if (aoi_blocks_check(&matrix, (aoi_part){0, n}, stored) == AOI_OK) {
        use_blocks(in, &matrix, stored);
    }
}

/* Edges in both directions: every node is in an aggregate, and its number below their count. */
static void of_graph(input *in)
{
    enum { NODES = 12 };
    const size_t n = take_below(in, NODES);
    unsigned char edge[NODES][NODES] = {{0}};
    int32_t *start = take_bytes(in, n + 1, sizeof *start), *all = take_bytes(in, n * n, sizeof *all);
    int32_t *aggregate = take_bytes(in, n, sizeof *aggregate);
    for (size_t i = 0; i < n; i++) {
        for (size_t j = i; j < n; j++) {
            edge[i][j] = edge[j][i] = take_byte(in) % 3 == 0;
        }
    }
    for (size_t i = 0; i < n; i++) {
        start[i + 1] = start[i];
        for (size_t j = 0; j < n; j++) {
            if (edge[i][j]) {
                all[start[i + 1]++] = (int32_t)j;
            }
        }
    }
    const size_t count = aoi_graph_aggregate(n, start, all, aggregate);
    REQUIRE(count <= n && (n == 0 || count > 0));
    for (size_t i = 0; i < n; i++) {
        REQUIRE(aggregate[i] >= 0 && (size_t)aggregate[i] < count);
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    input in = open_input(data, size);
    switch (take_below(&in, 3)) {
    case 0:
        of_matrix(&in);
        break;
    case 1:
        of_blocks(&in);
        break;
    default:
        of_graph(&in);
    }
    close_input(&in);
    return 0;
}
