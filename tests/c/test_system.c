/* Who touches whom. */
#include "check.h"

#include "aoimpact.h"

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

int main(void)
{
    every_body_knows_its_joints();
    the_most_modes_of_any_body();
    return check_report();
}
