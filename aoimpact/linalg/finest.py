"""The matrix A of multigrid's finest level: K + s²M in blocks, some rows at a time.

As a whole it takes half the memory of K and M. On quadratic meshes it is never there as a whole:
only what `Blocks` stores of it, about one triangle, and Pᵀ A P are kept.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from itertools import chain, pairwise
from typing import Any

import numpy as np
import numpy.typing as npt
import scipy.sparse as sp

from ..base import PRINTED, FloatArray, SingularError, at_once
from ..mesh import rigid_motions
from .blocks import Blocks, Stored, diagonal_blocks, diagonal_places
from .pencil import Pencil
from .rows import ENTRIES_AT_ONCE, rows_of

Place = npt.NDArray[np.int64]
Column = npt.NDArray[np.int32]

# Threads take the rows in so many shares. What comes of them is added up in their order, so that
# the number of threads changes no bit.
_SHARES = 4


@dataclass(frozen=True, eq=False)
class Finest:
    """K + s²M in blocks b x b.

    Attributes
    ----------
    rows : callable
        rows(begin, end) returns those rows of blocks as a BSR matrix, in order, with every diagonal
        block; it raises SingularError where one is missing.
    cuts : list of int
        Where to divide the rows: those between two cuts stay in the caches.
    motions : ndarray, shape (n, b, m)
        Motions that A resists little: rigid ones.
    nodes : ndarray, shape (n, 3), optional
        Where the nodes are, if the blocks are of nodes.
    place : ndarray of int or slice
        Rows of the pencil's dofs; those of constrained dofs are between them.
    """

    rows: Callable[[int, int], Any]
    cuts: list[int]
    motions: FloatArray
    nodes: FloatArray | None
    place: Place | slice

    def whole(self) -> Any:
        """Return all rows."""
        return self.rows(0, len(self.motions))


def finest_level(pencil: Pencil) -> Finest:
    """Return K + s²M by blocks of nodes, or of what little is known of the dofs."""
    if pencil.nodes is None or pencil.free is None:
        return _without_nodes(pencil)
    nodes, number = np.unique(pencil.free // 3, return_inverse=True)
    place = 3 * number + pencil.free % 3
    whole = np.array_equal(place, np.arange(3 * len(nodes)))
    ascending, K, M = place, pencil.K, pencil.M
    if (np.diff(place) < 0).any():
        order = np.argsort(place)
        ascending, K, M = place[order], K[order][:, order], M[order][:, order]
    return Finest(
        partial(_rows, pencil, K, M, ascending.astype(np.int32), 3 * len(nodes)),
        _cuts(len(nodes), K),
        rigid_motions(pencil.nodes).reshape(-1, 3, 6)[nodes],
        pencil.nodes[nodes],
        slice(None) if whole else place,
    )


def reduced(level: Finest, part: Place, prolongation: Any) -> tuple[Blocks, FloatArray, Any]:
    """Return A as blocks, its diagonal ones and Pᵀ A P, without A as a whole.

    Parameters
    ----------
    level : Finest
        A.
    part : ndarray of int
        Which part of the blocks each of its rows belongs to.
    prolongation : scipy.sparse.bsr_array
        P.
    """
    cuts = level.cuts
    ends = np.unique(np.linspace(0, len(cuts) - 1, 1 + _SHARES, dtype=int)).tolist()
    shares = [cuts[first : last + 1] for first, last in pairwise(ends)]
    stored: list[list[Stored]] = [[] for _ in shares]
    diagonal = np.empty((len(part), 3, 3))
    coarse: list[Any] = [None] * len(shares)

    def call(share: int) -> None:
        own, products = shares[share], []
        for begin, end in pairwise(own):
            A = level.rows(begin, end)
            stored[share].append(Stored.of(A, part, begin))
            diagonal[begin:end] = diagonal_blocks(A, begin)
            products.append(A @ prolongation)
        coarse[share] = rows_of(prolongation, own[0], own[-1]).T @ _stacked(products)

    at_once([partial(call, share) for share in range(len(shares))])
    pieces = list(chain.from_iterable(stored))
    stored.clear()  # the blocks leave none of them
    return Blocks(pieces, part), diagonal, sum(coarse[1:], start=coarse[0])


def _stacked(pieces: list[Any]) -> Any:
    """Return BSR matrices below each other; SciPy's way goes by triples of each entry."""
    data = np.concatenate([piece.data for piece in pieces])
    indices = np.concatenate([piece.indices for piece in pieces])
    lengths = np.concatenate([np.diff(piece.indptr) for piece in pieces])
    indptr = np.concatenate([[0], np.cumsum(lengths)])
    shape = (len(lengths) * data.shape[1], pieces[0].shape[1])
    return sp.bsr_array((data, indices, indptr), shape=shape)


