/* The errors of a step as shares of the tolerance, and the length of the next step.
 *
 * Two errors are kept below rtol in each step. The tail of the indentation's Legendre series measures how well the
 * polynomial follows the motion within the step, hence the peak. The integrated defect of the force between the nodes
 * measures the error at the end of the step, hence impulse, velocities and later times. Radau nodes make the second far
 * smaller than the first, except at the beginning and end of a contact, where the force starts like d^(3/2). Both are
 * samples, and miss modes that oscillate many times within the step. The effect of these on the force is bounded in
 * step_ring.c, and kept below rtol, too. */
#include "adaptive/run.h"
#include "adaptive/step.h"
#include "linear/vector.h"
#include "law/law.h"
#include "motion/modes.h"
#include "motion/polynomial.h"
#include "motion/radau.h"
#include "motion/nodes.h"
#include "collocation/collocation.h"
#include "collocation/sliding.h"

#include <float.h>
#include <math.h>

/* TAIL_SHARE, STEP_SHARE: shares of rtol for the polynomial's tail and for the error at the end of one step. Errors
 * add up over some twenty steps of a contact, and grow from one contact to the next. See the table in ../README.md. */
static const double TAIL_SHARE = 0.3, STEP_SHARE = 0.1;

/* Factor on STEP_SHARE, and at a residual compliance on TAIL_SHARE, in the first and last step of a
 * contact. The force is not a smooth function of time there, and the quadrature of the force's
 * defect misses part of it. */
static const double END_SHARE = 0.03;

/* Largest ratio of the length of a step tried to the length that the error allows: see ../README.md. */
static const double CAUTION = 0.9;

/* Largest growth from a step whose error tells little of the next: one with an edge, or while a contact is slack, where
 * the bodies still overlap, but the law's force is cut at zero: see ../README.md. */
static const double BLIND_GROWTH = 2.0;

/* Largest ratio of the step length allowed at a contact's end to that of the step in which the contact began.
 * Measured: 1 costs 1.3 % more work, 4.2 costs 0.3 %. */
static const double EDGE_REACH = 1.4;

/* Order of the error of friction's impulse in the step's length where its rate has a kink. */
static const double KINK_ORDER = 3.0;

/* Ratio of the forces at the last two nodes: a little above 0.986, which holds where the force grows like t^(1/4)
 * from the start. */
static const double NEAR_TOP = 0.99;

/* Ratio of the relative errors of force and indentation, divided by 3/2, its value for Hertz's law; at least 1. */
static double steepness_of(const aoi_adaptive *run, const aoi_contact_step *entry, double largest)
{
    aoi_law_value value;
    aoi_law_push(aoi_step_law(run, entry), entry->memory, largest, entry->start_rate, &value);
    /* The error is relative to the largest force: a small force at the end of a contact needs no relative accuracy. */
    const double force = fmax(value.force, run->contact[entry->contact].ledger.peak.force);
    return force > 0.0 ? fmax(value.stiffness * largest / (1.5 * force), 1.0) : 1.0;
}

/* Size of the last coefficients of the force's polynomial. Under a rate-dependent law light contact masses and stiff
 * oscillators appear in the force long before they appear in the indentation. At a massless contact point the force may
 * change faster than the indentation, within the relaxation time of law and residual compliance. */
static double force_tail(const aoi_contact_step *entry)
{
    double c[4];
    for (size_t k = 0; k < 4; k++) {
        c[k] = fabs(aoi_nodes_dot(aoi_radau_to_legendre[AOI_NODES - 1 - k], entry->force));
    }
    const double last = c[0] + 0.2 * c[1], before = c[2] + 0.2 * c[3];
    return last < before ? last * sqrt(last / before) : last;
}

static double force_scale(const aoi_adaptive *run, const aoi_contact_step *entry)
{
    return aoi_step_force_scale(run, entry, aoi_step_force(entry));
}

/* Size of the last coefficients of the rate's series. It is fitted to the nodes without the start: where a force sets
 * in or ends, the rate of a massless contact point jumps. */
static double rate_tail(const aoi_contact_step *entry)
{
    return fabs(aoi_vector_dot(AOI_NODES, aoi_radau_to_legendre[AOI_NODES - 1], entry->rate)) +
           fabs(aoi_vector_dot(AOI_NODES, aoi_radau_to_legendre[AOI_NODES - 2], entry->rate));
}

