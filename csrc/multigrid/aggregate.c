/* Aggregation of the nodes of a graph to the coarse nodes of smoothed aggregation. */
#include "multigrid/multigrid.h"

enum { FREE = -1 };

/* True if node i and all its neighbours are free. */
static int surrounded_by_free(const int32_t *start, const int32_t *indices,
                              const int32_t *aggregate, size_t i)
{
    if (aggregate[i] != FREE) {
        return 0;
    }
    for (int32_t p = start[i]; p < start[i + 1]; p++) {
        if (aggregate[indices[p]] != FREE) {
            return 0;
        }
    }
    return 1;
}

/* Gives node i and its free neighbours the same aggregate number. */
static void gather(const int32_t *start, const int32_t *indices, int32_t *aggregate, size_t i,
                   size_t number)
{
    aggregate[i] = (int32_t)number;
    for (int32_t p = start[i]; p < start[i + 1]; p++) {
        if (aggregate[indices[p]] == FREE) {
            aggregate[indices[p]] = (int32_t)number;
        }
    }
}

/* Returns the number of an aggregate of the first pass that has a neighbour of node i; FREE if there is none. */
static int32_t beside(const int32_t *start, const int32_t *indices, const int32_t *aggregate,
                      size_t i)
{
    for (int32_t p = start[i]; p < start[i + 1]; p++) {
        if (aggregate[indices[p]] >= 0) {
            return aggregate[indices[p]];
        }
    }
    return FREE;
}

size_t aoi_graph_aggregate(size_t n, const int32_t *start, const int32_t *indices,
                           int32_t *aggregate)
{
    size_t count = 0;
    for (size_t i = 0; i < n; i++) {
        aggregate[i] = FREE;
    }
    for (size_t i = 0; i < n; i++) {
        if (surrounded_by_free(start, indices, aggregate, i)) {
            gather(start, indices, aggregate, i, count++);
        }
    }
    /* Nodes that join an aggregate are marked by numbers below FREE during this pass, so that no chain of nodes
     * joins an aggregate. After the first pass, each free node has a neighbour in an aggregate. */
    for (size_t i = 0; i < n; i++) {
        if (aggregate[i] == FREE) {
            aggregate[i] = FREE - 1 - beside(start, indices, aggregate, i);
        }
    }
    for (size_t i = 0; i < n; i++) {
        if (aggregate[i] < FREE) {
            aggregate[i] = FREE - 1 - aggregate[i];
        }
    }
    return count;
}
