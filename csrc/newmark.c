/* Newmark's rule on a star (section 3.1 of the paper, on the model of section 2). An oscillator's
 * equation has only its own and the contact mass's acceleration in it: eliminated by hand, the whole
 * star is one scalar equation, and a step costs O(n).
 *
 * The oscillators are stepped by their stretch s = u_i - u_0, not by their place: a free body may fly
 * far, and the rounding of its place would act on its springs. With p the predictor of u_0, q that of
 * a stretch, and a' the new accelerations, u_0' = p + beta dt^2 a_0', s' = q + beta dt^2 (a_i' - a_0'):
 *   m_i a_i' = -k_i s'   gives   a_i' = w_i (beta dt^2 a_0' - q_i),  w_i = k_i / (m_i + beta dt^2 k_i)
 *   (m_0 + beta dt^2 (k_0 + sum m_i w_i)) a_0' = f - k_0 p + sum m_i w_i q_i
 * Solving for accelerations, not displacements, keeps their digits where dt is small. Displacements
 * are formed as dt (v + dt/4 a), never with a rounded dt^2: its ratio to dt is what keeps the energy.
 *
 * Without m0 the contact has no acceleration of its own: it stays where it was as a predictor, the
 * stretches' rates and accelerations are then the oscillators' own, and a_0' stands for its move. */
#include "aoimpact.h"

#include <math.h>

enum { DT, PREDICT_U, PREDICT_V, CORRECT_U, CORRECT_V, REACH, INERTIA, FREE_A, MASSLESS, RATE, CENTRE };

size_t aoi_body_star_size(size_t n) { return 5 * n + 3; }

/* state: u_0 and the stretches, their rates, their accelerations; then w_i and m_i w_i. */
static double *state_u(const aoi_body *body) { return body->state; }
static double *state_v(const aoi_body *body, size_t n) { return body->state + (n + 1); }
static double *state_a(const aoi_body *body, size_t n) { return body->state + 2 * (n + 1); }
static double *gain_of(const aoi_body *body, size_t n) { return body->state + 3 * (n + 1); }
static double *reaction_of(const aoi_body *body, size_t n) { return gain_of(body, n) + n; }

/* s, v, a of the oscillators become their predictors; returns sum m_i w_i q_i. Four partial sums, so
 * that the compiler may keep them in vector registers. */
static double oscillators_predict(size_t n, const double *c, const double *restrict reaction,
                                  double *restrict s, double *restrict v, const double *restrict a)
{
    double sum[4] = {0.0, 0.0, 0.0, 0.0};
    size_t i = 0;
    for (; i + 4 <= n; i += 4) {
        for (size_t lane = 0; lane < 4; lane++) {
            const size_t j = i + lane;
            const double q = s[j] + c[DT] * (v[j] + c[PREDICT_U] * a[j]);
            v[j] += c[PREDICT_V] * a[j];
            s[j] = q;
            sum[lane] += reaction[j] * q;
        }
    }
    for (; i < n; i++) {
        const double q = s[i] + c[DT] * (v[i] + c[PREDICT_U] * a[i]);
        v[i] += c[PREDICT_V] * a[i];
        s[i] = q;
        sum[0] += reaction[i] * q;
    }
    return (sum[0] + sum[1]) + (sum[2] + sum[3]);
}

static int star_predict(aoi_body *body, double *displacement, double *velocity)
{
    const aoi_star *star = body->model;
    const size_t n = star->n;
    double *c = body->scratch, *u = state_u(body), *v = state_v(body, n), *a = state_a(body, n);
    if (c[MASSLESS] == 0.0) {
        u[0] += c[DT] * (v[0] + c[PREDICT_U] * a[0]);
        v[0] += c[PREDICT_V] * a[0];
    }
    const double push = oscillators_predict(n, c, reaction_of(body, n), u + 1, v + 1, a + 1);
    c[FREE_A] = (push - star->k0 * u[0]) / c[INERTIA];
    const double rise = c[DT] * (c[CORRECT_U] * c[FREE_A]);
    *displacement = u[0] + rise;
    *velocity = c[MASSLESS] == 0.0 ? v[0] + c[CORRECT_V] * c[FREE_A] : rise / c[DT];
    return AOI_OK;
}

/* lead: acceleration of what the stretch is measured from; of_rate: of what its rate is. */
static void oscillators_correct(size_t n, double lead, double of_rate, const double *c,
                                const double *restrict gain, double *restrict s,
                                double *restrict v, double *restrict a)
{
    const double rise = c[REACH] * lead;
    for (size_t i = 0; i < n; i++) {
        const double own = gain[i] * (rise - s[i]);
        a[i] = own - of_rate;
        v[i] += c[CORRECT_V] * a[i];
        s[i] += c[DT] * (c[CORRECT_U] * (own - lead));
    }
}

