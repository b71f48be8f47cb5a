/* Private to adaptive/: what run.c (which step comes next), closing.c, release.c, watch.c and the files
 * of one step share; step.h has what those share among themselves. */
#ifndef AOI_ADAPTIVE_H
#define AOI_ADAPTIVE_H

#include "law/law.h"
#include "model/coupled.h"
#include "motion/free.h"
#include "motion/response.h"
#include "collocation/collocation.h"

#include <math.h>

enum { AOI_TABLES = 12 };

/* What a run knows of a body: since when x, v hold, and the tables of the steps it made last. */
typedef struct aoi_adaptive_body {
    double time;
    int engaged; /* in this step: 2 under force, 1 beside such a body, 0 in free motion */
    int changed; /* since its last row */
    double work, dissipated;
    double *block;
    size_t table_count;
    aoi_response table[AOI_TABLES];
    int table_level[AOI_TABLES];
    size_t table_use[AOI_TABLES];
} aoi_adaptive_body;

/* What a run knows of a contact, and what it has found out about it. */
typedef struct aoi_adaptive_contact {
    int closed, begins, piece;
    double low, high; /* ends of the piece */
    double mobility;  /* of both ports under a sudden force, 1/kg */
    double edge;      /* length of a step that its beginning, so its end, allows; 0: not known */
    double memory[AOI_LAW_MEMORY];
    double start, start_rate, force; /* now, while closed */
    double touch_rate; /* when its force last began, before that changed it */
    double bending;    /* the force that the residual compliance knows of */
    double force_rate; /* at the end of the last step, where bodies have a residual compliance */
    double indentation_scale, impulse_scale, rate_scale;
    double free_until; /* while open, and both bodies in free motion: no touch before */
    int touches;       /* but then */
    size_t place;      /* among the watched ones */
    double slack;      /* while open: so much deeper than rest is no touch yet */
    int event;         /* what happens to it in the step being tried, and where */
    double event_place;
    double last_length, last[AOI_NODES + 1]; /* the last step's indentation, to guess the next */
    double peak_force, peak_time, impulse, since_touch, work;
} aoi_adaptive_contact;

/* Numbers of bodies or contacts. */
typedef struct aoi_list {
    size_t count, *at;
} aoi_list;

/* A run. What a step costs depends on the bodies that take part in it only. */
struct aoi_adaptive {
    const aoi_system *system;
    double rtol, time, end;
    int rested; /* the bodies have come to rest under loads and contacts; 0: those set in at time */
    double *x, *v; /* of all bodies */
    aoi_adaptive_body *body;
    aoi_adaptive_contact *contact;
    aoi_contact_step *entry;
    aoi_response *response;
    aoi_contact_state *balanced; /* contacts at places without mass, while their forces are found */

    aoi_list closed;     /* contacts, ascending                                           */
    aoi_list watched[2]; /* open ones in free motion: until when they are free, when they touch */
    aoi_list engaged, changed; /* bodies: in this step; since their last row              */
    size_t span, row_size;
    size_t closed_count, entry_count; /* the entries: closed contacts first, then those beside them */
    int level;                        /* steps are base 2^(-level/8) long */
    int grain;                        /* of which only these multiples are taken  */
    double table_cost, saved;         /* what tables cost, in steps, and what longer ones had saved */
    double base;
    double indentation_scale, impulse_scale; /* the largest of the contacts that are closed */
    double force_scale; /* in the step tried, where more than one is closed; else 0 */
    double origin, elapsed; /* time is their sum: short steps of a late contact */
    double left_off;        /* of elapsed by rounding */
    double horizon;         /* no contact between bodies in free motion before */
    int unbalanced;         /* something has happened to a contact since the last step */
    double *flight[2], *scratch, *port_force, *collocation;
    double *port_slope; /* of the step's forces at its start, where a body has modes that ring: aoi_step_slopes */
    size_t steps, rejected, uses;
    size_t failed; /* contact in which an error came up */
};

/* Steps are base 2^(-level/8) long. */
enum {
    AOI_LEVELS = 8, /* an octave */
    AOI_DEEPEST_LEVEL = 90 * AOI_LEVELS,
    AOI_HIGHEST_LEVEL = -40 * AOI_LEVELS,
    AOI_NO_LEVEL = 1000
};

/* After a step that was good enough the next is longer by this at most. */
#define AOI_MOST_GROWTH 8.0

/* The search for a touch looks at so many modes in all, some tenth of a second, before it hands over. */
enum { AOI_MOST_LOOKS = 500000 };

/* What may happen to a contact within a step. */
enum aoi_event {
    AOI_EVENT_NONE = 0,
    AOI_EVENT_TOUCH,    /* an open contact closes                                  */
    AOI_EVENT_OPEN,     /* the indentation falls to rest                           */
    AOI_EVENT_SLACKEN,  /* the force falls to zero before that                     */
    AOI_EVENT_TIGHTEN,  /* and comes back                                          */
    AOI_EVENT_TURN,     /* the indentation stops growing, under a law that remembers */
    AOI_EVENT_ABOVE,    /* it leaves the law's piece                               */
    AOI_EVENT_BELOW
};

/* One try at a step. */
typedef struct aoi_attempt {
    double h, growth; /* by which it could be longer; below 1 it has failed */
    double place;     /* of its first event, as a share of h; 1 at its end, above 1: none */
    int closed;       /* a contact had to be closed at the start: prepare again */
} aoi_attempt;

