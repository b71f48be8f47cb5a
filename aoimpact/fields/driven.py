"""A body stepped again under the forces that a run recorded.

Seen from one body, a run is forces over time. Newmark's rule with those forces takes the body
through the very states that it had in the run, and this time they can be looked at.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..base import FloatArray
from ..integrate import Newmark
from ..linalg import factorize
from ..scene import Equations

__all__ = ["Driven"]


@dataclass(frozen=True, eq=False)
class Driven:
    """A linear body, and what acts on it at the steps of a run.

    Attributes
    ----------
    equations : Equations
    rule : Newmark
    dt : float
        s.
    forces : ndarray, shape (p, steps + 1)
        As `Plan.port_forces` gives them.
    model : callable
        The model's coordinates from those that are stepped, (n,) or (n, times).
    """

    equations: Equations
    rule: Newmark
    dt: float
    forces: FloatArray
    model: Callable[[FloatArray], FloatArray]

    @property
    def duration(self) -> float:
        return self.dt * float(self.forces.shape[1] - 1)

    def observed(self, rows: Any, times: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return rows @ q and rows @ q̇ of the model's coordinates at `times`, s.

        q and q̇ themselves where rows is None. Between two steps everything is linear in time, so
        that the equations of motion, which are linear too, hold there as they do at the steps; the
        error is of the rule's own order.
        """
        last = self.forces.shape[1] - 1
        place = np.clip(times / self.dt, 0.0, float(last))
        before = np.minimum(place.astype(np.int64), max(last - 1, 0))
        steps, where = np.unique(np.stack([before, before + 1]), return_inverse=True)
        kept: list[tuple[FloatArray, FloatArray]] = []
        for step, state in enumerate(self._states(int(steps[-1]))):
            if step == steps[len(kept)]:
                u, v = (self.model(values) for values in state)
                kept.append((u, v) if rows is None else (rows @ u, rows @ v))
        seen = np.array(kept).transpose(1, 2, 0)
        left, right = where.reshape(2, -1)
        share = place - before
        u, v = seen[:, :, left] * (1.0 - share) + seen[:, :, right] * share
        return u, v

    def force(self, times: FloatArray) -> FloatArray:
        """Return the forces at `times`, N, shape (p, times)."""
        return self._between(self.forces, times)

    def force_rate(self, times: FloatArray) -> FloatArray:
        """Return their rates, N/s: slopes over two steps, linear in time between the steps."""
        return self._between(np.gradient(self.forces, self.dt, axis=1), times)

    def _between(self, values: FloatArray, times: FloatArray) -> FloatArray:
        steps = self.dt * np.arange(self.forces.shape[1])
        return np.array([np.interp(times, steps, row) for row in values])

    def _states(self, last: int) -> Iterator[tuple[FloatArray, FloatArray]]:
        """u and v at the steps 0 … last."""
        body, dt = self.equations, self.dt
        beta, gamma = self.rule.beta, self.rule.gamma
        matrix = body.M + gamma * dt * body.C + beta * dt**2 * body.K
        inverse = factorize(matrix, what="M + γ dt C + β dt² K")
        u, v = body.u0, body.v0
        a = _at_start(body, self.forces[:, 0])
        yield u, v
        for step in range(1, last + 1):
            u = u + dt * v + (0.5 - beta) * dt**2 * a
            v = v + (1.0 - gamma) * dt * a
            a = inverse.solve(body.B @ self.forces[:, step] - body.K @ u - body.C @ v)
            u = u + beta * dt**2 * a
            v = v + gamma * dt * a
            yield u, v


def _at_start(body: Equations, forces: FloatArray) -> FloatArray:
    """The accelerations that the forces give at t = 0; without mass there are none."""
    left = body.B @ forces - body.K @ body.u0 - body.C @ body.v0
    heavy = np.flatnonzero(body.M.diagonal() > 0.0)
    a: FloatArray = np.zeros_like(left)
    if left.any():
        a[heavy] = factorize(body.M[heavy][:, heavy], what="M").solve(left[heavy])
    return a
