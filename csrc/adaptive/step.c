/* One step of an adaptive run, tried: the motion without contact forces, a first guess, the forces by
 * collocation, and what the other files say of them. */
#include "adaptive/adaptive.h"
#include "adaptive/run.h"
#include "adaptive/step.h"
#include "law/law.h"
#include "motion/flight.h"
#include "motion/polynomial.h"
#include "motion/radau.h"
#include "motion/response.h"
#include "motion/stages.h"
#include "collocation/collocation.h"

#include <math.h>

/* A step ends where a contact lets go if it does so to this share of its length. */
static const double EDGE_WIDTH = 0.1;

/* It begins where it touches if it is no deeper there than this share of how far it could go in it. */
static const double EDGE_DEPTH = 1e-3;

/* Newton's convergence is judged on no smaller indentation than this share of the largest. */
static const double NEWTON_SHARE = 1e-6;

/* Beside another contact at a massless place it has the rounding of that one's. */
static const double SHARED_NEWTON_SHARE = 1e-3;

/* Whether two bodies answer alike: often they are one model. */
static int are_alike(const aoi_modes *one, const aoi_modes *other)
{
    return one->n == other->n && one->ports == other->ports && one->omega == other->omega &&
           one->decay == other->decay && one->shape == other->shape && one->push == other->push;
}

/* The tables of a body for this step: the one not used for longest makes room. */
static void make_response(aoi_adaptive *run, size_t b, double h, int level, int with_rates)
{
    aoi_follower *body = &run->body[b];
    const aoi_modes *modes = &run->system->body[b];
    size_t oldest = 0;
    for (size_t i = 0; i < body->table_count; i++) {
        if (body->table_use[i] > 0 && body->table_level[i] == level && level != AOI_NO_LEVEL &&
            body->table[i].has_rates >= with_rates) {
            body->table_use[i] = ++run->uses;
            run->response[b] = body->table[i];
            return;
        }
        oldest = body->table_use[i] < body->table_use[oldest] ? i : oldest;
    }
    aoi_response_make(&body->table[oldest], modes, h, with_rates,
                      body->block + oldest * aoi_response_size(modes));
    body->table_level[oldest] = level;
    body->table_use[oldest] = ++run->uses;
    run->response[b] = body->table[oldest];
}

/* The indentation at the start has it in it already; the motion without contact forces has not. */
double aoi_contact_bent(const aoi_adaptive *run, size_t joint, int rates)
{
    const aoi_joint *of = &run->system->joint[joint];
    double sum = 0.0;
    for (int side = 0; side < 2; side++) {
        const aoi_modes *body = &run->system->body[of->body[side]];
        const size_t end = body->residual ? run->system->first_joint[of->body[side] + 1] : 0;
        for (size_t i = run->system->first_joint[of->body[side]]; i < end; i++) {
            const size_t joint_by = run->system->joint_of[i];
            const aoi_joint *by = &run->system->joint[joint_by];
            const int other = by->body[1] == of->body[side];
            const double compliance = body->residual[of->port[side] * body->ports + by->port[other]];
            const aoi_contact_state *contact = &run->contact[joint_by];
            sum += (side == other ? 1.0 : -1.0) * compliance *
                   (rates ? contact->force_rate : contact->bending);
        }
    }
    return sum;
}

/* Takes off what the forces that places without mass follow do in the step if they stay as they are. */
static void add_constant_forces(const aoi_adaptive *run, aoi_stage *stage, int with_rates)
{
    const aoi_system *system = run->system;
    const aoi_joint *of = &system->joint[stage->joint];
    for (int side = 0; side < 2; side++) {
        const size_t b = of->body[side], ports = system->body[b].ports;
        for (size_t i = system->first_joint[b]; i < system->first_joint[b + 1]; i++) {
            const aoi_joint *by = &system->joint[system->joint_of[i]];
            const double force = run->contact[system->joint_of[i]].bending;
            const int other = by->body[1] == b;
            const size_t pair = of->port[side] * ports + by->port[other];
            const size_t at = pair * AOI_STAGES * AOI_STAGES;
            for (size_t q = 0; q < AOI_STAGES && force != 0.0; q++) {
                const double sign = side == other ? -force : force;
                const size_t column = at + q * AOI_STAGES;
                aoi_stages_add(sign, run->response[b].influence + column, stage->homogeneous);
                if (with_rates) {
                    aoi_stages_add(sign, run->response[b].influence_rate + column, stage->homogeneous_rate);
                }
            }
        }
    }
}

