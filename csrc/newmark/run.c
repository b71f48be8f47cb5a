/* Runs of bodies, contacts and loads by Newmark's rule. A step predicts all bodies, solves the contact equations,
 * corrects all bodies and writes the record. */
#include "newmark/body.h"
#include "linear/vector.h"
#include "law/law.h"
#include "model/coupled.h"
#include "model/load.h"
#include "model/system.h"

#include <float.h>
#include <math.h>
#include <string.h>

/* Number of columns of the record that are gathered before they are written: they fill a cache line in each row. */
enum { BLOCK = 8 };

/* Capacity for the springs of a contact with friction, which needs about 2/sqrt(precision). */
enum { SPRINGS = 2048 };

struct aoi_newmark {
    const aoi_system *system;
    aoi_rule_step step;
    /* loaded: 1 if a body has a load; deflects: 1 if a body has a residual compliance */
    int energies, loaded, deflects;
    double *record;
    size_t columns, done, failed;
    aoi_coupled coupled;
    double *x, *v;                           /* coordinates and rates of all bodies                       */
    aoi_stepped *body;
    aoi_contact_state *state;                /* one for each contact force                                */
    aoi_rubbing *rubbing;                    /* one for each contact with friction                        */
    double *displacement, *velocity;         /* of all ports, m and m/s; in a step first without contact forces */
    double *displacement_before;             /* displacements at the last column                          */
    double *push, *push_before;              /* forces on all ports, loads included: now and one step before */
    double *load, *load_before;              /* loads on all ports: now and one step before, N            */
    double *load_work, *gravity_start;       /* work of loads so far; value of gravity's work at the start, J */
    double *column;                          /* gathered columns of the record, row by row                */
};

static aoi_newmark lay_out(const aoi_system *system, void *block, size_t *size)
{
    aoi_memory memory = {block, 0};
    const size_t bodies = system->body_count, forces = aoi_system_forces(system);
    const size_t rubbing = (forces - system->contact_count) / 2;
    const size_t ports = system->first_port[bodies], rows = aoi_record_rows(system);
    aoi_newmark made = {.system = system, .deflects = aoi_system_bends(system)};
    aoi_coupled *e = &made.coupled;
    (void)aoi_memory_take(&memory, 1, sizeof made);
    e->count = forces;
    e->band = aoi_system_span(system);
    made.x = aoi_memory_doubles(&memory, system->first[bodies]);
    made.v = aoi_memory_doubles(&memory, system->first[bodies]);
    made.body = aoi_memory_take(&memory, bodies, sizeof *made.body);
    made.state = aoi_memory_take(&memory, forces, sizeof *made.state);
    made.rubbing = aoi_memory_take(&memory, rubbing, sizeof *made.rubbing);
    aoi_stretch *spring = aoi_memory_take(&memory, aoi_times(2 * SPRINGS, rubbing), sizeof *spring);
    double **of_ports[] = {&made.displacement, &made.velocity, &made.displacement_before, &made.push,
                           &made.push_before,  &made.load,     &made.load_before};
    for (size_t i = 0; i < sizeof of_ports / sizeof *of_ports; i++) {
        *of_ports[i] = aoi_memory_doubles(&memory, ports);
    }
    made.load_work = aoi_memory_doubles(&memory, bodies);
    made.gravity_start = aoi_memory_doubles(&memory, bodies);
    e->compliance = aoi_memory_doubles(&memory, aoi_times(2 * e->band + 1, forces));
    e->rate_compliance = aoi_memory_doubles(&memory, aoi_times(2 * e->band + 1, forces));
    double **of_contacts[] = {&e->free, &e->rate_free, &e->indentation, &e->rate, &e->force};
    for (size_t i = 0; i < sizeof of_contacts / sizeof *of_contacts; i++) {
        *of_contacts[i] = aoi_memory_doubles(&memory, forces);
    }
    e->work = aoi_memory_doubles(&memory, aoi_coupled_size(forces, e->band));
    made.column = aoi_memory_doubles(&memory, aoi_times(BLOCK, rows));
    for (size_t i = 0; block && i < rubbing; i++, spring += 2 * SPRINGS) {
        made.rubbing[i].state = (aoi_friction_state){SPRINGS, 0, spring, spring + SPRINGS, 0.0, 0.0, 0.0};
    }
    for (size_t b = 0; b < bodies; b++) {
        aoi_stepped body;
        aoi_stepped_lay_out(&body, &system->body[b], &memory);
        if (block) {
            body.x = made.x + system->first[b];
            body.v = made.v + system->first[b];
            made.body[b] = body;
            made.loaded = made.loaded || body.model->load.count > 0;
        }
    }
    *size = memory.used;
    return made;
}