def _rows(pencil: Pencil, K: Any, M: Any, place: Column, n: int, begin: int, end: int) -> Any:
    """Return some rows of nodes of K + s²M, whose dofs have ascending places in n."""
    own = slice(*np.searchsorted(place, (3 * begin, 3 * end)))

    def spread(matrix: Any) -> Any:
        some, size = rows_of(matrix, own.start, own.stop), 3 * (end - begin)
        return some if len(place) == n else _spread(some, place[own] - 3 * begin, size, place, n)

    A = in_order(spread(K).tobsr((3, 3)))
    if pencil.s2:
        A = add(A, pencil.s2, spread(M))
    _check_diagonal(A, pencil, begin)
    if len(place) < n:  # partly constrained nodes: their other dofs stay uncoupled
        fixed = np.full(A.shape[0], pencil.scale)
        fixed[place[own] - 3 * begin] = 0.0
        add_to_diagonal(A, fixed, begin)
    return A


def _cuts(n: int, matrix: Any) -> list[int]:
    """Return where to divide n rows, for so many entries of a matrix at once."""
    cuts: list[int] = np.unique(
        np.linspace(0, n, 2 + matrix.nnz // ENTRIES_AT_ONCE, dtype=int)
    ).tolist()
    return cuts


def _spread(some: Any, rows: Column, size: int, columns: Column, n: int) -> Any:
    """Return a CSR matrix with row i moved to rows[i] of size, and column j to columns[j] of n."""
    indptr = np.zeros(size + 1, dtype=np.int32)
    indptr[rows + 1] = np.diff(some.indptr)
    np.cumsum(indptr, out=indptr)
    return sp.csr_array((some.data, columns[some.indices], indptr), shape=(size, n))


def _without_nodes(pencil: Pencil) -> Finest:
    """Dofs of which nothing is known: three translations if K does not resist these, else one."""
    A = pencil.matrix()
    moves = np.tile(np.eye(3), (A.shape[0] // 3 + 1, 1))[: A.shape[0]]
    inner = np.abs(pencil.K @ moves) <= PRINTED * pencil.K.diagonal()[:, None]
    if A.shape[0] % 3 == 0 and inner.mean() > 0.5:  # the others are on nodes beside supports
        A, motions = A.tobsr((3, 3)), moves.reshape(-1, 3, 3)
    else:
        A, motions = A.tobsr((1, 1)), np.ones((A.shape[0], 1, 1))
    _check_diagonal(A, pencil)
    n = len(motions)
    return Finest(partial(rows_of, in_order(A)), [0, n], motions, None, slice(None))


def _check_diagonal(A: Any, pencil: Pencil, first: int = 0) -> None:
    """Refuse a BSR matrix that does not store every block of its diagonal."""
    if len(diagonal_places(A, first)) < len(A.indptr) - 1:
        raise SingularError(f"{pencil.what} is singular: some dofs have no stiffness")


def add(A: Any, factor: float, M: Any) -> Any:
    """Return A + factor M, of a BSR matrix in order and a CSR matrix; A is used up.

    Some rows at a time, in A's arrays: M in blocks takes three times M. Where M has blocks that A
    has not, the sum has arrays of its own.
    """
    size = A.blocksize[0]
    for begin, end in pairwise(_cuts(len(A.indptr) - 1, M)):
        some = in_order(rows_of(M, size * begin, size * end).tobsr(A.blocksize))
        own, starts = slice(*A.indptr[[begin, end]]), A.indptr[begin : end + 1] - A.indptr[begin]
        alike = np.array_equal(some.indptr, starts)
        if not (alike and np.array_equal(some.indices, A.indices[own])):
            rest = M.copy()  # couples other nodes than A
            rest.data[: M.indptr[size * begin]] = 0.0
            return in_order(A + factor * rest.tobsr(A.blocksize))
        some.data *= factor
        A.data[own] += some.data
    return A


def in_order(A: Any) -> Any:
    """Return a BSR matrix with its blocks sorted and its indices int32, as the core wants them."""
    A.sort_indices()
    A.indices, A.indptr = A.indices.astype(np.int32), A.indptr.astype(np.int32)
    return A


def add_to_diagonal(A: Any, values: FloatArray, first: int = 0) -> None:
    """Add to the diagonal of a BSR matrix that stores all its diagonal blocks."""
    size = A.blocksize[0]
    local = np.arange(size)
    A.data[diagonal_places(A, first)[:, None], local, local] += values.reshape(-1, size)
