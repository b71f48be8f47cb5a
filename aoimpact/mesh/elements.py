"""Shape functions and quadrature rules of each kind of element, with nodes in meshio's order.

A kind is defined by its nodes and by the space of functions that its shape functions span. Each
shape function is one at its own node and zero at the others.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cache, cached_property
from itertools import combinations, product
from typing import Any

import numpy as np
import scipy

from ..base import ROUNDING, ArrayPair, FloatArray, IntArray, record


@record
class Cell:
    """The shape of a reference element, shared by elements of several orders.

    Attributes
    ----------
    linear : str
        The kind of element whose nodes are the corners alone.
    corners : ndarray, shape (n_corners, 3)
    normals : ndarray, shape (n_sides, 3)
        Outward normals of the sides, of any length; for a surface cell, normals of its edges.
    of_brick : ndarray, shape (n_cells, n_corners, 3)
        Corners of the cells of this shape that together fill the unit brick.
    """

    linear: str
    corners: FloatArray
    normals: FloatArray
    of_brick: FloatArray

    def inside(self, place: FloatArray) -> FloatArray:
        """Return a point, (3,), moved onto the surface towards the middle if it was outside."""
        middle = self.corners.mean(axis=0)
        beyond = self.normals @ (place - middle)
        room = (self.corners @ self.normals.T).max(axis=0) - self.normals @ middle
        drawn: FloatArray = middle + (place - middle) / max(1.0, float((beyond / room).max()))
        return drawn


@record
class Rule:
    """A quadrature rule on the reference element: points (n, 3), weights (n,), all positive."""

    points: FloatArray
    weights: FloatArray


@record
class ReferenceElement:
    """One kind of element, described in reference coordinates.

    Attributes
    ----------
    kind : str
        meshio's name, followed by "+" if the element is enriched.
    cell : Cell
    nodes : ndarray, shape (n_nodes, 3)
        Reference coordinates of the nodes in meshio's order: the corners first, then the middles of
        edges, faces and the element.
    """

    kind: str
    cell: Cell
    nodes: FloatArray
    _points: Sequence[int]
    _basis: _Basis

    @cached_property
    def stiffness_rule(self) -> Rule:
        """Rule for stiffness, exact for ∫∇φ dV on curved elements, as the patch test needs."""
        return _quadrature(self.cell.linear, self._points[0])

    @cached_property
    def mass_rule(self) -> Rule:
        """Rule for mass, exact for ∫φφ dV on curved elements."""
        return _quadrature(self.cell.linear, self._points[1])

    @property
    def n_nodes(self) -> int:
        return len(self.nodes)

    @property
    def n_corners(self) -> int:
        return len(self.cell.corners)

    @property
    def linear(self) -> ReferenceElement:
        """The first-order element on the same corners, which may be this element."""
        return self if self.kind == self.cell.linear else reference_element(self.cell.linear)

    @property
    def own(self) -> ReferenceElement:
        """This element without the functions that `enriched_element` adds."""
        return reference_element(self.kind.removesuffix("+"))

    @property
    def lower(self) -> ReferenceElement:
        """The element without its enrichment or, if it has none, the linear one on its corners."""
        return self.own if self.kind[-1] == "+" else self.linear

    def shape(self, points: FloatArray) -> FloatArray:
        """Return the shape functions φ_a at reference points (n, 3), shape (n, n_nodes)."""
        return self.evaluate(points)[0]

    def gradient(self, points: FloatArray) -> FloatArray:
        """Return the derivatives ∂φ_a/∂ξ_α at reference points (n, 3), shape (n, n_nodes, 3)."""
        return self.evaluate(points)[1]

    def evaluate(self, points: FloatArray) -> ArrayPair:
        """Return `shape` and `gradient`, for little more work than either alone."""
        return self._basis(points)

    @property
    def quadratic(self) -> bool:
        """True if the element has nodes between its corners."""
        return self.n_nodes > self.n_corners

    @property
    def thin(self) -> bool:
        """True for surface and line elements, whose reference cells lie in z = 0."""
        return self.kind in THIN

    @cached_property
    def edges(self) -> IntArray:
        """The two end corners of each edge that has a middle node, shape (n_edges, 2)."""
        weights = self.linear.shape(self.nodes[self.n_corners :]) > ROUNDING
        return np.nonzero(weights[weights.sum(axis=1) == 2])[1].reshape(-1, 2)

    @property
    def mirror(self) -> IntArray:
        """Permutation of the nodes that turns a left-handed element into a right-handed one."""
        reflected = self.nodes[:, [1, 0, 2]]
        distance = np.abs(reflected[:, None, :] - self.nodes[None, :, :]).max(axis=2)
        order: IntArray = distance.argmin(axis=1)
        return order


@record
class ReferenceFace:
    """A side of a reference element, with surface coordinates u, v.

    Attributes
    ----------
    nodes : ndarray of int
        Numbers within the element of the side's nodes: the corners, counter-clockwise as seen from
        outside; the middle of the edge after each corner; the middle of the side.
    element : ReferenceElement
        The surface element on these nodes, with u, v ≥ 0: u + v ≤ 1 on a triangle, u, v ≤ 1 on a
        quadrilateral.
    """

    nodes: IntArray
    element: ReferenceElement

    @property
    def n_corners(self) -> int:
        return self.element.n_corners

    def evaluate(self, uv: FloatArray) -> ArrayPair:
        """Return shape functions φ_a, (n, n_nodes), and slopes ∂φ_a/∂(u, v), (n, n_nodes, 2)."""
        shape, gradient = self.element.evaluate(np.pad(uv, ((0, 0), (0, 1))))
        return shape, gradient[..., :2]


# Exponents (i, j, k, l) of a function xⁱ yʲ zᵏ (1 - z)⁻ˡ, each from 0 to 3.
_Powers = tuple[int, int, int, int]


@record
class _Basis:
    """Shape functions and their derivatives as combinations of xⁱ yʲ zᵏ (1 - z)⁻ˡ.

    Attributes
    ----------
    middle : float
        Origin of x, y and z: the middle of bricks, for small rounding errors; 0 for other elements.
    powers : ndarray of int, shape (m, 4)
        Exponents (i, j, k, l) of the functions that are combined.
    shape : ndarray, shape (m, n_nodes)
        Coefficients of the shape functions.
    gradient : ndarray, shape (m, 3 n_nodes)
        Coefficients of their derivatives: x, y and z of the first node, then of the next.
    """

    middle: float
    powers: IntArray
    shape: FloatArray
    gradient: FloatArray

    @classmethod
    def of(cls, space: tuple[_Powers, ...], nodes: FloatArray, middle: float) -> _Basis:
        """Return the nodal basis of a space: each function is one at one node, zero elsewhere."""
        # The derivative of a function along x, y or z is a number times a function of the same
        # form.
        slopes = [
            (axis, column, of, factor)
            for column, (i, j, k, m) in enumerate(space)
            for axis, of, factor in (
                (0, (i - 1, j, k, m), i),
                (1, (i, j - 1, k, m), j),
                (2, (i, j, k - 1, m), k),
                (2, (i, j, k, m + 1), m),
            )
            if factor
        ]
        every = dict.fromkeys([*space, *(of for _, _, of, _ in slopes)])
        place = {powers: i for i, powers in enumerate(every)}
        derivatives = np.zeros((len(every), 3, len(space)))
        for axis, column, of, factor in slopes:
            derivatives[place[of], axis, column] += factor
        found = np.array(list(every))
        at_nodes = _monomials(nodes - middle, found)[: len(space)]
        nodal = np.linalg.inv(at_nodes.T)
        shape = np.zeros((len(every), len(nodes)))
        shape[: len(space)] = nodal
        gradient = (derivatives @ nodal).swapaxes(1, 2).reshape(len(every), -1)
        return cls(middle, found, shape, gradient)

    def __call__(self, points: FloatArray) -> ArrayPair:
        values = _monomials(points - self.middle, self.powers).T
        shape = values @ self.shape
        return shape, (values @ self.gradient).reshape(*shape.shape, 3)


def _monomials(points: FloatArray, powers: IntArray) -> FloatArray:
    """Return xⁱ yʲ zᵏ (1 - z)⁻ˡ, shape (m, n); at the apex z = 1 the limit on x = y = 0."""
    base = points.T
    if powers[:, 3].any():
        base = np.vstack([base, 1.0 / np.maximum(1.0 - base[2], ROUNDING)])
    raised = np.stack([np.ones_like(base), base, base**2, base**3])
    found: FloatArray = raised[powers[:, 0], 0] * raised[powers[:, 1], 1]
    for axis in range(2, len(base)):
        found *= raised[powers[:, axis], axis]
    return found


def _quadrature(linear: str, n: int) -> Rule:
    """Return the Gauss rule of n points in each direction, exact to degree 2n − 1, on a cell.

    The unit brick is mapped to the cell, and Gauss-Jacobi rules with weights (1 − x_i)^power absorb
    the Jacobian of the map. In a wedge y = s (1 − x), in a tetrahedron also
    z = t (1 − x)(1 − s) (Stroud, 1971); in a pyramid x = a (1 − z) and y = b (1 − z).
    """
    if linear == "tetra" and n == 3:
        # Symmetric rule of 14 points, exact to degree 5: points on the lines from each corner to
        # the middle of the opposite side, and between the middles of opposite edges
        # (N. J. Walkington, Quadrature on simplices of arbitrary dimension, Carnegie Mellon 2000).
        # Of the four barycentric coordinates, all but `large` equal `small`.
        corners, found = np.vstack([np.zeros(3), np.eye(3)]), []
        for small, weight, large in (
            (0.31088591926330060980, 0.018781320953002641800, 1),
            (0.092735250310891226402, 0.012248840519393658257, 1),
            (0.045503704125649649492, 0.0070910034628469110730, 2),
        ):
            for which in combinations(range(4), large):
                shares = np.full(4, small)
                shares[list(which)] = (1.0 - (4 - large) * small) / large
                found.append([*(shares @ corners), weight])
        return Rule(np.array(found)[:, :3], np.array(found)[:, 3])
    powers = {"hexahedron": (0, 0, 0), "wedge": (1, 0, 0), "pyramid": (0, 0, 2), "tetra": (2, 1, 0)}
    rules = [scipy.special.roots_jacobi(n, power, 0.0) for power in powers[linear]]
    points = np.meshgrid(*((1.0 + x) / 2.0 for x, _ in rules), indexing="ij")
    weights = [w / 2.0 ** (k + 1) for (_, w), k in zip(rules, powers[linear], strict=True)]
    x, y, z = (along.reshape(-1) for along in points)
    if linear == "tetra":
        y, z = y * (1.0 - x), z * (1.0 - x) * (1.0 - y)
    elif linear == "wedge":
        y = y * (1.0 - x)
    elif linear == "pyramid":
        x, y = x * (1.0 - z), y * (1.0 - z)
    return Rule(np.stack([x, y, z], axis=-1), np.einsum("i,j,k->ijk", *weights).ravel())


_AXES = np.eye(3)
_SQUARE = np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)])
_BRICK = np.vstack([_SQUARE, _SQUARE + _AXES[2], np.full(3, 0.5)])  # eight corners, then the middle


def _cell(linear: str, corners: Any, normals: Any, of_brick: str) -> Cell:
    """Return a cell; `of_brick`: the cells that fill a brick, as digits that index `_BRICK`."""
    pieces = _BRICK[[[*map(int, piece)] for piece in of_brick.split()]]
    return Cell(linear, np.array(corners, float), np.array(normals, float), pieces)


_TETRAHEDRON = _cell(
    "tetra",
    np.vstack([np.zeros(3), _AXES]),
    np.vstack([-_AXES, np.ones(3)]),
    "0126 0516 0236 0376 0456 0746",  # six pieces around the diagonal from 0 to 6
)
_HEXAHEDRON = _cell("hexahedron", _BRICK[:8], np.vstack([-_AXES, _AXES]), "01234567")
_WEDGE = _cell(
    "wedge",
    _BRICK[[0, 1, 3, 4, 5, 7]],
    np.vstack([-_AXES[:2], [(1, 1, 0)], -_AXES[2], _AXES[2]]),
    "013457 231675",
)
_PYRAMID = _cell(
    "pyramid",
    _BRICK[:5],
    np.vstack([-_AXES[:2], _AXES[:2] + _AXES[2], -_AXES[2]]),
    "01238 03748 04518 54768 21568 73268",
)

# Cells of shells and beams. A surface has one side, whose normal is +z; a line has none.
_LINE = _cell("line", _BRICK[:2], np.vstack([-_AXES[0], _AXES[0]]), "01")
_QUAD = _cell("quad", _SQUARE, np.vstack([-_AXES[:2], _AXES[:2]]), "0123")
_TRIANGLE = _cell("triangle", _BRICK[[0, 1, 3]], np.vstack([-_AXES[:2], [(1, 1, 0)]]), "012 023")


def _space(degree: int, has: Callable[[int, int, int], bool]) -> tuple[_Powers, ...]:
    """Return the functions xⁱ yʲ zᵏ, with i, j, k ≤ `degree`, for which `has(i, j, k)` holds."""
    each = range(degree + 1)
    return tuple((i, j, k, 0) for i, j, k in product(each, each, each) if has(i, j, k))


# Spaces of functions. Hexahedra of 20 nodes: products quadratic in at most one coordinate, the
# serendipity space (D. Arnold & G. Awanou, Found. Comput. Math. 11, 337, 2011). Wedges of 15 nodes:
# quadratic functions of x, y times 1 and z, and linear functions of x, y times z². Pyramids of 13
# nodes: all quadratic functions, xy/(1-z), x²y/(1-z) and xy²/(1-z) (G. Bedrosian, Int. J. Num.
# Meth. Eng. 35, 95, 1992). Linear pyramids: all linear functions and xy/(1-z).
_TETRAHEDRON_4 = _space(1, lambda i, j, k: i + j + k <= 1)
_TETRAHEDRON_10 = _space(2, lambda i, j, k: i + j + k <= 2)
_HEXAHEDRON_8 = _space(1, lambda i, j, k: True)
_HEXAHEDRON_20 = _space(2, lambda i, j, k: (i, j, k).count(2) <= 1)
_HEXAHEDRON_27 = _space(2, lambda i, j, k: True)
_WEDGE_6 = _space(1, lambda i, j, k: i + j <= 1)
_WEDGE_15 = _space(2, lambda i, j, k: i + j <= (2 if k < 2 else 1))
_PYRAMID_5 = (*_TETRAHEDRON_4, (1, 1, 0, 1))
_PYRAMID_13 = (*_TETRAHEDRON_10, (1, 1, 0, 1), (2, 1, 0, 1), (1, 2, 0, 1))


_EDGES = "01 12 23 03 45 56 67 47 04 15 26 37"  # corners of each edge of a hexahedron
_FACES = "0347 1256 0145 2367 0123 4567"

# All kinds of elements, by meshio's names: the cell; for each node after the corners, the corners
# in whose middle it lies (VTK's file-format figures); the space of functions; and the numbers of
# quadrature points in each direction, for stiffness and for mass.
#
# Polynomial degrees to be integrated on elements of order p with curved sides, where the Jacobian
# is a polynomial too, for ∫∇φ dV and ∫φφ dV. Hexahedra: 3p − 1 and 5p − 1 in each coordinate;
# tetrahedra: 3p − 3 and 5p − 3 in total; wedges: 3p − 2 and 5p − 2 in the triangle; pyramids: 3p
# and 5p in x/(1-z) and y/(1-z).
_ALL: dict[str, tuple[Cell, str, tuple[_Powers, ...], int, int]] = {
    "tetra": (_TETRAHEDRON, "", _TETRAHEDRON_4, 1, 2),
    "tetra10": (_TETRAHEDRON, "01 12 02 03 13 23", _TETRAHEDRON_10, 3, 4),
    "hexahedron": (_HEXAHEDRON, "", _HEXAHEDRON_8, 2, 3),
    "hexahedron20": (_HEXAHEDRON, _EDGES, _HEXAHEDRON_20, 3, 5),
    "hexahedron27": (_HEXAHEDRON, f"{_EDGES} {_FACES} 01234567", _HEXAHEDRON_27, 3, 5),
    "wedge": (_WEDGE, "", _WEDGE_6, 2, 3),
    "wedge15": (_WEDGE, "01 12 02 34 45 35 03 14 25", _WEDGE_15, 3, 5),
    "pyramid": (_PYRAMID, "", _PYRAMID_5, 2, 3),
    "pyramid13": (_PYRAMID, "01 12 23 03 04 14 24 34", _PYRAMID_13, 4, 6),
}

# Cubic spaces of elements of second order, for `enriched_element`: the trunk space of degree 3
# (B. Szabó and I. Babuška, Finite Element Analysis, 1991, section 6.1); the triangular sides that
# have a bubble function; and the numbers of quadrature points for stiffness and mass.
_TRUNK = _space(3, lambda *powers: sum(n > 1 for n in powers) <= 1)
_CUBIC: dict[str, tuple[tuple[_Powers, ...], str, int, int]] = {
    "tetra10": (_space(3, lambda i, j, k: i + j + k <= 3), "012 013 023 123", 4, 4),
    "hexahedron20": (_TRUNK, "", 4, 5),
    "hexahedron27": (_TRUNK, "", 4, 5),
    "wedge15": (_space(3, lambda i, j, k: i + j <= (3 if k < 2 else 1)), "012 345", 4, 5),
}

# Kinds of solid elements. Elements of shells, beams and sides of solids, added to `_ALL` below,
# need no quadrature rule here; their functions are those of a solid, restricted to a side or an
# edge in z = 0.
KINDS = tuple(_ALL)
_ALL |= {
    kind: (cell, middles, tuple(of for of in space if not any(of[n_axes:])), 1, 1)
    for kind, n_axes, cell, middles, space in (
        ("line", 1, _LINE, "", _HEXAHEDRON_8),
        ("line3", 1, _LINE, "01", _HEXAHEDRON_20),
        ("triangle", 2, _TRIANGLE, "", _TETRAHEDRON_4),
        ("triangle6", 2, _TRIANGLE, "01 12 02", _TETRAHEDRON_10),
        ("quad", 2, _QUAD, "", _HEXAHEDRON_8),
        ("quad8", 2, _QUAD, "01 12 23 03", _HEXAHEDRON_20),
        ("quad9", 2, _QUAD, "01 12 23 03 0123", _HEXAHEDRON_27),
    )
}
THIN = ("quad", "triangle", "line")

# The second-order kind for each first-order kind: for hexahedra hexahedron20, which is assigned
# after hexahedron27.
RAISED = {_ALL[kind][0].linear: kind for kind in reversed(KINDS) if _ALL[kind][1]}

# Kinds of surface elements by their numbers of nodes.
SURFACES = {3: "triangle", 4: "quad", 6: "triangle6", 8: "quad8", 9: "quad9"}


@cache
def reference_element(kind: str) -> ReferenceElement:
    """Return the element of meshio's name `kind`; a final "+" asks for `enriched_element`."""
    if kind[-1] == "+" and (found := enriched_element(kind[:-1])) is not None:
        return found[0]
    cell, middles, space, *points = _ALL[kind]
    means = (cell.corners[[*map(int, of)]].mean(axis=0) for of in middles.split())
    nodes = np.vstack([cell.corners, *means])
    basis = _Basis.of(space, nodes, 0.5 if cell is _HEXAHEDRON else 0.0)
    return ReferenceElement(kind, cell, nodes, points, basis)


