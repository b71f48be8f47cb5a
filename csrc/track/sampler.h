/* Dense output: a track read at any time. */
#ifndef AOI_TRACK_SAMPLER_H
#define AOI_TRACK_SAMPLER_H

#include "aoimpact.h"

/* A track to be sampled, at times that ascend from one call to the next. The caller sets the first block;
 * work: doubles of aoi_sampler_size. */
typedef struct aoi_sampler {
    const aoi_system *system;
    const double *track; /* size */
    const size_t *index; /* rows */
    size_t size, rows;
    size_t *body_row, *body_at;       /* body_count each: the row that holds it, and where */
    size_t *contact_row, *contact_at; /* joint_count each                                  */
    double *work;

    size_t row, most_modes;
    int has_edge; /* a contact of the row was solved with an edge      */
    double part;  /* of the row up to where port_force goes: else 1    */
    double *port_force, *states;
    double *settled; /* work on each contact up to the end of its last row; NaN: not yet asked for */
    double *flown, *booked; /* bodies in flight as they were at the last bend of their loads */
} aoi_sampler;

size_t aoi_sampler_size(const aoi_system *system);

/* To the beginning of the track. AOI_ERROR_ARGUMENT for one that does not start with all bodies, or names
 * what is not in the system, or has contacts in a row of no length, or rows that go back in time, or is not
 * whole; and as aoi_system_check. */
int aoi_sampler_start(aoi_sampler *sampler);

/* Rows of a record, and the column of one time of it: value i goes to record[i * stride]. energies: 0
 * leaves their rows alone. */
size_t aoi_sampler_rows(const aoi_system *system);
void aoi_sampler_column(aoi_sampler *sampler, double time, int energies, double *record,
                        size_t stride);

/* The contact forces at one time, N: that of joint c goes to force[c * stride]. They need no body's motion,
 * which is what a column costs. */
void aoi_sampler_forces(aoi_sampler *sampler, double time, double *force, size_t stride);

/* x, then v, of one body (2n doubles) at that time. */
void aoi_sampler_state(aoi_sampler *sampler, double time, size_t body, double *state);

#endif
