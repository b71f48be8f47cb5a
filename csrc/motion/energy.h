/* Energies of a body in modes, and the work of loads and damping on it. */
#ifndef AOI_MOTION_ENERGY_H
#define AOI_MOTION_ENERGY_H

#include "aoimpact.h"

/* Finds the kinetic and elastic energy of a body, J. force: contact forces plus loads on its ports, whose energy
 * in the residual compliance is included; or NULL. */
void aoi_modes_energy(const aoi_modes *body, const double *x, const double *v, const double *force,
                      double *kinetic, double *elastic);

/* Finds the work of gravity and loads on a body that moves from x0, v0 to x1, v1 without contact, and the energy
 * dissipated by its damping, J. from, to: times of both states, s; scratch: 2n doubles. */
void aoi_modes_free_work(const aoi_modes *body, double from, double to, const double *x0,
                           const double *v0, const double *x1, const double *v1, double *scratch,
                           double *work, double *dissipated);

/* Finds work and dissipated energy as aoi_modes_free_work, for the part of a step of length h from its start to
 * `place` (0 .. 1), under force[port][node]. x0, v0: state at the start; x1: coordinates at `place`. The change of
 * aoi_modes_bent_work is not included in the work, since it needs the forces at both times. The dissipated energy
 * is the integral of the damping's power along the motion. It does not use the balance of energies, which can
 * therefore serve as a check. */
void aoi_modes_step_work(const aoi_modes *body, double from, double h, double place,
                         const double *force, const double *x0, const double *v0, const double *x1,
                         double *work, double *dissipated);

/* Returns the loads times the deflection of the residual compliance under the contact forces at a time, J: the
 * part of the loads' work since a time without contact that is due to this deflection. force: contact forces plus
 * loads on the ports. */
double aoi_modes_bent_work(const aoi_modes *body, double time, const double *force);

#endif
