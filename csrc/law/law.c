/* Functions common to all contact laws: creation by name, the choice of a smooth piece, the removal of a patch's
 * compliance, and the replacement of negative forces by zero. */
#include "law/kinds.h"
#include "law/law.h"
#include "linear/vector.h"

#include <float.h>
#include <math.h>
#include <string.h>

/* HALLEYS: largest number of iterations of Halley's method, of which few are needed; MOST_ITERATIONS: largest
 * number including the bisections that follow. Tried: HALLEYS from 13 to 120 changes no run. */
enum { HALLEYS = 40, MOST_ITERATIONS = 200 };

/* Relative residual up to which an indentation is accepted, since laws written by the caller may be accurate to
 * only six digits. Tried with a third and three times the value: no run changes. */
static const double LAW_NOISE = 1e-6;

/* Limit of c dF/dd. Taking a compliance c out of a law divides its stiffness by 1 - c dF/dd, which tends to zero.
 * Where the limit is reached, the law is continued as a straight line. */
static const double MOST_SHARE = 0.95;

static int create(aoi_law *law, const aoi_law_kind *kind, size_t count, const double *parameter)
{
    if (count != kind->count) {
        return AOI_ERROR_ARGUMENT;
    }
    *law = kind->law;
    law->limit = HUGE_VAL;
    for (size_t i = 0; i < count; i++) {
        const double p = parameter[i];
        if (!isfinite(p) || p < kind->least[i] || p > kind->most[i] ||
            (kind->least[i] == AOI_POSITIVE && !(p > 0.0))) {
            return AOI_ERROR_ARGUMENT;
        }
        law->parameter[i] = p;
    }
    if (kind->prepare) {
        kind->prepare(law);
    }
    return aoi_vector_is_finite(AOI_LAW_PARAMETERS, law->parameter) ? AOI_OK : AOI_ERROR_ARGUMENT;
}

int aoi_law_create(aoi_law *law, const char *name, size_t count, const double *parameter)
{
    const struct {
        const aoi_law_kind *kind;
        size_t count;
    } tables[] = {{aoi_laws_power, aoi_laws_power_count},
                  {aoi_laws_plastic, aoi_laws_plastic_count},
                  {&aoi_law_yang_sun, 1}};
    for (size_t i = 0; i < sizeof tables / sizeof tables[0]; i++) {
        for (size_t j = 0; j < tables[i].count; j++) {
            if (strcmp(name, tables[i].kind[j].name) == 0) {
                return create(law, &tables[i].kind[j], count, parameter);
            }
        }
    }
    return AOI_ERROR_ARGUMENT;
}

int aoi_law_check(const aoi_law *law)
{
    const int usable = law && law->force && law->potential && isfinite(law->compliance) &&
                       law->limit > 0.0;
    return usable ? AOI_OK : AOI_ERROR_ARGUMENT;
}

/* Records a NaN of a law, and the indentation and rate that gave it, in the law's note. */
static void note_nan(const aoi_law *law, double indentation, double rate,
                     const aoi_law_value *value)
{
    if (law->note && isnan(value->force + value->stiffness + value->damping)) {
        law->note[0] = indentation;
        law->note[1] = rate;
        law->note[2] = AOI_ERROR_LAW;
    }
}

/* Sets `value` to the law's own force and slopes on a piece, at its own indentation. */
static void own_force(const aoi_law *law, const double *memory, int piece, double indentation,
                      double rate, aoi_law_value *value)
{
    law->force(law, memory, piece, indentation, rate, value);
    note_nan(law, indentation, rate, value);
}

/* Converts derivatives with respect to the law's own indentation d to derivatives with respect to the total
 * indentation d - c F. */
static void stiffen(double compliance, aoi_law_value *value)
{
    const double share = compliance * value->stiffness;
    const double stiffer = 1.0 / (1.0 - (share < MOST_SHARE ? share : MOST_SHARE));
    value->stiffness *= stiffer;
    value->damping *= stiffer;
}

/* Returns d with c dF/dd = MOST_SHARE, by bisection. c dF/dd is below MOST_SHARE at `low`, and not below it at
 * `high`. */
static double steepest(const aoi_law *law, const double *memory, int piece, double rate, double low,
                       double high, aoi_law_value *value)
{
    for (int i = 0; i < MOST_ITERATIONS && high - low > 2.0 * DBL_EPSILON * high; i++) {
        const double middle = 0.5 * (low + high);
        own_force(law, memory, piece, middle, rate, value);
        if (law->compliance * value->stiffness < MOST_SHARE) {
            low = middle;
        } else {
            high = middle;
        }
    }
    own_force(law, memory, piece, low, rate, value);
    return low;
}

