"""Stress of a deformed body: at the Gauss points of its elements, and averaged at its nodes.

At the Gauss points the strains are those of the elements. From there they are carried to the nodes
by the polynomial of the element's corners (linear in a tetrahedron, trilinear in a brick) that fits
them best: one degree lower than the displacements, it takes from the strains what is accurate to
one order more (J. Barlow, Int. J. Num. Meth. Eng. 10, 243, 1976). Of an element that has functions
of the next degree beside its own, it is a polynomial of its own degree. At a node the elements'
values are averaged, but never across an interface of materials, where stress jumps: there it is
that of the stiffest.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache

import numpy as np

from ..base import ArrayPair, FloatArray, IntArray, choice, record
from ..mesh import Mesh, cofactors, jacobians, reference_element
from .composition import AnyMaterial, Layout, OneMaterial, Piece, each_of, layout, pieces
from .material import PAIRS, PLACES, Material

# VTK's order of a symmetric tensor.
COMPONENTS = ("xx", "yy", "zz", "xy", "yz", "xz")

# Angles of shear are twice the tensor's components.
ANGLE = np.array([1.0, 1.0, 1.0, 2.0, 2.0, 2.0])

# Tensors of each component of strain, with γ of one for shear, (6, 3, 3).
UNIT_STRAINS = np.eye(6)[:, PLACES] / ANGLE[:, None, None]

# Elements are taken so many at a time that their gradients stay in this size, bytes.
_BATCH = 16e6


@record
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
        return self.components[..., place]

    @property
    def tensor(self) -> FloatArray:
        """The symmetric tensor, shape (..., 3, 3)."""
        return self.components[..., PLACES]

    @property
    def principal(self) -> FloatArray:
        """Principal values, the largest first, shape (..., 3)."""
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
    """Strain at points of a body; see `Tensor`. Shears are those of the tensor, half of γ."""

    def along(self, direction: FloatArray) -> FloatArray:
        """Return the strain along a unit vector, shape (...)."""
        return np.asarray(np.einsum("...ij,i,j->...", self.tensor, direction, direction))


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

    The strain has the shape (6, ..., n_cells, n) for displacements (..., n_nodes, 3).
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
    """Return the stress, Pa, under strains of shape (6, ...), whose shears are the tensor's."""
    if not isinstance(material, Material):
        return np.asarray(np.einsum("ab,b...->a...", material.stiffness * ANGLE, strain))
    lam, mu = material.lame
    stress: FloatArray = 2.0 * mu * strain
    stress[:3] += lam * strain[:3].sum(axis=0)
    return stress


def compliances(mesh: Mesh, material: AnyMaterial, nodes: IntArray) -> FloatArray:
    """Return strain by stress at some nodes, 1/Pa, shape (n, 6, 6), of the material shown there.

    Shears are those of the tensor.
    """
    every = np.stack([np.linalg.inv(of.stiffness * ANGLE) for of in each_of(material)])
    places = layout(mesh, material)
    return every[places.which[shown(places, material)[nodes]]]


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
    return np.asarray(order[last])


def slopes_at_nodes(mesh: Mesh, piece: Piece) -> FloatArray:
    """Return ∂φ_a/∂x_i of the Gauss points at the nodes, shape (n_cells, n_nodes, n_local, 3)."""
    element = piece.element
    gradient = element.gradient(element.stiffness_rule.points)
    det, cof = cofactors(jacobians(mesh.nodes[piece.cells], gradient))
    slopes = np.einsum("gat,iteg->eagi", gradient, cof / det)
    to_nodes = extrapolation(element.kind)
    return np.asarray(np.einsum("ng,eagi->enai", to_nodes, piece.signed(slopes)))


@cache
def extrapolation(kind: str) -> FloatArray:
    """Values at the nodes of the lower polynomial that fits values at the Gauss points best.

    By least squares with the weights of the quadrature. A single point gives its value everywhere.
    """
    element = reference_element(kind)
    lower, rule = element.lower, element.stiffness_rule
    root = np.sqrt(rule.weights)
    fit = np.linalg.pinv(root[:, None] * lower.shape(rule.points)) * root
    return lower.shape(element.own.nodes) @ fit
