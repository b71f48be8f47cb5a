"""How wrong the stress of a displacement field is, from its jumps between elements.

Stress that is averaged at the nodes and interpolated between them is better than that of the
elements; the energy of their difference estimates that of the field's error (O. C. Zienkiewicz and
J. Z. Zhu, Int. J. Num. Meth. Eng. 24, 337, 1987). By Galerkin's orthogonality the energy of the
error of x = (K + s²M)⁻¹ b is what the compliance bᵀx lacks.

Elements that lock hold mostly false strain, and lack more energy than they have, which that
difference cannot show. But the average keeps the true part, a share ϑ of their energy. Elements L
times too stiff move 1/L as far under a given load, so that ϑ = 1/L, and the compliance lacks L - 1
times their energy: (1 - ϑ)/ϑ of it, in place of 1 - ϑ (`missing_energy`).

On free surfaces the average is worst, and one thing is known: there is no traction. What there is
of it is taken out, P σ P with P = I - n nᵀ. So the estimate sees, too, the false stress across a
plate of one layer of linear elements, which all of them have alike.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from ..base import FloatArray
from ..fem import Body, Material
from ..mesh import Mesh, cofactors, jacobians, reference_element
from .stress import Stress, batches, elements_at, extrapolation, gauss_stress

__all__ = ["energy_error", "missing_energy", "stresses_around"]

# No share of the energy is taken to be less true than this.
_LEAST_TRUE = 0.1

# The components of strain, in the order of `COMPONENTS`.
_PAIRS = ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2))


def missing_energy(difference: FloatArray, own: FloatArray) -> float:
    """Return twice the strain energy that some elements lack, J, from `energy_error` of them."""
    false, whole = float(difference.sum()), float(own.sum())
    return false / max(1.0 - false / whole, _LEAST_TRUE) if whole > 0.0 else 0.0


def energy_error(
    body: Body, displacement: FloatArray, loaded: npt.NDArray[np.bool_]
) -> tuple[FloatArray, FloatArray]:
    """Return twice the strain energy of averaged strain less the elements' own, and of their own.

    Parameters
    ----------
    body : FEModel
        Made from a mesh.
    displacement : ndarray, shape (n_dofs,)
        m.
    loaded : ndarray of bool, shape (n_nodes,)
        Nodes that may carry traction, beside those of the supports.

    Returns
    -------
    difference, own : ndarray, shape (n_cells,)
        Of each element, J.
    """
    mesh, material = body.mesh, body.material
    assert mesh is not None
    assert material is not None
    everywhere = np.zeros(3 * mesh.n_nodes)
    everywhere[body.free] = displacement
    moved = everywhere.reshape(-1, 3)
    element = reference_element(mesh.kind)
    gradient = element.gradient(element.stiffness_rule.points)
    averaged = np.zeros((6, mesh.n_nodes))
    for batch in batches(mesh.n_cells, element):
        cells = mesh.cells[batch]
        strain, _ = _strain(mesh.nodes[cells], moved[cells], gradient)
        for total, share in zip(averaged, strain @ extrapolation(mesh.kind).T, strict=True):
            total += np.bincount(cells.reshape(-1), share.reshape(-1), mesh.n_nodes)
    averaged /= elements_at(mesh)
    _free_of_traction(averaged, body, loaded)
    shape, weights = element.shape(element.stiffness_rule.points), element.stiffness_rule.weights
    difference, own = np.empty(mesh.n_cells), np.empty(mesh.n_cells)
    for batch in batches(mesh.n_cells, element):
        cells = mesh.cells[batch]
        strain, det = _strain(mesh.nodes[cells], moved[cells], gradient)
        own[batch] = (det * _density(strain, material)) @ weights
        strain -= averaged[:, cells] @ shape.T
        difference[batch] = (det * _density(strain, material)) @ weights
    return difference, own


def _density(strain: FloatArray, material: Material) -> FloatArray:
    """Twice the energy of a volume, J/m³, of strain of shape (6, ...)."""
    lam, mu = material.lame
    direct, shear = (strain[:3] ** 2).sum(axis=0), (strain[3:] ** 2).sum(axis=0)
    density: FloatArray = 2.0 * mu * (direct + 2.0 * shear) + lam * strain[:3].sum(axis=0) ** 2
    return density


def _free_of_traction(strain: FloatArray, body: Body, loaded: npt.NDArray[np.bool_]) -> None:
    """Take the traction out of the strain at nodes of free surfaces, shape (6, n_nodes)."""
    surface, material = body.surface, body.material
    assert surface is not None
    assert material is not None
    supported = np.ones(3 * len(loaded), dtype=bool)
    supported[body.free] = False
    normals = surface.node_normals
    free = np.flatnonzero(normals[0].any(axis=1) & ~loaded & ~supported.reshape(-1, 3).any(axis=1))
    lam, mu = material.lame
    tensor, identity = np.empty((len(free), 3, 3)), np.eye(3)
    for row, (i, j) in zip(strain, _PAIRS, strict=True):
        tensor[:, i, j] = tensor[:, j, i] = row[free]
    stress = 2.0 * mu * tensor + lam * np.trace(tensor, axis1=1, axis2=2)[:, None, None] * identity
    for normal in normals[:, free]:
        across = identity - normal[:, :, None] * normal[:, None, :]
        stress = across @ stress @ across
    share = lam / (3.0 * lam + 2.0 * mu)
    stress -= share * np.trace(stress, axis1=1, axis2=2)[:, None, None] * identity
    for row, (i, j) in zip(strain, _PAIRS, strict=True):
        row[free] = stress[:, i, j] / (2.0 * mu)


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


def stresses_around(body: Body, displacement: FloatArray, node: int) -> tuple[Stress, Stress]:
    """Return the stress at a node, averaged and as each of the elements that meet there has it.

    Parameters
    ----------
    body : FEModel
        Made from a mesh.
    displacement : ndarray, shape (n_nodes, 3)
        m.
    node : int

    Returns
    -------
    averaged, of_elements : Stress
        Of shapes (6,) and (n, 6), Pa.
    """
    mesh, material = body.mesh, body.material
    assert mesh is not None
    assert material is not None
    around, local = np.nonzero(mesh.cells == node)
    nodes, cells = np.unique(mesh.cells[around], return_inverse=True)
    part = Mesh(mesh.nodes[nodes], cells.reshape(len(around), -1), mesh.kind)
    at_gauss = gauss_stress(part, material, displacement[nodes]).components
    found = np.einsum("eg,egc->ec", extrapolation(mesh.kind)[local], at_gauss)
    return Stress(found.mean(axis=0), mesh.nodes[node]), Stress(found, mesh.nodes[node])
