/* Private to adaptive/: declarations that run.c (which step comes next), closing.c, release.c, watch.c and the files
 * of one step share. Declarations for the files of one step alone are in step.h. */
#ifndef AOI_ADAPTIVE_H
#define AOI_ADAPTIVE_H

#include "law/law.h"
#include "model/coupled.h"
#include "motion/free.h"
#include "motion/response.h"
#include "collocation/collocation.h"
#include "collocation/sliding.h"

#include <math.h>

/* Number of step lengths whose tables a body keeps. */
enum { AOI_TABLES = 12 };

/* Role of a body in a step: free motion, a watched contact, or contact forces. The largest of its roles prevails. */
enum aoi_part { AOI_FREE_MOTION = 0, AOI_WATCHED, AOI_UNDER_FORCE };

/* State of a body in a run: the time at which x, v hold, and the tables of the last step lengths. */
typedef struct aoi_adaptive_body {
    double time;
    int engaged; /* its aoi_part in this step */
    int changed; /* 1: its state has changed since its last row */
    double work, dissipated;
    aoi_columns columns; /* columns of its tables */
    double *block;
    size_t table_count, table_size;
    aoi_response table[AOI_TABLES];
    int table_level[AOI_TABLES];
    size_t table_use[AOI_TABLES];
} aoi_adaptive_body;

/* State of an open contact. until: time before which both bodies are in free motion and do not touch. */
typedef struct aoi_flight {
    double until;
    int touches;  /* 1: the contact touches at `until` */
    size_t place; /* its place among the watched contacts */
    double slack; /* indentation beyond rest up to which there is no touch, m */
} aoi_flight;

/* State of a closed contact at the present time: its indentation (start: that at the start of the next step), rate
 * and force, and the piece of its law that it is on. */
typedef struct aoi_closed {
    double start, rate, force;
    double touch_rate; /* the rate when its force last began, before a sudden change of it, m/s */
    int begins, piece;
    double low, high; /* ends of the piece */
    double edge;      /* step length that the error of its first step allows, used at its end; 0: not known */
    double last_length, last[AOI_NODES + 1]; /* the last step's indentation, to guess the next */
} aoi_closed;

/* Scales of a contact. indentation, rate, impulse: largest values so far, estimated at first. force: largest of the
 * estimates that are made at each touch, before any step, N. */
typedef struct aoi_scales {
    double indentation, rate, impulse, force;
    double mobility; /* relative acceleration of both ports per sudden force, 1/kg */
} aoi_scales;

/* Totals of a contact in the run. since_touch: impulse since its last touch, N s; work: work of its force, J. */
typedef struct aoi_ledger {
    aoi_peak peak;
    double since_touch, work;
} aoi_ledger;

/* Force on a residual compliance. bending: force included in the deflection, N; force_rate: rate of the force at the
 * end of the last step, N/s. */
typedef struct aoi_massless {
    double bending, force_rate;
} aoi_massless;

/* A contact in a run. */
typedef struct aoi_adaptive_contact {
    int is_closed;
    aoi_flight flight;
    aoi_closed closed;
    aoi_scales scales;
    aoi_ledger ledger;
    aoi_massless massless;
    double memory[AOI_LAW_MEMORY];
    int event; /* its first event in the step being tried, and where */
    double event_place;
    aoi_sliding *sliding; /* NULL: without friction */
} aoi_adaptive_contact;

/* A list of numbers of bodies or contacts. */
typedef struct aoi_list {
    size_t count, *at;
} aoi_list;

/* A run. The cost of a step depends only on the bodies that take part in it. */
struct aoi_adaptive {
    const aoi_system *system;
    double rtol, time, end;
    int rested; /* 1: the bodies start at rest under loads and contacts; 0: loads and contacts begin at time */
    double *x, *v; /* coordinates and rates of all bodies */
    aoi_adaptive_body *body;
    aoi_adaptive_contact *contact;
    aoi_contact_step *entry;
    aoi_response *response;
    aoi_sliding *sliding; /* friction of the contacts that have it, and their springs */
    aoi_stretch *spring;
    aoi_contact_state *balanced; /* contacts at massless contact points, while their forces are found */

