/* Layout of the rows of a track: a run writes them, and dense output reads them. */
#ifndef AOI_ADAPTIVE_ROW_H
#define AOI_ADAPTIVE_ROW_H

#include "collocation/sliding.h"
#include "law/law.h"
#include "model/system.h"

/* A row of a track, the dense record of an adaptive run: a step of contact, or the start of free motion of some
 * bodies. A row consists of the five values of aoi_row; for each of its bodies, of an aoi_row_body with
 * AOI_TRACK_STATE + 2 n values: the body's number, the work of loads and gravity on it and the energy dissipated
 * in it before the row (J), and x, v at the row's start; and for each of its contacts, of an aoi_row_contact. A
 * body moves freely after the last row that contains it. */
enum aoi_row { AOI_TRACK_START = 0, AOI_TRACK_LENGTH, AOI_TRACK_BODIES, AOI_TRACK_CONTACTS,
               AOI_TRACK_SIZE, AOI_TRACK_FIXED };

/* Values of a body in a row. */
enum aoi_row_body { AOI_TRACK_BODY = 0, AOI_TRACK_BODY_WORK, AOI_TRACK_BODY_LOST, AOI_TRACK_STATE };

/* Values of a contact in a row.
 *   CONTACT        index of the contact
 *   BEGINS, ENDS   1 if its force begins at the row's start (BEGINS) or ends at its end (ENDS), else 0
 *   EDGE           enum aoi_edge with which the step was solved: whether its force begins or ends in it
 *   PIECE, MEMORY  piece and memory of its law
 *   WORK, LOST     work of its force before the row, energy lost in a pull-off at the row's end, J
 *   RATE           rate of the indentation at the last time when its force began, m/s
 *   START_FORCE    force at the row's start, N
 *   FORCE          forces at the nodes, N
 *   INDENTATION    Legendre coefficients of the indentation, m
 * If no row says that a contact's force ends, and the contact is in no later row or continues as AOI_SLACK, the
 * contact has ended at the end of its last row with force. */
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

/* Further values of a contact with friction. The stretch here is the ratio of friction to the normal force, times
 * the indentation of the bodies.
 *   SLIDE_WORK  work on slides before the row, less the energy of the stretches at the run's start, J
 *   DISSIPATED  dissipated part of this work, J: at the row's start, at the nodes or an edge's quadrature points, and
 *               at the row's end
 *   STUCK       share of the indentation up to which springs stick, at the same places
 *   SLIPS       1 if all springs slip at the row's start, else 0
 *   CHANGES     positions (0 to 1) at which all springs begin or cease to slip; 2: no further change
 *   TANGENTS    for each tangent: friction at the start and the nodes; the stretch there and at the CHANGES; the
 *               Legendre coefficients of the slide */
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

/* Returns the number of doubles that a contact takes in a row. */
static inline size_t aoi_row_contact_size(const aoi_contact *contact)
{
    return contact->friction ? AOI_TRACK_FRICTION_SIZE : AOI_TRACK_CONTACT_SIZE;
}

/* Sets `force` to the forces of a contact with friction at a position (0 to 1) of a row, along the normal and the
 * tangents, N. of: the contact's values in the row; bent: set to the contact's own indentation minus that of the
 * bodies, m. */
void aoi_row_rub(const aoi_contact *contact, const double *of, double place, double force[3], double *bent);

/* Sets `force` to the values, at the nodes of the part of a row up to `place`, of the polynomial of the contact
 * force (with friction, of all three forces). h: length of the row, s. In a row with an edge the polynomial is
 * fitted anew on that part, since the row's own polynomial is a fit over the whole row. */
void aoi_row_forces(const aoi_contact *contact, const double *of, double h, double place, double force[3][AOI_NODES]);

/* Return the work of friction up to a position in a row, including the work before the row, J.
 * aoi_row_slide_stored: on the contact's own slide, which is the slide of the bodies plus the compliance taken out
 * of the law times the forces; this work is dissipated or stored in the stretches. aoi_row_slide_work: without the
 * deflection caused by friction itself. */
double aoi_row_slide_work(const aoi_contact *contact, const double *of, double place);
double aoi_row_slide_stored(const aoi_contact *contact, const double *of, double place);

/* Returns the value at a position in a row, interpolated linearly between the values at the row's start, at the
 * nodes or an edge's quadrature points, and at the row's end. first: index of the value at the start. */
double aoi_row_between(const double *of, int first, double place);

/* Returns the stuck share of the indentation at a position in a row: 0 while all springs slip, else interpolated
 * linearly, to 0 where all springs begin to slip. */
double aoi_row_stuck(const double *of, double place);

#endif
