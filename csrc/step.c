/* One step of an adaptive run: which contacts and bodies take part, whether it meets the tolerance, what
 * happens within it, and what it leaves behind.
 *
 * Two errors are kept below rtol in each step. The tail of the indentation's Legendre series says how
 * well the polynomial follows the motion within the step, so the peak; the integrated defect of the
 * force between the nodes says what the step hands on, so impulse, velocities and later times. Radau
 * nodes make the second far smaller than the first, except at the beginning and end of a contact,
 * where the force starts like d^(3/2). */
#include "adaptive.h"
#include "radau.h"
#include "stages.h"

#include <float.h>
#include <math.h>

/* Shares of rtol: of the polynomial's tail, and of what one step may hand on. Errors add up over some
 * twenty steps of a contact, and grow from one contact to the next. */
static const double TAIL_SHARE = 0.3, STEP_SHARE = 0.1;

/* At the ends of a contact the force is no smooth function of time, and the quadrature of its defect
 * misses part of it. */
static const double END_SHARE = 0.03;

/* How well events are hit, as a share of rtol, and the rounding of an indentation from the bodies'
 * places. */
static const double EVENT_SHARE = 0.01, PLACE_ROUNDING = 8.0;

/* A contact need not be more exact than this share of the largest beside it. */
static const double LESSER_SHARE = 0.01;

/* A contact dozes off within this share of what it wakes up at. */
static const double DOZING = 0.1;

/* A step is not tried at more than 1/0.9 of the length that its error allows. */
static const double CAUTION = 0.9;

/* Where a law that may not pull has let go of bodies that still overlap, steps grow, but not by leaps. */
static const double SLACK_GROWTH = 2.0;

/* A step ends where a contact lets go if it does so to this share of its length. */
static const double EDGE_WIDTH = 0.1;

/* Beside an edge a step may be so much longer than the one with it; and how much longer than that one,
 * if its error says so, the other edge's may be. */
static const double EDGE_GROWTH = 2.0, EDGE_REACH = 1.4;

/* It begins where it touches if it is no deeper there than this share of how far it could go in it. */
static const double EDGE_DEPTH = 1e-3;

/* A force that grows like t^(1/4) from the start is so much of its last value at the node before. */
static const double NEAR_TOP = 0.99;

/* Newton's convergence is judged on no smaller indentation than this share of the largest. */
static const double NEWTON_SHARE = 1e-6;

double aoi_run_now(const aoi_adaptive *run) { return run->origin + run->elapsed; }

double aoi_event_tolerance(const aoi_adaptive *run, double scale)
{
    return fmax(EVENT_SHARE * run->rtol, 4.0 * DBL_EPSILON) * scale;
}

static const aoi_law *law_of(const aoi_adaptive *run, const aoi_stage *stage)
{
    return run->system->joint[stage->joint].law;
}

int aoi_body_yields(const aoi_modes *body)
{
    for (size_t k = 0; k < body->ports * body->n; k++) {
        if (body->push[k] != 0.0) {
            return 1;
        }
    }
    return 0;
}

static int has_ledger(const aoi_modes *body)
{
    return body->gravity || body->decay || body->load_count > 0;
}

void aoi_body_account(aoi_adaptive *run, size_t b, double time, const double *x, const double *v)
{
    const aoi_modes *body = &run->system->body[b];
    const size_t at = run->system->first[b];
    double work, dissipated;
    if (has_ledger(body)) {
        aoi_modes_flight_work(body, run->body[b].time, time, run->x + at, run->v + at, x, v,
                              run->flight[0], &work, &dissipated);
        run->body[b].work += work;
        run->body[b].dissipated += dissipated;
    }
}

void aoi_body_engage(aoi_adaptive *run, size_t b, int how)
{
    aoi_follower *body = &run->body[b];
    const size_t at = run->system->first[b];
    const double now = aoi_run_now(run);
    if (how > 1 && !aoi_body_yields(&run->system->body[b])) {
        how = 1;
    }
    if (body->engaged == 0) {
        run->engaged.at[run->engaged.count++] = b;
    }
    body->engaged = how > body->engaged ? how : body->engaged;
    if (body->time < now) {
        const size_t n = run->system->body[b].n;
        for (size_t j = 0; j < n; j++) {
            run->scratch[j] = run->x[at + j];
            run->scratch[n + j] = run->v[at + j];
        }
        aoi_modes_fly(&run->system->body[b], body->time, now, run->scratch, run->scratch + n);
        aoi_body_account(run, b, now, run->scratch, run->scratch + n);
        for (size_t j = 0; j < n; j++) {
            run->x[at + j] = run->scratch[j];
            run->v[at + j] = run->scratch[n + j];
        }
        body->time = now;
    }
}

void aoi_body_note_change(aoi_adaptive *run, size_t b)
{
    if (!run->body[b].changed) {
        run->body[b].changed = 1;
        run->changed.at[run->changed.count++] = b;
    }
}

void aoi_pair_now(const aoi_adaptive *run, size_t joint, aoi_flight *pair)
{
    const aoi_joint *of = &run->system->joint[joint];
    for (int side = 0; side < 2; side++) {
        const size_t at = run->system->first[of->body[side]];
        pair->body[side] = &run->system->body[of->body[side]];
        pair->port[side] = of->port[side];
        pair->x[side] = run->x + at;
        pair->v[side] = run->v + at;
    }
    pair->gap = of->gap;
    pair->time = aoi_run_now(run);
}

