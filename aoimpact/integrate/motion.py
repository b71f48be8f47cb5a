"""The motion of one body in a run, in the coordinates of its model, at any times.

The record of an adaptive run has the states at any time. A run with fixed steps records the forces,
but no states. A single body under prescribed forces is linear, so that Newmark's rule with the same
steps reproduces its states in the run.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from ..base import ArrayPair, FloatArray, SingularError, record
from ..linalg import Factorization, factorize
from ..scene import Equations

if TYPE_CHECKING:
    from .fixed_steps import SteppedRecorder


@record
class Motion:
    """The coordinates q of a body in a run, and the forces on its ports.

    Attributes
    ----------
    run : Recorder
    body : int
        Number of the body in the scene.
    resolution : float
        Interval of central differences for accelerations, s.
    instant : float
        Interval of central differences for the rates of forces, s.
    """

    run: Any
    body: int
    resolution: float
    instant: float

    @property
    def duration(self) -> float:
        return float(self.run.duration)

    def force(self, times: FloatArray) -> FloatArray:
        """Return the forces on the ports, N, (p, times); see `Scenario.port_forces`."""
        found: FloatArray = self.run.plan.port_forces(self.body, times, self.run.pushes(times))
        return found

    def force_rate(self, times: FloatArray) -> FloatArray:
        """Return the rates of the forces of `force`, N/s, (p, times)."""
        after = np.minimum(times + self.instant, self.duration)
        before = np.maximum(times - self.instant, 0.0)
        rate: FloatArray = (self.force(after) - self.force(before)) / (after - before)
        return rate

    def observed(self, rows: Any, times: FloatArray) -> ArrayPair:
        """Return rows @ q and rows @ q̇ at `times`, s; q and q̇ themselves if `rows` is None."""
        u, v = self.run.modes(times, self.body)
        return (u, v) if rows is None else (rows @ u, rows @ v)

    def acceleration(self, rows: Any, times: FloatArray) -> FloatArray:
        """Return rows @ q̈ at `times`, s; only for runs with fixed steps."""
        raise NotImplementedError


class SteppedMotion(Motion):
    """A linear body under the forces that a run with fixed steps recorded."""

    run: SteppedRecorder

    def observed(self, rows: Any, times: FloatArray) -> ArrayPair:
        u, v, _ = self._seen(rows, times)
        return u, v

    def acceleration(self, rows: Any, times: FloatArray) -> FloatArray:
        return np.asarray(self._seen(rows, times)[2])

    def _seen(self, rows: Any, times: FloatArray) -> FloatArray:
        """Return the products of `rows` with q, q̇ and q̈, shape (3, rows, times).

        The products are interpolated linearly between the steps. Interpolated values satisfy the
        linear equations of motion, as do the values at the steps, and have errors of the order of
        the rule's.
        """
        last = len(self.run.times) - 1
        place = np.clip(times / self.run.dt, 0.0, float(last))
        before = np.minimum(place.astype(np.int64), max(last - 1, 0))
        steps, where = np.unique(np.stack([before, before + 1]), return_inverse=True)
        kept: list[FloatArray] = []
        for step, state in enumerate(self._states(int(steps[-1]))):
            if step == steps[len(kept)]:
                q = np.array(state)
                kept.append(q if rows is None else np.array([rows @ one for one in q]))
        seen = np.array(kept).transpose(1, 2, 0)
        left, right = where.reshape(2, -1)
        share = place - before
        found: FloatArray = seen[:, :, left] * (1.0 - share) + seen[:, :, right] * share
        return found

    @cached_property
    def _equations(self) -> Equations:
        return self.run.plan.stepped(self.body).equations

    def _states(self, last: int) -> Iterator[tuple[FloatArray, FloatArray, FloatArray]]:
        """Yield displacement, velocity and acceleration at the steps 0 … last."""
        body, dt, rule = self._equations, self.run.dt, self.run.rule
        beta, gamma = rule.beta, rule.gamma
        # A wall has no column for the weight.
        forces = self.force(self.run.times)[: body.B.shape[1]]
        matrix = body.M + gamma * dt * body.C + beta * dt**2 * body.K
        inverse = factorize(matrix, what="M + γ dt C + β dt² K")
        u, v = body.u0, body.v0
        a = _at_start(body, forces[:, 0], inverse)
        yield u, v, a
        for step in range(1, last + 1):
            u = u + dt * v + (0.5 - beta) * dt**2 * a
            v = v + (1.0 - gamma) * dt * a
            a = inverse.solve(body.B @ forces[:, step] - body.K @ u - body.C @ v)
            u = u + beta * dt**2 * a
            v = v + gamma * dt * a
            yield u, v, a


def _at_start(body: Equations, forces: FloatArray, inverse: Factorization) -> FloatArray:
    """Return accelerations at t = 0 from the balance of forces; 0 for massless coordinates.

    If M without massless coordinates is singular, the matrix of Newmark's steps replaces M.
    """
    left = body.B @ forces - body.K @ body.u0 - body.C @ body.v0
    heavy = np.flatnonzero(body.M.diagonal() > 0.0)
    a: FloatArray = np.zeros_like(left)
    if left.any():
        try:
            a[heavy] = factorize(body.M[heavy][:, heavy], what="M").solve(left[heavy])
        except SingularError:
            a = inverse.solve(left)
    return a
