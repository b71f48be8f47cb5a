"""Compliance of a shell under a contact: plate elements compared with an elastic layer.

A contact law contains the indentation of a half-space, and a shell contains bending and transverse
shear. Beyond the half-space, an elastic layer has a finite compliance R. The compliance of a
shear-deformable plate, however, grows without bound as the load narrows, by ln(t/a)/(2π S), and so
does that of a mesh with ever smaller elements. As for solids (`extraction`), the excess c = G - R
is removed from the contact law. Here G and R belong to infinite plates: for G the mesh about the
contact is solved with K + s²M and the motion of the infinite plate at its rim, and R follows from
elastodynamics. So c contains only what the elements make of bending and shear near the load,
independently of the body's boundaries.

The displacement of one face under a pressure on this face, at the wave number k, is half the sum of
the symmetric and antisymmetric motions of Rayleigh and Lamb (K. F. Graff, Wave motion in elastic
solids, 1975, section 8.1), with ξ² = k² + s²/c_p² and η² = k² + s²/c_s²:

    H = s²ξ/(2μ c_s²) Σ 1/((k² + η²)² T(ξt/2) - 4k²ξη T(ηt/2)),   T = tanh and coth.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from itertools import pairwise

import numpy as np
import scipy

from ..base import BoolArray, ComplexArray, FloatArray, IntArray
from ..fem import Laminate, Layers, Material, Shell, thin_stiffness_mass
from ..mesh import plane_of, sides

# Integrals over wave numbers k are sums over `_WAVES` Gauss points in log k. With the thickness t
# and the bending length λ, integrands fall as (kλ)² below 1/λ, and as (ka)⁻⁴ and (kt)⁻⁴ or faster
# above 1/a and 1/t; `_TAIL` is the share left out at each end. The points resolve p̂² for contact
# radii up to some bending lengths.
_WAVES, _TAIL = 96, 1e-6
_POINTS, _WEIGHTS = 0.5 * (np.polynomial.legendre.leggauss(_WAVES) + np.array([[1.0], [0.0]]))

# Number of directions of waves for mean compliances; a laminate's compliance is exact to 1e-4 for
# E1/E2 = 50, and to 1e-6 for carbon. The motion of its plate takes four times as many.
_TURNS = 12

# Radius of the mesh about the contact: the smaller of _EDGES element edges and _LENGTHS bending
# lengths λ, but at least 3 edges.
_EDGES, _LENGTHS = 6.0, 8.0

# Number of elements through a laminate's thickness t, the finest for the shortest wave: the local
# compliance is exact to 3e-4 for contact radii a of 2 t to t/100, and to 6e-4 for t/1000.
_GRADES = 16

# For the motion of a laminate's plate: ratio of the distance r to the width over which the force is
# spread. The wave numbers then reach 42/r; as cubes of Gauss points they also resolve bending waves
# 300 times as long as r, to 2e-5 (10 times: to 1e-9).
_SPREAD = 6.0

# Ratio of bending length λ to thickness t at the frequency `slow_bending`. The rounding error of
# waves in laminates grows as (λ/t)^4.
_LONG_WAVES = 30.0


def layer_compliance(material: Material, thickness: float, radius: float, s: float) -> float:
    """Return the compliance of an infinite layer beyond that of the half-space, m/N.

    The compliance is the pressure-weighted mean displacement under Hertz's pressure of a unit force
    e^{st} on one face, minus that of a half-space under a static force, 0.6/(a E*).

    Parameters
    ----------
    material : Material
    thickness : float
        Thickness t, m.
    radius : float
        Contact radius a, m.
    s : float
        Frequency (Laplace variable), rad/s, positive.
    """
    k = _waves(radius, thickness, bending_length(Shell(thickness, material), s))
    mu, h = material.shear_modulus, 0.5 * thickness
    fast2, slow2 = (s / material.pressure_speed) ** 2, (s / material.shear_speed) ** 2
    xi, eta = np.sqrt(k**2 + fast2), np.sqrt(k**2 + slow2)
    one, other = (k**2 + eta**2) ** 2, 4.0 * k**2 * xi * eta
    by_xi, by_eta = np.tanh(h * xi), np.tanh(h * eta)
    # `one - other` and `by_eta - by_xi` are rearranged, since their terms nearly cancel for k far
    # above s divided by the wave speed.
    apart = slow2 - fast2
    rayleigh = 16.0 * k**6 * apart + (24.0 * slow2 - 16.0 * fast2) * slow2 * k**4
    rayleigh = (rayleigh + 8.0 * k**2 * slow2**3 + slow2**4) / (one + other)
    more = other * np.tanh(h * apart / (xi + eta)) * (1.0 - by_xi * by_eta)
    both = 1.0 / (rayleigh * by_xi - more) + by_xi * by_eta / (rayleigh * by_eta + more)
    half_space = 2.0 / (material.plane_strain_modulus * k)
    return _mean(k, radius, 0.5 * slow2 * xi / mu * both - half_space)


def plate_compliance(layers: Layers, radius: float, s: float) -> float:
    """Return the infinite plate's compliance, its mean displacement under Hertz's pressure, m/N.

    First-order shear deformation theory is used: Mindlin's plate for a single isotropic layer.
    """
    k = _waves(radius, layers.total_thickness, bending_length(layers, s))
    if not _isotropic(layers):
        turns = np.pi / _TURNS * np.arange(_TURNS)
        moved = np.mean([_plate_waves(layers, turn, k, s)[:, 2].real for turn in turns], axis=0)
        return _mean(k, radius, moved)
    D, S, m, inertia = _numbers(layers)
    bent = D * k**2 + S + inertia * s**2
    return _mean(k, radius, bent / ((S * k**2 + m * s**2) * bent - (S * k) ** 2))


def plate_motion(layers: Layers, s: float, x: FloatArray) -> FloatArray:
    """Return u, v, w, θx and θy of the infinite plate under a force e^{st} of 1 N at the origin.

    Parameters
    ----------
    layers : Shell or Laminate
    s : float
        Frequency (Laplace variable), rad/s, positive.
    x : ndarray, shape (n, 2)
        Points other than the origin, m. The first axis is that of the layers.
    """
    if not _isotropic(layers):
        return _motion_of_waves(layers, s, x)
    D, S, m, inertia = _numbers(layers)
    # The poles k² = -ζ² are roots of S D ζ⁴ - s²(m D + S I) ζ² + m s²(S + I s²) = 0.
    half = 0.5 * s**2 * (m / S + inertia / D)
    root = np.sqrt(half**2 - m * s**2 * (S + inertia * s**2) / (S * D) + 0j)
    roots, r = np.array([[half + root], [half - root]]), np.linalg.norm(x, axis=1)
    zeta, share = np.sqrt(roots), 1.0 / (2.0 * np.pi * D * (roots[::-1] - roots))
    shear = 1.0 + (inertia * s**2 - D * roots) / S
    w = (shear * share * scipy.special.kv(0, zeta * r)).sum(axis=0).real
    slope = -(share * zeta * scipy.special.kv(1, zeta * r)).sum(axis=0).real / r
    still = np.zeros_like(w)
    return np.stack([still, still, w, slope * x[:, 1], -slope * x[:, 0]], axis=1)


def _motion_of_waves(layers: Layers, s: float, x: FloatArray) -> FloatArray:
    """Return `plate_motion`, as an integral over plane waves in all directions.

    The force is spread by a modified Gaussian whose second and fourth moments vanish.
    """
    away = np.linalg.norm(x, axis=1)
    width = away.min() / _SPREAD
    k = 7.0 / width * _POINTS**3
    y = 0.5 * (k * width) ** 2
    share = 3.0 / _POINTS * _WEIGHTS * k**2 * np.exp(-y) * (1.0 + y + 0.5 * y**2)
    moved, around = np.zeros((len(x), 5)), 4 * _TURNS
    for turn in np.pi / around * np.arange(around):
        waves = share[:, None] * _plate_waves(layers, turn, k, s)
        phase = np.outer(x @ np.array([np.cos(turn), np.sin(turn)]), k)
        moved += np.cos(phase) @ waves.real - np.sin(phase) @ waves.imag
    u, v, w, by_x, by_y = moved.T / (2.0 * np.pi * around)
    return np.stack([u, v, w, -by_y, by_x], axis=1)


def layer_compliance_of(layers: Layers, radius: float, s: float) -> float:
    """Return R, the compliance of infinite layers beyond the half-space under the contact, m/N.

    For laminates, R is the compliance of the plate minus its excess over elasticity theory. The
    excess hardly depends on frequency if bending waves are long, and is lost in rounding errors if
    they are very long. The excess is therefore evaluated at no lower frequency than `slow_bending`.
    """
    material = layers.plies[0].material
    if isinstance(material, Material) and _isotropic(layers):
        return layer_compliance(material, layers.total_thickness, radius, s)
    beyond = _laminate_excess(layers, radius, max(s, slow_bending(layers)))
    return plate_compliance(layers, radius, s) - beyond


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
    """Return G, the compliance of an infinite plate with the shell's mesh about the contact, m/N.

    Parameters
    ----------
    nodes : ndarray, shape (n_nodes, 3)
        Coordinates, m.
    cells : list of ndarray of int
        Nodes of the elements about the contact, one array per kind.
    layers : Shell or Laminate
    forces : ndarray, shape (n_nodes,)
        Nodal shares of a unit force along the normal.
    point, normal : ndarray, shape (3,)
        Contact point, m, and normal at this point.
    s : float
        Frequency (Laplace variable), rad/s.
    couples : ndarray, shape (n_nodes, 3), optional
        Nodal couples of the unit force, m.
    """
    axes = plane_of(normal, layers.reference)
    load = np.zeros((len(nodes), 6))
    load[:, 2] = forces
    if couples is not None:
        load[:, 3:5] = couples @ axes.T
    x = (nodes - point) @ axes.T
    used = np.unique(np.concatenate([group.ravel() for group in cells]))
    chosen = [_facing(np.searchsorted(used, group), x[used]) for group in cells if len(group)]
    x, load = x[used], load[used]
    plate: Layers = Laminate(layers.plies, (1.0, 0.0, 0.0), layers.offset)
    if _isotropic(layers):  # the neutral surface has no offset
        plate = Shell(layers.total_thickness, layers.plies[0].material)
    K, M = thin_stiffness_mass(np.column_stack([x, 0.0 * x[:, 0]]), [(c, plate) for c in chosen])
    rim = rim_nodes(x, chosen) & ~load.any(axis=1)
    # Without coupling of bending and membrane, only w, θx and θy are nonzero.
    moving = np.full(6, plate.stiffness[:3, 3:6].any()) | (np.abs(np.arange(6) - 3) < 2)
    free = np.outer(~rim, moving)
    free[:, 5] = moving[5]  # the infinite plate prescribes no drilling rotation at the rim
    free, moved = np.flatnonzero(free), np.zeros((len(used), 6))
    A = (K + s**2 * M).tocsr()[free]
    moved[rim, :5] = plate_motion(plate, s, x[rim])
    right = load.ravel()[free] - A @ moved.ravel()
    moved.ravel()[free] = scipy.sparse.linalg.spsolve(A[:, free].tocsc(), right)
    return float((load * moved).sum())


def _facing(cells: IntArray, x: FloatArray) -> IntArray:
    """Return the elements with their nodes in counter-clockwise order in the plane."""
    one, other = x[cells[:, 1]] - x[cells[:, 0]], x[cells[:, 2]] - x[cells[:, 0]]
    turned = one[:, 0] * other[:, 1] < one[:, 1] * other[:, 0]
    return np.where(turned[:, None], cells[:, ::-1], cells)


def contact_reach(layers: Layers, edge: float, s: float) -> float:
    """Return the radius, m, of the mesh about a contact, for elements of a given edge length, m."""
    return min(_EDGES * edge, max(_LENGTHS * bending_length(layers, s), 3.0 * edge))


def _isotropic(layers: Layers) -> bool:
    return len(layers.plies) == 1 and isinstance(layers.plies[0].material, Material)


def _numbers(layers: Layers) -> tuple[float, float, float, float]:
    """Return bending and shear stiffness, mass and rotary inertia per area of an isotropic layer.

    The values refer to the neutral surface, where bending causes no membrane force.
    """
    m, first, second = layers.inertia.tolist()
    D, S = _bending(layers)[0, 0], layers.stiffness[6, 6]
    return float(D), float(S), m, second - first**2 / m


def _bending(layers: Layers) -> FloatArray:
    """Return the bending stiffness (moments per curvature) without membrane forces, N m, (3, 3)."""
    A, B = layers.stiffness[:3, :3], layers.stiffness[:3, 3:6]
    bending: FloatArray = layers.stiffness[3:6, 3:6] - B.T @ np.linalg.solve(A, B)
    return bending


def bending_length(layers: Layers, s: float) -> float:
    """Return the decay length λ = (D/(m s²))^(1/4), m, of bending e^{st}; D: smallest stiffness."""
    turns = np.pi / (4 * _TURNS) * np.arange(4 * _TURNS)
    c, d = np.cos(turns), np.sin(turns)
    curved = np.stack([c * c, d * d, 2.0 * c * d])
    D = np.einsum("in,ij,jn->n", curved, _bending(layers), curved).min()
    return float((D / (layers.inertia[0] * s**2)) ** 0.25)


def slow_bending(layers: Layers) -> float:
    """Return the frequency s, rad/s, at which the bending length is `_LONG_WAVES` thicknesses."""
    return (bending_length(layers, 1.0) / (_LONG_WAVES * layers.total_thickness)) ** 2


def _waves(radius: float, thickness: float, length: float) -> FloatArray:
    low, high = _TAIL**0.5 / max(length, thickness), _TAIL**-0.25 / min(radius, thickness)
    return np.asarray(low * (high / low) ** _POINTS)


def _mean(k: FloatArray, radius: float, compliance: FloatArray) -> float:
    """Return the mean compliance ∫ p̂² H k dk/(2π) under Hertz's pressure, m/N.

    H is the `compliance` at wave number k, one of `_waves`; p̂ = 3 j₁(x)/x with x = k a.
    """
    pressure = 3.0 * scipy.special.spherical_jn(1, k * radius) / (k * radius)
    step = np.log(k[-1] / k[0]) / np.ptp(_POINTS)
    return float(_WEIGHTS @ (pressure**2 * compliance * k**2) * step / (2.0 * np.pi))


@lru_cache(maxsize=8)
def _laminate_excess(layers: Layers, radius: float, s: float) -> float:
    """Return a plate's compliance minus the elastic laminate's beyond a half-space, m/N.

    The half-space has the material of the top ply. The result is the mean over directions of waves.
    """
    modulus = layers.half_space(None).plane_strain_modulus
    k = _waves(radius, layers.total_thickness, bending_length(layers, s))
    excess = 2.0 / (modulus * k)
    for turn in np.pi / _TURNS * np.arange(_TURNS):
        plate = _plate_waves(layers, turn, k, s)[:, 2].real
        excess += (plate - _layer_waves(layers, turn, k, s)) / _TURNS
    return _mean(k, radius, excess)


def _plate_waves(layers: Layers, turn: float, k: FloatArray, s: float) -> ComplexArray:
    """Return amplitudes (u, v, w, βx, βy), (n, 5), of plate waves e^{ikx} per unit pressure.

    The plate is that of first-order shear deformation theory. The waves run at the angle `turn`,
    rad, to the layers' x axis.
    """
    along, still, (c, d) = np.zeros((8, 5)), np.zeros((8, 5)), (np.cos(turn), np.sin(turn))
    for strain, moved in ((0, 0), (3, 3)):  # first membrane, then bending
        along[strain, moved] = along[strain + 2, moved + 1] = c
        along[strain + 1, moved + 1] = along[strain + 2, moved] = d
    along[6:, 2] = c, d
    still[6, 3] = still[7, 4] = 1.0
    m0, m1, m2 = layers.inertia
    mass = np.diag([m0, m0, m0, m2, m2])
    mass[[0, 1, 3, 4], [3, 4, 0, 1]] = m1
    K0, K1, K2 = _by_wave_number(along, still, layers.stiffness)
    k = k[:, None, None]
    force = np.broadcast_to(np.eye(5)[:, 2:3], (len(k), 5, 1))
    return np.asarray(np.linalg.solve(K0 + s**2 * mass + 1j * k * K1 + k**2 * K2, force)[..., 0])


def _layer_waves(layers: Layers, turn: float, k: FloatArray, s: float) -> FloatArray:
    """Return the deflection w of the top face of elastic layers per unit pressure e^{ikx} on it.

    Quadratic elements through the thickness are used, finer towards the top (E. Kausel and J. M.
    Roësset, Bull. Seism. Soc. Am. 71, 1743, 1981).
    """
    t, z = layers.total_thickness, layers.interfaces
    ends = np.concatenate([z, z[-1] - np.geomspace(2.0 / k[-1], t, _GRADES)])
    ends = np.unique(np.round(ends / t, 6)) * t
    one = np.eye(3)
    n = 3 * (2 * len(ends) - 1)
    bands = np.zeros((4, 9, n))  # lower diagonals of K0, K1, K2 and M
    along, still, (c, d) = np.zeros((6, 3)), np.zeros((6, 3)), (np.cos(turn), np.sin(turn))
    along[[0, 3, 5], [0, 1, 2]] = c
    along[[1, 3, 4], [1, 0, 2]] = d
    still[[2, 4, 5], [2, 1, 0]] = 1.0
    points, weights = np.polynomial.legendre.leggauss(3)
    shapes = [np.kron([0.5 * x * (x - 1.0), 1.0 - x * x, 0.5 * x * (x + 1.0)], one) for x in points]
    slopes = [np.kron([x - 0.5, -2.0 * x, x + 0.5], one) for x in points]
    low, high = np.tril_indices(9)
    for number, (lower, upper) in enumerate(pairwise(ends.tolist())):
        ply = layers.plies[max(int(np.searchsorted(z[:-1], 0.5 * (lower + upper))) - 1, 0)]
        stiffness: FloatArray = np.asarray(np.linalg.inv(ply.compliance), dtype=np.float64)
        half = 0.5 * (upper - lower)
        for weight, shape, slope in zip(weights, shapes, slopes, strict=True):
            elastic = _by_wave_number(along @ shape, still @ slope / half, stiffness)
            for band, of in zip(bands, (*elastic, ply.material.rho * shape.T @ shape), strict=True):
                band[low - high, 6 * number + high] += weight * half * of[low, high]
    K0, K1, K2, M = bands
    fixed, force = K0 + s**2 * M, np.eye(n)[-1]
    found = [
        scipy.linalg.solveh_banded(fixed + 1j * q * K1 + q * q * K2, force, lower=True)[-1].real
        for q in k
    ]
    return np.array(found)


def _by_wave_number(
    along: FloatArray, still: FloatArray, stiffness: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return K0, K1 and K2 of the matrix BᴴCB = K0 + ik K1 + k² K2, with B = ik along + still."""
    mixed = still.T @ stiffness @ along
    return still.T @ stiffness @ still, mixed - mixed.T, along.T @ stiffness @ along


def rim_nodes(nodes: FloatArray, cells: Sequence[IntArray]) -> BoolArray:
    """Return a mask of the nodes on edges that no two elements share, shape (n_nodes,)."""
    ends, number = sides(nodes, cells)[:2]
    rim = np.zeros(len(nodes), dtype=bool)
    rim[ends[np.bincount(number)[number] == 1]] = True
    return rim
