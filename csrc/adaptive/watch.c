/* Open contacts between bodies in flight, in two heaps: those that are certain not to touch before a time,
 * and those that touch at it. However many there are, only the first of each is ever looked at. */
#include "adaptive/adaptive.h"
#include "adaptive/run.h"

static const size_t NOWHERE = (size_t)-1;

/* Of two contacts of a heap: at the same time the lower number comes first. */
static int comes_first(const aoi_adaptive *run, size_t one, size_t other)
{
    const double time = run->contact[one].free_until, its = run->contact[other].free_until;
    return time < its || (time == its && one < other);
}

static void put(aoi_adaptive *run, size_t *heap, size_t place, size_t joint)
{
    heap[place] = joint;
    run->contact[joint].place = place;
}

/* Moves a contact from a place towards the top as far as it belongs. */
static void rise(aoi_adaptive *run, size_t *heap, size_t place)
{
    const size_t joint = heap[place];
    while (place > 0 && comes_first(run, joint, heap[(place - 1) / 2])) {
        put(run, heap, place, heap[(place - 1) / 2]);
        place = (place - 1) / 2;
    }
    put(run, heap, place, joint);
}

/* And away from it. */
static void sink(aoi_adaptive *run, size_t *heap, size_t count, size_t place)
{
    const size_t joint = heap[place];
    for (size_t below = 2 * place + 1; below < count; below = 2 * place + 1) {
        if (below + 1 < count && comes_first(run, heap[below + 1], heap[below])) {
            below++;
        }
        if (!comes_first(run, heap[below], joint)) {
            break;
        }
        put(run, heap, place, heap[below]);
        place = below;
    }
    put(run, heap, place, joint);
}

void aoi_watch_begin(aoi_adaptive *run)
{
    run->watched[0].count = run->watched[1].count = 0;
    for (size_t c = 0; c < run->system->joint_count; c++) {
        run->contact[c].place = NOWHERE;
    }
}

int aoi_watch_has(const aoi_adaptive *run, size_t joint) { return run->contact[joint].place != NOWHERE; }

void aoi_watch_add(aoi_adaptive *run, size_t joint)
{
    aoi_list *heap = &run->watched[run->contact[joint].touches != 0];
    if (run->contact[joint].place != NOWHERE) {
        return;
    }
    heap->at[heap->count] = joint;
    rise(run, heap->at, heap->count++);
}

int aoi_watch_remove(aoi_adaptive *run, size_t joint)
{
    aoi_list *heap = &run->watched[run->contact[joint].touches != 0];
    const size_t place = run->contact[joint].place;
    if (place == NOWHERE) {
        return 0;
    }
    run->contact[joint].place = NOWHERE;
    const size_t last = heap->at[--heap->count];
    if (last != joint) {
        put(run, heap->at, place, last);
        rise(run, heap->at, place);
        sink(run, heap->at, heap->count, run->contact[last].place);
    }
    return 1;
}

double aoi_watch_first(const aoi_adaptive *run, int touches, double limit, size_t *joint)
{
    const aoi_list *heap = &run->watched[touches];
    if (heap->count == 0 || !(run->contact[heap->at[0]].free_until < limit)) {
        *joint = run->system->joint_count;
        return limit;
    }
    *joint = heap->at[0];
    return run->contact[*joint].free_until;
}
