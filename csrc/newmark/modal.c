/* Newmark's rule for natural modes, each an independent oscillator with any damping:
 *   (1 + 2 decay gamma dt + omega^2 beta dt^2) a' = f - omega^2 p - 2 decay q
 * with the predictors p of displacement and q of velocity. */
#include "newmark/body.h"
#include "linear/vector.h"
#include "model/modes.h"

#include <math.h>

/* Indices of `own`: omega^2, 2 decay and gravity of each mode, divided by the factor of a' above. */
enum { STIFFNESS, DRAG, DRIVE };

/* A plain body keeps its predictors: q of displacements in own[PLACE], w of rates in free_a. The correction of a
 * step and the prediction of the next are combined in one update: q' = q + dt (w + (gamma + 1/2) dt a), w' = w +
 * dt a. */
enum { PLACE = DRIVE };

/* Indices of weighted sums over the displacement predictors q: displacement and free acceleration of the port
 * (PORT, PORT_A), and of the centre of mass. */
enum { PORT, PORT_A, CENTRE, CENTRE_A };

static double twice_decay(const aoi_modes *modes, size_t j)
{
    return modes->decay ? 2.0 * modes->decay[j] : 0.0;
}

static int modal_prepare(aoi_stepped *body)
{
    const aoi_modes *modes = body->model;
    const size_t n = modes->n;
    for (size_t j = 0; j < n; j++) {
        const double omega = modes->omega[j], inertia = 1.0 + body->step->correct_v * twice_decay(modes, j);
        const double mobility = 1.0 / (inertia + body->step->reach * omega * omega);
        if (!isfinite(omega * omega)) {
            return AOI_ERROR_NOT_FINITE;
        }
        body->own[STIFFNESS][j] = mobility * (omega * omega);
        body->own[DRAG][j] = mobility * twice_decay(modes, j);
        body->own[DRIVE][j] = modes->gravity ? mobility * modes->gravity[j] : 0.0;
        for (size_t p = 0; p < modes->ports; p++) {
            body->gain[p * n + j] = mobility * modes->push[p * n + j];
        }
    }
    if (!modes->decay) {
        body->before = NULL;
    }
    return AOI_OK;
}

static int modal_begin(aoi_stepped *body)
{
    const aoi_modes *modes = body->model;
    for (size_t j = 0; j < modes->n; j++) {
        const double gravity = modes->gravity ? modes->gravity[j] : 0.0, omega = modes->omega[j];
        body->a[j] = gravity - omega * (omega * body->x[j]) - twice_decay(modes, j) * body->v[j] + body->free_a[j];
    }
    return AOI_OK;
}

static int modal_accelerate(aoi_stepped *body)
{
    const size_t n = body->model->n;
    const double *restrict x = body->x, *restrict v = body->v, *restrict stiffness = body->own[STIFFNESS];
    const double *restrict drag = body->own[DRAG], *restrict drive = body->own[DRIVE];
    double *restrict free_a = body->free_a;
    for (size_t j = 0; j < n; j++) {
        free_a[j] = drive[j] - stiffness[j] * x[j];
    }
    for (size_t j = 0; j < n && body->before; j++) {
        free_a[j] -= drag[j] * v[j];
    }
    return AOI_OK;
}

void aoi_plain_start(aoi_stepped *body)
{
    const aoi_rule_step *step = body->step;
    const aoi_modes *modes = body->model;
    double *place = body->own[PLACE], *rate = body->free_a;
    body->centre_reached = 0.0;
    for (size_t j = 0; j < modes->n; j++) {
        place[j] = body->x[j] + step->dt * (body->v[j] + step->predict_u * body->a[j]);
        rate[j] = body->v[j] + step->predict_v * body->a[j];
        double *seen = body->seen + AOI_PLAIN_SEEN * j;
        seen[PORT] = modes->shape[j];
        seen[PORT_A] = -modes->shape[j] * body->own[STIFFNESS][j];
        seen[CENTRE] = modes->centre[j];
        seen[CENTRE_A] = -modes->centre[j] * body->own[STIFFNESS][j];
        body->centre_reached += modes->centre[j] * body->gain[j];
    }
    body->port_rate = aoi_vector_dot(modes->n, modes->shape, rate);
    body->centre_rate = aoi_vector_dot(modes->n, modes->centre, rate);
}

/* Computes sum_j seen[j] place_j for all four weights, row by row: the compiler keeps the sums of even and of odd
 * modes in vector registers. */
