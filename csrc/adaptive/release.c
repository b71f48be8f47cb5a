/* Prediction of the time of separation, so that the last step of a contact ends there and the step before has a
 * suitable length. */
#include "adaptive/run.h"
#include "law/law.h"
#include "collocation/collocation.h"

#include <float.h>
#include <math.h>
#include <stddef.h>

/* MOST_TERMS: largest number of terms of the series in slowness(). NEGLIGIBLE: least factor of a term that is
 * included. The series affects step lengths only. Tried: MOST_TERMS = 20 changes 29 runs, by 8e-10, and 180 none;
 * other values of NEGLIGIBLE change 34 runs, by 4e-9. */
enum { MOST_TERMS = 60 };

static const double NEGLIGIBLE = 1e-13;

/* MOST_OF_REST, LEAST_OF_REST: largest and least length of the steps before the last one, as a share of the time
 * left to separation. Measured: either constant at 0.2 costs 0.8 % more work; 0.9 and 0.6 save none. */
static const double MOST_OF_REST = 2.0 / 3.0, LEAST_OF_REST = 0.5;

/* Returns int_0^1 du / sqrt(1 - e u^power): the ratio of the time to separation to the time that the same distance
 * takes at the rate of separation. */
static double slowness(double e, double power)
{
    double factor = 1.0, sum = 1.0;
    for (int j = 1; j < MOST_TERMS && factor > NEGLIGIBLE; j++) {
        factor *= e * (2.0 * j - 1.0) / (2.0 * j);
        sum += factor / (power * j + 1.0);
    }
    return sum;
}

/* Returns the closed contact if there is only one, else NULL: several closed contacts influence each other's
 * separation. */
static const aoi_adaptive_contact *only_contact(const aoi_adaptive *run)
{
    const int rubs = run->closed_count == 3 && run->entry[0].sliding;
    return run->closed_count == 1 || rubs ? &run->contact[run->entry[0].contact] : NULL;
}

double aoi_release_after(const aoi_adaptive *run, double within)
{
    const aoi_adaptive_contact *contact = only_contact(run);
    if (!contact || contact->closed.piece == AOI_SLACK || !(contact->closed.rate < 0.0)) {
        return HUGE_VAL;
    }
    const size_t c = run->entry[0].contact;
    const aoi_law *law = run->system->contact[c].law;
    const double depth = contact->closed.start - aoi_law_rest(law, contact->memory);
    double rate;
    aoi_law_value value;
    aoi_law_force(law, contact->memory, contact->closed.piece, contact->closed.start, contact->closed.rate, &value);
    if (!(depth > 0.0) || !(value.force > 0.0)) {
        return HUGE_VAL;
    }
    /* The force is taken as a power of the indentation beyond rest. While the energy stored in the law exceeds the
     * kinetic energy, the prediction is too rough. */
    const double power = 1.0 + value.stiffness * depth / value.force;
    const double gain = 2.0 * contact->scales.mobility * value.force * depth / power;
    const double squared = contact->closed.rate * contact->closed.rate;
    if (gain > squared || depth > within * sqrt(squared + gain)) {
        return HUGE_VAL;
    }
    (void)aoi_contact_free(run, c, &rate);
    const double speed = rate * rate + gain;
    return depth / sqrt(speed) * slowness(gain / speed, power);
}

double aoi_release_step(const aoi_adaptive *run, double h)
{
    const aoi_adaptive_contact *contact = only_contact(run);
    if (!contact || contact->closed.edge == 0.0) {
        return h;
    }
    const double left = aoi_release_after(run, fmax(h / LEAST_OF_REST, contact->closed.edge));
    if (left <= contact->closed.edge) {
        /* The step ends slightly beyond separation: if rounding let it end before, a very short last step would be
         * needed. */
        const double beyond = 0.25 * aoi_event_tolerance(run, contact->scales.indentation) /
                              fabs(contact->closed.rate);
        return fmin(h, left + fmax(beyond, 16.0 * DBL_EPSILON * run->elapsed));
    }
    const double most = fmin(left - contact->closed.edge, MOST_OF_REST * left);
    return fmin(h, fmax(most, LEAST_OF_REST * left));
}
