/* Friction of a contact in an adaptive run: its forces along the motion of a step.
 *
 * The springs of friction remember how the contact moved. Here they follow the polynomials of a step on two paths: along
 * straight parts between the points where forces are found, and along the halves of these. The force errs by the square of
 * a part, so that both extrapolate it (Richardson), and their difference shows the error. Each path has springs of its
 * own, which go on from step to step. */
#ifndef AOI_COLLOCATION_SLIDING_H
#define AOI_COLLOCATION_SLIDING_H

#include "collocation/collocation.h"
#include "law/oblique.h"
#include "motion/radau.h"

/* Paths, and springs of each. A step is tried with fewer: one that is accepted moves on from at most 2 MOST_STOPS places,
 * each with some knots of its own, and a step that needs more is shortened before it is accepted. */
enum { AOI_PATHS = 2, AOI_SPRINGS = 2048, AOI_TRIED_SPRINGS = AOI_SPRINGS - 256 };

/* Within a step all of a contact begins to slip, or ceases to, so often at most: what more there were is not told apart. */
enum { AOI_SLIP_CHANGES = 4 };

/* Where a path has come to: its springs; the contact's own slides since the touch; by how much these and the own
 * indentation exceed those of the bodies, and the forces, normal and along the tangents. */
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
    double force[3][AOI_NODES], by[3][3][AOI_NODES]; /* at the nodes or the points of an edge, and d force/d place */
    double apart[3][AOI_NODES];                      /* by how much those of the second path exceed the first's */
    double drift[3];                                 /* growth of the force's error by the length of the parts   */
    double beyond[3][AOI_EDGE_CHECKS];               /* the law's less the polynomial's, as find_beyond has it   */

    double slide[2];                    /* of the bodies since the touch, at the start of a step */
    double last[2][AOI_NODES + 1];      /* the last step's, as Legendre series, to guess the next */
    double largest;                     /* of the friction so far */
    double work, lost, stuck; /* on the slides so far; of this dissipated; stuck share of the indentation */
    double share[2][AOI_NODES], stretched_at[AOI_NODES + 1], stuck_at[AOI_NODES + 1]; /* of the last step */
    int slipped, slips;                    /* 1 if all springs do, at the start of the last step and at its end */
    size_t changes;                        /* in between, at these places */
    double change_at[AOI_SLIP_CHANGES], change_stretch[2][AOI_SLIP_CHANGES]; /* and the row's stretches there */
};

/* Where the springs are not stretched: a touch. */
void aoi_sliding_touch(aoi_sliding *sliding);

/* The same, and from there straight to where the bodies are, an indentation and two slides. Errors as
 * aoi_oblique_solve. */
int aoi_sliding_begin(aoi_sliding *sliding, const double place[3]);

/* The force at the end of the last step. */
double aoi_sliding_force(const aoi_sliding *sliding, size_t axis);

/* Before the forces of a step are found: adds springs that the step will turn apart, by a guess of the places of the
 * three entries. */
void aoi_sliding_prepare(aoi_sliding *sliding, const aoi_contact_step *entry);

/* Sets force and by along the places of the three entries of a contact; both: follows both paths and sets drift, else only
 * the first, and takes the second to be as far from it as before. Errors as aoi_oblique_solve. */
int aoi_sliding_evaluate(aoi_sliding *sliding, const aoi_contact_step *entry, int both);

/* Sets beyond of a step that has been solved. Errors as aoi_oblique_solve. */
int aoi_sliding_check(aoi_sliding *sliding, const aoi_contact_step *entry);

/* The first place, beyond one, of a step that has been solved at which all of the contact begins to slip, or ceases to:
 * friction has a corner there. 2 where there is none. */
double aoi_sliding_corner(aoi_sliding *sliding, const aoi_contact_step *entry, double beyond);

/* Takes all paths to the end of the step. */
int aoi_sliding_advance(aoi_sliding *sliding, const aoi_contact_step *entry);

#endif
