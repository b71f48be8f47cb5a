/* The end of an accepted step: states of bodies and contacts, peaks, and the events there. */
#include "adaptive/row.h"
#include "adaptive/run.h"
#include "adaptive/step.h"
#include "law/law.h"
#include "motion/energy.h"
#include "motion/polynomial.h"
#include "motion/radau.h"
#include "motion/response.h"
#include "motion/nodes.h"
#include "collocation/collocation.h"

#include <math.h>
#include <string.h>

/* Returns the position of the largest maximum of the force in the step (0 to 1); 1 if there is none inside. For an
 * elastic law it is the position of the largest indentation, for a rate-dependent law the position of the maximum
 * of the polynomial through the forces at the nodes. In a step with an edge, its own force polynomial, a
 * least-squares fit, is not used: it may differ from the forces at the nodes by 1 %. */
static double top_of(const aoi_law *law, const aoi_contact_step *entry)
{
    double place, value, by_force[AOI_NODES];
    const double *force = entry->force;
    aoi_law_values at_nodes;
    if (!law->depends_on_rate) {
        return aoi_legendre_top(AOI_NODES + 1, entry->legendre, &place, &value) ? place : 1.0;
    }
    if (entry->edge != AOI_EDGE_NONE) {
        aoi_law_forces(law, entry->memory, entry->piece, entry->indentation, entry->rate, &at_nodes);
        force = at_nodes.force;
    }
    aoi_nodes_to_legendre(force, by_force);
    return aoi_legendre_top(AOI_NODES, by_force, &place, &value) ? place : 1.0;
}

/* Updates the peak of the normal force of a contact with friction. The peak is found from the contact's row, since
 * friction changes the normal force a little. */
static void note_rubbing_peak(aoi_adaptive *run, const aoi_contact_step *entry, double h, const double *of)
{
    double place, value, force[3], bent;
    if (aoi_legendre_top(AOI_NODES + 1, entry->legendre, &place, &value)) {
        aoi_row_rub(&run->system->contact[entry->contact], of, place, force, &bent);
        aoi_contact_note_peak(run, entry->contact, force[0], place * h);
    }
    aoi_contact_note_peak(run, entry->contact, aoi_sliding_force(entry->sliding, 0), h);
}

static void note_peak(aoi_adaptive *run, const aoi_contact_step *entry, double h)
{
    const aoi_law *law = aoi_step_law(run, entry);
    double by_rate[AOI_NODES + 1], slope, rate = 0.0;
    aoi_law_value value;
    if (!aoi_step_may_peak(&run->contact[entry->contact], entry)) {
        return;
    }
    const double place = top_of(law, entry);
    if (law->depends_on_rate) {
        /* the slope of the indentation's series would lose digits */
        aoi_legendre_fit(entry->start_rate, entry->rate, by_rate);
        rate = aoi_legendre_evaluate(AOI_NODES + 1, by_rate, place, &slope);
    }
    if (place < 1.0) {
        const double indentation = aoi_legendre_evaluate(AOI_NODES + 1, entry->legendre, place, &slope);
        aoi_law_force(law, entry->memory, entry->piece, indentation, rate, &value);
        aoi_contact_note_peak(run, entry->contact, value.force, place * h);
    }
    aoi_step_law_at_end(law, entry, &value);
    aoi_contact_note_peak(run, entry->contact, value.force, h);
}

/* Advances a body with contact forces to the end of the step. */
static void move_body(aoi_adaptive *run, size_t b, double h)
{
    const aoi_modes *body = &run->system->body[b];
    const double *force = run->port_force + run->system->first_port[b] * AOI_NODES;
    double *x = run->x + run->system->first[b], *v = run->v + run->system->first[b];
    const double now = aoi_run_now(run);
    double *before = run->free_state[0], work, dissipated;
    const int booked = aoi_body_has_ledger(body);
    if (booked) {
        aoi_body_copy(run, b, before);
    }
    aoi_response_propagate(&run->response[b], body, now, force, x, v);
    if (booked) {
        aoi_modes_step_work(body, now, h, 1.0, force, before, before + body->n, x, &work, &dissipated);
        run->body[b].work += work;
        run->body[b].dissipated += dissipated;
    }
}

