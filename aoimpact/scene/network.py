"""Bodies that press on each other in one set of coordinates, and what a force on these moves.

The coordinates are the bodies' modes, and one without mass for what no mode of a massless contact
has. With contacts of stiffness S in directions D, K x + Dᵀ S D x = b is solved for the contacts'
forces and the loose modes, those without springs: the others follow one by one. So the cost grows
with the number of contacts, and a soft spring beside a stiff one keeps its digits.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt
import scipy.sparse as sp

from ..base import FloatArray
from ..reduction import ModalBody
from .contact import Port

__all__ = ["Bound", "ContactNetwork"]

BoolArray = npt.NDArray[np.bool_]
IntArray = npt.NDArray[np.intp]

# Ground springs on what may move freely: of one body of a group that nothing else holds, as stiff
# as its contacts; of bodies touched in several places, whose rigid motions the others may
# hold or not, by so much less that they do not show.
_PINNED, _BARELY = 1.0, 1e-12


@dataclass(frozen=True, eq=False)
class ContactNetwork:
    """Bodies, and which of them touch.

    Attributes
    ----------
    bodies : sequence of ModalBody
    ends : sequence of (Port, Port)
        Of each contact; the indentation is the first's coordinate minus the second's.
    """

    bodies: Sequence[ModalBody]
    ends: Sequence[tuple[Port, Port]]

    @cached_property
    def first(self) -> tuple[int, ...]:
        """Where each body's modes begin; and how many these are."""
        return tuple(itertools.accumulate((body.n for body in self.bodies), initial=0))

    @cached_property
    def _massless(self) -> list[tuple[int, FloatArray, FloatArray]]:
        """Of each body with a massless contact, its number, stiffnesses and shapes (p, n)."""
        found = []
        for number, body in enumerate(self.bodies):
            if body.residual is not None:
                compliance, shape = np.linalg.eigh(body.residual)
                yields = compliance > 0.0
                found.append((number, 1.0 / compliance[yields], shape[:, yields]))
        return found

    @cached_property
    def owner(self) -> IntArray:
        """The body of each coordinate, shape (n,)."""
        modes = [np.full(body.n, number) for number, body in enumerate(self.bodies)]
        more = [np.full(len(stiffness), number) for number, stiffness, _ in self._massless]
        return np.concatenate([*modes, *more])

    @cached_property
    def stiffness(self) -> FloatArray:
        """Of the coordinates, shape (n,)."""
        modes = [body.inertia * body.omega**2 for body in self.bodies]
        return np.concatenate([*modes, *(stiffness for _, stiffness, _ in self._massless)])

    @cached_property
    def movable(self) -> BoolArray:
        """Which coordinates are not a wall's, shape (n,)."""
        inertia = np.concatenate([body.inertia for body in self.bodies])
        more = len(self.stiffness) - len(inertia)
        return np.concatenate([inertia > 0.0, np.ones(more, dtype=bool)])

    @cached_property
    def _shapes(self) -> list[list[tuple[IntArray, FloatArray]]]:
        """Of each body, pairs of coordinates, shape (n,), and their shapes (p, n)."""
        found = [
            [(np.arange(first, last), body.shape)]
            for body, (first, last) in zip(self.bodies, itertools.pairwise(self.first), strict=True)
        ]
        last = self.first[-1]
        for number, stiffness, shape in self._massless:
            found[number].append((np.arange(last, last + len(stiffness)), shape))
            last += len(stiffness)
        return found

    @cached_property
    def directions(self) -> sp.csr_array:
        """Of the contacts, shape (contacts, n): its indentation is a row times x minus its gap."""
        rows, columns, values = [], [], []
        for contact, ends in enumerate(self.ends):
            for (body, port), sign in zip(ends, (1.0, -1.0), strict=True):
                for where, shape in self._shapes[body]:
                    rows.append(np.full(len(where), contact))
                    columns.append(where)
                    values.append(sign * shape[port])
        size = (len(self.ends), len(self.stiffness))
        if not rows:
            return sp.csr_array(size)
        entries = np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))
        return sp.csr_array(sp.coo_array(entries, shape=size))

    @cached_property
    def reach(self) -> sp.csr_array:
        """How much coordinates of any sign may move contacts, shape (contacts, n)."""
        return abs(self.directions)

    def modes(self, x: FloatArray) -> tuple[FloatArray, ...]:
        """Return the modes of each body, shape (n,), among the coordinates."""
        return tuple(x[first:end] for first, end in itertools.pairwise(self.first))

    def beside(self, x: FloatArray) -> tuple[FloatArray, ...]:
        """Return displacements of each body's ports, m, shape (p,), beside those of its modes."""
        found = [np.zeros(body.ports) for body in self.bodies]
        for number, _, shape in self._massless:
            found[number] += shape @ x[self._shapes[number][1][0]]
        return tuple(found)

    def load(self, gravity: float, forces: Sequence[FloatArray]) -> FloatArray:
        """Return the forces on the coordinates, shape (n,).

        Parameters
        ----------
        gravity : float
            m/s².
        forces : sequence of ndarrays, shape (p,)
            On the ports of each body, N.
        """
        weights = [gravity * body.weight * body.inertia for body in self.bodies]
        found = np.concatenate([*weights, np.zeros(len(self.stiffness) - self.first[-1])])
        for shapes, force in zip(self._shapes, forces, strict=True):
            for where, shape in shapes:
                found[where] += force @ shape
        return np.where(self.movable, found, 0.0)

    # ------------------------------------------------------------------- what holds the bodies

    @cached_property
    def loose(self) -> BoolArray:
        """Which coordinates have no spring of their own, shape (n,)."""
        found: BoolArray = self.movable & (self.stiffness == 0.0)
        return found

    @cached_property
    def _alone(self) -> list[IntArray]:
        """Of each group of bodies in contact that nothing else holds, the loose coordinates."""
        return self._unheld(np.ones(len(self.ends), dtype=bool))

    def _unheld(self, joined: BoolArray) -> list[IntArray]:
        """Of each group of bodies that these contacts join, and nothing holds, the loose ones."""
        count = len(self.bodies)
        pairs = self._pairs[joined]
        graph = sp.coo_array((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(count,) * 2)
        groups, group = sp.csgraph.connected_components(graph, directed=False)
        held = np.zeros(groups, dtype=bool)
        for number, body in enumerate(self.bodies):
            held[group[number]] |= body.ports > 1 or not self._loose_of(number).any()
        loose = np.flatnonzero(self.loose)
        whose = group[self.owner[loose]]
        order = np.argsort(whose, kind="stable")
        starts = np.searchsorted(whose[order], np.arange(groups + 1))
        return [
            loose[order[slice(*ends)]]
            for of, ends in enumerate(itertools.pairwise(starts))
            if not held[of]
        ]

    def adrift(self, pressed: BoolArray, x: FloatArray) -> list[tuple[IntArray, FloatArray]]:
        """Return what no force keeps in its place, and how it gets back to where it was put.

        Parameters
        ----------
        pressed : ndarray, shape (contacts,)
            Which contacts bear a force.
        x : ndarray, shape (n,)
            The coordinates.

        Returns
        -------
        list of (where, way)
            The loose coordinates of each group that nothing else holds, and the way of each, m.
        """
        inertia = np.concatenate([body.inertia for body in self.bodies])
        groups = self._unheld(pressed)
        found = [(of, np.full(len(of), -np.average(x[of], weights=inertia[of]))) for of in groups]
        touched = set(self._pairs[pressed].ravel().tolist())
        for number, body in enumerate(self.bodies):
            if body.ports > 1 and number not in touched:
                where = self.first[number] + np.flatnonzero(self._loose_of(number))
                found.append((where, -x[where]))
        return found

    @cached_property
    def _pairs(self) -> IntArray:
        """The bodies of the contacts, shape (contacts, 2)."""
        return np.array([(a, b) for (a, _), (b, _) in self.ends], dtype=np.intp).reshape(-1, 2)

    def _loose_of(self, body: int) -> BoolArray:
        ours: BoolArray = self.loose[self.first[body] : self.first[body + 1]]
        return ours

    @cached_property
    def ground(self) -> FloatArray:
        """Springs that make up for what nothing holds, relative to the contacts', shape (n,)."""
        found = np.zeros(len(self.stiffness))
        for number, body in enumerate(self.bodies):
            if body.ports > 1:
                where = slice(self.first[number], self.first[number + 1])
                found[where] = np.where(self._loose_of(number), _BARELY, 0.0)
        found[[group[0] for group in self._alone]] = _PINNED
        return found

    def centred(self, x: FloatArray) -> FloatArray:
        """Return x with the centre of mass of what nothing holds where it was."""
        inertia, found = np.concatenate([body.inertia for body in self.bodies]), x.copy()
        for group in self._alone:
            found[group] -= np.average(x[group], weights=inertia[group])
        return found

    # ------------------------------------------------------------------- what forces move

    def bound(self, contacts: FloatArray, springs: float = 1.0) -> Bound | None:
        """Return the network with contacts as springs of such stiffnesses, N/m, shape (contacts,).

        None if some are so soft beside others that they hold nothing in floating-point numbers.

        Parameters
        ----------
        contacts : ndarray, shape (contacts,)
            N/m.
        springs : float, optional
            How many times as stiff the bodies' own springs are taken.
        """
        try:
            return Bound(self, contacts, springs)
        except RuntimeError:  # SuperLU's word for a singular matrix
            return None

    @cached_property
    def across(self) -> _Across:
        """The parts of what `Bound` solves that do not change."""
        sprung = self.movable & ~self.loose
        own = self.directions[:, sprung]
        give = sp.coo_array(own @ sp.diags_array(1.0 / self.stiffness[sprung]) @ own.T)
        free = sp.coo_array(self.directions[:, self.loose])
        count, least = len(self.ends), np.arange(len(self.ends))
        ground = np.arange(count, count + free.shape[1])
        row, column = free.row, count + free.col
        rows = np.concatenate([give.row, least, row, column, ground])
        columns = np.concatenate([give.col, least, column, row, ground])
        # Entries in the order of columns; those at the same place are added up.
        order = np.lexsort((rows, columns))
        new = np.r_[True, np.diff(rows[order]) != 0] | np.r_[True, np.diff(columns[order]) != 0]
        starts = np.searchsorted(columns[order][new], np.arange(ground.size + count + 1))
        pattern = rows[order][new].astype(np.int32), starts.astype(np.int32)
        return _Across(sprung, own, give, free, order, np.flatnonzero(new), pattern)


@dataclass(frozen=True, eq=False)
class _Across:
    """What does not change while contacts stiffen: which coordinates have springs, the contacts'
    directions in these, what these give way between contacts, m/N, and the directions in loose
    coordinates; where all entries come to stand, sorted and added up by columns."""

    sprung: BoolArray
    own: sp.csr_array
    give: sp.coo_array
    free: sp.coo_array
    order: IntArray
    new: IntArray
    pattern: tuple[npt.NDArray[np.int32], npt.NDArray[np.int32]]


class Bound:
    """A network whose contacts are springs; see `ContactNetwork.bound`."""

    def __init__(self, network: ContactNetwork, contacts: FloatArray, springs: float) -> None:
        self._network, across = network, network.across
        root, give, free = np.sqrt(contacts), across.give, across.free
        self._compliance = 1.0 / (springs * network.stiffness[across.sprung])
        # In √S: symmetric, and of the size of one where bodies give way less than contacts.
        between = give.data * root[give.row] * root[give.col] / springs
        own = np.zeros(len(root))
        np.add.at(own, give.row, np.where(give.row == give.col, between, 0.0))
        self._root = root / np.sqrt(1.0 + own)
        between = between / np.sqrt((1.0 + own[give.row]) * (1.0 + own[give.col]))
        down = free.data * self._root[free.row]
        norm = np.sqrt(np.bincount(free.col, down**2, minlength=free.shape[1]))
        self._scale = 1.0 / np.where(norm > 0.0, norm, 1.0)
        down = down * self._scale[free.col]
        self._ground = network.ground[network.loose]
        entries = np.concatenate([between, 1.0 / (1.0 + own), -down, down, self._ground])
        data = np.add.reduceat(entries[across.order], across.new)
        size = len(root) + free.shape[1]
        self._lu = sp.linalg.splu(sp.csc_array((data, *across.pattern), shape=(size, size)))

    def moved(self, force: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return where forces, N, shape (n,), move the coordinates; what only the ground bears."""
        network, across = self._network, self._network.across
        pushed = self._compliance * force[across.sprung]
        right = self._root * (across.own @ pushed), self._scale * force[network.loose]
        found = self._lu.solve(np.concatenate(right))
        between, rigid = np.split(found, [len(self._root)])
        x, unheld = np.zeros(len(force)), np.zeros(len(force))
        x[network.loose] = self._scale * rigid
        x[across.sprung] = pushed - self._compliance * (across.own.T @ (self._root * between))
        unheld[network.loose] = self._ground * rigid / self._scale
        return x, unheld
