/* An impact in a few numbers, against closed forms of rigid bodies and a linear law. */
#include "check.h"
#include "track/brief.h"

#include <stdlib.h>
#include <string.h>

enum { ROWS = 2000 };

/* Two bodies of one mode each. */
typedef struct pair {
    double omega[2], shape[2], push[2], inertia[2], centre[2], x[2], v[2];
    aoi_modes body[2];
    aoi_law law;
    aoi_contact contact;
    aoi_system system;
    size_t links[20];
} pair;

static void make_pair(pair *p, double first_mass, double second_mass, double k, double gap)
{
    memset(p, 0, sizeof *p);
    for (size_t b = 0; b < 2; b++) {
        const double mass = b == 0 ? first_mass : second_mass;
        p->shape[b] = p->centre[b] = 1.0;
        p->push[b] = isinf(mass) ? 0.0 : 1.0 / mass;
        p->inertia[b] = isinf(mass) ? 0.0 : mass;
        p->body[b] = (aoi_modes){.n = 1, .ports = 1, .omega = &p->omega[b], .shape = &p->shape[b],
                                 .push = &p->push[b], .inertia = &p->inertia[b],
                                 .centre = &p->centre[b]};
    }
    CHECK(aoi_law_create(&p->law, "linear", 1, &k) == AOI_OK, "law");
    p->contact = (aoi_contact){{0, 1}, {0, 0}, gap, &p->law, NULL, NULL};
    p->system = (aoi_system){.body_count = 2, .contact_count = 1, .body = p->body, .contact = &p->contact};
}

static int brief_of(pair *p, double velocity, double end, size_t most, aoi_brief *brief)
{
    CHECK(aoi_system_size(&p->system) <= sizeof p->links, "room for links");
    CHECK(aoi_system_link(&p->system, p->links) == AOI_OK, "linked");
    void *memory = malloc(aoi_brief_size(&p->system, most));
    p->v[0] = velocity;
    const aoi_start start = {.x = p->x, .v = p->v};
    const int status = aoi_brief_run(&p->system, &start, 1e-9, end, most, memory, brief);
    free(memory);
    return status;
}

/* Half a swing of the relative motion; momentum changes hands. */
static void balls_collide(void)
{
    const double m = 0.3, n = 0.5, k = 1e6, gap = 1e-3, velocity = 2.0;
    const double reduced = m * n / (m + n), swing = PI * sqrt(reduced / k);
    pair p;
    aoi_brief brief;
    make_pair(&p, m, n, k, gap);
    CHECK(brief_of(&p, velocity, 0.1, ROWS, &brief) == AOI_OK, "it runs");
    CHECK(brief.touches == 1 && !brief.lasting, "once, and over");
    CHECK(near(brief.start, gap / velocity, 1e-14), "touch");
    CHECK(near(brief.end - brief.start, swing, 1e-8), "duration");
    CHECK(near(brief.peak_time - brief.start, 0.5 * swing, 1e-6), "time of the peak");
    CHECK(near(brief.peak_force, velocity * sqrt(k * reduced), 1e-8), "peak");
    CHECK(near(brief.impulse, 2.0 * reduced * velocity, 1e-8), "impulse");
    CHECK(near(brief.velocity[0], velocity * (m - n) / (m + n), 1e-7), "first flies on");
    CHECK(near(brief.velocity[1], velocity * 2.0 * m / (m + n), 1e-8), "second flies off");
}

/* What a law left in its note in a run before is not taken for this one's trouble. */
static void a_note_does_not_outlive_its_run(void)
{
    double note[AOI_LAW_NOTE] = {1e-3, 1.0, AOI_ERROR_LAW};
    pair p;
    aoi_brief brief;
    make_pair(&p, 0.3, (double)INFINITY, 1e6, 0.0);
    p.law.note = note;
    CHECK(brief_of(&p, 2.0, 0.1, ROWS, &brief) == AOI_OK, "it runs");
    CHECK(isnan(note[0]), "nothing was wrong in it");
}

static void what_cannot_be_summed_up(void)
{
    pair p;
    aoi_brief brief;
    make_pair(&p, 0.3, 0.5, 1e6, 0.0);
    CHECK(brief_of(&p, 2.0, 0.1, 3, &brief) == AOI_ERROR_TOO_LONG, "three rows are few");
    make_pair(&p, 0.3, 0.5, 1e6, 0.0);
    p.system.contact_count = 0;
    CHECK(brief_of(&p, 2.0, 0.1, ROWS, &brief) == AOI_ERROR_ARGUMENT, "no contact");
    make_pair(&p, 0.3, 0.5, 1e6, 0.0);
    CHECK(brief_of(&p, 2.0, -1.0, ROWS, &brief) != AOI_OK, "an end before the start");
}

/* A light ball that bounces on a heavy one on a spring is met again. What comes after the last touch does not count. */
static void touches_are_counted(void)
{
    pair p;
    aoi_brief brief, early;
    make_pair(&p, 0.3, 0.5, 1e6, 0.0);
    p.omega[1] = 1000.0;
    CHECK(brief_of(&p, 2.0, 0.05, ROWS, &brief) == AOI_OK, "it runs");
    CHECK(brief.touches > 1, "%d touches", (int)brief.touches);
    CHECK(brief.start == 0.0, "the first one's start");
    CHECK(brief.end > 1e-3 && brief.end < 0.05, "the last one's end: %g", brief.end);
    make_pair(&p, 0.3, 0.5, 1e6, 0.0);
    p.omega[1] = 1000.0;
    CHECK(brief_of(&p, 2.0, 1.001 * brief.end, ROWS, &early) == AOI_OK && early.touches == brief.touches, "as many");
    CHECK(near(early.velocity[1], brief.velocity[1], 1e-9), "and then at %g m/s", early.velocity[1]);
}

int main(void)
{
    balls_collide();
    a_note_does_not_outlive_its_run();
    touches_are_counted();
    what_cannot_be_summed_up();
    return check_report();
}
