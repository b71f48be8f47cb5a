"""Oblique impacts by fixed springs with Coulomb friction and explicit time steps.

Nothing is shared with the core. Springs start at fixed indentations, evenly spaced in contact
radius, and are returned radially to their friction bound. Bodies follow Newton-Euler equations in
vectors, or K and M with all dofs, by velocity Verlet. The error of the force is of order
1/springs²; on curved slide paths it is of first order in the step.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from aoimpact.base import FloatArray

__all__ = ["Elastic", "Motion", "Rigid", "march"]


@dataclass
class Rigid:
    """A rigid body with a contact point at `arm` from its centre; an infinite mass means a wall."""

    mass: float
    inertia: FloatArray
    arm: FloatArray
    velocity: FloatArray = field(default_factory=lambda: np.zeros(3))
    spin: FloatArray = field(default_factory=lambda: np.zeros(3))

    def __post_init__(self) -> None:
        self.place, self.turn, self.rate = np.zeros(3), np.zeros(3), np.zeros(6)
        self.velocity, self.spin = self.velocity.copy(), self.spin.copy()
        self.lever = np.cross(np.eye(3), self.arm).T  # matrix of turn × arm
        self.moment = np.linalg.solve(self.inertia, self.lever.T)  # angular acceleration per force

    @property
    def point(self) -> FloatArray:
        return self.place + self.lever @ self.turn

    def drift(self, dt: float) -> None:
        self.place += dt * self.velocity + 0.5 * dt * dt * self.rate[:3]
        self.turn += dt * self.spin + 0.5 * dt * dt * self.rate[3:]

    def kick(self, force: FloatArray, gravity: FloatArray, dt: float) -> None:
        before = self.rate
        if np.isfinite(self.mass):
            self.rate = np.concatenate([force / self.mass + gravity, self.moment @ force])
        self.velocity += 0.5 * dt * (before + self.rate)[:3]
        self.spin += 0.5 * dt * (before + self.rate)[3:]


@dataclass
class Elastic:
    """A body given by K and M, touched at a node without constraints."""

    K: Any
    M: Any
    dofs: FloatArray  # dofs of the contact node along x, y, z
    unit: FloatArray  # unit translations, shape (n, 3)

    def __post_init__(self) -> None:
        self.inverse = np.linalg.inv(self.M.toarray())
        n = len(self.inverse)
        self.x, self.v, self.a = np.zeros(n), np.zeros(n), np.zeros(n)

    @property
    def point(self) -> FloatArray:
        return self.x[self.dofs]

    @property
    def velocity(self) -> FloatArray:
        """Velocity of the centre of mass."""
        momentum = self.unit.T @ (self.M @ self.v)
        return momentum / float(self.unit[:, 0] @ (self.M @ self.unit[:, 0]))

    def drift(self, dt: float) -> None:
        self.x += dt * self.v + 0.5 * dt * dt * self.a

    def kick(self, force: FloatArray, gravity: FloatArray, dt: float) -> None:
        before, load = self.a, -(self.K @ self.x)
        load[self.dofs] += force
        self.a = self.inverse @ load + self.unit @ gravity
        self.v += 0.5 * dt * (before + self.a)


@dataclass
class Motion:
    """Normal and friction forces on the second body over time."""

    t: FloatArray
    force: FloatArray
    friction: FloatArray


def march(
    first: Any,
    second: Any,
    normal: FloatArray,
    *,
    k: float,
    mu: float,
    ratio: float,
    depth: float,
    duration: float,
    steps: int,
    power: float = 1.5,
    springs: int = 200,
    gravity: FloatArray | None = None,
    damping: float = 0.0,
) -> Motion:
    """Integrate the impact of two bodies with the normal force k δ^power (1 + damping dδ/dt) ≥ 0.

    `normal` is the direction of travel, `depth` an upper bound of the indentation, `ratio` G*/E*.
    Damping scales the friction bounds of all springs by the same factor.
    """
    edge = depth * (np.arange(springs + 1) / springs) ** 2
    at = depth * ((np.arange(springs) + 0.5) / springs) ** 2
    stiffness = np.diff(k * power * edge ** (power - 1.0))
    stretch, slid, dt = np.zeros((springs, 3)), np.zeros(3), duration / steps
    last = np.zeros(3)  # last indentations, for the rate from a parabola through them
    falls = np.zeros(3) if gravity is None else gravity
    t = dt * np.arange(steps + 1)
    pressed, along = np.zeros(steps + 1), np.zeros((steps + 1, 3))
    for step in range(1, steps + 1):
        for body in (first, second):
            body.drift(dt)
        apart = first.point - second.point
        depth_now = float(normal @ apart)
        slide = apart - depth_now * normal
        if depth_now > depth:
            raise ValueError("deeper than the springs")
        last = np.array([depth_now, *last[:2]])
        rate = (1.5 * last[0] - 2.0 * last[1] + 0.5 * last[2]) / dt
        share = max(1.0 + damping * rate, 0.0)
        room = mu / ratio * share * np.maximum(depth_now - at, 0.0)
        stretch += slide - slid
        length = np.linalg.norm(stretch, axis=1)
        stretch *= np.divide(room, length, out=np.ones(springs), where=length > room)[:, None]
        slid = slide
        pressed[step] = share * k * max(depth_now, 0.0) ** power
        along[step] = ratio * stiffness @ stretch
        force = pressed[step] * normal + along[step]
        first.kick(-force, falls, dt)
        second.kick(force, falls, dt)
    return Motion(t, pressed, along)