size_t aoi_newmark_size(const aoi_system *system)
{
    size_t size = 0;
    if (system->first) {
        (void)lay_out(system, NULL, &size);
    }
    return size;
}

aoi_progress aoi_newmark_progress(const aoi_newmark *run)
{
    return (aoi_progress){.time = run->step.dt * (double)run->done, .steps = run->done, .failed = run->failed,
                          .x = run->x, .v = run->v};
}

/* ------------------------------------------------------------------------------ the contacts */

/* Returns the reduction of the indentation or slide at force i (or, with of_rate = 1, of its rate) per unit of
 * force j, through the bodies on which both forces act. */
static double coupling(const aoi_newmark *run, size_t i, size_t j, int of_rate)
{
    const aoi_contact *one = &run->system->contact[run->state[i].contact];
    const aoi_contact *other = &run->system->contact[run->state[j].contact];
    double sum = 0.0;
    for (int side = 0; side < 2; side++) {
        const aoi_stepped *body = &run->body[one->body[side]];
        const double *matrix = of_rate ? body->rate_compliance : body->compliance;
        for (int far = 0; far < 2; far++) {
            if (other->body[far] == one->body[side]) {
                const size_t row = one->port[side] + run->state[i].axis, column = other->port[far] + run->state[j].axis;
                const double share = matrix[row * body->model->ports + column];
                sum += far == side ? share : -share;
            }
        }
    }
    return sum;
}

static int couple(aoi_newmark *run)
{
    const aoi_coupled *e = &run->coupled;
    double *compliance = e->compliance, *rate_compliance = e->rate_compliance;
    for (size_t i = 0; i < e->count; i++) {
        for (size_t k = 0; k <= 2 * e->band; k++) {
            const int inside = i + k >= e->band && i + k - e->band < e->count;
            *compliance++ = inside ? coupling(run, i, i + k - e->band, 0) : 0.0;
            *rate_compliance++ = inside ? coupling(run, i, i + k - e->band, 1) : 0.0;
        }
        if (!(compliance[-(ptrdiff_t)e->band - 1] > 0.0)) {
            return AOI_ERROR_NOT_POSITIVE;
        }
    }
    return AOI_OK;
}

/* Moves the springs of friction to the indentation and slides that a step has found. */
static int rub(aoi_contact_state *contact)
{
    aoi_rubbing *of = contact->rubbing;
    const aoi_oblique_solution *found = &of->found;
    const int status = aoi_friction_move(&of->rub.friction, &of->state, found->place[0], found->share, &found->place[1]);
    of->depth = found->place[0];
    memcpy(of->guess, found->place, sizeof of->guess);
    for (int k = 1; k < 3; k++) {
        contact[k].from += found->place[k];
    }
    return status;
}

/* Starts the friction of a contact, for straight motion of the bodies from (0, 0) to their indentation and slides. */
static int rubbing_begin(const aoi_contact *of, aoi_contact_state *contact, const aoi_newmark *run)
{
    aoi_rubbing *rubbing = contact->rubbing;
    aoi_oblique_equation equation = {.rate_free = contact->rate};
    *rubbing = (aoi_rubbing){.rub = aoi_rub_of(of), .state = rubbing->state};
    rubbing->state.count = 0;
    rubbing->state.indentation = 0.0;
    for (size_t i = 0; i < 3; i++) {
        equation.free[i] = equation.guess[i] =
            run->displacement[contact->port[0] + i] - run->displacement[contact->port[1] + i] - (i == 0 ? of->gap : 0.0);
    }
    int status = aoi_rub_solve(&rubbing->rub, &rubbing->state, &equation, &rubbing->found);
    if (status == AOI_OK && rubbing->found.place[0] == 0.0 && contact->rate > 0.0 && of->law->depends_on_rate) {
        rubbing->found.force[0] = aoi_law_push_only(&of->friction->law, NULL, DBL_MIN, contact->rate);
    }
    if (status == AOI_OK) {
        status = rub(contact);
        rubbing->guess[1] = rubbing->guess[2] = 0.0; /* the guess for the next step is no slide */
        rubbing->start_energy = aoi_friction_energy(of->friction, &rubbing->state);
        contact->start_energy = aoi_law_potential(&of->friction->law, NULL, rubbing->depth);
    }
    return status;
}

