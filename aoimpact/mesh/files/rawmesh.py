"""A mesh as a file has it, before it is put in order, and what readers of several formats share."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from ...base import FloatArray, IntArray
from ..elements import KINDS, reference_element

__all__ = ["LINES", "SOLIDS", "SURFACES", "UPRIGHT_FIRST", "RawBlock", "RawMesh", "rows_of"]

# Kinds of cells by their numbers of nodes.
SOLIDS = {len(reference_element(kind).nodes): kind for kind in KINDS}
SURFACES = {3: "triangle", 4: "quad", 6: "triangle6", 8: "quad8", 9: "quad9"}
LINES = {2: "line", 3: "line3"}

# Orders of nodes that number the midside nodes of upright edges before those of the top, in VTK's.
UPRIGHT_FIRST = {
    "hexahedron20": (*range(12), *range(16, 20), *range(12, 16)),
    "wedge15": (*range(9), *range(12, 15), *range(9, 12)),
}


def rows_of(known: IntArray, wanted: IntArray) -> IntArray:
    """Return the rows of labels among those that are known, of the same shape; -1 for others."""
    if not len(known):
        return np.full(wanted.shape, -1)
    order = np.argsort(known, kind="stable")
    rows = order[np.searchsorted(known, wanted, sorter=order).clip(max=len(known) - 1)]
    found: IntArray = np.where(known[rows] == wanted, rows, -1)
    return found


@dataclass(frozen=True, eq=False)
class RawBlock:
    """Cells of one kind, of any dimension, in the order of the file.

    Attributes
    ----------
    kind : str
        meshio's name, such as "tetra10", "quad8" or "line"; node order is meshio's (VTK's).
    cells : ndarray of int, shape (n, nodes per cell)
        Row numbers of `RawMesh.nodes`.
    labels : ndarray of int, shape (n,), or None
        Numbers that the file gives to the elements; None for formats without numbers.
    """

    kind: str
    cells: IntArray
    labels: IntArray | None = None

    @property
    def dim(self) -> int:
        """Dimension of the cells: 0 for points to 3 for solids."""
        shape = self.kind.rstrip("0123456789")
        return {"vertex": 0, "line": 1, "triangle": 2, "quad": 2, "polygon": 2}.get(shape, 3)


@dataclass(frozen=True, eq=False)
class RawMesh:
    """Nodes, cells and named groups of a file.

    Attributes
    ----------
    nodes : ndarray, shape (n_nodes, 3)
        Coordinates in the file's unit of length and in global axes.
    blocks : tuple of RawBlock
    node_sets : mapping of str to ndarray of int
        Row numbers of `nodes`.
    cell_sets : mapping of str to ndarray of int
        Cell numbers, counted through all blocks from 0, of any dimension.
    node_labels : ndarray of int, shape (n_nodes,), or None
        Numbers that the file gives to the nodes; None for formats without numbers. A number may
        occur twice, as in two instances of an Abaqus part.
    left_out : mapping of str to str
        Groups that hold more than solids, and what, as in "3 MASS, 20 S4R": of solids alone they
        would be incomplete.
    """

    nodes: FloatArray
    blocks: tuple[RawBlock, ...]
    node_sets: Mapping[str, IntArray] = field(default_factory=dict)
    cell_sets: Mapping[str, IntArray] = field(default_factory=dict)
    node_labels: IntArray | None = None
    left_out: Mapping[str, str] = field(default_factory=dict)

    @property
    def first(self) -> IntArray:
        """Number of the first cell of each block, shape (n_blocks + 1,); the last is the count."""
        counts = [len(block.cells) for block in self.blocks]
        return np.concatenate([[0], np.cumsum(counts, dtype=np.int64)])

    @property
    def cell_labels(self) -> IntArray | None:
        """Numbers that the file gives to the cells, through all blocks; None if one has none."""
        labels = [block.labels for block in self.blocks if block.labels is not None]
        return np.concatenate(labels) if 0 < len(labels) == len(self.blocks) else None
