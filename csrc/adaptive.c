/* The adaptive run: contact by collocation in steps of base 2^-level, flight in closed form.
 *
 * Two errors are kept below rtol in each step. The tail of the indentation's Legendre series says how
 * well the polynomial follows the motion within the step, so the peak; the integrated defect of the
 * force between the nodes says what the step hands on, so impulse, velocities and later times. Radau
 * nodes make the second far smaller than the first, except at the beginning and end of a contact,
 * where the force starts like d^(3/2). */
#include "aoimpact.h"

#include <float.h>
#include <math.h>

enum { DEEPEST_LEVEL = 60, HIGHEST_LEVEL = -40, LAST_LEVEL = 1000, MOST_STRIDES = 10000000 };

/* Shares of rtol: of the polynomial's tail, and of what one step may hand on. Errors add up over some
 * twenty steps of a contact, and grow from one contact to the next. */
static const double TAIL_SHARE = 0.3, STEP_SHARE = 0.1;

/* At the ends of a contact the force is no smooth function of time, and the quadrature of its defect
 * misses part of it. */
static const double END_SHARE = 0.03;

int aoi_adaptive_start(aoi_adaptive *run)
{
    if (!(run->rtol > 0.0) || !(run->end > run->time) || run->relative->n == 0) {
        return AOI_ERROR_ARGUMENT;
    }
    run->in_contact = 0;
    run->level = 0;
    run->base = run->indentation_scale = run->impulse_scale = 0.0;
    run->peak_force = run->impulse = run->last_length = 0.0;
    run->peak_time = run->time;
    run->steps = run->rejected = run->uses = 0;
    for (size_t i = 0; i < AOI_TABLES; i++) {
        run->table_use[i] = 0;
    }
    return AOI_OK;
}

/* The indentation at which the law holds an energy. */
static double deepest(const aoi_law *law, double energy)
{
    double low = -700.0, high = 100.0; /* logarithms */
    for (int i = 0; i < 40; i++) {
        const double middle = 0.5 * (low + high);
        if (law->potential(law, exp(middle)) < energy) {
            low = middle;
        } else {
            high = middle;
        }
    }
    return exp(high);
}

/* Scales of the contact that begins, as if nothing but the touching parts took part: lower bounds, so
 * that the first steps are rather too careful. */
static int touch(aoi_adaptive *run)
{
    const aoi_relative *relative = run->relative;
    double indentation, rate, weight = 0.0, amplitude = 0.0;
    aoi_law_value value;
    aoi_relative_indentation(relative, run->x, run->v, &indentation, &rate);
    for (size_t j = 0; j < relative->n; j++) {
        weight += relative->weight[j];
        amplitude += relative->omega[j] > 0.0
                         ? hypot(run->x[j], run->v[j] / relative->omega[j])
                         : (run->v[j] != 0.0 ? HUGE_VAL : 0.0);
    }
    const double energy = 0.5 * rate * rate / weight;
    if (!(energy > 0.0) || !isfinite(energy)) {
        return AOI_ERROR_NOT_FINITE;
    }
    /* A soft law lets held bodies swing through: then they turn back by themselves. */
    const double reach = fmin(deepest(run->law, energy), amplitude);
    run->law->force(run->law, reach, rate, &value);
    if (!(reach > 0.0) || !isfinite(value.force) || !isfinite(3.0 * reach / rate)) {
        return AOI_ERROR_NOT_FINITE;
    }
    run->indentation_scale = fmax(run->indentation_scale, reach);
    run->impulse_scale =
        fmax(run->impulse_scale, fmin(rate / weight, value.force * reach / rate));
    if (run->base == 0.0) {
        run->base = 3.0 * reach / rate;
    }
    /* The motion starts like t + t^(7/2): the first step resolves that to rtol. */
    const double first = 3.0 * reach / rate * pow(run->rtol, 1.0 / 3.5);
    const double levels = log2(run->base / first);
    if (!(fabs(levels) < DEEPEST_LEVEL)) {
        return AOI_ERROR_NOT_FINITE;
    }
    run->level = (int)ceil(levels);
    run->touched = run->time;
    run->elapsed = run->last_length = run->start = run->without_force = 0.0;
    run->in_contact = 1;
    return AOI_OK;
}

/* The tables of the present level: the one not used for longest makes room. The last step of a record
 * that ends in contact is as long as what is left, on no level. */
