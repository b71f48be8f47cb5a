"""Section 3 of the paper: a steel sphere on a like sphere at 1 m/s. Bodies, runs and tables.

Every body and run is computed at its first use, and kept.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..base import FloatArray
from ..fem import ContactPoint, FEModel, Material
from ..impact import simulate
from ..integrate import Newmark
from ..io import paper_sphere_mesh
from ..laws import Hertz
from ..mesh import sphere_mesh
from ..reduction import AOModel, FullModel, ModalModel, antioscillators, full, modal, rigid
from ..results import Result
from .table import Row, Table, printed

STEEL = Material(E=210e9, nu=0.3, rho=7800.0)
RADIUS = 0.01
VELOCITY = 1.0
BALL_MASS = 4.0 / 3.0 * math.pi * RADIUS**3 * STEEL.rho
LAW = Hertz.between(STEEL, RADIUS, STEEL, RADIUS)

# Resolved contact mechanics of these two spheres: fine axisymmetric finite elements
# (6 ... 40 µm at the contact) with unilateral contact, explicit, converged; force ± 0.5 N.
RESOLVED_FORCE, RESOLVED_DURATION = 1014.7, 59.41e-6

# Radius of the patch, m, that the shipped mesh resolves; the contact's own is 0.32 mm.
PATCH = 0.003

# Numbers of modes of Fig. 4; velocities of Fig. 7, m/s; sizes of elements, m, of meshes beside
# the paper's.
MODE_COUNTS = (6, 25, 50, 100, 200, 300, 400, 500, 600, 700, 800, 900, 1000)
SPEEDS = (1e-4, 1e-3, 1e-2, 0.1, 0.25, 0.5, 1.0, 2.0, 10.0)
MESH_SIZES = (0.008, 0.005, 0.003)


def hertz_pair(k: float, mass: float, velocity: float) -> tuple[float, float]:
    """Return peak force and duration of a rigid Hertz impact in closed form.

    δ_max = (5 μ V² / 4k)^(2/5), F = k δ_max^(3/2), T = 2 δ_max/V ∫₀¹ ds/√(1 - s^(5/2)): Johnson,
    *Contact Mechanics*, section 11.4.

    Parameters
    ----------
    k : float
        Hertz's stiffness, N/m^1.5.
    mass : float
        Effective mass μ = m₁m₂/(m₁ + m₂), kg.
    velocity : float
        V, m/s.
    """
    depth = (1.25 * mass * velocity**2 / k) ** 0.4
    integral = math.sqrt(math.pi) * math.gamma(0.4) / (2.5 * math.gamma(0.9))
    return k * depth**1.5, 2.0 * depth / velocity * integral


def at_one_dof(body: FEModel, point: tuple[float, float, float], direction: int) -> ContactPoint:
    """Return the paper's contact functional, eq. (1): ± the unit vector of a dof at a node.

    Made without a place on the surface, so that the law keeps all of its indentation, as the
    paper's does; `FEModel.contact` would take the compliance of the mesh out of it.

    Parameters
    ----------
    body : FEModel
    point : tuple of float
        Coordinates of a node, m.
    direction : int
        1, 2, 3 for x, y, z, or negative.
    """
    assert body.nodes is not None
    assert body.free is not None
    node = int(np.linalg.norm(body.nodes - point, axis=1).argmin())
    b, axis = np.zeros(3 * len(body.nodes)), np.zeros(3)
    b[3 * node + abs(direction) - 1] = axis[abs(direction) - 1] = np.sign(direction)
    return ContactPoint(body, b[body.free], axis)


@dataclass(frozen=True, eq=False)
class SphereStudy:
    """The two spheres of section 3.

    The target is the projectile's mirror image: one contact functional serves both.

    Parameters
    ----------
    dt : float
        Newmark's step for the finite elements and the modal series, s. The paper does not give its
        own; at 0.1 µs the peak force has converged to some 1e-5.
    star_dt : float
        The step for one-AO and rigid spheres, s. The light m0 rings at about half a megahertz: at
        0.1 µs that is a few 1e-4 of the peak force, at 0.01 µs some 1e-6.
    duration : float
        Length of the records, s.
    """

    dt: float = 0.1e-6
    star_dt: float = 0.01e-6
    duration: float = 100e-6

    @cached_property
    def tip(self) -> ContactPoint:
        """The point of the sphere that is touched."""
        body = FEModel.from_mesh(paper_sphere_mesh(), STEEL)
        return at_one_dof(body, (RADIUS, 0.0, 0.0), 1)

    @cached_property
    def frequencies(self) -> FloatArray:
        """Lowest natural frequencies, Hz, six rigid modes first."""
        return self.body.frequencies(24)

    @property
    def body(self) -> FEModel:
        """The finite-element model of one sphere."""
        body = self.tip.body
        assert isinstance(body, FEModel)
        return body

    @property
    def mass(self) -> float:
        """Mass of the finite-element model, kg."""
        assert self.body.mass is not None
        return self.body.mass

    @cached_property
    def oscillator(self) -> AOModel:
        """The sphere by one anti-oscillator (Table 3)."""
        return antioscillators(self.tip, n=1)

    @cached_property
    def modes(self) -> ModalModel:
        """The classical modal model with the most modes of Fig. 4."""
        return modal(self.tip, n=max(MODE_COUNTS))

    @cached_property
    def full(self) -> Result:
        """Both spheres by all their finite elements."""
        return self.pair(full(self.tip))

    @cached_property
    def one_ao(self) -> Result:
        """Both spheres by one anti-oscillator each."""
        return self.pair(self.oscillator)

    @cached_property
    def rigid(self) -> Result:
        """Two rigid spheres."""
        return self.pair(rigid(mass=BALL_MASS))

    @cached_property
    def patched(self) -> Result:
        """One anti-oscillator each, touched over a patch, whose part the law leaves out."""
        place = (RADIUS, 0.0, 0.0)
        tip = self.body.contact(point=place, direction=(1.0, 0.0, 0.0), radius=PATCH)
        return self.pair(antioscillators(tip, n=1))

    @cached_property
    def modal(self) -> dict[int, Result]:
        """Both spheres by their first natural modes, for each number of modes of Fig. 4."""
        return {n: self.pair(self.modes.truncated(n)) for n in MODE_COUNTS}

    @cached_property
    def by_speed(self) -> dict[float, Result]:
        """One anti-oscillator each, for each velocity of Fig. 7."""
        return {speed: self.pair(self.oscillator, speed) for speed in SPEEDS}

    @cached_property
    def meshes(self) -> dict[float, MeshCase]:
        """The impact on other meshes, for each size of elements."""
        return {size: mesh_case(self, size) for size in MESH_SIZES}

    def printed(self, mass: float) -> Result:
        """One anti-oscillator each, with the numbers that the paper prints in Table 3."""
        return self.pair(
            AOModel(m0=0.001 * mass, m=np.array([0.999 * mass]), k=np.array([275.7e6]))
        )

    def pair(self, body: AOModel | ModalModel | FullModel, speed: float = VELOCITY) -> Result:
        """Run two like bodies against each other; contact times go as V^(-1/5), and so does dt."""
        slower = (VELOCITY / speed) ** 0.2
        dt = self.star_dt if isinstance(body, AOModel) else self.dt
        return simulate(
            projectile=body,
            target=body,
            law=LAW,
            velocity=speed,
            duration=slower * self.duration,
            solver=Newmark(dt=slower * dt),
        )


@dataclass(frozen=True)
class MeshCase:
    """One sphere mesh: how many nodes, the k1 it gives, and the force of the impact."""

    nodes: int
    k1: float
    peak_force: float
    duration: float


def mesh_case(study: SphereStudy, size: float) -> MeshCase:
    """Return the paper's impact, one anti-oscillator each, on a mesh with elements of `size` m."""
    body = FEModel.from_mesh(sphere_mesh(RADIUS, size), STEEL)
    model = antioscillators(at_one_dof(body, (RADIUS, 0.0, 0.0), 1), n=1)
    hit = study.pair(model)
    assert body.nodes is not None
    return MeshCase(len(body.nodes), float(model.k[0]), hit.peak_force, hit.contact_duration)


