/* Bodies, contacts and loads in time by Newmark's rule. */
#ifndef AOI_NEWMARK_SCENE_H
#define AOI_NEWMARK_SCENE_H

#include "newmark/body.h"
#include "model/coupled.h"

/* A load on so many ports of a body, from port on. */
typedef struct aoi_scene_load {
    size_t body, port, ports;
    aoi_load load;
} aoi_scene_load;

/* The caller sets the first block: bodies started by one rule with step dt, contacts, loads, whether
 * energies are recorded (their rows are left alone otherwise); start_force: the contact forces at the
 * start [N], or NULL: what the laws give, which is wrong where a contact point without mass meets a law
 * that depends on the rate; first_port: body_count + 1; memory: aoi_scene_size(scene) bytes. */
typedef struct aoi_scene {
    size_t body_count, contact_count, load_count;
    aoi_body *const *body;
    const aoi_contact *contact;
    const aoi_scene_load *load;
    double dt;
    int energies;
    const double *start_force;
    size_t *first_port;
    void *memory;

    size_t failed; /* contact that went deeper than its law holds */
    aoi_coupled coupled;
    aoi_contact_state *state; /* of the contacts */
    double *displacement, *free_displacement, *free_velocity; /* of all ports                  */
    double *push, *load_now, *load_before; /* on all ports; push: of loads and contacts        */
    double *load_work, *gravity_start;     /* of the bodies                                    */
    double *column;                        /* some columns of the record, row by row           */
} aoi_scene;

/* AOI_ERROR_ARGUMENT where a contact or a load names a body or port that is not there, a gap is not
 * finite, a law not usable, a load has no values, or times that do not ascend, or no dt > 0 to go by. To
 * be called before the next two. */
int aoi_scene_check(const aoi_scene *scene);

size_t aoi_scene_rows(const aoi_scene *scene);
size_t aoi_scene_size(const aoi_scene *scene);

/* The same before there are bodies: for contacts at most band apart that share one. */
size_t aoi_scene_most(size_t bodies, size_t ports, size_t contacts, size_t band);

/* Sets the scene to its beginning, the bodies' accelerations included, and writes column 0. record:
 * aoi_scene_rows(scene) rows of `columns` values. Errors as aoi_scene_check, and
 * AOI_ERROR_NOT_POSITIVE for a contact where nothing can deform or move. */
int aoi_scene_start(aoi_scene *scene, double *record, size_t columns);

/* Steps on from column first to column last. done gets the last column written; on an error it is the
 * step before the one that failed. May be called again to go on. */
int aoi_scene_run(aoi_scene *scene, double *record, size_t columns, size_t first, size_t last,
                  size_t *done);

#endif
