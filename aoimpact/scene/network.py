"""The bodies of a scene and their contacts as one network of springs, in one set of coordinates.

The coordinates are the bodies' modes, and massless ones for the displacement of a massless contact
that no mode has. With contacts of stiffness S in directions D, K x + Dᵀ S D x = b is solved for the
contact forces and for the unsprung modes, those without stiffness. The others follow one by one. So
the cost grows with the number of contacts, and a soft spring beside a stiff one keeps its digits.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt
import scipy.sparse as sp

from ..base import FloatArray, IntArray
from ..reduction import ModalBody
from .contact import Port

BoolArray = npt.NDArray[np.bool_]

# Ground springs on what may move freely: on one body of a group that nothing constrains, as stiff
# as its contacts; of bodies touched in several places, whose rigid motions the others may
# constrain or not, by so much less that they do not show.
_PINNED, _BARELY = 1.0, 1e-12


@dataclass(frozen=True, eq=False)
class ContactNetwork:
    """Bodies, and which of them are in contact.

    Attributes
    ----------
    bodies : sequence of ModalBody
    ends : sequence of (Port, Port)
        Two ends of each contact; the indentation is the first's coordinate minus the second's.
    """

    bodies: Sequence[ModalBody]
    ends: Sequence[tuple[Port, Port]]

    @cached_property
    def first(self) -> tuple[int, ...]:
        """Number of the first mode of each body, and the number of all."""
        return tuple(itertools.accumulate((body.n for body in self.bodies), initial=0))

    @cached_property
    def _massless(self) -> list[tuple[int, FloatArray, FloatArray]]:
        """Number, residual stiffnesses and shapes (p, n) of each body with a massless contact."""
        found = []
        for number, body in enumerate(self.bodies):
            if body.residual is not None:
                compliance, shape = np.linalg.eigh(body.residual)
                soft = compliance > 0.0
                found.append((number, 1.0 / compliance[soft], shape[:, soft]))
        return found

    @cached_property
    def owner(self) -> IntArray:
        """The body of each coordinate, shape (n,)."""
        modes = [np.full(body.n, number) for number, body in enumerate(self.bodies)]
        more = [np.full(len(stiffness), number) for number, stiffness, _ in self._massless]
        return np.concatenate([*modes, *more])

    @cached_property
    def stiffness(self) -> FloatArray:
        """Stiffnesses of the coordinates, shape (n,)."""
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
        """For each body, pairs of coordinates, shape (n,), and their shapes (p, n)."""
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
        """Shape (contacts, n): the indentation of a contact is its row times x minus its gap."""
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
        """The directions without sign: bounds of indentations, shape (contacts, n)."""
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

    # ------------------------------------------------------------------- constraints

    @cached_property
    def unsprung(self) -> BoolArray:
        """Which coordinates have no stiffness of their own, shape (n,)."""
        found: BoolArray = self.movable & (self.stiffness == 0.0)
        return found

    @cached_property
    def _floating(self) -> list[IntArray]:
        """Unsprung coordinates of each unconstrained group of bodies in contact."""
        return self._unconstrained(np.ones(len(self.ends), dtype=bool))

    def _unconstrained(self, joined: BoolArray) -> list[IntArray]:
        """Unsprung coordinates of each unconstrained group of bodies that these contacts join."""
        count = len(self.bodies)
        pairs = self._pairs[joined]
        graph = sp.coo_array((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(count,) * 2)
        groups, group = sp.csgraph.connected_components(graph, directed=False)
        constrained = np.zeros(groups, dtype=bool)
        for number, body in enumerate(self.bodies):
            constrained[group[number]] |= body.ports > 1 or not self._unsprung_of(number).any()
        unsprung = np.flatnonzero(self.unsprung)
        whose = group[self.owner[unsprung]]
        order = np.argsort(whose, kind="stable")
        starts = np.searchsorted(whose[order], np.arange(groups + 1))
        return [
            unsprung[order[slice(*ends)]]
            for of, ends in enumerate(itertools.pairwise(starts))
            if not constrained[of]
        ]

    def floating(self, pressed: BoolArray, x: FloatArray) -> list[tuple[IntArray, FloatArray]]:
        """Return what no force keeps in its place, and the displacement back to where it was put.

        Parameters
        ----------
        pressed : ndarray, shape (contacts,)
            Which contacts carry a force.
        x : ndarray, shape (n,)
            The coordinates.

        Returns
        -------
        list of (where, displacement)
            The unsprung coordinates of each unconstrained group, and the displacement of each, m.
        """
        inertia = np.concatenate([body.inertia for body in self.bodies])
        groups = self._unconstrained(pressed)
        found = [(of, np.full(len(of), -np.average(x[of], weights=inertia[of]))) for of in groups]
        touched = set(self._pairs[pressed].ravel().tolist())
        for number, body in enumerate(self.bodies):
            if body.ports > 1 and number not in touched:
                where = self.first[number] + np.flatnonzero(self._unsprung_of(number))
                found.append((where, -x[where]))
        return found

    @cached_property
    def _pairs(self) -> IntArray:
        """The bodies of the contacts, shape (contacts, 2)."""
        return np.array([(a, b) for (a, _), (b, _) in self.ends], dtype=np.intp).reshape(-1, 2)

    def _unsprung_of(self, body: int) -> BoolArray:
        ours: BoolArray = self.unsprung[self.first[body] : self.first[body + 1]]
        return ours

    @cached_property
    def ground(self) -> FloatArray:
        """Springs that constrain what nothing else does, relative to the contacts', shape (n,)."""
        found = np.zeros(len(self.stiffness))
        for number, body in enumerate(self.bodies):
            if body.ports > 1:
                where = slice(self.first[number], self.first[number + 1])
                found[where] = np.where(self._unsprung_of(number), _BARELY, 0.0)
        found[[group[0] for group in self._floating]] = _PINNED
        return found

    def centred(self, x: FloatArray) -> FloatArray:
        """Return x with the centre of mass of each unconstrained group where it was."""
        inertia, found = np.concatenate([body.inertia for body in self.bodies]), x.copy()
        for group in self._floating:
            found[group] -= np.average(x[group], weights=inertia[group])
        return found

    # ------------------------------------------------------------------- displacements under forces

    def linearized(self, contacts: FloatArray, springs: float = 1.0) -> LinearNetwork | None:
        """Return the network with contacts as springs of such stiffnesses, N/m, shape (contacts,).

        None if some are so soft beside others that the matrix is singular in double precision.

        Parameters
        ----------
        contacts : ndarray, shape (contacts,)
            N/m.
        springs : float, optional
            Factor on the stiffness of the bodies themselves.
        """
        try:
            return LinearNetwork(self, contacts, springs)
        except RuntimeError:  # how SuperLU reports a singular matrix
            return None

    @cached_property
    def coupling(self) -> _Coupling:
        """The parts of what `LinearNetwork` solves that do not change."""
        sprung = self.movable & ~self.unsprung
        own = self.directions[:, sprung]
        compliance = sp.coo_array(own @ sp.diags_array(1.0 / self.stiffness[sprung]) @ own.T)
        free = sp.coo_array(self.directions[:, self.unsprung])
        count, least = len(self.ends), np.arange(len(self.ends))
        ground = np.arange(count, count + free.shape[1])
        row, column = free.row, count + free.col
        rows = np.concatenate([compliance.row, least, row, column, ground])
        columns = np.concatenate([compliance.col, least, column, row, ground])
        # Entries in the order of columns; those at the same place are added up.
        order = np.lexsort((rows, columns))
        new = np.r_[True, np.diff(rows[order]) != 0] | np.r_[True, np.diff(columns[order]) != 0]
        starts = np.searchsorted(columns[order][new], np.arange(ground.size + count + 1))
        pattern = rows[order][new].astype(np.int32), starts.astype(np.int32)
        return _Coupling(sprung, own, compliance, free, order, np.flatnonzero(new), pattern)


