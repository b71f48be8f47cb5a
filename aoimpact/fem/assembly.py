"""Stiffness and consistent mass of a mesh of solid, shell and beam elements.

Both matrices consist of one block per pair of nodes that share an element. The position of each
block of each element matrix is found once; then the blocks are summed in place, without duplicate
entries.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import Any

import numpy as np
import numpy.typing as npt

from ..base import FloatArray, IntArray, at_once, bar, in_batches, require, sp
from ..linalg import ENTRIES_AT_ONCE, with_int32
from ..mesh import Mesh, ReferenceElement, cofactors, jacobians, parted
from .beams import Beam, beam_matrices
from .composition import AnyMaterial, Piece, pieces
from .laminate import Layers
from .material import Material
from .shells import element_mass, element_stiffness, nodal_normals, rigid_ends

# Memory for each pair of dofs whose nodes share an element, bytes: K and M as dense blocks (8 each)
# and as CSR entries with column indices (12 each).
_BYTES_PER_DOFS = 40.0

# Components (i, j) of the blocks K_ij in the upper triangle; K_ji is the transpose.
_PAIRS = ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2))


# Sparsity pattern of nodes that share an element: its CSR arrays indptr and indices, and for each
# block of elements of one kind the position of each entry of the element matrices in the pattern,
# shape (n_elements, n_local, n_local).
_Pattern = tuple[npt.NDArray[np.int32], npt.NDArray[np.int32], list[IntArray]]


def stiffness_mass(mesh: Mesh, material: AnyMaterial) -> tuple[sp.csr_array, sp.csr_array]:
    """Return the stiffness K and the consistent mass M; the dofs are 3·node + component.

    With shells or beams, rotations 3·n_nodes + 3·node + component follow. The rows of the rotations
    of nodes of solid elements only are empty.

    Parameters
    ----------
    mesh : Mesh
    material : Material, Orthotropic, Shell, Laminate, Beam or Materials

    Returns
    -------
    K, M : scipy.sparse.csr_array, shape (3 n_nodes, 3 n_nodes) or (6 n_nodes, 6 n_nodes)
        Stiffness, N/m (with rotations N and N m), and mass, kg (with rotations kg m and kg m²).
        Exactly symmetric, column indices sorted.
    """
    parts = pieces(mesh, material, (Layers, Beam))
    if not parts:
        return _of_solids(mesh, material)
    dofs = np.arange(3 * mesh.n_nodes).reshape(-1, 3)
    order = np.argsort(np.hstack([dofs, dofs + 3 * mesh.n_nodes]).ravel())
    found = thin_stiffness_mass(mesh.nodes, [(part.cells, part.of) for part in parts])
    K, M = (matrix[order][:, order] for matrix in found)
    if (solids := mesh.of_elements(thin=False)).blocks:
        for of in (own := _of_solids(solids, material)):
            of.resize(K.shape)
        K, M = K + own[0], M + own[1]
    return with_int32(K.sorted_indices()), with_int32(M.sorted_indices())


def thin_stiffness_mass(
    nodes: FloatArray, parts: Sequence[tuple[IntArray, Layers | Beam]]
) -> list[sp.csr_array]:
    """Return K and M of shells and beams over the dofs 6·node + (u, v, w, θx, θy, θz).

    Rotations are right-handed.

    Parameters
    ----------
    nodes : ndarray, shape (n_nodes, 3)
        Coordinates, m.
    parts : sequence of (ndarray of int, Shell, Laminate or Beam)
        Nodes of the elements, shape (n, 2), (n, 3) or (n, 4), and their section.

    Returns
    -------
    list of two scipy.sparse.csr_array, shape (6 n_nodes, 6 n_nodes)
        K in N/m, N and N m; M in kg, kg m and kg m². Exactly symmetric, column indices sorted. M
        has zero rows for rotations about the normal of a flat shell.
    """
    surfaces = [(cells, part) for cells, part in parts if not isinstance(part, Beam)]
    joints = rigid_ends(nodes, surfaces) if surfaces else []
    normals = nodal_normals(nodes, [cells for cells, _ in surfaces]) if surfaces else []
    constant = len({cells.shape[1] for cells, _ in surfaces}) > 1
    strips = [strip for _, strip, _ in joints]
    indptr, indices, places = _pattern([*(of for of, _ in parts), *strips], len(nodes), 6)
    K, M = np.zeros((2, len(indices), 6, 6))

    def add(values: FloatArray, place: Any, matrices: FloatArray) -> None:
        blocks = matrices.reshape(*place.shape[:2], 6, -1, 6).swapaxes(2, 3)
        at = 36 * place[..., None] + np.arange(36)
        np.add.at(values.reshape(-1), at.reshape(-1), blocks.reshape(-1))

    shells = iter(zip(normals, joints, places[len(parts) :], strict=True))
    for (cells, part), place in zip(parts, places, strict=False):
        if isinstance(part, Beam):
            for values, matrices in zip((K, M), beam_matrices(nodes[cells], part), strict=True):
                add(values, place, matrices)
            continue
        normal, (ends, strip, links), there = next(shells)
        for some in in_batches(len(cells), 8.0 * (6 * cells.shape[1]) ** 2):
            at, more = nodes[cells[some]], (normal[some], ends[some])
            add(K, place[some], element_stiffness(at, part, *more, constant=constant))
            add(M, place[some], element_mass(at, part))
        if len(strip):
            add(K, there, element_stiffness(nodes[strip], part, ends=links))
    found, n = [], 6 * len(nodes)
    for of in (K, M):
        found.append(sp.bsr_array((of, indices, indptr), shape=(n, n)).tocsr())
        found[-1].eliminate_zeros()
    return found


def _of_solids(mesh: Mesh, material: AnyMaterial) -> tuple[sp.csr_array, sp.csr_array]:
    """Return K and M of the solid elements.

    Full integration is exact for M, and for K if elements have straight sides and a constant
    Jacobian. The blocks of K are K_ij = ∫ λ ∂iφ ∂jφᵀ + μ ∂jφ ∂iφᵀ + δij μ ∇φ·∇φᵀ dV for isotropic
    materials, otherwise K_ij = ∫ C_ikjl ∂kφ ∂lφᵀ dV.
    """
    indptr, indices, places = _pattern([of.cells for of in mesh.blocks], mesh.n_nodes, 3)
    stiffness, mass = np.zeros((len(indices), 3, 3)), np.zeros(len(indices))
    with bar("assembly", mesh.n_cells, unit="element") as progress:

        def add_stiffness() -> None:
            for batch, place in _batches(mesh, material, places):
                blocks = _stiffness(batch, mesh.nodes[batch.cells])
                at, whole = 9 * place.reshape(-1), stiffness.reshape(-1)
                for (i, j), block in zip(_PAIRS, blocks, strict=True):
                    np.add.at(whole, at + 3 * i + j, block.reshape(-1))
                    if i != j:  # K_ji is the transpose
                        np.add.at(whole, at + 3 * j + i, block.transpose(0, 2, 1).reshape(-1))
                progress.update(len(place))

        def add_mass() -> None:
            for batch, place in _batches(mesh, material, places):
                values = batch.of.rho * _mass(batch.element, mesh.nodes[batch.cells])
                values = batch.signed(batch.signed(values).swapaxes(1, 2))
                np.add.at(mass, place.reshape(-1), values.reshape(-1))

        at_once([add_stiffness, add_mass])
    n, pairs = mesh.n_nodes, (indices, indptr)
    K = sp.bsr_array((stiffness, *pairs), shape=(3 * n, 3 * n)).tocsr()
    # M has the same row for each of the three components of a node.
    rows = np.arange(3 * n, dtype=np.int32)
    M = sp.csr_array((mass, *pairs), shape=(n, n))[rows // 3]
    M = sp.csr_array(
        (M.data, 3 * M.indices + np.repeat(rows % 3, np.diff(M.indptr)), M.indptr), shape=K.shape
    )
    return with_int32(K), with_int32(M)


def _batches(mesh: Mesh, material: AnyMaterial, places: Any) -> Iterator[tuple[Piece, Any]]:
    """Yield batches of elements of one kind and material, and the part of `places` for each."""
    for piece in pieces(mesh, material):
        place, of = places[mesh.blocks.index(piece.block)], piece.element
        n_points = max(len(of.stiffness_rule.weights), len(of.mass_rule.weights))
        for batch in piece.batches(8.0 * max((3 * of.n_nodes) ** 2, 9 * n_points)):
            yield batch, place[batch.rows]


def _stiffness(piece: Piece, nodes: FloatArray) -> Iterator[FloatArray]:
    """Yield the blocks K_ij of the element stiffness, (n_elements, n_local, n_local)."""
    n, n_local = nodes.shape[:2]
    element, material = piece.element, piece.of
    rule = element.stiffness_rule
    gradient = element.gradient(rule.points)
    det, cof = cofactors(jacobians(nodes, gradient))
    cof *= np.sqrt(rule.weights / det)
    slopes = np.empty((n, 3, n_local, len(rule.weights)))
    for i in range(3):
        slopes[:, i] = sum(
            gradient[:, :, alpha].T * cof[i, alpha][:, None, :] for alpha in range(3)
        )
    slopes = piece.signed(slopes.swapaxes(1, 2)).swapaxes(1, 2)
    rows = slopes.reshape(n, 3 * n_local, -1)
    products = (rows @ rows.transpose(0, 2, 1)).reshape(n, 3, n_local, 3, n_local)
    for i, j in _PAIRS:
        if isinstance(material, Material):
            (lam, mu), product = material.lame, products[:, i, :, j]
            block = lam * product + mu * product.transpose(0, 2, 1)
            if i == j:
                block += mu * (products[:, 0, :, 0] + products[:, 1, :, 1] + products[:, 2, :, 2])
        else:
            block = np.einsum("nkalb,kl->nab", products, material.tensor[i, :, j, :])
        if i == j:
            block = 0.5 * (block + block.transpose(0, 2, 1))
        yield block


def _mass(element: ReferenceElement, nodes: FloatArray) -> FloatArray:
    """Return ∫ φ φᵀ dV of each element, shape (n_elements, n_local, n_local)."""
    rule = element.mass_rule
    det, _ = cofactors(jacobians(nodes, element.gradient(rule.points)))
    shape = element.shape(rule.points)
    row, column = np.triu_indices(element.n_nodes)
    products = rule.weights[:, None] * shape[:, row] * shape[:, column]
    upper = np.einsum("eq,qp->ep", det, products)  # unlike BLAS, reproducible to the last bit
    full = np.empty((len(nodes), element.n_nodes, element.n_nodes))
    full[:, row, column] = upper
    full[:, column, row] = upper
    return full


def _pattern(groups: Sequence[IntArray], n_nodes: int, dofs: int) -> _Pattern:
    """Return the sparsity pattern of the nodes of all elements; see `_Pattern`."""
    pairs = [cells[:, :, None] * n_nodes + cells[:, None, :] for cells in groups]
    key, place = np.unique(np.concatenate([of.ravel() for of in pairs]), return_inverse=True)
    row, column = np.divmod(key, n_nodes)
    indptr = np.append(0, np.cumsum(np.bincount(row, minlength=n_nodes)))
    what = f"stiffness and mass of {n_nodes} nodes"
    require(_BYTES_PER_DOFS * dofs**2 * len(key), what, "coarsen the mesh away from the contact")
    return indptr.astype(np.int32), column.astype(np.int32), parted(place, pairs)


def kept_rows_columns(matrix: Any, kept: IntArray) -> sp.csr_array:
    """Return a CSR matrix reduced to the rows and columns `kept`, ascending; overwrite its arrays.

    For a plate of 224 000 dofs this takes 0.5 s. A copy takes 2.3 s, mostly to allocate memory.
    """
    place, end = np.full(matrix.shape[0], -1, dtype=matrix.indices.dtype), 0
    place[kept] = np.arange(len(kept))
    lengths, indptr = np.zeros_like(matrix.indptr), np.zeros(len(kept) + 1, matrix.indptr.dtype)
    cuts = np.linspace(0, len(place), 2 + matrix.nnz // ENTRIES_AT_ONCE, dtype=int).tolist()
    for first, last in pairwise(cuts):
        starts = matrix.indptr[first : last + 1]
        some = slice(starts[0], starts[-1])
        columns = place[matrix.indices[some]]
        inside = (columns >= 0) & np.repeat(place[first:last] >= 0, np.diff(starts))
        before = np.concatenate([[0], np.cumsum(inside)])
        lengths[first:last] = np.diff(before[starts - starts[0]])
        to = slice(end, end := end + int(before[-1]))
        matrix.indices[to], matrix.data[to] = columns[inside], matrix.data[some][inside]
    np.cumsum(lengths[kept], out=indptr[1:])
    parts = matrix.data[:end], matrix.indices[:end], indptr
    return with_int32(sp.csr_array(parts, shape=(len(kept), len(kept))))
