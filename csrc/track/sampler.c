/* Dense output: the record of a track at any time. Bodies are advanced from the start of a row to this time
 * exactly as in the run. At evenly spaced times in free motion they are advanced from one time to the next. */
#include "linear/vector.h"
#include "linear/work.h"
#include "law/law.h"
#include "model/system.h"
#include "motion/energy.h"
#include "motion/modes.h"
#include "motion/nodes.h"
#include "motion/polynomial.h"
#include "motion/radau.h"
#include "motion/response.h"
#include "motion/even.h"
#include "collocation/collocation.h"
#include "adaptive/row.h"

#include <float.h>
#include <math.h>
#include <string.h>

struct aoi_sampler {
    const aoi_system *system;
    const double *track;
    const size_t *index; /* index of each row in track */
    size_t rows;
    /* for each body: number of the last row that contains it, and the body's index in track */
    size_t *body_row, *body_at;
    size_t *contact_row, *contact_at; /* for each contact: number of its last row, and its index in track */

    size_t row, most_modes;
    int has_edge; /* 1: the force of a contact begins or ends in the row */
    /* share of the row that port_force covers: 1 or, if has_edge, the part up to the last time read */
    double part;
    double *port_force, *states; /* forces on all ports at the nodes of that part, N; work space for three states */
    double *ports; /* forces on all ports, their rates, and displacements of all ports */
    /* for each contact: energy lost up to the end of its last row, J; NaN: not computed so far */
    double *settled;
    double *flown; /* for each body in free motion: its state at the last bend of its load */
    aoi_even *even; /* for each body without a load: its free motion at evenly spaced times */
};

/* State of a body in free motion at the last bend of its load: time, work of loads and gravity and energy
 * dissipated since the body's row, then x and v. */
enum { BEND_TIME, BEND_WORK, BEND_LOST, BEND_STATE };

/* Returns the number of doubles that the states of all bodies at bends take. */
static size_t bends_size(const aoi_system *system)
{
    return BEND_STATE * system->body_count + 2 * system->first[system->body_count];
}

/* Lays out the sampler's arrays behind the sampler in `block`; if block is NULL, only the bytes are counted.
 * Returns their number. */
static size_t lay_out(aoi_sampler *sampler, const aoi_system *system, void *block)
{
    const size_t bodies = system->body_count, contacts = system->contact_count;
    const size_t ports = system->first_port[bodies];
    aoi_memory memory = {block, 0};
    (void)aoi_memory_take(&memory, 1, sizeof *sampler);
    sampler->body_row = aoi_memory_numbers(&memory, bodies);
    sampler->body_at = aoi_memory_numbers(&memory, bodies);
    sampler->contact_row = aoi_memory_numbers(&memory, contacts);
    sampler->contact_at = aoi_memory_numbers(&memory, contacts);
    sampler->port_force = aoi_memory_doubles(&memory, ports * AOI_NODES);
    sampler->ports = aoi_memory_doubles(&memory, 3 * ports);
    sampler->states = aoi_memory_doubles(&memory, 6 * sampler->most_modes);
    sampler->settled = aoi_memory_doubles(&memory, contacts);
    sampler->flown = aoi_memory_doubles(&memory, bends_size(system));
    sampler->even = aoi_memory_take(&memory, bodies, sizeof *sampler->even);
    for (size_t b = 0; b < bodies; b++) {
        const aoi_modes *body = &system->body[b];
        const size_t size = aoi_even_size(body);
        aoi_even even = {.time = NAN};
        even.lanes = aoi_memory_take(&memory, size, sizeof *even.lanes);
        even.x = aoi_memory_take(&memory, size, sizeof *even.x);
        even.v = aoi_memory_take(&memory, size, sizeof *even.v);
        if (block) {
            memset(even.x, 0, size * sizeof *even.x);
            memset(even.v, 0, size * sizeof *even.v);
            sampler->even[b] = even;
        }
    }
    return memory.used;
}

size_t aoi_sampler_size(const aoi_system *system)
{
    if (!system->first) {
        return 0;
    }
    aoi_sampler counted = {.most_modes = aoi_system_most_modes(system)};
    return lay_out(&counted, system, NULL);
}

static const double *row_of(const aoi_sampler *sampler, size_t row)
{
    return sampler->track + sampler->index[row];
}

