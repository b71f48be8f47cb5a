/* A body with one port, stepped by hand, and two of them with one contact: what the tests of
 * Newmark's rule share. */
#ifndef AOIMPACT_TEST_BODY_H
#define AOIMPACT_TEST_BODY_H

#include "check.h"
#include "model/coupled.h"
#include "newmark/body.h"
#include "newmark/scene.h"

/* What aoi_body.observe writes, by name. */
typedef struct observation {
    double centre_displacement, centre_velocity;
    double kinetic, elastic, dissipated, work;
    double displacement, velocity;
} observation;

static inline observation observe(const aoi_body *body)
{
    double row[AOI_BODY_ROWS + AOI_PORT_ROWS];
    body->observe(body, 1, row, 1);
    return (observation){row[0], row[1], row[2], row[3], row[4], row[5], row[6], row[7]};
}

/* From accelerations without force at the port. */
static inline int begin_freely(aoi_body *body)
{
    const double none = 0.0;
    return body->begin(body, &none);
}

/* One step under a force; -1 where the prediction fails. */
static inline int step_with(aoi_body *body, double force)
{
    double u, v;
    const int status = body->predict(body, &u, &v);
    if (status == AOI_OK) {
        body->correct(body, &force);
    }
    return status;
}

/* Rows of the record of two bodies, with a port each, and one contact. */
enum {
    FORCE,
    INDENTATION,
    STORED,
    LOST,
    BODIES,
    OF_BODY = AOI_BODY_ROWS + AOI_PORT_ROWS,
    ROWS = BODIES + 2 * OF_BODY,
    DISPLACEMENT = AOI_BODY_ROWS,
    VELOCITY
};

enum { PAIR_WORK = 400 };

typedef struct pair {
    aoi_body *body[2];
    aoi_contact contact;
    aoi_scene scene;
    size_t first_port[3];
    double work[PAIR_WORK];
} pair;

static inline void pair_make(pair *p, aoi_body *projectile, aoi_body *target, const aoi_law *law,
                             double gap)
{
    p->body[0] = projectile;
    p->body[1] = target;
    p->contact = (aoi_contact){.body = {0, 1}, .law = law, .gap = gap};
    p->scene = (aoi_scene){.body_count = 2,
                           .contact_count = 1,
                           .body = p->body,
                           .contact = &p->contact,
                           .energies = 1,
                           .memory = p->work,
                           .first_port = p->first_port};
    CHECK(aoi_scene_check(&p->scene) == AOI_OK && aoi_scene_rows(&p->scene) == ROWS &&
              aoi_scene_size(&p->scene) <= sizeof p->work,
          "room to work in");
}

#endif
