/* The star (AO model) of Fig. 2 of the paper: its receptance, its energies, and its conversion to modes and back. */
#include "star/secular.h"
#include "linear/work.h"

#include <math.h>

int aoi_star_check(const aoi_star *star)
{
    if (isnan(star->m0) || !isfinite(star->k0) || (isinf(star->m0) && star->n > 0)) {
        return AOI_ERROR_NOT_FINITE;
    }
    if (star->n > 0 && (!star->m || !star->k)) {
        return AOI_ERROR_ARGUMENT;
    }
    if (star->m0 < 0.0 || star->k0 < 0.0 || (star->n == 0 && star->m0 == 0.0)) {
        return AOI_ERROR_NOT_POSITIVE;
    }
    for (size_t i = 0; i < star->n; i++) {
        if (!isfinite(star->m[i]) || !isfinite(star->k[i])) {
            return AOI_ERROR_NOT_FINITE;
        }
        if (star->m[i] <= 0.0 || star->k[i] <= 0.0) {
            return AOI_ERROR_NOT_POSITIVE;
        }
    }
    return AOI_OK;
}

double aoi_star_static_mass(const aoi_star *star)
{
    double sum = 0.0;
    for (size_t i = 0; i < star->n; i++) {
        sum += star->m[i];
    }
    return star->m0 + sum;
}

void aoi_star_receptance(const aoi_star *star, size_t count, const double *omega,
                         double *receptance)
{
    for (size_t j = 0; j < count; j++) {
        const double x = omega[j] * omega[j];
        double inertia = star->m0;
        for (size_t i = 0; i < star->n; i++) {
            inertia += star->k[i] / (star->k[i] / star->m[i] - x);
        }
        receptance[j] = isinf(star->m0) ? 0.0 : 1.0 / (star->k0 - x * inertia);
    }
}

void aoi_star_energy(const aoi_star *star, const double *u, const double *v, double *kinetic,
                     double *elastic)
{
    double twice_kinetic = isinf(star->m0) ? 0.0 : star->m0 * v[0] * v[0];
    double twice_elastic = star->k0 * u[0] * u[0];
    for (size_t i = 0; i < star->n; i++) {
        const double stretch = u[i + 1] - u[0];
        twice_kinetic += star->m[i] * v[i + 1] * v[i + 1];
        twice_elastic += star->k[i] * stretch * stretch;
    }
    *kinetic = 0.5 * twice_kinetic;
    *elastic = 0.5 * twice_elastic;
}

/* Returns the participation r of the natural mode with omega^2 = origin + offset: 1/sqrt(modal mass), for a mode
 * with unit displacement of the contact. The modal mass may overflow although its square root does not. */
static double natural_mode_share(const aoi_star *star, const double *antiresonance, double origin,
                                 double offset)
{
    double mass = star->m0, root = sqrt(star->m0);
    for (size_t i = 0; i < star->n; i++) {
        const double gain = antiresonance[i] / ((antiresonance[i] - origin) - offset);
        mass += star->m[i] * gain * gain;
    }
    if (!isinf(mass)) {
        return 1.0 / sqrt(mass);
    }
    for (size_t i = 0; i < star->n; i++) {
        const double gain = antiresonance[i] / ((antiresonance[i] - origin) - offset);
        root = hypot(root, sqrt(star->m[i]) * gain);
    }
    return 1.0 / root;
}

int aoi_star_to_modal(const aoi_star *star, double *omega2, double *participation,
                      size_t *mode_count, double *pole, const aoi_pause *pause)
{
    const size_t n = star->n;
    double stiffness = star->k0;
    int status = aoi_star_check(star);
    if (status != AOI_OK || isinf(star->m0)) {
        return status != AOI_OK ? status : AOI_ERROR_ARGUMENT;
    }
    for (size_t i = 0; i < n; i++) {
        pole[i] = star->k[i] / star->m[i];
        stiffness += star->k[i];
    }
    /* The largest eigenvalue is at most the sum of those of the two diagonal blocks. */
    const double ceiling = 2.0 * (stiffness / star->m0 + (n > 0 ? pole[n - 1] : 0.0));
    const aoi_secular minus_stiffness = {n, pole, star->k, -star->k0, star->m0, 1};
    *mode_count = star->m0 > 0.0 ? n + 1 : n;
    for (size_t j = 0; j < *mode_count; j++) {
        size_t nearest = n;
        double offset = n > 0 ? 0.0 : star->k0 / star->m0;
        if (n > 0 && (j > 0 || star->k0 > 0.0)) { /* otherwise this is the rigid mode, whose omega2 is exactly zero */
            status = aoi_secular_root(&minus_stiffness, (ptrdiff_t)j - 1, ceiling, &nearest, &offset);
        }
        if (status == AOI_OK && aoi_work_stops(pause)) {
            status = AOI_ERROR_STOPPED;
        }
        if (status != AOI_OK) {
            return status;
        }
        const double origin = nearest < n ? pole[nearest] : 0.0;
        omega2[j] = origin + offset;
        participation[j] = natural_mode_share(star, pole, origin, offset);
        if (!isfinite(omega2[j]) || !isfinite(participation[j]) || !(participation[j] > 0.0)) {
            return AOI_ERROR_NOT_FINITE;
        }
    }
    return AOI_OK;
}

int aoi_star_from_modal(size_t count, const double *omega2, const double *weight, double *m0,
                        double *k0, double *m, double *k, const aoi_pause *pause)
{
    const aoi_secular receptance = {count, omega2, weight, 0.0, 0.0, 0};
    double static_compliance = 0.0, inverse_mass = 0.0;
    if (count < 1 || omega2[0] < 0.0) {
        return AOI_ERROR_ARGUMENT;
    }
    for (size_t j = 0; j < count; j++) {
        if (!isfinite(omega2[j]) || !isfinite(weight[j])) {
            return AOI_ERROR_NOT_FINITE;
        }
        if (weight[j] <= 0.0) {
            return AOI_ERROR_NOT_POSITIVE;
        }
        inverse_mass += weight[j];
        static_compliance += weight[j] / omega2[j];
    }
    *m0 = 1.0 / inverse_mass;
    *k0 = omega2[0] > 0.0 ? 1.0 / static_compliance : 0.0;
    if (!isfinite(*m0) || !isfinite(*k0)) {
        return AOI_ERROR_NOT_FINITE;
    }
    for (size_t i = 0; i + 1 < count; i++) {
        size_t nearest;
        double offset, slope = 0.0;
        int status = aoi_secular_root(&receptance, (ptrdiff_t)i, 0.0, &nearest, &offset);
        if (status == AOI_OK && aoi_work_stops(pause)) {
            status = AOI_ERROR_STOPPED;
        }
        if (status != AOI_OK) {
            return status;
        }
        const double origin = nearest < count ? omega2[nearest] : 0.0;
        for (size_t j = 0; j < count; j++) {
            const double distance = (omega2[j] - origin) - offset;
            slope += weight[j] / (distance * distance);
        }
        const double antiresonance = origin + offset;
        k[i] = 1.0 / (antiresonance * slope);
        m[i] = k[i] / antiresonance;
        if (!isfinite(k[i]) || !isfinite(m[i])) {
            return AOI_ERROR_NOT_FINITE;
        }
    }
    return AOI_OK;
}