/* Sets the state of a contact force at the start. A force that depends on the rate acts as soon as the bodies
 * touch. */
static int contact_begin(const aoi_newmark *run, size_t i, const aoi_start *start)
{
    aoi_contact_state *contact = &run->state[i];
    const aoi_contact *of = &run->system->contact[contact->contact];
    const aoi_law *law = of->law;
    const size_t a = contact->port[0], b = contact->port[1];
    aoi_law_value value;
    contact->indentation = run->displacement[a] - run->displacement[b] - contact->from;
    contact->rate = run->velocity[a] - run->velocity[b];
    contact->last_indentation = contact->indentation;
    if (contact->rubbing) {
        const int status = contact->axis > 0 ? AOI_OK : rubbing_begin(of, contact, run);
        contact->force = start->force ? start->force[i] : contact->rubbing->found.force[contact->axis];
        return status;
    }
    double at = contact->indentation;
    if (at == 0.0 && contact->rate > 0.0 && law->depends_on_rate) {
        at = DBL_MIN;
    }
    aoi_law_push(law, contact->memory, at, contact->rate, &value);
    contact->force = start->force ? start->force[i] : value.force;
    if (isfinite(contact->indentation) && isnan(value.force)) {
        return AOI_ERROR_LAW;
    }
    if (!isfinite(contact->indentation) || !isfinite(contact->force)) {
        return AOI_ERROR_NOT_FINITE;
    }
    aoi_law_remember(law, contact->indentation, contact->rate, contact->memory);
    contact->start_energy = aoi_law_potential(law, contact->memory, contact->indentation);
    return aoi_law_stands(law, contact->memory, contact->indentation, contact->rate) ? AOI_OK
                                                                                     : AOI_ERROR_PATCH;
}

/* Updates the three forces of a contact with friction, and its state, from the last step to this one. */
static int rubbing_advance(aoi_contact_state *contact)
{
    aoi_rubbing *of = contact->rubbing;
    const double *force = of->found.force, touched = of->depth;
    contact->work += 0.5 * (contact->force + force[0]) * (of->found.place[0] - touched);
    for (size_t k = 0; k < 3; k++) {
        of->work += k > 0 ? 0.5 * (contact[k].force + force[k]) * of->found.place[k] : 0.0;
        contact[k].force = force[k];
    }
    const int status = rub(contact);
    of->guess[0] += touched > 0.0 ? of->depth - touched : 0.0;
    contact->indentation = of->depth;
    for (size_t k = 0; k < 3; k++) {
        contact->indentation -= of->rub.compliance[0][k] * force[k];
    }
    const double alone = of->depth - contact->law->compliance * force[0];
    return aoi_law_stands(contact->law, contact->memory, alone, of->found.rate) ? status : AOI_ERROR_PATCH;
}

static int contact_advance(const aoi_coupled *e, size_t c, aoi_contact_state *contact)
{
    if (contact->rubbing) {
        return contact->axis > 0 ? AOI_OK : rubbing_advance(contact);
    }
    const double indentation = e->indentation[c];
    contact->work += 0.5 * (contact->force + e->force[c]) * (indentation - contact->indentation);
    contact->last_indentation = contact->indentation;
    contact->indentation = indentation;
    contact->force = e->force[c];
    contact->rate = e->rate[c];
    if (contact->law->remember) {
        aoi_law_remember(contact->law, indentation, contact->rate, contact->memory);
    }
    return aoi_law_stands(contact->law, contact->memory, indentation, contact->rate) ? AOI_OK
                                                                                     : AOI_ERROR_PATCH;
}

/* --------------------------------------------------------------------------- the record */

/* Writes the rows of friction. Returns the energy of the stretches minus the energy of the compliance taken out of
 * law and friction, J, which is stored in the bodies. */
