"""Normal and curvatures of a surface at a point, estimated from the mesh nodes around it.

The height over the tangent plane is fitted to the nodes as a polynomial of degree six
(F. Cazals and M. Pouget, *Computer Aided Geometric Design* 22 (2005) 121). The fit is a Bayesian
regression (C. E. Rasmussen and C. K. I. Williams, *Gaussian Processes for Machine Learning*
(2006), sections 2.1 and 5.4): its error includes the noise of the nodes and the prior width of
terms that the nodes do not determine.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import scipy

from ..base import BoolArray, FloatArray, Frozen, InputError, IntArray, plain, record, sp
from .mesh import AT_NODE, SHARP, twins
from .surface import Surface, plane_of
from .vectors import dot

# Cosine of 75°. An edge at which two faces turn by more is certainly sharp; from 45° to 75° it may
# belong to a round body of very few linear elements.
_SURELY_SHARP = 0.25

# Cosine of 60°, the largest angle between a face and the tangent plane for a face to be fitted as
# a height over that plane.
_GRAPH = 0.5

# Radii around the point within which nodes are fitted, in distances between neighbouring nodes. Of
# the fits that agree with the fits at all smaller radii, the one with the smallest error is taken.
_REACHES = (2.2, 2.8, 3.6, 5.0, 7.0)

# `_DEVIATIONS`: ratio of the stated error to the standard deviation. `_LEAST_ERROR`: smallest
# relative error. The ratio is calibrated, since surfaces are no samples of the prior. On gmsh's
# meshes of spheres, tori and ellipsoids, of one to eight straight or one to four curved elements
# per radius, 2 of 773 true errors exceed six deviations. On cylinders 41 of 300 do, by up to 4.5
# times: their nodes lie in rows, and a polynomial of low degree fits a few rows without any sign
# that a higher degree is missing. On cylinders the stated error is therefore at least 2 κ (κh)³, h
# being the distance between nodes; it then covers all of the 300 cases, and 276 of 280 on regular
# meshes.
_DEVIATIONS, _LEAST_ERROR = 6.0, 1e-3

# `_ONE_WAY`: largest ratio of the principal curvatures of a shape treated as a cylinder.
# `_IN_ROWS`: the factor 2 in the smallest error of a cylinder (above).
_ONE_WAY, _IN_ROWS = 0.1, 2.0

# `_POWERS`: exponents of the polynomial's terms, ascending by `_DEGREE`. `_BINOMIAL`: square roots
# of the binomial coefficients; as prior standard deviations they make the prior isotropic.
_POWERS = [(degree - j, j) for degree in range(7) for j in range(degree + 1)]
_DEGREE = np.array([i + j for i, j in _POWERS])
_BINOMIAL = np.sqrt([math.comb(i + j, j) for i, j in _POWERS])

# Number of terms of a polynomial of degree two, the smallest number of nodes of a fit.
_LEAST = int(np.count_nonzero(_DEGREE <= 2))

# Prior standard deviation of the terms for height and slope, relative to the terms for curvature:
# so large that the prior hardly restricts height and slope.
_FREE = 1e3

# Parameters over whose values the fit is averaged. `_ROUGHNESS`: λ, the ratio of prior standard
# deviations of successive degrees (κ reach/2 for a sphere). `_NOISE`: s, the ratio of the nodes'
# noise to the prior standard deviation of the curvature.
_ROUGHNESS = np.array([0.25, 0.5, 1.0, 2.0])
_NOISE = np.geomspace(1e-9, 1.0, 19)

# Prior standard deviations of all terms for each value of λ, shape (4, 28).
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
        Principal directions: unit tangents that belong to the curvatures.
    error : float
        Estimated largest error of the curvatures, 1/m.
    reach : float
        Radius around the point within which nodes were fitted, m.
    """

    normal: FloatArray
    curvatures: FloatArray
    directions: FloatArray
    error: float
    reach: float

    @property
    def from_below(self) -> SurfaceShape:
        """Normal and curvatures of the same place seen from the other side of a shell."""
        curvatures, directions = -self.curvatures[::-1], self.directions[::-1].copy()
        return replace(self, normal=-self.normal, curvatures=curvatures, directions=directions)


