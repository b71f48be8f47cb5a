/* Python binding of adaptive runs; also returns the peaks and intervals of their contacts. */
#include "python/binding.h"
#include "aoimpact.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---------------------------------------------------------------------------------- the run */

static const size_t MOST_BYTES = (size_t)1 << 30;

/* Largest number of rows that one piece of a run adds to the track. The clock is read after each piece. */
enum { ROWS = 48 };

/* A run in progress. It ends after about most_steps steps, rejected steps included. */
typedef struct job {
    aoi_adaptive *run;
    aoi_track *track;
    size_t room, most_steps;
    double end;
    int status;
} job;

static int few_rows(void *data)
{
    job *of = data;
    aoi_track *track = of->track;
    const aoi_progress at = aoi_adaptive_progress(of->run);
    if (!(at.time < of->end)) {
        return 0;
    }
    const int full = track->capacity - track->used < of->room || track->rows == track->row_capacity;
    if (track->used * sizeof(double) > MOST_BYTES || at.steps + at.rejected > of->most_steps) {
        of->status = AOI_ERROR_TOO_LONG;
    } else if (full && aoi_track_grow(track, of->room, realloc) != AOI_OK) {
        of->status = CALL_NO_MEMORY;
    } else {
        const size_t all = track->row_capacity;
        track->row_capacity = all - track->rows < ROWS ? all : track->rows + ROWS;
        of->status = aoi_adaptive_run(of->run, track);
        track->row_capacity = all;
    }
    return of->status == AOI_OK;
}

/* Sets the initial rates v of all bodies. The rates of a body that moves as a whole are its velocity times its
 * rates at unit velocity (moving). */
static void take_moving(call *of, PyObject *moving, PyObject *velocities, aoi_system *system, double *v)
{
    for (size_t b = 0; b < system->body_count && of->status == AOI_OK; b++) {
        size_t n = system->body[b].n;
        const double *rate;
        double velocity;
        TAKE_SOME(of, moving, b, system->body_count, ARRAY('d', rate, n));
        TAKE_SOME(of, velocities, b, system->body_count, VALUE('x', velocity));
        for (size_t j = 0; j < n && of->status == AOI_OK; j++) {
            v[system->first[b] + j] = velocity * rate[j];
        }
    }
}

/* Appends an object to a list, and takes over the reference to it. Returns 1, or 0 with an error set. */
static int append(PyObject *list, PyObject *pair)
{
    const int fine = pair && PyList_Append(list, pair) == 0;
    Py_XDECREF(pair);
    return fine;
}

/* Returns a new tuple for contact c: (peak force, its time, impulse, [(start, end)], [(impulse, pace)]). If there
 * are several contacts, intervals without impulse, in which no force acted, are left out. */
static PyObject *one_contact(const aoi_adaptive *run, size_t c, int several, size_t count, const aoi_interval *interval)
{
    const aoi_peak of = aoi_adaptive_peak(run, c);
    PyObject *spans = PyList_New(0), *touches = PyList_New(0);
    int fine = spans && touches;
    for (size_t i = 0; fine && i < count; i++) {
        fine = interval[i].contact != c || (several && interval[i].impulse == 0.0) ||
               (append(spans, Py_BuildValue("dd", interval[i].start, interval[i].end)) &&
                append(touches, Py_BuildValue("dd", interval[i].impulse, interval[i].pace)));
    }
    if (!fine) {
        Py_CLEAR(spans);
    }
    return Py_BuildValue("dddNN", of.force, of.time, of.impulse, spans, touches);
}

static PyObject *contacts_of(const aoi_adaptive *run, kept_track *kept, double end)
{
    const aoi_system *system = &kept->made.system;
    const size_t contacts = system->contact_count;
    aoi_interval *work = call_room(&kept->of, contacts, sizeof *work), *interval = NULL;
    const size_t count = work ? aoi_track_intervals(system, &kept->track, end, work, 0, NULL) : 0;
    if (count > 0) {
        interval = call_room(&kept->of, count, sizeof *interval);
    }
    if (interval) {
        (void)aoi_track_intervals(system, &kept->track, end, work, count, interval);
    }
    PyObject *result = kept->of.status == AOI_OK ? PyTuple_New((Py_ssize_t)contacts) : NULL;
    for (size_t c = 0; result && c < contacts; c++) {
        PyObject *one = one_contact(run, c, contacts > 1, count, interval);
        if (!one || PyTuple_SetItem(result, (Py_ssize_t)c, one) != 0) {
            Py_CLEAR(result);
        }
    }
    free(work);
    free(interval);
    return result;
}

/* Returns a new tuple (track, contacts, steps, rejected). The track's capsule takes over *kept. */
static PyObject *adaptive_result(const aoi_adaptive *run, kept_track **kept, double end)
{
    const aoi_progress at = aoi_adaptive_progress(run);
    PyObject *contacts = contacts_of(run, *kept, end), *track = contacts ? track_capsule(kept) : NULL;
    return Py_BuildValue("NNnn", track, contacts, (Py_ssize_t)at.steps, (Py_ssize_t)at.rejected);
}

/* Runs a system to a tolerance. args: (bodies, contacts, rtol, end, x, moving, velocities, most steps). x: initial
 * modal coordinates of all bodies, or None for zero. */
PyObject *adaptive(PyObject *args)
{
    call of = {.status = AOI_OK};
    PyObject *bodies = NULL, *contacts = NULL, *x, *moving = NULL, *velocities = NULL, *result = NULL;
    double rtol, end;
    size_t most_steps;
    TAKE(&of, args, VALUE('t', bodies), VALUE('t', contacts), VALUE('x', rtol), VALUE('x', end), VALUE('O', x),
         VALUE('t', moving), VALUE('t', velocities), VALUE('n', most_steps));
    kept_track *kept = of.status == AOI_OK ? track_new(bodies, contacts) : NULL;
    if (!kept) {
        return NULL;
    }
    aoi_system *system = &kept->made.system;
    aoi_adaptive *run = NULL;
    call_fail(&of, kept->of.status);
    size_t all = of.status == AOI_OK ? system->first[system->body_count] : 0;
    double *v = call_room(&of, all, sizeof *v);
    aoi_start start = {.v = v};
    TAKE_SOME(&of, args, 4, 8, ARRAY('o', start.x, all));
    take_moving(&of, moving, velocities, system, v);
    start.rested = start.x != NULL;
    if (of.status == AOI_OK && !(run = malloc(aoi_adaptive_size(system)))) {
        of.status = CALL_NO_MEMORY;
    }
    aoi_progress reached = {.failed = SIZE_MAX};
    if (of.status == AOI_OK && (of.status = aoi_adaptive_start(run, system, &start, rtol, end)) == AOI_OK) {
        job rows = {run, &kept->track, aoi_adaptive_room(system), most_steps, end, AOI_OK};
        run_pieces(&kept->made.signals, few_rows, &rows);
        of.status = rows.status;
        reached = aoi_adaptive_progress(run);
    }
    if (run) {
        raise_of_laws(&of, "adaptive run", reached.time, kept->made.law, system->contact_count, reached.failed);
    }
    if (of.status == AOI_OK && !PyErr_Occurred()) {
        result = adaptive_result(run, &kept, end);
    }
    free(run);
    free(v);
    track_free(kept);
    PyObject *done = finish(&of, "adaptive run", "");
    Py_XDECREF(done);
    return result;
}
