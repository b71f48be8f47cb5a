/* The layout of the rows of a track, which a run writes and its dense output reads. */
#ifndef AOI_ADAPTIVE_ROW_H
#define AOI_ADAPTIVE_ROW_H

#include "law/law.h"

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

#endif