def surface_shape(surface: Surface, point: FloatArray) -> SurfaceShape:
    """Return the normal and curvatures of a surface at a point, from the nodes around it.

    Nodes beyond a sharp edge (45°) are left out, and so are the middle nodes of straight edges,
    which lie on chords of the true surface.

    Parameters
    ----------
    surface : Surface
    point : ndarray, shape (3,)
        Coordinates, m. The point of the surface nearest to them is taken.

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
    for i, shape in enumerate(shapes):
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
    """Nodes around a point that are not separated from it by a sharp edge.

    Attributes
    ----------
    nodes : ndarray, shape (n, 3)
        Coordinates, m.
    distance : ndarray, shape (n,)
        Distance of each node from the point, m.
    bends : ndarray, shape (any, 2)
        Distance from the point, m, and turning angle, rad, of each edge of 45° to 75°, which is
        either sharp or part of a coarse round mesh.
    limit : float
        Distance, m, of the first face turned by more than 60° from the tangent plane.
    """

    nodes: FloatArray
    distance: FloatArray
    bends: FloatArray
    limit: float


def _doubt(bends: FloatArray, reach: float) -> float:
    """Return the curvature, 1/m, at edges of 45° to 75° within reach, if they are not sharp."""
    turn = bends[bends[:, 0] <= reach, 1]
    return float(turn.max(initial=0.0)) / reach


def _spacing(surface: Surface, face: IntArray) -> float:
    """Return the mean distance between neighbouring nodes of faces, m."""
    edge = float(surface.edges(face).mean())
    return 0.5 * edge if _curved(surface, face).any() else edge


def _curved(surface: Surface, face: IntArray) -> BoolArray:
    """Return which faces are curved, with any midside node off the straight edge or flat side."""
    gap = np.linalg.norm(surface.bulges(face), axis=2).max(axis=1)
    return np.asarray(gap > AT_NODE * surface.edges(face))


def _flat(
    surface: Surface, start: IntArray, here: FloatArray, normal: FloatArray
) -> SurfaceShape | None:
    """Return a `SurfaceShape` of a plane if the faces at the point are coplanar, else None."""
    face = np.flatnonzero(np.isin(surface.nodes, surface.nodes[start]).any(axis=1))
    joined, bends = _joined(surface, face, here)
    face = face[_linked(joined, np.isin(face, start))]
    offset = surface.mesh.nodes[np.unique(surface.nodes[face])] - here
    height = float(np.abs(offset @ normal).max())
    reach = float(np.linalg.norm(offset, axis=1).max())
    if height > AT_NODE * reach:
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
    """Return which faces are connected, directly or through others, to a face of `start`."""
    label = sp.csgraph.connected_components(joined, directed=False)[1]
    return np.isin(label, label[start])


def _joined(surface: Surface, face: IntArray, here: FloatArray) -> tuple[sp.csr_array, FloatArray]:
    """Return the adjacency matrix of faces joined at smooth edges, and `_Region.bends`."""
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
    """Return the shape found by fitting heights over the tangent plane to the nodes within reach.

    Bayesian regression: the prior standard deviation of terms of degree k is A λ^(k-2), the
    standard deviation of the nodes' noise is A s. The amplitude A is integrated out. The result is
    the mean over λ and s, weighted by their evidence.
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
    along, weight = seen @ left, right[:, :, :_LEAST] * _WIDTHS[:, None, :_LEAST]
    # Axes of the arrays below, in this order: λ, s, singular value.
    size, along = size[:, None], along[:, None]
    total = size**2 + _NOISE[:, None] ** 2
    misfit = (along**2 / total).sum(axis=2) + beyond / _NOISE**2
    means = (size / total * along) @ weight
    covariance = _WIDTHS[:, None, :_LEAST] ** 2 - (size**2 / total) @ weight**2
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
