/* Bodies, contacts and an adaptive run of them with all the memory it takes; and the same motion by
 * Runge and Kutta's classical method, which knows nothing of modes in closed form. */
#ifndef AOIMPACT_TEST_PLANT_H
#define AOIMPACT_TEST_PLANT_H

#include "check.h"
#include "adaptive/row.h"
#include "adaptive/run.h"
#include "aoimpact.h"

#include <stdlib.h>
#include <string.h>

#ifndef MOST_BODIES /* a test of many says so before */
#define MOST_BODIES 6
#endif

enum { MOST_MODES = 12, MOST_PORTS = 3, MOST_LOADS = 4, MOST_CONTACTS = MOST_BODIES };
enum { ALL_MODES = MOST_MODES * MOST_BODIES, FIRST_ROOM = 64, LAST_ROOM = 40000 };

/* A body: the arrays of its aoi_modes, and how it starts. */
typedef struct part {
    size_t n, ports, load_count;
    int damped, pulled, massless;
    double omega[MOST_MODES], decay[MOST_MODES], gravity[MOST_MODES], inertia[MOST_MODES];
    double centre[MOST_MODES], shape[MOST_PORTS * MOST_MODES], push[MOST_PORTS * MOST_MODES];
    double residual[MOST_PORTS * MOST_PORTS];
    double load_time[MOST_LOADS], load_force[MOST_LOADS * MOST_PORTS];
    double x[MOST_MODES], v[MOST_MODES];
} part;

typedef struct plant {
    part part[MOST_BODIES];
    aoi_modes body[MOST_BODIES];
    size_t bodies, contacts;
    aoi_contact contact[MOST_CONTACTS];
    aoi_system system;
    size_t links[3 * (MOST_BODIES + 2) + 3 * MOST_CONTACTS + 4];
    double x[ALL_MODES], v[ALL_MODES];
    int rested;
    aoi_adaptive *run;
    aoi_track track;
    aoi_sampler *sampler;
    aoi_contact_step entry[MOST_CONTACTS]; /* a step by itself */
    aoi_response response[MOST_BODIES];
    double *work;
} plant;

static inline aoi_modes part_modes(const part *of)
{
    return (aoi_modes){.n = of->n,
                       .ports = of->ports,
                       .omega = of->omega,
                       .decay = of->damped ? of->decay : NULL,
                       .shape = of->shape,
                       .push = of->push,
                       .residual = of->massless ? of->residual : NULL,
                       .gravity = of->pulled ? of->gravity : NULL,
                       .inertia = of->inertia,
                       .centre = of->centre,
                       .load = {of->load_count, of->load_time, of->load_force}};
}

static inline part *add_rigid(plant *p, double mass, double velocity)
{
    part *made = &p->part[p->bodies++];
    *made = (part){.n = 1, .ports = 1};
    made->shape[0] = made->centre[0] = 1.0;
    made->push[0] = 1.0 / mass;
    made->inertia[0] = mass;
    made->v[0] = velocity;
    return made;
}

static inline part *add_wall(plant *p)
{
    part *made = add_rigid(p, 1.0, 0.0);
    made->push[0] = made->inertia[0] = 0.0;
    return made;
}

/* A free body of that mass, mass-normalised modes up to a highest frequency, flying undeformed. */
static inline part *add_ringing(plant *p, size_t n, size_t ports, double mass, double highest,
                                double velocity, uint64_t *seed)
{
    part *made = &p->part[p->bodies++];
    *made = (part){.n = n, .ports = ports};
    for (size_t j = 0; j < n; j++) {
        made->omega[j] = highest * (double)j / (double)(n > 1 ? n - 1 : 1);
        made->inertia[j] = 1.0;
        for (size_t q = 0; q < ports; q++) {
            const double side = uniform(seed) < 0.5 ? -1.0 : 1.0;
            made->shape[q * n + j] = (j == 0 ? 1.0 : side * (0.4 + 0.6 * uniform(seed))) / sqrt(mass);
            made->push[q * n + j] = made->shape[q * n + j];
        }
    }
    made->centre[0] = 1.0 / sqrt(mass);
    made->v[0] = velocity * sqrt(mass);
    return made;
}

static inline void join(plant *p, size_t one, size_t port, size_t other, size_t other_port, double gap,
                        const aoi_law *law)
{
    p->contact[p->contacts++] = (aoi_contact){{one, other}, {port, other_port}, gap, law, NULL, NULL};
}

static inline void join_rigid(plant *p, size_t one, size_t other, double gap, const aoi_law *law)
{
    join(p, one, 0, other, 0, gap, law);
}

/* A rigid body that touches a wall. */
static inline plant ball_on_wall(double mass, double velocity, const aoi_law *law)
{
    plant p = {.bodies = 0};
    add_rigid(&p, mass, velocity);
    add_wall(&p);
    join_rigid(&p, 0, 1, 0.0, law);
    return p;
}