# Kinds of solid elements by their numbers of nodes.
SOLIDS = {reference_element(kind).n_nodes: kind for kind in KINDS}


@cache
def enriched_element(kind: str) -> tuple[ReferenceElement, list[list[int]]] | None:
    """Return an element with added functions of the next degree, and the corners of each function.

    The added functions are zero at the element's own nodes. There is one on each edge, of the next
    degree (odd about the middle of the edge if that is a node), and a bubble on each triangular
    side of second order.

    Returns
    -------
    element : ReferenceElement
        Each added function has a node, where it is 1 and the other added functions are 0.
    corners : list of lists of int
        Corners of the edge or side of each added function. An odd function changes its sign if the
        corners are swapped.
    None
        For pyramids of second order, shells and beams.
    """
    own = reference_element(kind)
    if own.thin or (own.quadratic and kind not in _CUBIC):
        return None
    if own.quadratic:
        (space, sides, *points), edges = _CUBIC[kind], own.edges
    else:
        (_, _, space, *points), sides = _ALL[RAISED[kind]], ""
        edges = reference_element(RAISED[kind]).edges
    corners, added = own.cell.corners, [*edges.tolist(), *([*map(int, of)] for of in sides.split())]
    first, last = corners[edges].swapaxes(0, 1)
    on_edges = first + (last - first) / (3.0 if own.quadratic else 2.0)
    middles = [corners[of].mean(axis=0) for of in added[len(edges) :]]
    # Second order: a cubic that is zero at both ends and in the middle of an edge is odd, and
    # nonzero elsewhere, so that any other point of the edge can be its node.
    known = own.nodes[: len(corners) + own.quadratic * len(edges)]
    places = np.vstack([known, on_edges, *middles])
    nodal, basis = _Basis.of(space, places, own._basis.middle), own._basis
    both = _Basis(
        basis.middle,
        np.vstack([basis.powers, nodal.powers]),
        scipy.linalg.block_diag(basis.shape, nodal.shape[:, len(known) :]),
        scipy.linalg.block_diag(basis.gradient, nodal.gradient[:, 3 * len(known) :]),
    )
    nodes = np.vstack([own.nodes, places[len(known) :]])
    return ReferenceElement(f"{kind}+", own.cell, nodes, points, both), added


