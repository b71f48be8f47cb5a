"""Rigid-body motions: which of them a stiffness matrix leaves free."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
import scipy
import scipy.sparse as sp

from ..base import FloatArray, SingularError

# Largest |K r|_i of an unresisted rigid motion, over K_ii max |r|. Rounding of a mesh's own K gives
# some 1e-15, a K printed with ten digits 1e-10; a spring to the ground gives its share of the
# stiffness at its dof.
_RESISTED = 1e-9

# Relative difference below which motions are the same one (rotation of a line about itself).
_DEPENDENT = 1e-9


def rigid_motions(nodes: FloatArray, *, rotations: bool = False) -> FloatArray:
    """Return three translations and three rotations about the middle, shape (3 n_nodes, 6).

    Rotations are scaled by the body's size, so that all columns are of the same magnitude. With
    `rotations`, the nodes' own rotations follow the displacements of all: shape (6 n_nodes, 6).
    """
    middle = 0.5 * (nodes.min(axis=0) + nodes.max(axis=0))
    size = float(np.ptp(nodes, axis=0).max()) or 1.0
    moved = motions_at((nodes - middle) / size).reshape(-1, 6)
    if not rotations:
        return moved
    turned = np.hstack([np.zeros((3, 3)), np.eye(3) / size])
    return np.vstack([moved, np.tile(turned, (len(nodes), 1))])


def motions_at(places: FloatArray) -> FloatArray:
    """Return x, y, z of unit translations and rotations about the origin, shape (n, 3, 6)."""
    x, y, z = places.T
    motions = np.zeros((len(places), 3, 6))
    motions[:, [0, 1, 2], [0, 1, 2]] = 1.0
    motions[:, 1, 3], motions[:, 2, 3] = -z, y
    motions[:, 2, 4], motions[:, 0, 4] = -x, z
    motions[:, 0, 5], motions[:, 1, 5] = -y, x
    return motions


def unresisted_motions(
    K: Any, M: Any, motions: FloatArray, springs: FloatArray | None = None
) -> FloatArray:
    """Return an M-orthonormal basis of the rigid motions with K r = 0, shape (n, r).

    Every combination of the motions is tested (a body hinged about any line turns about it),
    for each part of the body that K does not connect with the rest.

    Parameters
    ----------
    K, M : scipy.sparse.csr_array, shape (n, n)
    motions : ndarray, shape (n, 6)
        Rigid motions on the dofs of K, of magnitude one.
    springs : ndarray, shape (n,), optional
        Springs to the ground, which K contains. They resist however soft they are.
    """
    forces = K @ motions
    if springs is not None:  # apart from rounding of the forces in the body
        forces -= springs[:, None] * motions
    stiffness = K.diagonal()[:, None]
    np.divide(forces, stiffness, out=forces, where=stiffness > 0.0)
    if springs is not None:
        forces = np.where(springs[:, None] > 0.0, motions, forces)
    # K is symmetric, so that strong connection is connection; it needs no transpose.
    n_parts, part = sp.csgraph.connected_components(K, connection="strong")
    order = np.argsort(part, kind="stable")
    bounds = np.searchsorted(part[order], np.arange(n_parts + 1))
    found = []
    for first, last in pairwise(bounds):
        rows = order[first:last]
        local = _null_combinations(motions[rows], forces[rows])
        columns = np.zeros((len(motions), local.shape[1]))
        columns[rows] = local
        found.append(columns)
    return _orthonormalised(np.concatenate(found, axis=1), M)


def every_motion(M: Any) -> FloatArray:
    """Return an M-orthonormal basis of all motions, (n, n): those of a body of no stiffness."""
    return _orthonormalised(np.eye(M.shape[0]), M)


def _null_combinations(motions: FloatArray, forces: FloatArray) -> FloatArray:
    """Return motions · c of all combinations c with forces · c = 0 to rounding."""
    _, size, right = np.linalg.svd(motions, full_matrices=False)
    kept = size > _DEPENDENT * size[0]
    combination = right[kept].T / size[kept]
    combination = combination @ np.linalg.svd(forces @ combination, full_matrices=False)[2].T
    basis: FloatArray = motions @ combination
    residual = np.abs(forces @ combination).max(axis=0)
    unresisted: FloatArray = basis[:, residual <= _RESISTED * np.abs(basis).max(axis=0)]
    return unresisted


def _orthonormalised(basis: FloatArray, M: Any) -> FloatArray:
    # Twice: the first Gram matrix carries the rounding of however skew the basis was.
    for _ in range(2):
        try:
            factor = scipy.linalg.cholesky(basis.T @ (M @ basis), lower=True)
        except scipy.linalg.LinAlgError:
            raise SingularError(
                "M is not positive for a motion without stiffness, or its entries lie too far "
                "apart. Check rho, masses, their centres and inertias"
            ) from None
        basis = scipy.linalg.solve_triangular(factor, basis.T, lower=True).T
    return np.ascontiguousarray(basis)
