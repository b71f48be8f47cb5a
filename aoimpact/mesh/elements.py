"""The solid elements: shape functions and quadrature of each kind, nodes in meshio's order.

Shape functions are scikit-fem's. Its nodes come in another order than meshio's (VTK's); the two
are matched by the nodes' places in the reference element, so there is no table of permutations
that could be wrong.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, partial
from itertools import permutations
from typing import Any

import numpy as np
import scipy

from ..base import FloatArray, IntArray

__all__ = [
    "KINDS",
    "Cell",
    "ReferenceElement",
    "Rule",
    "cofactors",
    "jacobians",
    "reference_element",
]


@dataclass(frozen=True, eq=False)
class Cell:
    """A reference cell, which elements of several orders share.

    Attributes
    ----------
    linear : str
        The kind of element whose nodes are the corners alone.
    corners : ndarray, shape (n_corners, 3)
    normals : ndarray, shape (n_sides, 3)
        Outward normals of the sides, of any length.
    summed : int
        Of so many coordinates the sum is at most 1; each one lies between 0 and 1.
    of_brick : ndarray, shape (n_cells, n_corners, 3)
        The cells into which a brick, from 0 to 1 along each axis, is cut.
    """

    linear: str
    corners: FloatArray
    normals: FloatArray
    summed: int
    of_brick: FloatArray


@dataclass(frozen=True, eq=False)
class Rule:
    """A quadrature rule on the reference element: points (n, 3), weights (n,), all positive."""

    points: FloatArray
    weights: FloatArray


@dataclass(frozen=True, eq=False)
class ReferenceElement:
    """One kind of element.

    Attributes
    ----------
    kind : str
        meshio's name.
    cell : Cell
    nodes : ndarray, shape (n_nodes, 3)
        Reference coordinates of the nodes, meshio's order: the corners first; the rest lie in the
        middle of edges, faces, and the body.
    stiffness_rule, mass_rule : Rule
        Exact for ∫∇φ dV, which the patch test needs, and for ∫φφ dV, on elements however curved.
    """

    kind: str
    cell: Cell
    nodes: FloatArray
    stiffness_rule: Rule
    mass_rule: Rule
    _basis: Any
    _order: IntArray

    @property
    def n_nodes(self) -> int:
        return len(self.nodes)

    @property
    def n_corners(self) -> int:
        return len(self.cell.corners)

    @property
    def linear(self) -> ReferenceElement:
        """The element of first order on the same corners; itself, if it is of first order."""
        return self if self.kind == self.cell.linear else reference_element(self.cell.linear)

    def shape(self, points: FloatArray) -> FloatArray:
        """Return φ_a at reference points (n, 3), shape (n, n_nodes)."""
        return self.evaluate(points)[0]

    def gradient(self, points: FloatArray) -> FloatArray:
        """Return ∂φ_a/∂ξ_α at reference points (n, 3), shape (n, n_nodes, 3)."""
        return self.evaluate(points)[1]

    def evaluate(self, points: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return `shape` and `gradient` at once, for little more than one of them."""
        shape = np.empty((len(points), self.n_nodes))
        gradient = np.empty((len(points), self.n_nodes, 3))
        for a, i in enumerate(self._order):
            shape[:, a], derivatives = self._basis.lbasis(points.T, int(i))
            for alpha, derivative in enumerate(derivatives):
                gradient[:, a, alpha] = derivative
        return shape, gradient

    @property
    def mirror(self) -> IntArray:
        """The order of nodes that turns a left-handed element into a right-handed one."""
        reflected = self.nodes[:, [1, 0, 2]]
        return _match(reflected, self.nodes)


def _match(wanted: FloatArray, among: FloatArray) -> IntArray:
    """For each row of `wanted` the row of `among` that equals it."""
    distance = np.abs(wanted[:, None, :] - among[None, :, :]).max(axis=2)
    found: IntArray = distance.argmin(axis=1)
    assert np.array_equal(np.sort(found), np.arange(len(among)))
    assert distance[np.arange(len(wanted)), found].max() < 1e-12
    return found


