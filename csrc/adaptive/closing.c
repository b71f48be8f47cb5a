/* A contact that closes: the state that it begins with, and how large it will be, before it is known. */
#include "adaptive/run.h"
#include "law/law.h"
#include "model/system.h"
#include "motion/free.h"
#include "motion/modes.h"
#include "collocation/collocation.h"

#include <math.h>

/* How often a rising load and the time that it has are put into each other. */
enum { RISES = 4 };

/* Work on a contact from the touch on, as a share of force times indentation: 1/(n+1) for a power n. */
static const double HERTZ_SHARE = 0.4;

/* The first step as a share of the time in and of a power of rtol, as far as the solution at an edge
 * reaches, or where there is none, with a residual compliance; and at most. */
static const double EDGE_START = 40.0, BENT_START = 3.0, MOST_START = 0.75;

/* Where the search for the deepest indentation begins, and how it goes on up, logarithms: a scale need not be
 * sharp. A caller's law may end not far beyond what it is for, so that nobody may ask there. */
static const double SHALLOW = -28.0, STRIDE = 0.35, SHARPNESS = 1e-3;

/* The integral over a stretch of a force that goes from one value to another like a power of the indentation. */
static double power_work(double here, double force, double next, double next_force)
{
    const double power = force > 0.0 ? log(next_force / force) / log(next / here) : 0.0;
    return force > 0.0 && power > -1.0 && isfinite(power)
               ? (next_force * next - force * here) / (power + 1.0)
               : 0.5 * (force + next_force) * (next - here);
}

/* Where in a stretch from nothing a force that rises like Hertz's has taken an energy, and a steady force's work. */
static double shallow(const aoi_law *law, const double *memory, double energy, double force, double high)
{
    double low = -700.0;
    high = log(high);
    while (high - low > SHARPNESS) {
        const double middle = 0.5 * (low + high), here = exp(middle);
        aoi_law_value value;
        aoi_law_push(law, memory, here, 0.0, &value);
        if (HERTZ_SHARE * value.force * here < energy + force * here) {
            low = middle;
        } else {
            high = middle;
        }
    }
    return exp(high);
}

/* About the indentation at which the law has taken an energy, and what a steady force has added to it on the way;
 * at most so far, to where the motion would lead without the law. By the law's force, since what a plastic law gives
 * back is only a part of its work; linear between the places where it is asked. */
static double deepest(const aoi_law *law, const double *memory, double energy, double force, double most)
{
    double here = fmin(exp(SHALLOW), most);
    aoi_law_value value;
    aoi_law_push(law, memory, here, 0.0, &value);
    double lack = energy + force * here - HERTZ_SHARE * value.force * here, before = value.force;
    if (!(lack > 0.0)) {
        return shallow(law, memory, energy, force, here);
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

/* The compliance of both ports to a sudden force, 1/kg. */
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

/* How bodies approach each other without contact force: a rate and an acceleration that last, and how far and how fast
 * the modes that turn back meanwhile may swing besides. */
typedef struct approach {
    double rate, acceleration, swing, swing_rate;
} approach;

/* The same for a time, from the rate and the acceleration of the moment. */
static approach lasting(const aoi_free_pair *pair, approach now, double time)
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
            now.swing += amplitude;
            now.swing_rate += omega * amplitude;
            now.rate -= sign * shape * v;
            now.acceleration -= sign * shape * (load - 2.0 * (body->decay ? body->decay[j] : 0.0) * v);
        }
    }
    return now;
}

/* What a load that rises from nothing comes to while the contact takes it, as an acceleration: it and the
 * time that the contact takes hang on each other, loosely. */
static double rising(const aoi_adaptive *run, const aoi_adaptive_contact *contact, const aoi_law *law,
                     const aoi_free_pair *pair)
{
    const double jerk = aoi_free_pair_jerk(pair);
    const double left = run->end - pair->time;
    double time = left;
    for (int side = 0; side < 2; side++) {
        time = fmin(time, aoi_modes_next_bend(pair->body[side], pair->time) - pair->time);
    }
    for (int i = 0; i < RISES && jerk > 0.0; i++) {
        const double acceleration = jerk * time;
        const double reach = deepest(law, contact->memory, 0.0, acceleration / contact->mobility,
                                     0.5 * acceleration * left * left);
        time = fmin(time, sqrt(reach / acceleration));
    }
    return fmax(jerk * time, 0.0);
}

/* How deep that leads in the time left, and how long it takes. */
static double reach_of(const aoi_adaptive_contact *contact, const aoi_law *law, const approach *by, double left)
{
    const double rate = fmax(by->rate, 0.0), acceleration = fmax(by->acceleration, 0.0);
    return rate + acceleration > 0.0
               ? by->swing + deepest(law, contact->memory, 0.5 * rate * rate / contact->mobility,
                                     acceleration / contact->mobility,
                                     left * (rate + 0.5 * acceleration * left))
               : by->swing;
}

static double time_of(const approach *by, double reach)
{
    return reach / (fmax(by->rate, 0.0) + sqrt(fmax(by->acceleration, 0.0) * reach));
}

/* The first step of a run, and what counts as fine enough for this contact: the motion starts like t + t^(7/2), which
 * the first step resolves to rtol. */
