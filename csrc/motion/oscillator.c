/* Motion of one mode, x'' + 2 decay x' + omega^2 x = load + slope t, in closed form: after any time, and under a
 * polynomial force. The mode may be undamped, damped or overdamped, or have no spring. */
#include "motion/oscillator.h"
#include "law/law.h"
#include "motion/lanes.h"

#include <math.h>

enum { SERIES_TERMS = 18 };

/* The Taylor series of the motion ends when two successive coefficients add up to less than this; the series' sums
 * are between 1/8 and 1. */
static const double NOTHING = 1e-19;

/* Arguments below which the closed forms lose digits to cancellation. SERIES_LIMIT: of omega or decay times the
 * time, in the motion of a mode; RAMP_LIMIT: of s t, in the second integral of e^(-s t). */
static const double SERIES_LIMIT = 0.5, RAMP_LIMIT = 1.0;

/* Ratio of omega to decay below which the two exponentials of an overdamped mode differ enough to be subtracted. */
static const double SLOW_SHARE = 0.5;

/* Ratio of |omega^2 - decay^2| to decay^2 below which damping counts as critical. */
static const double CRITICAL = 1e-6;

/* Computes the motion by the Taylor series of the impulse response, whose coefficients follow from the
 * differential equation. */
static void series(double omega, double decay, double time, aoi_motion *motion)
{
    const double damping = 2.0 * decay * time, spring = omega * time * (omega * time);
    double before = 0.0, here = 1.0; /* coefficients k-1 and k of the series of impulse / time */
    *motion = (aoi_motion){0.0, 0.0, 0.0, 0.0};
    for (int k = 1; k < SERIES_TERMS && fabs(before) + fabs(here) > NOTHING; k++) {
        motion->impulse += here;
        motion->rate += k * here;
        motion->step += here / (k + 1.0);
        motion->ramp += here / ((k + 1.0) * (k + 2.0));
        const double next = -(damping * k * here + spring * before) / (k * (k + 1.0));
        before = here;
        here = next;
    }
    motion->impulse *= time;
    motion->step *= time * time;
    motion->ramp *= time * time * time;
}

static void undamped(double omega, double time, aoi_motion *motion)
{
    const double lanes[AOI_LANES] = {omega, omega, omega, omega};
    aoi_turn turn;
    aoi_motions all;
    aoi_turn_make(lanes, time, &turn);
    aoi_turn_motions(&turn, &all);
    *motion = (aoi_motion){all.impulse[0], all.rate[0], all.step[0], (time - all.impulse[0]) / (omega * omega)};
}

/* Computes the motion if the mode is not strongly overdamped and the time not short: step and ramp follow from the
 * differential equation. */
static void damped(double omega, double decay, double time, aoi_motion *motion)
{
    const double square = (omega - decay) * (omega + decay), turn = sqrt(fabs(square));
    const double angle = turn * time, left = exp(-decay * time);
    const double damping = 2.0 * decay, spring = omega * omega;
    if (square > 0.0) {
        motion->impulse = left * (angle > 0.0 ? sin(angle) / angle : 1.0) * time;
        motion->rate = left * cos(angle) - decay * motion->impulse;
    } else {
        const double fast = decay + turn, slow = omega * (omega / fast);
        motion->impulse = turn > 0.0 ? -exp(-slow * time) * expm1(-2.0 * angle) / (2.0 * turn)
                                     : left * time;
        motion->rate = exp(-fast * time) - slow * motion->impulse;
    }
    motion->step = (1.0 - motion->rate - damping * motion->impulse) / spring;
    motion->ramp = (time - motion->impulse - damping * motion->step) / spring;
}

/* Computes the first and the second integral of e^(-s t) over a time. */
static void creep(double s, double time, double *once, double *twice)
{
    const double z = s * time;
    *once = z > 0.0 ? -expm1(-z) / s : time;
    if (z > RAMP_LIMIT) {
        *twice = (time - *once) / s;
        return;
    }
    double term = 0.5, total = term;
    for (int k = 1; k < SERIES_TERMS; k++) {
        term *= -z / (k + 2.0);
        total += term;
    }
    *twice = time * time * total;
}

