"""Stiffness and consistent mass of bodies of shells and beams, six dofs to a node."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import scipy.sparse as sp

from ..base import FloatArray, IntArray
from .beams import Beam, beam_mass, beam_stiffness
from .laminate import Layers
from .shells import element_mass, element_stiffness, nodal_normals

__all__ = ["ThinPart", "thin_stiffness_mass"]


# Nodes of elements, shape (n, 2), (n, 3) or (n, 4), and what these are.
ThinPart = tuple[IntArray, Layers | Beam]


def thin_stiffness_mass(
    nodes: FloatArray, parts: Sequence[ThinPart]
) -> tuple[sp.csr_array, sp.csr_array]:
    """Return K and M over the dofs 6·node + (u, v, w, θx, θy, θz), rotations right-handed.

    Parameters
    ----------
    nodes : ndarray, shape (n_nodes, 3)
        m.
    parts : sequence of (ndarray of int, Shell, Laminate or Beam)

    Returns
    -------
    K, M : scipy.sparse.csr_array, shape (6 n_nodes, 6 n_nodes)
        N/m, N and N m; kg, kg m and kg m². Exactly symmetric, column indices sorted. Rows of M of
        rotations about a flat shell's normal are zero.
    """
    place, indices, indptr = _pattern(len(nodes), [cells for cells, _ in parts])
    surfaces = [cells for cells, part in parts if not isinstance(part, Beam)]
    normals = iter(nodal_normals(nodes, surfaces) if surfaces else [])
    constant = len({cells.shape[1] for cells in surfaces}) > 1
    stiffness, mass = [], []
    for cells, part in parts:
        ends = nodes[cells]
        if isinstance(part, Beam):
            stiffness.append(_blocks(beam_stiffness(ends, part)))
            mass.append(_blocks(beam_mass(ends, part)))
        else:
            stiffness.append(
                _blocks(element_stiffness(ends, part, next(normals), constant=constant))
            )
            mass.append(_blocks(element_mass(ends, part)))
    found = []
    for each in (stiffness, mass):
        blocks = np.concatenate(each)
        to_pairs = sp.csr_array(
            (np.ones(len(place)), (place, np.arange(len(place)))), shape=(len(indices), len(place))
        )
        values = (to_pairs @ blocks).reshape(-1, 6, 6)
        matrix = sp.bsr_array((values, indices, indptr), shape=(6 * len(nodes),) * 2).tocsr()
        matrix.eliminate_zeros()
        found.append(matrix)
    return found[0], found[1]


def _blocks(matrices: FloatArray) -> FloatArray:
    """Blocks of 6 x 6 of element matrices, shape (n nodes², 36)."""
    n, width = matrices.shape[:2]
    split = matrices.reshape(n, width // 6, 6, width // 6, 6).swapaxes(2, 3)
    blocks: FloatArray = split.reshape(-1, 36)
    return blocks


def _pattern(n_nodes: int, groups: Sequence[IntArray]) -> tuple[IntArray, IntArray, IntArray]:
    """Of each block of each element its place among pairs of nodes; those by compressed rows."""
    pairs = np.concatenate(
        [(cells[:, :, None] * n_nodes + cells[:, None, :]).reshape(-1) for cells in groups]
    )
    key, place = np.unique(pairs, return_inverse=True)
    row, column = np.divmod(key, n_nodes)
    indptr = np.concatenate([[0], np.cumsum(np.bincount(row, minlength=n_nodes))])
    return place, column.astype(np.int32), indptr.astype(np.int32)
