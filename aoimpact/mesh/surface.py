"""The surface of a mesh: sides of solids that no other element shares, and surface elements."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cached_property

import numpy as np

from ..base import (
    PRINTED,
    ROUNDING,
    ArrayPair,
    BoolArray,
    FloatArray,
    IntArray,
    Kept,
    MeshError,
    in_batches,
    record,
    sp,
)
from .elements import ReferenceFace, reference_faces
from .mesh import AT_NODE, SHARP, Mesh, twins
from .vectors import unit

# `ITERATIONS`: maximum number of Newton steps, enough wherever a solution exists. `_LONGEST`:
# longest step in u and v (0 to 1 on a side). Longer steps leave the side for good or oscillate.
ITERATIONS, _LONGEST = 25, 0.5

# Distance of u or v from 0.5 beyond which a Newton iteration is stopped, since it does not return
# to the side.
_LOST = 1.5

# Largest sum of abs(φ_a) over the nodes between the corners of a side: 2 in the middle of sides of
# eight nodes, 4/3 on sides of six nodes, 1.39 on sides of nine.
_BETWEEN = 2.0

# Number of points whose nearest points on the surface are cached: enough for a few contacts.
_REMEMBERED = 16


@record
class Place:
    """Points on the surface of a mesh.

    Attributes
    ----------
    face : ndarray of int, shape (n,)
        Number of the face in `Surface` that holds each point; -1 if no point was found.
    uv : ndarray, shape (n, 2)
        Coordinates u, v of the points on their faces.
    x : ndarray, shape (n, 3)
        Coordinates of the points, m.
    distance : ndarray, shape (n,)
        Distances from the points given to the search, m.
    """

    face: IntArray
    uv: FloatArray
    x: FloatArray
    distance: FloatArray


@record
class Surface:
    """The boundary of a mesh.

    Attributes
    ----------
    mesh : Mesh
    cell : ndarray of int, shape (n_faces,)
        Number of the element that each face belongs to.
    side : ndarray of int, shape (n_faces,)
        Index in `sides` of each face.
    joined : ndarray of int, shape (any, 2)
        Pairs of elements that share a side.
    sides : list of (int, ReferenceFace)
        All sides of all kinds of elements in the mesh: the number of the block, and the side.
    """

    mesh: Mesh
    cell: IntArray
    side: IntArray
    joined: IntArray
    sides: list[tuple[int, ReferenceFace]]

    @cached_property
    def part(self) -> IntArray:
        """For each element, the number of its connected part; elements are connected by sides."""
        n = self.mesh.n_cells
        links = sp.coo_array((np.ones(len(self.joined), bool), tuple(self.joined.T)), shape=(n, n))
        part: IntArray = sp.csgraph.connected_components(links, directed=False)[1].astype(np.int64)
        return part

    @cached_property
    def nodes(self) -> IntArray:
        """Node numbers of each face, corners first; short rows repeat their first node."""
        width = max(4, *(len(face.nodes) for _, face in self.sides))
        rows = [[*of.nodes, *[of.nodes[0]] * (width - len(of.nodes))] for _, of in self.sides]
        return np.take_along_axis(self.mesh.cells[self.cell], np.array(rows)[self.side], axis=1)

    def thin(self, face: IntArray) -> BoolArray:
        """Return which faces are surface elements of shells, which have two sides."""
        return np.array([self.mesh.blocks[i].element.thin for i, _ in self.sides])[self.side[face]]

    @cached_property
    def balls(self) -> ArrayPair:
        """Centres, shape (n_faces, 3), and radii of balls that enclose each face."""
        x, bulge = self.mesh.nodes[self.nodes], self.bulges(np.arange(len(self.cell)))
        centre, room = x.mean(axis=1), _BETWEEN * np.linalg.norm(bulge, axis=2).max(axis=1)
        radius = np.linalg.norm(x[:, :4] - centre[:, None], axis=2).max(axis=1) + room
        return centre, (1.0 + PRINTED) * radius

    @cached_property
    def _counts(self) -> IntArray:
        """Number of nodes on each of `sides`."""
        return np.array([len(face.nodes) for _, face in self.sides])

    def of_count(self, face: IntArray) -> Iterator[tuple[ReferenceFace, IntArray]]:
        """Yield, for each number of nodes, a side and the rows of `face` with that many nodes."""
        counts = self._counts[self.side[face]]
        for count in np.unique(counts):
            side = self.sides[int((self._counts == count).argmax())][1]
            yield side, np.flatnonzero(counts == count)

    def shape(self, face: IntArray, uv: FloatArray) -> FloatArray:
        """Return the values of the shape functions of the faces' `nodes`, shape (n, width)."""
        return self._evaluate(face, uv)[0]

    def at(self, face: IntArray, uv: FloatArray) -> ArrayPair:
        """Return x, shape (n, 3), and ∂x/∂u, ∂x/∂v, shape (n, 2, 3), of points on faces."""
        nodes = self.mesh.nodes[self.nodes[face]]
        shape, gradient = self._evaluate(face, uv)
        return np.einsum("na,nai->ni", shape, nodes), gradient.swapaxes(1, 2) @ nodes

    def _evaluate(self, face: IntArray, uv: FloatArray) -> ArrayPair:
        """Return shape functions and gradients, padded with zeros like the rows of `nodes`."""
        width = self.nodes.shape[1]
        shape, gradient = np.zeros((len(face), width)), np.zeros((len(face), width, 2))
        for side, on in self.of_count(face):
            n = len(side.nodes)
            shape[on, :n], gradient[on, :n] = side.evaluate(uv[on])
        return shape, gradient

    def normal(self, face: IntArray, uv: FloatArray) -> FloatArray:
        """Return outward unit normals, (n, 3); at a collapsed corner, those close to the corner.

        Raises
        ------
        MeshError
            If a side has no area.
        """
        normal, flat = self._crossed(face, uv)
        if flat.any():
            beside = uv[flat] + AT_NODE * (self.middle(face[flat]) - uv[flat])
            normal[flat], still = self._crossed(face[flat], beside)
            if still.any():
                cell = int(self.cell[face[flat][still]][0])
                nodes = self.mesh.cells[cell].tolist()
                raise MeshError(f"mesh: a side of element {cell}, nodes {nodes}, has no area")
        return unit(normal)

    def _crossed(self, face: IntArray, uv: FloatArray) -> tuple[FloatArray, BoolArray]:
        """Return ∂x/∂u × ∂x/∂v, and where this product is zero apart from rounding."""
        tangents = self.at(face, uv)[1]
        normal = np.cross(tangents[:, 0], tangents[:, 1])
        longest = (tangents**2).sum(axis=2).max(axis=1)
        return normal, np.linalg.norm(normal, axis=1) <= PRINTED * longest

    def edges(self, face: IntArray) -> FloatArray:
        """Return the mean length of the straight edges of each face, m, shape (n,)."""
        corner = self.mesh.nodes[self.corners(face)]
        lengths = np.linalg.norm(np.diff(corner, axis=1, append=corner[:, :1]), axis=2)
        return np.asarray(lengths.sum(axis=1) / np.where(self._triangles[face], 3, 4))

    def middle(self, face: IntArray) -> FloatArray:
        """Return the coordinates (u, v) of the faces' middles, shape (n, 2)."""
        return np.where(self._triangles[face], 1.0 / 3.0, 0.5)[:, None] * np.ones(2)

    def corners(self, face: IntArray) -> IntArray:
        """Return the corners around each face, shape (n, 4); triangles repeat the first corner."""
        corners = self.nodes[face, :4]
        triangle = self._triangles[face]
        corners[triangle, 3] = corners[triangle, 0]
        return corners

    def ends(self, face: IntArray) -> IntArray:
        """Return the two nodes, sorted, of the edge after each of `corners`, shape (n, 4, 2)."""
        corners = self.corners(face)
        return np.sort(np.stack([corners, np.roll(corners, -1, axis=1)], axis=2), axis=2)

    def nearest(self, point: FloatArray) -> Place:
        """Return the nearest point of the surface, once for each face that it lies on.

        Where a web of shells ends on a skin, only the faces of the skin are returned.
        """
        return self._places.get(point.tobytes(), lambda: self._nearest(point))

    @cached_property
    def _places(self) -> Kept:
        """Cache of `nearest`: a contact asks for the same point many times."""
        return Kept(_REMEMBERED)

    def _nearest(self, point: FloatArray) -> Place:
        centre, radius = self.balls
        distance = np.linalg.norm(centre - point, axis=1)
        face = np.flatnonzero(distance - radius <= (distance + radius).min())
        uv = self.middle(face)
        for _ in range(ITERATIONS):
            x, tangents = self.at(face, uv)
            gap = np.einsum("nui,ni->nu", tangents, point - x)
            before = uv
            step = _solved(tangents @ tangents.swapaxes(1, 2), gap)
            u, v = np.clip(uv + step, 0.0, 1.0).T  # the next lines enforce u + v ≤ 1 on triangles
            excess = np.where(self._triangles[face], np.maximum(u + v - 1.0, 0.0), 0.0)
            u = np.clip(u - 0.5 * excess, 0.0, 1.0)
            uv = np.stack([u, np.minimum(v, np.where(excess > 0.0, 1.0 - u, 1.0))], axis=1)
            if np.abs(uv - before).max() <= PRINTED:
                break
        x = self.at(face, uv)[0]
        distance = np.linalg.norm(x - point, axis=1)
        shared = np.flatnonzero(distance <= distance.min() + PRINTED * radius[face].max())
        shared = shared[np.argsort(distance[shared], kind="stable")]
        shared = shared[self._continuing(face[shared], x[shared[0]], float(radius[face].max()))]
        return Place(face[shared], uv[shared], x[shared], distance[shared])

    def smooth_normal(self, place: Place) -> FloatArray | None:
        """Return the unit normal at a point that several faces may share; None on a sharp edge."""
        normals = self.normal(place.face, place.uv)
        if (normals @ normals.T).min() < SHARP:
            return None
        mean: FloatArray = normals.mean(axis=0)
        return mean / np.linalg.norm(mean)

    def _continuing(self, face: IntArray, x: FloatArray, size: float) -> BoolArray:
        """Return which of the faces at a point belong to the skin on which a web ends there.

        Surface elements whose normals differ by less than 45° form one skin. A skin is continuous
        at the point if two of its elements share each of its edges through the point. All faces
        are returned unless exactly one skin is continuous.
        """
        every = np.ones(len(face), dtype=bool)
        if len(face) < 3 or not self.thin(face).all():
            return every
        normal = self.normal(face, self.middle(face))
        level = sp.csr_array(np.abs(normal @ normal.T) > SHARP)
        count, skin = sp.csgraph.connected_components(level, directed=False)
        ends = self.ends(face)
        a, b = self.mesh.nodes[ends[..., 0]], self.mesh.nodes[ends[..., 1]]
        lengths = [np.linalg.norm(of, axis=2) for of in (a - x, b - x, b - a)]
        through = (lengths[0] + lengths[1] <= lengths[2] + PRINTED * size) & (lengths[2] > 0.0)
        shared = [
            np.unique(ends[(skin == number)[:, None] & through], axis=0, return_counts=True)[1]
            for number in range(count)
        ]
        goes_on = [number for number, elements in enumerate(shared) if (elements > 1).all()]
        return skin == goes_on[0] if len(goes_on) == 1 else every

    def pierced(
        self, points: FloatArray, axis: FloatArray, *, reach: float, outward: bool = True
    ) -> Place:
        """Return the point where the line along `axis` through each of `points` meets the surface.

        If there are several such points, the nearest is returned.

        Parameters
        ----------
        points : ndarray, shape (n, 3)
            Coordinates, m.
        axis : ndarray, shape (3,)
            Unit vector, in both directions of which crossings are searched.
        reach : float
            Largest distance between a point and its crossing, m.
        outward : bool
            True: only faces with a normal along `axis` are crossed; False: only those against it.
        """
        across = plane_of(axis)
        middle, spread = points.mean(axis=0), np.ptp(points, axis=0)
        centre, radius = self.balls
        offset = centre - middle
        near = np.linalg.norm(offset @ across.T, axis=1) <= radius + np.linalg.norm(spread)
        near &= np.abs(offset @ axis) <= reach + radius + np.linalg.norm(spread)
        face = np.flatnonzero(near)
        frame = np.vstack([across, axis])
        low, high = self.bounds(face, frame)
        margin = AT_NODE * radius[face] + np.array([[0.0], [0.0], [reach]])
        at = (frame @ points.T)[:, :, None]
        within = (at >= (low - margin)[:, None]) & (at <= (high + margin)[:, None])
        point, candidate = np.nonzero(within.all(axis=0))
        face = face[candidate]
        n = len(points)
        best = Place(np.full(n, -1), np.zeros((n, 2)), points.copy(), np.full(n, np.inf))
        for some in in_batches(len(face), 24.0 * self.nodes.shape[1]):
            to, on = point[some], face[some]
            uv, active = self.middle(on), np.arange(len(on))
            for _ in range(ITERATIONS):  # Newton's method for the components across the axis
                x, tangents = self.at(on[active], uv[active])
                gap = (points[to[active]] - x) @ across.T
                step = _solved((tangents @ across.T).swapaxes(1, 2), gap)
                uv[active] += step
                moving = np.abs(step).max(axis=1, initial=0.0) > PRINTED
                active = active[moving & (np.abs(uv[active] - 0.5).max(axis=1) < _LOST)]
                if not len(active):
                    break
            x, tangents = self.at(on, uv)
            # Unconverged iterates belong to faces that the line misses.
            missed = np.linalg.norm((points[to] - x) @ across.T, axis=1) > PRINTED * radius[on]
            uv[missed] = np.inf
            looks = np.cross(tangents[:, 0], tangents[:, 1]) @ axis
            height = np.abs((x - points[to]) @ axis)
            sum_or_larger = np.where(self._triangles[on], uv.sum(axis=1), uv.max(axis=1))
            good = (uv >= -PRINTED).all(axis=1) & (sum_or_larger <= 1.0 + PRINTED)
            good &= ((looks > 0.0) == outward) & (height <= reach)
            good &= height < best.distance[to]
            order = np.flatnonzero(good)[np.lexsort((height[good], to[good]))]
            winner = order[np.diff(to[order], prepend=-1) > 0]
            to = to[winner]
            best.face[to], best.uv[to] = on[winner], uv[winner]
            best.x[to], best.distance[to] = x[winner], height[winner]
        return best

    def bulges(self, face: IntArray) -> FloatArray:
        """Return offsets of midside nodes from where straight sides have them, m, (n, 5, 3)."""
        found = np.zeros((len(face), 5, 3))
        for side, on in self.of_count(face):
            n, count, of = side.n_corners, len(side.nodes), side.element
            x = self.mesh.nodes[self.nodes[face[on], :count]]
            found[on, : count - n] = x[:, n:] - of.linear.shape(of.nodes[n:]) @ x[:, :n]
        return found

    def bounds(self, face: IntArray, frame: FloatArray) -> ArrayPair:
        """Return lower and upper bounds of the faces along the axes `frame`, m, each (3, n)."""
        corners = self.mesh.nodes[self.corners(face)] @ frame.T
        room = _BETWEEN * np.abs(self.bulges(face) @ frame.T).max(axis=1)
        return (corners.min(axis=1) - room).T, (corners.max(axis=1) + room).T

    @cached_property
    def _triangles(self) -> BoolArray:
        return np.array([face.n_corners == 3 for _, face in self.sides])[self.side]


