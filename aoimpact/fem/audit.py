"""Mass, centre, density and wave speed of a body, which reveal wrong units in K and M.

All are computed from K, M, and the coordinates and labels of their rows alone.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import scipy

from ..base import FloatArray, aligned, record, sp, with_unit
from ..mesh import motions_at
from .labels import axes_of
from .model import FEW_DIGITS

# Plausible ratios of a body's mass to its bounding box's volume, kg/m³: from foam and thin rings to
# tungsten.
_DENSITIES = 10.0, 25e3

# Range of longitudinal wave speeds in solids, m/s: from cork (500) to diamond (18 000), "Speed of
# sound in various media", CRC Handbook of Chemistry and Physics. K in N/mm with M in kg gives
# speeds √1000 = 32 times too low.
_SPEEDS = 500.0, 20e3

# Typical wave speed, m/s; the ratio of a body's speed to it suggests which units were mixed up.
_TYPICAL_SPEED = 5e3

# Likely causes of an implausible wave speed. Each key is the largest ratio of the speed to the
# typical speed for which its cause holds. Coordinates in millimetres read as metres raise the speed
# a thousandfold; the opposite mistake lowers it a thousandfold.
_SOFT = "of foam, soft rubber or much added mass; else, K in N/mm beside M in kg?"
_CAUSES = {
    1e-4: _SOFT,
    5e-3: "coordinates in metres, and length=1e-3 given?",
    1.0: _SOFT,
    200.0: "of no solid; K in N/m beside M in tonnes, or not the files' unit of length?",
    1e4: "coordinates in millimetres? Give length=1e-3 (with N and tonnes, mass=1e3)",
}

# Smallest thickness of the bounding box, relative to its largest edge, in an estimate of density:
# the box of nodes in one plane has no volume.
_THINNEST = 1e-3

# Relative elastic force ‖K r‖ / ‖|K| |r|‖ of a rigid motion r above which supports resist r; below
# `FEW_DIGITS`, r is free.
_RESISTED = 1e-4

# Largest share of couplings that may be missing in K or M; above it, rows or nodes are probably in
# different orders.
_MOST_MISSING = 0.5


@record
class Audit:
    """Mass, size, wave speed and frequencies of a body, which reveal wrong units and files.

    Attributes
    ----------
    n_dofs, n_nodes : int
        Numbers of free degrees of freedom and of nodes.
    mass : float or None
        Mass, kg; None if M does not determine it.
    centre : ndarray, shape (3,), or None
        Centre of mass, m.
    extent : ndarray, shape (3,), or None
        Edges of the box around the nodes, m.
    density : float or None
        Ratio of mass to the volume of the box around the nodes, kg/m³. If M lacks the constrained
        nodes, the mass is estimated from the free nodes.
    speed : float or None
        Speed of longitudinal waves, m/s: √(dᵀKd/tᵀMt) for a displacement d of uniform strain and a
        translation t along an axis, median over the three axes. Exact for a free uniform body;
        supports raise the value, added masses lower it.
    rigid_residual : tuple of float
        Relative elastic force ‖K r‖ / ‖abs(K) abs(r)‖ of the translations r along x, y, z and, with
        coordinates, of the rotations about these axes. Below 1e-6 nothing resists the motion r.
    frequencies : ndarray
        Lowest natural frequencies, Hz.
    doubts : tuple of str
        Implausible values, each with its likely cause.

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
        rows.append(("mass", "not known" if self.mass is None else with_unit(self.mass, "kg")))
        for name, place in (("centre of mass", self.centre), ("extent", self.extent)):
            if place is not None:
                rows.append((name, ", ".join(f"{x:.4g}" for x in place) + " m"))
        if self.density is not None:
            rows.append(("mass over box", f"{self.density:.3g} kg/m³"))
        if self.speed is not None:
            rows.append(("waves at", f"{self.speed:.3g} m/s"))
        for name, value in zip(
            ("x", "y", "z", "rx", "ry", "rz"), self.rigid_residual, strict=False
        ):
            moved = "free" if value < FEW_DIGITS else "constrained"
            rows.append((f"rigid motion {name}", f"{value:.1e} ({moved})"))
        if len(self.frequencies):
            rows.append(("frequencies", ", ".join(f"{f:.4g}" for f in self.frequencies) + " Hz"))
        table = "\n".join(aligned(rows, left=(0, 1)))
        return "\n".join([table, *(f"! {doubt}" for doubt in self.doubts)])