/* The rounding of an indentation that is a difference of places. */
static double rounding_of(const aoi_flight *pair)
{
    double size = fabs(pair->gap);
    for (int side = 0; side < 2; side++) {
        const aoi_modes *body = pair->body[side];
        for (size_t j = 0; j < body->n; j++) {
            size += fabs(body->shape[pair->port[side] * body->n + j] * pair->x[side][j]);
        }
    }
    return PLACE_ROUNDING * DBL_EPSILON * size;
}

void aoi_step_release(aoi_adaptive *run)
{
    for (size_t i = 0; i < run->engaged.count; i++) {
        run->body[run->engaged.at[i]].engaged = 0;
    }
    for (size_t s = 0; s < run->stage_count; s++) {
        if (!run->contact[run->stage[s].joint].closed) {
            aoi_watch_add(run, run->stage[s].joint);
        }
    }
    run->engaged.count = run->closed_count = run->stage_count = 0;
}

/* Open contacts of a body under force take part in the step: whatever was known of them no longer holds. */
static void bring_along(aoi_adaptive *run, size_t b)
{
    const aoi_system *system = run->system;
    for (size_t i = system->first_joint[b]; i < system->first_joint[b + 1]; i++) {
        const size_t joint = system->joint_of[i];
        if (aoi_watch_remove(run, joint)) {
            run->stage[run->stage_count++].joint = joint;
            run->contact[joint].free_until = -HUGE_VAL;
            run->contact[joint].touches = 0;
            aoi_body_engage(run, system->joint[joint].body[0], 1);
            aoi_body_engage(run, system->joint[joint].body[1], 1);
        }
    }
}

void aoi_step_prepare(aoi_adaptive *run)
{
    aoi_step_release(run);
    for (size_t i = 0; i < run->closed.count; i++) {
        const size_t joint = run->closed.at[i];
        run->stage[i].joint = joint;
        aoi_body_engage(run, run->system->joint[joint].body[0], 2);
        aoi_body_engage(run, run->system->joint[joint].body[1], 2);
    }
    run->closed_count = run->stage_count = run->closed.count;
    const size_t count = run->engaged.count; /* those brought along bring nobody */
    for (size_t i = 0; i < count; i++) {
        if (run->body[run->engaged.at[i]].engaged == 2) {
            bring_along(run, run->engaged.at[i]);
        }
    }
}

/* ------------------------------------------------------------------------------- one attempt */

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
double aoi_step_bent_at_start(const aoi_adaptive *run, size_t joint)
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
            sum += (side == other ? 1.0 : -1.0) * compliance * run->contact[joint_by].force;
        }
    }
    return sum;
}

