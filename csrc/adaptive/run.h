/* Private to adaptive/: declarations shared by run.c (which chooses the next step), closing.c, release.c, watch.c
 * and the files that compute a step. Declarations for these last files alone are in step.h. */
#ifndef AOI_ADAPTIVE_H
#define AOI_ADAPTIVE_H

#include "law/law.h"
#include "model/coupled.h"
#include "motion/free.h"
#include "motion/response.h"
#include "collocation/collocation.h"
#include "collocation/sliding.h"

#include <math.h>

/* Number of step lengths for which a body keeps tables of responses. */
enum { AOI_TABLES = 12 };

/* Role of a body in a step: it moves freely, or one of its contacts is watched for a touch, or contact forces act
 * on it. The largest of its roles prevails. */
enum aoi_part { AOI_FREE_MOTION = 0, AOI_WATCHED, AOI_UNDER_FORCE };

/* State of a body in a run. time: at which its x and v hold, s; work, dissipated: work of loads and gravity, and
 * energy dissipated by damping, up to that time, J; table, table_level, table_use: responses for the last step
 * lengths, the levels of these lengths, and when each table was last used. */
typedef struct aoi_adaptive_body {
    double time;
    int engaged; /* role in this step, an aoi_part */
    int changed; /* 1: its state has changed since its last row */
    double work, dissipated;
    aoi_columns columns; /* the ports for which the tables have columns */
    double *block;
    size_t table_count, table_size;
    aoi_response table[AOI_TABLES];
    int table_level[AOI_TABLES];
    size_t table_use[AOI_TABLES];
} aoi_adaptive_body;

/* State of an open contact. until: time up to which both bodies move freely without touching. */
typedef struct aoi_flight {
    double until;
    int touches;  /* 1: the contact touches at `until` */
    size_t place; /* index among the watched contacts     */
    double slack; /* indentation beyond rest below which the contact stays open, m */
} aoi_flight;

/* State of a closed contact at the present time. start: indentation, at which the next step starts, m; rate,
 * force: m/s and N; piece: the piece of its law that applies. */
typedef struct aoi_closed {
    double start, rate, force;
    double touch_rate; /* rate at the last start of its force, before a sudden change of the rate, m/s */
    int begins, piece; /* begins: 1 if the force begins at the start of the next step */
    double low, high;  /* ends of the law's piece, m */
    /* largest length of the contact's last step, s, that the error of its first step allows; 0: not known */
    double edge;
    /* length and indentation polynomial of the last step, to guess the next */
    double last_length, last[AOI_NODES + 1];
} aoi_closed;

/* Scales of a contact. indentation, rate, impulse: largest values so far, initially estimates. force: largest of
 * the estimates made at each touch, before any step, N. */
typedef struct aoi_scales {
    double indentation, rate, impulse, force;
    double mobility; /* relative acceleration of both ports per contact force, 1/kg */
} aoi_scales;

/* Totals of a contact in the run. peak: largest force, its time, and the impulse of all touches; since_touch:
 * impulse since the last touch, N s; work: work of the contact force, J. */
typedef struct aoi_ledger {
    aoi_peak peak;
    double since_touch, work;
} aoi_ledger;

/* Force of a contact on residual compliances. bending: force whose deflection is included in the indentation, N;
 * force_rate: rate of the contact force at the end of the last step, N/s. */
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
    int event; /* kind of its first event in the step being tried, and the position of this event in the step */
    double event_place;
    aoi_sliding *sliding; /* NULL: without friction */
} aoi_adaptive_contact;

/* A list of indices of bodies or contacts. */
typedef struct aoi_list {
    size_t count, *at;
} aoi_list;

/* An adaptive run. The cost of a step depends only on the bodies that take part in that step. */
struct aoi_adaptive {
    const aoi_system *system;
    double rtol, time, end;
    int rested; /* 1: the bodies start at rest under loads and contacts; 0: loads and contacts set in at the start */
    double *x, *v; /* coordinates and rates of all bodies */
    aoi_adaptive_body *body;
    aoi_adaptive_contact *contact;
    aoi_contact_step *entry;
    aoi_response *response;
    aoi_sliding *sliding; /* state of friction of each contact with friction */
    aoi_stretch *spring;
    aoi_contact_state *balanced; /* contacts at massless contact points, listed while their forces are found */