static void move_bodies(aoi_adaptive *run, double h, double later)
{
    for (size_t i = 0; i < run->engaged.count; i++) {
        const size_t b = run->engaged.at[i];
        if (run->body[b].engaged == AOI_UNDER_FORCE) {
            move_body(run, b, h);
            run->body[b].time = later;
            aoi_body_note_change(run, b);
        }
    }
}

/* Returns the largest indentation at the start and the nodes, m; if the law has a limit, also the largest between
 * the nodes. */
static double deepest(const aoi_law *law, const aoi_contact_step *entry)
{
    const double at_nodes = aoi_step_indentation(entry);
    double place, value;
    const int between = law->limit < HUGE_VAL &&
                        aoi_legendre_top(AOI_NODES + 1, entry->legendre, &place, &value);
    return between ? fmax(at_nodes, value) : at_nodes;
}

/* True if the law is valid at all nodes at which there is a force (aoi_law_stands). */
static int stands(const aoi_law *law, const aoi_contact_step *entry)
{
    int all = 1;
    for (size_t i = 0; i < AOI_NODES && law->compliance > 0.0 && law->depends_on_rate && all; i++) {
        all = entry->force[i] <= 0.0 ||
              aoi_law_stands(law, entry->memory, entry->indentation[i], entry->rate[i]);
    }
    return all;
}

/* Returns the force of a contact at the end of a step, N. In a step with an edge it is the law's force, since the
 * force polynomial is a least-squares fit. */
static double force_at_end(const aoi_law *law, const aoi_contact_step *entry)
{
    aoi_law_value value;
    if (entry->edge == AOI_EDGE_NONE) {
        return entry->force[AOI_NODES - 1];
    }
    aoi_step_law_at_end(law, entry, &value);
    return value.force;
}

/* Returns the slope of a Legendre series at the end of a step of unit length, where the slope of the shifted P_k
 * is k (k + 1). */
static double end_slope(const double *legendre)
{
    double sum = 0.0;
    for (size_t k = 1; k <= AOI_NODES; k++) {
        sum += (double)(k * (k + 1)) * legendre[k];
    }
    return sum;
}

static double force_slope(const aoi_contact_step *entry)
{
    double legendre[AOI_NODES + 1] = {0.0};
    aoi_nodes_to_legendre(entry->force, legendre);
    return end_slope(legendre);
}

/* Updates a contact's peak, impulse, work and scales, and sets its state to that at the end of the step. of: the
 * contact's values in the row. */
static int move_contact(aoi_adaptive *run, const aoi_contact_step *entry, double h, int with_rates, const double *of)
{
    aoi_adaptive_contact *contact = &run->contact[entry->contact];
    const aoi_law *law = aoi_step_law(run, entry);
    const double largest = deepest(law, entry);
    const int end = AOI_NODES - 1;
    if (largest > law->limit || !stands(law, entry)) {
        run->failed = entry->contact;
        return AOI_ERROR_PATCH;
    }
    if (entry->piece != AOI_SLACK) {
        if (entry->sliding) {
            note_rubbing_peak(run, entry, h, of);
        } else {
            note_peak(run, entry, h);
        }
        const double impulse = aoi_collocation_impulse(entry, h);
        contact->ledger.peak.impulse += impulse;
        contact->ledger.since_touch += impulse;
        contact->ledger.work += aoi_collocation_work(entry->legendre, entry->force, 1.0);
    }
    contact->scales.impulse = fmax(contact->scales.impulse, contact->ledger.since_touch);
    contact->scales.indentation = fmax(contact->scales.indentation, largest);
    memcpy(contact->closed.last, entry->legendre, sizeof contact->closed.last);
    contact->closed.last_length = h;
    contact->closed.begins = 0;
    contact->closed.start = entry->indentation[end];
    contact->closed.rate = entry->rate[end];
    if (!with_rates) {
        contact->closed.rate = end_slope(entry->legendre) / h;
    }
    contact->closed.force = entry->sliding ? aoi_sliding_force(entry->sliding, 0) : force_at_end(law, entry);
    if (aoi_contact_has_residual(run, entry->contact)) {
        contact->massless.bending = entry->force[end];
        contact->massless.force_rate = force_slope(entry) / h;
    }
    contact->scales.rate = fmax(contact->scales.rate, fabs(contact->closed.rate));
    if (entry->piece != AOI_SLACK) {
        aoi_law_remember(law, contact->closed.start, contact->closed.rate, contact->memory);
    }
    return AOI_OK;
}

