"""Stress at points of a body as a linear function of displacements and rotations.

Strains of solid and shell elements are extrapolated from the quadrature points to the nodes by a
least-squares fit of linear (bi-, trilinear) functions, and converted to stress there, for shells in
one layer. At each node the stress is averaged over the elements of one material, or over those of
one shell on one smooth surface. Stress of beams is not averaged, since it jumps at joints and
loads.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from ..base import (
    PRINTED,
    BoolArray,
    FloatArray,
    InputError,
    IntArray,
    finite_array,
    in_batches,
    record,
    sp,
    text,
    warn,
)
from ..mesh import AT_NODE, Mesh, group, parted
from .beams import Beam, BeamSection, beam_frames, beam_rows
from .composition import AnyMaterial, Piece, layout, pieces
from .laminate import Layers
from .material import PLACES, SIX, Solid
from .shells import Strains, nodal_normals, rigid_ends, strain_rows
from .stress import UNIT_STRAINS, batches, hooke, slopes_at_nodes

_OF_SHELLS = ("bottom", "middle", "top")
_SIDES = (*_OF_SHELLS, "left", "right")


@dataclass(frozen=True)
class Layer:
    """Position of stress within the sections of shells and beams; see `checked_layer`.

    Attributes
    ----------
    of : str, (int, str), (float, float) or None
        Side, ply and side, or point (y, z) in the section of beams.
    part : str or None
        Group of elements.
    """

    of: Any = None
    part: str | None = None

    @property
    def ply(self) -> bool:
        return isinstance(self.of, tuple) and isinstance(self.of[1], str)

    @property
    def place(self) -> bool:
        return isinstance(self.of, tuple) and not self.ply

    @property
    def of_beams(self) -> bool:
        """True for a side or point that only beams have."""
        return self.place or self.of in ("left", "right")

    def __str__(self) -> str:
        return f"layer={self.of!r}" + (f", part={self.part!r}" if self.part else "")


def checked_layer(layer: Any = None, part: Any = None) -> Layer:
    """Return the checked position of stress within sections.

    Parameters
    ----------
    layer : str, (int, str) or (float, float), optional
        "top", "middle" or "bottom"; or the index of a ply and one of these; for beams also "left",
        "right" or a point (y, z) in the section, m. By default the top of shells, and the point
        with the largest von Mises stress in the section of beams.
    part : str, optional
        Group of elements whose stress is taken.

    Raises
    ------
    InputError, InputTypeError
    """
    of: Any = layer
    if isinstance(layer, list | tuple) and len(layer) == 2 and not isinstance(layer[1], str):
        of = tuple(finite_array("layer", layer, shape=(2,), unit="m").tolist())
        sound = True
    elif isinstance(layer, list | tuple) and len(layer) == 2:
        ply, side = of = tuple(layer)
        whole = isinstance(ply, int | np.integer) and not isinstance(ply, bool)
        sound = whole and ply >= 0 and side in _OF_SHELLS
    else:
        sound = layer is None or (isinstance(layer, str) and layer in _SIDES)
    if not sound:
        raise InputError(
            'layer must be "top", "middle", "bottom", "left" or "right", a pair of the number of a '
            "ply, from 0 at the bottom, and one of the first three, or a place (y, z) in a beam's "
            f"section, m; got {layer!r}"
        )
    return Layer(of, None if part is None else text("part", part))


# Sections of the elements of one beam: index of the point of each section, (m,); axes x, y, z of
# the section as rows, (m, 3, 3); the beam.
_Sections = tuple[IntArray, FloatArray, Beam]


@record
class StressRows:
    """Matrix that gives stress, or strain, at points of a body from its dofs.

    Attributes
    ----------
    rows : scipy.sparse.csr_array, shape (6 n + 6 m, n_dofs)
        Rows for xx, yy, zz, xy, yz, xz at each of n points, Pa, followed by rows for the six
        generalised strains of m sections of beam elements.
    known : ndarray of bool, shape (n,)
        False for points without the requested layer or part.
    """

    rows: sp.csr_array
    known: BoolArray
    _sections: tuple[_Sections, ...] = ()
    _layer: Layer = Layer()
    _strain: bool = False

    def of_dofs(self, free: IntArray) -> StressRows:
        """Return the matrix restricted to the columns of the dofs `free`."""
        return replace(self, rows=self.rows[:, free])

    @property
    def linear(self) -> bool:
        """True if no point is on a beam: the maximum over a beam's section is not linear."""
        return not self._sections

    def components(self, values: FloatArray) -> FloatArray:
        """Return the tensors, (k, n, 6), of k motions; `values` = `rows` @ dofs, (6 n + 6 m, k)."""
        first = 6 * len(self.known)
        found = np.array(values[:first].T.reshape(-1, len(self.known), 6))
        found[:, ~self.known] = np.nan
        if not self._sections:
            return found
        places, layer = np.concatenate([place for place, _, _ in self._sections]), self._layer.of
        cuts = np.cumsum([len(place) for place, _, _ in self._sections])[:-1]
        strains = values[first:].T.reshape(len(found), -1, 6)
        for some in in_batches(len(found), 8.0 * 6.0 * len(places)):
            sizes, tensors = [], []
            each = zip(self._sections, np.split(strains[some], cuts, axis=1), strict=True)
            for (_, axes, beam), own in each:
                side: Any = beam.side(layer) if isinstance(layer, str) else layer
                stress = beam.stress(own, side)
                local = np.zeros((*stress.shape[:2], 6))
                local[..., [0, 3, 5]] = stress
                tensor = np.einsum("ncb,knb->knc", _turning(axes), local)
                if self._strain:
                    E, nu = beam.material.E, beam.material.nu
                    trace = tensor[..., :3].sum(axis=-1, keepdims=True)
                    tensor = ((1.0 + nu) * tensor - nu * trace * (np.arange(6) < 3)) / E
                sizes.append(stress**2 @ [1.0, 3.0, 3.0])  # von Mises' stress squared
                tensors.append(tensor)
            every = zip(found[some], np.hstack(sizes), np.hstack(tensors), strict=True)
            for at_places, size, at_sections in every:
                order = np.lexsort((size, places))
                at_places[places[order]] = at_sections[order]  # the largest, assigned last, remains
        return found