def audited(body: Any, *, frequencies: int = 8) -> Audit:
    """Return the audit of an `FEModel`; see `FEModel.audit`."""
    nodes, labels, mass = body.nodes, body.labels, body.mass
    axes = axes_of(body.free, labels, 0 if nodes is None else len(nodes))
    n_nodes = None if labels is None else len(np.unique(labels[:, 0]))
    centre = extent = density = speed = None
    residuals: tuple[float, ...] = ()
    if axes is not None:
        motions = axes
        if nodes is not None:
            places = nodes - nodes.mean(axis=0)
            motions = motions_at(places, rotations=True).reshape(-1, 6)[body.free]
        most = np.linalg.norm(abs(body.K) @ np.abs(motions), axis=0)
        residual = np.linalg.norm(body.K @ motions, axis=0) / np.where(most > 0.0, most, 1.0)
        residuals = tuple(residual.tolist())
    if nodes is not None and axes is not None:
        n_nodes, extent, node = len(nodes), np.ptp(nodes, axis=0), body.free // 3 % len(nodes)
        inertia = body.M @ axes
        if mass is not None:
            centre = (inertia[:, 0] * axes[:, 0]) @ nodes[node] / mass
        moved = np.sum(inertia * axes, axis=0)
        box = float(np.prod(np.maximum(extent, _THINNEST * extent.max())))
        shares = np.bincount(node[body.free < 3 * n_nodes], minlength=n_nodes)
        if shares.sum() == len(node) and box > 0.0:  # shells and beams do not fill a box
            # If the mass is unknown, constrained nodes are taken as heavy as the free ones.
            whole = float(moved.mean()) * 3 * n_nodes / len(node) if mass is None else mass
            density = whole / box
        # Displacement d = x - x₀ of a uniform strain along an axis. x₀: mean of the constrained
        # nodes or, without any, of all nodes.
        constrained = shares < 3
        origin = nodes[constrained if constrained.any() else slice(None)].mean(axis=0)
        strain = (nodes[node] - origin) * axes
        energy, known = np.sum(strain * (body.K @ strain), axis=0), moved > 0.0
        if known.any():
            squares = np.maximum(energy[known], 0.0) / moved[known]
            speed = float(np.median(np.sqrt(squares)))
    count = min(frequencies, body.n_dofs)
    return Audit(
        n_dofs=body.n_dofs,
        n_nodes=n_nodes,
        mass=mass,
        centre=centre,
        extent=extent,
        density=density,
        speed=speed,
        rigid_residual=residuals,
        frequencies=body.frequencies(count) if count else np.zeros(0),
        # K and M assembled from a mesh need no check: the material's own units are checked.
        doubts=()
        if body.assembled
        else (*_doubts_of_order(body, residuals), *_doubts(density, speed)),
    )


def _doubts_of_order(body: Any, residuals: tuple[float, ...]) -> list[str]:
    """Return signs that the rows of K, the rows of M and the nodes are in different orders."""
    if body.nodes is None:  # dofs may be modal coordinates, which M couples and K does not
        return []
    said = []
    if _missing(body.M, body.K) > _MOST_MISSING:
        said.append("M couples rows that K does not: are the rows of both in the same order?")
    free = np.array(residuals) < FEW_DIGITS
    if _missing_neighbours(body) > _MOST_MISSING:
        said.append("K does not couple neighbouring nodes: are the nodes in the order of its rows?")
    elif len(free) == 6 and free[:3].all() and max(residuals[3:]) > _RESISTED:
        said.append(
            "the body is free to move along all axes, and not to turn: are the coordinates those "
            "of the rows, and all in one unit?"
        )
    elif free.sum() > body.rigid_modes.shape[1]:
        said.append(
            f"{free.sum()} rigid motions meet next to no elastic force, and "
            f"{body.rigid_modes.shape[1]} none at all: the rounding of K to few digits holds the "
            "body like soft springs; write K with all its digits"
        )
    return said


def _missing(matrix: Any, other: Any) -> float:
    """Return the share of off-diagonal nonzeros of `matrix` that are zero in `other`."""
    off = sp.triu(matrix, 1).tocsr()
    missing = off.nnz - off.multiply(other).count_nonzero()
    return float(missing / off.nnz) if off.nnz else 0.0


def _missing_neighbours(body: Any) -> float:
    """Return the share of nodes that K does not couple with their nearest neighbour."""
    node = body.free // 3 % len(body.nodes)
    places = np.unique(node)
    if len(places) < 2:
        return 0.0
    near = scipy.spatial.cKDTree(body.nodes[places]).query(body.nodes[places], k=2)[1]
    near = places[np.where(places[near[:, 0]] == places, near[:, 1], near[:, 0])]
    rows = np.arange(len(node))
    of_node = sp.csr_array((np.ones(len(node)), (rows, node)), shape=(len(node), len(body.nodes)))
    coupled = (of_node.T @ abs(body.K) @ of_node).tocsr()
    return float(np.mean(np.asarray(coupled[places, near]).ravel() == 0.0))


def _doubts(density: float | None, speed: float | None) -> list[str]:
    """Return signs of wrong units, each with the likely correction."""
    said = []
    if speed is not None and not _SPEEDS[0] <= speed <= _SPEEDS[1]:
        known = (of for most, of in _CAUSES.items() if speed <= most * _TYPICAL_SPEED)
        cause = next(known, "are the units of length, K and M consistent?")
        said.append(f"K and M have waves at {speed:.3g} m/s: {cause}")
    if density is not None and not _DENSITIES[0] <= density <= _DENSITIES[1]:
        cause = "M in grams, or coordinates in other units than metres?"
        if speed is not None and speed > 100.0 * _TYPICAL_SPEED:
            fitting = density * 1e9  # density if the coordinates are in millimetres
            tonnes = " and mass=1e3" if fitting < 1e3 * _DENSITIES[0] else ""
            cause = f"coordinates in millimetres? Give length=1e-3{tonnes}"
        elif density < _DENSITIES[0]:
            cause = "M in tonnes and K in N/mm? Give mass=1e3 (or is the body mostly air?)"
        said.append(f"mass over the box around the nodes is {density:.3g} kg/m³: {cause}")
    return said