static void first_level(aoi_adaptive *run, size_t c, double time)
{
    if (run->base == 0.0) {
        run->base = 3.0 * time;
        run->level = AOI_HIGHEST_LEVEL;
    }
    const double first = time * (aoi_system_residual(run->system, c) > 0.0
                                     ? BENT_START * pow(run->rtol, 1.0 / 3.5)
                                     : fmin(EDGE_START * pow(run->rtol, 1.0 / 3.5), MOST_START));
    const double levels = AOI_LEVELS * log2(run->base / first);
    if (fabs(levels) < AOI_DEEPEST_LEVEL && aoi_level_from(run, levels) > run->level) {
        run->level = aoi_level_from(run, levels);
    }
}

/* Scales of the contact that begins, as if nothing but the touching parts took part: lower bounds, so
 * that the first steps are rather too careful. What rings meanwhile brings the bodies no nearer than it swings,
 * however fast it is now. None, where the contacts beside it decide what it will be. */
static void estimate_scales(aoi_adaptive *run, size_t c, const aoi_free_pair *pair, double rate,
                            double acceleration)
{
    aoi_adaptive_contact *contact = &run->contact[c];
    const aoi_law *law = run->system->contact[c].law;
    const double left = run->end - aoi_run_now(run);
    aoi_law_value value;
    contact->mobility = mobility_of(pair);
    if (!(contact->mobility > 0.0)) {
        return;
    }
    const approach now = {rate, acceleration != 0.0 ? acceleration : rising(run, contact, law, pair),
                          0.0, 0.0};
    approach by = now, slow = now;
    double reach = reach_of(contact, law, &by, left), time = time_of(&by, reach);
    for (int i = 0; i < RISES; i++) {
        slow = lasting(pair, now, time);
        const double less = slow.swing > 0.0 ? reach_of(contact, law, &slow, left) : reach;
        if (!(less < reach)) {
            break;
        }
        by = slow.rate > 0.0 || slow.acceleration > 0.0 ? slow : now;
        reach = less;
        time = fmax(time, time_of(&by, reach));
    }
    if (now.acceleration < 0.0 && slow.swing_rate > slow.rate) { /* a crest that may be drawn back at once */
        reach = fmin(reach, 0.5 * rate * rate / -now.acceleration);
        time = fmin(time, rate / -now.acceleration);
    }
    aoi_law_push(law, contact->memory, reach, fmax(rate, 0.0), &value);
    if (!(reach > 0.0) || !(time > 0.0) || !isfinite(3.0 * time) || !isfinite(value.force)) {
        return;
    }
    const double pace = fmax(rate, 0.0) + fmax(by.acceleration, 0.0) * time;
    const double stop = pace / contact->mobility, push = value.force * time;
    contact->indentation_scale = fmax(contact->indentation_scale, reach);
    contact->rate_scale = fmax(contact->rate_scale, pace);
    /* A force below all numbers (a high power, a short record) is no scale. */
    contact->impulse_scale = fmax(contact->impulse_scale, push > 0.0 ? fmin(stop, push) : stop);
    first_level(run, c, time);
}

/* Lists it among the closed ones, which stay in order. */
static void list_closed(aoi_adaptive *run, size_t c)
{
    size_t at = run->closed.count++;
    for (; at > 0 && run->closed.at[at - 1] > c; at--) {
        run->closed.at[at] = run->closed.at[at - 1];
    }
    run->closed.at[at] = c;
    run->contact[c].closed = 1;
}

void aoi_contact_close(aoi_adaptive *run, size_t c)
{
    aoi_adaptive_contact *contact = &run->contact[c];
    const aoi_contact *of = &run->system->contact[c];
    const double rest = aoi_law_rest(of->law, contact->memory);
    double here, rate, acceleration;
    aoi_free_pair pair;
    aoi_law_value value;
    aoi_watch_remove(run, c);
    list_closed(run, c);
    aoi_body_engage(run, of->body[0], 1);
    aoi_body_engage(run, of->body[1], 1);
    aoi_pair_now(run, c, &pair);
    aoi_free_pair_indentation(&pair, &here, &rate, &acceleration);
    here -= aoi_contact_bent(run, c, 0);
    rate -= aoi_contact_bent(run, c, 1);
    const int bends = aoi_system_residual(run->system, c) > 0.0;
    run->unbalanced = 1;
    contact->begins = 1;
    contact->slack = 0.0;

    /* Exactly: what is left off here would add up. What has no mass is where the forces say. */
    contact->start = bends ? here : fmax(here, rest);
    contact->start_rate = contact->touch_rate = rate;
    contact->last_length = contact->since_touch = contact->edge = 0.0;
    contact->piece = aoi_law_piece(of->law, contact->memory, contact->start, rate >= 0.0,
                                   &contact->low, &contact->high);
    aoi_law_force(of->law, contact->memory, contact->piece, fmax(here, rest), rate, &value);
    contact->force = value.force;
    if (value.damping > 0.0 && bends) {
        contact->start_rate = contact->force = 0.0; /* a damper stops what has no mass */
    }
    if (contact->force < 0.0 && !of->law->pulls) { /* within rounding of a touch to come, but still parting */
        contact->piece = AOI_SLACK;
        contact->force = 0.0;
    }
    if (!bends) { /* else the step says what it begins with */
        aoi_contact_note_peak(run, c);
    }
    estimate_scales(run, c, &pair, rate, acceleration);
    run->indentation_scale = fmax(run->indentation_scale, contact->indentation_scale);
    run->impulse_scale = fmax(run->impulse_scale, contact->impulse_scale);
}
