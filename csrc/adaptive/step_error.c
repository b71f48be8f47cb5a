/* Whether a step meets the tolerance, and how long the next may be.
 *
 * Two errors are kept below rtol in each step. The tail of the indentation's Legendre series says how
 * well the polynomial follows the motion within the step, so the peak; the integrated defect of the
 * force between the nodes says what the step hands on, so impulse, velocities and later times. Radau
 * nodes make the second far smaller than the first, except at the beginning and end of a contact,
 * where the force starts like d^(3/2). Both are samples, which modes that turn many times in the step may
 * fool; what these make of the force is bounded in step_ring.c, and is kept below rtol, too. */
#include "adaptive/run.h"
#include "adaptive/step.h"
#include "linear/vector.h"
#include "law/law.h"
#include "motion/modes.h"
#include "motion/radau.h"
#include "motion/nodes.h"
#include "collocation/collocation.h"

#include <float.h>
#include <math.h>

/* Shares of rtol: of the polynomial's tail, and of what one step may hand on. Errors add up over some
 * twenty steps of a contact, and grow from one contact to the next. */
static const double TAIL_SHARE = 0.3, STEP_SHARE = 0.1;

/* At the ends of a contact the force is no smooth function of time, and the quadrature of its defect
 * misses part of it. */
static const double END_SHARE = 0.03;

/* Times no farther apart than so many roundings of the record's end are the same. */
static const double ROUNDINGS = 16.0;

/* A step is not tried at more than 1/0.9 of the length that its error allows. */
static const double CAUTION = 0.9;

/* Where a law that may not pull has let go of bodies that still overlap, steps grow, but not by leaps. */
static const double SLACK_GROWTH = 2.0;

/* Beside an edge a step may be so much longer than the one with it; and how much longer than that one,
 * if its error says so, the other edge's may be. */
static const double EDGE_GROWTH = 2.0, EDGE_REACH = 1.4;

/* A force that grows like t^(1/4) from the start is so much of its last value at the node before. */
static const double NEAR_TOP = 0.99;

/* By how much more of the force an error of the indentation makes under this law than under Hertz's. */
static double steepness_of(const aoi_adaptive *run, const aoi_contact_step *entry, double largest)
{
    aoi_law_value value;
    aoi_law_push(aoi_step_law(run, entry), entry->memory, largest, entry->start_rate, &value);
    /* Of the largest force: a small one at the end of a contact is not to be right to itself. */
    const double force = fmax(value.force, run->contact[entry->contact].peak_force);
    return force > 0.0 ? fmax(value.stiffness * largest / (1.5 * force), 1.0) : 1.0;
}

/* What the last coefficients of the force's polynomial hold. Under a law of the rate light contact masses
 * and stiff oscillators ring in the force long before they show in the indentation; a massless contact
 * follows its forces at once: they may run away from a smooth indentation, within the time that law and
 * compliance make together. */
static double force_tail(const aoi_contact_step *entry)
{
    double c[4];
    for (size_t k = 0; k < 4; k++) {
        c[k] = fabs(aoi_nodes_dot(aoi_radau_to_legendre[AOI_NODES - 1 - k], entry->force));
    }
    const double last = c[0] + 0.2 * c[1], before = c[2] + 0.2 * c[3];
    return last < before ? last * sqrt(last / before) : last;
}

/* What counts as large for its force, or what its impulse takes at the pace at which the bodies met. */
static double force_scale(const aoi_adaptive *run, const aoi_contact_step *entry, double impulse,
                          double indentation)
{
    return fmax(aoi_step_force_scale(run, entry, aoi_step_force(entry)),
                impulse * run->contact[entry->contact].rate_scale / indentation);
}

/* What the last coefficients of the rate's series hold. From the nodes alone: where a force comes or goes, the
 * rate of what has no mass jumps. */
static double rate_tail(const aoi_contact_step *entry)
{
    return fabs(aoi_vector_dot(AOI_NODES, aoi_radau_to_legendre[AOI_NODES - 1], entry->rate)) +
           fabs(aoi_vector_dot(AOI_NODES, aoi_radau_to_legendre[AOI_NODES - 2], entry->rate));
}

/* The error of a force that depends on the rate where it is largest inside a step with an edge, of which its
 * own series says nothing. The rate's coefficients fall slowly there, like a power: those to come hold more
 * than the last ones do. */
static double edge_force_error(const aoi_law *law, const aoi_contact_step *entry, double tail)
{
    double largest = 0.0;
    aoi_law_value value;
    aoi_step_law_at_end(law, entry, &value);
    for (size_t i = 0; i + 1 < AOI_NODES; i++) {
        largest = fmax(largest, entry->force[i]);
    }
    if (largest <= fmax(entry->start_force, NEAR_TOP * value.force)) {
        return 0.0;
    }
    return fabs(value.stiffness) * tail +
           fabs(value.damping) * rate_tail(entry) * AOI_NODES / 3.0;
}

/* Whether a load on one of the two bodies has just begun to change otherwise. */
static int load_bent(const aoi_adaptive *run, const aoi_contact_step *entry)
{
    const aoi_contact *of = &run->system->contact[entry->contact];
    const double now = aoi_run_now(run), slack = ROUNDINGS * DBL_EPSILON * run->end;
    return aoi_modes_next_bend(&run->system->body[of->body[0]], now - slack) <= now + slack ||
           aoi_modes_next_bend(&run->system->body[of->body[1]], now - slack) <= now + slack;
}

/* By how much a force jumps at the start of a step where it goes on though a load bends there: the nodes have not seen
 * it. Of what has no mass it may jump, but for what rests: that has the force of its rest when it sets off. */
