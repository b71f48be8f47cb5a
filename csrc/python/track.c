/* The track of an adaptive run, kept for Python with all that it takes to read it, and its dense output. */
#include "python/binding.h"
#include "adaptive/row.h"

#include <stdlib.h>
#include <string.h>

static const char NAME[] = "aoimpact._core.track";

/* Bytes copied between looks for signals: a hundredth of a second at most. */
#define CHUNK ((size_t)1 << 22)

/* ------------------------------------------------------------------------------- the capsule */

void track_free(kept_track *kept)
{
    if (kept) {
        buffers_release(&kept->buffers);
        free_system(&kept->made);
        free(kept->track.values);
        free(kept->track.row);
        Py_XDECREF(kept->bodies);
        Py_XDECREF(kept->contacts);
        free(kept);
    }
}

kept_track *track_new(PyObject *bodies, PyObject *contacts, int *status)
{
    kept_track *kept = calloc(1, sizeof *kept);
    if (!kept) {
        PyErr_NoMemory();
        return NULL;
    }
    kept->bodies = Py_NewRef(bodies);
    kept->contacts = Py_NewRef(contacts);
    *status = take_system(&kept->buffers, bodies, contacts, &kept->made);
    return kept;
}

static void destroy(PyObject *capsule) { track_free(PyCapsule_GetPointer(capsule, NAME)); }

PyObject *track_capsule(kept_track **kept)
{
    aoi_track *track = &(*kept)->track; /* without the room for more */
    double *values = realloc(track->values, track->used * sizeof *values + 1);
    size_t *row = realloc(track->row, track->rows * sizeof *row + 1);
    track->values = values ? values : track->values;
    track->row = row ? row : track->row;
    PyObject *capsule = PyCapsule_New(*kept, NAME, destroy);
    if (capsule) {
        *kept = NULL;
    }
    return capsule;
}

