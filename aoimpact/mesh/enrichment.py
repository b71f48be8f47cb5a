"""Meshes whose elements have the functions of the next degree as well."""

from __future__ import annotations

import numpy as np

from ..base import ROUNDING, BoolArray, IntArray
from .elements import ReferenceElement, enriched_element, reference_faces
from .mesh import Block, Mesh


def enriched(mesh: Mesh) -> tuple[Mesh, IntArray, BoolArray] | None:
    """Return a mesh whose elements have the functions of the next degree after their own.

    A function of an edge or side is a node after those of the mesh. Its place is the origin, so
    that it has no part in the shape of its elements.

    Returns
    -------
    mesh : Mesh
        Not checked, since the added nodes are no places.
    members : ndarray of int, shape (n_added, width)
        The nodes of the mesh on the edge or side of each function; short rows repeat the first.
    shared : ndarray of bool, shape (n_added,)
        Whether an element has that edge or side, too, that is not enriched. The function must be
        left out there, so that displacements are continuous.
    None
        Where no element is enriched.
    """
    keys, members, others = [], [], [np.zeros((0, 3), dtype=np.int64)]
    for block in mesh.blocks:
        found, own = enriched_element(block.kind), block.element
        if found is None:
            others += [_keys(block.cells, list(corners)) for corners in _edges_and_triangles(own)]
            continue
        for corners in found[1]:
            keys.append(_keys(block.cells, list(corners)))
            elsewhere = np.delete(own.linear.shape(own.nodes), corners, axis=1)
            on = np.flatnonzero(np.abs(elsewhere).max(axis=1) < ROUNDING)
            members.append(block.cells[:, np.resize(on, 4)])
    if not keys:
        return None
    every, first, number = np.unique(
        np.concatenate(keys), axis=0, return_index=True, return_inverse=True
    )
    number, start, blocks = number.ravel(), 0, []
    for block in mesh.blocks:
        found = enriched_element(block.kind)
        if found is None:
            blocks.append(block)
            continue
        cells, n = [block.cells], len(block.cells)
        signs = np.ones((n, found[0].n_nodes))
        for function, corners in enumerate(found[1], block.cells.shape[1]):
            cells.append(mesh.n_nodes + number[start : start + n, None])
            start += n
            if len(corners) == 2 and block.element.quadratic:
                ends = block.cells[:, corners]
                signs[:, function] = np.where(ends[:, 0] < ends[:, 1], 1.0, -1.0)
        blocks.append(Block(found[0].kind, np.hstack(cells), block.first, signs))
    made = object.__new__(Mesh)
    for name, value in vars(mesh).items():
        object.__setattr__(made, name, value)
    nodes = np.vstack([mesh.nodes, np.zeros((len(every), 3))])
    object.__setattr__(made, "nodes", nodes)
    object.__setattr__(made, "blocks", tuple(blocks))
    both = np.concatenate([every, np.concatenate(others)])
    _, place = np.unique(both, axis=0, return_inverse=True)
    shared = np.isin(place.ravel()[: len(every)], place.ravel()[len(every) :])
    return made, np.concatenate(members)[first], shared


def _keys(cells: IntArray, corners: list[int]) -> IntArray:
    """The sorted corners of an edge or side of each element, (n, 3); -1 is the third of an edge."""
    found = np.full((len(cells), 3), -1)
    found[:, : len(corners)] = np.sort(cells[:, corners], axis=1)
    return found


def _edges_and_triangles(element: ReferenceElement) -> set[tuple[int, ...]]:
    """The corners of each edge and each triangle of an element."""
    if element.kind == "line":
        return {(0, 1)}
    sides = [of.nodes[: of.n_corners].tolist() for of in reference_faces(element.kind)]
    edges = {(one, other) for of in sides for one, other in zip(of, [*of[1:], of[0]], strict=True)}
    return edges | {tuple(of) for of in sides if len(of) == 3}
