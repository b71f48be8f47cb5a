"""Enrichment of a mesh: shape functions of the next degree are added to its elements."""

from __future__ import annotations

from copy import copy
from typing import Any

import numpy as np

from ..base import ROUNDING, BoolArray, IntArray
from .elements import enriched_element, reference_faces
from .mesh import Block, Mesh


def enriched(mesh: Mesh) -> tuple[Mesh, IntArray, BoolArray] | None:
    """Return the mesh with the functions of `enriched_element` added to its elements.

    Each added function has a node, numbered after the nodes of the given mesh. Its coordinates are
    zero, since the function does not change the shape of the elements.

    Returns
    -------
    mesh : Mesh
        The enriched mesh, not checked, as its added nodes are no points of the body. Its `cells`
        are those of the given mesh, without the added nodes.
    members : ndarray of int, shape (n_added, 4)
        Nodes of the given mesh on the edge or side of each added function; fewer than four are
        repeated.
    shared : ndarray of bool, shape (n_added,)
        True if the edge or side also belongs to an element that cannot be enriched. The added
        function is then set to zero, so that displacements are continuous.
    None
        If no element can be enriched.
    """
    keys = []
    members = []
    others = []
    for block in mesh.blocks:
        found = enriched_element(block.kind)
        own = block.element
        if found is None:
            faces = [of.nodes[: of.n_corners] for of in reference_faces(own.kind)]
            for side in faces or [np.arange(2)]:  # a line has no faces
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
    """Return the sorted corners of an edge or side of each element, (n, 3), filled up with -1."""
    found = np.full((len(cells), 3), -1)
    found[:, : len(corners)] = np.sort(cells[:, corners], axis=1)
    return found
