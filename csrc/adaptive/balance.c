/* The forces on massless contact points are in equilibrium at every instant. Where a contact begins or ends there,
 * the forces of the contacts coupled to it change at once: rates jump, and with them the forces that depend on
 * rates.
 *
 * With residual compliances C, contact forces F and the indentations z without the deflection C F, the
 * indentations are d = z - C F. At an event, d is continuous if a law depends on the rate, and follows from
 * equilibrium if none does. The rates follow from the derivative, d' = z' - C F', with F' = K d' for a law that
 * does not depend on the rate, and from F = f(d, d') for a law that does. */
#include "adaptive/run.h"
#include "adaptive/step.h"
#include "linear/vector.h"
#include "linear/work.h"
#include "law/law.h"
#include "model/coupled.h"
#include "model/system.h"
#include "motion/modes.h"
#include "collocation/collocation.h"

#include <math.h>
#include <string.h>

/* SUDDEN, LEAST_AFTER and MOST_AFTER are times in units of the contact time; MOST_STEPS limits the contact time,
 * in steps of the run. SUDDEN: length of the implicit step that replaces a sudden change. Indentations do not
 * change in this step, except where a dashpot vanishes at the touch: there the force falls from its full value
 * like the square root of time, and its fall within SUDDEN is missed. SUDDEN = 1e-13 lost up to 15 % of a peak;
 * 1e-22 loses 5e-5 of the peak; 1e-24 has rounding errors of 1e-7. PART_RELAXED: rates and forces just after the
 * change are extrapolated from two short steps, whose length is PART_RELAXED times the relaxation time, but at
 * least LEAST_AFTER and at most MOST_AFTER. The relative error is PART_RELAXED squared, plus a rounding error
 * inversely proportional to the length. A dashpot whose relaxation time is shorter than the steps is neglected.
 *
 * Measured with SUDDEN = 1e-13: the largest jump of the sum of the forces at a place that a ball strikes, in 1200
 * scenes at rtol from 1e-9 to 1e-5, is 2 rtol. The jump is 11 rtol with PART_RELAXED = 1e-4, 87 rtol with
 * LEAST_AFTER = 1e-7, 7e4 rtol with MOST_AFTER = 1e-4, 7 rtol with MOST_STEPS = 1000, and at most 2 rtol with a
 * tenth of any of these constants. */
static const double SUDDEN = 1e-22, LEAST_AFTER = 1e-8, MOST_AFTER = 1e-5, PART_RELAXED = 1e-5,
                    MOST_STEPS = 100.0;

/* Largest ratio of a dashpot's relaxation time to the length of the implicit step at the start of a run; the step
 * is lengthened if necessary. With a larger ratio, the dashpot's force is only rounding error. Measured: 1e14 and
 * 1e15 solve all of the 400 scenes of YIELD in coupled.c, of which 4 fail without this limit; 1e13 changes the
 * time of another contact's first touch by 4e-8. */
static const double RIGID = 1e15;

/* Largest ratio of a dashpot's relaxation time to the length of an implicit step after an event. A stronger
 * dashpot is replaced by one at this limit, at which the indentation changes only by rounding. Tried with a third
 * and three times the value: 6 runs change, by a relative 4e-13. */
static const double RIGID_IN_STEP = 1e13;

/* Largest number of Newton iterations, for the forces in equilibrium and for the rates after a sudden change.
 * Tried with a third and three times the value: 1 run changes, by a relative 1e-13. */
enum { MOST_LOOPS = 30 };

size_t aoi_balance_size(size_t count, size_t span)
{
    const size_t entries = aoi_times(count, 2 * span + 1);
    return aoi_plus(aoi_plus(aoi_times(2, entries), aoi_times(5, count)), aoi_coupled_size(count, span));
}

