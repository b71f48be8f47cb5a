/* Adaptive runs of scenes, and their dense output, for Python. */
#include "python/binding.h"
#include "aoimpact.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Bytes copied between looks for signals: a hundredth of a second at most. */
#define CHUNK ((size_t)1 << 22)

/* ---------------------------------------------------------------------------------- the run */

static const size_t MOST_BYTES = (size_t)1 << 30;

enum { FIRST_ROWS = 48 };

/* A track grows as the run goes on. */
static int grow(aoi_track *track, size_t room)
{
    const size_t capacity = track->capacity ? 2 * track->capacity : room + 4096;
    const size_t rows = track->row_capacity ? 2 * track->row_capacity : FIRST_ROWS;
    double *values = realloc(track->values, capacity * sizeof(double));
    track->values = values ? values : track->values;
    size_t *row = realloc(track->row, rows * sizeof(size_t));
    track->row = row ? row : track->row;
    if (!values || !row) {
        PyErr_NoMemory();
        return 0;
    }
    track->capacity = capacity;
    track->row_capacity = rows;
    return 1;
}

/* Goes on without the GIL, by so many rows at most. */
static int run_piece(aoi_adaptive *run, aoi_track *track, size_t rows)
{
    const size_t all = track->row_capacity;
    int status;
    track->row_capacity = all - track->rows < rows ? all : track->rows + rows;
    Py_BEGIN_ALLOW_THREADS
    status = aoi_adaptive_run(run, track);
    Py_END_ALLOW_THREADS
    track->row_capacity = all;
    return status;
}

/* Runs in pieces, between which signals are checked, up to about most_steps steps, rejected ones included. */
static int run_to_end(aoi_adaptive *run, const aoi_system *system, double end, aoi_track *track,
                      size_t most_steps)
{
    const size_t room = aoi_adaptive_room(system);
    size_t rows = FIRST_ROWS;
    int status = AOI_OK;
    for (aoi_progress at = aoi_adaptive_progress(run); status == AOI_OK && at.time < end;
         at = aoi_adaptive_progress(run)) {
        if (track->used * sizeof(double) > MOST_BYTES || at.steps + at.rejected > most_steps) {
            return AOI_ERROR_TOO_LONG;
        }
        if ((track->capacity - track->used < room || track->rows == track->row_capacity) &&
            !grow(track, room)) {
            break;
        }
        const int timed = track->rows > 0; /* most runs have one piece, shorter than a look at the clock is worth */
        const clock_t began = timed ? clock() : 0;
        status = run_piece(run, track, rows);
        rows = timed ? piece_after(rows, began) : rows;
        if (PyErr_CheckSignals() != 0) {
            break;
        }
    }
    return status;
}

/* The start: bodies that move as a whole (moving: their rates at unit velocity) from modes x, or from
 * none of them where x is None. v: the rates, set here. */
static void take_start(buffer_list *buffers, PyObject *x_in, PyObject *moving, PyObject *velocities,
                       const aoi_system *system, double *v, aoi_start *start)
{
    size_t all = system->first[system->body_count];
    start->x = doubles_or_none(buffers, x_in, "x", &all);
    start->v = v;
    start->rested = start->x != NULL;
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
            v[system->first[b] + j] = velocity * rate[j];
        }
    }
}

static int append_pair(PyObject *list, double first, double second)
{
    PyObject *pair = Py_BuildValue("dd", first, second);
    const int fine = pair && PyList_Append(list, pair) == 0;
    Py_XDECREF(pair);
    return fine;
}

/* Of each contact (peak force, its time, impulse, [(start, end)], [(impulse, pace)]). */
static PyObject *contacts_without_intervals(const aoi_adaptive *run, size_t count)
{
    PyObject *result = PyTuple_New((Py_ssize_t)count);
    for (size_t c = 0; result && c < count; c++) {
        const aoi_peak of = aoi_adaptive_peak(run, c);
        PyObject *spans = PyList_New(0), *touches = PyList_New(0);
        PyObject *one = spans && touches
                            ? Py_BuildValue("dddOO", of.force, of.time, of.impulse, spans, touches)
                            : NULL;
        Py_XDECREF(spans);
        Py_XDECREF(touches);
        if (!one || PyTuple_SetItem(result, (Py_ssize_t)c, one) != 0) {
            Py_CLEAR(result);
        }
    }
    return result;
}

