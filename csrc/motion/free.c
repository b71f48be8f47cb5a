/* Free motion of two bodies in closed form, and a search for their next touch that misses none. */
#include "motion/free.h"
#include "motion/modes.h"
#include "motion/polynomial.h"
#include "law/law.h"

#include <float.h>
#include <math.h>

void aoi_forced_fit(double from, double length, const double *values, aoi_forced *forced)
{
    forced->from = from;
    forced->length = length;
    forced->bend = 0.0;
    aoi_legendre_fit(values[0], values + 1, forced->series[0]);
    for (size_t d = 1; d <= AOI_DERIVATIVES; d++) {
        aoi_legendre_derive(AOI_NODES + 1, forced->series[d - 1], forced->series[d]);
        for (size_t k = 0; k <= AOI_NODES; k++) {
            forced->series[d][k] /= length;
        }
    }
    for (size_t k = 0; k <= AOI_NODES; k++) { /* |P_k| <= 1 */
        forced->bend += fabs(forced->series[2][k]);
    }
}

/* Returns a derivative with respect to time of the indentation added by contact forces; derivative = 0: the
 * indentation itself, m. */
static double forced_at(const aoi_free_pair *pair, int derivative)
{
    const aoi_forced *forced = pair->forced;
    double slope;
    return forced ? aoi_legendre_evaluate(AOI_NODES + 1, forced->series[derivative],
                                          (pair->time - forced->from) / forced->length, &slope)
                  : 0.0;
}

void aoi_free_pair_motion(const aoi_free_pair *pair, int most, double *of)
{
    for (int derivative = 0; derivative <= most; derivative++) {
        of[derivative] = forced_at(pair, derivative);
    }
    of[0] -= pair->gap;
    for (int side = 0; side < 2; side++) {
        const aoi_modes *body = pair->body[side];
        const double sign = side == 0 ? 1.0 : -1.0;
        double displacement, velocity, load, slope;
        aoi_modes_port(body, pair->port[side], pair->x[side], pair->v[side], &displacement,
                       &velocity);
        for (size_t q = 0; body->residual && q < body->ports; q++) {
            const double compliance = body->residual[pair->port[side] * body->ports + q];
            aoi_modes_load(body, q, pair->time, &load, &slope);
            displacement += compliance * load;
            velocity += compliance * slope;
        }
        of[0] += sign * displacement;
        of[1] += sign * velocity;
        for (size_t j = 0; most > 1 && j < body->n; j++) {
            aoi_modes_drive(body, j, pair->time, &load, &slope);
            const double share = sign * body->shape[pair->port[side] * body->n + j], omega = body->omega[j];
            const double drag = body->decay ? 2.0 * body->decay[j] : 0.0, v = pair->v[side][j];
            const double a = load - (omega * omega * pair->x[side][j] + drag * v);
            of[2] += share * a;
            of[3] += share * (slope - omega * omega * v - drag * a);
        }
    }
}

/* Returns the first positive time t at which c + b t + a t^2 becomes positive, or infinity. For c = 0 (bodies that
 * have just separated) this is the time at which the parabola becomes positive again. */
static double first_root(double c, double b, double a)
{
    if (c > 0.0 || (c == 0.0 && (b > 0.0 || (b == 0.0 && a > 0.0)))) {
        return 0.0;
    }
    if (a == 0.0) {
        return b > 0.0 ? -c / b : HUGE_VAL;
    }
    const double discriminant = b * b - 4.0 * a * c;
    if (discriminant < 0.0) {
        return HUGE_VAL; /* a < 0: the maximum lies below zero */
    }
    const double q = -0.5 * (b + copysign(sqrt(discriminant), b));
    const double roots[2] = {q / a, q != 0.0 ? c / q : 0.0};
    double first = HUGE_VAL;
    for (int i = 0; i < 2; i++) {
        if (roots[i] > 0.0 && roots[i] < first) {
            first = roots[i];
        }
    }
    return first;
}

/* Phase advance of a mode in the time left, rad, below which the mode is treated as slow: its equilibrium under a
 * load, about which a fast mode is bounded, may be very far away. Tried with a third and three times the value: 49
 * runs change, by a relative 4e-8 where rtol is 1e-5. */
static const double HARDLY_TURNS = 0.1;

/* Upper bound of a mode's contribution to the indentation over a time. For a slow mode it is a parabola, for a
 * fast mode the amplitude about an equilibrium that moves with the loads. */
