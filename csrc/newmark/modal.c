/* Newmark's rule on natural modes, each an oscillator of its own with any damping:
 *   (1 + 2 decay gamma dt + omega^2 beta dt^2) a' = f - omega^2 p - 2 decay q
 * with the predictors p, q of displacement and velocity. What the modes leave of the static compliance
 * follows the forces at once. */
#include "newmark/body.h"
#include "linear/vector.h"
#include "linear/work.h"
#include "model/modes.h"

#include <math.h>
#include <string.h>

enum { LOST };

/* state by the mode: x, v, a, the free acceleration, the acceleration of a unit force in a step, twice the
 * dashpot; by the port: the last force and the one before; compliance, rate compliance. */
enum { X, V, A, FREE_A, MOBILITY, DASHPOT, PARTS };

size_t aoi_body_modal_size(size_t n, size_t ports) 
{
    return aoi_plus(aoi_times(PARTS, n), aoi_times(2 * ports, 1 + ports));
}

static const aoi_modes *modes_of(const aoi_body *body) { return body->model; }

static double *part(const aoi_body *body, size_t which)
{
    return body->state + which * modes_of(body)->n;
}

static double *force_of(const aoi_body *body) { return part(body, PARTS); }

static double twice_decay(const aoi_modes *modes, size_t j)
{
    return modes->decay ? 2.0 * modes->decay[j] : 0.0;
}

/* Row p of the residual times forces. */
static double residual_times(const aoi_modes *modes, size_t p, const double *force)
{
    return modes->residual ? aoi_vector_dot(modes->ports, modes->residual + p * modes->ports, force)
                           : 0.0;
}

/* What is left of a mode's acceleration without forces at the ports: gravity - omega^2 x - 2 decay v. */
static double modal_drive(const aoi_body *body, size_t j, double x, double v)
{
    const aoi_modes *modes = modes_of(body);
    const double gravity = modes->gravity ? modes->gravity[j] : 0.0;
    return gravity - modes->omega[j] * (modes->omega[j] * x) - twice_decay(modes, j) * v;
}

static int modal_predict(aoi_body *body, double *displacement, double *velocity)
{
    const aoi_modes *modes = modes_of(body);
    const aoi_rule_step *step = &body->step;
    const size_t n = modes->n;
    double *x = part(body, X), *v = part(body, V), *free_a = part(body, FREE_A);
    const double *a = part(body, A), *mobility = part(body, MOBILITY);
    for (size_t j = 0; j < n; j++) {
        x[j] += step->dt * (v[j] + step->predict_u * a[j]);
        v[j] += step->predict_v * a[j];
        free_a[j] = mobility[j] * modal_drive(body, j, x[j], v[j]);
    }
    for (size_t p = 0; p < modes->ports; p++) {
        const double *r = modes->shape + p * n, reached = aoi_vector_dot(n, r, free_a);
        displacement[p] = aoi_vector_dot(n, r, x) + step->reach * reached;
        velocity[p] = aoi_vector_dot(n, r, v) + step->correct_v * reached -
                      residual_times(modes, p, force_of(body)) / step->dt;
    }
    return AOI_OK;
}

static void modal_correct(aoi_body *body, const double *force)
{
    const aoi_modes *modes = modes_of(body);
    const aoi_rule_step *step = &body->step;
    const size_t n = modes->n, ports = modes->ports;
    double *x = part(body, X), *v = part(body, V), *a = part(body, A), power = 0.0;
    const double *free_a = part(body, FREE_A), *mobility = part(body, MOBILITY);
    const double *dashpot = part(body, DASHPOT);
    for (size_t j = 0; j < n; j++) {
        const double before = v[j] - step->predict_v * a[j];
        double push = 0.0;
        for (size_t p = 0; p < ports; p++) {
            push += modes->push[p * n + j] * force[p];
        }
        a[j] = free_a[j] + mobility[j] * push;
        v[j] += step->correct_v * a[j];
        x[j] += step->dt * (step->correct_u * a[j]);
        power += dashpot[j] * (before + v[j]) * (before + v[j]);
    }
    body->scratch[LOST] += 0.25 * step->dt * power;
    memcpy(force_of(body) + ports, force_of(body), ports * sizeof(double));
    memcpy(force_of(body), force, ports * sizeof(double));
}

/* x^T y, each mode by its inertia. */
static double weighted_dot(const aoi_modes *modes, const double *x, const double *y)
{
    double sum = 0.0;
    for (size_t j = 0; modes->inertia && j < modes->n; j++) {
        sum += modes->inertia[j] * x[j] * y[j];
    }
    return modes->inertia ? sum : aoi_vector_dot(modes->n, x, y);
}

static double modal_elastic(const aoi_body *body)
{
    const aoi_modes *modes = modes_of(body);
    const double *x = part(body, X), *force = force_of(body);
    double twice = 0.0;
    for (size_t j = 0; j < modes->n; j++) {
        const double pull = modes->omega[j] * x[j];
        twice += aoi_modes_inertia(modes, j) * pull * pull;
    }
    for (size_t p = 0; p < modes->ports; p++) {
        twice += force[p] * residual_times(modes, p, force);
    }
    return 0.5 * twice;
}

