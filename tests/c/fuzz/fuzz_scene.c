/* Scenes by Newmark's rule: stars, modal bodies and finite elements, contacts and loads. */
#include "dense.h"
#include "linear/sparse.h"
#include "model/coupled.h"
#include "newmark/body.h"
#include "newmark/scene.h"

enum { MOST_BODIES = 4, MOST_CONTACTS = 5, MOST_LOADS = 3, MOST_MODES = 5, MOST_PORTS = 3, COLUMNS = 16 };

typedef struct scene_body {
    aoi_body body;
    aoi_star star;
    aoi_modes modal;
    aoi_full full;
    chain_solver solver;
    size_t n;
} scene_body;

/* A residual compliance matrix, positive semidefinite: a sum of squares. */
static double *take_residual(input *in, size_t ports)
{
    double *of = take_room(in, ports * ports), *r = take_array(in, ports, take_signed);
    for (size_t i = 0; i < ports * ports; i++) {
        of[i] = r[i / ports] * r[i % ports];
    }
    return of;
}

static aoi_body_start take_start(input *in, size_t n, size_t ports)
{
    aoi_body_start start = {take_array(in, n, take_signed), take_array(in, n, take_signed),
                       take_array(in, n, take_not_negative), NULL, NULL};
    if (take_byte(in) % 4 == 0) {
        start.gravity = take_array(in, n, take_signed);
    }
    if (take_byte(in) % 8 == 0) {
        start.force = take_array(in, 2 * ports, take_signed);
    }
    return start;
}

static int take_star(input *in, scene_body *one, const aoi_rule *rule)
{
    const size_t n = take_below(in, MOST_MODES);
    one->star = (aoi_star){n, take_not_negative(in), take_not_negative(in), take_array(in, n, take_positive),
                           take_array(in, n, take_positive)};
    one->n = n + 1;
    if (n == 0 && take_byte(in) % 8 == 0) {
        one->star.m0 = INFINITY;
    }
    const aoi_rayleigh damping = {take_not_negative(in), take_not_negative(in)};
    const aoi_body_start start = take_start(in, n + 1, 1);
    return aoi_body_start_star(&one->body, &one->star, take_byte(in) & 1 ? &damping : NULL, rule, &start,
                               take_room(in, aoi_body_star_size(n)));
}

static int take_modal(input *in, scene_body *one, const aoi_rule *rule)
{
    const size_t n = take_below(in, MOST_MODES), ports = take_between(in, 1, MOST_PORTS);
    one->modal = (aoi_modes){.n = n, .ports = ports};
    one->n = n;
    one->modal.omega = take_array(in, n, take_not_negative);
    one->modal.decay = take_byte(in) & 1 ? take_array(in, n, take_not_negative) : NULL;
    one->modal.shape = take_array(in, n * ports, take_signed);
    one->modal.push = one->modal.shape;
    one->modal.residual = take_byte(in) & 1 ? take_residual(in, ports) : NULL;
    const aoi_body_start start = take_start(in, n, ports);
    one->modal.gravity = start.gravity;
    one->modal.centre = start.centre;
    return aoi_body_start_modal(&one->body, &one->modal, rule, &start,
                                take_room(in, aoi_body_modal_size(n, ports)));
}

static int take_full(input *in, scene_body *one, const aoi_rule *rule)
{
    const size_t n = take_between(in, 1, MOST_MODES), ports = take_between(in, 1, MOST_PORTS);
    const double *none = take_room(in, n);
    aoi_full *full = &one->full;
    one->n = n;
    full->K = take_chain(in, n, take_array(in, n, take_positive), take_array(in, n, take_not_negative));
    full->M = take_chain(in, n, none, take_array(in, n, take_not_negative));
    full->b = take_array(in, n * ports, take_signed);
    full->ports = ports;
    full->damping = (aoi_rayleigh){take_not_negative(in), take_not_negative(in)};
    const double along = rule->gamma * rule->dt;
    one->solver = take_solver(in, &full->K, &full->M,
                              rule->beta * rule->dt * rule->dt + full->damping.beta * along,
                              1.0 + full->damping.alpha * along);
    full->solver = (aoi_solver){chain_solve, &one->solver};
    const aoi_body_start start = take_start(in, n, ports);
    return aoi_body_start_full(&one->body, full, rule, &start, take_room(in, aoi_body_full_size(n, ports)));
}