static double force_jump(const aoi_adaptive *run, const aoi_contact_step *entry)
{
    const int bent = aoi_contact_has_residual(run, entry->contact);
    const int goes_on = bent ? run->rested && run->steps == 0
                             : entry->edge == AOI_EDGE_NONE && load_bent(run, entry);
    return goes_on ? fabs(aoi_nodes_at_start(entry->force) - entry->start_force) : 0.0;
}

/* Whether the largest force of all may lie inside the step. Else what counts is what a wrong force does within
 * the step: where one begins like t^(1/4) at a place without mass, it is wrong in the shortest one. */
static int may_top(const aoi_adaptive_contact *contact, const aoi_contact_step *entry, double wrong)
{
    const double largest = aoi_step_force(entry);
    return largest > entry->force[AOI_NODES - 1] && largest + wrong > contact->peak_force;
}

/* The errors of a step as shares of what they may be, and what may be missed of a force that rings, N. */
typedef struct errors {
    double within, handed_on, ripple;
} errors;

/* No step can do better than rounding. */
static void find_errors(const aoi_adaptive *run, aoi_contact_step *entry, double h, errors *of)
{
    const aoi_adaptive_contact *contact = &run->contact[entry->contact];
    const double largest = aoi_step_indentation(entry), scale = aoi_step_scale(run, entry, largest);
    const double impulse_scale = fmax(contact->impulse_scale, LESSER_SHARE * run->impulse_scale);
    const int at_an_end = contact->last_length == 0.0 || entry->indentation[AOI_NODES - 1] <= 0.0;
    const double end_share = at_an_end ? END_SHARE : 1.0;
    const int bent = aoi_contact_has_residual(run, entry->contact);
    const double tail_share =
        fmax(TAIL_SHARE * (bent ? end_share : 1.0) * run->rtol, 8.0 * DBL_EPSILON);
    const double step_share = STEP_SHARE * end_share * run->rtol;
    aoi_collocation_error error;
    aoi_collocation_estimate(run->system, run->response, h, entry, &error);
    of->within = steepness_of(run, entry, largest) * error.tail / (tail_share * scale);
    const aoi_law *law = aoi_step_law(run, entry);
    if (law->depends_on_rate && (bent || aoi_step_may_peak(contact, entry))) {
        const double wrong = entry->edge == AOI_EDGE_NONE
                                 ? force_tail(entry)
                                 : edge_force_error(law, entry, error.tail);
        const double usual = force_scale(run, entry, impulse_scale, scale);
        const double size = fmax(usual, bent && !may_top(contact, entry, wrong) ? impulse_scale / h : 0.0);
        of->within = fmax(of->within, wrong / (tail_share * size));
        of->within = fmax(of->within, force_jump(run, entry) / (run->rtol * usual));
    }
    of->ripple = fmax(run->rtol, 8.0 * DBL_EPSILON) * force_scale(run, entry, impulse_scale, scale);
    of->handed_on = (fabs(error.impulse) / impulse_scale + fabs(error.indentation) / scale) /
                 fmax(step_share, 2.0 * DBL_EPSILON);
}

/* What counts as fast for a contact: what it has seen, or a small share of what the others have. */
static double rate_scale(const aoi_adaptive *run, const aoi_contact_step *entry)
{
    double scale = run->contact[entry->contact].rate_scale;
    for (size_t s = 0; s < run->closed_count; s++) {
        scale = fmax(scale, LESSER_SHARE * run->contact[run->entry[s].contact].rate_scale);
    }
    return scale;
}

/* The same where a law has let go: the motion is exact, but is to be seen well enough to tell whether the
 * force comes back, which the rate decides. */
static double slack_growth(const aoi_adaptive *run, const aoi_contact_step *entry, double h, double within)
{
    const double scale = aoi_step_scale(run, entry, aoi_step_indentation(entry));
    const double slow = TAIL_SHARE * run->rtol * fmax(rate_scale(run, entry), scale / h);
    const double unseen = fmax(within, rate_tail(entry) / fmax(slow, DBL_MIN));
    const double growth = CAUTION * pow(unseen, -1.0 / AOI_NODES);
    return unseen > 1.0 ? fmin(growth, CAUTION) : fmin(fmax(growth, 1.0), SLACK_GROWTH);
}

/* At an edge errors grow like the powers of time that a polynomial misses: d^(3/2) makes t^(7/2) of the
 * motion, t^(5/2) of the impulse. */
static double growth_of(aoi_adaptive_contact *contact, const aoi_contact_step *entry, double h, const errors *of)
{
    const int at_edge = entry->edge != AOI_EDGE_NONE;
    const double by_tail = at_edge ? 3.5 : AOI_NODES + 1, by_impulse = at_edge ? 2.5 : 2 * AOI_NODES;
    double growth = CAUTION * pow(of->within, -1.0 / by_tail);
    if (of->within > 1.0 || of->handed_on > of->within * of->within) { /* else the first is the least */
        growth = fmin(growth, CAUTION * pow(of->handed_on, -1.0 / by_impulse));
    }
    if (of->within > 1.0 || of->handed_on > 1.0) {
        return fmin(growth, CAUTION);
    }
    if (at_edge) {
        contact->edge = h * fmin(fmax(growth, 1.0), EDGE_REACH);
        return EDGE_GROWTH;
    }
    return fmax(growth, 1.0);
}

double aoi_step_growth(aoi_adaptive *run, aoi_contact_step *entry, double h)
{
    errors of;
    find_errors(run, entry, h, &of);
    if (isnan(of.within + of.handed_on)) {
        return 0.0;
    }
    const double growth = entry->piece == AOI_SLACK ? slack_growth(run, entry, h, of.within)
                                                    : growth_of(&run->contact[entry->contact], entry, h, &of);
    return aoi_step_ring_growth(run, entry, h, growth, of.ripple);
}
