"""Meshes, bodies and static solutions of shells and beams."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt
import scipy.linalg
import scipy.sparse.linalg as sla

import aoimpact as ao

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]
KINDS = {2: "line", 3: "triangle", 4: "quad"}


def grid(
    n: int, m: int, place: Callable[[FloatArray, FloatArray], Any], kind: str = "quad"
) -> tuple[FloatArray, IntArray, FloatArray, FloatArray]:
    """Nodes, elements and nodal (r, s) of n × m cells of the unit square, mapped by `place`."""
    r, s = np.meshgrid(np.linspace(0.0, 1.0, n + 1), np.linspace(0.0, 1.0, m + 1), indexing="ij")
    r, s = r.ravel(), s.ravel()
    nodes = np.stack(np.broadcast_arrays(*place(r, s)), axis=1).astype(np.float64)
    i = np.arange(len(r)).reshape(n + 1, m + 1)
    cells = np.stack([i[:-1, :-1], i[1:, :-1], i[1:, 1:], i[:-1, 1:]], axis=-1).reshape(-1, 4)
    if kind == "triangle":
        cells = np.vstack([cells[:, :3], cells[:, [0, 2, 3]]])
    return nodes, cells, r, s


def line(length: float = 1.0, n: int = 10) -> ao.Mesh:
    """A line of elements along x, with node sets "xmin" and "xmax"."""
    nodes = np.column_stack([np.linspace(0, length, n + 1), np.zeros((n + 1, 2))])
    cells = np.column_stack([np.arange(n), np.arange(1, n + 1)])
    return ao.Mesh(nodes, cells, "line", {"xmin": np.array([0]), "xmax": np.array([n])})


def bar(
    section: Any, material: ao.Material, length: float = 1.0, n: int = 20, **given: Any
) -> ao.FEModel:
    """A beam along x with the z axis of its section along z."""
    return ao.FEModel.from_mesh(line(length, n), ao.Beam(section, material, (0, 0, 1)), **given)


def matrices(nodes: FloatArray, *parts: tuple[IntArray, Any]) -> tuple[Any, Any]:
    """K and M of a body over 6 dofs per node; parts are pairs of elements and their material."""
    cells, groups, first = {}, {}, 0
    for width in (4, 3, 2):
        for i, (own, _) in enumerate(parts):
            if own.shape[1] == width:
                cells.setdefault(KINDS[width], []).append(own)
                groups[f"part {i}"] = np.arange(first, first + len(own))
                first += len(own)
    blocks: Any = [(kind, np.concatenate(own)) for kind, own in cells.items()]
    mesh = ao.Mesh(nodes, blocks, "mixed", cell_sets=groups)
    body = ao.FEModel.from_mesh(mesh, {f"part {i}": part for i, (_, part) in enumerate(parts)})
    each = np.arange(3 * len(nodes)).reshape(-1, 3)
    order = np.hstack([each, each + 3 * len(nodes)]).ravel()
    return body.K[order][:, order], body.M[order][:, order]


def dofs(nodes: Any, components: Sequence[int] | range) -> IntArray:
    """Dofs of nodes, given by mask or index; components 0-2: displacements, 3-5: rotations."""
    numbers = np.asarray(nodes)
    numbers = np.flatnonzero(numbers) if numbers.dtype == bool else np.atleast_1d(numbers)
    return (6 * numbers[:, None] + np.array(list(components))).ravel()


def solved(K: Any, force: FloatArray, *fixed: IntArray) -> FloatArray:
    """Solve for static displacements and rotations, shape (n_nodes, 6)."""
    free = np.setdiff1d(np.arange(len(force)), np.concatenate(fixed))
    x = np.zeros(len(force))
    x[free] = sla.spsolve(K[free][:, free].tocsc(), force[free])
    return x.reshape(-1, 6)


def frequencies(K: Any, M: Any, n: int, *fixed: IntArray) -> FloatArray:
    """The n lowest natural frequencies, Hz."""
    free = np.setdiff1d(np.arange(K.shape[0]), np.concatenate(fixed) if fixed else [])
    K, M = K[free][:, free].tocsc(), M[free][:, free].tocsc()
    shift = 1e-4 * float(abs(K).max()) / float(abs(M).max())
    solve = sla.splu(K + shift * M)
    inverse = sla.LinearOperator(K.shape, matvec=solve.solve, dtype=np.float64)
    start = np.random.default_rng(0).normal(size=K.shape[0])
    found = sla.eigsh(K, n, M, sigma=-shift, OPinv=inverse, v0=start, return_eigenvectors=False)
    return np.sqrt(np.maximum(np.sort(found), 0.0)) / (2.0 * np.pi)


def pressed(nodes: FloatArray, cells: IntArray, layers: Any, force: Any) -> FloatArray:
    """Nodal forces, shape (6 n_nodes,), of a uniform force per area (3,), N/m²."""
    body = ao.FEModel.from_mesh(ao.Mesh(nodes, cells, KINDS[cells.shape[1]]), layers)
    area = (body.M @ body.translation((0, 0, 1)))[2 : 3 * len(nodes) : 3] / layers.inertia[0]
    loads = np.zeros((len(nodes), 6))
    loads[:, :3] = area[:, None] * np.array(force)
    return loads.ravel()


def rigid_motions(nodes: FloatArray) -> FloatArray:
    """Unit translations along and rotations about x, y and z, shape (6 n_nodes, 6)."""
    motions = np.zeros((len(nodes), 6, 6))
    for i, axis in enumerate(np.eye(3)):
        motions[:, :3, i] = axis
        motions[:, :3, 3 + i] = np.cross(axis, nodes)
        motions[:, 3:, 3 + i] = axis
    return motions.reshape(-1, 6)


def turned() -> FloatArray:
    """A rotation matrix about an oblique axis, (3, 3)."""
    return np.asarray(scipy.linalg.expm(np.cross(np.eye(3), [0.4, -0.7, 1.1])))
