/* Declarations shared by the files of the binding, which only converts arguments and results. Only the files of
 * this folder include Python.h, through this header. The Python side passes arrays as C-contiguous buffers of
 * float64, float32 or int32; results are written into buffers of the caller. The GIL is released for some
 * milliseconds at a time, so that other threads run and Ctrl-C takes effect. */
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

/* State of one call from Python: the status of its first failure, after which no more arguments are read, and the
 * buffers that it holds. Initially {.status = AOI_OK}. */
typedef struct call {
    int status; /* aoi_status, CALL_RAISED (a Python error is set) or CALL_NO_MEMORY */
    buffer_block block;
} call;

enum { CALL_RAISED = -1, CALL_NO_MEMORY = -2 };

void call_fail(call *of, int status);
void call_release(call *of);

/* One item of a tuple of arguments, and the variable that receives it.
 *   name               name of the argument in error messages
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

/* TAKE reads all items of a tuple by a table of arguments. TAKE_SOME reads items from index `first` on, of a tuple
 * that must have `size` items. */
#define ROWS(...) sizeof((argument[]){__VA_ARGS__}) / sizeof(argument), (argument[]){__VA_ARGS__}
#define TAKE(of, tuple, ...)                                                                       \
    call_take(of, tuple, 0, sizeof((argument[]){__VA_ARGS__}) / sizeof(argument), ROWS(__VA_ARGS__))
#define TAKE_SOME(of, tuple, first, size, ...) call_take(of, tuple, first, size, ROWS(__VA_ARGS__))
void call_take(call *of, PyObject *tuple, size_t first, size_t size, size_t count, const argument *table);

/* Returns item i (borrowed reference) of a tuple. The call fails if the tuple does not have `size` items. */
PyObject *tuple_item(call *of, PyObject *tuple, size_t i, size_t size);

/* Raises the exception that the function `maker` of aoimpact.base.errors returns for a tuple of arguments. The
 * reference to the tuple is taken over. */
void raise_made(const char *maker, PyObject *arguments);

/* Raises the exception for a status, made by aoimpact.base.errors.core_error.
 *   what               the computation that failed
 *   time               time reached, s; negative: not known
 *   indentation, rate  state in which a law gave NaN, m and m/s; NaN if none did
 *   contact            index of the contact that failed; -1: not known */
void raise_at(int status, const char *what, double time, double indentation, double rate, Py_ssize_t contact);

/* Ends a call: releases its buffers, and returns Py_BuildValue(format, ...) or, if the call has failed, NULL with
 * an error set. what: the computation, for the error message. */
PyObject *finish(call *of, const char *what, const char *format, ...);

/* ------------------------------------------------------------------ pause.c: signals */

/* Returns the time of a monotonic clock, s. */
double seconds_now(void);

/* State of the checks for signals, such as Ctrl-C, which one call makes every SIGNAL_INTERVAL seconds. `pause` is
 * passed to the core. Between release and regain the GIL is free, except during the checks. A check that ends the
 * call leaves an error set. */
#define SIGNAL_INTERVAL 0.02
typedef struct signal_check {
    aoi_pause pause;
    double next;           /* time of the next check, s    */
    PyThreadState *thread; /* saved thread state while the GIL is free */
} signal_check;

void signal_check_open(signal_check *signals);
void signal_check_release(signal_check *signals);
void signal_check_regain(signal_check *signals);

/* Calls piece(job) repeatedly without the GIL, until it returns 0 or a signal handler has set an error. Each call
 * must be short, since signals are checked only between calls. */
void run_pieces(signal_check *signals, int (*piece)(void *job), void *job);

/* ------------------------------------------------------------------ tuples to structs */

/* Reads a law from the tuple (name, parameters, compliance, limit, note, data) that ContactLaw.for_core makes. */
void take_law(call *of, PyObject *tuple, aoi_law *law);

/* Reads a contact into *contact, and the law and friction to which it points into *law and *friction. tuple:
 * (first body, its port, second body, its port, gap, law), and with friction a seventh item, as Contact.for_core
 * makes it. */
void take_contact(call *of, PyObject *tuple, aoi_contact *contact, aoi_law *law, aoi_friction *friction);

/* Raises the error for the status of a run, unless an error is set already, for example by a law written in
 * Python. Must be called before the buffers of the notes are released.
 *   what, time  the computation, and the time reached, s
 *   law, count  the run's laws; the first one that gave NaN is reported, from its note
 *   contact     index of the contact that failed */
void raise_of_laws(call *of, const char *what, double time, const aoi_law *law, size_t count, size_t contact);

/* Items of the tuple that describes a body, in this order; an item is None if the body does not have it. Python
 * takes the names from _core.MODES. */
#define MODES_PARTS(X)                                                                             \
    X(centre) X(shape) X(push) X(omega) X(decay) X(residual) X(gravity) X(inertia)                 \
    X(centre_residual) X(load_time) X(load_force) X(full)

/* Matrices of a body of n coordinates, and its solver, a Python callable that takes a right-hand side as bytes and
 * returns the solution. */
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

/* Reads a body from its tuple. full: receives its matrices; if it is NULL, a body with matrices is refused. */
void take_body(call *of, PyObject *tuple, aoi_modes *body, taken_full *full, signal_check *signals);

/* Reads and links a system, from the tuples of its bodies and contacts. *made must be zero before, and must not be
 * moved afterwards, since its members point to each other. */
void take_system(call *of, PyObject *bodies, PyObject *contacts, taken_system *made);
void free_system(taken_system *made);

/* Returns memory for count + 1 elements, set to zero. Without memory it returns NULL, and the call fails. */
void *call_room(call *of, size_t count, size_t size);

/* A track and its system, the content of the capsule that Python holds. Threads may share it, since nothing
 * changes it after the run. */
typedef struct kept_track {
    call of; /* call that holds the buffers */
    taken_system made;
    aoi_track track;
    PyObject *bodies, *contacts;
} kept_track;

/* Returns a new kept_track without rows; NULL with an error set if there is no memory. Its call has failed if the
 * system could not be read. */
kept_track *track_new(PyObject *bodies, PyObject *contacts);

/* Returns the capsule, which takes over *kept and sets it to NULL; NULL with an error set on failure. */
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
