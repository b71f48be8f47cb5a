/* Functions of contact laws for the integrators, beside the public ones. */
#ifndef AOI_LAW_LAW_H
#define AOI_LAW_LAW_H

#include "aoimpact.h"

/* Number of nodes in time of a step of an adaptive run, at which laws are evaluated. */
enum { AOI_NODES = 8 };

/* Values of a law at the nodes of a step. */
typedef struct aoi_law_values {
    double force[AOI_NODES], stiffness[AOI_NODES], damping[AOI_NODES];
} aoi_law_values;

/* The force of aoi_law_push alone: cheaper for a law whose derivatives are finite differences. */
double aoi_law_push_only(const aoi_law *law, const double *memory, double indentation, double rate);

/* 1 if aoi_law_push returned the law itself, 0 if it returned the straight-line continuation past its validity: deeper
 * than the law's limit, or where dF/dd reaches 1/c at a rate. Integrators then stop with AOI_ERROR_PATCH. */
int aoi_law_stands(const aoi_law *law, const double *memory, double indentation, double rate);

/* As law->piece, for the total indentation and for every law. Returns AOI_NO_PIECE if no piece reaches that far;
 * aoi_law_force then gives NaN. */
enum { AOI_NO_PIECE = -2 };
int aoi_law_piece(const aoi_law *law, const double *memory, double indentation, int rising,
                  double *low, double *high);

/* As law->force on a given piece, at the total indentation: solves d - c F(d) = indentation for the law's own d, to
 * rounding. Where c dF/dd comes near 1 the law is continued as a straight line. The line is beyond the law's limit
 * and serves intermediate iterates only. NaN, and a note of AOI_ERROR_LAW_JUMPS, where no d solves the equation
 * since the force drops. */
void aoi_law_force(const aoi_law *law, const double *memory, int piece, double indentation,
                   double rate, aoi_law_value *value);

/* aoi_law_force at AOI_NODES indentations. */
void aoi_law_forces(const aoi_law *law, const double *memory, int piece, const double *indentation,
                    const double *rate, aoi_law_values *values);

/* As law->rest; 0 for a law without. A compliance has no effect, since the force is 0 there. */
double aoi_law_rest(const aoi_law *law, const double *memory);

/* As law->remember, at the total indentation; no effect on a law without memory. To be called at
 * the end of every accepted step, and where the rate turns. */
void aoi_law_remember(const aoi_law *law, double indentation, double rate, double *memory);

#endif