    aoi_list closed;     /* closed contacts, ascending                                    */
    aoi_list watched[2]; /* open contacts in free motion: [0] no touch found yet, [1] touch found */
    aoi_list engaged, changed; /* bodies in this step; bodies changed since their last row */
    size_t span, row_size;
    int crowded; /* 1: contacts are solved by modes (crowd.c) */
    /* numbers of entries: closed_count of the closed contacts, which come first; entry_count of all contacts */
    size_t closed_count, entry_count;
    int level;                        /* steps are base 2^(-level/8) long */
    int grain;                        /* levels are multiples of this */
    /* table_cost: cost of new tables in steps, one per mode; saved: number of steps that a coarser level would have
     * saved */
    double table_cost, saved;
    double base;
    double indentation_scale, impulse_scale; /* largest scales of closed contacts */
    double force_scale; /* largest force in the step tried, where more than one contact is closed; else 0 */
    double origin, elapsed; /* time is their sum, so that short steps late in a run are not rounded away */
    double left_off;        /* rounding error of elapsed, s */
    double horizon;         /* no touch between bodies in free motion before this time */
    /* time of the next halt, at which all bodies are advanced, so that no advance spans more than a
     * limited number of bends of the loads (AOI_MOST_BENDS); HUGE_VAL: none */
    double halt;
    int unbalanced;         /* 1: an event has changed a contact since the last step */
    double *free_state[2], *scratch, *port_force, *collocation;
    double *port_series; /* Legendre series of the port forces */
    size_t steps, rejected, uses;
    size_t failed; /* contact in which an error occurred */
};

/* Steps are base 2^(-level/8) long. */
enum {
    AOI_LEVELS = 8, /* levels per octave */
    AOI_DEEPEST_LEVEL = 90 * AOI_LEVELS,
    AOI_HIGHEST_LEVEL = -40 * AOI_LEVELS,
    AOI_NO_LEVEL = 1000
};

/* Error of the rates found, relative to the largest rate. It is also the tolerance of Newton's method for these
 * rates, in which laws are nearly linear, and of the last change of the forces in equilibrium: the error that
 * remains is the square of this change. Measured: from 3e-9 to 3e-8 errors and work are the same. At a start from
 * rest, a jump of the force by this share of the largest force may be such an error. */
#define AOI_RATE_ERROR 1e-8

/* Largest growth of the step length after an accepted step. Measured: 3 costs 0.4 % more work, 24 saves none. */
#define AOI_MOST_GROWTH 8.0

/* AOI_MOST_LOOKS: largest number of evaluations of a mode in one search for a touch, which takes less than a tenth
 * of a second: an evaluation takes up to 0.7 us in bodies of few modes. AOI_LOOKS_IN_STEP: the same for a search
 * within a step, which may be shortened instead. */
enum { AOI_MOST_LOOKS = 100000, AOI_LOOKS_IN_STEP = 10000 };

/* Largest number of evaluations of a mode from one halt to the next, which take some hundredths of a second: the
 * loads are looked up in each, and the bodies are advanced once more at the halt. It limits the time between checks
 * for signals and does not affect the results. Tried: no run changes. */
enum { AOI_MOST_BENDS = 30000 };

/* Largest distance of an event from the start of a step, as a share of its length, at which the event is applied at
 * the start. Measured: from 3e-10 to 3e-9 errors and work are the same. */
#define AOI_AT_START 1e-9

