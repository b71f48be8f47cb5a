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

/* (K, M, s2, solve, b, basis, stiffness, load, rigid, given, progress, wanted); progress: the columns there are and the
 * solves so far, written back on errors, too. */
PyObject *krylov_extend(PyObject *args)
{
    call of = {.status = AOI_OK};
    aoi_krylov space = {.port_count = ANY_LENGTH, .capacity = ANY_LENGTH};
    callable solver = {.solve = NULL};
    PyObject *K = NULL, *M = NULL;
    size_t n = ANY_LENGTH, wanted, two = 2;
    int32_t *progress;
    TAKE(&of, args, VALUE('t', K), VALUE('t', M), VALUE('x', space.s2), VALUE('O', solver.solve),
         MATRIX('d', space.b, space.port_count, n), MATRIX('D', space.basis, space.capacity, n),
         MATRIX('D', space.stiffness, space.capacity, space.capacity), ARRAY('D', space.load, n),
         VALUE('n', space.rigid_count), VALUE('n', space.given_count), ARRAY('I', progress, two), VALUE('n', wanted));
    take_sparse(&of, K, &n, &space.K);
    take_sparse(&of, M, &n, &space.M);
    if (of.status == AOI_OK &&
        (n == 0 || space.port_count == 0 || (Py_ssize_t)wanted < 0 || progress[0] < 0 || progress[1] < 0 ||
         space.given_count < space.rigid_count || (size_t)progress[0] < space.given_count ||
         (size_t)progress[0] > space.capacity)) {
        of.status = AOI_ERROR_ARGUMENT;
    }
    if (of.status == AOI_OK) {
        space.count = (size_t)progress[0];
        space.next = (size_t)progress[1];
        space.solver = (aoi_residual_solver){call_back, &solver};
        solver.bytes = n * sizeof(double);
        make_views(&solver);
        space.work = call_room(&of, aoi_krylov_work_size(n, space.capacity), sizeof(double));
        if (!PyErr_Occurred()) {
            space.pause = &solver.signals.pause;
            signal_check_release(&solver.signals);
            of.status = aoi_krylov_extend(&space, wanted);
            signal_check_regain(&solver.signals);
        }
        free(space.work);
        drop_views(&solver);
        progress[0] = (int32_t)space.count;
        progress[1] = (int32_t)space.next;
    }
    return finish(&of, "Krylov subspace", "");
}