static void forces_on_part(const aoi_sampler *sampler, size_t c, double place, double force[3][AOI_NODES])
{
    aoi_row_forces(&sampler->system->contact[c], sampler->track + sampler->contact_at[c],
                   row_of(sampler, sampler->contact_row[c])[AOI_TRACK_LENGTH], place, force);
}

/* Sets port_force to the forces on all ports, at the nodes of the part of the present row from its start to the
 * share `part`. */
static void gather(aoi_sampler *sampler, double part)
{
    const aoi_system *system = sampler->system;
    const size_t ports = system->first_port[system->body_count];
    sampler->part = part;
    memset(sampler->port_force, 0, ports * AOI_NODES * sizeof(double));
    for (size_t c = 0; c < system->contact_count; c++) {
        if (sampler->contact_row[c] != sampler->row) {
            continue;
        }
        double force[3][AOI_NODES];
        forces_on_part(sampler, c, part, force);
        for (size_t i = 0, count = 2 * aoi_contact_forces(&system->contact[c]); i < count; i++) {
            const size_t side = i % 2, axis = i / 2;
            const size_t port = system->first_port[system->contact[c].body[side]] +
                                system->contact[c].port[side] + axis;
            aoi_vector_add(AOI_NODES, side == 0 ? -1.0 : 1.0, force[axis],
                           sampler->port_force + port * AOI_NODES);
        }
    }
}

static double *bend_of(const aoi_sampler *sampler, size_t b)
{
    return sampler->flown + BEND_STATE * b + 2 * sampler->system->first[b];
}

/* Makes a row the present one, and records where its bodies and contacts are in the track. */
static void enter_row(aoi_sampler *sampler, size_t row)
{
    const aoi_system *system = sampler->system;
    const double *here = sampler->track + sampler->index[row];
    size_t at = sampler->index[row] + AOI_TRACK_FIXED;
    sampler->row = row;
    sampler->has_edge = 0;
    for (size_t i = 0; i < (size_t)here[AOI_TRACK_BODIES]; i++) {
        const size_t b = (size_t)sampler->track[at];
        sampler->body_row[b] = row;
        sampler->body_at[b] = at;
        *bend_of(sampler, b) = NAN;
        at += AOI_TRACK_STATE + 2 * system->body[b].n;
    }
    for (size_t i = 0; i < (size_t)here[AOI_TRACK_CONTACTS]; i++) {
        const size_t c = (size_t)sampler->track[at];
        sampler->contact_row[c] = row;
        sampler->contact_at[c] = at;
        sampler->settled[c] = NAN;
        sampler->has_edge |= sampler->track[at + AOI_TRACK_EDGE] != AOI_EDGE_NONE;
        at += aoi_row_contact_size(&system->contact[c]);
    }
}

int aoi_sampler_start(aoi_sampler *sampler, const aoi_system *system, const aoi_track *track)
{
    if (!aoi_system_is_plain(system) || track->rows == 0) {
        return AOI_ERROR_ARGUMENT;
    }
    *sampler = (aoi_sampler){.system = system, .most_modes = aoi_system_most_modes(system)};
    sampler->track = track->values;
    sampler->index = track->row;
    sampler->rows = track->rows;
    (void)lay_out(sampler, system, sampler);
    for (size_t b = 0; b < system->body_count; b++) {
        sampler->body_row[b] = sampler->rows;
    }
    for (size_t c = 0; c < system->contact_count; c++) {
        sampler->contact_row[c] = sampler->rows;
        sampler->contact_at[c] = 0;
    }
    enter_row(sampler, 0);
    for (size_t b = 0; b < system->body_count; b++) {
        if (sampler->body_row[b] == sampler->rows) {
            return AOI_ERROR_ARGUMENT;
        }
    }
    gather(sampler, 1.0);
    return AOI_OK;
}

/* Returns the position of a time in the present row, as a share of its length; 1 after the row. */
static double place_of(const aoi_sampler *sampler, double time)
{
    const double *row = row_of(sampler, sampler->row);
    const double length = row[AOI_TRACK_LENGTH], into = time - row[AOI_TRACK_START];
    return length > 0.0 ? fmin(1.0, into / length) : 1.0;
}

