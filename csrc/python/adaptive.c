/* Adaptive runs of scenes, and their dense output, seen from Python. */
#include "python/binding.h"
#include "linear/vector.h"
#include "law/law.h"
#include "motion/polynomial.h"
#include "motion/radau.h"
#include "collocation/collocation.h"
#include "adaptive/adaptive.h"
#include "adaptive/row.h"
#include "track/sampler.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Rows, or bytes, between looks for signals: a hundredth of a second at most. */
#define AT_ONCE ((size_t)1 << 22)

/* ----------------------------------------------------------------------- bodies and contacts */

/* A system and all that it is made of. */
typedef struct taken {
    aoi_system system;
    aoi_modes *body;
    aoi_joint *joint;
    aoi_law *law; /* one a joint */
    size_t *first, *first_port, *first_joint, *joint_of;
} taken;

static void give_up(taken *made)
{
    free(made->body);
    free(made->joint);
    free(made->law);
    free(made->first);
    free(made->first_port);
    free(made->first_joint);
    free(made->joint_of);
}

/* An array that may be None. */
static const double *maybe(held *buffers, PyObject *object, const char *name, size_t *count)
{
    return object == Py_None ? NULL : doubles(buffers, object, name, count);
}

void take_modes(held *buffers, PyObject *tuple, aoi_modes *body)
{
    size_t n = (size_t)-1, shapes = (size_t)-1;
    need_tuple(buffers, tuple, 11);
    if (buffers->failed) {
        return;
    }
    PyObject *item[11];
    for (Py_ssize_t i = 0; i < 11; i++) {
        item[i] = PyTuple_GetItem(tuple, i);
    }
    body->omega = doubles(buffers, item[0], "omega", &n);
    body->decay = maybe(buffers, item[1], "decay", &n);
    body->shape = doubles(buffers, item[2], "shape", &shapes);
    body->push = doubles(buffers, item[3], "push", &shapes);
    if (!buffers->failed && (n == 0 || shapes % n != 0 || shapes == 0)) {
        buffers->failed = 1;
        PyErr_SetString(PyExc_ValueError, "a body needs modes and ports");
    }
    body->n = n;
    body->ports = buffers->failed ? 1 : shapes / n;
    size_t ports = body->ports, pairs = ports * ports, times = (size_t)-1;
    body->residual = maybe(buffers, item[4], "residual", &pairs);
    body->gravity = maybe(buffers, item[5], "gravity", &n);
    body->inertia = doubles(buffers, item[6], "inertia", &n);
    body->centre = doubles(buffers, item[7], "centre", &n);
    body->centre_residual = maybe(buffers, item[8], "centre residual", &ports);
    body->load_time = maybe(buffers, item[9], "load times", &times);
    body->load_count = body->load_time ? times : 0;
    size_t loads = body->load_count * ports;
    body->load_force = body->load_time ? doubles(buffers, item[10], "load forces", &loads) : NULL;
}

/* (first body, its port, second body, its port, gap, law) */
static int take_joint(held *buffers, PyObject *tuple, aoi_joint *joint, aoi_law *law)
{
    need_tuple(buffers, tuple, 6);
    if (buffers->failed) {
        return AOI_OK;
    }
    for (Py_ssize_t i = 0; i < 2; i++) {
        joint->body[i] = PyLong_AsSize_t(PyTuple_GetItem(tuple, 2 * i));
        joint->port[i] = PyLong_AsSize_t(PyTuple_GetItem(tuple, 2 * i + 1));
    }
    joint->gap = PyFloat_AsDouble(PyTuple_GetItem(tuple, 4));
    joint->law = law;
    if (PyErr_Occurred()) {
        buffers->failed = 1;
        return AOI_OK;
    }
    return take_law(buffers, PyTuple_GetItem(tuple, 5), law);
}

