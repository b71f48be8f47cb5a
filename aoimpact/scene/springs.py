"""The contacts of a network as nonlinear springs that only push, all of one law at once."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from .. import _core
from ..base import FloatArray
from ..laws import ContactLaw, CoreLaw, loading_work

# The indentations, m, between which the one under a load is looked for, by these factors in turn. A
# user's law is not evaluated much deeper than it will be in the run.
_SHALLOWEST, _DEEPEST = 2.0**-90, 2.0**30
_STRIDES, _OWN_STRIDES = (2.0**16, 2.0**4, 2.0), (2.0,)


@dataclass(frozen=True, eq=False)
class _Kind:
    """The contacts of one law, by their numbers; beyond its limit, m, it is continued linearly."""

    of: ContactLaw
    law: CoreLaw
    limit: float
    strides: tuple[float, ...]
    which: npt.NDArray[np.intp]

    def force(self, depth: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return F and dF/dδ, shape (m,)."""
        within = np.clip(depth, 0.0, self.limit)
        force, stiffness, damping = (np.empty(len(depth)) for _ in range(3))
        _core.law_force(self.law, within, np.zeros(len(depth)), force, stiffness, damping, False)
        closed = depth > 0.0
        stiffness = np.maximum(stiffness, 0.0)  # rounding may make it negative
        beyond = force + stiffness * (depth - within)
        return np.where(closed, beyond, 0.0), np.where(closed, stiffness, 0.0)

    def energy(self, depth: FloatArray) -> FloatArray:
        """Return the work of the force up to there, J, shape (m,)."""
        within, stored = np.clip(depth, 0.0, self.limit), np.empty(len(depth))
        if self.of.has_memory:  # a plastic contact stores less than that
            stored[:] = [loading_work(self.of, one) for one in within.tolist()]
        else:
            _core.law_potential(self.law, within, stored)
        mean = 0.5 * (self.force(within)[0] + self.force(depth)[0])
        return stored + np.maximum(depth - within, 0.0) * mean

    def stiffness_under(self, load: float) -> float:
        """Return the stiffness, N/m, under a load, N; the secant's where the tangent is level."""
        depth = np.array([_SHALLOWEST])
        for stride in self.strides:
            while stride * depth[0] <= _DEEPEST and self.force(stride * depth)[0][0] <= load:
                depth *= stride
        force, slope = self.force(depth)
        return float(max(slope[0], force[0] / depth[0]))


class Springs:
    """Forces and energies over indentations, m, shape (contacts,)."""

    def __init__(self, laws: Sequence[ContactLaw]) -> None:
        self._count = len(laws)
        which: dict[ContactLaw, list[int]] = {}
        for number, law in enumerate(laws):
            which.setdefault(law, []).append(number)
        self._kinds = [
            _Kind(
                law,
                law.for_core(),
                law.limit,
                _OWN_STRIDES if law.by_caller else _STRIDES,
                np.array(numbers),
            )
            for law, numbers in which.items()
        ]

    def force(self, depth: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the forces, N, and their slopes, N/m, shape (contacts,) each."""
        force, slope = np.zeros(self._count), np.zeros(self._count)
        for kind in self._kinds:
            force[kind.which], slope[kind.which] = kind.force(depth[kind.which])
        return force, slope

    def energy(self, depth: FloatArray) -> float:
        """Return the work of the forces of all, J."""
        return float(sum(kind.energy(depth[kind.which]).sum() for kind in self._kinds))

    def stiffness_under(self, load: float) -> FloatArray:
        """Return the stiffness of each, N/m, shape (contacts,), under one load, N."""
        found = np.zeros(self._count)
        for kind in self._kinds:
            found[kind.which] = kind.stiffness_under(load)
        return found

    @property
    def limits(self) -> FloatArray:
        """The indentation to which each law is valid, m, shape (contacts,)."""
        found = np.zeros(self._count)
        for kind in self._kinds:
            found[kind.which] = kind.limit
        return found
