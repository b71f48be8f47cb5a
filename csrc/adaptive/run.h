/* Private to adaptive/: what run.c (which step comes next), closing.c, release.c, watch.c and the files
 * of one step share; step.h has what those share among themselves. */
#ifndef AOI_ADAPTIVE_H
#define AOI_ADAPTIVE_H

#include "adaptive/adaptive.h"
#include "motion/flight.h"

#include <math.h>

/* Steps are base 2^(-level/8) long. */
enum {
    AOI_LEVELS = 8, /* an octave */
    AOI_DEEPEST_LEVEL = 90 * AOI_LEVELS,
    AOI_HIGHEST_LEVEL = -40 * AOI_LEVELS,
    AOI_NO_LEVEL = 1000
};

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

/* The step's bodies and contacts are none any more: open ones fly again. */
void aoi_step_release(aoi_adaptive *run);

/* Whether an event so long after the start of a step of length h happens at its start. */
int aoi_is_at_start(const aoi_adaptive *run, double after, double h);

/* Tries a step of length h, of that level (AOI_NO_LEVEL: of no level). */
void aoi_step_try(aoi_adaptive *run, double h, int level, aoi_attempt *attempt);

/* Writes its row and takes bodies and contacts to its end, where its events happen. */
int aoi_step_accept(aoi_adaptive *run, const aoi_attempt *attempt, double *row, size_t *size);

/* Writes the row of bodies that fly from now on; stage_count contacts of the step, 0 for none. */
size_t aoi_step_write(aoi_adaptive *run, double h, size_t contacts, double *row);

/* What contact forces take from a contact's indentation now by the residual compliances, m; with rates, from
 * its rate, as they went on so far, m/s. */
double aoi_contact_bent(const aoi_adaptive *run, size_t joint, int rates);

/* A contact's indentation now, by the places of its bodies and the forces that bend them. */
double aoi_contact_place(const aoi_adaptive *run, size_t joint);

/* Takes note of a contact's force now, which may be its largest. */
void aoi_contact_note_peak(aoi_adaptive *run, size_t joint);

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
void aoi_contact_close(aoi_adaptive *run, size_t joint);

/* Strikes it off the closed ones. */
void aoi_contact_open(aoi_adaptive *run, size_t joint);

/* Whether forces move any mode of a body. */
int aoi_body_yields(const aoi_modes *body);

/* Books work and losses of a body that has flown to a time and a state. */
void aoi_body_account(aoi_adaptive *run, size_t b, double time, const double *x, const double *v);

/* Lists a body among those that go into the next row. */
void aoi_body_note_change(aoi_adaptive *run, size_t b);

/* Brings a body here; how: as aoi_follower.engaged. */
void aoi_body_engage(aoi_adaptive *run, size_t b, int how);

/* The two bodies of a joint, at the time now, in place. */
void aoi_pair_now(const aoi_adaptive *run, size_t joint, aoi_flight *pair);

/* Nothing is watched yet. */
void aoi_watch_begin(aoi_adaptive *run);

/* Watches an open contact, if it is not watched yet, by its free_until and touches, which are not to change
 * until it is removed. */
void aoi_watch_add(aoi_adaptive *run, size_t joint);

int aoi_watch_has(const aoi_adaptive *run, size_t joint);

/* Returns whether it was watched. */
int aoi_watch_remove(aoi_adaptive *run, size_t joint);

/* The first time before limit of those watched that touch, or that do not; whose. limit and joint_count
 * where there is none. */
double aoi_watch_first(const aoi_adaptive *run, int touches, double limit, size_t *joint);

#endif
