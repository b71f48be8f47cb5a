/* A body in modes under its loads: what drives it, and its free motion. */
#ifndef AOI_MOTION_MODES_H
#define AOI_MOTION_MODES_H

#include "aoimpact.h"
#include "model/load.h"
#include "motion/lanes.h"

/* The first time after `time` at which a load bends; infinite where there is none. */
static inline double aoi_modes_next_bend(const aoi_modes *body, double time)
{
    return aoi_load_later_bend(&body->load, time, 0);
}

/* The load on a port just after a time, N, and its slope, N/s. */
void aoi_modes_load(const aoi_modes *body, size_t port, double time, double *force, double *slope);

/* Acceleration (but for contact forces, decay and spring) of mode j just after a time, and its slope. */
void aoi_modes_drive(const aoi_modes *body, size_t j, double time, double *load, double *slope);

/* Takes x, v (n each) from one time to another without contact forces, in place. */
void aoi_modes_advance(const aoi_modes *body, double from, double to, double *x, double *v);

/* The same for AOI_LANES modes from the first on, over a time in which no load bends, by how they move in it. */
void aoi_modes_move(const aoi_modes *body, size_t first, double from, const aoi_motions *by, double *x,
                    double *v);

/* Of modes first .. first + AOI_LANES - 1 of a body, as far as it has them: how they move in a time, with
 * the ramp where the body has loads; and the integrals over that time, unless NULL. */
void aoi_lanes_of(const aoi_modes *body, size_t first, double time, aoi_motions *motions,
                  aoi_integrals *integrals);

/* Displacement and velocity of a port, but for the residual compliance's share. */
void aoi_modes_port(const aoi_modes *body, size_t port, const double *x, const double *v,
                    double *displacement, double *velocity);

#endif