static void homogeneous(aoi_adaptive *run, aoi_stage *stage, double h, int with_rates)
{
    const aoi_joint *joint = &run->system->joint[stage->joint];
    const double bent = aoi_step_bent_at_start(run, stage->joint);
    for (size_t i = 0; i < AOI_STAGES; i++) {
        stage->homogeneous[i] = stage->start + bent;
        stage->homogeneous_rate[i] =
            with_rates ? -bent / h * aoi_radau_slope_at_node[0][i] : 0.0;
    }
    for (int side = 0; side < 2; side++) {
        const size_t b = joint->body[side], at = run->system->first[b];
        aoi_response_homogeneous(&run->response[b], &run->system->body[b], joint->port[side],
                                 side == 0 ? 1.0 : -1.0, aoi_run_now(run), run->x + at, run->v + at,
                                 stage->homogeneous, with_rates ? stage->homogeneous_rate : NULL);
    }
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

/* A guess: the last step's polynomial drawn on, where it reaches, or the motion without force; never
 * deeper than that. */
static void guess(const aoi_contact_state *contact, double h, double usual, int with_rates,
                  aoi_stage *stage)
{
    const int known = contact->last_length > 0.0 && h <= 2.0 * contact->last_length;
    double drawn_on[AOI_STAGES], rate[AOI_STAGES], largest = 0.0;
    if (known) {
        draw_on(contact, h, drawn_on, with_rates ? rate : NULL);
    }
    for (size_t i = 0; i < AOI_STAGES; i++) {
        const int shallower = known && drawn_on[i] < stage->homogeneous[i];
        stage->indentation[i] = shallower ? drawn_on[i] : stage->homogeneous[i];
        stage->rate[i] = shallower && with_rates ? rate[i] : stage->homogeneous_rate[i];
        largest = fabs(stage->indentation[i]) > largest ? fabs(stage->indentation[i]) : largest;
    }
    stage->scale = largest > NEWTON_SHARE * usual ? largest : NEWTON_SHARE * usual;
}

/* Whether a residual compliance lies between the bodies of a contact: its velocity changes at once where
 * the force begins or ends. */
static int bends(const aoi_adaptive *run, size_t joint)
{
    const size_t *body = run->system->joint[joint].body;
    return run->system->body[body[0]].residual != NULL || run->system->body[body[1]].residual != NULL;
}

/* Which edge of a contact a step of length h has. */
static enum aoi_edge edge_of(const aoi_adaptive *run, size_t joint, double h)
{
    const aoi_contact_state *contact = &run->contact[joint];
    const aoi_law *law = run->system->joint[joint].law;
    if (!contact->closed || contact->piece == AOI_SLACK || bends(run, joint)) {
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

/* Fills the stage of a contact, open or closed, for a step of length h. */
static void begin_stage(aoi_adaptive *run, size_t s, double h, int with_rates)
{
    aoi_stage *stage = &run->stage[s];
    const aoi_contact_state *contact = &run->contact[stage->joint];
    stage->memory = contact->memory;
    stage->piece = contact->closed ? contact->piece : AOI_SLACK;
    stage->edge = edge_of(run, stage->joint, h);
    stage->start_force = contact->force;
    stage->start = contact->start;
    stage->start_rate = contact->start_rate;
    if (s >= run->closed_count) {
        aoi_flight pair;
        double acceleration;
        aoi_pair_now(run, stage->joint, &pair);
        aoi_flight_indentation(&pair, &stage->start, &stage->start_rate, &acceleration);
        stage->start_force = 0.0;
        stage->start -= aoi_step_bent_at_start(run, stage->joint);
    }
    homogeneous(run, stage, h, with_rates);
    if (s < run->closed_count) {
        guess(contact, h, run->indentation_scale, with_rates, stage);
    }
}

static double largest_of(const aoi_stage *stage)
{
    return aoi_stages_largest(stage->start, stage->indentation);
}

/* What counts as large for a contact: what it has seen, or a small share of what the others have. */
static double scale_of(const aoi_adaptive *run, const aoi_stage *stage, double largest)
{
    return fmax(fmax(run->contact[stage->joint].indentation_scale, largest),
                LESSER_SHARE * run->indentation_scale);
}

/* By how much more of the force an error of the indentation makes under this law than under Hertz's. */
static double steepness_of(const aoi_adaptive *run, const aoi_stage *stage, double largest)
{
    aoi_law_value value;
    aoi_law_push(law_of(run, stage), stage->memory, largest, stage->start_rate, &value);
    /* Of the largest force: a small one at the end of a contact is not to be right to itself. */
    const double force = fmax(value.force, run->contact[stage->joint].peak_force);
    return force > 0.0 ? fmax(value.stiffness * largest / (1.5 * force), 1.0) : 1.0;
}

/* What the last coefficients of the force's polynomial hold. Under a law of the rate light contact masses
 * and stiff oscillators ring in the force long before they show in the indentation; a massless contact
 * follows its forces at once: they may run away from a smooth indentation, within the time that law and
 * compliance make together. */
static double force_tail(const aoi_stage *stage)
{
    double c[4];
    for (size_t k = 0; k < 4; k++) {
        c[k] = fabs(aoi_stages_dot(aoi_radau_to_legendre[AOI_STAGES - 1 - k], stage->force));
    }
    const double last = c[0] + 0.2 * c[1], before = c[2] + 0.2 * c[3];
    return last < before ? last * sqrt(last / before) : last;
}

/* The largest force at the nodes. */
static double largest_force(const aoi_stage *stage)
{
    return aoi_stages_largest(0.0, stage->force);
}

/* What counts as large for its force: what it has seen, or what its impulse takes at the pace at which
 * the bodies met. */
static double force_scale(const aoi_contact_state *contact, const aoi_stage *stage, double impulse,
                          double indentation)
{
    return fmax(fmax(contact->peak_force, largest_force(stage)),
                impulse * contact->rate_scale / indentation);
}

static void law_at_end(const aoi_law *law, const aoi_stage *stage, aoi_law_value *value)
{
    const int end = AOI_STAGES - 1;
    aoi_law_force(law, stage->memory, stage->piece, stage->indentation[end], stage->rate[end], value);
}

/* What the last coefficients of the rate's series hold. From the nodes alone: where a force comes or goes, the
 * rate of what has no mass jumps. */
static double rate_tail(const aoi_stage *stage)
{
    return fabs(aoi_vector_dot(AOI_STAGES, aoi_radau_to_legendre[AOI_STAGES - 1], stage->rate)) +
           fabs(aoi_vector_dot(AOI_STAGES, aoi_radau_to_legendre[AOI_STAGES - 2], stage->rate));
}

/* The error of a force that depends on the rate where it is largest inside a step with an edge, of which its
 * own series says nothing. The rate's coefficients fall slowly there, like a power: those to come hold more
 * than the last ones do. */
static double edge_force_error(const aoi_law *law, const aoi_stage *stage, double tail)
{
    double largest = 0.0;
    aoi_law_value value;
    law_at_end(law, stage, &value);
    for (size_t i = 0; i + 1 < AOI_STAGES; i++) {
        largest = fmax(largest, stage->force[i]);
    }
    if (largest <= fmax(stage->start_force, NEAR_TOP * value.force)) {
        return 0.0;
    }
    return fabs(value.stiffness) * tail +
           fabs(value.damping) * rate_tail(stage) * AOI_STAGES / 3.0;
}

/* The errors of a step as shares of what they may be. No step can do better than rounding. */
static void judge(aoi_adaptive *run, aoi_stage *stage, double h, double *within, double *handed_on)
{
    const aoi_contact_state *contact = &run->contact[stage->joint];
    const double largest = largest_of(stage), scale = scale_of(run, stage, largest);
    const double impulse_scale = fmax(contact->impulse_scale, LESSER_SHARE * run->impulse_scale);
    const int at_an_end = contact->last_length == 0.0 || stage->indentation[AOI_STAGES - 1] <= 0.0;
    const double end_share = at_an_end ? END_SHARE : 1.0;
    const int bent = bends(run, stage->joint);
    const double tail_share =
        fmax(TAIL_SHARE * (bent ? end_share : 1.0) * run->rtol, 8.0 * DBL_EPSILON);
    const double step_share = STEP_SHARE * end_share * run->rtol;
    aoi_collocation_error error;
    aoi_collocation_estimate(run->system, run->response, h, stage, &error);
    *within = steepness_of(run, stage, largest) * error.tail / (tail_share * scale);
    const aoi_law *law = law_of(run, stage);
    if (law->depends_on_rate && (bent || largest_force(stage) >= CAUTION * contact->peak_force)) {
        const double size = force_scale(contact, stage, impulse_scale, scale);
        const double wrong = stage->edge == AOI_EDGE_NONE
                                 ? force_tail(stage)
                                 : edge_force_error(law, stage, error.tail);
        *within = fmax(*within, wrong / (tail_share * size));
    }
    *handed_on = (fabs(error.impulse) / impulse_scale + fabs(error.indentation) / scale) /
                 fmax(step_share, 2.0 * DBL_EPSILON);
}

/* The same where a law has let go: the motion is exact, but is to be seen well enough to tell whether the
 * force comes back, which the rate decides. */
static double slack_growth(const aoi_adaptive *run, const aoi_stage *stage, double within)
{
    const double slow = TAIL_SHARE * run->rtol * run->contact[stage->joint].rate_scale;
    const double unseen = fmax(within, rate_tail(stage) / fmax(slow, DBL_MIN));
    const double growth = CAUTION * pow(unseen, -1.0 / AOI_STAGES);
    return unseen > 1.0 ? fmin(growth, CAUTION) : fmin(fmax(growth, 1.0), SLACK_GROWTH);
}

/* By how much the step could be longer, as far as this contact goes. At an edge errors grow like the
 * powers of time that a polynomial misses: d^(3/2) makes t^(7/2) of the motion, t^(5/2) of the impulse. */
static double growth_of(aoi_adaptive *run, aoi_stage *stage, double h)
{
    const int at_edge = stage->edge != AOI_EDGE_NONE;
    double within, handed_on;
    judge(run, stage, h, &within, &handed_on);
    if (stage->piece == AOI_SLACK) {
        return slack_growth(run, stage, within);
    }
    if (isnan(within + handed_on)) {
        return 0.0;
    }
    const double by_tail = at_edge ? 3.5 : AOI_STAGES + 1, by_impulse = at_edge ? 2.5 : 2 * AOI_STAGES;
    double growth = CAUTION * pow(within, -1.0 / by_tail);
    if (within > 1.0 || handed_on > within * within) { /* else the first is the least */
        growth = fmin(growth, CAUTION * pow(handed_on, -1.0 / by_impulse));
    }
    if (within > 1.0 || handed_on > 1.0) {
        return fmin(growth, CAUTION);
    }
    if (at_edge) {
        run->contact[stage->joint].edge = h * fmin(fmax(growth, 1.0), EDGE_REACH);
        return EDGE_GROWTH;
    }
    return fmax(growth, 1.0);
}

/* ------------------------------------------------------------------------------------ events */

/* Whether a quantity falls below zero, and where. Ending within tolerance below zero, without having been
 * lower before, it falls at the end; else the step is to end where it will be there. */
static int falls_below(const double *values, double tolerance, double *place)
{
    double coefficient[AOI_STAGES + 1];
    int early = 0;
    for (size_t i = 1; i < AOI_STAGES; i++) {
        early = early || values[i] < -tolerance;
    }
    if (!early && !(values[AOI_STAGES] < 0.0)) {
        return 0;
    }
    *place = 1.0;
    if (early || values[AOI_STAGES] < -tolerance) {
        aoi_legendre_fit(values, coefficient);
        (void)aoi_legendre_falls(values, coefficient, -0.5 * tolerance, place);
    }
    return 1;
}

/* Takes note of what happens to a contact at a place, if that is its first event. */
static void note_event(double place, int kind, aoi_contact_state *contact, aoi_attempt *attempt)
{
    if (place < contact->event_place) {
        contact->event_place = place;
        contact->event = kind;
    }
    attempt->place = place < attempt->place ? place : attempt->place;
}

/* The same where a quantity falls. */
static void falls(const double *values, double tolerance, int kind, aoi_contact_state *contact,
                  aoi_attempt *attempt)
{
    double place;
    if (falls_below(values, tolerance, &place)) {
        note_event(place, kind, contact, attempt);
    }
}

/* Whether a node is the lowest about, so that a dip beside it may be as deep as what it rises to a neighbour. */
static int may_dip(const double *values, double depth)
{
    for (size_t i = 1; i <= AOI_STAGES; i++) {
        const double next = i < AOI_STAGES ? values[i + 1] : values[i];
        const double higher = fmax(values[i - 1], next) - values[i];
        if (values[i] <= values[i - 1] && values[i] <= next && values[i] < higher - depth) {
            return 1;
        }
    }
    return 0;
}

/* The same for a distance from an end, or a force, that may have been passed and come back to between
 * two nodes. Only a step that is good enough says so. */
static void leaves(const double *values, double tolerance, int kind, aoi_contact_state *contact,
                   aoi_attempt *attempt)
{
    double coefficient[AOI_STAGES + 1], place;
    falls(values, tolerance, kind, contact, attempt);
    if (contact->event == kind || !(attempt->growth >= 1.0) || !may_dip(values, tolerance)) {
        return;
    }
    aoi_legendre_fit(values, coefficient);
    if (aoi_legendre_dips(coefficient, -tolerance, -0.5 * tolerance, &place)) {
        note_event(place, kind, contact, attempt);
    }
}

/* start and AOI_STAGES nodes of factor * value + shift. */
static void line_up(double start, const double *nodes, double factor, double shift, double *values)
{
    values[0] = factor * start + shift;
    for (size_t i = 0; i < AOI_STAGES; i++) {
        values[i + 1] = factor * nodes[i] + shift;
    }
}

/* The piece of the law that a contact is on, or would be if it were not slack. */
static int piece_of(const aoi_law *law, const aoi_stage *stage)
{
    double low, high;
    return stage->piece != AOI_SLACK
               ? stage->piece
               : aoi_law_piece(law, stage->memory, stage->start, stage->start_rate > 0.0, &low, &high);
}

/* Where the law's own force, which is cut at zero, changes its sign. */
static void force_events(aoi_adaptive *run, const aoi_stage *stage, aoi_attempt *attempt)
{
    aoi_contact_state *contact = &run->contact[stage->joint];
    const aoi_law *law = law_of(run, stage);
    const int piece = piece_of(law, stage);
    double force[AOI_STAGES], values[AOI_STAGES + 1], largest = 0.0;
    aoi_law_value value;
    for (size_t i = 0; i < AOI_STAGES; i++) {
        aoi_law_force(law, stage->memory, piece, stage->indentation[i], stage->rate[i], &value);
        force[i] = value.force;
        largest = fmax(largest, fabs(value.force));
    }
    largest = fmax(largest, contact->peak_force);
    const double tolerance = aoi_event_tolerance(run, largest);
    if (stage->piece == AOI_SLACK) {
        aoi_law_force(law, stage->memory, piece, stage->start, stage->start_rate, &value);
        line_up(fmin(value.force, 0.0), force, -1.0, 0.0, values);
        leaves(values, tolerance, AOI_EVENT_TIGHTEN, contact, attempt);
    } else {
        line_up(fmax(stage->start_force, 0.0), force, 1.0, 0.0, values);
        leaves(values, tolerance, AOI_EVENT_SLACKEN, contact, attempt);
    }
}

/* What is left to rise before a turn is below the tolerance: it turns where it is, since steps as short as
 * that would see rates that are rounding. */
static void turn_now(const aoi_stage *stage, double tolerance, aoi_contact_state *contact,
                     aoi_attempt *attempt)
{
    if (contact->event == AOI_EVENT_TURN && contact->event_place < 1.0 &&
        stage->start_rate * contact->event_place * attempt->h <= tolerance) {
        contact->event_place = attempt->place = 0.0;
    }
}

static void closed_events(aoi_adaptive *run, aoi_stage *stage, aoi_attempt *attempt)
{
    const aoi_law *law = law_of(run, stage);
    aoi_contact_state *contact = &run->contact[stage->joint];
    const double rest = aoi_law_rest(law, stage->memory);
    const double tolerance = aoi_event_tolerance(run, scale_of(run, stage, largest_of(stage)));
    double values[AOI_STAGES + 1];
    line_up(stage->start, stage->indentation, 1.0, -rest, values);
    falls(values, tolerance, AOI_EVENT_OPEN, contact, attempt);
    if (law->depends_on_rate && !law->pulls) {
        force_events(run, stage, attempt);
    }
    if (stage->piece != AOI_SLACK && contact->high < HUGE_VAL) {
        line_up(stage->start, stage->indentation, -1.0, contact->high, values);
        leaves(values, tolerance, AOI_EVENT_ABOVE, contact, attempt);
    }
    if (stage->piece != AOI_SLACK && contact->low > rest) {
        line_up(stage->start, stage->indentation, 1.0, -contact->low, values);
        leaves(values, tolerance, AOI_EVENT_BELOW, contact, attempt);
    }
    if (law->turns && stage->piece != AOI_SLACK && stage->start_rate > 0.0) {
        const double slow = EVENT_SHARE * run->rtol * contact->rate_scale;
        line_up(stage->start_rate, stage->rate, 1.0, 0.0, values);
        falls(values, slow, AOI_EVENT_TURN, contact, attempt);
        turn_now(stage, tolerance, contact, attempt);
    }
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

/* The displacement that they add to a port at the nodes. */
static void add_forced(const aoi_adaptive *run, size_t b, size_t port, double sign, double *indentation)
{
    const aoi_modes *body = &run->system->body[b];
    for (size_t q = 0; q < body->ports; q++) {
        const double *force = run->port_force + (run->system->first_port[b] + q) * AOI_STAGES;
        const size_t pair = port * body->ports + q;
        double answer[AOI_STAGES];
        aoi_stages_multiply(run->response[b].influence + pair * AOI_STAGES * AOI_STAGES, force, answer);
        aoi_stages_add(sign, answer, indentation);
        if (body->residual) {
            aoi_stages_add(sign * body->residual[pair], force, indentation);
        }
    }
}

/* An open contact at rounding from a touch: within so much of it nothing happens. */
static double touch_tolerance(aoi_adaptive *run, const aoi_stage *stage)
{
    aoi_flight pair;
    aoi_pair_now(run, stage->joint, &pair);
    return fmax(EVENT_SHARE * run->rtol * scale_of(run, stage, 0.0), rounding_of(&pair));
}

/* Behind a wave bodies go on side by side, with overlaps and velocities that are rounding. A force that
 * would not change the last digit of the contact's impulse if it lasted to the end of the run has ended:
 * else all that has ever been passed would be solved for in every step. */
static void doze(aoi_adaptive *run, aoi_stage *stage, aoi_attempt *attempt)
{
    aoi_contact_state *contact = &run->contact[stage->joint];
    const double left = run->end - aoi_run_now(run);
    double force = fabs(stage->start_force);
    for (size_t i = 0; i < AOI_STAGES; i++) {
        force = fabs(stage->force[i]) > force ? fabs(stage->force[i]) : force;
    }
    if (contact->event != AOI_EVENT_NONE || contact->begins || stage->piece == AOI_SLACK ||
        !(force * left <= DBL_EPSILON * contact->impulse)) {
        return;
    }
    const double tolerance = touch_tolerance(run, stage);
    if (!(largest_of(stage) - aoi_law_rest(law_of(run, stage), stage->memory) <= DOZING * tolerance)) {
        return;
    }
    contact->event = AOI_EVENT_OPEN;
    contact->event_place = 1.0;
    contact->slack = 0.5 * tolerance;
    attempt->place = fmin(attempt->place, 1.0);
}

/* An open contact beside closed ones. It takes no force as long as it stays within the tolerance. */
static void open_events(aoi_adaptive *run, aoi_stage *stage, aoi_attempt *attempt)
{
    const aoi_joint *joint = &run->system->joint[stage->joint];
    aoi_contact_state *contact = &run->contact[stage->joint];
    const double rest = aoi_law_rest(joint->law, stage->memory);
    double values[AOI_STAGES + 1], place = attempt->place;
    for (size_t i = 0; i < AOI_STAGES; i++) {
        stage->indentation[i] = stage->homogeneous[i];
    }
    for (int side = 0; side < 2; side++) {
        add_forced(run, joint->body[side], joint->port[side], side == 0 ? 1.0 : -1.0,
                   stage->indentation);
    }
    const double tolerance = touch_tolerance(run, stage);
    line_up(stage->start, stage->indentation, -1.0, rest + fmax(0.5 * tolerance, contact->slack),
            values);
    falls(values, tolerance, AOI_EVENT_TOUCH, contact, attempt);
    if (contact->event == AOI_EVENT_TOUCH && values[0] <= 2.0 * tolerance) {
        attempt->place = place;
        contact->event = AOI_EVENT_NONE;
        attempt->closed = 1;
        aoi_contact_close(run, stage->joint);
    }
}

/* ------------------------------------------------------------------------------- the attempt */

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
        }
        begin_stage(run, s, h, with_rates);
    }
    if (aoi_collocation_solve(run->system, run->response, h, run->closed_count, span_of(run),
                              run->stage, run->collocation) != AOI_OK) {
        return;
    }
    gather_forces(run);
    attempt->growth = HUGE_VAL;
    for (size_t s = 0; s < run->closed_count; s++) {
        const double growth = growth_of(run, &run->stage[s], h);
        attempt->growth = growth < attempt->growth ? growth : attempt->growth;
        closed_events(run, &run->stage[s], attempt);
        doze(run, &run->stage[s], attempt);
    }
    for (size_t s = run->closed_count; s < run->stage_count; s++) {
        open_events(run, &run->stage[s], attempt);
    }
}

/* -------------------------------------------------------------------------------- acceptance */

/* Where in the step the force has its largest maximum: that of the indentation, or, under a law that
 * depends on the rate, before it. 1 where there is none inside. */
static double top_of(const aoi_law *law, const aoi_stage *stage)
{
    double place, value, by_force[AOI_STAGES];
    if (!law->depends_on_rate) {
        return aoi_legendre_top(AOI_STAGES + 1, stage->legendre, &place, &value) ? place : 1.0;
    }
    for (size_t k = 0; k < AOI_STAGES; k++) {
        by_force[k] = aoi_stages_dot(aoi_radau_to_legendre[k], stage->force);
    }
    return aoi_legendre_top(AOI_STAGES, by_force, &place, &value) ? place : 1.0;
}

static void take_peak(const aoi_adaptive *run, double force, double after, aoi_contact_state *contact)
{
    if (force > contact->peak_force) {
        contact->peak_force = force;
        contact->peak_time = aoi_run_now(run) + after;
    }
}

static void note_peak(const aoi_adaptive *run, const aoi_stage *stage, double h, aoi_contact_state *contact)
{
    const aoi_law *law = law_of(run, stage);
    double rates[AOI_STAGES + 1] = {stage->start_rate}, by_rate[AOI_STAGES + 1], slope, rate = 0.0;
    aoi_law_value value;
    if (largest_force(stage) < CAUTION * contact->peak_force) {
        return;
    }
    const double place = top_of(law, stage);
    if (law->depends_on_rate) {
        take_peak(run, stage->start_force, 0.0, contact);
        for (size_t i = 0; i < AOI_STAGES; i++) {
            rates[i + 1] = stage->rate[i];
        }
        aoi_legendre_fit(rates, by_rate); /* a slope over a very short step would be noise */
        rate = aoi_legendre_evaluate(AOI_STAGES + 1, by_rate, place, &slope);
    }
    if (place < 1.0) {
        const double indentation =
            aoi_legendre_evaluate(AOI_STAGES + 1, stage->legendre, place, &slope);
        aoi_law_force(law, stage->memory, stage->piece, indentation, rate, &value);
        take_peak(run, value.force, place * h, contact);
    }
    law_at_end(law, stage, &value);
    take_peak(run, value.force, h, contact);
}

static size_t write_body(const aoi_adaptive *run, size_t b, double *row)
{
    const size_t n = run->system->body[b].n, first = run->system->first[b];
    row[0] = (double)b;
    row[1] = run->body[b].work;
    row[2] = run->body[b].dissipated;
    for (size_t j = 0; j < n; j++) {
        row[AOI_TRACK_STATE + j] = run->x[first + j];
        row[AOI_TRACK_STATE + n + j] = run->v[first + j];
    }
    return AOI_TRACK_STATE + 2 * n;
}

static void write_contact(const aoi_contact_state *contact, const aoi_stage *stage, double *of)
{
    const int ends = contact->event == AOI_EVENT_OPEN || contact->event == AOI_EVENT_SLACKEN;
    of[AOI_TRACK_JOINT] = (double)stage->joint;
    of[AOI_TRACK_BEGINS] = contact->begins && stage->piece != AOI_SLACK;
    of[AOI_TRACK_ENDS] = ends && stage->piece != AOI_SLACK;
    of[AOI_TRACK_EDGE] = stage->edge;
    of[AOI_TRACK_PIECE] = stage->piece;
    of[AOI_TRACK_WORK] = contact->work;
    for (size_t i = 0; i < AOI_LAW_MEMORY; i++) {
        of[AOI_TRACK_MEMORY + i] = contact->memory[i];
    }
    for (size_t i = 0; i < AOI_STAGES; i++) {
        of[AOI_TRACK_FORCE + i] = stage->force[i];
    }
    for (size_t i = 0; i <= AOI_STAGES; i++) {
        of[AOI_TRACK_INDENTATION + i] = stage->legendre[i];
    }
}

size_t aoi_step_write(aoi_adaptive *run, double h, size_t contacts, double *row)
{
    size_t at = AOI_TRACK_FIXED;
    for (size_t i = 0; contacts > 0 && i < run->engaged.count; i++) {
        if (run->body[run->engaged.at[i]].engaged == 2) {
            aoi_body_note_change(run, run->engaged.at[i]);
        }
    }
    const size_t bodies = run->changed.count;
    for (size_t i = 0; i < bodies; i++) {
        at += write_body(run, run->changed.at[i], row + at);
        run->body[run->changed.at[i]].changed = 0;
    }
    run->changed.count = 0;
    for (size_t s = 0; s < contacts; s++, at += AOI_TRACK_CONTACT_SIZE) {
        write_contact(&run->contact[run->stage[s].joint], &run->stage[s], row + at);
    }
    row[AOI_TRACK_START] = aoi_run_now(run);
    row[AOI_TRACK_LENGTH] = h;
    row[AOI_TRACK_BODIES] = (double)bodies;
    row[AOI_TRACK_CONTACTS] = (double)contacts;
    row[AOI_TRACK_SIZE] = (double)at;
    return at;
}

/* Bodies under force to the end of the step. */
static void move_body(aoi_adaptive *run, size_t b, double h)
{
    const aoi_modes *body = &run->system->body[b];
    const double *force = run->port_force + run->system->first_port[b] * AOI_STAGES;
    double *x = run->x + run->system->first[b], *v = run->v + run->system->first[b];
    const double now = aoi_run_now(run);
    double *before = run->flight[0], *scratch = run->flight[0] + 2 * body->n, work, dissipated;
    const int booked = has_ledger(body);
    for (size_t j = 0; booked && j < body->n; j++) {
        before[j] = x[j];
        before[body->n + j] = v[j];
    }
    aoi_response_propagate(&run->response[b], body, now, force, x, v);
    if (booked) {
        aoi_modes_step_work(body, now, h, 1.0, force, before, before + body->n, x, v, scratch, &work,
                            &dissipated);
        run->body[b].work += work;
        run->body[b].dissipated += dissipated;
    }
}

static void move_bodies(aoi_adaptive *run, double h, double later)
{
    for (size_t i = 0; i < run->engaged.count; i++) {
        const size_t b = run->engaged.at[i];
        if (run->body[b].engaged == 2) {
            move_body(run, b, h);
            run->body[b].time = later;
            aoi_body_note_change(run, b);
        }
    }
}

/* Whether the forces at the nodes are the law's, or a line drawn on beyond it. */
static int stands(const aoi_law *law, const aoi_stage *stage)
{
    int all = 1;
    for (size_t i = 0; i < AOI_STAGES && law->compliance > 0.0 && law->depends_on_rate && all; i++) {
        all = stage->force[i] <= 0.0 ||
              aoi_law_stands(law, stage->memory, stage->indentation[i], stage->rate[i]);
    }
    return all;
}

/* At an edge the nodes' polynomial is right on the whole, but not at its end. */
static double force_at_end(const aoi_law *law, const aoi_stage *stage)
{
    aoi_law_value value;
    if (stage->edge == AOI_EDGE_NONE) {
        return stage->force[AOI_STAGES - 1];
    }
    law_at_end(law, stage, &value);
    return value.force;
}

/* Where the slope of P_k is k (k + 1). */
static double end_slope(const double *legendre)
{
    double sum = 0.0;
    for (size_t k = 1; k <= AOI_STAGES; k++) {
        sum += (double)(k * (k + 1)) * legendre[k];
    }
    return sum;
}

/* What a contact has gone through in the step, and its state at the end. */
static int move_contact(aoi_adaptive *run, const aoi_stage *stage, double h, int with_rates)
{
    aoi_contact_state *contact = &run->contact[stage->joint];
    const aoi_law *law = law_of(run, stage);
    const double largest = largest_of(stage);
    const int end = AOI_STAGES - 1;
    if (largest > law->limit || !stands(law, stage)) {
        run->culprit = stage->joint;
        return AOI_ERROR_PATCH;
    }
    if (stage->piece != AOI_SLACK) {
        note_peak(run, stage, h, contact);
        const double impulse = aoi_collocation_impulse(stage, h);
        contact->impulse += impulse;
        contact->since_touch += impulse;
        contact->work += aoi_collocation_work(stage);
    }
    contact->impulse_scale = fmax(contact->impulse_scale, contact->since_touch);
    contact->indentation_scale = fmax(contact->indentation_scale, largest);
    for (size_t i = 0; i <= AOI_STAGES; i++) {
        contact->last[i] = stage->legendre[i];
    }
    contact->last_length = h;
    contact->begins = 0;
    contact->start = stage->indentation[end];
    contact->start_rate = stage->rate[end];
    if (!with_rates) {
        contact->start_rate = end_slope(stage->legendre) / h;
    }
    contact->force = force_at_end(law, stage);
    contact->rate_scale = fmax(contact->rate_scale, fabs(contact->start_rate));
    if (stage->piece != AOI_SLACK) {
        aoi_law_remember(law, contact->start, contact->start_rate, contact->memory);
    }
    return AOI_OK;
}

/* On which piece of its law a closed contact goes on. */
static void take_piece(const aoi_law *law, aoi_contact_state *contact, double indentation, int rising)
{
    aoi_law_value value;
    contact->piece =
        aoi_law_piece(law, contact->memory, indentation, rising, &contact->low, &contact->high);
    aoi_law_force(law, contact->memory, contact->piece, contact->start, contact->start_rate, &value);
    contact->force = value.force;
}

/* Strikes it off the list of closed ones. */
static void strike_closed(aoi_adaptive *run, size_t joint)
{
    size_t at = 0;
    while (run->closed.at[at] != joint) {
        at++;
    }
    run->closed.count--;
    for (; at < run->closed.count; at++) {
        run->closed.at[at] = run->closed.at[at + 1];
    }
    run->contact[joint].closed = 0;
}

static void happen(aoi_adaptive *run, size_t joint, double now)
{
    aoi_contact_state *contact = &run->contact[joint];
    const aoi_law *law = run->system->joint[joint].law;
    switch (contact->event) {
    case AOI_EVENT_OPEN:
        strike_closed(run, joint);
        contact->work += aoi_system_snap(run->system, joint, contact->force);
        contact->force = 0.0;
        contact->touches = 0;
        contact->free_until = now;
        break;
    case AOI_EVENT_SLACKEN:
        contact->piece = AOI_SLACK;
        contact->force = 0.0;
        break;
    case AOI_EVENT_TIGHTEN:
        contact->begins = 1;
        contact->last_length = 0.0;
        take_piece(law, contact, contact->start, contact->start_rate > 0.0);
        break;
    case AOI_EVENT_TURN:
        contact->start_rate = fmin(contact->start_rate, 0.0); /* or it would turn again, for ever */
        take_piece(law, contact, contact->start, 0);
        contact->last_length = 0.0;
        break;
    case AOI_EVENT_ABOVE:
        take_piece(law, contact, fmax(contact->high, contact->start), 1);
        break;
    case AOI_EVENT_BELOW:
        take_piece(law, contact, contact->low, 0);
        break;
    default:
        break;
    }
}

/* Whether an event at the very start is one only to a polynomial that is not good enough: a contact that
 * opens in the first look at it, or leaves its piece by the end that it moves away from. */
static int goes_back(const aoi_contact_state *contact)
{
    return (contact->event == AOI_EVENT_OPEN && contact->begins) ||
           (contact->event == AOI_EVENT_ABOVE && contact->start_rate < 0.0) ||
           (contact->event == AOI_EVENT_BELOW && contact->start_rate > 0.0);
}

int aoi_step_at_start(aoi_adaptive *run, double place)
{
    int some = 0;
    for (size_t s = 0; s < run->closed_count; s++) {
        aoi_contact_state *contact = &run->contact[run->stage[s].joint];
        if (contact->event_place > place) {
            continue;
        }
        if (goes_back(contact)) {
            return 0;
        }
        happen(run, run->stage[s].joint, aoi_run_now(run));
        some = 1;
    }
    return some;
}

/* Many equal steps are rounded alike, which would add up to a phase: what is left off is added later. */
static void pass_time(aoi_adaptive *run, double h)
{
    const double step = h + run->left_off, elapsed = run->elapsed + step;
    run->left_off = step - (elapsed - run->elapsed);
    run->elapsed = elapsed;
}

int aoi_step_accept(aoi_adaptive *run, const aoi_attempt *attempt, double *row, size_t *size)
{
    const double h = attempt->h, later = run->origin + (run->elapsed + (h + run->left_off));
    const int with_rates =
        aoi_collocation_wants_rates(run->system, run->closed_count, run->stage);
    *size = aoi_step_write(run, h, run->closed_count, row);
    move_bodies(run, h, later);
    for (size_t s = 0; s < run->closed_count; s++) {
        const int status = move_contact(run, &run->stage[s], h, with_rates);
        if (status != AOI_OK) {
            return status;
        }
    }
    pass_time(run, h);
    run->steps++;
    run->indentation_scale = run->impulse_scale = 0.0;
    for (size_t s = 0; s < run->stage_count; s++) {
        const size_t joint = run->stage[s].joint;
        if (run->contact[joint].event == AOI_EVENT_TOUCH) {
            aoi_contact_close(run, joint);
        } else if (s < run->closed_count) {
            happen(run, joint, later);
        }
        run->indentation_scale =
            fmax(run->indentation_scale, run->contact[joint].indentation_scale);
        run->impulse_scale = fmax(run->impulse_scale, run->contact[joint].impulse_scale);
    }
    return AOI_OK;
}