@record
class _Wanted:
    """Points at which stress is wanted, and the layer (position in sections) to evaluate there.

    Attributes
    ----------
    mesh, material, weights, layer, strain
        Arguments of `body_stress_rows`.
    """

    mesh: Mesh
    material: AnyMaterial
    weights: sp.csr_array
    layer: Layer
    strain: bool = False

    @cached_property
    def held(self) -> tuple[IntArray, IntArray]:
        """Pairs of an element in the layer's part and a point within it, as two index arrays."""
        mesh, part = self.mesh, self.layer.part
        near = sp.csr_array(self.weights, copy=True)
        near.data = (np.abs(near.data) > PRINTED).astype(np.float64)
        near.eliminate_zeros()
        cells = np.arange(mesh.n_cells) if part is None else group(mesh, "part", part)
        rows = np.repeat(cells, mesh.cells.shape[1])
        shape = (mesh.n_cells, near.shape[1])
        own = sp.csr_array((np.ones(len(rows)), (rows, mesh.cells[cells].ravel())), shape=shape)
        own.data[:] = 1.0
        shared = sp.csc_array(own @ near.T).tocoo()
        cell, place = shared.coords
        whole = shared.data == np.diff(near.indptr)[place]
        return cell[whole], place[whole]

    @cached_property
    def chosen(self) -> IntArray:
        """The shell or solid element whose stress is taken at each point, -1 if there is none.

        Among the elements that contain the point, one of the stiffest shell or, without shells, of
        the stiffest solid.
        """
        of_shell, stiffness = np.zeros((2, self.mesh.n_cells))
        for part in pieces(self.mesh, self.material, Layers | Solid):
            if self.has(part.of):
                stiffness[part.numbers] = np.trace(part.of.stiffness[:2, :2])
                of_shell[part.numbers] = isinstance(part.of, Layers)
        cell, place = self.held
        cell, place = cell[stiffness[cell] > 0.0], place[stiffness[cell] > 0.0]
        order = np.lexsort((cell, stiffness[cell], of_shell[cell], place))
        found = np.full(self.weights.shape[0], -1)
        found[place[order]] = cell[order]  # the stiffest, assigned last, remains
        return found

    def has(self, of: Solid | Layers | Beam) -> bool:
        """Return whether a section has the layer; beams without orientation have no sides."""
        layer = self.layer
        if isinstance(of, Solid):
            return not (layer.ply or layer.of_beams)
        if isinstance(of, Layers):
            return not layer.of_beams and not (layer.ply and layer.of[0] >= len(of.plies))
        if layer.ply or (layer.place and not of.holds(layer.of)):
            return False
        return layer.of in (None, "middle", (0.0, 0.0)) or of.orientation is not None


