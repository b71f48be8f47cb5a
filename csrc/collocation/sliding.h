/* Friction of a contact in an adaptive run: its forces along the motion of a step.
 *
 * The springs of friction remember how the contact moved. Here they follow the polynomials of a step on two paths: along
 * straight parts between the points where forces are found, and along the halves of these. The error of the force is
 * proportional to the square of a part's length, so that the forces of both paths are extrapolated (Richardson), and
 * their difference shows the error. Each path has springs of its own, which go on from step to step. */
#ifndef AOI_COLLOCATION_SLIDING_H
#define AOI_COLLOCATION_SLIDING_H

#include "collocation/collocation.h"
#include "law/oblique.h"
#include "motion/radau.h"

/* Numbers of paths, and of springs of each. A step is tried with fewer springs: to accept it takes
 * some more, at up to 2 MOST_STOPS places, and a step that needs more is shortened before. */
enum { AOI_PATHS = 2, AOI_SPRINGS = 2048, AOI_TRIED_SPRINGS = AOI_SPRINGS - 256 };

/* Largest number of changes in a step, at which all of a contact begins to slip, or ceases to, that
 * are recorded; more are ignored. */
enum { AOI_SLIP_CHANGES = 4 };

/* State of a path: its springs; the contact's own slides since the touch; its own indentation and
 * slides less those of the bodies (bent); and the forces, normal and along the tangents. */
typedef struct aoi_slide_path {
    aoi_friction_state springs;
    double own[2], bent[3], force[3];
} aoi_slide_path;

/* The friction of one contact. The caller sets the first block; the springs of path and trial have room.
 *   enough  change of a place relative to its scale at which Newton's method ends */
struct aoi_sliding {
    aoi_rub rub;
    aoi_friction exact;
    double enough;

    aoi_slide_path path[AOI_PATHS], trial;
    /* forces at the nodes or the points of an edge, and d force/d place */
    double force[3][AOI_NODES], by[3][3][AOI_NODES];
    /* forces of the second path less the first's */
    double apart[3][AOI_NODES];
    /* growth of the error of the forces in the step, N */
    double drift[3];
    double beyond[3][AOI_EDGE_CHECKS];               /* forces of the law less the polynomial's                  */

    /* slides of the bodies since the touch, at the start of a step */
    double slide[2];
    /* slides in the last step, as Legendre series, to guess the next */
    double last[2][AOI_NODES + 1];
    double largest;                     /* largest friction so far */
    /* work on the slides so far; the part dissipated; stuck share of the indentation */
    double work, lost, stuck;
    /* in the last step: ratio of friction to normal force, energy of stretches, stuck share */
    double share[2][AOI_NODES], stretched_at[AOI_NODES + 1], stuck_at[AOI_NODES + 1];
    /* 1 if all springs slip, at the start of the last step and at its end */
    int slipped, slips;
    size_t changes;                        /* number of changes in between */
    /* places of the changes, and the stretches there */
    double change_at[AOI_SLIP_CHANGES], change_stretch[2][AOI_SLIP_CHANGES];
};

/* Sets a contact to a touch, where the springs are not stretched. */
void aoi_sliding_touch(aoi_sliding *sliding);

/* Sets a contact to a touch, and moves it straight to the place of the bodies, an indentation and
 * two slides. Errors as aoi_oblique_solve. */
int aoi_sliding_begin(aoi_sliding *sliding, const double place[3]);

/* Force of a contact at the end of the last step, along the normal (axis 0) or a tangent. */
double aoi_sliding_force(const aoi_sliding *sliding, size_t axis);

/* Adds springs where the step will turn neighbours by different angles, by a guess of the places of
 * the three entries. To be called before the forces of a step are found. */
void aoi_sliding_prepare(aoi_sliding *sliding, const aoi_contact_step *entry);

/* Sets force and by along the places of the three entries of a contact; both: follows both paths and sets drift, else only
 * the first, and takes the second to be as far from it as before. Errors as aoi_oblique_solve. */
int aoi_sliding_evaluate(aoi_sliding *sliding, const aoi_contact_step *entry, int both);

/* Sets beyond of a step that has been solved. Errors as aoi_oblique_solve. */
int aoi_sliding_check(aoi_sliding *sliding, const aoi_contact_step *entry);

/* First place after `beyond`, in a step that has been solved, at which all of the contact begins to
 * slip, or ceases to: friction has a corner there. 2: none. */
double aoi_sliding_corner(aoi_sliding *sliding, const aoi_contact_step *entry, double beyond);

/* Moves both paths to the end of the step. */
int aoi_sliding_advance(aoi_sliding *sliding, const aoi_contact_step *entry);

#endif