static double write_friction(const aoi_contact_state *contact, double *row)
{
    const aoi_rubbing *of = contact->rubbing;
    const double stretched = aoi_friction_energy(&of->rub.friction, &of->state);
    double taken_out = 0.0;
    for (size_t i = 0; i < 9; i++) {
        taken_out += 0.5 * contact[i / 3].force * of->rub.compliance[i / 3][i % 3] * contact[i % 3].force;
    }
    row[AOI_CONTACT_TANGENTIAL * BLOCK] = contact[1].force;
    row[(AOI_CONTACT_TANGENTIAL + 1) * BLOCK] = contact[2].force;
    row[AOI_CONTACT_FRICTION * BLOCK] = of->work - (stretched - of->start_energy);
    row[AOI_CONTACT_STUCK * BLOCK] = of->depth > 0.0 ? of->found.stuck / of->depth : 0.0;
    return stretched - taken_out;
}

static void write_contact(const aoi_contact_state *contact, int energies, double *row)
{
    const aoi_rubbing *rubbing = contact->rubbing;
    /* with friction the law is a function of the contact's own indentation */
    const aoi_law *law = rubbing ? &rubbing->rub.friction.law : contact->law;
    const double stretched = rubbing ? write_friction(contact, row) : 0.0;
    row[AOI_CONTACT_FORCE * BLOCK] = contact->force;
    row[AOI_CONTACT_INDENTATION * BLOCK] = contact->indentation;
    if (energies) {
        const double elastic =
            aoi_law_potential(law, contact->memory, rubbing ? rubbing->depth : contact->indentation);
        const int loses = law->depends_on_rate || law->turns;
        row[AOI_CONTACT_ELASTIC * BLOCK] = elastic + stretched;
        row[AOI_CONTACT_DISSIPATED * BLOCK] = loses ? contact->work - (elastic - contact->start_energy) : 0.0;
    }
}

/* Adds the work of loads and gravity on body b since the start to its row of work. */
static void write_work(aoi_newmark *run, size_t b, double *row)
{
    const size_t *first = run->system->first_port;
    for (size_t p = first[b]; p < first[b + 1] && run->loaded; p++) {
        const double moved = run->displacement[p] - run->displacement_before[p];
        run->load_work[b] += 0.5 * (run->load_before[p] + run->load[p]) * moved;
    }
    row[AOI_BODY_WORK * BLOCK] += run->load_work[b] - run->gravity_start[b];
}

/* Writes the present state to column `slot` of the block of gathered columns. */
static void write_column(aoi_newmark *run, size_t slot)
{
    const aoi_system *system = run->system;
    double *row = run->column + slot;
    for (size_t i = 0; i < run->coupled.count; i++) {
        if (run->state[i].axis == 0) {
            write_contact(&run->state[i], run->energies, row);
            row += (run->state[i].rubbing ? AOI_FRICTION_ROWS : AOI_CONTACT_ROWS) * BLOCK;
        }
    }
    for (size_t b = 0; b < system->body_count; b++) {
        const size_t first = system->first_port[b];
        aoi_stepped_observe(&run->body[b], run->push + first, run->push_before + first, run->energies, row, BLOCK);
        if (run->energies) {
            write_work(run, b, row);
        }
        row += AOI_BODY_ROWS * BLOCK;
        for (size_t p = first; p < system->first_port[b + 1]; p++, row += AOI_PORT_ROWS * BLOCK) {
            row[0] = run->displacement[p];
            row[BLOCK] = run->velocity[p];
        }
    }
}

static void copy_rows(const double **from, double **to, size_t rows, size_t columns, size_t count)
{
    for (size_t i = 0; i < rows; i++) {
        memcpy(*to, *from, count * sizeof(double));
        *from += BLOCK;
        *to += columns;
    }
}

/* Writes `count` gathered columns to the record, from column `first` on. If energies are not wanted, their rows,
 * which follow two other rows of each contact and body, are left out. */
