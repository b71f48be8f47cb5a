/* One step of contact: the force as a polynomial through the Radau nodes, its effect on the bodies
 * exact, Newton on its values. What is linear is never discretised, so a stiff oscillator that
 * nobody excites asks for no short step. */
#include "aoimpact.h"

#include <float.h>
#include <math.h>

#include "collocation_data.inc"

enum { MOST_ITERATIONS = 25 };

/* Below this, sin is summed by its series, over all modes at once; above, by Bessel functions. */
static const double SERIES_LIMIT = 3.0;

size_t aoi_collocation_size(size_t n) { return 4 * AOI_STAGES * n; }

/* Row i of the influence: sum_j weight_j int_0^(c_i h) sin(omega_j (c_i h - t)) / omega_j l_k dt. */
static void influence_row(aoi_collocation *step, const aoi_relative *relative, size_t i)
{
    const double h = step->h;
    double sum_of_powers[MOMENTS] = {0.0}, by_legendre[AOI_STAGES] = {0.0};
    int has_fast_modes = 0;
    for (size_t j = 0; j < relative->n; j++) {
        const double z = relative->omega[j] * h, at_node = z * node[i];
        if (at_node <= SERIES_LIMIT) {
            double power = relative->weight[j];
            for (size_t m = 0; m < MOMENTS && power != 0.0; m++) {
                sum_of_powers[m] += power;
                power *= -z * z;
            }
        } else {
            double sine[AOI_STAGES], cosine[AOI_STAGES];
            const double scale = relative->weight[j] * node[i] * h / relative->omega[j];
            aoi_bessel_trigonometric(at_node, AOI_STAGES, sine, cosine);
            for (size_t l = 0; l < AOI_STAGES; l++) {
                by_legendre[l] += scale * sine[l];
            }
            has_fast_modes = 1;
        }
    }
    for (size_t k = 0; k < AOI_STAGES; k++) {
        double sum = 0.0;
        for (size_t m = 0; m < MOMENTS; m++) {
            sum += sum_of_powers[m] * moment[m][i][k];
        }
        step->influence[i][k] = sum * h * h;
    }
    for (size_t q = 0; q < AOI_STAGES && has_fast_modes; q++) {
        const double on_whole = aoi_vector_dot(q + 1, shrink[i][q], by_legendre);
        aoi_vector_add(AOI_STAGES, on_whole, to_legendre[q], step->influence[i]);
    }
}

/* Column j of the four tables: a mode's free motion to the nodes, and what F does to it. */
static void mode_tables(aoi_collocation *step, const aoi_relative *relative, size_t j)
{
    const double h = step->h, omega = relative->omega[j];
    double sine[AOI_STAGES] = {0.5, -1.0 / 6.0}, cosine[AOI_STAGES] = {1.0};
    double sine_scale = h * h;
    for (size_t i = 0; i < AOI_STAGES; i++) {
        const double z = omega * h * node[i];
        const double half = sin(0.5 * z);
        step->cosine[i * relative->n + j] = -2.0 * half * half; /* cos z - 1 */
        step->sine[i * relative->n + j] = z > 0.0 ? sin(z) / omega : h * node[i];
    }
    if (omega * h > DBL_EPSILON) {
        aoi_bessel_trigonometric(omega * h, AOI_STAGES, sine, cosine);
        sine_scale = h / omega;
    }
    for (size_t k = 0; k < AOI_STAGES; k++) {
        double sine_sum = 0.0, cosine_sum = 0.0;
        for (size_t q = 0; q < AOI_STAGES; q++) {
            sine_sum += sine[q] * to_legendre[q][k];
            cosine_sum += cosine[q] * to_legendre[q][k];
        }
        step->to_x[k * relative->n + j] = sine_scale * sine_sum;
        step->to_v[k * relative->n + j] = h * cosine_sum;
    }
}

static void defect_table(aoi_collocation *step, const aoi_relative *relative)
{
    for (size_t i = 0; i < AOI_STAGES; i++) {
        const double left = step->h * (1.0 - extra[i]);
        double displacement = 0.0;
        for (size_t j = 0; j < relative->n; j++) {
            const double z = relative->omega[j] * left;
            displacement += relative->weight[j] * (z > 0.0 ? sin(z) / relative->omega[j] : left);
        }
        step->defect[i] = displacement * step->h * extra_weight[i];
    }
}

