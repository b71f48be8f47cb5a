/* States of a body in free motion at evenly spaced times. */
#include "motion/even.h"
#include "motion/modes.h"

#include <math.h>

/* Largest number of successive states that are each computed from the state before. This adds an error of some
 * 3e-16 of a mode's amplitude. */
enum { FOLLOWING = 32 };

/* Largest deviations from even spacing. NEARLY_EVEN: relative to the spacing; SMALL_ANGLE: as phase angle of the
 * fastest mode, rad. Times rounded to doubles are not quite even. The deviation is corrected to first order, since
 * the square of the angle is below rounding. */
static const double NEARLY_EVEN = 1e-6, SMALL_ANGLE = 1e-8;

static void make(aoi_even *even, const aoi_modes *body)
{
    even->made = 1;
    even->fastest = 0.0;
    for (size_t j = 0; j < body->n; j++) {
        aoi_even_lanes *of = &even->lanes[j / AOI_LANES];
        const size_t i = j % AOI_LANES;
        if (i == 0) {
            memset(of, 0, sizeof *of);
            aoi_lanes_of(body, j, even->spacing, &of->by, NULL);
        }
        of->spring[i] = body->omega[j] * body->omega[j];
        of->damping[i] = body->decay ? 2.0 * body->decay[j] : 0.0;
        of->gravity[i] = body->gravity ? body->gravity[j] : 0.0;
        even->fastest = fmax(even->fastest, body->omega[j] + of->damping[i]);
    }
}

/* Advances four modes by the spacing and by the deviation `off` of the time from even spacing, s. */
static void turn(const aoi_even_lanes *of, double off, double *x, double *v)
{
    double place[AOI_LANES], speed[AOI_LANES];
    for (size_t i = 0; i < AOI_LANES; i++) {
        const double pull = of->gravity[i] - of->spring[i] * x[i];
        const double to = x[i] + v[i] * of->by.impulse[i] + pull * of->by.step[i];
        const double rate = v[i] * of->by.rate[i] + pull * of->by.impulse[i];
        place[i] = to + off * rate;
        speed[i] = rate + off * (of->gravity[i] - of->spring[i] * to - of->damping[i] * rate);
    }
    memcpy(x, place, sizeof place);
    memcpy(v, speed, sizeof speed);
}

/* True if the next state can be computed from the last one, which lies in the same free motion. */
static int follows(aoi_even *even, const aoi_modes *body, double spacing)
{
    if (!(fabs(spacing - even->spacing) <= NEARLY_EVEN * spacing)) {
        even->spacing = spacing;
        even->made = 0;
        return 0;
    }
    if (!even->made) {
        make(even, body);
    }
    return even->left > 0 && fabs(spacing - even->spacing) * even->fastest <= SMALL_ANGLE;
}

void aoi_even_state(aoi_even *even, const aoi_modes *body, double from, const double *x0, double time,
                    double *state)
{
    const size_t n = body->n;
    const double spacing = time - even->time;
    if (even->time >= from && spacing > 0.0 && follows(even, body, spacing)) {
        for (size_t i = 0; i < aoi_even_size(body); i++) {
            turn(&even->lanes[i], spacing - even->spacing, even->x[i], even->v[i]);
        }
        even->left--;
        memcpy(state, even->x, n * sizeof *state);
        memcpy(state + n, even->v, n * sizeof *state);
    } else {
        memcpy(state, x0, 2 * n * sizeof *state);
        aoi_modes_advance(body, from, time, state, state + n);
        memcpy(even->x, state, n * sizeof *state);
        memcpy(even->v, state + n, n * sizeof *state);
        even->left = FOLLOWING;
    }
    even->time = time;
}
