"""Static equilibrium of bodies in contact under gravity and loads: where a run may start.

It is found by damped Newton iterations on the balance of forces. The potential energy of bodies on
springs that only push is convex. So the forces are determinate, in closed loops of contacts too, as
long as the indentations are larger than the rounding of the bodies' positions.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..base import HUGE, ConvergenceError, FloatArray, InputError, LawLimitError
from ..linalg import LARGEST
from ..reduction import ModalBody
from .contact import Contact
from .network import ContactNetwork, LinearNetwork
from .springs import Springs

_EPSILON = float(np.finfo(np.float64).eps)

# The constants below were tuned in tests/scene/test_preload.py, which also tries other values.

# A bound, where every step gains a little: 300 do.
_MOST_STEPS = 2000

# Steps after which the imbalance must be half of what it was, or the energy lower. With 10 a stiff
# loop is given up too early; without it scenes that have no rest take twice as long to be refused.
_PATIENCE = 40

# The damping of the next step after one that comes nearer to balance, and after one that does not:
# 0.1 to 0.5, and 3 to 100, take the same time within a tenth. With more than the last a step no
# longer changes the coordinates.
_TIGHTER, _LOOSER, _MOST_DAMPING = 0.2, 10.0, 1.0 / _EPSILON

# Energies that differ by less are the same: sums of many terms that cancel. 1e-12 does as well,
# and with none the last steps are refused.
_ROUNDING = 1e-9

# Imbalance that counts as none, relative to the forces on the same coordinate; and, where
# iterations gain no more, relative to the largest force. Ten times as much, and for the first a
# tenth, does as well; without the second what touches without force comes to no rest.
_BALANCED, _SETTLED = 1e-12, 1e-14

# A force that nothing would carry even if all contacts stuck makes a body fall for ever, if it is
# more than these shares of the imbalance and of all forces: less is on its way to balance. From
# 1e-6 to 0.1, and up to 1e-6, the same scenes are refused.
_UNCONSTRAINED, _UNCONSTRAINED_OF_ALL = 1e-3, 1e-9

# Rounding of positions, in units in the last place, one for each of the sums that make up an
# indentation (with 16, rows that are determined are refused); the largest share of the forces that
# may come of it: six digits, as a run has (with 1e-8 such rows are refused); and the share of the
# first overlap's forces below which forces are none (1e-6 does as well).
_UNITS, _DETERMINED, _NEGLIGIBLE = 4.0, 1e-6, 1e-9

# A gap that rounding may have left of none, of the gap as it was given.
_CLOSED = 1e-9

# With more contacts no closed loops are looked for, at a cost that grows with their cube: it is
# for a message only.
_MOST_LOOPED = 1000


@dataclass(frozen=True, eq=False)
class Equilibrium:
    """Bodies at rest.

    Attributes
    ----------
    modes : tuple of ndarrays, shape (n,)
        Displacements of each body's modes.
    beside : tuple of ndarrays, shape (p,)
        Displacements of massless ports beyond those of the modes, m.
    """

    modes: tuple[FloatArray, ...]
    beside: tuple[FloatArray, ...]


@dataclass(frozen=True, eq=False)
class _Configuration:
    """The bodies displaced by x.

    Attributes
    ----------
    x, balance, present : ndarrays, shape (n,)
        Coordinates, the imbalance of forces on them, and the sum of the sizes of these.
    depth, force, slope, rounding : ndarrays, shape (contacts,)
        Indentation, m, force, N, stiffness, N/m, and what rounding of x makes of the force, N.
    energy : float
        The potential energy, J, least at rest.
    """

    x: FloatArray
    balance: FloatArray
    present: FloatArray
    depth: FloatArray
    force: FloatArray
    slope: FloatArray
    rounding: FloatArray
    energy: float

    def better_than(self, other: _Configuration) -> bool:
        """True if its energy is lower; or as low, but for rounding, and it is nearer to balance."""
        if self.energy < other.energy:
            return True
        nearer = np.linalg.norm(self.balance) <= np.linalg.norm(other.balance)
        return bool(nearer) and self.energy <= other.energy + _ROUNDING * abs(other.energy)

    def no_nearer_than(self, other: _Configuration) -> bool:
        """True if the steps since have gained neither energy nor balance."""
        gained = other.energy - self.energy > _ROUNDING * abs(other.energy)
        return not gained and bool(
            np.linalg.norm(self.balance) > 0.5 * np.linalg.norm(other.balance)
        )


@dataclass(frozen=True, eq=False)
class _Statics:
    """A network under loads, N, shape (n,), its contacts with gaps, m, shape (contacts,)."""

    network: ContactNetwork
    load: FloatArray
    springs: Springs
    gaps: FloatArray

    @cached_property
    def first(self) -> _Configuration:
        """The static deflection without contacts; unsprung coordinates stay."""
        sprung = self.network.stiffness > 0.0
        return self.at(np.where(sprung, self.load / np.where(sprung, self.network.stiffness, 1), 0))

    @cached_property
    def slopes(self) -> FloatArray:
        """Each contact's stiffness, N/m, which scales the steps.

        Under all loads at once, or under the largest force of the first overlap if that is more.
        """
        overlap = float(self.first.force.max(initial=0.0))
        return self.springs.stiffness_under(max(float(np.abs(self.load).sum()), overlap))

    def at(self, x: FloatArray) -> _Configuration:
        """Return the configuration with coordinates x."""
        network, directions = self.network, self.network.directions
        depth = directions @ x - self.gaps
        force, slope = self.springs.force(depth)
        own = network.stiffness * x
        balance = np.where(network.movable, self.load - own - directions.T @ force, 0.0)
        present = np.abs(self.load) + np.abs(own) + network.reach.T @ force
        energy = float(0.5 * x @ own - self.load @ x) + self.springs.energy(depth)
        rounding = self.rounding(x, slope)
        return _Configuration(x, balance, present, depth, force, slope, rounding, energy)

    def rounding(self, x: FloatArray, slopes: FloatArray) -> FloatArray:
        """Return what the last digits of x make of the contact forces, N."""
        reach = self.network.reach @ np.abs(x) + np.abs(self.gaps)
        rounding: FloatArray = slopes * _UNITS * _EPSILON * reach
        return rounding

    def balanced(self, at: _Configuration, besides: FloatArray | float = 0.0) -> bool:
        """True if the imbalance is no more than rounding, and `besides`, N."""
        rounding = self.network.reach.T @ at.rounding
        return bool((np.abs(at.balance) <= _BALANCED * at.present + rounding + besides).all())

    def settled(self, at: _Configuration) -> bool:
        """True if the reactions balance the loads to the digits of the largest force.

        A contact that touches without force has none of its own to measure an imbalance by.
        """
        holds = at.present - np.abs(self.load)
        return self.balanced(at, np.minimum(holds, _SETTLED * self.size(at)))

    def size(self, at: _Configuration) -> float:
        """The largest force, N."""
        return float(max(np.abs(self.load).max(initial=0.0), at.force.max(initial=0.0)))

    @cached_property
    def _stuck(self) -> LinearNetwork | None:
        """The network with contacts that cannot open."""
        return self.network.linearized(self.slopes)

    def unconstrained(self, at: _Configuration) -> int | None:
        """The coordinate of an imbalance that nothing would carry if all contacts stuck."""
        if self._stuck is None:
            return None
        carried_by_none = np.abs(self._stuck.displacement(at.balance)[1])
        least = max(
            _UNCONSTRAINED * np.abs(at.balance).max(), _UNCONSTRAINED_OF_ALL * self.size(at)
        )
        return int(carried_by_none.argmax()) if carried_by_none.max() > least else None

    def check_depth(self, at: _Configuration) -> None:
        """Refuse a contact deeper than its law is valid for."""
        limits = self.springs.limits
        for i in np.flatnonzero(at.depth > limits)[:1]:
            raise LawLimitError(
                f"preload: contact {i} is {at.depth[i]:.3g} m deep at rest, and its law is valid "
                f"to {limits[i]:.3g} m; take a larger patch, a longer table, or less load"
            )

    def check_limits(self, at: _Configuration) -> None:
        """Refuse laws that end before they carry the load, where no equilibrium was found."""
        limits = self.springs.limits
        force, slope = self.springs.force(np.minimum(at.depth, limits))
        for i in np.flatnonzero((at.depth > limits) & (slope == 0.0))[:1]:
            raise LawLimitError(
                f"preload: contact {i} finds no rest: its law is valid to {limits[i]:.3g} m, "
                f"where it has {force[i]:.3g} N and rises no more; take a longer table, or less "
                "load"
            )

    def check_stiffness(self) -> None:
        """Refuse contacts whose stiffness leads out of the range of numbers."""
        worst = int(np.argmax(self.slopes)) if len(self.slopes) else -1
        if worst >= 0 and not self.slopes[worst] <= LARGEST:
            raise InputError(
                f"preload: contact {worst} is {self.slopes[worst]:.3g} N/m stiff under the loads, "
                "which cannot be computed with; give its law in N and m, or start without preload"
            )

    def check_rounding(self, at: _Configuration, slopes: FloatArray, size: float) -> None:
        """Refuse contacts so stiff that forces of this size, N, are rounding."""
        rounding = self.rounding(at.x, slopes)
        if rounding.max(initial=0.0) <= _DETERMINED * size:
            return
        worst = int(rounding.argmax())
        loop = (
            "; its bodies are in a closed loop of contacts, which is statically indeterminate "
            "where these do not deform"
            if self._in_loop(at)
            else ""
        )
        raise InputError(
            f"preload: the forces at rest are not determined: contact {worst} is so stiff, "
            f"{slopes[worst]:.3g} N/m, that the last digit of where its bodies are makes "
            f"{rounding[worst]:.2g} N{loop}; take a softer law, or smaller gaps"
        )

    def _in_loop(self, at: _Configuration) -> bool:
        """True if more contacts are closed, but for rounding, than balance determines."""
        closed = np.flatnonzero(at.depth >= -_CLOSED * np.abs(self.gaps))
        if not 0 < len(closed) <= _MOST_LOOPED:
            return False
        rows = self.network.directions[closed][:, self.network.unsprung].toarray()
        return int(np.linalg.matrix_rank(rows)) < len(closed)

    def least_moved(self, at: _Configuration) -> _Configuration:
        """Return the equilibrium with unloaded bodies as near to their places as others allow.

        Newton's steps drag along all that touches, also where contacts are open.
        """
        pressed = at.force > at.rounding + _SETTLED * self.size(at)
        x, room, columns = at.x.copy(), np.maximum(-at.depth, 0.0), self.network.directions.tocsc()
        floating = [
            (where, way)
            for where, way in self.network.floating(pressed, x)
            if abs(self.load[where].sum()) <= _BALANCED * np.abs(self.load[where]).sum()
        ]
        # Forward and back: in a row the first to move makes room for the next.
        for where, way in (*floating, *reversed(floating)):
            closing = columns[:, where] @ way
            nearer = closing > 0.0
            share = (room[nearer] / closing[nearer]).min(initial=1.0)
            x[where] += share * way
            room -= share * closing
            way *= 1.0 - share
        moved = self.at(x)
        return moved if self.settled(moved) else at

    def step(self, at: _Configuration, damping: float) -> FloatArray | None:
        """Return a damped Newton step; None where the matrix is singular with so little damping."""
        linear = self.network.linearized(at.slope + damping * self.slopes, 1.0 + damping)
        return None if linear is None else self.network.centred(linear.displacement(at.balance)[0])


def equilibrium(
    bodies: Sequence[ModalBody],
    contacts: Sequence[Contact],
    *,
    gravity: float,
    forces: Sequence[FloatArray],
) -> Equilibrium:
    """Return all bodies at rest.

    Parameters
    ----------
    bodies : sequence of ModalBody
    contacts : sequence of Contact
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
    statics.check_stiffness()
    at, unconstrained = _descend(statics, first)
    if statics.settled(at):
        at = statics.least_moved(at)
        size = max(statics.size(at), _NEGLIGIBLE * statics.size(first))
        statics.check_rounding(at, at.slope, size)
        statics.check_depth(at)
        return Equilibrium(network.modes(at.x), network.beside(at.x))
    statics.check_rounding(first, statics.slopes, statics.size(first))
    statics.check_limits(at)
    worst = int(np.abs(at.balance).argmax()) if unconstrained is None else unconstrained
    raise ConvergenceError(
        "preload: no static equilibrium found; a body that nothing supports against gravity or its "
        "load, or only a law whose force cannot be as large, falls for ever (imbalance "
        f"{abs(at.balance[worst]):.3g} N on body {network.owner[worst]}); support it, or start "
        "without preload"
    )


def _descend(statics: _Statics, at: _Configuration) -> tuple[_Configuration, int | None]:
    """The last configuration, and the coordinate of what nothing would carry, if any."""
    before, damping = at, 1.0
    for number in range(_MOST_STEPS):
        if statics.balanced(at):
            break
        if (unconstrained := statics.unconstrained(at)) is not None:
            return at, unconstrained
        if number % _PATIENCE == _PATIENCE - 1 and at.no_nearer_than(before):
            break
        before = at if number % _PATIENCE == 0 else before
        step = statics.step(at, damping)
        if step is not None and not np.abs(at.x + step).max(initial=0.0) < HUGE:
            break
        trial = None if step is None else statics.at(at.x + step)
        if trial is not None and trial.better_than(at):
            at, damping = trial, damping * _TIGHTER
        elif damping > _MOST_DAMPING:
            break
        else:
            damping *= _LOOSER
    return at, None