    aoi_list closed;     /* indices of closed contacts, ascending                         */
    aoi_list watched[2]; /* open contacts in free motion: [0] no touch found so far, [1] touch found */
    aoi_list engaged, changed; /* bodies in this step; bodies changed since their last row */
    size_t span, row_size; /* aoi_system_span and aoi_adaptive_room */
    int crowded; /* 1: contact equations are solved in terms of the bodies' modes (crowd.c) */
    /* closed_count: number of entries of closed contacts, which come first; entry_count: number of entries of all
     * contacts in the step */
    size_t closed_count, entry_count;
    int level;                        /* level of the present step length, base 2^(-level/8) */
    int grain;                        /* admissible levels are multiples of this */
    /* table_cost: cost of new tables, in units of a step's cost; saved: number of steps that a coarser level would
     * have saved */
    double table_cost, saved;
    double base; /* step length of level 0, s; 0: not set */
    double indentation_scale, impulse_scale; /* largest indentation and impulse scales of the closed contacts */
    double force_scale; /* largest force of the closed contacts, so far or expected, N; 0 if only one is closed */
    double origin, elapsed; /* the time is their sum: short steps late in a run would otherwise be lost in rounding */
    double left_off;        /* rounding error of elapsed, s */
    double horizon;         /* time before which no bodies in free motion touch, s     */
    /* time of the next halt, at which all bodies are advanced, s; HUGE_VAL: none. Between halts the loads have a
     * limited number of bends (AOI_MOST_BENDS). */
    double halt;
    int unbalanced;         /* 1: an event has changed a contact since the last step */
    double *free_state[2], *scratch, *port_force, *collocation;
    double *port_series; /* Legendre series of the port forces */
    size_t steps, rejected, uses;
    size_t failed; /* index of the contact in which an error occurred */
};

/* Levels of step lengths, which are base 2^(-level/8). */
enum {
    AOI_LEVELS = 8, /* number of levels per factor of two */
    AOI_DEEPEST_LEVEL = 90 * AOI_LEVELS,
    AOI_HIGHEST_LEVEL = -40 * AOI_LEVELS,
    AOI_NO_LEVEL = 1000
};

/* Relative error of the rates found after a sudden change. This is also the tolerance of Newton's method for these
 * rates, and for the last change of the forces in equilibrium: the error of the forces that remains is the square
 * of that change, since laws are nearly linear there. Measured: from 3e-9 to 3e-8 errors and work are the same. At
 * a start from rest, a jump of the force by this share of the largest force may come from this error. */
#define AOI_RATE_ERROR 1e-8

/* Largest factor by which the step length grows after an accepted step. Measured: 3 costs 0.4 % more work, 24
 * saves none. */
#define AOI_MOST_GROWTH 8.0

/* AOI_MOST_LOOKS: largest number of evaluations of a mode in one search for a touch. At up to 0.7 us each in
 * bodies of few modes, a search takes less than a tenth of a second. AOI_LOOKS_IN_STEP: the same for a search
 * within a step, which may be shortened instead. */
enum { AOI_MOST_LOOKS = 100000, AOI_LOOKS_IN_STEP = 10000 };

/* Largest number of evaluations of a mode from one halt to the next, which take some hundredths of a second: each
 * evaluation looks up the loads, and a halt advances all bodies once more. This limits the time between checks for
 * signals and does not affect the results. Tried with a third and three times the value: no run changes. */
enum { AOI_MOST_BENDS = 30000 };

/* An event closer than this to the start of a step, as a share of the step, is applied at the start. Measured:
 * from 3e-10 to 3e-9 errors and work are the same. */
#define AOI_AT_START 1e-9

/* Events of a contact within a step. */
enum aoi_event {
    AOI_EVENT_NONE = 0,
    AOI_EVENT_TOUCH,    /* an open contact closes                                  */
    AOI_EVENT_OPEN,     /* the indentation falls to rest, where the force vanishes */
    AOI_EVENT_SLACKEN,  /* the force falls to zero while the bodies still overlap  */
    AOI_EVENT_TIGHTEN,  /* the force of a slack contact rises above zero           */
    AOI_EVENT_TURN,     /* the indentation stops growing, under a law that unloads differently */
    AOI_EVENT_ABOVE,    /* the indentation rises above the end of the law's piece; BELOW: it falls below its start */
    AOI_EVENT_BELOW
};

