/* Systems of bodies in modes for the harnesses of adaptive runs and their tracks. */
#ifndef AOIMPACT_FUZZ_SYSTEM_H
#define AOIMPACT_FUZZ_SYSTEM_H

#include "fuzz.h"
#include "aoimpact.h"

enum { MOST_BODIES = 4, MOST_CONTACTS = 4, MOST_MODES = 4, MOST_PORTS = 3, MOST_TRACK_ROWS = 48 };

static inline double *take_maybe(input *in, size_t count, taker *one)
{
    return take_byte(in) & 1 ? take_array(in, count, one) : NULL;
}

static inline void take_loads(input *in, aoi_modes *body)
{
    const size_t count = body->load.count = take_byte(in) % 4 ? 0 : take_between(in, 1, 5);
    double time = take_signed(in), *times = take_room(in, count);
    double *force = take_array(in, count * body->ports, take_signed);
    for (size_t i = 0; i < count; i++) {
        times[i] = time;
        time += take_not_negative(in);
    }
    (void)spoil(in, times, count);
    (void)spoil(in, force, count * body->ports);
    body->load.time = times;
    body->load.force = force;
}

static inline aoi_modes take_body(input *in)
{
    const size_t n = take_between(in, 1, MOST_MODES), ports = take_between(in, 1, MOST_PORTS);
    aoi_modes body = {.n = n, .ports = ports};
    double *omega = take_room(in, n), *shape = take_array(in, n * ports, take_signed), *push = shape;
    double least = take_byte(in) & 1 ? 0.0 : take_positive(in);
    for (size_t j = 0; j < n; j++, least += take_not_negative(in)) {
        omega[j] = least;
    }
    (void)spoil(in, omega, n);
    (void)spoil(in, shape, n * ports);
    if (n == 1 && take_byte(in) % 4 == 0) { /* a wall */
        push = take_room(in, n * ports);
    }
    body.omega = omega;
    body.shape = shape;
    body.push = push;
    body.decay = take_maybe(in, n, take_not_negative);
    body.gravity = take_maybe(in, n, take_signed);
    body.inertia = take_array(in, n, take_positive);
    body.centre = take_array(in, n, take_signed);
    body.centre_residual = take_maybe(in, ports, take_signed);
    if (take_byte(in) % 4 == 0) {
        double *residual = take_room(in, ports * ports), *r = take_array(in, ports, take_signed);
        for (size_t i = 0; i < ports * ports; i++) {
            residual[i] = r[i / ports] * r[i % ports];
        }
        body.residual = residual;
    }
    take_loads(in, &body);
    return body;
}

static inline aoi_contact take_contact(input *in, size_t bodies, int *status)
{
    aoi_contact c = {.friction = NULL};
    aoi_law *law = take_bytes(in, 1, sizeof *law);
    for (int side = 0; side < 2; side++) {
        c.body[side] = side == 0 ? take_below(in, bodies)
                                     : (c.body[0] + 1 + take_below(in, bodies - 1)) % bodies;
        c.port[side] = take_byte(in) & 1 ? 0 : take_below(in, MOST_PORTS);
    }
    c.gap = take_byte(in) > 250 ? take_any(in) : take_signed(in);
    *law = take_law(in, status);
    law->note = take_room(in, AOI_LAW_NOTE);
    law->note[0] = law->note[1] = (double)NAN;
    c.law = law;
    if (*status == AOI_OK) {
        c.friction = take_friction(in, law, &c.compliance);
    }
    return c;
}

/* A linked system that its check has let through; else a status. */
static inline int take_system(input *in, size_t least, aoi_system *system)
{
    const size_t nb = take_between(in, least, MOST_BODIES), nj = least == 2 ? take_between(in, 1, MOST_CONTACTS) : 0;
    aoi_modes *body = take_bytes(in, nb, sizeof *body);
    aoi_contact *contact = take_bytes(in, nj, sizeof *contact);
    int status = AOI_OK;
    for (size_t b = 0; b < nb; b++) {
        body[b] = take_body(in);
    }
    for (size_t c = 0; c < nj; c++) {
        int made;
        contact[c] = take_contact(in, nb, &made);
        status = status != AOI_OK ? status : made;
    }
    *system = (aoi_system){.body_count = nb, .contact_count = nj, .body = body, .contact = contact};
    return status != AOI_OK ? status : aoi_system_link(system, take_bytes(in, 1, aoi_system_size(system)));
}

/* How a run of it begins. */
static inline void take_start(input *in, const aoi_system *system, aoi_start *start, double *rtol, double *end)
{
    const size_t n = system->first[system->body_count];
    *rtol = take_byte(in) > 250 ? take_any(in) : pow(10.0, -1.0 - 8.0 * take_share(in));
    *end = take_byte(in) > 250 ? take_any(in) : take_positive(in);
    start->x = take_array(in, n, take_byte(in) & 1 ? take_signed : take_not_negative);
    start->v = take_array(in, n, take_signed);
    start->rested = take_byte(in) & 1;
}

static inline aoi_sampler *take_sampler(input *in, const aoi_system *system)
{
    return take_bytes(in, 1, aoi_sampler_size(system));
}

#endif
