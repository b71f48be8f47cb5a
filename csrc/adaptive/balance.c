/* The forces on places without mass balance at every instant. Where a contact begins or ends there, those
 * beside it take up the change at once: rates jump, and with them the forces that depend on rates.
 *
 * With C the residual compliances, F the forces and z the indentations without them, d = z - C F. What the
 * forces hold is the state there: d stays as it is in an event where a law depends on the rate, and is
 * where forces balance where none does. The rates follow from the derivative of that, d' = z' - C F', with
 * F' = K d' for a law without rate; dashpots find theirs from the balance itself, F = f(d, d'). */
#include "adaptive/run.h"
#include "adaptive/step.h"
#include "linear/work.h"
#include "law/law.h"
#include "model/coupled.h"
#include "model/system.h"
#include "motion/free.h"
#include "motion/modes.h"
#include "collocation/collocation.h"

#include <float.h>
#include <math.h>

/* Shares of the time that contacts take. What happens at once is an implicit step of the first: places change over it
 * by a thousandth of the least error that a step may make (rtol 1e-10), and rates by rounding / 1e-13, which no place
 * feels. Rates just after follow from steps of the second, whose length is extrapolated to zero: rounding / 1e-7. A
 * dashpot that comes to rest in less counts as none. */
static const double AT_ONCE = 1e-13, SOON = 1e-7;

/* A dashpot so much slower than such a step counts as no faster: its place moves by rounding alone. */
static const double MUCH = 1e13;

/* The error that leaves in rates, as a share of the largest; and Newton's method on them, of laws that are all but
 * linear in rates, has settled. Two steps bring places, which all but balance before, to rounding. */
static const double RATE_ERROR = 1e-8;
enum { MOST_LOOPS = 30, PLACE_LOOPS = 2 };

/* What the force of one contact takes from the indentation of another by the residual compliance, m/N. */
static double compliance_between(const aoi_system *system, size_t c, size_t by)
{
    const aoi_contact *of = &system->contact[c], *from = &system->contact[by];
    double sum = 0.0;
    for (int i = 0; i < 4; i++) {
        const aoi_modes *body = &system->body[of->body[i / 2]];
        if (of->body[i / 2] == from->body[i % 2] && body->residual) {
            const size_t pair = of->port[i / 2] * body->ports + from->port[i % 2];
            sum += (i / 2 == i % 2 ? 1.0 : -1.0) * body->residual[pair];
        }
    }
    return sum;
}

/* In the work space of aoi_collocation_solve, which is larger. */
static aoi_coupled lay_out(const aoi_adaptive *run, size_t count)
{
    aoi_coupled e = {.count = count, .band = run->span < count ? run->span : count - 1};
    const size_t entries = count * (2 * e.band + 1);
    double *work = run->collocation;
    e.compliance = aoi_work_take(&work, entries);
    e.rate_compliance = aoi_work_take(&work, entries);
    e.free = aoi_work_take(&work, count);
    e.rate_free = aoi_work_take(&work, count);
    e.indentation = aoi_work_take(&work, count);
    e.rate = aoi_work_take(&work, count);
    e.force = aoi_work_take(&work, count);
    e.work = work;
    return e;
}

/* The equations of the listed contacts over a time, or at rest where it is zero. */
static void set_equations(const aoi_adaptive *run, double time, aoi_coupled *e)
{
    const size_t width = 2 * e->band + 1;
    for (size_t i = 0; i < e->count; i++) {
        const aoi_contact_state *contact = &run->balanced[i];
        double here, rate, acceleration;
        aoi_free_pair pair;
        aoi_pair_now(run, contact->at[0], &pair);
        aoi_free_pair_indentation(&pair, &here, &rate, &acceleration);
        e->free[i] = here;
        e->rate_free[i] = time > 0.0 ? rate + (here - contact->indentation) / time : 0.0;
        for (size_t k = 0; k < width; k++) {
            const size_t j = i + k - e->band; /* wraps round below the first */
            e->compliance[i * width + k] =
                j < e->count ? compliance_between(run->system, contact->at[0], run->balanced[j].at[0])
                             : 0.0;
            e->rate_compliance[i * width + k] =
                time > 0.0 ? e->compliance[i * width + k] / time : 0.0;
        }
    }
}