static void write_block(const aoi_newmark *run, size_t first, size_t count)
{
    const aoi_system *system = run->system;
    const double *from = run->column;
    double *to = run->record + first;
    for (size_t i = 0; i < system->contact_count + system->body_count; i++) {
        const int is_contact = i < system->contact_count;
        const size_t all = is_contact ? (size_t)AOI_CONTACT_ROWS : (size_t)AOI_BODY_ROWS;
        const size_t kept = run->energies ? all : 2;
        copy_rows(&from, &to, kept, run->columns, count);
        from += (all - kept) * BLOCK;
        to += (all - kept) * run->columns;
        const size_t more = is_contact ? 2 * (aoi_contact_forces(&system->contact[i]) - 1)
                                       : AOI_PORT_ROWS * run->body[i - system->contact_count].model->ports;
        copy_rows(&from, &to, more, run->columns, count);
    }
}

/* ---------------------------------------------------------------------------- in time */

/* Finds the loads on all ports at a time and, if slope is not NULL, their rates just after that time. */
static void find_loads(aoi_newmark *run, double time, double *slope)
{
    const aoi_system *system = run->system;
    for (size_t b = 0; b < system->body_count; b++) {
        const aoi_load *load = &system->body[b].load;
        const size_t ports = system->body[b].ports;
        double *now = run->load + system->first_port[b];
        if (load->count > 0) {
            const aoi_load_span at = aoi_load_at(load, ports, time);
            for (size_t p = 0; p < ports; p++) {
                now[p] = at.here[p] + (at.next[p] - at.here[p]) * (at.into / at.length);
                if (slope) {
                    slope[system->first_port[b] + p] = (at.next[p] - at.here[p]) / at.length;
                }
            }
        }
    }
}

/* Sets `push` to the forces on all ports (or their rates) due to the contact forces (or their rates). */
static void find_push(const aoi_newmark *run, const double *force, double *push)
{
    memset(push, 0, run->system->first_port[run->system->body_count] * sizeof *push);
    for (size_t i = 0; i < run->coupled.count; i++) {
        push[run->state[i].port[0]] -= force[i];
        push[run->state[i].port[1]] += force[i];
    }
}

/* Adds the effect of a force on a port of body b to the displacements and velocities of all its ports at the end
 * of the step. */
static void press(aoi_newmark *run, size_t b, size_t port, double force)
{
    const aoi_stepped *body = &run->body[b];
    const size_t ports = body->model->ports, first = run->system->first_port[b];
    for (size_t p = 0; p < ports; p++) {
        run->displacement[first + p] += body->compliance[p * ports + port] * force;
        run->velocity[first + p] += body->rate_compliance[p * ports + port] * force;
    }
}

/* Sets displacements and velocities of the ports at the start, from the bodies' coordinates and the deflection of
 * the residual compliance. */
static void find_ports(aoi_newmark *run)
{
    const aoi_system *system = run->system;
    for (size_t b = 0; b < system->body_count; b++) {
        const aoi_stepped *body = &run->body[b];
        const size_t n = body->model->n, first = system->first_port[b];
        const double *push = run->push + first, *before = run->push_before + first;
        for (size_t p = 0; p < body->model->ports; p++) {
            const double *shape = body->model->shape + p * n, settled = aoi_stepped_residual(body, p, push);
            const double moved = settled - aoi_stepped_residual(body, p, before);
            run->displacement[first + p] = aoi_vector_dot(n, shape, body->x) + settled;
            run->velocity[first + p] = aoi_vector_dot(n, shape, body->v) + moved / run->step.dt;
        }
    }
}

/* Sets the forces on the ports at the start, and extrapolates the forces one step before from their rates. If
 * contact forces are not given, both are zero. slope: rates of the loads. */
static void start_push(aoi_newmark *run, const aoi_start *start, const double *slope)
{
    const size_t ports = run->system->first_port[run->system->body_count];
    memset(run->push, 0, ports * sizeof(double));
    memset(run->push_before, 0, ports * sizeof(double));
    if (!start->force) {
        return;
    }
    find_push(run, start->force, run->push);
    if (start->force_rate) {
        find_push(run, start->force_rate, run->push_before);
    }
    for (size_t p = 0; p < ports; p++) {
        run->push[p] += run->load[p];
        run->push_before[p] = run->push[p] - run->step.dt * (run->push_before[p] + slope[p]);
    }
}