void aoi_collocation_make(aoi_collocation *step, const aoi_relative *relative, double h,
                          double *block)
{
    const size_t size = AOI_STAGES * relative->n;
    step->h = h;
    step->cosine = block;
    step->sine = block + size;
    step->to_x = block + 2 * size;
    step->to_v = block + 3 * size;
    for (size_t i = 0; i < AOI_STAGES; i++) {
        influence_row(step, relative, i);
        step->influence[i][i] += relative->residual[0] + relative->residual[1];
    }
    for (size_t j = 0; j < relative->n; j++) {
        mode_tables(step, relative, j);
    }
    defect_table(step, relative);
}

void aoi_collocation_homogeneous(const aoi_collocation *step, const aoi_relative *relative,
                                 double start, const double *x, const double *v,
                                 double *indentation)
{
    const size_t n = relative->n;
    double acceleration = 0.0;
    for (size_t j = 0; j < n; j++) {
        acceleration += relative->omega[j] > 0.0 ? 0.0 : relative->load[j];
    }
    for (size_t i = 0; i < AOI_STAGES; i++) {
        const double time = step->h * node[i];
        indentation[i] = start + (aoi_vector_dot(n, step->cosine + i * n, x) +
                                  aoi_vector_dot(n, step->sine + i * n, v) +
                                  0.5 * acceleration * time * time);
    }
}

/* Gauss without pivoting: I + influence diag(stiffness), with influence nearly a Volterra operator,
 * has pivots near or above one. */
static void eliminate(double matrix[AOI_STAGES][AOI_STAGES], double *right)
{
    for (size_t k = 0; k < AOI_STAGES; k++) {
        const double inverse = 1.0 / matrix[k][k];
        for (size_t i = k + 1; i < AOI_STAGES; i++) {
            const double factor = matrix[i][k] * inverse;
            for (size_t q = k + 1; q < AOI_STAGES; q++) {
                matrix[i][q] -= factor * matrix[k][q];
            }
            right[i] -= factor * right[k];
        }
    }
    for (size_t k = AOI_STAGES; k-- > 0;) {
        for (size_t q = k + 1; q < AOI_STAGES; q++) {
            right[k] -= matrix[k][q] * right[q];
        }
        right[k] /= matrix[k][k];
    }
}

/* One Newton iteration; returns the largest change. */
static double newton(const aoi_collocation *step, const aoi_law *law, const double *homogeneous,
                     double *indentation, double *force)
{
    double matrix[AOI_STAGES][AOI_STAGES], change[AOI_STAGES], stiffness[AOI_STAGES];
    double largest = 0.0;
    for (size_t i = 0; i < AOI_STAGES; i++) {
        aoi_law_value value;
        law->force(law, indentation[i], 0.0, &value);
        force[i] = value.force;
        stiffness[i] = value.stiffness;
    }
    for (size_t i = 0; i < AOI_STAGES; i++) {
        change[i] = homogeneous[i] - indentation[i] -
                    aoi_vector_dot(AOI_STAGES, step->influence[i], force);
        for (size_t k = 0; k < AOI_STAGES; k++) {
            matrix[i][k] = step->influence[i][k] * stiffness[k];
        }
        matrix[i][i] += 1.0;
    }
    eliminate(matrix, change);
    for (size_t i = 0; i < AOI_STAGES; i++) {
        indentation[i] += change[i];
        largest = fabs(change[i]) <= largest ? largest : fabs(change[i]);
    }
    return largest;
}

int aoi_collocation_solve(const aoi_collocation *step, const aoi_law *law,
                          const double *homogeneous, double scale, double *indentation,
                          double *force)
{
    double before = HUGE_VAL;
    for (int i = 0; i < MOST_ITERATIONS; i++) {
        const double change = newton(step, law, homogeneous, indentation, force);
        if (!isfinite(change)) {
            return AOI_ERROR_NO_CONVERGENCE;
        }
        /* Converging quadratically, or at rounding where a change no longer shrinks. */
        if (change <= 1e-13 * scale || (change <= 1e-10 * scale && change >= 0.5 * before)) {
            for (size_t k = 0; k < AOI_STAGES; k++) {
                aoi_law_value value;
                law->force(law, indentation[k], 0.0, &value);
                force[k] = value.force;
            }
            return AOI_OK;
        }
        before = change;
    }
    return AOI_ERROR_NO_CONVERGENCE;
}

