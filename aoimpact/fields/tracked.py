"""A body at any times of an adaptive run, in the coordinates of its model."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ..base import FloatArray
from ..integrate import Track
from ..scene import Plan

__all__ = ["Tracked"]


# The forces' rates are central differences over this share of the shortest contact: a smooth force
# has moved far more than its rounding there, and its curve not yet bent.
_DIFFERENCE = 1e-6


@dataclass(frozen=True, eq=False)
class Tracked:
    """One body of a track.

    Attributes
    ----------
    track : Track
    plan : Plan
        What was run.
    body : int
        Its number in the scene.
    """

    track: Track
    plan: Plan
    body: int

    @property
    def duration(self) -> float:
        return self.track.duration

    def observed(self, rows: Any, times: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return rows @ q and rows @ q̇ at `times`, s; q and q̇ themselves where rows is None."""
        modal = self.plan.modal[self.body]
        u, v = (modal.coordinates(of) for of in self.track.states(times, self.body))
        if modal.residual is not None and modal.ports == 1:
            residual = float(modal.residual[0, 0])  # a massless contact follows at once
            u[0] += residual * self.force(times)[0]
            v[0] += residual * self.force_rate(times)[0]
        return (u, v) if rows is None else (rows @ u, rows @ v)

    def force(self, times: FloatArray) -> FloatArray:
        """Return the forces on the ports, along their directions, N, shape (p, times)."""
        record = self.track.sample(times, energies=False)
        return self.plan.port_forces(self.body, times, record)

    def force_rate(self, times: FloatArray) -> FloatArray:
        """Return their rates, N/s."""
        touches = [end - start for of in self.track.events for start, end in of.contacts]
        step = _DIFFERENCE * min(touches, default=self.duration)
        after = np.minimum(times + step, self.duration)
        before = np.maximum(times - step, 0.0)
        rate: FloatArray = (self.force(after) - self.force(before)) / (after - before)
        return rate
