"""Compliance of a shell under a contact: a mesh of plate elements in place of an elastic layer.

A contact law contains the indentation of a half-space, and a shell contains bending and transverse
shear. A layer of the same thickness has a compliance R beyond the half-space that is finite, while
that of a shear-deformable plate grows without bound as the load narrows, by ln(t/a)/(2π S), and so
does that of a mesh with smaller elements. As for solids (`extraction`), the excess c = G - R is
taken out of the law, here of an infinite layer: the mesh about the contact is solved for K + s²M
with the motion of Mindlin's infinite plate at its rim, and R is that of elastodynamics. So c holds
what the elements make of bending and shear near the load, and nothing of the body's other bounds.

The displacement of one face under a pressure on it, at the wave number k, is the sum of half the
symmetric and half the antisymmetric motions of Rayleigh and Lamb (K. F. Graff, Wave motion in
elastic solids, 1975, section 8.1), with ξ² = k² + s²/c_p² and η² = k² + s²/c_s²:

    H = s²ξ/(2μ c_s²) Σ 1/((k² + η²)² T(ξt/2) - 4k²ξη T(ηt/2)),   T = tanh and coth.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from itertools import pairwise

import numpy as np
import numpy.typing as npt
import scipy

from ..base import FloatArray, IntArray
from .laminate import Laminate, Layers, Ply, Shell
from .material import Material
from .thin import thin_stiffness_mass

# Wave numbers of the integrals over k: how many, and how far beyond 1/λ and 1/a.
_WAVES, _LONG, _SHORT = 3000, 1e-3, 40.0

# The mesh about the contact reaches over so many of its edges, or lengths λ if these are less.
_EDGES, _LENGTHS = 6.0, 8.0

# k a below which the transform of Hertz's pressure is its series.
_SERIES = 1e-2

# ν of the plate that stands for a laminate in the mesh's share.
_NU = 0.3

# For laminates: wave numbers, directions, elements through the thickness, and the finest's share.
_FEW_WAVES, _TURNS, _GRADES, _FINEST = 60, 4, 24, 5e-3


def layer_compliance(material: Material, thickness: float, radius: float, s: float) -> float:
    """Return the compliance of an infinite layer beyond that of the half-space, m/N.

    The mean displacement under Hertz's pressure of a force e^{st} on one face, weighted with that
    pressure, less the static one of a half-space, 0.6/(a E*).

    Parameters
    ----------
    material : Material
    thickness : float
        t, m.
    radius : float
        a, m.
    s : float
        rad/s, positive.
    """
    k = _waves(radius, thickness, bending_length(Shell(thickness, material), s))
    mu, h = material.shear_modulus, 0.5 * thickness
    slow2 = (s / material.shear_speed) ** 2
    xi, eta = np.sqrt(k**2 + (s / material.pressure_speed) ** 2), np.sqrt(k**2 + slow2)
    one, other = (k**2 + eta**2) ** 2, 4.0 * k**2 * xi * eta
    by_xi, by_eta = np.tanh(h * xi), np.tanh(h * eta)
    both = 1.0 / (one * by_xi - other * by_eta) + 1.0 / (one / by_xi - other / by_eta)
    half_space = 2.0 / (material.plane_strain_modulus * k)
    return _mean(k, radius, 0.5 * slow2 * xi / mu * both - half_space)


def plate_compliance(layers: Layers, radius: float, s: float) -> float:
    """Return the mean displacement of Mindlin's infinite plate under Hertz's pressure, m/N."""
    D, S, m, inertia = _numbers(layers)
    k = _waves(radius, layers.total_thickness, bending_length(layers, s))
    bent = D * k**2 + S + inertia * s**2
    return _mean(k, radius, bent / ((S * k**2 + m * s**2) * bent - (S * k) ** 2))


def plate_motion(layers: Layers, s: float, x: FloatArray) -> FloatArray:
    """Return w, θx and θy of Mindlin's infinite plate under a force e^{st} of 1 N at the origin.

    Parameters
    ----------
    layers : Shell or Laminate
        For a laminate, the isotropic plate of the same mean stiffness.
    s : float
        rad/s, positive.
    x : ndarray, shape (n, 2)
        m, none at the origin.
    """
    D, S, m, inertia = _numbers(layers)
    # Roots of S D ζ⁴ - s²(m D + S I) ζ² + m s²(S + I s²) = 0: k² = -ζ² is a pole.
    half = 0.5 * s**2 * (m / S + inertia / D)
    root = np.sqrt(half**2 - m * s**2 * (S + inertia * s**2) / (S * D) + 0j)
    one, other = half + root, half - root
    r = np.linalg.norm(x, axis=1)
    parts = []
    for here, there in ((one, other), (other, one)):
        zeta = np.sqrt(here)
        share = 1.0 / (2.0 * np.pi * D * (there - here))
        shear = 1.0 + (inertia * s**2 - D * here) / S
        parts.append(
            (
                shear * share * scipy.special.kv(0, zeta * r),
                share * zeta * scipy.special.kv(1, zeta * r),
            )
        )
    (w_one, slope_one), (w_other, slope_other) = parts
    w, slope = (w_one + w_other).real, -(slope_one + slope_other).real / r
    return np.stack([w, slope * x[:, 1], -slope * x[:, 0]], axis=1)


def excess_compliance(
    nodes: FloatArray,
    cells: list[IntArray],
    layers: Layers,
    forces: FloatArray,
    point: FloatArray,
    normal: FloatArray,
    radius: float,
    s: float,
) -> float:
    """Return c = G - R, the compliance that shell elements have in excess of a layer's, m/N.

    Parameters
    ----------
    nodes : ndarray, shape (n_nodes, 3)
        m.
    cells : list of ndarray of int, shape (n, 3) or (n, 4)
        Elements of the surface that is touched.
    layers : Shell or Laminate
        Under the contact, which presses on its top. The mesh's share of a laminate's c is that of
        the isotropic plate of the same mean stiffness.
    forces : ndarray, shape (n_nodes,)
        Shares of a unit force along the normal: the contact's functional.
    point, normal : ndarray, shape (3,)
        m; where the surface is touched, and its normal, either way.
    radius : float
        a, of the contact itself, m.
    s : float
        rad/s, of K + s²M; 10 over the duration of the contact.
    """
    of_mesh = mesh_compliance(nodes, cells, layers, forces, point, normal, s)
    return of_mesh - layer_compliance_of(layers, radius, s)


def layer_compliance_of(
    layers: Layers, radius: float, s: float, slowly: float | None = None
) -> float:
    """Return R, the compliance of infinite layers beyond the half-space under the contact, m/N.

    For a laminate it is that of the isotropic plate of the same mean stiffness, plus what the
    laminate itself has beyond its own plate theory: so c of the mesh may be that of the isotropic
    plate. That part takes most of the time and varies slowly: it may be that of another frequency,
    slowly.
    """
    material = layers.plies[0].material
    if len(layers.plies) == 1 and isinstance(material, Material):
        return layer_compliance(material, layers.total_thickness, radius, s)
    beyond = _laminate_excess(layers, radius, s if slowly is None else slowly)
    return plate_compliance(_plate(layers), radius, s) - beyond


def mesh_compliance(
    nodes: FloatArray,
    cells: list[IntArray],
    layers: Layers,
    forces: FloatArray,
    point: FloatArray,
    normal: FloatArray,
    s: float,
    couples: FloatArray | None = None,
) -> float:
    """Return G, the compliance of an infinite plate that is meshed as the shell is there, m/N.

    Parameters as for `excess_compliance`; couples, shape (n_nodes, 3), are those of the functional.
    """
    axes, load = _plane(normal), np.zeros((len(nodes), 3))
    load[:, 0] = forces
    if couples is not None:
        load[:, 1:] = couples @ axes.T
    return _mesh_compliance((nodes - point) @ axes.T, cells, _plate(layers), load, s)


def contact_reach(layers: Layers, edge: float, s: float) -> float:
    """Return how far the mesh about a contact is taken that has elements of that edge there, m."""
    return min(_EDGES * edge, max(_LENGTHS * bending_length(layers, s), 3.0 * edge))


def _mesh_compliance(
    x: FloatArray, cells: list[IntArray], plate: _Plate, load: FloatArray, s: float
) -> float:
    """Mean displacement under a unit force of an infinite plate, meshed about the force.

    Parameters
    ----------
    x : ndarray, shape (n_nodes, 2)
        Places in the tangent plane, m; the force is at the origin.
    load : ndarray, shape (n_nodes, 3)
        Forces and couples about both axes, of a unit force.
    """
    away = np.linalg.norm(x, axis=1)
    loaded: npt.NDArray[np.bool_] = np.any(load, axis=1)
    edge = longest_edge(x, cells, loaded)
    reach = contact_reach(plate, edge, s)
    inside = away < reach + away[loaded].max()
    chosen = [group[inside[group].any(axis=1)] for group in cells]
    chosen = [group for group in chosen if len(group)]
    used = np.unique(np.concatenate([group.ravel() for group in chosen]))
    chosen = [np.searchsorted(used, group) for group in chosen]
    x, load = x[used], load[used]
    K, M = thin_stiffness_mass(np.column_stack([x, 0.0 * x[:, 0]]), [(c, plate) for c in chosen])
    bent = (6 * np.arange(len(used))[:, None] + [2, 3, 4]).ravel()
    A = (K + s**2 * M)[bent][:, bent].tocsr()
    moved, rim = np.zeros((len(used), 3)), _rim(chosen, len(used)) & ~load.any(axis=1)
    moved[rim] = plate_motion(plate, s, x[rim])
    free = np.repeat(~rim, 3)
    right = (load.ravel() - A @ moved.ravel())[free]
    moved[~rim] = scipy.sparse.linalg.spsolve(A[free][:, free].tocsc(), right).reshape(-1, 3)
    return float((load * moved).sum())


def _numbers(layers: Layers) -> tuple[float, float, float, float]:
    """Bending and shear stiffness, mass and rotary inertia per area, of the isotropic plate.

    About the surface in which bending makes no membrane force.
    """
    A, B = layers.stiffness[:3, :3], layers.stiffness[:3, 3:6]
    d = layers.stiffness[3:6, 3:6] - B.T @ np.linalg.solve(A, B)
    D = float((3.0 * (d[0, 0] + d[1, 1]) + 2.0 * d[0, 1] + 4.0 * d[2, 2]) / 8.0)
    S = float(0.5 * np.trace(layers.stiffness[6:, 6:]))
    m, first, second = layers.inertia.tolist()
    return D, S, m, second - first**2 / m


def bending_length(layers: Layers, s: float) -> float:
    """λ = (D/(m s²))^(1/4): how far a bending motion e^{st} reaches, m."""
    D, _, m, _ = _numbers(layers)
    return float((D / (m * s**2)) ** 0.25)


def _waves(radius: float, thickness: float, length: float) -> FloatArray:
    low, high = _LONG / max(length, thickness), _SHORT / min(radius, thickness)
    return np.exp(np.linspace(np.log(low), np.log(high), _WAVES))


def _mean(k: FloatArray, radius: float, compliance: FloatArray) -> float:
    """∫ p̂² H k dk/(2π) with Hertz's pressure p̂ = 3 (sin x - x cos x)/x³, x = k a; over log k."""
    x = k * radius
    exact = 3.0 * (np.sin(x) - x * np.cos(x)) / np.maximum(x, _SERIES) ** 3
    pressure = np.where(x < _SERIES, 1.0 - x**2 / 10.0, exact)
    values = pressure**2 * compliance * k**2
    return float(np.trapezoid(values, np.log(k)) / (2.0 * np.pi))