def body_stress_rows(
    mesh: Mesh,
    material: AnyMaterial,
    weights: sp.csr_array,
    layer: Layer = Layer(),
    *,
    strain: bool = False,
) -> StressRows:
    """Return the matrix that gives the stress at points of a body from all dofs of its nodes.

    Where elements of different kinds meet, shells take precedence over beams, and beams over
    solids, unless `layer.part` excludes them. Among shells, the stiffest is taken.

    Parameters
    ----------
    mesh : Mesh
    material : Material, Orthotropic, Shell, Laminate, Beam or Materials
    weights : scipy.sparse.csr_array, shape (n, n_nodes)
        Weights of the nodes that interpolate to each point, without added shape functions.
    layer : Layer, optional
        Position in the sections. With a ply's index, stress refers to the ply's axes, otherwise to
        the body's.
    strain : bool, optional
        If True, the matrix gives the strain tensor instead of stress.
    """
    if layer.part is not None and not mesh.thin:
        raise InputError(f"part={layer.part!r} is for bodies with shells or beams; leave it out")
    wanted = _Wanted(mesh, material, weights, layer if mesh.thin else Layer(), strain)
    thin = [part.of for part in pieces(mesh, material, Layers | Beam)]
    if thin and (layer.ply or layer.of_beams) and not any(map(wanted.has, thin)):
        raise InputError(
            f"{layer}: no shell or beam of the body has this layer. Plies count from 0 at the "
            "bottom; sides and points need beams with an orientation, points lie in the section"
        )
    known = wanted.chosen >= 0
    (cell, place), rows, sections = wanted.held, [_averaged(wanted)], list[_Sections]()
    shells = [part.numbers for part in pieces(mesh, material, Layers)]
    free = ~np.isin(wanted.chosen, np.concatenate([[-2], *shells]))
    cell, place = cell[free[place]], place[free[place]]
    for part in pieces(mesh, material, Beam):
        own = np.isin(cell, part.numbers)
        if not wanted.has(part.of) or not own.any():
            continue
        if isinstance(part.of.section, BeamSection) and len(part.of.section.points) == 1:
            warn("stress of a BeamSection without points leaves out bending; give its points=[...]")
        row = np.searchsorted(part.numbers, cell[own])
        ends = part.cells[row]
        share = np.asarray(weights[place[own], ends[:, 1]]).ravel()
        at_ends = beam_rows(mesh.nodes[part.cells], part.of, np.array([0.0, 1.0]))[row]
        strains = at_ends[:, 0] + share[:, None, None] * (at_ends[:, 1] - at_ends[:, 0])
        shape = (6 * len(row), 6 * mesh.n_nodes)
        rows.append(_by_dofs(np.arange(len(row)), ends, strains, shape))
        axes = beam_frames(mesh.nodes[part.cells], part.of)[0][row]
        sections.append((place[own], axes, part.of))
        known[place[own]] = True
    return StressRows(sp.csr_array(sp.vstack(rows)), known, tuple(sections), layer, strain)


