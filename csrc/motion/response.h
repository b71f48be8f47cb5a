/* Response of a body over one step to forces that are polynomials in time. */
#ifndef AOI_MOTION_RESPONSE_H
#define AOI_MOTION_RESPONSE_H

#include "law/law.h"

/* Columns of an influence matrix, one for each port on which forces act. port: port of each column; of: column of
 * each port; both NULL: column and port have the same index. count = AOI_BY_MODES: the influences [n][node][node]
 * are the motion of each mode per unit force on that mode; influences between ports are weighted sums of them. */
typedef struct aoi_columns {
    size_t count, *port, *of;
} aoi_columns;

#define AOI_BY_MODES SIZE_MAX

/* Response of a body over a step of length h to polynomial forces, given by their values at the AOI_NODES Radau
 * nodes. It is exact for any omega h. */
typedef struct aoi_response {
    double h;
    int has_rates;                        /* 1: influence_rate is filled                  */
    double *impulse, *rate, *step, *ramp; /* [n][node]: members of aoi_motion at the nodes */
    double *to_x, *to_v;                  /* [n][node]: x, v at the end of the step, per unit force at the node */
    /* [port][column][node][node]: displacement (rate) of the port at the second node, per unit force on the
     * column's port at the first node */
    double *influence, *influence_rate;
    aoi_columns columns;
    /* [port][node]: displacement after a unit impulse on the port at the start */
    double *impulse_response;
    double *scratch;
} aoi_response;

/* Returns the index, in influence and influence_rate, of the block for the effect on a port of a force on the port
 * `by`. */
static inline size_t aoi_response_at(const aoi_response *response, size_t port, size_t by)
{
    const aoi_columns *columns = &response->columns;
    return (port * columns->count + (columns->of ? columns->of[by] : by)) * AOI_NODES * AOI_NODES;
}

/* Returns the size of `block` of aoi_response_make, in doubles, for `columns` columns (or AOI_BY_MODES). */
size_t aoi_response_size(const aoi_modes *body, size_t columns);

/* Fills the tables for a step of length h > 0. columns: NULL for a column per port. block: aoi_response_size
 * doubles, which the response keeps, as it does the arrays of columns. */
void aoi_response_make(aoi_response *response, const aoi_modes *body, const aoi_columns *columns, double h,
                       int with_rates, double *block);

/* Adds sign times the change since the start of a port's displacement at the nodes and, if `rate` is not NULL, of
 * its rate. The change is due to the state at the start, to the loads and to constant forces on all ports (force,
 * or NULL). The deflection of the residual compliance under these constant forces is not included. time: start of
 * the step, s. */
void aoi_response_homogeneous(const aoi_response *response, const aoi_modes *body, size_t port,
                              double sign, double time, const double *x, const double *v, const double *force,
                              double *displacement, double *rate);

/* Advances x, v to the end of the step, under the forces force[port][node] and the loads. */
void aoi_response_propagate(const aoi_response *response, const aoi_modes *body, double time,
                            const double *force, double *x, double *v);

/* Advances x, v from the start of a step of length h, at the time `from`, to a position `place` in it (0 .. 1),
 * under the forces force[port][node] and the loads. */
void aoi_response_carry(const aoi_modes *body, double from, double h, const double *force,
                        double place, double *x, double *v);

#endif
