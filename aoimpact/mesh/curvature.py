"""The shape of a surface at a point, from the nodes of its mesh around it.

A polynomial of degree four, the height over the tangent plane, is fitted to the nodes
(F. Cazals and M. Pouget, *Computer Aided Geometric Design* 22 (2005) 121). Its coefficients have
prior widths (ridge regression), so that terms that the nodes cannot tell apart neither blow up
nor pass for known: they enter the error.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt
import scipy
import scipy.sparse as sp

from ..base import FloatArray, Frozen, InputError, IntArray, plain, positive
from .elements import reference_element
from .surface import Place, Surface, plane_of

__all__ = ["SHARP", "SurfaceShape", "surface_shape"]


# Faces that meet at more than 45° meet at a sharp edge: between the faces of a round body of few
# linear elements there are up to 40°.
SHARP = np.sqrt(0.5)

# The surface is a height over the tangent plane where it turns away by less than 60°.
_GRAPH = 0.5

# Reaches that are tried, in distances between neighbouring nodes.
_REACHES = (2.2, 2.8, 3.6, 5.0, 7.0)

# Nodes in a plane to this fraction of the reach are flat: digits of a mesh file.
_IN_PLANE = 1e-6

# Prior widths of the coefficients of degree two, by the reach: a turn of 45° over the reach is 0.4.
_PRIOR = 0.5

# Standard deviations in the error.
_DEVIATIONS = 2.5

_POWERS = [(i, degree - i) for degree in range(5) for i in range(degree, -1, -1)]
_DEGREE = np.array([i + j for i, j in _POWERS])


@dataclass(frozen=True, eq=False)
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


def surface_shape(
    surface: Surface, point: FloatArray, *, reach: float | None = None
) -> SurfaceShape:
    """Return the shape of a surface at a point, from the nodes around it.

    Nodes beyond a sharp edge (45°) do not count. The middle nodes of straight edges do not either:
    they lie on chords.

    Parameters
    ----------
    point : ndarray, shape (3,)
        On the surface, m; the nearest point on it is taken.
    reach : float, optional
        How far nodes are taken from, m. By default the one, of some elements, that leaves the
        least error.

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
    normals = np.concatenate([surface.normal(place.face, place.uv) for place in places])
    if (normals @ normals.T).min() < SHARP:
        raise InputError(
            f"point {plain(point)} m is on a sharp edge or corner of the body, where the surface "
            "has no curvature; choose a point inside a face, or give law"
        )
    normal = normals.mean(axis=0)
    normal /= np.linalg.norm(normal)
    here = places[0].x[0]
    spacing = _spacing(surface, places)
    if reach is not None:
        reaches = [positive("reach", reach, unit="m")]
    else:
        reaches = [times * spacing for times in _REACHES]
        flat = _flat(surface, places, here, normal)
        if flat is not None:
            return flat
    nodes = _smooth_nodes(surface, places, here, normal, max(reaches))
    shapes = [_fitted(surface.mesh.nodes[nodes], here, normal, length) for length in reaches]
    return _best(shapes)


def _best(shapes: list[SurfaceShape]) -> SurfaceShape:
    """Return the fit of the least error, to which its difference from the next one is added."""
    first, *others = sorted(shapes, key=lambda shape: shape.error)
    if not others:
        return first
    apart = float(np.abs(first.curvatures - others[0].curvatures).max())
    return replace(first, error=first.error + apart)


def _spacing(surface: Surface, places: list[Place]) -> float:
    """Mean distance between neighbouring nodes at a place, m."""
    face = np.concatenate([place.face for place in places])
    edge = float(surface.edges(face).mean())
    return 0.5 * edge if _curved(surface, face).any() else edge


def _curved(surface: Surface, face: IntArray) -> npt.NDArray[np.bool_]:
    """Whether the faces have nodes between the corners that lie off the chords."""
    element = reference_element(surface.mesh.kind)
    if element.n_nodes == element.n_corners:
        return np.zeros(len(face), dtype=bool)
    cells = surface.mesh.nodes[surface.mesh.cells[surface.cell[face]]]
    n = element.n_corners
    straight = np.einsum("ac,nci->nai", element.linear.shape(element.nodes[n:]), cells[:, :n])
    on = np.isin(surface.mesh.cells[surface.cell[face], n:], surface.nodes[face])
    gap = np.linalg.norm(cells[:, n:] - straight, axis=2)
    gap[~on] = 0.0
    far: npt.NDArray[np.bool_] = gap.max(axis=1) > _IN_PLANE * surface.edges(face)
    return far


def _flat(
    surface: Surface, places: list[Place], here: FloatArray, normal: FloatArray
) -> SurfaceShape | None:
    """Return a flat shape if the faces about the place lie in a plane."""
    start = np.concatenate([place.face for place in places])
    near = np.isin(surface.nodes, surface.nodes[start]).any(axis=1)
    face = np.flatnonzero(near)
    face = face[surface.normal(face, surface.middle(face)) @ normal > SHARP]
    nodes = surface.mesh.nodes[np.unique(surface.nodes[face])] - here
    height = np.abs(nodes @ normal).max()
    reach = float(np.linalg.norm(nodes, axis=1).max())
    if height > _IN_PLANE * reach:
        return None
    rounding = np.finfo(float).eps * float(np.abs(surface.mesh.nodes).max())
    error = 8.0 * (float(height) + rounding) / reach**2
    return SurfaceShape(normal, np.zeros(2), plane_of(normal), error, reach)