/* Lists a contact where a place of its is without mass. */
static size_t list(aoi_adaptive *run, size_t c, size_t count)
{
    const aoi_adaptive_contact *contact = &run->contact[c];
    const aoi_law *law = run->system->contact[c].law;
    if (!(aoi_system_residual(run->system, c) > 0.0)) {
        return count;
    }
    /* On its way to a contact that is open a place meets nothing. */
    const double rest = aoi_law_rest(law, contact->memory);
    const double from = contact->closed ? contact->start : fmax(contact->start, rest);
    run->balanced[count] = (aoi_contact_state){.law = law,
                                         .force = contact->force,
                                         .indentation = from,
                                         .last_indentation = from,
                                         .rate = contact->start_rate};
    run->balanced[count].at[0] = c;
    for (size_t i = 0; i < AOI_LAW_MEMORY; i++) {
        run->balanced[count].memory[i] = contact->memory[i];
    }
    return count + 1;
}

/* An indentation as the bodies were put, before the loads bend what is without mass. */
static double placed(const aoi_adaptive *run, size_t c)
{
    const aoi_contact *of = &run->system->contact[c];
    double indentation, rate, acceleration;
    aoi_free_pair pair;
    aoi_pair_now(run, c, &pair);
    aoi_free_pair_indentation(&pair, &indentation, &rate, &acceleration);
    for (int side = 0; side < 2; side++) {
        const aoi_modes *body = pair.body[side];
        for (size_t q = 0; body->residual && q < body->ports; q++) {
            aoi_modes_load(body, q, run->time, &rate, &acceleration);
            indentation -= (side == 0 ? 1.0 : -1.0) * rate *
                           body->residual[of->port[side] * body->ports + q];
        }
    }
    return indentation;
}

int aoi_balance_at_start(aoi_adaptive *run)
{
    const double time = run->rested ? 0.0 : AT_ONCE * (run->end - run->time);
    size_t count = 0;
    for (size_t c = 0; c < run->system->contact_count; c++) {
        run->contact[c].start = placed(run, c);
        count = list(run, c, count);
    }
    if (count == 0) {
        return AOI_OK;
    }
    aoi_coupled e = lay_out(run, count);
    set_equations(run, time, &e);
    const int status = aoi_coupled_solve(&e, run->balanced);
    for (size_t i = 0; i < count && status == AOI_OK; i++) {
        run->contact[run->balanced[i].at[0]].start = e.indentation[i];
        run->contact[run->balanced[i].at[0]].force = e.force[i];
        run->contact[run->balanced[i].at[0]].bending = e.force[i];
    }
    return status;
}

/* About the time that contacts take. */
static double time_of_contacts(const aoi_adaptive *run, size_t count)
{
    const double left = run->end - aoi_run_now(run);
    double depth = 0.0, rate = 0.0;
    for (size_t i = 0; i < count; i++) {
        const aoi_adaptive_contact *contact = &run->contact[run->balanced[i].at[0]];
        depth = fmax(depth, contact->indentation_scale);
        rate = fmax(rate, contact->rate_scale);
    }
    return depth > 0.0 && depth < rate * left ? depth / rate : left;
}

/* What a law that may not pull is cut to. */
static double cut(const aoi_law *law, double force) { return law->pulls ? force : fmax(force, 0.0); }

/* The piece of the law that a contact is on; that of its place where it is slack, or something has moved it beyond an
 * end by more than events are off. */
static int piece_at(const aoi_adaptive *run, const aoi_contact_state *of, double indentation, double rate)
{
    const aoi_adaptive_contact *contact = &run->contact[of->at[0]];
    const double off = run->rtol * contact->indentation_scale;
    double low, high;
    if (contact->closed && contact->piece != AOI_SLACK && indentation >= contact->low - off &&
        indentation <= contact->high + off) {
        return contact->piece;
    }
    return aoi_law_piece(of->law, of->memory, indentation, rate > 0.0, &low, &high);
}

/* The law's own force, which is not cut. */
static void ask(const aoi_adaptive *run, const aoi_contact_state *of, double indentation, double rate,
                aoi_law_value *value)
{
    aoi_law_force(of->law, of->memory, piece_at(run, of, indentation, rate), indentation, rate, value);
}

/* at[1] of a contact that is listed: whether it presses, or pulls, when places are found. */
enum { IS_SLACK, ACTS };

/* The force of a contact after a time at its bodies' own rate, and in place of the damping what it gains with its rate.
 * over: places are those after it, and roles are given; else those before, and a law that would pull does nothing. */
