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

/* State of one call from Python: the status of its first failure, after which no more arguments are
 * taken, and the buffers that it holds. {.status = AOI_OK} is an empty one. */
typedef struct call {
    int status; /* aoi_status, CALL_RAISED (a Python error is set) or CALL_NO_MEMORY */
    buffer_block block;
} call;

enum { CALL_RAISED = -1, CALL_NO_MEMORY = -2 };

void call_fail(call *of, int status);
void call_release(call *of);

/* One item of a tuple of arguments, and the variable that receives it.
 *   name               in error messages
 *   kind               'd', 'f', 'i': data of a float64, float32 or int32 buffer; 'D', 'F', 'I': the
 *                      same, writable; 'o': of a float64 buffer, or NULL for None; 'x': a double;
 *                      'n': a size_t; 'p': an int, the truth value; 't': a tuple; 'O': any PyObject
 *   to                 address of the variable
 *   count, each, more  an array must hold *count * *each + more values; if *count is ANY_LENGTH, it
 *                      is set from the array's length */
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

/* TAKE reads all items of a tuple by a table of arguments. TAKE_SOME reads those from item `first`
 * on, of a tuple that must have `size` items. */
#define ROWS(...) sizeof((argument[]){__VA_ARGS__}) / sizeof(argument), (argument[]){__VA_ARGS__}
#define TAKE(of, tuple, ...)                                                                       \
    call_take(of, tuple, 0, sizeof((argument[]){__VA_ARGS__}) / sizeof(argument), ROWS(__VA_ARGS__))
#define TAKE_SOME(of, tuple, first, size, ...) call_take(of, tuple, first, size, ROWS(__VA_ARGS__))
void call_take(call *of, PyObject *tuple, size_t first, size_t size, size_t count, const argument *table);

/* Returns item i, borrowed, of a tuple that must have `size` items; else the call fails. */
PyObject *tuple_item(call *of, PyObject *tuple, size_t i, size_t size);

/* Raises the exception that the function `maker` of aoimpact.base.errors returns for a tuple of
 * arguments, whose reference it takes over. */
void raise_made(const char *maker, PyObject *arguments);

/* Raises the exception for a status, by aoimpact.base.errors.core_error.
 *   what               the computation that failed
 *   time               reached, s; negative: unknown
 *   indentation, rate  at which a law gave NaN, m and m/s; NaN: none did
 *   contact            the one that failed; -1: unknown */
void raise_at(int status, const char *what, double time, double indentation, double rate, Py_ssize_t contact);

/* Ends a call: releases its buffers and returns Py_BuildValue(format, ...), or NULL with an error
 * raised for its status. what: the computation, for the message. */
PyObject *finish(call *of, const char *what, const char *format, ...);

/* ------------------------------------------------------------------ pause.c: signals */

/* Seconds of a monotonic clock. */
double seconds_now(void);

/* Check for signals, such as Ctrl-C, every SIGNAL_INTERVAL seconds of one call. `pause` is passed
 * to the core. Between release and regain the GIL is released, but for the checks themselves. A
 * check that ends the call leaves an error set. */
#define SIGNAL_INTERVAL 0.02
typedef struct signal_check {
    aoi_pause pause;
    double next;           /* time of the next check, s    */
    PyThreadState *thread; /* saved while the GIL is free */
} signal_check;

void signal_check_open(signal_check *signals);
void signal_check_release(signal_check *signals);
void signal_check_regain(signal_check *signals);

/* Calls piece(job), which takes some microseconds, repeatedly and without the GIL, until it returns
 * 0 or a signal handler has set an error. */
void run_pieces(signal_check *signals, int (*piece)(void *job), void *job);

/* ------------------------------------------------------------------ tuples to structs */

/* Reads a law from the tuple (name, parameters, compliance, limit, note, data) of
 * ContactLaw.for_core. */
void take_law(call *of, PyObject *tuple, aoi_law *law);

/* Reads a contact from the tuple (first body, its port, second body, its port, gap, law) of
 * Contact.for_core, with friction as a seventh item, into *contact, and what it points to into *law
 * and *friction. */
void take_contact(call *of, PyObject *tuple, aoi_contact *contact, aoi_law *law, aoi_friction *friction);

/* Raises the error for the status of a run, unless an error, such as that of a law written in
 * Python, is set already.
 *   what, time  the computation, and the time reached, s
 *   law, count  the run's laws; the first one that gave NaN is reported, from its note
 *   contact     the one that failed
 * The buffers that hold the notes must not be released yet. */
void raise_of_laws(call *of, const char *what, double time, const aoi_law *law, size_t count, size_t contact);

/* Items of the tuple of a body, in this order; None: the body has none. Python takes the names from
 * _core.MODES. */
#define MODES_PARTS(X)                                                                             \
    X(centre) X(shape) X(push) X(omega) X(decay) X(residual) X(gravity) X(inertia)                 \
    X(centre_residual) X(load_time) X(load_force) X(full)

/* Matrices of a body of n coordinates, and a Python callable that takes a right-hand side as bytes
 * and returns the solution. */
typedef struct taken_full {
    aoi_full full;
    PyObject *solve;
    size_t n;
} taken_full;

/* A system and the arrays that it points to. */
typedef struct taken_system {
    aoi_system system;
    aoi_modes *body;
    taken_full *full; /* one per body */
    aoi_contact *contact;
    aoi_law *law; /* one per contact */
    aoi_friction *friction;
    void *links;
    signal_check signals;
} taken_system;

/* Reads a body from its tuple. full: for its matrices; NULL: a body with matrices is refused. */
void take_body(call *of, PyObject *tuple, aoi_modes *body, taken_full *full, signal_check *signals);

/* Reads and links a system, from the tuples of its bodies and contacts. *made must be zero before,
 * and must not be moved afterwards: its parts point to each other. */
void take_system(call *of, PyObject *bodies, PyObject *contacts, taken_system *made);
void free_system(taken_system *made);

/* Allocates count + 1 zeroed elements. Without memory it returns NULL, and the call fails. */
void *call_room(call *of, size_t count, size_t size);

/* A track and its system: the content of the capsule that Python holds. Threads may share it, since
 * nothing changes it after the run. */
typedef struct kept_track {
    call of; /* holds the buffers */
    taken_system made;
    aoi_track track;
    PyObject *bodies, *contacts;
} kept_track;

/* Makes a kept_track without rows, whose call may have failed; returns NULL with an error set if
 * there is no memory. */
kept_track *track_new(PyObject *bodies, PyObject *contacts);

/* Makes the capsule, which takes over *kept and sets it to NULL; returns NULL with an error raised
 * on failure. */
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