static const aoi_collocation *table_of_level(aoi_adaptive *run)
{
    const double left = run->end - run->time, h = ldexp(run->base, -run->level);
    const int wanted = h > left ? LAST_LEVEL : run->level;
    size_t oldest = 0;
    for (size_t i = 0; i < AOI_TABLES; i++) {
        if (run->table_use[i] > 0 && run->table_level[i] == wanted && wanted != LAST_LEVEL) {
            run->table_use[i] = ++run->uses;
            return &run->table[i];
        }
        oldest = run->table_use[i] < run->table_use[oldest] ? i : oldest;
    }
    aoi_collocation_make(&run->table[oldest], run->relative, h > left ? left : h,
                         run->block + oldest * aoi_collocation_size(run->relative->n));
    run->table_level[oldest] = wanted;
    run->table_use[oldest] = ++run->uses;
    return &run->table[oldest];
}

/* One try at a step. */
typedef struct attempt {
    double indentation[AOI_STAGES], force[AOI_STAGES], legendre[AOI_STAGES + 1];
    double largest; /* indentation */
    double growth; /* by which the step could be longer; below 1 it has failed */
} attempt;

static void try_step(const aoi_adaptive *run, const aoi_collocation *step, attempt *made)
{
    double homogeneous[AOI_STAGES], scale = 0.0;
    aoi_collocation_error error;
    made->growth = 0.0;
    made->largest = 0.0;
    aoi_collocation_homogeneous(step, run->relative, run->without_force, run->x, run->v,
                                homogeneous);
    aoi_collocation_guess(step, run->last_length, run->last, homogeneous, made->indentation);
    for (size_t i = 0; i < AOI_STAGES; i++) {
        scale = fmax(scale, fabs(made->indentation[i]));
    }
    if (aoi_collocation_solve(step, run->law, homogeneous, scale, made->indentation,
                              made->force) != AOI_OK) {
        return;
    }
    aoi_collocation_estimate(step, run->law, run->start, made->indentation, made->force,
                             made->legendre, &error);
    for (size_t i = 0; i < AOI_STAGES; i++) {
        made->largest = fmax(made->largest, made->indentation[i]);
    }
    const double reach = fmax(run->indentation_scale, made->largest);
    /* A massless contact changes its velocity at once where the force ends: a bend to fit. */
    const int at_an_end = run->last_length == 0.0 || made->indentation[AOI_STAGES - 1] <= 0.0;
    const int bends = run->relative->residual[0] + run->relative->residual[1] > 0.0;
    const double end_share = at_an_end ? END_SHARE : 1.0;
    /* No step can do better than rounding. */
    const double tail_share =
        fmax(TAIL_SHARE * (bends ? end_share : 1.0) * run->rtol, 8.0 * DBL_EPSILON);
    const double step_share = fmax(STEP_SHARE * end_share * run->rtol, 2.0 * DBL_EPSILON);
    /* A law of a high power makes more of an error of the indentation than Hertz's. */
    aoi_law_value value;
    run->law->force(run->law, made->largest, 0.0, &value);
    const double steepness =
        value.force > 0.0 ? value.stiffness * made->largest / (1.5 * value.force) : 1.0;
    const double within = fmax(steepness, 1.0) * error.tail / (tail_share * reach);
    const double handed_on =
        (fabs(error.impulse) / run->impulse_scale + fabs(error.indentation) / reach) / step_share;
    made->growth = 0.9 * fmin(pow(within, -1.0 / (AOI_STAGES + 1)),
                              pow(handed_on, -1.0 / (2 * AOI_STAGES)));
    if (within <= 1.0 && handed_on <= 1.0) {
        made->growth = fmax(made->growth, 1.0);
    } else { /* NaN, too, is no success */
        made->growth = made->growth < 0.9 ? made->growth : (isnan(within + handed_on) ? 0.0 : 0.9);
    }
}

static void note_peak(aoi_adaptive *run, const attempt *made, double h)
{
    double place = 1.0, indentation = made->indentation[AOI_STAGES - 1];
    aoi_law_value value;
    if (made->largest < 0.9 * run->indentation_scale && run->peak_force > 0.0) {
        run->law->force(run->law, made->largest, 0.0, &value);
        if (value.force < 0.9 * run->peak_force) {
            return;
        }
    }
    double inside_place, inside;
    if (aoi_collocation_deepest(made->legendre, &inside_place, &inside) && inside > indentation) {
        place = inside_place;
        indentation = inside;
    }
    run->law->force(run->law, indentation, 0.0, &value);
    if (value.force > run->peak_force) {
        run->peak_force = value.force;
        run->peak_time = run->time + place * h;
    }
}

