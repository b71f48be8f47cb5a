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

/* Values of a body in a row. */
enum aoi_row_body { AOI_TRACK_BODY = 0, AOI_TRACK_BODY_WORK, AOI_TRACK_BODY_LOST, AOI_TRACK_STATE };

/* Values of a contact in a row.
 *   CONTACT        its number
 *   BEGINS, ENDS   1 if its force begins at the row's start, and ends at its end, else 0
 *   EDGE           with which it was solved
 *   PIECE, MEMORY  of its law
 *   WORK, LOST     work done on it before the row, energy lost at the row's end, J
 *   RATE           at which its force began, m/s
 *   START_FORCE    at the row's start, N
 *   FORCE          at the nodes, N
 *   INDENTATION    Legendre coefficients, m
 * A contact that is in no later row, or goes on as AOI_SLACK, without a row in which it ends, has
 * ended where its last row with force does. */
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

/* For a contact with friction more follows. Its stretch is the ratio of friction to the normal
 * force, times the indentation of the bodies.
 *   SLIDE_WORK  work on slides before the row, less the energy of the stretches at the run's start, J
 *   DISSIPATED  of that, J: at the row's start, at the nodes or the points of an edge, and at its end
 *   STUCK       stuck share of the indentation, at the same places
 *   SLIPS       1 if all springs slip at the row's start, else 0
 *   CHANGES     places where that changes; 2: no further change
 *   TANGENTS    for each tangent: the force at the start and the nodes; the stretch there and at the
 *               changes; the Legendre coefficients of the slide */
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

/* Number of doubles of a contact in a row. */
static inline size_t aoi_row_contact_size(const aoi_contact *contact)
{
    return contact->friction ? AOI_TRACK_FRICTION_SIZE : AOI_TRACK_CONTACT_SIZE;
}

/* Forces of a contact with friction at a place (0 to 1) of a row, along the normal and the
 * tangents, N. of: its values in the row; bent: its own indentation less that of the bodies, m. */
void aoi_row_rub(const aoi_contact *contact, const double *of, double place, double force[3], double *bent);

/* Values of the force's polynomial (with friction, of all three) at the nodes of the part of a row
 * of length h up to `place`. At an edge it is fitted anew on that part, since the row's own
 * polynomial is a fit over the whole row. */
void aoi_row_forces(const aoi_contact *contact, const double *of, double h, double place, double force[3][AOI_NODES]);

/* Work of friction up to a place, with that before the row, J, on the contact's own slide: that of
 * the bodies plus the compliance taken out times the forces. aoi_row_slide_work leaves out the
 * deflection by friction itself. With it, aoi_row_slide_stored is the energy dissipated or stored
 * in the stretches. */
double aoi_row_slide_work(const aoi_contact *contact, const double *of, double place);
double aoi_row_slide_stored(const aoi_contact *contact, const double *of, double place);

/* Value at a place, linear between those at the start, at the nodes or the points of an edge, and
 * at the end; first: index of the first of these. */
double aoi_row_between(const double *of, int first, double place);

/* Stuck share at a place: 0 where all springs slip, else linear, falling to 0 where that begins. */
double aoi_row_stuck(const double *of, double place);

#endif
