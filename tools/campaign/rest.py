"""Bodies at rest under gravity and loads: Newton's method on the balance of forces.

In the full coordinates of the AO models, with the massless ones, the energy is convex: linear
springs, and contacts that only push.
"""

from __future__ import annotations

import numpy as np

from .case import Body, Case
from .formulas import Formula
from .outcome import FloatArray
from .system import sides_of, starts, stiffness_of

_MOST = 3000


class NoRestError(Exception):
    """Newton's method found no balance."""


def rest(case: Case, laws: list[Formula], loads: FloatArray) -> tuple[list[FloatArray], FloatArray]:
    """Return each body's coordinates, contact first, and the contacts' indentations, m."""
    first = starts(len(body.masses) for body in case.bodies)
    ports = starts(body.ports for body in case.bodies)
    n = int(first[-1])
    stiffness, force = np.zeros((n, n)), np.zeros(n)
    free = np.ones(n, dtype=bool)
    for i, body in enumerate(case.bodies):
        own = slice(first[i], first[i + 1])
        free[own] = not body.wall
        stiffness[own, own] = stiffness_of(body)
        # A held AO model given by numbers has unknown supports, so that its weight does not act.
        if not body.wall and not (body.held and isinstance(body, Body)):
            force[own] = np.array(body.masses) * case.gravity
        force[first[i] : first[i] + body.ports] += loads[ports[i] : ports[i + 1]]
    sides = sides_of(case, first, n)
    gaps = np.array([contact.gap for contact in case.contacts])
    x = _balance(stiffness, force, sides, gaps, laws, free)
    return [x[first[i] : first[i + 1]] for i in range(len(case.bodies))], sides @ x - gaps


def _balance(
    stiffness: FloatArray,
    force: FloatArray,
    sides: FloatArray,
    gaps: FloatArray,
    laws: list[Formula],
    free: FloatArray,
) -> FloatArray:
    """Return the coordinates in balance, by Newton's method, damped until the energy falls."""

    def look(x: FloatArray) -> tuple[FloatArray, FloatArray, float, float]:
        depth = sides @ x - gaps
        values = [law.statically(float(d)) for law, d in zip(laws, depth, strict=True)]
        push = np.array([value[0] for value in values])
        slope = np.array([value[1] for value in values])
        over = np.where(free, force - stiffness @ x - sides.T @ push, 0.0)
        size = max(float(np.abs(force).max() + push.max(initial=0.0)), 1e-300)
        energy = 0.5 * x @ stiffness @ x - force @ x
        energy += sum(law.taken(float(d)) for law, d in zip(laws, depth, strict=True) if d > 0.0)
        tangent = stiffness + (sides.T * slope) @ sides
        return over, tangent, float(np.abs(over).max() / size), float(energy)

    x = np.zeros(len(force))
    over, tangent, error, energy = look(x)
    ridge = np.where(free, np.abs(np.diag(stiffness)) + _usual_slope(laws, force), 1.0)
    within = np.outer(free, free)
    damping = 1e-3
    for _ in range(_MOST):
        if error < 1e-14:
            return x
        trial = x + np.linalg.solve(np.where(within, tangent, 0.0) + np.diag(damping * ridge), over)
        result = look(trial)
        rounding = 1e-14 * float(np.abs(x) @ np.abs(stiffness) @ np.abs(x) + np.abs(force @ x))
        if result[3] < energy - rounding or (result[3] <= energy + rounding and result[2] < error):
            x, (over, tangent, error, energy) = trial, result
            damping = max(damping * 0.2, 1e-17)
        elif damping < 1e12:
            damping *= 5.0
        else:
            break
    if error < 1e-10:
        return x
    raise NoRestError(f"imbalance {error:.2g}")


def _usual_slope(laws: list[Formula], force: FloatArray) -> float:
    """Return the largest stiffness of the laws under the sum of all loads, N/m."""
    load = float(np.abs(force).sum())
    found = 1e-300
    for law in laws:
        depth = np.geomspace(1e-15, 1e3, 300)
        values = [law.statically(float(d)) for d in depth]
        reached = [slope for push, slope in values if push >= load]
        found = max(found, reached[0] if reached else values[-1][1])
    return found
