/* The errors of a step relative to their tolerances, and the length of the next step.
 *
 * Two errors are kept below rtol in each step. The last coefficients of the indentation's Legendre series measure
 * how well the polynomial follows the motion within the step, hence the peak. The difference between the law's
 * force and the force polynomial, integrated over the step, measures the error at its end, hence impulse,
 * velocities and later times. With Radau nodes the second error is far smaller than the first, except at the
 * beginning and end of a contact, where the force is like d^(3/2). Both errors are found at a few points, and miss
 * modes that oscillate many times within the step. The effect of these modes on the force is bounded in
 * step_ring.c, and kept below rtol as well. */
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

/* TAIL_SHARE, STEP_SHARE: shares of rtol for the error within a step (last coefficients of the polynomial) and for
 * the error at the end of one step. Errors at the ends of steps add up over some twenty steps of a contact, and
 * grow from one contact to the next. See the table in ../README.md. */
static const double TAIL_SHARE = 0.3, STEP_SHARE = 0.1;

/* Factor on STEP_SHARE, and at a residual compliance also on TAIL_SHARE, in the first and last step of a contact.
 * There the force is not a smooth function of time, and the quadrature of its difference from the polynomial
 * misses part of the error. */
static const double END_SHARE = 0.05;

/* Largest length of a trial step, as a share of the length that the error allows: see ../README.md. */
static const double CAUTION = 0.9;

/* Largest growth of the step length after a step whose error does not predict that of the next: a step in which a
 * force begins or ends (an edge), or of a slack contact, whose bodies overlap although the law's force is cut at
 * zero. See ../README.md. */
static const double BLIND_GROWTH = 2.0;

/* Upper limit of the length that the error allows the last step of a contact, in units of the length of its first
 * step. Measured: 1 costs 1.3 % more work, 4.2 costs 0.3 %. */
static const double EDGE_REACH = 1.4;

/* Power of the step length to which the error of friction's impulse is proportional if the rate of friction has a
 * kink. */
static const double KINK_ORDER = 3.0;

/* The maximum of a step's force is inside if the force at a node before the last exceeds this share of the force
 * at the end. The share is a little above 0.986, the ratio of the forces at the last two nodes where the force
 * grows like t^(1/4) from the start. */
static const double NEAR_TOP = 0.99;

/* Returns the ratio of the relative errors of force and indentation, divided by 3/2, its value for Hertz's law; at
 * least 1. */
static double steepness_of(const aoi_adaptive *run, const aoi_contact_step *entry, double largest)
{
    aoi_law_value value;
    aoi_law_push(aoi_step_law(run, entry), entry->memory, largest, entry->start_rate, &value);
    /* The error of the force is relative to the largest force: a small force at the end of a contact needs no
     * relative accuracy. */
    const double force = fmax(value.force, run->contact[entry->contact].ledger.peak.force);
    return force > 0.0 ? fmax(value.stiffness * largest / (1.5 * force), 1.0) : 1.0;
}

/* Returns the size of the last Legendre coefficients of the force's polynomial, N, an estimate of its error. Under
 * a rate-dependent law, the motion of light contact masses and stiff oscillators shows in the force long before it
 * shows in the indentation. At a massless contact point the force may change faster than the indentation, within
 * the relaxation time of law and residual compliance. */
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

/* Returns the size of the last Legendre coefficients of the rate's polynomial, m/s. The polynomial is fitted to
 * the nodes without the start, since the rate of a massless contact point jumps where a force begins or ends. */
static double rate_tail(const aoi_contact_step *entry)
{
    return fabs(aoi_vector_dot(AOI_NODES, aoi_radau_to_legendre[AOI_NODES - 1], entry->rate)) +
           fabs(aoi_vector_dot(AOI_NODES, aoi_radau_to_legendre[AOI_NODES - 2], entry->rate));
}

/* Returns an estimate of the error of a rate-dependent force whose maximum lies inside a step with an edge, N; 0
 * if the maximum does not lie inside. In such a step the force's polynomial gives no estimate. The rate's Legendre
 * coefficients decay slowly, like a power of the degree: those left out add up to more than the last ones. tail:
 * error of the indentation, m. */
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

/* True if a load on one of the contact's two bodies has a kink or a jump at the present time. */
static int load_bent(const aoi_adaptive *run, const aoi_contact_step *entry)
{
    const aoi_contact *of = &run->system->contact[entry->contact];
    /* Times closer than this count as equal: run.c steps beyond a kink by up to 8 times the rounding error of the
     * time. Tried with a third and three times the value: no run changes. */
    const double now = aoi_run_now(run), slack = 16.0 * DBL_EPSILON * run->end;
    return aoi_modes_next_bend(&run->system->body[of->body[0]], now - slack) <= now + slack ||
           aoi_modes_next_bend(&run->system->body[of->body[1]], now - slack) <= now + slack;
}

/* Returns the difference between the step's force polynomial at the start and the force at the start, N, where the
 * force is continuous and the nodes may not resolve it: a load has a kink there, in a step without an edge, or, at
 * a massless contact point, a run starts from rest. Returns 0 in all other cases; at a massless contact point the
 * force may then jump. */