static inline aoi_law law_named(const char *name, size_t count, double a, double b, double c)
{
    const double parameter[] = {a, b, c};
    aoi_law law;
    CHECK(aoi_law_create(&law, name, count, parameter) == AOI_OK, "the law %s", name);
    return law;
}

static inline aoi_law hertz(double k) { return law_named("hertz", 1, k, 0.0, 0.0); }
static inline aoi_law linear(double k) { return law_named("linear", 1, k, 0.0, 0.0); }

/* The system, from what was added; what linking it says. */
static inline int lay_out(plant *p)
{
    for (size_t b = 0; b < p->bodies; b++) {
        p->body[b] = part_modes(&p->part[b]);
    }
    p->system = (aoi_system){.body_count = p->bodies, .contact_count = p->contacts, .body = p->body};
    p->system.contact = p->contact;
    CHECK(aoi_system_size(&p->system) <= sizeof p->links, "room for links");
    const int status = aoi_system_link(&p->system, p->links);
    for (size_t b = 0; status == AOI_OK && b < p->bodies; b++) {
        memcpy(p->x + p->system.first[b], p->part[b].x, p->part[b].n * sizeof(double));
        memcpy(p->v + p->system.first[b], p->part[b].v, p->part[b].n * sizeof(double));
    }
    return status;
}

/* Makes the track as long as so many of the longest rows. */
static inline void make_room(plant *p, size_t rows)
{
    p->track.capacity = rows * aoi_adaptive_room(&p->system);
    p->track.row_capacity = rows;
    p->track.values = realloc(p->track.values, p->track.capacity * sizeof(double));
    p->track.row = realloc(p->track.row, rows * sizeof(size_t));
}

static inline int begin(plant *p, double rtol, double end)
{
    const int status = lay_out(p);
    const aoi_start start = {.x = p->x, .v = p->v, .rested = p->rested};
    if (status != AOI_OK) {
        return status;
    }
    p->run = malloc(aoi_adaptive_size(&p->system));
    p->sampler = malloc(aoi_sampler_size(&p->system));
    make_room(p, FIRST_ROOM);
    return aoi_adaptive_start(p->run, &p->system, &start, rtol, end);
}

/* x and v as the run has left them. */
static inline void keep_state(plant *p)
{
    memcpy(p->x, p->run->x, p->system.first[p->bodies] * sizeof(double));
    memcpy(p->v, p->run->v, p->system.first[p->bodies] * sizeof(double));
}

static inline int go(plant *p, double rtol, double end)
{
    int status = begin(p, rtol, end);
    if (status != AOI_OK) {
        return status;
    }
    status = aoi_adaptive_finish(p->run, &p->track);
    while (status == AOI_ERROR_TOO_LONG && p->track.row_capacity < LAST_ROOM) {
        make_room(p, 2 * p->track.row_capacity);
        status = aoi_adaptive_finish(p->run, &p->track);
    }
    keep_state(p);
    return status;
}

static inline void must_go(plant *p, double rtol, double end)
{
    const int status = go(p, rtol, end);
    CHECK(status == AOI_OK, "it runs: status %d at %g", status, p->run->time);
    CHECK(p->run->time == end, "to the end: %.17g of %g", p->run->time, end);
}

static inline void release(plant *p)
{
    free(p->run);
    free(p->sampler);
    free(p->track.values);
    free(p->track.row);
    free(p->work);
}

static inline int open_sampler(plant *p)
{
    const int status = aoi_track_check(&p->system, &p->track);
    return status == AOI_OK ? aoi_sampler_start(p->sampler, &p->system, &p->track) : status;
}

/* A contact's force, of a plant without energies whose sampler is open. */
static inline double force_at(plant *p, size_t contact, double time)
{
    double record[MOST_CONTACTS * AOI_CONTACT_ROWS + MOST_BODIES * (AOI_BODY_ROWS + MOST_PORTS * AOI_PORT_ROWS)];
    aoi_sampler_column(p->sampler, time, 0, record, 1);
    return record[contact * AOI_CONTACT_ROWS];
}

/* Start (what = AOI_TRACK_BEGINS) or end of a contact's first interval of force; -1 if there is none. A
 * contact that is in no row any more has ended where its last one did. */
static inline double moment_of(const plant *p, size_t c, enum aoi_row_contact what)
{
    double last = -1.0;
    for (size_t r = 0; r < p->track.rows; r++) {
        const double *row = p->track.values + p->track.row[r], *of = row + AOI_TRACK_FIXED;
        for (size_t i = 0; i < (size_t)row[AOI_TRACK_BODIES]; i++) {
            of += AOI_TRACK_STATE + 2 * p->part[(size_t)of[0]].n;
        }
        for (size_t i = 0; i < (size_t)row[AOI_TRACK_CONTACTS]; i++, of += AOI_TRACK_CONTACT_SIZE) {
            if ((size_t)of[AOI_TRACK_CONTACT] != c) {
                continue;
            }
            last = row[AOI_TRACK_START] + (what == AOI_TRACK_ENDS ? row[AOI_TRACK_LENGTH] : 0.0);
            if (of[what] != 0.0) {
                return last;
            }
        }
    }
    return what == AOI_TRACK_ENDS ? last : -1.0;
}