/* Moves on to the row that contains a time, and gathers the forces of that row on the ports. */
static void advance(aoi_sampler *sampler, double time)
{
    const size_t before = sampler->row;
    while (sampler->row + 1 < sampler->rows &&
           row_of(sampler, sampler->row + 1)[AOI_TRACK_START] <= time) {
        enter_row(sampler, sampler->row + 1);
    }
    const double place = place_of(sampler, time);
    const double part = sampler->has_edge && place > 0.0 ? place : 1.0;
    if (sampler->row != before || sampler->part != part) {
        gather(sampler, part);
    }
}

/* Advances a body in free motion to the last bend of its load before a time, from the last bend that was reached;
 * a start from the body's row would pass all bends since that row for each time. Returns the state at that bend. */
static double *fly_to_bend(const aoi_sampler *sampler, double time, size_t b)
{
    const aoi_modes *body = &sampler->system->body[b];
    const double *stored = sampler->track + sampler->body_at[b] + AOI_TRACK_STATE;
    const double start = row_of(sampler, sampler->body_row[b])[AOI_TRACK_START];
    double *at = bend_of(sampler, b);
    double *x = at + BEND_STATE, *before = sampler->states + 2 * sampler->most_modes;
    const size_t bytes = 2 * body->n * sizeof(double);
    if (!(at[BEND_TIME] <= time)) { /* also if it is NaN: not computed so far */
        at[BEND_TIME] = start;
        at[BEND_WORK] = at[BEND_LOST] = 0.0;
        memcpy(x, stored, bytes);
    }
    for (double bend = aoi_modes_next_bend(body, at[BEND_TIME]); bend < time;
         bend = aoi_modes_next_bend(body, bend)) {
        double work, lost;
        memcpy(before, x, bytes);
        aoi_modes_advance(body, at[BEND_TIME], bend, x, x + body->n);
        aoi_modes_free_work(body, at[BEND_TIME], bend, before, before + body->n, x, x + body->n,
                            before + 2 * sampler->most_modes, &work, &lost);
        at[BEND_WORK] += work;
        at[BEND_LOST] += lost;
        at[BEND_TIME] = bend;
    }
    return at;
}

/* Writes x and v of a body at a time to state (2 n). Returns 1 if contact forces have acted on the body since its
 * row, 0 if it is in free motion. */
static int state_at(const aoi_sampler *sampler, double time, size_t b, double *state)
{
    const aoi_modes *body = &sampler->system->body[b];
    const double *stored = sampler->track + sampler->body_at[b] + AOI_TRACK_STATE;
    const double *row = row_of(sampler, sampler->body_row[b]);
    const double start = row[AOI_TRACK_START], length = row[AOI_TRACK_LENGTH];
    const int pushed = sampler->body_row[b] == sampler->row && length > 0.0 && time > start;
    if (!pushed) {
        if (body->load.count == 0) {
            aoi_even_state(&sampler->even[b], body, start, stored, time, state);
            return 0;
        }
        const double *bend = fly_to_bend(sampler, time, b);
        memcpy(state, bend + BEND_STATE, 2 * body->n * sizeof(double));
        aoi_modes_advance(body, bend[BEND_TIME], time, state, state + body->n);
        return 0;
    }
    const double place = place_of(sampler, time);
    memcpy(state, stored, 2 * body->n * sizeof(double));
    aoi_response_carry(body, start, sampler->part * length,
                       sampler->port_force + sampler->system->first_port[b] * AOI_NODES,
                       place / sampler->part, state, state + body->n);
    aoi_modes_advance(body, start + length, time, state, state + body->n);
    return 1;
}

void aoi_sampler_state(aoi_sampler *sampler, double time, size_t body, double *state)
{
    advance(sampler, time);
    (void)state_at(sampler, time, body, state);
}

/* Returns the work done on a contact from the start of its row to the position `place`, by the quadrature of the
 * run, J. */
static double contact_work(const aoi_sampler *sampler, size_t c, double place)
{
    double force[3][AOI_NODES];
    forces_on_part(sampler, c, place, force);
    return aoi_collocation_work(sampler->track + sampler->contact_at[c] + AOI_TRACK_INDENTATION, force[0], place);
}