static int take_system(held *buffers, PyObject *bodies, PyObject *joints, taken *made)
{
    const size_t nb = (size_t)PyTuple_Size(bodies), nj = (size_t)PyTuple_Size(joints);
    made->body = calloc(nb + 1, sizeof *made->body);
    made->joint = calloc(nj + 1, sizeof *made->joint);
    made->law = calloc(nj + 1, sizeof *made->law);
    made->first = calloc(nb + 1, sizeof *made->first);
    made->first_port = calloc(nb + 1, sizeof *made->first_port);
    made->first_joint = calloc(nb + 1, sizeof *made->first_joint);
    made->joint_of = calloc(2 * nj + 1, sizeof *made->joint_of);
    if (!made->body || !made->joint || !made->law || !made->first || !made->first_port ||
        !made->first_joint || !made->joint_of) {
        buffers->failed = 1;
        PyErr_NoMemory();
        return AOI_OK;
    }
    int status = AOI_OK;
    for (size_t b = 0; b < nb && !buffers->failed; b++) {
        take_modes(buffers, PyTuple_GetItem(bodies, (Py_ssize_t)b), &made->body[b]);
        made->first[b + 1] = made->first[b] + made->body[b].n;
        made->first_port[b + 1] = made->first_port[b] + made->body[b].ports;
    }
    for (size_t c = 0; c < nj && !buffers->failed && status == AOI_OK; c++) {
        status = take_joint(buffers, PyTuple_GetItem(joints, (Py_ssize_t)c), &made->joint[c],
                            &made->law[c]);
    }
    made->system = (aoi_system){.body_count = nb, .joint_count = nj, .body = made->body};
    made->system.first = made->first;
    made->system.first_port = made->first_port;
    made->system.joint = made->joint;
    const int linked = buffers->failed ? AOI_OK
                                       : aoi_system_link(&made->system, made->first_joint, made->joint_of);
    return status != AOI_OK ? status : linked;
}

/* ---------------------------------------------------------------------------------- the run */

/* A track that grows as the run goes on. */
typedef struct growing {
    double *track;
    size_t *index;
    size_t used, capacity, rows, most;
} growing;

static const size_t MOST_BYTES = (size_t)1 << 30;

enum { FIRST_ROWS = 48 };

static int grow(growing *track, size_t row_size)
{
    const size_t capacity = track->capacity ? 2 * track->capacity : row_size + 4096;
    const size_t most = track->most ? 2 * track->most : FIRST_ROWS;
    double *values = realloc(track->track, capacity * sizeof(double));
    track->track = values ? values : track->track;
    size_t *index = realloc(track->index, most * sizeof(size_t));
    track->index = index ? index : track->index;
    if (!values || !index) {
        PyErr_NoMemory();
        return 0;
    }
    track->capacity = capacity;
    track->most = most;
    return 1;
}

/* Runs without the GIL, in pieces between which signals are heard; no more steps, tried in vain or not,
 * than about so many. */
static int run_to_end(aoi_adaptive *run, growing *track, size_t most_steps)
{
    /* A row costs some 0.2 us a mode: pieces of a tenth of a second at most. */
    const size_t modes = run->system->first[run->system->body_count];
    const size_t between_signals = 1 + 400000 / (modes + 100);
    int status = aoi_adaptive_start(run);
    while (status == AOI_OK && run->time < run->end) {
        size_t used = 0, rows = 0;
        if (track->used * sizeof(double) > MOST_BYTES || run->steps + run->rejected > most_steps) {
            return AOI_ERROR_TOO_LONG;
        }
        if ((track->capacity - track->used < run->row_size || track->rows == track->most) &&
            !grow(track, run->row_size)) {
            break;
        }
        const size_t left = track->most - track->rows;
        Py_BEGIN_ALLOW_THREADS
        status = aoi_adaptive_run(run, track->capacity - track->used,
                                  left < between_signals ? left : between_signals,
                                  track->track + track->used, track->index + track->rows, &used,
                                  &rows);
        Py_END_ALLOW_THREADS
        for (size_t i = 0; i < rows; i++) {
            track->index[track->rows + i] += track->used;
        }
        track->used += used;
        track->rows += rows;
        if (PyErr_CheckSignals() != 0) {
            break;
        }
    }
    return status;
}

