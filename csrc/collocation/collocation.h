/* Contact forces of all contacts in one step of an adaptive run, by collocation. */
#ifndef AOI_COLLOCATION_COLLOCATION_H
#define AOI_COLLOCATION_COLLOCATION_H

#include "law/law.h"
#include "motion/nodes.h"
#include "motion/radau.h"
#include "motion/response.h"

/* Changes of an indentation below this, relative to its scale, count as rounding. */
#define AOI_COLLOCATION_ROUNDING 1e-12

/* Piece number of a slack contact: its bodies overlap, but the law's force is cut at zero. */
enum { AOI_SLACK = -1 };

/* An edge is an end of a step at which a contact's force begins or ends, like t^(3/2). The polynomial through the
 * force at the nodes would miss part of the impulse there; the least-squares polynomial through the force at the
 * edge's quadrature points does not. */
enum aoi_edge { AOI_EDGE_START = 0, AOI_EDGE_END, AOI_EDGE_NONE };

typedef struct aoi_sliding aoi_sliding; /* sliding.h */

/* State of a contact in a step. A contact with friction has three successive entries, for its normal and two
 * tangents; the `indentation` of a tangent is the slide of the bodies since the touch. The caller sets the first
 * block:
 *   memory, piece                   memory of the law, and the piece that applies
 *   edge                            edge at which the step begins or ends, if any
 *   start, start_rate, start_force  indentation, rate and force at the start of the step
 *   scale                           indentation to which errors are relative, m
 *   constant                        part of the force that is constant in the step, N: at a massless
 *                                   contact point the force at the start, else 0. Rates then follow from
 *                                   changes of forces within the step, without loss of digits in a short step
 *   homogeneous, homogeneous_rate   indentation and rate under the constant forces of all contacts
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

/* Returns the size of the work space of aoi_collocation_solve, in doubles, for count entries. span: largest
 * distance in the list between two entries of one body. */
size_t aoi_collocation_size(size_t count, size_t span);

/* aoi_crowd_pays: true if a step costs less by the method of crowd.c, with forces on the modes of the bodies and
 * influences AOI_BY_MODES, than by elimination. It compares, with all contacts closed, the multiplications of the
 * elimination with those of the largest number of iterations. aoi_crowd_size: size of the work space for crowd.c,
 * in doubles. */
int aoi_crowd_pays(const aoi_system *system);
size_t aoi_crowd_size(const aoi_system *system);

/* Returns minus the displacements of the modes of all bodies in contact, [first[body] + mode][node], under the
 * contact forces of a step that aoi_collocation_solve has solved. */
const double *aoi_crowd_motion(const aoi_system *system, size_t count, double *work);

/* True if rates must be computed: the law of one of these contacts depends on the rate, or on the rate's sign. */
int aoi_collocation_wants_rates(const aoi_system *system, size_t count, const aoi_contact_step *entry);

/* Solves F = law(indentation, rate), and the equations of friction, for all contacts together by Newton's method,
 * to rounding relative to the scale of each contact. F is the law's force at all nodes or, in a step with an edge
 * (only for bodies without residual compliance), the least-squares polynomial for the law's force. indentation,
 * rate: a guess on entry, the solution on return. response: one for each body. Returns AOI_ERROR_NO_CONVERGENCE if
 * the guess is too far from the solution: a shorter step is then needed. */
int aoi_collocation_solve(const aoi_system *system, const aoi_response *response, double h,
                          size_t count, size_t span, aoi_contact_step *entry, double *work);

/* Estimated errors of a step's solution. impulse, indentation: errors of both at the end of the step, N s and m,
 * to leading order, from the difference between the law's force and the force polynomial between the nodes. tail:
 * size of the last Legendre coefficients of the indentation, m. aoi_collocation_estimate also fills
 * entry->legendre; for a contact with friction, aoi_sliding_check must be called before. */
typedef struct aoi_collocation_error {
    double impulse, indentation, tail;
} aoi_collocation_error;
void aoi_collocation_estimate(const aoi_system *system, const aoi_response *response, double h,
                              aoi_contact_step *entry, aoi_collocation_error *error);

/* Returns the number of check points of a step, at which the law's force is compared with the force polynomial. */
static inline size_t aoi_edge_checks(enum aoi_edge edge)
{
    return edge == AOI_EDGE_NONE ? AOI_NODES : AOI_EDGE_CHECKS;
}

/* Sets `nodes` to the nodal values of the least-squares polynomial for `points`, values at the quadrature points
 * of an edge. Both may be the same array. */
static inline void aoi_edge_project(enum aoi_edge edge, const double *points, double *nodes)
{
    aoi_nodes_multiply(&aoi_radau_edge_projection[edge][0][0], points, nodes);
}

/* aoi_collocation_impulse: returns int F dt over the step, N s. aoi_collocation_work: returns int F d(indentation)
 * over the part of the step up to `place` (0 to 1), J; force: F at the nodes of this part. */
double aoi_collocation_impulse(const aoi_contact_step *entry, double h);
double aoi_collocation_work(const double *legendre, const double *force, double place);

#endif
