/* The Krylov subspace, for Python: its linear solver is a Python callable. */
#include "python/binding.h"
#include "linear/krylov.h"
#include "linear/sparse.h"

#include <stdlib.h>
#include <string.h>

enum { VECTORS = 3 };

/* A callable that gets the right-hand side as a writable memoryview and puts the solution there, and
 * its products with K and M in two more. They are views of an object that lives for as long as they do,
 * and not of what the core works on: a callable may keep them, as its traceback does. */
typedef struct callable {
    PyObject *solve;
    PyObject *memory, *view[VECTORS];
    size_t bytes; /* of a vector */
    signal_check signals;
} callable;

static int call_back(void *data, double *x, double *kx, double *mx)
{
    callable *solver = data;
    double *arrays[VECTORS] = {x, kx, mx};
    signal_check_regain(&solver->signals);
    char *memory = PyByteArray_AsString(solver->memory);
    memcpy(memory, x, solver->bytes);
    PyObject *done = PyObject_CallFunctionObjArgs(solver->solve, solver->view[0], solver->view[1],
                                                  solver->view[2], NULL);
    for (size_t i = 0; done && i < VECTORS; i++) {
        memcpy(arrays[i], memory + i * solver->bytes, solver->bytes);
    }
    Py_XDECREF(done);
    signal_check_release(&solver->signals);
    return done == NULL;
}

static void make_views(callable *solver)
{
    const Py_ssize_t bytes = (Py_ssize_t)solver->bytes;
    solver->memory = PyByteArray_FromStringAndSize(NULL, VECTORS * bytes);
    PyObject *all = solver->memory ? PyMemoryView_FromObject(solver->memory) : NULL;
    for (Py_ssize_t i = 0; all && i < VECTORS; i++) {
        solver->view[i] = PySequence_GetSlice(all, i * bytes, (i + 1) * bytes);
    }
    Py_XDECREF(all);
}

static void drop_views(callable *solver)
{
    for (size_t i = 0; i < VECTORS; i++) {
        Py_XDECREF(solver->view[i]);
    }
    Py_XDECREF(solver->memory);
}

/* progress: the columns there are and the solves so far, written back on errors, too. */
static int take_space(buffer_list *buffers, PyObject *args, aoi_krylov *space, callable *solver,
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
    *progress = buffers_take(buffers, reached, "progress", 'i', 1, &two);
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
    buffer_list buffers = {.failed = 0};
    aoi_krylov space = {.s2 = 0.0};
    callable solver = {.solve = NULL};
    int32_t *progress = NULL;
    size_t wanted = 0;
    (void)self;
    int status = take_space(&buffers, args, &space, &solver, &progress, &wanted);
    if (!buffers.failed && status == AOI_OK) {
        space.solver = (aoi_residual_solver){call_back, &solver};
        make_views(&solver);
        space.work = malloc(aoi_krylov_work_size(space.K.n, space.capacity) * sizeof(double));
        if (!PyErr_Occurred() && space.work) {
            signal_check_open(&solver.signals);
            space.pause = &solver.signals.pause;
            signal_check_release(&solver.signals);
            status = aoi_krylov_extend(&space, wanted);
            signal_check_regain(&solver.signals);
        } else if (!PyErr_Occurred()) {
            PyErr_NoMemory();
        }
        free(space.work);
        drop_views(&solver);
        progress[0] = (int32_t)space.count;
        progress[1] = (int32_t)space.next;
    }
    return finish(&buffers, status, "Krylov subspace");
}
