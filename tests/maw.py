"""Tangential impact of elastic spheres, by the method of Maw, Barber and Fawcett.

The contact area is divided into rings of uniform shear traction; trial and error determines which
rings stick and which slip at the end of each step (N. Maw, J. R. Barber, J. N. Fawcett, Wear 38,
101, 1976). The influence of a ring is the difference of two discs (K. L. Johnson, Contact
Mechanics, eq. 3.29, with the tangential modulus of the pair instead of the normal one). There are
no springs and no superposition, so that nothing is shared with the core.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from scipy.special import ellipe, ellipk

from aoimpact.base import FloatArray

__all__ = ["MEASURED", "Rings", "impact"]

# Measurements of Kharaz, Gorham and Salman (2001) for an alumina ball of 5 mm on glass at 3.9 m/s:
# angle from the normal, °, tangential restitution, spin after the impact, rad/s.
MEASURED = [
    (3.93, 0.7450, None),
    (20.08, 0.5964, None),
    (39.30, 0.7719, None),
    (59.84, 0.9019, None),
    (10.98, None, 264.5),
    (31.09, None, 612.6),
    (50.22, None, 452.9),
]


def _disc(r: FloatArray, a: FloatArray, modulus: float) -> FloatArray:
    """Surface displacement at r under a unit traction on a disc of radius a."""
    with np.errstate(divide="ignore", invalid="ignore"):
        inside, outside = np.minimum(r / a, 1.0) ** 2, np.minimum(a / r, 1.0) ** 2
        beyond = ellipe(outside) - np.where(outside < 1.0, (1.0 - outside) * ellipk(outside), 0.0)
        u = np.where(r <= a, a * ellipe(inside), r * beyond)
    return np.where(a > 0.0, 4.0 / (math.pi * modulus) * u, 0.0)


class Rings:
    """Contact of a sphere of radius R with a half-space, with tangential motion along one line.

    Parameters
    ----------
    normal, tangential : float
        Contact moduli E* and G* of the pair, Pa.
    R : float
        Radius of the sphere, m.
    mu : float
        Coefficient of friction.
    depth : float
        Indentation, m, whose contact radius is the outer radius of the rings.
    count : int
        Number of rings. The error of the force is proportional to 1/count.
    """

    def __init__(
        self, normal: float, tangential: float, R: float, mu: float, depth: float, count: int
    ) -> None:
        self.R, self.mu, self.pressure = R, mu, 2.0 * normal / (math.pi * R)
        self.edge = math.sqrt(R * depth) * np.linspace(0.0, 1.0, count + 1)
        middle = 0.5 * (self.edge[1:] + self.edge[:-1])[:, None]
        self.influence = _disc(middle, self.edge[None, 1:], tangential)
        self.influence -= _disc(middle, self.edge[None, :-1], tangential)
        self.traction, self.slips, self.slide = np.zeros(count), np.zeros(count), 0.0

    def force(self, depth: float, slide: float) -> float:
        """Return the friction force, N, after a step to an indentation and a total slide, m."""
        a, area = math.sqrt(self.R * depth), math.pi * np.diff(self.edge**2)
        share = np.maximum(1.0 - (self.edge / a) ** 2, 0.0) ** 1.5
        bound = self.mu * 2.0 / 3.0 * math.pi * self.pressure * a**3 * -np.diff(share) / area
        touch = bound > 0.0
        slips = np.where(touch, self.slips, 1.0)
        for _ in range(200):
            sticks, traction = slips == 0.0, slips * bound
            own = self.influence[np.ix_(sticks, sticks)]
            traction[sticks] = self.traction[sticks]
            moved = slide - self.slide - self.influence @ (traction - self.traction)
            traction[sticks] += np.linalg.solve(own, moved[sticks])
            moved = slide - self.slide - self.influence @ (traction - self.traction)
            over = sticks & (np.abs(traction) > bound * (1.0 + 1e-9))
            back = touch & ~sticks & (slips * moved < -1e-9 * abs(slide - self.slide))
            if not (over | back).any():
                self.traction, self.slips, self.slide = traction, slips * touch, slide
                return float(traction @ area)
            slips = np.where(over, np.sign(traction), np.where(back, 0.0, slips))
        raise RuntimeError("no state of stick and slip found")


def impact(
    force: Callable[[float, float], float],
    k: float,
    inertia: float,
    velocity: tuple[float, float],
    steps: int,
) -> tuple[float, float]:
    """Return the velocities of the contact point after an impact of a unit mass, by Verlet's rule.

    Parameters
    ----------
    force : callable
        Friction force after the next step, as a function of indentation and slide.
    k : float
        Hertz's stiffness.
    inertia : float
        Tangential acceleration of the contact point per force: 7/2 for a sphere.
    velocity : tuple of float
        Normal and tangential velocity of the contact point.
    steps : int
        Number of steps in Hertz's duration.
    """
    v, w = velocity
    deepest = (1.25 * v * v / k) ** 0.4
    dt = 2.9432 * deepest / v / steps
    d = u = normal = friction = 0.0
    while True:
        v, w = v - 0.5 * dt * normal, w - 0.5 * dt * inertia * friction
        d, u = d + dt * v, u + dt * w
        if d <= 0.0:
            return v, w
        normal, friction = k * d**1.5, force(d, u)
        v, w = v - 0.5 * dt * normal, w - 0.5 * dt * inertia * friction
