/* A system of bodies and contacts: checks of its data, its links, and the layout of its records. */
#include "model/load.h"
#include "model/modes.h"
#include "model/system.h"
#include "linear/vector.h"
#include "linear/work.h"

#include <math.h>
#include <string.h>

/* Largest difference between symmetric entries of a residual compliance, relative to the geometric mean of both
 * diagonal entries. It allows for rounding errors of a reduction. */
static const double SYMMETRY = 1e-6;

/* True if an array, which may be missing, has finite values only. */
static int all_finite(const double *values, size_t count)
{
    return !values || aoi_vector_is_finite(count, values);
}

static int none_negative(const double *values, size_t count)
{
    for (size_t i = 0; values && i < count; i++) {
        if (!(values[i] >= 0.0)) {
            return 0;
        }
    }
    return 1;
}

/* True if forces do no negative work on a residual compliance, which is checked for each port and each pair of
 * ports. */
static int residual_is_sound(const double *residual, size_t ports)
{
    for (size_t p = 0; residual && p < ports; p++) {
        const double own = residual[p * (ports + 1)];
        for (size_t q = 0; q <= p; q++) {
            const double one = residual[p * ports + q], other = residual[q * ports + p];
            const double most = sqrt(own) * sqrt(residual[q * (ports + 1)]);
            if (!(fabs(one - other) <= SYMMETRY * most && fabs(one) <= (1.0 + SYMMETRY) * most)) {
                return 0;
            }
        }
    }
    return 1;
}

/* True if frequencies ascend and are not negative; equal neighbours are allowed. */
static int ascending(const double *values, size_t count)
{
    double least = 0.0;
    for (size_t i = 0; i < count; i++) {
        if (!(values[i] >= least && values[i] < HUGE_VAL)) {
            return 0;
        }
        least = values[i];
    }
    return 1;
}

/* True if the description of a body by its modes, or by its matrices, can be used. */
static int kind_is_sound(const aoi_modes *body)
{
    const aoi_full *full = body->full;
    if (!full) {
        return body->omega && ascending(body->omega, body->n);
    }
    return !body->omega && !body->decay && !body->residual && !body->inertia && !body->centre_residual &&
           full->K.n == body->n && full->M.n == body->n && full->solver.solve && full->alpha >= 0.0 &&
           full->beta >= 0.0 && isfinite(full->alpha + full->beta);
}

static int body_is_sound(const aoi_modes *body)
{
    const size_t n = body->n, ports = body->ports;
    if (n == 0 || ports == 0 || !body->shape || !body->push || !body->centre || !kind_is_sound(body) ||
        !aoi_load_is_sound(&body->load, ports)) {
        return 0;
    }
    if (!none_negative(body->decay, n) || !none_negative(body->inertia, n) ||
        !residual_is_sound(body->residual, ports)) {
        return 0;
    }
    return all_finite(body->decay, n) && all_finite(body->shape, ports * n) &&
           all_finite(body->push, ports * n) && all_finite(body->gravity, n) &&
           all_finite(body->residual, ports * ports) && all_finite(body->inertia, n) &&
           all_finite(body->centre, n) && all_finite(body->centre_residual, ports);
}

/* True if friction is what aoi_friction_create makes of the given law. */
static int friction_is_sound(const aoi_friction *friction, const aoi_law *law)
{
    aoi_friction made;
    const aoi_law *of = &friction->law;
    return aoi_friction_create(&made, law, friction->mu, friction->ratio, friction->precision) == AOI_OK &&
           of->force == law->force && of->compliance == 0.0 && of->table == law->table &&
           memcmp(of->parameter, law->parameter, sizeof of->parameter) == 0 &&
           memcmp(&of->user, &law->user, sizeof of->user) == 0;
}

static int contact_is_sound(const aoi_system *system, const aoi_contact *contact)
{
    const size_t ports = aoi_contact_forces(contact);
    for (int side = 0; side < 2; side++) {
        if (contact->body[side] >= system->body_count || system->body[contact->body[side]].ports < ports ||
            contact->port[side] > system->body[contact->body[side]].ports - ports) {
            return 0;
        }
    }
    return contact->body[0] != contact->body[1] && isfinite(contact->gap) &&
           aoi_law_check(contact->law) == AOI_OK && all_finite(contact->compliance, ports * ports) &&
           (!contact->compliance || contact->compliance[0] == contact->law->compliance) &&
           (!contact->friction || friction_is_sound(contact->friction, contact->law));
}

/* True if a force on a port moves the port; false for a wall. */
static int port_can_move(const aoi_modes *body, size_t port)
{
    const double *shape = body->shape + port * body->n, *push = body->push + port * body->n;
    for (size_t j = 0; j < body->n; j++) {
        if (shape[j] != 0.0 && push[j] != 0.0) {
            return 1;
        }
    }
    return body->residual && body->residual[port * (body->ports + 1)] > 0.0;
}

/* True if the force of every contact, in each of its directions, can deform or move a body. */
static int contacts_can_move(const aoi_system *system)
{
    for (size_t c = 0; c < system->contact_count; c++) {
        const aoi_contact *of = &system->contact[c];
        for (size_t axis = 0; axis < aoi_contact_forces(of); axis++) {
            if (!port_can_move(&system->body[of->body[0]], of->port[0] + axis) &&
                !port_can_move(&system->body[of->body[1]], of->port[1] + axis)) {
                return 0;
            }
        }
    }
    return 1;
}