/* True for a law without losses. The dissipated energy of its contact is recorded as 0, since the difference
 * between work and stored energy is only the error of the run. */
static int is_elastic(const aoi_law *law) { return !law->depends_on_rate && !law->remember; }

/* Returns the force at the position `place` of a row, N. At the start it is the stored force, since the polynomial
 * through the nodes would extrapolate. */
static double force_at(const double *of, double place)
{
    double legendre[AOI_NODES], slope;
    aoi_nodes_to_legendre(of + AOI_TRACK_FORCE, legendre);
    return place > 0.0 ? aoi_legendre_evaluate(AOI_NODES, legendre, place, &slope)
                       : of[AOI_TRACK_START_FORCE];
}

/* Writes the rows of a closed contact. Returns its force, N, and sets force_rate to the rate of that force, N/s. */
static double closed_contact(const aoi_sampler *sampler, size_t c, double place, int energies,
                             double *record, size_t stride, double *force_rate)
{
    const aoi_law *law = sampler->system->contact[c].law;
    const double *of = sampler->track + sampler->contact_at[c];
    const double length = row_of(sampler, sampler->row)[AOI_TRACK_LENGTH];
    const int piece = (int)of[AOI_TRACK_PIECE];
    double slope;
    aoi_law_value value = {0.0, 0.0, 0.0};
    const double indentation = aoi_legendre_evaluate(AOI_NODES + 1, of + AOI_TRACK_INDENTATION, place, &slope);
    if (piece != AOI_SLACK) {
        aoi_law_force(law, of + AOI_TRACK_MEMORY, piece, indentation, slope / length, &value);
        if (law->depends_on_rate && of[AOI_TRACK_EDGE] == AOI_EDGE_NONE) {
            /* The force is taken from its polynomial, except in a row with an edge: in a very short step the rate,
             * a slope of the indentation, is only rounding error. */
            value.force = force_at(of, place);
        }
        value.force = law->pulls || value.force > 0.0 ? value.force : 0.0;
    }
    *force_rate = value.stiffness * slope / length;
    record[AOI_CONTACT_FORCE * stride] = value.force;
    record[AOI_CONTACT_INDENTATION * stride] = indentation;
    if (energies) {
        const double elastic = piece == AOI_SLACK ? 0.0
                                                  : aoi_law_potential(law, of + AOI_TRACK_MEMORY,
                                                                      indentation);
        record[AOI_CONTACT_ELASTIC * stride] = elastic;
        record[AOI_CONTACT_DISSIPATED * stride] =
            is_elastic(law) ? 0.0 : of[AOI_TRACK_WORK] + contact_work(sampler, c, place) - elastic;
    }
    return value.force;
}

/* Writes the rows of a closed contact with friction. Returns its normal force, N. */
static double rubbing_contact(const aoi_sampler *sampler, size_t c, double place, int energies, double *record,
                              size_t stride)
{
    const aoi_contact *contact = &sampler->system->contact[c];
    const double *of = sampler->track + sampler->contact_at[c], *out = contact->compliance;
    const double lost = aoi_row_between(of, AOI_TRACK_DISSIPATED, place);
    double force[3], bent, slope;
    aoi_row_rub(contact, of, place, force, &bent);
    const double indentation = aoi_legendre_evaluate(AOI_NODES + 1, of + AOI_TRACK_INDENTATION, place, &slope);
    record[AOI_CONTACT_FORCE * stride] = force[0];
    record[AOI_CONTACT_INDENTATION * stride] = indentation;
    record[AOI_CONTACT_TANGENTIAL * stride] = force[1];
    record[(AOI_CONTACT_TANGENTIAL + 1) * stride] = force[2];
    record[AOI_CONTACT_FRICTION * stride] = lost;
    record[AOI_CONTACT_STUCK * stride] = aoi_row_stuck(of, place);
    if (energies) {
        double taken_out = 0.5 * contact->law->compliance * force[0] * force[0];
        for (size_t i = 0; i < 9 && out; i++) {
            taken_out += i > 0 ? 0.5 * force[i / 3] * out[i] * force[i % 3] : 0.0;
        }
        record[AOI_CONTACT_ELASTIC * stride] =
            aoi_law_potential(&contact->friction->law, NULL, indentation + bent) - taken_out +
            aoi_row_slide_stored(contact, of, place) - lost;
        record[AOI_CONTACT_DISSIPATED * stride] = 0.0;
    }
    return force[0];
}

