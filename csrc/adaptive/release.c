/* When a contact will let go, before it does: what is left of it is taken in steps that fit. */
#include "adaptive/run.h"
#include "law/law.h"
#include "motion/free.h"
#include "collocation/collocation.h"

#include <float.h>
#include <math.h>
#include <stddef.h>

/* Of a series whose last terms fall by the share of the energy that is still in the law. */
enum { MOST_TERMS = 60 };

static const double NEGLIGIBLE = 1e-13;

/* A step before the last may be so much of what is left; and is not worth less than that. */
static const double MOST_OF_REST = 2.0 / 3.0, LEAST_OF_REST = 0.5;

/* int_0^1 du / sqrt(1 - e u^power): how much longer the way out takes than at its last velocity. */
static double slowness(double e, double power)
{
    double factor = 1.0, sum = 1.0;
    for (int j = 1; j < MOST_TERMS && factor > NEGLIGIBLE; j++) {
        factor *= e * (2.0 * j - 1.0) / (2.0 * j);
        sum += factor / (power * j + 1.0);
    }
    return sum;
}

/* With several contacts at once none ends as it would alone. */
static const aoi_adaptive_contact *only_contact(const aoi_adaptive *run)
{
    return run->closed_count == 1 ? &run->contact[run->entry[0].contact] : NULL;
}

double aoi_release_after(const aoi_adaptive *run, double within)
{
    const aoi_adaptive_contact *contact = only_contact(run);
    if (!contact || contact->piece == AOI_SLACK || !(contact->start_rate < 0.0)) {
        return HUGE_VAL;
    }
    const size_t c = run->entry[0].contact;
    const aoi_law *law = run->system->contact[c].law;
    const double depth = contact->start - aoi_law_rest(law, contact->memory);
    double here, rate, acceleration;
    aoi_law_value value;
    aoi_free_pair pair;
    aoi_law_force(law, contact->memory, contact->piece, contact->start, contact->start_rate, &value);
    if (!(depth > 0.0) || !(value.force > 0.0)) {
        return HUGE_VAL;
    }
    /* As if the force fell like a power of the depth. As long as most of the energy is to come from the
     * law, what else there is in the bodies decides when. */
    const double power = 1.0 + value.stiffness * depth / value.force;
    const double gain = 2.0 * contact->mobility * value.force * depth / power;
    const double squared = contact->start_rate * contact->start_rate;
    if (gain > squared || depth > within * sqrt(squared + gain)) {
        return HUGE_VAL;
    }
    aoi_pair_now(run, c, &pair);
    aoi_free_pair_indentation(&pair, &here, &rate, &acceleration);
    const double speed = rate * rate + gain;
    return depth / sqrt(speed) * slowness(gain / speed, power);
}

double aoi_release_step(const aoi_adaptive *run, double h)
{
    const aoi_adaptive_contact *contact = only_contact(run);
    if (!contact || contact->edge == 0.0) {
        return h;
    }
    const double left = aoi_release_after(run, fmax(h / LEAST_OF_REST, contact->edge));
    if (left <= contact->edge) {
        /* Not short of it by rounding: else it is found in the next step, that is a sliver. */
        const double beyond = 0.25 * aoi_event_tolerance(run, contact->indentation_scale) /
                              fabs(contact->start_rate);
        return fmin(h, left + fmax(beyond, 16.0 * DBL_EPSILON * run->elapsed));
    }
    const double most = fmin(left - contact->edge, MOST_OF_REST * left);
    return fmin(h, fmax(most, LEAST_OF_REST * left));
}
