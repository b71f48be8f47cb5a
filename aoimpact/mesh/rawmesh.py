"""A mesh as a file has it, before it is put in order: what every reader returns."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from ..base import FloatArray, IntArray

__all__ = ["RawBlock", "RawMesh"]


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