/* Room for a run; the caller frees run->body, contact, stage, balanced, response, x (and v with it), work, lists. */
static int furnish(aoi_adaptive *run, const aoi_system *system)
{
    size_t work, lists, row;
    const size_t n = system->first[system->body_count];
    aoi_adaptive_size(system, &work, &lists, &row);
    run->system = system;
    run->body = calloc(system->body_count + 1, sizeof *run->body);
    run->response = calloc(system->body_count + 1, sizeof *run->response);
    run->contact = calloc(system->joint_count + 1, sizeof *run->contact);
    run->stage = calloc(system->joint_count + 1, sizeof *run->stage);
    run->balanced = calloc(system->joint_count + 1, sizeof *run->balanced);
    run->x = calloc(2 * n + 1, sizeof(double));
    run->v = run->x ? run->x + n : NULL;
    run->work = malloc((work + 1) * sizeof(double));
    run->lists = malloc((lists + 1) * sizeof(size_t));
    if (!run->body || !run->response || !run->contact || !run->stage || !run->balanced || !run->x ||
        !run->work || !run->lists) {
        PyErr_NoMemory();
        return 0;
    }
    return 1;
}

/* The start: bodies that move as a whole (moving: their rates at unit velocity) from modes x, or from
 * none of them where x is None. */
static void take_start(held *buffers, PyObject *x_in, PyObject *moving, PyObject *velocities,
                       aoi_adaptive *run)
{
    const aoi_system *system = run->system;
    size_t all = system->first[system->body_count];
    const double *x = maybe(buffers, x_in, "x", &all);
    run->rested = x != NULL;
    if (x) {
        memcpy(run->x, x, all * sizeof(double));
    }
    need_tuple(buffers, moving, (Py_ssize_t)system->body_count);
    need_tuple(buffers, velocities, (Py_ssize_t)system->body_count);
    for (size_t b = 0; b < system->body_count && !buffers->failed; b++) {
        size_t n = system->body[b].n;
        const double *rate = doubles(buffers, PyTuple_GetItem(moving, (Py_ssize_t)b), "moving", &n);
        const double velocity = PyFloat_AsDouble(PyTuple_GetItem(velocities, (Py_ssize_t)b));
        if (PyErr_Occurred()) {
            buffers->failed = 1;
        }
        for (size_t j = 0; j < n && !buffers->failed; j++) {
            run->v[system->first[b] + j] = velocity * rate[j];
        }
    }
}

/* What is known of a contact while its intervals are gathered. */
typedef struct history {
    int closed;
    double start, rate; /* of the interval under way, and of the indentation as it began */
    double until, impulse, deepest;
    PyObject *intervals, *touches; /* lists of (start, end) and of (impulse, pace) */
} history;

static int append_pair(PyObject *list, double first, double second)
{
    PyObject *pair = Py_BuildValue("dd", first, second);
    const int fine = pair && PyList_Append(list, pair) == 0;
    Py_XDECREF(pair);
    return fine;
}

/* An interval is over; one that would begin where the record ends is none. */
static int close_interval(history *known, double end, double record_end)
{
    const double lasted = end - known->start;
    const double pace = known->deepest > 0.0 ? known->rate * lasted / known->deepest : 0.0;
    known->closed = 0;
    return known->start >= record_end || (append_pair(known->intervals, known->start, end) &&
                                          append_pair(known->touches, known->impulse, pace));
}

/* What a contact does in one row. One that is in no row any more has ended where its last one did. */
static int follow_contact(const double *row, const double *of, history *known, double record_end)
{
    const double start = row[AOI_TRACK_START], end = start + row[AOI_TRACK_LENGTH];
    /* It may have slackened at the very start of the row. */
    const int slack = of[AOI_TRACK_PIECE] == AOI_SLACK;
    double slope;
    if ((slack || of[AOI_TRACK_BEGINS] != 0.0) && known->closed &&
        !close_interval(known, known->until, record_end)) {
        return 0;
    }
    if (slack) {
        return 1;
    }
    if (of[AOI_TRACK_BEGINS] != 0.0) {
        (void)aoi_legendre_evaluate(AOI_STAGES + 1, of + AOI_TRACK_INDENTATION, 0.0, &slope);
        known->start = start;
        known->rate = slope / row[AOI_TRACK_LENGTH];
        known->closed = 1;
        known->impulse = known->deepest = 0.0;
    }
    known->deepest = fmax(known->deepest, aoi_legendre_evaluate(AOI_STAGES + 1, of + AOI_TRACK_INDENTATION,
                                                                1.0, &slope));
    known->impulse += row[AOI_TRACK_LENGTH] * aoi_vector_dot(AOI_STAGES, aoi_radau_to_legendre[0],
                                                             of + AOI_TRACK_FORCE);
    known->until = end;
    return of[AOI_TRACK_ENDS] == 0.0 || close_interval(known, end, record_end);
}