/* Events of a contact within a step. */
enum aoi_event {
    AOI_EVENT_NONE = 0,
    AOI_EVENT_TOUCH,    /* an open contact closes                                  */
    AOI_EVENT_OPEN,     /* the indentation falls to rest                           */
    AOI_EVENT_SLACKEN,  /* the force falls to zero before the indentation does     */
    AOI_EVENT_TIGHTEN,  /* the force of a slack contact rises above zero           */
    AOI_EVENT_TURN,     /* the indentation stops growing, under a law that remembers */
    AOI_EVENT_ABOVE,    /* the indentation leaves the law's piece upwards, or downwards */
    AOI_EVENT_BELOW
};

/* One try at a step. */
typedef struct aoi_attempt {
    double h, growth; /* length, s; factor by which its error allows it to be longer: below 1 if it fails */
    double place;     /* place of its first event, as a share of h; 1: at the end; above 1: no event */
    int closed;       /* 1: a contact was closed at its start, and the step must be prepared again */
    int corner;       /* 1: the step is to end at `place`, a corner of friction                    */
} aoi_attempt;

/* The present time, s. */
double aoi_run_now(const aoi_adaptive *run);

/* Number of the entries of the closed contacts. */
size_t aoi_run_forces(const aoi_adaptive *run);

/* The length of a step of the run's level, s. */
double aoi_run_step(const aoi_adaptive *run);

/* Tolerance of a function's value at an event; scale: size of the function. */
double aoi_event_tolerance(const aoi_adaptive *run, double scale);

/* The first admissible level from this one on. Where a force may change faster than the indentation and a body has
 * oscillating modes, error estimates are rough, and steps change by whole octaves. */
static inline int aoi_level_from(const aoi_adaptive *run, double level)
{
    /* if level is NaN, the deepest level is used */
    const double least = level < AOI_DEEPEST_LEVEL ? level : AOI_DEEPEST_LEVEL;
    return run->grain * (int)ceil(fmax(least, AOI_HIGHEST_LEVEL) / run->grain);
}

/* Lists the contacts of the step that begins now, and advances their bodies to the present time. */
void aoi_step_prepare(aoi_adaptive *run);

/* Number of doubles of work space for the forces in equilibrium of `count` contacts at massless contact points.
 * Contacts that share a body are at most `span` places apart in the list. */
size_t aoi_balance_size(size_t count, size_t span);

/* Empties the lists of the step's bodies and contacts; its open contacts are watched again. */
void aoi_step_release(aoi_adaptive *run);

/* True if an event at a time `after` the start of a step of length h counts as one at its start. */
int aoi_is_at_start(const aoi_adaptive *run, double after, double h);

/* Computes a step of length h without accepting it; level as in aoi_adaptive, or AOI_NO_LEVEL. */
void aoi_step_try(aoi_adaptive *run, double h, int level, aoi_attempt *attempt);

/* Writes the step's row, advances bodies and contacts to the step's end and applies the events there. */
int aoi_step_accept(aoi_adaptive *run, const aoi_attempt *attempt, double *row, size_t *size);

/* Writes a row: of a step of length h, or of bodies that move freely from now on. contacts: number of entries of the
 * step, 0 for free motion; of: set to the first contact in the row. Returns the row's size. */
size_t aoi_step_write(aoi_adaptive *run, double h, size_t contacts, double *row, double **of);

/* Reduction of a contact's indentation due to the contact forces on residual compliances, m. With rates: reduction
 * of its rate due to the force rates at the end of the last step, m/s. */
double aoi_contact_bent(const aoi_adaptive *run, size_t c, int rates);

/* Present indentation of a contact without the deflection under contact forces, m, and its rate, m/s. */
double aoi_contact_free(const aoi_adaptive *run, size_t c, double *rate);

/* A contact's indentation now, including the deflection of residual compliances, m. */
double aoi_contact_place(const aoi_adaptive *run, size_t c);

/* The slide of the ports of a contact along a tangent now, m. */
double aoi_contact_slide(const aoi_adaptive *run, size_t c, size_t axis);

/* Updates a contact's largest force with its force, N, at a time `after` from now, s. */
void aoi_contact_note_peak(aoi_adaptive *run, size_t c, double force, double after);

