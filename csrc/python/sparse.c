/* Sparse matrices and factors, for Python. */
#include "python/binding.h"
#include "linear/sparse.h"

int take_sparse(buffer_list *buffers, PyObject *tuple, size_t n, aoi_sparse *matrix)
{
    size_t rows = n + 1, stored = (size_t)-1;
    need_tuple(buffers, tuple, 3);
    if (buffers->failed) {
        return AOI_OK;
    }
    matrix->n = n;
    matrix->start = integers(buffers, PyTuple_GetItem(tuple, 0), "row starts", &rows);
    matrix->values = doubles(buffers, PyTuple_GetItem(tuple, 2), "values", &stored);
    matrix->indices = integers(buffers, PyTuple_GetItem(tuple, 1), "indices", &stored);
    return buffers->failed ? AOI_OK : aoi_sparse_check(matrix, stored);
}

int take_factors(buffer_list *buffers, PyObject *tuple, size_t n, aoi_factors *factors)
{
    size_t columns = n + 1, stored = (size_t)-1, panels = (size_t)-1;
    need_tuple(buffers, tuple, 6);
    if (buffers->failed) {
        return AOI_OK;
    }
    factors->n = n;
    factors->start = integers(buffers, PyTuple_GetItem(tuple, 0), "column starts", &columns);
    factors->values = doubles(buffers, PyTuple_GetItem(tuple, 2), "factor values", &stored);
    factors->rows = integers(buffers, PyTuple_GetItem(tuple, 1), "factor rows", &stored);
    factors->pivots = doubles(buffers, PyTuple_GetItem(tuple, 3), "pivots", &n);
    factors->place = integers(buffers, PyTuple_GetItem(tuple, 4), "place", &n);
    factors->panel = integers(buffers, PyTuple_GetItem(tuple, 5), "panels", &panels);
    factors->panel_count = panels - 1;
    if (!buffers->failed && panels < 1) {
        return AOI_ERROR_ARGUMENT;
    }
    return buffers->failed ? AOI_OK : aoi_factors_check(factors, stored);
}

PyObject *factors_find_panels(PyObject *self, PyObject *args)
{
    PyObject *start_in, *rows_in, *panel_out;
    buffer_list buffers = {.failed = 0};
    size_t columns = (size_t)-1, stored = (size_t)-1, count = 0;
    (void)self;
    if (!PyArg_ParseTuple(args, "OOO", &start_in, &rows_in, &panel_out)) {
        return NULL;
    }
    const int32_t *start = integers(&buffers, start_in, "column starts", &columns);
    const int32_t *rows = integers(&buffers, rows_in, "factor rows", &stored);
    int32_t *panel = buffers_take(&buffers, panel_out, "panels", 'i', 1, &columns);
    int status = AOI_OK;
    if (!buffers.failed) {
        const aoi_sparse pattern = {columns > 0 ? columns - 1 : 0, start, rows, NULL};
        status = columns > 0 ? aoi_sparse_check(&pattern, stored) : AOI_ERROR_ARGUMENT;
        count = status == AOI_OK ? aoi_factors_find_panels(pattern.n, start, rows, panel) : 0;
    }
    PyObject *done = finish(&buffers, status, "factors");
    Py_XDECREF(done);
    return done ? PyLong_FromSize_t(count) : NULL;
}

PyObject *factors_solve(PyObject *self, PyObject *args)
{
    PyObject *factors_in, *work_out, *x_out;
    buffer_list buffers = {.failed = 0};
    aoi_factors factors = {.n = 0};
    size_t n = (size_t)-1;
    (void)self;
    if (!PyArg_ParseTuple(args, "O!OO", &PyTuple_Type, &factors_in, &work_out, &x_out)) {
        return NULL;
    }
    double *x = doubles_out(&buffers, x_out, "x", &n);
    factors.work = doubles_out(&buffers, work_out, "work", &n);
    int status = take_factors(&buffers, factors_in, n, &factors);
    if (!buffers.failed && status == AOI_OK) {
        signal_check signals;
        signal_check_open(&signals);
        factors.pause = &signals.pause;
        signal_check_release(&signals);
        status = aoi_factors_solve(&factors, x);
        signal_check_regain(&signals);
    }
    return finish(&buffers, status, "back-substitution");
}
