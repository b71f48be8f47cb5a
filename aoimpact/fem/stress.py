"""Stress of a deformed body: at the Gauss points of its elements, and averaged at its nodes.

At the Gauss points the strains are those of the elements. From there they are carried to the nodes
by the polynomial of the element's corners (linear in a tetrahedron, trilinear in a brick) that fits
them best: one degree lower than the displacements, it takes from the strains what is accurate to
one order more (J. Barlow, Int. J. Num. Meth. Eng. 10, 243, 1976). At a node the elements' values
are averaged, but never across an interface of materials, where stress jumps: there it is that of
the stiffest.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache

import numpy as np
import scipy.sparse as sp

from ..base import FloatArray, IntArray, choice
from ..mesh import Mesh, ReferenceElement, cofactors, jacobians, reference_element
from .composition import AnyMaterial, Layout, OneMaterial, Piece, each_of, layout, pieces
from .material import PAIRS, Material

# VTK's order of a symmetric tensor.
COMPONENTS = ("xx", "yy", "zz", "xy", "yz", "xz")

# Elements are taken so many at a time that their gradients stay in this size, bytes.
_BATCH = 16e6


@dataclass(frozen=True, eq=False)
class Tensor:
    """A symmetric tensor at points of a body.

    ``stress["xx"]`` is one component.

    Attributes
    ----------
    components : ndarray, shape (..., 6)
        xx, yy, zz, xy, yz, xz; tension is positive.
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
        """The symmetric tensor, shape (..., 3, 3)."""
        tensor = np.empty((*self.components.shape[:-1], 3, 3))
        for place, (i, j) in enumerate(PAIRS):
            tensor[..., i, j] = tensor[..., j, i] = self.components[..., place]
        return tensor

    @property
    def principal(self) -> FloatArray:
        """Principal values, the largest first, shape (..., 3)."""
        return np.asarray(np.linalg.eigvalsh(self.tensor), dtype=np.float64)[..., ::-1]


