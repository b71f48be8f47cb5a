/* Newmark's rule on a star (section 3.1 of the paper, on the model of section 2). An oscillator's
 * equation has only its own and the contact mass's acceleration in it: eliminated by hand, the whole
 * star is one scalar equation, and a step costs O(n).
 *
 * The oscillators are stepped by their stretch s = u_i - u_0, not by their place: a free body may move freely
 * far, and the rounding of its place would act on its springs. With p the predictor of u_0, q that of
 * a stretch, and a' the new accelerations, u_0' = p + beta dt^2 a_0', s' = q + beta dt^2 (a_i' - a_0'):
 *   m_i a_i' = -k_i s'   gives   a_i' = w_i (beta dt^2 a_0' - q_i),  w_i = k_i / (m_i + beta dt^2 k_i)
 *   (m_0 + beta dt^2 (k_0 + sum m_i w_i)) a_0' = f - k_0 p + sum m_i w_i q_i
 * Solving for accelerations, not displacements, keeps their digits where dt is small. Displacements
 * are formed as dt (v + dt/4 a), never with a rounded dt^2: its ratio to dt is what keeps the energy.
 *
 * Rayleigh's dashpots (alpha m_i to the ground, beta k_i beside each spring) change the constants, and
 * q to an effective one, q + beta q' + (alpha m/k)(p' + q') with the predicted rates p', q':
 *   w_i = k_i / (m_i (1 + alpha gamma dt) + k_i reach),  reach = beta_N dt^2 + beta gamma dt.
 *
 * Gravity g_i costs nothing: with the stretches counted from g_i/k_i, where the springs carry it, all
 * of it acts on the contact coordinate.
 *
 * Without m0 the contact has no acceleration of its own: it stays where it was as a predictor, the
 * stretches' rates and accelerations are then the oscillators' own, and a_0' stands for its move. */
#include "newmark/body.h"
#include "linear/vector.h"

#include <math.h>

enum { MOBILITY, FREE_A, MASSLESS, RATE, CENTRE, DEFLECTION, FALL, ALPHA, BETA, REACH, LOST };

int aoi_rule_prepare(const aoi_rule *rule, aoi_rule_step *step)
{
    const double h = rule->dt;
    if (!(h > 0.0) || !(rule->beta > 0.0) || !(rule->gamma >= 0.5) || !isfinite(h)) {
        return AOI_ERROR_ARGUMENT;
    }
    step->dt = h;
    step->predict_u = h * (0.5 - rule->beta);
    step->predict_v = h * (1.0 - rule->gamma);
    step->correct_u = h * rule->beta;
    step->correct_v = h * rule->gamma;
    step->reach = rule->beta * h * h;
    return isfinite(step->correct_u) && isfinite(step->correct_v) && step->reach > 0.0 &&
                   isfinite(step->reach)
               ? AOI_OK
               : AOI_ERROR_ARGUMENT;
}

size_t aoi_body_star_size(size_t n) { return 7 * n + 5; }

/* state: u_0 and the stretches, their rates, their accelerations; then w_i, m_i w_i; of damped stars
 * the effective q and alpha m_i / k_i; compliance and rate compliance. */
static double *state_u(const aoi_body *body) { return body->state; }
static double *state_v(const aoi_body *body, size_t n) { return body->state + (n + 1); }
static double *state_a(const aoi_body *body, size_t n) { return body->state + 2 * (n + 1); }
static double *gain_of(const aoi_body *body, size_t n) { return body->state + 3 * (n + 1); }
static double *reaction_of(const aoi_body *body, size_t n) { return gain_of(body, n) + n; }
static double *effective_of(const aoi_body *body, size_t n) { return gain_of(body, n) + 2 * n; }
static double *drag_of(const aoi_body *body, size_t n) { return gain_of(body, n) + 3 * n; }

/* s of the oscillators becomes its predictor; returns sum m_i w_i q_i. Four partial sums, so that the
 * compiler may keep them in vector registers. Rates wait for the correction: one store less. */
