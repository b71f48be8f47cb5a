/* Bodies, contacts and the system of them, from Python. */
#include "python/binding.h"
#include "linear/work.h"

#include <stdlib.h>

#define PLACE_OF(part) part##_at,
enum { MODES_PARTS(PLACE_OF) MODES_COUNT };

/* (K, M, alpha, beta, factors). */
static void take_full(call *of, PyObject *tuple, size_t n, taken_full *full, signal_check *signals)
{
    PyObject *K = NULL, *M = NULL, *factors = NULL;
    full->full.pause = full->factors.pause = &signals->pause;
    full->full.solver = (aoi_solver){aoi_factors_solve, &full->factors};
    full->factors.work = full->work = call_room(of, n, sizeof(double));
    TAKE(of, tuple, VALUE('t', K), VALUE('t', M), VALUE('x', full->full.alpha), VALUE('x', full->full.beta),
         VALUE('t', factors));
    take_sparse(of, K, &n, &full->full.K);
    take_sparse(of, M, &n, &full->full.M);
    take_factors(of, factors, n, &full->factors);
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
    for (size_t b = 0; made->full && b < made->system.body_count; b++) {
        free(made->full[b].work);
    }
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
