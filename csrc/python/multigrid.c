/* Python binding of the inner loops of multigrid. */
#include "python/binding.h"
#include "multigrid/multigrid.h"

#include <stdlib.h>

static const char PATTERN[] = "aoimpact pattern of blocks";

/* Sparsity pattern of a block matrix. It is checked once: a check in each call would double the time, since a call
 * reads the matrix only once. */
typedef struct pattern {
    call of; /* call that holds the buffers */
    aoi_blocks matrix;
    size_t stored;
} pattern;

static void pattern_free(pattern *made)
{
    call_release(&made->of);
    free(made);
}

static void pattern_end(PyObject *capsule)
{
    pattern_free(PyCapsule_GetPointer(capsule, PATTERN));
}

/* Makes the pattern of a block matrix. args: (order, row starts, indices, block size). */
PyObject *blocks_pattern(PyObject *args)
{
    PyObject *capsule = NULL;
    pattern *made = calloc(1, sizeof *made);
    if (!made) {
        return PyErr_NoMemory();
    }
    call *of = &made->of;
    aoi_blocks *matrix = &made->matrix;
    matrix->n = made->stored = ANY_LENGTH;
    TAKE(of, args, ARRAY('i', matrix->order, matrix->n), LONGER('i', matrix->start, matrix->n, 1),
         ARRAY('i', matrix->indices, made->stored), VALUE('n', matrix->size));
    if (of->status == AOI_OK &&
        (of->status = aoi_blocks_check(matrix, (aoi_part){0, matrix->n}, made->stored)) == AOI_OK) {
        capsule = PyCapsule_New(made, PATTERN, pattern_end);
    } else {
        (void)finish(of, "pattern of blocks", "");
    }
    if (!capsule) {
        pattern_free(made);
    }
    return capsule;
}

/* Arguments shared by the calls that work on some of the rows. */
typedef struct part_call {
    call of;
    aoi_blocks matrix;
    aoi_part part;
    size_t stage, length, entries, works; /* works: number of values per row in a work array */
} part_call;

/* Reads the first three of `size` arguments: the matrix, the rows (begin, end), and the stage, which must be 0 or
 * 1 if product = 1. The matrix is a tuple of `parts` items that begins with its pattern. */
static void take_part(part_call *all, PyObject *args, size_t size, size_t parts, int product)
{
    call *of = &all->of;
    PyObject *described = NULL, *rows = NULL;
    TAKE_SOME(of, args, 0, size, VALUE('t', described), VALUE('t', rows), VALUE('n', all->stage));
    PyObject *capsule = tuple_item(of, described, 0, parts);
    const pattern *made = of->status == AOI_OK ? PyCapsule_GetPointer(capsule, PATTERN) : NULL;
    call_fail(of, made ? AOI_OK : CALL_RAISED);
    TAKE(of, rows, VALUE('n', all->part.begin), VALUE('n', all->part.end));
    if (of->status != AOI_OK) {
        return;
    }
    all->matrix = made->matrix;
    all->length = made->matrix.n * made->matrix.size;
    all->entries = made->stored * made->matrix.size * made->matrix.size;
    all->works = AOI_BLOCKS_WORK * (made->matrix.size + 1);
    if (all->part.begin > all->part.end || all->part.end > made->matrix.n) {
        PyErr_SetString(PyExc_ValueError, "a part must lie within the rows");
        call_fail(of, CALL_RAISED);
    } else if (product && all->stage > 1) {
        PyErr_SetString(PyExc_ValueError, "a stage of a product must be 0 or 1");
        call_fail(of, CALL_RAISED);
    }
    if (parts == 3) { /* the matrix is the tuple (pattern, values, inverse) */
        TAKE_SOME(of, described, 1, 3, ARRAY('f', all->matrix.values, all->entries),
                  MATRIX('f', all->matrix.inverse, all->length, all->matrix.size));
    }
}

/* Computes one stage of y = A x. args: (matrix, part, stage, x, y, work). */
PyObject *blocks_multiply(PyObject *args)
{
    part_call all = {.matrix.n = 0};
    const double *values, *x;
    double *y, *work;
    take_part(&all, args, 6, 2, 1);
    TAKE_SOME(&all.of, tuple_item(&all.of, args, 0, 6), 1, 2, ARRAY('d', values, all.entries));
    TAKE_SOME(&all.of, args, 3, 6, ARRAY('d', x, all.length), ARRAY('D', y, all.length),
              MATRIX('D', work, all.matrix.n, all.works));
    if (all.of.status == AOI_OK) {
        Py_BEGIN_ALLOW_THREADS
        aoi_blocks_multiply(&all.matrix, all.part, (int)all.stage, values, x, y, work);
        Py_END_ALLOW_THREADS
    }
    return finish(&all.of, "product of blocks", "");
}

/* Computes one stage of r -= A x. args: (matrix, part, stage, x, r, work). */
PyObject *blocks_subtract(PyObject *args)
{
    part_call all = {.matrix.n = 0};
    const float *x;
    float *r, *work;
    take_part(&all, args, 6, 3, 1);
    TAKE_SOME(&all.of, args, 3, 6, ARRAY('f', x, all.length), ARRAY('F', r, all.length),
              MATRIX('F', work, all.matrix.n, all.works));
    if (all.of.status == AOI_OK) {
        Py_BEGIN_ALLOW_THREADS
        aoi_blocks_subtract(&all.matrix, all.part, (int)all.stage, x, r, work);
        Py_END_ALLOW_THREADS
    }
    return finish(&all.of, "product of blocks", "");
}

/* Computes one stage of aoi_blocks_smooth. args: (matrix, part, stage, steps, low, high, finish, x, r, work). */
PyObject *blocks_smooth(PyObject *args)
{
    part_call all = {.matrix.n = 0};
    size_t steps;
    int finished;
    double low, high;
    float *x, *r, *work;
    take_part(&all, args, 10, 3, 0);
    TAKE_SOME(&all.of, args, 3, 10, VALUE('n', steps), VALUE('x', low), VALUE('x', high),
              VALUE('p', finished), ARRAY('F', x, all.length), ARRAY('F', r, all.length),
              MATRIX('F', work, all.matrix.n, all.works));
    if (all.of.status == AOI_OK && (Py_ssize_t)steps < 1) {
        all.of.status = AOI_ERROR_ARGUMENT;
    }
    if (all.of.status == AOI_OK) {
        Py_BEGIN_ALLOW_THREADS
        all.of.status = aoi_blocks_smooth(&all.matrix, all.part, all.stage, steps, low, high, finished, x, r, work);
        Py_END_ALLOW_THREADS
    }
    return finish(&all.of, "smoothing", "");
}

/* Aggregates the nodes of a graph by aoi_graph_aggregate. args: (row starts, indices, aggregates). */
PyObject *graph_aggregate(PyObject *args)
{
    call of = {.status = AOI_OK};
    aoi_sparse graph = {.n = ANY_LENGTH};
    size_t stored = ANY_LENGTH, count = 0;
    int32_t *aggregate;
    TAKE(&of, args, LONGER('i', graph.start, graph.n, 1), ARRAY('i', graph.indices, stored),
         ARRAY('I', aggregate, graph.n));
    if (of.status == AOI_OK && (of.status = aoi_sparse_check(&graph, stored)) == AOI_OK) {
        count = aoi_graph_aggregate(graph.n, graph.start, graph.indices, aggregate);
    }
    return finish(&of, "aggregation", "n", (Py_ssize_t)count);
}
