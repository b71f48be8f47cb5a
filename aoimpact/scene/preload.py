"""Bodies at rest under gravity and loads, pressed on each other: where a run may start.

Newton's method on the balance of forces, damped: the potential energy of bodies on springs that
only push is convex. So the forces are determinate, in closed loops of contacts too, as far as what
the contacts give way is more than the rounding of where the bodies are.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..base import ConvergenceError, FloatArray, InputError, LawLimitError
from ..reduction import ModalBody
from .contact import Joint
from .network import Bound, ContactNetwork
from .springs import Springs

__all__ = ["Equilibrium", "equilibrium"]


_MOST_STEPS = 2000

# Steps after which the imbalance must be half of what it was, or the energy lower.
_PATIENCE = 40

# A step that brings balance nearer lets the next one be longer, one that does not, shorter.
_TIGHTER, _LOOSER, _MOST_DAMPING = 0.2, 10.0, 1e12

_EPSILON = float(np.finfo(np.float64).eps)

# Energies that differ by less are the same.
_ROUNDING = 1e-9

# What has moved as far falls for ever; farther, energies overflow.
_FARTHEST = 1e100

# Balance of forces relative to those that are there; and to the largest, where it comes no nearer.
_BALANCED, _SETTLED = 1e-12, 1e-14

# What nothing holds although all contacts stick falls for ever, if it is more than such a share of
# the imbalance, and than rounding makes of all forces.
_UNHELD, _UNHELD_OF_ALL = 1e-3, 1e-9

# Rounding of positions, in units of the last place; the share of the forces that it may make; and
# the share of those of the first overlap below which forces are none.
_UNITS, _DETERMINED, _NEGLIGIBLE = 4.0, 1e-6, 1e-9

# Contacts beyond which no loops are looked for, at a cost that grows with their cube.
_MOST_LOOPED = 1000


@dataclass(frozen=True, eq=False)
class Equilibrium:
    """Bodies at rest.

    Attributes
    ----------
    modes : tuple of ndarrays, shape (n,)
        Displacements of each body's modes.
    beside : tuple of ndarrays, shape (p,)
        What these leave out of the displacements of massless ports, m.
    """

    modes: tuple[FloatArray, ...]
    beside: tuple[FloatArray, ...]


@dataclass(frozen=True, eq=False)
class _Place:
    """Where the coordinates are, shape (n,): the forces left over there and those that there are;
    each contact's indentation, force, slope and what rounding of x makes of its force; and the
    energy that is least at rest, J."""

    x: FloatArray
    balance: FloatArray
    present: FloatArray
    depth: FloatArray
    force: FloatArray
    slope: FloatArray
    rounding: FloatArray
    energy: float

    def better_than(self, other: _Place) -> bool:
        """Whether it is lower; or as low, but for rounding, and nearer to balance."""
        if self.energy < other.energy:
            return True
        nearer = np.linalg.norm(self.balance) <= np.linalg.norm(other.balance)
        return bool(nearer) and self.energy <= other.energy + _ROUNDING * abs(other.energy)

    def no_nearer_than(self, other: _Place) -> bool:
        """Whether neither energy nor balance is worth the steps since."""
        gained = other.energy - self.energy > _ROUNDING * abs(other.energy)
        return not gained and bool(
            np.linalg.norm(self.balance) > 0.5 * np.linalg.norm(other.balance)
        )


@dataclass(frozen=True, eq=False)
class _Statics:
    """A network under loads, shape (n,), pressed on springs with gaps, m, shape (contacts,)."""

    network: ContactNetwork
    load: FloatArray
    springs: Springs
    gaps: FloatArray

    @cached_property
    def first(self) -> _Place:
        """Where the loads would bring the bodies without contacts; what is loose stays."""
        sprung = self.network.stiffness > 0.0
        return self.place(
            np.where(sprung, self.load / np.where(sprung, self.network.stiffness, 1), 0)
        )

    @cached_property
    def slopes(self) -> FloatArray:
        """Each contact's stiffness under all of the loads at once, or under the largest force of
        the first overlap if that is more: the scale of steps."""
        overlap = float(self.first.force.max(initial=0.0))
        return self.springs.stiffness_under(max(float(np.abs(self.load).sum()), overlap))

    def place(self, x: FloatArray) -> _Place:
        """What holds where the coordinates are x."""
        network, across = self.network, self.network.directions
        depth = across @ x - self.gaps
        force, slope = self.springs.force(depth)
        own = network.stiffness * x
        balance = np.where(network.movable, self.load - own - across.T @ force, 0.0)
        present = np.abs(self.load) + np.abs(own) + network.reach.T @ force
        energy = float(0.5 * x @ own - self.load @ x) + self.springs.energy(depth)
        rounding = self.rounding(x, slope)
        return _Place(x, balance, present, depth, force, slope, rounding, energy)

    def rounding(self, x: FloatArray, slopes: FloatArray) -> FloatArray:
        """What the last digits of x make of the contacts' forces, N."""
        reach = self.network.reach @ np.abs(x) + np.abs(self.gaps)
        rounding: FloatArray = slopes * _UNITS * _EPSILON * reach
        return rounding

    def balanced(self, at: _Place, besides: FloatArray | float = 0.0) -> bool:
        """Whether the forces left over are those of rounding, and besides, N, not more."""
        rounding = self.network.reach.T @ at.rounding
        return bool((np.abs(at.balance) <= _BALANCED * at.present + rounding + besides).all())

    def settled(self, at: _Place) -> bool:
        """Whether what holds the bodies is in balance as far as the largest force lets it be seen:
        what touches and is not pressed has no force of its own to measure the rest by."""
        holds = at.present - np.abs(self.load)
        return self.balanced(at, np.minimum(holds, _SETTLED * self.size(at)))

    def size(self, at: _Place) -> float:
        """The forces that are there, N."""
        return float(max(np.abs(self.load).max(initial=0.0), at.force.max(initial=0.0)))

    @cached_property
    def _stuck(self) -> Bound | None:
        """The network if no contact could open."""
        return self.network.bound(self.slopes)

    def unheld(self, at: _Place) -> int | None:
        """The coordinate of a force left over that nothing would hold if all contacts stuck."""
        if self._stuck is None:
            return None
        unheld = np.abs(self._stuck.moved(at.balance)[1])
        least = max(_UNHELD * np.abs(at.balance).max(), _UNHELD_OF_ALL * self.size(at))
        return int(unheld.argmax()) if unheld.max() > least else None

    def check_depth(self, at: _Place) -> None:
        """Refuse a rest that laws do not stand for."""
        limits = self.springs.limits
        for i in np.flatnonzero(at.depth > limits)[:1]:
            raise LawLimitError(
                f"preload: contact {i} is {at.depth[i]:.3g} m deep at rest, and its law stands up "
                f"to {limits[i]:.3g} m; take a larger patch, a longer table, or less load"
            )

    def check_limits(self, at: _Place) -> None:
        """Refuse laws that end before they bear the load, where no rest was found."""
        limits = self.springs.limits
        force, slope = self.springs.force(np.minimum(at.depth, limits))
        for i in np.flatnonzero((at.depth > limits) & (slope == 0.0))[:1]:
            raise LawLimitError(
                f"preload: contact {i} finds no rest: its law stands up to {limits[i]:.3g} m, "
                f"where it has {force[i]:.3g} N and rises no more; take a longer table, or less "
                "load"
            )

    def check_rounding(self, at: _Place, slopes: FloatArray, size: float) -> None:
        """Refuse contacts so stiff that forces of that size, N, are rounding."""
        rounding = self.rounding(at.x, slopes)
        if rounding.max(initial=0.0) <= _DETERMINED * size:
            return
        worst = int(rounding.argmax())
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
        closed = np.flatnonzero(at.depth >= -1e-9 * np.abs(self.gaps))
        if not 0 < len(closed) <= _MOST_LOOPED:
            return False
        rows = self.network.directions[closed][:, self.network.loose].toarray()
        return int(np.linalg.matrix_rank(rows)) < len(closed)

    def least_moved(self, at: _Place) -> _Place:
        """The same rest with what nothing presses as near to where it was put as the others let it.

        Newton's steps drag along what is touched, open contacts too.
        """
        pressed = at.force > at.rounding + _SETTLED * self.size(at)
        x, room, columns = at.x.copy(), np.maximum(-at.depth, 0.0), self.network.directions.tocsc()
        drifting = [
            (where, way)
            for where, way in self.network.adrift(pressed, x)
            if abs(self.load[where].sum()) <= _BALANCED * np.abs(self.load[where]).sum()
        ]
        # There and back: in a row the first to move makes room for the next.
        for where, way in (*drifting, *reversed(drifting)):
            closing = columns[:, where] @ way
            nearer = closing > 0.0
            share = (room[nearer] / closing[nearer]).min(initial=1.0)
            x[where] += share * way
            room -= share * closing
            way *= 1.0 - share
        moved = self.place(x)
        return moved if self.settled(moved) else at

    def step(self, at: _Place, damping: float) -> FloatArray | None:
        """Newton's step, shorter the more it is damped; None if so little damping gives none."""
        bound = self.network.bound(at.slope + damping * self.slopes, 1.0 + damping)
        return None if bound is None else self.network.centred(bound.moved(at.balance)[0])


