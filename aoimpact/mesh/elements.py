"""The solid elements: shape functions and quadrature of each kind, nodes in meshio's order.

Shape functions are scikit-fem's. Its nodes come in another order than meshio's (VTK's); the two
are matched by the nodes' places in the reference element, so there is no table of permutations
that could be wrong.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
import scipy

from ..base import FloatArray, IntArray

__all__ = ["KINDS", "ReferenceElement", "Rule", "cofactors", "jacobians", "reference_element"]


_TET = ((0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1))
_HEX = ((0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1))
_WEDGE = ((0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (0, 1, 1))

# The nodes after the corners, each in the middle of these corners (VTK's file-format figures).
_TET_EDGES = ((0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3))
_HEX_EDGES = (
    *((0, 1), (1, 2), (2, 3), (0, 3)),
    *((4, 5), (5, 6), (6, 7), (4, 7)),
    *((0, 4), (1, 5), (2, 6), (3, 7)),
)
_HEX_FACES = (
    *((0, 3, 4, 7), (1, 2, 5, 6)),
    *((0, 1, 4, 5), (2, 3, 6, 7)),
    *((0, 1, 2, 3), (4, 5, 6, 7)),
)
_HEX_MIDDLE = ((0, 1, 2, 3, 4, 5, 6, 7),)


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
    n_corners : int
        The first nodes are corners; the rest lie in the middle of edges, faces, and the body.
    nodes : ndarray, shape (n_nodes, 3)
        Reference coordinates of the nodes, meshio's order.
    stiffness_rule, mass_rule : Rule
        Exact for ∫∇φ dV, which the patch test needs, and for ∫φφ dV, on elements however curved.
    """

    kind: str
    n_corners: int
    nodes: FloatArray
    stiffness_rule: Rule
    mass_rule: Rule
    _basis: Any
    _order: IntArray

    @property
    def n_nodes(self) -> int:
        return len(self.nodes)

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


# Degrees needed with curved sides, where the Jacobian is a polynomial too. Hexahedra of order p, in
# each coordinate: 3p − 1 for ∫∇φ dV, 5p − 1 for ∫φφ dV; tetrahedra, in all: 3p − 3 and 5p − 3.
# From "degree" 5 on, scikit-fem's positive rules for tetrahedra are exact to one degree less.
def _build(kind: str) -> ReferenceElement:
    import skfem.element

    corners, middles, basis, stiffness, mass = {
        "tetra": (_TET, (), "ElementTetP1", _rule("RefTet", 1), _rule("RefTet", 2)),
        "tetra10": (_TET, _TET_EDGES, "ElementTetP2", _rule("RefTet", 5), _conical_rule(4)),
        "hexahedron": (_HEX, (), "ElementHex1", _rule("RefHex", 3), _rule("RefHex", 5)),
        "hexahedron20": (_HEX, _HEX_EDGES, "ElementHexS2", _rule("RefHex", 5), _rule("RefHex", 9)),
        "hexahedron27": (
            *(_HEX, _HEX_EDGES + _HEX_FACES + _HEX_MIDDLE, "ElementHex2"),
            *(_rule("RefHex", 5), _rule("RefHex", 9)),
        ),
        "wedge": (_WEDGE, (), "ElementWedge1", _wedge_rule(2), _wedge_rule(4)),
    }[kind]
    places = np.array(corners, dtype=np.float64)
    nodes = np.vstack([places, *(places[list(c)].mean(axis=0) for c in middles)])
    element = getattr(skfem.element, basis)()
    order = _match(nodes, np.asarray(element.doflocs, dtype=np.float64))
    return ReferenceElement(kind, len(corners), nodes, stiffness, mass, element, order)


KINDS = ("tetra", "tetra10", "hexahedron", "hexahedron20", "hexahedron27", "wedge")


@cache
def reference_element(kind: str) -> ReferenceElement:
    """Return the element of meshio's name `kind`, one of `KINDS`."""
    return _build(kind)


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
