/* Runs in fixed steps, for Python. */
#include "python/binding.h"

#include <stdlib.h>
#include <string.h>

/* Steps between looks for signals at most: of contacts without mass one may take a hundred times as long as those
 * before it, some 100 us. */
enum { MOST_STEPS = 256 };

/* Runs the steps in pieces without the GIL; between them signals are checked. */
static int run_in_pieces(aoi_newmark *run, taken_system *made, const aoi_rule *rule, const aoi_start *start, int energies,
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
PyObject *newmark(PyObject *args)
{
    call of = {.status = AOI_OK};
    PyObject *bodies = NULL, *contacts = NULL;
    taken_system made = {.body = NULL};
    aoi_newmark *run = NULL;
    aoi_rule rule;
    aoi_start start = {.x = NULL};
    int energies;
    size_t columns = ANY_LENGTH, done = 0;
    double *x, *v, *record;
    TAKE_SOME(&of, args, 0, 11, VALUE('t', bodies), VALUE('t', contacts));
    take_system(&of, bodies, contacts, &made);
    if (of.status == AOI_OK) {
        size_t all = made.system.first[made.system.body_count], rows = aoi_record_rows(&made.system);
        size_t forces = made.system.first_force[made.system.contact_count];
        TAKE_SOME(&of, args, 2, 11, VALUE('x', rule.dt), VALUE('x', rule.beta), VALUE('x', rule.gamma),
                  ARRAY('D', x, all), ARRAY('D', v, all), ARRAY('o', start.force, forces),
                  ARRAY('o', start.force_rate, forces), MATRIX('D', record, columns, rows),
                  VALUE('p', energies));
        run = call_room(&of, aoi_newmark_size(&made.system), 1);
    }
    if (run) {
        start.x = x;
        start.v = v;
        of.status = run_in_pieces(run, &made, &rule, &start, energies, record, columns, &done);
        const aoi_progress end = aoi_newmark_progress(run);
        const size_t bytes = made.system.first[made.system.body_count] * sizeof(double);
        if (of.status == AOI_OK && !PyErr_Occurred()) {
            memcpy(x, end.x, bytes);
            memcpy(v, end.v, bytes);
        }
        raise_of_laws(&of, "Newmark step", rule.dt * (double)(done + 1), made.law, made.system.contact_count,
                      end.failed);
    }
    free(run);
    free_system(&made);
    return finish(&of, "Newmark step", "");
}
