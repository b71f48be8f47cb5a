/* A run to a tolerance. */
#ifndef AOI_ADAPTIVE_ADAPTIVE_H
#define AOI_ADAPTIVE_ADAPTIVE_H

#include "law/law.h"
#include "model/coupled.h"
#include "motion/response.h"
#include "collocation/collocation.h"

enum { AOI_TABLES = 12 };

/* What a run knows of a body: since when x, v hold, and the tables of the steps it made last. */
typedef struct aoi_follower {
    double time;
    int engaged; /* in this step: 2 under force, 1 beside such a body, 0 in flight */
    int changed; /* since its last row */
    double work, dissipated;
    double *block;
    size_t table_count;
    aoi_response table[AOI_TABLES];
    int table_level[AOI_TABLES];
    size_t table_use[AOI_TABLES];
} aoi_follower;

/* What a run knows of a contact, and what it has found out about it. */
typedef struct aoi_contact_state {
    int closed, begins, piece;
    double low, high; /* ends of the piece */
    double mobility;  /* of both ports under a sudden force, 1/kg */
    double edge;      /* length of a step that its beginning, so its end, allows; 0: not known */
    double memory[AOI_LAW_MEMORY];
    double start, start_rate, force; /* now, while closed */
    double bending;    /* the force that the residual compliance knows of */
    double force_rate; /* at the end of the last step, where bodies have a residual compliance */
    double indentation_scale, impulse_scale, rate_scale;
    double free_until; /* while open, and both bodies in flight: no touch before */
    int touches;       /* but then */
    size_t place;      /* among the watched ones */
    double slack;      /* while open: so much deeper than rest is no touch yet */
    int event;         /* what happens to it in the step being tried, and where */
    double event_place;
    double last_length, last[AOI_STAGES + 1]; /* the last step's indentation, to guess the next */
    double peak_force, peak_time, impulse, since_touch, work;
} aoi_contact_state;

/* Numbers of bodies or contacts. */
typedef struct aoi_list {
    size_t count, *at;
} aoi_list;

/* A run to a relative tolerance rtol of peak force, contact times, impulse and velocities. The caller
 * sets the first block: a linked system; x, v at time, of all bodies; body, contact, stage and response of
 * body_count, joint_count, joint_count and body_count elements, and balanced of joint_count; work and lists
 * of as many doubles and numbers as aoi_adaptive_size says; and calls aoi_adaptive_start. Bodies that overlap at the start are in
 * contact from the start. What a step costs depends on the bodies that take part in it only. */
typedef struct aoi_adaptive {
    const aoi_system *system;
    double rtol, time, end;
    int rested; /* the bodies have come to rest under loads and contacts; 0: those set in at time */
    double *x, *v;
    aoi_follower *body;
    aoi_contact_state *contact;
    aoi_stage *stage;
    aoi_response *response;
    aoi_contact *balanced; /* contacts at places without mass, while their forces are found */
    double *work;
    size_t *lists;

    aoi_list closed;     /* contacts, ascending                                           */
    aoi_list watched[2]; /* open ones in flight: until when they are free, when they touch */
    aoi_list engaged, changed; /* bodies: in this step; since their last row              */
    size_t span, row_size;
    size_t closed_count, stage_count; /* the stages: closed contacts first, then those beside them */
    int level;                        /* steps are base 2^(-level/8) long */
    int grain;                        /* of which only these multiples are taken  */
    double table_cost, saved;         /* what tables cost, in steps, and what longer ones had saved */
    double base;
    double indentation_scale, impulse_scale; /* the largest of the contacts that are closed */
    double force_scale; /* in the step tried, where more than one is closed; else 0 */
    double origin, elapsed; /* time is their sum: short steps of a late contact */
    double left_off;        /* of elapsed by rounding */
    double horizon;         /* no contact between bodies in flight before */
    int unbalanced;         /* something has happened to a contact since the last step */
    double *flight[2], *scratch, *port_force, *collocation;
    double *port_slope; /* of the step's forces at its start, where a body has modes that ring: aoi_step_slopes */
    size_t steps, rejected, uses;
    size_t culprit; /* contact in which an error came up */
} aoi_adaptive;

/* Doubles of work, numbers of lists, and the largest row of the track. */
void aoi_adaptive_size(const aoi_system *system, size_t *work, size_t *lists, size_t *row);

/* Sets the rest of the run to its beginning. Errors as aoi_system_check, also where rtol or the duration
 * is not positive; AOI_ERROR_NOT_FINITE for x, v. */
int aoi_adaptive_start(aoi_adaptive *run);

/* Goes on until time >= end, or less than a row's room is left of capacity doubles of track or of most
 * entries of index (where each row starts), or a touch takes more than some .1 s to find; used and rows say how many were written; call again with
 * more. AOI_ERROR_TOLERANCE where even the shortest step does not meet rtol; AOI_ERROR_LAW where a law
 * gives no number; AOI_ERROR_PATCH where contact goes deeper than the law holds. */
int aoi_adaptive_run(aoi_adaptive *run, size_t capacity, size_t most, double *track, size_t *index,
                     size_t *used, size_t *rows);

#endif
