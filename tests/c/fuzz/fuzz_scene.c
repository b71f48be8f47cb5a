/* Systems by Newmark's rule: bodies in modes and in finite elements, contacts and loads. */
#include "dense.h"
#include "linear/sparse.h"

enum { MOST_BODIES = 4, MOST_CONTACTS = 5, MOST_MODES = 5, MOST_PORTS = 3, COLUMNS = 16 };

typedef struct full_body {
    aoi_full full;
    chain_solver solver;
} full_body;

/* A residual compliance matrix, positive semidefinite: a sum of squares. */
static double *take_residual(input *in, size_t ports)
{
    double *of = take_room(in, ports * ports), *r = take_array(in, ports, take_signed);
    for (size_t i = 0; i < ports * ports; i++) {
        of[i] = r[i / ports] * r[i % ports];
    }
    return of;
}

static aoi_load take_load(input *in, size_t ports)
{
    const size_t count = take_below(in, 5);
    double time = take_signed(in), *times = take_room(in, count), *force = take_array(in, count * ports, take_signed);
    for (size_t i = 0; i < count; i++) {
        times[i] = time;
        time += take_not_negative(in);
    }
    (void)spoil(in, times, count);
    (void)spoil(in, force, count * ports);
    return (aoi_load){count, times, force};
}

static aoi_modes take_star(input *in)
{
    const size_t n = take_below(in, MOST_MODES);
    aoi_star star = {n, take_not_negative(in), take_not_negative(in), take_array(in, n, take_positive),
                     take_array(in, n, take_positive)};
    aoi_modes body = {.n = 0};
    if (n == 0 && take_byte(in) % 8 == 0) {
        star.m0 = INFINITY;
    }
    return aoi_star_modes(&star, take_bytes(in, 1, aoi_star_modes_size(&star)), &body) == AOI_OK ? body
                                                                                             : (aoi_modes){.n = 0};
}

static aoi_modes take_modal(input *in)
{
    const size_t n = take_below(in, MOST_MODES), ports = take_between(in, 1, MOST_PORTS);
    double *omega = take_array(in, n, take_not_negative);
    for (size_t j = 1; j < n; j++) {
        omega[j] = fmax(omega[j], omega[j - 1]);
    }
    aoi_modes body = {.n = n, .ports = ports, .omega = omega};
    body.shape = take_array(in, n * ports, take_signed);
    body.push = take_byte(in) & 1 ? body.shape : take_array(in, n * ports, take_signed);
    body.inertia = take_byte(in) & 1 ? take_array(in, n, take_not_negative) : NULL;
    body.centre = take_array(in, n, take_not_negative);
    body.residual = take_byte(in) & 1 ? take_residual(in, ports) : NULL;
    body.load = take_load(in, ports);
    return body;
}

static aoi_modes take_full(input *in, full_body *one, const aoi_rule *rule)
{
    const size_t n = take_between(in, 1, MOST_MODES), ports = take_between(in, 1, MOST_PORTS);
    const double *none = take_room(in, n);
    aoi_full *full = &one->full;
    full->K = take_chain(in, n, take_array(in, n, take_positive), take_array(in, n, take_not_negative));
    full->M = take_chain(in, n, none, take_array(in, n, take_not_negative));
    full->alpha = take_not_negative(in);
    full->beta = take_not_negative(in);
    const double along = rule->gamma * rule->dt;
    one->solver = take_solver(in, &full->K, &full->M, rule->beta * rule->dt * rule->dt + full->beta * along,
                              1.0 + full->alpha * along);
    full->solver = (aoi_solver){chain_solve, &one->solver};
    aoi_modes body = {.n = n, .ports = ports, .full = full};
    body.shape = body.push = take_array(in, n * ports, take_signed);
    body.centre = take_array(in, n, take_not_negative);
    body.load = take_load(in, ports);
    return body;
}

