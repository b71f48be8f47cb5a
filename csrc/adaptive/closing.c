/* Closing of a contact: its initial state, and estimates of its largest indentation, rate and impulse. */
#include "adaptive/run.h"
#include "law/law.h"
#include "model/system.h"
#include "motion/free.h"
#include "motion/modes.h"
#include "collocation/collocation.h"

#include <float.h>
#include <math.h>

/* Number of fixed-point iterations for estimates that depend on the contact time, which itself depends on these
 * estimates. Tried: from 2 to 12 no run changes. */
enum { RISES = 4 };

/* Ratio of the work of a force F proportional to d^n, up to an indentation d, to F d: 1/(n+1), for n = 3/2. */
static const double HERTZ_SHARE = 0.4;

/* EDGE_START, BENT_START: length of the first step of a contact, in units of the compression time times
 * rtol^(2/7); EDGE_START without residual compliance, BENT_START with one. MOST_START: limit of that length, in
 * units of the compression time; see ../README.md. Measured: EDGE_START = 13 costs as much work and 120 costs
 * 1.7 % more; BENT_START = 1 costs 1.3 % and 9 costs 0.2 % more. */
static const double EDGE_START = 40.0, BENT_START = 3.0, MOST_START = 0.75;

/* SHALLOW, STRIDE: start and stride, in log(indentation), of the search for the largest indentation, a scale that
 * need not be accurate. The stride is short because a law written by the caller may fail far beyond its range.
 * Measured: a third of the stride costs 2.0 % more work, three times the stride 0.8 %. */
static const double SHALLOW = -28.0, STRIDE = 0.35;

/* Returns the integral of a force over an interval of indentation, J; between its values at the ends of the
 * interval, the force is taken as a power of the indentation. */
static double power_work(double here, double force, double next, double next_force)
{
    const double power = force > 0.0 ? log(next_force / force) / log(next / here) : 0.0;
    return force > 0.0 && power > -1.0 && isfinite(power)
               ? (next_force * next - force * here) / (power + 1.0)
               : 0.5 * (force + next_force) * (next - here);
}

/* Returns an estimate of the largest indentation, m, at which the law has taken up the given energy and the work
 * of a constant force. most: limit of the result, the indentation that the bodies would reach without the law's
 * force. The law's force is integrated, since the potential of a plastic law is only the recoverable part of the
 * work. Between the points where the law is evaluated, the work is interpolated linearly. */
static double deepest(const aoi_law *law, const double *memory, double energy, double force, double most)
{
    double here = fmin(exp(SHALLOW), most);
    aoi_law_value value;
    aoi_law_push(law, memory, here, 0.0, &value);
    double lack = energy + force * here - HERTZ_SHARE * value.force * here, before = value.force;
    if (!(lack > 0.0)) { /* up to `here` the force is taken as proportional to d^(3/2) */
        const double work = HERTZ_SHARE * value.force * here;
        return here * fmax(pow(energy / work, 0.4), pow(force * here / work, 2.0 / 3.0));
    }
    while (here < most) {
        const double next = fmin(here * exp(STRIDE), most);
        aoi_law_push(law, memory, next, 0.0, &value);
        const double gain = power_work(here, before, next, value.force) - force * (next - here);
        if (!(gain < lack)) {
            return gain > 0.0 && gain < HUGE_VAL ? here + (next - here) * (lack / gain) : next;
        }
        lack -= gain;
        before = value.force;
        here = next;
    }
    return most;
}

/* Returns the acceleration of one port relative to the other per contact force, 1/kg. */
static double mobility_of(const aoi_free_pair *pair)
{
    double mobility = 0.0;
    for (int side = 0; side < 2; side++) {
        const aoi_modes *body = pair->body[side];
        for (size_t j = 0; j < body->n; j++) {
            const size_t at = pair->port[side] * body->n + j;
            mobility += body->shape[at] * body->push[at];
        }
    }
    return mobility;
}

/* Approach of two bodies without contact force. rate, acceleration: mean values, without the modes that oscillate
 * within the contact time; amplitude, amplitude_rate: sums of the amplitudes of displacement and velocity of these
 * modes, m and m/s. */
typedef struct approach {
    double rate, acceleration, amplitude, amplitude_rate;
} approach;

/* Returns the mean approach over a time, from the rate and acceleration at its start (now). Modes that oscillate
 * within this time contribute only their amplitudes. */
static approach mean_approach(const aoi_free_pair *pair, approach now, double time)
{
    for (int side = 0; side < 2; side++) {
        const aoi_modes *body = pair->body[side];
        for (size_t j = body->n; j-- > 0 && body->omega[j] * time > 1.0;) {
            const double shape = body->shape[pair->port[side] * body->n + j], sign = side == 0 ? 1.0 : -1.0;
            const double omega = body->omega[j], x = pair->x[side][j], v = pair->v[side][j];
            double load, slope;
            aoi_modes_drive(body, j, pair->time, &load, &slope);
            load -= omega * omega * x;
            const double amplitude = fabs(shape) * hypot(load / (omega * omega), v / omega);
            now.amplitude += amplitude;
            now.amplitude_rate += omega * amplitude;
            now.rate -= sign * shape * v;
            now.acceleration -= sign * shape * (load - 2.0 * (body->decay ? body->decay[j] : 0.0) * v);
        }
    }
    return now;
}

