/* Free motion at even times, against the closed forms in the long double's digits. */
#include "check.h"
#include "aoimpact.h"
#include "motion/even.h"

#include <stdlib.h>
#include <string.h>

enum { MODES = 6, TIMES = 1000 };

static const double OMEGA[MODES] = {0.0, 3.0, 40.0, 41.0, 900.0, 2e4};
static const double DECAY[MODES] = {0.0, 0.2, 60.0, 0.0, 5.0, 100.0};
static const double GRAVITY[MODES] = {-9.81, 0.0, 2.0, -1.0, 30.0, 0.0};
static const double STATE[2 * MODES] = {0.1, -0.3, 0.02, 1.0, 1e-3, 1e-4, 2.0, 1.0, -3.0, 0.0, 0.7, 5.0};

/* x'' + 2 decay x' + omega^2 x = gravity from x0, v0: about the place of rest, or v' + 2 decay v = gravity. */
static void closed_form(size_t j, int damped, double gravity, double time, long double *x, long double *v)
{
    const long double w = OMEGA[j], t = time, c = damped ? DECAY[j] : 0.0, x0 = STATE[j];
    const long double v0 = STATE[MODES + j], g = gravity;
    if (j == 0) { /* neither spring nor damping */
        *x = x0 + v0 * t + 0.5L * g * t * t;
        *v = v0 + g * t;
        return;
    }
    const long double rest = g / (w * w), square = w * w - c * c, turn = sqrtl(fabsl(square));
    const long double even = square > 0.0L ? cosl(turn * t) : coshl(turn * t);
    const long double odd = (square > 0.0L ? sinl(turn * t) : sinhl(turn * t)) / turn;
    const long double fade = expl(-c * t);
    *x = rest + fade * ((x0 - rest) * even + (v0 + c * (x0 - rest)) * odd);
    *v = fade * (v0 * even - (c * v0 + w * w * (x0 - rest)) * odd);
}

/* The worst error over all times, as a share of each mode's amplitude, less what the rounding of an angle makes. */
static double worst(int damped, int pulled, double from, const double *time)
{
    const aoi_modes body = {.n = MODES, .omega = OMEGA, .decay = damped ? DECAY : NULL,
                            .gravity = pulled ? GRAVITY : NULL};
    aoi_even_lanes lanes[2];
    double x[2][AOI_LANES] = {{0.0}}, v[2][AOI_LANES] = {{0.0}}, error = 0.0;
    aoi_even even = {.lanes = lanes, .x = x, .v = v, .time = NAN};
    CHECK(aoi_even_size(&body) == 2, "six modes, four at a time");
    for (size_t i = 0; i < TIMES; i++) {
        double state[2 * MODES];
        aoi_even_state(&even, &body, from, STATE, time[i], state);
        for (size_t j = 0; j < MODES; j++) {
            const double gravity = pulled ? GRAVITY[j] : 0.0, span = time[i] - from, w = fmax(OMEGA[j], 1.0);
            const double size = fabs(STATE[j]) + (fabs(STATE[MODES + j]) + fabs(gravity) * fmin(span, 1.0 / w)) / w;
            const double least = OMEGA[j] > 0.0 ? size : size * (1.0 + span * span);
            long double to, rate;
            closed_form(j, damped, gravity, span, &to, &rate);
            const double angle = 2.0 * DBL_EPSILON * OMEGA[j] * span;
            error = fmax(error, (double)fabsl(state[j] - to) / least - angle);
            error = fmax(error, (double)fabsl(state[MODES + j] - rate) / (w * least) - angle);
        }
    }
    return error;
}

static void even_times_are_as_exact_as_others(void)
{
    static double time[TIMES];
    for (int of = 0; of < 4; of++) {
        for (int k = 0; k < 3; k++) {
            const double length = k == 0 ? 1e-3 : k == 1 ? 0.05 : 1.0, from = 0.7 * length;
            for (size_t i = 0; i < TIMES; i++) {
                time[i] = from + length * (double)i / (TIMES - 1);
            }
            const double error = worst(of & 1, of & 2, from, time);
            CHECK(error < 1e-14, "damping %d, gravity %d, %g s: error %g", of & 1, of >> 1, length, error);
        }
    }
}

/* Jittered by shares of the spacing above and below what counts as even, and steps of two sizes, or none. */
static void so_are_times_that_are_nearly_even(void)
{
    static double time[TIMES];
    for (int k = 4; k < 14; k++) {
        uint64_t seed = 5;
        for (size_t i = 0; i < TIMES; i++) {
            time[i] = 1e-4 * ((double)i + pow(10.0, -k) * uniform(&seed));
        }
        const double error = worst(k & 1, k & 2, 0.0, time);
        CHECK(error < 1e-14, "even to 1e-%d: error %g", k, error);
    }
    for (size_t i = 0; i < TIMES; i++) {
        time[i] = 1e-4 * (double)(i / 3 * 2);
        time[i] += i % 7 == 0 ? 3e-5 : 0.0;
    }
    const double error = worst(0, 1, 0.0, time);
    CHECK(error < 1e-14, "times that repeat, and go back: error %g", error);
}

/* What came before `from` is of another motion. */
static void a_new_motion_begins_anew(void)
{
    const aoi_modes body = {.n = MODES, .omega = OMEGA};
    aoi_even_lanes lanes[2];
    double x[2][AOI_LANES] = {{0.0}}, v[2][AOI_LANES] = {{0.0}}, state[2 * MODES], other[2 * MODES];
    double start[2 * MODES];
    aoi_even even = {.lanes = lanes, .x = x, .v = v, .time = NAN};
    for (int i = 0; i < 4; i++) {
        aoi_even_state(&even, &body, 0.0, STATE, 0.25 * i, state);
    }
    for (int i = 0; i < 2 * MODES; i++) {
        start[i] = -2.0 * STATE[i];
    }
    aoi_even_state(&even, &body, 0.8, start, 1.0, state);
    even.time = NAN;
    aoi_even_state(&even, &body, 0.8, start, 1.0, other);
    CHECK(memcmp(state, other, sizeof state) == 0, "the state is that of the new motion alone");
}

int main(void)
{
    even_times_are_as_exact_as_others();
    so_are_times_that_are_nearly_even();
    a_new_motion_begins_anew();
    return check_report();
}
