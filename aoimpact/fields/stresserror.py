"""How wrong the stress of a displacement field is, from its jumps between elements.

Stress that is averaged at the nodes and interpolated between them is better than that of the
elements; the energy of their difference estimates that of the field's error (O. C. Zienkiewicz and
J. Z. Zhu, Int. J. Num. Meth. Eng. 24, 337, 1987). By Galerkin's orthogonality the energy of the
error of x = (K + s²M)⁻¹ b is what the compliance bᵀx lacks.
"""

from __future__ import annotations

import numpy as np

from ..base import FloatArray
from ..fem import Material
from ..mesh import Mesh, cofactors, jacobians, reference_element
from .stress import batches, elements_at, extrapolation

__all__ = ["energy_error"]


_PAIRS = ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2))


def energy_error(mesh: Mesh, material: Material, displacement: FloatArray) -> FloatArray:
    """Return twice the strain energy of averaged strain less the elements' own, for each element.

    Parameters
    ----------
    mesh : Mesh
    material : Material
    displacement : ndarray, shape (n_nodes, 3)
        m.

    Returns
    -------
    ndarray, shape (n_cells,)
        J.
    """
    element = reference_element(mesh.kind)
    gradient = element.gradient(element.stiffness_rule.points)
    shape = element.shape(element.stiffness_rule.points)
    carry = extrapolation(mesh.kind)
    averaged = np.zeros((6, mesh.n_nodes))
    for batch in batches(mesh.n_cells, element):
        cells = mesh.cells[batch]
        strain, _ = _strain(mesh.nodes[cells], displacement[cells], gradient)
        for total, share in zip(averaged, strain @ carry.T, strict=True):
            total += np.bincount(cells.reshape(-1), share.reshape(-1), mesh.n_nodes)
    averaged /= elements_at(mesh)
    lam, mu = material.lame
    energy = np.empty(mesh.n_cells)
    for batch in batches(mesh.n_cells, element):
        cells = mesh.cells[batch]
        strain, det = _strain(mesh.nodes[cells], displacement[cells], gradient)
        strain -= averaged[:, cells] @ shape.T
        trace = strain[:3].sum(axis=0)
        twice = lam * trace**2 + 2.0 * mu * (strain[:3] ** 2).sum(axis=0)
        twice += 4.0 * mu * (strain[3:] ** 2).sum(axis=0)
        energy[batch] = (det * twice) @ element.stiffness_rule.weights
    return energy


def _strain(
    corners: FloatArray, moved: FloatArray, gradient: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Strain xx, yy, zz, xy, yz, xz at the Gauss points, shape (6, n_cells, n_gauss), and det J."""
    det, cofactor = cofactors(jacobians(corners, gradient))
    slope = jacobians(moved, gradient)
    strain = np.empty((6, *det.shape))
    for row, (i, j) in zip(strain, _PAIRS, strict=True):
        np.einsum("aeg,aeg->eg", slope[i], cofactor[j], out=row)
        if i != j:
            row += np.einsum("aeg,aeg->eg", slope[j], cofactor[i])
            row *= 0.5
    strain /= det
    return strain, det
