/* Declarations shared by the files of the binding, which only converts arguments and results. Only the files
 * of this folder include Python.h, through this header. Arrays come as C-contiguous
 * buffers of float64 or int32, made so by the Python side; results are written into buffers that the
 * caller made. The GIL is released in chunks of some milliseconds, so that other threads run and
 * Ctrl-C takes effect. */
#ifndef AOIMPACT_BINDING_H
#define AOIMPACT_BINDING_H

#define PY_SSIZE_T_CLEAN
#include <Python.h>
#include <time.h>

#include "linear/sparse.h"

/* ------------------------------------------------------------------ buffers.c: in and out */

enum { MOST_BUFFERS = 40 };

typedef struct buffer_block {
    Py_buffer view[MOST_BUFFERS];
    int count;
    struct buffer_block *next;
} buffer_block;

/* The buffers that one call holds, as many as it takes; after the first failure the others are not
 * taken. Made as {.failed = 0}, it is empty. */
typedef struct buffer_list {
    int failed;
    buffer_block block;
} buffer_list;

void buffers_release(buffer_list *buffers);

/* type: 'd' for float64, 'f' for float32, 'i' for int32. In this and the next three, count is the length that the
 * buffer must have; with -1 any length is accepted, and returned. */
void *buffers_take(buffer_list *buffers, PyObject *object, const char *name, char type, int writable,
                size_t *count);
const double *doubles(buffer_list *buffers, PyObject *object, const char *name, size_t *count);
double *doubles_out(buffer_list *buffers, PyObject *object, const char *name, size_t *count);
const double *doubles_or_none(buffer_list *buffers, PyObject *object, const char *name, size_t *count); /* NULL: None */
const int32_t *integers(buffer_list *buffers, PyObject *object, const char *name, size_t *count);

/* Fails where the object is not a tuple of that size. */
void need_tuple(buffer_list *buffers, PyObject *tuple, Py_ssize_t size);

/* Whether a tuple, not empty, begins with that word. */
int is_kind(PyObject *tuple, const char *kind);

/* Raises what a function of aoimpact.base.errors returns for the arguments, a tuple, which it takes over. */
PyObject *raise_made(const char *maker, PyObject *arguments);

/* Raises the error of aoimpact.base.errors for a status: the table of the core's codes is there. raise_at: with the
 * state in which a law gave NaN, and the contact that failed, or -1. */
PyObject *raise_status(int status, const char *what, double time);
PyObject *raise_at(int status, const char *what, double time, double indentation, double rate,
                   Py_ssize_t contact);

/* Releases the buffers; None, or NULL with an error raised. */
PyObject *finish(buffer_list *buffers, int status, const char *what);

/* ------------------------------------------------------------------ pause.c: signals */

/* How many rows or steps to take next, so that signals are looked for every few hundredths of a second of processor
 * time: twice as many after a short piece, a quarter after a long one. began: clock() before the last piece. */
size_t piece_after(size_t rows, clock_t began);

/* Seconds of a monotonic clock. */
double seconds_now(void);

/* Checks for signals during one call. pause is for the core, and checks every SIGNAL_INTERVAL seconds, with the GIL or,
 * between release and regain, without it. An error is set once it has ended the call. */
#define SIGNAL_INTERVAL 0.02
typedef struct signal_check {
    aoi_pause pause;
    double next;
    PyThreadState *thread; /* while the GIL is released */
} signal_check;

void signal_check_open(signal_check *signals);
void signal_check_release(signal_check *signals);
void signal_check_regain(signal_check *signals);

/* ------------------------------------------------------------------ tuples to structs */

/* (name, parameters, compliance, limit, note, data), made by ContactLaw.for_core and read only here. */
int take_law(buffer_list *buffers, PyObject *tuple, aoi_law *law);

/* (first body, its port, second body, its port, gap, law), made by Contact.for_core; law is what it refers to. */
int take_contact(buffer_list *buffers, PyObject *tuple, aoi_contact *contact, aoi_law *law);

