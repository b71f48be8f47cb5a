/* Gravity and loads on the modes of a body, and its free motion. */
#ifndef AOI_MOTION_MODES_H
#define AOI_MOTION_MODES_H

#include "aoimpact.h"
#include "model/load.h"
#include "motion/lanes.h"

/* Returns the first time after `time` at which a load bends, that is, changes its slope, s; infinite if there is
 * none. */
static inline double aoi_modes_next_bend(const aoi_modes *body, double time)
{
    return aoi_load_later_bend(&body->load, time, 0);
}

/* Finds the load on a port just after a time, N, and its slope, N/s. */
void aoi_modes_load(const aoi_modes *body, size_t port, double time, double *force, double *slope);

/* Finds the acceleration of mode j due to gravity and loads just after a time, and its slope in time. */
void aoi_modes_drive(const aoi_modes *body, size_t j, double time, double *load, double *slope);

/* Advances x, v (n each) in place in free motion from one time to another. */
void aoi_modes_advance(const aoi_modes *body, double from, double to, double *x, double *v);

/* Advances AOI_LANES modes, from mode `first` on, over a time in which no load bends. from: start of that time, s;
 * by: motion of these modes over that time. */
void aoi_modes_move(const aoi_modes *body, size_t first, double from, const aoi_motions *by, double *x,
                    double *v);

/* Finds the motion of modes first .. first + AOI_LANES - 1, as far as the body has them, over a time;
 * motions->ramp only if the body has loads. integrals: set to the integrals over that time; or NULL. */
void aoi_lanes_of(const aoi_modes *body, size_t first, double time, aoi_motions *motions,
                  aoi_integrals *integrals);

/* Finds displacement and velocity of a port, without the deflection of the residual compliance. */
void aoi_modes_port(const aoi_modes *body, size_t port, const double *x, const double *v,
                    double *displacement, double *velocity);

#endif