void aoi_collocation_propagate(const aoi_collocation *step, const aoi_relative *relative,
                               const double *force, double *x, double *v)
{
    const size_t n = relative->n, end = (AOI_STAGES - 1) * n;
    for (size_t j = 0; j < n; j++) {
        const double omega = relative->omega[j], x0 = x[j], v0 = v[j];
        double push = 0.0, kick = 0.0;
        for (size_t k = 0; k < AOI_STAGES; k++) {
            push += step->to_x[k * n + j] * force[k];
            kick += step->to_v[k * n + j] * force[k];
        }
        const double load = omega > 0.0 ? 0.0 : relative->load[j];
        x[j] = x0 + (step->cosine[end + j] * x0 + step->sine[end + j] * v0 +
                     0.5 * load * step->h * step->h - relative->weight[j] * push);
        v[j] = v0 + (step->cosine[end + j] * v0 - omega * omega * step->sine[end + j] * x0 +
                     load * step->h - relative->weight[j] * kick);
    }
}

void aoi_collocation_estimate(const aoi_collocation *step, const aoi_law *law, double start,
                              const double *indentation, const double *force, double *legendre,
                              aoi_collocation_error *error)
{
    double values[AOI_STAGES + 1] = {start};
    *error = (aoi_collocation_error){0.0, 0.0, 0.0};
    for (size_t i = 0; i < AOI_STAGES; i++) {
        values[i + 1] = indentation[i];
    }
    for (size_t i = 0; i < AOI_STAGES; i++) {
        aoi_law_value value;
        law->force(law, aoi_vector_dot(AOI_STAGES + 1, indentation_at_extra[i], values), 0.0, &value);
        const double defect = value.force - aoi_vector_dot(AOI_STAGES, force_at_extra[i], force);
        error->impulse += step->h * extra_weight[i] * defect;
        error->indentation += step->defect[i] * defect;
    }
    for (size_t k = 0; k <= AOI_STAGES; k++) {
        legendre[k] = aoi_vector_dot(AOI_STAGES + 1, to_legendre_0[k], values);
    }
    error->tail = fabs(legendre[AOI_STAGES]) + 0.2 * fabs(legendre[AOI_STAGES - 1]);
}

void aoi_collocation_guess(const aoi_collocation *step, double last_length, const double *last,
                           const double *homogeneous, double *indentation)
{
    for (size_t i = 0; i < AOI_STAGES; i++) {
        indentation[i] = homogeneous[i];
        if (last_length > 0.0 && step->h <= 2.0 * last_length) {
            double slope;
            const double drawn_on = aoi_legendre_evaluate(
                AOI_STAGES + 1, last, 1.0 + node[i] * step->h / last_length, &slope);
            indentation[i] = drawn_on < homogeneous[i] ? drawn_on : homogeneous[i];
        }
    }
}

/* The zero of the polynomial (or of its slope) between two places where its sign differs: the
 * secant method, Illinois variant. */
static double zero_between(const double *legendre, int of_slope, double low, double high)
{
    double slope, value_low, value_high;
    value_low = aoi_legendre_evaluate(AOI_STAGES + 1, legendre, low, &slope);
    value_low = of_slope ? slope : value_low;
    value_high = aoi_legendre_evaluate(AOI_STAGES + 1, legendre, high, &slope);
    value_high = of_slope ? slope : value_high;
    if ((value_low > 0.0) == (value_high > 0.0)) { /* rounding has taken the change of sign */
        return fabs(value_low) < fabs(value_high) ? low : high;
    }
    int side = 0;
    for (int i = 0; i < 60 && high - low > DBL_EPSILON && value_high != value_low; i++) {
        const double at = low - value_low * (high - low) / (value_high - value_low);
        double value = aoi_legendre_evaluate(AOI_STAGES + 1, legendre, at, &slope);
        value = of_slope ? slope : value;
        if (value == 0.0) {
            return at;
        }
        if ((value > 0.0) == (value_low > 0.0)) {
            low = at;
            value_low = value;
            value_high *= side == 1 ? 0.5 : 1.0;
            side = 1;
        } else {
            high = at;
            value_high = value;
            value_low *= side == 2 ? 0.5 : 1.0;
            side = 2;
        }
    }
    return fabs(value_low) < fabs(value_high) ? low : high;
}