# --------------------------------------------------------------------------------- tables


def table_1(study: SphereStudy) -> Table:
    """Table 1, and eq. (13): the sphere and Hertz's stiffness."""
    return printed("table_1", 1e3 * BALL_MASS, 1e3 * study.mass, LAW.k / 1e10)


def table_2(study: SphereStudy) -> Table:
    """Table 2: natural frequencies."""
    groups = multiplets(study.frequencies[6:])[:3]
    rigid_modes = float(np.abs(study.frequencies[:6]).max())
    counts = {f"f{i}": len(group) for i, group in enumerate(groups, 2)}
    return printed("table_2", rigid_modes, *(1e-6 * group.mean() for group in groups), **counts)


def multiplets(frequencies: FloatArray, apart: float = 0.03) -> list[FloatArray]:
    """Split ascending frequencies where two neighbours are more than `apart`, relative."""
    gaps = np.flatnonzero(np.diff(frequencies) > apart * frequencies[1:])
    return np.split(frequencies, gaps + 1)


def table_3(study: SphereStudy) -> Table:
    """Table 3: the anti-oscillator of the sphere."""
    model = study.oscillator
    m0, m1 = (100.0 * m / study.mass for m in (model.m0, float(model.m[0])))
    return printed("table_3", model.k0, m0, 1e-6 * float(model.k[0]), m1)