/* Returns the relative acceleration that a load, rising from zero, reaches within the contact time, m/s^2. The
 * contact time itself depends on the load: a few fixed-point iterations suffice. */
static double rising(const aoi_adaptive *run, const aoi_adaptive_contact *contact, const aoi_law *law,
                     const aoi_free_pair *pair, double jerk)
{
    const double left = run->end - pair->time;
    double time = left;
    for (int side = 0; side < 2; side++) {
        time = fmin(time, aoi_modes_next_bend(pair->body[side], pair->time) - pair->time);
    }
    for (int i = 0; i < RISES && jerk > 0.0; i++) {
        const double acceleration = jerk * time;
        const double reach = deepest(law, contact->memory, 0.0, acceleration / contact->scales.mobility,
                                     0.5 * acceleration * left * left);
        time = fmin(time, sqrt(reach / acceleration));
    }
    return fmax(jerk * time, 0.0);
}

/* Returns the time derivative of the acceleration of approach due to loads alone, m/s^3. */
static double load_jerk(const aoi_free_pair *pair)
{
    double jerk = 0.0;
    for (int side = 0; side < 2; side++) {
        const aoi_modes *body = pair->body[side];
        for (size_t j = 0; j < body->n && body->load.count > 0; j++) {
            double load, slope;
            aoi_modes_drive(body, j, pair->time, &load, &slope);
            jerk += (side == 0 ? 1.0 : -1.0) * body->shape[pair->port[side] * body->n + j] * slope;
        }
    }
    return jerk;
}

/* Returns an estimate of the largest indentation, m, that an approach (by) leads to within the time `left`, s. */
static double reach_of(const aoi_adaptive_contact *contact, const aoi_law *law, const approach *by, double left)
{
    const double rate = fmax(by->rate, 0.0), acceleration = fmax(by->acceleration, 0.0);
    return rate + acceleration > 0.0
               ? by->amplitude + deepest(law, contact->memory, 0.5 * rate * rate / contact->scales.mobility,
                                     acceleration / contact->scales.mobility,
                                     left * (rate + 0.5 * acceleration * left))
               : by->amplitude;
}

/* Returns an estimate of the compression time, from the touch to the largest indentation, s. */
static double time_of(const approach *by, double reach)
{
    return reach / (fmax(by->rate, 0.0) + sqrt(fmax(by->acceleration, 0.0) * reach));
}

/* Sets the base length of the run's steps, if it is not set, and refines the level of the step length for a
 * contact that begins: the first step must resolve its motion, which starts like t + t^(7/2), to rtol. time:
 * compression time, s. */
static void first_level(aoi_adaptive *run, size_t c, double time)
{
    if (run->base == 0.0) {
        run->base = 3.0 * time;
        run->level = AOI_HIGHEST_LEVEL;
    }
    const double first = time * (aoi_system_residual(run->system, c, c) > 0.0
                                     ? BENT_START * pow(run->rtol, 1.0 / 3.5)
                                     : fmin(EDGE_START * pow(run->rtol, 1.0 / 3.5), MOST_START));
    const double levels = AOI_LEVELS * log2(run->base / first);
    if (fabs(levels) < AOI_DEEPEST_LEVEL && aoi_level_from(run, levels) > run->level) {
        run->level = aoi_level_from(run, levels);
    }
}

/* Returns the time for which a contact's present rate of approach may last, s: up to the run's end or, at a
 * massless contact point, up to the next bend of a load, which the point follows at once. */
static double time_left(const aoi_adaptive *run, size_t c)
{
    /* slightly later than now: a bend of a load within rounding of the present time counts as past */
    const double now = aoi_run_now(run) * (1.0 + 8.0 * DBL_EPSILON);
    double end = run->end;
    for (int side = 0; side < 2 && aoi_system_residual(run->system, c, c) > 0.0; side++) {
        end = fmin(end, aoi_modes_next_bend(&run->system->body[run->system->contact[c].body[side]], now));
    }
    return end - aoi_run_now(run);
}

/* Estimates the scales of a contact that begins, from the mobility of its two ports alone. rate: rate of its
 * indentation; alone: derivatives of the indentation without contact force. The scales are lower bounds: the first
 * steps may be too short, but not too long. A mode that oscillates within the contact time contributes at most its
 * amplitude, whatever its velocity. At a massless contact point without mobility there is no estimate. */