/* Lays out the arrays of the equations in the work space that aoi_collocation_solve also uses. */
static aoi_coupled lay_out(const aoi_adaptive *run, size_t count)
{
    aoi_coupled e = {.count = count, .band = run->span < count ? run->span : count - 1};
    const size_t entries = count * (2 * e.band + 1);
    double **part[] = {&e.free, &e.rate_free, &e.indentation, &e.rate, &e.force}, *work = run->collocation;
    e.compliance = aoi_work_take(&work, entries);
    e.rate_compliance = aoi_work_take(&work, entries);
    for (size_t i = 0; i < sizeof part / sizeof *part; i++) {
        *part[i] = aoi_work_take(&work, count);
    }
    e.work = work;
    return e;
}

/* Sets up the contact equations of the listed contacts, for an implicit step of length `time`, s, or, if time is
 * 0, for the state of rest. */
static void set_equations(const aoi_adaptive *run, double time, aoi_coupled *e)
{
    const size_t width = 2 * e->band + 1;
    for (size_t i = 0; i < e->count; i++) {
        const aoi_contact_state *contact = &run->balanced[i];
        double rate;
        const double here = e->free[i] = aoi_contact_free(run, contact->contact, &rate);
        e->rate_free[i] = time > 0.0 ? rate + (here - contact->indentation) / time : 0.0;
        for (size_t k = 0; k < width; k++) {
            const size_t j = i + k - e->band; /* a negative index wraps round to a large one, which is no column */
            e->compliance[i * width + k] =
                j < e->count ? aoi_system_residual(run->system, contact->contact, run->balanced[j].contact)
                             : 0.0;
            e->rate_compliance[i * width + k] = time > 0.0 ? e->compliance[i * width + k] / time : 0.0;
        }
    }
}

/* Adds contact c to the list run->balanced of `count` entries if its contact point is massless. Returns the new
 * count. */
static size_t list(aoi_adaptive *run, size_t c, size_t count)
{
    const aoi_adaptive_contact *contact = &run->contact[c];
    const aoi_law *law = run->system->contact[c].law;
    if (!(aoi_system_residual(run->system, c, c) > 0.0)) {
        return count;
    }
    /* The dashpot of an open contact acts from the touch on: its indentation starts at rest, not at the open gap. */
    const double rest = aoi_law_rest(law, contact->memory);
    const double from = contact->is_closed ? contact->closed.start : fmax(contact->closed.start, rest);
    run->balanced[count] = (aoi_contact_state){.law = law,
                                         .force = contact->closed.force,
                                         .indentation = from,
                                         .last_indentation = from,
                                         .rate = contact->closed.rate};
    run->balanced[count].contact = c;
    memcpy(run->balanced[count].memory, contact->memory, sizeof contact->memory);
    return count + 1;
}

/* Returns the piece of the law that applies to a contact. It is the contact's present piece, unless the contact is
 * open, slack, or beyond an end of that piece by more than the tolerance of events; then indentation and rate
 * determine it. */
static int piece_at(const aoi_adaptive *run, const aoi_contact_state *of, double indentation, double rate)
{
    const aoi_adaptive_contact *contact = &run->contact[of->contact];
    const double off = run->rtol * contact->scales.indentation;
    double low, high;
    if (contact->is_closed && contact->closed.piece != AOI_SLACK && indentation >= contact->closed.low - off &&
        indentation <= contact->closed.high + off) {
        return contact->closed.piece;
    }
    return aoi_law_piece(of->law, of->memory, indentation, rate > 0.0, &low, &high);
}

/* Sets `value` to the force and slopes of a law, where a negative force is not replaced by zero. */
static void uncut_force(const aoi_adaptive *run, const aoi_contact_state *of, double indentation, double rate,
                        aoi_law_value *value)
{
    aoi_law_force(of->law, of->memory, piece_at(run, of, indentation, rate), indentation, rate, value);
}

/* Returns a contact's indentation at the start of a run, m, without the deflection of residual compliances under
 * loads. */
static double placed(const aoi_adaptive *run, size_t c)
{
    const aoi_contact *of = &run->system->contact[c];
    double load, slope, indentation = aoi_contact_free(run, c, &slope);
    for (int side = 0; side < 2; side++) {
        const aoi_modes *body = &run->system->body[of->body[side]];
        for (size_t q = 0; body->residual && q < body->ports; q++) {
            aoi_modes_load(body, q, run->time, &load, &slope);
            indentation -= (side == 0 ? 1.0 : -1.0) * load *
                           body->residual[of->port[side] * body->ports + q];
        }
    }
    return indentation;
}

