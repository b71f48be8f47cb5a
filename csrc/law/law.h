/* What integrators ask of a contact law, beside what everybody may. */
#ifndef AOI_LAW_LAW_H
#define AOI_LAW_LAW_H

#include "aoimpact.h"

/* At how many places in time a step of an adaptive run asks a law. */
enum { AOI_NODES = 8 };

/* Those at the nodes of a step. */
typedef struct aoi_law_values {
    double force[AOI_NODES], stiffness[AOI_NODES], damping[AOI_NODES];
} aoi_law_values;

/* The force of aoi_law_push, which is cheaper where the derivatives are taken by differences. */
double aoi_law_push_only(const aoi_law *law, const double *memory, double indentation, double rate);

/* 1 if aoi_law_push returned the law itself, 0 if it returned the straight-line continuation past its validity: deeper
 * than the law's limit, or where dF/dd reaches 1/c at a rate. Integrators then stop with AOI_ERROR_PATCH. */
int aoi_law_stands(const aoi_law *law, const double *memory, double indentation, double rate);

/* As law->piece, of total indentations (compliance or not), for every law. AOI_NO_PIECE where its
 * pieces do not go on to there: aoi_law_force gives NaN for it. */
enum { AOI_NO_PIECE = -2 };
int aoi_law_piece(const aoi_law *law, const double *memory, double indentation, int rising,
                  double *low, double *high);

/* As law->force on a given piece, of the total indentation: solves d - c F(d) = indentation for the
 * law's own d, to rounding. Where c dF/dd comes near 1, so that no law is left, it goes on as a
 * straight line: that is beyond limit, and only for an iteration on its way. NaN, and a note of
 * AOI_ERROR_LAW_JUMPS, where the law's force falls from one value to another and no d is between. */
void aoi_law_force(const aoi_law *law, const double *memory, int piece, double indentation,
                   double rate, aoi_law_value *value);

/* The same at AOI_NODES places. */
void aoi_law_forces(const aoi_law *law, const double *memory, int piece, const double *indentation,
                    const double *rate, aoi_law_values *values);

/* As law->rest, 0 for a law without. The force is zero there, so compliance plays no part. */
double aoi_law_rest(const aoi_law *law, const double *memory);

/* As law->remember, of the total indentation; nothing for a law without memory. To be called at the
 * end of every accepted step, and where the rate turns. */
void aoi_law_remember(const aoi_law *law, double indentation, double rate, double *memory);

#endif
