"""The shape of a surface at a point, from the nodes of its mesh around it.

A polynomial of degree six, the height over the tangent plane, is fitted to the nodes
(F. Cazals and M. Pouget, *Computer Aided Geometric Design* 22 (2005) 121). The fit is a Bayesian
regression (C. E. Rasmussen and C. K. I. Williams, *Gaussian Processes for Machine Learning*
(2006), sections 2.1 and 5.4): terms that the nodes cannot tell apart share the prior's width, which
enters the error as noise in the nodes does.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import scipy

from ..base import BoolArray, FloatArray, Frozen, InputError, IntArray, plain, record, sp
from .mesh import twins
from .surface import SHARP, Surface, plane_of
from .vectors import dot

# Cosine of 75°: beyond it the edge between two faces is sharp for certain; up to it the body may be
# round, of very few linear elements.
_SURELY_SHARP = 0.25

# Cosine of the largest turn, 60°, of a surface that is taken as a height over the tangent plane.
_GRAPH = 0.5

# Reaches that are tried, in distances between neighbouring nodes.
_REACHES = (2.2, 2.8, 3.6, 5.0, 7.0)

# Height of nodes that lie in a plane, as a fraction of the reach: digits of a mesh file.
_IN_PLANE = 1e-6

# Standard deviations in the error, and the least relative error. A shape is no sample of the prior.
# On meshes that gmsh makes of spheres, tori and ellipsoids, of one to eight straight and one to
# four curved elements a radius, 2 of 773 errors exceed six deviations. On cylinders 41 of 300 do,
# by up to 4.5 times: their nodes lie in rows, and few rows fit a lower degree and show no need of a
# higher one. There the estimate is at least 2 κ (κh)³ with h between nodes, which covers all of
# these and 276 of 280 places on regular meshes.
_DEVIATIONS, _LEAST_ERROR = 6.0, 1e-3

# Share of the larger curvature below which a shape bends along one direction alone, and the factor
# 2 of its error.
_ONE_WAY, _IN_ROWS = 0.1, 2.0

# Nodes that a fit needs: as many as a polynomial of degree two has terms.
_LEAST = 6

# Powers of the polynomial's terms, ascending by degree, and the square roots of the binomial
# coefficients, with which a prior is the same in every direction.
_POWERS = [(degree - j, j) for degree in range(7) for j in range(degree + 1)]
_DEGREE = np.array([i + j for i, j in _POWERS])
_BINOMIAL = np.sqrt([math.comb(i + j, j) for i, j in _POWERS])

# Width of height and slope, against that of the curvature.
_FREE = 1e3

# How much the terms grow from degree to degree over the reach (a sphere's, κ reach/2), and noise in
# the nodes against the height of the bulge.
_ROUGHNESS = np.array([0.25, 0.5, 1.0, 2.0])
_NOISE = np.geomspace(1e-9, 1.0, 19)

# The prior's widths for each of these, shape (4, 28).
_WIDTHS = _BINOMIAL * _ROUGHNESS[:, None] ** (_DEGREE - 2.0)
_WIDTHS[:, :3] = _FREE


@record
class SurfaceShape(Frozen):
    """Normal and curvatures of a surface at a point.

    Attributes
    ----------
    normal : ndarray, shape (3,)
        Outward unit vector.
    curvatures : ndarray, shape (2,)
        Principal curvatures, 1/m, the larger first; positive where the body is convex.
    directions : ndarray, shape (2, 3)
        Unit tangents along which the surface bends so.
    error : float
        How wrong each curvature may be, 1/m.
    reach : float
        Distance from the point of the farthest nodes that were taken, m.
    """

    normal: FloatArray
    curvatures: FloatArray
    directions: FloatArray
    error: float
    reach: float

    @property
    def from_below(self) -> SurfaceShape:
        """The shape of the other side of a shell."""
        curvatures, directions = -self.curvatures[::-1], self.directions[::-1].copy()
        return replace(self, normal=-self.normal, curvatures=curvatures, directions=directions)


def surface_shape(surface: Surface, point: FloatArray) -> SurfaceShape:
    """Return the shape of a surface at a point, from the nodes around it.

    Nodes beyond a sharp edge (45°) do not count. The middle nodes of straight edges do not either:
    they lie on chords.

    Parameters
    ----------
    point : ndarray, shape (3,)
        On the surface, m; the nearest point on it is taken.

    Raises
    ------
    InputError
        If the point is on a sharp edge.

    Examples
    --------
    >>> from aoimpact.mesh import boundary, sphere_mesh
    >>> shape = surface_shape(boundary(sphere_mesh(0.01, 0.002)), np.array([0.0, 0.0, 0.01]))
    >>> np.abs(shape.curvatures - 100.0).max() < shape.error < 2.0
    True
    """
    places = surface.nearest(np.asarray(point, dtype=np.float64))
    here, start, normal = places.x[0], places.face, surface.smooth_normal(places)
    if normal is None:
        why = f"point {plain(here)} m is on a sharp edge of the mesh, without a curvature"
        raise InputError(f"{why}. Choose one inside a face, or refine a round body there")
    if (flat := _flat(surface, start, here, normal)) is not None:
        return flat
    reaches = np.array(_REACHES) * _spacing(surface, start)
    region = _region(surface, start, here, normal, float(reaches[-1]))
    reaches = np.unique(np.minimum(reaches, region.distance.max()))
    counts = [int((region.distance <= length).sum()) for length in reaches]
    reaches = reaches[np.array(counts) >= _LEAST]
    if not len(reaches):
        why = f"point {plain(here)} m: only {counts[-1]} nodes lie around it before its edges"
        raise InputError(f"{why}, not {_LEAST}. Refine the mesh there, or give law")
    reaches = reaches[(reaches <= region.limit) | (reaches == reaches[0])]
    normal = _fitted(region, here, normal, float(reaches[0])).normal
    shapes = [_fitted(region, here, normal, float(length)) for length in reaches]
    best = shapes[0]
    for i, shape in enumerate(shapes):  # the least error that agrees with every fit of less reach
        agrees = all(
            np.abs(shape.curvatures - other.curvatures).max() <= shape.error + other.error
            for other in shapes[:i]
        )
        if agrees and shape.error < best.error:
            best = shape
    small, large = np.sort(np.abs(best.curvatures))
    if small > _ONE_WAY * large:
        return best
    in_rows = _IN_ROWS * float(large) * (float(large) * _spacing(surface, start)) ** 3
    return replace(best, error=max(best.error, in_rows))


@record
class _Region:
    """Nodes about a place that no sharp edge parts from it.

    Attributes
    ----------
    nodes : ndarray, shape (n, 3)
        m.
    distance : ndarray, shape (n,)
        From the place, m.
    bends : ndarray, shape (any, 2)
        Distance, m, and turn, rad, of the edges that may be sharp or a coarse mesh.
    limit : float
        Distance at which the surface turns away, m.
    """

    nodes: FloatArray
    distance: FloatArray
    bends: FloatArray
    limit: float


def _doubt(bends: FloatArray, reach: float) -> float:
    """Return the curvature, 1/m, that the edges within reach have if they are no edges."""
    turn = bends[bends[:, 0] <= reach, 1]
    return float(turn.max(initial=0.0)) / reach


def _spacing(surface: Surface, face: IntArray) -> float:
    """Return the mean distance between neighbouring nodes of faces, m."""
    edge = float(surface.edges(face).mean())
    return 0.5 * edge if _curved(surface, face).any() else edge


def _curved(surface: Surface, face: IntArray) -> BoolArray:
    """Return which faces have nodes between their corners that lie off the chords."""
    gap = np.linalg.norm(surface.bulges(face), axis=2).max(axis=1)
    return np.asarray(gap > _IN_PLANE * surface.edges(face))


def _flat(
    surface: Surface, start: IntArray, here: FloatArray, normal: FloatArray
) -> SurfaceShape | None:
    """Return a flat shape if the faces about the place lie in a plane."""
    face = np.flatnonzero(np.isin(surface.nodes, surface.nodes[start]).any(axis=1))
    joined, bends = _joined(surface, face, here)
    face = face[_linked(joined, np.isin(face, start))]
    offset = surface.mesh.nodes[np.unique(surface.nodes[face])] - here
    height = float(np.abs(offset @ normal).max())
    reach = float(np.linalg.norm(offset, axis=1).max())
    if height > _IN_PLANE * reach:
        return None
    doubt = _doubt(bends, reach)
    error = 8.0 * (height + _rounding(surface.mesh.nodes)) / reach**2 + doubt
    return SurfaceShape(normal, np.zeros(2), plane_of(normal), error, reach)


def _rounding(nodes: FloatArray) -> float:
    return float(np.finfo(float).eps * np.abs(nodes).max())


def _region(
    surface: Surface, start: IntArray, here: FloatArray, normal: FloatArray, reach: float
) -> _Region:
    centre, radius = surface.balls
    face = np.flatnonzero(np.linalg.norm(centre - here, axis=1) <= radius + reach)
    joined, bends = _joined(surface, face, here)
    graph = surface.normal(face, surface.middle(face)) @ normal > _GRAPH
    graph |= np.isin(face, start)
    kept = sp.diags_array(graph.astype(float))
    linked = _linked(kept @ joined @ kept, np.isin(face, start))
    turned = (joined + joined.T) @ linked.astype(float) > 0.0
    turned &= ~graph
    limit = np.linalg.norm(centre[face[turned]] - here, axis=1).min(initial=np.inf)
    face = face[linked]
    bent = surface.nodes[face[_curved(surface, face)]]
    nodes = surface.mesh.nodes[np.union1d(surface.corners(face), bent)]
    return _Region(nodes, np.linalg.norm(nodes - here, axis=1), bends, float(limit))


def _linked(joined: sp.csr_array, start: BoolArray) -> BoolArray:
    """Return which faces are connected with those to start from."""
    label = sp.csgraph.connected_components(joined, directed=False)[1]
    return np.isin(label, label[start])


def _joined(surface: Surface, face: IntArray, here: FloatArray) -> tuple[sp.csr_array, FloatArray]:
    """Return which of the faces share an edge that is not sharp, and `_Region.bends`."""
    key = surface.ends(face).reshape(-1, 2)
    row = np.repeat(np.arange(len(face)), 4)
    middles = np.zeros((len(face), 4, 2))
    for side, on in surface.of_count(face):
        uv = side.element.cell.corners[:, :2]
        middles[on, : side.n_corners] = 0.5 * (uv + np.roll(uv, -1, axis=0))
    normal = surface.normal(face[row], middles.reshape(-1, 2))
    two, one = (of[key[of, 0] < key[of, 1]] for of in twins(key))
    cosine = dot(normal[one], normal[two])
    smooth = cosine > SHARP
    shape = (len(face), len(face))
    pairs = (row[one[smooth]], row[two[smooth]])
    joined = sp.csr_array((np.ones(int(smooth.sum())), pairs), shape=shape)
    maybe = ~smooth & (cosine > _SURELY_SHARP)
    middle = surface.mesh.nodes[key[one[maybe]]].mean(axis=1)
    far = np.linalg.norm(middle - here, axis=1)
    return joined, np.stack([far, np.arccos(cosine[maybe])], axis=1)


def _fitted(region: _Region, here: FloatArray, normal: FloatArray, reach: float) -> SurfaceShape:
    """Return the shape of the height over the tangent plane that fits the nodes within reach.

    Bayesian regression with the prior widths A λ^(k-2) of the terms of degree k and noise A s in
    the nodes. A is integrated out, λ and s are averaged over by their evidence.
    """
    offset = region.nodes[region.distance <= reach] - here
    across, height = plane_of(normal), offset @ normal / reach
    x, y = (np.vander(along, 7, increasing=True) for along in (offset @ across.T / reach).T)
    n, (i, j) = len(offset), np.array(_POWERS).T
    q, r = np.linalg.qr(x[:, i] * y[:, j])
    seen = q.T @ height
    rounding = _rounding(region.nodes) / reach
    beyond = max(float(height @ height - seen @ seen), 0.0) + n * rounding**2
    free = max(n - 3, 1)
    left, size, right = np.linalg.svd(r * _WIDTHS[:, None], full_matrices=False)
    along, weight = seen @ left, right[:, :, :6] * _WIDTHS[:, None, :6]
    # By roughness, noise and singular value.
    size, along = size[:, None], along[:, None]
    total = size**2 + _NOISE[:, None] ** 2
    misfit = (along**2 / total).sum(axis=2) + beyond / _NOISE**2
    means = (size / total * along) @ weight
    covariance = _WIDTHS[:, None, :6] ** 2 - (size**2 / total) @ weight**2
    variances = (misfit / max(free - 2, 1))[:, :, None] * covariance.clip(0.0)
    absent = 2.0 * (n - size.shape[2]) * np.log(_NOISE)
    evidence = -0.5 * (np.log(total).sum(axis=2) + absent + free * np.log(misfit))
    share = np.exp(evidence - evidence.max())
    share /= share.sum()
    mean = np.tensordot(share, means, axes=2)
    spread = np.tensordot(share, variances + (means - mean) ** 2, axes=2)[3:]
    slope, bend = mean[1:3], np.array([[2.0 * mean[3], mean[4]], [mean[4], 2.0 * mean[5]]])
    deviation = float(np.sqrt(spread @ [4.0, 2.0, 4.0]))
    length = np.sqrt(1.0 + slope @ slope)
    tangents = across + np.outer(slope, normal)
    kappa, vectors = scipy.linalg.eigh(-bend / (length * reach), tangents @ tangents.T)
    error = _DEVIATIONS * deviation / reach + _LEAST_ERROR * float(np.abs(kappa).max())
    return SurfaceShape(
        (normal - slope @ across) / length,
        kappa[::-1].copy(),
        vectors[:, ::-1].T @ tangents,
        error + _doubt(region.bends, reach),
        reach,
    )