/* Intervals that are found by one reading of the track; two readings find more. */
enum { FEW_INTERVALS = 4 };

static PyObject *contacts_of(const aoi_adaptive *run, const aoi_system *system, const aoi_track *track,
                             double end)
{
    const size_t contacts = system->contact_count;
    PyObject *result = contacts_without_intervals(run, contacts);
    aoi_interval *work = malloc((contacts + 1) * sizeof *work), few[FEW_INTERVALS], *interval = few;
    const size_t count = work ? aoi_track_intervals(system, track, end, work, FEW_INTERVALS, few) : 0;
    if (count > FEW_INTERVALS && (interval = malloc(count * sizeof *interval))) {
        (void)aoi_track_intervals(system, track, end, work, count, interval);
    }
    if (!work || !interval) {
        PyErr_NoMemory();
    }
    int fine = result && work && interval;
    for (size_t i = 0; fine && i < count; i++) {
        PyObject *of = PyTuple_GetItem(result, (Py_ssize_t)interval[i].contact);
        fine = append_pair(PyTuple_GetItem(of, 3), interval[i].start, interval[i].end) &&
               append_pair(PyTuple_GetItem(of, 4), interval[i].impulse, interval[i].pace);
    }
    free(work);
    if (interval != few) {
        free(interval);
    }
    if (!fine) {
        Py_CLEAR(result);
    }
    return result;
}

/* A record may fill GiB: signals are checked while it is copied. */
static PyObject *bytes_of(const void *record, size_t size)
{
    PyObject *bytes = PyBytes_FromStringAndSize(NULL, (Py_ssize_t)size);
    for (size_t done = 0; bytes && done < size; done += CHUNK) {
        const size_t left = size - done;
        memcpy(PyBytes_AsString(bytes) + done, (const char *)record + done,
               left < CHUNK ? left : CHUNK);
        if (PyErr_CheckSignals() != 0) {
            Py_CLEAR(bytes);
        }
    }
    return bytes;
}

/* (track, index, x, v, contacts, steps, rejected) */
static PyObject *adaptive_result(const aoi_adaptive *run, const aoi_system *system,
                                 const aoi_track *track, double end)
{
    const Py_ssize_t state = (Py_ssize_t)(system->first[system->body_count] * sizeof(double));
    const aoi_progress at = aoi_adaptive_progress(run);
    PyObject *contacts = contacts_of(run, system, track, end);
    PyObject *rows = contacts ? bytes_of(track->values, track->used * sizeof(double)) : NULL;
    PyObject *index = rows ? bytes_of(track->row, track->rows * sizeof(size_t)) : NULL;
    if (!index) {
        Py_XDECREF(contacts);
        Py_XDECREF(rows);
        return NULL;
    }
    return Py_BuildValue("NNy#y#Nnn", rows, index, (const char *)at.x, state, (const char *)at.v, state,
                         contacts, (Py_ssize_t)at.steps, (Py_ssize_t)at.rejected);
}

/* What one call of adaptive() has to release. */
typedef struct running {
    buffer_list buffers;
    taken made;
    aoi_adaptive *run;
    double *v;
    aoi_track track;
} running;

/* Up to this size a run has room for all contacts closed at once, B. */
static const size_t BYTES_FOR_ALL = (size_t)1 << 24;

/* Contacts closed at once for which a run has room at first: fewer than all where bodies with many contacts make it
 * large. Few of these are closed at once as a rule, and the run is much faster as well. */