class _Plate(Layers):
    """An isotropic plate by its numbers, with its middle surface at the nodes."""

    reference = None

    def __init__(
        self, stiffness: FloatArray, inertia: FloatArray, thickness: float, nu: float
    ) -> None:
        self.stiffness, self.inertia, self.nu = stiffness, inertia, nu
        self.total_thickness = thickness


def _plate(layers: Layers) -> _Plate:
    """The plate that bends and shears as the layers do in the mean over all directions."""
    D, S, m, inertia = _numbers(layers)
    material = layers.plies[0].material
    nu = material.nu if len(layers.plies) == 1 and isinstance(material, Material) else _NU
    matrix = np.zeros((8, 8))
    matrix[3:6, 3:6] = D * np.array([[1.0, nu, 0.0], [nu, 1.0, 0.0], [0.0, 0.0, 0.5 * (1.0 - nu)]])
    matrix[:3, :3] = matrix[3:6, 3:6] * 12.0 / layers.total_thickness**2
    matrix[6, 6] = matrix[7, 7] = S
    return _Plate(matrix, np.array([m, 0.0, inertia]), layers.total_thickness, nu)


@lru_cache(maxsize=8)
def _laminate_excess(layers: Layers, radius: float, s: float) -> float:
    """Compliance of a laminate's plate, less the laminate's own beyond its top's half-space, m/N.

    In the mean over directions of waves. The laminate is resolved through its thickness by
    quadratic elements, finer towards the top (E. Kausel and J. M. Roësset, Bull. Seism. Soc. Am.
    71, 1743, 1981).
    """
    modulus = layers.half_space(top=True).plane_strain_modulus
    k = np.geomspace(0.02 / bending_length(layers, s), 25.0 / radius, _FEW_WAVES)
    excess = 2.0 / (modulus * k)
    for angle in 180.0 / _TURNS * np.arange(_TURNS):
        plies = [Ply(ply.thickness, ply.material, ply.angle_deg - angle) for ply in layers.plies]
        turned = Laminate(plies, fibre_axis=(1.0, 0.0, 0.0))
        excess += (_plate_waves(turned, k, s) - _layer_waves(turned, k, s)) / _TURNS
    return _mean(k, radius, excess)