/* Returns the relaxation time of a contact's dashpot, damping times residual compliance, s; 0 if the bodies do not
 * touch. */
static double relaxation_of(const aoi_adaptive *run, const aoi_contact_state *of)
{
    const size_t c = of->contact;
    aoi_law_value value;
    uncut_force(run, of, of->indentation, 0.0, &value);
    return run->contact[c].closed.start < of->indentation ? 0.0 : value.damping * aoi_system_residual(run->system, c, c);
}

int aoi_balance_at_start(aoi_adaptive *run)
{
    double time = run->rested ? 0.0 : SUDDEN * (run->end - run->time);
    size_t count = 0;
    for (size_t c = 0; c < run->system->contact_count; c++) {
        run->contact[c].closed.start = placed(run, c);
        count = list(run, c, count);
    }
    if (count == 0) {
        return AOI_OK;
    }
    for (size_t i = 0; i < count && !run->rested; i++) {
        time = fmax(time, relaxation_of(run, &run->balanced[i]) / RIGID);
    }
    aoi_coupled e = lay_out(run, count);
    set_equations(run, time, &e);
    const int status = aoi_coupled_solve(&e, run->balanced);
    for (size_t i = 0; i < count && status == AOI_OK; i++) {
        run->contact[run->balanced[i].contact].closed.start = e.indentation[i];
        run->contact[run->balanced[i].contact].closed.force = e.force[i];
        run->contact[run->balanced[i].contact].massless.bending = e.force[i];
    }
    return status;
}

/* Returns an estimate of the contact time, s: the ratio of the largest indentation to the largest present rate. */
static double time_of_contacts(const aoi_adaptive *run, size_t count)
{
    const double left = fmin(run->end - aoi_run_now(run), MOST_STEPS * aoi_run_step(run));
    double depth = 0.0, rate = 0.0;
    for (size_t i = 0; i < count; i++) {
        const aoi_adaptive_contact *contact = &run->contact[run->balanced[i].contact];
        depth = fmax(depth, contact->scales.indentation);
        rate = fmax(rate, fabs(contact->closed.begins ? contact->closed.touch_rate : contact->closed.rate));
    }
    return depth > 0.0 && depth < rate * left ? depth / rate : left;
}

/* Returns the force, with a negative value replaced by zero unless the law has adhesion (pulls). */
static double cut(const aoi_law *law, double force) { return law->pulls ? force : fmax(force, 0.0); }

/* Returns a contact's force after an implicit step of length `time`, s, linearised in its rate: `force` is the
 * force at the rate that constant contact forces would give, `damping` the derivative with respect to the rate.
 * after = 1: indentations are those at the step's end, and `acts` says which contacts have a force. after = 0:
 * indentations are those at the step's start; the force of a rate-dependent law without adhesion is then zero
 * where it would be negative, and where the step has located the event at which it became zero. */
static aoi_law_value linear_force(const aoi_adaptive *run, const aoi_coupled *e, size_t i, double time, int after)
{
    const aoi_contact_state *of = &run->balanced[i];
    const double own = e->compliance[i * (2 * e->band + 1) + e->band];
    /* damping above which the indentation stays constant in the step */
    const double enough = RIGID_IN_STEP * time / own;
    aoi_law_value still, value;
    uncut_force(run, of, e->indentation[i], 0.0, &still);
    uncut_force(run, of, e->indentation[i], e->rate[i], &value);
    if (after && of->acts && value.damping > enough) {
        return (aoi_law_value){e->force[i] + enough * e->rate_free[i], 0.0, enough};
    }
    const double by_place = time * fmax(still.stiffness, 0.0), damping = fmax(value.damping, 0.0);
    const double growth = after ? 0.0 : by_place * e->rate_free[i];
    const double force = value.force + damping * (e->rate_free[i] - e->rate[i]) + growth;
    const int cuts = of->law->depends_on_rate && !of->law->pulls;
    const int has_let_go = run->contact[of->contact].event == AOI_EVENT_SLACKEN;
    if (after ? !of->acts : cuts && (has_let_go || !(value.force + by_place * e->rate[i] > 0.0))) {
        return (aoi_law_value){0.0, 0.0, 0.0};
    }
    return (aoi_law_value){force, 0.0, damping + by_place};
}

