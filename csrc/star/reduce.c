/* Reduction of a body, given by its constraint modes, to anti-oscillators: section 2 of the paper, with the unit
 * vector of dof i_0 replaced by any functional b. Eigenproblems and factorisations are left to the caller. */
#include "aoimpact.h"
#include "linear/vector.h"

#include <float.h>
#include <math.h>

/* Largest relative difference of omega^2 between modes that are combined in one oscillator. */
static const double EQUAL = 1e-9;

/* Mass of a mode, as a share of the static mass, below which it counts as zero (rounding error). */
static const double NO_MASS = 1e-13;

/* Residual mass, as a share of the static mass, below which it counts as zero: the rounding error of a sum of
 * thousands of masses. */
static const double MASS_ROUNDING = 1e-11;

/* Rounding error of an eigenvalue, as a share of the largest eigenvalue. */
static const double EIGEN_ROUNDING = 10.0 * DBL_EPSILON;

/* Finds the largest mass of a mode that counts as zero, as a share of the static mass: share[1] for modes whose
 * eigenvalue is within the rounding error of the largest, share[0] for others. Returns that rounding error. A mode
 * with such an eigenvalue contains a part of the lowest mode above the rounding error: to first order, the ratio
 * of the rounding error to the distance of both eigenvalues. Eigenvalues of LAPACK have an error of the rounding
 * of the largest times a modest number (LAPACK Users' Guide, 4.10). */
static double least_shares(size_t count, const double *omega2, double share[2])
{
    const double lost = count > 0 ? fmax(EIGEN_ROUNDING * omega2[count - 1], 0.0) : 0.0;
    size_t above = 0;
    while (above < count && !(omega2[above] > lost)) {
        above++;
    }
    const double mixed = above < count ? lost / omega2[above] : 0.0;
    share[0] = NO_MASS;
    share[1] = fmax(NO_MASS, mixed * mixed);
    return lost;
}

int aoi_star_from_constraint_modes(size_t n, size_t count, const double *phi_st, const double *m_phi_st, double k0,
                                   const double *phi, const double *m_phi, const double *omega2, aoi_star *star,
                                   double *m, double *k, double *coefficient, int32_t *oscillator)
{
    const double static_mass = aoi_vector_dot(n, phi_st, m_phi_st);
    double share[2], last = -HUGE_VAL, residual = static_mass;
    size_t size = 0;
    if (count > INT32_MAX) {
        return AOI_ERROR_ARGUMENT;
    }
    if (!isfinite(static_mass) || !isfinite(k0) || !aoi_vector_is_finite(count, omega2)) {
        return AOI_ERROR_NOT_FINITE;
    }
    if (!(static_mass > 0.0) || k0 < 0.0) {
        return AOI_ERROR_NOT_POSITIVE;
    }
    const double lost = least_shares(count, omega2, share);
    for (size_t j = 0; j < count; j++) {
        const double *mode = phi + j * n;
        const double coupling = aoi_vector_dot(n, mode, m_phi_st), own = aoi_vector_dot(n, mode, m_phi + j * n);
        if (!isfinite(coupling) || !isfinite(own)) {
            return AOI_ERROR_NOT_FINITE;
        }
        if (j > 0 && omega2[j] < omega2[j - 1]) {
            return AOI_ERROR_ARGUMENT;
        }
        coefficient[j] = 0.0;
        oscillator[j] = -1;
        if (!(coupling * coupling > share[omega2[j] <= lost] * static_mass * own)) {
            continue;
        }
        if (!(own > 0.0) || !(omega2[j] > 0.0)) {
            return AOI_ERROR_NOT_POSITIVE;
        }
        coefficient[j] = coupling / own;
        const double mass = coupling * coefficient[j], stiffness = omega2[j] * mass;
        if (size == 0 || omega2[j] - last > EQUAL * omega2[j]) {
            m[size] = k[size] = 0.0;
            size++;
        }
        last = omega2[j];
        m[size - 1] += mass;
        k[size - 1] += stiffness;
        oscillator[j] = (int32_t)(size - 1);
        residual -= mass;
    }
    /* It suffices to check the sums: a value of a mode that is not finite makes a sum not finite. */
    if (!isfinite(residual) || !aoi_vector_is_finite(size, k)) {
        return AOI_ERROR_NOT_FINITE;
    }
    if (fabs(residual) < MASS_ROUNDING * static_mass) {
        residual = 0.0;
    }
    *star = (aoi_star){size, residual, k0, m, k};
    return AOI_OK;
}
