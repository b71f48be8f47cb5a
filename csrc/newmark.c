/* Newmark's rule on a star (section 3.1 of the paper, on the model of section 2). An oscillator's
 * equation has only its own and the contact mass's acceleration in it: eliminated by hand, the whole
 * star is one scalar equation, and a step costs O(n).
 *
 * With p the predictor and a' the new accelerations, u' = p + beta dt^2 a':
 *   m_i a_i' = k_i (u_0' - u_i')   gives   a_i' = w_i (u_0' - p_i),  w_i = k_i / (m_i + beta dt^2 k_i)
 *   (m_0 + beta dt^2 (k_0 + sum m_i w_i)) a_0' = f - k_0 p_0 - sum m_i w_i (p_0 - p_i)
 * Solving for accelerations, not displacements, keeps their digits where dt is small. */
#include "aoimpact.h"

#include <math.h>

enum { DT, PREDICT_U, PREDICT_V, CORRECT_U, CORRECT_V, INERTIA, FREE_A, MASSLESS };

size_t aoi_body_star_size(size_t n) { return 5 * n + 3; }

static double *state_u(const aoi_body *body) { return body->state; }
static double *state_v(const aoi_body *body, size_t n) { return body->state + (n + 1); }
static double *state_a(const aoi_body *body, size_t n) { return body->state + 2 * (n + 1); }
static double *gain_of(const aoi_body *body, size_t n) { return body->state + 3 * (n + 1); }
static double *reaction_of(const aoi_body *body, size_t n) { return gain_of(body, n) + n; }

/* u, v, a of the oscillators become their predictors; returns sum m_i w_i (p_0 - p_i). Four partial
 * sums, so that the compiler may keep them in vector registers. */
static double oscillators_predict(size_t n, double p0, const double *c, const double *reaction,
                                  double *u, double *v, const double *a)
{
    double sum[4] = {0.0, 0.0, 0.0, 0.0};
    size_t i = 0;
    for (; i + 4 <= n; i += 4) {
        for (size_t lane = 0; lane < 4; lane++) {
            const size_t j = i + lane;
            const double p = u[j] + c[DT] * v[j] + c[PREDICT_U] * a[j];
            v[j] += c[PREDICT_V] * a[j];
            u[j] = p;
            sum[lane] += reaction[j] * (p0 - p);
        }
    }
    for (; i < n; i++) {
        const double p = u[i] + c[DT] * v[i] + c[PREDICT_U] * a[i];
        v[i] += c[PREDICT_V] * a[i];
        u[i] = p;
        sum[0] += reaction[i] * (p0 - p);
    }
    return (sum[0] + sum[1]) + (sum[2] + sum[3]);
}

static int star_predict(aoi_body *body, double *displacement, double *velocity)
{
    const aoi_star *star = body->model;
    const size_t n = star->n;
    double *c = body->scratch, *u = state_u(body), *v = state_v(body, n), *a = state_a(body, n);
    const double before = u[0];
    if (c[MASSLESS] == 0.0) {
        u[0] += c[DT] * v[0] + c[PREDICT_U] * a[0];
        v[0] += c[PREDICT_V] * a[0];
    }
    const double pull =
        oscillators_predict(n, u[0], c, reaction_of(body, n), u + 1, v + 1, a + 1);
    c[FREE_A] = (-star->k0 * u[0] - pull) / c[INERTIA];
    *displacement = u[0] + c[CORRECT_U] * c[FREE_A];
    *velocity = c[MASSLESS] == 0.0 ? v[0] + c[CORRECT_V] * c[FREE_A]
                                   : (*displacement - before) / c[DT];
    return AOI_OK;
}

static void oscillators_correct(size_t n, double u0, const double *c, const double *gain, double *u,
                                double *v, double *a)
{
    for (size_t i = 0; i < n; i++) {
        const double new_a = gain[i] * (u0 - u[i]);
        a[i] = new_a;
        v[i] += c[CORRECT_V] * new_a;
        u[i] += c[CORRECT_U] * new_a;
    }
}

static void star_correct(aoi_body *body, double force)
{
    const aoi_star *star = body->model;
    const size_t n = star->n;
    const double *c = body->scratch;
    double *u = state_u(body), *v = state_v(body, n), *a = state_a(body, n);
    const double a0 = c[FREE_A] + force / c[INERTIA];
    const double u0 = u[0] + c[CORRECT_U] * a0;
    oscillators_correct(n, u0, c, gain_of(body, n), u + 1, v + 1, a + 1);
    a[0] = a0;
    v[0] = c[MASSLESS] == 0.0 ? v[0] + c[CORRECT_V] * a0 : (u0 - u[0]) / c[DT];
    u[0] = u0;
}

static void star_observe(const aoi_body *body, int energies, aoi_observation *seen)
{
    const aoi_star *star = body->model;
    const size_t n = star->n;
    const double *u = state_u(body), *v = state_v(body, n);
    double centre = 0.0, centre_velocity = 0.0;
    for (size_t i = 0; i <= n; i++) {
        centre += body->centre[i] * u[i];
        centre_velocity += body->centre[i] * v[i];
    }
    seen->displacement = u[0];
    seen->velocity = v[0];
    seen->centre_displacement = centre;
    seen->centre_velocity = centre_velocity;
    if (energies) {
        aoi_star_energy(star, u, v, &seen->kinetic, &seen->elastic);
    }
}

int aoi_body_start_star(aoi_body *body, const aoi_star *star, const aoi_newmark *rule,
                        const double *centre, const double *u0, const double *v0, double *work)
{
    const size_t n = star->n;
    const double h = rule->dt, reach = rule->beta * h * h;
    const int status = aoi_star_check(star);
    if (status != AOI_OK) {
        return status;
    }
    if (!(h > 0.0) || !(rule->beta > 0.0) || !(rule->gamma >= 0.5) || !isfinite(h)) {
        return AOI_ERROR_ARGUMENT;
    }
    *body = (aoi_body){star_predict, star_correct, star_observe, 0.0, 0.0, star, centre, work, {0}};
    double *c = body->scratch, *u = state_u(body), *v = state_v(body, n), *a = state_a(body, n);
    double *gain = gain_of(body, n), *reaction = reaction_of(body, n), stiffness = star->k0;
    double force = -star->k0 * u0[0];
    for (size_t i = 0; i < n; i++) {
        gain[i] = star->k[i] / (star->m[i] + reach * star->k[i]);
        reaction[i] = gain[i] * star->m[i];
        stiffness += reaction[i];
        a[i + 1] = star->k[i] / star->m[i] * (u0[0] - u0[i + 1]);
        force -= star->k[i] * (u0[0] - u0[i + 1]);
    }
    for (size_t i = 0; i <= n; i++) {
        u[i] = u0[i];
        v[i] = v0[i];
    }
    a[0] = star->m0 > 0.0 ? force / star->m0 : 0.0;
    c[DT] = h;
    c[PREDICT_U] = h * h * (0.5 - rule->beta);
    c[PREDICT_V] = h * (1.0 - rule->gamma);
    c[CORRECT_U] = reach;
    c[CORRECT_V] = h * rule->gamma;
    c[INERTIA] = star->m0 + reach * stiffness;
    c[MASSLESS] = star->m0 == 0.0;
    body->compliance = reach / c[INERTIA];
    body->rate_compliance = (star->m0 > 0.0 ? c[CORRECT_V] : reach / h) / c[INERTIA];
    return AOI_OK;
}
