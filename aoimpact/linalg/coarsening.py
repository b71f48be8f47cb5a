"""Multigrid's finest level, K + s²M in blocks, and the prolongations from coarser levels."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from .. import _core
from ..base import PRINTED, ROUNDING, FloatArray, SingularError, sp
from ..mesh import rigid_motions
from .blocks import diagonal_places
from .pencil import Pencil

# Product ω λ_max(D⁻¹A), with the damping factor ω of the Jacobi step that smooths the prolongation
# (Vanek, Mandel and Brezina 1996).
_DAMPING = 4.0 / 3.0


class Finest(NamedTuple):
    """K + s²M in blocks b x b.

    Attributes
    ----------
    A : scipy.sparse.bsr_array
        Matrix with sorted indices and every diagonal block stored.
    motions : ndarray, shape (n, b, m)
        Near-null-space vectors of A: rigid motions.
    nodes : ndarray, shape (n, 3), optional
        Coordinates of the nodes, m, if each block row belongs to a node.
    place : ndarray of int or slice
        Row of A of each dof of the pencil; the other rows belong to constrained dofs.
    """

    A: Any
    motions: FloatArray
    nodes: FloatArray | None
    place: npt.NDArray[np.int64] | slice


def finest_level(pencil: Pencil) -> Finest:
    """Return K + s²M in blocks of 3 dofs per node; without nodes, in blocks of 3 or 1.

    Raises
    ------
    SingularError
        If a diagonal block is missing.
    """
    K, M, where = pencil.K, pencil.M, None
    place: npt.NDArray[np.int64] | slice = slice(None)
    if pencil.nodes is None or pencil.free is None:
        # Blocks of 3 if most rows of K have no force under translations of dof triples, else of 1.
        moves = np.tile(np.eye(3), (pencil.n // 3 + 1, 1))[: pencil.n]
        inner = np.abs(K @ moves) <= PRINTED * K.diagonal()[:, None]
        size = 3 if pencil.n % 3 == 0 and inner.mean() > 0.5 else 1  # except near supports
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
    if A.shape[0] > pencil.n:  # constrained dofs of partly free nodes get only a diagonal entry
        fixed = np.full(A.shape[0], pencil.scale)
        fixed[place] = 0.0
        add_to_diagonal(A, fixed)
    return Finest(A, motions, where, place)


def _spread(matrix: Any, place: npt.NDArray[np.int64], n: int) -> Any:
    """Return an n x n CSR matrix with row and column i of `matrix` as row and column place[i]."""
    order = np.argsort(place)
    rows, lengths = matrix[order] if (np.diff(place) < 0).any() else matrix, np.zeros(n + 1, int)
    lengths[1 + place[order]] = np.diff(rows.indptr)
    columns = place.astype(np.int32)[rows.indices]
    return sp.csr_array((rows.data, columns, np.cumsum(lengths)), shape=(n, n))


def add(A: Any, factor: float, M: Any) -> Any:
    """Return A + factor M, of a BSR matrix with sorted indices and a CSR matrix; overwrites A."""
    blocks = in_order(M.tobsr(A.blocksize))
    if not all(np.array_equal(getattr(A, of), getattr(blocks, of)) for of in ("indptr", "indices")):
        return in_order(A + factor * blocks)  # M has other nonzero blocks than A
    blocks.data *= factor
    A.data += blocks.data
    return A


def in_order(A: Any) -> Any:
    """Return a BSR matrix with its blocks sorted and its indices int32, as the core requires."""
    A.sort_indices()
    A.indices, A.indptr = A.indices.astype(np.int32), A.indptr.astype(np.int32)
    return A


def add_to_diagonal(A: Any, values: FloatArray) -> None:
    """Add values to the diagonal of a BSR matrix, which must store every diagonal block."""
    size = A.blocksize[0]
    local = np.arange(size)
    A.data[diagonal_places(A)[:, None], local, local] += values.reshape(-1, size)


def corners_of(pencil: Pencil) -> tuple[sp.csr_array, FloatArray, FloatArray] | None:
    """Return the values of the corners' linear shape functions at all nodes of a quadratic mesh.

    The linear elements' functions lie in the space of the quadratic elements: exactly if the sides
    are straight, nearly if they are curved.

    Returns
    -------
    interpolation : scipy.sparse.csr_array, shape (n, n_corners)
        Rows: nodes that have dofs; columns: corners.
    motions : ndarray, shape (n_corners, 3, 6)
        Rigid motions of the corners that have dofs.
    places : ndarray, shape (n_corners, 3)
        Coordinates of these corners, m.

    None if the mesh is not quadratic, or all corners are constrained.
    """
    mesh, free, nodes_at = pencil.mesh, pencil.free, pencil.nodes
    if mesh is None or free is None or nodes_at is None or not mesh.quadratic:
        return None
    is_corner = np.zeros(mesh.n_nodes, dtype=bool)
    for block in mesh.blocks:
        is_corner[block.cells[:, : block.element.n_corners]] = True
    corners, number = np.flatnonzero(is_corner), np.cumsum(is_corner) - 1
    rows, columns, values = [], [], []
    done = np.zeros(mesh.n_nodes, dtype=bool)
    for block in mesh.blocks:
        element = block.element
        shape = element.linear.shape(element.nodes)
        # A node has the same weights in all elements that share it: take the first.
        nodes, first = np.unique(block.cells, return_index=True)
        nodes, first = nodes[~done[nodes]], first[~done[nodes]]
        done[nodes] = True
        cell, local = np.divmod(first, element.n_nodes)
        weights, parents = shape[local], number[block.cells[cell, : element.n_corners]]
        used = np.abs(weights) > ROUNDING
        rows.append(np.repeat(nodes, used.sum(axis=1)))
        columns.append(parents[used])
        values.append(weights[used])
    entries = (np.concatenate(values), (np.concatenate(rows), np.concatenate(columns)))
    moving = np.unique(free // 3)
    kept = np.isin(corners, moving, assume_unique=True)
    if not kept.any():
        return None
    interpolation = sp.csr_array(entries, shape=(mesh.n_nodes, len(corners)))[moving][:, kept]
    motions = rigid_motions(nodes_at).reshape(-1, 3, 6)[corners[kept]]
    return interpolation, motions, nodes_at[corners[kept]]


def aggregated(A: Any, candidates: FloatArray, highest: float) -> tuple[Any, FloatArray]:
    """Return the prolongation of smoothed aggregation, and the candidates on the coarse level.

    Vanek, Mandel and Brezina, Computing 56 (1996): the candidates, restricted to aggregates of
    nodes and made orthonormal there, span the coarse space; one Jacobi step smooths it.

    Parameters
    ----------
    A : scipy.sparse.bsr_array
        n x n blocks b x b.
    candidates : ndarray, shape (n, b, m)
        Near-null-space vectors of A: rigid motions.
    highest : float
        λ_max of D⁻¹A, with D the diagonal blocks.

    Returns
    -------
    prolongation : scipy.sparse.bsr_array
        n x n_aggregates blocks b x m.
    coarse : ndarray, shape (n_aggregates, m, m)
        Near-null-space vectors on the coarse level.
    """
    n, size, count = candidates.shape
    aggregate = np.empty(n, dtype=np.int32)
    n_coarse = _core.graph_aggregate(A.indptr, A.indices, aggregate)
    order = np.argsort(aggregate, kind="stable")
    starts = np.searchsorted(aggregate[order], np.arange(n_coarse))
    gram = np.einsum("nbi,nbj->nij", candidates, candidates)[order]
    values, vectors = np.linalg.eigh(np.add.reduceat(gram, starts, axis=0))
    # Orthonormal candidates: BᵀB = V Λ Vᵀ gives B = Q R with Q = B V Λ^(-1/2) and R = Λ^(1/2) Vᵀ.
    # The columns of Q for dependent candidates are zero.
    kept = values > ROUNDING * values[:, -1:]
    root = np.sqrt(np.where(kept, values, 0.0))
    inverse_root = np.divide(1.0, root, out=np.zeros_like(root), where=kept)
    local = np.matmul(candidates, (vectors * inverse_root[:, None, :])[aggregate])
    coarse = root[:, :, None] * vectors.transpose(0, 2, 1)
    shape = (n * size, n_coarse * count)
    rows = np.arange(n + 1, dtype=np.int32)
    tentative = sp.bsr_array((local, aggregate, rows), shape=shape)
    change = A @ tentative
    row = np.repeat(np.arange(n), np.diff(change.indptr))
    change.data = np.matmul(np.linalg.inv(A.data[diagonal_places(A)])[row], change.data)
    change.data *= -_DAMPING / highest
    return tentative + change, coarse