/* Returns the energy lost by a contact that is open, including the loss at its end, J. It is computed once after
 * the contact's last row. */
static double lost_in(aoi_sampler *sampler, size_t c)
{
    if (sampler->contact_row[c] == sampler->rows || is_elastic(sampler->system->contact[c].law)) {
        return 0.0;
    }
    if (isnan(sampler->settled[c])) {
        const double *of = sampler->track + sampler->contact_at[c];
        sampler->settled[c] = of[AOI_TRACK_WORK] + contact_work(sampler, c, 1.0) +
                              of[AOI_TRACK_LOST];
    }
    return sampler->settled[c];
}

/* Writes the rows of an open contact, for given displacements of all ports. */
static void open_contact(aoi_sampler *sampler, size_t c, const double *port_displacement,
                         int energies, double *record, size_t stride)
{
    const aoi_contact *contact = &sampler->system->contact[c];
    const size_t *first = sampler->system->first_port, *body = contact->body;
    record[AOI_CONTACT_FORCE * stride] = 0.0;
    record[AOI_CONTACT_INDENTATION * stride] = port_displacement[first[body[0]] + contact->port[0]] -
                                               port_displacement[first[body[1]] + contact->port[1]] - contact->gap;
    if (energies) {
        record[AOI_CONTACT_ELASTIC * stride] = 0.0;
        record[AOI_CONTACT_DISSIPATED * stride] = lost_in(sampler, c);
    }
    if (contact->friction) {
        const double *of = sampler->track + sampler->contact_at[c];
        const double lost = sampler->contact_row[c] == sampler->rows ? 0.0 : of[AOI_TRACK_DISSIPATED + AOI_NODES + 1];
        for (size_t i = AOI_CONTACT_TANGENTIAL; i < AOI_FRICTION_ROWS; i++) {
            record[i * stride] = i == AOI_CONTACT_FRICTION ? lost : 0.0;
        }
    }
}

static void body_ledger(const aoi_sampler *sampler, double time, size_t b, int pushed,
                        const double *state, double *work, double *dissipated)
{
    const aoi_modes *body = &sampler->system->body[b];
    const double *stored = sampler->track + sampler->body_at[b];
    const double *row = row_of(sampler, sampler->body_row[b]), start = row[AOI_TRACK_START];
    const double *x0 = stored + AOI_TRACK_STATE, *v0 = x0 + body->n;
    double *scratch = sampler->states + 4 * sampler->most_modes, more = 0.0, lost = 0.0;
    if (!body->decay && !body->gravity && body->load.count == 0) {
        /* only contact forces do work on the body */
    } else if (pushed) {
        aoi_modes_step_work(body, start, sampler->part * row[AOI_TRACK_LENGTH],
                            place_of(sampler, time) / sampler->part,
                            sampler->port_force + sampler->system->first_port[b] * AOI_NODES, x0, v0,
                            state, &more, &lost);
    } else {
        const double *bend = fly_to_bend(sampler, time, b), *x = bend + BEND_STATE;
        aoi_modes_free_work(body, bend[BEND_TIME], time, x, x + body->n, state, state + body->n, scratch,
                              &more, &lost);
        more += bend[BEND_WORK];
        lost += bend[BEND_LOST];
    }
    *work = stored[AOI_TRACK_BODY_WORK] + more;
    *dissipated = stored[AOI_TRACK_BODY_LOST] + lost;
}

/* Writes the rows of a body, and finds the displacements of its ports. force, force_rate: contact forces plus
 * loads on its ports, and their rates. */
