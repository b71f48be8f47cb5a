/* Very many contacts on one body, whose steps are solved by its modes. n equal balls that strike one place are a ball of n
 * times the mass, with n times the law: so few contacts, solved by elimination, say what many must do. */
#include "body.h"
#include "collocation/collocation.h"

enum { MODES = 12, PLACES = 3, TRACK = 1000 };

static const double SPEED = 1.0, BALL = 0.03, LATE = 2e-5;

/* What the balls of each place do together, and then all bodies: the plate's modes first. */
typedef struct outcome {
    double force[PLACES], impulse[PLACES], velocity[PLACES], mode[MODES];
} outcome;

/* A contact law, its friction if mu > 0, and whether the places have residual compliances. */
typedef struct kind {
    const char *name;
    double more, mu;
    int massless;
} kind;

/* A ringing plate, struck at each place by so many balls, at one place after the other. */
static aoi_system struck(kind of, size_t copies)
{
    const size_t count = PLACES * copies, axes = of.mu > 0.0 ? 3 : 1;
    const double parameter[3] = {2e9 / (double)copies, of.more, 1.5};
    double *omega = zeros(MODES), *shape = zeros(count * axes * MODES), *centre = zeros(MODES);
    double *ball = zeros(9), *mobility = zeros(9), *residual = zeros(count * count);
    aoi_law *law = keep(sizeof *law);
    aoi_friction *friction = keep(sizeof *friction);
    aoi_modes *body = keep((count + 1) * sizeof *body);
    aoi_contact *contact = keep(count * sizeof *contact);
    CHECK(aoi_law_create(law, of.name, of.more > 0.0 ? 3 : 1, parameter) == AOI_OK, "a law");
    CHECK(of.mu == 0.0 || aoi_friction_create(friction, law, of.mu, 0.82, 1e-4) == AOI_OK, "friction");
    for (size_t i = 0; i < count * axes * MODES; i++) {
        const size_t place = i / MODES / axes / copies, axis = i / MODES % axes, j = i % MODES;
        shape[i] = 0.8 * cos((double)((1 + place) * j + axis * (j + 1)));
        omega[j] = 6000.0 * (double)j;
    }
    for (size_t i = 0; i < count * count; i++) {
        const size_t one = i / count / copies, other = i % count / copies;
        residual[i] = one == other ? 2e-8 : 1e-8 / (double)(one + other);
    }
    for (size_t i = 0; i < axes; i++) {
        ball[i * (axes + 1)] = 1.0;
        mobility[i * (axes + 1)] = (double)copies / BALL;
    }
    body[0] = (aoi_modes){.n = MODES, .ports = count * axes, .omega = omega, .shape = shape, .push = shape,
                          .centre = centre, .residual = of.massless ? residual : NULL};
    for (size_t c = 0; c < count; c++) {
        body[1 + c] = (aoi_modes){.n = axes, .ports = axes, .omega = centre, .shape = ball, .push = mobility, .centre = centre};
        contact[c] = (aoi_contact){{1 + c, 0}, {0, c * axes}, LATE * (double)(c / copies), law,
                                   of.mu > 0.0 ? friction : NULL, NULL};
    }
    aoi_system system = {.body_count = count + 1, .contact_count = count, .body = body, .contact = contact};
    CHECK(aoi_system_link(&system, keep(aoi_system_size(&system))) == AOI_OK, "a sound system");
    CHECK(aoi_crowd_pays(&system) == (copies > 1), "%zu balls a place", copies);
    return system;
}

static outcome go(kind of, size_t copies, double rtol)
{
    const aoi_system system = struck(of, copies);
    double *v = zeros(system.first[system.body_count]);
    for (size_t c = 0; c < system.contact_count; c++) {
        v[system.first[1 + c] + (of.mu > 0.0)] = 0.3 * SPEED;
        v[system.first[1 + c]] = SPEED;
    }
    const aoi_start start = {.v = v};
    aoi_track track = {.capacity = TRACK * aoi_adaptive_room(&system), .row_capacity = TRACK};
    track.values = malloc(track.capacity * sizeof(double)); /* too long to be filled, as keep() does */
    track.row = keep(TRACK * sizeof *track.row);
    aoi_adaptive *run = keep(aoi_adaptive_size(&system));
    int status = aoi_adaptive_start(run, &system, &start, rtol, 3e-4);
    status = status == AOI_OK ? aoi_adaptive_finish(run, &track) : status;
    CHECK(status == AOI_OK, "%s", aoi_status_text(status));
    const aoi_progress at = aoi_adaptive_progress(run);
    outcome made;
    memcpy(made.mode, at.v, sizeof made.mode);
    for (size_t p = 0; p < PLACES; p++) {
        const aoi_peak peak = aoi_adaptive_peak(run, p * copies + copies / 2);
        made.force[p] = peak.force * (double)copies;
        made.impulse[p] = peak.impulse * (double)copies;
        made.velocity[p] = at.v[system.first[1 + p * copies]];
    }
    free(track.values);
    drop();
    return made;
}

/* To a tenth of the tolerance, which is what these runs promise. */
static void many_are_as_few(kind of, size_t copies, double rtol)
{
    const outcome few = go(of, 1, 0.1 * rtol), many = go(of, copies, 0.1 * rtol);
    const double enough = 0.1 * rtol;
    for (size_t p = 0; p < PLACES; p++) {
        CHECK(few.force[p] > 0.0 && near(many.force[p], few.force[p], enough), "%s, place %zu: %.17g, not %.17g N", of.name, p,
              many.force[p], few.force[p]);
        CHECK(near(many.impulse[p], few.impulse[p], enough), "%s: %g, not %g N s", of.name, many.impulse[p], few.impulse[p]);
        CHECK(fabs(many.velocity[p] - few.velocity[p]) < enough * SPEED, "%s: rebound from place %zu", of.name, p);
    }
    for (size_t j = 0; j < MODES; j++) {
        CHECK(fabs(many.mode[j] - few.mode[j]) < enough * fabs(few.mode[0]), "%s, mode %zu of the plate", of.name, j);
    }
}

static void memory_grows_with_the_contacts_not_with_their_square(void)
{
    const kind plain = {"hertz", 0.0, 0.0, 0};
    const aoi_system some = struck(plain, 100), more = struck(plain, 200);
    CHECK(aoi_adaptive_size(&more) < 2 * aoi_adaptive_size(&some), "twice the contacts");
    CHECK(aoi_adaptive_size(&more) < 20000000, "%zu bytes", aoi_adaptive_size(&more));
    drop();
}

int main(void)
{
    many_are_as_few((kind){"hertz", 0.0, 0.0, 0}, 30, 1e-4);
    many_are_as_few((kind){"hertz", 0.0, 0.0, 0}, 30, 1e-9);
    many_are_as_few((kind){"hertz", 0.0, 0.2, 0}, 12, 1e-4);
    many_are_as_few((kind){"hunt_crossley", 0.2, 0.0, 0}, 30, 1e-6);
    many_are_as_few((kind){"hertz", 0.0, 0.0, 1}, 30, 1e-6);
    many_are_as_few((kind){"hunt_crossley", 0.2, 0.0, 1}, 30, 1e-6);
    memory_grows_with_the_contacts_not_with_their_square();
    return check_report();
}
