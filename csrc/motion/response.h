/* Response of a body over one step to polynomial forces. */
#ifndef AOI_MOTION_RESPONSE_H
#define AOI_MOTION_RESPONSE_H

#include "law/law.h"

/* Columns of an influence, one for each port on which forces act. port: port of each column; of: column of each
 * port; both NULL: the column of a port has its number. count = AOI_BY_MODES: influences [n][node][node] on each
 * mode of a unit force on the mode; sums of these are the influences between ports. */
typedef struct aoi_columns {
    size_t count, *port, *of;
} aoi_columns;

#define AOI_BY_MODES SIZE_MAX

/* Response of a body over a step of length h to polynomial forces, given by their values at the AOI_NODES Radau nodes:
 * exact for any omega h. */
typedef struct aoi_response {
    double h;
    int has_rates;                        /* influence_rate is filled                     */
    double *impulse, *rate, *step, *ramp; /* [n][node]: aoi_motion at the nodes          */
    double *to_x, *to_v;                  /* [n][node]: x, v at the end, per unit force */
    /* [port][column][node][node]: displacement (rate) of the port at the second node per unit force on the column's
     * port at the first node */
    double *influence, *influence_rate;
    aoi_columns columns;
    double *impulse_response;             /* [port][node]: displacement after a unit impulse */
    double *scratch;
} aoi_response;

/* Index in influence and influence_rate at which the influence of a force on the port `by` on another port begins. */
static inline size_t aoi_response_at(const aoi_response *response, size_t port, size_t by)
{
    const aoi_columns *columns = &response->columns;
    return (port * columns->count + (columns->of ? columns->of[by] : by)) * AOI_NODES * AOI_NODES;
}

/* Number of doubles in `block` of aoi_response_make, for `columns` columns (or AOI_BY_MODES). */
size_t aoi_response_size(const aoi_modes *body, size_t columns);

/* Fills the tables of a step of length h > 0. columns: NULL: each port has its own. block:
 * aoi_response_size doubles; they and the arrays of columns are kept. */
void aoi_response_make(aoi_response *response, const aoi_modes *body, const aoi_columns *columns, double h,
                       int with_rates, double *block);

/* Adds sign times the change of a port's displacement and, if not NULL, its rate at the nodes that
 * is due to the state at the start, to the loads and to constant forces on all ports (or NULL),
 * whose residual compliance is left out; time: of the start. */
void aoi_response_homogeneous(const aoi_response *response, const aoi_modes *body, size_t port,
                              double sign, double time, const double *x, const double *v, const double *force,
                              double *displacement, double *rate);

/* Advances x, v to the end of the step under force[port][node] and the loads. */
void aoi_response_propagate(const aoi_response *response, const aoi_modes *body, double time,
                            const double *force, double *x, double *v);

/* Advances x, v from the start of a step of length h, at the time `from`, to its place (0 .. 1),
 * under force[port][node] and the loads. */
void aoi_response_carry(const aoi_modes *body, double from, double h, const double *force,
                        double place, double *x, double *v);

#endif