/* One trial of a step. */
typedef struct aoi_attempt {
    /* length, s; factor by which the error allows the step to be longer (below 1: the step is rejected) */
    double h, growth;
    double place;     /* position of the first event, as a share of h; 1: at the end; above 1: no event */
    int closed;       /* 1: a contact was closed at the step's start, so that the step must be prepared again */
    int corner;       /* 1: the step must end at `place`, where slip begins or ends                */
} aoi_attempt;

/* Returns the present time, s. */
double aoi_run_now(const aoi_adaptive *run);

/* Returns the number of forces of the closed contacts: one each, or three with friction. */
size_t aoi_run_forces(const aoi_adaptive *run);

/* Returns the step length of the run's present level, s. */
double aoi_run_step(const aoi_adaptive *run);

/* Returns the tolerance of a function whose change of sign is an event. scale: size of that function. */
double aoi_event_tolerance(const aoi_adaptive *run, double scale);

/* Returns the first admissible level from the given one on. If a force may change faster than the indentation and
 * a body has oscillating modes, error estimates are rough: then levels change by whole octaves (factors of two in
 * length). */
static inline int aoi_level_from(const aoi_adaptive *run, double level)
{
    /* if level is NaN, the deepest level is used */
    const double least = level < AOI_DEEPEST_LEVEL ? level : AOI_DEEPEST_LEVEL;
    return run->grain * (int)ceil(fmax(least, AOI_HIGHEST_LEVEL) / run->grain);
}

/* Lists the contacts and bodies that take part in the step that begins now, and advances these bodies to the
 * present time. */
void aoi_step_prepare(aoi_adaptive *run);

/* Returns the size of the work space, in doubles, for the forces in equilibrium of `count` contacts at massless
 * contact points. span: largest distance in the list between two contacts of one body. */
size_t aoi_balance_size(size_t count, size_t span);

/* Empties the lists of the step's bodies and contacts. The open contacts of the step are watched again. */
void aoi_step_release(aoi_adaptive *run);

/* True if an event at a time `after` the start of a step of length h counts as an event at the start. */
int aoi_is_at_start(const aoi_adaptive *run, double after, double h);

/* Computes a step of length h without accepting it. level: level of h, or AOI_NO_LEVEL; attempt: set to the
 * result. */
void aoi_step_try(aoi_adaptive *run, double h, int level, aoi_attempt *attempt);

/* Writes the step's row, advances bodies and contacts to the step's end and applies the events there. */
int aoi_step_accept(aoi_adaptive *run, const aoi_attempt *attempt, double *row, size_t *size);

/* Writes a row: of a step of length h, or (contacts = 0) of bodies that move freely from now on. contacts: number
 * of entries of closed contacts; of: set to the first contact in the row. Returns the row's size, in doubles. */
size_t aoi_step_write(aoi_adaptive *run, double h, size_t contacts, double *row, double **of);

/* Returns the reduction of a contact's indentation due to the deflection of residual compliances under all contact
 * forces, m. rates = 1: the same for the rate, with the force rates at the end of the last step, m/s. */
double aoi_contact_bent(const aoi_adaptive *run, size_t c, int rates);

/* Returns the present indentation of a contact without the deflection of residual compliances under contact
 * forces, m, and sets `rate` to its rate, m/s. */
double aoi_contact_free(const aoi_adaptive *run, size_t c, double *rate);

/* Returns the present indentation of a contact, including the deflection of residual compliances, m. */
double aoi_contact_place(const aoi_adaptive *run, size_t c);

/* Returns the present slide between the bodies of a contact along a tangent (axis 1 or 2), m. */
double aoi_contact_slide(const aoi_adaptive *run, size_t c, size_t axis);

/* Raises a contact's recorded peak to the force, N, at a time `after` from now, s, if that force is larger. */
void aoi_contact_note_peak(aoi_adaptive *run, size_t c, double force, double after);