/* Finds the indentations at the start, and the forces of contacts at massless contact points. Either the bodies rest
 * under loads and contacts, or the loads begin suddenly and dashpots keep the indentations unchanged. Errors as
 * aoi_coupled_solve. */
int aoi_balance_at_start(aoi_adaptive *run);

/* Finds indentations, rates and forces of contacts at massless contact points after an event of one of them; if none
 * are found, all stay unchanged. A contact that has just touched opens again if other contacts separate its bodies.
 * pull_off: an adhesive contact has let go, and its massless contact point jumps back. Then only indentations and
 * forces are found, and the step's contacts that the point reaches are closed. */
void aoi_balance_at_once(aoi_adaptive *run, int pull_off);

/* The energy in residual compliances and in the laws of contacts at them, J. Adds sign times its law's energy to the
 * work on each of these contacts: sign is -1 before a sudden change, 1 after it. */
double aoi_balance_book(aoi_adaptive *run, double sign);

/* True if one of the events up to a place in the step tried is a pull-off at a massless contact point: the contact
 * ends under tension, and the point jumps back. */
int aoi_step_pulls_off(const aoi_adaptive *run, double place);

/* Applies the events of the step tried whose place is at most `place`, which is at its start. Returns 0 where applying
 * them would repeat without end: take a shorter step. */
int aoi_step_at_start(aoi_adaptive *run, double place);

/* Time until the only closed contact separates, if its force follows a power of the indentation and no other contact
 * closes; infinite where it does not separate, or not within the time given. */
double aoi_release_after(const aoi_adaptive *run, double within);

/* The length of the next step, at most h. Where the only contact is about to separate it is shorter, so that the last
 * step ends at separation and is no longer than the error at an edge allows. */
double aoi_release_step(const aoi_adaptive *run, double h);

/* Closes a contact at the present places of its bodies. */
void aoi_contact_close(aoi_adaptive *run, size_t c);

/* Sets the piece of its law that a contact is on, at an indentation. aoi_contact_press_again: also
 * that the force of a slack contact begins again. */
void aoi_contact_take_piece(const aoi_law *law, aoi_adaptive_contact *contact, double indentation, int rising);
void aoi_contact_press_again(const aoi_law *law, aoi_adaptive_contact *contact);

/* Opens a closed contact, without a prediction of its next touch. */
void aoi_contact_open(aoi_adaptive *run, size_t c);

/* Adds a body to the list of bodies that the next row contains. */
void aoi_body_note_change(aoi_adaptive *run, size_t b);

/* aoi_body_copy: copies the state of a body, x, then v. aoi_body_take: sets a body to a state that holds at present. */
void aoi_body_copy(const aoi_adaptive *run, size_t b, double *state);
void aoi_body_take(aoi_adaptive *run, size_t b, const double *state);

/* Advances a body in free motion to the present time. */
void aoi_body_bring(aoi_adaptive *run, size_t b);

/* Advances a body to the present time as a part of the step; how: an aoi_part. */
void aoi_body_engage(aoi_adaptive *run, size_t b, int how);

/* The two bodies of a contact at the present time; x, v point into the run. */
void aoi_pair_now(const aoi_adaptive *run, size_t c, aoi_free_pair *pair);

/* Empties the lists of watched contacts. */
void aoi_watch_begin(aoi_adaptive *run);

/* Adds an open contact to the watched ones, if it is not there yet. Its flight.until and touches
 * must not change until it is removed. */
void aoi_watch_add(aoi_adaptive *run, size_t c);

int aoi_watch_has(const aoi_adaptive *run, size_t c);

/* Removes a contact from the watched ones; returns whether it was watched. */
int aoi_watch_remove(aoi_adaptive *run, size_t c);

/* Least flight.until before `limit` of the watched contacts that touch (touches = 1) or do not (0). c: number of
 * that contact. Without such a contact, limit is returned and c is contact_count. */
double aoi_watch_first(const aoi_adaptive *run, int touches, double limit, size_t *c);

#endif
