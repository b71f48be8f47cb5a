"""Meshes of surface and line elements with edges half as long."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..base import IntArray, sp
from .mesh import Mesh

# The corners of the parts of an element, each the mean of four of its own corners.
_PARTS = {
    "line": [[(0, 0, 0, 0), (0, 0, 1, 1)], [(0, 0, 1, 1), (1, 1, 1, 1)]],
    "triangle": [
        [(0, 0, 0, 0), (0, 0, 1, 1), (0, 0, 2, 2)],
        [(1, 1, 1, 1), (1, 1, 2, 2), (0, 0, 1, 1)],
        [(2, 2, 2, 2), (0, 0, 2, 2), (1, 1, 2, 2)],
        [(0, 0, 1, 1), (1, 1, 2, 2), (0, 0, 2, 2)],
    ],
    "quad": [
        [(k, k, k, k), (k, k, k - 3, k - 3), (0, 1, 2, 3), (k, k, k - 1, k - 1)] for k in range(4)
    ],
}


def halved(mesh: Mesh) -> tuple[sp.csr_array, Mesh, IntArray]:
    """Cut surface elements in four and line elements in two, parts one after another.

    Returns
    -------
    mean : scipy.sparse.csr_array, shape (new nodes, nodes)
        The new nodes as means of the old ones, which come first.
    mesh : Mesh
    parent : ndarray of int, shape (new elements,)
        The element that each is a part of.
    """
    corners = [np.sort(of.cells[:, _PARTS[of.kind]], axis=3) for of in mesh.blocks]
    own = np.repeat(np.arange(mesh.n_nodes)[:, None], 4, axis=1)
    members, number = np.unique(
        np.concatenate([own, *(each.reshape(-1, 4) for each in corners)]),
        axis=0,
        return_inverse=True,
    )
    old = (members[:, :1] == members).all(axis=1)
    order = np.argsort(~old, kind="stable")
    members, number = members[order], np.argsort(order)[number.ravel()[mesh.n_nodes :]]
    entries = np.full(members.size, 0.25), (np.arange(members.size) // 4, members.ravel())
    mean = sp.csr_array(entries, shape=(len(members), mesh.n_nodes))
    parts = np.split(number, np.cumsum([each.size // 4 for each in corners])[:-1])
    cells: Any = [
        (of.kind, part.reshape(-1, of.cells.shape[1]))
        for of, part in zip(mesh.blocks, parts, strict=True)
    ]
    parent = [
        np.repeat(np.arange(of.numbers.start, of.numbers.stop), len(_PARTS[of.kind]))
        for of in mesh.blocks
    ]
    of = np.concatenate(parent)
    groups = {name: np.flatnonzero(np.isin(of, own)) for name, own in mesh.cell_sets.items()}
    return mean, Mesh(mean @ mesh.nodes, cells, cell_sets=groups), of
