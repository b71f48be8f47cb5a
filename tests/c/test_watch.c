/* Contacts in flight come out in the order of their times, whatever goes in and out between. */
#include "check.h"
#include "adaptive/adaptive.h"
#include "adaptive/run.h"

#include <math.h>

enum { JOINTS = 50, MOVES = 20000 };

typedef struct watching {
    aoi_system system;
    aoi_contact_state contact[JOINTS];
    size_t lists[2 * JOINTS];
    int watched[JOINTS];
    aoi_adaptive run;
} watching;

static void begin(watching *w)
{
    *w = (watching){.system = {.joint_count = JOINTS}};
    w->run.system = &w->system;
    w->run.contact = w->contact;
    w->run.watched[0] = (aoi_list){0, w->lists};
    w->run.watched[1] = (aoi_list){0, w->lists + JOINTS};
    aoi_watch_begin(&w->run);
}

/* The first of all by looking at each. */
static size_t first_of(const watching *w, int touches, double limit)
{
    size_t first = JOINTS;
    for (size_t c = 0; c < JOINTS; c++) {
        if (w->watched[c] && w->contact[c].touches == touches && w->contact[c].free_until < limit) {
            limit = w->contact[c].free_until;
            first = c;
        }
    }
    return first;
}

static void the_first_comes_first(void)
{
    uint64_t seed = 11;
    watching w;
    begin(&w);
    for (int i = 0; i < MOVES; i++) {
        const size_t joint = (size_t)(uniform(&seed) * JOINTS);
        CHECK(aoi_watch_remove(&w.run, joint) == w.watched[joint], "whether %zu was watched", joint);
        w.watched[joint] = uniform(&seed) < 0.7;
        if (w.watched[joint]) { /* with many at the same time */
            w.contact[joint].free_until = floor(20.0 * uniform(&seed));
            w.contact[joint].touches = uniform(&seed) < 0.5;
            aoi_watch_add(&w.run, joint);
        }
        for (int touches = 0; touches < 2; touches++) {
            const double limit = 20.0 * uniform(&seed);
            const size_t wanted = first_of(&w, touches, limit);
            size_t found;
            const double time = aoi_watch_first(&w.run, touches, limit, &found);
            CHECK(found == wanted, "move %d: %zu, not %zu", i, found, wanted);
            CHECK(time == (wanted < JOINTS ? w.contact[wanted].free_until : limit), "its time");
        }
    }
}

static void all_come_out_in_order(void)
{
    uint64_t seed = 5;
    watching w;
    size_t joint, count = 0;
    begin(&w);
    for (size_t c = 0; c < JOINTS; c++) {
        w.contact[c].free_until = c < 10 ? -HUGE_VAL : uniform(&seed);
        aoi_watch_add(&w.run, c);
    }
    for (double last = -HUGE_VAL; aoi_watch_first(&w.run, 0, HUGE_VAL, &joint) < HUGE_VAL; count++) {
        CHECK(w.contact[joint].free_until >= last, "%zu after what is later", joint);
        CHECK(count >= 10 || joint == count, "of those at one time %zu before %zu", joint, count);
        last = w.contact[joint].free_until;
        CHECK(aoi_watch_remove(&w.run, joint) && !aoi_watch_remove(&w.run, joint), "once");
    }
    CHECK(count == JOINTS, "all: %zu", count);
}

int main(void)
{
    the_first_comes_first();
    all_come_out_in_order();
    return check_report();
}
