"""Static equilibrium of bodies in contact under gravity and loads, as the start of a run.

The coordinates are modal coordinates of the bodies, and massless coordinates for the displacements
of massless contacts beyond the modes. The potential energy of bodies on springs that only push is
convex, so that damped Newton iterations on the balance of forces find its minimum. The forces are
determinate, also in closed loops of contacts, if indentations exceed the rounding errors of
positions.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from .. import _core
from ..base import (
    PRINTED,
    ROUNDING,
    ArrayPair,
    ConvergenceError,
    FloatArray,
    InputError,
    IntArray,
    LawLimitError,
    sp,
)
from ..laws import ContactLaw
from ..linalg import LARGEST
from ..reduction import Body
from .contact import Contact

_EPSILON = float(np.finfo(np.float64).eps)

# Largest number of steps. Towers of a thousand balls take some 50.
_MOST_STEPS = 1000

# Factor on the damping of Newton steps after a full step. Values from 0.02 to 0.2 change the number
# of steps by up to a third.
_TIGHTER = 0.1

# Largest relative error of forces due to rounding: six digits, as in a run (with 1e-8, determinate
# rows of bodies are refused).
_DETERMINED = 1e-6


class Equilibrium(NamedTuple):
    """Static equilibrium of the bodies.

    Attributes
    ----------
    modes : list of ndarrays, shape (n,)
        Modal coordinates of each body.
    forces : ndarray, shape (contacts,)
        Contact forces, N.
    """

    modes: list[FloatArray]
    forces: FloatArray


class _Springs:
    """Contacts as springs that only push, continued linearly beyond the limits of their laws."""

    def __init__(self, laws: Sequence[ContactLaw]) -> None:
        same: dict[ContactLaw, list[int]] = {}
        for number, law in enumerate(laws):
            same.setdefault(law, []).append(number)
        self._kinds = [(law.for_core(), np.array(which)) for law, which in same.items()]
        self.limits = np.array([law.limit for law in laws])

    def force(self, depth: FloatArray) -> ArrayPair:
        """Return forces, N, and their slopes, N/m, at indentations, m, shape (contacts,) each."""
        force, slope = np.zeros((2, len(depth)))
        within = np.clip(depth, 0.0, self.limits)
        for law, which in self._kinds:
            still, own, steepness, damping = np.zeros((4, len(which)))
            _core.law_force(law, within[which], still, own, steepness, damping, False)
            force[which], slope[which] = own, steepness
        slope = np.where(depth > 0.0, np.maximum(slope, 0.0), 0.0)  # a rounding error may be < 0
        return np.where(depth > 0.0, force + slope * (depth - within), 0.0), slope

    def stiffness_under(self, load: float) -> FloatArray:
        """Return the larger of tangent and secant stiffness of each spring, N/m, at `load`, N."""
        # Doubling keeps a user's law from much larger indentations than those of the run.
        depth = np.full(len(self.limits), _EPSILON)
        while (deeper := (depth < 1.0 / _EPSILON) & (self.force(2.0 * depth)[0] <= load)).any():
            depth[deeper] *= 2.0
        force, slope = self.force(depth)
        return np.asarray(np.maximum(slope, force / depth))


@dataclass(frozen=True, eq=False)
class _Configuration:
    """The bodies displaced by x, and the forces on them.

    Attributes
    ----------
    x, balance, present : ndarrays, shape (n,)
        Coordinates, the sum of the forces on each, and the sum of the absolute values of the
        forces.
    depth, force, slope, rounding : ndarrays, shape (contacts,)
        Indentation, m, force, N, stiffness, N/m, and error of the force due to rounding errors of
        x, N.
    """

    x: FloatArray
    balance: FloatArray
    present: FloatArray
    depth: FloatArray
    force: FloatArray
    slope: FloatArray
    rounding: FloatArray


class _Statics:
    """Bodies and the contacts between them as one network of springs under loads.

    Attributes
    ----------
    stiffness, inertia, load : ndarrays, shape (n,)
        Stiffness, N/m, mass, kg (0 if massless), and load, N (0 for a wall), of each coordinate.
    owner : ndarray of int, shape (n,)
        Number of the body of each coordinate.
    movable, sprung, free : ndarrays of bool, shape (n,)
        True for coordinates of bodies other than walls; of these, for coordinates with a stiffness,
        and for coordinates without.
    directions, reach : sparse arrays, shape (contacts, n)
        Matrix D of the indentations D x - gaps, and its absolute values.
    """

    def __init__(
        self,
        bodies: Sequence[Body],
        contacts: Sequence[Contact],
        gravity: float,
        forces: Sequence[FloatArray],
    ) -> None:
        self._bodies, shapes, columns = bodies, [], []
        for number, body in enumerate(bodies):
            known = np.zeros((body.ports,) * 2) if body.residual is None else body.residual
            compliance, beside = np.linalg.eigh(known)
            soft = compliance > 0.0
            none = np.zeros(int(soft.sum()))
            shapes.append(np.hstack([body.shape, beside[:, soft]]))
            own = (
                body.inertia,
                body.inertia * body.omega**2,
                gravity * body.whole.weight * body.inertia,
            )
            more = none, 1.0 / compliance[soft], none
            values = [np.concatenate(both) for both in zip(own, more, strict=True)]
            held = (body.omega > 0.0) | body.shape.any(axis=0)  # by a stiffness or by a contact
            movable = np.concatenate([held & (body.inertia > 0.0), none == 0.0])
            columns.append([*values, movable, np.full(len(movable), number)])
        self.inertia, self.stiffness, weight, self.movable, self.owner = map(
            np.concatenate, zip(*columns, strict=True)
        )
        self.sprung = self.movable & (self.stiffness > 0.0)
        self.free = self.movable & (self.stiffness == 0.0)
        shape = sp.block_diag(shapes, format="csr")
        self.load = np.where(self.movable, weight + shape.T @ np.concatenate(forces), 0.0)
        first = np.cumsum([0, *(body.ports for body in bodies)])
        ends = [[first[body] + port for body, port in of.ports] for of in contacts]
        one, other = np.array(ends, dtype=np.intp).reshape(-1, 2).T
        self.directions = sp.csr_array(shape[one] - shape[other])
        self.reach = abs(self.directions)
        self.pairs = np.array([(of.first, of.second) for of in contacts]).reshape(-1, 2)
        self.gaps = np.array([of.gap for of in contacts])
        self.springs = _Springs([of.law for of in contacts])

    def modes(self, x: FloatArray) -> list[FloatArray]:
        """Return the modal coordinates of each body, shape (n,)."""
        ends = np.searchsorted(self.owner, np.arange(len(self._bodies)))
        return [
            x[end : end + len(body.omega)] for end, body in zip(ends, self._bodies, strict=True)
        ]

    @cached_property
    def first(self) -> _Configuration:
        """Static deflection without contacts; coordinates without stiffness are 0."""
        still = np.zeros(len(self.load))
        return self.at(np.divide(self.load, self.stiffness, out=still, where=self.sprung))

    @cached_property
    def slopes(self) -> FloatArray:
        """Reference stiffness of each contact, N/m, which scales the damping of steps.

        The stiffness is taken under the sum of all loads or, if larger, under the largest force of
        the initial overlap.
        """
        overlap = float(self.first.force.max(initial=0.0))
        return self.springs.stiffness_under(max(float(np.abs(self.load).sum()), overlap))

    def at(self, x: FloatArray) -> _Configuration:
        """Return the configuration of the bodies with coordinates x."""
        depth = self.directions @ x - self.gaps
        force, slope = self.springs.force(depth)
        own = self.stiffness * x
        balance = np.where(self.movable, self.load - own - self.directions.T @ force, 0.0)
        present = np.abs(self.load) + np.abs(own) + self.reach.T @ force
        return _Configuration(x, balance, present, depth, force, slope, self.rounding(x, slope))

    def rounding(self, x: FloatArray, slopes: FloatArray) -> FloatArray:
        """Return the errors of the contact forces due to rounding errors of x, N."""
        reach = self.reach @ np.abs(x) + np.abs(self.gaps)
        return np.asarray(slopes * _EPSILON * reach)

    def settled(self, at: _Configuration) -> bool:
        """True if the reactions balance the loads to the rounding errors of the largest force.

        Imbalances are compared with the largest force, as a contact that only touches has no force.
        """
        largest = max(self.size(at), self.size(self.first))
        holds = np.minimum(at.present - np.abs(self.load), _EPSILON * largest)
        rounding = ROUNDING * at.present + self.reach.T @ at.rounding
        return bool((np.abs(at.balance) <= holds + rounding).all())

    def size(self, at: _Configuration) -> float:
        """Largest load or contact force, N."""
        return float(max(np.abs(self.load).max(initial=0.0), at.force.max(initial=0.0)))

    def check(self, at: _Configuration, slopes: FloatArray, size: float) -> None:
        """Raise if a law's limit is exceeded, or rounding errors are large for forces of `size`."""
        limits, rounding = self.springs.limits, self.rounding(at.x, slopes)
        for i in np.flatnonzero(at.depth > limits)[:1]:
            raise LawLimitError(
                f"preload: contact {i} is {at.depth[i]:.3g} m deep at rest, and its law is valid "
                f"to {limits[i]:.3g} m; take a larger patch, a longer table, or less load"
            )
        if rounding.max(initial=0.0) > _DETERMINED * size:
            i = int(rounding.argmax())
            raise InputError(
                f"preload: contact {i} is so stiff, {slopes[i]:.3g} N/m, that its force has a "
                f"rounding error of {rounding[i]:.2g} N; take a softer law, or smaller gaps"
            )

    @cached_property
    def _constant(self) -> tuple[sp.csr_array, sp.csr_array, sp.csr_array, FloatArray]:
        """Matrices of all steps: D for coordinates with and without stiffness, D K⁻¹ Dᵀ, ground.

        The last is the stiffness of springs to the ground at coordinates without stiffness, N/m.
        """
        own, free = self.directions[:, self.sprung], self.directions[:, self.free]
        between = own @ sp.diags_array(1.0 / self.stiffness[self.sprung]) @ own.T
        ground = (free**2).T @ self.slopes
        return own, free, between, ROUNDING * np.where(ground > 0.0, ground, 1.0)

    def step(self, at: _Configuration, damping: float) -> FloatArray:
        """Return a Newton step s, damped by raised stiffnesses of contacts and bodies.

        With the contact stiffnesses S, K s + Dᵀ S D s = balance is solved for the forces S D s and
        the coordinates without stiffness; the other coordinates follow one by one. The cost depends
        on the number of contacts, and a soft spring loses no digits next to a stiff one.
        """
        own, free, between, ground = self._constant
        contacts = sp.diags_array(1.0 / (at.slope + damping * self.slopes))
        rows = [[between / (1.0 + damping) + contacts, -free], [free.T, sp.diags_array(ground)]]
        matrix = sp.block_array(rows, format="csc")
        compliance = 1.0 / ((1.0 + damping) * self.stiffness[self.sprung])
        pushed = compliance * at.balance[self.sprung]
        right = np.concatenate([own @ pushed, at.balance[self.free]])
        force, rigid = np.split(sp.linalg.splu(matrix).solve(right), [len(self.gaps)])
        step = np.zeros(len(at.x))
        step[self.sprung], step[self.free] = pushed - compliance * (own.T @ force), rigid
        return step

    def descend(self) -> _Configuration:
        """Return the configuration of least energy, or the last one if there is no minimum."""
        # Once forces balance to rounding errors, each of two further steps squares the error.
        at, damping, more = self.first, 1.0, 2
        for _ in range(_MOST_STEPS):
            if (more := more - self.settled(at)) < 0:
                break
            step, share = self.step(at, damping), 1.0
            work, trial = at.balance @ step, self.at(at.x + step)
            # The step is too long if the work of the forces at its end opposes half of that at its
            # start; the secant method shortens it.
            while (end := trial.balance @ step) < -0.5 * work and share > _EPSILON:
                share *= max(0.1, float(work / (work - end)))
                trial = self.at(at.x + share * step)
            # A step with the least damping is longer than any gap. If it does not change the
            # imbalance, only the springs to the ground hold a body.
            changed = np.linalg.norm(trial.balance - at.balance)
            still = changed <= 1e-3 * np.linalg.norm(at.balance)
            if share == 1.0 and damping == ROUNDING and still:
                break
            at = trial
            if share == 1.0:
                damping = max(_TIGHTER * damping, ROUNDING)
        return at

    def floating(self, at: _Configuration) -> Iterator[tuple[IntArray, FloatArray]]:
        """Yield the bodies that no force keeps in place, and the displacements that return them.

        Yields
        ------
        where, way : ndarrays, shape (m,)
            Indices of the coordinates of an unloaded body, or group of bodies that press on each
            other, and the displacement that returns its centre of mass to the initial position.
        """
        count = len(self._bodies)
        pairs = self.pairs[at.force > at.rounding + ROUNDING * self.size(at)]
        graph = sp.coo_array((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(count,) * 2)
        groups, group = sp.csgraph.connected_components(graph, directed=False)
        sizes, places = np.bincount(group), np.flatnonzero(self.free)
        held = np.array([body.ports > 1 for body in self._bodies]) & (sizes[group] > 1)
        held |= np.bincount(self.owner[places], minlength=count) == 0
        kept = np.bincount(group, held) > 0.0
        owner = group[self.owner[places]]
        for number in range(groups):
            where = places[owner == number]
            load, x = self.load[where], at.x[where]
            if kept[number] or abs(load.sum()) > ROUNDING * np.abs(load).sum():
                continue
            mean = np.average(x, weights=self.inertia[where])
            yield where, -x if sizes[number] == 1 else np.full(len(x), -mean)

    def least_moved(self, at: _Configuration) -> _Configuration:
        """Return the equilibrium after moving unloaded bodies back towards their initial places.

        The bodies move as far as other bodies leave room. Moving back undoes a side effect of the
        iterations' damping, which also moves bodies at open contacts.
        """
        room, columns = np.maximum(-at.depth, 0.0), self.directions.tocsc()
        x = np.where(self.sprung & (self.reach.T @ at.force == 0.0), self.first.x, at.x)
        floating = list(self.floating(at))
        # There are two passes, in both orders: in a row of bodies each body makes room for the
        # next.
        for where, way in (*floating, *reversed(floating)):
            closing = columns[:, where] @ way
            nearer = closing > 0.0
            share = (room[nearer] / closing[nearer]).min(initial=1.0)
            x[where] += share * way
            room -= share * closing
            way *= 1.0 - share
        moved = self.at(x)
        return moved if self.settled(moved) else at


def equilibrium(
    bodies: Sequence[Body],
    contacts: Sequence[Contact],
    *,
    gravity: float,
    forces: Sequence[FloatArray],
) -> Equilibrium:
    """Return the static equilibrium of bodies in contact.

    Parameters
    ----------
    bodies : sequence of Body
    contacts : sequence of Contact
    gravity : float
        Acceleration of gravity, m/s².
    forces : sequence of ndarrays, shape (p,)
        Loads on the ports of each body at t = 0, N.

    Raises
    ------
    ConvergenceError
        If there is no static equilibrium: some body is free to move under its loads.
    InputError
        If the forces at rest are not determined.
    LawLimitError
        If a contact is deeper than its law is valid for.
    """
    statics = _Statics(bodies, contacts, gravity, forces)
    first = statics.first
    for i in np.flatnonzero(~(statics.slopes <= LARGEST))[:1]:
        raise InputError(
            f"preload: contact {i} has a stiffness of {statics.slopes[i]:.3g} N/m under the loads, "
            "out of range; give its law in N and m, or start without preload"
        )
    at = statics.descend()
    if statics.settled(at):
        at = statics.least_moved(at)
        least = PRINTED * statics.size(first)
        statics.check(at, at.slope, max(statics.size(at), least))
        return Equilibrium(statics.modes(at.x), at.force)
    statics.check(at, np.zeros(len(at.slope)), 0.0)
    statics.check(first, statics.slopes, statics.size(first))
    present = np.where(at.present > 0.0, at.present, 1.0)
    worst = int((np.abs(at.balance) / present).argmax())
    raise ConvergenceError(
        f"preload: nothing supports body {statics.owner[worst]} against "
        f"{abs(at.balance[worst]):.3g} N; support it, or start without preload"
    )
