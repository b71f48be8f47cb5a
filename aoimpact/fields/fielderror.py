"""How wrong the motion of a whole body may be that a few shapes give.

There are two errors. The first is that of the correction (`Recovery`): it is as uncertain as it is
large, and its largest value persists as vibration. The second comes after the first contact, when
the body vibrates at the model's frequencies. If a mode φ of the model leaves the residual r = K φ -
λ M φ, a natural λ* lies within |(λ + s²)/(λ* + s²) - 1| ≤ |e|, e = (K + s²M)⁻¹ r in the norm of M,
|φ| = 1, or within |e|²/γ with the relative gap γ to the next mode of the model (bounds of the
symmetric problem (K + s²M)⁻¹ M; B. N. Parlett, The Symmetric Eigenvalue Problem, chapter 11). The
phase is then wrong by up to |ω - ω*| times the time since. The error is that share of the mode's
amplitude, kinetic energy included, since a wrong phase shows most where the mode passes through
zero. The force may be right all the same: it is over by then.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy

from ..base import FloatArray
from ..reduction import Recovery

__all__ = ["FieldError", "History"]


# Share of the largest mass over stiffness below which a coordinate has no inertia.
_NO_INERTIA = 1e-12

# Modes up to this many times s vibrate freely; faster ones follow the force.
_SLOW = 3.0


# The difference of two vibrations of one amplitude, root mean square, with phases unknown.
_OPPOSITE = math.sqrt(2.0)


@dataclass(frozen=True, eq=False)
class History:
    """The states of a reduced model at some times.

    Attributes
    ----------
    times : ndarray, shape (k,)
        s, ascending.
    coordinates, rates, forces : ndarrays, shapes (n, k), (n, k), (p, k)
    """

    times: FloatArray
    coordinates: FloatArray
    rates: FloatArray
    forces: FloatArray


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

        Modes much faster than s follow the force as the correction does; they have no drift.
        """
        reduced, s2 = self.recovery.reduced, self.recovery.s**2
        shifted = reduced.stiffness + s2 * np.diag(reduced.mass)
        inverse, y = scipy.linalg.eigh(np.diag(reduced.mass), shifted)
        inert = inverse > _NO_INERTIA * inverse.max()
        inverse, y = inverse[inert], y[:, inert]
        square = np.maximum(1.0 / inverse - s2, 0.0)
        drift, slow = np.zeros(len(square)), square < _SLOW**2 * s2
        if slow.any():
            # What the correction adds to a mode is e; |φ|² is 1/(λ + s²) in these modes.
            none = np.zeros((reduced.loads.shape[1], int(slow.sum())))
            left = self.recovery.amounts(y[:, slow], none)
            residual = np.sqrt(_energy(self._products[1], left) / inverse[slow])
            apart = np.abs(np.subtract.outer(inverse[slow], inverse))
            apart[apart == 0.0] = np.inf  # itself
            gap = apart.min(axis=1) / inverse[slow]
            off = np.minimum(residual, residual**2 / gap) / inverse[slow]
            swift = np.maximum(np.sqrt(square[slow]), np.sqrt(off))
            drift[slow] = off / (2.0 * np.where(swift > 0.0, swift, 1.0))  # rigid: none
        return square, (shifted @ y).T, drift

    def energies(self, coordinates: FloatArray, rates: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return twice the strain, and twice the kinetic energy of modes, J, (modes, times)."""
        square, shares, _ = self._modes
        weight = 1.0 / (square + self.recovery.s**2)
        strain: FloatArray = (square * weight)[:, None] * (shares @ coordinates) ** 2
        kinetic: FloatArray = weight[:, None] * (shares @ rates) ** 2
        return strain, kinetic

    def estimate(self, contact: History, at: History, since: FloatArray) -> FloatArray:
        """Return the errors at some times, relative to the largest motion, shape (times,).

        Parameters
        ----------
        contact, at : History
            During contact, and at the given times.
        since : ndarray, shape (times,)
            How long the body has vibrated freely, s; negative before it does.
        """
        strain, kinetic = self.energies(at.coordinates, at.rates)
        during = self.energies(contact.coordinates, contact.rates)[0].sum(axis=0)
        largest = max(float(of.max(initial=0.0)) for of in (strain.sum(axis=0), during))
        # An error of displacement persists as free vibration, whatever its value at a moment.
        missed = self._added(at), self._added(contact)
        largest = max(largest, *(float(of.max(initial=0.0)) for of in missed))
        if largest == 0.0:
            return np.zeros(len(since))
        before = np.maximum.accumulate(np.concatenate([[0.0], missed[1]]))
        so_far = before[np.searchsorted(contact.times, at.times, side="right")]
        wrong = np.maximum.accumulate(np.maximum(missed[0], so_far))
        # A mode with a wrong phase is most wrong where it passes through zero: by its amplitude.
        astray = np.minimum(_OPPOSITE, np.outer(self._modes[2], np.maximum(since, 0.0))) ** 2
        swing = ((strain + kinetic) * astray).sum(axis=0)
        error: FloatArray = np.sqrt((wrong + swing) / largest)
        return error

    @cached_property
    def _products(self) -> tuple[FloatArray, FloatArray]:
        """Products of the correction's shapes by way of K and of M, shapes (k, k)."""
        shapes, body = self.recovery.shapes, self.recovery.reduced.body
        return shapes.T @ (body.K @ shapes), shapes.T @ (body.M @ shapes)

    def _added(self, at: History) -> FloatArray:
        """Twice the strain energy of what the correction adds, J, shape (times,)."""
        return _energy(self._products[0], self.recovery.amounts(at.coordinates, at.forces))


def _energy(product: FloatArray, amounts: FloatArray) -> FloatArray:
    """xᵀ `product` x of each column x of `amounts`; not below 0 by rounding."""
    energy: FloatArray = np.einsum("it,it->t", amounts, product @ amounts)
    return np.maximum(energy, 0.0)