def boundary(mesh: Mesh) -> Surface:
    """Return the surface of a mesh: the sides whose corners belong to no other element.

    A surface element is a side, with the normal given by the order of its nodes; lines have none.

    Raises
    ------
    MeshError
        If elements of different kinds do not fit together.
    """
    sides = [
        (number, face)
        for number, block in enumerate(mesh.blocks)
        for face in reference_faces(block.kind)
    ]
    corners, cells = [], []
    for number, face in sides:
        block = mesh.blocks[number]
        key = np.full((len(block.cells), 4), -1)
        if block.element.thin:  # unique: kept even on the side of a solid
            key[:] = -2 - np.arange(block.first, block.numbers.stop)[:, None]
        else:
            key[:, : face.n_corners] = np.sort(block.cells[:, face.nodes[: face.n_corners]], axis=1)
        corners.append(key)
        cells.append(np.r_[block.numbers])
    side_of = np.repeat(np.arange(len(sides)), [*map(len, cells)])
    key, cell = np.concatenate(corners), np.concatenate(cells)
    single = np.ones(len(key), dtype=bool)
    other, one = twins(key)
    single[one] = single[other] = False
    joined = np.stack([cell[one], cell[other]], axis=1)
    surface = Surface(mesh, cell[single], side_of[single], joined, sides)
    if len(mesh.blocks) > 1:
        _check_fit(surface, key[single], side_of[one], side_of[other])
    return surface