double aoi_contact_place(const aoi_adaptive *run, size_t joint)
{
    double without_forces, rate, acceleration;
    aoi_flight pair;
    aoi_pair_now(run, joint, &pair);
    aoi_flight_indentation(&pair, &without_forces, &rate, &acceleration);
    return without_forces - aoi_contact_bent(run, joint, 0);
}

static void homogeneous(aoi_adaptive *run, aoi_stage *stage, int with_rates)
{
    const aoi_joint *joint = &run->system->joint[stage->joint];
    for (size_t i = 0; i < AOI_STAGES; i++) {
        stage->homogeneous[i] = stage->start;
        stage->homogeneous_rate[i] = 0.0;
    }
    for (int side = 0; side < 2; side++) {
        const size_t b = joint->body[side], at = run->system->first[b];
        aoi_response_homogeneous(&run->response[b], &run->system->body[b], joint->port[side],
                                 side == 0 ? 1.0 : -1.0, aoi_run_now(run), run->x + at, run->v + at,
                                 stage->homogeneous, with_rates ? stage->homogeneous_rate : NULL);
    }
    add_constant_forces(run, stage, with_rates);
}

/* The last step's polynomial at the nodes of a step of length h behind it, and its slope there. */
static void draw_on(const aoi_contact_state *contact, double h, double *indentation, double *rate)
{
    const double stretch = h / contact->last_length;
    if (stretch == 1.0 && !rate) {
        const double *beyond = &aoi_radau_legendre_beyond[0][0];
        aoi_stages_multiply_from(contact->last[0], beyond, contact->last + 1, indentation);
        return;
    }
    for (size_t i = 0; i < AOI_STAGES; i++) {
        double slope;
        indentation[i] = aoi_legendre_evaluate(AOI_STAGES + 1, contact->last,
                                               1.0 + aoi_radau_node[i] * stretch, &slope);
        if (rate) {
            rate[i] = slope / contact->last_length;
        }
    }
}

/* The same of the motion at its start. */
static void draw_line(const aoi_contact_state *contact, double h, double *indentation, double *rate)
{
    for (size_t i = 0; i < AOI_STAGES; i++) {
        indentation[i] = contact->start + h * aoi_radau_node[i] * contact->start_rate;
        rate[i] = contact->start_rate;
    }
}

/* A guess: the last step's polynomial drawn on, where it reaches, or the motion without force; never
 * deeper than that. Where other contacts press on the same massless place this bounds nothing: it would
 * leap away, at rates without limit. */
static void guess(const aoi_contact_state *contact, double h, double usual, int with_rates, int shared,
                  aoi_stage *stage)
{
    const int known = contact->last_length > 0.0 && h <= 2.0 * contact->last_length;
    double drawn_on[AOI_STAGES], rate[AOI_STAGES], largest = 0.0;
    if (known) {
        draw_on(contact, h, drawn_on, with_rates ? rate : NULL);
    } else if (shared) {
        draw_line(contact, h, drawn_on, rate);
    }
    for (size_t i = 0; i < AOI_STAGES; i++) {
        const int shallower = shared || (known && drawn_on[i] < stage->homogeneous[i]);
        stage->indentation[i] = shallower ? drawn_on[i] : stage->homogeneous[i];
        stage->rate[i] = shallower && with_rates ? rate[i] : stage->homogeneous_rate[i];
        largest = fabs(stage->indentation[i]) > largest ? fabs(stage->indentation[i]) : largest;
    }
    stage->scale = fmax(largest, (shared ? SHARED_NEWTON_SHARE : NEWTON_SHARE) * usual);
}

/* Which edge of a contact a step of length h has. */
static enum aoi_edge edge_of(const aoi_adaptive *run, size_t joint, double h)
{
    const aoi_contact_state *contact = &run->contact[joint];
    const aoi_law *law = run->system->joint[joint].law;
    if (!contact->closed || contact->piece == AOI_SLACK || aoi_joint_bends(run, joint)) {
        return AOI_EDGE_NONE;
    }
    if (contact->begins) { /* from touch, not pressed together, and not with a force that jumps */
        const double rest = aoi_law_rest(law, contact->memory);
        const double deep = EDGE_DEPTH * h * contact->start_rate;
        return contact->force == 0.0 && contact->start - rest <= deep ? AOI_EDGE_START : AOI_EDGE_NONE;
    }
    const double left = aoi_release_after(run, 2.0 * h);
    return fabs(left - h) <= EDGE_WIDTH * h ? AOI_EDGE_END : AOI_EDGE_NONE;
}