static double force_jump(const aoi_adaptive *run, const aoi_contact_step *entry)
{
    const int bent = aoi_contact_has_residual(run, entry->contact);
    const int goes_on = bent ? run->rested && run->steps == 0
                             : entry->edge == AOI_EDGE_NONE && load_bent(run, entry);
    return goes_on ? fabs(aoi_nodes_at_start(entry->force) - entry->start_force) : 0.0;
}

/* True if the contact's largest force may lie inside the step; wrong: error of the force, N. Otherwise this error
 * is compared with the impulse scale divided by the step length: at a massless contact point a force may begin
 * like t^(1/4), and its relative error then does not decrease with the step length. */
static int may_top(const aoi_adaptive_contact *contact, const aoi_contact_step *entry, double wrong)
{
    const double largest = aoi_step_force(entry);
    return largest > entry->force[AOI_NODES - 1] && largest + wrong > contact->ledger.peak.force;
}

/* Errors of a step, each divided by its tolerance (above 1: the step is too long). within: of indentation and
 * force within the step; handed_on: of impulse and indentation at its end; drift: of friction, whose springs
 * follow the slide along straight parts. ripple is no error, but the tolerance of force oscillations that the
 * nodes do not resolve, N. */
typedef struct errors {
    double within, handed_on, ripple;
    double drift;
} errors;

/* Least friction, as a share of Coulomb's bound, that errors of friction are compared with: smaller friction is
 * rounding of the normal force, and no higher accuracy is promised. */
static const double LEAST_FRICTION = 1e-9;

/* Returns the ratio of the largest friction of a contact, so far and in this step, to the scale of its normal
 * force. The ratio scales friction and slides, since friction is far below Coulomb's bound while a contact sticks. */
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

/* Finds the errors of a step, each divided by its tolerance, which is at least a few rounding errors. */
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
    const double tail_share = fmax(TAIL_SHARE * (bent ? end_share : 1.0) * run->rtol, 8.0 * DBL_EPSILON);
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
    /* the tolerance of the drift is at least the error of the curve of stretches, which hides a smaller drift */
    if (entry->sliding) {
        const double known = fmax(STEP_SHARE * run->rtol, entry->sliding->rub.friction.precision);
        of->drift = entry->sliding->drift[entry->axis] / (known * share * force_scale(run, normal));
    }
    of->handed_on = (fabs(error.impulse) / impulse_scale + fabs(error.indentation) / scale) /
                 fmax(step_share, 2.0 * DBL_EPSILON);
}

/* Returns the rate scale of a contact, m/s: the larger of its largest rate so far and LESSER_SHARE times the
 * largest rate of any closed contact. */
static double rate_scale(const aoi_adaptive *run, const aoi_contact_step *entry)
{
    double scale = run->contact[entry->contact].scales.rate;
    for (size_t s = 0; s < run->closed_count; s++) {
        scale = fmax(scale, LESSER_SHARE * run->contact[run->entry[s].contact].scales.rate);
    }
    return scale;
}

/* Returns the admissible growth of the step length while a contact is slack. The contact's motion is then exact,
 * but the rate must be resolved well enough to find where the force rises above zero again. Rounding errors of the
 * rate are subtracted, since they are larger in shorter steps. */
static double slack_growth(const aoi_adaptive *run, const aoi_contact_step *entry, double h, double within)
{
    const double scale = aoi_step_scale(run, entry, aoi_step_indentation(entry));
    const double slow = TAIL_SHARE * run->rtol * fmax(rate_scale(run, entry), scale / h);
    /* Rounding errors of the values change slopes at the nodes by up to these errors times the number of nodes
     * squared, divided by the step's length. */
    const double rounding = AOI_NODES * AOI_NODES * AOI_COLLOCATION_ROUNDING * entry->scale / h;
    const double unresolved = fmax(within, fmax(rate_tail(entry) - rounding, 0.0) / fmax(slow, DBL_MIN));
    const double growth = CAUTION * pow(unresolved, -1.0 / AOI_NODES);
    return unresolved > 1.0 ? fmin(growth, CAUTION) : fmin(fmax(growth, 1.0), BLIND_GROWTH);
}

/* Returns the factor by which the step length may grow in view of the errors of friction. Where slip begins or
 * ends within a step, the rate of friction has a kink; both the drift and the error at the step's end (handed_on)
 * are then proportional to about the power KINK_ORDER of the step length. handed_on counts only above 1, its
 * tolerance. */
static double sliding_growth(const errors *of)
{
    const double worst = fmax(of->drift, of->handed_on > 1.0 ? of->handed_on : 0.0);
    const double growth = CAUTION * pow(worst, -1.0 / KINK_ORDER);
    return worst > 1.0 ? growth : fmax(growth, 1.0);
}

/* Returns the growth of the step length that the errors allow. In a step with an edge, errors grow like the powers
 * of time that a polynomial cannot represent: a force like d^(3/2) gives t^(7/2) in the motion and t^(5/2) in the
 * impulse. */
static double growth_of(aoi_adaptive_contact *contact, const aoi_contact_step *entry, double h, const errors *of)
{
    const int at_edge = entry->edge != AOI_EDGE_NONE;
    const double by_tail = at_edge ? 3.5 : AOI_NODES + 1, by_impulse = at_edge ? 2.5 : 2 * AOI_NODES;
    double growth = CAUTION * pow(of->within, -1.0 / by_tail);
    /* otherwise `within` allows the smaller growth */
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
