/* Dense output: the record at any time of a track, from the row that holds it. Between the start of a
 * row and the time asked for, the bodies are taken on exactly as the run itself took them. */
#include "aoimpact.h"

/* The last of the rows that starts at or before time. */
static size_t row_at(size_t rows, size_t width, const double *track, double time)
{
    size_t low = 0, high = rows;
    while (high - low > 1) {
        const size_t middle = low + (high - low) / 2;
        if (track[middle * width + AOI_TRACK_START] <= time) {
            low = middle;
        } else {
            high = middle;
        }
    }
    return low;
}

/* x, v at a time of a row; gives force, indentation and its rate there. */
static void state_at(const aoi_relative *relative, const aoi_law *law, const double *row, double time,
                     double *x, double *v, aoi_law_value *value, double *indentation, double *rate)
{
    const size_t n = relative->n;
    const double length = row[AOI_TRACK_LENGTH];
    for (size_t j = 0; j < n; j++) {
        x[j] = row[AOI_TRACK_FIXED + j];
        v[j] = row[AOI_TRACK_FIXED + n + j];
    }
    const double flown = time - row[AOI_TRACK_START];
    aoi_relative_fly(relative, flown, x, v);
    *value = (aoi_law_value){0.0, 0.0, 0.0};
    const double place = length > 0.0 ? flown / length : 0.0;
    if (row[AOI_TRACK_CONTACT] == 1.0 && place > 0.0) {
        aoi_collocation_push(length, relative, row + AOI_TRACK_FORCE, place, x, v);
    }
    aoi_relative_indentation(relative, x, v, indentation, rate);
    if (row[AOI_TRACK_CONTACT] == 1.0) {
        double slope;
        *indentation =
            aoi_legendre_evaluate(AOI_STAGES + 1, row + AOI_TRACK_INDENTATION, place, &slope);
        *rate = length > 0.0 ? slope / length : *rate;
        law->force(law, *indentation, *rate, value);
    }
}

/* The six rows of one body: modes first .. last-1, sign of their share in the indentation. */
static void write_body(const aoi_relative *relative, size_t first, size_t last, double sign,
                       double residual, const aoi_law_value *value, double rate,
                       const double *centre_weight, double centre_residual, const double *x,
                       const double *v, double *const *row, size_t column)
{
    const double held_back = sign * residual * value->force;
    const double held_back_rate = sign * residual * value->stiffness * rate;
    double seen[AOI_ROW_BODY_COUNT] = {-held_back, -held_back_rate,
                                       -sign * centre_residual * value->force,
                                       -sign * centre_residual * value->stiffness * rate,
                                       0.0,
                                       0.5 * residual * value->force * value->force};
    for (size_t j = first; j < last; j++) {
        const double omega_x = relative->omega[j] * x[j];
        seen[0] += sign * x[j];
        seen[1] += sign * v[j];
        seen[2] += sign * centre_weight[j] * x[j];
        seen[3] += sign * centre_weight[j] * v[j];
        if (relative->weight[j] > 0.0) { /* a wall's energy is not counted */
            seen[4] += 0.5 * v[j] * v[j] / relative->weight[j];
            seen[5] += 0.5 * omega_x * omega_x / relative->weight[j];
        }
    }
    for (int i = 0; i < AOI_ROW_BODY_COUNT; i++) {
        if (row[i]) {
            row[i][column] = seen[i];
        }
    }
}

int aoi_track_sample(const aoi_relative *relative, const aoi_law *law, const aoi_centres *centres,
                     size_t rows, const double *track, size_t count, const double *times,
                     double *const *row, double *work)
{
    const size_t n = relative->n, width = AOI_TRACK_FIXED + 2 * n;
    double *x = work, *v = work + n;
    if (rows == 0) {
        return AOI_ERROR_ARGUMENT;
    }
    for (size_t i = 0; i < count; i++) {
        const double *here = track + row_at(rows, width, track, times[i]) * width;
        aoi_law_value value;
        double indentation, rate;
        state_at(relative, law, here, times[i], x, v, &value, &indentation, &rate);
        if (row[AOI_ROW_FORCE]) {
            row[AOI_ROW_FORCE][i] = value.force;
        }
        if (row[AOI_ROW_INDENTATION]) {
            row[AOI_ROW_INDENTATION][i] = indentation;
        }
        if (row[AOI_ROW_CONTACT_ENERGY]) {
            row[AOI_ROW_CONTACT_ENERGY][i] = law->potential(law, indentation);
        }
        write_body(relative, 0, relative->n_projectile, 1.0, relative->residual[0], &value, rate,
                   centres->weight, centres->residual[0], x, v, row + AOI_ROW_BODY, i);
        write_body(relative, relative->n_projectile, n, -1.0, relative->residual[1], &value, rate,
                   centres->weight, centres->residual[1], x, v,
                   row + AOI_ROW_BODY + AOI_ROW_BODY_COUNT, i);
    }
    return AOI_OK;
}