static int gather_intervals(const growing *track, const aoi_system *system, double end, history *seen)
{
    for (size_t r = 0; r < track->rows; r++) {
        const double *row = track->track + track->index[r], *of = row + AOI_TRACK_FIXED;
        if (r % (AT_ONCE / 64) == 0 && PyErr_CheckSignals() != 0) {
            return 0;
        }
        for (size_t i = 0; i < (size_t)row[AOI_TRACK_BODIES]; i++) {
            of += AOI_TRACK_STATE + 2 * system->body[(size_t)of[0]].n;
        }
        for (size_t i = 0; i < (size_t)row[AOI_TRACK_CONTACTS]; i++) {
            if (!follow_contact(row, of, &seen[(size_t)of[AOI_TRACK_JOINT]], end)) {
                return 0;
            }
            of += AOI_TRACK_CONTACT_SIZE;
        }
    }
    for (size_t c = 0; c < system->joint_count; c++) {
        const int lasting = seen[c].until >= end * (1.0 - 1e-14);
        if (seen[c].closed && !close_interval(&seen[c], lasting ? end : seen[c].until, end)) {
            return 0;
        }
    }
    return 1;
}

/* Of each contact (peak force, its time, impulse, intervals, touches). */
static PyObject *contacts_of(const aoi_adaptive *run, const growing *track)
{
    const size_t count = run->system->joint_count;
    PyObject *result = PyTuple_New((Py_ssize_t)count);
    history *seen = calloc(count + 1, sizeof *seen);
    int fine = result && seen;
    for (size_t c = 0; fine && c < count; c++) {
        const aoi_contact_state *of = &run->contact[c];
        seen[c].intervals = PyList_New(0);
        seen[c].touches = PyList_New(0);
        PyObject *one = seen[c].intervals && seen[c].touches
                            ? Py_BuildValue("dddOO", of->peak_force, of->peak_time, of->impulse,
                                            seen[c].intervals, seen[c].touches)
                            : NULL;
        fine = one && PyTuple_SetItem(result, (Py_ssize_t)c, one) == 0;
    }
    fine = fine && gather_intervals(track, run->system, run->end, seen);
    for (size_t c = 0; seen && c < count; c++) {
        Py_XDECREF(seen[c].intervals);
        Py_XDECREF(seen[c].touches);
    }
    if (!seen) {
        PyErr_NoMemory();
    }
    free(seen);
    if (!fine) {
        Py_XDECREF(result);
        return NULL;
    }
    return result;
}

/* A record may fill GiB: signals are heard while it is copied. */
static PyObject *bytes_of(const void *record, size_t size)
{
    PyObject *bytes = PyBytes_FromStringAndSize(NULL, (Py_ssize_t)size);
    for (size_t done = 0; bytes && done < size; done += AT_ONCE) {
        const size_t left = size - done;
        memcpy(PyBytes_AsString(bytes) + done, (const char *)record + done,
               left < AT_ONCE ? left : AT_ONCE);
        if (PyErr_CheckSignals() != 0) {
            Py_CLEAR(bytes);
        }
    }
    return bytes;
}

