"""A rigid body against a wall: simulated, pushed by a load, and integrated by SciPy."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import scipy.integrate
from scipy.special import gamma

import aoimpact as ao

Force = Callable[[float, float], float]


def on_a_wall(
    law: ao.ContactLaw,
    mass: float,
    velocity: float,
    solver: Any,
    duration: float = 1e-4,
    gap: float = 0.0,
) -> ao.Result:
    return ao.simulate(
        projectile=ao.rigid(mass=mass),
        target=ao.rigid(mass=math.inf),
        law=law,
        velocity=velocity,
        duration=duration,
        solver=solver,
        gap=gap,
    )


def rigid_power(k: float, n: float, mass: float, velocity: float) -> tuple[float, float]:
    """Peak force, N, and duration, s, of a rigid mass on F = k dⁿ, from conservation of energy."""
    deepest = ((n + 1) * mass * velocity**2 / (2 * k)) ** (1 / (n + 1))
    p = 1 / (n + 1)
    integral = math.sqrt(math.pi) * gamma(1 + p) / gamma(0.5 + p)
    return k * deepest**n, 2 * deepest / velocity * integral


def against_a_wall(
    body: ao.AOModel, law: ao.ContactLaw, force: Any, *, gap: float = 0.0, velocity: float = 0.0
) -> tuple[ao.Scene, Any]:
    """Return a scene in which a force pushes a body against a wall, and the body's handle."""
    scene = ao.Scene()
    pushed, wall = scene.add(body, velocity=velocity), scene.add(ao.rigid(math.inf))
    scene.connect(pushed, wall, law, gap=gap)
    scene.apply(pushed, force=force)
    return scene, pushed


def rebound(force: Force, mass: float, velocity: float, *, pulls: bool = False) -> float:
    """Restitution of m x'' = -F(x, x') from x = 0 until F, or x if F may pull, returns to zero."""
    # Scaling: the unit of length s satisfies F(s) s = m V²; the unit of time is s/V.
    s = 1.0
    for _ in range(200):
        s *= (mass * velocity**2 / (force(s, 0.0) * s)) ** 0.4
    scale = s / (mass * velocity**2)

    def push(x: float, v: float) -> float:
        return scale * force(s * max(x, 0.0), velocity * v)

    def ends(_: float, y: np.ndarray) -> float:
        if y[1] > 0.0:
            return 1.0
        return float(y[0]) if pulls else push(y[0], y[1]) if y[0] > 0.0 else -1.0

    ends.terminal = True
    run = scipy.integrate.solve_ivp(
        lambda _, y: [y[1], -push(y[0], y[1])],
        (0.0, 1e7),
        [0.0, 1.0],
        method="DOP853",
        rtol=1e-13,
        atol=1e-17,
        events=ends,
    )
    assert run.t_events[0].size
    return float(-run.y_events[0][0, 1])