/* True if a body rests deflected by contact forces that are not given: only an adaptive run finds these. */
static int rests_deflected(const aoi_system *system, const aoi_start *start)
{
    return start->rested && !start->force && aoi_system_bends(system);
}

/* Sets the contact, ports, law and friction of each force. */
static void set_states(aoi_newmark *run)
{
    const aoi_system *system = run->system;
    aoi_rubbing *rubbing = run->rubbing;
    for (size_t c = 0, i = 0; c < system->contact_count; c++) {
        const aoi_contact *of = &system->contact[c];
        for (size_t axis = 0; axis < aoi_contact_forces(of); axis++, i++) {
            run->state[i] = (aoi_contact_state){.law = of->law, .contact = c, .axis = axis};
            run->state[i].from = axis > 0 ? 0.0 : of->gap;
            run->state[i].rubbing = of->friction ? rubbing : NULL;
            for (int side = 0; side < 2; side++) {
                run->state[i].port[side] = system->first_port[of->body[side]] + of->port[side] + axis;
            }
        }
        rubbing += of->friction != NULL;
    }
}

/* Sets the states of contacts and the accelerations of bodies at the start. */
static int begin(aoi_newmark *run, const aoi_start *start)
{
    const aoi_system *system = run->system;
    const size_t ports = system->first_port[system->body_count];
    /* arrays of the first step, which are not in use at the start */
    double *push = run->load_before, *slope = run->displacement_before;
    set_states(run);
    int status = couple(run);
    memset(run->load, 0, ports * sizeof(double));
    memset(slope, 0, ports * sizeof(double));
    find_loads(run, 0.0, slope);
    start_push(run, start, slope);
    find_ports(run);
    for (size_t i = 0; i < run->coupled.count && status == AOI_OK; i++) {
        status = contact_begin(run, i, start);
        run->failed = status != AOI_OK ? run->state[i].contact : run->failed;
        run->coupled.force[i] = run->state[i].force;
    }
    if (status != AOI_OK) {
        return status;
    }
    find_push(run, run->coupled.force, push);
    aoi_vector_add(ports, 1.0, run->load, push);
    for (size_t b = 0; b < system->body_count && status == AOI_OK; b++) {
        status = aoi_stepped_begin(&run->body[b], push + system->first_port[b]);
        run->load_work[b] = run->gravity_start[b] = 0.0;
    }
    memcpy(run->displacement_before, run->displacement, ports * sizeof(double));
    memcpy(run->load_before, run->load, ports * sizeof(double));
    return status;
}

int aoi_newmark_start(aoi_newmark *run, const aoi_system *system, const aoi_rule *rule,
                      const aoi_start *start, int energies, double *record, size_t columns)
{
    aoi_rule_step step;
    size_t size;
    if (!system->first || columns == 0 || rests_deflected(system, start) ||
        aoi_rule_prepare(rule, &step) != AOI_OK) {
        return AOI_ERROR_ARGUMENT;
    }
    const size_t all = system->first[system->body_count], forces = aoi_system_forces(system);
    if ((start->force && !aoi_vector_is_finite(forces, start->force)) ||
        (start->force_rate && !aoi_vector_is_finite(forces, start->force_rate))) {
        return AOI_ERROR_NOT_FINITE;
    }
    *run = lay_out(system, run, &size);
    run->step = step;
    run->energies = energies;
    run->record = record;
    run->columns = columns;
    run->failed = SIZE_MAX;
    if (!aoi_vector_take(all, start->x, run->x) || !aoi_vector_take(all, start->v, run->v)) {
        return AOI_ERROR_NOT_FINITE;
    }
    int status = AOI_OK;
    for (size_t b = 0; b < system->body_count && status == AOI_OK; b++) {
        status = aoi_stepped_start(&run->body[b], &run->step);
    }
    if (status == AOI_OK) {
        status = begin(run, start);
    }
    if (status == AOI_OK) {
        write_column(run, 0);
        for (size_t b = 0; b < system->body_count && energies; b++) {
            double *work = run->column + (aoi_record_body(system, b) + AOI_BODY_WORK) * BLOCK;
            run->gravity_start[b] = *work;
            *work = 0.0;
        }
        write_block(run, 0, 1);
    }
    return status;
}