static aoi_scene_load take_load(input *in, size_t bodies)
{
    const size_t count = take_below(in, 5);
    double time = take_signed(in), *times = take_room(in, count), *force = take_array(in, count, take_signed);
    for (size_t i = 0; i < count; i++) {
        times[i] = time;
        time += take_not_negative(in);
    }
    (void)spoil(in, times, count);
    (void)spoil(in, force, count);
    return (aoi_scene_load){.body = take_below(in, bodies + 1), .port = take_below(in, MOST_PORTS), .ports = 1,
                            .load = {count, times, force}};
}

/* Every force is a number, and presses unless its law pulls. */
static void look_at_forces(const aoi_scene *scene, const double *record, size_t columns, size_t last)
{
    for (size_t c = 0; c < scene->contact_count; c++) {
        const double *force = record + AOI_CONTACT_ROWS * c * columns;
        for (size_t i = 0; i <= last; i++) {
            REQUIRE(isfinite(force[i]) && isfinite(force[columns + i]));
            REQUIRE(force[i] >= 0.0 || scene->contact[c].law->pulls);
        }
    }
}

static void run(input *in, aoi_scene *scene)
{
    if (aoi_scene_check(scene) != AOI_OK) {
        return;
    }
    const size_t columns = take_between(in, 1, COLUMNS);
    double *record = take_room(in, aoi_scene_rows(scene) * columns);
    scene->memory = take_bytes(in, 1, aoi_scene_size(scene));
    if (aoi_scene_start(scene, record, columns) != AOI_OK) {
        return;
    }
    size_t done = 0;
    look_at_forces(scene, record, columns, 0);
    for (size_t first = 1; first < columns; first = done + 1) {
        const size_t last = first + take_below(in, columns - first);
        const int status = aoi_scene_run(scene, record, columns, first, last, &done);
        REQUIRE(status == AOI_OK ? done == last : done + 1 >= first && done < last);
        look_at_forces(scene, record, columns, done);
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
    scene_body *all = take_bytes(&in, MOST_BODIES, sizeof *all);
    aoi_body **body = take_bytes(&in, MOST_BODIES, sizeof *body);
    aoi_scene scene = {.dt = rule.dt, .energies = take_byte(&in) & 1, .body = body};
    const size_t bodies = take_between(&in, 1, MOST_BODIES);
    int status = AOI_OK;
    for (size_t b = 0; b < bodies && status == AOI_OK; b++) {
        int (*const kinds[])(input *, scene_body *, const aoi_rule *) = {take_star, take_modal, take_full};
        status = kinds[take_below(&in, 3)](&in, &all[b], &rule);
        body[b] = &all[b].body;
    }
    scene.body_count = bodies;
    scene.contact_count = take_below(&in, MOST_CONTACTS);
    scene.load_count = take_below(&in, MOST_LOADS);
    aoi_contact *contacts = take_bytes(&in, scene.contact_count, sizeof *contacts);
    aoi_scene_load *loads = take_bytes(&in, scene.load_count, sizeof *loads);
    scene.contact = contacts;
    scene.load = loads;
    scene.first_port = take_bytes(&in, bodies + 1, sizeof(size_t));
    for (size_t c = 0; c < scene.contact_count && status == AOI_OK; c++) {
        aoi_contact *contact = &contacts[c];
        for (int side = 0; side < 2; side++) {
            contact->body[side] = take_below(&in, bodies + (take_byte(&in) > 250));
            contact->port[side] = take_below(&in, MOST_PORTS);
        }
        contact->gap = take_byte(&in) > 250 ? take_any(&in) : take_signed(&in);
        contact->law = take_shared_law(&in, &status);
    }
    for (size_t i = 0; i < scene.load_count; i++) {
        loads[i] = take_load(&in, bodies);
    }
    if (status == AOI_OK) {
        run(&in, &scene);
    }
    close_input(&in);
    return 0;
}
