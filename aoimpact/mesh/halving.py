"""Meshes of surface and line elements with edges half as long."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..base import IntArray, sp
from .mesh import Mesh
from .vectors import parted

# The corners of the parts of an element, each the mean of four of its own corners.
_PARTS = {
    kind: [[np.resize([*map(int, at)], 4) for at in part.split()] for part in parts.split(",")]
    for kind, parts in {
        "line": "0 01, 01 1",
        "triangle": "0 01 02, 1 12 01, 2 02 12, 01 12 02",
        "quad": "0 01 0123 03, 1 12 0123 01, 2 23 0123 12, 3 03 0123 23",
    }.items()
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
    every = np.concatenate([own, *(each.reshape(-1, 4) for each in corners)])
    members, number = np.unique(every, axis=0, return_inverse=True)
    order = np.argsort((members[:, :1] != members).any(axis=1), kind="stable")
    members = members[order]
    number = np.argsort(order)[number.ravel()[mesh.n_nodes :]]
    entries = np.full(members.size, 0.25), (np.arange(members.size) // 4, members.ravel())
    mean = sp.csr_array(entries, shape=(len(members), mesh.n_nodes))
    parts = zip(mesh.blocks, parted(number, [each[..., 0] for each in corners]), strict=True)
    cells: Any = [(of.kind, part.reshape(-1, of.cells.shape[1])) for of, part in parts]
    parents = [np.repeat(np.r_[of.numbers], len(_PARTS[of.kind])) for of in mesh.blocks]
    parent = np.concatenate(parents)
    groups = {name: np.flatnonzero(np.isin(parent, own)) for name, own in mesh.cell_sets.items()}
    return mean, Mesh(mean @ mesh.nodes, cells, cell_sets=groups), parent