/* The time now. */
double aoi_run_now(const aoi_adaptive *run);

/* How far below its level a quantity of that scale may be where its event happens. */
double aoi_event_tolerance(const aoi_adaptive *run, double scale);

/* The first level from this one on that is taken. Where forces may run away from a smooth indentation, and
 * a body rings, errors are known only roughly: whole octaves leave a margin. */
static inline int aoi_level_from(const aoi_adaptive *run, double level)
{
    const double least = level < AOI_DEEPEST_LEVEL ? level : AOI_DEEPEST_LEVEL; /* NaN is the deepest */
    return run->grain * (int)ceil(fmax(least, AOI_HIGHEST_LEVEL) / run->grain);
}

/* Lists the contacts of the step that begins now and brings their bodies here. */
void aoi_step_prepare(aoi_adaptive *run);

/* The step's bodies and contacts are none any more: open ones move freely again. */
void aoi_step_release(aoi_adaptive *run);

/* Whether an event so long after the start of a step of length h happens at its start. */
int aoi_is_at_start(const aoi_adaptive *run, double after, double h);

/* Tries a step of length h, of that level (AOI_NO_LEVEL: of no level). */
void aoi_step_try(aoi_adaptive *run, double h, int level, aoi_attempt *attempt);

/* Writes its row and takes bodies and contacts to its end, where its events happen. */
int aoi_step_accept(aoi_adaptive *run, const aoi_attempt *attempt, double *row, size_t *size);

/* Writes the row of bodies that move freely from now on; entry_count contacts of the step, 0 for none. */
size_t aoi_step_write(aoi_adaptive *run, double h, size_t contacts, double *row);

/* What contact forces take from a contact's indentation now by the residual compliances, m; with rates, from
 * its rate, as they went on so far, m/s. */
double aoi_contact_bent(const aoi_adaptive *run, size_t c, int rates);

/* A contact's indentation now, by the places of its bodies and the forces that bend them. */
double aoi_contact_place(const aoi_adaptive *run, size_t c);

/* Takes note of a contact's force now, which may be its largest. */
void aoi_contact_note_peak(aoi_adaptive *run, size_t c);

/* Finds indentations at the start, and with them forces of contacts at places without mass: where the bodies rest
 * under loads and contacts, or where laws of the rate let them be at once when the loads set in. Errors as
 * aoi_coupled_solve. */
int aoi_balance_at_start(aoi_adaptive *run);

/* Finds places, rates and forces of such contacts after something has happened to one of them, or leaves all as it
 * is. One that has only just touched opens again where the others draw it away. snaps: a place snaps back, as one that
 * was pulled is let go; only places and forces are found, and those of the step that it meets close. */
void aoi_balance_at_once(aoi_adaptive *run, int snaps);

/* The energy in residual compliances and in the laws of contacts at them, J; the work on each of these contacts
 * takes note of its law's share: with sign -1 before something happens at once, with 1 after it. */
double aoi_balance_book(aoi_adaptive *run, double sign);

/* Whether one of the events up to a place in the step tried is the end of a pull at a place without mass, which
 * snaps back. */
int aoi_step_snaps(const aoi_adaptive *run, double place);

/* Lets the events up to a place at the very start of the step tried happen; 0 where that would go on for
 * ever: take a shorter step. */
int aoi_step_at_start(aoi_adaptive *run, double place);

/* In what time the only closed contact will let go, if its force goes on as a power of the indentation and
 * nothing else happens; infinite where it does not move out, or not within the time given. */
double aoi_release_after(const aoi_adaptive *run, double within);

/* The length of the next step, at most h: shorter where the only contact is about to let go, so that the
 * last step ends there and is no longer than such a step may be. */
double aoi_release_step(const aoi_adaptive *run, double h);

/* Closes a contact where its bodies are now. */
void aoi_contact_close(aoi_adaptive *run, size_t c);

/* Strikes it off the closed ones. */
void aoi_contact_open(aoi_adaptive *run, size_t c);

/* Books work and losses of a body that has moved freely to a time and a state. */
void aoi_body_account(aoi_adaptive *run, size_t b, double time, const double *x, const double *v);

/* Lists a body among those that go into the next row. */
void aoi_body_note_change(aoi_adaptive *run, size_t b);

/* Brings a body here; how: as aoi_adaptive_body.engaged. */
void aoi_body_engage(aoi_adaptive *run, size_t b, int how);

/* The two bodies of a contact, at the time now, in place. */
void aoi_pair_now(const aoi_adaptive *run, size_t c, aoi_free_pair *pair);

/* Nothing is watched yet. */
void aoi_watch_begin(aoi_adaptive *run);

/* Watches an open contact, if it is not watched yet, by its free_until and touches, which are not to change
 * until it is removed. */
void aoi_watch_add(aoi_adaptive *run, size_t c);

int aoi_watch_has(const aoi_adaptive *run, size_t c);

/* Returns whether it was watched. */
int aoi_watch_remove(aoi_adaptive *run, size_t c);

/* The first time before limit of those watched that touch, or that do not; whose. limit and contact_count
 * where there is none. */
double aoi_watch_first(const aoi_adaptive *run, int touches, double limit, size_t *c);

#endif
