"""Stiffness and consistent mass of bodies of shells and beams, six dofs to a node."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from ..base import FloatArray, IntArray, sp
from .beams import Beam, beam_mass, beam_stiffness
from .laminate import Layers
from .shells import element_mass, element_stiffness, nodal_normals, rigid_ends

# Elements are taken so many at a time that their strains stay in the caches.
_BATCH = 512


def thin_stiffness_mass(
    nodes: FloatArray, parts: Sequence[tuple[IntArray, Layers | Beam]]
) -> tuple[sp.csr_array, sp.csr_array]:
    """Return K and M over the dofs 6·node + (u, v, w, θx, θy, θz), rotations right-handed.

    Parameters
    ----------
    nodes : ndarray, shape (n_nodes, 3)
        m.
    parts : sequence of (ndarray of int, Shell, Laminate or Beam)
        Nodes of elements, shape (n, 2), (n, 3) or (n, 4), and what these are.

    Returns
    -------
    K, M : scipy.sparse.csr_array, shape (6 n_nodes, 6 n_nodes)
        N/m, N and N m; kg, kg m and kg m². Exactly symmetric, column indices sorted. Rows of M of
        rotations about a flat shell's normal are zero.
    """
    surfaces = [(cells, part) for cells, part in parts if not isinstance(part, Beam)]
    joints = rigid_ends(nodes, surfaces) if surfaces else []
    normals = nodal_normals(nodes, [cells for cells, _ in surfaces]) if surfaces else []
    constant = len({cells.shape[1] for cells, _ in surfaces}) > 1
    strips = [strip for _, strip, _ in joints]
    places, indices, indptr = _pattern(len(nodes), [*(cells for cells, _ in parts), *strips])
    K, M = np.zeros(36 * len(indices)), np.zeros(36 * len(indices))
    shells = iter(zip(normals, joints, places[len(parts) :], strict=True))
    for (cells, part), place in zip(parts, places, strict=False):
        if isinstance(part, Beam):
            _add(K, place, beam_stiffness(nodes[cells], part))
            _add(M, place, beam_mass(nodes[cells], part))
            continue
        normal, (ends, strip, links), there = next(shells)
        for start in range(0, len(cells), _BATCH):
            some = slice(start, start + _BATCH)
            at, more = nodes[cells[some]], (normal[some], ends[some])
            _add(K, place[some], element_stiffness(at, part, *more, constant=constant))
            _add(M, place[some], element_mass(at, part))
        if len(strip):
            _add(K, there, element_stiffness(nodes[strip], part, ends=links))
    return _compressed(K, indices, indptr), _compressed(M, indices, indptr)


def _compressed(
    values: FloatArray, indices: npt.NDArray[np.int32], indptr: npt.NDArray[np.int32]
) -> sp.csr_array:
    """The matrix of blocks of 6 x 6, without the zeros in them."""
    size = 6 * (len(indptr) - 1)
    blocks = sp.bsr_array((values.reshape(-1, 6, 6), indices, indptr), shape=(size, size))
    matrix = blocks.tocsr()
    matrix.eliminate_zeros()
    return matrix


def _add(values: FloatArray, place: IntArray, matrices: FloatArray) -> None:
    """Add the blocks of 6 x 6 of element matrices to those of pairs of nodes."""
    n, nodes = place.shape[:2]
    blocks = matrices.reshape(n, nodes, 6, nodes, 6).swapaxes(2, 3)
    at = 36 * place[..., None] + np.arange(36)
    np.add.at(values, at.reshape(-1), blocks.reshape(-1))


def _pattern(
    n_nodes: int, groups: Sequence[IntArray]
) -> tuple[list[IntArray], npt.NDArray[np.int32], npt.NDArray[np.int32]]:
    """Return the place of each element's blocks among pairs of nodes, and the pairs by rows."""
    pairs = [cells[:, :, None] * n_nodes + cells[:, None, :] for cells in groups]
    key, place = np.unique(np.concatenate([each.ravel() for each in pairs]), return_inverse=True)
    parts = np.split(place, np.cumsum([each.size for each in pairs])[:-1])
    row, column = np.divmod(key, n_nodes)
    indptr = np.concatenate([[0], np.cumsum(np.bincount(row, minlength=n_nodes))])
    places = [part.reshape(each.shape) for part, each in zip(parts, pairs, strict=True)]
    return places, column.astype(np.int32), indptr.astype(np.int32)