/* Search for the d that solves d - c F(d) = indentation, on one piece of the law at one rate. */
typedef struct search {
    const aoi_law *law;
    const double *memory;
    int piece;
    double indentation, rate;
    double low, high;
} search;

/* Continues the search from a d below the root at which c dF/dd has reached MOST_SHARE. If the law is less steep
 * further on (as d^(1/4), steep only at its start), d is increased. If the root is below the indentation of
 * MOST_SHARE, the bracket is reduced. In both cases 0 is returned. Otherwise the law is continued as a straight
 * line from MOST_SHARE on, and 1 is returned, with the force on this line and d = indentation + c F. */
static int too_steep(search *s, double *d, aoi_law_value *value)
{
    const double c = s->law->compliance, further = s->indentation + c * value->force;
    aoi_law_value there;
    own_force(s->law, s->memory, s->piece, further, s->rate, &there);
    if (c * there.stiffness < c * value->stiffness) {
        *d = further;
        return 0;
    }
    s->low = fmax(s->low, aoi_law_rest(s->law, s->memory));
    s->high = steepest(s->law, s->memory, s->piece, s->rate, s->low, *d, value);
    const double beyond = s->indentation - (s->high - c * value->force);
    if (beyond < 0.0) {
        *d = 0.5 * (s->low + s->high);
        return 0;
    }
    value->force += beyond * value->stiffness / (1.0 - MOST_SHARE);
    *d = s->indentation + c * value->force;
    return 1;
}

/* Returns the step of Halley's method from d, m, with the curvature of a power law: n = d F'/F, F'' = (n - 1)
 * F'/d. If the law is unlike a power, the step is Newton's. */
static double step_of(double c, double missing, double d, const aoi_law_value *value)
{
    const double slope = value->stiffness, force = value->force;
    const double give = 1.0 - (c * slope < MOST_SHARE ? c * slope : MOST_SHARE);
    const double excess = d * slope - force; /* (n - 1) F */
    if (!(force > 0.0 && excess > 0.0 && excess < 3.0 * force)) {
        return missing / give;
    }
    const double bend = 0.5 * c * missing * slope * excess / (force * d * give);
    return missing / (give - (bend < 0.5 * give ? bend : 0.5 * give));
}

/* Returns the next iterate after d, at which the total indentation is too small by `missing`, m. The iterate lies
 * inside the bracket once both ends of the bracket are known. */
static double next_of(const search *s, double missing, double d, int iteration,
                      const aoi_law_value *value)
{
    const double next = d + step_of(s->law->compliance, missing, d, value);
    const int closed = s->low > -HUGE_VAL && s->high < HUGE_VAL;
    const int inside = next > s->low && next < s->high && iteration < HALLEYS;
    return closed && !inside ? 0.5 * (s->low + s->high) : next;
}

/* Solves d - c F(d) = indentation for the law's own indentation d (own); value: set to the law there. Halley's
 * method starts at d = indentation, with the curvature of a power law; for other laws a bracket makes it safe.
 * Returns AOI_ERROR_PATCH if the law was continued as a straight line, and AOI_ERROR_LAW_JUMPS if no such d exists
 * because the force drops. A NaN of the law is passed on with AOI_OK. */
static int own_indentation(const aoi_law *law, const double *memory, int piece,
                           double indentation, double rate, double *own, aoi_law_value *value)
{
    search s = {law, memory, piece, indentation, rate, -HUGE_VAL, HUGE_VAL};
    double missing = HUGE_VAL, *d = own;
    if (piece == AOI_NO_PIECE) {
        return AOI_ERROR_LAW_JUMPS;
    }
    *d = indentation;
    for (int i = 0; i < MOST_ITERATIONS; i++) {
        own_force(law, memory, piece, *d, rate, value);
        missing = indentation - (*d - law->compliance * value->force);
        if (isnan(missing)) {
            return AOI_OK;
        }
        if (missing > 0.0 && law->compliance * value->stiffness >= MOST_SHARE) {
            if (too_steep(&s, d, value)) {
                return AOI_ERROR_PATCH;
            }
            continue;
        }
        if (fabs(missing) <= 2.0 * DBL_EPSILON * fmax(fabs(*d), fabs(indentation))) {
            /* rounding relative to the larger term, which is the indentation under a force that pulls */
            return AOI_OK;
        }
        *(missing > 0.0 ? &s.low : &s.high) = *d;
        const double next = next_of(&s, missing, *d, i, value);
        if (next == *d || next == s.low || next == s.high) {
            break; /* no floating-point number lies between */
        }
        *d = next;
    }
    return fabs(missing) <= LAW_NOISE * fmax(fabs(*d), fabs(indentation)) ? AOI_OK
                                                                           : AOI_ERROR_LAW_JUMPS;
}