def _smooth_nodes(
    surface: Surface, places: list[Place], here: FloatArray, normal: FloatArray, reach: float
) -> IntArray:
    """Numbers of the nodes within reach on faces joined to the place without a sharp edge."""
    centre, radius = surface.balls
    start = np.concatenate([place.face for place in places])
    near = np.linalg.norm(centre - here, axis=1) <= radius + reach
    near[start] = True
    face = np.flatnonzero(near)
    face = face[surface.normal(face, surface.middle(face)) @ normal > _GRAPH]
    joined = _joined(surface, face)
    label = sp.csgraph.connected_components(joined, directed=False)[1]
    face = face[np.isin(label, label[np.isin(face, start)])]
    rows = surface.nodes[face]
    straight = ~_curved(surface, face)
    corners = rows[:, :4].copy()
    corners[surface.triangular(face), 3] = corners[surface.triangular(face), 0]
    if straight.all():
        return np.unique(corners)
    return np.unique(rows)


def _joined(surface: Surface, face: IntArray) -> sp.coo_array:
    """Which of the faces share an edge across which the normal turns by less than 45°."""
    keys, rows, normals = [], [], []
    for triangular, ring in (
        (True, np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]])),
        (False, np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])),
    ):
        row = np.flatnonzero(surface.triangular(face) == triangular)
        for k in range(len(ring)):
            ends = surface.nodes[face[row]][:, [k, (k + 1) % len(ring)]]
            middle = np.tile(0.5 * (ring[k] + ring[(k + 1) % len(ring)]), (len(row), 1))
            keys.append(np.sort(ends, axis=1))
            rows.append(row)
            normals.append(surface.normal(face[row], middle))
    key, row, normal = np.concatenate(keys), np.concatenate(rows), np.concatenate(normals)
    order = np.lexsort(key.T)
    one, two = order[1:], order[:-1]
    same = (key[one] == key[two]).all(axis=1)
    same &= np.einsum("ni,ni->n", normal[one], normal[two]) > SHARP
    pairs = (row[one[same]], row[two[same]])
    return sp.coo_array((np.ones(int(same.sum()), bool), pairs), shape=(len(face),) * 2)


def _fitted(nodes: FloatArray, here: FloatArray, normal: FloatArray, reach: float) -> SurfaceShape:
    """Fit the height over the tangent plane, which turns to the fitted normal."""
    offset = nodes - here
    offset = offset[np.linalg.norm(offset, axis=1) <= reach]
    rounding = np.finfo(float).eps * float(np.abs(nodes).max()) / reach
    for _ in range(2):
        across = plane_of(normal)
        coefficients, covariance = _regression(
            offset @ across.T / reach, offset @ normal / reach, rounding
        )
        slope = coefficients[1:3]
        length = np.sqrt(1.0 + slope @ slope)
        tangents = across + np.outer(slope, normal)
        bend = np.array(
            [[2 * coefficients[3], coefficients[4]], [coefficients[4], 2 * coefficients[5]]]
        ) / (length * reach)
        kappa, vectors = scipy.linalg.eigh(-bend, tangents @ tangents.T)
        directions = vectors[:, ::-1].T @ tangents
        normal = (normal - slope @ across) / length
    spread = 4 * covariance[3, 3] + 2 * covariance[4, 4] + 4 * covariance[5, 5]
    error = _DEVIATIONS * float(np.sqrt(spread)) / reach
    return SurfaceShape(normal, kappa[::-1].copy(), directions, error, reach)


def _regression(
    u: FloatArray, height: FloatArray, rounding: float
) -> tuple[FloatArray, FloatArray]:
    """Coefficients of the polynomial, shape (15,), and their covariance."""
    basis = np.stack([u[:, 0] ** i * u[:, 1] ** j for i, j in _POWERS], axis=1)
    weight = np.sqrt(1.0 - 0.9 * (u**2).sum(axis=1).clip(0.0, 1.0))
    noise, width = 1e-4, np.where(_DEGREE > 2, 0.3, 10.0)
    width[_DEGREE == 2] = _PRIOR
    for _ in range(3):
        scaled = weight[:, None] * basis
        gain = np.linalg.solve(scaled.T @ scaled + np.diag((noise / width) ** 2), scaled.T * weight)
        c = gain @ height
        residual = weight * (height - basis @ c)
        left = max(1.0, len(u) - float(np.trace(gain @ basis)))
        noise = max(float(np.sqrt(residual @ residual / left)), rounding)
        typical = float(np.abs(c[_DEGREE == 2]).max()) + noise
        width[_DEGREE > 2] = 0.5 * typical
    unknown = (np.eye(len(c)) - gain @ basis) * width
    return c, noise**2 * gain @ gain.T + unknown @ unknown.T
