"""The finer body: of solids with the functions of the next degree beside the elements' own.

Its dofs are those of the body, followed by the amplitudes of the added functions, which are zero at
the body's nodes. So a motion of the body is one of the finer body with zeros appended, and the
body's K and M are blocks of the finer one's.

Shells and beams, whose elements have no next degree, are cut instead: in four and in two.
"""

from __future__ import annotations

from functools import cached_property
from typing import Any

import numpy as np

from ..base import ROUNDING, FloatArray, IntArray, sp
from ..linalg import FEW_SOLUTIONS, LinearSolver, Solver, two_level
from ..mesh import Surface, enriched, halved
from .assembly import stiffness_mass, with_int32
from .composition import taken_material
from .mechanism import Mechanism
from .model import FEModel


class _Finer(FEModel):
    """A body that is made of another, with K and M when they are first needed."""

    def __reduce__(self) -> Any:
        """Pickle by the other body."""
        return _finer_of, (self.given,)

    def alike(self, *motions: FloatArray) -> tuple[FloatArray, Any]:
        n = self.n_dofs
        return np.hstack([x if len(x) == n else self.appended(x) for x in motions]), self.K

    @cached_property
    def node_labels(self) -> IntArray | None:
        return self.given.node_labels

    @cached_property
    def _momentum(self) -> FloatArray | None:
        shapes, known = self.shapes, self.given._momentum
        if known is None:
            return None
        moved, n_places = np.zeros((6 * shapes.n_nodes, 3)), shapes.cells.max() + 1
        moved[: 3 * n_places] = np.tile(np.eye(3), (n_places, 1))
        ground, _, M = self.held
        if self.masses is not None:
            M = M + self.masses[:, ground]
        found = self.M @ moved[self.free] + (M @ moved[ground])[self.free]
        if not self.assembled:
            found[: len(known)] = known
        return np.asarray(found)


class FinerBody(_Finer):
    """A body whose elements have more functions than `mesh`, which has its places."""

    @cached_property
    def _made(self) -> tuple[Any, Any, tuple[IntArray, Any, Any]]:
        """K and M, and `held`."""
        body, free, material = self.given, self.free, self.material
        assert free is not None
        assert material is not None
        K, M = stiffness_mass(self.shapes, material)
        ground = np.setdiff1d(np.flatnonzero(np.diff(K.indptr)), free)
        held = ground, K[:, ground], M[:, ground]
        K, M = (with_int32(of[free][:, free]) for of in (K, M))
        if not body.assembled or body.masses is not None or body.springs is not None:
            K, M = (_with(of, known) for of, known in ((K, body.K), (M, body.M)))
        return K, M, held

    def _matrices(self) -> tuple[Any, Any]:
        return self._made[:2]

    @cached_property
    def held(self) -> tuple[IntArray, Any, Any]:
        return self._made[2]

    @cached_property
    def rigid_modes(self) -> FloatArray:
        return self.appended(self.given.rigid_modes)

    @cached_property
    def surface(self) -> Surface | None:
        return self.given.surface

    @cached_property
    def mechanism(self) -> Mechanism | None:
        return None

    def translation(self, direction: Any) -> FloatArray:
        return self.appended(self.given.translation(direction))

    def inverse(
        self, s2: float = 0.0, *, solver: Solver = "auto", solutions: int = FEW_SOLUTIONS
    ) -> LinearSolver:
        if (found := self._living.get((s2, solver))) is None:
            coarse = self.given.inverse(s2, solver=solver, solutions=8 * solutions)
            found = self._living[s2, solver] = two_level(self._pencil.at(s2), coarse)
        return found

    def appended(self, x: FloatArray) -> FloatArray:
        return np.pad(x, [(0, self.n_dofs - len(x)), *[(0, 0)] * (x.ndim - 1)])

    def carried(self, values: FloatArray) -> FloatArray:
        added = self.shapes.n_nodes - len(values)
        return np.pad(values, [(0, added), *[(0, 0)] * (values.ndim - 1)])

    def restricted(self, x: FloatArray) -> FloatArray:
        return x[: self.given.n_dofs]

    def functional(self, b: FloatArray) -> FloatArray:
        return self.appended(b)


