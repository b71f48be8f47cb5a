"""How wrong the motion of a whole body may be that a few shapes give.

Two things go wrong. What the correction (recovery.py) adds to the shapes is as uncertain as it is
large, and what it was at the largest force rings on. And after the blow the body swings on with the
model's frequencies: where K φ - λ M φ = r is left of a mode φ, there is a natural λ* with
|(λ + s²)/(λ* + s²) - 1| ≤ |e|, e = (K + s²M)⁻¹ r in the norm of M, |φ| = 1, or |e|²/γ with the
relative gap γ to the next mode (the bounds of a symmetric problem, here (K + s²M)⁻¹ M; B. N.
Parlett, The Symmetric Eigenvalue Problem, chapter 11; the gap is the model's own), and the phase
goes astray by up to |ω - ω*| times the time since. The force may be right all
the same: it is over by then.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt
import scipy.linalg as la

from .recovery import Recovery

__all__ = ["FieldError"]

FloatArray = npt.NDArray[np.float64]

# Of the largest mass over stiffness: what is less belongs to coordinates without inertia.
_NO_INERTIA = 1e-12


@dataclass(frozen=True, eq=False)
class FieldError:
    """Estimates of relative errors of displacement in the norm of strain energy.

    Attributes
    ----------
    recovery : Recovery
    """

    recovery: Recovery

    @cached_property
    def _modes(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """λ of the model's modes, their shares of coordinates, shape (n, n), and |ω - ω*|, rad/s.

        Modes faster than s follow the blow as the correction does; they count with no drift.
        """
        reduced, s2 = self.recovery.reduced, self.recovery.s**2
        shifted = reduced.stiffness + s2 * np.diag(reduced.mass)
        inverse, y = la.eigh(np.diag(reduced.mass), shifted)
        inert = inverse > _NO_INERTIA * inverse.max()
        inverse, y = inverse[inert], y[:, inert]
        square = np.maximum(1.0 / inverse - s2, 0.0)
        drift, slow = np.zeros(len(square)), square < s2
        if slow.any():
            mass = reduced.body.M
            shapes = reduced.basis @ y[:, slow]
            moved = self.recovery.solve(mass @ shapes)
            left = shapes - moved / inverse[slow]
            norms = [np.sqrt(np.einsum("it,it->t", x, mass @ x)) for x in (left, shapes)]
            residual = norms[0] / norms[1]
            apart = np.abs(np.subtract.outer(inverse[slow], inverse))
            apart[apart == 0.0] = np.inf  # itself
            gap = apart.min(axis=1) / inverse[slow]
            off = np.minimum(residual, residual**2 / gap) / inverse[slow]
            drift[slow] = off / (2.0 * np.maximum(np.sqrt(square[slow]), np.sqrt(off)))
        return square, (shifted @ y).T, drift

    def energies(self, coordinates: FloatArray) -> FloatArray:
        """Return twice the strain energy of the model's modes, J, shape (modes, times)."""
        square, shares, _ = self._modes
        s2 = self.recovery.s**2
        energies: FloatArray = (square / (square + s2))[:, None] * (shares @ coordinates) ** 2
        return energies

    def estimate(
        self,
        coordinates: FloatArray,
        forces: FloatArray,
        since: FloatArray,
        peak: tuple[FloatArray, FloatArray],
    ) -> FloatArray:
        """Return the errors at some times, relative to the largest motion, shape (times,).

        Parameters
        ----------
        coordinates, forces : ndarrays, shapes (n, times), (p, times)
        since : ndarray, shape (times,)
            How long ago the blow was over, s; zero before that.
        peak : (coordinates, forces), shapes (n, 1), (p, 1)
            At the largest force.
        """
        energies = self.energies(coordinates)
        largest = max(float(energies.sum(axis=0).max()), float(self.energies(peak[0]).sum()))
        if largest == 0.0:
            return np.zeros(coordinates.shape[1])
        missed = self._added(coordinates, forces)
        missed = np.where(since > 0.0, np.maximum(missed, self._added(*peak)), missed)
        astray = np.minimum(1.0, np.outer(self._modes[2], since)) ** 2
        error: FloatArray = np.sqrt((missed + (energies * astray).sum(axis=0)) / largest)
        return error

    def _added(self, coordinates: FloatArray, forces: FloatArray) -> FloatArray:
        """Twice the strain energy of what the correction adds, J, shape (times,)."""
        reduced = self.recovery.reduced
        added = self.recovery.displacement(coordinates, forces) - reduced.basis @ coordinates
        energy: FloatArray = np.einsum("it,it->t", added, reduced.body.K @ added)
        return energy
