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

#include "aoimpact.h"
#include "linear/sparse.h"

/* ------------------------------------------------------------------ call.c: in and out */

enum { MOST_BUFFERS = 40 };

typedef struct buffer_block {
    Py_buffer view[MOST_BUFFERS];
    int count;
    struct buffer_block *next;
} buffer_block;

/* A call's first failure, after which nothing more is taken, and the buffers that it holds. Made as
 * {.status = AOI_OK}, it is empty. */
typedef struct call {
    int status; /* or CALL_RAISED: an error is set; CALL_NO_MEMORY: finish() sets it */
    buffer_block block;
} call;

enum { CALL_RAISED = -1, CALL_NO_MEMORY = -2 };

void call_fail(call *of, int status);
void call_release(call *of);

/* One item of a tuple, and where it goes. kind: 'd', 'f', 'i' for the memory of a buffer of float64, float32, int32;
 * 'D', 'F', 'I' for one to write; 'o' for float64 or None (NULL); 'x' a double, 'n' a size_t, 'p' an int, whether true;
 * 't' a tuple, 'O' any PyObject. An array holds *count * *each + more values; where *count is ANY_LENGTH, it is found. */
typedef struct argument {
    const char *name;
    char kind;
    void *to;
    size_t *count, *each, more;
} argument;

#define ANY_LENGTH ((size_t)-1)
#define VALUE(kind, to) {#to, kind, (void *)&(to), NULL, NULL, 0}
#define ARRAY(kind, to, count) {#to, kind, (void *)&(to), &(count), NULL, 0}
#define LONGER(kind, to, count, more) {#to, kind, (void *)&(to), &(count), NULL, more}
#define MATRIX(kind, to, count, each) {#to, kind, (void *)&(to), &(count), &(each), 0}

/* Takes a tuple by a table of its items; or those from the first on of a tuple of so many. */
#define ROWS(...) sizeof((argument[]){__VA_ARGS__}) / sizeof(argument), (argument[]){__VA_ARGS__}
#define TAKE(of, tuple, ...)                                                                       \
    call_take(of, tuple, 0, sizeof((argument[]){__VA_ARGS__}) / sizeof(argument), ROWS(__VA_ARGS__))
#define TAKE_SOME(of, tuple, first, size, ...) call_take(of, tuple, first, size, ROWS(__VA_ARGS__))
void call_take(call *of, PyObject *tuple, size_t first, size_t size, size_t count, const argument *table);

/* Item i of a tuple of so many. */
PyObject *tuple_item(call *of, PyObject *tuple, size_t i, size_t size);

/* Raises what a function of aoimpact.base.errors returns for the arguments, a tuple, which it takes over. */
void raise_made(const char *maker, PyObject *arguments);

/* Raises the error for a status: the table of the core's codes is in aoimpact.base.errors. With the state in which a
 * law gave NaN, and the contact that failed, or -1. */
void raise_at(int status, const char *what, double time, double indentation, double rate, Py_ssize_t contact);

/* Releases the buffers; what Py_BuildValue makes of the rest, or NULL with an error raised. */
PyObject *finish(call *of, const char *what, const char *format, ...);

/* ------------------------------------------------------------------ pause.c: signals */

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

/* Calls piece, some microseconds of a job each, without the GIL until it returns 0, or a signal has set an error. */
void run_pieces(signal_check *signals, int (*piece)(void *job), void *job);

/* ------------------------------------------------------------------ tuples to structs */

/* (name, parameters, compliance, limit, note, data), made by ContactLaw.for_core and read only here. */
void take_law(call *of, PyObject *tuple, aoi_law *law);

/* (first body, its port, second body, its port, gap, law), made by Contact.for_core; law is what it refers to. */
void take_contact(call *of, PyObject *tuple, aoi_contact *contact, aoi_law *law, aoi_friction *friction);

/* Raises the error of a run's status, if it has one; of count laws any may have stopped it; what a law written in
 * Python has raised stays as it is. contact: which failed. The buffers must still be held. */
void raise_of_laws(call *of, const char *what, double time, const aoi_law *law, size_t count, size_t contact);

/* Entries of the tuple of a body, in this order; None where the body has none. Python takes the names from
 * _core.MODES. */
#define MODES_PARTS(X)                                                                             \
    X(centre) X(shape) X(push) X(omega) X(decay) X(residual) X(gravity) X(inertia)                 \
    X(centre_residual) X(load_time) X(load_force) X(full)

/* The matrices of a body of n coordinates, and a callable that gives the solution for a right-hand side in bytes. */
typedef struct taken_full {
    aoi_full full;
    PyObject *solve;
    size_t n;
} taken_full;

/* A system and all that it is made of. */
typedef struct taken_system {
    aoi_system system;
    aoi_modes *body;
    taken_full *full; /* one a body */
    aoi_contact *contact;
    aoi_law *law; /* one a contact */
    aoi_friction *friction;
    void *links;
    signal_check signals;
} taken_system;

/* full: room for matrices, or NULL where a body with matrices is refused. */
void take_body(call *of, PyObject *tuple, aoi_modes *body, taken_full *full, signal_check *signals);

/* Bodies and contacts of two tuples, linked; made is empty before, and stays where it is. */
void take_system(call *of, PyObject *bodies, PyObject *contacts, taken_system *made);
void free_system(taken_system *made);

/* malloc, zeroed, of count + 1; the call fails where there is no memory. */
void *call_room(call *of, size_t count, size_t size);

/* A track, and all that it takes to read it: what Python holds as a capsule. Only read once a run has written it, so that
 * threads may share it. */
typedef struct kept_track {
    call of; /* holds the buffers */
    taken_system made;
    aoi_track track;
    PyObject *bodies, *contacts;
} kept_track;

/* One without rows; NULL with an error set, or one whose call may have failed. */
kept_track *track_new(PyObject *bodies, PyObject *contacts);

/* The capsule, which takes it over and leaves NULL; NULL with an error raised. */
PyObject *track_capsule(kept_track **kept);

void track_free(kept_track *kept);

/* -------------------------------------- the module's functions, by file; module.c has their table */

#define FUNCTIONS(X)                                                                               \
    /* laws.c */                                                                                   \
    X(law_force) X(law_potential)                                                                  \
    /* star.c */                                                                                   \
    X(star_from_constraint_modes) X(star_to_modal) X(star_from_modal)                              \
    /* multigrid.c */                                                                              \
    X(blocks_pattern) X(blocks_multiply) X(blocks_subtract) X(blocks_smooth) X(graph_aggregate)    \
    /* newmark.c, adaptive.c */                                                                    \
    X(newmark) X(adaptive)                                                                         \
    /* track.c */                                                                                  \
    X(track_open) X(track_bytes) X(track_rows) X(track_slips) X(track_read)                        \
    /* many.c */                                                                                   \
    X(briefs)

#define DECLARED(name) PyObject *name(PyObject *args);
FUNCTIONS(DECLARED)

#endif