/* Sets the equations for the changes of the forces in a short time, (1 + W C / time) change = force - present
 * force, with the force and the damping W from linear_force and the residual compliances C. */
static void set_changes(const aoi_adaptive *run, double time, int after, const aoi_coupled *e, double *change)
{
    const size_t width = 2 * e->band + 1;
    for (size_t i = 0; i < e->count; i++) {
        const aoi_law_value value = linear_force(run, e, i, time, after);
        for (size_t k = 0; k < width; k++) {
            e->rate_compliance[i * width + k] = value.damping * e->compliance[i * width + k] / time;
        }
        e->rate_compliance[i * width + e->band] += 1.0;
        change[i] = value.force - e->force[i];
    }
}

/* Makes one iteration of Newton's method: solves for the changes of the forces, and updates the rates. most: set
 * to the largest change of a rate minus its rounding error, m/s. Returns the largest rate, m/s; NaN if there is no
 * solution. */
static double change_rates(const aoi_adaptive *run, double time, int after, const aoi_coupled *e, double *change,
                           double *most)
{
    double largest = 0.0;
    set_changes(run, time, after, e, change);
    *most = 0.0;
    if (!aoi_band_factorise(e->count, e->band, e->rate_compliance)) {
        return (double)NAN;
    }
    aoi_band_substitute(e->count, e->band, e->rate_compliance, change);
    for (size_t i = 0; i < e->count; i++) {
        const double *row = e->compliance + i * (2 * e->band + 1);
        double sum = 0.0, size = 0.0;
        for (size_t k = 0; k <= 2 * e->band; k++) {
            const size_t j = i + k - e->band; /* a negative index wraps round to a large one, which is no column */
            sum += j < e->count ? row[k] * change[j] : 0.0;
            size += j < e->count ? fabs(row[k] * change[j]) : 0.0;
        }
        const double rate = e->rate_free[i] - sum / time;
        *most = fmax(*most, fabs(rate - e->rate[i]) - AOI_COUPLED_ROUNDING * size / time);
        largest = fmax(largest, fmax(fabs(rate), fabs(e->rate_free[i])));
        e->rate[i] = rate;
    }
    return largest;
}

/* Sets the indentations under the present contact forces, and the rates that hold while these forces are constant. */
static void set_motion(const aoi_adaptive *run, const aoi_coupled *e)
{
    const size_t width = 2 * e->band + 1;
    for (size_t i = 0; i < e->count; i++) {
        e->indentation[i] = aoi_contact_free(run, run->balanced[i].contact, &e->rate_free[i]);
        for (size_t k = 0; k < width; k++) {
            const size_t j = i + k - e->band; /* a negative index wraps round to a large one, which is no column */
            e->indentation[i] -= j < e->count ? e->compliance[i * width + k] * e->force[j] : 0.0;
        }
    }
}

/* Finds the forces in equilibrium and the indentations under them, by Newton's method. More than two iterations
 * are needed where the residual compliance is far above the compliance of the contacts: a force that ends within
 * the tolerance of events then changes the other indentations by more than their size. Indentations at dashpots
 * stay unchanged. Laws that do not depend on the rate are continued below the touch, which is known only within a
 * tolerance. Returns 1, or 0 if no forces are found. */
static int find_places(const aoi_adaptive *run, double time, const aoi_coupled *e)
{
    double *change = e->free, largest = 0.0, most, changed = HUGE_VAL, force = 0.0;
    for (int k = 0; k < MOST_LOOPS && isfinite(largest) && changed > AOI_RATE_ERROR * force; k++) {
        set_motion(run, e);
        for (size_t i = 0; i < e->count; i++) {
            e->rate_free[i] += (e->indentation[i] - run->balanced[i].indentation) / time;
            e->rate[i] = e->rate_free[i];
        }
        largest = change_rates(run, time, 1, e, change, &most);
        changed = force = 0.0;
        for (size_t i = 0; i < e->count; i++) {
            e->force[i] += change[i];
            changed = fmax(changed, fabs(change[i]));
            force = fmax(force, fabs(e->force[i]));
        }
    }
    set_motion(run, e);
    return isfinite(largest);
}