/* The error of a rate-dependent force whose maximum lies inside a step with an edge, where the series of the force
 * gives no estimate. The rate's Legendre coefficients decay slowly there, like a power of the degree: the sum of the
 * coefficients left out exceeds the last ones. */
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

/* True if a load on one of the two bodies has a kink or a jump now. */
static int load_bent(const aoi_adaptive *run, const aoi_contact_step *entry)
{
    const aoi_contact *of = &run->system->contact[entry->contact];
    /* Times closer than this multiple of the rounding of the end time count as equal: run.c goes up to 8 beyond a kink.
     * Tried: no run changes. */
    const double now = aoi_run_now(run), slack = 16.0 * DBL_EPSILON * run->end;
    return aoi_modes_next_bend(&run->system->body[of->body[0]], now - slack) <= now + slack ||
           aoi_modes_next_bend(&run->system->body[of->body[1]], now - slack) <= now + slack;
}

/* Jump of the step's force polynomial at the start of a step at which the force should be continuous: where a load has
 * a kink there, which the nodes do not resolve. At a massless contact point the force may jump, except at the start of
 * a run from rest, where it is the force at rest. */
static double force_jump(const aoi_adaptive *run, const aoi_contact_step *entry)
{
    const int bent = aoi_contact_has_residual(run, entry->contact);
    const int goes_on = bent ? run->rested && run->steps == 0
                             : entry->edge == AOI_EDGE_NONE && load_bent(run, entry);
    return goes_on ? fabs(aoi_nodes_at_start(entry->force) - entry->start_force) : 0.0;
}

/* True if the contact's largest force may lie inside the step. Otherwise the force's error is measured by its impulse
 * in the step: at a massless contact point a force may begin like t^(1/4), with a relative error that does not decrease
 * with the step length. */
static int may_top(const aoi_adaptive_contact *contact, const aoi_contact_step *entry, double wrong)
{
    const double largest = aoi_step_force(entry);
    return largest > entry->force[AOI_NODES - 1] && largest + wrong > contact->ledger.peak.force;
}

/* Errors of a step as shares of their tolerances: within the step (within) and at its end (handed_on). ripple:
 * tolerance of the unresolved oscillation of a force, N. */
typedef struct errors {
    double within, handed_on, ripple;
    double drift; /* error of friction due to paths of straight parts, as a share of its tolerance */
} errors;

/* Share of Coulomb's bound below which friction is rounding of the normal force, and no higher accuracy is promised. */
static const double LEAST_FRICTION = 1e-9;

/* Ratio of the largest friction of a contact, so far and in this step, to the scale of its normal force. It scales
 * friction and slides. While a contact sticks, friction is far below Coulomb's bound. */
static double friction_share(const aoi_adaptive *run, const aoi_contact_step *normal)
{
    const aoi_sliding *sliding = normal->sliding;
    double largest = sliding->largest;
    for (size_t k = 0; k < AOI_NODES; k++) {
        largest = fmax(largest, hypot(normal[1].force[k], normal[2].force[k]));
    }
    const double share = largest / force_scale(run, normal);
    return fmin(fmax(share, LEAST_FRICTION * sliding->rub.friction.mu), sliding->rub.friction.mu);
}

/* Finds the errors as shares of their tolerances, which are at least a few times the rounding. */
static void find_errors(const aoi_adaptive *run, aoi_contact_step *entry, double h, errors *of)
{
    const aoi_adaptive_contact *contact = &run->contact[entry->contact];
    const aoi_contact_step *normal = entry - entry->axis;
    const double share = entry->axis > 0 ? friction_share(run, normal) : 1.0;
    const double largest = aoi_step_indentation(normal);
    double scale = aoi_step_scale(run, normal, largest);
    double impulse_scale = fmax(contact->scales.impulse, LESSER_SHARE * run->impulse_scale);
    if (entry->axis > 0) {
        scale *= share / entry->sliding->rub.friction.ratio;
        impulse_scale *= share;
    }
    const int at_an_end = contact->closed.last_length == 0.0 || normal->indentation[AOI_NODES - 1] <= 0.0;
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
        const double usual = force_scale(run, entry);
        const double size = fmax(usual, bent && !may_top(contact, entry, wrong) ? impulse_scale / h : 0.0);
        of->within = fmax(of->within, wrong / (tail_share * size));
        const double known = fmax(run->rtol * usual, AOI_RATE_ERROR * fmax(usual, run->force_scale));
        of->within = fmax(of->within, force_jump(run, entry) / known);
    }
    of->ripple = fmax(run->rtol, 8.0 * DBL_EPSILON) * share * force_scale(run, normal);
    of->drift = 0.0;
    if (entry->sliding) { /* the error of the curve of stretches hides a smaller drift */
        const double known = fmax(STEP_SHARE * run->rtol, entry->sliding->rub.friction.precision);
        of->drift = entry->sliding->drift[entry->axis] / (known * share * force_scale(run, normal));
    }
    of->handed_on = (fabs(error.impulse) / impulse_scale + fabs(error.indentation) / scale) /
                 fmax(step_share, 2.0 * DBL_EPSILON);
}

