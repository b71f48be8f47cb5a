"""Eigenpairs of dense symmetric pencils by LAPACK."""

from __future__ import annotations

import numpy as np
import scipy

from ..base import ROUNDING, FloatArray, SingularError

# Smallest pivot of M, relative to its diagonal, with which the reduction by M⁻¹ keeps the digits of
# low ω².
_LIGHT = 1e-6

# s², relative to the mean of K_ii over that of M_ii, where modes are found by (K + s²M)⁻¹.
_SHIFT = 1e-4


def dense_modes(
    stiffness: FloatArray, mass: FloatArray, n: int | None = None
) -> tuple[FloatArray, FloatArray]:
    """Return ω² and M-orthonormal φ of K φ = ω² M φ: the `n` lowest, or all.

    Motions without mass are no modes, so that there may be fewer.

    Parameters
    ----------
    stiffness, mass : ndarrays, shape (dofs, dofs)
        Symmetric, mass positive semidefinite and K + s²M definite; both may be overwritten.
    n : int, optional

    Raises
    ------
    SingularError
        If mass is not positive semidefinite, or LAPACK does not converge.
    """
    factor, failed = scipy.linalg.lapack.dpotrf(mass, lower=1)
    pivots = np.diagonal(factor) ** 2
    try:
        # A motion may have next to no mass, as where elements integrate it at few points.
        if failed or (pivots < _LIGHT * np.diagonal(mass)).any():
            return _of_light_motions(stiffness, mass, n)
        return _solved(stiffness, mass, n)
    except scipy.linalg.LinAlgError as error:
        raise SingularError(
            f"K and M have no modes that can be computed ({error}); give both with all their "
            "digits, hold what is too heavy to move, and condense out what has no mass"
        ) from None


def _of_light_motions(
    stiffness: FloatArray, mass: FloatArray, n: int | None
) -> tuple[FloatArray, FloatArray]:
    """The modes by M φ = θ (K + s²M) φ, θ = 1/(ω² + s²): θ = 0 is a motion without mass."""
    whole = float(np.trace(mass))
    if whole <= 0.0:
        raise scipy.linalg.LinAlgError("mass is not positive semidefinite")
    s2 = _SHIFT * float(np.trace(stiffness)) / whole
    inverse, modes = _solved(-mass, stiffness + s2 * mass, n)
    theta = -inverse
    if theta[-1] < -np.sqrt(ROUNDING) * theta[0]:
        raise scipy.linalg.LinAlgError("mass is not positive semidefinite")
    heavy = theta > ROUNDING * theta[0]
    return 1.0 / theta[heavy] - s2, modes[:, heavy] / np.sqrt(theta[heavy])


def _solved(
    stiffness: FloatArray, mass: FloatArray, n: int | None
) -> tuple[FloatArray, FloatArray]:
    some = None if n is None else [0, n - 1]
    found: tuple[FloatArray, FloatArray] = scipy.linalg.eigh(
        stiffness, mass, subset_by_index=some, overwrite_a=True, overwrite_b=True
    )
    return found