def equilibrium(
    bodies: Sequence[ModalBody],
    contacts: Sequence[Joint],
    *,
    gravity: float,
    forces: Sequence[FloatArray],
) -> Equilibrium:
    """Return all bodies at rest.

    Parameters
    ----------
    bodies : sequence of ModalBody
    contacts : sequence of Joint
    gravity : float
        m/s².
    forces : sequence of ndarrays, shape (p,)
        On the ports of each body at the start, N.

    Raises
    ------
    ConvergenceError
        If there is no static equilibrium: some body is free to move under its loads.
    InputError
        If the forces at rest are not determined.
    LawLimitError
        If a contact is deeper than its law is valid for.
    """
    network = ContactNetwork(bodies, [of.ports for of in contacts])
    springs = Springs([of.law for of in contacts])
    statics = _Statics(
        network, network.load(gravity, forces), springs, np.array([of.gap for of in contacts])
    )
    first = statics.first
    at, unheld = _descend(statics, first)
    if statics.settled(at):
        at = statics.least_moved(at)
        size = max(statics.size(at), _NEGLIGIBLE * statics.size(first))
        statics.check_rounding(at, at.slope, size)
        statics.check_depth(at)
        return Equilibrium(network.modes(at.x), network.beside(at.x))
    statics.check_rounding(first, statics.slopes, statics.size(first))
    statics.check_limits(at)
    worst = int(np.abs(at.balance).argmax()) if unheld is None else unheld
    raise ConvergenceError(
        "preload: no static equilibrium found; a body that nothing holds against gravity or its "
        f"load falls for ever (imbalance {abs(at.balance[worst]):.3g} N on body "
        f"{network.owner[worst]}); support it, or start without preload"
    )


def _descend(statics: _Statics, at: _Place) -> tuple[_Place, int | None]:
    """The place of rest, or how far it goes; and the coordinate of what nothing holds."""
    before, damping = at, 1.0
    for number in range(_MOST_STEPS):
        if statics.balanced(at):
            break
        if (unheld := statics.unheld(at)) is not None:
            return at, unheld
        if number % _PATIENCE == _PATIENCE - 1 and at.no_nearer_than(before):
            break
        before = at if number % _PATIENCE == 0 else before
        step = statics.step(at, damping)
        if step is not None and not np.abs(at.x + step).max(initial=0.0) < _FARTHEST:
            break
        trial = None if step is None else statics.place(at.x + step)
        if trial is not None and trial.better_than(at):
            at, damping = trial, damping * _TIGHTER
        elif damping > _MOST_DAMPING:
            break
        else:
            damping *= _LOOSER
    return at, None