static aoi_law_value answer(const aoi_adaptive *run, const aoi_coupled *e, size_t i, double time, int over)
{
    const aoi_contact_state *of = &run->balanced[i];
    const double own = e->compliance[i * (2 * e->band + 1) + e->band];
    const double enough = MUCH * time / own; /* of a dashpot to keep the place where it is meanwhile */
    aoi_law_value still, value;
    ask(run, of, e->indentation[i], 0.0, &still);
    ask(run, of, e->indentation[i], e->rate[i], &value);
    if (over && of->at[1] == ACTS && value.damping > enough) {
        return (aoi_law_value){e->force[i] + enough * e->rate_free[i], 0.0, enough};
    }
    const double by_place = time * fmax(still.stiffness, 0.0), damping = fmax(value.damping, 0.0);
    const double way = over ? 0.0 : by_place * e->rate_free[i];
    const double force = value.force + damping * (e->rate_free[i] - e->rate[i]) + way;
    const int cuts = of->law->depends_on_rate && !of->law->pulls;
    if (over ? of->at[1] == IS_SLACK
             : cuts && !(value.force + by_place * e->rate[i] > 0.0)) {
        return (aoi_law_value){0.0, 0.0, 0.0};
    }
    return (aoi_law_value){force, 0.0, damping + by_place};
}

/* The equations of the changes of forces in a short time, (1 + W C / time) change = force - held, with W by answer,
 * as the force is at the rates without changes. */
static void set_changes(const aoi_adaptive *run, double time, int over, const aoi_coupled *e, double *change)
{
    const size_t width = 2 * e->band + 1;
    for (size_t i = 0; i < e->count; i++) {
        const aoi_law_value value = answer(run, e, i, time, over);
        for (size_t k = 0; k < width; k++) {
            e->rate_compliance[i * width + k] = value.damping * e->compliance[i * width + k] / time;
        }
        e->rate_compliance[i * width + e->band] += 1.0;
        change[i] = value.force - e->force[i];
    }
}

/* Rates by the changes of forces, and the largest. Returns the largest change of one. */
static double set_rates(double time, const aoi_coupled *e, const double *change, double *largest)
{
    double most = 0.0;
    *largest = 0.0;
    for (size_t i = 0; i < e->count; i++) {
        const double *row = e->compliance + i * (2 * e->band + 1);
        double sum = 0.0;
        for (size_t k = 0; k <= 2 * e->band; k++) {
            const size_t j = i + k - e->band; /* wraps round below the first */
            sum += j < e->count ? row[k] * change[j] : 0.0;
        }
        const double rate = e->rate_free[i] - sum / time;
        most = fmax(most, fabs(rate - e->rate[i]));
        *largest = fmax(*largest, fmax(fabs(rate), fabs(e->rate_free[i])));
        e->rate[i] = rate;
    }
    return most;
}

/* Places that the forces make, and the rates of the bodies alone. */
static void set_motion(const aoi_adaptive *run, const aoi_coupled *e)
{
    const size_t width = 2 * e->band + 1;
    for (size_t i = 0; i < e->count; i++) {
        double acceleration;
        aoi_free_pair pair;
        aoi_pair_now(run, run->balanced[i].at[0], &pair);
        aoi_free_pair_indentation(&pair, &e->indentation[i], &e->rate_free[i], &acceleration);
        for (size_t k = 0; k < width; k++) {
            const size_t j = i + k - e->band; /* wraps round below the first */
            e->indentation[i] -= j < e->count ? e->compliance[i * width + k] * e->force[j] : 0.0;
        }
    }
}

/* Forces that balance, and places, by Newton's method from some that all but do: what dashpots hold stays where it
 * was, and laws without go on below the touch, which is hit to a tolerance. */
static int find_places(const aoi_adaptive *run, double time, const aoi_coupled *e)
{
    double *change = e->free, largest = 0.0;
    for (int k = 0; k < PLACE_LOOPS && isfinite(largest); k++) {
        set_motion(run, e);
        for (size_t i = 0; i < e->count; i++) {
            e->rate_free[i] += (e->indentation[i] - run->balanced[i].indentation) / time;
            e->rate[i] = e->rate_free[i];
        }
        set_changes(run, time, 1, e, change);
        if (!aoi_coupled_eliminate(e->count, e->band, e->rate_compliance, change)) {
            return 0;
        }
        (void)set_rates(time, e, change, &largest);
        for (size_t i = 0; i < e->count; i++) {
            e->force[i] += change[i];
        }
    }
    set_motion(run, e);
    return isfinite(largest);
}

/* Newton's method on rates a short time after what happens at once, from places and forces then. Returns the
 * largest, m/s; NaN where they are not found. */
static double rates_after(const aoi_adaptive *run, double time, const aoi_coupled *e)
{
    double *change = e->free, largest;
    for (int i = 0; i < MOST_LOOPS; i++) {
        set_changes(run, time, 0, e, change);
        if (!aoi_coupled_eliminate(e->count, e->band, e->rate_compliance, change)) {
            break;
        }
        if (set_rates(time, e, change, &largest) <= RATE_ERROR * largest) {
            return largest;
        }
    }
    return (double)NAN;
}