static void look(size_t n, const double *restrict seen, const double *restrict place, double *restrict sum)
{
    double even[AOI_PLAIN_SEEN] = {0.0, 0.0, 0.0, 0.0}, odd[AOI_PLAIN_SEEN] = {0.0, 0.0, 0.0, 0.0};
    size_t j = 0;
    for (; j + 2 <= n; j += 2, seen += 2 * AOI_PLAIN_SEEN) {
        for (size_t i = 0; i < AOI_PLAIN_SEEN; i++) {
            even[i] += seen[i] * place[j];
        }
        for (size_t i = 0; i < AOI_PLAIN_SEEN; i++) {
            odd[i] += seen[AOI_PLAIN_SEEN + i] * place[j + 1];
        }
    }
    for (size_t i = 0; i < AOI_PLAIN_SEEN && j < n; i++) {
        even[i] += seen[i] * place[j];
    }
    for (size_t i = 0; i < AOI_PLAIN_SEEN; i++) {
        sum[i] = even[i] + odd[i];
    }
}

void aoi_plain_predict(aoi_stepped *body, double *displacement, double *velocity)
{
    const aoi_rule_step *step = body->step;
    double sum[AOI_PLAIN_SEEN];
    look(body->model->n, body->seen, body->own[PLACE], sum);
    body->port_a = sum[PORT_A];
    body->centre_a = sum[CENTRE_A];
    body->centre[0] = sum[CENTRE];
    *displacement = sum[PORT] + step->reach * body->port_a;
    *velocity = body->port_rate + step->correct_v * body->port_a;
}

/* Advances the predictors place and rate by a step, and sets the accelerations a. */
static void advance(size_t n, double force, const aoi_rule_step *step, const double *restrict gain,
                    const double *restrict stiffness, double *restrict place, double *restrict rate,
                    double *restrict a)
{
    const double h = step->dt, ahead = step->correct_u + step->correct_v + step->predict_u;
    for (size_t j = 0; j < n; j++) {
        const double next = force * gain[j] - stiffness[j] * place[j];
        place[j] += h * (rate[j] + ahead * next);
        rate[j] += h * next;
        a[j] = next;
    }
}

/* Advances the predictors place and rate by a step, and sets x and v at the step's end. */
static void advance_seen(size_t n, double force, const aoi_rule_step *step, const double *restrict gain,
                         const double *restrict stiffness, double *restrict place, double *restrict rate,
                         double *restrict x, double *restrict v)
{
    const double h = step->dt, ahead = step->correct_u + step->correct_v + step->predict_u;
    const double correct_u = step->correct_u, correct_v = step->correct_v;
    for (size_t j = 0; j < n; j++) {
        const double q = place[j], w = rate[j], next = force * gain[j] - stiffness[j] * q;
        place[j] = q + h * (w + ahead * next);
        rate[j] = w + h * next;
        x[j] = q + h * (correct_u * next);
        v[j] = w + correct_v * next;
    }
}

void aoi_plain_correct(aoi_stepped *body, double force, int seen)
{
    const aoi_rule_step *step = body->step;
    const double *gain = body->gain, *stiffness = body->own[STIFFNESS];
    double *place = body->own[PLACE], *rate = body->free_a;
    if (seen) {
        advance_seen(body->model->n, force, step, gain, stiffness, place, rate, body->x, body->v);
    } else {
        advance(body->model->n, force, step, gain, stiffness, place, rate, body->a);
    }
    body->moved = !seen;
    body->port_rate += step->dt * (body->port_a + force * body->reached);
    body->centre_a += force * body->centre_reached;
    body->centre[0] += step->dt * (step->correct_u * body->centre_a);
    body->centre[1] = body->centre_rate + step->correct_v * body->centre_a;
    body->centre_rate += step->dt * body->centre_a;
}

void aoi_stepped_settle(aoi_stepped *body)
{
    const aoi_rule_step *step = body->step;
    for (size_t j = 0; j < body->model->n && body->moved; j++) {
        const double rate = body->free_a[j] - step->predict_v * body->a[j];
        body->x[j] = body->own[PLACE][j] - step->dt * (rate + step->predict_u * body->a[j]);
        body->v[j] = rate;
    }
    body->moved = 0;
}

static double modal_power(const aoi_stepped *body)
{
    double power = 0.0;
    for (size_t j = 0; j < body->model->n; j++) {
        power += aoi_modes_inertia(body->model, j) * twice_decay(body->model, j) * body->before[j] * body->before[j];
    }
    return power;
}

static void modal_observe(const aoi_stepped *body, double *row, size_t stride)
{
    const aoi_modes *modes = body->model;
    double work = 0.0;
    for (size_t j = 0, n = modes->gravity ? modes->n : 0; j < n; j++) {
        work += aoi_modes_inertia(modes, j) * modes->gravity[j] * body->x[j];
    }
    row[AOI_BODY_KINETIC * stride] = 0.5 * aoi_vector_squares(modes->n, modes->inertia, NULL, body->v);
    row[AOI_BODY_ELASTIC * stride] = 0.5 * aoi_vector_squares(modes->n, modes->inertia, modes->omega, body->x);
    row[AOI_BODY_WORK * stride] = work;
}

const aoi_stepped_kind aoi_stepped_modal = {modal_prepare, modal_begin, modal_accelerate, modal_power, modal_observe};
