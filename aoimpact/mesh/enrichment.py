"""Meshes whose elements have the functions of the next degree as well."""

from __future__ import annotations

from copy import copy
from typing import Any

import numpy as np

from ..base import ROUNDING, BoolArray, IntArray
from .elements import enriched_element, reference_faces
from .mesh import Block, Mesh


def enriched(mesh: Mesh) -> tuple[Mesh, IntArray, BoolArray] | None:
    """Return a mesh whose elements have the functions of the next degree after their own.

    A function of an edge or side is a node after those of the mesh. Its place is the origin, so
    that it has no part in the shape of its elements.

    Returns
    -------
    mesh : Mesh
        Not checked, since the added nodes are no places. Its `cells` are still those of the given
        mesh: the nodes that are places.
    members : ndarray of int, shape (n_added, width)
        The nodes of the mesh on the edge or side of each function; short rows repeat the first.
    shared : ndarray of bool, shape (n_added,)
        Whether an element has that edge or side, too, that is not enriched. The function is zero
        then, so that displacements are continuous.
    None
        Where no element is enriched.
    """
    keys = []
    members = []
    others = []
    for block in mesh.blocks:
        found = enriched_element(block.kind)
        own = block.element
        if found is None:
            faces = [of.nodes[: of.n_corners] for of in reference_faces(own.kind)]
            for side in faces or [np.arange(2)]:  # a line has none
                edges = np.stack([side, np.roll(side, 1)], axis=1)
                corners_of = [*edges, side] if len(side) == 3 else edges
                others += [_keys(block.cells, corners) for corners in corners_of]
            continue
        for corners in found[1]:
            keys.append(_keys(block.cells, corners))
            elsewhere = np.delete(own.linear.shape(own.nodes), corners, axis=1)
            on = np.flatnonzero(np.abs(elsewhere).max(axis=1) < ROUNDING)
            members.append(block.cells[:, np.resize(on, 4)])
    if not keys:
        return None
    count = sum(map(len, keys))
    _, first, place = np.unique(
        np.concatenate(keys + others), axis=0, return_index=True, return_inverse=True
    )
    used, number = np.unique(place.ravel()[:count], return_inverse=True)
    shared = np.isin(used, place.ravel()[count:])
    numbers = iter(np.split(number, np.cumsum([*map(len, keys)])))
    blocks = []
    for block in mesh.blocks:
        found = enriched_element(block.kind)
        if found is None:
            blocks.append(block)
            continue
        cells = [block.cells]
        signs = np.ones((len(block.cells), found[0].n_nodes))
        for function, corners in enumerate(found[1], block.cells.shape[1]):
            added = next(numbers)
            cells.append(mesh.n_nodes + added[:, None])
            if len(corners) == 2 and block.element.quadratic:
                ends = block.cells[:, corners]
                signs[:, function] = np.sign(ends[:, 1] - ends[:, 0])
            signs[shared[added], function] = 0.0
        blocks.append(Block(found[0].kind, np.hstack(cells), block.first, signs))
    made = copy(mesh)
    nodes = np.vstack([mesh.nodes, np.zeros((len(used), 3))])
    vars(made).update(nodes=nodes, blocks=tuple(blocks))
    return made, np.concatenate(members)[first[used]], shared


def _keys(cells: IntArray, corners: Any) -> IntArray:
    """The sorted corners of an edge or side of each element, (n, 3); -1 is the third of an edge."""
    found = np.full((len(cells), 3), -1)
    found[:, : len(corners)] = np.sort(cells[:, corners], axis=1)
    return found