/* raise_status for a run with count laws, any of which may have stopped it; what a law written in
 * Python has raised stays as it is. contact: which went deeper than its law holds, if that is the status.
 * The buffers must still be held. */
PyObject *raise_of_laws(int status, const char *what, double time, const aoi_law *law, size_t count,
                        Py_ssize_t contact);

/* (start, indices, values) of a matrix of n rows. */
int take_sparse(buffer_list *buffers, PyObject *tuple, size_t n, aoi_sparse *matrix);

/* (start, rows, values, pivots, place, panel); factors->work is there already. */
int take_factors(buffer_list *buffers, PyObject *tuple, size_t n, aoi_factors *factors);

/* What the tuple of a body holds, in this order; None for what there is not. Python makes it by these names, which it
 * has from _core.MODES. */
#define MODES_PARTS(X)                                                                             \
    X(omega) X(decay) X(shape) X(push) X(residual) X(gravity) X(inertia) X(centre)                 \
    X(centre_residual) X(load_time) X(load_force) X(full)

/* The matrices of a body and its factors. */
typedef struct taken_full {
    aoi_full full;
    aoi_factors factors;
    double *work;
} taken_full;

/* A system and all that it is made of. */
typedef struct taken {
    aoi_system system;
    aoi_modes *body;
    taken_full *full; /* one a body */
    aoi_contact *contact;
    aoi_law *law; /* one a contact */
    void *links;
    signal_check signals;
} taken;

/* full: room for matrices, or NULL where a body with matrices is refused. */
int take_body(buffer_list *buffers, PyObject *tuple, aoi_modes *body, taken_full *full, signal_check *signals);

/* Bodies and contacts of two tuples, linked; made is empty before, and stays where it is. */
int take_system(buffer_list *buffers, PyObject *bodies, PyObject *contacts, taken *made);
void free_system(taken *made);

/* A track, and all that it takes to read it: what Python holds as a capsule. Only read once a run has written it, so that
 * threads may share it. */
typedef struct kept_track {
    buffer_list buffers;
    taken made;
    aoi_track track;
    PyObject *bodies, *contacts;
} kept_track;

/* One without rows; NULL, or an error set, where it cannot be made. */
kept_track *track_new(PyObject *bodies, PyObject *contacts, int *status);

/* The capsule, which takes it over and leaves NULL; NULL with an error raised. */
PyObject *track_capsule(kept_track **kept);

void track_free(kept_track *kept);

/* -------------------------------------- the module's functions, by file; module.c has their table */

/* laws.c */
PyObject *law_force(PyObject *self, PyObject *args);
PyObject *law_potential(PyObject *self, PyObject *args);

/* reduce.c */
PyObject *static_constrained(PyObject *self, PyObject *args);
PyObject *static_free(PyObject *self, PyObject *args);
PyObject *constraint_project(PyObject *self, PyObject *args);
PyObject *constraint_reflector(PyObject *self, PyObject *args);
PyObject *constraint_congruence(PyObject *self, PyObject *args);
PyObject *star_from_constraint_modes(PyObject *self, PyObject *args);

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
PyObject *blocks_pattern(PyObject *self, PyObject *args);
PyObject *blocks_multiply(PyObject *self, PyObject *args);
PyObject *blocks_subtract(PyObject *self, PyObject *args);
PyObject *blocks_smooth(PyObject *self, PyObject *args);
PyObject *graph_aggregate(PyObject *self, PyObject *args);

/* newmark.c */
PyObject *newmark(PyObject *self, PyObject *args);

/* adaptive.c */
PyObject *adaptive(PyObject *self, PyObject *args);

/* track.c */
PyObject *track_open(PyObject *self, PyObject *args);
PyObject *track_bytes(PyObject *self, PyObject *capsule);
PyObject *track_rows(PyObject *self, PyObject *capsule);
PyObject *track_sample(PyObject *self, PyObject *args);
PyObject *track_forces(PyObject *self, PyObject *args);
PyObject *track_states(PyObject *self, PyObject *args);

/* many.c */
PyObject *briefs(PyObject *self, PyObject *args);

#endif