def _averaged(wanted: _Wanted) -> sp.csr_array:
    """Return the matrix of the stress at points on shells and solids, (6 n, dofs).

    The stress is averaged over the elements of one smooth surface of a shell, or of one solid.
    """
    mesh, layer, strain, chosen = wanted.mesh, wanted.layer, wanted.strain, wanted.chosen
    known = chosen >= 0
    nodes = np.zeros(mesh.n_nodes, dtype=bool)
    nodes[mesh.cells[chosen[known]]] = True
    near, places = np.asarray(nodes[mesh.cells].any(axis=1)), layout(mesh, wanted.material)
    # A spot pairs a node with one smooth surface of one shell, or with one solid material.
    spots = np.full(mesh.cells.shape, -1)
    shells, of_shells = _shell_pieces(mesh, wanted.material, near)
    shells = [piece for piece in shells if wanted.has(piece[0].of)]
    for part, _, own in shells:
        spots[part.numbers, : own.shape[1]] = own
    solids = [of.taken(near[of.numbers]) for of in pieces(mesh, wanted.material)]
    solids = [of for of in solids if wanted.has(of.of)]
    for of in solids:
        spots[of.numbers, : of.element.own.n_nodes] = len(of_shells) + places.of(of)
    count = np.bincount(spots[spots >= 0], minlength=1)
    means = sp.csr_array((6 * len(count), (6 if mesh.thin else 3) * mesh.n_nodes))
    for part, strains, own in shells:
        by_strain, turn = _station(part.of, layer.of or "top", strain)
        cells, corners = np.nonzero(nodes[part.cells])
        to_corners = np.linalg.pinv(strains.shape)
        for some in in_batches(len(cells), strains.rows[0].nbytes):
            cell, corner = cells[some], corners[some]
            at = np.einsum("nq,nqsd->nsd", to_corners[corner], strains.rows[cell, :, :8])
            rows = np.einsum("sc,nsd->ncd", by_strain, at)
            frames = strains.frames[cell] if turn is None else turn[None].swapaxes(1, 2)
            rows = np.einsum("ncb,nbd->ncd", _turning(frames), rows)
            rows /= count[spot := own[cell, corner]][:, None, None]
            means += _by_dofs(spot, part.cells[cell], rows, means.shape)
    for of in solids:
        by_slope = UNIT_STRAINS if strain else hooke(UNIT_STRAINS, of.of)
        for batch in batches(of):
            cell, corner = np.nonzero(nodes[batch.cells[:, : of.element.own.n_nodes]])
            slopes = slopes_at_nodes(mesh, batch)[cell, corner]
            rows = np.einsum("cik,nai->ncak", by_slope, slopes).reshape(len(cell), 6, -1)
            rows /= count[spot := spots[batch.numbers[cell], corner]][:, None, None]
            means += _by_dofs(spot, batch.cells[cell], rows, means.shape)
    at = wanted.weights.tocoo()
    place, node = (each[known[at.coords[0]]] for each in at.coords)
    corner = (mesh.cells[chosen[place]] == node[:, None]).argmax(axis=1)
    shares = (at.data[known[at.coords[0]]], (place, spots[chosen[place], corner]))
    mixed = sp.csr_array(shares, shape=(len(known), len(count)))
    return sp.csr_array(sp.kron(mixed, np.eye(6)) @ means)


def _station(layers: Layers, layer: Any, strain: bool) -> tuple[FloatArray, FloatArray | None]:
    """Return the matrix, (8, 6), from generalised strains to stress or strain, and a ply's axes.

    The axes, shape (3, 3), are None unless `layer` names the ply by its index.
    """
    ply, side = (None, layer) if isinstance(layer, str) else layer
    z = layers.height(side, ply)
    if ply is None:
        ply = int(np.searchsorted(layers.interfaces[1:-1], z, side="right"))
    found = layers.stress_at(np.eye(8), ply, z)
    if strain:  # tensor components of shear are γ/2
        half = np.where(np.arange(6) < 3, 1.0, 0.5)
        found = found @ layers.plies[ply].compliance.T * half
    if isinstance(layer, str):
        return found, None
    angle = math.radians(layers.plies[ply].angle_deg)
    c, s = math.cos(angle), math.sin(angle)
    return found, np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])


def _turning(frames: FloatArray) -> FloatArray:
    """Return the matrices, (n, 6, 6), that turn σ into Fᵀ σ F; rows of F: the axes of σ."""
    unit = np.eye(6)[:, PLACES]
    found: FloatArray = np.einsum("nai,cab,nbj->ncij", frames, unit, frames)[..., *SIX]
    return found.swapaxes(1, 2)


