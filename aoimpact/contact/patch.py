"""A patch of the surface that carries Hertz's pressure, p ∝ √(1 - ρ²/r²) over a disc of radius r.

The weights that spread a force over it also give the displacement conjugate to that force: the mean
of the surface's displacement, weighted by the pressure.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import scipy

from ..base import FloatArray, RoomError
from ..mesh import Place, Surface, plane_of

# Rings, and points on each, of the quadrature over the disc: exact for polynomials of degree 47.
# Kinks of the shape functions between faces are what limits it; see tests/fem/test_patch.py.
_RINGS, _AROUND = 24, 64

# Successive rings are turned by this share of the angle between points, so that no two line up with
# the edges of the faces in the same way.
_GOLDEN = 0.5 * (math.sqrt(5.0) - 1.0)

# Steeper than this against the patch's middle, a surface is no disc of a half-space: cos 45°.
_STEEPEST = math.sqrt(0.5)

# The mean normal over the patch is found when it turns by less than this, rad; or by less than the
# second where turns no longer shrink: a point of the disc may lie on an edge between two faces.
_SETTLED, _ON_AN_EDGE, _TURNS = 1e-6, 1e-4, 12


@dataclass(frozen=True)
class Patch:
    """The patch of a contact point.

    Attributes
    ----------
    radius : float
        r, m.
    faces : int
        How many faces of elements it touches.

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
    """Shares of a force that the nodes take, and where on the surface it acts.

    Attributes
    ----------
    weights : ndarray, shape (n_nodes,)
        Their sum is 1, and their centre lies on the normal through the point.
    normal : ndarray, shape (3,)
        Outward; the mean over the patch.
    under : Place
        The places of the quadrature on the surface.
    share : ndarray, shape (n,)
        Their shares of the force.
    """

    weights: FloatArray
    normal: FloatArray
    under: Place
    share: FloatArray


def spread(surface: Surface, point: FloatArray, normal: FloatArray, radius: float) -> Spread:
    """Return the weights of a patch about a point of the surface.

    Each point of the quadrature over the disc is carried along the normal to the face it lies on,
    and its weight goes to the nodes by that face's shape functions. So the weights sum to one and
    have no first moment about the normal, whatever the mesh.

    Parameters
    ----------
    point : ndarray, shape (3,)
    normal : ndarray, shape (3,)
        Outward at the point, a first guess: the disc stands on the mean normal under the pressure.
    radius : float
        m.

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
        if turned < _SETTLED or 0.5 * before < turned < _ON_AN_EDGE:
            break
        # Turned no further about the normal than it must be, or the points would not settle.
        normal, across, before = mean, plane_of(mean, across[0]), turned
    weights = np.zeros(surface.mesh.n_nodes)
    np.add.at(
        weights, surface.nodes[under.face], share[:, None] * surface.shape(under.face, under.uv)
    )
    return Spread(weights, normal, under, share)


def _disc_rule(radius: float) -> tuple[FloatArray, FloatArray]:
    """Points of the disc, shape (n, 2), and shares of the pressure on it, shape (n,).

    Gauss–Jacobi in ρ²/r², with the weight √(1 - ρ²/r²), and even angles.
    """
    x, w = scipy.special.roots_jacobi(_RINGS, 0.5, 0.0)
    rho = radius * np.sqrt(0.5 * (1.0 + x))
    turn = np.arange(_AROUND) + np.modf(_GOLDEN * np.arange(_RINGS))[0][:, None]
    angle = 2.0 * np.pi / _AROUND * turn
    points = rho[:, None, None] * np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    return points.reshape(-1, 2), np.repeat(w / (w.sum() * _AROUND), _AROUND)


def _free(surface: Surface, under: Place, normal: FloatArray, rho: FloatArray) -> float:
    lost = under.face < 0
    steep = surface.normal(under.face[~lost], under.uv[~lost]) @ normal < _STEEPEST
    return float(min(rho[lost].min(initial=np.inf), rho[~lost][steep].min(initial=np.inf)))
