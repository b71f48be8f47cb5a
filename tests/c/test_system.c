/* Who touches whom. */
#include "check.h"
#include "model/system.h"

#include <math.h>

enum { BODIES = 30, CONTACTS = 80 };

static const size_t ZEROS[4];
static const double ZERO[1] = {0.0}, ONES[2] = {1.0, 1.0};

static aoi_law linear_law(void)
{
    const double k = 1e6;
    aoi_law law;
    CHECK(aoi_law_create(&law, "linear", 1, &k) == AOI_OK, "a law");
    return law;
}

static aoi_modes ball(size_t ports)
{
    return (aoi_modes){.n = 1, .ports = ports, .omega = ZERO, .shape = ONES, .push = ONES, .centre = ONES};
}

static void every_body_knows_its_contacts(void)
{
    uint64_t seed = 3;
    const aoi_law law = linear_law();
    aoi_modes body[BODIES];
    aoi_contact contact[CONTACTS];
    size_t links[3 * (BODIES + 2) + 3 * CONTACTS + 2];
    aoi_system system = {.body_count = BODIES, .contact_count = CONTACTS, .body = body, .contact = contact};
    for (size_t b = 0; b < BODIES; b++) {
        body[b] = ball(1 + b % 2);
    }
    for (size_t c = 0; c < CONTACTS; c++) { /* the last body is untouched */
        const size_t one = (size_t)(uniform(&seed) * (BODIES - 1));
        contact[c] = (aoi_contact){.body = {one, (one + 1 + c % (BODIES - 2)) % (BODIES - 1)}, .law = &law};
    }
    CHECK(aoi_system_size(&system) <= sizeof links, "room for links");
    CHECK(aoi_system_link(&system, links) == AOI_OK, "linked");
    CHECK(system.first_contact[0] == 0 && system.first_contact[BODIES] == 2 * CONTACTS, "two ends each");
    for (size_t b = 0; b < BODIES; b++) {
        size_t at = system.first_contact[b];
        CHECK(system.first[b] == b && system.first_port[b + 1] == system.first_port[b] + 1 + b % 2,
              "places of body %zu", b);
        for (size_t c = 0; c < CONTACTS; c++) {
            if (contact[c].body[0] == b || contact[c].body[1] == b) {
                CHECK(at < system.first_contact[b + 1] && system.contact_of[at] == c, "body %zu, contact %zu", b, c);
                at++;
            }
        }
        CHECK(at == system.first_contact[b + 1], "body %zu has no others", b);
    }
    contact[7].body[1] = BODIES;
    CHECK(aoi_system_link(&system, links) == AOI_ERROR_ARGUMENT, "no such body");
}

static void the_most_modes_of_any_body(void)
{
    const aoi_modes body[3] = {{.n = 2}, {.n = 7}, {.n = 3}};
    const aoi_system some = {.body_count = 3, .body = body}, none = {.body_count = 0};
    CHECK(aoi_system_most_modes(&some) == 7, "of three bodies");
    CHECK(aoi_system_most_modes(&none) == 1, "of none");
}

/* Two balls in contact, one of two ports. */
typedef struct touching {
    aoi_modes body[2];
    aoi_law law;
    aoi_contact contact;
    size_t links[16];
    aoi_system system;
} touching;

static void make_touching(touching *t)
{
    t->body[0] = ball(2);
    t->body[1] = ball(1);
    t->law = linear_law();
    t->contact = (aoi_contact){{0, 1}, {1, 0}, 0.0, &t->law, NULL, NULL};
    t->system = (aoi_system){.body_count = 2, .contact_count = 1, .body = t->body, .contact = &t->contact};
}

static void what_cannot_be_run_is_refused(void)
{
    static const double nan[4] = {NAN, NAN, NAN, NAN}, negative[1] = {-1.0}, late[2] = {1.0, 0.0};
    static const double gives[4] = {1.0, 0.0, 0.0, -1.0}, lopsided[4] = {1.0, 0.5, 0.4, 1.0};
    static const double pulls[4] = {1.0, 1.1, 1.1, 1.0}; /* forces 1 and -1 do work -0.1 on it */
    enum { ARRAYS = 17 };
    for (int i = -1; i < ARRAYS + 9; i++) {
        touching t;
        make_touching(&t);
        aoi_modes *first = &t.body[0];
        const struct {
            const double **array;
            const double *wrong;
        } arrays[ARRAYS] = {{&first->omega, nan},    {&first->omega, NULL},     {&first->shape, nan},
                      {&first->shape, NULL},   {&first->push, nan},       {&first->push, NULL},
                      {&first->centre, nan},   {&first->centre, NULL},    {&first->decay, negative},
                      {&first->residual, nan}, {&first->gravity, nan},    {&first->inertia, nan},
                      {&first->omega, negative}, {&first->inertia, negative},
                      {&first->residual, gives}, {&first->residual, lopsided},
                      {&first->residual, pulls}};
        if (i >= 0 && i < ARRAYS) {
            *arrays[i].array = arrays[i].wrong;
        }
        const aoi_load loads[] = {{2, late, ONES}, {1, ONES, NULL}, {1, NULL, ONES}};
        const int other = i - ARRAYS;
        if (other >= 0 && other < 3) {
            first->load = loads[other];
        }
        t.contact.port[1] = other == 3;
        t.contact.gap = other == 4 ? HUGE_VAL : 0.0;
        t.law.compliance = other == 5 ? (double)NAN : 0.0;
        t.contact.law = other == 6 ? NULL : &t.law;
        t.system.body = other == 7 ? NULL : t.body;
        t.system.contact = other == 8 ? NULL : &t.contact;
        t.system.first = ZEROS; /* of a link before */
        const int status = aoi_system_link(&t.system, t.links);
        CHECK(status == (i < 0 ? AOI_OK : AOI_ERROR_ARGUMENT), "case %d: status %d", i, status);
        CHECK((t.system.first != NULL) == (i < 0), "case %d: what is refused is not linked", i);
    }
}

