"""The matrix A of multigrid's finest level: K + s²M in blocks."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
import scipy.sparse as sp

from ..base import PRINTED, FloatArray, SingularError
from ..mesh import rigid_motions
from .blocks import diagonal_places
from .pencil import Pencil


class Finest(NamedTuple):
    """K + s²M in blocks b x b.

    Attributes
    ----------
    A : scipy.sparse.bsr_array
        In order, with every diagonal block.
    motions : ndarray, shape (n, b, m)
        Motions that A resists little: rigid ones.
    nodes : ndarray, shape (n, 3), optional
        Where the nodes are, if the blocks are of nodes.
    place : ndarray of int or slice
        Rows of the pencil's dofs; those of constrained dofs are between them.
    """

    A: Any
    motions: FloatArray
    nodes: FloatArray | None
    place: npt.NDArray[np.int64] | slice


def finest_level(pencil: Pencil) -> Finest:
    """Return K + s²M by blocks of nodes, or of what little is known of the dofs.

    Raises
    ------
    SingularError
        If a diagonal block is missing.
    """
    K, M, where = pencil.K, pencil.M, None
    place: npt.NDArray[np.int64] | slice = slice(None)
    if pencil.nodes is None or pencil.free is None:
        # Three translations of a node if K does not resist these, else dofs by themselves.
        moves = np.tile(np.eye(3), (pencil.n // 3 + 1, 1))[: pencil.n]
        inner = np.abs(K @ moves) <= PRINTED * K.diagonal()[:, None]
        size = 3 if pencil.n % 3 == 0 and inner.mean() > 0.5 else 1  # the rest is beside supports
        motions = moves.reshape(-1, 3, 3) if size == 3 else np.ones((pencil.n, 1, 1))
    else:
        size, free, nodes = 3, pencil.free, np.unique(pencil.free // 3)
        rows = 3 * np.searchsorted(nodes, free // 3) + free % 3
        motions, where = rigid_motions(pencil.nodes).reshape(-1, 3, 6)[nodes], pencil.nodes[nodes]
        if not np.array_equal(rows, np.arange(3 * len(nodes))):
            place = rows
            K, M = (_spread(matrix, rows, 3 * len(nodes)) for matrix in (K, M))
    A = in_order(K.tobsr((size, size)))
    if pencil.s2:
        A = add(A, pencil.s2, M)
    if len(diagonal_places(A)) < len(motions):
        raise SingularError(f"{pencil.what} is singular: some dofs have no stiffness")
    if A.shape[0] > pencil.n:  # partly constrained nodes: their other dofs stay uncoupled
        fixed = np.full(A.shape[0], pencil.scale)
        fixed[place] = 0.0
        add_to_diagonal(A, fixed)
    return Finest(A, motions, where, place)


def _spread(matrix: Any, place: npt.NDArray[np.int64], n: int) -> Any:
    """Return a CSR matrix with row and column i moved to place[i] of n."""
    order = np.argsort(place)
    rows, lengths = matrix[order] if (np.diff(place) < 0).any() else matrix, np.zeros(n + 1, int)
    lengths[1 + place[order]] = np.diff(rows.indptr)
    columns = place.astype(np.int32)[rows.indices]
    return sp.csr_array((rows.data, columns, np.cumsum(lengths)), shape=(n, n))


def add(A: Any, factor: float, M: Any) -> Any:
    """Return A + factor M, of a BSR matrix in order and a CSR matrix; A is used up."""
    blocks = in_order(M.tobsr(A.blocksize))
    if not all(np.array_equal(getattr(A, of), getattr(blocks, of)) for of in ("indptr", "indices")):
        return in_order(A + factor * blocks)  # M couples other nodes than A
    blocks.data *= factor
    A.data += blocks.data
    return A


def in_order(A: Any) -> Any:
    """Return a BSR matrix with its blocks sorted and its indices int32, as the core wants them."""
    A.sort_indices()
    A.indices, A.indptr = A.indices.astype(np.int32), A.indptr.astype(np.int32)
    return A


def add_to_diagonal(A: Any, values: FloatArray) -> None:
    """Add to the diagonal of a BSR matrix that stores all its diagonal blocks."""
    size = A.blocksize[0]
    local = np.arange(size)
    A.data[diagonal_places(A)[:, None], local, local] += values.reshape(-1, size)
