/* Bodies, contacts and the system of them, from Python. */
#include "python/binding.h"
#include "linear/work.h"

#include <stdlib.h>

static PyObject *item(PyObject *tuple, Py_ssize_t i) { return PyTuple_GetItem(tuple, i); }

#define PLACE_OF(part) part##_at,
enum { MODES_PARTS(PLACE_OF) MODES_COUNT };

/* (K, M, alpha, beta, factors). */
static int take_full(buffer_list *buffers, PyObject *tuple, size_t n, taken_full *full, signal_check *signals)
{
    need_tuple(buffers, tuple, 5);
    full->work = buffers->failed ? NULL : malloc(aoi_times(n + 1, sizeof(double)));
    if (!buffers->failed && !full->work) {
        buffers->failed = 1;
        PyErr_NoMemory();
    }
    if (buffers->failed) {
        return AOI_OK;
    }
    full->full.alpha = PyFloat_AsDouble(item(tuple, 2));
    full->full.beta = PyFloat_AsDouble(item(tuple, 3));
    full->full.pause = full->factors.pause = &signals->pause;
    full->full.solver = (aoi_solver){aoi_factors_solve, &full->factors};
    full->factors.work = full->work;
    int status = take_sparse(buffers, item(tuple, 0), n, &full->full.K);
    if (status == AOI_OK) {
        status = take_sparse(buffers, item(tuple, 1), n, &full->full.M);
    }
    return status == AOI_OK ? take_factors(buffers, item(tuple, 4), n, &full->factors) : status;
}

int take_body(buffer_list *buffers, PyObject *tuple, aoi_modes *body, taken_full *full, signal_check *signals)
{
    size_t n = (size_t)-1, shapes = (size_t)-1, times = (size_t)-1;
    need_tuple(buffers, tuple, MODES_COUNT);
    if (buffers->failed) {
        return AOI_OK;
    }
    body->centre = doubles(buffers, item(tuple, centre_at), "centre", &n);
    body->shape = doubles(buffers, item(tuple, shape_at), "shape", &shapes);
    body->push = doubles(buffers, item(tuple, push_at), "push", &shapes);
    if (!buffers->failed && (n == 0 || shapes % n != 0 || shapes == 0)) {
        buffers->failed = 1;
        PyErr_SetString(PyExc_ValueError, "a body needs modes and ports");
    }
    body->n = n;
    body->ports = buffers->failed ? 1 : shapes / n;
    size_t ports = body->ports, pairs = ports * ports;
    body->omega = doubles_or_none(buffers, item(tuple, omega_at), "omega", &n);
    body->decay = doubles_or_none(buffers, item(tuple, decay_at), "decay", &n);
    body->residual = doubles_or_none(buffers, item(tuple, residual_at), "residual", &pairs);
    body->gravity = doubles_or_none(buffers, item(tuple, gravity_at), "gravity", &n);
    body->inertia = doubles_or_none(buffers, item(tuple, inertia_at), "inertia", &n);
    body->centre_residual = doubles_or_none(buffers, item(tuple, centre_residual_at), "centre residual", &ports);
    body->load.time = doubles_or_none(buffers, item(tuple, load_time_at), "load times", &times);
    body->load.count = body->load.time ? times : 0;
    size_t loads = body->load.count * ports;
    body->load.force = body->load.time ? doubles(buffers, item(tuple, load_force_at), "load forces", &loads) : NULL;
    if (buffers->failed || item(tuple, full_at) == Py_None) {
        return AOI_OK;
    }
    if (!full) {
        return AOI_ERROR_ARGUMENT;
    }
    body->full = &full->full;
    return take_full(buffers, item(tuple, full_at), n, full, signals);
}

void free_system(taken *made)
{
    for (size_t b = 0; made->full && b < made->system.body_count; b++) {
        free(made->full[b].work);
    }
    free(made->body);
    free(made->full);
    free(made->contact);
    free(made->law);
    free(made->links);
}

int take_system(buffer_list *buffers, PyObject *bodies, PyObject *contacts, taken *made)
{
    const size_t nb = (size_t)PyTuple_Size(bodies), nc = (size_t)PyTuple_Size(contacts);
    int status = AOI_OK;
    signal_check_open(&made->signals);
    made->body = calloc(nb + 1, sizeof *made->body);
    made->full = calloc(nb + 1, sizeof *made->full);
    made->contact = calloc(nc + 1, sizeof *made->contact);
    made->law = calloc(nc + 1, sizeof *made->law);
    made->system = (aoi_system){.body_count = nb, .contact_count = nc, .body = made->body};
    made->system.contact = made->contact;
    made->links = malloc(aoi_system_size(&made->system));
    if (!made->body || !made->full || !made->contact || !made->law || !made->links) {
        buffers->failed = 1;
        PyErr_NoMemory();
        return AOI_OK;
    }
    for (size_t b = 0; b < nb && !buffers->failed && status == AOI_OK; b++) {
        status = take_body(buffers, item(bodies, (Py_ssize_t)b), &made->body[b], &made->full[b], &made->signals);
    }
    for (size_t c = 0; c < nc && !buffers->failed && status == AOI_OK; c++) {
        status = take_contact(buffers, item(contacts, (Py_ssize_t)c), &made->contact[c], &made->law[c]);
    }
    buffers->failed = buffers->failed || PyErr_Occurred();
    return buffers->failed || status != AOI_OK ? status : aoi_system_link(&made->system, made->links);
}