/* Sets the force to NaN, at which the integrators stop, and records where the law has no force. */
static void no_force(const aoi_law *law, double indentation, double rate, aoi_law_value *value)
{
    *value = (aoi_law_value){(double)NAN, (double)NAN, (double)NAN};
    if (law->note) {
        law->note[0] = indentation;
        law->note[1] = rate;
        law->note[2] = AOI_ERROR_LAW_JUMPS;
    }
}

void aoi_law_force(const aoi_law *law, const double *memory, int piece, double indentation,
                   double rate, aoi_law_value *value)
{
    double own;
    if (law->compliance == 0.0) {
        own_force(law, memory, piece, indentation, rate, value);
    } else if (own_indentation(law, memory, piece, indentation, rate, &own, value) == AOI_ERROR_LAW_JUMPS) {
        no_force(law, indentation, rate, value);
    } else if (law->compliance < 0.0 && own < aoi_law_rest(law, memory)) {
        /* The law begins with a jump, which the force has not reached: only the compliance in series deforms. */
        const double rest = aoi_law_rest(law, memory);
        *value = (aoi_law_value){(rest - indentation) / law->compliance, -1.0 / law->compliance, 0.0};
    } else {
        stiffen(law->compliance, value);
    }
}

void aoi_law_forces(const aoi_law *law, const double *memory, int piece, const double *indentation,
                    const double *rate, aoi_law_values *values)
{
    if (law->together && law->compliance == 0.0) {
        law->together(law, indentation, rate, values); /* never NaN, so that nothing is recorded */
        return;
    }
    for (size_t k = 0; k < AOI_NODES; k++) {
        aoi_law_value value;
        aoi_law_force(law, memory, piece, indentation[k], rate[k], &value);
        values->force[k] = value.force;
        values->stiffness[k] = value.stiffness;
        values->damping[k] = value.damping;
    }
}

double aoi_law_rest(const aoi_law *law, const double *memory)
{
    return law->rest ? law->rest(law, memory) : 0.0;
}

/* Returns the total indentation at an end of a piece, given by the law's own indentation, m. If c dF/dd is too
 * large there, the upper end (upwards = 1) is infinite: the law's limit is below it, and beyond the limit the
 * total indentation may even decrease. */
static double total_at(const aoi_law *law, const double *memory, int piece, double end, int upwards)
{
    aoi_law_value value;
    if (law->compliance == 0.0 || fabs(end) == HUGE_VAL) {
        return end;
    }
    own_force(law, memory, piece, end, 0.0, &value);
    return upwards && !(law->compliance * value.stiffness < MOST_SHARE) ? HUGE_VAL : end - law->compliance * value.force;
}

/* Goes down from a piece to the piece that contains the total indentation, for a negative compliance, for which d
 * < indentation. Within rounding of an end, only a falling motion goes on to the next piece. Returns the piece,
 * and its ends. */
static int lower_piece(const aoi_law *law, const double *memory, double indentation, int rising,
                       int piece, double *low, double *high)
{
    const double rounding = (rising ? 64.0 : -64.0) * DBL_EPSILON * indentation;
    double start = total_at(law, memory, piece, *low, 0);
    while (start > indentation + rounding && *low > -HUGE_VAL) {
        const double before = *low;
        piece = law->piece(law, memory, nextafter(*low, -HUGE_VAL), rising, low, high);
        if (!(*low < before)) {
            return AOI_NO_PIECE;
        }
        start = total_at(law, memory, piece, *low, 0);
    }
    *high = total_at(law, memory, piece, *high, 0);
    *low = start;
    return piece;
}