/* Sets the piece of the law on which a closed contact continues, and the contact's force on that piece. */
static void take_piece(const aoi_law *law, aoi_adaptive_contact *contact, double indentation, int rising)
{
    aoi_law_value value;
    aoi_contact_take_piece(law, contact, indentation, rising);
    aoi_law_force(law, contact->memory, contact->closed.piece, contact->closed.start, contact->closed.rate, &value);
    contact->closed.force = value.force;
}

static void apply_event(aoi_adaptive *run, size_t c)
{
    aoi_adaptive_contact *contact = &run->contact[c];
    const aoi_law *law = run->system->contact[c].law;
    run->unbalanced |= contact->event != AOI_EVENT_NONE;
    switch (contact->event) {
    case AOI_EVENT_OPEN:
        aoi_contact_open(run, c);
        break;
    case AOI_EVENT_SLACKEN:
        contact->closed.piece = AOI_SLACK;
        contact->closed.force = contact->massless.bending = contact->massless.force_rate = 0.0;
        break;
    case AOI_EVENT_TIGHTEN:
        aoi_contact_press_again(law, contact);
        take_piece(law, contact, contact->closed.start, contact->closed.rate > 0.0);
        break;
    case AOI_EVENT_TURN:
        contact->closed.rate = fmin(contact->closed.rate, 0.0); /* otherwise the same event would occur again    */
        take_piece(law, contact, contact->closed.start, 0);
        contact->closed.last_length = 0.0;
        break;
    case AOI_EVENT_ABOVE:
        take_piece(law, contact, fmax(contact->closed.high, contact->closed.start), 1);
        break;
    case AOI_EVENT_BELOW:
        take_piece(law, contact, contact->closed.low, 0);
        break;
    default:
        break;
    }
}

/* True if an event at the start of a step only reflects the error of the step's polynomial: the contact opens just
 * after it has closed, or leaves its piece at an end from which it moves away. */
static int goes_back(const aoi_adaptive_contact *contact)
{
    return (contact->event == AOI_EVENT_OPEN && contact->closed.begins && contact->event_place > 0.0) ||
           (contact->event == AOI_EVENT_ABOVE && contact->closed.rate < 0.0) ||
           (contact->event == AOI_EVENT_BELOW && contact->closed.rate > 0.0);
}

int aoi_step_at_start(aoi_adaptive *run, double place)
{
    int some = 0;
    for (size_t s = 0; s < run->closed_count; s++) {
        aoi_adaptive_contact *contact = &run->contact[run->entry[s].contact];
        if (run->entry[s].axis > 0) {
            continue;
        }
        if (contact->event_place > place) {
            contact->event = AOI_EVENT_NONE; /* the event comes later in the step */
            continue;
        }
        if (goes_back(contact)) {
            return 0;
        }
        apply_event(run, run->entry[s].contact);
        some = 1;
    }
    return some;
}

/* Advances the time by compensated (Kahan) summation, since the rounding errors of many equal steps would add up. */
static void pass_time(aoi_adaptive *run, double h)
{
    const double step = h + run->left_off, elapsed = run->elapsed + step;
    run->left_off = step - (elapsed - run->elapsed);
    run->elapsed = elapsed;
}