/* Computes the motion of a strongly overdamped mode as a difference of two exponentials, of which the slow one is
 * constant if there is no spring. */
static void overdamped(double omega, double decay, double time, aoi_motion *motion)
{
    const double split = sqrt((decay - omega) * (decay + omega)), fast = decay + split;
    const double slow = omega * (omega / fast), apart = 2.0 * split;
    double slow_once, slow_twice, fast_once, fast_twice;
    creep(slow, time, &slow_once, &slow_twice);
    creep(fast, time, &fast_once, &fast_twice);
    motion->impulse = -exp(-slow * time) * expm1(-apart * time) / apart;
    motion->rate = exp(-fast * time) - slow * motion->impulse;
    motion->step = (slow_once - fast_once) / apart;
    motion->ramp = (slow_twice - fast_twice) / apart;
}

void aoi_oscillator_motion(double omega, double decay, double time, aoi_motion *motion)
{
    if (fmax(omega, decay) * time < SERIES_LIMIT) {
        series(omega, decay, time, motion);
    } else if (decay == 0.0) {
        undamped(omega, time, motion);
    } else if (omega < SLOW_SHARE * decay) {
        overdamped(omega, decay, time, motion);
    } else {
        damped(omega, decay, time, motion);
    }
}

/* Computes the integrals of the impulse response and of its rate if omega^2 - decay^2 = square is not near zero.
 * slow: the lower of the two decay rates, for square < 0. */
static void damped_integrals(double square, double slow, double decay, double h, size_t count,
                             double *impulse, double *rate)
{
    double real[AOI_NODES], imaginary[AOI_NODES], other[AOI_NODES];
    const double root = sqrt(fabs(square));
    if (square > 0.0) {
        aoi_bessel_exponential(decay * h, -root * h, count, real, imaginary);
    } else {
        aoi_bessel_exponential(slow * h, 0.0, count, real, other);
        aoi_bessel_exponential((decay + root) * h, 0.0, count, imaginary, other);
    }
    for (size_t k = 0; k < count; k++) {
        if (square > 0.0) {
            impulse[k] = imaginary[k] / root;
            rate[k] = real[k] - decay * impulse[k];
        } else { /* real: integrals of the slow exponential, imaginary: of the fast one */
            impulse[k] = (real[k] - imaginary[k]) / (2.0 * root);
            rate[k] = 0.5 * (real[k] + imaginary[k]) - decay * impulse[k];
        }
    }
}

/* For a damped mode, the integrals are those of complex exponentials; otherwise those of sin(omega t)/omega and
 * cos(omega t), as in lanes.c. */
void aoi_oscillator_integrals(double omega, double decay, double h, size_t count, double *impulse,
                              double *rate)
{
    if (decay > 0.0) {
        const double square = (omega - decay) * (omega + decay), near = CRITICAL * decay * decay;
        if (fabs(square) >= near) {
            const double slow = omega * (omega / (decay + sqrt(fabs(square))));
            damped_integrals(square, slow, decay, h, count, impulse, rate);
            return;
        }
        /* Near critical damping, the integrals are even functions of the root of square. They are extrapolated
         * linearly in square from two values. */
        double further[AOI_NODES], further_rate[AOI_NODES];
        const double share = (square - near) / (3.0 * near);
        damped_integrals(near, 0.0, decay, h, count, impulse, rate);
        damped_integrals(4.0 * near, 0.0, decay, h, count, further, further_rate);
        for (size_t k = 0; k < count; k++) {
            impulse[k] += share * (further[k] - impulse[k]);
            rate[k] += share * (further_rate[k] - rate[k]);
        }
        return;
    }
    const double lanes[AOI_LANES] = {omega, omega, omega, omega};
    aoi_turn turn;
    aoi_integrals all;
    aoi_turn_make(lanes, h, &turn);
    aoi_turn_integrals(&turn, &all);
    for (size_t k = 0; k < count; k++) {
        impulse[k] = all.impulse[k][0];
        rate[k] = all.rate[k][0];
    }
}