/* Finds the rates a short time after a sudden change by Newton's method, from the indentations and forces just
 * after the change. Returns the largest rate, m/s; NaN if the method does not converge. */
static double rates_after(const aoi_adaptive *run, double time, const aoi_coupled *e)
{
    double largest = 0.0, most = HUGE_VAL;
    for (int i = 0; i < MOST_LOOPS && !isnan(largest) && !(most <= AOI_RATE_ERROR * largest); i++) {
        largest = change_rates(run, time, 0, e, e->free, &most);
    }
    return most <= AOI_RATE_ERROR * largest ? largest : (double)NAN;
}

/* Finds rates and forces just after a sudden change, extrapolated from their values after a short time and after
 * twice that time. For a strong dashpot, the extrapolated force is more accurate than the force at the
 * extrapolated rate. Returns the largest rate, m/s. */
static double find_rates(const aoi_adaptive *run, double time, const aoi_coupled *e)
{
    const double *change = e->free;
    double largest = 0.0;
    for (int k = 2; k > 0 && !isnan(largest); k--) {
        largest = rates_after(run, k * time, e);
        for (size_t i = 0; i < e->count; i++) {
            aoi_contact_state *of = &run->balanced[i];
            const double force = e->force[i] + change[i];
            of->rate = k == 2 ? e->rate[i] : 2.0 * e->rate[i] - of->rate;
            of->force = k == 2 ? force : 2.0 * force - of->force;
        }
    }
    return largest;
}

static double least_jump(const aoi_adaptive *run, size_t count)
{
    double largest = run->force_scale;
    for (size_t i = 0; i < count; i++) {
        largest = fmax(largest, run->contact[run->balanced[i].contact].ledger.peak.force);
    }
    /* Least jump of a force that closes or opens a contact, as a multiple of rtol times the largest force: a
     * smaller jump is an error of the last step, in which events are located only within a tolerance. Measured and
     * tried: from 3 to 30 no run changes. */
    return 10.0 * run->rtol * largest;
}

/* True if a contact becomes slack at a sudden change, because its law depends on the rate, has no adhesion, and
 * gives a negative force. */
static int becomes_slack(const aoi_adaptive_contact *contact, const aoi_law *law, double force, double least)
{
    return contact->closed.piece != AOI_SLACK && !contact->closed.begins && law->depends_on_rate && !law->pulls &&
           force < -least;
}

/* True if a contact that has just touched separates at once because other contacts move its massless contact
 * point. A touch that the step has located stays closed, since its bodies approach each other. */
static int is_separated(const aoi_adaptive *run, const aoi_contact_state *from, double least, double error)
{
    const aoi_adaptive_contact *contact = &run->contact[from->contact];
    return contact->closed.begins && contact->event != AOI_EVENT_TOUCH &&
           contact->closed.start <= aoi_law_rest(from->law, contact->memory) && from->force <= least &&
           from->rate < -error;
}

/* Handles a change of the rate's sign at a sudden change. If the step has located this change (AOI_EVENT_TURN),
 * the rate must not become positive again; if the rate has become negative only now, the contact moves to the
 * unloading piece of its law. */
static void turn(const aoi_law *law, double before, aoi_adaptive_contact *contact)
{
    if (contact->event == AOI_EVENT_TURN) {
        contact->closed.rate = fmin(contact->closed.rate, 0.0);
    } else if (before > 0.0 && contact->closed.rate < 0.0) {
        aoi_contact_take_piece(law, contact, contact->closed.start, 0);
        contact->closed.last_length = 0.0;
    }
}

