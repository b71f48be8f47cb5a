"""Contact region on a meshed body: a point of its surface, or a patch about the point.

A patch carries Hertz's pressure, p ∝ √(1 - ρ²/r²) over a disc of radius r. The nodal weights that
distribute the force also give the displacement conjugate to the force: the mean displacement of the
surface, weighted by the pressure.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy

from ..base import ROUNDING, ArrayPair, FloatArray, InputError, IntArray, RoomError, plain, warn
from ..fem import (
    Beam,
    Layers,
    beam_motion,
    linked,
    material_of,
    nodal_normals,
)
from ..mesh import (
    AT_NODE,
    GOLDEN,
    ON_SURFACE,
    SHARP,
    Mesh,
    Place,
    Surface,
    nearest_line,
    plane_of,
)

# Largest ratio of a given point's distance from the surface to the size of the face there.
_OFF_SURFACE = 0.1

# Smallest |cosine| between a surface's normal and a direction that presses on it: 84°.
_TANGENT = 0.1

# Quadrature over the disc: `_RINGS` rings of four times as many points, exact for polynomials of
# degree 79. Kinks of the shape functions between faces limit its accuracy; see
# tests/fem/test_patch.py.
_RINGS = 20

# Iteration for the mean normal over the patch. `_ON_AN_EDGE`: tolerance, rad, of changes that no
# longer shrink, as a point of the disc may lie on an edge between faces. `_TURNS`: largest number
# of steps.
_ON_AN_EDGE, _TURNS = 1e-4, 12


@dataclass(frozen=True)
class Patch:
    """The patch of a contact point.

    Attributes
    ----------
    radius : float
        Radius r, m.
    faces : int
        Number of element faces that the patch touches.

    Examples
    --------
    >>> ball = ao.FEModel.from_mesh(ao.paper_sphere_mesh(), ao.Material(E=210e9, nu=0.3, rho=7800))
    >>> ball.contact(point=(0.01, 0, 0), radius=0.004).patch.radius
    0.004
    """

    radius: float
    faces: int


@dataclass(frozen=True, eq=False)
class Spread:
    """Distribution of a unit force over a patch, at quadrature points and at nodes.

    Attributes
    ----------
    weights : ndarray, shape (n_nodes,)
        Nodal shares of the force. Their sum is 1, and their centre lies on the normal through the
        point.
    normal : ndarray, shape (3,)
        Outward mean normal over the patch.
    under : Place
        Quadrature points on the surface.
    share : ndarray, shape (n,)
        Share of the force at each quadrature point.
    """

    weights: FloatArray
    normal: FloatArray
    under: Place
    share: FloatArray


def spread(surface: Surface, point: FloatArray, normal: FloatArray, radius: float) -> Spread:
    """Return the distribution of a unit force over a patch about a point of the surface.

    Each quadrature point of the disc is projected along the normal onto a face, and its weight is
    distributed to the nodes by the face's shape functions. On any mesh, the weights therefore sum
    to one and have no first moment about the normal.

    Parameters
    ----------
    point : ndarray, shape (3,)
        Centre of the patch on the surface, m.
    normal : ndarray, shape (3,)
        Outward normal at the point: initial guess of the mean normal, which is normal to the disc.
    radius : float
        Radius of the disc, m.

    Raises
    ------
    RoomError
        If the surface ends within the disc, or turns away by more than 45°.
    """
    offsets, share = _disc_rule(radius)
    across, before = plane_of(normal), math.inf
    for _ in range(_TURNS):
        under = surface.pierced(point + offsets @ across, normal, reach=radius)
        reach = _free(surface, under, normal, np.linalg.norm(offsets, axis=1))
        if reach < radius:
            reason = (
                f"the surface ends, or turns away by more than 45°, {reach:.3g} m from the point"
            )
            cure = "take a smaller radius, or a point farther from the edge"
            raise RoomError(f"radius={radius:g} m: {reason}; {cure}", reach, reason)
        mean = share @ surface.normal(under.face, under.uv)
        mean /= np.linalg.norm(mean)
        turned = float(np.linalg.norm(mean - normal))
        if turned < AT_NODE or 0.5 * before < turned < _ON_AN_EDGE:
            break
        # Keep the disc's axes, as a rotation about the normal would prevent convergence.
        normal, across, before = mean, plane_of(mean, across[0]), turned
    return Spread(_weights(surface, under.face, under.uv, share), normal, under, share)


def _weights(surface: Surface, face: IntArray, uv: FloatArray, share: FloatArray) -> FloatArray:
    """Return the nodal shares of a force, (n_nodes,), from its shares at points of faces."""
    weights = np.zeros(surface.mesh.n_nodes)
    np.add.at(weights, surface.nodes[face], share[:, None] * surface.shape(face, uv))
    return weights


def _disc_rule(radius: float) -> ArrayPair:
    """Return quadrature points of the disc, (n, 2), and their shares of the force, (n,).

    The rule is Gauss–Jacobi in ρ²/r², with the weight √(1 - ρ²/r²), and equidistant in the angle.
    Each ring is turned from the one before by the golden section of the angle between its points:
    otherwise, several rings would be aligned alike with the edges of the faces.
    """
    x, w = scipy.special.roots_jacobi(_RINGS, 0.5, 0.0)
    rho = radius * np.sqrt(0.5 * (1.0 + x))
    around = 4 * _RINGS
    turn = np.arange(around) + np.modf(GOLDEN * np.arange(_RINGS))[0][:, None]
    angle = 2.0 * np.pi / around * turn
    points = rho[:, None, None] * np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    return points.reshape(-1, 2), np.repeat(w / (w.sum() * around), around)


def _free(surface: Surface, under: Place, normal: FloatArray, rho: FloatArray) -> float:
    lost = under.face < 0
    steep = surface.normal(under.face[~lost], under.uv[~lost]) @ normal < SHARP
    return float(min(rho[lost].min(initial=np.inf), rho[~lost][steep].min(initial=np.inf)))


@dataclass(frozen=True, eq=False)
class Touch:
    """A unit contact force on a surface.

    Attributes
    ----------
    point : ndarray, shape (3,)
        Contact point on the surface, m.
    direction : ndarray, shape (3,)
        Unit vector of the force.
    forces : ndarray, shape (2, n_nodes, 3)
        Nodal forces, followed by nodal couples, m, of shells and beams.
    normal : ndarray, shape (3,), or None
        Outward normal; None on a sharp edge.
    patch : Patch or None
        Patch over which the force is distributed; None for a point.
    """

    point: FloatArray
    direction: FloatArray
    forces: FloatArray
    normal: FloatArray | None = None
    patch: Patch | None = None


def touched(surface: Surface, point: FloatArray, along: FloatArray | None, radius: float) -> Touch:
    """Return the unit contact force at a point of the surface, or distributed over a patch.

    Parameters
    ----------
    point : ndarray, shape (3,)
        Contact point, m; at most a tenth of the size of a face off the surface.
    along : ndarray, shape (3,), or None
        Unit vector of the force; None for the inward normal.
    radius : float
        Radius of the patch, m; 0 for a point force.
    """
    here = _place(surface, point)
    normal: Any = surface.smooth_normal(here)
    # A shell is touched on the side that faces the force.
    behind = normal is not None and along is not None and float(along @ normal) > 0.0
    sign = -1.0 if behind and surface.thin(here.face)[0] else 1.0
    sharp = f"point {plain(point)} m is on a sharp edge, where the surface has no normal; choose"
    if radius == 0.0:
        if normal is None and along is None:
            raise InputError(f"{sharp} a point inside a face, or give direction")
        normals = surface.normal(here.face, here.uv) if normal is None else normal[None]
        places, share, patch = (here.face[:1], here.uv[:1]), np.ones(1), None
    else:
        if normal is None:
            cure = "a point farther from the edge, or radius=0 for the edge itself"
            raise InputError(f"{sharp} {cure}")
        if radius >= (most := 0.5 * surface.mesh.size):
            reason = f"the patch is larger than the body, which is {surface.mesh.size:.3g} m long"
            cure = "take a smaller radius (is it in metres?)"
            raise RoomError(f"radius={radius:g} m: {reason}; {cure}", most, reason)
        on = spread(surface, here.x[0], normal, radius)
        places, share, normal = (on.under.face, on.under.uv), on.share, on.normal
        normals, patch = normal[None], Patch(radius, len(np.unique(places[0])))
    direction = _pressing(point, along, normals)
    weights = _weights(surface, *places, share)
    couples = _couples(surface, *places, share, direction)
    forces = np.stack([np.outer(weights, direction), couples])
    return Touch(here.x[0], direction, forces, None if normal is None else sign * normal, patch)


def _couples(
    surface: Surface, face: IntArray, uv: FloatArray, share: FloatArray, direction: FloatArray
) -> FloatArray:
    """Return the nodal couples, m, of a unit force with the given shares at points of faces.

    On shells the couples do the work of the force on the deflection between nodes, see `linked`;
    on solids they are zero.
    """
    couples = np.zeros((surface.mesh.n_nodes, 3))
    for one in np.unique(face[surface.thin(face)]).tolist():
        on = face == one
        nodes, motion = _bent(surface.mesh, int(surface.cell[one]), surface.shape(face[on], uv[on]))
        couples[nodes] += np.einsum("p,i,pinj->nj", share[on], direction, motion)
    return couples


def _bent(mesh: Mesh, number: int, shape: FloatArray) -> tuple[IntArray, FloatArray]:
    """Return the nodes of a shell element, and displacements of its points per nodal rotation."""
    block = next(of for of in mesh.blocks if number < of.numbers.stop)
    nodes = block.cells[number - block.first]
    groups = [nodes[None]]
    for of in mesh.blocks:
        near = np.isin(of.cells, nodes).any(axis=1)
        near &= of.first + np.arange(len(of.cells)) != number
        if of.kind in ("quad", "triangle"):
            groups.append(of.cells[near])
    normals = nodal_normals(mesh.nodes, groups)[0]
    return nodes, linked(mesh.nodes[nodes], normals[0], shape[:, : len(nodes)])


def motion_between(
    body: Any, nodes: IntArray, weights: FloatArray
) -> tuple[IntArray, FloatArray] | None:
    """Return the displacement of a point of a shell or beam per nodal dof of its element.

    Parameters
    ----------
    body : FEModel
    nodes, weights : ndarray, shape (k,)
        Two or more nodes, and their shape functions at the point.

    Returns
    -------
    nodes : ndarray of int, shape (n,)
        Nodes of the element.
    motion : ndarray, shape (3, n, 2, 3)
        Components of the displacement per displacement, then per rotation, of each node.
    None
        If the point is in a solid.
    """
    mesh = body.mesh
    thin = [block for block in mesh.blocks if block.element.thin]
    for block in sorted(thin, key=lambda block: block.kind == "line"):  # shells first
        held = np.isin(block.cells, nodes).sum(axis=1) == len(nodes)
        if not held.any():
            continue
        number = block.first + int(held.argmax())
        cell = block.cells[number - block.first]
        shape = (cell[:, None] == nodes) @ weights
        if block.kind == "line":
            of: Any = material_of(body.material, number)
            return cell, beam_motion(mesh.nodes[cell][None], of, float(shape[1]))
        by_shift = np.eye(3)[:, None] * shape[:, None]
        return cell, np.stack([by_shift, _bent(mesh, number, shape[None])[1][0]], axis=2)
    return None


def element_at(body: Any, point: FloatArray) -> tuple[int, FloatArray, float]:
    """Return the nearest element, the nearest point on its face or axis, m, and its distance, m.

    Parameters
    ----------
    body : FEModel
        Body with a mesh.
    """
    if body.surface is None:
        cell, share, gap = nearest_line(body.mesh, point)
        first, last = body.mesh.nodes[body.mesh.cells[cell, :2]]
        return cell, first + share * (last - first), gap
    here = body.surface.nearest(point)
    return int(body.surface.cell[here.face[0]]), here.x[0], float(here.distance[0])


def to_nodes(body: Any, point: FloatArray) -> FloatArray:
    """Project a point on the face of a shell or beam to the surface or axis of its nodes, m.

    Other points are returned unchanged.

    Parameters
    ----------
    body : FEModel
    point : ndarray, shape (3,)
        Point, m.
    """
    if body.mesh is None or body.material is None or not body.mesh.thin:
        return point
    cell, x, gap = element_at(body, point)
    of = material_of(body.material, cell)
    on = isinstance(of, (Layers, Beam)) and gap <= of.reach + AT_NODE * body.mesh.size
    return np.asarray(x) if on else point


def edge_length(surface: Surface, point: FloatArray) -> float:
    """Return the mean length of the edges of the faces at a point, m."""
    return float(surface.edges(_place(surface, point).face).mean())


def thickness(surface: Surface, point: FloatArray, along: FloatArray) -> float:
    """Return the distance from a point of the surface through the body to the opposite surface, m.

    Parameters
    ----------
    along : ndarray, shape (3,)
        Unit vector into or out of the body.
    """
    reach = 2.0 * surface.mesh.size
    found = [
        float(surface.pierced(point[None], axis, reach=reach, outward=False).distance[0])
        for axis in (along, -along)  # in one direction the only face found is the touched one
    ]
    return max((d for d in found if 0.0 < d < np.inf), default=np.inf)


def _place(surface: Surface, point: FloatArray) -> Place:
    """Return the nearest surface point, once for each face that contains it; refuse far points."""
    here = surface.nearest(point)
    gap, size = float(here.distance[0]), float(surface.edges(here.face[:1])[0])
    if gap > _OFF_SURFACE * size:
        normal = surface.normal(here.face, here.uv)[0]
        where = "inside the body" if (point - here.x[0]) @ normal < 0.0 else "off the body"
        raise InputError(
            f"point {plain(point)} m is {where}, {gap:.3g} m from the nearest place on its "
            f"surface, {plain(here.x[0])} m: give a point on the surface (is it in metres?)"
        )
    if gap > ON_SURFACE * size:
        warn(
            f"point {plain(point)} m is {gap:.3g} m off the surface; {plain(here.x[0])} m is taken"
        )
    return here


def _pressing(point: FloatArray, along: FloatArray | None, normals: FloatArray) -> FloatArray:
    """Return the force's direction, by default against the normal; refuse tangential directions.

    On a sharp edge, the direction must press on at least one of the faces that meet there.
    """
    if along is None:
        return np.where(np.abs(normals[0]) > ROUNDING, -normals[0], 0.0)
    if np.abs(normals @ along).max() < _TANGENT:
        known = np.unique(np.where(np.abs(normals) > ROUNDING, normals, 0.0).round(6), axis=0)
        raise InputError(
            f"direction {plain(along)} runs along the surface at point {plain(point)} m, whose "
            f"outward normal is {' or '.join(map(plain, known))}: give one that presses on it"
        )
    return along