static double oscillators_predict(size_t n, const aoi_rule_step *step,
                                  const double *restrict reaction, double *restrict s,
                                  const double *restrict v, const double *restrict a)
{
    const double h = step->dt, predict_u = step->predict_u;
    double sum[4] = {0.0, 0.0, 0.0, 0.0};
    size_t i = 0;
    for (; i + 4 <= n; i += 4) {
        for (size_t lane = 0; lane < 4; lane++) {
            const size_t j = i + lane;
            const double q = s[j] + h * (v[j] + predict_u * a[j]);
            s[j] = q;
            sum[lane] += reaction[j] * q;
        }
    }
    for (; i < n; i++) {
        const double q = s[i] + h * (v[i] + predict_u * a[i]);
        s[i] = q;
        sum[0] += reaction[i] * q;
    }
    return (sum[0] + sum[1]) + (sum[2] + sum[3]);
}

static void contact_predict(const aoi_rule_step *step, double *u, double *v, const double *a)
{
    *u += step->dt * (*v + step->predict_u * *a);
    *v += step->predict_v * *a;
}

static int star_predict(aoi_body *body, double *displacement, double *velocity)
{
    const aoi_star *star = body->model;
    const aoi_rule_step *step = &body->step;
    const size_t n = star->n;
    double *c = body->scratch, *u = state_u(body), *v = state_v(body, n), *a = state_a(body, n);
    if (c[MASSLESS] == 0.0) {
        contact_predict(step, u, v, a);
    }
    const double push = oscillators_predict(n, step, reaction_of(body, n), u + 1, v + 1, a + 1);
    c[FREE_A] = (push + c[FALL] - star->k0 * u[0]) * c[MOBILITY];
    const double rise = step->dt * (step->correct_u * c[FREE_A]);
    *displacement = u[0] + rise;
    *velocity = c[MASSLESS] == 0.0 ? v[0] + step->correct_v * c[FREE_A] : rise / step->dt;
    return AOI_OK;
}

static int damped_predict(aoi_body *body, double *displacement, double *velocity)
{
    const aoi_star *star = body->model;
    const aoi_rule_step *step = &body->step;
    const size_t n = star->n;
    double *c = body->scratch, *u = state_u(body), *v = state_v(body, n), *a = state_a(body, n);
    double *effective = effective_of(body, n);
    const double *reaction = reaction_of(body, n), *drag = drag_of(body, n);
    double push = c[FALL];
    contact_predict(step, u, v, a);
    for (size_t i = 0; i < n; i++) {
        contact_predict(step, &u[i + 1], &v[i + 1], &a[i + 1]);
        const double speed = v[0] + v[i + 1];
        effective[i] = u[i + 1] + c[BETA] * v[i + 1] + drag[i] * speed;
        push += reaction[i] * effective[i] - c[ALPHA] * star->m[i] * speed;
    }
    push -= star->k0 * (u[0] + c[BETA] * v[0]);
    if (!isinf(star->m0)) {
        push -= c[ALPHA] * star->m0 * v[0];
    }
    c[FREE_A] = push * c[MOBILITY];
    *displacement = u[0] + step->dt * (step->correct_u * c[FREE_A]);
    *velocity = v[0] + step->correct_v * c[FREE_A];
    return AOI_OK;
}

/* lead: acceleration of what the stretch is measured from. */
static void oscillators_correct(size_t n, double lead, const aoi_rule_step *step,
                                const double *restrict gain, double *restrict s,
                                double *restrict v, double *restrict a)
{
    const double rise = step->reach * lead;
    const double h = step->dt, correct_u = step->correct_u, correct_v = step->correct_v;
    const double predict_v = step->predict_v;
    for (size_t i = 0; i < n; i++) {
        const double own = gain[i] * (rise - s[i]) - lead;
        v[i] = (v[i] + predict_v * a[i]) + correct_v * own;
        s[i] += h * (correct_u * own);
        a[i] = own;
    }
}

