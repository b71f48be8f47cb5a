"""A body of a scene in its natural modes, the coordinates in which its motion has a closed form.

Mode j of a star is measured by its share x_j in the displacement of the contact coordinate, so that
masses of any size stay apart; modes of a body with several ports are mass-normalised.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from operator import itemgetter
from typing import Any

import numpy as np

from .. import _core
from ..base import FloatArray

# The parts of a body as the core takes it, in its order.
_PARTS = itemgetter(*_core.MODES.split())


# Along the direction of travel; or of the centre of mass in three directions, and spin, shape (6,).
Velocity = float | FloatArray

# Gravity along the direction of travel; or in three directions, shape (3,).
Pull = float | FloatArray


@dataclass(frozen=True, eq=False)
class RigidMotion:
    """A body's motion as a whole by the rates of its modes, in the axes of its mesh.

    Attributes
    ----------
    velocity : ndarray, shape (6, n)
        Rows of the velocity of the centre of mass and of the mean spin; without spin, shape (3, n),
        where supports leave none.
    momentum : ndarray, shape (n, 6)
        Rates of the modes of the undeformed body for a unit velocity and spin.
    """

    velocity: FloatArray
    momentum: FloatArray


@dataclass(frozen=True, eq=False)
class ModalBody:
    """ẍ_j + 2σ_j ẋ_j + ω_j² x_j = g_j + Σ_p push_pj f_p, u_p = Σ_j shape_pj x_j + Σ_q R_pq f_q.

    Attributes
    ----------
    omega : ndarray, shape (n,)
        rad/s, ascending.
    decay : ndarray, shape (n,), or None
        σ, 1/s; None where nothing is damped.
    shape, push : ndarrays, shape (p, n)
    residual : ndarray, shape (p, p), or None
        Compliance that no mode has (of a massless contact), m/N.
    weight : ndarray, shape (n,)
        Acceleration g_j under unit gravity along the direction of travel.
    inertia : ndarray, shape (n,)
        Kinetic energy is Σ inertia ẋ²/2; zero for a wall.
    centre : ndarray, shape (n,)
        Displacement of the centre of mass by modes.
    centre_residual : ndarray, shape (p,), or None
        And by forces, m/N.
    moving : ndarray, shape (n,)
        ẋ of the body moving undeformed with unit velocity.
    antiresonance : ndarray, shape (oscillators,), or None
        ω² of the oscillators of a star, (rad/s)²; None where the modes are the model's coordinates.
    rigid : RigidMotion, optional
        Its motion as a whole in three directions, where that is known.
    """

    omega: FloatArray
    decay: FloatArray | None
    shape: FloatArray
    push: FloatArray
    residual: FloatArray | None
    weight: FloatArray
    inertia: FloatArray
    centre: FloatArray
    centre_residual: FloatArray | None
    moving: FloatArray
    antiresonance: FloatArray | None = None
    rigid: RigidMotion | None = None
    _still: tuple[Any, ...] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "_still", self._tuple(None, None, None))

    @property
    def n(self) -> int:
        """Number of modes."""
        return len(self.omega)

    @property
    def ports(self) -> int:
        """Number of contact functionals."""
        return len(self.shape)

    @cached_property
    def gain(self) -> FloatArray:
        """How far oscillator i moves per unit of the contact in mode j, shape (oscillators, n)."""
        assert self.antiresonance is not None
        return oscillator_gain(self.antiresonance, self.omega)

    def rates(self, velocity: Velocity) -> FloatArray:
        """Return ẋ of the body moving undeformed, shape (n,).

        Parameters
        ----------
        velocity : float or ndarray, shape (6,)
            Along the direction of travel, m/s; or of the centre of mass in three directions, m/s,
            and spin, rad/s.
        """
        if not isinstance(velocity, np.ndarray):
            return velocity * self.moving
        return self._moved(velocity)

    def _moved(self, along: FloatArray) -> FloatArray:
        """Rates, or accelerations, of the modes for those of the whole, shape (6,)."""
        assert self.rigid is not None
        found: FloatArray = self.rigid.momentum @ along
        return found

    def for_core(
        self, gravity: Pull = 0.0, load: tuple[FloatArray, FloatArray] | None = None
    ) -> tuple[Any, ...]:
        """Return the core's tuple (aoi_modes).

        Parameters
        ----------
        gravity : float or ndarray, shape (3,), optional
            Along the direction of travel, or in three directions, m/s².
        load : (times, forces), optional
            Shapes (m,) and (m, p); forces on the ports, N, straight between the times, s.
        """
        if isinstance(gravity, np.ndarray):
            falls = self._moved(np.concatenate([gravity, np.zeros(3)]))
            pulled = falls if falls.any() and self.inertia.any() else None
        else:
            pulled = gravity * self.weight if gravity and self.weight.any() else None
        if pulled is None and load is None:
            return self._still
        return self._tuple(pulled, *(load if load is not None else (None, None)))

    def _tuple(
        self, gravity: FloatArray | None, times: FloatArray | None, forces: FloatArray | None
    ) -> tuple[Any, ...]:
        acting = {"gravity": gravity, "load_time": times, "load_force": forces}
        parts = vars(self) | acting | {"full": None}
        found: tuple[Any, ...] = _PARTS(parts)
        return found

    def coordinates(self, x: FloatArray) -> FloatArray:
        """Return the model's own coordinates (or rates) of the modes', shape (n,) or (n, times).

        Without what a massless contact moves under the force of the moment.
        """
        if self.antiresonance is None:
            return x
        return np.concatenate([x.sum(axis=0, keepdims=True), self.gain @ x])


def oscillator_gain(antiresonance: FloatArray, omega: FloatArray) -> FloatArray:
    """Return ω_i²/(ω_i² - ω_j²), shape (oscillators, n)."""
    distance = np.subtract.outer(antiresonance, omega**2)
    gain: FloatArray = antiresonance[:, None] / np.where(distance == 0.0, np.inf, distance)
    return gain
