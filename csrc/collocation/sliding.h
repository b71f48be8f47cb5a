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

/* AOI_PATHS, AOI_SPRINGS: numbers of paths, and of springs of each path. A trial step uses at most
 * AOI_TRIED_SPRINGS, since accepting the step adds springs at up to 2 MOST_STOPS places; a step that needs more is
 * shortened. */
enum { AOI_PATHS = 2, AOI_SPRINGS = 2048, AOI_TRIED_SPRINGS = AOI_SPRINGS - 256 };

/* Largest number of changes recorded in a step, at which all springs of a contact begin or cease to slip; further
 * changes are ignored. */
enum { AOI_SLIP_CHANGES = 4 };

/* State of a path. own: the contact's own slides since the touch, m; bent: the contact's own indentation and slides
 * less those of the bodies, m; force: normal force and friction along the tangents, N. */
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
    /* work: on the slides so far, J; lost: dissipated part of it, J; stuck: stuck share of the indentation */
    double work, lost, stuck;
    /* in the last step: ratio of friction to normal force, energy of the stretches (J), stuck share of the
     * indentation */
    double share[2][AOI_NODES], stretched_at[AOI_NODES + 1], stuck_at[AOI_NODES + 1];
    /* 1 if all springs slip: at the start of the last step (slipped), at its end (slips) */
    int slipped, slips;
    size_t changes;                        /* number of changes of slip in it */
    /* places in the last step where slip begins or ends, and the stretches at these places */
    double change_at[AOI_SLIP_CHANGES], change_stretch[2][AOI_SLIP_CHANGES];
};

/* Sets a contact to the state at a touch, where the springs are not stretched. */
void aoi_sliding_touch(aoi_sliding *sliding);

/* Sets a contact to the state at a touch, and moves it straight to the place of the bodies: an indentation and two
 * slides, m. Errors as aoi_oblique_solve. */
int aoi_sliding_begin(aoi_sliding *sliding, const double place[3]);

/* Force of a contact at the end of the last step, along the normal (axis 0) or a tangent. */
double aoi_sliding_force(const aoi_sliding *sliding, size_t axis);

/* Adds springs where the step will turn neighbouring springs by different angles, according to the guess in the
 * three entries. To be called before the forces of a step are found. */
void aoi_sliding_prepare(aoi_sliding *sliding, const aoi_contact_step *entry);

/* Sets `force` and `by` for the indentation and slides in the three entries of a contact. both = 1: follows both
 * paths and sets `drift`; 0: follows only the first path, and keeps `apart`, the difference of the second. Errors as
 * aoi_oblique_solve. */
int aoi_sliding_evaluate(aoi_sliding *sliding, const aoi_contact_step *entry, int both);

/* Sets `beyond` for a step that has been solved. Errors as aoi_oblique_solve. */
int aoi_sliding_check(aoi_sliding *sliding, const aoi_contact_step *entry);

/* First place after `beyond`, in a step that has been solved, at which all of the contact begins to
 * slip, or ceases to: friction has a corner there. 2: none. */
double aoi_sliding_corner(aoi_sliding *sliding, const aoi_contact_step *entry, double beyond);

/* Moves both paths to the end of the step. */
int aoi_sliding_advance(aoi_sliding *sliding, const aoi_contact_step *entry);

#endif