/* The same where rates and accelerations are not relative to the contact's. */
static void absolute_correct(size_t n, double lead, const aoi_rule_step *step,
                             const double *restrict gain, double *restrict s, double *restrict v,
                             double *restrict a)
{
    const double rise = step->reach * lead;
    for (size_t i = 0; i < n; i++) {
        const double own = gain[i] * (rise - s[i]);
        v[i] = (v[i] + step->predict_v * a[i]) + step->correct_v * own;
        s[i] += step->dt * (step->correct_u * (own - lead));
        a[i] = own;
    }
}

static void star_correct(aoi_body *body, const double *force)
{
    const aoi_star *star = body->model;
    const aoi_rule_step *step = &body->step;
    const size_t n = star->n;
    double *c = body->scratch, *u = state_u(body), *v = state_v(body, n), *a = state_a(body, n);
    const double lead = c[FREE_A] + *force * c[MOBILITY];
    const double rise = step->dt * (step->correct_u * lead);
    u[0] += rise;
    if (c[MASSLESS] == 0.0) {
        a[0] = lead;
        v[0] += step->correct_v * lead;
        c[RATE] = v[0];
        oscillators_correct(n, lead, step, gain_of(body, n), u + 1, v + 1, a + 1);
    } else {
        c[RATE] = rise / step->dt;
        absolute_correct(n, lead, step, gain_of(body, n), u + 1, v + 1, a + 1);
    }
}

/* Adds the new acceleration; returns the sum of the rates before and after the step. */
static double damped_move(const aoi_rule_step *step, double acceleration, double *u, double *v,
                          double *a)
{
    const double before = *v - step->predict_v * *a;
    *a = acceleration;
    *v += step->correct_v * *a;
    *u += step->dt * (step->correct_u * *a);
    return before + *v;
}

static void damped_correct(aoi_body *body, const double *force)
{
    const aoi_star *star = body->model;
    const size_t n = star->n;
    double *c = body->scratch, *u = state_u(body), *v = state_v(body, n), *a = state_a(body, n);
    const double *gain = gain_of(body, n), *effective = effective_of(body, n);
    const double lead = c[FREE_A] + *force * c[MOBILITY];
    const double twice_v0 = damped_move(&body->step, lead, u, v, a);
    double of_mass = isinf(star->m0) ? 0.0 : star->m0 * twice_v0 * twice_v0;
    double of_springs = star->k0 * twice_v0 * twice_v0;
    for (size_t i = 0; i < n; i++) {
        const double own = gain[i] * (c[REACH] * lead - effective[i]);
        const double rate = damped_move(&body->step, own - lead, &u[i + 1], &v[i + 1], &a[i + 1]);
        of_mass += star->m[i] * (twice_v0 + rate) * (twice_v0 + rate);
        of_springs += star->k[i] * rate * rate;
    }
    c[RATE] = v[0];
    c[LOST] += 0.25 * body->step.dt * (c[ALPHA] * of_mass + c[BETA] * of_springs);
}

/* How much longer an oscillator's spring is than the stretch in the state. */
static double deflection(const aoi_body *body, size_t i)
{
    const aoi_star *star = body->model;
    return body->gravity ? body->gravity[i + 1] / star->k[i] : 0.0;
}

/* sum weight_i (x_i + shift)^2, by four partial sums. */
static double weighted_squares(size_t n, const double *weight, const double *x, double shift)
{
    double sum[4] = {0.0, 0.0, 0.0, 0.0};
    size_t i = 0;
    for (; i + 4 <= n; i += 4) {
        for (size_t lane = 0; lane < 4; lane++) {
            const double y = x[i + lane] + shift;
            sum[lane] += weight[i + lane] * y * y;
        }
    }
    for (; i < n; i++) {
        sum[0] += weight[i] * (x[i] + shift) * (x[i] + shift);
    }
    return (sum[0] + sum[1]) + (sum[2] + sum[3]);
}

