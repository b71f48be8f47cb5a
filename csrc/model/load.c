/* A force that runs straight between given times. */
#include "model/load.h"

double aoi_load_at(aoi_load *load, double time)
{
    const size_t last = load->count - 1;
    while (load->next <= last && load->time[load->next] <= time) {
        load->next++;
    }
    if (load->next == 0 || load->next > last) {
        return load->force[load->next == 0 ? 0 : last];
    }
    const double *t = load->time + load->next, *force = load->force + load->next;
    return force[-1] + (force[0] - force[-1]) * ((time - t[-1]) / (t[0] - t[-1]));
}
