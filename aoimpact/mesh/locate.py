"""Location of points of a body: the element at a point, and its shape functions there."""

from __future__ import annotations

import numpy as np

from ..base import ROUNDING, FloatArray, InputError, IntArray, plain
from .mesh import AT_NODE, Mesh
from .surface import ITERATIONS
from .vectors import dot

# Distance from an element, as a fraction of its size, up to which a point counts as on it: points
# of a curved surface lie off the facets of its mesh.
ON_SURFACE = 0.02


def weights_at(
    mesh: Mesh, point: FloatArray, shapes: Mesh | None = None
) -> tuple[IntArray, FloatArray]:
    """Return the nodes of the element at a point, and the values of their shape functions there.

    Parameters
    ----------
    mesh : Mesh
    point : ndarray, shape (3,)
        Coordinates, m.
    shapes : Mesh, optional
        Mesh whose shape functions are evaluated: `mesh` by default, or that from `enriched`.

    Returns
    -------
    nodes : ndarray of int, shape (nodes per element,)
        Nodes of the element.
    weights : ndarray, shape (nodes per element,)
        Values of the shape functions; those not added by `enriched` have a sum of 1.

    Raises
    ------
    InputError
        If the point is off the body.
    """
    # Candidates: bounding boxes of elements, enlarged by half for bulging sides. The element with
    # the nearest middle is tried first.
    places = mesh.nodes[mesh.cells]
    low, high = places.min(axis=1), places.max(axis=1)
    room = 0.25 * (high - low).max(axis=1, keepdims=True)
    found = np.flatnonzero(((point >= low - room) & (point <= high + room)).all(axis=1))
    distance = np.linalg.norm(places[found].mean(axis=1) - point, axis=1)
    best = np.inf
    for cell in found[np.argsort(distance, kind="stable")]:
        number, block = next(of for of in enumerate(mesh.blocks) if cell < of[1].numbers.stop)
        element, members = block.element, block.cells[cell - block.first]
        corners = mesh.nodes[members]
        place = element.nodes[: element.n_corners].mean(axis=0)
        for _ in range(ITERATIONS):  # Newton's method, kept near the element
            miss = point - element.shape(place[None])[0] @ corners
            jacobian = corners.T @ element.gradient(place[None])[0]
            ahead = np.clip(place + np.linalg.lstsq(jacobian, miss)[0], -1.0, 2.0)
            if np.abs(ahead - place).max() <= ROUNDING:
                break
            place = ahead
        place = element.cell.inside(np.clip(place, 0.0, 1.0))
        shape = element.shape(place[None])[0]
        size = np.linalg.norm(np.ptp(corners, axis=0))
        off = float(np.linalg.norm(shape @ corners - point) / size)
        if off < best:
            best, found_in, found_at = off, (number, cell - block.first), place
        if best <= ROUNDING:
            break
    if best > ON_SURFACE:
        low, high = mesh.nodes.min(axis=0), mesh.nodes.max(axis=0)
        box = ", ".join(f"{c} {a:.4g}…{b:.4g}" for c, a, b in zip("xyz", low, high, strict=True))
        why = f"point {plain(point)} m is off the body, which spans {box} m"
        raise InputError(f"{why}; {_nearest(mesh.nodes, point)[1]}")
    block, row = (shapes or mesh).blocks[found_in[0]], found_in[1]
    weights = block.element.shape(found_at[None])[0]
    return block.cells[row], weights if block.signs is None else weights * block.signs[row]


def nearest_line(mesh: Mesh, point: FloatArray) -> tuple[int, float, float]:
    """Return the line element nearest to a point, the place along it (0 to 1), the distance, m."""
    block = next(of for of in mesh.blocks if of.kind == "line")
    ends = mesh.nodes[block.cells]
    along = ends[:, 1] - ends[:, 0]
    place = np.clip(dot(point - ends[:, 0], along) / dot(along, along), 0.0, 1.0)
    gap = np.linalg.norm(ends[:, 0] + place[:, None] * along - point, axis=1)
    nearest = int(gap.argmin())
    return block.first + nearest, float(place[nearest]), float(gap[nearest])


def node_at(nodes: FloatArray, point: FloatArray) -> int:
    """Return the number of the node at a point of a body without elements.

    Raises
    ------
    InputError
        If there is no node at the point.
    """
    node, said = _nearest(nodes, point)
    size = np.linalg.norm(np.ptp(nodes, axis=0))
    if np.linalg.norm(nodes[node] - point) > AT_NODE * size:
        raise InputError(f"point {plain(point)} m is no node of this body without mesh; {said}")
    return node


def _nearest(nodes: FloatArray, point: FloatArray) -> tuple[int, str]:
    """Return the number of the node nearest to a point, and a phrase for messages that names it."""
    distance = np.linalg.norm(nodes - point, axis=1)
    node = int(np.argmin(distance))
    place = plain(nodes[node])
    return node, f"the nearest node is {node} at {place} m, {distance[node]:.3g} m away"
