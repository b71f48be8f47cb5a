"""Bodies at rest under gravity and loads, pressed on each other: where a run may start.

Newton's method on the balance of forces in modes, damped: the potential energy of bodies on springs
that only push is convex.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from . import _core
from .errors import ConvergenceError
from .modalbody import ModalBody

__all__ = ["Pressed", "equilibrium"]

FloatArray = npt.NDArray[np.float64]

_MOST_STEPS = 2000

# A step that brings balance nearer lets the next one be longer, one that does not, shorter.
_TIGHTER, _LOOSER, _MOST_DAMPING = 0.2, 10.0, 1e12

_HALVINGS, _BISECTIONS = 60, 200

# Energies that differ by less are the same.
_ROUNDING = 1e-9

# What has moved as far falls for ever; farther, energies overflow.
_FARTHEST = 1e100

# Balance of forces relative to the forces that are there.
_BALANCED = 1e-12


@dataclass(frozen=True, eq=False)
class Pressed:
    """A contact as statics sees it: δ = direction · x - residual F - gap."""

    direction: FloatArray
    gap: float
    law: tuple[Any, ...]
    residual: float

    def force(self, free: float) -> tuple[float, float]:
        """Return F and dF/d(free) at the indentation `free` that there would be without F."""
        if free <= 0.0:
            return 0.0, 0.0
        force, stiffness = self._law(self._depth(free))
        return force, stiffness / (1.0 + self.residual * stiffness)

    def energy(self, free: float) -> float:
        """Return what is stored there, J, in the law and the residual compliance."""
        if free <= 0.0:
            return 0.0
        depth, out = self._depth(free), np.empty(1)
        _core.law_potential(self.law, np.array([depth]), out)
        return float(out[0]) + 0.5 * self.residual * self._law(depth)[0] ** 2

    def _depth(self, free: float) -> float:
        """The indentation that is left of it."""
        low, high = 0.0, free
        for _ in range(_BISECTIONS if self.residual else 0):
            middle = 0.5 * (low + high)
            over = middle + self.residual * self._law(middle)[0] > free
            low, high = (low, middle) if over else (middle, high)
        return high

    def _law(self, indentation: float) -> tuple[float, float]:
        out = np.empty((3, 1))
        _core.law_force(self.law, np.array([indentation]), np.zeros(1), *out)
        return float(out[0, 0]), float(out[1, 0])


@dataclass(frozen=True, eq=False)
class _Place:
    """Where the bodies are, shape (n,): the forces left over there, each contact's force and slope,
    and the energy that is least at rest, J."""

    x: FloatArray
    balance: FloatArray
    pushes: list[tuple[float, float]]
    energy: float

    def better_than(self, other: _Place) -> bool:
        """Whether it is lower; or as low, but for rounding, and nearer to balance."""
        if self.energy < other.energy:
            return True
        nearer = np.linalg.norm(self.balance) <= np.linalg.norm(other.balance)
        return bool(nearer) and self.energy <= other.energy + _ROUNDING * abs(other.energy)


@dataclass(frozen=True, eq=False)
class _Pile:
    """Springs, loads and contacts in modes, shapes (n,); `movable` has no walls."""

    stiffness: FloatArray
    load: FloatArray
    movable: npt.NDArray[np.bool_]
    contacts: Sequence[Pressed]

    @cached_property
    def usual(self) -> FloatArray:
        """The stiffness, shape (n, n), under all of the loads at once: the scale of steps."""
        force = float(np.abs(self.load).sum())
        matrix = np.zeros((len(self.load), len(self.load)))
        for of in self.contacts:
            depth = 1.0
            for _ in range(_HALVINGS):
                depth = depth * 0.5 if of.force(depth)[0] > force else depth
            matrix += of.force(depth)[1] * np.outer(of.direction, of.direction)
        return matrix + np.diag(self.stiffness)

    def place(self, x: FloatArray) -> _Place:
        """What holds where the modes are x."""
        depths = [float(of.direction @ x) - of.gap for of in self.contacts]
        pushes = [of.force(depth) for of, depth in zip(self.contacts, depths, strict=True)]
        balance = self.load - self.stiffness * x
        for (force, _), of in zip(pushes, self.contacts, strict=True):
            balance = balance - force * of.direction
        stored = sum(of.energy(depth) for of, depth in zip(self.contacts, depths, strict=True))
        energy = float(0.5 * x @ (self.stiffness * x) - self.load @ x) + stored
        return _Place(x, np.where(self.movable, balance, 0.0), pushes, energy)

    def balanced(self, at: _Place) -> bool:
        """Whether the forces left over are those of rounding."""
        size = np.abs(self.load).max(initial=0.0) + sum(
            force * np.abs(of.direction).max()
            for (force, _), of in zip(at.pushes, self.contacts, strict=True)
        )
        return bool(np.abs(at.balance).max(initial=0.0) <= _BALANCED * size)

    def step(self, at: _Place, damping: float) -> FloatArray:
        """Newton's step, shorter the more it is damped."""
        matrix = np.diag(self.stiffness) + damping * self.usual
        for (_, slope), of in zip(at.pushes, self.contacts, strict=True):
            matrix += slope * np.outer(of.direction, of.direction)
        step, free = np.zeros(len(at.x)), self.movable
        step[free] = np.linalg.lstsq(matrix[np.ix_(free, free)], at.balance[free], rcond=None)[0]
        return step


def equilibrium(
    bodies: Sequence[ModalBody], loads: Sequence[FloatArray], contacts: Sequence[Pressed]
) -> FloatArray:
    """Return the modes of all bodies at rest.

    Parameters
    ----------
    bodies : sequence of ModalBody
    loads : sequence of ndarrays, shape (n,)
        Modal accelerations under gravity and loads at the start, for each body.
    contacts : sequence of Pressed

    Raises
    ------
    ConvergenceError
        If they come to no rest: nothing holds some body against its loads.
    """
    stiffness = np.concatenate([body.inertia * body.omega**2 for body in bodies])
    inertia = np.concatenate([body.inertia for body in bodies])
    load = np.where(inertia > 0.0, inertia, 0.0) * np.concatenate(loads)
    pile = _Pile(stiffness, load, inertia > 0.0, contacts)
    sprung = np.where(stiffness > 0.0, stiffness, 1.0)
    at, damping = pile.place(np.where(stiffness > 0.0, load / sprung, 0.0)), 1.0
    for _ in range(_MOST_STEPS):
        if pile.balanced(at):
            return at.x
        x = at.x + pile.step(at, damping)
        if not np.abs(x).max(initial=0.0) < _FARTHEST:
            break
        trial = pile.place(x)
        if trial.better_than(at):
            at, damping = trial, damping * _TIGHTER
        elif damping > _MOST_DAMPING:
            break
        else:
            damping *= _LOOSER
    raise ConvergenceError(
        "preload: no static equilibrium found; a body that nothing holds against gravity or its "
        f"load falls for ever (imbalance {np.abs(at.balance).max():.3g} N); support it, or start "
        "without preload"
    )