/* Every force is a number, and presses unless its law pulls. So are all rows of friction. */
static void look_at_forces(const aoi_system *system, const double *record, size_t columns, size_t first, size_t last)
{
    for (size_t c = 0; c < system->contact_count; c++) {
        const aoi_contact *contact = &system->contact[c];
        const double *force = record + aoi_record_contact(system, c) * columns;
        for (size_t i = first; i <= last; i++) {
            REQUIRE(isfinite(force[i]) && isfinite(force[columns + i]));
            REQUIRE(force[i] >= 0.0 || contact->law->pulls);
            for (size_t row = AOI_CONTACT_TANGENTIAL; contact->friction && row <= AOI_CONTACT_STUCK; row++) {
                REQUIRE(isfinite(force[row * columns + i]));
            }
        }
    }
}

static void run(input *in, aoi_system *system, const aoi_rule *rule)
{
    if (aoi_system_link(system, take_bytes(in, 1, aoi_system_size(system))) != AOI_OK) {
        return;
    }
    const size_t columns = take_between(in, 1, COLUMNS), all = system->first[system->body_count];
    aoi_start start = {take_array(in, all, take_signed), take_array(in, all, take_signed), take_byte(in) & 1, NULL, NULL};
    const int given = take_byte(in) % 4 == 0;
    if (given) {
        start.force = take_array(in, system->first_force[system->contact_count], take_signed);
        start.force_rate =
            take_byte(in) & 1 ? take_array(in, system->first_force[system->contact_count], take_signed) : NULL;
    }
    const int energies = take_byte(in) & 1;
    double *record = take_room(in, aoi_record_rows(system) * columns);
    aoi_newmark *steps = take_bytes(in, 1, aoi_newmark_size(system));
    if (aoi_newmark_start(steps, system, rule, &start, energies, record, columns) != AOI_OK) {
        return;
    }
    size_t done = 0;
    if (!given) {
        look_at_forces(system, record, columns, 0, 0);
    }
    while (done + 1 < columns) {
        const size_t before = done, last = done + 1 + take_below(in, columns - done - 1);
        const int status = aoi_newmark_run(steps, last, &done);
        REQUIRE(status == AOI_OK ? done == last : done >= before && done < last);
        look_at_forces(system, record, columns, before + 1, done);
        if (status != AOI_OK) {
            return;
        }
    }
}

static const aoi_law *take_shared_law(input *in, int *status)
{
    aoi_law *law = take_bytes(in, 1, sizeof *law);
    *law = take_law(in, status);
    law->note = take_room(in, AOI_LAW_NOTE);
    return law;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    input in = open_input(data, size);
    const int usual = take_byte(&in) & 1;
    const aoi_rule rule = {take_positive(&in), usual ? 0.25 : take_positive(&in),
                              usual ? 0.5 : 0.5 + take_share(&in)};
    const size_t bodies = take_between(&in, 1, MOST_BODIES), count = take_below(&in, MOST_CONTACTS);
    full_body *full = take_bytes(&in, bodies, sizeof *full);
    aoi_modes *body = take_bytes(&in, bodies, sizeof *body);
    aoi_contact *contacts = take_bytes(&in, count, sizeof *contacts);
    aoi_system system = {.body_count = bodies, .contact_count = count, .body = body, .contact = contacts};
    int status = AOI_OK;
    for (size_t b = 0; b < bodies; b++) {
        const size_t kind = take_below(&in, 3);
        body[b] = kind == 0 ? take_star(&in) : (kind == 1 ? take_modal(&in) : take_full(&in, &full[b], &rule));
        if (body[b].n > 0 && !body[b].full) {
            body[b].decay = take_byte(&in) & 1 ? take_array(&in, body[b].n, take_not_negative) : NULL;
        }
        if (take_byte(&in) % 4 == 0) {
            body[b].gravity = take_array(&in, body[b].n, take_signed);
        }
    }
    for (size_t c = 0; c < count && status == AOI_OK; c++) {
        for (int side = 0; side < 2; side++) {
            contacts[c].body[side] = take_below(&in, bodies + (take_byte(&in) > 250));
            contacts[c].port[side] = take_below(&in, MOST_PORTS);
        }
        contacts[c].gap = take_byte(&in) > 250 ? take_any(&in) : take_signed(&in);
        contacts[c].law = take_shared_law(&in, &status);
        if (status == AOI_OK) {
            contacts[c].friction = take_friction(&in, contacts[c].law, &contacts[c].compliance);
        }
    }
    if (status == AOI_OK) {
        run(&in, &system, &rule);
    }
    close_input(&in);
    return 0;
}