class HalvedBody(_Finer):
    """A body of shells and beams of which each element is cut; the nodes that it had come first."""

    mean: Any  # the new nodes as means of the old ones

    def carried(self, values: FloatArray) -> FloatArray:
        columns = values.reshape(len(values), -1)
        return np.asarray((self.mean @ columns).reshape(-1, *values.shape[1:]))

    @cached_property
    def _own(self) -> IntArray:
        """The dofs of the nodes that the other body has."""
        given: Any = self.given.free
        free: Any = self.free
        n = self.given.shapes.n_nodes
        return np.asarray(np.searchsorted(free, _placed(given, n, self.shapes.n_nodes - n)))

    def restricted(self, x: FloatArray) -> FloatArray:
        return np.asarray(x[self._own])

    def functional(self, b: FloatArray) -> FloatArray:
        found = np.zeros(self.n_dofs)
        found[self._own] = b
        return found

    def appended(self, x: FloatArray) -> FloatArray:
        """Return motions of the other body, (n, ...), as those of this one.

        An edge is bent as a beam with the rotations of its ends, and a beam's middle turns with it.
        """
        mean, shapes, free = sp.csr_array(self.mean), self.shapes, self.free
        at_nodes = self.given.at_nodes(x.reshape(len(x), -1).T).transpose(1, 2, 3, 0)
        moved, turned = map(self.carried, at_nodes)
        mean.sum_duplicates()
        edges = np.flatnonzero(np.diff(mean.indptr) == 2)
        first, last = mean[edges].indices.reshape(-1, 2).T
        bent, along = np.zeros(moved.shape), (shapes.nodes[last] - shapes.nodes[first])[..., None]
        bent[edges] = np.cross(turned[first] - turned[last], along, axis=1) / 8.0
        for block in shapes.blocks:
            if block.kind == "quad":  # each part has half of two edges, and the middle
                _, before, middle, after = block.cells.T
                np.add.at(bent, middle, 0.25 * (bent[before] + bent[after]))
            elif block.kind == "line":
                (first, middle), last = block.cells[::2].T, block.cells[1::2, 1]
                along = (shapes.nodes[last] - shapes.nodes[first])[..., None]
                length = np.linalg.norm(along, axis=1, keepdims=True)
                chord = np.cross(along, moved[last] - moved[first], axis=1) / length**2
                own, axis = turned[middle], along / length
                across = own - axis * (axis * own).sum(axis=1, keepdims=True)
                turned[middle] = own + 1.5 * (chord - across)
        every = np.concatenate([moved + bent, turned]).reshape(-1, at_nodes.shape[-1])[free]
        return every.reshape(-1, *x.shape[1:])


def finer_body(body: FEModel) -> FEModel | None:
    """Return the finer body; None of one without elements that can be made finer."""
    if body.mesh is None or body.material is None or body.free is None:
        return None
    if all(block.element.thin for block in body.mesh.blocks):
        return _halved(body) if body.assembled else None
    found = enriched(body.mesh)
    if found is None:
        return None
    shapes, members, shared = found
    n, added = body.mesh.n_nodes, len(members)
    moves = np.zeros(3 * n, dtype=bool)
    moves[body.free[body.free < 3 * n]] = True
    # A support holds a function where it holds all nodes of its edge or side.
    loose = moves.reshape(-1, 3)[members].any(axis=1) & ~shared[:, None]
    free = np.concatenate([_placed(body.free, n, added), 3 * n + np.flatnonzero(loose)])
    finer = object.__new__(FinerBody)
    finer._set(nodes=shapes.nodes, free=free, mass=body.mass, mesh=body.mesh, coarse=body)
    finer._set(material=body.material, damping=body.damping, name=body.name)
    finer._set(assembled=body.assembled, masses=_masses(body, added))
    vars(finer).update(shapes=shapes)
    if body.springs is not None:
        finer._set(springs=finer.appended(body.springs))
    return finer


def _halved(body: FEModel) -> FEModel:
    """The body cut finer.

    What is mounted on nodes stays there, and a support holds the nodes between those that it holds.
    """
    mesh, material, free = body.mesh, body.material, body.free
    assert mesh is not None
    assert material is not None
    assert free is not None
    mean, cut, parent = halved(mesh)
    n, added = mesh.n_nodes, cut.n_nodes - mesh.n_nodes
    holds = np.ones(6 * n)
    holds[free] = 0.0
    held = np.stack([mean @ of for of in holds.reshape(2, n, 3)])
    loose = np.flatnonzero(held.ravel() < 1.0 - ROUNDING)
    finer = object.__new__(HalvedBody)
    finer._set(nodes=cut.nodes, free=loose, mesh=cut, material=taken_material(material, parent))
    finer._set(mass=body.mass, damping=body.damping, name=body.name, coarse=body)
    finer._set(assembled=True, masses=_masses(body, added), mean=mean)
    vars(finer).update(parent=parent)
    if body.springs is not None:
        springs = np.zeros(6 * cut.n_nodes)
        springs[_placed(free, n, added)] = body.springs
        finer._set(springs=springs[loose])
    return finer


def _placed(dofs: Any, n: int, added: int) -> Any:
    """Dofs of a body of n nodes among those with more nodes, after which the rotations come."""
    return dofs + np.where(dofs < 3 * n, 0, 3 * added)


def _masses(body: FEModel, added: int) -> Any:
    """The added masses over all dofs of a body with more nodes."""
    if body.masses is None:
        return None
    mesh: Any = body.mesh
    of, n = body.masses.tocoo(), mesh.n_nodes
    size = (n + added) * (6 if mesh.thin else 3)
    at = tuple(_placed(index, n, added) for index in of.coords)
    return sp.csr_array((of.data, at), shape=(size, size))


def _finer_of(body: FEModel) -> Any:
    return body.finer


def _with(matrix: Any, block: Any) -> Any:
    """The matrix with another first block."""
    n, entries = block.shape[0], sp.coo_array(matrix)
    row, column = entries.coords
    kept = (row >= n) | (column >= n)
    entries = sp.coo_array((entries.data[kept], (row[kept], column[kept])), shape=matrix.shape)
    block = sp.coo_array(block)
    first = sp.coo_array((block.data, block.coords), shape=matrix.shape)
    return with_int32((entries + first).tocsr().sorted_indices())
