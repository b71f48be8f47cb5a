"""Impact on a simply supported plate of cross plies, by Navier's waves of 3-D elasticity.

No code of the package is used. Each wave sin(mπx/a) sin(nπy/b) is discretised through the thickness
by quadratic elements (N. J. Pagano, J. Comp. Mat. 4, 20, 1970, solves the same equations in closed
form). Its bending mode is dynamic, its other modes are quasi-static. The indentation follows
Hertz's law; the compliance of a half-space of the top ply is subtracted from that of each wave.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import numpy.typing as npt
import scipy.linalg
import scipy.optimize

FloatArray = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Sheet:
    """A ply: thickness, m; elasticity matrix in the order xx, yy, zz, xy, yz, xz, Pa; ρ, kg/m³."""

    thickness: float
    stiffness: FloatArray
    rho: float


def orthotropic(
    E: Sequence[float], G: Sequence[float], nu: Sequence[float], angle: int = 0
) -> FloatArray:
    """Elasticity matrix of a ply with fibres along x (0°) or y (90°); G, nu for 12, 13, 23."""
    compliance = np.diag([1 / E[0], 1 / E[1], 1 / E[2], 1 / G[0], 1 / G[2], 1 / G[1]])
    for (i, j), of in zip(((0, 1), (0, 2), (1, 2)), nu, strict=True):
        compliance[i, j] = compliance[j, i] = -of / E[i]
    order = [0, 1, 2, 3, 4, 5] if angle == 0 else [1, 0, 2, 3, 5, 4]
    return np.linalg.inv(compliance)[np.ix_(order, order)]


def waves(plies: Sequence[Sheet], ends: FloatArray, k: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Stiffness and mass matrices per area of waves k, (n, 2), with nodes from bottom to top."""
    n = 3 * (2 * len(ends) - 1)
    K, M = np.zeros((len(k), n, n)), np.zeros((n, n))
    upto = np.cumsum([0.0, *(ply.thickness for ply in plies)])
    points, weights = np.polynomial.legendre.leggauss(3)
    for e, (low, high) in enumerate(pairwise(ends.tolist())):
        ply = plies[int(np.searchsorted(upto, 0.5 * (low + high))) - 1]
        half, own = 0.5 * (high - low), slice(6 * e, 6 * e + 9)
        for x, weight in zip(points, weights, strict=True):
            N = np.kron([0.5 * x * (x - 1), 1 - x * x, 0.5 * x * (x + 1)], np.eye(3))
            dN = np.kron(np.array([x - 0.5, -2 * x, x + 0.5]) / half, np.eye(3))
            B = np.zeros((len(k), 6, 9))
            one, other = k[:, 0, None], k[:, 1, None]
            B[:, 0], B[:, 1], B[:, 2] = -one * N[0], -other * N[1], dN[2]
            B[:, 3] = other * N[0] + one * N[1]
            B[:, 4], B[:, 5] = dN[1] + other * N[2], dN[0] + one * N[2]
            K[:, own, own] += weight * half * np.swapaxes(B, 1, 2) @ ply.stiffness @ B
            M[own, own] += weight * half * ply.rho * N.T @ N
    return K, M


def half_space(ply: Sheet, k: FloatArray) -> FloatArray:
    """Compliance of a half-space of the ply to waves k, from a layer much deeper than the waves."""
    deep = [Sheet(40.0, ply.stiffness, ply.rho)]
    ends = 40.0 - np.append(np.geomspace(40.0, 1e-2, 40), 0.0)
    turns = np.linspace(0.0, 0.5 * math.pi, 17)
    K, _ = waves(deep, ends, np.stack([np.cos(turns), np.sin(turns)], axis=1))
    found = _top(K[:, 3:, 3:])
    return np.interp(np.arctan2(k[:, 1], k[:, 0]), turns, found) / np.linalg.norm(k, axis=1)


