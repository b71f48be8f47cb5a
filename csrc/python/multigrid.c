/* The inner loops of multigrid, for Python. */
#include "python/binding.h"
#include "linear/multigrid.h"
#include "linear/sparse.h"

/* (start, indices, ...) of so many entries: their pattern; the number of rows and the size of a block
 * follow from the lengths. */
static int take_pattern(buffer_list *buffers, PyObject *tuple, size_t length, size_t entries,
                        aoi_blocks *matrix)
{
    size_t rows = (size_t)-1, stored = (size_t)-1;
    matrix->start = integers(buffers, PyTuple_GetItem(tuple, 0), "row starts", &rows);
    matrix->indices = integers(buffers, PyTuple_GetItem(tuple, 1), "indices", &stored);
    if (buffers->failed) {
        return AOI_OK;
    }
    matrix->n = rows > 0 ? rows - 1 : 0;
    matrix->size = matrix->n > 0 ? length / matrix->n : 0;
    if (matrix->n * matrix->size != length || stored * matrix->size * matrix->size != entries) {
        return AOI_ERROR_ARGUMENT;
    }
    return aoi_blocks_check(matrix, stored);
}

/* (start, indices, values, inverse). */
static int take_blocks(buffer_list *buffers, PyObject *tuple, size_t length, aoi_blocks *matrix)
{
    size_t entries = (size_t)-1, diagonal = (size_t)-1;
    need_tuple(buffers, tuple, 4);
    if (buffers->failed) {
        return AOI_OK;
    }
    matrix->values = buffers_take(buffers, PyTuple_GetItem(tuple, 2), "values", 'f', 0, &entries);
    matrix->inverse = buffers_take(buffers, PyTuple_GetItem(tuple, 3), "inverse", 'f', 0, &diagonal);
    if (buffers->failed) {
        return AOI_OK;
    }
    const int status = take_pattern(buffers, tuple, length, entries, matrix);
    return status == AOI_OK && diagonal != length * matrix->size ? AOI_ERROR_ARGUMENT : status;
}

static void *take_work(buffer_list *buffers, PyObject *work_out, char type, const aoi_blocks *matrix)
{
    size_t length = AOI_BLOCKS_WORK * matrix->n * (matrix->size + 1);
    return buffers_take(buffers, work_out, "work", type, 1, &length);
}

PyObject *blocks_multiply(PyObject *self, PyObject *args)
{
    PyObject *matrix_in, *x_in, *y_out, *work_out;
    buffer_list buffers = {.failed = 0};
    aoi_blocks matrix = {.n = 0};
    size_t length = (size_t)-1, entries = (size_t)-1;
    int status = AOI_OK;
    const double *values = NULL;
    (void)self;
    if (!PyArg_ParseTuple(args, "O!OOO", &PyTuple_Type, &matrix_in, &x_in, &y_out, &work_out)) {
        return NULL;
    }
    const double *x = doubles(&buffers, x_in, "x", &length);
    double *y = buffers_take(&buffers, y_out, "y", 'd', 1, &length);
    need_tuple(&buffers, matrix_in, 3);
    if (!buffers.failed) {
        values = doubles(&buffers, PyTuple_GetItem(matrix_in, 2), "values", &entries);
    }
    if (!buffers.failed) {
        status = take_pattern(&buffers, matrix_in, length, entries, &matrix);
    }
    double *work = status == AOI_OK ? take_work(&buffers, work_out, 'd', &matrix) : NULL;
    if (!buffers.failed && status == AOI_OK) {
        Py_BEGIN_ALLOW_THREADS
        aoi_blocks_multiply(&matrix, values, x, y, work);
        Py_END_ALLOW_THREADS
    }
    return finish(&buffers, status, "product of blocks");
}

PyObject *blocks_subtract(PyObject *self, PyObject *args)
{
    PyObject *matrix_in, *x_in, *r_out, *work_out;
    buffer_list buffers = {.failed = 0};
    aoi_blocks matrix = {.n = 0};
    size_t length = (size_t)-1;
    (void)self;
    if (!PyArg_ParseTuple(args, "O!OOO", &PyTuple_Type, &matrix_in, &x_in, &r_out, &work_out)) {
        return NULL;
    }
    const float *x = buffers_take(&buffers, x_in, "x", 'f', 0, &length);
    float *r = buffers_take(&buffers, r_out, "r", 'f', 1, &length);
    const int status = take_blocks(&buffers, matrix_in, length, &matrix);
    float *work = status == AOI_OK ? take_work(&buffers, work_out, 'f', &matrix) : NULL;
    if (!buffers.failed && status == AOI_OK) {
        Py_BEGIN_ALLOW_THREADS
        aoi_blocks_subtract(&matrix, x, r, work);
        Py_END_ALLOW_THREADS
    }
    return finish(&buffers, status, "product of blocks");
}

PyObject *blocks_smooth(PyObject *self, PyObject *args)
{
    PyObject *matrix_in, *x_out, *r_out, *work_out;
    buffer_list buffers = {.failed = 0};
    aoi_blocks matrix = {.n = 0};
    size_t length = (size_t)-1;
    Py_ssize_t steps;
    double low, high;
    int finished;
    (void)self;
    if (!PyArg_ParseTuple(args, "O!nddpOOO", &PyTuple_Type, &matrix_in, &steps, &low, &high,
                          &finished, &x_out, &r_out, &work_out)) {
        return NULL;
    }
    float *x = buffers_take(&buffers, x_out, "x", 'f', 1, &length);
    float *r = buffers_take(&buffers, r_out, "r", 'f', 1, &length);
    int status = take_blocks(&buffers, matrix_in, length, &matrix);
    float *work = status == AOI_OK ? take_work(&buffers, work_out, 'f', &matrix) : NULL;
    if (!buffers.failed && status == AOI_OK) {
        Py_BEGIN_ALLOW_THREADS
        status = steps > 0 ? aoi_blocks_smooth(&matrix, (size_t)steps, low, high, finished, x, r, work)
                           : AOI_ERROR_ARGUMENT;
        Py_END_ALLOW_THREADS
    }
    return finish(&buffers, status, "smoothing");
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