static void star_correct(aoi_body *body, double force)
{
    const aoi_star *star = body->model;
    const size_t n = star->n;
    double *c = body->scratch, *u = state_u(body), *v = state_v(body, n), *a = state_a(body, n);
    const double lead = c[FREE_A] + force / c[INERTIA];
    const double rise = c[DT] * (c[CORRECT_U] * lead);
    u[0] += rise;
    if (c[MASSLESS] == 0.0) {
        a[0] = lead;
        v[0] += c[CORRECT_V] * lead;
        c[RATE] = v[0];
    } else {
        c[RATE] = rise / c[DT];
    }
    oscillators_correct(n, lead, a[0], c, gain_of(body, n), u + 1, v + 1, a + 1);
}

static void star_energy(const aoi_body *body, double *kinetic, double *elastic)
{
    const aoi_star *star = body->model;
    const size_t n = star->n;
    const double *u = state_u(body), *v = state_v(body, n);
    double twice_kinetic = isinf(star->m0) ? 0.0 : star->m0 * v[0] * v[0];
    double twice_elastic = star->k0 * u[0] * u[0];
    for (size_t i = 0; i < n; i++) {
        const double speed = v[0] + v[i + 1];
        twice_kinetic += star->m[i] * speed * speed;
        twice_elastic += star->k[i] * u[i + 1] * u[i + 1];
    }
    *kinetic = 0.5 * twice_kinetic;
    *elastic = 0.5 * twice_elastic;
}

static void star_observe(const aoi_body *body, int energies, aoi_observation *seen)
{
    const aoi_star *star = body->model;
    const size_t n = star->n;
    const double *u = state_u(body), *v = state_v(body, n), *weight = body->centre;
    const double all = body->scratch[CENTRE], contact_rate = body->scratch[RATE];
    const double centre = all * u[0] + aoi_vector_dot(n, weight + 1, u + 1);
    const double rate = weight[0] * contact_rate + (all - weight[0]) * v[0] +
                        aoi_vector_dot(n, weight + 1, v + 1);
    seen->displacement = u[0];
    seen->velocity = contact_rate;
    seen->centre_displacement = centre;
    seen->centre_velocity = rate;
    if (energies) {
        star_energy(body, &seen->kinetic, &seen->elastic);
    }
}

static void star_copy_state(const aoi_body *body, double *u_out, double *v_out)
{
    const size_t n = ((const aoi_star *)body->model)->n;
    const double *u = state_u(body), *v = state_v(body, n);
    u_out[0] = u[0];
    v_out[0] = body->scratch[RATE];
    for (size_t i = 1; i <= n; i++) {
        u_out[i] = u[0] + u[i];
        v_out[i] = v[0] + v[i];
    }
}

/* The state at the start, and w_i, m_i w_i; returns k_0 + sum m_i w_i. */
static double star_fill(const aoi_body *body, const double *u0, const double *v0, double reach)
{
    const aoi_star *star = body->model;
    const size_t n = star->n;
    const int massless = star->m0 == 0.0;
    double *u = state_u(body), *v = state_v(body, n), *a = state_a(body, n);
    double *gain = gain_of(body, n), *reaction = reaction_of(body, n);
    double force = -star->k0 * u0[0], stiffness = star->k0;
    for (size_t i = 0; i < n; i++) {
        gain[i] = star->k[i] / (star->m[i] + reach * star->k[i]);
        reaction[i] = gain[i] * star->m[i];
        stiffness += reaction[i];
        force += star->k[i] * (u0[i + 1] - u0[0]);
    }
    u[0] = u0[0];
    v[0] = massless ? 0.0 : v0[0];
    a[0] = massless ? 0.0 : force / star->m0;
    for (size_t i = 1; i <= n; i++) {
        u[i] = u0[i] - u0[0];
        v[i] = v0[i] - v[0];
        a[i] = -(star->k[i - 1] / star->m[i - 1]) * u[i] - a[0];
    }
    return stiffness;
}

int aoi_body_start_star(aoi_body *body, const aoi_star *star, const aoi_newmark *rule,
                        const double *centre, const double *u0, const double *v0, double *work)
{
    const double h = rule->dt, reach = rule->beta * h * h;
    const int status = aoi_star_check(star);
    if (status != AOI_OK) {
        return status;
    }
    if (!(h > 0.0) || !(rule->beta > 0.0) || !(rule->gamma >= 0.5) || !isfinite(h)) {
        return AOI_ERROR_ARGUMENT;
    }
    *body = (aoi_body){star_predict, star_correct, star_observe, star_copy_state, 0.0, 0.0,
                       star,         centre,       work,         {0}};
    double *c = body->scratch;
    const double stiffness = star_fill(body, u0, v0, reach);
    c[DT] = h;
    c[PREDICT_U] = h * (0.5 - rule->beta);
    c[PREDICT_V] = h * (1.0 - rule->gamma);
    c[CORRECT_U] = h * rule->beta;
    c[CORRECT_V] = h * rule->gamma;
    c[REACH] = reach;
    c[INERTIA] = star->m0 + reach * stiffness;
    c[MASSLESS] = star->m0 == 0.0;
    c[RATE] = v0[0];
    for (size_t i = 0; i <= star->n; i++) {
        c[CENTRE] += centre[i];
    }
    body->compliance = reach / c[INERTIA];
    body->rate_compliance = (star->m0 > 0.0 ? c[CORRECT_V] : reach / h) / c[INERTIA];
    return AOI_OK;
}
