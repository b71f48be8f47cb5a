/* A law that depends on the rate, as a caller of the core may write one. */
#ifndef AOIMPACT_TEST_VISCOUS_H
#define AOIMPACT_TEST_VISCOUS_H

#include "check.h"
#include "aoimpact.h"

/* Hunt and Crossley: k d^(3/2) (1 + c rate), never pulling; parameters k, c. */
static inline void hunt_crossley(const aoi_law *law, const double *memory, int piece, double d,
                                 double rate, aoi_law_value *value)
{
    (void)memory;
    (void)piece;
    const double k = law->parameter[0], c = law->parameter[1], root = d > 0.0 ? sqrt(d) : 0.0;
    const double factor = 1.0 + c * rate;
    value->force = factor > 0.0 ? k * root * d * factor : 0.0;
    value->stiffness = factor > 0.0 ? 1.5 * k * root * factor : 0.0;
    value->damping = factor > 0.0 ? k * root * d * c : 0.0;
}

#endif