def _quadrature(domain: str, degree: int) -> tuple[FloatArray, FloatArray]:
    """Return scikit-fem's points, shape (dimension, n), and weights on a reference domain."""
    from skfem import quadrature, refdom  # slow to import, and of no use without a mesh

    return quadrature.get_quadrature(getattr(refdom, domain), degree)  # type: ignore[no-any-return]


def _rule(domain: str, degree: int) -> Rule:
    points, weights = _quadrature(domain, degree)
    return Rule(np.ascontiguousarray(points.T), weights)


def _wedge_rule(degree: int) -> Rule:
    # scikit-fem's own rule for wedges integrates the volume 1/2 to 1/4 (version 12.0.2).
    (triangle, w), (line, v) = _quadrature("RefTri", degree), _quadrature("RefLine", degree)
    points = [(x, y, z) for x, y in triangle.T for z in line[0]]
    return Rule(np.array(points), np.outer(w, v).ravel())


def _conical_rule(n: int) -> Rule:
    """Exact to degree 2n − 1 on the tetrahedron, positive: Gauss–Jacobi rules, n in each direction.

    x = r, y = s (1 − r), z = t (1 − r)(1 − s) has the Jacobian (1 − r)² (1 − s) (Stroud, 1971).
    """
    (r, u), (s, v), (t, w) = (
        scipy.special.roots_jacobi(n, power, 0.0) for power in (2.0, 1.0, 0.0)
    )
    r, s, t = np.meshgrid((1 + r) / 2, (1 + s) / 2, (1 + t) / 2, indexing="ij")
    points = np.stack([r, s * (1 - r), t * (1 - r) * (1 - s)], axis=-1).reshape(-1, 3)
    weights = np.einsum("i,j,k->ijk", u / 8, v / 4, w / 2).ravel()
    return Rule(points, weights)


def _tetrahedra_of_a_brick() -> FloatArray:
    """Six tetrahedra about one diagonal, each along the axes in another order."""
    orders = [np.eye(3)[list(order)] for order in permutations(range(3))]
    pieces = np.stack([np.cumsum([[0, 0, 0], *order], axis=0) for order in orders])
    odd = np.linalg.det(pieces[:, 1:]) < 0.0
    pieces[odd] = pieces[odd][:, [0, 2, 1, 3]]
    return pieces


def _cell(
    linear: str, corners: Any, normals: Any, summed: int, of_brick: FloatArray | None = None
) -> Cell:
    places = np.array(corners, dtype=np.float64)
    pieces = places[None] if of_brick is None else of_brick
    return Cell(linear, places, np.array(normals, dtype=np.float64), summed, pieces)


_TETRAHEDRON = _cell(
    "tetra",
    corners=((0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)),
    normals=((-1, 0, 0), (0, -1, 0), (0, 0, -1), (1, 1, 1)),
    summed=3,
    of_brick=_tetrahedra_of_a_brick(),
)
_HEXAHEDRON = _cell(
    "hexahedron",
    corners=(
        *((0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)),
        *((0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)),
    ),
    normals=((-1, 0, 0), (0, -1, 0), (0, 0, -1), (1, 0, 0), (0, 1, 0), (0, 0, 1)),
    summed=0,
)
_WEDGE_CORNERS = np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (0, 1, 1)])
_WEDGE = _cell(
    "wedge",
    corners=_WEDGE_CORNERS,
    normals=((-1, 0, 0), (0, -1, 0), (1, 1, 0), (0, 0, -1), (0, 0, 1)),
    summed=2,
    of_brick=np.stack([_WEDGE_CORNERS, _WEDGE_CORNERS * [-1, -1, 1] + [1, 1, 0]]),
)

# The nodes after the corners, each in the middle of these corners (VTK's file-format figures).
_TETRAHEDRON_EDGES = ((0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3))
_HEXAHEDRON_EDGES = (
    *((0, 1), (1, 2), (2, 3), (0, 3)),
    *((4, 5), (5, 6), (6, 7), (4, 7)),
    *((0, 4), (1, 5), (2, 6), (3, 7)),
)
_HEXAHEDRON_FACES = (
    *((0, 3, 4, 7), (1, 2, 5, 6)),
    *((0, 1, 4, 5), (2, 3, 6, 7)),
    *((0, 1, 2, 3), (4, 5, 6, 7)),
)
_HEXAHEDRON_MIDDLES = (*_HEXAHEDRON_EDGES, *_HEXAHEDRON_FACES, tuple(range(8)))


