/* Bodies, contacts and loads, step by step: predict all bodies, solve the contact equations, correct
 * all bodies, write the record. */
#include "newmark/body.h"
#include "newmark/scene.h"
#include "linear/work.h"
#include "law/law.h"
#include "model/coupled.h"
#include "model/load.h"

#include <float.h>
#include <math.h>
#include <string.h>

/* Columns of the record that are gathered before they are written: a cache line of each row. */
enum { BLOCK = 8 };

static size_t count_ports(const aoi_scene *scene)
{
    size_t ports = 0;
    for (size_t b = 0; b < scene->body_count; b++) {
        ports += scene->body[b]->ports;
    }
    return ports;
}

static size_t count_rows(const aoi_scene *scene, size_t ports)
{
    return AOI_CONTACT_ROWS * scene->contact_count + AOI_BODY_ROWS * scene->body_count +
           AOI_PORT_ROWS * ports;
}

size_t aoi_scene_rows(const aoi_scene *scene) { return count_rows(scene, count_ports(scene)); }

/* ---------------------------------------------------------------------------- the layout */

/* Whether a body hands the force of one contact on to another: a wall does not. */
static int couples(const aoi_body *body)
{
    for (size_t i = 0; i < body->ports * body->ports; i++) {
        if (body->compliance[i] != 0.0) {
            return 1;
        }
    }
    return 0;
}

/* How far apart contacts that share such a body stand. */
static size_t find_band(const aoi_scene *scene)
{
    size_t band = 0, *earliest = scene->first_port; /* 1 + its first contact, of each body */
    memset(earliest, 0, scene->body_count * sizeof *earliest);
    for (size_t c = 0; c < scene->contact_count; c++) {
        for (int side = 0; side < 2; side++) {
            const size_t b = scene->contact[c].body[side];
            const aoi_body *body = scene->body[b];
            if (!couples(body)) {
                continue;
            }
            if (earliest[b] == 0) {
                earliest[b] = c + 1;
            }
            band = c + 1 - earliest[b] > band ? c + 1 - earliest[b] : band;
        }
    }
    return band;
}

/* Deals out memory; which is only counted where it is NULL. */
static size_t lay_out(aoi_scene *scene, size_t ports, size_t band, void *block)
{
    aoi_memory memory = {block, 0};
    const size_t contacts = scene->contact_count;
    aoi_coupled *e = &scene->coupled;
    e->count = contacts;
    e->band = band;
    scene->state = aoi_memory_take(&memory, contacts, sizeof *scene->state);
    scene->displacement = aoi_memory_doubles(&memory, ports);
    scene->free_displacement = aoi_memory_doubles(&memory, ports);
    scene->free_velocity = aoi_memory_doubles(&memory, ports);
    scene->push = aoi_memory_doubles(&memory, ports);
    scene->load_now = aoi_memory_doubles(&memory, ports);
    scene->load_before = aoi_memory_doubles(&memory, ports);
    scene->load_work = aoi_memory_doubles(&memory, scene->body_count);
    scene->gravity_start = aoi_memory_doubles(&memory, scene->body_count);
    e->compliance = aoi_memory_doubles(&memory, aoi_times(2 * e->band + 1, contacts));
    e->rate_compliance = aoi_memory_doubles(&memory, aoi_times(2 * e->band + 1, contacts));
    e->free = aoi_memory_doubles(&memory, contacts);
    e->rate_free = aoi_memory_doubles(&memory, contacts);
    e->indentation = aoi_memory_doubles(&memory, contacts);
    e->rate = aoi_memory_doubles(&memory, contacts);
    e->force = aoi_memory_doubles(&memory, contacts);
    e->work = aoi_memory_doubles(&memory, aoi_coupled_size(contacts, e->band));
    scene->column = aoi_memory_doubles(&memory, BLOCK * count_rows(scene, ports));
    return memory.used;
}

size_t aoi_scene_size(const aoi_scene *scene)
{
    aoi_scene counted = *scene;
    return lay_out(&counted, count_ports(scene), find_band(scene), NULL);
}

size_t aoi_scene_most(size_t bodies, size_t ports, size_t contacts, size_t band)
{
    aoi_scene counted = {.body_count = bodies, .contact_count = contacts};
    return lay_out(&counted, ports, band, NULL);
}

