"""Symmetric matrices of small blocks, as the core takes them: in parts, which threads share out."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from .. import _core
from ..base import FloatArray, IntArray, at_once

Part = tuple[int, int]

# AOI_BLOCKS_WORK of csrc/multigrid/multigrid.h; the core refuses work space of any other length.
_WORK = 3

# Minimum dofs of a part, and maximum number of parts. Each cut stores a layer of elements
# twice: four parts of a plate of 268 000 dofs store 2 % more, those of a cube 5 %. To hand a part
# over takes 20 µs, a product of so many dofs 1 to 2 ms.
_LEAST, _MOST_PARTS = 30_000, 4


class Blocks:
    """A symmetric matrix; of most of it one triangle is stored, so that it is read once.

    Whoever uses it gives the core work space of its own: one product at a time.

    Parameters
    ----------
    A : scipy.sparse.bsr_array
        In order, with every block of its diagonal.
    places : ndarray, shape (n, 3), optional
        Coordinates of the rows of blocks: those of a large body are cut into slabs across its
        longest side, which are the parts.

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

    def __init__(self, A: Any, places: FloatArray | None = None) -> None:
        size, n = A.blocksize[0], len(A.indptr) - 1
        part = np.zeros(n, dtype=np.int64)
        count = max(1, min(_MOST_PARTS, size * n // _LEAST))
        if places is not None and count > 1:
            along = places[:, np.ptp(places, axis=0).argmax()]
            cuts = np.quantile(along, np.arange(1, count) / count)
            part = np.unique(np.searchsorted(cuts, along), return_inverse=True)[1]
        order = np.argsort(part, kind="stable").astype(np.int32)
        place = np.empty(n, dtype=np.int32)
        place[order] = np.arange(n)
        row = np.repeat(np.arange(n), np.diff(A.indptr))
        inside = part[row] == part[A.indices]
        kept = np.flatnonzero(~inside | (A.indices >= row))
        if part.any():  # in the order of rows; in each, those of other parts come first
            kept = kept[np.lexsort((inside[kept], place[row[kept]]))]
        starts = np.zeros(n + 1, dtype=np.int32)
        np.cumsum(np.bincount(place[row[kept]], minlength=n), out=starts[1:])
        self.pattern = _core.blocks_pattern(order, starts, A.indices[kept], size)
        self.values: FloatArray = A.data[kept].reshape(-1)
        ends = np.cumsum(np.bincount(part))
        self.parts: list[Part] = list(zip([0, *ends[:-1].tolist()], ends.tolist(), strict=True))
        self.work_length = _WORK * n * (size + 1)

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


def diagonal_places(A: Any) -> IntArray:
    """Return which blocks of a BSR matrix lie on its diagonal, by rows."""
    row = np.repeat(np.arange(len(A.indptr) - 1), np.diff(A.indptr))
    return np.flatnonzero(A.indices == row)