/* Sets a contact's rate, piece and force after a sudden change. */
static void set_contact(aoi_adaptive *run, const aoi_contact_state *from, double least)
{
    aoi_adaptive_contact *contact = &run->contact[from->contact];
    const aoi_law *law = from->law;
    const double before = contact->closed.rate;
    contact->closed.rate = from->rate;
    if (law->turns && contact->closed.piece != AOI_SLACK) {
        turn(law, before, contact);
    }
    if (contact->closed.piece != AOI_SLACK &&
        piece_at(run, from, contact->closed.start, from->rate) != contact->closed.piece) {
        aoi_contact_take_piece(law, contact, contact->closed.start, from->rate > 0.0);
        contact->closed.last_length = 0.0;
    }
    /* An event that the step has located is kept: the step's rates are more accurate than those found here. */
    const int found = contact->event == AOI_EVENT_SLACKEN || contact->event == AOI_EVENT_TIGHTEN;
    if (!found && contact->closed.piece == AOI_SLACK && from->force > least) {
        aoi_contact_press_again(law, contact);
    } else if (!found && becomes_slack(contact, law, from->force, least)) {
        contact->closed.piece = AOI_SLACK;
    }
    contact->closed.force = contact->closed.piece != AOI_SLACK ? cut(law, from->force) : 0.0;
}

/* Opens a contact and adds it to the watched contacts. */
static void open_and_watch(aoi_adaptive *run, size_t c)
{
    aoi_contact_open(run, c);
    aoi_watch_add(run, c);
}

/* Sets the forces in equilibrium after a pull-off, opens the contacts that the massless contact point has left,
 * and closes those that it has reached. Rates are found later, when all closed contacts are listed. */
static void meet(aoi_adaptive *run, const aoi_coupled *e)
{
    for (size_t i = 0; i < e->count; i++) {
        run->contact[run->balanced[i].contact].massless.bending = run->balanced[i].acts ? e->force[i] : 0.0;
    }
    for (size_t i = 0; i < e->count; i++) {
        const aoi_contact_state *of = &run->balanced[i];
        const size_t c = of->contact;
        aoi_adaptive_contact *contact = &run->contact[c];
        const double tolerance = aoi_event_tolerance(run, contact->scales.indentation);
        contact->closed.start = aoi_contact_place(run, c);
        const int acts = of->acts;
        const int touches = contact->closed.start >= aoi_law_rest(of->law, of->memory) - tolerance;
        if (contact->is_closed && !touches && !acts) {
            open_and_watch(run, c);
        } else if (contact->is_closed && contact->closed.piece == AOI_SLACK && acts) {
            aoi_contact_press_again(of->law, contact); /* treated as an open contact that closes */
        } else if (!contact->is_closed && acts) {
            aoi_contact_close(run, c);
        } else if (!contact->is_closed) {
            contact->massless.bending = 0.0;
        }
    }
}

/* Lists the closed contacts and, after a pull-off, the step's open contacts, which the contact point that jumps
 * back may reach. Returns their number. */
static size_t list_all(aoi_adaptive *run, int pull_off)
{
    size_t count = 0;
    for (size_t i = 0; i < run->closed.count && !pull_off; i++) {
        count = list(run, run->closed.at[i], count);
    }
    for (size_t c = 0; c < run->system->contact_count && pull_off; c++) {
        const aoi_adaptive_contact *contact = &run->contact[c];
        if (contact->is_closed || (!aoi_watch_has(run, c) && contact->event != AOI_EVENT_OPEN)) {
            count = list(run, c, count);
        }
    }
    return count;
}

/* Sets the forces on residual compliances, and the indentations including the deflection under these forces. */
static void set_forces(aoi_adaptive *run, const aoi_coupled *e)
{
    for (size_t i = 0; i < e->count; i++) {
        run->contact[run->balanced[i].contact].massless.bending = e->force[i];
    }
    for (size_t i = 0; i < e->count; i++) {
        const size_t c = run->balanced[i].contact;
        run->contact[c].closed.start = aoi_contact_place(run, c);
    }
}

/* Returns force and slopes of a contact's law just after a sudden change; zero for a contact without force. */
static aoi_law_value acting(const aoi_adaptive *run, const aoi_coupled *e, size_t i)
{
    aoi_law_value value = {0.0, 0.0, 0.0};
    if (run->balanced[i].acts) {
        uncut_force(run, &run->balanced[i], e->indentation[i], e->rate[i], &value);
    }
    return value;
}