/* Finds the indentations at the start of a run, and the forces of contacts at massless contact points. Either the
 * bodies rest under loads and contacts, or the loads begin suddenly and dashpots keep the indentations unchanged.
 * Errors as for aoi_coupled_solve. */
int aoi_balance_at_start(aoi_adaptive *run);

/* Finds indentations, rates and forces of contacts at massless contact points after an event of one of them; if
 * the search fails, all stay unchanged. A contact that has just touched opens again if other contacts separate its
 * bodies. pull_off = 1: an adhesive contact has let go, and its massless contact point jumps back; then only
 * indentations and forces are found, and contacts that the point reaches are closed. */
void aoi_balance_at_once(aoi_adaptive *run, int pull_off);

/* Returns the energy in residual compliances and in the laws of contacts at them, J. For each of these contacts,
 * sign times the energy of its law is added to its work: sign is -1 before a sudden change, 1 after it. */
double aoi_balance_book(aoi_adaptive *run, double sign);

/* True if one of the events up to a position in the trial step is a pull-off at a massless contact point: an
 * adhesive contact ends under tension, and the point jumps back. */
int aoi_step_pulls_off(const aoi_adaptive *run, double place);

/* Applies the events of the trial step up to position `place`, which counts as its start. Returns 0 if no event
 * was applied, or if applying one would repeat without end: a shorter step is then needed. */
int aoi_step_at_start(aoi_adaptive *run, double place);

/* Returns the time until the only closed contact separates, s, for a force that follows a power of the
 * indentation. The result is infinite if several contacts are closed, or if the contact does not separate within
 * the given time. */
double aoi_release_after(const aoi_adaptive *run, double within);

/* Returns the length of the next step, s, at most h. If the only closed contact is about to separate, the length
 * is reduced so that the last step ends at separation and is short enough for the error of a step in which a force
 * ends. */
double aoi_release_step(const aoi_adaptive *run, double h);

/* Closes a contact in the present state of its bodies. */
void aoi_contact_close(aoi_adaptive *run, size_t c);

/* Set the piece of its law that a contact is on. aoi_contact_take_piece: at a given indentation.
 * aoi_contact_press_again: at the present indentation, where the force of a slack contact begins again. */
void aoi_contact_take_piece(const aoi_law *law, aoi_adaptive_contact *contact, double indentation, int rising);
void aoi_contact_press_again(const aoi_law *law, aoi_adaptive_contact *contact);

/* Opens a closed contact, without a prediction of its next touch. */
void aoi_contact_open(aoi_adaptive *run, size_t c);

/* Adds a body to the list of bodies that the next row will contain. */
void aoi_body_note_change(aoi_adaptive *run, size_t b);

/* aoi_body_copy: copies the x, then the v of a body to `state`. aoi_body_take: sets a body to a state at the
 * present time. */
void aoi_body_copy(const aoi_adaptive *run, size_t b, double *state);
void aoi_body_take(aoi_adaptive *run, size_t b, const double *state);

/* Advances a body in free motion to the present time. */
void aoi_body_bring(aoi_adaptive *run, size_t b);

/* Advances a body to the present time and gives it a role in the step; how: an aoi_part. */
void aoi_body_engage(aoi_adaptive *run, size_t b, int how);

/* Sets `pair` to the two bodies of a contact at the present time; its x and v point into the run. */
void aoi_pair_now(const aoi_adaptive *run, size_t c, aoi_free_pair *pair);

/* Empties the lists of watched contacts. */
void aoi_watch_begin(aoi_adaptive *run);

/* Adds an open contact to the watched contacts unless it is among them. Its flight.until and flight.touches must
 * not change until it is removed. */
void aoi_watch_add(aoi_adaptive *run, size_t c);

int aoi_watch_has(const aoi_adaptive *run, size_t c);

/* Removes a contact from the watched contacts. Returns whether it was among them. */
int aoi_watch_remove(aoi_adaptive *run, size_t c);

/* Returns the least flight.until before `limit` of the watched contacts that touch (touches = 1) or do not touch
 * (0), s. c: set to the index of that contact. If there is none, limit is returned and c is contact_count. */
double aoi_watch_first(const aoi_adaptive *run, int touches, double limit, size_t *c);

#endif
