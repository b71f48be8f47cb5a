/* Selection of the contacts and bodies that take part in a step. Each of these bodies is first advanced to the
 * time of the run. */
#include "adaptive/run.h"
#include "adaptive/step.h"
#include "model/modes.h"
#include "model/system.h"
#include "motion/energy.h"
#include "motion/free.h"
#include "motion/modes.h"

#include <math.h>

void aoi_step_release(aoi_adaptive *run)
{
    for (size_t i = 0; i < run->engaged.count; i++) {
        run->body[run->engaged.at[i]].engaged = AOI_FREE_MOTION;
    }
    for (size_t s = 0; s < run->entry_count; s++) {
        if (!run->contact[run->entry[s].contact].is_closed) {
            aoi_watch_add(run, run->entry[s].contact);
        }
    }
    run->engaged.count = run->closed_count = run->entry_count = 0;
}

/* Adds the open contacts of a body under force to the step: the searches for their touches assumed free motion. */
static void bring_along(aoi_adaptive *run, size_t b)
{
    const aoi_system *system = run->system;
    for (size_t i = system->first_contact[b]; i < system->first_contact[b + 1]; i++) {
        const size_t c = system->contact_of[i];
        if (aoi_watch_remove(run, c)) {
            aoi_contact_step *entry = &run->entry[run->entry_count++];
            entry->contact = c;
            entry->axis = 0;
            entry->sliding = NULL;
            run->contact[c].flight.until = -HUGE_VAL;
            run->contact[c].flight.touches = 0;
            aoi_body_engage(run, system->contact[c].body[0], AOI_WATCHED);
            aoi_body_engage(run, system->contact[c].body[1], AOI_WATCHED);
        }
    }
}

void aoi_step_prepare(aoi_adaptive *run)
{
    aoi_step_release(run);
    for (size_t i = 0; i < run->closed.count; i++) {
        const size_t c = run->closed.at[i], forces = aoi_contact_forces(&run->system->contact[c]);
        for (size_t axis = 0; axis < forces; axis++) {
            aoi_contact_step *entry = &run->entry[run->closed_count++];
            entry->contact = c;
            entry->axis = axis;
            entry->sliding = run->contact[c].sliding;
        }
        aoi_body_engage(run, run->system->contact[c].body[0], AOI_UNDER_FORCE);
        aoi_body_engage(run, run->system->contact[c].body[1], AOI_UNDER_FORCE);
    }
    run->entry_count = run->closed_count;
    const size_t count = run->engaged.count; /* only the bodies of closed contacts, since bring_along adds others */
    for (size_t i = 0; i < count; i++) {
        if (run->body[run->engaged.at[i]].engaged == AOI_UNDER_FORCE) {
            bring_along(run, run->engaged.at[i]);
        }
    }
}