static size_t first_at_once(aoi_system system)
{
    system.at_once = system.contact_count;
    for (size_t size = aoi_adaptive_size(&system), before = SIZE_MAX; size > BYTES_FOR_ALL && size < before / 4 * 3;) {
        system.at_once = (system.at_once + 1) / 2;
        before = size;
        size = aoi_adaptive_size(&system);
    }
    return system.at_once;
}

/* Makes the run, and makes it again with more room for as long as it has too little. */
static int run_with_room(running *all, const aoi_start *start, double rtol, double end, size_t most_steps)
{
    aoi_system *system = &all->made.system;
    int status = AOI_ERROR_CROWDED;
    for (system->at_once = first_at_once(*system); status == AOI_ERROR_CROWDED; system->at_once *= 2) {
        free(all->run);
        all->run = malloc(aoi_adaptive_size(system));
        if (!all->run) {
            PyErr_NoMemory();
            return AOI_OK;
        }
        all->track.used = all->track.rows = 0;
        status = aoi_adaptive_start(all->run, system, start, rtol, end);
        if (status == AOI_OK) {
            status = run_to_end(all->run, system, end, &all->track, most_steps);
        }
    }
    return status;
}

static void release_run(running *all)
{
    buffers_release(&all->buffers);
    free(all->run);
    free(all->v);
    free(all->track.values);
    free(all->track.row);
    free_system(&all->made);
}

PyObject *adaptive(PyObject *self, PyObject *args)
{
    PyObject *bodies, *contacts, *x_in, *moving, *velocities, *result = NULL;
    running all = {.run = NULL};
    const aoi_system *system = &all.made.system;
    aoi_start start;
    double rtol, end;
    aoi_progress reached = {.time = 0.0};
    Py_ssize_t most_steps;
    (void)self;
    if (!PyArg_ParseTuple(args, "O!O!ddOOOn", &PyTuple_Type, &bodies, &PyTuple_Type, &contacts, &rtol, &end,
                          &x_in, &moving, &velocities, &most_steps)) {
        return NULL;
    }
    int status = take_system(&all.buffers, bodies, contacts, &all.made);
    if (!all.buffers.failed && status == AOI_OK) {
        all.v = calloc(system->first[system->body_count] + 1, sizeof(double));
        if (all.v) {
            take_start(&all.buffers, x_in, moving, velocities, system, all.v, &start);
        } else {
            PyErr_NoMemory();
        }
    }
    if (!all.buffers.failed && !PyErr_Occurred() && status == AOI_OK) {
        status = run_with_room(&all, &start, rtol, end, (size_t)most_steps);
        reached = all.run ? aoi_adaptive_progress(all.run) : reached;
    }
    if (!all.buffers.failed && !PyErr_Occurred()) {
        result = status == AOI_OK ? adaptive_result(all.run, system, &all.track, end)
                                  : raise_of_laws(status, "adaptive run", reached.time, all.made.law,
                                                  system->contact_count, (Py_ssize_t)reached.failed);
    }
    release_run(&all);
    return result;
}

/* ------------------------------------------------------------------------------ dense output */

/* A track opened to be sampled. */
typedef struct opened {
    buffer_list buffers;
    taken made;
    aoi_sampler *sampler;
    const double *times;
    size_t count;
} opened;

static int open_track(opened *all, PyObject *bodies, PyObject *contacts, PyObject *track_in,
                      const char *index, Py_ssize_t index_size, PyObject *times_in)
{
    size_t values = (size_t)-1;
    all->count = (size_t)-1;
    const int status = take_system(&all->buffers, bodies, contacts, &all->made);
    const double *row = doubles(&all->buffers, track_in, "track", &values);
    all->times = doubles(&all->buffers, times_in, "times", &all->count);
    if (all->buffers.failed || status != AOI_OK) {
        return status;
    }
    /* Only read. */
    const aoi_track track = {.values = (double *)row, .row = (size_t *)(void *)index, .used = values,
                             .rows = (size_t)index_size / sizeof(size_t)};
    all->sampler = malloc(aoi_sampler_size(&all->made.system));
    if (!all->sampler) {
        all->buffers.failed = 1;
        PyErr_NoMemory();
        return AOI_OK;
    }
    return aoi_sampler_start(all->sampler, &all->made.system, &track);
}