@dataclass(frozen=True, eq=False)
class Stress(Tensor):
    """Stress at points of a body, Pa; see `Tensor`."""

    @property
    def von_mises(self) -> FloatArray:
        """Von Mises' equivalent stress √(3/2 s:s) with s the deviator, Pa, shape (...)."""
        xx, yy, zz, xy, yz, xz = np.moveaxis(self.components, -1, 0)
        direct = (xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2
        equivalent: FloatArray = np.sqrt(0.5 * direct + 3.0 * (xy**2 + yz**2 + xz**2))
        return equivalent


@dataclass(frozen=True, eq=False)
class Strain(Tensor):
    """Strain at points of a body; see `Tensor`. Shears are those of the tensor, half of γ."""

    def along(self, direction: FloatArray) -> FloatArray:
        """Return the strain along a unit vector, shape (...)."""
        found: FloatArray = np.einsum("...ij,i,j->...", self.tensor, direction, direction)
        return found


def gauss_stress(mesh: Mesh, material: AnyMaterial, displacement: FloatArray) -> Stress:
    """Return the stress at the points of quadrature of the stiffness.

    Parameters
    ----------
    mesh : Mesh
    material : Material, Orthotropic or Materials
    displacement : ndarray, shape (..., n_nodes, 3)
        m.

    Returns
    -------
    Stress
        Of shape (..., n_cells, n_gauss, 6), in a mixed mesh with nan after an element's own points.
    """
    most = max(len(block.element.stiffness_rule.weights) for block in mesh.blocks)
    components = np.full((*displacement.shape[:-2], mesh.n_cells, most, 6), np.nan)
    points = np.full((mesh.n_cells, most, 3), np.nan)
    for piece in pieces(mesh, material):
        element = piece.element
        shape = element.shape(element.stiffness_rule.points)
        for batch in batches(piece):
            cells, numbers = batch.cells, batch.numbers
            points[numbers, : len(shape)] = shape @ mesh.nodes[cells]
            components[..., numbers, : len(shape), :] = gauss_of(mesh, batch, displacement)
    return Stress(components, points)


def gauss_of(mesh: Mesh, piece: Piece, displacement: FloatArray) -> FloatArray:
    """Return the components of `gauss_stress` of some elements, shape (..., n, n_gauss, 6)."""
    slopes = _slopes(mesh.nodes[piece.cells], piece.element)
    gradient = np.einsum("...eaj,egai->...egji", displacement[..., piece.cells, :], slopes)
    return _hooke(gradient, piece.material)


def nodal_stress(mesh: Mesh, material: AnyMaterial, displacement: FloatArray) -> Stress:
    """Return the stress at the nodes, averaged over the elements that meet there.

    Where materials meet, over the elements of the stiffest.

    Parameters
    ----------
    mesh : Mesh
    material : Material, Orthotropic or Materials
    displacement : ndarray, shape (..., n_nodes, 3)
        m.

    Returns
    -------
    Stress
        Of shape (..., n_nodes, 6).
    """
    places = layout(mesh, material)
    gradient = np.zeros((*displacement.shape[:-2], len(places.key), 3, 3))
    for piece in pieces(mesh, material):
        for batch in batches(piece):
            cells = batch.cells
            slopes = _slopes_at_nodes(mesh.nodes[cells], piece.element)
            shares = np.einsum("...eaj,enai->...enji", displacement[..., cells, :], slopes)
            at = places.of(batch)
            for total, share in zip(_histories(gradient, 3), _histories(shares, 4), strict=True):
                np.add.at(total, at, share)
    gradient /= elements_at(mesh, material, places)[:, None, None]
    chosen = shown(places, material)
    stress = np.empty((*displacement.shape[:-2], mesh.n_nodes, 6))
    for number, of in enumerate(each_of(material)):
        on = places.which[chosen] == number
        stress[..., on, :] = _hooke(gradient[..., chosen[on], :, :], of)
    return Stress(stress, mesh.nodes)


def stress_rows(mesh: Mesh, material: AnyMaterial, nodes: IntArray) -> sp.csr_array:
    """Return the stress at some nodes as a linear function of all displacements.

    Parameters
    ----------
    mesh : Mesh
    material : Material, Orthotropic or Materials
    nodes : ndarray of int
        Each once.

    Returns
    -------
    scipy.sparse.csr_array, shape (6 len(nodes), 3 n_nodes)
        Its product with the displacements is `nodal_stress` there, component by component.
    """
    places = layout(mesh, material)
    wanted = shown(places, material)[nodes]
    slopes = _averaged_slopes(mesh, material, places, wanted)
    # The stress by each ∂u_j/∂x_i, (3 i, 3 j, 6).
    unit = np.zeros((3, 3, 3, 3))
    for j, i in np.ndindex(3, 3):
        unit[i, j, j, i] = 1.0
    found, order = [], []
    for number, of in enumerate(each_of(material)):
        on = np.flatnonzero(places.which[wanted] == number)
        by_slope = zip(slopes, _hooke(unit, of), strict=True)
        one, two, three = (sp.kron(slope[on], by.T, format="csr") for slope, by in by_slope)
        found.append(one + two + three)
        order.append(on)
    row = np.argsort(np.concatenate(order))
    return sp.csr_array(sp.vstack(found, format="csr")[(6 * row[:, None] + np.arange(6)).ravel()])


def _averaged_slopes(
    mesh: Mesh, material: AnyMaterial, places: Layout, wanted: IntArray
) -> list[sp.csr_array]:
    """∂/∂x, ∂/∂y, ∂/∂z at some places of a function given at all nodes, each (n, n_nodes)."""
    count = elements_at(mesh, material, places)
    row = np.full(len(places.key), -1)
    row[wanted] = np.arange(len(wanted))
    found: list[tuple[IntArray, IntArray, FloatArray]] = []
    for piece in pieces(mesh, material):
        around = np.flatnonzero((row[places.of(piece)] >= 0).any(axis=1))
        for batch in batches(piece.taken(around)):
            cells, at_places = batch.cells, places.of(batch)
            cell, local = np.nonzero(row[at_places] >= 0)
            slopes = _slopes_at_nodes(mesh.nodes[cells], piece.element)[cell, local]
            at = at_places[cell, local]
            slopes /= count[at][:, None, None]
            i = np.repeat(row[at], cells.shape[1])
            found.append((i, cells[cell].ravel(), slopes.reshape(-1, 3)))
    i, j, values = (np.concatenate(parts) for parts in zip(*found, strict=True))
    shape = (len(wanted), mesh.n_nodes)
    return [sp.csr_array((values[:, axis], (i, j)), shape=shape) for axis in range(3)]


def compliances(mesh: Mesh, material: AnyMaterial, nodes: IntArray) -> FloatArray:
    """Return strain by stress at some nodes, 1/Pa, shape (n, 6, 6), of the material shown there.

    Shears are those of the tensor.
    """
    half = np.where(np.arange(6) < 3, 1.0, 0.5)[:, None]
    every = np.stack([half * np.linalg.inv(of.stiffness) for of in each_of(material)])
    places = layout(mesh, material)
    found: FloatArray = every[places.which[shown(places, material)[nodes]]]
    return found


def batches(piece: Piece) -> Iterator[Piece]:
    """Parts of the elements, of which all values at Gauss points fit into a cache or two."""
    element = piece.element
    n_points = max(element.n_nodes, len(element.stiffness_rule.weights))
    return piece.batches(max(1, int(_BATCH / (8 * 3 * n_points * element.n_nodes))))


def shown(places: Layout, material: AnyMaterial) -> IntArray:
    """Return of each node the place whose material is the stiffest, shape (n_nodes,)."""
    size = np.array([np.trace(of.stiffness) for of in each_of(material)])
    order = np.lexsort((size[places.which], places.node))
    last = np.append(np.diff(places.node[order]) > 0, True)
    stiffest: IntArray = order[last]
    return stiffest


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


def elements_at(mesh: Mesh, material: AnyMaterial, places: Layout) -> FloatArray:
    """How many elements meet at each place."""
    count = np.zeros(len(places.key))
    for piece in pieces(mesh, material):
        count += np.bincount(places.of(piece).reshape(-1), minlength=len(count))
    return count


def _histories(array: FloatArray, axes: int) -> FloatArray:
    """The array with all but its last `axes` axes made one."""
    return array.reshape(-1, *array.shape[array.ndim - axes :])


def _hooke(gradient: FloatArray, material: OneMaterial) -> FloatArray:
    """σ of displacement gradients (..., 3, 3), shape (..., 6)."""
    if not isinstance(material, Material):
        strain = np.empty((*gradient.shape[:-2], 6))
        for place, (i, j) in enumerate(PAIRS):
            both = gradient[..., i, j] + gradient[..., j, i]
            strain[..., place] = both if i != j else 0.5 * both
        found: FloatArray = strain @ material.stiffness
        return found
    lam, mu = material.lame
    trace = np.einsum("...ii->...", gradient)
    stress = np.empty((*gradient.shape[:-2], 6))
    for place, (i, j) in enumerate(PAIRS):
        stress[..., place] = mu * (gradient[..., i, j] + gradient[..., j, i])
    stress[..., :3] += lam * trace[..., None]
    return stress
