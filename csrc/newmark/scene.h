/* Bodies, contacts and loads in time by Newmark's rule. */
#ifndef AOI_NEWMARK_SCENE_H
#define AOI_NEWMARK_SCENE_H

#include "newmark/body.h"
#include "model/coupled.h"
#include "model/load.h"

/* The caller sets the first block: bodies started by one rule with step dt, contacts, loads, whether
 * energies are recorded (their rows are left alone otherwise); start_force: the contact forces at the
 * start [N], or NULL: what the laws give, which is wrong where a contact point without mass meets a law
 * that depends on the rate; work: aoi_scene_size(scene) doubles, first_port: body_count + 1. */
typedef struct aoi_scene {
    size_t body_count, contact_count, load_count;
    aoi_body *const *body;
    aoi_contact *contact;
    aoi_load *load;
    double dt;
    int energies;
    const double *start_force;
    double *work;
    size_t *first_port;

    aoi_coupled coupled;
    double *displacement, *free_displacement, *free_velocity; /* of all ports                  */
    double *push, *load_now, *load_before; /* on all ports; push: of loads and contacts        */
    double *load_work, *gravity_start;     /* of the bodies                                    */
    double *column;                        /* some columns of the record, row by row           */
} aoi_scene;

/* AOI_ERROR_ARGUMENT where a contact or a load names a body or port that is not there, a gap is not
 * finite, a law not usable, a load has no values or times that do not ascend, or no dt > 0 to go by. To
 * be called before the next two. */
int aoi_scene_check(const aoi_scene *scene);

size_t aoi_scene_rows(const aoi_scene *scene);
size_t aoi_scene_size(const aoi_scene *scene);

/* Sets the scene to its beginning, the bodies' accelerations included, and writes column 0. record:
 * aoi_scene_rows(scene) rows of `columns` values. Errors as aoi_scene_check, and
 * AOI_ERROR_NOT_POSITIVE for a contact where nothing can give way. */
int aoi_scene_start(aoi_scene *scene, double *record, size_t columns);

/* Steps on from column first to column last. done gets the last column written; on an error it is the
 * step before the one that failed. May be called again to go on. */
int aoi_scene_run(aoi_scene *scene, double *record, size_t columns, size_t first, size_t last,
                  size_t *done);

#endif
