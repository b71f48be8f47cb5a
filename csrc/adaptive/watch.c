/* Watched contacts: open ones between bodies in free motion, in two heaps ordered by the time flight.until. One
 * heap has the contacts that touch at that time, the other those that do not touch before it. Only the first
 * contact of each heap is read. */
#include "adaptive/run.h"

static const size_t NOWHERE = (size_t)-1;

/* True if the first of two contacts comes before the other in a heap: its time is earlier, or equal and its index
 * lower. */
static int comes_first(const aoi_adaptive *run, size_t one, size_t other)
{
    const double time = run->contact[one].flight.until, its = run->contact[other].flight.until;
    return time < its || (time == its && one < other);
}

static void put(aoi_adaptive *run, size_t *heap, size_t place, size_t c)
{
    heap[place] = c;
    run->contact[c].flight.place = place;
}

/* Moves the contact at a position of a heap up until the heap is in order. */
static void rise(aoi_adaptive *run, size_t *heap, size_t place)
{
    const size_t c = heap[place];
    while (place > 0 && comes_first(run, c, heap[(place - 1) / 2])) {
        put(run, heap, place, heap[(place - 1) / 2]);
        place = (place - 1) / 2;
    }
    put(run, heap, place, c);
}

/* Moves the contact at a position of a heap down until the heap is in order. */
static void sink(aoi_adaptive *run, size_t *heap, size_t count, size_t place)
{
    const size_t c = heap[place];
    for (size_t below = 2 * place + 1; below < count; below = 2 * place + 1) {
        if (below + 1 < count && comes_first(run, heap[below + 1], heap[below])) {
            below++;
        }
        if (!comes_first(run, heap[below], c)) {
            break;
        }
        put(run, heap, place, heap[below]);
        place = below;
    }
    put(run, heap, place, c);
}

void aoi_watch_begin(aoi_adaptive *run)
{
    run->watched[0].count = run->watched[1].count = 0;
    for (size_t c = 0; c < run->system->contact_count; c++) {
        run->contact[c].flight.place = NOWHERE;
    }
}

int aoi_watch_has(const aoi_adaptive *run, size_t c) { return run->contact[c].flight.place != NOWHERE; }

void aoi_watch_add(aoi_adaptive *run, size_t c)
{
    aoi_list *heap = &run->watched[run->contact[c].flight.touches != 0];
    if (run->contact[c].flight.place != NOWHERE) {
        return;
    }
    heap->at[heap->count] = c;
    rise(run, heap->at, heap->count++);
}

int aoi_watch_remove(aoi_adaptive *run, size_t c)
{
    aoi_list *heap = &run->watched[run->contact[c].flight.touches != 0];
    const size_t place = run->contact[c].flight.place;
    if (place == NOWHERE) {
        return 0;
    }
    run->contact[c].flight.place = NOWHERE;
    const size_t last = heap->at[--heap->count];
    if (last != c) {
        put(run, heap->at, place, last);
        rise(run, heap->at, place);
        sink(run, heap->at, heap->count, run->contact[last].flight.place);
    }
    return 1;
}

double aoi_watch_first(const aoi_adaptive *run, int touches, double limit, size_t *c)
{
    const aoi_list *heap = &run->watched[touches];
    if (heap->count == 0 || !(run->contact[heap->at[0]].flight.until < limit)) {
        *c = run->system->contact_count;
        return limit;
    }
    *c = heap->at[0];
    return run->contact[*c].flight.until;
}