/* ------------------------------------------------------------------------- the second method */

static inline double load_on(const part *of, size_t port, double time)
{
    const double *t = of->load_time, *f = of->load_force + port;
    size_t i = 0;
    while (i < of->load_count && t[i] <= time) {
        i++;
    }
    if (of->load_count == 0) {
        return 0.0;
    }
    if (i == 0 || i == of->load_count) {
        return f[(i == 0 ? 0 : i - 1) * of->ports];
    }
    const double here = f[(i - 1) * of->ports], next = f[i * of->ports];
    return here + (next - here) * (time - t[i - 1]) / (t[i] - t[i - 1]);
}

static inline double displacement_of(const plant *p, size_t b, size_t port, const double *x)
{
    double sum = 0.0;
    for (size_t j = 0; j < p->part[b].n; j++) {
        sum += p->part[b].shape[port * p->part[b].n + j] * x[p->system.first[b] + j];
    }
    return sum;
}

/* x'' of all modes; no residual compliance. */
static inline void accelerations(const plant *p, double time, const double *x, const double *v, double *a)
{
    double force[MOST_BODIES][MOST_PORTS];
    for (size_t b = 0; b < p->bodies; b++) {
        for (size_t q = 0; q < p->part[b].ports; q++) {
            force[b][q] = load_on(&p->part[b], q, time);
        }
    }
    for (size_t c = 0; c < p->contacts; c++) {
        const aoi_contact *of = &p->contact[c];
        const double d = displacement_of(p, of->body[0], of->port[0], x) -
                         displacement_of(p, of->body[1], of->port[1], x) - of->gap;
        const double rate = displacement_of(p, of->body[0], of->port[0], v) -
                            displacement_of(p, of->body[1], of->port[1], v);
        const double none[AOI_LAW_MEMORY] = {0.0};
        aoi_law_value value;
        aoi_law_push(of->law, none, d, rate, &value);
        force[of->body[0]][of->port[0]] -= value.force;
        force[of->body[1]][of->port[1]] += value.force;
    }
    for (size_t b = 0; b < p->bodies; b++) {
        const part *of = &p->part[b];
        for (size_t j = 0; j < of->n; j++) {
            const size_t at = p->system.first[b] + j;
            a[at] = (of->pulled ? of->gravity[j] : 0.0) - of->omega[j] * of->omega[j] * x[at] -
                    (of->damped ? 2.0 * of->decay[j] * v[at] : 0.0);
            for (size_t q = 0; q < of->ports; q++) {
                a[at] += of->push[q * of->n + j] * force[b][q];
            }
        }
    }
}

static inline void plant_slopes(const void *data, double time, const double *state, double *slope)
{
    const plant *p = data;
    const size_t n = p->system.first[p->bodies];
    memcpy(slope, state + n, n * sizeof(double));
    accelerations(p, time, state, state + n, slope + n);
}

typedef void slopes_at(const void *data, double time, const double *state, double *slope);

/* One step of n numbers from a time. */
static inline void runge_kutta_step(slopes_at *of, const void *data, size_t n, double time, double h, double *state)
{
    const double share[4] = {0.0, 0.5, 0.5, 1.0}, weight[4] = {1.0 / 6, 1.0 / 3, 1.0 / 3, 1.0 / 6};
    double sum[2 * ALL_MODES] = {0.0}, slope[2 * ALL_MODES] = {0.0}, here[2 * ALL_MODES];
    for (int s = 0; s < 4; s++) {
        for (size_t j = 0; j < n; j++) {
            here[j] = state[j] + share[s] * h * slope[j];
        }
        of(data, time + share[s] * h, here, slope);
        for (size_t j = 0; j < n; j++) {
            sum[j] += weight[s] * slope[j];
        }
    }
    for (size_t j = 0; j < n; j++) {
        state[j] += h * sum[j];
    }
}

/* From the start of the plant to a time, in equal steps; before `lay_out` or after. */
static inline void runge_kutta(plant *p, double end, size_t steps, double *x, double *v)
{
    double state[2 * ALL_MODES];
    const double h = end / (double)steps;
    CHECK(lay_out(p) == AOI_OK, "a sound system");
    const size_t n = p->system.first[p->bodies];
    memcpy(state, p->x, n * sizeof(double));
    memcpy(state + n, p->v, n * sizeof(double));
    for (size_t i = 0; i < steps; i++) {
        runge_kutta_step(plant_slopes, p, 2 * n, h * (double)i, h, state);
    }
    memcpy(x, state, n * sizeof(double));
    memcpy(v, state + n, n * sizeof(double));
}

#endif