/* Rate scale of a contact: its largest so far, or a small share of the other contacts' scale. */
static double rate_scale(const aoi_adaptive *run, const aoi_contact_step *entry)
{
    double scale = run->contact[entry->contact].scales.rate;
    for (size_t s = 0; s < run->closed_count; s++) {
        scale = fmax(scale, LESSER_SHARE * run->contact[run->entry[s].contact].scales.rate);
    }
    return scale;
}

/* The admissible growth while a contact is slack: the motion is exact, but the rate must be resolved well enough to
 * find where the force rises above zero again. Rounding is left out: shorter steps have more of it. */
static double slack_growth(const aoi_adaptive *run, const aoi_contact_step *entry, double h, double within)
{
    const double scale = aoi_step_scale(run, entry, aoi_step_indentation(entry));
    const double slow = TAIL_SHARE * run->rtol * fmax(rate_scale(run, entry), scale / h);
    /* Rounding changes slopes at the nodes by up to the rounding of the values, times the number of nodes squared,
     * divided by the step's length. */
    const double rounding = AOI_NODES * AOI_NODES * AOI_COLLOCATION_ROUNDING * entry->scale / h;
    const double unresolved = fmax(within, fmax(rate_tail(entry) - rounding, 0.0) / fmax(slow, DBL_MIN));
    const double growth = CAUTION * pow(unresolved, -1.0 / AOI_NODES);
    return unresolved > 1.0 ? fmin(growth, CAUTION) : fmin(fmax(growth, 1.0), BLIND_GROWTH);
}

/* Growth allowed by friction, where slip may begin or end in the step. The drift and the error of the impulse have
 * about the order of a kink of the rate; the latter counts only if it is too large. */
static double sliding_growth(const errors *of)
{
    const double worst = fmax(of->drift, of->handed_on > 1.0 ? of->handed_on : 0.0);
    const double growth = CAUTION * pow(worst, -1.0 / KINK_ORDER);
    return worst > 1.0 ? growth : fmax(growth, 1.0);
}

/* Growth of the step length that the errors allow. At an edge, errors grow like the powers of time that a polynomial
 * cannot represent: a force like d^(3/2) gives t^(7/2) in the motion and t^(5/2) in the impulse. */
static double growth_of(aoi_adaptive_contact *contact, const aoi_contact_step *entry, double h, const errors *of)
{
    const int at_edge = entry->edge != AOI_EDGE_NONE;
    const double by_tail = at_edge ? 3.5 : AOI_NODES + 1, by_impulse = at_edge ? 2.5 : 2 * AOI_NODES;
    double growth = CAUTION * pow(of->within, -1.0 / by_tail);
    /* else the tail allows the smaller growth */
    if (of->within > 1.0 || of->handed_on > of->within * of->within) {
        growth = fmin(growth, CAUTION * pow(of->handed_on, -1.0 / by_impulse));
    }
    if (entry->sliding) {
        growth = fmin(growth, sliding_growth(of));
    }
    if (of->within > 1.0 || of->handed_on > 1.0 || of->drift > 1.0) {
        return fmin(growth, CAUTION);
    }
    if (at_edge) {
        contact->closed.edge = h * fmin(fmax(growth, 1.0), EDGE_REACH);
        return BLIND_GROWTH;
    }
    return fmax(growth, 1.0);
}

double aoi_step_growth(aoi_adaptive *run, aoi_contact_step *entry, double h)
{
    errors of;
    find_errors(run, entry, h, &of);
    if (isnan(of.within + of.handed_on + of.drift)) {
        return 0.0;
    }
    const double growth = entry->piece == AOI_SLACK ? slack_growth(run, entry, h, of.within)
                                                    : growth_of(&run->contact[entry->contact], entry, h, &of);
    return aoi_step_ring_growth(run, entry, h, growth, of.ripple);
}