static void write_body(aoi_sampler *sampler, double time, size_t b, int energies, const double *force,
                       const double *force_rate, double *record, size_t stride,
                       double *port_displacement)
{
    const aoi_modes *body = &sampler->system->body[b];
    double *x = sampler->states, *v = x + body->n;
    const int pushed = state_at(sampler, time, b, x);
    double *centre = record + AOI_BODY_CENTRE * stride, *rate = record + AOI_BODY_CENTRE_VELOCITY * stride;
    *centre = aoi_vector_dot(body->n, body->centre, x);
    *rate = aoi_vector_dot(body->n, body->centre, v);
    for (size_t p = 0; p < body->ports; p++) {
        double displacement, velocity;
        aoi_modes_port(body, p, x, v, &displacement, &velocity);
        for (size_t q = 0; body->residual && q < body->ports; q++) {
            displacement += body->residual[p * body->ports + q] * force[q];
            velocity += body->residual[p * body->ports + q] * force_rate[q];
        }
        *centre += body->centre_residual ? body->centre_residual[p] * force[p] : 0.0;
        *rate += body->centre_residual ? body->centre_residual[p] * force_rate[p] : 0.0;
        record[(AOI_BODY_ROWS + AOI_PORT_ROWS * p) * stride] = port_displacement[p] = displacement;
        record[(AOI_BODY_ROWS + AOI_PORT_ROWS * p + 1) * stride] = velocity;
    }
    if (energies) {
        double *work = record + AOI_BODY_WORK * stride;
        aoi_modes_energy(body, x, v, force, &record[AOI_BODY_KINETIC * stride],
                         &record[AOI_BODY_ELASTIC * stride]);
        body_ledger(sampler, time, b, pushed, x, work, &record[AOI_BODY_DISSIPATED * stride]);
        *work += aoi_modes_bent_work(body, time, force);
    }
}

/* Writes the rows of the closed contacts. Sets the forces on all ports, loads included, and their rates. */
static void closed_contacts(aoi_sampler *sampler, double time, int energies, double *record,
                            size_t stride, double *force, double *rate)
{
    const aoi_system *system = sampler->system;
    const double place = place_of(sampler, time);
    for (size_t b = 0; b < system->body_count; b++) {
        for (size_t q = 0; q < system->body[b].ports; q++) {
            const size_t port = system->first_port[b] + q;
            aoi_modes_load(&system->body[b], q, time, &force[port], &rate[port]);
        }
    }
    for (size_t c = 0; c < system->contact_count; c++) {
        if (sampler->contact_row[c] != sampler->row) {
            continue;
        }
        double change = 0.0, *of = record + aoi_record_contact(system, c) * stride;
        const double pressed = system->contact[c].friction
                                   ? rubbing_contact(sampler, c, place, energies, of, stride)
                                   : closed_contact(sampler, c, place, energies, of, stride, &change);
        for (int side = 0; side < 2; side++) {
            const aoi_contact *contact = &system->contact[c];
            const size_t port = system->first_port[contact->body[side]] + contact->port[side];
            force[port] += side == 0 ? -pressed : pressed;
            rate[port] += side == 0 ? -change : change;
        }
    }
}

void aoi_sampler_column(aoi_sampler *sampler, double time, int energies, double *record,
                        size_t stride)
{
    const aoi_system *system = sampler->system;
    const size_t ports = system->first_port[system->body_count];
    double *force = sampler->ports, *rate = force + ports;
    double *displacement = rate + ports;
    advance(sampler, time);
    closed_contacts(sampler, time, energies, record, stride, force, rate);
    double *of_body = record + aoi_record_body(system, 0) * stride;
    for (size_t b = 0; b < system->body_count; b++) {
        const size_t port = system->first_port[b];
        write_body(sampler, time, b, energies, force + port, rate + port, of_body, stride,
                   displacement + port);
        of_body += (AOI_BODY_ROWS + AOI_PORT_ROWS * system->body[b].ports) * stride;
    }
    for (size_t c = 0; c < system->contact_count; c++) {
        if (sampler->contact_row[c] != sampler->row) {
            open_contact(sampler, c, displacement, energies, record + aoi_record_contact(system, c) * stride, stride);
        }
    }
}

void aoi_sampler_forces(aoi_sampler *sampler, double time, double *force, size_t stride)
{
    advance(sampler, time);
    const double place = place_of(sampler, time);
    for (size_t c = 0; c < sampler->system->contact_count; c++) {
        double record[AOI_FRICTION_ROWS], rate;
        const int closed = sampler->contact_row[c] == sampler->row, rubs = sampler->system->contact[c].friction != NULL;
        force[c * stride] = !closed ? 0.0
                            : rubs  ? rubbing_contact(sampler, c, place, 0, record, 1)
                                    : closed_contact(sampler, c, place, 0, record, 1, &rate);
    }
}
