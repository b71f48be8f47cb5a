/* Defaults of the arrays that a body in modes may leave out, and a test whether the body can move. */
#ifndef AOI_MODEL_MODES_H
#define AOI_MODEL_MODES_H

#include "aoimpact.h"

static inline double aoi_modes_inertia(const aoi_modes *body, size_t j)
{
    return body->inertia ? body->inertia[j] : 1.0;
}

/* True if forces move any mode of a body; false for a wall. */
static inline int aoi_modes_can_move(const aoi_modes *body)
{
    for (size_t k = 0; k < body->ports * body->n; k++) {
        if (body->push[k] != 0.0) {
            return 1;
        }
    }
    return 0;
}

#endif
