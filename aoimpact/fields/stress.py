"""Stress of a deformed body: at the Gauss points of its elements, and averaged at its nodes.

At the Gauss points the strains are those of the elements. From there they are carried to the nodes
by the polynomial of the element's corners (linear in a tetrahedron, trilinear in a brick) that fits
them best: one degree lower than the displacements, it takes from the strains what is accurate to
one order more (J. Barlow, Int. J. Num. Meth. Eng. 10, 243, 1976). At a node the elements' values
are averaged.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache

import numpy as np
import scipy.sparse as sp

from ..base import FloatArray, IntArray, choice
from ..fem import Material
from ..mesh import Mesh, ReferenceElement, cofactors, jacobians, reference_element

__all__ = [
    "COMPONENTS",
    "Stress",
    "batches",
    "elements_at",
    "extrapolation",
    "gauss_stress",
    "nodal_stress",
    "stress_rows",
]


# VTK's order of a symmetric tensor.
COMPONENTS = ("xx", "yy", "zz", "xy", "yz", "xz")
_PLACES = ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2))

# Elements are taken so many at a time that their gradients stay in this size, bytes.
_BATCH = 16e6


@dataclass(frozen=True, eq=False)
class Stress:
    """Stress at points of a body.

    ``stress["xx"]`` is one component.

    Attributes
    ----------
    components : ndarray, shape (..., 6)
        σxx, σyy, σzz, σxy, σyz, σxz, Pa; tension is positive.
    points : ndarray, shape (n_nodes, 3) or (n_cells, n_gauss, 3)
        Where, on the undeformed body, m.
    """

    components: FloatArray
    points: FloatArray

    def __getitem__(self, name: str) -> FloatArray:
        place = COMPONENTS.index(choice("name of a component", name, COMPONENTS))
        component: FloatArray = self.components[..., place]
        return component

    @property
    def tensor(self) -> FloatArray:
        """The symmetric tensor, Pa, shape (..., 3, 3)."""
        tensor = np.empty((*self.components.shape[:-1], 3, 3))
        for place, (i, j) in enumerate(_PLACES):
            tensor[..., i, j] = tensor[..., j, i] = self.components[..., place]
        return tensor

    @property
    def von_mises(self) -> FloatArray:
        """Von Mises' equivalent stress √(3/2 s:s) with s the deviator, Pa, shape (...)."""
        xx, yy, zz, xy, yz, xz = np.moveaxis(self.components, -1, 0)
        direct = (xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2
        equivalent: FloatArray = np.sqrt(0.5 * direct + 3.0 * (xy**2 + yz**2 + xz**2))
        return equivalent

    @property
    def principal(self) -> FloatArray:
        """Principal stresses, the largest first, Pa, shape (..., 3)."""
        return np.asarray(np.linalg.eigvalsh(self.tensor), dtype=np.float64)[..., ::-1]


def gauss_stress(mesh: Mesh, material: Material, displacement: FloatArray) -> Stress:
    """Return the stress at the points of quadrature of the stiffness.

    Parameters
    ----------
    mesh : Mesh
    material : Material
    displacement : ndarray, shape (..., n_nodes, 3)
        m.

    Returns
    -------
    Stress
        Of shape (..., n_cells, n_gauss, 6).
    """
    element = reference_element(mesh.kind)
    shape = element.shape(element.stiffness_rule.points)
    n_gauss = len(shape)
    components = np.empty((*displacement.shape[:-2], mesh.n_cells, n_gauss, 6))
    points = np.empty((mesh.n_cells, n_gauss, 3))
    for batch in batches(mesh.n_cells, element):
        cells = mesh.cells[batch]
        points[batch] = shape @ mesh.nodes[cells]
        slopes = _slopes(mesh.nodes[cells], element)
        gradient = np.einsum("...eaj,egai->...egji", displacement[..., cells, :], slopes)
        components[..., batch, :, :] = _hooke(gradient, material)
    return Stress(components, points)


def nodal_stress(mesh: Mesh, material: Material, displacement: FloatArray) -> Stress:
    """Return the stress at the nodes, averaged over the elements that meet there.

    Parameters
    ----------
    mesh : Mesh
    material : Material
    displacement : ndarray, shape (..., n_nodes, 3)
        m.

    Returns
    -------
    Stress
        Of shape (..., n_nodes, 6).
    """
    element = reference_element(mesh.kind)
    gradient = np.zeros((*displacement.shape[:-2], mesh.n_nodes, 3, 3))
    for batch in batches(mesh.n_cells, element):
        cells = mesh.cells[batch]
        slopes = _slopes_at_nodes(mesh.nodes[cells], element)
        shares = np.einsum("...eaj,enai->...enji", displacement[..., cells, :], slopes)
        for total, share in zip(_histories(gradient, 3), _histories(shares, 4), strict=True):
            np.add.at(total, cells, share)
    gradient /= elements_at(mesh)[:, None, None]
    return Stress(_hooke(gradient, material), mesh.nodes)


def stress_rows(mesh: Mesh, material: Material, nodes: IntArray) -> sp.csr_array:
    """Return the stress at some nodes as a linear function of all displacements.

    Parameters
    ----------
    mesh : Mesh
    material : Material
    nodes : ndarray of int
        Each once.

    Returns
    -------
    scipy.sparse.csr_array, shape (6 len(nodes), 3 n_nodes)
        Its product with the displacements is `nodal_stress` there, component by component.
    """
    # The stress by each ∂u_j/∂x_i, (3 i, 3 j, 6).
    unit = np.zeros((3, 3, 3, 3))
    for j, i in np.ndindex(3, 3):
        unit[i, j, j, i] = 1.0
    stress = _hooke(unit, material)
    slopes = _averaged_slopes(mesh, nodes)
    rows = [sp.kron(slope, by.T, format="csr") for slope, by in zip(slopes, stress, strict=True)]
    return rows[0] + rows[1] + rows[2]


def _averaged_slopes(mesh: Mesh, nodes: IntArray) -> list[sp.csr_array]:
    """∂/∂x, ∂/∂y, ∂/∂z at some nodes of a function given at all, each (len(nodes), n_nodes)."""
    element, count = reference_element(mesh.kind), elements_at(mesh)
    row = np.full(mesh.n_nodes, -1)
    row[nodes] = np.arange(len(nodes))
    around = np.flatnonzero((row[mesh.cells] >= 0).any(axis=1))
    found: list[tuple[IntArray, IntArray, FloatArray]] = []
    for batch in batches(len(around), element):
        cells = mesh.cells[around[batch]]
        cell, local = np.nonzero(row[cells] >= 0)
        slopes = _slopes_at_nodes(mesh.nodes[cells], element)[cell, local]
        at = cells[cell, local]
        slopes /= count[at][:, None, None]
        found.append((np.repeat(row[at], cells.shape[1]), cells[cell].ravel(), slopes))
    i, j, values = (np.concatenate(parts) for parts in zip(*found, strict=True))
    shape = (len(nodes), mesh.n_nodes)
    return [sp.csr_array((values[..., axis].ravel(), (i, j)), shape=shape) for axis in range(3)]


def batches(n_cells: int, element: ReferenceElement) -> Iterator[slice]:
    """Slices of the elements, of which all values at Gauss points fit into a cache or two."""
    n_points = max(element.n_nodes, len(element.stiffness_rule.weights))
    step = max(1, int(_BATCH / (8 * 3 * n_points * element.n_nodes)))
    for start in range(0, n_cells, step):
        yield slice(start, start + step)


def _slopes(corners: FloatArray, element: ReferenceElement) -> FloatArray:
    """∂φ_a/∂x_i at the Gauss points, shape (n_cells, n_gauss, n_local, 3)."""
    gradient = element.gradient(element.stiffness_rule.points)
    det, cof = cofactors(jacobians(corners, gradient))
    slopes: FloatArray = np.einsum("gat,iteg->egai", gradient, cof / det)
    return slopes


def _slopes_at_nodes(corners: FloatArray, element: ReferenceElement) -> FloatArray:
    """The slopes carried on to the nodes, shape (n_cells, n_local, n_local, 3)."""
    slopes: FloatArray = np.einsum(
        "ng,egai->enai", extrapolation(element.kind), _slopes(corners, element)
    )
    return slopes


@cache
def extrapolation(kind: str) -> FloatArray:
    """Values at the nodes of the corners' polynomial that fits values at the Gauss points best.

    By least squares with the weights of the quadrature. A single point gives its value everywhere.
    """
    element = reference_element(kind)
    corners, rule = element.linear, element.stiffness_rule
    root = np.sqrt(rule.weights)
    fit = np.linalg.pinv(root[:, None] * corners.shape(rule.points)) * root
    extrapolation: FloatArray = corners.shape(element.nodes) @ fit
    return extrapolation


def elements_at(mesh: Mesh) -> FloatArray:
    """How many elements meet at each node."""
    return np.bincount(mesh.cells.reshape(-1), minlength=mesh.n_nodes).astype(np.float64)


def _histories(array: FloatArray, axes: int) -> FloatArray:
    """The array with all but its last `axes` axes made one."""
    return array.reshape(-1, *array.shape[array.ndim - axes :])


def _hooke(gradient: FloatArray, material: Material) -> FloatArray:
    """σ = λ tr ε I + 2μ ε of displacement gradients (..., 3, 3), shape (..., 6)."""
    lam, mu = material.lame
    trace = np.einsum("...ii->...", gradient)
    stress = np.empty((*gradient.shape[:-2], 6))
    for place, (i, j) in enumerate(_PLACES):
        stress[..., place] = mu * (gradient[..., i, j] + gradient[..., j, i])
    stress[..., :3] += lam * trace[..., None]
    return stress