/* (track, index, x, v, contacts, steps, rejected) */
static PyObject *adaptive_result(const aoi_adaptive *run, const growing *track)
{
    const size_t n = run->system->first[run->system->body_count];
    const Py_ssize_t state = (Py_ssize_t)(n * sizeof(double));
    PyObject *contacts = contacts_of(run, track);
    PyObject *rows = contacts ? bytes_of(track->track, track->used * sizeof(double)) : NULL;
    PyObject *index = rows ? bytes_of(track->index, track->rows * sizeof(size_t)) : NULL;
    if (!index) {
        Py_XDECREF(contacts);
        Py_XDECREF(rows);
        return NULL;
    }
    return Py_BuildValue("NNy#y#Nnn", rows, index, (const char *)run->x, state,
                         (const char *)run->v, state, contacts, (Py_ssize_t)run->steps,
                         (Py_ssize_t)run->rejected);
}

PyObject *adaptive(PyObject *self, PyObject *args)
{
    PyObject *bodies, *joints, *x_in, *moving, *velocities, *result = NULL;
    held buffers = {.failed = 0};
    taken made = {.body = NULL};
    aoi_adaptive run = {.system = NULL};
    growing track = {.track = NULL};
    Py_ssize_t most_steps;
    (void)self;
    if (!PyArg_ParseTuple(args, "O!O!ddOOOn", &PyTuple_Type, &bodies, &PyTuple_Type, &joints, &run.rtol,
                          &run.end, &x_in, &moving, &velocities, &most_steps)) {
        return NULL;
    }
    int status = take_system(&buffers, bodies, joints, &made);
    if (!buffers.failed && status == AOI_OK && furnish(&run, &made.system)) {
        take_start(&buffers, x_in, moving, velocities, &run);
        status = buffers.failed ? AOI_OK : run_to_end(&run, &track, (size_t)most_steps);
    }
    if (!buffers.failed && !PyErr_Occurred()) {
        result = status == AOI_OK
                     ? adaptive_result(&run, &track)
                     : raise_of_laws(status, "adaptive run", run.time, made.law,
                                     made.system.joint_count);
    }
    held_release(&buffers);
    free(run.body);
    free(run.response);
    free(run.contact);
    free(run.stage);
    free(run.balanced);
    free(run.x);
    free(run.work);
    free(run.lists);
    free(track.track);
    free(track.index);
    give_up(&made);
    return result;
}

/* ------------------------------------------------------------------------------ dense output */

/* A track opened to be sampled. */
typedef struct opened {
    held buffers;
    taken made;
    aoi_sampler sampler;
    size_t *places;
    const double *times;
    size_t count;
} opened;

static int open_track(opened *all, PyObject *bodies, PyObject *joints, PyObject *track_in,
                      const char *index, Py_ssize_t index_size, PyObject *times_in)
{
    size_t values = (size_t)-1;
    all->count = (size_t)-1;
    int status = take_system(&all->buffers, bodies, joints, &all->made);
    const aoi_system *system = &all->made.system;
    all->sampler.track = doubles(&all->buffers, track_in, "track", &values);
    all->times = doubles(&all->buffers, times_in, "times", &all->count);
    if (all->buffers.failed || status != AOI_OK) {
        return status;
    }
    all->sampler.system = system;
    all->sampler.size = values;
    all->sampler.index = (const size_t *)(const void *)index;
    all->sampler.rows = (size_t)index_size / sizeof(size_t);
    all->places = calloc(2 * (system->body_count + system->joint_count) + 1, sizeof(size_t));
    all->sampler.work = malloc((aoi_sampler_size(system) + 1) * sizeof(double));
    if (!all->places || !all->sampler.work) {
        all->buffers.failed = 1;
        PyErr_NoMemory();
        return AOI_OK;
    }
    all->sampler.body_row = all->places;
    all->sampler.body_at = all->places + system->body_count;
    all->sampler.contact_row = all->places + 2 * system->body_count;
    all->sampler.contact_at = all->sampler.contact_row + system->joint_count;
    return aoi_sampler_start(&all->sampler);
}

static PyObject *close_track(opened *all, int status)
{
    PyObject *done = finish(&all->buffers, status, "dense output");
    free(all->places);
    free(all->sampler.work);
    give_up(&all->made);
    if (done && PyErr_Occurred()) {
        Py_DECREF(done);
        return NULL;
    }
    return done;
}

/* Whether there is time for one more column before signals are to be heard; started: the piece, s. */
static int has_time(double started) { return seconds_now() - started < HEARD_EVERY; }