int aoi_collocation_release(const double *indentation, const double *legendre, double *place)
{
    int changes = 0, in_touch = 1;
    for (size_t i = 0; i < AOI_STAGES; i++) {
        const int touches = indentation[i] > 0.0;
        if (touches != in_touch) {
            if (++changes == 1 && i > 0) {
                *place = zero_between(legendre, 0, node[i - 1], node[i]);
            } else if (i == 0) {
                *place = node[0];
            }
        }
        in_touch = touches;
    }
    return changes;
}

int aoi_collocation_deepest(const double *legendre, double *place, double *indentation)
{
    double slope, before = 0.0, slope_before;
    int found = 0;
    (void)aoi_legendre_evaluate(AOI_STAGES + 1, legendre, 0.0, &slope_before);
    *indentation = 0.0;
    for (size_t i = 0; i < AOI_STAGES; i++) {
        (void)aoi_legendre_evaluate(AOI_STAGES + 1, legendre, node[i], &slope);
        if (slope_before > 0.0 && slope <= 0.0) {
            const double at = zero_between(legendre, 1, before, node[i]);
            const double value = aoi_legendre_evaluate(AOI_STAGES + 1, legendre, at, &slope_before);
            if (value > *indentation) {
                *indentation = value;
                *place = at;
                found = 1;
            }
        }
        before = node[i];
        slope_before = slope;
    }
    return found;
}

double aoi_collocation_impulse(const aoi_collocation *step, const double *force)
{
    return step->h * aoi_vector_dot(AOI_STAGES, to_legendre[0], force);
}

void aoi_collocation_push(double h, const aoi_relative *relative, const double *force, double place,
                          double *x, double *v)
{
    double legendre[AOI_STAGES], shrunk[AOI_STAGES], on_part[AOI_STAGES];
    const double length = place * h;
    for (size_t k = 0; k < AOI_STAGES; k++) {
        legendre[k] = aoi_vector_dot(AOI_STAGES, to_legendre[k], force);
    }
    for (size_t i = 0; i < AOI_STAGES; i++) {
        double slope;
        shrunk[i] = aoi_legendre_evaluate(AOI_STAGES, legendre, place * node[i], &slope);
    }
    for (size_t k = 0; k < AOI_STAGES; k++) {
        on_part[k] = aoi_vector_dot(AOI_STAGES, to_legendre[k], shrunk);
    }
    for (size_t j = 0; j < relative->n; j++) {
        double sine[AOI_STAGES] = {0.5, -1.0 / 6.0}, cosine[AOI_STAGES] = {1.0};
        const double omega = relative->omega[j];
        const int turns = omega * length > DBL_EPSILON;
        if (turns) {
            aoi_bessel_trigonometric(omega * length, AOI_STAGES, sine, cosine);
        }
        const double reach = turns ? length / omega : length * length;
        x[j] -= relative->weight[j] * reach * aoi_vector_dot(AOI_STAGES, sine, on_part);
        v[j] -= relative->weight[j] * length * aoi_vector_dot(AOI_STAGES, cosine, on_part);
    }
}

double aoi_legendre_evaluate(size_t count, const double *coefficient, double at, double *slope)
{
    const double xi = 2.0 * at - 1.0;
    double before = 1.0, here = xi, slope_before = 0.0, slope_here = 2.0;
    double value = coefficient[0];
    *slope = 0.0;
    for (size_t k = 1; k < count; k++) {
        const double kd = (double)k;
        value += coefficient[k] * here;
        *slope += coefficient[k] * slope_here;
        const double next = ((2.0 * kd + 1.0) * xi * here - kd * before) / (kd + 1.0);
        const double slope_next = slope_before + 2.0 * (2.0 * kd + 1.0) * here;
        before = here;
        here = next;
        slope_before = slope_here;
        slope_here = slope_next;
    }
    return value;
}