/* Fills the stage of a closed contact for a step of length h. */
static void begin_stage(aoi_adaptive *run, size_t s, double h, int with_rates)
{
    aoi_stage *stage = &run->stage[s];
    aoi_contact_state *contact = &run->contact[stage->joint];
    if (aoi_joint_bends(run, stage->joint)) {
        contact->start = aoi_contact_place(run, stage->joint);
    }
    stage->constant = contact->bending;
    stage->memory = contact->memory;
    stage->piece = contact->piece;
    stage->edge = edge_of(run, stage->joint, h);
    stage->start_force = contact->force;
    stage->start = contact->start;
    stage->start_rate = contact->start_rate;
    homogeneous(run, stage, with_rates);
    const int shared = run->closed_count > 1 && aoi_joint_bends(run, stage->joint);
    guess(contact, h, run->indentation_scale, with_rates, shared, stage);
}

/* The step's forces on the ports of all bodies under force. */
static void gather_forces(aoi_adaptive *run)
{
    const aoi_system *system = run->system;
    for (size_t i = 0; i < run->engaged.count; i++) {
        const size_t b = run->engaged.at[i];
        double *force = run->port_force + system->first_port[b] * AOI_STAGES;
        for (size_t k = 0; k < system->body[b].ports * AOI_STAGES; k++) {
            force[k] = 0.0;
        }
    }
    for (size_t s = 0; s < run->closed_count; s++) {
        const aoi_joint *joint = &system->joint[run->stage[s].joint];
        for (int side = 0; side < 2; side++) {
            const size_t port = run->system->first_port[joint->body[side]] + joint->port[side];
            aoi_stages_add(side == 0 ? -1.0 : 1.0, run->stage[s].force,
                           run->port_force + port * AOI_STAGES);
        }
    }
}

/* The largest force of contacts beside each other: seen, met in this step, or to be expected. */
static double force_scale_of(const aoi_adaptive *run)
{
    double largest = 0.0;
    for (size_t s = 0; s < run->closed_count && run->closed_count > 1; s++) {
        const aoi_contact_state *contact = &run->contact[run->stage[s].joint];
        const double stop = contact->impulse_scale * contact->rate_scale;
        largest = fmax(largest, fmax(contact->peak_force, aoi_step_force(&run->stage[s])));
        largest = stop > 0.0 ? fmax(largest, stop / contact->indentation_scale) : largest;
    }
    return largest;
}

/* Contacts that share a body are at most so many stages apart. */
static size_t span_of(const aoi_adaptive *run)
{
    return run->closed_count < 2 ? 0
                                 : (run->span < run->closed_count ? run->span
                                                                  : run->closed_count - 1);
}

void aoi_step_try(aoi_adaptive *run, double h, int level, aoi_attempt *attempt)
{
    const int with_rates =
        aoi_collocation_wants_rates(run->system, run->closed_count, run->stage);
    *attempt = (aoi_attempt){h, 0.0, 2.0, 0};
    for (size_t i = 0; i < run->engaged.count; i++) {
        const size_t b = run->engaged.at[i], before = i > 0 ? run->engaged.at[i - 1] : b;
        if (i > 0 && are_alike(&run->system->body[before], &run->system->body[b])) {
            run->response[b] = run->response[before];
        } else {
            make_response(run, b, h, level, with_rates);
        }
    }
    for (size_t s = 0; s < run->stage_count; s++) {
        run->contact[run->stage[s].joint].event = AOI_EVENT_NONE;
        run->contact[run->stage[s].joint].event_place = HUGE_VAL;
        if (s < run->closed_count) {
            run->contact[run->stage[s].joint].slack = 0.0;
            begin_stage(run, s, h, with_rates);
        }
    }
    if (aoi_collocation_solve(run->system, run->response, h, run->closed_count, span_of(run),
                              run->stage, run->collocation) != AOI_OK) {
        return;
    }
    for (size_t s = 0; s < run->closed_count && with_rates; s++) {
        if (aoi_joint_bends(run, run->stage[s].joint)) {
            run->stage[s].start_rate = aoi_stages_at_start(run->stage[s].rate);
        }
    }
    gather_forces(run);
    run->force_scale = force_scale_of(run);
    attempt->growth = HUGE_VAL;
    for (size_t s = 0; s < run->closed_count; s++) {
        const double growth = aoi_step_growth(run, &run->stage[s], h);
        attempt->growth = growth < attempt->growth ? growth : attempt->growth;
        aoi_step_closed_events(run, &run->stage[s], attempt);
        aoi_step_doze(run, &run->stage[s], attempt);
    }
    for (size_t s = run->closed_count; s < run->stage_count; s++) {
        aoi_step_open_events(run, &run->stage[s], attempt);
    }
}
