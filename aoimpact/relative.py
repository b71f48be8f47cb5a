"""Two stars seen from the contact between them: the modes of their relative displacement.

A star and its natural modes are the same thing in two coordinate systems; the secular equation
leads from one to the other. In modes, motion under a given force has a closed form.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

from .star import AOModel

__all__ = ["Relative", "relative"]

FloatArray = npt.NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class _Side:
    """A star's modes, as the indentation sees them."""

    star: AOModel
    omega: FloatArray
    weight: FloatArray
    residual: float

    @cached_property
    def gain(self) -> FloatArray:
        """How far oscillator i moves per unit of the contact in mode j: ω_i²/(ω_i² - ω_j²)."""
        antiresonance = self.star.k / self.star.m
        distance = np.subtract.outer(antiresonance, self.omega**2)
        gain: FloatArray = antiresonance[:, None] / np.where(distance == 0.0, np.inf, distance)
        return gain

    @cached_property
    def centre(self) -> tuple[FloatArray, float]:
        """Motion of the centre of mass per unit of the contact: by mode, by residual compliance."""
        weights = self.star.centre_weights
        if not self.star.held:  # elastic modes of a free body do not move its centre of mass
            return np.where(self.omega == 0.0, weights.sum(), 0.0), 0.0
        return weights[0] + weights[1:] @ self.gain, float(weights[0])

    def coordinates(self, shares: FloatArray) -> FloatArray:
        """Star coordinates of the modes' contact displacements, contact first; without residual."""
        return np.concatenate([[shares.sum()], self.gain @ shares])


def _side(star: AOModel) -> _Side:
    if math.isinf(star.m0):  # one rigid mode that no force moves
        return _Side(star, np.zeros(1), np.zeros(1), 0.0)
    omega2, participation = star.to_modal()
    residual = 0.0 if star.m0 > 0.0 else 1.0 / (star.k0 + math.fsum(star.k))
    return _Side(star, np.sqrt(omega2), participation**2, residual)


@dataclass(frozen=True, eq=False)
class Relative:
    """The relative displacement of a projectile and a target, in modes; as ``aoi_relative``.

    Attributes
    ----------
    omega, weight : ndarrays, shape (n,)
        rad/s; squares of the participations, 1/kg; the projectile's modes first.
    n_projectile : int
    residual : ndarray, shape (2,)
        Compliances without inertia (of a massless contact), m/N.
    gap : float
        m.
    """

    sides: tuple[_Side, _Side]
    omega: FloatArray
    weight: FloatArray
    n_projectile: int
    residual: FloatArray
    gap: float

    def for_core(self) -> tuple[FloatArray, FloatArray, FloatArray, int, FloatArray, float]:
        """Return the core's tuple; no load acts on the bodies."""
        load = np.zeros_like(self.omega)
        return self.omega, self.weight, load, self.n_projectile, self.residual, self.gap

    def coordinates(self, shares: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return both stars' coordinates for the modes' shares x (or rates v), shape (n,)."""
        n = self.n_projectile
        return self.sides[0].coordinates(shares[:n]), -self.sides[1].coordinates(shares[n:])

    def start(self, velocity: float) -> tuple[FloatArray, FloatArray]:
        """Return x and v, each shape (n,), of a projectile that moves undeformed at `velocity`.

        All of its coordinates move alike: mode j has r_j² k0/ω_j² of it, the rigid one all of it.
        """
        x, v = np.zeros_like(self.omega), np.zeros_like(self.omega)
        ours = slice(0, self.n_projectile)
        star, omega = self.sides[0].star, self.omega[ours]
        if star.k0 > 0.0:
            v[ours] = velocity * self.weight[ours] * star.k0 / omega**2
        else:
            v[ours] = np.where(omega == 0.0, velocity, 0.0)
        return x, v

    @cached_property
    def centre(self) -> tuple[FloatArray, FloatArray]:
        """Weights of the modes, shape (n,), and residuals, shape (2,), in the centres of mass."""
        modes, residuals = zip(*(side.centre for side in self.sides), strict=True)
        return np.concatenate(modes), np.array(residuals) * self.residual


def relative(projectile: AOModel, target: AOModel, gap: float) -> Relative:
    """Return the relative displacement of two stars, `gap` m apart at the start."""
    sides = _side(projectile), _side(target)
    return Relative(
        sides,
        np.concatenate([side.omega for side in sides]),
        np.concatenate([side.weight for side in sides]),
        len(sides[0].omega),
        np.array([side.residual for side in sides]),
        gap,
    )
