/* Friction of a contact in an adaptive run: its forces along the motion of a step.
 *
 * The springs of friction remember how the contact has moved. In a step they follow the polynomials of the
 * indentation and the slides on two paths. The first path has straight parts between the points where forces are
 * found, the second has parts of half that length. The error of the force is proportional to the square of a
 * part's length: the forces of both paths are extrapolated (Richardson), and their difference gives the error.
 * Each path has springs of its own, which are kept from step to step. */
#ifndef AOI_COLLOCATION_SLIDING_H
#define AOI_COLLOCATION_SLIDING_H

#include "collocation/collocation.h"
#include "law/oblique.h"
#include "motion/radau.h"

/* AOI_PATHS: number of paths; AOI_SPRINGS: largest number of springs of each path. A trial step uses at most
 * AOI_TRIED_SPRINGS, since accepting the step adds springs at up to 2 MOST_STOPS positions; a step that needs more
 * is shortened. At most AOI_KEPT_SPRINGS are kept after a step, so that the next one has room. */
enum { AOI_PATHS = 2, AOI_SPRINGS = 2048, AOI_TRIED_SPRINGS = AOI_SPRINGS - 256, AOI_KEPT_SPRINGS = AOI_SPRINGS - 512 };

/* Largest number of changes recorded in a step. At a change, all springs of a contact begin or cease to slip;
 * further changes are ignored. */
enum { AOI_SLIP_CHANGES = 4 };

/* State of a path. own: the contact's own slides since the touch, m; bent: the contact's own indentation and
 * slides minus those of the bodies, m; force: normal force and friction along both tangents, N. */
typedef struct aoi_slide_path {
    aoi_friction_state springs;
    double own[2], bent[3], force[3];
} aoi_slide_path;

/* Friction of one contact. The caller sets the first block; the springs of all paths, trial included, must have
 * room.
 *   rub, exact  the contact's friction, and the same with the precision for paths within a step
 *   enough      change of an indentation or slide, relative to its scale, at which Newton's method ends */
struct aoi_sliding {
    aoi_rub rub;
    aoi_friction exact;
    double enough;

    aoi_slide_path path[AOI_PATHS], trial;
    /* forces at the nodes or an edge's quadrature points, and their derivatives with respect to indentation and
     * slides */
    double force[3][AOI_NODES], by[3][3][AOI_NODES];
    /* forces of the second path minus forces of the first, N */
    double apart[3][AOI_NODES];
    /* error that the straight parts of the paths add to the forces in the step, N */
    double drift[3];
    double beyond[3][AOI_EDGE_CHECKS]; /* forces minus their polynomials at the check points, N */

    /* slides of the bodies since the touch, at the start of a step */
    double slide[2];
    /* slides of the last step as Legendre series, to guess the slides of the next step */
    double last[2][AOI_NODES + 1];
    double largest;                     /* largest friction so far, N */
    /* work: work on the slides so far, J; lost: dissipated part of this work, J; stuck: stuck share of the
     * indentation */
    double work, lost, stuck;
    /* share: ratio of friction to normal force at the nodes of the last step, if it had an edge; stretched_at,
     * stuck_at: energy of the stretches (J) and stuck share of the indentation, at the nodes or an edge's
     * quadrature points, and at the step's end */
    double share[2][AOI_NODES], stretched_at[AOI_NODES + 1], stuck_at[AOI_NODES + 1];
    /* 1 if all springs slip: at the start of the last step (slipped), at its end (slips) */
    int slipped, slips;
    size_t changes;                        /* number of changes of slip in the last step */
    /* positions in the last step at which slip begins or ends, and the stretches there */
    double change_at[AOI_SLIP_CHANGES], change_stretch[2][AOI_SLIP_CHANGES];
};

/* Sets a contact to its state at a touch: its springs are not stretched. */
void aoi_sliding_touch(aoi_sliding *sliding);

/* Sets a contact to its state at a touch, and then moves it straight to an indentation and two slides of the
 * bodies (place), m. Errors as for aoi_oblique_solve. */
int aoi_sliding_begin(aoi_sliding *sliding, const double place[3]);

/* Returns the force of a contact at the end of the last step, along the normal (axis 0) or a tangent (1, 2), N. */
double aoi_sliding_force(const aoi_sliding *sliding, size_t axis);

/* Adds springs where the step will turn neighbouring springs by different angles, as the guess in the three
 * entries shows. Must be called before the forces of a step are found. */
void aoi_sliding_prepare(aoi_sliding *sliding, const aoi_contact_step *entry);

/* Sets `force` and `by` for the indentation and slides in the three entries of a contact. both = 1: follows both
 * paths, and sets `apart` and `drift`. both = 0: follows only the first path, and takes the difference of the
 * second path's forces from `apart`. Errors as for aoi_oblique_solve. */
int aoi_sliding_evaluate(aoi_sliding *sliding, const aoi_contact_step *entry, int both);

/* Sets `beyond`, the differences of the forces of law and friction from their polynomials at the check points, for
 * a step that has been solved. Errors as for aoi_oblique_solve. */
int aoi_sliding_check(aoi_sliding *sliding, const aoi_contact_step *entry);

/* Returns the first position after `beyond`, in a step that has been solved, at which all springs of the contact
 * begin or cease to slip, so that friction has a corner; 2 if there is none. */
double aoi_sliding_corner(aoi_sliding *sliding, const aoi_contact_step *entry, double beyond);

/* Moves both paths to the end of the step, and records the results along it. Errors as for aoi_oblique_solve. */
int aoi_sliding_advance(aoi_sliding *sliding, const aoi_contact_step *entry);

#endif