PyObject *track_sample(PyObject *self, PyObject *args)
{
    PyObject *bodies, *joints, *track_in, *times_in, *record_out;
    const char *index;
    Py_ssize_t index_size;
    int energies;
    opened all;
    memset(&all, 0, sizeof all);
    (void)self;
    if (!PyArg_ParseTuple(args, "O!O!Oy#OOp", &PyTuple_Type, &bodies, &PyTuple_Type, &joints,
                          &track_in, &index, &index_size, &times_in, &record_out, &energies)) {
        return NULL;
    }
    int status = open_track(&all, bodies, joints, track_in, index, index_size, times_in);
    size_t wanted = all.buffers.failed ? 0 : aoi_sampler_rows(&all.made.system) * all.count;
    double *record = doubles_out(&all.buffers, record_out, "record", &wanted);
    for (size_t i = 0; !all.buffers.failed && status == AOI_OK && i < all.count &&
                       PyErr_CheckSignals() == 0;) {
        const double started = seconds_now();
        Py_BEGIN_ALLOW_THREADS
        for (; i < all.count && has_time(started); i++) {
            aoi_sampler_column(&all.sampler, all.times[i], energies, record + i, all.count);
        }
        Py_END_ALLOW_THREADS
    }
    return close_track(&all, status);
}

PyObject *track_forces(PyObject *self, PyObject *args)
{
    PyObject *bodies, *joints, *track_in, *times_in, *forces_out;
    const char *index;
    Py_ssize_t index_size;
    opened all;
    memset(&all, 0, sizeof all);
    (void)self;
    if (!PyArg_ParseTuple(args, "O!O!Oy#OO", &PyTuple_Type, &bodies, &PyTuple_Type, &joints,
                          &track_in, &index, &index_size, &times_in, &forces_out)) {
        return NULL;
    }
    const int status = open_track(&all, bodies, joints, track_in, index, index_size, times_in);
    size_t wanted = all.buffers.failed ? 0 : all.made.system.joint_count * all.count;
    double *forces = doubles_out(&all.buffers, forces_out, "forces", &wanted);
    for (size_t i = 0; !all.buffers.failed && status == AOI_OK && i < all.count &&
                       PyErr_CheckSignals() == 0;) {
        const double started = seconds_now();
        Py_BEGIN_ALLOW_THREADS
        for (; i < all.count && has_time(started); i++) {
            aoi_sampler_forces(&all.sampler, all.times[i], forces + i, all.count);
        }
        Py_END_ALLOW_THREADS
    }
    return close_track(&all, status);
}

PyObject *track_states(PyObject *self, PyObject *args)
{
    PyObject *bodies, *joints, *track_in, *times_in, *states_out;
    const char *index;
    Py_ssize_t index_size, body;
    opened all;
    memset(&all, 0, sizeof all);
    (void)self;
    if (!PyArg_ParseTuple(args, "O!O!Oy#OnO", &PyTuple_Type, &bodies, &PyTuple_Type, &joints,
                          &track_in, &index, &index_size, &times_in, &body, &states_out)) {
        return NULL;
    }
    int status = open_track(&all, bodies, joints, track_in, index, index_size, times_in);
    if (!all.buffers.failed && status == AOI_OK &&
        (body < 0 || (size_t)body >= all.made.system.body_count)) {
        status = AOI_ERROR_ARGUMENT;
    }
    const int fine = !all.buffers.failed && status == AOI_OK;
    const size_t width = fine ? 2 * all.made.body[body].n : 0;
    size_t wanted = width * all.count;
    double *states = fine ? doubles_out(&all.buffers, states_out, "states", &wanted) : NULL;
    for (size_t i = 0; fine && !all.buffers.failed && i < all.count && PyErr_CheckSignals() == 0;) {
        const double started = seconds_now();
        Py_BEGIN_ALLOW_THREADS
        for (; i < all.count && has_time(started); i++) {
            aoi_sampler_state(&all.sampler, all.times[i], (size_t)body, states + i * width);
        }
        Py_END_ALLOW_THREADS
    }
    return close_track(&all, status);
}
