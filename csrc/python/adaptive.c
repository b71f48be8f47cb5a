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

/* (track, x, v, contacts, steps, rejected); the track is given away. */
static PyObject *adaptive_result(const aoi_adaptive *run, kept_track **kept, double end)
{
    const aoi_system *system = &(*kept)->made.system;
    const Py_ssize_t state = (Py_ssize_t)(system->first[system->body_count] * sizeof(double));
    const aoi_progress at = aoi_adaptive_progress(run);
    PyObject *contacts = contacts_of(run, system, &(*kept)->track, end);
    PyObject *track = contacts ? track_capsule(kept) : NULL;
    if (!track) {
        Py_XDECREF(contacts);
        return NULL;
    }
    return Py_BuildValue("Ny#y#Nnn", track, (const char *)at.x, state, (const char *)at.v, state, contacts,
                         (Py_ssize_t)at.steps, (Py_ssize_t)at.rejected);
}

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
static int run_with_room(aoi_adaptive **run, kept_track *kept, const aoi_start *start, double rtol, double end,
                         size_t most_steps)
{
    aoi_system *system = &kept->made.system;
    int status = AOI_ERROR_CROWDED;
    for (system->at_once = first_at_once(*system); status == AOI_ERROR_CROWDED; system->at_once *= 2) {
        free(*run);
        *run = malloc(aoi_adaptive_size(system));
        if (!*run) {
            PyErr_NoMemory();
            return AOI_OK;
        }
        kept->track.used = kept->track.rows = 0;
        status = aoi_adaptive_start(*run, system, start, rtol, end);
        if (status == AOI_OK) {
            status = run_to_end(*run, system, end, &kept->track, most_steps);
        }
    }
    return status;
}

PyObject *adaptive(PyObject *self, PyObject *args)
{
    PyObject *bodies, *contacts, *x_in, *moving, *velocities, *result = NULL;
    aoi_start start = {.x = NULL};
    double rtol, end, *v = NULL;
    aoi_adaptive *run = NULL;
    aoi_progress reached = {.time = 0.0};
    Py_ssize_t most_steps;
    (void)self;
    if (!PyArg_ParseTuple(args, "O!O!ddOOOn", &PyTuple_Type, &bodies, &PyTuple_Type, &contacts, &rtol, &end,
                          &x_in, &moving, &velocities, &most_steps)) {
        return NULL;
    }
    int status;
    buffer_list starts = {.failed = 0};
    kept_track *kept = track_new(bodies, contacts, &status);
    int fine = kept && status == AOI_OK && !PyErr_Occurred();
    if (fine) {
        const aoi_system *system = &kept->made.system;
        v = calloc(system->first[system->body_count] + 1, sizeof(double));
        if (v) {
            take_start(&starts, x_in, moving, velocities, system, v, &start);
        } else {
            PyErr_NoMemory();
        }
        fine = !starts.failed && !PyErr_Occurred();
    }
    if (fine) {
        status = run_with_room(&run, kept, &start, rtol, end, (size_t)most_steps);
        reached = run ? aoi_adaptive_progress(run) : reached;
    }
    if (kept && !PyErr_Occurred()) {
        result = status == AOI_OK ? adaptive_result(run, &kept, end)
                                  : raise_of_laws(status, "adaptive run", reached.time, kept->made.law,
                                                  kept->made.system.contact_count, (Py_ssize_t)reached.failed);
    }
    buffers_release(&starts);
    free(run);
    free(v);
    track_free(kept);
    return result;
}
