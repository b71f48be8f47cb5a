"""A patch of the surface that carries Hertz's pressure, p ∝ √(1 - ρ²/r²) over a disc of radius r.

The weights that spread a force over it also give the displacement conjugate to that force, the mean
of the surface's own under that pressure. On a half-space this mean is known, so what one node
leaves to the mesh, its own indentation, becomes a number that can be taken out of the contact law.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import partial

import numpy as np
import scipy

from ..base import FloatArray, IntArray, RoomError, checked, integer, nonnegative, positive
from ..mesh import Place, Surface, plane_of
from .material import Material

__all__ = [
    "Patch",
    "Spread",
    "circle_means",
    "free_radius",
    "half_space_compliance",
    "half_space_deflection",
    "spread",
]


# Rings, and points on each, of the quadrature over the disc: exact for polynomials of degree 47.
# Kinks of the shape functions between faces are what limits it; see tests/fem/test_patch.py.
_RINGS, _AROUND = 24, 64

# Points of a circle over which the displacement is averaged.
_ON_CIRCLE = 24

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
    modulus : float
        E* = E/(1 - ν²) of the body's material, Pa.
    compliance : float
        Deflection of an elastic half-space under the patch per force along the direction of
        travel, m/N: 0.6/(r E*) along the normal.
    faces : int
        How many faces of elements it touches.
    edges : float
        Mean length of their edges, m.

    Examples
    --------
    >>> ball = ao.FEModel.from_mesh(ao.paper_sphere_mesh(), ao.Material(E=210e9, nu=0.3, rho=7800))
    >>> patch = ball.contact(point=(0.01, 0, 0), radius=0.004).patch
    >>> modulus = 210e9 / (1 - 0.3**2)
    >>> round(patch.compliance / (0.6 / (0.004 * modulus)), 12)
    1.0
    """

    radius: float
    modulus: float
    compliance: float
    faces: int
    edges: float

    def __post_init__(self) -> None:
        checked(self, radius=partial(positive, unit="m"), modulus=partial(positive, unit="Pa"))
        checked(
            self, compliance=partial(nonnegative, unit="m/N"), edges=partial(positive, unit="m")
        )
        checked(self, faces=partial(integer, low=1))


@dataclass(frozen=True, eq=False)
class Spread:
    """Shares of a force that the nodes take, and where on the surface it acts.

    Attributes
    ----------
    weights : ndarray, shape (n_nodes,)
        Their sum is 1, and their centre lies on the normal through the point.
    normal : ndarray, shape (3,)
        Outward; the mean over the patch.
    faces : ndarray of int
        The faces of the surface that it touches.
    """

    weights: FloatArray
    normal: FloatArray
    faces: IntArray


def half_space_compliance(material: Material, radius: float, cosine: float) -> float:
    """Return the mean displacement of a half-space under its patch per force, m/N.

    Along the normal, u(ρ) = π p₀ (2r² - ρ²)/(4 r E*) has the mean 0.6 F/(r E*) under the pressure
    p₀ √(1 - ρ²/r²) itself (Johnson, *Contact Mechanics*, eqs. 3.41, 3.42). Along the surface,
    u_x = π q₀ (4(2-ν)r² - (4-3ν)x² - (4-ν)y²)/(32 G r) has 0.15 (2-ν) Q/(G r) (eq. 3.91a). Neither
    has a mean in the other's direction.

    Parameters
    ----------
    cosine : float
        Of the angle between the force and the normal.
    """
    along = 0.6 / (radius * material.plane_strain_modulus)
    across = 0.15 * (2.0 - material.nu) / (radius * material.shear_modulus)
    return cosine**2 * along + (1.0 - cosine**2) * across


def half_space_deflection(rho: FloatArray, radius: float) -> FloatArray:
    """Return the displacement of a half-space at ρ from the middle, over its mean under the patch.

    Johnson, *Contact Mechanics*, eqs. (3.42a), (3.42b), and E* ρ/(0.6 π) in place of r without a
    patch, eq. (3.22a). Along the surface, the mean around the circle is the same function.

    Parameters
    ----------
    rho : ndarray
        m; positive.
    radius : float
        r, m; 0 for a point, whose displacement is then over that under a patch of radius 1 m.
    """
    if radius == 0.0:
        return np.asarray(1.0 / (0.6 * math.pi * rho))
    k = rho / radius
    ratio = 1.0 / np.maximum(1.0, k)
    outside = np.sqrt(np.maximum(k**2 - 1.0, 0.0))
    return np.asarray(((2.0 - k**2) * np.arcsin(ratio) + outside) / (0.8 * math.pi))


def circle_means(
    surface: Surface, point: FloatArray, normal: FloatArray, radii: FloatArray
) -> FloatArray:
    """Return the nodes' weights in the mean over circles about a point, shape (n, n_nodes).

    Of as many of the circles, shape (n,), as lie on the surface.
    """
    turn = (
        2.0
        * np.pi
        / _ON_CIRCLE
        * (np.arange(_ON_CIRCLE) + _GOLDEN * np.arange(len(radii))[:, None])
    )
    offsets = radii[:, None, None] * np.stack([np.cos(turn), np.sin(turn)], axis=-1)
    points = point + offsets.reshape(-1, 2) @ plane_of(normal)
    under = surface.pierced(points, normal, reach=float(radii.max()))
    reach = _free(surface, under, normal, np.repeat(radii, _ON_CIRCLE))
    means = []
    for i in range(int((radii < reach).sum())):
        on = slice(i * _ON_CIRCLE, (i + 1) * _ON_CIRCLE)
        cells = surface.mesh.cells[surface.cell[under.face[on]]]
        shares = surface.shape(under.face[on], under.uv[on]) / _ON_CIRCLE
        means.append(np.bincount(cells.reshape(-1), shares.reshape(-1), surface.mesh.n_nodes))
    return np.stack(means) if means else np.empty((0, surface.mesh.n_nodes))


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
    cells = surface.mesh.cells[surface.cell[under.face]]
    np.add.at(weights, cells, share[:, None] * surface.shape(under.face, under.uv))
    return Spread(weights, normal, np.unique(under.face))


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


def free_radius(surface: Surface, point: FloatArray, normal: FloatArray, radius: float) -> float:
    """Return how far from the point the surface goes on as a patch needs it.

    Infinite if farther than `radius`; to within a twentieth of it.
    """
    offsets, _ = _disc_rule(radius)
    under = surface.pierced(point + offsets @ plane_of(normal), normal, reach=radius)
    return _free(surface, under, normal, np.linalg.norm(offsets, axis=1))


def _free(surface: Surface, under: Place, normal: FloatArray, rho: FloatArray) -> float:
    lost = under.face < 0
    steep = surface.normal(under.face[~lost], under.uv[~lost]) @ normal < _STEEPEST
    return float(min(rho[lost].min(initial=np.inf), rho[~lost][steep].min(initial=np.inf)))
