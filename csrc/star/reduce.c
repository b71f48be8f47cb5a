/* From the matrices of a body to its anti-oscillators: section 2 of the paper, with the unit vector
 * of dof i_0 replaced by any functional b. Eigenproblems and factorisations are the caller's. */
#include "star/reduce.h"
#include "linear/vector.h"

#include <float.h>
#include <math.h>

int aoi_static_constrained(size_t n, const double *b, double *x, double *stiffness)
{
    const double compliance = aoi_vector_dot(n, b, x);
    if (!(aoi_vector_dot(n, b, b) > 0.0)) {
        return AOI_ERROR_UNREACHED;
    }
    if (!isfinite(compliance)) {
        return AOI_ERROR_NOT_FINITE;
    }
    if (!(compliance > 0.0)) {
        return AOI_ERROR_NOT_POSITIVE;
    }
    for (size_t i = 0; i < n; i++) {
        x[i] /= compliance;
    }
    *stiffness = 1.0 / compliance;
    return isfinite(*stiffness) && aoi_vector_is_finite(n, x) ? AOI_OK : AOI_ERROR_NOT_FINITE;
}

int aoi_static_free(size_t n, size_t rigid_count, const double *rigid, const double *b,
                    double *phi_st, double *mass)
{
    double reach = 0.0, largest = 0.0;
    for (size_t i = 0; i < n; i++) {
        phi_st[i] = 0.0;
    }
    for (size_t j = 0; j < rigid_count; j++) {
        const double *mode = rigid + j * n;
        const double r = aoi_vector_dot(n, b, mode);
        reach += r * r;
        largest += aoi_vector_dot(n, b, b) * aoi_vector_dot(n, mode, mode);
        aoi_vector_add(n, r, mode, phi_st);
    }
    if (!isfinite(reach)) {
        return AOI_ERROR_NOT_FINITE;
    }
    /* r is a sum of n products: below this it is nothing but their rounding. */
    if (!(reach > 1e4 * DBL_EPSILON * DBL_EPSILON * largest)) {
        return AOI_ERROR_UNREACHED;
    }
    for (size_t i = 0; i < n; i++) {
        phi_st[i] /= reach;
    }
    *mass = 1.0 / reach;
    return isfinite(*mass) && aoi_vector_is_finite(n, phi_st) ? AOI_OK : AOI_ERROR_NOT_FINITE;
}

int aoi_constraint_project(size_t n, const double *b, const double *z, double *x)
{
    const double bz = aoi_vector_dot(n, b, z);
    if (!(bz > 0.0)) {
        return AOI_ERROR_NOT_POSITIVE;
    }
    /* Twice, because the first pass subtracts two large numbers where b is soft against the rest. */
    for (int pass = 0; pass < 2; pass++) {
        aoi_vector_add(n, -aoi_vector_dot(n, b, x) / bz, z, x);
    }
    return aoi_vector_is_finite(n, x) ? AOI_OK : AOI_ERROR_NOT_FINITE;
}

int aoi_constraint_reflector(size_t n, const double *b, double *h)
{
    const double norm = sqrt(aoi_vector_dot(n, b, b));
    if (!isfinite(norm)) {
        return AOI_ERROR_NOT_FINITE;
    }
    if (n == 0 || !(norm > 0.0)) {
        return AOI_ERROR_UNREACHED;
    }
    for (size_t i = 0; i < n; i++) {
        h[i] = b[i] / norm;
    }
    h[0] += b[0] < 0.0 ? -1.0 : 1.0;
    const double length = sqrt(aoi_vector_dot(n, h, h) / 2.0);
    for (size_t i = 0; i < n; i++) {
        h[i] /= length;
    }
    return AOI_OK;
}

void aoi_constraint_congruence(size_t n, const double *h, double *a, double *work)
{
    for (size_t j = 0; j < n; j++) {
        work[j] = aoi_vector_dot(n, a + j * n, h);
    }
    aoi_vector_add(n, -0.5 * aoi_vector_dot(n, h, work), h, work);
    for (size_t j = 0; j < n; j++) {
        double *column = a + j * n;
        for (size_t i = 0; i < n; i++) {
            column[i] -= h[i] * work[j] + work[i] * h[j];
        }
    }
}

int aoi_oscillators_project(size_t n, size_t count, const double *phi, const double *modal_mass,
                            const double *omega2, const double *m_phi_st, double *coefficient,
                            double *mass, double *stiffness)
{
    for (size_t j = 0; j < count; j++) {
        const double coupling = aoi_vector_dot(n, phi + j * n, m_phi_st);
        if (!isfinite(coupling)) {
            return AOI_ERROR_NOT_FINITE;
        }
        if (!(modal_mass[j] > 0.0) || !(omega2[j] > 0.0)) {
            return AOI_ERROR_NOT_POSITIVE;
        }
        coefficient[j] = coupling / modal_mass[j];
        mass[j] = coupling * coefficient[j];
        stiffness[j] = omega2[j] * mass[j];
        if (!isfinite(coefficient[j]) || !isfinite(mass[j]) || !isfinite(stiffness[j])) {
            return AOI_ERROR_NOT_FINITE;
        }
    }
    return AOI_OK;
}
