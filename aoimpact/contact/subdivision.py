"""Quadrature on the faces and cells of a mesh, refined towards a point.

Faces and cells are cut into triangles and tetrahedra in their reference coordinates. Triangles and
tetrahedra are split repeatedly until they are small compared with their distance from the point.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from itertools import pairwise

import numpy as np
import scipy

from ..base import ArrayPair, FloatArray, IntArray, in_batches
from ..mesh import Block, ReferenceElement, cofactors

# Number of points per direction of the product rules, which are exact to degree 5 on triangles and
# 3 on tetrahedra.
_ON_SIDE, _IN_CELL = 3, 2

# `_SIDES`, `_CELLS`: largest ratio of the size of triangles and tetrahedra to their distance from
# the point, or to _FLOOR contact radii a if that is larger. Tetrahedra are halved at most _MOST
# times: further halvings change the body's compliance R by less than 5e-5/(E* a).
_SIDES, _CELLS, _FLOOR, _MOST = 0.3, 2.4, 0.6, 3


@dataclass(frozen=True, eq=False)
class Points:
    """Quadrature points on n pieces of faces or cells of a block, q on each piece.

    Attributes
    ----------
    rows : ndarray of int, shape (n,)
        Index of each piece's cell in its block.
    x : ndarray, shape (n, q, 3)
        Coordinates, m.
    shape : ndarray, shape (n, q, nodes per cell)
        Shape functions.
    slopes : ndarray, shape (n, q, nodes per cell, 3)
        Derivatives of the shape functions along x, y, z, 1/m.
    weight : ndarray, shape (n, q)
        Weights in cells, m³; 1 on faces, since `area` contains the weights.
    area : ndarray, shape (n, q, 3)
        Weighted outward area vectors of faces, m²; zero for cells.
    """

    rows: IntArray
    x: FloatArray
    shape: FloatArray
    slopes: FloatArray
    weight: FloatArray
    area: FloatArray


def sides_towards(
    nodes: FloatArray,
    block: Block,
    rows: IntArray,
    corners: FloatArray,
    point: FloatArray,
    a: float,
) -> Iterator[Points]:
    """Yield quadrature points on one face of cells.

    Parameters
    ----------
    nodes : ndarray, shape (n_nodes, 3)
        Coordinates, m.
    block : Block
    rows : ndarray of int
        Indices of the cells in the block.
    corners : ndarray, shape (3 or 4, 3)
        Reference coordinates of the face's corners, counter-clockwise seen from outside.
    point : ndarray, shape (3,)
        Point towards which the quadrature is refined, m.
    a : float
        Length over which the integrand varies near the point, m.
    """
    halves = np.stack([corners[[0, i, i + 1]] for i in range(1, len(corners) - 1)])
    yield from _towards(nodes, block, rows, halves, point, a, _SIDES, np.inf)


def cells_towards(
    nodes: FloatArray, block: Block, rows: IntArray, point: FloatArray, a: float
) -> Iterator[Points]:
    """Yield quadrature points in cells of a block; for the parameters see `sides_towards`."""
    corners = block.element.cell.corners
    pieces = corners[np.array(_TETRAHEDRA[len(corners)])]
    yield from _towards(nodes, block, rows, pieces, point, a, _CELLS, _MOST)


def _towards(
    nodes: FloatArray,
    block: Block,
    rows: IntArray,
    pieces: FloatArray,
    point: FloatArray,
    a: float,
    limit: float,
    most: float,
) -> Iterator[Points]:
    element, split = block.element, _CHILDREN[pieces.shape[1]]
    rows, vertices = np.repeat(rows, len(pieces)), np.tile(pieces, (len(rows), 1, 1))
    level = 0
    while len(rows):
        d = vertices.shape[1]
        shape, _ = _evaluated(element, vertices, np.eye(d))
        corner = shape @ nodes[block.cells[rows]]
        size = np.linalg.norm(corner[:, :, None] - corner[:, None], axis=3).max(axis=(1, 2))
        away = np.linalg.norm(corner.mean(axis=1) - point, axis=1) - 0.5 * size
        large = (size > limit * np.maximum(away, _FLOOR * a)) & (level < most)
        yield from _points(nodes, block, rows[~large], vertices[~large])
        vertices = np.einsum("cvw,nwi->ncvi", split, vertices[large]).reshape(-1, d, 3)
        rows, level = np.repeat(rows[large], len(split)), level + 1


def _evaluated(element: ReferenceElement, vertices: FloatArray, shares: FloatArray) -> ArrayPair:
    """Return shape functions and gradients at barycentric points, once for equal simplices."""
    flat, place = np.unique(vertices.reshape(len(vertices), -1), axis=0, return_inverse=True)
    different = flat.reshape(-1, *vertices.shape[1:])
    shape, gradient = element.evaluate((shares @ different).reshape(-1, 3))
    size = len(different), len(shares), element.n_nodes
    return shape.reshape(size)[place.ravel()], gradient.reshape(*size, 3)[place.ravel()]


def _points(
    nodes: FloatArray, block: Block, rows: IntArray, vertices: FloatArray
) -> Iterator[Points]:
    d = vertices.shape[1] - 1
    shares, weight = _simplex_rule(d)
    for which in in_batches(len(rows), 24.0 * len(weight) * block.cells.shape[1]):
        some, corners = rows[which], vertices[which]
        shape, gradient = _evaluated(block.element, corners, shares)
        places = nodes[block.cells[some]]
        jacobian = gradient.swapaxes(2, 3) @ places[:, None]
        det, cofactor = cofactors(jacobian.transpose(3, 2, 0, 1))
        slopes = gradient @ (cofactor / det).transpose(2, 3, 1, 0)
        edges = corners[:, 1:] - corners[:, :1]
        if d == 2:
            along = np.einsum("net,nqti->nqei", edges, jacobian)
            area = weight[:, None] * np.cross(along[:, :, 0], along[:, :, 1])
            volume = np.ones(shape.shape[:2])
        else:
            volume = weight * np.abs(np.linalg.det(edges))[:, None] * det
            area = np.zeros((*shape.shape[:2], 3))
        x = shape @ places
        if block.signs is not None:
            signs = block.signs[some][:, None]
            shape, slopes = signs * shape, signs[..., None] * slopes
        yield Points(some, x, shape, slopes, volume, area)


@cache
def _simplex_rule(d: int) -> ArrayPair:
    """Return barycentric points (q, d + 1) and weights of Gauss–Jacobi rules (Stroud, 1971).

    The map x₁ = r₁, x₂ = r₂ (1 - r₁), … has the Jacobian (1 - r₁)^(d-1) (1 - r₂)^(d-2) …
    """
    count = _ON_SIDE if d == 2 else _IN_CELL
    points, weights, rest = np.zeros((1, 0)), np.ones(1), np.ones(1)
    for power in range(d - 1, -1, -1):
        r, w = scipy.special.roots_jacobi(count, float(power), 0.0)
        r, w = 0.5 * (1.0 + r), w / 2.0 ** (power + 1)
        column = np.outer(rest, r).reshape(-1, 1)
        points = np.hstack([np.repeat(points, count, axis=0), column])
        weights, rest = np.outer(weights, w).ravel(), np.outer(rest, 1.0 - r).ravel()
    return np.hstack([1.0 - points.sum(axis=1, keepdims=True), points]), weights


def _children(d: int, inside: list[list[tuple[int, int]]]) -> FloatArray:
    """Return the barycentric coordinates of the vertices of a split simplex's parts.

    There is one part at each vertex; `inside` lists the other parts. All vertices are midpoints of
    two vertices of the simplex, given as pairs.
    """
    unit, each = np.eye(d + 1), range(d + 1)
    pieces = [[(i, j) for j in each] for i in each] + inside
    return np.array([[0.5 * (unit[i] + unit[j]) for i, j in piece] for piece in pieces])


# A triangle is split into four. A tetrahedron is split into four corners and an octahedron. The
# octahedron is split into four along its diagonal from edge 02 to edge 13 (J. Bey, Computing 55,
# 355, 1995). `_AROUND`: edges around this diagonal, in order.
_AROUND = [(0, 1), (0, 3), (2, 3), (1, 2), (0, 1)]
_CHILDREN = {
    3: _children(2, [[(0, 1), (1, 2), (0, 2)]]),
    4: _children(3, [sorted([*edges, (0, 2), (1, 3)]) for edges in pairwise(_AROUND)]),
}

# Division of cells into tetrahedra, by number of corners; the tetrahedra of a brick share its
# diagonal 0 6.
_BRICK = (1, 2, 3, 7, 4, 5, 1)
_TETRAHEDRA = {
    4: ((0, 1, 2, 3),),
    5: ((0, 1, 2, 4), (0, 2, 3, 4)),
    6: ((0, 1, 2, 5), (0, 1, 5, 4), (0, 4, 5, 3)),
    8: tuple((0, _BRICK[i], _BRICK[i + 1], 6) for i in range(6)),
}