@dataclass(frozen=True, eq=False)
class _Coupling:
    """Factors that stay the same while contacts stiffen.

    Attributes
    ----------
    sprung : ndarray, shape (n,)
        Which coordinates have stiffness.
    own, free : sparse arrays, shapes (contacts, sprung), (contacts, unsprung)
        The contacts' directions in these coordinates and in the others.
    compliance : sparse array, shape (contacts, contacts)
        Of the bodies between contacts, m/N.
    order, new : ndarrays
        Where all entries come to stand, sorted and added up by columns.
    pattern : (indices, starts)
        Of the sparse matrix that is solved.
    """

    sprung: BoolArray
    own: sp.csr_array
    compliance: sp.coo_array
    free: sp.coo_array
    order: IntArray
    new: IntArray
    pattern: tuple[npt.NDArray[np.int32], npt.NDArray[np.int32]]


class LinearNetwork:
    """A network with its contacts as springs; see `ContactNetwork.linearized`."""

    def __init__(self, network: ContactNetwork, contacts: FloatArray, springs: float) -> None:
        self._network, coupling = network, network.coupling
        root, compliance, free = np.sqrt(contacts), coupling.compliance, coupling.free
        self._compliance = 1.0 / (springs * network.stiffness[coupling.sprung])
        # Scaled by √S: symmetric, and of the size of one where bodies deform less than contacts.
        between = compliance.data * root[compliance.row] * root[compliance.col] / springs
        own = np.zeros(len(root))
        np.add.at(own, compliance.row, np.where(compliance.row == compliance.col, between, 0.0))
        self._root = root / np.sqrt(1.0 + own)
        between = between / np.sqrt((1.0 + own[compliance.row]) * (1.0 + own[compliance.col]))
        down = free.data * self._root[free.row]
        norm = np.sqrt(np.bincount(free.col, down**2, minlength=free.shape[1]))
        self._scale = 1.0 / np.where(norm > 0.0, norm, 1.0)
        down = down * self._scale[free.col]
        self._ground = network.ground[network.unsprung]
        entries = np.concatenate([between, 1.0 / (1.0 + own), -down, down, self._ground])
        data = np.add.reduceat(entries[coupling.order], coupling.new)
        size = len(root) + free.shape[1]
        self._lu = sp.linalg.splu(sp.csc_array((data, *coupling.pattern), shape=(size, size)))

    def displacement(self, force: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return displacements under forces, N, shape (n,), and what only ground springs carry."""
        network, coupling = self._network, self._network.coupling
        pushed = self._compliance * force[coupling.sprung]
        right = self._root * (coupling.own @ pushed), self._scale * force[network.unsprung]
        found = self._lu.solve(np.concatenate(right))
        between, rigid = np.split(found, [len(self._root)])
        x, residual = np.zeros(len(force)), np.zeros(len(force))
        x[network.unsprung] = self._scale * rigid
        x[coupling.sprung] = pushed - self._compliance * (coupling.own.T @ (self._root * between))
        residual[network.unsprung] = self._ground * rigid / self._scale
        return x, residual
