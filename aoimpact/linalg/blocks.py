"""Products with sparse matrices in threads: by ranges of rows, or by blocks in the C core."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from .. import _core
from ..base import FloatArray, IntArray, at_once, sp

Part = tuple[int, int]

# Length of the core's work space, divided by n (size + 1): AOI_BLOCKS_WORK of
# csrc/multigrid/multigrid.h.
_WORK = 3

# Matrix entries processed in one pass: 2 MB, which fit into the caches. With 2**22, removing the
# supported dofs of a block of 493 000 dofs takes 1.4 s instead of 1.0 s, and forming K + s²M 2.8 s
# instead of 2.5 s.
ENTRIES_AT_ONCE = 2**18


# Products in parts. `_MOST_PARTS`: maximum number of parts. `_LEAST_ENTRIES`: minimum entries of a
# part, whose product takes 1 ms; handing it to a thread takes 20 µs. Between parts of blocks, a
# layer of elements is stored twice: four parts of a plate of 268 000 dofs store 2 % more, those of
# a cube 5 %.
_MOST_PARTS, _LEAST_ENTRIES = 4, 1_000_000


class Blocks:
    """A symmetric matrix in blocks; within each part one triangle is stored, and read once.

    Products that run at the same time each need their own work space.

    Parameters
    ----------
    A : scipy.sparse.bsr_array
        Matrix with sorted indices and every diagonal block stored.
    places : ndarray, shape (n, 3), optional
        Coordinates of the rows of blocks. With them a large body is cut across its longest side
        into slabs, the parts; without them there is one part.

    Attributes
    ----------
    pattern : object
        The core's record of the sparsity pattern and the order of rows.
    values : ndarray
        Entries of the stored blocks.
    parts : list of tuple
        Begin and end of each part in the order of rows.
    work_length : int
        Length of the work space that the core needs.
    """

    def __init__(self, A: Any, places: FloatArray | None = None) -> None:
        size, n = A.blocksize[0], len(A.indptr) - 1
        part = np.zeros(n, dtype=np.int64)
        count = len(_parts(A))
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
        if part.any():  # sort by row, then blocks of other parts first
            kept = kept[np.lexsort((inside[kept], place[row[kept]]))]
        starts = np.zeros(n + 1, dtype=np.int32)
        np.cumsum(np.bincount(place[row[kept]], minlength=n), out=starts[1:])
        self.pattern = _core.blocks_pattern(order, starts, A.indices[kept], size)
        self.values: FloatArray = A.data[kept].reshape(-1)
        ends = np.cumsum(np.bincount(part))
        self.parts: list[Part] = list(zip([0, *ends[:-1].tolist()], ends.tolist(), strict=True))
        self.work_length = _WORK * n * (size + 1)

    def multiply(self, x: FloatArray, work: FloatArray) -> FloatArray:
        """Return A x; `work`: space for `work_length` numbers."""
        matrix, product = (self.pattern, self.values), np.empty_like(x)
        in_stages(2, self.parts, _core.blocks_multiply, matrix, x, product, work)
        return product


def in_stages(
    count: int, parts: list[Part], function: Callable[..., None], matrix: Any, *rest: Any
) -> None:
    """Call the core for each part and stage; each stage waits for all parts of the previous one."""
    for stage in range(count):
        if len(parts) == 1:
            function(matrix, parts[0], stage, *rest)
        else:
            at_once([partial(function, matrix, part, stage, *rest) for part in parts])


def diagonal_places(A: Any) -> IntArray:
    """Return the positions of the diagonal blocks among the stored blocks of a BSR matrix."""
    row = np.repeat(np.arange(len(A.indptr) - 1), np.diff(A.indptr))
    return np.flatnonzero(A.indices == row)


def product(A: Any, x: FloatArray) -> FloatArray:
    """Return A x of a CSR matrix, bit for bit equal to A @ x; threads share the rows."""
    result, parts = np.empty((A.shape[0], *x.shape[1:])), _parts(A)

    def call(begin: int, end: int) -> None:
        result[begin:end] = (rows_of(A, begin, end) if len(parts) > 1 else A) @ x

    at_once([partial(call, *part) for part in parts])
    return result


def congruent(A: Any, P: Any) -> Any:
    """Return Pᵀ A P of sparse matrices, summed over ranges of A's rows, which threads share."""
    parts = _parts(A)
    terms: list[Any] = [None] * len(parts)

    def call(k: int, begin: int, end: int) -> None:
        terms[k] = rows_of(P, begin, end).T @ (rows_of(A, begin, end) @ P)

    at_once([partial(call, k, *part) for k, part in enumerate(parts)])
    return sum(terms[1:], start=terms[0])


def rows_of(A: Any, begin: int, end: int) -> Any:
    """Return rows `begin` to `end` (of blocks) of a CSR or BSR matrix, sharing its arrays."""
    first, last = A.indptr[begin], A.indptr[end]
    if A.format == "bsr":
        shape = ((end - begin) * A.blocksize[0], A.shape[1])
        some: Any = sp.bsr_array(shape, blocksize=A.blocksize, dtype=A.dtype)
    else:
        some = sp.csr_array((end - begin, A.shape[1]), dtype=A.dtype)
    # Assign the arrays after construction, since SciPy's constructors copy slices of less than half
    # of an array.
    some.data, some.indices = A.data[first:last], A.indices[first:last]
    some.indptr = A.indptr[begin : end + 1] - first
    return some


def _parts(A: Any) -> list[tuple[int, int]]:
    """Return ranges of rows (of blocks) with about equal numbers of entries."""
    count = max(1, min(_MOST_PARTS, A.nnz // _LEAST_ENTRIES))
    shares = np.arange(1, count) * (A.indptr[-1] / count)
    cuts = np.searchsorted(A.indptr, shares).tolist()
    return list(zip([0, *cuts], [*cuts, len(A.indptr) - 1], strict=True))
