"""A body stepped again under the forces that a run recorded.

Seen from one body, a run is forces over time. Newmark's rule with those forces takes the body
through the very states that it had in the run, and this time they can be looked at.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
import scipy.sparse as sp

from .newmark import CoreBody, Newmark
from .superlu import factorize

__all__ = ["Driven", "Equations", "equations_of"]

FloatArray = npt.NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Equations:
    """M ü + C u̇ + K u = B f, from u0 and v0.

    Attributes
    ----------
    K, M, C : scipy.sparse arrays, shape (n, n)
    B : ndarray, shape (n, p)
        The ports; under gravity the weight, N, after them.
    u0, v0 : ndarrays, shape (n,)
        At t = 0, m and m/s.
    """

    K: Any
    M: Any
    C: Any
    B: FloatArray
    u0: FloatArray
    v0: FloatArray


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


def equations_of(body: CoreBody) -> Equations:
    """Return the equations of a body from what `newmark_scene` takes of it."""
    kind, *parts = body
    u0, v0 = parts[-2].copy(), parts[-1].copy()
    if kind == "star":
        m0, k0, m, k, alpha, beta, gravity = parts[:7]
        K, M = _arrowhead(k0, k), sp.diags_array(np.concatenate([[m0], m])).tocsr()
        B, C = np.eye(1, len(m) + 1), alpha * M + beta * K
    elif kind == "modal":
        omega, decay, B, _, _, gravity = parts[:6]
        K, M = sp.diags_array(omega**2).tocsr(), sp.eye_array(len(omega), format="csr")
        C = sp.diags_array(2.0 * decay).tocsr()
    else:
        K, M = (_sparse(matrix) for matrix in parts[:2])
        B, alpha, beta, _, gravity = parts[2:7]
        C = alpha * M + beta * K
    ports = B.reshape(-1, len(u0)).T
    loads = ports if gravity is None else np.column_stack([ports, gravity])
    return Equations(K, M, C, loads, u0, v0)


def _arrowhead(k0: float, k: FloatArray) -> sp.csr_array:
    stiffness = sp.diags_array(np.concatenate([[k0 + k.sum()], k])).tolil()
    stiffness[0, 1:] = -k
    stiffness[1:, 0] = -k
    return stiffness.tocsr()


def _sparse(rows: tuple[Any, ...]) -> sp.csr_array:
    start, indices, values = rows
    return sp.csr_array((values, indices, start))
