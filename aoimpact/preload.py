"""Bodies at rest under gravity and loads, pressed on each other: where a run may start.

Newton's method on the balance of forces in modes, damped: the potential energy of bodies on springs
that only push is convex.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
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
    movable = inertia > 0.0
    x = np.where(stiffness > 0.0, load / np.where(stiffness > 0.0, stiffness, 1.0), 0.0)
    usual = _usual_stiffness(contacts, float(np.abs(load).sum()), len(x)) + np.diag(stiffness)
    balance, pushes = _imbalance(x, stiffness, load, contacts, movable)
    energy, damping = _potential(x, stiffness, load, contacts), 1.0
    for _ in range(_MOST_STEPS):
        size = np.abs(load).max(initial=0.0) + sum(
            force * np.abs(of.direction).max()
            for (force, _), of in zip(pushes, contacts, strict=True)
        )
        if np.abs(balance).max(initial=0.0) <= _BALANCED * size:
            return x
        matrix = np.diag(stiffness) + damping * usual
        for (_, slope), of in zip(pushes, contacts, strict=True):
            matrix += slope * np.outer(of.direction, of.direction)
        step = np.zeros(len(x))
        step[movable] = _solve(matrix[np.ix_(movable, movable)], balance[movable])
        if not np.abs(x + step).max(initial=0.0) < _FARTHEST:
            break
        trial, trial_pushes = _imbalance(x + step, stiffness, load, contacts, movable)
        lower = _potential(x + step, stiffness, load, contacts)
        nearer = np.linalg.norm(trial) <= np.linalg.norm(balance)
        if lower < energy or (nearer and lower <= energy + _ROUNDING * abs(energy)):
            x, balance, pushes, energy = x + step, trial, trial_pushes, lower
            damping *= _TIGHTER
        elif damping > _MOST_DAMPING:
            break
        else:
            damping *= _LOOSER
    raise ConvergenceError(
        "preload: no static equilibrium found; a body that nothing holds against gravity or its "
        f"load falls for ever (imbalance {np.abs(balance).max():.3g} N); support it, or start "
        "without preload"
    )


def _usual_stiffness(contacts: Sequence[Pressed], force: float, n: int) -> FloatArray:
    """What the contacts would have for stiffness under all of the loads: the scale of steps."""
    matrix = np.zeros((n, n))
    for of in contacts:
        depth = 1.0
        for _ in range(_HALVINGS):
            depth = depth * 0.5 if of.force(depth)[0] > force else depth
        matrix += of.force(depth)[1] * np.outer(of.direction, of.direction)
    return matrix


def _imbalance(
    x: FloatArray,
    stiffness: FloatArray,
    load: FloatArray,
    contacts: Sequence[Pressed],
    movable: npt.NDArray[np.bool_],
) -> tuple[FloatArray, list[tuple[float, float]]]:
    """Generalised forces that are left, and each contact's force and stiffness."""
    pushes = [of.force(float(of.direction @ x) - of.gap) for of in contacts]
    balance = load - stiffness * x
    for (force, _), of in zip(pushes, contacts, strict=True):
        balance = balance - force * of.direction
    return np.where(movable, balance, 0.0), pushes


def _potential(
    x: FloatArray, stiffness: FloatArray, load: FloatArray, contacts: Sequence[Pressed]
) -> float:
    """The energy that is least at rest, J."""
    stored = sum(of.energy(float(of.direction @ x) - of.gap) for of in contacts)
    return float(0.5 * x @ (stiffness * x) - load @ x) + stored


def _solve(matrix: FloatArray, right: FloatArray) -> FloatArray:
    return np.asarray(np.linalg.lstsq(matrix, right, rcond=None)[0], dtype=np.float64)
