/* The Krylov subspace seen from Python: its linear solver is a Python callable. */
#include "binding.h"

#include <stdlib.h>

/* A callable that gets the right-hand side as a writable memoryview and puts the solution there, and
 * its products with K and M in two more. */
typedef struct callable {
    PyObject *solve;
    size_t bytes;
    PyThreadState *thread; /* saved while the core runs without the GIL */
} callable;

static int call_back(void *data, double *x, double *kx, double *mx)
{
    callable *solver = data;
    double *arrays[] = {x, kx, mx};
    PyObject *views[] = {NULL, NULL, NULL};
    PyEval_RestoreThread(solver->thread);
    int failed = 0;
    for (size_t i = 0; i < 3; i++) {
        views[i] = PyMemoryView_FromMemory((char *)arrays[i], (Py_ssize_t)solver->bytes, PyBUF_WRITE);
        failed |= views[i] == NULL;
    }
    if (!failed) {
        PyObject *done =
            PyObject_CallFunctionObjArgs(solver->solve, views[0], views[1], views[2], NULL);
        failed = done == NULL;
        Py_XDECREF(done);
    }
    for (size_t i = 0; i < 3; i++) {
        Py_XDECREF(views[i]);
    }
    solver->thread = PyEval_SaveThread();
    return failed;
}

/* progress: the columns there are and the solves so far, written back whatever happens. */
static int take_space(held *buffers, PyObject *args, aoi_krylov *space, callable *solver,
                      int32_t **progress, size_t *wanted)
{
    PyObject *K, *M, *b, *basis, *stiffness, *load, *reached;
    size_t all = (size_t)-1, functionals = (size_t)-1, square, two = 2;
    Py_ssize_t rigid, given, last;
    if (!PyArg_ParseTuple(args, "O!O!dOOOOOnnOn", &PyTuple_Type, &K, &PyTuple_Type, &M, &space->s2,
                          &solver->solve, &b, &basis, &stiffness, &load, &rigid, &given, &reached,
                          &last)) {
        buffers->failed = 1;
        return AOI_OK;
    }
    need_tuple(buffers, K, 3);
    *progress = held_take(buffers, reached, "progress", 'i', 1, &two);
    const Py_ssize_t rows = buffers->failed ? 0 : PyObject_Length(PyTuple_GetItem(K, 0));
    if (rows < 2 || rigid < 0 || given < rigid || last < 0 || (*progress)[0] < given ||
        (*progress)[1] < 0) {
        return AOI_ERROR_ARGUMENT;
    }
    size_t n = (size_t)rows - 1;
    const int status = take_sparse(buffers, K, n, &space->K);
    const int status_m = take_sparse(buffers, M, n, &space->M);
    space->b = doubles(buffers, b, "b", &functionals);
    space->basis = doubles_out(buffers, basis, "basis", &all);
    space->capacity = all / n;
    square = space->capacity * space->capacity;
    space->stiffness = doubles_out(buffers, stiffness, "stiffness", &square);
    space->load = doubles_out(buffers, load, "load", &n);
    space->port_count = functionals / n;
    space->rigid_count = (size_t)rigid;
    space->given_count = (size_t)given;
    space->count = (size_t)(*progress)[0];
    space->next = (size_t)(*progress)[1];
    *wanted = (size_t)last;
    solver->bytes = n * sizeof(double);
    if (functionals < n || functionals % n != 0 || all % n != 0 || space->count > space->capacity) {
        return AOI_ERROR_ARGUMENT;
    }
    return status != AOI_OK ? status : status_m;
}

PyObject *krylov_extend(PyObject *self, PyObject *args)
{
    held buffers = {.failed = 0};
    aoi_krylov space = {.s2 = 0.0};
    callable solver = {NULL, 0, NULL};
    int32_t *progress = NULL;
    size_t wanted = 0;
    (void)self;
    int status = take_space(&buffers, args, &space, &solver, &progress, &wanted);
    if (!buffers.failed && status == AOI_OK) {
        space.solver = (aoi_residual_solver){call_back, &solver};
        space.work = malloc(aoi_krylov_work_size(space.K.n, space.capacity) * sizeof(double));
        if (space.work) {
            solver.thread = PyEval_SaveThread();
            status = aoi_krylov_extend(&space, wanted);
            PyEval_RestoreThread(solver.thread);
        } else {
            PyErr_NoMemory();
        }
        free(space.work);
        progress[0] = (int32_t)space.count;
        progress[1] = (int32_t)space.next;
    }
    if (PyErr_Occurred()) { /* of the callable, before what the core makes of it */
        buffers.failed = 1;
    }
    return finish(&buffers, status, "Krylov subspace");
}