def _top(K: FloatArray) -> FloatArray:
    """Deflection of the top per unit pressure on the top, for each wave."""
    load = np.zeros((len(K), K.shape[1], 1))
    load[:, -1] = 1.0
    return np.asarray(np.linalg.solve(K, load)[:, -1, 0])


@dataclass(frozen=True)
class Plate:
    """Bending modes: frequency, rad/s, squared shape at the force, 1/kg; other compliance, m/N."""

    omega: FloatArray
    square: FloatArray
    rest: float


def plate(
    sides: tuple[float, float],
    plies: Sequence[Sheet],
    radius: float,
    place: tuple[float, float] = (0.5, 0.5),
    moving: float = 60.0,
    reach: float = 12.0,
) -> Plate:
    """Return the plate under a force distributed as Hertz's pressure over `radius`, m.

    `place` is the position of the force relative to the sides. Waves up to `moving` half-waves on
    the longer side are dynamic; waves up to k = `reach`/thickness contribute statically.
    """
    t, a, b = math.fsum(ply.thickness for ply in plies), *sides
    top = min(plies[-1].thickness, 0.2 * t)
    upto = np.cumsum([0.0, *(ply.thickness for ply in plies)])
    ends = np.unique(np.append(upto, t - np.geomspace(0.1 * top, 0.5 * top, 3)).round(12))
    m, n = (np.arange(1, reach / t * side / math.pi) for side in sides)
    k = np.stack(np.meshgrid(m * math.pi / a, n * math.pi / b, indexing="ij"), axis=-1)
    share = np.outer(np.sin(m * math.pi * place[0]), np.sin(n * math.pi * place[1])) ** 2
    counted = (np.linalg.norm(k, axis=-1) < reach / t) & (share > 1e-9)
    k, share = k[counted], share[counted]
    size = np.linalg.norm(k, axis=1)
    x = size * radius
    pressure = 3 * (np.sin(x) - x * np.cos(x)) / x**3
    per_area = 4.0 / (a * b) * share * pressure**2
    found, rest = [], 0.0
    for part in np.array_split(np.arange(len(k)), max(1, len(k) // 300)):
        K, M = waves(plies, ends, k[part])
        rest += float(per_area[part] @ (_top(K) - half_space(plies[-1], k[part])))
        for i, K_i in zip(part, K, strict=True):
            if size[i] < moving * math.pi / max(sides):
                squared, shape = scipy.linalg.eigh(K_i, M, subset_by_index=(0, 0))
                found.append((math.sqrt(squared[0]), per_area[i] * shape[-1, 0] ** 2))
    omega, square = np.array(found).T
    return Plate(omega, square, rest - float((square / omega**2).sum()))


def struck(
    plate: Plate, hertz: float, mass: float, velocity: float, lasts: float, step: float
) -> tuple[FloatArray, float]:
    """Force at each time step, N, and final velocity of the ball, m/s."""
    omega = plate.omega
    cosine, sine = np.cos(omega * step), np.sin(omega * step)
    place, rate, shape = np.zeros_like(omega), np.zeros_like(omega), np.sqrt(plate.square)
    ball, speed, forces = 0.0, velocity, [0.0, 0.0]
    for _ in range(round(lasts / step)):
        between = max(1.5 * forces[-1] - 0.5 * forces[-2], 0.0)
        at_rest = shape * between / omega**2
        off = place - at_rest
        place = at_rest + off * cosine + rate / omega * sine
        rate = rate * cosine - off * omega * sine
        ball += speed * step - 0.5 * between / mass * step**2
        speed -= between / mass * step
        near, force = ball - float(shape @ place), 0.0
        if near > 0.0:
            depth = scipy.optimize.brentq(
                lambda d, near=near: d + plate.rest * hertz * max(d, 0.0) ** 1.5 - near,
                0.0,
                2.0 * near + 1e-12,
            )
            force = hertz * depth**1.5
        forces.append(force)
    return np.array(forces[1:]), speed