static void modal_observe(const aoi_body *body, int energies, double *row, size_t stride)
{
    const aoi_modes *modes = modes_of(body);
    const size_t n = modes->n, ports = modes->ports;
    const double *x = part(body, X), *v = part(body, V), *force = force_of(body);
    row[AOI_BODY_CENTRE * stride] = aoi_vector_dot(n, modes->centre, x);
    row[AOI_BODY_CENTRE_VELOCITY * stride] = aoi_vector_dot(n, modes->centre, v);
    for (size_t p = 0; modes->centre_residual && p < ports; p++) {
        const double change = force[p] - force[ports + p];
        row[AOI_BODY_CENTRE * stride] += modes->centre_residual[p] * force[p];
        row[AOI_BODY_CENTRE_VELOCITY * stride] += modes->centre_residual[p] * (change / body->step.dt);
    }
    for (size_t p = 0; p < ports; p++) {
        const double *r = modes->shape + p * n;
        const double settled = residual_times(modes, p, force);
        const double moved = settled - residual_times(modes, p, force + ports);
        double *port = row + (AOI_BODY_ROWS + AOI_PORT_ROWS * p) * stride;
        port[0] = aoi_vector_dot(n, r, x) + settled;
        port[stride] = aoi_vector_dot(n, r, v) + moved / body->step.dt;
    }
    if (energies) {
        row[AOI_BODY_KINETIC * stride] = 0.5 * weighted_dot(modes, v, v);
        row[AOI_BODY_ELASTIC * stride] = modal_elastic(body);
        row[AOI_BODY_DISSIPATED * stride] = body->scratch[LOST];
        row[AOI_BODY_WORK * stride] = modes->gravity ? weighted_dot(modes, modes->gravity, x) : 0.0;
    }
}

static void modal_copy_state(const aoi_body *body, double *u, double *v)
{
    const size_t bytes = modes_of(body)->n * sizeof(double);
    memcpy(u, part(body, X), bytes);
    memcpy(v, part(body, V), bytes);
}

static int modal_begin(aoi_body *body, const double *force)
{
    const aoi_modes *modes = modes_of(body);
    const size_t n = modes->n, ports = modes->ports;
    for (size_t j = 0; j < n; j++) {
        double push = modal_drive(body, j, part(body, X)[j], part(body, V)[j]);
        for (size_t p = 0; p < ports; p++) {
            push += modes->push[p * n + j] * force[p];
        }
        part(body, A)[j] = push;
    }
    return AOI_OK;
}

static int modal_check(const aoi_modes *modes)
{
    for (size_t j = 0; j < modes->n; j++) {
        if (!(modes->omega[j] >= 0.0) || !(twice_decay(modes, j) >= 0.0)) {
            return AOI_ERROR_ARGUMENT;
        }
        if (!isfinite(modes->omega[j] * modes->omega[j]) || !isfinite(twice_decay(modes, j))) {
            return AOI_ERROR_NOT_FINITE;
        }
    }
    if (!aoi_vector_is_finite(modes->ports * modes->n, modes->shape) ||
        !aoi_vector_is_finite(modes->ports * modes->n, modes->push)) {
        return AOI_ERROR_NOT_FINITE;
    }
    return modes->ports >= 1 ? AOI_OK : AOI_ERROR_ARGUMENT;
}

/* Mobilities of the modes, and the ports' compliances as their sums. */
static int modal_prepare(const aoi_body *body, double *compliance, double *rate_compliance)
{
    const aoi_modes *modes = modes_of(body);
    const aoi_rule_step *step = &body->step;
    const size_t n = modes->n, ports = modes->ports;
    double *mobility = part(body, MOBILITY);
    for (size_t j = 0; j < n; j++) {
        const double stiffness = step->reach * modes->omega[j] * modes->omega[j];
        part(body, DASHPOT)[j] = aoi_modes_inertia(modes, j) * twice_decay(modes, j);
        mobility[j] = 1.0 / (1.0 + step->correct_v * twice_decay(modes, j) + stiffness);
    }
    for (size_t i = 0; i < ports * ports; i++) {
        const double *shape = modes->shape + (i / ports) * n;
        const double *push = modes->push + (i % ports) * n;
        const double residual = modes->residual ? modes->residual[i] : 0.0;
        double reached = 0.0;
        for (size_t j = 0; j < n; j++) {
            reached += mobility[j] * shape[j] * push[j];
        }
        compliance[i] = step->reach * reached + residual;
        rate_compliance[i] = step->correct_v * reached + residual / step->dt;
        if (!isfinite(compliance[i]) || !isfinite(rate_compliance[i])) {
            return AOI_ERROR_NOT_FINITE;
        }
    }
    return AOI_OK;
}

int aoi_body_start_modal(aoi_body *body, const aoi_modes *modes, const aoi_rule *rule,
                         const aoi_body_start *start, double *work)
{
    const size_t n = modes->n, ports = modes->ports;
    aoi_rule_step step;
    int status = aoi_rule_prepare(rule, &step);
    if (status == AOI_OK) {
        status = modal_check(modes);
    }
    if (status != AOI_OK) {
        return status;
    }
    double *compliance = work + PARTS * n + 2 * ports, *rate_compliance = compliance + ports * ports;
    *body = (aoi_body){modal_begin,      modal_predict, modal_correct,  modal_observe,
                       modal_copy_state, ports,         compliance,     rate_compliance,
                       modes,            modes->centre, modes->gravity, work,
                       step,             {0}};
    memcpy(part(body, X), start->u, n * sizeof(double));
    memcpy(part(body, V), start->v, n * sizeof(double));
    for (size_t p = 0; p < ports; p++) {
        force_of(body)[p] = start->force ? start->force[p] : 0.0;
        force_of(body)[ports + p] =
            start->force ? start->force[p] - step.dt * start->force[ports + p] : 0.0;
    }
    return modal_prepare(body, compliance, rate_compliance);
}
