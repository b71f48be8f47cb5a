/* The forces on places without mass balance at every instant. Where a contact begins or ends there, those
 * beside it take up the change at once: rates jump, and with them the forces that depend on rates.
 *
 * Displacements are continuous. What happens at once is one very short implicit step, which is the contact
 * equations of coupled.c: a law of the rate keeps its place meanwhile, one without follows the others. */
#include "adaptive/run.h"
#include "adaptive/step.h"
#include "linear/work.h"
#include "law/law.h"
#include "model/coupled.h"
#include "model/system.h"
#include "motion/free.h"
#include "motion/modes.h"
#include "collocation/collocation.h"

#include <math.h>

/* How short that step is, as a share of the next one of the run: first for indentations, which events leave off
 * by their tolerance, then for rates, which are right to about as many digits. */
static const double AT_ONCE = 1e-14, SOON = 1e-6;

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
        e->free[i] = here + time * rate;
        e->rate_free[i] = time > 0.0 ? (e->free[i] - contact->indentation) / time : 0.0;
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
    if (!(aoi_system_residual(run->system, c) > 0.0)) {
        return count;
    }
    run->balanced[count] = (aoi_contact_state){.law = run->system->contact[c].law,
                                         .force = contact->force,
                                         .indentation = contact->start,
                                         .last_indentation = contact->start,
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

/* A force that comes or goes at once does so by more than this, as a share of rtol and of the largest force:
 * less is the error of the step before, in which events have been found. */
static const double COMES = 10.0;

/* And a rate that parts bodies is more than this share of that at which they met. */
static const double DRAWN = 1e-3;

static double comes(const aoi_adaptive *run, size_t count)
{
    double largest = run->force_scale;
    for (size_t i = 0; i < count; i++) {
        largest = fmax(largest, run->contact[run->balanced[i].at[0]].peak_force);
    }
    return COMES * run->rtol * largest;
}

/* Whether a law that may not pull lets go at once, or its force comes back. */
static int lets_go(const aoi_adaptive_contact *contact, const aoi_law *law, double least)
{
    aoi_law_value value;
    if (contact->piece == AOI_SLACK || contact->begins || !law->depends_on_rate || law->pulls) {
        return 0;
    }
    aoi_law_force(law, contact->memory, contact->piece, contact->start, contact->start_rate, &value);
    return value.force < -least;
}

/* Whether a contact that has just touched parts again, since others move what has no mass there. */
static int is_drawn_away(const aoi_adaptive *run, const aoi_contact_state *from, double least)
{
    const aoi_adaptive_contact *contact = &run->contact[from->at[0]];
    return contact->begins && contact->start <= aoi_law_rest(from->law, contact->memory) &&
           from->force <= least && from->rate < -DRAWN * contact->rate_scale;
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

/* What a contact does from now on. */
static void take(aoi_adaptive *run, const aoi_contact_state *from, double least)
{
    aoi_adaptive_contact *contact = &run->contact[from->at[0]];
    const aoi_law *law = from->law;
    const double before = contact->start_rate;
    aoi_law_value value;
    contact->start = contact->begins && law->depends_on_rate
                         ? fmax(contact->start, aoi_law_rest(law, contact->memory))
                         : from->indentation;
    contact->start_rate = from->rate;
    if (law->turns && contact->piece != AOI_SLACK) {
        turn(law, before, contact);
    }
    if (contact->piece == AOI_SLACK && from->force > least) {
        contact->begins = 1;
        contact->last_length = 0.0;
        contact->piece = aoi_law_piece(law, contact->memory, contact->start, from->rate > 0.0,
                                       &contact->low, &contact->high);
    } else if (lets_go(contact, law, least)) {
        contact->piece = AOI_SLACK;
    }
    contact->force = 0.0;
    if (contact->piece != AOI_SLACK) {
        aoi_law_force(law, contact->memory, contact->piece, contact->start, contact->start_rate, &value);
        contact->force = law->pulls ? value.force : fmax(value.force, 0.0);
    }
    aoi_contact_note_peak(run, from->at[0]);
}

/* One such step of all that are listed: from their indentations. Rates by those, since a rate that follows from
 * forces is a small difference of large ones. */
static int step(const aoi_adaptive *run, double time, aoi_coupled *e)
{
    set_equations(run, time, e);
    const int status = aoi_coupled_solve(e, run->balanced);
    for (size_t i = 0; i < e->count && status == AOI_OK; i++) {
        e->rate[i] = (e->indentation[i] - run->balanced[i].indentation) / time;
    }
    if (e->count == 1 && e->force[0] != 0.0 && run->balanced[0].law->depends_on_rate) {
        e->force[0] = (e->free[0] - e->indentation[0]) / e->compliance[0];
    }
    return status;
}

void aoi_balance_at_once(aoi_adaptive *run, double within)
{
    aoi_contact_state *of = run->balanced;
    size_t count = 0;
    for (size_t i = 0; i < run->closed.count; i++) {
        count = list(run, run->closed.at[i], count);
    }
    if (count == 0) {
        return;
    }
    aoi_coupled e = lay_out(run, count);
    if (step(run, AT_ONCE * within, &e) != AOI_OK) {
        return; /* the step itself begins with a worse guess */
    }
    for (size_t i = 0; i < count; i++) {
        of[i].indentation = e.indentation[i];
        run->contact[of[i].at[0]].bending = e.force[i];
    }
    for (int k = 2; k > 0; k--) { /* over twice the time, then once: what is at its start by extrapolation */
        if (step(run, k * SOON * within, &e) != AOI_OK) {
            return;
        }
        for (size_t i = 0; i < count; i++) {
            of[i].force = k == 2 ? e.force[i] : 2.0 * e.force[i] - of[i].force;
            of[i].rate = k == 2 ? e.rate[i] : 2.0 * e.rate[i] - of[i].rate;
        }
    }
    const double least = comes(run, count);
    for (size_t i = 0; i < count; i++) {
        if (is_drawn_away(run, &of[i], least)) {
            aoi_contact_open(run, of[i].at[0]);
            aoi_watch_add(run, of[i].at[0]);
        } else {
            take(run, &of[i], least);
        }
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
