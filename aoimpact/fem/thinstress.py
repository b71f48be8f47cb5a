"""Stress of shells and beams at their nodes, as a linear function of displacements and rotations.

The strains of an element are carried from its points of quadrature to its corners by the (bi)linear
function that fits them best, and become the stresses of a layer there. At a node these are averaged
over the elements of one shell on one smooth surface; where shells meet, over those of the stiffest.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np
import numpy.typing as npt
import scipy.sparse as sp

from ..base import FloatArray, InputError, IntArray
from ..mesh import Mesh, taken
from .beams import Beam, beam_frames, beam_rows
from .composition import AnyMaterial, Materials, pieces, thin_parts
from .laminate import Layers
from .material import PAIRS
from .stress import compliances, stress_rows
from .thinerror import shell_pieces

__all__ = ["Layer", "body_stress_rows", "checked_layer", "corner_stress"]

Layer = str | tuple[int, str]

_SIDES = ("bottom", "middle", "top")

# Elements are taken so many at a time.
_BATCH = 4096


def checked_layer(name: str, layer: Any) -> Layer:
    """Return "top", "middle" or "bottom", or the number of a ply and one of these.

    Raises
    ------
    InputError
    """
    pair = isinstance(layer, (tuple, list)) and len(layer) == 2
    ply, side = layer if pair else (0, layer)
    known = isinstance(side, str) and side in _SIDES
    if not known or not isinstance(ply, (int, np.integer)) or isinstance(ply, bool) or ply < 0:
        raise InputError(
            f'{name} must be "top", "middle" or "bottom", or a pair of the number of a ply, from 0 '
            f"at the bottom, and one of these; got {layer!r}"
        )
    return (int(ply), str(side)) if pair else str(side)


def body_stress_rows(
    mesh: Mesh,
    material: AnyMaterial,
    nodes: IntArray,
    layer: Layer = "top",
    *,
    strain: bool = False,
) -> tuple[sp.csr_array, npt.NDArray[np.bool_]]:
    """Return the stress at some nodes as a linear function of a body's dofs, and where it is known.

    Parameters
    ----------
    mesh : Mesh
    material : Material, Orthotropic, Shell, Laminate, Beam or Materials
    nodes : ndarray of int
        Each once.
    layer : str or (int, str), optional
        Of shells and beams; see `checked_layer`. By a ply's number stress is along the ply's axes,
        else in the body's.

    Returns
    -------
    rows : scipy.sparse.csr_array, shape (6 len(nodes), 3 n_nodes) or (6 len(nodes), 6 n_nodes)
        xx, yy, zz, xy, yz, xz at each node in turn, Pa, or with `strain` the tensor of strain.
    known : ndarray of bool, shape (len(nodes),)
        False where no shell has the ply.
    """
    if not mesh.thin:
        return stress_rows(mesh, material, nodes), np.ones(len(nodes), dtype=bool)
    most = max(
        (len(p.of.plies) for p in thin_parts(mesh, material) if isinstance(p.of, Layers)), default=0
    )
    if not isinstance(layer, str) and layer[0] >= most:
        raise InputError(f"layer: there is no ply {layer[0]}, the last is {most - 1}")
    n, row = mesh.n_nodes, np.full(mesh.n_nodes, -1)
    row[nodes] = np.arange(len(nodes))
    total = sp.csr_array((6 * len(nodes), 6 * n))
    covered = np.zeros(n, dtype=bool)
    for found in (_of_shells, _of_beams, _of_solids):
        left = np.where(covered, -1, row)
        if (left >= 0).any():
            at, rows = found(mesh, material, left, layer, strain)
            rows.resize(total.shape)
            total = total + rows
            covered[at] = True
    return sp.csr_array(total), covered[nodes]


def corner_stress(
    mesh: Mesh, material: AnyMaterial, node: int, layer: Layer, moved: FloatArray
) -> FloatArray:
    """Return the stress of each shell element at a node, (n, 6), for displacements and rotations.

    Parameters
    ----------
    moved : ndarray, shape (n_nodes, 6)
    """
    wanted = np.full(mesh.n_nodes, -1)
    wanted[node] = 0
    values = [
        np.einsum("ncd,nd->nc", rows, moved[cells].reshape(len(cells), -1))
        for _, cells, _, rows in _corners(mesh, material, wanted, layer)[0]
    ]
    return np.concatenate([np.zeros((0, 6)), *values])


def _of_shells(
    mesh: Mesh, material: AnyMaterial, row: IntArray, layer: Layer, strain: bool
) -> tuple[IntArray, sp.csr_array]:
    found, place_node, stiffness = _corners(mesh, material, row, layer, strain)
    if not found:
        return np.zeros(0, dtype=np.int64), sp.csr_array((6 * (row.max() + 1), 6 * mesh.n_nodes))
    # For each node the place of the stiffest shell.
    places = np.concatenate([place for place, *_ in found])
    used = np.unique(places)
    order = used[np.lexsort((stiffness[used], place_node[used]))]
    last = order[np.append(np.diff(place_node[order]) > 0, True)]
    count = np.bincount(places, minlength=len(place_node))
    shown = np.zeros(len(place_node), dtype=bool)
    shown[last] = True
    i, j, values = [], [], []
    for place, cells, _, rows in found:
        on = shown[place]
        size = 6 * cells.shape[1]
        scaled = rows[on] / count[place[on]][:, None, None]
        i.append(np.repeat(6 * row[place_node[place[on]]][:, None] + np.arange(6), size).ravel())
        dofs = _dofs(cells[on], mesh.n_nodes)
        j.append(np.broadcast_to(dofs[:, None], scaled.shape).ravel())
        values.append(scaled.ravel())
    shape = (6 * (row.max() + 1), 6 * mesh.n_nodes)
    matrix = sp.csr_array(
        (np.concatenate(values), (np.concatenate(i), np.concatenate(j))), shape=shape
    )
    return place_node[last], matrix


def _corners(
    mesh: Mesh, material: AnyMaterial, row: IntArray, layer: Layer, strain: bool = False
) -> tuple[list[tuple[IntArray, IntArray, IntArray, FloatArray]], IntArray, FloatArray]:
    """For corners at wanted nodes: their places, elements' nodes, corners and stress rows.

    Also the node of each place and the stiffness of its shell.
    """
    wanted_cells = np.zeros(mesh.n_cells, dtype=bool)
    for part in thin_parts(mesh, material):
        wanted_cells[part.numbers] = (row[part.cells] >= 0).any(axis=1)
    shells, place_node = shell_pieces(mesh, material, wanted_cells)
    stiffness, found = np.zeros(len(place_node)), []
    for piece in shells:
        stiffness[piece.places] = piece.layers.stiffness[0, 0] + piece.layers.stiffness[1, 1]
        if not len(piece.part.cells) or not (
            isinstance(layer, str) or layer[0] < len(piece.layers.plies)
        ):
            continue
        by_strain, turn = _station(piece.layers, layer, strain)
        cell, corner = np.nonzero(row[piece.part.cells] >= 0)
        to_corners = np.linalg.pinv(piece.strains.shape)
        for some in _batches(len(cell)):
            own = piece.strains.rows[cell[some], :, :8]
            at = np.einsum("nq,nqsd->nsd", to_corners[corner[some]], own)
            stress = np.einsum("sc,nsd->ncd", by_strain, at)
            frames = piece.strains.frames[cell[some]] if turn is None else turn[None].swapaxes(1, 2)
            stress = np.einsum("ncb,nbd->ncd", _turning(frames), stress)
            cells = piece.part.cells[cell[some]]
            found.append((piece.places[cell[some], corner[some]], cells, corner[some], stress))
    return found, place_node, stiffness


def _station(layers: Layers, layer: Layer, strain: bool) -> tuple[FloatArray, FloatArray | None]:
    """Stress or strain of unit generalised strains, (8, 6), and axes of a ply given by number."""
    if isinstance(layer, str):
        ends = layers.interfaces
        middle = 0.5 * float(ends[0] + ends[-1])
        inside = int(np.searchsorted(ends[1:-1], middle, side="right"))
        ply, z = {
            "bottom": (0, float(ends[0])),
            "middle": (inside, middle),
            "top": (len(layers.plies) - 1, float(ends[-1])),
        }[layer]
    else:
        ply, side = layer
        low, high = layers.interfaces[ply : ply + 2].tolist()
        z = {"bottom": low, "middle": 0.5 * (low + high), "top": high}[side]
    found = layers.stress_at(np.eye(8), ply, z)
    if strain:  # shears of the tensor are half of γ
        half = np.where(np.arange(6) < 3, 1.0, 0.5)
        found = found @ layers.plies[ply].compliance.T * half
    if isinstance(layer, str):
        return found, None
    angle = math.radians(layers.plies[ply].angle_deg)
    c, s = math.cos(angle), math.sin(angle)
    return found, np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])


def _turning(frames: FloatArray) -> FloatArray:
    """Components Fᵀ σ F by those of σ, (n, 6, 6), with the rows of F the axes of σ."""
    found = np.empty((len(frames), 6, 6))
    for column, (a, b) in enumerate(PAIRS):
        unit = frames[:, a, :, None] * frames[:, b, None, :]
        unit = unit if a == b else unit + unit.swapaxes(1, 2)
        for component, (i, j) in enumerate(PAIRS):
            found[:, component, column] = unit[:, i, j]
    return found


def _of_beams(
    mesh: Mesh, material: AnyMaterial, row: IntArray, layer: Layer, strain: bool
) -> tuple[IntArray, sp.csr_array]:
    """Direct stress at the side of the section along ±z, or in its middle."""
    shape = (6 * (row.max() + 1), 6 * mesh.n_nodes)
    total, count = sp.csr_array(shape), np.zeros(mesh.n_nodes)
    for part in thin_parts(mesh, material):
        if not isinstance(part.of, Beam) or not isinstance(layer, str):
            continue
        cell, corner = np.nonzero(row[part.cells] >= 0)
        ends = mesh.nodes[part.cells]
        z = np.array(part.of.numbers.points)[:, 1]
        height = {"bottom": z.min(), "middle": 0.0, "top": z.max()}[str(layer)]
        bent = beam_rows(ends, part.of, np.array([0.0, 1.0]))[cell, corner]
        direct = part.of.material.E * (bent[:, 0] + height * bent[:, 1])
        axis = beam_frames(ends, part.of)[0][cell, 0]
        tensor = np.stack([axis[:, i] * axis[:, j] for i, j in PAIRS], axis=1)
        if strain:
            E, nu = part.of.material.E, part.of.material.nu
            tensor = ((1.0 + nu) * tensor - nu * (np.arange(6) < 3)) / E
        values = tensor[:, :, None] * direct[:, None, :]
        node = part.cells[cell, corner]
        i = np.repeat(6 * row[node][:, None] + np.arange(6), 12)
        j = np.broadcast_to(_dofs(part.cells[cell], mesh.n_nodes)[:, None], values.shape)
        total = total + sp.csr_array((values.ravel(), (i.ravel(), j.ravel())), shape=shape)
        count += np.bincount(node, minlength=mesh.n_nodes)
    wanted = np.flatnonzero(row >= 0)
    share = np.zeros(shape[0] // 6)
    share[row[wanted]] = 1.0 / np.maximum(count[wanted], 1.0)
    return np.flatnonzero(count), sp.csr_array(sp.diags_array(np.repeat(share, 6)) @ total)


def _of_solids(
    mesh: Mesh, material: AnyMaterial, row: IntArray, layer: Layer, strain: bool
) -> tuple[IntArray, sp.csr_array]:
    shape = (6 * (row.max() + 1), 6 * mesh.n_nodes)
    solids = list(pieces(mesh, material))
    none = np.zeros(0, dtype=np.int64)
    if not solids:
        return none, sp.csr_array(shape)
    assert isinstance(material, Materials)
    cells = np.sort(np.concatenate([piece.numbers for piece in solids]))
    own = np.unique(np.concatenate([piece.cells.ravel() for piece in solids]))
    wanted = own[row[own] >= 0]
    if not len(wanted):
        return none, sp.csr_array(shape)
    sub, of, at = taken(mesh, cells), material.taken(cells), np.searchsorted(own, wanted)
    rows = stress_rows(sub, of, at)
    if strain:
        rows = sp.csr_array(sp.block_diag(list(compliances(sub, of, at)), format="csr") @ rows)
    found = rows.tocoo()
    i = 6 * row[wanted][found.row // 6] + found.row % 6
    j = 3 * own[found.col // 3] + found.col % 3
    return wanted, sp.csr_array((found.data, (i, j)), shape=shape)


def _dofs(cells: IntArray, n_nodes: int) -> IntArray:
    """Dofs of (u, v, w, θx, θy, θz) of elements' nodes in turn, (n, 6 nodes)."""
    moved = 3 * cells[:, :, None] + np.arange(3)
    both = np.concatenate([moved, moved + 3 * n_nodes], axis=2)
    return both.reshape(len(cells), 6 * cells.shape[1])


def _batches(count: int) -> Iterator[slice]:
    for start in range(0, count, _BATCH):
        yield slice(start, start + _BATCH)
