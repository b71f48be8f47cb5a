"""What tells a body that was read from one in wrong units: mass, centre, density, speed of sound.

Only K and M, and the coordinates and labels of their rows, are looked at.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy

from ..base import FloatArray, aligned, quantity

__all__ = ["Audit", "audited"]

# Mean densities of solids, kg/m³, over the box around them: from foam and rings to tungsten.
_DENSITIES = 10.0, 25e3

# Speeds that stiffness over mass of an element gives, m/s: from rubber to diamond, with what the
# shape of an element makes of them.
_SPEEDS = 5.0, 1e5

# Of what a unit mistaken is likely to be: millimetres for metres, tonnes or grams for kilograms.
_TYPICAL_SPEED = 4e3

# Elastic force of a rigid motion over that of its entries, that rounding and few digits leave.
_FREE = 1e-6

# Nodes whose neighbours are looked for.
_SAMPLE = 2000


@dataclass(frozen=True, eq=False)
class Audit:
    """A body's figures, by which mistakes of units and files are seen.

    Attributes
    ----------
    n_dofs, n_nodes : int
    mass : float or None
        kg; None where M does not determine it.
    centre : ndarray, shape (3,), or None
        Of mass, m.
    extent : ndarray, shape (3,), or None
        Of the coordinates, m.
    density : float or None
        Mass over the volume of the box around the nodes, kg/m³.
    speed : float or None
        Median of √(K_ii/M_ii) times the distance to the nearest node, m/s: some times the speed of
        sound.
    rigid_residual : tuple of float
        ‖K r‖ relative to what its entries could make, for the translations x, y, z, and, with
        coordinates, the rotations about them: below 1e-6 the body is free to make the motion.
    frequencies : ndarray
        The lowest natural ones, Hz.
    doubts : tuple of str
        What is not like a body, and the likely cause.

    Examples
    --------
    >>> mesh = ao.box_mesh((0.1, 0.01, 0.01), (10, 1, 1), kind="hexahedron20")
    >>> bar = ao.FEModel.from_mesh(mesh, ao.Material(E=70e9, nu=0.33, rho=2700))
    >>> audit = bar.audit(frequencies=0)
    >>> round(audit.mass, 6), audit.doubts
    (0.027, ())
    """

    n_dofs: int
    n_nodes: int | None
    mass: float | None
    centre: FloatArray | None
    extent: FloatArray | None
    density: float | None
    speed: float | None
    rigid_residual: tuple[float, ...]
    frequencies: FloatArray
    doubts: tuple[str, ...]

    def __str__(self) -> str:
        rows = [("dofs", str(self.n_dofs))]
        if self.n_nodes is not None:
            rows.append(("nodes", str(self.n_nodes)))
        rows.append(("mass", "not known" if self.mass is None else quantity(self.mass, "kg")))
        for name, place in (("centre of mass", self.centre), ("extent", self.extent)):
            if place is not None:
                rows.append((name, ", ".join(f"{x:.4g}" for x in place) + " m"))
        if self.density is not None:
            rows.append(("mass over box", f"{self.density:.3g} kg/m³"))
        if self.speed is not None:
            rows.append(("speed from K/M", f"{self.speed:.3g} m/s"))
        for name, value in zip(
            ("x", "y", "z", "rx", "ry", "rz"), self.rigid_residual, strict=False
        ):
            moved = "free" if value < _FREE else "constrained"
            rows.append((f"rigid motion {name}", f"{value:.1e} ({moved})"))
        if len(self.frequencies):
            rows.append(("frequencies", ", ".join(f"{f:.4g}" for f in self.frequencies) + " Hz"))
        table = "\n".join(aligned(rows, left=(0, 1)))
        return "\n".join([table, *(f"! {doubt}" for doubt in self.doubts)])


def audited(body: Any, *, frequencies: int = 8) -> Audit:
    """Return the audit of an `FEModel`; see `FEModel.audit`."""
    nodes, axes = body.nodes, _axes(body)
    centre = extent = density = None
    if nodes is not None:
        extent = np.ptp(nodes, axis=0)
        if body.mass is not None and axes is not None:
            momentum = body.M @ axes
            at = nodes[body.free // 3]
            centre = np.array([momentum[:, 0] @ (axes[:, 0] * at[:, c]) for c in range(3)])
            centre = centre / body.mass
            box = float(np.prod(np.maximum(extent, 1e-3 * extent.max())))
            density = body.mass / box if box > 0.0 else None
    speed = _speed(body)
    count = min(frequencies, body.n_dofs)
    return Audit(
        n_dofs=body.n_dofs,
        n_nodes=_n_nodes(body),
        mass=body.mass,
        centre=centre,
        extent=extent,
        density=density,
        speed=speed,
        rigid_residual=_residuals(body, axes),
        frequencies=body.frequencies(count) if count else np.zeros(0),
        doubts=tuple(_doubts(density, speed)),
    )


def _n_nodes(body: Any) -> int | None:
    if body.nodes is not None:
        return len(body.nodes)
    return None if body.labels is None else len(np.unique(body.labels[:, 0]))


def _axes(body: Any) -> FloatArray | None:
    if body.free is None and body.labels is None:
        return None
    return np.stack([body.translation(axis) for axis in np.eye(3)], axis=1)


def _residuals(body: Any, axes: FloatArray | None) -> tuple[float, ...]:
    """‖K r‖ over ‖|K| |r|‖ of the rigid motions that are known."""
    if axes is None:
        return ()
    motions = [axes[:, c] for c in range(3)]
    if body.nodes is not None:
        at = body.nodes[body.free // 3] - body.nodes.mean(axis=0)
        motions += [np.sum(np.cross(turn, at) * axes, axis=1) for turn in np.eye(3)]
    size = abs(body.K)
    forces = [float(np.linalg.norm(size @ np.abs(r))) for r in motions]
    return tuple(
        float(np.linalg.norm(body.K @ r)) / force if force else 0.0
        for r, force in zip(motions, forces, strict=True)
    )


def _speed(body: Any) -> float | None:
    """Median of √(K_ii/M_ii) times the distance to the nearest other node."""
    if body.nodes is None or len(body.nodes) < 2:
        return None
    step = max(1, len(body.free) // _SAMPLE)
    rows = np.arange(0, len(body.free), step)
    tree = scipy.spatial.cKDTree(body.nodes)
    near = tree.query(body.nodes[body.free[rows] // 3], k=2)[0][:, 1]
    omega2 = body.K.diagonal()[rows] / body.M.diagonal()[rows]
    return float(np.median(np.sqrt(np.maximum(omega2, 0.0)) * near))


def _doubts(density: float | None, speed: float | None) -> list[str]:
    """What wrong units would look like, and which would put it right."""
    said = []
    if speed is not None and not _SPEEDS[0] <= speed <= _SPEEDS[1]:
        said.append(_doubt_of_speed(speed))
    if density is not None and not _DENSITIES[0] <= density <= _DENSITIES[1]:
        said.append(_doubt_of_density(density, speed))
    return said


def _doubt_of_speed(speed: float) -> str:
    ratio = speed / _TYPICAL_SPEED
    cause = "are the units of length, K and M consistent?"
    if 100.0 < ratio < 1e4:
        cause = "coordinates in millimetres? Give length=1e-3 (with N and tonnes, mass=1e3)"
    elif 1e-4 < ratio < 1e-2:
        cause = "coordinates in metres, and length=1e-3 given?"
    elif 10.0 < ratio <= 100.0 or 1e-2 <= ratio < 0.1:
        cause = "K and M in units that do not fit, as N/mm with kg, or N/m with tonnes?"
    return f"stiffness over mass at the distance of nodes is a speed of {speed:.3g} m/s: {cause}"


def _doubt_of_density(density: float, speed: float | None) -> str:
    cause = "is M in kg, and are the coordinates in m?"
    if speed is not None and speed > 100.0 * _TYPICAL_SPEED:
        fitting = density * 1e9  # with millimetres
        tonnes = " and mass=1e3" if fitting < 1e3 * _DENSITIES[0] else ""
        cause = f"coordinates in millimetres? Give length=1e-3{tonnes}"
    elif density < _DENSITIES[0]:
        cause = "M in tonnes and K in N/mm? Give mass=1e3 (or is the body mostly air?)"
    elif density > _DENSITIES[1]:
        cause = "M in grams, or coordinates in other units than metres?"
    return f"mass over the box around the nodes is {density:.3g} kg/m³: {cause}"