/* Rates at that time, which dashpots change on the way: by those after once and twice as long. Returns the largest. */
static double find_rates(const aoi_adaptive *run, double time, const aoi_coupled *e)
{
    double largest = 0.0;
    for (int k = 2; k > 0 && !isnan(largest); k--) {
        largest = rates_after(run, k * time, e);
        for (size_t i = 0; i < e->count; i++) {
            run->balanced[i].rate = k == 2 ? e->rate[i] : 2.0 * e->rate[i] - run->balanced[i].rate;
        }
    }
    return largest;
}

/* A force that comes or goes at once does so by more than this, as a share of rtol and of the largest force:
 * less is the error of the step before, in which events have been found. */
static const double COMES = 10.0;

static double comes(const aoi_adaptive *run, size_t count)
{
    double largest = run->force_scale;
    for (size_t i = 0; i < count; i++) {
        largest = fmax(largest, run->contact[run->balanced[i].at[0]].peak_force);
    }
    return COMES * run->rtol * largest;
}

/* Whether a law that may not pull lets go at once. */
static int lets_go(const aoi_adaptive_contact *contact, const aoi_law *law, double force, double least)
{
    return contact->piece != AOI_SLACK && !contact->begins && law->depends_on_rate && !law->pulls &&
           force < -least;
}

/* Whether a contact that has just touched parts again, since others move what has no mass there. One that the step has
 * found comes on, if not at once. */
static int is_drawn_away(const aoi_adaptive *run, const aoi_contact_state *from, double least, double error)
{
    const aoi_adaptive_contact *contact = &run->contact[from->at[0]];
    return contact->begins && contact->event != AOI_EVENT_TOUCH &&
           contact->start <= aoi_law_rest(from->law, contact->memory) && from->force <= least &&
           from->rate < -error;
}

/* A law that remembers has turned, or turns now. */
static void turn(const aoi_law *law, double before, aoi_adaptive_contact *contact)
{
    if (contact->event == AOI_EVENT_TURN) {
        contact->start_rate = fmin(contact->start_rate, 0.0);
    } else if (before > 0.0 && contact->start_rate < 0.0) {
        contact->piece = aoi_law_piece(law, contact->memory, contact->start, 0, &contact->low,
                                       &contact->high);
        contact->last_length = 0.0;
    }
}

/* A contact that had let go presses again. */
static void press_again(const aoi_law *law, double rate, aoi_adaptive_contact *contact)
{
    contact->begins = 1;
    contact->touch_rate = rate;
    contact->last_length = 0.0;
    contact->piece =
        aoi_law_piece(law, contact->memory, contact->start, rate > 0.0, &contact->low, &contact->high);
}

/* What a contact does from now on. */
static void take(aoi_adaptive *run, const aoi_contact_state *from, double least)
{
    aoi_adaptive_contact *contact = &run->contact[from->at[0]];
    const aoi_law *law = from->law;
    const double before = contact->start_rate;
    contact->start_rate = from->rate;
    if (law->turns && contact->piece != AOI_SLACK) {
        turn(law, before, contact);
    }
    if (contact->piece != AOI_SLACK &&
        piece_at(run, from, contact->start, from->rate) != contact->piece) {
        contact->piece = aoi_law_piece(law, contact->memory, contact->start, from->rate > 0.0,
                                       &contact->low, &contact->high);
        contact->last_length = 0.0;
    }
    /* What the step has just found is not undone: it knows more digits. */
    const int found = contact->event == AOI_EVENT_SLACKEN || contact->event == AOI_EVENT_TIGHTEN;
    if (!found && contact->piece == AOI_SLACK && from->force > least) {
        press_again(law, from->rate, contact);
    } else if (!found && lets_go(contact, law, from->force, least)) {
        contact->piece = AOI_SLACK;
    }
    contact->force = contact->piece != AOI_SLACK ? cut(law, from->force) : 0.0;
}

/* A contact opens; whatever was known of its touch no longer holds. */
static void leave(aoi_adaptive *run, size_t c)
{
    aoi_contact_open(run, c);
    run->contact[c].touches = 0;
    run->contact[c].free_until = aoi_run_now(run);
    aoi_watch_add(run, c);
}

/* What snaps back is held by the forces found: it has left contacts behind, and met others. Rates are found when all
 * are listed. */
