"""M-orthonormal bases, and the motions that a stiffness matrix leaves free."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np

from ..base import PRINTED, FloatArray, SingularError, sp


def m_orthonormal(space: FloatArray | None, vectors: FloatArray, M: Any) -> FloatArray:
    """Return an M-orthonormal basis of the part of `vectors` that `space` does not span.

    Gram-Schmidt runs twice, since rounding may dominate a short remainder of the first pass
    (Giraud, Langou and Rozložník, Comput. Math. Appl. 50 (2005) 1069).

    Parameters
    ----------
    space : ndarray, shape (n, r), or None
        M-orthonormal basis of a space; None if it is empty.
    vectors : ndarray, shape (n, m)
    M : matrix, shape (n, n)
        Symmetric positive semidefinite; sparse or dense.

    Returns
    -------
    basis : ndarray, shape (n, k), k ≤ m
        `space` and the columns together span the same space as `space` and `vectors`. A vector adds
        no column if it has no mass, or lies in the span of `space` and the vectors before it up to
        1e-9 of its length.

    Examples
    --------
    >>> m_orthonormal(None, np.array([[2.0, 2.0], [0.0, 1.0]]), np.eye(2))
    array([[1., 0.],
           [0., 1.]])
    """
    basis = vectors
    for _ in range(2):
        moved = M @ basis
        whole = np.sqrt(np.einsum("ij,ij->j", basis, moved).clip(0.0))
        if space is not None and space.shape[1]:
            basis = basis - space @ (space.T @ moved)
            moved = M @ basis
        found, momenta, k = np.empty_like(basis, order="F"), np.empty_like(basis, order="F"), 0
        for x, mx, size in zip(basis.T, moved.T, whole, strict=True):
            shares = momenta[:, :k].T @ x
            x = x - found[:, :k] @ shares
            mx = mx - momenta[:, :k] @ shares
            length = float(np.sqrt(max(x @ mx, 0.0)))
            if length > PRINTED * size:
                found[:, k] = x / length
                momenta[:, k] = mx / length
                k += 1
        basis = found[:, :k]
    return np.ascontiguousarray(basis)


def unresisted_motions(
    K: Any, M: Any, motions: FloatArray, springs: FloatArray | None = None
) -> FloatArray:
    """Return an M-orthonormal basis of the rigid motions with K r = 0, shape (n, r).

    All combinations of the motions are tested, such as the rotation of a body about a hinge along
    any line, and each part of the body that K does not connect with the rest is tested alone.

    Parameters
    ----------
    K, M : scipy.sparse.csr_array, shape (n, n)
    motions : ndarray, shape (n, 6)
        Rigid motions on the dofs of K, of magnitude one.
    springs : ndarray, shape (n,), optional
        Springs to the ground, which K contains. They resist however soft they are.

    Raises
    ------
    SingularError
        If a motion without elastic forces has no mass.
    """
    forces = K @ motions
    if springs is not None:  # rounding of K may hide soft springs: set below
        forces -= springs[:, None] * motions
    stiffness = K.diagonal()[:, None]
    np.divide(forces, stiffness, out=forces, where=stiffness > 0.0)
    if springs is not None:
        forces = np.where(springs[:, None] > 0.0, motions, forces)
    # Strongly and weakly connected components of a symmetric K agree; strong ones need no K.T.
    n_parts, part = sp.csgraph.connected_components(K, connection="strong")
    order = np.argsort(part, kind="stable")
    bounds = np.searchsorted(part[order], np.arange(n_parts + 1))
    found = []
    for first, last in pairwise(bounds):
        rows = order[first:last]
        _, size, right = np.linalg.svd(motions[rows], full_matrices=False)
        kept = size > PRINTED * size[0]
        combination = right[kept].T / size[kept]
        combination @= np.linalg.svd(forces[rows] @ combination, full_matrices=False)[2].T
        basis = motions[rows] @ combination
        # Forces are relative to K_ii: a spring in K that `springs` does not name counts by its
        # share of K_ii.
        residual = np.abs(forces[rows] @ combination).max(axis=0)
        free = residual <= PRINTED * np.abs(basis).max(axis=0)
        columns = np.zeros((len(motions), np.count_nonzero(free)))
        columns[rows] = basis[:, free]
        found.append(columns)
    unresisted = np.concatenate(found, axis=1)
    basis = m_orthonormal(None, unresisted, M)
    if basis.shape != unresisted.shape:
        raise SingularError(
            "M must be positive for motions without stiffness, and its entries not too far apart. "
            "Check rho, masses, their centres and inertias"
        )
    return basis
