/* Loads: forces that are linear functions of time between given times. */
#include "model/load.h"
#include "linear/vector.h"

#include <math.h>

/* Returns the number of the load's times up to `time`, which is the index of the next time (bend), by bisection:
 * loads may have many points, and every step calls this function. */
static size_t bends_until(const aoi_load *load, double time)
{
    size_t low = 0, high = load->count; /* time[i] <= time for i < low, and > time for i >= high */
    while (low < high) {
        const size_t middle = low + (high - low) / 2;
        if (load->time[middle] <= time) {
            low = middle + 1;
        } else {
            high = middle;
        }
    }
    return low;
}

aoi_load_span aoi_load_at(const aoi_load *load, size_t ports, double time)
{
    const size_t low = bends_until(load, time);
    const double *row = load->force + (low > 0 ? low - 1 : 0) * ports;
    if (low == 0 || low == load->count) {
        return (aoi_load_span){row, row, 0.0, 1.0};
    }
    const double start = load->time[low - 1];
    return (aoi_load_span){row, row + ports, time - start, load->time[low] - start};
}

double aoi_load_later_bend(const aoi_load *load, double time, size_t skipped)
{
    const size_t next = bends_until(load, time);
    return skipped < load->count - next ? load->time[next + skipped] : HUGE_VAL;
}

int aoi_load_is_sound(const aoi_load *load, size_t ports)
{
    if (load->count > 0 && (!load->time || !load->force)) {
        return 0;
    }
    for (size_t i = 1; i < load->count; i++) {
        if (!(load->time[i] >= load->time[i - 1])) {
            return 0;
        }
    }
    return load->count == 0 || (aoi_vector_is_finite(load->count, load->time) &&
                                aoi_vector_is_finite(load->count * ports, load->force));
}
