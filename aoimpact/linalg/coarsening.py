"""Prolongations from one level of multigrid to the next."""

from __future__ import annotations

from typing import Any

import numpy as np
import scipy.sparse as sp

from .. import _core
from ..base import ROUNDING, FloatArray
from ..mesh import rigid_motions
from .blocks import diagonal_places
from .pencil import Pencil

# ω of the prolongation's smoothing, over λ_max of D⁻¹A (Vanek, Mandel and Brezina 1996).
_DAMPING = 4.0 / 3.0


def corners_of(pencil: Pencil) -> tuple[sp.csr_array, FloatArray, FloatArray] | None:
    """Return the linear functions of a quadratic mesh's corners, at all its nodes.

    The space of the linear elements on the corners lies in that of the quadratic ones, so this is
    exact (on elements with straight sides; nearly so on curved ones).

    Returns
    -------
    interpolation : scipy.sparse.csr_array, shape (n, n_corners)
        At the nodes that have dofs.
    motions : ndarray, shape (n_corners, 3, 6)
        Rigid motions of the corners that have dofs.
    places : ndarray, shape (n_corners, 3)
        Their coordinates.

    None where the mesh is not quadratic, or all corners are constrained.
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

    Vanek, Mandel and Brezina, Computing 56 (1996): the candidates, cut to aggregates of nodes and
    made orthonormal there, span the coarse space; one Jacobi step smooths it.

    Parameters
    ----------
    A : scipy.sparse.bsr_array
        n x n blocks b x b.
    candidates : ndarray, shape (n, b, m)
        Motions that A resists little: rigid ones.
    highest : float
        λ_max of D⁻¹A, with D the diagonal blocks.

    Returns
    -------
    prolongation : scipy.sparse.bsr_array
        n x n_aggregates blocks b x m.
    coarse : ndarray, shape (n_aggregates, m, m)
    """
    n, size, count = candidates.shape
    aggregate = np.empty(n, dtype=np.int32)
    n_coarse = _core.graph_aggregate(A.indptr, A.indices, aggregate)
    order = np.argsort(aggregate, kind="stable")
    starts = np.searchsorted(aggregate[order], np.arange(n_coarse))
    gram = np.einsum("nbi,nbj->nij", candidates, candidates)[order]
    values, vectors = np.linalg.eigh(np.add.reduceat(gram, starts, axis=0))
    # gram = V Λ Vᵀ: with B = Q R, Q is B V Λ^(-1/2) and R is Λ^(1/2) Vᵀ; zero where dependent.
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
