/* Functions of contact laws for the integrators, in addition to the public ones. */
#ifndef AOI_LAW_LAW_H
#define AOI_LAW_LAW_H

#include "aoimpact.h"

/* Number of nodes in time of a step of an adaptive run, at which laws are evaluated. */
enum { AOI_NODES = 8 };

/* Force and slopes of a law at the nodes of a step. */
typedef struct aoi_law_values {
    double force[AOI_NODES], stiffness[AOI_NODES], damping[AOI_NODES];
} aoi_law_values;

/* Returns the force of aoi_law_push alone, which is cheaper if the law's derivatives are finite differences. */
double aoi_law_push_only(const aoi_law *law, const double *memory, double indentation, double rate);

/* Returns 1 if the value of aoi_law_push is the law's own, 0 if it is on the straight line that continues the law
 * beyond its validity: deeper than the law's limit or, at a rate, where dF/dd reaches 1/c. Integrators then stop
 * with AOI_ERROR_PATCH. */
int aoi_law_stands(const aoi_law *law, const double *memory, double indentation, double rate);

/* Returns the piece of any law as law->piece, but for the total indentation. Returns AOI_NO_PIECE if no piece
 * reaches that far; aoi_law_force then gives NaN. */
enum { AOI_NO_PIECE = -2 };
int aoi_law_piece(const aoi_law *law, const double *memory, double indentation, int rising,
                  double *low, double *high);

/* Sets `value` to the law on a given piece as law->force, but at the total indentation: solves d - c F(d) =
 * indentation for the law's own d, to rounding. Where c dF/dd comes near 1 the law is continued as a straight
 * line, which lies beyond the law's limit and serves intermediate iterates only. If no d solves the equation
 * because the force drops, the value is NaN, and AOI_ERROR_LAW_JUMPS is recorded in the note. */
void aoi_law_force(const aoi_law *law, const double *memory, int piece, double indentation,
                   double rate, aoi_law_value *value);

/* Evaluates aoi_law_force at AOI_NODES indentations and rates. */
void aoi_law_forces(const aoi_law *law, const double *memory, int piece, const double *indentation,
                    const double *rate, aoi_law_values *values);

/* Returns the indentation at and below which the law has no force, as law->rest; 0 if that is NULL. A compliance
 * does not change it, since the force there is 0. */
double aoi_law_rest(const aoi_law *law, const double *memory);

/* Updates the memory of a contact as law->remember, but at the total indentation; no effect on a law without
 * memory. Must be called at the end of every accepted step, and where the rate changes its sign. */
void aoi_law_remember(const aoi_law *law, double indentation, double rate, double *memory);

#endif