static void a_contact_is_between_two_bodies(void)
{
    static const double residual[4] = {1e-9, 2e-9, 2e-9, 5e-9};
    touching t;
    make_touching(&t);
    t.body[0].residual = residual;
    CHECK(aoi_system_size(&t.system) <= sizeof t.links, "room for links");
    CHECK(aoi_system_link(&t.system, t.links) == AOI_OK, "of different bodies");
    CHECK(aoi_system_residual(&t.system, 0, 0) == 5e-9, "the residual compliance at its ports");
    t.contact = (aoi_contact){{0, 0}, {0, 1}, 0.0, &t.law, NULL, NULL};
    CHECK(aoi_system_link(&t.system, t.links) == AOI_ERROR_ARGUMENT, "of a body with itself");
}

/* Of two walls none gives way to a force, unless a residual compliance does. */
static void nothing_moves_between_walls(void)
{
    static const double residual[1] = {1e-9};
    touching t;
    make_touching(&t);
    t.body[1].push = ZERO;
    CHECK(aoi_system_link(&t.system, t.links) == AOI_OK, "a ball on a wall");
    t.body[0].push = (const double[]){1.0, 0.0};
    t.contact.port[0] = 1;
    CHECK(aoi_system_link(&t.system, t.links) == AOI_ERROR_NOT_POSITIVE && !t.system.first, "a port that is held");
    t.contact.port[0] = 0;
    t.body[0].push = (const double[]){0.0, 0.0};
    CHECK(aoi_system_link(&t.system, t.links) == AOI_ERROR_NOT_POSITIVE && !t.system.first, "two walls");
    t.body[1].residual = residual;
    CHECK(aoi_system_link(&t.system, t.links) == AOI_OK, "a soft place on one");
}

/* Friction has springs of the contact's law: one that was never made, or of another law, would give two laws' forces. */
static void friction_is_of_the_contacts_law(void)
{
    static const double ones[3] = {1.0, 1.0, 1.0}, k = 2e6;
    const aoi_modes body = {.n = 1, .ports = 3, .omega = ZERO, .shape = ones, .push = ones, .centre = ones};
    const aoi_modes bodies[2] = {body, body};
    aoi_law law[4] = {linear_law(), linear_law()}; /* its own, softer by its compliance, and two others */
    aoi_friction made[2] = {{.mu = 0.2}, {.mu = 0.2, .ratio = 0.8, .precision = 1e-4}};
    law[1].compliance = 1e-9;
    CHECK(aoi_law_create(&law[2], "linear", 1, &k) == AOI_OK, "twice as stiff");
    CHECK(aoi_law_create(&law[3], "hertz", 1, law->parameter) == AOI_OK, "of the same number");
    CHECK(aoi_friction_create(&made[0], law, 0.2, 0.8, 1e-4) == AOI_OK, "friction");
    for (size_t i = 0; i < 8; i++) {
        const aoi_contact contact = {.body = {0, 1}, .law = &law[i / 2], .friction = &made[i % 2]};
        aoi_system system = {.body_count = 2, .contact_count = 1, .body = bodies, .contact = &contact};
        size_t links[40];
        CHECK(aoi_system_size(&system) <= sizeof links, "room");
        CHECK(aoi_system_link(&system, links) == (i == 0 || i == 2 ? AOI_OK : AOI_ERROR_ARGUMENT), "pair %zu", i);
    }
}

/* Where the rows of a record stand: four of each contact, then six and two a port of each body. */
static void the_rows_of_a_record(void)
{
    touching t;
    make_touching(&t);
    CHECK(aoi_system_link(&t.system, t.links) == AOI_OK, "linked");
    CHECK(aoi_record_contact(&t.system, 0) == 0 && aoi_record_body(&t.system, 0) == 4, "first");
    CHECK(aoi_record_body(&t.system, 1) == 14 && aoi_record_rows(&t.system) == 22, "second, and all");
}

int main(void)
{
    every_body_knows_its_contacts();
    the_most_modes_of_any_body();
    what_cannot_be_run_is_refused();
    a_contact_is_between_two_bodies();
    nothing_moves_between_walls();
    friction_is_of_the_contacts_law();
    the_rows_of_a_record();
    return check_report();
}