@cache
def reference_faces(kind: str) -> tuple[ReferenceFace, ...]:
    """Return the sides of the element of meshio's name `kind`.

    On a side, the shape functions of every kind of element are those of the surface element on the
    side's nodes. A surface element is its own side.
    """
    element, found = reference_element(kind), []
    sides = element.cell.normals
    if element.thin:
        sides = np.eye(3)[[] if kind == "line" else [2]]
    for normal in sides:
        height = element.nodes @ normal
        on = np.flatnonzero(np.abs(height - height.max()) < ROUNDING)
        corner = on < element.n_corners
        arms = element.nodes[on] - element.nodes[on[corner]].mean(axis=0)
        turn = np.arctan2(arms @ np.cross(normal, arms[0]), arms @ arms[0] * np.linalg.norm(normal))
        first = 0.0 if element.thin else turn[corner].min()  # surface elements keep their corner 0
        turn = np.round(turn - first, 9) % (2.0 * np.pi)
        middle = np.linalg.norm(arms, axis=1) < ROUNDING
        nodes = on[np.lexsort((turn, middle, ~corner))]
        found.append(ReferenceFace(nodes, reference_element(SURFACES[len(nodes)])))
    return tuple(found)


def jacobians(corners: FloatArray, gradient: FloatArray) -> FloatArray:
    """Return J = ∂x_i/∂ξ_α, shape (3, 3, n_elements, n_points), axes (i, α, element, point).

    Parameters
    ----------
    corners : ndarray, shape (n_elements, n_nodes, 3)
        Coordinates of all nodes of the elements, m.
    gradient : ndarray, shape (n_points, n_nodes, 3)
        ∂φ_a/∂ξ_α from `ReferenceElement.gradient`.
    """
    n_points, n_nodes, _ = gradient.shape
    x = corners.transpose(2, 0, 1).reshape(-1, n_nodes)
    slopes = gradient.transpose(1, 2, 0).reshape(n_nodes, 3 * n_points)
    j = np.einsum("xn,nq->xq", x, slopes)  # BLAS would vary in the last bits with threads
    found: FloatArray = j.reshape(3, len(corners), 3, n_points).transpose(0, 2, 1, 3)
    return found


def cofactors(j: FloatArray) -> ArrayPair:
    """Return det J and the cofactors C of J from `jacobians`: J⁻ᵀ = C / det J."""
    cof = np.empty(j.shape)
    for i, a in product(range(3), repeat=2):  # negative indices count from the end
        cof[i, a] = j[i - 2, a - 2] * j[i - 1, a - 1] - j[i - 2, a - 1] * j[i - 1, a - 2]
    det = j[0, 0] * cof[0, 0] + j[0, 1] * cof[0, 1] + j[0, 2] * cof[0, 2]
    return det, cof


def meshio_of_all_kinds() -> Any:
    """Return meshio, extended by `KINDS` that its readers return but its `Mesh` rejects."""
    import meshio  # slow to import
    from meshio._mesh import topological_dimension

    for kind in KINDS:
        topological_dimension.setdefault(kind, 3)
    return meshio
