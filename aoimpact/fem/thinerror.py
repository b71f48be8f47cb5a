"""How wrong the strains of shells are, from their jumps between elements.

As for solids (`stresserror`): strains that are averaged at the nodes are better than those of the
elements, and the energy of the difference estimates the error. They are averaged over elements of
one shell on one smooth surface. Beams are exact between nodes that carry the loads, and lack what
they bend and shear under their own inertia (`beam_inertial_error`).
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ..base import ArrayPair, BoolArray, FloatArray, IntArray
from .beams import Beam, beam_inertial_error, beam_stiffness
from .composition import Piece, pieces
from .laminate import Layers
from .shells import Strains, nodal_normals, nodal_strains, rigid_ends, strain_rows
from .stress import UNIT_STRAINS

# Tensors of membrane strain, curvature and shear by each of the generalised strains, (8, 3, 3, 3).
_UNIT = np.zeros((8, 3, 3, 3))
_UNIT[:3, 0] = _UNIT[3:6, 1] = UNIT_STRAINS[[0, 1, 3]]
_UNIT[6:, 2] = UNIT_STRAINS[[5, 4]]

# Normals at a node that differ by less belong to one surface.
_ALIKE = 6


class ShellPiece(NamedTuple):
    """The elements of one kind of one shell, and the surfaces on which their corners lie.

    Attributes
    ----------
    part : Piece
    strains : Strains
    places : ndarray of int, shape (n, nodes)
        For each corner the number of its node on its smooth surface, through all pieces.
    """

    part: Piece
    strains: Strains
    places: IntArray


def shell_pieces(
    mesh: Any, material: Any, wanted: BoolArray | None = None
) -> tuple[list[ShellPiece], IntArray]:
    """Return the shells of a body by kind, and the node of each place.

    Parameters
    ----------
    mesh, material
    wanted : ndarray of bool, shape (n_cells,), optional
        The elements that are needed; all if left out.
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
        for of, on in [(part.cells.ravel(), normal.reshape(-1, 3).round(_ALIKE) + 0.0)]
    ]
    places, place = np.unique(np.concatenate(keys), axis=0, return_inverse=True)
    ends = np.cumsum([part.cells.size for part in parts])[:-1]
    found = []
    split = np.split(place.reshape(-1), ends)
    for part, normal, (link, *_), own in zip(parts, normals, joints, split, strict=True):
        rows = slice(None) if wanted is None else wanted[part.numbers]
        some = part.taken(rows)
        if not len(some.rows):
            continue
        corners = mesh.nodes[some.cells]
        strains = strain_rows(corners, part.of, normal[rows], link[rows], constant=constant)
        at = own.reshape(part.cells.shape)[rows]
        found.append(ShellPiece(some, strains, at))
    return found, places[:, 0].astype(np.int64)


def thin_energy_error(mesh: Any, material: Any, moved: FloatArray, s: float) -> ArrayPair:
    """Return twice the strain energy of averaged strain less the elements' own, and of their own.

    For beams the first is twice the energy that they lack.

    Parameters
    ----------
    mesh, material
        A body of shells and beams.
    moved : ndarray, shape (n_nodes, 6)
        Displacements and rotations at the frequency i s.
    s : float
        rad/s.

    Returns
    -------
    difference, own : ndarray, shape (n_cells,)
        Energy of each element, J; 0 of solids.
    """
    difference, own = np.zeros((2, mesh.n_cells))
    for part in pieces(mesh, material, Beam):
        stiffness = beam_stiffness(mesh.nodes[part.cells], part.of)
        x = moved[part.cells].reshape(len(part.cells), -1)
        own[part.numbers] = np.einsum("ni,nij,nj->n", x, stiffness, x)
        difference[part.numbers] = beam_inertial_error(mesh.nodes[part.cells], part.of, x, s)
    shells, places = shell_pieces(mesh, material)
    total, elements = np.zeros((len(places), 3, 3, 3)), np.zeros(len(places))
    for piece in shells:
        frames, corners = (
            piece.strains.frames,
            nodal_strains(piece.strains, moved[piece.part.cells]),
        )
        local = np.einsum("ncs,stab->nctab", corners, _UNIT)
        tensors = np.einsum("nai,nctab,nbj->nctij", frames, local, frames, optimize=True)
        np.add.at(total, piece.places, tensors)  # in global axes, as the mean at a node is
        elements += np.bincount(piece.places.ravel(), minlength=len(places))
    total /= elements[:, None, None, None]
    for piece in shells:
        frames, tensors = piece.strains.frames, total[piece.places]
        local = np.einsum("nai,nctij,nbj->nctab", frames, tensors, frames, optimize=True)
        mean = np.einsum("nctab,stab->ncs", local, (_UNIT > 0.0).astype(np.float64))
        x = moved[piece.part.cells].reshape(len(mean), -1)
        strain = np.einsum("nqsd,nd->nqs", piece.strains.rows[:, :, :8], x)
        off = strain - np.einsum("qa,nas->nqs", piece.strains.shape, mean)
        for values, found in ((strain, own), (off, difference)):
            energy = np.einsum("nqi,ij,nqj->nq", values, piece.part.of.stiffness, values)
            found[piece.part.numbers] = (piece.strains.weights * energy).sum(axis=1)
    return difference, own
