/* Python binding of the track of an adaptive run: its capsule, its bytes and its dense output. */
#include "python/binding.h"
#include "adaptive/row.h"

#include <stdlib.h>
#include <string.h>

static const char NAME[] = "aoimpact._core.track";

/* Number of bytes copied between two checks for signals, which takes a hundredth of a second at most. */
#define CHUNK ((size_t)1 << 22)

/* ------------------------------------------------------------------------------- the capsule */

void track_free(kept_track *kept)
{
    if (kept) {
        call_release(&kept->of);
        free_system(&kept->made);
        free(kept->track.values);
        free(kept->track.row);
        Py_XDECREF(kept->bodies);
        Py_XDECREF(kept->contacts);
        free(kept);
    }
}

kept_track *track_new(PyObject *bodies, PyObject *contacts)
{
    kept_track *kept = calloc(1, sizeof *kept);
    if (!kept) {
        PyErr_NoMemory();
        return NULL;
    }
    kept->bodies = Py_NewRef(bodies);
    kept->contacts = Py_NewRef(contacts);
    take_system(&kept->of, bodies, contacts, &kept->made);
    return kept;
}

static void destroy(PyObject *capsule) { track_free(PyCapsule_GetPointer(capsule, NAME)); }

PyObject *track_capsule(kept_track **kept)
{
    aoi_track *track = &(*kept)->track; /* the track's arrays are shortened to what is used */
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

static void *copied(call *of, const char *bytes, Py_ssize_t size)
{
    void *copy = call_room(of, (size_t)size, 1);
    return copy ? memcpy(copy, bytes, (size_t)size) : NULL;
}

/* Makes a track from the bytes that track_bytes returns, and checks it. args: (bodies, contacts, values, start
 * indices of the rows). */
PyObject *track_open(PyObject *args)
{
    PyObject *bodies, *contacts, *capsule = NULL;
    const char *values, *places;
    Py_ssize_t size, place_size;
    if (!PyArg_ParseTuple(args, "O!O!y#y#", &PyTuple_Type, &bodies, &PyTuple_Type, &contacts, &values, &size, &places,
                          &place_size)) {
        return NULL;
    }
    kept_track *kept = track_new(bodies, contacts);
    if (!kept) {
        return NULL;
    }
    call *of = &kept->of;
    kept->track = (aoi_track){.used = (size_t)size / sizeof(double), .rows = (size_t)place_size / sizeof(size_t)};
    kept->track.values = copied(of, values, size);
    kept->track.row = copied(of, places, place_size);
    if (of->status == AOI_OK && (of->status = aoi_track_check(&kept->made.system, &kept->track)) == AOI_OK) {
        capsule = track_capsule(&kept);
    } else {
        (void)finish(of, "dense output", "");
    }
    track_free(kept);
    return capsule;
}

/* Copies memory to a bytes object. Signals are checked in between, since a record may take gigabytes. */
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

/* Returns the content of a track's capsule; NULL, with an error raised, for any other object. */
static const kept_track *held(call *of, PyObject *capsule)
{
    const kept_track *kept = of->status == AOI_OK ? PyCapsule_GetPointer(capsule, NAME) : NULL;
    call_fail(of, kept ? AOI_OK : CALL_RAISED);
    return kept;
}

PyObject *track_bytes(PyObject *args)
{
    call of = {.status = AOI_OK};
    PyObject *capsule = NULL;
    TAKE(&of, args, VALUE('O', capsule));
    const kept_track *kept = held(&of, capsule);
    PyObject *values = kept ? bytes_of(kept->track.values, kept->track.used * sizeof(double)) : NULL;
    PyObject *places = values ? bytes_of(kept->track.row, kept->track.rows * sizeof(size_t)) : NULL;
    return Py_BuildValue("NN", values, places);
}

/* Returns 3 * count doubles as a bytes object, and frees the array. */
static PyObject *triples(call *of, double *made, size_t count)
{
    PyObject *bytes = made ? bytes_of(made, 3 * count * sizeof *made) : finish(of, "dense output", "");
    free(made);
    return bytes;
}

/* Returns start and length of each row, s, and its number of contacts, as a bytes object of doubles. */
PyObject *track_rows(PyObject *args)
{
    call of = {.status = AOI_OK};
    PyObject *capsule = NULL;
    TAKE(&of, args, VALUE('O', capsule));
    const kept_track *kept = held(&of, capsule);
    double *made = call_room(&of, kept ? 3 * kept->track.rows : 0, sizeof *made);
    for (size_t r = 0; made && r < kept->track.rows; r++) {
        const double *row = kept->track.values + kept->track.row[r];
        made[3 * r] = row[AOI_TRACK_START];
        made[3 * r + 1] = row[AOI_TRACK_LENGTH];
        made[3 * r + 2] = row[AOI_TRACK_CONTACTS];
    }
    return triples(&of, made, kept ? kept->track.rows : 0);
}

/* Returns the phases of slip from aoi_track_slips as a bytes object of doubles: for each its contact, time (s),
 * and 1 (slips) or 0. */
PyObject *track_slips(PyObject *args)
{
    call of = {.status = AOI_OK};
    PyObject *capsule = NULL;
    TAKE(&of, args, VALUE('O', capsule));
    const kept_track *kept = held(&of, capsule);
    const size_t count = kept ? aoi_track_slips(&kept->made.system, &kept->track, 0, NULL) : 0;
    aoi_slip *slip = call_room(&of, count, sizeof *slip);
    double *made = call_room(&of, 3 * count, sizeof *made);
    if (made) {
        (void)aoi_track_slips(&kept->made.system, &kept->track, count, slip);
    }
    for (size_t i = 0; made && i < count; i++) {
        made[3 * i] = (double)slip[i].contact;
        made[3 * i + 1] = slip[i].time;
        made[3 * i + 2] = slip[i].slips;
    }
    free(slip);
    return triples(&of, made, count);
}

/* ------------------------------------------------------------------------------ dense output */

/* A request to read a track at many times. what: columns of the record, with energies or without; contact forces;
 * or states of a body. */
enum { RECORD = 0, ENERGIES, FORCES, STATES, READINGS };
typedef struct reading {
    aoi_sampler *sampler;
    const double *time;
    double *out;
    size_t what, body, count, done, width; /* width: number of values per time */
} reading;

static int read_next(void *data)
{
    reading *of = data;
    if (of->done == of->count) {
        return 0;
    }
    const size_t i = of->done++;
    if (of->what == STATES) {
        aoi_sampler_state(of->sampler, of->time[i], of->body, of->out + i * of->width);
    } else if (of->what == FORCES) {
        aoi_sampler_forces(of->sampler, of->time[i], of->out + i, of->count);
    } else {
        aoi_sampler_column(of->sampler, of->time[i], of->what == ENERGIES, of->out + i, of->count);
    }
    return of->done < of->count;
}

/* Reads a track at times in ascending order, without the GIL between checks for signals. args: (track, times,
 * what, body, out). */
PyObject *track_read(PyObject *args)
{
    call of = {.status = AOI_OK};
    PyObject *capsule = NULL, *out;
    reading at = {.count = ANY_LENGTH};
    TAKE(&of, args, VALUE('O', capsule), ARRAY('d', at.time, at.count), VALUE('n', at.what), VALUE('n', at.body),
         VALUE('O', out));
    const kept_track *kept = held(&of, capsule);
    const aoi_system *system = kept ? &kept->made.system : NULL;
    if (kept && (at.what >= READINGS || at.body >= system->body_count)) {
        call_fail(&of, AOI_ERROR_ARGUMENT);
    }
    if (of.status == AOI_OK) {
        at.width = at.what == FORCES   ? system->contact_count
                   : at.what == STATES ? 2 * system->body[at.body].n
                                       : aoi_record_rows(system);
        TAKE_SOME(&of, args, 4, 5, MATRIX('D', at.out, at.count, at.width));
        at.sampler = call_room(&of, aoi_sampler_size(system), 1);
    }
    if (at.sampler) {
        of.status = aoi_sampler_start(at.sampler, system, &kept->track);
    }
    if (of.status == AOI_OK) {
        signal_check signals;
        run_pieces(&signals, read_next, &at);
    }
    free(at.sampler);
    return finish(&of, "dense output", "");
}
