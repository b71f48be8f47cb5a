/* The layout of the rows of a track, which a run writes and its dense output reads. */
#ifndef AOI_ADAPTIVE_ROW_H
#define AOI_ADAPTIVE_ROW_H

#include "collocation/sliding.h"
#include "law/law.h"
#include "model/system.h"

/* A row of a track, the dense record of an adaptive run: a step of contact, or the start of free motion of some bodies.
 * First the five values of aoi_row; then for each of its bodies an aoi_row_body: its number, the work done on it and the
 * energy dissipated in it before (J), and x, v at the start (AOI_TRACK_STATE + 2 n); then for each of its contacts an
 * aoi_row_contact. After its last row a body moves freely. */
enum aoi_row { AOI_TRACK_START = 0, AOI_TRACK_LENGTH, AOI_TRACK_BODIES, AOI_TRACK_CONTACTS,
               AOI_TRACK_SIZE, AOI_TRACK_FIXED };

/* A body in a row. */
enum aoi_row_body { AOI_TRACK_BODY = 0, AOI_TRACK_BODY_WORK, AOI_TRACK_BODY_LOST, AOI_TRACK_STATE };

/* A contact in a row: which; whether its force begins at the row's start and ends at its end (1 or 0); the edge it was
 * solved with; piece, memory, work done on it before, and lost at the end of the row (J); the rate at which its force
 * began; the force at the row's start, and at the nodes; the Legendre coefficients of the indentation. A contact that
 * is in no later row, or goes on as AOI_SLACK, without a row in which it ends, has ended where its last row with force
 * does. */
enum aoi_row_contact {
    AOI_TRACK_CONTACT = 0,
    AOI_TRACK_BEGINS,
    AOI_TRACK_ENDS,
    AOI_TRACK_EDGE,
    AOI_TRACK_PIECE,
    AOI_TRACK_MEMORY,
    AOI_TRACK_WORK = AOI_TRACK_MEMORY + AOI_LAW_MEMORY,
    AOI_TRACK_LOST,
    AOI_TRACK_RATE,
    AOI_TRACK_START_FORCE,
    AOI_TRACK_FORCE,
    AOI_TRACK_INDENTATION = AOI_TRACK_FORCE + AOI_NODES,
    AOI_TRACK_CONTACT_SIZE = AOI_TRACK_INDENTATION + AOI_NODES + 1
};

/* With friction more follows: the work on slides before, less the energy of stretches at the start of a run; of it
 * dissipated, J, and the stuck share of the indentation, before and at the nodes or the points of an edge, and at the end;
 * 1 if all slips at the start, else 0, and the places where that changes, 2 in place of those that there are not; then
 * for each tangent an aoi_row_tangent: the force at the start and at the nodes; there and where slip changes the stretch, its
 * ratio to the normal force times the indentation of the bodies; and the Legendre coefficients of the slide. */
enum aoi_row_friction {
    AOI_TRACK_SLIDE_WORK = AOI_TRACK_CONTACT_SIZE,
    AOI_TRACK_DISSIPATED,
    AOI_TRACK_STUCK = AOI_TRACK_DISSIPATED + AOI_NODES + 2,
    AOI_TRACK_SLIPS = AOI_TRACK_STUCK + AOI_NODES + 2,
    AOI_TRACK_CHANGES,
    AOI_TRACK_TANGENTS = AOI_TRACK_CHANGES + AOI_SLIP_CHANGES,
    AOI_TRACK_TANGENT_START = 0,
    AOI_TRACK_TANGENT_FORCE,
    AOI_TRACK_TANGENT_STRETCH = AOI_TRACK_TANGENT_FORCE + AOI_NODES,
    AOI_TRACK_TANGENT_CHANGES = AOI_TRACK_TANGENT_STRETCH + AOI_NODES + 1,
    AOI_TRACK_TANGENT_SLIDE = AOI_TRACK_TANGENT_CHANGES + AOI_SLIP_CHANGES,
    AOI_TRACK_TANGENT_SIZE = AOI_TRACK_TANGENT_SLIDE + AOI_NODES + 1,
    AOI_TRACK_FRICTION_SIZE = AOI_TRACK_TANGENTS + 2 * AOI_TRACK_TANGENT_SIZE
};

/* Doubles of a contact in a row. */
static inline size_t aoi_row_contact_size(const aoi_contact *contact)
{
    return contact->friction ? AOI_TRACK_FRICTION_SIZE : AOI_TRACK_CONTACT_SIZE;
}

/* The normal force and those along the tangents of a contact with friction (of: in its row) at a place (0 .. 1) of the
 * row, N, and the indentation beyond that of the bodies, m. */
void aoi_row_rub(const aoi_contact *contact, const double *of, double place, double force[3], double *bent);

/* The polynomials of the force, with friction of all three, at the nodes of the part up to place of a row of length h. At an
 * edge these are the nearest ones on that part, since the row's own is right on the whole only. */
void aoi_row_forces(const aoi_contact *contact, const double *of, double h, double place, double force[3][AOI_NODES]);

/* The work on slides up to a place, with that before, J: but for that on slides which the compliance that is taken out
 * would make of friction. With it what is dissipated or in the stretches. */
double aoi_row_slide_work(const aoi_contact *contact, const double *of, double place);
double aoi_row_slide_stored(const aoi_contact *contact, const double *of, double place);

/* A value at a place, linear between those before, at the nodes or the points of an edge, and at the end. */
double aoi_row_between(const double *of, int first, double place);

/* The stuck share at a place: 0 where all slips, and else linear, to 0 where that begins. */
double aoi_row_stuck(const double *of, double place);

#endif
