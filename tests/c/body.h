/* Bodies and contacts that Newmark's rule takes through time, by the public header: what its tests share. */
#ifndef AOIMPACT_TEST_BODY_H
#define AOIMPACT_TEST_BODY_H

#include "aoimpact.h"
#include "check.h"

#include <stdlib.h>
#include <string.h>

enum { MOST_KEPT = 4096, MOST_TOGETHER = 32, MOST_PORTS_HERE = 2 };

/* Memory that lasts until drop(). */
static void *kept[MOST_KEPT];
static size_t kept_count;

static inline void *keep(size_t bytes)
{
    CHECK(kept_count < MOST_KEPT, "memory");
    void *made = malloc(bytes + 1);
    memset(made, 0xA5, bytes); /* what a caller hands over is anything */
    return kept[kept_count++] = made;
}

static inline void drop(void)
{
    while (kept_count > 0) {
        free(kept[--kept_count]);
    }
}

/* A system that is built up, how it starts, and its run. */
typedef struct world {
    aoi_modes body[MOST_TOGETHER];
    aoi_contact contact[MOST_TOGETHER];
    double *x[MOST_TOGETHER], *v[MOST_TOGETHER];
    double push[MOST_PORTS_HERE]; /* on the first body, if step() takes it by the hand */
    aoi_system system;
    aoi_start start;
    aoi_rule rule;
    aoi_newmark *run;
    double *record;
    size_t columns, at; /* at: the last column */
    int lean;           /* without energies */
} world;

static inline size_t add_body(world *w, aoi_modes body, double *x, double *v)
{
    const size_t b = w->system.body_count++;
    CHECK(b < MOST_TOGETHER, "too many bodies");
    w->body[b] = body;
    w->x[b] = x;
    w->v[b] = v;
    return b;
}

static inline double *zeros(size_t n)
{
    double *made = keep(n * sizeof *made);
    for (size_t i = 0; i < n; i++) {
        made[i] = 0.0;
    }
    return made;
}

/* How coordinate i of a star, the contact's first, moves in a mode. */
static inline double star_shape(const aoi_star *star, const aoi_modes *body, size_t i, size_t j)
{
    const double own = i > 0 ? star->k[i - 1] / star->m[i - 1] : 0.0;
    return i == 0 ? body->shape[j] : body->shape[j] * own / (own - body->omega[j] * body->omega[j]);
}

/* A star that moves as a whole, its contact mass faster by kick, under Rayleigh's damping and a force on each of its
 * coordinates, or NULL. */
static inline size_t add_star(world *w, const aoi_star *star, double velocity, double kick, const double *damping,
                              const double *gravity)
{
    aoi_modes body;
    CHECK(aoi_star_modes(star, keep(aoi_star_modes_size(star)), &body) == AOI_OK, "modes of a star of %zu", star->n);
    double *v = zeros(body.n), *push = zeros(body.n), *inertia = zeros(body.n), *shape = zeros(body.n);
    double *decay = zeros(body.n), *weight = zeros(body.n), *centre = zeros(body.n);
    const double mass = aoi_star_static_mass(star), *r = body.shape;
    for (size_t j = 0; j < body.n; j++) { /* each by its share in the contact's displacement */
        shape[j] = 1.0;
        push[j] = isinf(mass) ? 0.0 : (star->n == 0 ? 1.0 / mass : r[j] * r[j]);
        inertia[j] = isinf(mass) ? 0.0 : 1.0 / push[j];
        centre[j] = isinf(mass) || star->n == 0 ? 1.0 : body.centre[j] / r[j];
        v[j] = velocity * (isinf(mass) || star->n == 0 ? 1.0 : mass * body.centre[j] * r[j]);
        v[j] += star->m0 > 0.0 && !isinf(mass) ? kick * star->m0 * push[j] : 0.0;
        decay[j] = damping ? 0.5 * (damping[0] + damping[1] * body.omega[j] * body.omega[j]) : 0.0;
        for (size_t i = 0; gravity && i <= star->n; i++) {
            weight[j] += r[j] * star_shape(star, &body, i, j) * gravity[i];
        }
    }
    body.shape = shape;
    body.push = push;
    body.inertia = inertia;
    body.centre = centre;
    body.decay = damping ? decay : NULL;
    body.gravity = gravity ? weight : NULL;
    return add_body(w, body, zeros(body.n), v);
}