typedef struct bound {
    double level, rate, bend; /* bound of a slow mode, level + rate t + bend t^2 */
    double rest, drift;       /* bound of a fast mode, rest + drift t */
    double now, later;        /* for omega = 0: limits between which the acceleration stays      */
} bound;

static int only_slow(double omega, double within) { return omega * within < HARDLY_TURNS; }

static bound bound_of(const aoi_free_pair *pair, int side, size_t j, double within)
{
    const aoi_modes *body = pair->body[side];
    const double shape = (side == 0 ? 1.0 : -1.0) * body->shape[pair->port[side] * body->n + j];
    const double omega = body->omega[j], decay = body->decay ? body->decay[j] : 0.0;
    const double x = pair->x[side][j], v = pair->v[side][j];
    double load, slope;
    aoi_modes_drive(body, j, pair->time, &load, &slope);
    bound made = {.level = shape * x, .rate = shape * v};
    if (omega == 0.0) {
        const double rise = slope != 0.0 && isfinite(within) ? slope * within : 0.0;
        made.now = shape * (load - 2.0 * decay * v);
        made.later = decay == 0.0 ? made.now + shape * rise : shape * slope / (2.0 * decay);
        return made;
    }
    const double drift = slope / (omega * omega);
    const double rest = load / (omega * omega) - 2.0 * decay * drift / (omega * omega);
    const double amplitude = fabs(shape) * hypot(x - rest, (v - drift) / omega);
    made.bend = 0.5 * omega * (omega + 2.0 * decay) * amplitude;
    if (!only_slow(omega, within)) {
        made.rest = shape * rest + amplitude;
        made.drift = shape * drift;
    }
    return made;
}

/* Returns the side (0 or 1) of the next mode, in ascending order of omega over both bodies. */
static int next_side(const aoi_free_pair *pair, const size_t *at)
{
    if (at[0] == pair->body[0]->n || at[1] == pair->body[1]->n) {
        return at[0] == pair->body[0]->n;
    }
    return pair->body[1]->omega[at[1]] < pair->body[0]->omega[at[0]];
}

/* Sums of accelerations over the modes of both bodies with omega = 0: rigid motion common to both bodies cancels
 * in the indentation, and in now and later. alike = 1: all decays are equal (decay), and all accelerations change
 * from now to later by the same function of time. */
typedef struct drifting {
    double now, later, apart; /* sums over the modes; apart: of max(now, later) of each mode */
    double decay;
    int count, alike;
} drifting;

static void add_drifting(const bound *of, double decay, drifting *sum)
{
    sum->alike = sum->count++ == 0 || (sum->alike && decay == sum->decay);
    sum->decay = decay;
    sum->now += of->now;
    sum->later += of->later;
    sum->apart += fmax(of->now, of->later);
}

static double bend_of(const drifting *sum)
{
    return 0.5 * (sum->alike ? fmax(sum->now, sum->later) : sum->apart);
}

/* Returns a time within which the bodies cannot touch, s: the longest over all ways to split the modes into slow
 * and fast ones. level, rate: bound of the indentation and of its rate with all modes fast. */
static double safe_stride(const aoi_free_pair *pair, double level, double rate, double within)
{
    const size_t count = pair->body[0]->n + pair->body[1]->n;
    size_t at[2] = {0, 0};
    double bend = pair->forced ? 0.5 * pair->forced->bend : 0.0, best = 0.0;
    drifting together = {.alike = 1};
    for (size_t k = 0; k <= count; k++) {
        const int side = k < count ? next_side(pair, at) : 0;
        const aoi_modes *body = pair->body[side];
        if (k == count || !only_slow(body->omega[at[side]], within)) {
            const double stride = first_root(level, rate, bend + bend_of(&together));
            best = stride > best ? stride : best;
        }
        if (k < count) {
            const size_t j = at[side]++;
            const bound of = bound_of(pair, side, j, within);
            level += of.level - of.rest;
            rate += of.rate - of.drift;
            bend += of.bend;
            if (body->omega[j] == 0.0) {
                add_drifting(&of, body->decay ? body->decay[j] : 0.0, &together);
            }
        }
    }
    return best;
}

/* Changes level and drift from the indentation and its rate to the bounds of both with all modes fast. The gap and
 * the residual compliance stay included. scale: set to the magnitude of the terms of the indentation, now and
 * within the time, since bodies may rest at their origin. */
