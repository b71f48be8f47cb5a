/* Bodies in modes and the contacts between them: whether they can be run, and who touches whom. */
#include "model/system.h"
#include "linear/vector.h"

#include <math.h>

/* An array that may be missing. */
static int all_finite(const double *values, size_t count)
{
    return !values || aoi_vector_is_finite(count, values);
}

/* Whether values ascend from a least one; equal neighbours may be. */
static int ascending(const double *values, size_t count, double least)
{
    for (size_t i = 0; i < count; i++) {
        if (!(values[i] >= least && values[i] < HUGE_VAL)) {
            return 0;
        }
        least = values[i];
    }
    return 1;
}

static int check_body(const aoi_modes *body)
{
    const size_t n = body->n, ports = body->ports;
    if (n == 0 || ports == 0 || !ascending(body->omega, n, 0.0) ||
        !ascending(body->load_time, body->load_count, -HUGE_VAL)) {
        return AOI_ERROR_ARGUMENT;
    }
    for (size_t j = 0; body->decay && j < n; j++) {
        if (!(body->decay[j] >= 0.0)) {
            return AOI_ERROR_ARGUMENT;
        }
    }
    const int finite = all_finite(body->decay, n) && all_finite(body->shape, ports * n) &&
                       all_finite(body->push, ports * n) && all_finite(body->gravity, n) &&
                       all_finite(body->residual, ports * ports) && all_finite(body->inertia, n) &&
                       all_finite(body->centre, n) && all_finite(body->centre_residual, ports) &&
                       all_finite(body->load_force, body->load_count * ports);
    return finite ? AOI_OK : AOI_ERROR_ARGUMENT;
}

static int check_joint(const aoi_system *system, const aoi_joint *joint)
{
    for (int side = 0; side < 2; side++) {
        if (joint->body[side] >= system->body_count ||
            joint->port[side] >= system->body[joint->body[side]].ports) {
            return AOI_ERROR_ARGUMENT;
        }
    }
    return joint->body[0] != joint->body[1] && isfinite(joint->gap) ? aoi_law_check(joint->law)
                                                                    : AOI_ERROR_ARGUMENT;
}

/* Whether modes and ports of the bodies stand one after the other in the arrays of all. */
static int places_are_sound(const aoi_system *system)
{
    if (system->first[0] != 0 || system->first_port[0] != 0) {
        return 0;
    }
    for (size_t b = 0; b < system->body_count; b++) {
        if (system->first[b + 1] - system->first[b] != system->body[b].n ||
            system->first_port[b + 1] - system->first_port[b] != system->body[b].ports) {
            return 0;
        }
    }
    return 1;
}

/* Whether the joints of each body are those that name it, ascending. */
static int links_are_sound(const aoi_system *system)
{
    const size_t *first = system->first_joint;
    if (first[0] != 0 || first[system->body_count] != 2 * system->joint_count) {
        return 0;
    }
    for (size_t b = 0; b < system->body_count; b++) {
        if (first[b + 1] < first[b] || first[b + 1] > 2 * system->joint_count) {
            return 0;
        }
        for (size_t i = first[b]; i < first[b + 1]; i++) {
            const size_t c = system->joint_of[i];
            if (c >= system->joint_count || (i > first[b] && c <= system->joint_of[i - 1]) ||
                (system->joint[c].body[0] != b && system->joint[c].body[1] != b)) {
                return 0;
            }
        }
    }
    return 1;
}

int aoi_system_check(const aoi_system *system)
{
    for (size_t b = 0; b < system->body_count; b++) {
        if (check_body(&system->body[b]) != AOI_OK) {
            return AOI_ERROR_ARGUMENT;
        }
    }
    for (size_t c = 0; c < system->joint_count; c++) {
        if (check_joint(system, &system->joint[c]) != AOI_OK) {
            return AOI_ERROR_ARGUMENT;
        }
    }
    return places_are_sound(system) && (!system->first_joint || links_are_sound(system))
               ? AOI_OK
               : AOI_ERROR_ARGUMENT;
}

int aoi_system_link(aoi_system *system, size_t *first_joint, size_t *joint_of)
{
    const size_t ends = 2 * system->joint_count;
    for (size_t b = 0; b <= system->body_count; b++) {
        first_joint[b] = 0;
    }
    for (size_t i = 0; i < ends; i++) {
        const size_t b = system->joint[i / 2].body[i % 2];
        if (b >= system->body_count) {
            return AOI_ERROR_ARGUMENT;
        }
        first_joint[b]++;
    }
    for (size_t b = 0; b < system->body_count; b++) { /* where the next body's begin */
        first_joint[b + 1] += first_joint[b];
    }
    for (size_t i = ends; i-- > 0;) {
        joint_of[--first_joint[system->joint[i / 2].body[i % 2]]] = i / 2;
    }
    system->first_joint = first_joint;
    system->joint_of = joint_of;
    return AOI_OK;
}

size_t aoi_system_most_modes(const aoi_system *system)
{
    size_t most = 1;
    for (size_t b = 0; b < system->body_count; b++) {
        most = system->body[b].n > most ? system->body[b].n : most;
    }
    return most;
}

double aoi_system_residual(const aoi_system *system, size_t joint)
{
    const aoi_joint *of = &system->joint[joint];
    double sum = 0.0;
    for (int side = 0; side < 2; side++) {
        const aoi_modes *body = &system->body[of->body[side]];
        sum += body->residual ? body->residual[of->port[side] * (body->ports + 1)] : 0.0;
    }
    return sum;
}
