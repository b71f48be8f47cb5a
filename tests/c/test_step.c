/* What takes part in a step, and what no longer does. */
#define MOST_BODIES 100

#include "plant.h"
#include "adaptive/row.h"

/* A wave runs along a row of balls. Behind it they go on side by side, or apart: what is solved for at any
 * time is the wave, some ten contacts however long the row. All momentum and energy is passed on. */
static void what_a_wave_has_passed_dozes_off(void)
{
    const aoi_law law = hertz(1e10);
    const double mass = 0.0327, end = 30.5e-6 * MOST_BODIES;
    for (int tolerance = 6; tolerance <= 10; tolerance += 2) {
        plant p = {.bodies = 0};
        double momentum = 0.0, energy = 0.0, most = 0.0;
        for (size_t b = 0; b < MOST_BODIES; b++) {
            add_rigid(&p, mass, b == 0 ? 1.0 : 0.0);
            if (b > 0) {
                join_rigid(&p, b - 1, b, 0.0, &law);
            }
        }
        must_go(&p, pow(10.0, -tolerance), end);
        for (size_t r = 0; r < p.track.rows; r++) {
            most = fmax(most, p.track.values[p.track.row[r] + AOI_TRACK_CONTACTS]);
        }
        CHECK(most < 14.0, "rtol 1e-%d: %g contacts at a time", tolerance, most);
        for (size_t b = 0; b < MOST_BODIES; b++) {
            momentum += p.v[b];
            energy += p.v[b] * p.v[b];
        }
        CHECK(near(momentum, 1.0, 1e-12), "rtol 1e-%d: momentum", tolerance);
        CHECK(near(energy, 1.0, pow(10.0, 1 - tolerance)), "rtol 1e-%d: energy %g", tolerance, energy - 1.0);
        release(&p);
    }
}

int main(void)
{
    what_a_wave_has_passed_dozes_off();
    return check_report();
}