/* Writes the row of what happens next: state, start, kind. */
static void begin_row(const aoi_adaptive *run, double *row, double contact)
{
    const size_t n = run->relative->n;
    row[AOI_TRACK_START] = run->time;
    row[AOI_TRACK_CONTACT] = contact;
    row[AOI_TRACK_RELEASE] = -1.0;
    for (size_t i = AOI_TRACK_FORCE; i < AOI_TRACK_FIXED; i++) {
        row[i] = 0.0;
    }
    for (size_t j = 0; j < n; j++) {
        row[AOI_TRACK_FIXED + j] = run->x[j];
        row[AOI_TRACK_FIXED + n + j] = run->v[j];
    }
}

static void accept(aoi_adaptive *run, const aoi_collocation *step, const attempt *made,
                   double release, double *row)
{
    begin_row(run, row, 1.0);
    row[AOI_TRACK_LENGTH] = step->h;
    for (size_t i = 0; i < AOI_STAGES; i++) {
        row[AOI_TRACK_FORCE + i] = made->force[i];
    }
    for (size_t i = 0; i <= AOI_STAGES; i++) {
        row[AOI_TRACK_INDENTATION + i] = run->last[i] = made->legendre[i];
    }
    note_peak(run, made, step->h);
    run->impulse += aoi_collocation_impulse(step, made->force);
    run->impulse_scale = fmax(run->impulse_scale, run->impulse);
    run->indentation_scale = fmax(run->indentation_scale, made->largest);
    aoi_collocation_propagate(step, run->relative, made->force, run->x, run->v);
    run->start = made->indentation[AOI_STAGES - 1];
    run->without_force =
        run->start + (run->relative->residual[0] + run->relative->residual[1]) *
                         made->force[AOI_STAGES - 1];
    if (release >= 0.0) {
        row[AOI_TRACK_RELEASE] = run->touched + (run->elapsed + release * step->h);
        run->in_contact = 0;
    }
    run->time = step->h < run->end - run->time ? run->touched + (run->elapsed + step->h) : run->end;
    run->elapsed += step->h;
    run->last_length = step->h;
    run->steps++;
    const int longer = (made->growth >= 2.0) + (made->growth >= 4.0) + (made->growth >= 8.0);
    run->level = run->level - longer > HIGHEST_LEVEL ? run->level - longer : HIGHEST_LEVEL;
}

static int contact_step(aoi_adaptive *run, double *row)
{
    while (run->level < DEEPEST_LEVEL) {
        const aoi_collocation *step = table_of_level(run);
        if (!(run->elapsed + step->h > run->elapsed)) {
            break; /* shorter than the clock can tell */
        }
        attempt made;
        double release = -1.0;
        try_step(run, step, &made);
        if (made.growth >= 1.0) {
            const int changes =
                aoi_collocation_release(made.indentation, made.legendre, &release);
            /* More than one end, or an end before the first node: look closer. */
            if (changes == 0 || (changes == 1 && made.indentation[0] > 0.0)) {
                accept(run, step, &made, release, row);
                return AOI_OK;
            }
            made.growth = 0.4;
        }
        run->rejected++;
        run->level += 1 + (made.growth < 0.25) + 2 * (made.growth < 0.06);
    }
    return AOI_ERROR_TOLERANCE;
}

static int flight(aoi_adaptive *run, double *row)
{
    double flown;
    int touches;
    begin_row(run, row, 0.0);
    int status =
        aoi_relative_next_touch(run->relative, run->order, run->end - run->time, MOST_STRIDES,
                                run->x, run->v, &flown, &touches);
    row[AOI_TRACK_LENGTH] = flown;
    run->time = touches ? run->time + flown : run->end;
    if (status == AOI_OK && touches) {
        status = touch(run);
    }
    return status;
}

int aoi_adaptive_run(aoi_adaptive *run, size_t capacity, double *track, size_t *rows)
{
    const size_t width = AOI_TRACK_FIXED + 2 * run->relative->n;
    *rows = 0;
    while (run->time < run->end && *rows < capacity) {
        double *row = track + *rows * width;
        const int status = run->in_contact ? contact_step(run, row) : flight(run, row);
        if (status != AOI_OK) {
            return status;
        }
        *rows += run->in_contact || row[AOI_TRACK_LENGTH] > 0.0;
    }
    return AOI_OK;
}
