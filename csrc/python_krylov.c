/* The Krylov subspace seen from Python: its linear solver is a Python callable. */
#include "binding.h"

#include <stdlib.h>

/* A callable that gets the right-hand side as a writable memoryview and puts the solution there. */
typedef struct callable {
    PyObject *solve;
    size_t bytes;
    PyThreadState *thread; /* saved while the core runs without the GIL */
} callable;

static int call_back(void *data, double *x)
{
    callable *solver = data;
    PyEval_RestoreThread(solver->thread);
    PyObject *view = PyMemoryView_FromMemory((char *)x, (Py_ssize_t)solver->bytes, PyBUF_WRITE);
    PyObject *done = view ? PyObject_CallFunctionObjArgs(solver->solve, view, NULL) : NULL;
    const int failed = done == NULL;
    Py_XDECREF(done);
    Py_XDECREF(view);
    solver->thread = PyEval_SaveThread();
    return failed;
}

static int take_space(held *buffers, PyObject *args, aoi_krylov *space, callable *solver,
                      size_t *wanted)
{
    PyObject *K, *M, *b, *basis, *stiffness;
    size_t all = (size_t)-1, functionals = (size_t)-1, square;
    Py_ssize_t rigid, given, count, next, last;
    if (!PyArg_ParseTuple(args, "O!O!dOOOOnnnnn", &PyTuple_Type, &K, &PyTuple_Type, &M, &space->s2,
                          &solver->solve, &b, &basis, &stiffness, &rigid, &given, &count, &next,
                          &last)) {
        buffers->failed = 1;
        return AOI_OK;
    }
    need_tuple(buffers, K, 3);
    const Py_ssize_t rows = buffers->failed ? 0 : PyObject_Length(PyTuple_GetItem(K, 0));
    if (rows < 2 || rigid < 0 || given < rigid || count < given || next < 0 || last < 0) {
        return AOI_ERROR_ARGUMENT;
    }
    const size_t n = (size_t)rows - 1;
    const int status = take_sparse(buffers, K, n, &space->K);
    const int status_m = take_sparse(buffers, M, n, &space->M);
    space->b = doubles(buffers, b, "b", &functionals);
    space->basis = doubles_out(buffers, basis, "basis", &all);
    space->capacity = all / n;
    square = space->capacity * space->capacity;
    space->stiffness = doubles_out(buffers, stiffness, "stiffness", &square);
    space->port_count = functionals / n;
    space->rigid_count = (size_t)rigid;
    space->given_count = (size_t)given;
    space->count = (size_t)count;
    space->next = (size_t)next;
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
    size_t wanted = 0;
    (void)self;
    int status = take_space(&buffers, args, &space, &solver, &wanted);
    if (!buffers.failed && status == AOI_OK) {
        space.solver = (aoi_solver){call_back, &solver};
        space.work = malloc(aoi_krylov_work_size(space.K.n, space.capacity) * sizeof(double));
        if (space.work) {
            solver.thread = PyEval_SaveThread();
            status = aoi_krylov_extend(&space, wanted);
            PyEval_RestoreThread(solver.thread);
        } else {
            PyErr_NoMemory();
        }
        free(space.work);
    }
    if (PyErr_Occurred()) { /* of the callable, before what the core makes of it */
        buffers.failed = 1;
    }
    PyObject *done = finish(&buffers, status, "Krylov subspace");
    Py_XDECREF(done);
    return done ? Py_BuildValue("nn", (Py_ssize_t)space.count, (Py_ssize_t)space.next) : NULL;
}
