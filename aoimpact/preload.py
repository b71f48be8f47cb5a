"""Bodies at rest under gravity and loads, pressed on each other: where a run may start.

Newton's method on the balance of forces in modes, damped: the potential energy of bodies on springs
that only push is convex. So the forces are determinate, in closed loops of contacts too, as far as
what the contacts give way is more than the rounding of where the bodies are.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt
import scipy.sparse as sp

from . import _core
from .errors import ConvergenceError, InputError, LawLimitError
from .modalbody import ModalBody

__all__ = ["Pressed", "equilibrium"]

FloatArray = npt.NDArray[np.float64]

_MOST_STEPS = 2000

# A step that brings balance nearer lets the next one be longer, one that does not, shorter.
_TIGHTER, _LOOSER, _MOST_DAMPING = 0.2, 10.0, 1e12

_EPSILON = float(np.finfo(np.float64).eps)
_HALVINGS, _BISECTIONS = 60, 200

# Energies that differ by less are the same.
_ROUNDING = 1e-9

# What has moved as far falls for ever; farther, energies overflow.
_FARTHEST = 1e100

# Balance of forces relative to the forces that are there.
_BALANCED = 1e-12

# Rounding of positions, in units of the last place; the share of the forces that it may make; and
# the share of those of the first overlap below which forces are none.
_UNITS, _DETERMINED, _NEGLIGIBLE = 4.0, 1e-6, 1e-9


@dataclass(frozen=True, eq=False)
class Pressed:
    """A contact as statics sees it: δ = direction · x - residual F - gap.

    Attributes
    ----------
    direction : ndarray, shape (n,)
    gap : float
        m.
    law : tuple
        As the core takes it.
    limit : float
        Indentation that the law stands for, m; beyond, it goes on straight while rest is looked
        for.
    residual : float
        m/N.
    """

    direction: FloatArray
    gap: float
    law: tuple[Any, ...]
    limit: float
    residual: float

    def force(self, free: float) -> tuple[float, float]:
        """Return F and dF/d(free) at the indentation `free` that there would be without F."""
        if free <= 0.0:
            return 0.0, 0.0
        force, stiffness = self._law(self.depth(free))
        return force, stiffness / (1.0 + self.residual * stiffness)

    def energy(self, free: float) -> float:
        """Return what is stored there, J, in the law and the residual compliance."""
        if free <= 0.0:
            return 0.0
        depth, out = self.depth(free), np.empty(1)
        within = min(depth, self.limit)
        _core.law_potential(self.law, np.array([within]), out)
        beyond = 0.5 * (depth - within) * (self._law(within)[0] + self._law(depth)[0])
        return float(out[0]) + beyond + 0.5 * self.residual * self._law(depth)[0] ** 2

    def depth(self, free: float) -> float:
        """Return the indentation that is left of it."""
        low, high = 0.0, free
        for _ in range(_BISECTIONS if self.residual else 0):
            middle = 0.5 * (low + high)
            over = middle + self.residual * self._law(middle)[0] > free
            low, high = (low, middle) if over else (middle, high)
        return high

    def _law(self, indentation: float) -> tuple[float, float]:
        out = np.empty((3, 1))
        within = min(indentation, self.limit)
        _core.law_force(self.law, np.array([within]), np.zeros(1), *out)
        force, stiffness = float(out[0, 0]), float(out[1, 0])
        return force + stiffness * (indentation - within), stiffness


@dataclass(frozen=True, eq=False)
class _Place:
    """Where the bodies are, shape (n,): the forces left over there, each contact's force and slope,
    what rounding of x makes of its force, N, and the energy that is least at rest, J."""

    x: FloatArray
    balance: FloatArray
    pushes: list[tuple[float, float]]
    rounding: list[float]
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
    def slopes(self) -> list[float]:
        """Each contact's stiffness under all of the loads at once, on level stretches the mean."""
        load, found = float(np.abs(self.load).sum()), []
        for of in self.contacts:
            depth = 1.0
            for _ in range(_HALVINGS):
                depth = depth * 0.5 if of.force(depth)[0] > load else depth
            force, slope = of.force(depth)
            found.append(max(slope, force / depth))
        return found

    @cached_property
    def usual(self) -> FloatArray:
        """The stiffness, shape (n, n), of all of it so: the scale of steps."""
        return np.diag(self.stiffness) + self.pressed(self.slopes)

    @cached_property
    def directions(self) -> sp.csr_array:
        """Those of the contacts, shape (contacts, n); each has entries of its two bodies only."""
        rows = [of.direction for of in self.contacts]
        return sp.csr_array(np.array(rows).reshape(len(rows), len(self.load)))

    def pressed(self, slopes: Sequence[float]) -> FloatArray:
        """The stiffness, shape (n, n), that contacts of such slopes, N/m, add."""
        across = self.directions
        added: FloatArray = (across.T @ sp.diags_array(np.array(slopes)) @ across).toarray()
        return added

    def place(self, x: FloatArray) -> _Place:
        """What holds where the modes are x."""
        depths = [float(of.direction @ x) - of.gap for of in self.contacts]
        pushes = [of.force(depth) for of, depth in zip(self.contacts, depths, strict=True)]
        balance = self.load - self.stiffness * x
        for (force, _), of in zip(pushes, self.contacts, strict=True):
            balance = balance - force * of.direction
        rounding = self.rounding(x, [slope for _, slope in pushes])
        stored = sum(of.energy(depth) for of, depth in zip(self.contacts, depths, strict=True))
        energy = float(0.5 * x @ (self.stiffness * x) - self.load @ x) + stored
        return _Place(x, np.where(self.movable, balance, 0.0), pushes, rounding, energy)

    def rounding(self, x: FloatArray, slopes: list[float]) -> list[float]:
        """What the last digits of x make of the contacts' forces, N."""
        return [
            slope * _UNITS * _EPSILON * float(np.abs(of.direction) @ np.abs(x) + abs(of.gap))
            for slope, of in zip(slopes, self.contacts, strict=True)
        ]

    def balanced(self, at: _Place) -> bool:
        """Whether the forces left over are those of rounding."""
        rounding = (abs(self.directions).T @ np.array(at.rounding)).max(initial=0.0)
        left = np.abs(at.balance).max(initial=0.0)
        largest = max((force for force, _ in at.pushes), default=0.0)
        return bool(left <= _BALANCED * max(largest, np.abs(self.load).max(initial=0.0)) + rounding)

    def size(self, at: _Place) -> float:
        """The forces that are there, N."""
        return float(np.abs(self.load).max(initial=0.0)) + sum(
            force * float(np.abs(of.direction).max())
            for (force, _), of in zip(at.pushes, self.contacts, strict=True)
        )

    def check_depth(self, at: _Place) -> None:
        """Refuse a rest that laws do not stand for."""
        for i, of in enumerate(self.contacts):
            depth = of.depth(max(float(of.direction @ at.x) - of.gap, 0.0))
            if depth > of.limit:
                raise LawLimitError(
                    f"preload: contact {i} is {depth:.3g} m deep at rest, and its law stands up to "
                    f"{of.limit:.3g} m; take a larger patch, a longer table, or less load"
                )

    def check_limits(self, at: _Place) -> None:
        """Refuse laws that end before they bear the load, where no rest was found."""
        for i, of in enumerate(self.contacts):
            if float(of.direction @ at.x) - of.gap > of.limit and of.force(of.limit)[1] == 0.0:
                raise LawLimitError(
                    f"preload: contact {i} finds no rest: its law stands up to {of.limit:.3g} m, "
                    f"where it has {of.force(of.limit)[0]:.3g} N and rises no more; take a longer "
                    "table, or less load"
                )

    def check_rounding(self, at: _Place, slopes: list[float], size: float) -> None:
        """Refuse contacts so stiff that forces of that size, N, are rounding."""
        rounding = self.rounding(at.x, slopes)
        worst = max(range(len(rounding)), key=rounding.__getitem__, default=0)
        if not rounding or rounding[worst] <= _DETERMINED * size:
            return
        loop = (
            "; its bodies are held by a closed loop of contacts, which is statically indeterminate "
            "where these do not give way"
            if self._in_loop(at)
            else ""
        )
        raise InputError(
            f"preload: the forces at rest are not determined: contact {worst} is so stiff, "
            f"{slopes[worst]:.3g} N/m, that the last digit of where its bodies are makes "
            f"{rounding[worst]:.2g} N{loop}; take a softer law, or smaller gaps"
        )

    def _in_loop(self, at: _Place) -> bool:
        """Whether there are more contacts, closed but for rounding, than balance determines."""
        rows = [
            of.direction[self.movable & (self.stiffness == 0.0)]
            for of in self.contacts
            if float(of.direction @ at.x) - of.gap >= -1e-9 * abs(of.gap)
        ]
        return bool(rows) and int(np.linalg.matrix_rank(np.array(rows))) < len(rows)

    def step(self, at: _Place, damping: float) -> FloatArray:
        """Newton's step, shorter the more it is damped."""
        slopes = [slope for _, slope in at.pushes]
        matrix = np.diag(self.stiffness) + damping * self.usual + self.pressed(slopes)
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
    InputError
        If the forces at rest are not determined.
    LawLimitError
        If a contact is deeper than its law stands for.
    """
    stiffness = np.concatenate([body.inertia * body.omega**2 for body in bodies])
    inertia = np.concatenate([body.inertia for body in bodies])
    load = np.where(inertia > 0.0, inertia, 0.0) * np.concatenate(loads)
    pile = _Pile(stiffness, load, inertia > 0.0, contacts)
    sprung = np.where(stiffness > 0.0, stiffness, 1.0)
    at, damping = pile.place(np.where(stiffness > 0.0, load / sprung, 0.0)), 1.0
    first = at
    for _ in range(_MOST_STEPS):
        if pile.balanced(at):
            size = max(pile.size(at), _NEGLIGIBLE * pile.size(first))
            pile.check_rounding(at, [slope for _, slope in at.pushes], size)
            pile.check_depth(at)
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
    pile.check_rounding(first, pile.slopes, pile.size(first))
    pile.check_limits(at)
    raise ConvergenceError(
        "preload: no static equilibrium found; a body that nothing holds against gravity or its "
        f"load falls for ever (imbalance {np.abs(at.balance).max():.3g} N); support it, or start "
        "without preload"
    )
