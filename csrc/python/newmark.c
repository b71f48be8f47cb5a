/* Python binding of runs in fixed steps. */
#include "python/binding.h"

#include <stdlib.h>
#include <string.h>

/* Number of steps between two readings of the clock; a step with massless contacts may take some 100 us. */
enum { PIECE_STEPS = 64 };

typedef struct job {
    aoi_newmark *run;
    size_t columns, done;
    int status;
} job;

static int few_steps(void *data)
{
    job *of = data;
    const size_t left = of->columns - 1 - of->done;
    of->status = aoi_newmark_run(of->run, of->done + (left < PIECE_STEPS ? left : PIECE_STEPS), &of->done);
    return of->status == AOI_OK && of->done + 1 < of->columns;
}

/* Runs a system in fixed steps. args: (bodies, contacts, dt, beta, gamma, x, v, force, force rate, record,
 * energies). x, v: coordinates and rates of all bodies, initial ones on entry and final ones on return. */
PyObject *newmark(PyObject *args)
{
    call of = {.status = AOI_OK};
    PyObject *bodies = NULL, *contacts = NULL;
    taken_system made = {.body = NULL};
    aoi_newmark *run = NULL;
    aoi_rule rule;
    aoi_start start = {.x = NULL};
    int energies;
    job steps = {.columns = ANY_LENGTH};
    double *x, *v, *record;
    TAKE_SOME(&of, args, 0, 11, VALUE('t', bodies), VALUE('t', contacts));
    take_system(&of, bodies, contacts, &made);
    if (of.status == AOI_OK) {
        size_t all = made.system.first[made.system.body_count], rows = aoi_record_rows(&made.system);
        size_t forces = made.system.first_force[made.system.contact_count];
        TAKE_SOME(&of, args, 2, 11, VALUE('x', rule.dt), VALUE('x', rule.beta), VALUE('x', rule.gamma),
                  ARRAY('D', x, all), ARRAY('D', v, all), ARRAY('o', start.force, forces),
                  ARRAY('o', start.force_rate, forces), MATRIX('D', record, steps.columns, rows),
                  VALUE('p', energies));
        run = call_room(&of, aoi_newmark_size(&made.system), 1);
    }
    if (run) {
        start.x = x;
        start.v = v;
        signal_check_release(&made.signals);
        steps.status = aoi_newmark_start(run, &made.system, &rule, &start, energies, record, steps.columns);
        signal_check_regain(&made.signals);
        steps.run = run;
        if (steps.status == AOI_OK && steps.columns > 1) {
            run_pieces(&made.signals, few_steps, &steps);
        }
        of.status = steps.status;
        const aoi_progress end = aoi_newmark_progress(run);
        const size_t bytes = made.system.first[made.system.body_count] * sizeof(double);
        if (of.status == AOI_OK && !PyErr_Occurred()) {
            memcpy(x, end.x, bytes);
            memcpy(v, end.v, bytes);
        }
        raise_of_laws(&of, "Newmark step", rule.dt * (double)(steps.done + 1), made.law, made.system.contact_count,
                      end.failed);
    }
    free(run);
    free_system(&made);
    return finish(&of, "Newmark step", "");
}