static double star_elastic(const aoi_body *body)
{
    const aoi_star *star = body->model;
    const double *u = state_u(body), *stretch = u + 1;
    double twice = star->k0 * u[0] * u[0];
    if (!body->gravity) {
        return 0.5 * (twice + weighted_squares(star->n, star->k, stretch, 0.0));
    }
    for (size_t i = 0; i < star->n; i++) {
        const double whole = stretch[i] + deflection(body, i);
        twice += star->k[i] * whole * whole;
    }
    return 0.5 * twice;
}

static double star_gravity_work(const aoi_body *body)
{
    const double *u = state_u(body);
    double work = body->scratch[FALL] * u[0];
    for (size_t i = 0; i < ((const aoi_star *)body->model)->n; i++) {
        work += body->gravity[i + 1] * (u[i + 1] + deflection(body, i));
    }
    return work;
}

static double star_kinetic(const aoi_body *body)
{
    const aoi_star *star = body->model;
    const double *v = state_v(body, star->n);
    const double of_contact = isinf(star->m0) ? 0.0 : star->m0 * v[0] * v[0];
    return 0.5 * (of_contact + weighted_squares(star->n, star->m, v + 1, v[0]));
}

static void star_observe(const aoi_body *body, int energies, double *row, size_t stride)
{
    const size_t n = ((const aoi_star *)body->model)->n;
    const double *u = state_u(body), *v = state_v(body, n), *weight = body->centre;
    const double all = body->scratch[CENTRE], contact_rate = body->scratch[RATE];
    double centre = all * u[0] + body->scratch[DEFLECTION];
    double rate = weight[0] * contact_rate + (all - weight[0]) * v[0];
    if (n > 0) {
        centre += aoi_vector_dot(n, weight + 1, u + 1);
        rate += aoi_vector_dot(n, weight + 1, v + 1);
    }
    row[AOI_BODY_CENTRE * stride] = centre;
    row[AOI_BODY_CENTRE_VELOCITY * stride] = rate;
    row[AOI_BODY_ROWS * stride] = u[0];
    row[(AOI_BODY_ROWS + 1) * stride] = contact_rate;
    if (energies) {
        row[AOI_BODY_KINETIC * stride] = star_kinetic(body);
        row[AOI_BODY_ELASTIC * stride] = star_elastic(body);
        row[AOI_BODY_DISSIPATED * stride] = body->scratch[LOST];
        row[AOI_BODY_WORK * stride] = body->gravity ? star_gravity_work(body) : 0.0;
    }
}

static void star_copy_state(const aoi_body *body, double *u_out, double *v_out)
{
    const size_t n = ((const aoi_star *)body->model)->n;
    const double *u = state_u(body), *v = state_v(body, n);
    u_out[0] = u[0];
    v_out[0] = body->scratch[RATE];
    for (size_t i = 1; i <= n; i++) {
        u_out[i] = u[0] + (u[i] + deflection(body, i - 1));
        v_out[i] = v[0] + v[i];
    }
}

/* m_0 a_0 = the forces on the contact mass, m_i (a_0 + a_i) = those on an oscillator. */
static int star_begin(aoi_body *body, const double *force)
{
    const aoi_star *star = body->model;
    const size_t n = star->n;
    const double *c = body->scratch, *u = state_u(body), *v = state_v(body, n);
    double *a = state_a(body, n), sum = -star->k0 * (u[0] + c[BETA] * v[0]) + c[FALL] + *force;
    for (size_t i = 0; i < n; i++) {
        sum += star->k[i] * (u[i + 1] + c[BETA] * v[i + 1]);
    }
    a[0] = c[MASSLESS] == 0.0 ? sum / star->m0 - c[ALPHA] * v[0] : 0.0;
    for (size_t i = 0; i < n; i++) {
        a[i + 1] = -(star->k[i] / star->m[i]) * (u[i + 1] + c[BETA] * v[i + 1]) -
                   c[ALPHA] * (v[0] + v[i + 1]) - a[0];
    }
    return AOI_OK;
}