def _plate_waves(layers: Layers, k: FloatArray, s: float) -> FloatArray:
    """w of (u, v, w, βx, βy) e^{ikx} under a unit pressure, by the plate theory of first order."""
    along, still = np.zeros((8, 5)), np.zeros((8, 5))
    for row, column in ((0, 0), (2, 1), (3, 3), (5, 4), (6, 2)):
        along[row, column] = 1.0
    still[6, 3] = still[7, 4] = 1.0
    m0, m1, m2 = layers.inertia
    mass = np.diag([m0, m0, m0, m2, m2])
    mass[[0, 1, 3, 4], [3, 4, 0, 1]] = m1
    K0, K1, K2 = _by_wave_number(along, still, layers.stiffness)
    return _waves_of(K0, K1, K2, mass, 2, k, s)


def _layer_waves(layers: Layers, k: FloatArray, s: float) -> FloatArray:
    """w of the top face under a unit pressure e^{ikx} on it, by elements through the thickness."""
    t, z = layers.total_thickness, layers.interfaces
    ends = np.concatenate([z, z[-1] - np.geomspace(_FINEST * t, t, _GRADES)])
    ends = np.unique(np.round(ends / t, 6)) * t
    n = 2 * len(ends) - 1
    parts = np.zeros((4, 3 * n, 3 * n))
    along, still = np.zeros((6, 3)), np.zeros((6, 3))
    along[[0, 3, 5], [0, 1, 2]] = still[[2, 4, 5], [2, 1, 0]] = 1.0
    points, weights = np.polynomial.legendre.leggauss(3)
    for number, (low, high) in enumerate(pairwise(ends.tolist())):
        ply = layers.plies[max(int(np.searchsorted(z[:-1], 0.5 * (low + high))) - 1, 0)]
        stiffness: FloatArray = np.asarray(np.linalg.inv(ply.compliance), dtype=np.float64)
        half = 0.5 * (high - low)
        dofs = slice(6 * number, 6 * number + 9)
        for x, weight in zip(points, weights, strict=True):
            shape = np.kron([0.5 * x * (x - 1.0), 1.0 - x * x, 0.5 * x * (x + 1.0)], np.eye(3))
            slope = np.kron(np.array([x - 0.5, -2.0 * x, x + 0.5]) / half, np.eye(3))
            elastic = _by_wave_number(along @ shape, still @ slope, stiffness)
            for part, of in zip(parts, (*elastic, ply.material.rho * shape.T @ shape), strict=True):
                part[dofs, dofs] += weight * half * of
    K0, K1, K2, M = parts
    return _waves_of(K0, K1, K2, M, 3 * n - 1, k, s)