/* Returns the index of the first entry with a pull-off up to a position in the step: an adhesive contact at a
 * massless contact point ends under tension, and the point jumps back. closed_count is returned if there is none. */
static size_t pull_off_entry(const aoi_adaptive *run, double place)
{
    size_t s = 0;
    for (; s < run->closed_count; s++) {
        const size_t c = run->entry[s].contact;
        const aoi_adaptive_contact *contact = &run->contact[c];
        if (run->system->contact[c].law->pulls && contact->event == AOI_EVENT_OPEN &&
            contact->event_place <= place && !contact->closed.begins && contact->closed.force < 0.0 &&
            aoi_contact_has_residual(run, c)) {
            break;
        }
    }
    return s;
}

int aoi_step_pulls_off(const aoi_adaptive *run, double place)
{
    return pull_off_entry(run, place) < run->closed_count;
}

/* Applies the events at the end of a step. */
static void apply_events(aoi_adaptive *run)
{
    run->indentation_scale = run->impulse_scale = 0.0;
    for (size_t s = 0; s < run->entry_count; s++) {
        const size_t c = run->entry[s].contact;
        if (run->entry[s].axis > 0) {
            continue;
        }
        if (run->contact[c].event == AOI_EVENT_TOUCH) {
            aoi_contact_close(run, c);
        } else if (s < run->closed_count) {
            apply_event(run, c);
        }
        run->indentation_scale = fmax(run->indentation_scale, run->contact[c].scales.indentation);
        run->impulse_scale = fmax(run->impulse_scale, run->contact[c].scales.impulse);
    }
}

/* Moves the springs of all contacts with friction to the end of the step. */
static int advance_friction(aoi_adaptive *run)
{
    int status = AOI_OK;
    for (size_t s = 0; s < run->closed_count && status == AOI_OK; s++) {
        if (run->entry[s].sliding && run->entry[s].axis == 0) {
            status = aoi_sliding_advance(run->entry[s].sliding, &run->entry[s]);
            run->failed = status != AOI_OK ? run->entry[s].contact : run->failed;
        }
    }
    return status;
}

int aoi_step_accept(aoi_adaptive *run, const aoi_attempt *attempt, double *row, size_t *size)
{
    const double h = attempt->h, later = run->origin + (run->elapsed + (h + run->left_off));
    const int with_rates = aoi_collocation_wants_rates(run->system, run->closed_count, run->entry);
    int status = aoi_system_rubs(run->system) ? advance_friction(run) : AOI_OK;
    double *of;
    if (status != AOI_OK) {
        return status;
    }
    *size = aoi_step_write(run, h, run->closed_count, row, &of);
    move_bodies(run, h, later);
    for (size_t s = 0; s < run->closed_count; s++) {
        if (run->entry[s].axis == 0) {
            status = move_contact(run, &run->entry[s], h, with_rates, of);
            of += aoi_row_contact_size(&run->system->contact[run->entry[s].contact]);
        }
        if (status != AOI_OK) {
            return status;
        }
    }
    pass_time(run, h);
    run->steps++;
    const size_t s = pull_off_entry(run, 1.0);
    if (s == run->closed_count) {
        apply_events(run);
        return AOI_OK;
    }
    for (size_t k = run->closed_count; k < run->entry_count; k++) {
        const aoi_contact *beside = &run->system->contact[run->entry[k].contact];
        aoi_body_engage(run, beside->body[0], AOI_WATCHED);
        aoi_body_engage(run, beside->body[1], AOI_WATCHED);
        run->contact[run->entry[k].contact].closed.start = aoi_contact_place(run, run->entry[k].contact);
    }
    const double before = aoi_balance_book(run, -1.0);
    apply_events(run);
    aoi_balance_at_once(run, 1);
    const double lost = before - aoi_balance_book(run, 1.0);
    run->contact[run->entry[s].contact].ledger.work += lost;
    row[*size - (run->closed_count - s) * AOI_TRACK_CONTACT_SIZE + AOI_TRACK_LOST] = lost;
    return AOI_OK;
}
