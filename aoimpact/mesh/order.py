"""Elements of second order from those of first order: a node in the middle of every edge."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..base import IntArray, MeshError
from .collapse import edges_of
from .elements import KINDS, reference_element
from .mesh import Mesh
from .surface import boundary

__all__ = ["of_second_order", "open_edges"]

# The kind of second order on the corners of each of first order: that with nodes on edges alone.
_RAISED = {
    reference_element(kind).cell.linear: kind
    for kind in KINDS
    if reference_element(kind).quadratic and kind != "hexahedron27"
}


def of_second_order(mesh: Mesh) -> Mesh:
    """Return the mesh with a node in the middle of each edge; one of second order as it is.

    Edges stay straight. The new nodes come after the others. With `Mesh.node_labels`, they have the
    numbers after the largest of these. A new node belongs to a set of nodes if both ends of its
    edge do; in a set of nodes on the surface, only edges on the surface count. The set of a group
    of elements is that of their nodes.

    Raises
    ------
    MeshError
        If it has elements of both orders.
    """
    linear = [not block.element.quadratic for block in mesh.blocks]
    if not any(linear):
        return mesh
    if not all(linear):
        raise MeshError(
            f"order: the mesh has elements of both orders, {mesh.contents}; give one of first order"
        )
    raised = [reference_element(_RAISED[block.kind]) for block in mesh.blocks]
    ends = [
        np.sort(block.cells[:, edges_of(element)], axis=2)
        for block, element in zip(mesh.blocks, raised, strict=True)
    ]
    edges, number = _unique(np.concatenate([part.reshape(-1, 2) for part in ends]), mesh.n_nodes)
    blocks: Any = []
    start = 0
    for block, element, part in zip(mesh.blocks, raised, ends, strict=True):
        middles = mesh.n_nodes + number[start : start + part.size // 2].reshape(part.shape[:2])
        blocks.append((element.kind, np.hstack([block.cells, middles])))
        start += part.size // 2
    labels = mesh.node_labels
    if labels is not None:
        labels = np.concatenate([labels, labels.max() + 1 + np.arange(len(edges))])
    return Mesh(
        np.concatenate([mesh.nodes, mesh.nodes[edges].mean(axis=1)]),
        blocks,
        "mixed",
        _node_sets(mesh, edges, [cells for _, cells in blocks]),
        mesh.cell_sets,
        labels,
        mesh.cell_labels,
    )


def open_edges(mesh: Mesh, ids: IntArray) -> int:
    """Return how many edges on the surface have both ends among some corners, but no middle.

    Parameters
    ----------
    mesh : Mesh
    ids : ndarray of int
        Nodes. If a midside node is one of them, they are no corners alone, and the result is 0.
    """
    chosen = np.zeros(mesh.n_nodes, dtype=bool)
    chosen[ids] = True
    middles = [np.zeros(0, dtype=np.int64)]
    for block in mesh.blocks:
        ends = edges_of(block.element)
        middle = block.cells[:, block.element.n_corners :][:, : len(ends)]
        if chosen[middle].any():
            return 0
        middles.append(middle[chosen[block.cells[:, ends]].all(axis=2)])
    found = np.unique(np.concatenate(middles))
    return int(np.isin(found, boundary(mesh).nodes).sum()) if len(found) else 0


def _unique(edges: IntArray, n_nodes: int) -> tuple[IntArray, IntArray]:
    """Return the different edges, shape (m, 2), and the number of each given one among them."""
    keys, number = np.unique(edges[:, 0] * n_nodes + edges[:, 1], return_inverse=True)
    return np.stack([keys // n_nodes, keys % n_nodes], axis=1), number.reshape(-1)


def _node_sets(mesh: Mesh, edges: IntArray, cells: list[IntArray]) -> dict[str, IntArray]:
    surface = boundary(mesh)
    outside = np.zeros(mesh.n_nodes, dtype=bool)
    outside[surface.nodes] = True
    around = surface.nodes[:, :4]  # a triangle repeats its first node
    skin = np.sort(np.stack([around, np.roll(around, -1, axis=1)], axis=2), axis=2).reshape(-1, 2)
    on_surface = np.isin(edges @ [mesh.n_nodes, 1], skin @ [mesh.n_nodes, 1])
    found = {}
    for name, ids in mesh.node_sets.items():
        chosen = np.zeros(mesh.n_nodes, dtype=bool)
        chosen[ids] = True
        between = chosen[edges].all(axis=1)
        if outside[ids].all():
            between &= on_surface
        found[name] = np.concatenate([ids, mesh.n_nodes + np.flatnonzero(between)])
    for name, members in mesh.cell_sets.items():
        own = [
            part[members[(members >= block.first) & (members < block.numbers.stop)] - block.first]
            for block, part in zip(mesh.blocks, cells, strict=True)
        ]
        nodes = np.unique(np.concatenate([part.reshape(-1) for part in own]))
        if np.array_equal(nodes[nodes < mesh.n_nodes], mesh.node_sets.get(name, [])):
            found[name] = nodes
    return found
