/* Who touches whom. */
#include "check.h"
#include "model/system.h"


enum { BODIES = 30, JOINTS = 80 };

static void every_body_knows_its_joints(void)
{
    uint64_t seed = 3;
    aoi_modes body[BODIES] = {{.n = 1}};
    aoi_joint joint[JOINTS];
    size_t first_joint[BODIES + 1], joint_of[2 * JOINTS];
    aoi_system system = {.body_count = BODIES, .joint_count = JOINTS, .body = body, .joint = joint};
    for (size_t c = 0; c < JOINTS; c++) { /* the last body is untouched */
        const size_t one = (size_t)(uniform(&seed) * (BODIES - 1));
        joint[c] = (aoi_joint){.body = {one, (one + 1 + c % (BODIES - 2)) % (BODIES - 1)}};
    }
    CHECK(aoi_system_link(&system, first_joint, joint_of) == AOI_OK, "linked");
    CHECK(first_joint[0] == 0 && first_joint[BODIES] == 2 * JOINTS, "each joint has two ends");
    for (size_t b = 0; b < BODIES; b++) {
        size_t at = first_joint[b];
        for (size_t c = 0; c < JOINTS; c++) {
            if (joint[c].body[0] == b || joint[c].body[1] == b) {
                CHECK(at < first_joint[b + 1] && joint_of[at] == c, "body %zu, joint %zu", b, c);
                at++;
            }
        }
        CHECK(at == first_joint[b + 1], "body %zu has no others", b);
    }
    joint[7].body[1] = BODIES;
    CHECK(aoi_system_link(&system, first_joint, joint_of) == AOI_ERROR_ARGUMENT, "no such body");
}

static void the_most_modes_of_any_body(void)
{
    const aoi_modes body[3] = {{.n = 2}, {.n = 7}, {.n = 3}};
    const aoi_system some = {.body_count = 3, .body = body}, none = {.body_count = 0};
    CHECK(aoi_system_most_modes(&some) == 7, "of three bodies");
    CHECK(aoi_system_most_modes(&none) == 1, "of none");
}

/* Two balls and a wall, each pair in contact. */
static int checked_with(size_t *spoilt, size_t value)
{
    static const double zero[1] = {0.0}, one[1] = {1.0};
    static size_t first[4], first_port[4], first_joint[4], joint_of[6], *const arrays[] = {
        first, first_port, first_joint, joint_of};
    const double k = 1e6;
    aoi_law law;
    CHECK(aoi_law_create(&law, "linear", 1, &k) == AOI_OK, "a law");
    aoi_modes body[3];
    first[0] = first_port[0] = 0;
    for (size_t b = 0; b < 3; b++) {
        body[b] = (aoi_modes){.n = 1, .ports = 1, .omega = zero, .shape = one, .push = one,
                              .inertia = one, .centre = one};
        first[b + 1] = first_port[b + 1] = b + 1;
    }
    const aoi_joint joint[3] = {{{0, 1}, {0, 0}, 0.0, &law}, {{1, 2}, {0, 0}, 0.0, &law},
                                {{2, 0}, {0, 0}, 0.0, &law}};
    aoi_system system = {.body_count = 3, .joint_count = 3, .body = body, .first = first,
                         .first_port = first_port, .joint = joint};
    CHECK(aoi_system_check(&system) == AOI_OK, "sound before it is linked");
    CHECK(aoi_system_link(&system, first_joint, joint_of) == AOI_OK, "linked");
    CHECK(aoi_system_check(&system) == AOI_OK, "sound");
    if (!spoilt) {
        law.compliance = -1e-9;
        return aoi_system_check(&system);
    }
    arrays[spoilt[0]][spoilt[1]] = value;
    return aoi_system_check(&system);
}

static void places_that_do_not_fit_are_refused(void)
{
    static const size_t far = (size_t)-1;
    for (size_t array = 0; array < 4; array++) {
        const size_t count = array < 3 ? 4 : 6, values[] = {1, 2, 3, 7, far};
        for (size_t at = 0; at < count; at++) {
            size_t refused = 0, spoilt[2] = {array, at};
            for (size_t i = 0; i < 5; i++) {
                refused += checked_with(spoilt, values[i]) == AOI_ERROR_ARGUMENT;
            }
            /* One of the values may be right. */
            CHECK(refused >= 4, "array %zu, place %zu: only %zu of 5 refused", array, at, refused);
        }
    }
    CHECK(checked_with(NULL, 0) == AOI_ERROR_ARGUMENT, "a law that cannot be used");
}

/* A body of two ports and one of one. */
static void a_joint_is_between_two_bodies(void)
{
    static const double zero[1] = {0.0}, ones[2] = {1.0, 1.0}, residual[4] = {1e-9, 2e-9, 2e-9, 5e-9};
    static const size_t first[] = {0, 1, 2}, first_port[] = {0, 2, 3};
    const double k = 1e6;
    aoi_law law;
    CHECK(aoi_law_create(&law, "linear", 1, &k) == AOI_OK, "a law");
    aoi_modes body[2];
    for (size_t b = 0; b < 2; b++) {
        body[b] = (aoi_modes){.n = 1, .ports = 2 - b, .omega = zero, .shape = ones, .push = ones,
                              .inertia = ones, .centre = ones};
    }
    body[0].residual = residual;
    aoi_joint joint = {{0, 1}, {1, 0}, 0.0, &law};
    const aoi_system system = {.body_count = 2, .joint_count = 1, .body = body, .first = first,
                               .first_port = first_port, .joint = &joint};
    CHECK(aoi_system_check(&system) == AOI_OK, "of different bodies");
    CHECK(aoi_system_residual(&system, 0) == 5e-9, "what its ports give way");
    joint = (aoi_joint){{0, 0}, {0, 1}, 0.0, &law};
    CHECK(aoi_system_check(&system) == AOI_ERROR_ARGUMENT, "of a body with itself");
}

int main(void)
{
    every_body_knows_its_joints();
    the_most_modes_of_any_body();
    places_that_do_not_fit_are_refused();
    a_joint_is_between_two_bodies();
    return check_report();
}
