"""Stress of a deformed body: at the Gauss points of its elements, and averaged at its nodes.

Strains at the Gauss points are extrapolated to the nodes of an element by the least-squares
polynomial of its corners (linear in a tetrahedron, trilinear in a brick). Its degree is one lower
than that of the displacements, which retains the superconvergent part of the strains (J. Barlow,
Int. J. Num. Meth. Eng. 10, 243, 1976). Elements with additional shape functions of the next degree
use a polynomial of their own degree. At each node the values of the elements are averaged within
each material, as stress jumps at interfaces; the stress given there is that of the stiffest
material.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache

import numpy as np

from ..base import ArrayPair, FloatArray, IntArray, choice, record
from ..mesh import Mesh, cofactors, jacobians, reference_element
from .composition import AnyMaterial, Layout, OneMaterial, Piece, each_of, layout, pieces
from .material import PAIRS, PLACES, Material

# Components in VTK's order of symmetric tensors.
COMPONENTS = ("xx", "yy", "zz", "xy", "yz", "xz")

# Ratios of engineering strains to tensor components: shear angles are γ = 2ε.
ANGLE = np.array([1.0, 1.0, 1.0, 2.0, 2.0, 2.0])

# Tensors of unit engineering strains, shape (6, 3, 3): γ = 1 for shear.
UNIT_STRAINS = np.eye(6)[:, PLACES] / ANGLE[:, None, None]


@record
class Tensor:
    """A symmetric tensor at points of a body.

    ``stress["xx"]`` is one component.

    Attributes
    ----------
    components : ndarray, shape (..., 6)
        Components xx, yy, zz, xy, yz, xz; tension is positive.
    points : ndarray, shape (n_nodes, 3) or (n_cells, n_gauss, 3)
        Positions on the undeformed body, m.
    """

    components: FloatArray
    points: FloatArray

    def __getitem__(self, name: str) -> FloatArray:
        place = COMPONENTS.index(choice("name of a component", name, COMPONENTS))
        return self.components[..., place]

    @property
    def tensor(self) -> FloatArray:
        """The symmetric tensor, shape (..., 3, 3)."""
        return self.components[..., PLACES]

    @property
    def principal(self) -> FloatArray:
        """Principal values in descending order, shape (..., 3)."""
        return np.asarray(np.linalg.eigvalsh(self.tensor), dtype=np.float64)[..., ::-1]


@record
class Stress(Tensor):
    """Stress at points of a body, Pa; see `Tensor`."""

    @property
    def von_mises(self) -> FloatArray:
        """Von Mises' equivalent stress √(3/2 s:s) with s the deviator, Pa, shape (...)."""
        xx, yy, zz, xy, yz, xz = np.moveaxis(self.components, -1, 0)
        direct = (xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2
        return np.asarray(np.sqrt(0.5 * direct + 3.0 * (xy**2 + yz**2 + xz**2)))


@record
class Strain(Tensor):
    """Strain at points of a body; see `Tensor`. Shear components are ε = γ/2."""

    def along(self, direction: FloatArray) -> FloatArray:
        """Return the normal strain along a unit vector, shape (...)."""
        return np.asarray(np.einsum("...ij,i,j->...", self.tensor, direction, direction))


def gauss_stress(mesh: Mesh, material: AnyMaterial, displacement: FloatArray) -> Stress:
    """Return the stress at the quadrature points of the stiffness.

    Parameters
    ----------
    mesh : Mesh
    material : Material, Orthotropic or Materials
    displacement : ndarray, shape (..., n_nodes, 3)
        Nodal displacements, m.

    Returns
    -------
    Stress
        Components of shape (..., n_cells, n_gauss, 6); nan beyond an element's own points in a mesh
        with several kinds of elements.
    """
    most = max(len(block.element.own.stiffness_rule.weights) for block in mesh.blocks)
    components = np.full((*displacement.shape[:-2], mesh.n_cells, most, 6), np.nan)
    points = np.full((mesh.n_cells, most, 3), np.nan)
    for piece in pieces(mesh, material):
        at = piece.element.own.stiffness_rule.points
        shape = piece.element.shape(at)
        for batch in batches(piece):
            points[batch.numbers, : len(shape)] = shape @ mesh.nodes[batch.cells]
            stress = hooke(strain_at(at, mesh, batch, displacement)[0], piece.of)
            components[..., batch.numbers, : len(shape), :] = np.moveaxis(stress, 0, -1)
    return Stress(components, points)


def nodal_stress(mesh: Mesh, material: AnyMaterial, displacement: FloatArray) -> Stress:
    """Return the stress at the nodes, averaged over the adjacent elements.

    Where materials meet, only elements of the stiffest material are averaged.

    Parameters
    ----------
    mesh : Mesh
    material : Material, Orthotropic or Materials
    displacement : ndarray, shape (..., n_nodes, 3)
        Nodal displacements, m.

    Returns
    -------
    Stress
        Components of shape (..., n_nodes, 6).
    """
    places = layout(mesh, material)
    chosen = shown(places, material)
    count = len(places.node)
    averaged, elements = np.zeros((6, *displacement.shape[:-2], count)), np.zeros(count)
    for piece in pieces(mesh, material):
        to_nodes, points = extrapolation(piece.element.kind).T, piece.element.stiffness_rule.points
        for batch in batches(piece):
            at = places.of(batch).reshape(-1)
            elements += np.bincount(at, minlength=count)
            strain, _ = strain_at(points, mesh, batch, displacement)
            shares = (strain @ to_nodes).reshape(-1, at.size)
            for total, share in zip(averaged.reshape(-1, count), shares, strict=True):
                total += np.bincount(at, share, count)
    strain = (averaged / np.maximum(elements, 1.0))[..., chosen]
    stress = np.empty((*strain.shape[1:], 6))
    for number, of in enumerate(each_of(material)):
        on = places.which[chosen] == number
        stress[..., on, :] = np.moveaxis(hooke(strain[..., on], of), 0, -1)
    return Stress(stress, mesh.nodes[: len(chosen)])


def strain_at(points: FloatArray, mesh: Mesh, piece: Piece, displacement: FloatArray) -> ArrayPair:
    """Return the strain of elements at reference points, (n, 3), and det J, shape (n_cells, n).

    The shape of the strain is (6, ..., n_cells, n) for displacements of shape (..., n_nodes, 3).
    """
    gradient = piece.element.gradient(points)
    det, cofactor = cofactors(jacobians(mesh.nodes[piece.cells], gradient))
    moved, signs = displacement[..., piece.cells, :], piece.block.signs
    if signs is not None:
        moved = moved * signs[piece.rows][..., None]
    shape = *moved.shape[:-2], len(gradient)
    slope = jacobians(moved.reshape(-1, *moved.shape[-2:]), gradient).reshape(3, 3, *shape)
    strain = np.empty((6, *shape))
    for row, (i, j) in zip(strain, PAIRS, strict=True):
        np.einsum("a...eg,aeg->...eg", slope[i], cofactor[j], out=row)
        if i != j:
            row += np.einsum("a...eg,aeg->...eg", slope[j], cofactor[i])
            row *= 0.5
    strain /= det
    return strain, det


def hooke(strain: FloatArray, material: OneMaterial) -> FloatArray:
    """Return the stress, Pa, for tensor components of strain (shear ε = γ/2), both (6, ...)."""
    if not isinstance(material, Material):
        return np.asarray(np.einsum("ab,b...->a...", material.stiffness * ANGLE, strain))
    lam, mu = material.lame
    stress: FloatArray = 2.0 * mu * strain
    stress[:3] += lam * strain[:3].sum(axis=0)
    return stress


def compliances(mesh: Mesh, material: AnyMaterial, nodes: IntArray) -> FloatArray:
    """Return the compliance of the (stiffest) material at nodes, 1/Pa, shape (n, 6, 6).

    Shear strains are tensor components, ε = γ/2.
    """
    every = np.stack([np.linalg.inv(of.stiffness * ANGLE) for of in each_of(material)])
    places = layout(mesh, material)
    return every[places.which[shown(places, material)[nodes]]]


def batches(piece: Piece) -> Iterator[Piece]:
    """Yield batches of elements small enough that values at Gauss points fit into the caches."""
    element = piece.element
    n_points = max(element.n_nodes, len(element.stiffness_rule.weights))
    return piece.batches(8.0 * 3.0 * n_points * element.n_nodes)


def shown(places: Layout, material: AnyMaterial) -> IntArray:
    """Return, for each node, the index in `places` of its pair with the stiffest material."""
    size = np.array([np.trace(of.stiffness) for of in each_of(material)])
    order = np.lexsort((size[places.which], places.node))
    last = np.append(np.diff(places.node[order]) > 0, True)
    return np.asarray(order[last])


def slopes_at_nodes(mesh: Mesh, piece: Piece) -> FloatArray:
    """Return ∂φ_a/∂x_i extrapolated from the Gauss points to the nodes.

    Shape (n_cells, n_nodes, n_local, 3).
    """
    element = piece.element
    gradient = element.gradient(element.stiffness_rule.points)
    det, cof = cofactors(jacobians(mesh.nodes[piece.cells], gradient))
    slopes = np.einsum("gat,iteg->eagi", gradient, cof / det)
    to_nodes = extrapolation(element.kind)
    return np.asarray(np.einsum("ng,eagi->enai", to_nodes, piece.signed(slopes)))


@cache
def extrapolation(kind: str) -> FloatArray:
    """Return the matrix that extrapolates from Gauss points to nodes, (n_nodes, n_gauss).

    The polynomial, `ReferenceElement.lower`, is fitted by least squares with the quadrature
    weights. A single Gauss point gives a constant.
    """
    element = reference_element(kind)
    lower, rule = element.lower, element.stiffness_rule
    root = np.sqrt(rule.weights)
    fit = np.linalg.pinv(root[:, None] * lower.shape(rule.points)) * root
    return lower.shape(element.own.nodes) @ fit