static void meet(aoi_adaptive *run, const aoi_coupled *e)
{
    for (size_t i = 0; i < e->count; i++) {
        run->contact[run->balanced[i].at[0]].bending = run->balanced[i].at[1] != IS_SLACK ? e->force[i] : 0.0;
    }
    for (size_t i = 0; i < e->count; i++) {
        const aoi_contact_state *of = &run->balanced[i];
        const size_t c = of->at[0];
        aoi_adaptive_contact *contact = &run->contact[c];
        const double tolerance = aoi_event_tolerance(run, contact->indentation_scale);
        contact->start = aoi_contact_place(run, c);
        const int acts = of->at[1] != IS_SLACK;
        const int touches = contact->start >= aoi_law_rest(of->law, of->memory) - tolerance;
        if (contact->closed && !touches && !acts) {
            leave(run, c);
        } else if (contact->closed && contact->piece == AOI_SLACK && acts) {
            press_again(of->law, contact->start_rate, contact); /* what has let go is met as what is open is */
        } else if (!contact->closed && acts) { /* if only as far as bodies come at once */
            aoi_contact_close(run, c);
        } else if (!contact->closed) {
            contact->bending = 0.0;
        }
    }
}

/* Contacts that take part: closed ones; or with those beside them, which a place that snaps back may meet. */
static size_t list_all(aoi_adaptive *run, int snaps)
{
    size_t count = 0;
    for (size_t i = 0; i < run->closed.count && !snaps; i++) {
        count = list(run, run->closed.at[i], count);
    }
    for (size_t c = 0; c < run->system->contact_count && snaps; c++) {
        const aoi_adaptive_contact *contact = &run->contact[c];
        if (contact->closed || (!aoi_watch_has(run, c) && contact->event != AOI_EVENT_OPEN)) {
            count = list(run, c, count);
        }
    }
    return count;
}

/* Forces and what they hold, from now on. */
static void hold(aoi_adaptive *run, const aoi_coupled *e)
{
    for (size_t i = 0; i < e->count; i++) {
        run->contact[run->balanced[i].at[0]].bending = e->force[i];
    }
    for (size_t i = 0; i < e->count; i++) {
        const size_t c = run->balanced[i].at[0];
        run->contact[c].start = aoi_contact_place(run, c);
    }
}

/* Rates at those places, and what contacts do at them; all as it is where no rates are found: then the step begins with
 * a worse guess. Returns whether one has left. */
static int go_on(aoi_adaptive *run, double time, double least, const aoi_coupled *e)
{
    aoi_contact_state *of = run->balanced;
    int some = 0;
    for (size_t i = 0; i < e->count; i++) {
        e->rate[i] = of[i].rate;
    }
    const double error = RATE_ERROR * find_rates(run, time, e);
    for (size_t i = 0; i < e->count && !isnan(error); i++) {
        aoi_law_value value;
        ask(run, &of[i], e->indentation[i], of[i].rate, &value);
        of[i].force = value.force;
        const double certain = least + value.damping * error;
        if (is_drawn_away(run, &of[i], certain, error)) {
            leave(run, of[i].at[0]);
            some = 1;
        } else {
            take(run, &of[i], certain);
        }
    }
    return some;
}

/* Returns whether all is to be done again, without a contact that has left. */
static int balance(aoi_adaptive *run, int snaps)
{
    const size_t count = list_all(run, snaps);
    if (count == 0) {
        return 0;
    }
    const double time = time_of_contacts(run, count);
    const double at_once = snaps ? aoi_event_tolerance(run, time) : AT_ONCE * time;
    aoi_coupled e = lay_out(run, count);
    set_equations(run, at_once, &e);
    if (snaps && aoi_coupled_solve(&e, run->balanced) != AOI_OK) {
        return 0;
    }
    for (size_t i = 0; i < count; i++) {
        const aoi_adaptive_contact *contact = &run->contact[run->balanced[i].at[0]];
        const int acts = snaps ? e.force[i] != 0.0 : contact->piece != AOI_SLACK;
        run->balanced[i].at[1] = acts ? ACTS : IS_SLACK;
        e.force[i] = snaps ? e.force[i] : contact->bending;
    }
    if (!find_places(run, at_once, &e)) {
        return 0;
    }
    if (snaps) {
        meet(run, &e);
        return 0;
    }
    hold(run, &e);
    return go_on(run, SOON * time, comes(run, count), &e);
}

void aoi_balance_at_once(aoi_adaptive *run, int snaps)
{
    while (balance(run, snaps)) { /* fewer each time */
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
                aoi_law_potential(run->system->contact[c].law, contact->memory, contact->start);
            contact->work += sign * elastic;
            stored += elastic + 0.5 * contact->bending * aoi_contact_bent(run, c, 0);
        }
    }
    return stored;
}
