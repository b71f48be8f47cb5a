"""How wrong the stress of a displacement field is, from its jumps between elements.

Stress that is averaged at the nodes and interpolated between them is better than that of the
elements; the energy of their difference estimates that of the field's error (O. C. Zienkiewicz and
J. Z. Zhu, Int. J. Num. Meth. Eng. 24, 337, 1987). By Galerkin's orthogonality the energy of the
error of x = (K + s²M)⁻¹ b is what the compliance bᵀx lacks.

In elements that lock most of the strain is spurious. The missing energy then exceeds the energy
present, which that difference cannot show. But the average keeps the true part, a share ϑ of their
energy. Elements L times too stiff move 1/L as far under a given load, so that ϑ = 1/L, and the
compliance lacks L - 1 times their energy: (1 - ϑ)/ϑ of it, in place of 1 - ϑ (`missing_energy`).

On free surfaces the average is least accurate, but the traction is known to be zero there. It is
removed from the average, P σ P with P = I - n nᵀ. So the estimate includes the false stress across
a plate of one layer of linear elements, which is the same in all of them. Where materials meet, the
exact stress jumps: each material has an average of its own there.
"""

from __future__ import annotations

import numpy as np

from ..base import ArrayPair, BoolArray, FloatArray
from .composition import Layout, OneMaterial, each_of, layout, pieces
from .material import PLACES, SIX, Solid
from .model import FEModel
from .stress import (
    ANGLE,
    averaged_strain,
    batches,
    gauss_strain,
    hooke,
)
from .supports import constrained
from .thinerror import thin_energy_error

# No share of the energy is taken to be less true than this.
_LEAST_TRUE = 0.1


def missing_energy(difference: FloatArray, own: FloatArray) -> float:
    """Return twice the strain energy that some elements lack, J, from `energy_error` of them."""
    false, whole = float(difference.sum()), float(own.sum())
    return false / max(1.0 - false / whole, _LEAST_TRUE) if whole > 0.0 else 0.0


def energy_error(body: FEModel, field: FloatArray, loaded: BoolArray, s: float = 0.0) -> ArrayPair:
    """Return twice the strain energy of averaged strain less the elements' own, and of their own.

    Parameters
    ----------
    body : FEModel
        Made from a mesh.
    field : ndarray, shape ([1 or 2,] n_nodes, 3)
        Displacement, m, and rotation of shells and beams.
    loaded : ndarray of bool, shape (n_nodes,)
        Nodes that may carry traction, beside those of supports, added masses and springs.
    s : float, optional
        rad/s; the field moves at the frequency i s, or s.

    Returns
    -------
    difference, own : ndarray, shape (n_cells,)
        Of each element, J.
    """
    mesh, material, field = body.mesh, body.material, field.reshape(-1, len(loaded), 3)
    assert mesh is not None
    assert material is not None
    difference, own = np.zeros((2, mesh.n_cells))
    if mesh.thin:
        difference, own = thin_energy_error(mesh, material, np.hstack(list(field)), s)
        loaded = loaded | np.isin(np.arange(len(loaded)), mesh.thin_nodes)
    solids = pieces(mesh, material)
    if not solids:
        return difference, own
    places = layout(mesh, material)
    averaged = averaged_strain(mesh, material, places, field[0])
    _free_of_traction(averaged, body, places, loaded)
    for piece in solids:
        rule, of = piece.element.stiffness_rule, piece.of
        shape = piece.element.shape(rule.points)
        for batch in batches(piece):
            strain, det = gauss_strain(mesh, batch, field[0])
            own[batch.numbers] = (det * _energy(strain, of)) @ rule.weights
            strain -= averaged[:, places.of(batch)] @ shape.T
            difference[batch.numbers] = (det * _energy(strain, of)) @ rule.weights
    return difference, own


def _energy(strain: FloatArray, material: OneMaterial) -> FloatArray:
    """Twice the energy of a volume, J/m³, of strain of shape (6, ...)."""
    direct, shear = np.split(strain * hooke(strain, material), 2)
    return np.asarray(direct.sum(axis=0) + 2.0 * shear.sum(axis=0))


def _free_of_traction(strain: FloatArray, body: FEModel, places: Layout, loaded: BoolArray) -> None:
    """Take the traction out of the strain at places on free surfaces, shape (6, n_places)."""
    surface, material = body.surface, body.material
    assert surface is not None
    assert material is not None
    assert body.free is not None
    kept = loaded | constrained(body.free, len(loaded)).any(axis=1)
    if body.springs is not None:
        kept[body.free[np.flatnonzero(body.springs)] // 3 % len(loaded)] = True
    if body.masses is not None:
        kept[np.flatnonzero(body.masses.diagonal()) // 3 % len(loaded)] = True
    kept = kept[places.node]
    count = len(places.node)
    normals = surface.node_normals
    if count > len(loaded):
        normals = surface.normals_at(places.cells, count)
    for number, of in enumerate(each_of(material)):
        if not isinstance(of, Solid):
            continue
        free = np.flatnonzero(normals[0].any(axis=1) & ~kept & (places.which == number))
        stress = hooke(strain[:, free], of).T[:, PLACES]
        for normal in normals[:, free]:
            across = np.eye(3) - normal[:, :, None] * normal[:, None, :]
            stress = across @ stress @ across
        strain[:, free] = np.linalg.solve(of.stiffness * ANGLE, stress[:, *SIX].T)
