"""Symmetric matrices of small blocks, as the core takes them: in parts, which threads share out."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
import numpy.typing as npt

from .. import _core
from ..base import FloatArray, IntArray, at_once

Part = tuple[int, int]

# AOI_BLOCKS_WORK of csrc/multigrid/multigrid.h; the core refuses work space of any other length.
_WORK = 3

# Minimum dofs of a part, and maximum number of parts. Each cut stores a layer of elements
# twice: four parts of a plate of 268 000 dofs store 2 % more, those of a cube 5 %. To hand a part
# over takes 20 µs, a product of so many dofs 1 to 2 ms.
_LEAST, _MOST_PARTS = 30_000, 4


@dataclass(frozen=True, eq=False)
class Stored:
    """Some rows of a symmetric matrix as `Blocks` stores them, in its order.

    Attributes
    ----------
    starts : ndarray of int, shape (n_rows + 1,)
    columns : ndarray of int
    values : ndarray, shape (len(columns), b, b)
    """

    starts: IntArray
    columns: npt.NDArray[np.int32]
    values: FloatArray

    @classmethod
    def of(cls, A: Any, part: IntArray, first: int = 0) -> Stored:
        """Return that of a BSR matrix's rows from `first` on; with a part for each of all rows."""
        row = np.repeat(np.arange(first, first + len(A.indptr) - 1), np.diff(A.indptr))
        inside = part[row] == part[A.indices]
        kept = np.flatnonzero(~inside | (A.indices >= row))
        row, inside = row[kept], inside[kept]
        if not inside.all():  # those of other parts come first
            kept = kept[np.lexsort((inside, row))]
        starts = np.searchsorted(row, np.arange(first, first + len(A.indptr)))
        return cls(starts, A.indices[kept].astype(np.int32, copy=False), A.data[kept])


class Blocks:
    """A symmetric matrix; of most of it one triangle is stored, so that it is read once.

    Whoever uses it gives the core work space of its own: one product at a time.

    Parameters
    ----------
    pieces : list of Stored
        Of all rows, in order. It is emptied, so that no more than one is held twice.
    part : ndarray of int, shape (n,)
        Which part each row of blocks belongs to, from 0 on.

    Attributes
    ----------
    pattern : object
        What the core knows of it.
    values : ndarray
        The entries of its blocks.
    parts : list of tuple
        Where each part begins and ends in the order.
    work_length : int
        How many numbers the core wants as work space.
    """

    def __init__(self, pieces: list[Stored], part: IntArray) -> None:
        size = pieces[0].values.shape[1]
        count = np.concatenate([np.diff(piece.starts) for piece in pieces])
        order = np.argsort(part, kind="stable").astype(np.int32)
        starts = np.zeros(len(part) + 1, dtype=np.int32)
        np.cumsum(count[order], out=starts[1:])
        place = np.empty(len(part), dtype=np.int64)
        place[order] = starts[:-1]
        columns, values = np.empty(starts[-1], dtype=np.int32), np.empty((starts[-1], size, size))
        first = 0
        while pieces:
            some = pieces.pop(0)
            rows = slice(first, first := first + len(some.starts) - 1)
            where = np.repeat(place[rows] - some.starts[:-1], count[rows])
            where += np.arange(len(where))
            columns[where], values[where] = some.columns, some.values
        self.pattern = _core.blocks_pattern(order, starts, columns, size)
        self.values: FloatArray = values.reshape(-1)
        ends = np.cumsum(np.bincount(part))
        self.parts: list[Part] = list(zip([0, *ends[:-1].tolist()], ends.tolist(), strict=True))
        self.work_length = _WORK * len(part) * (size + 1)

    @classmethod
    def of(cls, A: Any, part: IntArray | None = None) -> Blocks:
        """Return a BSR matrix that stores every diagonal block; in one part if left out."""
        part = np.zeros(len(A.indptr) - 1, dtype=np.int64) if part is None else part
        return cls([Stored.of(A, part)], part)

    def multiply(self, x: FloatArray, work: FloatArray) -> FloatArray:
        """Return A x."""
        matrix, product = (self.pattern, self.values), np.empty_like(x)
        in_stages(2, self.parts, _core.blocks_multiply, matrix, x, product, work)
        return product


def in_stages(
    count: int, parts: list[Part], function: Callable[..., None], matrix: Any, *rest: Any
) -> None:
    """Call the core for each part: none begins a stage before all have ended the last one."""
    for stage in range(count):
        if len(parts) == 1:
            function(matrix, parts[0], stage, *rest)
        else:
            at_once([partial(function, matrix, part, stage, *rest) for part in parts])


def slabs(places: FloatArray, size: int) -> npt.NDArray[np.int64]:
    """Return a part for each node: slabs across the longest side of a body of many dofs.

    Parameters
    ----------
    places : ndarray, shape (n, 3)
        Coordinates.
    size : int
        Dofs of a node.
    """
    count = max(1, min(_MOST_PARTS, size * len(places) // _LEAST))
    along = places[:, np.ptp(places, axis=0).argmax()]
    cuts = np.quantile(along, np.arange(1, count) / count)
    return np.unique(np.searchsorted(cuts, along), return_inverse=True)[1]


def diagonal_blocks(A: Any, first: int = 0) -> FloatArray:
    """Return the diagonal blocks of a BSR matrix that stores them all, shape (n, b, b)."""
    found: FloatArray = A.data[diagonal_places(A, first)]
    return found


def diagonal_places(A: Any, first: int = 0) -> IntArray:
    """Return which blocks of a BSR matrix's rows from `first` on lie on its diagonal, by rows."""
    row = np.repeat(np.arange(len(A.indptr) - 1), np.diff(A.indptr))
    return np.flatnonzero(A.indices == row + first)