static inline void add_contact(world *w, size_t first, size_t second, size_t port, const aoi_law *law, double gap)
{
    w->contact[w->system.contact_count++] = (aoi_contact){{first, second}, {0, port}, gap, law, NULL, NULL};
}

/* Starts a run of so many columns; record: where, or NULL. */
static inline int world_start(world *w, aoi_rule rule, size_t columns, double *record)
{
    w->system.body = w->body;
    w->system.contact = w->contact;
    w->rule = rule;
    w->at = 0;
    w->columns = columns;
    const int status = aoi_system_link(&w->system, keep(aoi_system_size(&w->system)));
    if (status != AOI_OK) {
        return status;
    }
    const size_t all = w->system.first[w->system.body_count];
    double *x = zeros(all), *v = zeros(all);
    for (size_t b = 0; b < w->system.body_count; b++) {
        memcpy(x + w->system.first[b], w->x[b], w->body[b].n * sizeof *x);
        memcpy(v + w->system.first[b], w->v[b], w->body[b].n * sizeof *v);
    }
    w->start.x = x;
    w->start.v = v;
    w->run = keep(aoi_newmark_size(&w->system));
    w->record = record ? record : keep(aoi_record_rows(&w->system) * columns * sizeof(double));
    return aoi_newmark_start(w->run, &w->system, &rule, &w->start, !w->lean, w->record, columns);
}

/* Has step() push the first body. */
static inline void by_hand(world *w)
{
    static const double time = 0.0;
    w->body[0].load = (aoi_load){1, &time, w->push};
}

static inline const double *row_of_body(const world *w, size_t body, size_t which)
{
    return w->record + (aoi_record_body(&w->system, body) + which) * w->columns;
}

/* The record of a body, by name. */
typedef struct observation {
    double centre_displacement, centre_velocity;
    double kinetic, elastic, dissipated, work;
    double displacement, velocity;
} observation;

static inline observation observe(const world *w, size_t b)
{
    double row[AOI_BODY_ROWS + AOI_PORT_ROWS];
    for (size_t i = 0; i < AOI_BODY_ROWS + AOI_PORT_ROWS; i++) {
        row[i] = row_of_body(w, b, i)[w->at];
    }
    return (observation){row[0], row[1], row[2], row[3], row[4], row[5], row[6], row[7]};
}

/* The loads' work is left out of it. */
static inline int step_on(world *w)
{
    size_t done;
    const int status = aoi_newmark_run(w->run, w->at + 1, &done);
    w->at = done;
    return status;
}

static inline observation step(world *w, double force)
{
    w->push[0] = force;
    CHECK(step_on(w) == AOI_OK, "step %zu", w->at + 1);
    return observe(w, 0);
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

/* A star of n oscillators of masses from a gram to 10^heaviest kg, in ascending order. */
enum { MOST_OSCILLATORS = 64 };
typedef struct random_star {
    double m[MOST_OSCILLATORS], k[MOST_OSCILLATORS];
    aoi_star star;
} random_star;

static inline void random_star_make(random_star *r, size_t n, uint64_t *seed, double heaviest, double m0, double k0)
{
    for (size_t i = 0; i < n; i++) {
        r->m[i] = decades(seed, -3.0, heaviest);
        r->k[i] = r->m[i] * decades(seed, 8.0, 12.0);
        for (size_t j = i; j > 0 && r->k[j] / r->m[j] < r->k[j - 1] / r->m[j - 1]; j--) {
            const double m = r->m[j], k = r->k[j];
            r->m[j] = r->m[j - 1];
            r->k[j] = r->k[j - 1];
            r->m[j - 1] = m;
            r->k[j - 1] = k;
        }
    }
    r->star = (aoi_star){n, m0, k0, r->m, r->k};
}

#endif
