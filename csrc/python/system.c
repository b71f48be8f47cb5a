/* Conversion of bodies, contacts and systems from Python tuples. */
#include "python/binding.h"

#include <stdlib.h>
#include <string.h>

#define PLACE_OF(part) part##_at,
enum { MODES_PARTS(PLACE_OF) MODES_COUNT };

/* Reads a sparse matrix of n rows from the tuple (start, indices, values). */
static void take_sparse(call *of, PyObject *tuple, size_t n, aoi_sparse *matrix)
{
    size_t stored = ANY_LENGTH;
    matrix->n = n;
    TAKE(of, tuple, LONGER('i', matrix->start, matrix->n, 1), ARRAY('i', matrix->indices, stored),
         ARRAY('d', matrix->values, stored));
    if (of->status == AOI_OK) {
        of->status = aoi_sparse_check(matrix, stored);
    }
}

/* The function aoi_solver.solve of a solver written in Python. It is called without the GIL; an exception stays
 * set. */
static int solve_by_python(void *data, double *x)
{
    const taken_full *of = data;
    const PyGILState_STATE state = PyGILState_Ensure();
    const Py_ssize_t size = (Py_ssize_t)(of->n * sizeof *x);
    Py_buffer view = {.obj = NULL};
    PyObject *found = PyObject_CallFunction(of->solve, "y#", (const char *)x, size);
    if (found && PyObject_GetBuffer(found, &view, PyBUF_C_CONTIGUOUS) == 0) {
        if (view.len == size) {
            memcpy(x, view.buf, (size_t)size);
        } else {
            PyErr_SetString(PyExc_ValueError, "a solution must be as long as its right-hand side");
        }
        PyBuffer_Release(&view);
    }
    Py_XDECREF(found);
    const int failed = PyErr_Occurred() != NULL;
    PyGILState_Release(state);
    return failed;
}

/* Reads the matrices of a body of n coordinates from the tuple (K, M, alpha, beta, callable). */
static void take_full(call *of, PyObject *tuple, size_t n, taken_full *full, signal_check *signals)
{
    PyObject *K = NULL, *M = NULL;
    full->n = n;
    full->full.pause = &signals->pause;
    full->full.solver = (aoi_solver){solve_by_python, full};
    TAKE(of, tuple, VALUE('t', K), VALUE('t', M), VALUE('x', full->full.alpha), VALUE('x', full->full.beta),
         VALUE('O', full->solve));
    take_sparse(of, K, n, &full->full.K);
    take_sparse(of, M, n, &full->full.M);
}

void take_body(call *of, PyObject *tuple, aoi_modes *body, taken_full *full, signal_check *signals)
{
    PyObject *matrices = Py_None;
    body->n = body->ports = body->load.count = ANY_LENGTH;
    TAKE(of, tuple, [centre_at] = ARRAY('d', body->centre, body->n),
         [shape_at] = MATRIX('d', body->shape, body->ports, body->n),
         [push_at] = MATRIX('d', body->push, body->ports, body->n),
         [omega_at] = ARRAY('o', body->omega, body->n),
         [decay_at] = ARRAY('o', body->decay, body->n),
         [residual_at] = MATRIX('o', body->residual, body->ports, body->ports),
         [gravity_at] = ARRAY('o', body->gravity, body->n),
         [inertia_at] = ARRAY('o', body->inertia, body->n),
         [centre_residual_at] = ARRAY('o', body->centre_residual, body->ports),
         [load_time_at] = ARRAY('o', body->load.time, body->load.count),
         [load_force_at] = MATRIX('o', body->load.force, body->load.count, body->ports),
         [full_at] = VALUE('O', matrices));
    body->load.count = body->load.count == ANY_LENGTH ? 0 : body->load.count;
    if (of->status == AOI_OK && matrices != Py_None && !full) {
        of->status = AOI_ERROR_ARGUMENT;
    } else if (of->status == AOI_OK && matrices != Py_None) {
        body->full = &full->full;
        take_full(of, matrices, body->n, full, signals);
    }
}

void free_system(taken_system *made)
{
    free(made->body);
    free(made->full);
    free(made->contact);
    free(made->law);
    free(made->friction);
    free(made->links);
}

void take_system(call *of, PyObject *bodies, PyObject *contacts, taken_system *made)
{
    if (of->status != AOI_OK) {
        return;
    }
    const size_t nb = (size_t)PyTuple_Size(bodies), nc = (size_t)PyTuple_Size(contacts);
    signal_check_open(&made->signals);
    made->body = call_room(of, nb, sizeof *made->body);
    made->full = call_room(of, nb, sizeof *made->full);
    made->contact = call_room(of, nc, sizeof *made->contact);
    made->law = call_room(of, nc, sizeof *made->law);
    made->friction = call_room(of, nc, sizeof *made->friction);
    made->system = (aoi_system){.body_count = nb, .contact_count = nc, .body = made->body};
    made->system.contact = made->contact;
    made->links = call_room(of, aoi_system_size(&made->system), 1);
    for (size_t b = 0; b < nb && of->status == AOI_OK; b++) {
        take_body(of, tuple_item(of, bodies, b, nb), &made->body[b], &made->full[b], &made->signals);
    }
    for (size_t c = 0; c < nc && of->status == AOI_OK; c++) {
        take_contact(of, tuple_item(of, contacts, c, nc), &made->contact[c], &made->law[c],
                     &made->friction[c]);
    }
    if (of->status == AOI_OK) {
        of->status = aoi_system_link(&made->system, made->links);
    }
}