/* (bodies, contacts, values, places): the track of track_bytes, checked. */
PyObject *track_open(PyObject *self, PyObject *args)
{
    PyObject *bodies, *contacts, *capsule = NULL;
    const char *values, *places;
    Py_ssize_t size, place_size;
    int status;
    (void)self;
    if (!PyArg_ParseTuple(args, "O!O!y#y#", &PyTuple_Type, &bodies, &PyTuple_Type, &contacts, &values, &size, &places,
                          &place_size)) {
        return NULL;
    }
    kept_track *kept = track_new(bodies, contacts, &status);
    if (kept && status == AOI_OK && !PyErr_Occurred()) {
        kept->track.used = (size_t)size / sizeof(double);
        kept->track.rows = (size_t)place_size / sizeof(size_t);
        kept->track.values = malloc((size_t)size + 1);
        kept->track.row = malloc((size_t)place_size + 1);
        if (kept->track.values && kept->track.row) {
            memcpy(kept->track.values, values, (size_t)size);
            memcpy(kept->track.row, places, (size_t)place_size);
            status = aoi_track_check(&kept->made.system, &kept->track);
        } else {
            PyErr_NoMemory();
        }
    }
    if (kept && !PyErr_Occurred()) {
        capsule = status == AOI_OK ? track_capsule(&kept) : raise_status(status, "dense output", -1.0);
    }
    track_free(kept);
    return capsule;
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

PyObject *track_bytes(PyObject *self, PyObject *capsule)
{
    const kept_track *kept = PyCapsule_GetPointer(capsule, NAME);
    (void)self;
    PyObject *values = kept ? bytes_of(kept->track.values, kept->track.used * sizeof(double)) : NULL;
    PyObject *places = values ? bytes_of(kept->track.row, kept->track.rows * sizeof(size_t)) : NULL;
    if (!places) {
        Py_XDECREF(values);
        return NULL;
    }
    return Py_BuildValue("NN", values, places);
}

/* Of each row when it starts, how long it lasts, s, and how many contacts it holds, as bytes of doubles. */
PyObject *track_rows(PyObject *self, PyObject *capsule)
{
    const kept_track *kept = PyCapsule_GetPointer(capsule, NAME);
    (void)self;
    double *made = kept ? malloc((3 * kept->track.rows + 1) * sizeof *made) : NULL;
    if (!made) {
        return kept ? PyErr_NoMemory() : NULL;
    }
    for (size_t r = 0; r < kept->track.rows; r++) {
        const double *row = kept->track.values + kept->track.row[r];
        made[3 * r] = row[AOI_TRACK_START];
        made[3 * r + 1] = row[AOI_TRACK_LENGTH];
        made[3 * r + 2] = row[AOI_TRACK_CONTACTS];
    }
    PyObject *bytes = bytes_of(made, 3 * kept->track.rows * sizeof *made);
    free(made);
    return bytes;
}

/* ------------------------------------------------------------------------------ dense output */

/* What is read at each of many times; of a body, its state. */
typedef struct reading {
    aoi_sampler *sampler;
    const double *time;
    double *out;
    size_t count, body, width; /* width: of a state */
    int energies;
} reading;

static void read_column(const reading *of, size_t i)
{
    aoi_sampler_column(of->sampler, of->time[i], of->energies, of->out + i, of->count);
}

static void read_forces(const reading *of, size_t i)
{
    aoi_sampler_forces(of->sampler, of->time[i], of->out + i, of->count);
}

static void read_state(const reading *of, size_t i)
{
    aoi_sampler_state(of->sampler, of->time[i], of->body, of->out + i * of->width);
}

/* Reads a track at ascending times into an array of so many rows, or columns; between looks for signals without the
 * GIL. */
static PyObject *read_track(PyObject *capsule, PyObject *times_in, PyObject *out, size_t rows,
                            void (*read)(const reading *, size_t), reading of)
{
    const kept_track *kept = PyCapsule_GetPointer(capsule, NAME);
    buffer_list buffers = {.failed = 0};
    int status = AOI_OK;
    of.count = (size_t)-1;
    of.time = doubles(&buffers, times_in, "times", &of.count);
    size_t wanted = rows * of.count;
    of.out = doubles_out(&buffers, out, "what is read", &wanted);
    of.sampler = buffers.failed ? NULL : malloc(aoi_sampler_size(&kept->made.system));
    if (of.sampler) {
        status = aoi_sampler_start(of.sampler, &kept->made.system, &kept->track);
    } else if (!buffers.failed) {
        PyErr_NoMemory();
    }
    for (size_t i = 0; of.sampler && status == AOI_OK && i < of.count && PyErr_CheckSignals() == 0;) {
        const double until = seconds_now() + SIGNAL_INTERVAL;
        Py_BEGIN_ALLOW_THREADS
        for (; i < of.count && seconds_now() < until; i++) {
            read(&of, i);
        }
        Py_END_ALLOW_THREADS
    }
    free(of.sampler);
    return finish(&buffers, status, "dense output");
}

/* (track, times, record, energies) */
PyObject *track_sample(PyObject *self, PyObject *args)
{
    PyObject *capsule, *times, *record;
    reading of = {.energies = 0};
    (void)self;
    if (!PyArg_ParseTuple(args, "OOOp", &capsule, &times, &record, &of.energies)) {
        return NULL;
    }
    const kept_track *kept = PyCapsule_GetPointer(capsule, NAME);
    return kept ? read_track(capsule, times, record, aoi_record_rows(&kept->made.system), read_column, of) : NULL;
}

/* (track, times, forces) */
PyObject *track_forces(PyObject *self, PyObject *args)
{
    PyObject *capsule, *times, *forces;
    const reading of = {.energies = 0};
    (void)self;
    if (!PyArg_ParseTuple(args, "OOO", &capsule, &times, &forces)) {
        return NULL;
    }
    const kept_track *kept = PyCapsule_GetPointer(capsule, NAME);
    return kept ? read_track(capsule, times, forces, kept->made.system.contact_count, read_forces, of) : NULL;
}

/* (track, times, body, states) */
PyObject *track_states(PyObject *self, PyObject *args)
{
    PyObject *capsule, *times, *states;
    reading of = {.energies = 0};
    Py_ssize_t body;
    (void)self;
    if (!PyArg_ParseTuple(args, "OOnO", &capsule, &times, &body, &states)) {
        return NULL;
    }
    const kept_track *kept = PyCapsule_GetPointer(capsule, NAME);
    if (kept && (body < 0 || (size_t)body >= kept->made.system.body_count)) {
        return raise_status(AOI_ERROR_ARGUMENT, "dense output", -1.0);
    }
    of.body = (size_t)body;
    of.width = kept ? 2 * kept->made.system.body[body].n : 0;
    return kept ? read_track(capsule, times, states, of.width, read_state, of) : NULL;
}