def beam_von_mises(mesh: Mesh, material: AnyMaterial, moved: FloatArray) -> FloatArray:
    """Return the largest von Mises stress of each beam element, Pa, (k, n_cells); 0 elsewhere.

    Parameters
    ----------
    moved : ndarray, shape (k, 6 n_nodes)
        Displacements of all nodes, then rotations, for each of k times.
    """
    found = np.zeros((len(moved), mesh.n_cells))
    for part in pieces(mesh, material, Beam):
        rows = beam_rows(mesh.nodes[part.cells], part.of, np.array([0.0, 1.0]))
        for time, x in enumerate(moved):
            strains = np.einsum("nesd,nd->nes", rows, x[_dofs(part.cells, mesh.n_nodes)])
            size = np.sqrt(part.of.stress(strains) ** 2 @ [1.0, 3.0, 3.0])
            found[time, part.numbers] = size.max(axis=1)
    return found


def _by_dofs(
    place: IntArray, cells: IntArray, rows: FloatArray, shape: tuple[int, int]
) -> sp.csr_array:
    """Return the matrix over all dofs assembled from elements' `rows`, (n, 6, element dofs).

    Rows with the same index `place` are added.
    """
    i = np.broadcast_to((6 * place[:, None] + np.arange(6))[..., None], rows.shape)
    turns = rows.shape[2] > 3 * cells.shape[1]
    dofs = _dofs(cells, shape[1] // 6) if turns else (3 * cells[..., None] + np.arange(3))
    j = np.broadcast_to(dofs.reshape(len(cells), 1, -1), rows.shape)
    return sp.csr_array((rows.ravel(), (i.ravel(), j.ravel())), shape=shape)


def _dofs(cells: IntArray, n_nodes: int) -> IntArray:
    """Return dofs (u, v, w, θx, θy, θz) of each node of elements, shape (n, 6 nodes)."""
    moved = 3 * cells[:, :, None] + np.arange(3)
    both = np.concatenate([moved, moved + 3 * n_nodes], axis=2)
    return both.reshape(len(cells), 6 * cells.shape[1])


# The elements of one kind and one shell, their strain matrices, and for each corner the index of
# its pair of node and smooth surface, (n, nodes); indices are counted over all pieces.
_ShellPiece = tuple[Piece, Strains, IntArray]


def _shell_pieces(
    mesh: Any, material: Any, wanted: BoolArray
) -> tuple[list[_ShellPiece], IntArray]:
    """Return the pieces of a body's shells, and the node of each pair of node and smooth surface.

    Parameters
    ----------
    mesh, material
    wanted : ndarray of bool, shape (n_cells,)
        True for elements that are needed.
    """
    parts = pieces(mesh, material, Layers)
    if not parts:
        return [], np.zeros(0, dtype=np.int64)
    normals = nodal_normals(mesh.nodes, [part.cells for part in parts])
    joints = rigid_ends(mesh.nodes, [(part.cells, part.of) for part in parts])
    constant = len({part.cells.shape[1] for part in parts}) > 1
    number: dict[Any, int] = {}
    keys = [
        np.column_stack([of, np.full(of.shape, number.setdefault(part.of, len(number))), on])
        for part, normal in zip(parts, normals, strict=True)
        for of, on in [(part.cells.ravel(), np.rint(normal.reshape(-1, 3) / AT_NODE) + 0.0)]
    ]
    places, place = np.unique(np.concatenate(keys), axis=0, return_inverse=True)
    found, split = [], parted(place.reshape(-1), [part.cells for part in parts])
    for part, normal, (link, *_), own in zip(parts, normals, joints, split, strict=True):
        rows = wanted[part.numbers]
        some = part.taken(rows)
        if not len(some.rows):
            continue
        corners = mesh.nodes[some.cells]
        strains = strain_rows(corners, part.of, normal[rows], link[rows], constant=constant)
        found.append((some, strains, own[rows]))
    return found, places[:, 0].astype(np.int64)