def _by_wave_number(
    along: FloatArray, still: FloatArray, stiffness: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """K0, K1 and K2 of BᴴCB = K0 + ik K1 + k² K2 with B = ik along + still."""
    mixed = still.T @ stiffness @ along
    return still.T @ stiffness @ still, mixed - mixed.T, along.T @ stiffness @ along


def _waves_of(
    K0: FloatArray,
    K1: FloatArray,
    K2: FloatArray,
    M: FloatArray,
    row: int,
    k: FloatArray,
    s: float,
) -> FloatArray:
    """The displacement in a row under a unit force there, at each wave number."""
    force = np.zeros(len(M))
    force[row] = 1.0
    fixed = K0 + s**2 * M
    found = [np.linalg.solve(fixed + 1j * q * K1 + q * q * K2, force)[row].real for q in k]
    return np.array(found)


def longest_edge(
    nodes: FloatArray, cells: Sequence[IntArray], loaded: npt.NDArray[np.bool_]
) -> float:
    """Return the longest edge of the elements that have some of the nodes, m."""
    longest = 0.0
    for group in cells:
        corners = nodes[group[loaded[group].any(axis=1)]]
        edges = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2)
        longest = max(longest, float(edges.max(initial=0.0)))
    return longest


def _rim(cells: list[IntArray], n_nodes: int) -> npt.NDArray[np.bool_]:
    """Nodes on edges that belong to a single element, shape (n_nodes,)."""
    ends = [np.stack([group, np.roll(group, -1, axis=1)], axis=2).reshape(-1, 2) for group in cells]
    edges, count = np.unique(np.sort(np.concatenate(ends), axis=1), axis=0, return_counts=True)
    rim = np.zeros(n_nodes, dtype=bool)
    rim[edges[count == 1]] = True
    return rim


def _plane(normal: FloatArray) -> FloatArray:
    """Two unit vectors across the normal, rows of (2, 3)."""
    first = np.cross(normal, np.eye(3)[np.abs(normal).argmin()])
    first /= np.linalg.norm(first)
    return np.stack([first, np.cross(normal, first)])