def _check_fit(surface: Surface, corners: IntArray, one: IntArray, other: IntArray) -> None:
    """Refuse elements that meet in sides with unequal nodes: displacements would have gaps."""
    apart = surface._counts[one] != surface._counts[other]
    if apart.any():
        cells = surface.joined[np.flatnonzero(apart)[0]].tolist()
        which = f"{int(apart.sum())} pairs of elements, the first {cells[0]} and {cells[1]}"
        raise MeshError(f"mesh: {which}, are of different order. Mesh the body with one order")
    square = corners[:, 3] >= 0
    triples = np.concatenate([np.delete(corners[square], i, axis=1) for i in range(4)])
    lone = np.concatenate([corners[~square, :3], np.unique(triples, axis=0)])
    again, _ = twins(lone)
    if len(again):
        nodes = lone[again[0]].tolist()
        which = f"{len(again)} triangular sides, the first on nodes {nodes}"
        raise MeshError(f"mesh: {which}, lie on quadrilateral ones. Put pyramids between them")


def plane_of(axis: FloatArray, near: FloatArray | None = None) -> FloatArray:
    """Return an orthonormal basis of the plane normal to `axis`, shape (2, 3).

    The first vector is along the projection of `near` onto the plane.
    """
    if near is None:
        first = np.cross(axis, np.eye(3)[np.abs(axis).argmin()])
    else:
        first = near - (near @ axis) * axis
    first /= np.linalg.norm(first)
    return np.stack([first, np.cross(axis, first)])


def _solved(matrix: FloatArray, right: FloatArray) -> FloatArray:
    """Return the Newton steps of 2 x 2 systems: zero if singular, limited to `_LONGEST`."""
    (a, b), (c, d) = matrix[:, 0].T, matrix[:, 1].T
    det = a * d - b * c
    size = np.abs(matrix).max(axis=(1, 2))
    safe = np.where(np.abs(det) > ROUNDING * size**2, det, np.inf)
    step = np.stack([d * right[:, 0] - b * right[:, 1], a * right[:, 1] - c * right[:, 0]], axis=1)
    step /= safe[:, None]
    cut: FloatArray = np.clip(step, -_LONGEST, _LONGEST)
    return cut
