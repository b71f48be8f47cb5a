/* Newmark's rule (section 3.1 of the paper) for a linear body. It is solved for accelerations, which keep their
 * digits if dt is small. Displacements are formed as dt (v + dt/4 a), never with a rounded dt^2: energy is
 * conserved only if dt^2 divided by dt is exactly dt. The residual compliance of a body in modes deflects at once
 * under the forces; the velocity of this deflection is its change over the step divided by dt. */
#include "newmark/body.h"
#include "linear/vector.h"

#include <math.h>
#include <string.h>

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

void aoi_stepped_lay_out(aoi_stepped *body, const aoi_modes *model, aoi_memory *memory)
{
    const size_t n = model->n, pairs = aoi_times(model->ports, model->ports);
    *body = (aoi_stepped){.model = model, .kind = model->full ? &aoi_stepped_full : &aoi_stepped_modal};
    body->a = aoi_memory_doubles(memory, n);
    body->free_a = aoi_memory_doubles(memory, n);
    body->gain = aoi_memory_doubles(memory, aoi_times(model->ports, n));
    body->before = aoi_memory_doubles(memory, n);
    for (size_t i = 0; i < AOI_STEPPED_OWN; i++) {
        body->own[i] = aoi_memory_doubles(memory, n);
    }
    body->plain = !model->full && !model->decay && !model->gravity && model->ports == 1;
    body->seen = aoi_memory_doubles(memory, body->plain ? aoi_times(AOI_PLAIN_SEEN, n) : 0);
    body->compliance = aoi_memory_doubles(memory, pairs);
    body->rate_compliance = aoi_memory_doubles(memory, pairs);
}

int aoi_stepped_start(aoi_stepped *body, const aoi_rule_step *step)
{
    const aoi_modes *model = body->model;
    const size_t n = model->n, ports = model->ports;
    body->step = step;
    const int status = body->kind->prepare(body);
    for (size_t i = 0; i < ports * ports && status == AOI_OK; i++) {
        const double reached = aoi_vector_dot(n, model->shape + (i / ports) * n, body->gain + (i % ports) * n);
        const double residual = model->residual ? model->residual[i] : 0.0;
        body->reached = reached;
        body->compliance[i] = step->reach * reached + residual;
        body->rate_compliance[i] = step->correct_v * reached + residual / step->dt;
        if (!isfinite(body->compliance[i]) || !isfinite(body->rate_compliance[i])) {
            return AOI_ERROR_NOT_FINITE;
        }
        if (model->full && i % (ports + 1) == 0 && !(reached > 0.0)) {
            return AOI_ERROR_NOT_POSITIVE;
        }
    }
    return status;
}

static void find_centre(aoi_stepped *body)
{
    body->centre[0] = aoi_vector_dot(body->centre_count, body->model->centre, body->x);
    body->centre[1] = aoi_vector_dot(body->centre_count, body->model->centre, body->v);
}

int aoi_stepped_begin(aoi_stepped *body, const double *force)
{
    const aoi_modes *model = body->model;
    body->centre_count = model->n;
    while (body->centre_count > 0 && model->centre[body->centre_count - 1] == 0.0) {
        body->centre_count--;
    }
    find_centre(body);
    memset(body->free_a, 0, model->n * sizeof(double));
    for (size_t p = 0; p < model->ports; p++) {
        aoi_vector_add(model->n, force[p], model->push + p * model->n, body->free_a);
    }
    const int status = body->kind->begin(body);
    if (body->plain) {
        aoi_plain_start(body);
    }
    return status;
}

double aoi_stepped_residual(const aoi_stepped *body, size_t p, const double *force)
{
    const aoi_modes *model = body->model;
    return model->residual ? aoi_vector_dot(model->ports, model->residual + p * model->ports, force) : 0.0;
}

int aoi_stepped_predict(aoi_stepped *body, double *displacement, double *velocity)
{
    const aoi_modes *model = body->model;
    const aoi_rule_step *step = body->step;
    const size_t n = model->n;
    double *restrict x = body->x, *restrict v = body->v;
    const double *restrict a = body->a, h = step->dt, predict_u = step->predict_u, predict_v = step->predict_v;
    if (body->before) {
        memcpy(body->before, v, n * sizeof(double));
    }
    for (size_t j = 0; j < n; j++) {
        x[j] += h * (v[j] + predict_u * a[j]);
        v[j] += predict_v * a[j];
    }
    const int status = body->kind->accelerate(body);
    for (size_t p = 0; p < model->ports; p++) {
        const double *shape = model->shape + p * n, reached = aoi_vector_dot(n, shape, body->free_a);
        displacement[p] = aoi_vector_dot(n, shape, x) + step->reach * reached;
        velocity[p] = aoi_vector_dot(n, shape, v) + step->correct_v * reached;
    }
    return status;
}

void aoi_stepped_correct(aoi_stepped *body, const double *force)
{
    const aoi_rule_step *step = body->step;
    const size_t n = body->model->n;
    double *restrict x = body->x, *restrict v = body->v, *restrict a = body->a;
    const double *restrict free_a = body->free_a, *restrict gain = body->gain;
    const double h = step->dt, correct_u = step->correct_u, correct_v = step->correct_v, first = force[0];
    for (size_t p = 1; p < body->model->ports; p++) {
        aoi_vector_add(n, force[p], body->gain + p * n, body->free_a);
    }
    for (size_t j = 0; j < n; j++) {
        a[j] = free_a[j] + first * gain[j];
        v[j] += correct_v * a[j];
        x[j] += h * (correct_u * a[j]);
    }
    if (body->before) {
        aoi_vector_add(n, 1.0, v, body->before);
        body->dissipated += 0.25 * h * body->kind->power(body);
    }
    find_centre(body);
}

void aoi_stepped_observe(const aoi_stepped *body, const double *force, const double *force_before, int energies,
                         double *row, size_t stride)
{
    const aoi_modes *model = body->model;
    double place = body->centre[0], rate = body->centre[1];
    for (size_t p = 0; model->centre_residual && p < model->ports; p++) {
        place += model->centre_residual[p] * force[p];
        rate += model->centre_residual[p] * ((force[p] - force_before[p]) / body->step->dt);
    }
    row[AOI_BODY_CENTRE * stride] = place;
    row[AOI_BODY_CENTRE_VELOCITY * stride] = rate;
    if (energies) {
        body->kind->observe(body, row, stride);
        row[AOI_BODY_DISSIPATED * stride] = body->dissipated;
        for (size_t p = 0; model->residual && p < model->ports; p++) {
            row[AOI_BODY_ELASTIC * stride] += 0.5 * force[p] * aoi_stepped_residual(body, p, force);
        }
    }
}
