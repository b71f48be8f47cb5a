/* Runs in fixed steps, for Python. */
#include "python/binding.h"

#include <stdlib.h>
#include <string.h>

/* Steps between looks for signals at most: of contacts without mass one may take a hundred times as long as those
 * before it, some 100 us. */
enum { MOST_STEPS = 256 };

/* Runs the steps in pieces without the GIL; between them signals are checked. */
static int run_in_pieces(aoi_newmark *run, taken *made, const aoi_rule *rule, const aoi_start *start, int energies,
                         double *record, size_t columns, size_t *done)
{
    size_t piece = 1;
    signal_check_release(&made->signals);
    int status = aoi_newmark_start(run, &made->system, rule, start, energies, record, columns);
    signal_check_regain(&made->signals);
    while (status == AOI_OK && *done + 1 < columns) {
        const size_t left = columns - 1 - *done;
        const clock_t began = clock();
        signal_check_release(&made->signals);
        status = aoi_newmark_run(run, *done + (left < piece ? left : piece), done);
        signal_check_regain(&made->signals);
        piece = piece_after(piece, began);
        piece = piece < MOST_STEPS ? piece : MOST_STEPS;
        if (PyErr_CheckSignals() != 0) {
            break;
        }
    }
    return status;
}

/* (bodies, contacts, dt, beta, gamma, x, v, force, force rate, record, energies); x and v are those of all bodies at
 * the start, and at the end. */
PyObject *newmark(PyObject *self, PyObject *args)
{
    PyObject *bodies, *contacts, *x_io, *v_io, *force_in, *force_rate_in, *record_out;
    buffer_list buffers = {.failed = 0};
    taken made = {.body = NULL};
    aoi_newmark *run = NULL;
    aoi_rule rule;
    aoi_start start = {.x = NULL};
    int energies;
    size_t values = (size_t)-1, done = 0;
    (void)self;
    if (!PyArg_ParseTuple(args, "O!O!dddOOOOOp", &PyTuple_Type, &bodies, &PyTuple_Type, &contacts, &rule.dt,
                          &rule.beta, &rule.gamma, &x_io, &v_io, &force_in, &force_rate_in,
                          &record_out, &energies)) {
        return NULL;
    }
    int status = take_system(&buffers, bodies, contacts, &made);
    size_t all = made.system.first ? made.system.first[made.system.body_count] : (size_t)-1;
    size_t count = made.system.contact_count;
    double *x = doubles_out(&buffers, x_io, "x", &all), *v = doubles_out(&buffers, v_io, "v", &all);
    start.x = x;
    start.v = v;
    start.force = doubles_or_none(&buffers, force_in, "force", &count);
    start.force_rate = doubles_or_none(&buffers, force_rate_in, "force rate", &count);
    double *record = doubles_out(&buffers, record_out, "record", &values);
    if (!buffers.failed && status == AOI_OK) {
        const size_t rows = aoi_record_rows(&made.system), columns = rows > 0 ? values / rows : 0;
        run = calloc(1, aoi_newmark_size(&made.system));
        if (!run) {
            PyErr_NoMemory();
        } else if (columns == 0 || columns * rows != values) {
            status = AOI_ERROR_ARGUMENT;
        } else {
            status = run_in_pieces(run, &made, &rule, &start, energies, record, columns, &done);
        }
    }
    const size_t failed = run ? aoi_newmark_progress(run).failed : 0;
    if (run && status == AOI_OK && !PyErr_Occurred()) {
        memcpy(x, aoi_newmark_progress(run).x, all * sizeof(double));
        memcpy(v, aoi_newmark_progress(run).v, all * sizeof(double));
    }
    if (!buffers.failed && status != AOI_OK) {
        raise_of_laws(status, "Newmark step", rule.dt * (double)(done + 1), made.law, count, (Py_ssize_t)failed);
    }
    free(run);
    free_system(&made);
    PyObject *result = finish(&buffers, AOI_OK, "Newmark step");
    if (result && PyErr_Occurred()) {
        Py_CLEAR(result);
    }
    return result;
}