/* Where ports and contacts have their places. */
static void find_places(aoi_scene *scene)
{
    scene->first_port[0] = 0;
    for (size_t b = 0; b < scene->body_count; b++) {
        scene->first_port[b + 1] = scene->first_port[b] + scene->body[b]->ports;
    }
    for (size_t c = 0; c < scene->contact_count; c++) {
        const aoi_contact *contact = &scene->contact[c];
        scene->state[c].law = contact->law;
        for (int side = 0; side < 2; side++) {
            scene->state[c].port[side] = scene->first_port[contact->body[side]] + contact->port[side];
        }
    }
}

/* ------------------------------------------------------------------------- at the start */

static int has_port(const aoi_scene *scene, size_t body, size_t port)
{
    return body < scene->body_count && port < scene->body[body]->ports;
}

int aoi_scene_check(const aoi_scene *scene)
{
    if (!isfinite(scene->dt) || (scene->load_count > 0 && !(scene->dt > 0.0))) {
        return AOI_ERROR_ARGUMENT;
    }
    for (size_t c = 0; c < scene->contact_count; c++) {
        const aoi_contact *contact = &scene->contact[c];
        if (!has_port(scene, contact->body[0], contact->port[0]) ||
            !has_port(scene, contact->body[1], contact->port[1]) || !isfinite(contact->gap) ||
            aoi_law_check(contact->law) != AOI_OK) {
            return AOI_ERROR_ARGUMENT;
        }
    }
    for (size_t i = 0; i < scene->load_count; i++) {
        const aoi_scene_load *on = &scene->load[i];
        if (!has_port(scene, on->body, on->port) || on->ports == 0 ||
            !has_port(scene, on->body, on->port + on->ports - 1) || on->load.count == 0 ||
            !aoi_load_is_sound(&on->load, on->ports)) {
            return AOI_ERROR_ARGUMENT;
        }
    }
    return AOI_OK;
}

/* What a force of contact j takes from the indentation of contact i (or its rate, by the bodies'
 * other matrix): they push the bodies that they share apart from the same side, or against each
 * other. */
static double coupling(const aoi_scene *scene, size_t i, size_t j, int of_rate)
{
    const aoi_contact *one = &scene->contact[i], *other = &scene->contact[j];
    double sum = 0.0;
    for (int side = 0; side < 2; side++) {
        const aoi_body *body = scene->body[one->body[side]];
        const double *matrix = of_rate ? body->rate_compliance : body->compliance;
        for (int far = 0; far < 2; far++) {
            if (other->body[far] == one->body[side]) {
                const double share = matrix[one->port[side] * body->ports + other->port[far]];
                sum += far == side ? share : -share;
            }
        }
    }
    return sum;
}

static int couple(aoi_scene *scene)
{
    const aoi_coupled *e = &scene->coupled;
    double *compliance = e->compliance, *rate_compliance = e->rate_compliance;
    for (size_t i = 0; i < e->count; i++) {
        for (size_t k = 0; k <= 2 * e->band; k++) {
            const int inside = i + k >= e->band && i + k - e->band < e->count;
            *compliance++ = inside ? coupling(scene, i, i + k - e->band, 0) : 0.0;
            *rate_compliance++ = inside ? coupling(scene, i, i + k - e->band, 1) : 0.0;
        }
        if (!(compliance[-(ptrdiff_t)e->band - 1] > 0.0)) {
            return AOI_ERROR_NOT_POSITIVE;
        }
    }
    return AOI_OK;
}

