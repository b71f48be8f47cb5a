"""Bodies and fields that several tests need."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from aoimpact.generate import box_mesh
from aoimpact.mesh import Mesh

FloatArray = npt.NDArray[np.float64]


def distorted_box(kind: str, lengths: tuple[float, float, float] = (2.0, 1.5, 1.0)) -> Mesh:
    """A box of `kind` whose nodes, midside nodes too, are pushed about at random.

    Nodes on a face move within it, so the box keeps its shape while its elements lose theirs:
    those of second order become curved.
    """
    mesh = box_mesh(lengths, (2, 2, 2), kind=kind)
    rng = np.random.default_rng(7)
    spacing = np.array(lengths) / 2
    push = 0.09 * spacing * rng.uniform(-1.0, 1.0, mesh.nodes.shape)
    for axis, length in enumerate(lengths):
        on_face = (mesh.nodes[:, axis] == 0.0) | (np.abs(mesh.nodes[:, axis] - length) < 1e-12)
        push[on_face, axis] = 0.0
    return Mesh(mesh.nodes + push, mesh.cells, mesh.kind, mesh.node_sets)


def interior(mesh: Mesh) -> npt.NDArray[np.bool_]:
    """Which nodes lie on no face of a box."""
    inside = np.ones(mesh.n_nodes, dtype=bool)
    for members in mesh.node_sets.values():
        inside[members] = False
    return inside


def rigid_motions(nodes: FloatArray) -> FloatArray:
    """Translations along and small rotations about the axes through the origin, (3 n_nodes, 6)."""
    columns = [np.tile(axis, (len(nodes), 1)) for axis in np.eye(3)]
    columns += [np.cross(axis, nodes) for axis in np.eye(3)]
    return np.stack([column.reshape(-1) for column in columns], axis=1)
