/* Bodies that rub: balls with spin and walls, by the ports normal, t1, t2, of which contacts with friction are made. */
#ifndef RUB_H
#define RUB_H

#include "body.h"

static const double MASS = 0.02, RADIUS = 0.01, K = 3e9, RATIO = 1.4 / 1.7, FAST = 2.0;

/* A ball of three translations and two spins, by the ports normal, t1, t2; its arm from the centre is R along the normal. */
static size_t add_ball(world *w, double arm, const double velocity[3], const double gravity[3])
{
    const double inertia = 0.4 * MASS * RADIUS * RADIUS;
    const double shapes[15] = {1, 0, 0, 0, 0, 0, 1, 0, arm, 0, 0, 0, 1, 0, arm};
    const double weights[5] = {MASS, MASS, MASS, inertia, inertia}, centres[5] = {1, 0, 0, 0, 0};
    double *shape = zeros(15), *push = zeros(15), *weight = zeros(5), *centre = zeros(5), *v = zeros(5), *fall = zeros(5);
    for (size_t i = 0; i < 15; i++) {
        shape[i] = shapes[i];
        push[i] = shapes[i] / weights[i % 5];
    }
    for (size_t j = 0; j < 5; j++) {
        weight[j] = weights[j];
        centre[j] = centres[j];
        v[j] = j < 3 ? velocity[j] : 0.0;
        fall[j] = j < 3 && gravity ? gravity[j] : 0.0;
    }
    const aoi_modes ball = {.n = 5, .ports = 3, .omega = zeros(5), .shape = shape, .push = push, .inertia = weight,
                            .centre = centre, .gravity = gravity ? fall : NULL};
    return add_body(w, ball, zeros(5), v);
}

static size_t add_wall(world *w)
{
    double *shape = zeros(9), *centre = zeros(3);
    shape[0] = shape[4] = shape[8] = centre[0] = 1.0;
    const aoi_modes wall = {.n = 3, .ports = 3, .omega = zeros(3), .shape = shape, .push = zeros(9), .inertia = zeros(3),
                            .centre = centre};
    return add_body(w, wall, zeros(3), zeros(3));
}

typedef struct pair {
    world w;
    aoi_law law;
    aoi_friction friction;
} pair;

/* A pair of nothing yet, whose contacts will have that law and friction. */
static void rub(pair *p, const char *name, double k, double mu)
{
    memset(p, 0, sizeof *p);
    CHECK(aoi_law_create(&p->law, name, 1, &k) == AOI_OK && aoi_friction_create(&p->friction, &p->law, mu, RATIO, 1e-4) == AOI_OK,
          "friction of a %s law", name);
}

static void join(pair *p, size_t first, size_t second)
{
    p->w.contact[p->w.system.contact_count++] =
        (aoi_contact){.body = {first, second}, .law = &p->law, .friction = &p->friction};
}

/* A ball as body 0 in contact with a wall as body 1. */
static void meet_wall(pair *p, double arm, const double velocity[3], const double gravity[3])
{
    const size_t ball = add_ball(&p->w, arm, velocity, gravity);
    join(p, ball, add_wall(&p->w));
}

/* The time of an elastic impact of a Hertzian mass on a wall, 2.943 depth/speed (Deresiewicz). */
static double hertz_time(double mass, double k, double speed)
{
    return 2.943 * pow(1.25 * mass * speed * speed / k, 0.4) / speed;
}

/* All energy in a column of a record, whose rows are stride apart, less the work of loads. */
static inline double energy_of(const world *w, const double *column, size_t stride)
{
    double sum = 0.0;
    for (size_t c = 0; c < w->system.contact_count; c++) {
        const double *of = column + aoi_record_contact(&w->system, c) * stride;
        sum += of[AOI_CONTACT_ELASTIC * stride] + of[AOI_CONTACT_FRICTION * stride];
    }
    for (size_t b = 0; b < w->system.body_count; b++) {
        const double *of = column + aoi_record_body(&w->system, b) * stride;
        sum += of[AOI_BODY_KINETIC * stride] + of[AOI_BODY_ELASTIC * stride] - of[AOI_BODY_WORK * stride];
    }
    return sum;
}

#endif
