/* Contacts in free motion come out in the order of their times, whatever goes in and out between. */
#include "check.h"
#include "adaptive/run.h"

#include <math.h>

enum { CONTACTS = 50, MOVES = 20000 };

typedef struct watching {
    aoi_system system;
    aoi_adaptive_contact contact[CONTACTS];
    size_t lists[2 * CONTACTS];
    int watched[CONTACTS];
    aoi_adaptive run;
} watching;

static void begin(watching *w)
{
    *w = (watching){.system = {.contact_count = CONTACTS}};
    w->run.system = &w->system;
    w->run.contact = w->contact;
    w->run.watched[0] = (aoi_list){0, w->lists};
    w->run.watched[1] = (aoi_list){0, w->lists + CONTACTS};
    aoi_watch_begin(&w->run);
}

/* The first of all by looking at each. */
static size_t first_of(const watching *w, int touches, double limit)
{
    size_t first = CONTACTS;
    for (size_t c = 0; c < CONTACTS; c++) {
        if (w->watched[c] && w->contact[c].flight.touches == touches && w->contact[c].flight.until < limit) {
            limit = w->contact[c].flight.until;
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
        const size_t c = (size_t)(uniform(&seed) * CONTACTS);
        CHECK(aoi_watch_remove(&w.run, c) == w.watched[c], "whether %zu was watched", c);
        w.watched[c] = uniform(&seed) < 0.7;
        if (w.watched[c]) { /* with many at the same time */
            w.contact[c].flight.until = floor(20.0 * uniform(&seed));
            w.contact[c].flight.touches = uniform(&seed) < 0.5;
            aoi_watch_add(&w.run, c);
        }
        for (int touches = 0; touches < 2; touches++) {
            const double limit = 20.0 * uniform(&seed);
            const size_t wanted = first_of(&w, touches, limit);
            size_t found;
            const double time = aoi_watch_first(&w.run, touches, limit, &found);
            CHECK(found == wanted, "move %d: %zu, not %zu", i, found, wanted);
            CHECK(time == (wanted < CONTACTS ? w.contact[wanted].flight.until : limit), "its time");
        }
    }
}

int main(void)
{
    the_first_comes_first();
    return check_report();
}
