/* A spinning ball strikes the end of a rod obliquely and with friction. The example shows rigid
 * bodies that turn, AO models in three directions, friction, and a track with growing memory.
 *
 *     make -C csrc example          or by hand, from the repository:
 *     cc -Iinclude examples/friction.c build/core/libaoimpact.a -lm */
#include "aoimpact.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

enum { TIMES = 5 };

static void check(int status, const char *what)
{
    if (status != AOI_OK) {
        fprintf(stderr, "%s: %s\n", what, aoi_status_text(status));
        exit(1);
    }
}

int main(void)
{
    /* A steel ball, kg, m; stiffness of Hertz's law, N/m^1.5; coefficient of friction. */
    const double mass = 0.0327, radius = 0.01, stiffness = 1.6e10, mu = 0.15;
    const double moment = 0.4 * mass * radius * radius;
    /* The normal points from the ball to the rod; so does the arm, from the ball's centre to the contact. */
    const aoi_rigid rigid = {mass, {moment, moment, moment}, {radius, 0.0, 0.0}};
    const double masses[] = {0.8, 0.4}, springs[] = {4e8, 1e9};
    const aoi_star star[3] = {{2, 0.05, 0.0, masses, springs}, {1, 0.05, 1e7, masses, springs}, {0, 1.0, 0.0, NULL, NULL}};
    double room[AOI_RIGID_ROOM];
    void *memory = malloc(aoi_star_modes_of_three_size(star));
    aoi_modes body[2];
    check(aoi_rigid_modes(&rigid, room, &body[0]), "ball");
    check(aoi_star_modes_of_three(star, memory, &body[1]), "rod");

    aoi_law law;
    aoi_friction friction;
    check(aoi_law_create(&law, "hertz", 1, &stiffness), "law");
    /* ratio of tangential to normal stiffness: 2 (1 - nu)/(2 - nu), nu = 0.3 */
    check(aoi_friction_create(&friction, &law, mu, 1.4 / 1.7, 1e-4), "friction");
    const aoi_contact contact = {.body = {0, 1}, .law = &law, .friction = &friction};
    aoi_system system = {.body_count = 2, .contact_count = 1, .body = body, .contact = &contact};
    void *links = malloc(aoi_system_size(&system));
    check(aoi_system_link(&system, links), "system");

    double v[16] = {1.0, 0.3, 0.0, 0.0, 0.0, -20.0}; /* ball's velocity towards the rod and along it, m/s; spin, rad/s */
    const aoi_start start = {.v = v};
    const double end = 3e-4;
    aoi_adaptive *run = malloc(aoi_adaptive_size(&system));
    aoi_track track = {.values = NULL};
    check(aoi_adaptive_start(run, &system, &start, 1e-5, end), "start");
    while (aoi_adaptive_progress(run).time < end) {
        check(aoi_track_grow(&track, aoi_adaptive_room(&system), realloc), "memory");
        check(aoi_adaptive_run(run, &track), "adaptive run");
    }

    aoi_sampler *sampler = malloc(aoi_sampler_size(&system));
    double *column = malloc(aoi_record_rows(&system) * sizeof(double));
    aoi_interval work[1], touch[1];
    check(aoi_track_intervals(&system, &track, end, work, 1, touch) == 1 ? AOI_OK : AOI_ERROR_ARGUMENT, "one touch");
    check(aoi_sampler_start(sampler, &system, &track), "dense output");
    printf("aoimpact %s\n    t, us   force, N   friction, N\n", aoi_version());
    for (int i = 0; i < TIMES; i++) {
        const double time = touch->start + (touch->end - touch->start) * i / (TIMES - 1);
        aoi_sampler_column(sampler, time, 1, column, 1);
        printf("%9.2f%11.2f%14.3f\n", 1e6 * time, column[AOI_CONTACT_FORCE], column[AOI_CONTACT_TANGENTIAL]);
    }
    const double *after = aoi_adaptive_progress(run).x ? aoi_adaptive_progress(run).v : v;
    printf("  rebound %.4f m/s, along %.4f m/s, spin %.2f rad/s\n", after[0], after[1], after[5]);

    /* All forces act at the point of contact: the ball's angular momentum about that point is conserved. */
    const double before = moment * v[5] - mass * radius * v[1], kept = moment * after[5] - mass * radius * after[1];
    check(fabs(kept - before) <= 1e-9 * fabs(before) ? AOI_OK : AOI_ERROR_TOLERANCE, "angular momentum");
    free(memory), free(links), free(run), free(track.values), free(track.row), free(sampler), free(column);
    return 0;
}
