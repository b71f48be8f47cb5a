"""A star in its natural modes: the coordinates in which its motion has a closed form.

Mode j moves the contact coordinate by its participation r_j and oscillator i by ω_i²/(ω_i² - ω_j²)
times that.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..base import FloatArray
from .star import AOModel

__all__ = ["StarModes", "star_modes"]


@dataclass(frozen=True, eq=False)
class StarModes:
    """Natural modes of a star, mass-normalised.

    Attributes
    ----------
    star : AOModel
    omega : ndarray, shape (n,)
        rad/s, ascending.
    participation : ndarray, shape (n,)
        r_j, 1/√kg; zero for a wall's one mode.
    residual : float
        Compliance left where the contact has no mass, m/N.
    """

    star: AOModel
    omega: FloatArray
    participation: FloatArray
    residual: float

    @cached_property
    def gain(self) -> FloatArray:
        """How far oscillator i moves per unit of the contact in mode j, shape (oscillators, n)."""
        antiresonance = self.star.k / self.star.m
        distance = np.subtract.outer(antiresonance, self.omega**2)
        gain: FloatArray = antiresonance[:, None] / np.where(distance == 0.0, np.inf, distance)
        return gain

    @cached_property
    def centre(self) -> tuple[FloatArray, float]:
        """Motion of the centre of mass per unit of the contact: by mode, by residual compliance."""
        weights = self.star.centre_weights
        if not self.star.constrained:  # elastic modes of a free body do not move its centre of mass
            return np.where(self.omega == 0.0, weights.sum(), 0.0), 0.0
        return weights[0] + weights[1:] @ self.gain, float(weights[0])

    @cached_property
    def decay(self) -> FloatArray:
        """σ_j, 1/s, of the star's damping; zero without."""
        damping = self.star.damping
        return np.zeros_like(self.omega) if damping is None else damping.decay(self.omega)

    def coordinates(self, shares: FloatArray) -> FloatArray:
        """Star coordinates of the modes' contact displacements, contact first; without residual.

        Shape (n,), or (n, times) for histories.
        """
        return np.concatenate([shares.sum(axis=0)[None], self.gain @ shares])

    def force(self, forces: FloatArray) -> FloatArray:
        """Forces on the modes, φᵀf, of forces on the star's coordinates, contact first."""
        on_modes: FloatArray = self.participation * (forces[0] + forces[1:] @ self.gain)
        return on_modes

    def project(self, coordinates: FloatArray) -> FloatArray:
        """Modal coordinates φᵀMu of star coordinates, contact first."""
        return self.force(np.concatenate([[self.star.m0], self.star.m]) * coordinates)


def star_modes(star: AOModel) -> StarModes:
    """Return a star's natural modes; a wall has one that no force moves."""
    if math.isinf(star.m0):
        return StarModes(star, np.zeros(1), np.zeros(1), 0.0)
    omega2, participation = star.to_modal()
    residual = 0.0 if star.m0 > 0.0 else 1.0 / (star.k0 + math.fsum(star.k))
    return StarModes(star, np.sqrt(omega2), participation, residual)
