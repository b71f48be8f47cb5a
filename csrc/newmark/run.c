/* A system of bodies in modes in time by Newmark's rule: its bodies started, and the scene of them. */
#include "newmark/scene.h"
#include "linear/vector.h"
#include "linear/work.h"
#include "model/system.h"
#include "newmark/body.h"

struct aoi_newmark {
    aoi_scene scene;
    aoi_body *body, **all;
    aoi_scene_load *load;
    double **work, *zero, *record;
    size_t columns, done;
};

/* Deals out memory behind the run itself, which is only counted where block is NULL. The scene's is left out:
 * it depends on the bodies, once started. */
static size_t lay_out(aoi_newmark *run, const aoi_system *system, void *block)
{
    const size_t bodies = system->body_count;
    aoi_memory memory = {block, 0};
    (void)aoi_memory_take(&memory, 1, sizeof *run);
    aoi_newmark made = {.body = aoi_memory_take(&memory, bodies, sizeof *made.body)};
    made.all = aoi_memory_take(&memory, bodies, sizeof *made.all);
    made.load = aoi_memory_take(&memory, bodies, sizeof *made.load);
    made.work = aoi_memory_take(&memory, bodies, sizeof *made.work);
    made.zero = aoi_memory_doubles(&memory, aoi_system_most_modes(system));
    made.scene.first_port = aoi_memory_numbers(&memory, bodies + 1);
    for (size_t b = 0; b < bodies; b++) {
        const aoi_modes *body = &system->body[b];
        double *work = aoi_memory_doubles(&memory, aoi_body_modal_size(body->n, body->ports));
        if (block) {
            made.work[b] = work;
        }
    }
    if (block) {
        made.scene.memory = (char *)block + memory.used;
        *run = made;
    }
    return memory.used;
}

size_t aoi_newmark_size(const aoi_system *system)
{
    if (!system->first) {
        return 0;
    }
    const size_t scene = aoi_scene_most(system->body_count, system->first_port[system->body_count],
                                        system->contact_count, aoi_system_span(system));
    return aoi_plus(lay_out(NULL, system, NULL), scene);
}

/* The bodies where they start, and their loads. */
static int start_bodies(aoi_newmark *run, const aoi_system *system, const aoi_rule *rule,
                        const aoi_start *start)
{
    for (size_t b = 0; b < system->body_count; b++) {
        const aoi_modes *body = &system->body[b];
        const size_t first = system->first[b];
        const aoi_body_start from = {.u = start->x ? start->x + first : run->zero,
                                     .v = start->v ? start->v + first : run->zero};
        const int status = aoi_body_start_modal(&run->body[b], body, rule, &from, run->work[b]);
        if (status != AOI_OK) {
            return status;
        }
        run->all[b] = &run->body[b];
        if (body->load.count > 0) {
            run->load[run->scene.load_count++] = (aoi_scene_load){b, 0, body->ports, body->load};
        }
    }
    return AOI_OK;
}

/* Whether a body rests bent by what it takes at once: by which forces, only an adaptive run finds. */
static int rests_bent(const aoi_system *system, const aoi_start *start)
{
    size_t bent = 0;
    for (size_t b = 0; b < system->body_count; b++) {
        bent += system->body[b].residual != NULL;
    }
    return start->rested && bent > 0;
}

int aoi_newmark_start(aoi_newmark *run, const aoi_system *system, const aoi_rule *rule,
                      const aoi_start *start, int energies, double *record, size_t columns)
{
    if (!system->first || columns == 0 || rests_bent(system, start)) {
        return AOI_ERROR_ARGUMENT;
    }
    const size_t all = system->first[system->body_count];
    if ((start->x && !aoi_vector_is_finite(all, start->x)) ||
        (start->v && !aoi_vector_is_finite(all, start->v))) {
        return AOI_ERROR_NOT_FINITE;
    }
    (void)lay_out(run, system, run);
    for (size_t j = 0, n = aoi_system_most_modes(system); j < n; j++) {
        run->zero[j] = 0.0;
    }
    const int status = start_bodies(run, system, rule, start);
    if (status != AOI_OK) {
        return status;
    }
    run->record = record;
    run->columns = columns;
    run->scene.body_count = system->body_count;
    run->scene.contact_count = system->contact_count;
    run->scene.body = run->all;
    run->scene.contact = system->contact;
    run->scene.load = run->load;
    run->scene.dt = rule->dt;
    run->scene.energies = energies;
    return aoi_scene_start(&run->scene, record, columns);
}

int aoi_newmark_run(aoi_newmark *run, size_t last, size_t *done)
{
    int status = last < run->columns ? AOI_OK : AOI_ERROR_ARGUMENT;
    if (status == AOI_OK && last > run->done) {
        status = aoi_scene_run(&run->scene, run->record, run->columns, run->done + 1, last, &run->done);
    }
    *done = run->done;
    return status;
}
