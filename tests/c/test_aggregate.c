/* Aggregates: each is the whole neighbourhood of some node, and what joined it from beside. */
#include "check.h"
#include "multigrid/multigrid.h"

enum { MOST = 400, EDGES = 16 * MOST };

typedef struct graph {
    size_t n;
    int32_t start[MOST + 1], indices[EDGES];
} graph;

static void connect_where(graph *g, size_t n, int (*joined)(size_t i, size_t j))
{
    int32_t stored = 0;
    g->n = n;
    for (size_t i = 0; i < n; i++) {
        g->start[i] = stored;
        for (size_t j = 0; j < n; j++) {
            if (joined(i, j)) {
                g->indices[stored++] = (int32_t)j;
            }
        }
    }
    g->start[n] = stored;
}

static int on_a_line(size_t i, size_t j) { return i == j || i == j + 1 || j == i + 1; }

static int on_a_grid(size_t i, size_t j) /* 20 x 20, four neighbours, itself not stored */
{
    const int across = (int)(i % 20) - (int)(j % 20), along = (int)(i / 20) - (int)(j / 20);
    return across * across + along * along == 1;
}

static int on_a_mixed_grid(size_t i, size_t j) { return on_a_grid(37 * i % MOST, 37 * j % MOST); }

static int alone(size_t i, size_t j) { return i == j; }

static int whole_neighbourhood(const graph *g, const int32_t *aggregate, size_t i)
{
    for (int32_t p = g->start[i]; p < g->start[i + 1]; p++) {
        if (aggregate[g->indices[p]] != aggregate[i]) {
            return 0;
        }
    }
    return 1;
}

/* Whether node i has its aggregate's middle among its neighbours, or one of theirs. */
static int near_a_middle(const graph *g, const int32_t *aggregate, size_t i)
{
    if (whole_neighbourhood(g, aggregate, i)) {
        return 1;
    }
    for (int32_t p = g->start[i]; p < g->start[i + 1]; p++) {
        const size_t j = (size_t)g->indices[p];
        if (aggregate[j] == aggregate[i] && whole_neighbourhood(g, aggregate, j)) {
            return 1;
        }
        for (int32_t q = g->start[j]; q < g->start[j + 1]; q++) {
            const size_t k = (size_t)g->indices[q];
            if (aggregate[k] == aggregate[i] && whole_neighbourhood(g, aggregate, k)) {
                return 1;
            }
        }
    }
    return 0;
}

static void every_node_is_near_the_middle_of_its_aggregate(void)
{
    static graph g;
    int32_t aggregate[MOST];
    int (*const kinds[])(size_t, size_t) = {on_a_line, on_a_grid, on_a_mixed_grid, alone};
    for (size_t kind = 0; kind < 4; kind++) {
        connect_where(&g, MOST, kinds[kind]);
        const size_t count = aoi_graph_aggregate(g.n, g.start, g.indices, aggregate);
        int size[MOST] = {0};
        for (size_t i = 0; i < g.n; i++) {
            CHECK(aggregate[i] >= 0 && (size_t)aggregate[i] < count, "node %d has one", (int)i);
            CHECK(near_a_middle(&g, aggregate, i), "kind %d: node %d", (int)kind, (int)i);
            size[aggregate[i]]++;
        }
        for (size_t a = 0; a < count; a++) {
            CHECK(size[a] >= (kind < 3 ? 2 : 1), "kind %d: aggregate %d", (int)kind, (int)a);
        }
    }
}

static void a_line_falls_into_threes(void)
{
    static graph g;
    int32_t aggregate[11];
    const int32_t expected[11] = {0, 0, 1, 1, 1, 2, 2, 2, 3, 3, 3};
    connect_where(&g, 11, on_a_line);
    CHECK(aoi_graph_aggregate(g.n, g.start, g.indices, aggregate) == 4, "four aggregates");
    for (size_t i = 0; i < 11; i++) {
        CHECK(aggregate[i] == expected[i], "node %d in %d", (int)i, (int)aggregate[i]);
    }
    connect_where(&g, 10, on_a_line);
    CHECK(aoi_graph_aggregate(g.n, g.start, g.indices, aggregate) == 4, "the end's own");
    CHECK(aggregate[9] == aggregate[8], "the end joins its neighbour");
    connect_where(&g, 3, on_a_line);
    CHECK(aoi_graph_aggregate(g.n, g.start, g.indices, aggregate) == 1, "one, and who joins it");
    CHECK(aggregate[2] == 0, "the last node joins it");
}

int main(void)
{
    every_node_is_near_the_middle_of_its_aggregate();
    a_line_falls_into_threes();
    return check_report();
}