@dataclass(frozen=True)
class _Kind:
    """What `ReferenceElement` is made from: scikit-fem's name of it, and rules when needed."""

    cell: Cell
    middles: tuple[tuple[int, ...], ...]
    basis: str
    stiffness_rule: Callable[[], Rule]
    mass_rule: Callable[[], Rule]


# Every kind of element, by meshio's name; nothing about a kind is said elsewhere.
#
# Degrees needed with curved sides, where the Jacobian is a polynomial too. Hexahedra of order p, in
# each coordinate: 3p − 1 for ∫∇φ dV, 5p − 1 for ∫φφ dV; tetrahedra, in all: 3p − 3 and 5p − 3.
# From "degree" 5 on, scikit-fem's positive rules for tetrahedra are exact to one degree less.
_ALL = {
    "tetra": _Kind(
        *(_TETRAHEDRON, (), "ElementTetP1"),
        *(partial(_rule, "RefTet", 1), partial(_rule, "RefTet", 2)),
    ),
    "tetra10": _Kind(
        *(_TETRAHEDRON, _TETRAHEDRON_EDGES, "ElementTetP2"),
        *(partial(_rule, "RefTet", 5), partial(_conical_rule, 4)),
    ),
    "hexahedron": _Kind(
        *(_HEXAHEDRON, (), "ElementHex1"),
        *(partial(_rule, "RefHex", 3), partial(_rule, "RefHex", 5)),
    ),
    "hexahedron20": _Kind(
        *(_HEXAHEDRON, _HEXAHEDRON_EDGES, "ElementHexS2"),
        *(partial(_rule, "RefHex", 5), partial(_rule, "RefHex", 9)),
    ),
    "hexahedron27": _Kind(
        *(_HEXAHEDRON, _HEXAHEDRON_MIDDLES, "ElementHex2"),
        *(partial(_rule, "RefHex", 5), partial(_rule, "RefHex", 9)),
    ),
    "wedge": _Kind(
        *(_WEDGE, (), "ElementWedge1"), *(partial(_wedge_rule, 2), partial(_wedge_rule, 4))
    ),
}

KINDS = tuple(_ALL)


@cache
def reference_element(kind: str) -> ReferenceElement:
    """Return the element of meshio's name `kind`, one of `KINDS`."""
    import skfem.element

    of = _ALL[kind]
    corners = of.cell.corners
    nodes = np.vstack([corners, *(corners[list(c)].mean(axis=0) for c in of.middles)])
    element = getattr(skfem.element, of.basis)()
    order = _match(nodes, np.asarray(element.doflocs, dtype=np.float64))
    return ReferenceElement(
        kind, of.cell, nodes, of.stiffness_rule(), of.mass_rule(), element, order
    )


def jacobians(corners: FloatArray, gradient: FloatArray) -> FloatArray:
    """Return J = ∂x_i/∂ξ_α, shape (3, 3, n_elements, n_points), axes (i, α, element, point).

    Parameters
    ----------
    corners : ndarray, shape (n_elements, n_nodes, 3)
        Coordinates of all nodes of the elements, m.
    gradient : ndarray, shape (n_points, n_nodes, 3)
        From `ReferenceElement.gradient`.
    """
    n_points, n_nodes, _ = gradient.shape
    x = corners.transpose(2, 0, 1).reshape(-1, n_nodes)
    j = x @ gradient.transpose(1, 2, 0).reshape(n_nodes, 3 * n_points)
    return j.reshape(3, len(corners), 3, n_points).transpose(0, 2, 1, 3)


def cofactors(j: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return det J and the cofactors C, J⁻ᵀ = C / det J, of `jacobians`."""
    cof = np.empty(j.shape)
    for i in range(3):
        for a in range(3):
            i1, i2, a1, a2 = (i + 1) % 3, (i + 2) % 3, (a + 1) % 3, (a + 2) % 3
            cof[i, a] = j[i1, a1] * j[i2, a2] - j[i1, a2] * j[i2, a1]
    det = j[0, 0] * cof[0, 0] + j[0, 1] * cof[0, 1] + j[0, 2] * cof[0, 2]
    return det, cof