static void all_fast(const aoi_free_pair *pair, double within, double *level, double *drift,
                     double *scale)
{
    const double start = *drift;
    double falls = 0.0;
    *scale = fabs(pair->gap);
    for (int side = 0; side < 2; side++) {
        for (size_t j = 0; j < pair->body[side]->n; j++) {
            const bound of = bound_of(pair, side, j, within);
            falls += fmax(fabs(of.now), fabs(of.later)) * within * within;
            *level += of.rest - of.level;
            *drift += of.drift - of.rate;
            *scale += fabs(of.level) + fabs(of.rest);
            *scale += only_slow(pair->body[side]->omega[j], within) ? of.bend * within * within : 0.0;
        }
    }
    if (*scale == 0.0 && start == 0.0) {
        *scale = falls; /* rigid bodies side by side, with all terms zero */
    }
}

static void fly_pair(aoi_free_pair *pair, double to)
{
    for (int side = 0; side < 2; side++) {
        aoi_modes_advance(pair->body[side], pair->time, to, pair->x[side], pair->v[side]);
    }
    pair->time = to;
}

/* Returns the time up to which no load bends, at most limit, s. */
static double stop_of(const aoi_free_pair *pair, double limit)
{
    const double bend = fmin(aoi_modes_next_bend(pair->body[0], pair->time),
                             aoi_modes_next_bend(pair->body[1], pair->time));
    return fmin(bend, limit);
}

/* True if bodies that touch are about to press on each other: the first derivative of the indentation that is not
 * zero is positive. */
static int closes(const double *of)
{
    for (int derivative = 1; derivative <= AOI_DERIVATIVES; derivative++) {
        if (of[derivative] != 0.0) {
            return of[derivative] > 0.0;
        }
    }
    return 0;
}

/* Widens the gap between two bodies by a rounding error if their indentation is zero within rounding and nothing
 * presses them together, so that they count as apart. Such bodies have just separated, or stay side by side until
 * a load draws one away. */
static void part(aoi_free_pair *pair, double within)
{
    double of[AOI_DERIVATIVES + 1], scale;
    aoi_free_pair_motion(pair, AOI_DERIVATIVES, of);
    double level = of[0], drift = of[1];
    all_fast(pair, within, &level, &drift, &scale);
    const double rounding = 4.0 * DBL_EPSILON * scale;
    if (of[0] > -rounding && !closes(of)) {
        pair->gap += of[0] + rounding;
    }
}

/* Returns the time in which an indentation changes by its rounding error, s. A rate that is itself rounding error
 * does not determine this time: bodies that rest side by side may be about to press on each other. */
static double rounding_time(double rounding, const double *of)
{
    const double rate = of[1], jerk = fabs(of[3]);
    const double sum = fabs(rate) + sqrt(rate * rate + 2.0 * fabs(of[2]) * rounding);
    const double time = 2.0 * rounding / sum;
    return jerk > 0.0 ? fmin(time, cbrt(6.0 * rounding / jerk)) : time;
}

int aoi_free_pair_next_touch(aoi_free_pair *pair, double limit, size_t most, int *touches)
{
    *touches = 0;
    part(pair, stop_of(pair, limit) - pair->time);
    for (size_t i = 0; i < most; i++) {
        double of[AOI_DERIVATIVES + 1], scale;
        const double stop = stop_of(pair, limit), within = stop - pair->time;
        aoi_free_pair_motion(pair, AOI_DERIVATIVES, of);
        double level = of[0], drift = of[1];
        all_fast(pair, within, &level, &drift, &scale);
        if (of[0] >= -4.0 * DBL_EPSILON * scale && closes(of)) {
            *touches = 1;
            return AOI_OK;
        }
        double stride = safe_stride(pair, level, drift, within);
        /* Where a touch is missed by less than rounding, advance by the time in which the indentation changes by
         * its rounding error. */
        const double rounding = DBL_EPSILON * scale;
        if (of[1] != 0.0 && stride * fabs(of[1]) < rounding) {
            stride = fmax(stride, rounding_time(rounding, of));
        }
        stride = fmax(stride, 2.0 * DBL_EPSILON * fabs(pair->time));
        const double next = pair->time + stride;
        fly_pair(pair, next < stop ? next : stop);
        if (!(pair->time < limit)) {
            return AOI_OK;
        }
    }
    return AOI_ERROR_NO_CONVERGENCE;
}