static int is_sound(const aoi_system *system)
{
    if ((system->body_count > 0 && !system->body) || (system->contact_count > 0 && !system->contact)) {
        return 0;
    }
    for (size_t b = 0; b < system->body_count; b++) {
        if (!body_is_sound(&system->body[b])) {
            return 0;
        }
    }
    for (size_t c = 0; c < system->contact_count; c++) {
        if (!contact_is_sound(system, &system->contact[c])) {
            return 0;
        }
    }
    return 1;
}

/* The arrays of a linked system in the caller's memory: first those for the bodies, then those for the contacts. */
typedef struct links {
    size_t *first, *first_port, *first_contact, *contact_of, *first_force;
} links;

static links lay_out(const aoi_system *system, aoi_memory *memory)
{
    links made;
    made.first = aoi_memory_numbers(memory, system->body_count + 1);
    made.first_port = aoi_memory_numbers(memory, system->body_count + 1);
    made.first_contact = aoi_memory_numbers(memory, system->body_count + 1);
    made.contact_of = aoi_memory_numbers(memory, 2 * system->contact_count);
    made.first_force = aoi_memory_numbers(memory, system->contact_count + 1);
    return made;
}

size_t aoi_system_size(const aoi_system *system)
{
    aoi_memory memory = {NULL, 0};
    (void)lay_out(system, &memory);
    return memory.used;
}

/* Lists the contacts of each body. */
static void link_contacts(const aoi_system *system, size_t *first_contact, size_t *contact_of)
{
    const size_t ends = 2 * system->contact_count;
    memset(first_contact, 0, (system->body_count + 1) * sizeof *first_contact);
    for (size_t i = 0; i < ends; i++) {
        first_contact[system->contact[i / 2].body[i % 2]]++;
    }
    /* afterwards, first_contact[b] is the end of body b's contacts */
    for (size_t b = 0; b < system->body_count; b++) {
        first_contact[b + 1] += first_contact[b];
    }
    for (size_t i = ends; i-- > 0;) {
        contact_of[--first_contact[system->contact[i / 2].body[i % 2]]] = i / 2;
    }
}

int aoi_system_link(aoi_system *system, void *memory)
{
    aoi_memory block = {memory, 0};
    const links made = lay_out(system, &block);
    system->first = system->first_port = system->first_contact = system->contact_of = system->first_force = NULL;
    if (!is_sound(system)) {
        return AOI_ERROR_ARGUMENT;
    }
    if (!contacts_can_move(system)) {
        return AOI_ERROR_NOT_POSITIVE;
    }
    made.first[0] = made.first_port[0] = made.first_force[0] = 0;
    for (size_t b = 0; b < system->body_count; b++) {
        made.first[b + 1] = made.first[b] + system->body[b].n;
        made.first_port[b + 1] = made.first_port[b] + system->body[b].ports;
    }
    for (size_t c = 0; c < system->contact_count; c++) {
        made.first_force[c + 1] = made.first_force[c] + aoi_contact_forces(&system->contact[c]);
    }
    link_contacts(system, made.first_contact, made.contact_of);
    system->first = made.first;
    system->first_port = made.first_port;
    system->first_contact = made.first_contact;
    system->contact_of = made.contact_of;
    system->first_force = made.first_force;
    return AOI_OK;
}

int aoi_system_is_plain(const aoi_system *system)
{
    size_t full = 0;
    for (size_t b = 0; b < system->body_count; b++) {
        full += system->body[b].full != NULL;
    }
    return system->first && full == 0;
}

size_t aoi_system_most_modes(const aoi_system *system)
{
    size_t most = 1;
    for (size_t b = 0; b < system->body_count; b++) {
        most = system->body[b].n > most ? system->body[b].n : most;
    }
    return most;
}

int aoi_system_bends(const aoi_system *system)
{
    for (size_t b = 0; b < system->body_count; b++) {
        if (system->body[b].residual) {
            return 1;
        }
    }
    return 0;
}

double aoi_system_residual(const aoi_system *system, size_t c, size_t by)
{
    const aoi_contact *of = &system->contact[c], *from = &system->contact[by];
    double sum = 0.0;
    for (int i = 0; i < 4; i++) {
        const aoi_modes *body = &system->body[of->body[i / 2]];
        if (body->residual && of->body[i / 2] == from->body[i % 2]) {
            const size_t pair = of->port[i / 2] * body->ports + from->port[i % 2];
            sum += (i / 2 == i % 2 ? 1.0 : -1.0) * body->residual[pair];
        }
    }
    return sum;
}

size_t aoi_system_span(const aoi_system *system)
{
    size_t span = aoi_system_rubs(system) ? 2 : 0;
    for (size_t b = 0; b < system->body_count; b++) {
        const size_t first = system->first_contact[b], end = system->first_contact[b + 1];
        const aoi_modes *body = &system->body[b];
        if (first < end && (body->residual || aoi_modes_can_move(body))) {
            const size_t apart = system->first_force[system->contact_of[end - 1] + 1] - 1 -
                                 system->first_force[system->contact_of[first]];
            span = apart > span ? apart : span;
        }
    }
    return span;
}

size_t aoi_record_rows(const aoi_system *system)
{
    return aoi_record_body(system, system->body_count);
}

size_t aoi_record_contact(const aoi_system *system, size_t contact)
{
    /* Friction adds two forces and four rows to a contact. */
    return system->first ? AOI_CONTACT_ROWS * contact + 2 * (system->first_force[contact] - contact) : 0;
}

size_t aoi_record_body(const aoi_system *system, size_t body)
{
    if (!system->first) {
        return 0;
    }
    return aoi_record_contact(system, system->contact_count) + AOI_BODY_ROWS * body +
           AOI_PORT_ROWS * system->first_port[body];
}