/* Advances all bodies and ports to the end of a step, under loads but without contact forces. */
static int predict(aoi_newmark *run, double time)
{
    const aoi_system *system = run->system;
    const size_t *first = system->first_port, bytes = first[system->body_count] * sizeof(double);
    if (run->loaded) {
        memcpy(run->displacement_before, run->displacement, bytes);
        memcpy(run->load_before, run->load, bytes);
        find_loads(run, time, NULL);
    }
    if (run->deflects) {
        memcpy(run->push_before, run->push, bytes);
    }
    memcpy(run->push, run->load, bytes);
    for (size_t b = 0; b < system->body_count; b++) {
        aoi_stepped *body = &run->body[b];
        double *u = run->displacement + first[b], *v = run->velocity + first[b];
        if (body->plain) {
            aoi_plain_predict(body, u, v);
        } else {
            const int status = aoi_stepped_predict(body, u, v);
            if (status != AOI_OK) {
                return status;
            }
        }
        for (size_t p = 0; run->deflects && p < body->model->ports; p++) {
            v[p] -= aoi_stepped_residual(body, p, run->push_before + first[b]) / run->step.dt;
        }
        for (size_t p = 0; run->loaded && p < body->model->ports; p++) {
            press(run, b, p, run->load[first[b] + p]);
        }
    }
    return AOI_OK;
}

/* Adds the effect of the contact forces to bodies and ports. */
static void correct(aoi_newmark *run)
{
    const aoi_system *system = run->system;
    for (size_t i = 0; i < run->coupled.count; i++) {
        const aoi_contact_state *contact = &run->state[i];
        const aoi_contact *of = &system->contact[contact->contact];
        const double force[2] = {-run->coupled.force[i], run->coupled.force[i]};
        for (int side = 0; side < 2; side++) {
            run->push[contact->port[side]] += force[side];
            press(run, of->body[side], of->port[side] + contact->axis, force[side]);
        }
    }
    for (size_t b = 0; b < system->body_count; b++) {
        aoi_stepped *body = &run->body[b];
        const double *push = run->push + system->first_port[b];
        if (body->plain) {
            aoi_plain_correct(body, *push, run->energies);
        } else {
            aoi_stepped_correct(body, push);
        }
    }
}

static int step(aoi_newmark *run, double time)
{
    aoi_coupled *e = &run->coupled;
    int status = predict(run, time);
    for (size_t c = 0; c < e->count; c++) {
        const aoi_contact_state *contact = &run->state[c];
        const size_t *port = contact->port;
        e->free[c] = run->displacement[port[0]] - run->displacement[port[1]] - contact->from;
        e->rate_free[c] = run->velocity[port[0]] - run->velocity[port[1]];
    }
    for (size_t i = 0; i < (e->count - run->system->contact_count) / 2 && status == AOI_OK; i++) {
        aoi_rubbing *of = &run->rubbing[i];
        status = aoi_friction_refine(&of->rub.friction, &of->state, of->guess[0], of->found.share, &of->guess[1]);
    }
    if (status == AOI_OK) {
        status = aoi_coupled_solve(e, run->state);
        run->failed = status == AOI_ERROR_LAW ? run->state[e->failed].contact : run->failed;
    }
    for (size_t c = 0; c < e->count && status == AOI_OK; c++) {
        status = contact_advance(e, c, &run->state[c]);
        run->failed = status != AOI_OK ? run->state[c].contact : run->failed;
    }
    if (status == AOI_OK) {
        correct(run);
    }
    return status;
}

int aoi_newmark_run(aoi_newmark *run, size_t last, size_t *done)
{
    int status = last < run->columns ? AOI_OK : AOI_ERROR_ARGUMENT;
    size_t written = run->done + 1, column = written; /* the block has the columns from `written` to column - 1 */
    for (; column <= last && status == AOI_OK; column++) {
        if (column - written == BLOCK) {
            write_block(run, written, BLOCK);
            written = column;
        }
        status = step(run, run->step.dt * (double)column);
        if (status != AOI_OK) {
            break;
        }
        write_column(run, column - written);
    }
    write_block(run, written, column - written);
    for (size_t b = 0; b < run->system->body_count; b++) {
        aoi_stepped_settle(&run->body[b]);
    }
    *done = run->done = column - 1;
    return status;
}