/* Returns the step length for the rates after a sudden change, s: short compared with the contact time, and with
 * the longest relaxation time of a dashpot in parallel with the springs of all contacts. */
static double time_after(const aoi_adaptive *run, double time, const aoi_coupled *e)
{
    double stiffness = 0.0, relaxation = 0.0;
    for (size_t i = 0; i < e->count; i++) {
        stiffness += fmax(acting(run, e, i).stiffness, 0.0);
    }
    for (size_t i = 0; i < e->count; i++) {
        const double own = e->compliance[i * (2 * e->band + 1) + e->band];
        relaxation = fmax(relaxation, acting(run, e, i).damping * own / (1.0 + stiffness * own));
    }
    return fmin(MOST_AFTER * time, fmax(LEAST_AFTER * time, PART_RELAXED * relaxation));
}

/* Sets rates and states of the listed contacts after a sudden change. If no rates are found, all rates and states
 * stay unchanged, and the next step begins with a poor guess. Returns whether a contact has opened. */
static int set_contacts(aoi_adaptive *run, double time, double least, const aoi_coupled *e)
{
    aoi_contact_state *of = run->balanced;
    int some = 0;
    for (size_t i = 0; i < e->count; i++) {
        e->rate[i] = of[i].rate;
    }
    const double error = AOI_RATE_ERROR * find_rates(run, time_after(run, time, e), e);
    for (size_t i = 0; i < e->count && !isnan(error); i++) {
        aoi_law_value value;
        uncut_force(run, &of[i], e->indentation[i], of[i].rate, &value);
        /* a force that was replaced by zero gets the law's value, which is negative */
        of[i].force = of[i].force != 0.0 ? of[i].force : value.force;
        const double certain = least + value.damping * error;
        if (is_separated(run, &of[i], certain, error)) {
            open_and_watch(run, of[i].contact);
            some = 1;
        } else {
            set_contact(run, &of[i], certain);
        }
    }
    return some;
}

/* Makes one pass of aoi_balance_at_once. Returns whether a contact has opened, after which another pass without
 * this contact is needed. */
static int balance(aoi_adaptive *run, int pull_off)
{
    const size_t count = list_all(run, pull_off);
    if (count == 0) {
        return 0;
    }
    const double time = time_of_contacts(run, count);
    const double length = pull_off ? aoi_event_tolerance(run, time) : SUDDEN * time;
    aoi_coupled e = lay_out(run, count);
    set_equations(run, length, &e);
    if (pull_off && aoi_coupled_solve(&e, run->balanced) != AOI_OK) {
        return 0;
    }
    for (size_t i = 0; i < count; i++) {
        const aoi_adaptive_contact *contact = &run->contact[run->balanced[i].contact];
        const int acts = pull_off ? e.force[i] != 0.0 : contact->closed.piece != AOI_SLACK;
        run->balanced[i].acts = acts;
        e.force[i] = pull_off ? e.force[i] : contact->massless.bending;
    }
    if (!find_places(run, length, &e)) {
        return 0;
    }
    if (pull_off) {
        meet(run, &e);
        return 0;
    }
    set_forces(run, &e);
    return set_contacts(run, time, least_jump(run, count), &e);
}

void aoi_balance_at_once(aoi_adaptive *run, int pull_off)
{
    while (balance(run, pull_off)) { /* each pass has fewer closed contacts */
    }
}

double aoi_balance_book(aoi_adaptive *run, double sign)
{
    double stored = 0.0;
    for (size_t i = 0; i < run->closed.count; i++) {
        const size_t c = run->closed.at[i];
        aoi_adaptive_contact *contact = &run->contact[c];
        if (aoi_contact_has_residual(run, c)) {
            const double elastic =
                aoi_law_potential(run->system->contact[c].law, contact->memory, contact->closed.start);
            contact->ledger.work += sign * elastic;
            stored += elastic + 0.5 * contact->massless.bending * aoi_contact_bent(run, c, 0);
        }
    }
    return stored;
}