static void estimate_scales(aoi_adaptive *run, size_t c, const aoi_free_pair *pair, double rate, const double *alone)
{
    aoi_adaptive_contact *contact = &run->contact[c];
    const aoi_law *law = run->system->contact[c].law;
    const double left = time_left(run, c);
    aoi_law_value value;
    contact->scales.mobility = mobility_of(pair);
    if (!(contact->scales.mobility > 0.0)) {
        return;
    }
    const approach now = {rate, alone[2] != 0.0 ? alone[2] : rising(run, contact, law, pair, alone[3]), 0.0, 0.0};
    approach by = now, slow = now;
    double reach = reach_of(contact, law, &by, left), time = time_of(&by, reach);
    for (int i = 0; i < RISES; i++) {
        slow = mean_approach(pair, now, time);
        const double less = slow.amplitude > 0.0 ? reach_of(contact, law, &slow, left) : reach;
        if (!(less < reach)) {
            break;
        }
        by = slow.rate > 0.0 || slow.acceleration > 0.0 ? slow : now;
        reach = less;
        time = fmax(time, time_of(&by, reach));
    }
    /* a mode may separate the bodies again at once */
    if (now.acceleration < 0.0 && slow.amplitude_rate > slow.rate) {
        reach = fmin(reach, 0.5 * rate * rate / -now.acceleration);
        time = fmin(time, rate / -now.acceleration);
    }
    const double jerk = load_jerk(pair);
    if (rate > 0.0 && jerk < 0.0) { /* changing loads may also separate the bodies */
        const double a = fmax(now.acceleration, 0.0), turn = 2.0 * rate / (sqrt(a * a - 2.0 * jerk * rate) - a);
        reach = fmin(reach, turn * (rate + turn * (0.5 * a + turn * jerk / 6.0)));
        time = fmin(time, turn);
    }
    aoi_law_push(law, contact->memory, reach, fmax(rate, 0.0), &value);
    if (!(reach > 0.0) || !(time > 0.0) || !isfinite(3.0 * time) || !isfinite(value.force)) {
        return;
    }
    const double pace = fmax(rate, 0.0) + fmax(by.acceleration, 0.0) * time;
    const double stop = pace / contact->scales.mobility, push = value.force * time;
    contact->scales.indentation = fmax(contact->scales.indentation, reach);
    contact->scales.rate = fmax(contact->scales.rate, pace);
    contact->scales.force = fmax(contact->scales.force, fmin(stop / time, value.force));
    /* An impulse that underflows to zero (law with a high power, short record) gives no scale. */
    contact->scales.impulse = fmax(contact->scales.impulse, push > 0.0 ? fmin(stop, push) : stop);
    first_level(run, c, time);
}

/* Adds a contact to the list of closed contacts, which is in ascending order. */
static void list_closed(aoi_adaptive *run, size_t c)
{
    size_t at = run->closed.count++;
    for (; at > 0 && run->closed.at[at - 1] > c; at--) {
        run->closed.at[at] = run->closed.at[at - 1];
    }
    run->closed.at[at] = c;
    run->contact[c].is_closed = 1;
}

void aoi_contact_close(aoi_adaptive *run, size_t c)
{
    aoi_adaptive_contact *contact = &run->contact[c];
    const aoi_contact *of = &run->system->contact[c];
    const double rest = aoi_law_rest(of->law, contact->memory);
    double alone[AOI_DERIVATIVES + 1];
    aoi_free_pair pair;
    aoi_law_value value;
    aoi_watch_remove(run, c);
    list_closed(run, c);
    aoi_body_engage(run, of->body[0], AOI_WATCHED);
    aoi_body_engage(run, of->body[1], AOI_WATCHED);
    aoi_pair_now(run, c, &pair);
    aoi_free_pair_motion(&pair, AOI_DERIVATIVES, alone);
    const double here = alone[0] - aoi_contact_bent(run, c, 0), rate = alone[1] - aoi_contact_bent(run, c, 1);
    const int bends = aoi_system_residual(run->system, c, c) > 0.0;
    run->unbalanced = 1;
    contact->flight.slack = contact->ledger.since_touch = 0.0;

    /* The indentation is not reset to rest at the touch, because the errors of these resets would add up. At a
     * residual compliance the indentation follows from the forces. */
    contact->closed = (aoi_closed){.start = bends ? here : fmax(here, rest), .rate = rate, .touch_rate = rate, .begins = 1};
    if (contact->sliding) {
        aoi_sliding_touch(contact->sliding);
    }
    aoi_contact_take_piece(of->law, contact, contact->closed.start, rate >= 0.0);
    aoi_law_force(of->law, contact->memory, contact->closed.piece, fmax(here, rest), rate, &value);
    contact->closed.force = value.force;
    if (value.damping > 0.0 && bends) {
        contact->closed.rate = contact->closed.force = 0.0; /* a dashpot stops a massless contact point */
    }
    if (contact->closed.force < 0.0 && !of->law->pulls) { /* a touch within rounding: the bodies still separate     */
        contact->closed.piece = AOI_SLACK;
        contact->closed.force = 0.0;
    }
    if (!bends) { /* with a residual compliance, the balance of the contact point finds the force */
        aoi_contact_note_peak(run, c, run->contact[c].closed.force, 0.0);
    }
    estimate_scales(run, c, &pair, rate, alone);
    run->indentation_scale = fmax(run->indentation_scale, contact->scales.indentation);
    run->impulse_scale = fmax(run->impulse_scale, contact->scales.impulse);
}
