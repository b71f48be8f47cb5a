/* The inner loops of multigrid, for Python. */
#include "python/binding.h"
#include "multigrid/multigrid.h"

#include <stdlib.h>

static const char PATTERN[] = "aoimpact pattern of blocks";

/* What has been checked once, for all calls, of which each reads the matrix once. */
typedef struct pattern {
    buffer_list buffers;
    aoi_blocks matrix;
    size_t stored;
} pattern;

static void pattern_free(pattern *made)
{
    buffers_release(&made->buffers);
    free(made);
}

static void pattern_end(PyObject *capsule)
{
    pattern_free(PyCapsule_GetPointer(capsule, PATTERN));
}

static int pattern_check(pattern *made, PyObject *order_in, PyObject *start_in, PyObject *indices_in)
{
    size_t rows = (size_t)-1, starts = (size_t)-1;
    aoi_blocks *matrix = &made->matrix;
    made->stored = (size_t)-1;
    matrix->order = integers(&made->buffers, order_in, "order", &rows);
    matrix->start = integers(&made->buffers, start_in, "row starts", &starts);
    matrix->indices = integers(&made->buffers, indices_in, "indices", &made->stored);
    matrix->n = rows;
    if (made->buffers.failed) {
        return AOI_OK;
    }
    return starts == rows + 1 ? aoi_blocks_check(matrix, (aoi_part){0, rows}, made->stored)
                              : AOI_ERROR_ARGUMENT;
}

PyObject *blocks_pattern(PyObject *self, PyObject *args)
{
    PyObject *order_in, *start_in, *indices_in;
    int size;
    (void)self;
    if (!PyArg_ParseTuple(args, "OOOi", &order_in, &start_in, &indices_in, &size)) {
        return NULL;
    }
    pattern *made = calloc(1, sizeof *made);
    if (!made) {
        return PyErr_NoMemory();
    }
    made->matrix.size = size > 0 ? (size_t)size : 0;
    const int status = pattern_check(made, order_in, start_in, indices_in);
    PyObject *capsule = NULL;
    if (!made->buffers.failed && status != AOI_OK) {
        raise_status(status, "pattern of blocks", -1.0);
    } else if (!made->buffers.failed) {
        capsule = PyCapsule_New(made, PATTERN, pattern_end);
    }
    if (!capsule) {
        pattern_free(made);
    }
    return capsule;
}

/* A call on some rows, in some stage. */
typedef struct part_call {
    buffer_list buffers;
    aoi_blocks matrix;
    aoi_part part;
    int stage;
    size_t length, entries;
} part_call;

/* The pattern that a matrix, a tuple of so many, begins with. */
static void take_pattern(part_call *call, PyObject *tuple, Py_ssize_t size)
{
    need_tuple(&call->buffers, tuple, size);
    const pattern *made =
        call->buffers.failed ? NULL : PyCapsule_GetPointer(PyTuple_GetItem(tuple, 0), PATTERN);
    if (!made) {
        call->buffers.failed = 1;
        return;
    }
    call->matrix = made->matrix;
    call->length = made->matrix.n * made->matrix.size;
    call->entries = made->stored * made->matrix.size * made->matrix.size;
    if (call->part.begin > call->part.end || call->part.end > made->matrix.n) {
        PyErr_SetString(PyExc_ValueError, "a part must lie within the rows");
        call->buffers.failed = 1;
    }
}

/* (pattern, values, inverse). */
static void take_blocks(part_call *call, PyObject *tuple)
{
    take_pattern(call, tuple, 3);
    if (!call->buffers.failed) {
        size_t diagonal = call->length * call->matrix.size;
        call->matrix.values =
            buffers_take(&call->buffers, PyTuple_GetItem(tuple, 1), "values", 'f', 0, &call->entries);
        call->matrix.inverse =
            buffers_take(&call->buffers, PyTuple_GetItem(tuple, 2), "inverse", 'f', 0, &diagonal);
    }
}

/* Of a product, which has two. */
static void need_stage(part_call *call)
{
    if (!call->buffers.failed && call->stage != 0 && call->stage != 1) {
        PyErr_SetString(PyExc_ValueError, "a stage of a product must be 0 or 1");
        call->buffers.failed = 1;
    }
}

static void *take_work(part_call *call, PyObject *work_out, char type)
{
    size_t length = AOI_BLOCKS_WORK * call->matrix.n * (call->matrix.size + 1);
    return buffers_take(&call->buffers, work_out, "work", type, 1, &length);
}

/* (begin, end) of rows, for PyArg_ParseTuple; beyond all rows where a number is negative. */
static int to_part(PyObject *object, void *found)
{
    Py_ssize_t begin, end;
    aoi_part *part = found;
    if (!PyTuple_Check(object)) {
        PyErr_SetString(PyExc_TypeError, "a part must be a tuple (begin, end)");
        return 0;
    }
    if (!PyArg_ParseTuple(object, "nn", &begin, &end)) {
        return 0;
    }
    *part = (aoi_part){(size_t)begin, (size_t)end};
    return 1;
}