/* The state at the start, w_i and m_i w_i, and the sums over the coordinates. */
static void star_fill(const aoi_body *body, const aoi_body_start *start, double *c)
{
    const aoi_star *star = body->model;
    const size_t n = star->n;
    double *u = state_u(body), *v = state_v(body, n);
    double *gain = gain_of(body, n), *reaction = reaction_of(body, n);
    const double inertia = 1.0 + c[ALPHA] * body->step.correct_v;
    double stiffness = star->k0;
    u[0] = start->u[0];
    v[0] = c[MASSLESS] == 0.0 ? start->v[0] : 0.0;
    c[CENTRE] = start->centre[0];
    c[FALL] = start->gravity ? start->gravity[0] : 0.0;
    for (size_t i = 0; i < n; i++) {
        const double mass = inertia * star->m[i];
        gain[i] = star->k[i] / (mass + c[REACH] * star->k[i]);
        reaction[i] = gain[i] * mass;
        stiffness += reaction[i];
        u[i + 1] = start->u[i + 1] - u[0] - deflection(body, i);
        v[i + 1] = start->v[i + 1] - v[0];
        c[CENTRE] += start->centre[i + 1];
        c[DEFLECTION] += start->centre[i + 1] * deflection(body, i);
        c[FALL] += start->gravity ? start->gravity[i + 1] : 0.0;
    }
    c[RATE] = start->v[0];
    c[MOBILITY] = 1.0 / (inertia * star->m0 + c[REACH] * stiffness);
}

static void damped_fill(aoi_body *body)
{
    const aoi_star *star = body->model;
    double *drag = drag_of(body, star->n);
    body->predict = damped_predict;
    body->correct = damped_correct;
    for (size_t i = 0; i < star->n; i++) {
        drag[i] = body->scratch[ALPHA] * star->m[i] / star->k[i];
    }
}

int aoi_body_start_star(aoi_body *body, const aoi_star *star, const aoi_rayleigh *damping,
                        const aoi_rule *rule, const aoi_body_start *start, double *work)
{
    const aoi_rayleigh none = {0.0, 0.0}, *d = damping ? damping : &none;
    const int damped = d->alpha != 0.0 || d->beta != 0.0;
    aoi_rule_step step;
    int status = aoi_star_check(star);
    if (status == AOI_OK) {
        status = aoi_rule_prepare(rule, &step);
    }
    if (status == AOI_OK && (!(d->alpha >= 0.0) || !(d->beta >= 0.0) ||
                             !isfinite(d->alpha + d->beta) || (damped && star->m0 == 0.0))) {
        status = AOI_ERROR_ARGUMENT;
    }
    if (status != AOI_OK) {
        return status;
    }
    double *compliance = work + aoi_body_star_size(star->n) - 2, *rate_compliance = compliance + 1;
    *body = (aoi_body){star_begin,     star_predict,    star_correct, star_observe,
                       star_copy_state, 1,              compliance,   rate_compliance,
                       star,           start->centre,   start->gravity, work,
                       step,           {0}};
    double *c = body->scratch;
    c[MASSLESS] = star->m0 == 0.0;
    c[ALPHA] = d->alpha;
    c[BETA] = d->beta;
    c[REACH] = step.reach + d->beta * step.correct_v;
    star_fill(body, start, c);
    if (damped) {
        damped_fill(body);
    }
    *compliance = step.reach * c[MOBILITY];
    *rate_compliance = (star->m0 > 0.0 ? step.correct_v : step.reach / step.dt) * c[MOBILITY];
    return isfinite(*compliance) && isfinite(*rate_compliance) ? AOI_OK : AOI_ERROR_NOT_FINITE;
}