int aoi_law_piece(const aoi_law *law, const double *memory, double indentation, int rising,
                  double *low, double *high)
{
    *low = -HUGE_VAL;
    *high = HUGE_VAL;
    if (!law->piece) {
        return 0;
    }
    int piece = law->piece(law, memory, indentation, rising, low, high);
    if (law->compliance == 0.0) {
        return piece;
    }
    if (law->compliance < 0.0) {
        return lower_piece(law, memory, indentation, rising, piece, low, high);
    }
    /* For a positive compliance, d > indentation: go up to the piece that contains the total indentation. Within
     * rounding of an end, only a rising motion goes on to the next piece. */
    double end = total_at(law, memory, piece, *high, 1);
    const double rounding = (rising ? 64.0 : -64.0) * DBL_EPSILON * indentation;
    while (end <= indentation + rounding && *high < HUGE_VAL) {
        const double before = *high;
        piece = law->piece(law, memory, *high, 1, low, high);
        if (!(*high > before)) {
            return AOI_NO_PIECE;
        }
        end = total_at(law, memory, piece, *high, 1);
    }
    *low = total_at(law, memory, piece, *low, 0);
    *high = end;
    return piece;
}

/* Solves as own_indentation, on the piece that the motion is on. */
static int own_at(const aoi_law *law, const double *memory, double indentation, double rate, double *own,
                  aoi_law_value *value)
{
    double low, high;
    const int piece = aoi_law_piece(law, memory, indentation, rate > 0.0, &low, &high);
    return own_indentation(law, memory, piece, indentation, rate, own, value);
}

void aoi_law_remember(const aoi_law *law, double indentation, double rate, double *memory)
{
    if (!law->remember) {
        return;
    }
    if (law->compliance != 0.0 && indentation > aoi_law_rest(law, memory)) {
        aoi_law_value value;
        if (own_at(law, memory, indentation, rate, &indentation, &value) == AOI_ERROR_LAW_JUMPS) {
            return; /* the force is NaN there, which stops the run */
        }
    }
    law->remember(law, indentation, rate, memory);
}

void aoi_law_push(const aoi_law *law, const double *memory, double indentation, double rate,
                  aoi_law_value *value)
{
    if (!(indentation > aoi_law_rest(law, memory))) {
        const double none = isnan(indentation) ? indentation : 0.0;
        *value = (aoi_law_value){none, none, none};
        return;
    }
    int piece = 0;
    if (law->piece) {
        double low, high;
        piece = aoi_law_piece(law, memory, indentation, rate > 0.0, &low, &high);
    }
    aoi_law_force(law, memory, piece, indentation, rate, value);
    if (value->force < 0.0 && !law->pulls) {
        *value = (aoi_law_value){0.0, 0.0, 0.0};
    }
}

double aoi_law_push_only(const aoi_law *law, const double *memory, double indentation, double rate)
{
    aoi_law_value value = {0.0, 0.0, 0.0};
    if (!law->alone || law->compliance != 0.0 || !(indentation > aoi_law_rest(law, memory))) {
        aoi_law_push(law, memory, indentation, rate, &value);
        return value.force;
    }
    value.force = law->alone(law, indentation, rate);
    note_nan(law, indentation, rate, &value);
    return value.force < 0.0 && !law->pulls ? 0.0 : value.force;
}

int aoi_law_stands(const aoi_law *law, const double *memory, double indentation, double rate)
{
    if (indentation > law->limit) {
        return 0;
    }
    if (law->compliance == 0.0 || !law->depends_on_rate || indentation <= aoi_law_rest(law, memory)) {
        return 1;
    }
    aoi_law_value value;
    double own;
    return own_at(law, memory, indentation, rate, &own, &value) != AOI_ERROR_PATCH;
}

/* Returns the potential of a law with a compliance, J, at a total indentation up to the law's limit. */
static double inner_potential(const aoi_law *law, const double *memory, double indentation)
{
    aoi_law_value value;
    double d;
    if (own_at(law, memory, indentation, 0.0, &d, &value) == AOI_ERROR_LAW_JUMPS) {
        no_force(law, indentation, 0.0, &value);
        return value.force;
    }
    return law->potential(law, memory, d) - 0.5 * law->compliance * value.force * value.force;
}

double aoi_law_potential(const aoi_law *law, const double *memory, double indentation)
{
    if (isnan(indentation)) {
        return indentation;
    }
    if (law->compliance == 0.0 || indentation <= aoi_law_rest(law, memory)) {
        return law->potential(law, memory, indentation);
    }
    const double past = indentation - law->limit;
    if (!(past > 0.0)) {
        return inner_potential(law, memory, indentation);
    }
    aoi_law_value end;
    aoi_law_push(law, memory, law->limit, 0.0, &end);
    return inner_potential(law, memory, law->limit) +
           past * (end.force + 0.5 * end.stiffness * past);
}