def impact_table(study: SphereStudy) -> Table:
    """The numbers of Figure 3 and section 3."""
    full, one, hard = study.full, study.one_ao, study.rigid
    return printed(
        "impact",
        *(full.peak_force, 1e6 * full.contact_duration, one.peak_force, hard.peak_force),
        *excesses(hard, full),
    )


def excesses(hit: Result, base: Result) -> tuple[float, float]:
    """Excess of peak force and duration over those of another run, %."""
    force = hit.peak_force / base.peak_force
    duration = hit.contact_duration / base.contact_duration
    return 100.0 * (force - 1.0), 100.0 * (duration - 1.0)


def method_table(study: SphereStudy) -> Table:
    """Numbers that do not depend on the mesh: the method itself."""
    peak, duration = hertz_pair(LAW.k, 0.5 * BALL_MASS, VELOCITY)
    own, light = study.printed(BALL_MASS), study.printed(0.03258)
    return printed(
        "method",
        *excesses(study.one_ao, study.full),
        *(own.peak_force, light.peak_force, 1e6 * own.contact_duration),
        *(peak, 1e6 * duration),
    )


def modal_table(study: SphereStudy) -> Table:
    """Figure 4: the modal series."""
    forces = (excesses(study.modal[n], study.full)[0] for n in (50, 200, 500))
    return printed("modal", *excesses(study.modal[1000], study.full), *forces)


def energy_table(study: SphereStudy) -> Table:
    """Figures 5 and 7: where the energy goes."""
    percent = 100.0 / (0.5 * study.mass * VELOCITY**2)
    target = study.one_ao.energy.target
    ratios = (local_over_nonlocal(study.by_speed[speed]) for speed in (1e-4, 1.0, 10.0))
    kept = percent * float(target.kinetic[-1]), percent * float(target.elastic[-1])
    return printed("energy", *kept, *ratios)


def local_over_nonlocal(hit: Result) -> float:
    """Return contact energy over the target's elastic energy, at the largest indentation."""
    at = int(np.argmax(hit.energy.contact))
    return float(hit.energy.contact[at] / hit.energy.target.elastic[at])


def resolved_table(study: SphereStudy) -> Table:
    """Resolved contact mechanics, and how far off each model is."""
    values: list[float] = []
    for hit in (study.full, study.rigid, study.patched):
        values += [hit.peak_force, 1e6 * hit.contact_duration]
    return printed("resolved", *values, 811.5)


def mesh_table(study: SphereStudy) -> Table:
    """Dependence of k1 and the force on the mesh."""
    rows = []
    for size, case in study.meshes.items():
        name = f"{case.nodes} nodes ({1e3 * size:g} mm)"
        rows.append(Row(f"{name}, k1", 1e-6 * case.k1, "", "MN/m"))
        rows.append(Row(f"{name}, peak force", case.peak_force, "", "N"))
    return Table("k1 and the force belong to the mesh: one AO each, one loaded node", tuple(rows))


# Those of the paper, in its order.
SPHERE_TABLES = (
    *(table_1, table_2, table_3, impact_table, method_table),
    *(modal_table, energy_table),
)