PyObject *blocks_multiply(PyObject *self, PyObject *args)
{
    PyObject *matrix_in, *x_in, *y_out, *work_out;
    part_call call = {.matrix.n = 0};
    const double *values = NULL;
    (void)self;
    if (!PyArg_ParseTuple(args, "O!O&iOOO", &PyTuple_Type, &matrix_in, to_part, &call.part, &call.stage,
                          &x_in, &y_out, &work_out)) {
        return NULL;
    }
    take_pattern(&call, matrix_in, 2);
    need_stage(&call);
    if (!call.buffers.failed) {
        values = doubles(&call.buffers, PyTuple_GetItem(matrix_in, 1), "values", &call.entries);
    }
    const double *x = doubles(&call.buffers, x_in, "x", &call.length);
    double *y = buffers_take(&call.buffers, y_out, "y", 'd', 1, &call.length);
    double *work = take_work(&call, work_out, 'd');
    if (!call.buffers.failed) {
        Py_BEGIN_ALLOW_THREADS
        aoi_blocks_multiply(&call.matrix, call.part, call.stage, values, x, y, work);
        Py_END_ALLOW_THREADS
    }
    return finish(&call.buffers, AOI_OK, "product of blocks");
}

PyObject *blocks_subtract(PyObject *self, PyObject *args)
{
    PyObject *matrix_in, *x_in, *r_out, *work_out;
    part_call call = {.matrix.n = 0};
    (void)self;
    if (!PyArg_ParseTuple(args, "O!O&iOOO", &PyTuple_Type, &matrix_in, to_part, &call.part, &call.stage,
                          &x_in, &r_out, &work_out)) {
        return NULL;
    }
    take_blocks(&call, matrix_in);
    need_stage(&call);
    const float *x = buffers_take(&call.buffers, x_in, "x", 'f', 0, &call.length);
    float *r = buffers_take(&call.buffers, r_out, "r", 'f', 1, &call.length);
    float *work = take_work(&call, work_out, 'f');
    if (!call.buffers.failed) {
        Py_BEGIN_ALLOW_THREADS
        aoi_blocks_subtract(&call.matrix, call.part, call.stage, x, r, work);
        Py_END_ALLOW_THREADS
    }
    return finish(&call.buffers, AOI_OK, "product of blocks");
}

PyObject *blocks_smooth(PyObject *self, PyObject *args)
{
    PyObject *matrix_in, *x_out, *r_out, *work_out;
    part_call call = {.matrix.n = 0};
    int steps, finished, status = AOI_OK;
    double low, high;
    (void)self;
    if (!PyArg_ParseTuple(args, "O!O&iiddpOOO", &PyTuple_Type, &matrix_in, to_part, &call.part,
                          &call.stage, &steps, &low, &high, &finished, &x_out, &r_out, &work_out)) {
        return NULL;
    }
    take_blocks(&call, matrix_in);
    float *x = buffers_take(&call.buffers, x_out, "x", 'f', 1, &call.length);
    float *r = buffers_take(&call.buffers, r_out, "r", 'f', 1, &call.length);
    float *work = take_work(&call, work_out, 'f');
    if (!call.buffers.failed) {
        Py_BEGIN_ALLOW_THREADS
        status = steps < 1 || call.stage < 0
                     ? AOI_ERROR_ARGUMENT
                     : aoi_blocks_smooth(&call.matrix, call.part, (size_t)call.stage, (size_t)steps, low,
                                         high, finished, x, r, work);
        Py_END_ALLOW_THREADS
    }
    return finish(&call.buffers, status, "smoothing");
}

PyObject *graph_aggregate(PyObject *self, PyObject *args)
{
    PyObject *start_in, *indices_in, *aggregate_out;
    buffer_list buffers = {.failed = 0};
    size_t rows = (size_t)-1, stored = (size_t)-1, count = 0;
    (void)self;
    if (!PyArg_ParseTuple(args, "OOO", &start_in, &indices_in, &aggregate_out)) {
        return NULL;
    }
    const int32_t *start = integers(&buffers, start_in, "row starts", &rows);
    const int32_t *indices = integers(&buffers, indices_in, "indices", &stored);
    size_t n = rows > 0 ? rows - 1 : 0;
    int32_t *aggregate = buffers_take(&buffers, aggregate_out, "aggregates", 'i', 1, &n);
    int status = AOI_OK;
    if (!buffers.failed) {
        const aoi_sparse graph = {n, start, indices, NULL};
        status = rows > 0 ? aoi_sparse_check(&graph, stored) : AOI_ERROR_ARGUMENT;
        count = status == AOI_OK ? aoi_graph_aggregate(n, start, indices, aggregate) : 0;
    }
    PyObject *done = finish(&buffers, status, "aggregation");
    Py_XDECREF(done);
    return done ? PyLong_FromSize_t(count) : NULL;
}
