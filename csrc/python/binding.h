/* What the files of the binding share: buffers in, buffers out, nothing of the method. Only the files
 * of this folder include Python.h, through this header. Arrays come as C-contiguous
 * buffers of float64 or int32, made so by the Python side; results are written into buffers that the
 * caller made. The GIL is released in chunks of some milliseconds, so that other threads run and
 * Ctrl-C is heard. */
#ifndef AOIMPACT_BINDING_H
#define AOIMPACT_BINDING_H

#define PY_SSIZE_T_CLEAN
#include <Python.h>

#include "linear/sparse.h"

/* ------------------------------------------------------------------ buffers.c: in and out */

enum { MOST_BUFFERS = 40 };

typedef struct held_block {
    Py_buffer view[MOST_BUFFERS];
    int count;
    struct held_block *next;
} held_block;

/* The buffers that one call holds, as many as it takes; after the first failure the others are not
 * taken. Made as {.failed = 0}, it is empty. */
typedef struct held {
    int failed;
    held_block block;
} held;

void held_release(held *buffers);

/* type: 'd' for float64, 'f' for float32, 'i' for int32. In this and the next three, count is what the buffer must
 * hold; -1 takes what comes and says it. */
void *held_take(held *buffers, PyObject *object, const char *name, char type, int writable,
                size_t *count);
const double *doubles(held *buffers, PyObject *object, const char *name, size_t *count);
double *doubles_out(held *buffers, PyObject *object, const char *name, size_t *count);
const int32_t *integers(held *buffers, PyObject *object, const char *name, size_t *count);

/* Fails where tuple is none of that size. */
void need_tuple(held *buffers, PyObject *tuple, Py_ssize_t size);

/* Whether a tuple, not empty, begins with that word. */
int is_kind(PyObject *tuple, const char *kind);

/* Raises what a function of aoimpact.base.errors returns for the arguments, a tuple, which it takes over. */
PyObject *raise_made(const char *maker, PyObject *arguments);

/* Raises what aoimpact.base.errors makes of a status: the one table of the core's codes stands there.
 * raise_at: with the state in which a law gave NaN; and the contact that is to blame, or -1. */
PyObject *raise_status(int status, const char *what, double time);
PyObject *raise_at(int status, const char *what, double time, double indentation, double rate,
                   Py_ssize_t contact);

/* Releases the buffers; None, or NULL with an error raised. */
PyObject *finish(held *buffers, int status, const char *what);

/* ------------------------------------------------------------------ pause.c: signals */

/* Seconds of a clock that only goes forward. */
double seconds_now(void);

/* What one call hears signals by: pause is for the core, and asks every HEARD_EVERY seconds, with the GIL or,
 * between release and regain, without. An error is set once it has said no. */
#define HEARD_EVERY 0.02
typedef struct listener {
    aoi_pause pause;
    double next;
    PyThreadState *thread; /* while the GIL is released */
} listener;

void listener_open(listener *ear);
void listener_release(listener *ear);
void listener_regain(listener *ear);

/* ------------------------------------------------------------------ what is made of tuples */

/* (name, parameters, compliance, limit, note, data), made by ContactLaw.for_core and read only here. */
int take_law(held *buffers, PyObject *tuple, aoi_law *law);

/* raise_status for a run with count laws, any of which may have stopped it; what a law written in
 * Python has raised stays as it is. contact: which went deeper than its law holds, if that is the status.
 * The buffers must still be held. */
PyObject *raise_of_laws(int status, const char *what, double time, const aoi_law *law, size_t count,
                        Py_ssize_t contact);

/* (start, indices, values) of a matrix of n rows. */
int take_sparse(held *buffers, PyObject *tuple, size_t n, aoi_sparse *matrix);

/* (start, rows, values, pivots, place, panel); factors->work is there already. */
int take_factors(held *buffers, PyObject *tuple, size_t n, aoi_factors *factors);

/* (omega, decay, shape, push, residual, gravity, inertia, centre, centre_residual, load_time,
 * load_force); None for what there is not. */
void take_modes(held *buffers, PyObject *tuple, aoi_modes *body);

/* -------------------------------------- the module's functions, by file; module.c has their table */

/* laws.c */
PyObject *law_force(PyObject *self, PyObject *args);
PyObject *law_potential(PyObject *self, PyObject *args);

/* reduce.c */
PyObject *static_held(PyObject *self, PyObject *args);
PyObject *static_free(PyObject *self, PyObject *args);
PyObject *constraint_project(PyObject *self, PyObject *args);
PyObject *constraint_reflector(PyObject *self, PyObject *args);
PyObject *constraint_congruence(PyObject *self, PyObject *args);
PyObject *oscillators_project(PyObject *self, PyObject *args);

/* krylov.c */
PyObject *krylov_extend(PyObject *self, PyObject *args);

/* star.c */
PyObject *star_receptance(PyObject *self, PyObject *args);
PyObject *modal_receptance(PyObject *self, PyObject *args);
PyObject *star_to_modal(PyObject *self, PyObject *args);
PyObject *star_from_modal(PyObject *self, PyObject *args);

/* sparse.c */
PyObject *factors_find_panels(PyObject *self, PyObject *args);
PyObject *factors_solve(PyObject *self, PyObject *args);

/* multigrid.c */
PyObject *blocks_multiply(PyObject *self, PyObject *args);
PyObject *blocks_subtract(PyObject *self, PyObject *args);
PyObject *blocks_smooth(PyObject *self, PyObject *args);
PyObject *graph_aggregate(PyObject *self, PyObject *args);

/* newmark.c */
PyObject *newmark_scene(PyObject *self, PyObject *args);

/* adaptive.c */
PyObject *adaptive(PyObject *self, PyObject *args);
PyObject *track_sample(PyObject *self, PyObject *args);
PyObject *track_forces(PyObject *self, PyObject *args);
PyObject *track_states(PyObject *self, PyObject *args);

/* many.c */
PyObject *briefs(PyObject *self, PyObject *args);

#endif