/* The force at the start. A force that depends on the rate is there as soon as the bodies touch. */
static int contact_begin(const aoi_scene *scene, size_t c)
{
    aoi_contact_state *contact = &scene->state[c];
    const aoi_law *law = contact->law;
    const size_t a = contact->port[0], b = contact->port[1];
    aoi_law_value value;
    contact->indentation = scene->displacement[a] - scene->displacement[b] - scene->contact[c].gap;
    contact->rate = scene->free_velocity[a] - scene->free_velocity[b];
    contact->last_indentation = contact->indentation;
    contact->work = 0.0;
    memset(contact->memory, 0, sizeof contact->memory);
    double at = contact->indentation;
    if (at == 0.0 && contact->rate > 0.0 && law->depends_on_rate) {
        at = DBL_MIN;
    }
    aoi_law_push(law, contact->memory, at, contact->rate, &value);
    contact->force = scene->start_force ? scene->start_force[c] : value.force;
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

/* --------------------------------------------------------------------------- the record */

static void write_contact(const aoi_contact_state *contact, int energies, double *row)
{
    row[0 * BLOCK] = contact->force;
    row[1 * BLOCK] = contact->indentation;
    if (energies) {
        const int loses = contact->law->depends_on_rate || contact->law->turns;
        const double elastic =
            aoi_law_potential(contact->law, contact->memory, contact->indentation);
        row[2 * BLOCK] = elastic;
        row[3 * BLOCK] = loses ? contact->work - (elastic - contact->start_energy) : 0.0;
    }
}

/* Adds the work of loads and gravity since the start. */
static void write_work(aoi_scene *scene, size_t b, double *row)
{
    const size_t first = scene->first_port[b], ports = scene->body[b]->ports;
    for (size_t p = 0; p < ports && scene->load_count > 0; p++) {
        const double load = scene->load_before[first + p] + scene->load_now[first + p];
        const double now = row[(AOI_BODY_ROWS + AOI_PORT_ROWS * p) * BLOCK];
        scene->load_work[b] += 0.5 * load * (now - scene->displacement[first + p]);
        scene->displacement[first + p] = now;
    }
    row[AOI_BODY_WORK * BLOCK] += scene->load_work[b] - scene->gravity_start[b];
}

/* Gathers what is now as the next column of the block. */
static void write_column(aoi_scene *scene, size_t slot)
{
    double *row = scene->column + slot;
    for (size_t c = 0; c < scene->contact_count; c++) {
        write_contact(&scene->state[c], scene->energies, row);
        row += AOI_CONTACT_ROWS * BLOCK;
    }
    for (size_t b = 0; b < scene->body_count; b++) {
        scene->body[b]->observe(scene->body[b], scene->energies, row, BLOCK);
        if (scene->energies) {
            write_work(scene, b, row);
        }
        row += (AOI_BODY_ROWS + AOI_PORT_ROWS * scene->body[b]->ports) * BLOCK;
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

static void skip_rows(const double **from, double **to, size_t rows, size_t columns)
{
    *from += rows * BLOCK;
    *to += rows * columns;
}

/* Writes count gathered columns to the record, from column first on. */
static void write_block(const aoi_scene *scene, double *record, size_t columns, size_t first,
                        size_t count)
{
    const double *from = scene->column;
    double *to = record + first;
    for (size_t i = 0; i < scene->contact_count + scene->body_count; i++) {
        const int is_contact = i < scene->contact_count;
        const size_t all = is_contact ? (size_t)AOI_CONTACT_ROWS : (size_t)AOI_BODY_ROWS;
        const size_t kept = scene->energies ? all : 2;
        copy_rows(&from, &to, kept, columns, count);
        skip_rows(&from, &to, all - kept, columns);
        if (!is_contact) {
            const size_t ports = scene->body[i - scene->contact_count]->ports;
            copy_rows(&from, &to, AOI_PORT_ROWS * ports, columns, count);
        }
    }
}

/* ---------------------------------------------------------------------------- in time */

static void find_loads(aoi_scene *scene, double time)
{
    const size_t ports = scene->first_port[scene->body_count];
    if (time > 0.0) {
        memcpy(scene->load_before, scene->load_now, ports * sizeof(double));
    }
    memset(scene->load_now, 0, ports * sizeof(double));
    for (size_t i = 0; i < scene->load_count; i++) {
        const aoi_scene_load *on = &scene->load[i];
        const aoi_load_span at = aoi_load_at(&on->load, on->ports, time);
        double *now = scene->load_now + scene->first_port[on->body] + on->port;
        for (size_t p = 0; p < on->ports; p++) {
            now[p] += at.here[p] + (at.next[p] - at.here[p]) * (at.into / at.length);
        }
    }
}

/* Forces on the ports: loads and contacts. */
static void find_push(aoi_scene *scene)
{
    double *push = scene->push;
    const double *load = scene->load_now;
    for (size_t p = 0, ports = scene->first_port[scene->body_count]; p < ports; p++) {
        push[p] = load[p];
    }
    for (size_t c = 0; c < scene->contact_count; c++) {
        const aoi_contact_state *contact = &scene->state[c];
        push[contact->port[0]] -= contact->force;
        push[contact->port[1]] += contact->force;
    }
}

/* The bodies' ports where they are, and what gravity has done to get them there. */
static void look_at_bodies(aoi_scene *scene)
{
    double *row = scene->column;
    for (size_t b = 0; b < scene->body_count; b++) {
        scene->body[b]->observe(scene->body[b], 1, row, 1);
        scene->gravity_start[b] = row[AOI_BODY_WORK];
        scene->load_work[b] = 0.0;
        for (size_t p = 0; p < scene->body[b]->ports; p++) {
            const size_t at = scene->first_port[b] + p;
            scene->displacement[at] = row[AOI_BODY_ROWS + AOI_PORT_ROWS * p];
            scene->free_velocity[at] = row[AOI_BODY_ROWS + AOI_PORT_ROWS * p + 1];
        }
    }
}

int aoi_scene_start(aoi_scene *scene, double *record, size_t columns)
{
    int status = aoi_scene_check(scene);
    if (status != AOI_OK) {
        return status;
    }
    (void)lay_out(scene, count_ports(scene), find_band(scene), scene->memory);
    find_places(scene);
    status = couple(scene);
    find_loads(scene, 0.0);
    memcpy(scene->load_before, scene->load_now, scene->first_port[scene->body_count] * sizeof(double));
    look_at_bodies(scene);
    for (size_t c = 0; c < scene->contact_count && status == AOI_OK; c++) {
        status = contact_begin(scene, c);
    }
    if (status == AOI_OK) {
        find_push(scene);
    }
    for (size_t b = 0; b < scene->body_count && status == AOI_OK; b++) {
        status = scene->body[b]->begin(scene->body[b], scene->push + scene->first_port[b]);
    }
    if (status == AOI_OK) {
        write_column(scene, 0);
        write_block(scene, record, columns, 0, 1);
    }
    return status;
}

/* Adds what loads do at the end of the step to the free motion. */
static void add_loads(aoi_scene *scene)
{
    for (size_t b = 0; b < scene->body_count; b++) {
        const aoi_body *body = scene->body[b];
        const size_t first = scene->first_port[b];
        for (size_t i = 0; i < body->ports * body->ports; i++) {
            const size_t to = first + i / body->ports, from = first + i % body->ports;
            scene->free_displacement[to] += body->compliance[i] * scene->load_now[from];
            scene->free_velocity[to] += body->rate_compliance[i] * scene->load_now[from];
        }
    }
}

static int contact_advance(const aoi_coupled *e, size_t c, aoi_contact_state *contact)
{
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

static int scene_step(aoi_scene *scene, double time)
{
    aoi_coupled *e = &scene->coupled;
    int status = AOI_OK;
    for (size_t b = 0; b < scene->body_count && status == AOI_OK; b++) {
        const size_t first = scene->first_port[b];
        status = scene->body[b]->predict(scene->body[b], scene->free_displacement + first,
                                         scene->free_velocity + first);
    }
    if (scene->load_count > 0) {
        find_loads(scene, time);
        add_loads(scene);
    }
    const double *u = scene->free_displacement, *v = scene->free_velocity;
    for (size_t c = 0; c < e->count; c++) {
        const aoi_contact_state *contact = &scene->state[c];
        e->free[c] = u[contact->port[0]] - u[contact->port[1]] - scene->contact[c].gap;
        e->rate_free[c] = v[contact->port[0]] - v[contact->port[1]];
    }
    if (status == AOI_OK) {
        status = aoi_coupled_solve(e, scene->state);
    }
    for (size_t c = 0; c < scene->contact_count && status == AOI_OK; c++) {
        status = contact_advance(e, c, &scene->state[c]);
        scene->failed = c;
    }
    if (status == AOI_OK) {
        find_push(scene);
        for (size_t b = 0; b < scene->body_count; b++) {
            scene->body[b]->correct(scene->body[b], scene->push + scene->first_port[b]);
        }
    }
    return status;
}

int aoi_scene_run(aoi_scene *scene, double *record, size_t columns, size_t first, size_t last,
                  size_t *done)
{
    int status = AOI_OK;
    size_t written = first, column = first; /* those from written to column-1 are in the block */
    for (; column <= last; column++) {
        if (column - written == BLOCK) {
            write_block(scene, record, columns, written, BLOCK);
            written = column;
        }
        status = scene_step(scene, scene->dt * (double)column);
        if (status != AOI_OK) {
            break;
        }
        write_column(scene, column - written);
    }
    write_block(scene, record, columns, written, column - written);
    *done = column - 1;
    return status;
}
