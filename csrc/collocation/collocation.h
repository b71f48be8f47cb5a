/* Contact forces of one step, of all contacts, by collocation. */
#ifndef AOI_COLLOCATION_COLLOCATION_H
#define AOI_COLLOCATION_COLLOCATION_H

#include "law/law.h"
#include "motion/nodes.h"
#include "motion/radau.h"
#include "motion/response.h"

/* Change of an indentation, as a share of its scale, that counts as rounding. */
#define AOI_COLLOCATION_ROUNDING 1e-12

/* Piece of a slack contact: its bodies overlap, but the law's force is cut at zero. */
enum { AOI_SLACK = -1 };

/* Edge: the end of a step at which a contact's force begins or ends, like t^(3/2). A polynomial through the force at
 * the nodes would miss part of its impulse, the polynomial of least squares does not. */
enum aoi_edge { AOI_EDGE_START = 0, AOI_EDGE_END, AOI_EDGE_NONE };

typedef struct aoi_sliding aoi_sliding; /* sliding.h */

/* State of a contact in a step. A contact with friction has three successive entries, for its normal and two tangents;
 * the `indentation` of a tangent is the slide of the bodies since the touch. The caller sets the first block:
 *   memory, piece                   of the law
 *   edge                            of the contact that the step has
 *   start, start_rate, start_force  indentation, rate and force at the start of the step
 *   scale                           of the indentation
 *   constant                        a constant force; at a massless contact point the force at the
 *                                   start: rates then follow from changes of forces within the step
 *                                   without loss of digits, however short it is
 *   homogeneous, homogeneous_rate   motion under the constant forces of all contacts
 *   indentation, rate               a guess; in the end the solution */
typedef struct aoi_contact_step {
    size_t contact, axis;  /* axis: 0 normal, 1 and 2 tangents */
    aoi_sliding *sliding;  /* NULL: without friction           */
    const double *memory;
    int piece;
    enum aoi_edge edge;
    double start, start_rate, start_force, scale;
    double constant;
    double homogeneous[AOI_NODES], homogeneous_rate[AOI_NODES];
    double indentation[AOI_NODES], rate[AOI_NODES];

    double force[AOI_NODES];
    double legendre[AOI_NODES + 1]; /* Legendre coefficients of the indentation */
} aoi_contact_step;

/* Number of doubles of work space of aoi_collocation_solve for count entries of which those that
 * share a body are at most span places apart. */
size_t aoi_collocation_size(size_t count, size_t span);

/* True if steps of a system's contacts cost less with the modes of its bodies (crowd.c) and influences AOI_BY_MODES.
 * With all contacts closed, the multiplications of the elimination are compared with those of the largest number of
 * iterations. aoi_crowd_size: size of the work space of crowd.c, instead of aoi_collocation_size. */
int aoi_crowd_pays(const aoi_system *system);
size_t aoi_crowd_size(const aoi_system *system);

/* The displacements of the modes of all bodies that are in contact at the nodes, [first[body] + mode][node], under the
 * contact forces of a step that aoi_collocation_solve has solved, with their signs changed. */
const double *aoi_crowd_motion(const aoi_system *system, size_t count, double *work);

/* True if rates are needed: a law of these contacts depends on the rate, or on changes of its sign. */
int aoi_collocation_wants_rates(const aoi_system *system, size_t count, const aoi_contact_step *entry);

/* Solves F = law(indentation, rate), and friction, for all contacts together by Newton's method, to rounding
 * relative to the scale of each contact. F is the law's force at all nodes, or, at an edge (of bodies without
 * residual compliance), the polynomial nearest to the law's force. indentation, rate: a guess in, the solution out.
 * response: one for each body. AOI_ERROR_NO_CONVERGENCE where the guess is too far from the solution: take a shorter
 * step. */
int aoi_collocation_solve(const aoi_system *system, const aoi_response *response, double h,
                          size_t count, size_t span, aoi_contact_step *entry, double *work);

/* Errors of the solution. The law's force minus the polynomial's between the nodes gives the leading error of the
 * impulse and of the indentation at the end of the step; tail is the size of the last Legendre coefficients of the
 * indentation. With friction, aoi_sliding_check must be called first. Fills entry->legendre. */
typedef struct aoi_collocation_error {
    double impulse, indentation, tail;
} aoi_collocation_error;
void aoi_collocation_estimate(const aoi_system *system, const aoi_response *response, double h,
                              aoi_contact_step *entry, aoi_collocation_error *error);

/* Number of points of a step where the law's force is compared with the polynomial's. */
static inline size_t aoi_edge_checks(enum aoi_edge edge)
{
    return edge == AOI_EDGE_NONE ? AOI_NODES : AOI_EDGE_CHECKS;
}

/* Sets `nodes` to the values at the nodes of the least-squares polynomial for the values `points` at the quadrature
 * points of an edge. Both may be the same array. */
static inline void aoi_edge_project(enum aoi_edge edge, const double *points, double *nodes)
{
    aoi_nodes_multiply(&aoi_radau_edge_projection[edge][0][0], points, nodes);
}

/* aoi_collocation_impulse: int F dt over the step, N s. aoi_collocation_work: int F d(indentation) over the part of
 * the step up to a place, J; force: F at the nodes of this part. */
double aoi_collocation_impulse(const aoi_contact_step *entry, double h);
double aoi_collocation_work(const double *legendre, const double *force, double place);

#endif
