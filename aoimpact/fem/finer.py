"""The finer body: a body with a refined mesh, for estimating the discretisation error.

Solid elements get additional shape functions of the next degree (hierarchical refinement). The
finer body's dofs are those of the original body, followed by the amplitudes of the added functions,
which vanish at the original nodes. So zeros appended to a motion of the original body give the same
motion of the finer body, and the original K and M are leading blocks of the finer K and M.

Shell elements are cut into four and beam elements into two, as they have no next degree.
"""

from __future__ import annotations

from functools import cached_property
from operator import attrgetter
from typing import Any

import numpy as np

from ..base import ROUNDING, FloatArray, IntArray, sp
from ..linalg import FEW_SOLUTIONS, LinearSolver, Solver, two_level
from ..mesh import Surface, enriched, halved
from .composition import taken_material
from .mechanism import Mechanism
from .model import FEModel, summed


class _Finer(FEModel):
    """A body refined from the body `given`; K and M are assembled at their first use."""

    mean: Any  # matrix from values at the nodes of `given` to values per shape function

    def __reduce__(self) -> Any:
        """Pickle only the body `given`, from which the refined body can be made again."""
        return attrgetter("finer"), (self.given,)

    def carried(self, values: FloatArray) -> FloatArray:
        columns = values.reshape(len(values), -1)
        return np.asarray((self.mean @ columns).reshape(-1, *values.shape[1:]))

    @cached_property
    def node_labels(self) -> IntArray | None:
        return self.given.node_labels


class FinerBody(_Finer):
    """A body with additional shape functions, which its `mesh` does not contain."""

    def _matrices(self) -> dict[str, Any]:
        found, body = super()._matrices(), self.given
        if not body.assembled:
            found |= {"K": _with(found["K"], body.K), "M": _with(found["M"], body.M)}
        return found

    @cached_property
    def rigid_modes(self) -> FloatArray:
        return self.appended(self.given.rigid_modes)

    @cached_property
    def surface(self) -> Surface | None:
        return self.given.surface

    @cached_property
    def mechanism(self) -> Mechanism | None:
        return None

    def inverse(
        self, s2: float = 0.0, *, solver: Solver = "auto", solutions: int = FEW_SOLUTIONS
    ) -> LinearSolver:
        if (found := self._living.get((s2, solver))) is None:
            # One solution takes the time of about 8 solutions of `given`: 5 to 20 iterations, each
            # for several loads together.
            coarse = self.given.inverse(s2, solver=solver, solutions=8 * solutions)
            found = self._living[s2, solver] = two_level(self._pencil.at(s2), coarse)
        return found

    appended = _Finer.functional

    def alike(self, *motions: FloatArray) -> tuple[FloatArray, Any]:
        n = self.n_dofs
        return np.hstack([x if len(x) == n else self.appended(x) for x in motions]), self.K


class HalvedBody(_Finer):
    """A body of shells and beams with each element cut into smaller ones; new nodes come last."""

    def alike(self, *motions: FloatArray) -> tuple[FloatArray, Any]:
        n = self.n_dofs
        return np.hstack([self.restricted(x) if len(x) == n else x for x in motions]), self.given.K


def finer_body(body: FEModel) -> FEModel | None:
    """Return the body with a refined mesh; None if no element can be refined."""
    if body.mesh is None or body.material is None or body.free is None:
        return None
    if all(block.element.thin for block in body.mesh.blocks):
        return _halved(body) if body.assembled else None
    found = None if isinstance(body, FinerBody) else enriched(body.mesh)
    if found is None:
        return None
    shapes, members, shared = found
    n = body.mesh.n_nodes
    added = len(members)
    moves = np.zeros(3 * n, dtype=bool)
    moves[body.free[body.free < 3 * n]] = True
    # Supports constrain an added function if they hold all nodes of its edge or face.
    loose = moves.reshape(-1, 3)[members].any(axis=1) & ~shared[:, None]
    free = np.concatenate([_placed(body.free, n, added), 3 * n + np.flatnonzero(loose)])
    mean = sp.eye_array(shapes.n_nodes, n, format="csr")
    made = {"shapes": shapes, "own": slice(body.n_dofs), "mean": mean}
    return _made_of(body, FinerBody, shapes.nodes, free, body.mesh, body.material, made)


def _halved(body: Any) -> FEModel:
    """Return the body of shells and beams with each element cut into smaller ones.

    Added masses and springs stay on their nodes. A new node between constrained nodes is
    constrained too.
    """
    mesh = body.mesh
    free = body.free
    mean, cut, parent = halved(mesh)
    n = mesh.n_nodes
    added = cut.n_nodes - mesh.n_nodes
    holds = np.ones(6 * n)
    holds[free] = 0.0
    held = np.stack([mean @ of for of in holds.reshape(2, n, 3)])
    loose = np.flatnonzero(held.ravel() < 1.0 - ROUNDING)
    own = np.searchsorted(loose, _placed(free, n, added))
    made = {"parent": parent, "own": own, "mean": mean}
    material = taken_material(body.material, parent)
    return _made_of(body, HalvedBody, cut.nodes, loose, cut, material, made)


def _made_of(
    body: FEModel, kind: Any, nodes: FloatArray, free: Any, mesh: Any, material: Any, made: Any
) -> FEModel:
    finer: FEModel = object.__new__(kind)
    finer._set(nodes=nodes, free=free, mesh=mesh, material=material, coarse=body, mass=body.mass)
    finer._set(damping=body.damping, name=body.name, assembled=body.assembled)
    vars(finer).update(made)
    if body.masses is not None:
        finer._set(masses=_masses(body.masses, body.mesh, len(nodes)))
    if body.springs is not None:
        finer._set(springs=finer.functional(body.springs))
    return finer


def _placed(dofs: Any, n: int, added: int) -> Any:
    """Renumber dofs for `added` nodes after the first n: rotations follow all displacements."""
    return dofs + np.where(dofs < 3 * n, 0, 3 * added)


def _masses(masses: Any, mesh: Any, n_nodes: int) -> Any:
    """Return a body's matrix of added masses, enlarged to all dofs of its finer body."""
    of = masses.tocoo()
    size = n_nodes * (6 if mesh.thin else 3)
    at = tuple(_placed(index, mesh.n_nodes, n_nodes - mesh.n_nodes) for index in of.coords)
    return sp.csr_array((of.data, at), shape=(size, size))


def _with(matrix: Any, block: Any) -> Any:
    """Return a matrix with its leading block replaced by `block`."""
    n = block.shape[0]
    change = (block - matrix[:n, :n]).tocsr()
    change.resize(matrix.shape)
    return summed(matrix, change)