static PyObject *close_track(opened *all, int status)
{
    PyObject *done = finish(&all->buffers, status, "dense output");
    free(all->sampler);
    free_system(&all->made);
    if (done && PyErr_Occurred()) {
        Py_DECREF(done);
        return NULL;
    }
    return done;
}

/* Whether another column may be computed before the next check of signals; started: the time of the last one, s. */
static int has_time(double started) { return seconds_now() - started < SIGNAL_INTERVAL; }

PyObject *track_sample(PyObject *self, PyObject *args)
{
    PyObject *bodies, *contacts, *track_in, *times_in, *record_out;
    const char *index;
    Py_ssize_t index_size;
    int energies;
    opened all;
    memset(&all, 0, sizeof all);
    (void)self;
    if (!PyArg_ParseTuple(args, "O!O!Oy#OOp", &PyTuple_Type, &bodies, &PyTuple_Type, &contacts,
                          &track_in, &index, &index_size, &times_in, &record_out, &energies)) {
        return NULL;
    }
    int status = open_track(&all, bodies, contacts, track_in, index, index_size, times_in);
    size_t wanted = all.made.system.first ? aoi_record_rows(&all.made.system) * all.count : (size_t)-1;
    double *record = doubles_out(&all.buffers, record_out, "record", &wanted);
    for (size_t i = 0; !all.buffers.failed && status == AOI_OK && i < all.count &&
                       PyErr_CheckSignals() == 0;) {
        const double started = seconds_now();
        Py_BEGIN_ALLOW_THREADS
        for (; i < all.count && has_time(started); i++) {
            aoi_sampler_column(all.sampler, all.times[i], energies, record + i, all.count);
        }
        Py_END_ALLOW_THREADS
    }
    return close_track(&all, status);
}

PyObject *track_forces(PyObject *self, PyObject *args)
{
    PyObject *bodies, *contacts, *track_in, *times_in, *forces_out;
    const char *index;
    Py_ssize_t index_size;
    opened all;
    memset(&all, 0, sizeof all);
    (void)self;
    if (!PyArg_ParseTuple(args, "O!O!Oy#OO", &PyTuple_Type, &bodies, &PyTuple_Type, &contacts,
                          &track_in, &index, &index_size, &times_in, &forces_out)) {
        return NULL;
    }
    const int status = open_track(&all, bodies, contacts, track_in, index, index_size, times_in);
    size_t wanted = all.buffers.failed ? 0 : all.made.system.contact_count * all.count;
    double *forces = doubles_out(&all.buffers, forces_out, "forces", &wanted);
    for (size_t i = 0; !all.buffers.failed && status == AOI_OK && i < all.count &&
                       PyErr_CheckSignals() == 0;) {
        const double started = seconds_now();
        Py_BEGIN_ALLOW_THREADS
        for (; i < all.count && has_time(started); i++) {
            aoi_sampler_forces(all.sampler, all.times[i], forces + i, all.count);
        }
        Py_END_ALLOW_THREADS
    }
    return close_track(&all, status);
}

PyObject *track_states(PyObject *self, PyObject *args)
{
    PyObject *bodies, *contacts, *track_in, *times_in, *states_out;
    const char *index;
    Py_ssize_t index_size, body;
    opened all;
    memset(&all, 0, sizeof all);
    (void)self;
    if (!PyArg_ParseTuple(args, "O!O!Oy#OnO", &PyTuple_Type, &bodies, &PyTuple_Type, &contacts,
                          &track_in, &index, &index_size, &times_in, &body, &states_out)) {
        return NULL;
    }
    int status = open_track(&all, bodies, contacts, track_in, index, index_size, times_in);
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
            aoi_sampler_state(all.sampler, all.times[i], (size_t)body, states + i * width);
        }
        Py_END_ALLOW_THREADS
    }
    return close_track(&all, status);
}
