"""Uniform refinement of meshes of surface and line elements: edges are halved."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..base import ROUNDING, IntArray, sp
from .elements import reference_element
from .mesh import Mesh
from .vectors import parted

# For each kind of linear element: the second-order kind on the same corners, and the parts into
# which an element is cut, by the second-order element's node numbers.
PARTS: dict[str, tuple[str, Any]] = {
    "line": ("line3", [(0, 2), (2, 1)]),
    "triangle": ("triangle6", [(0, 3, 5), (1, 4, 3), (2, 5, 4), (3, 4, 5)]),
    "quad": ("quad9", [(0, 4, 8, 7), (1, 5, 8, 4), (2, 6, 8, 5), (3, 7, 8, 6)]),
}


def halved(mesh: Mesh) -> tuple[sp.csr_array, Mesh, IntArray]:
    """Return the mesh with each surface element cut in four and each line element in two.

    The parts of an element follow each other.

    Returns
    -------
    mean : scipy.sparse.csr_array, shape (new nodes, nodes)
        Interpolation matrix: each new node is a mean of old nodes. The old nodes come first.
    mesh : Mesh
        The refined mesh.
    parent : ndarray of int, shape (new elements,)
        Number of the old element that each new element is a part of.
    """
    corners = []
    for block in mesh.blocks:
        raised = reference_element(PARTS[block.kind][0])
        shares = raised.linear.shape(raised.nodes) > ROUNDING
        between = [np.resize(np.flatnonzero(own), 4) for own in shares]
        corners.append(np.sort(block.cells[:, between], axis=2))
    every = np.concatenate([each.reshape(-1, 4) for each in corners])
    members, number = np.unique(every, axis=0, return_inverse=True)
    order = np.argsort((members[:, :1] != members).any(axis=1), kind="stable")
    members = members[order]
    number = np.argsort(order)[number.ravel()]
    entries = np.full(members.size, 0.25), (np.arange(members.size) // 4, members.ravel())
    mean = sp.csr_array(entries, shape=(len(members), mesh.n_nodes))
    nodes = parted(number, [each[..., 0] for each in corners])
    cells: Any = [
        (block.kind, own[:, PARTS[block.kind][1]].reshape(-1, block.cells.shape[1]))
        for block, own in zip(mesh.blocks, nodes, strict=True)
    ]
    parents = [np.repeat(np.r_[of.numbers], len(PARTS[of.kind][1])) for of in mesh.blocks]
    parent = np.concatenate(parents)
    groups = {name: np.flatnonzero(np.isin(parent, own)) for name, own in mesh.cell_sets.items()}
    return mean, Mesh(mean @ mesh.nodes, cells, cell_sets=groups), parent
