"""Section 3 of the paper: a steel sphere on an equal sphere at 1 m/s. Bodies, runs and tables.

Each body and each run is computed when it is first used, and kept.
"""

from __future__ import annotations

import math
from functools import cache

import numpy as np

import aoimpact as ao

from ..base import FloatArray
from .table import Row, beside

STEEL = ao.Material(E=210e9, nu=0.3, rho=7800.0)
RADIUS = 0.01
VELOCITY = 1.0
BALL_MASS = 4.0 / 3.0 * math.pi * RADIUS**3 * STEEL.rho
LAW = ao.Hertz.between(STEEL, RADIUS, STEEL, RADIUS)
BALL = ao.rigid(mass=BALL_MASS)

# Radius of a contact patch that the mesh supplied with the package resolves, m; the contact radius
# is 0.32 mm.
PATCH = 0.003

# MODE_COUNTS: numbers of modes in Fig. 4. SPEEDS: velocities in Fig. 7, m/s.
MODE_COUNTS = (6, 25, 50, 100, 200, 300, 400, 500, 600, 700, 800, 900, 1000)
SPEEDS = (1e-4, 1e-3, 1e-2, 0.1, 0.25, 0.5, 1.0, 2.0, 10.0)

# Newmark's steps at 1 m/s, s, which the paper does not give. _STEP is for finite elements and
# modes: with it the peak force has converged to some 1e-5. _STAR_STEP is for rigid and one-AO
# spheres: the light m0 vibrates at about half a megahertz, with an error of the peak force of a few
# 1e-4 at 0.1 µs, and of some 1e-6 at 0.01 µs.
_STEP, _STAR_STEP = 0.1e-6, 0.01e-6
_DURATION = 100e-6  # length of the records at 1 m/s, s


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
        Approach velocity V, m/s.
    """
    depth = (1.25 * mass * velocity**2 / k) ** 0.4
    integral = math.sqrt(math.pi) * math.gamma(0.4) / (2.5 * math.gamma(0.9))
    return k * depth**1.5, 2.0 * depth / velocity * integral


def at_one_dof(
    body: ao.FEModel, point: tuple[float, float, float], direction: tuple[float, float, float]
) -> ao.ContactPoint:
    """Return the paper's contact functional, eq. (1): one dof of the node at a point.

    The contact point has no position on the surface, so that the whole indentation is that of the
    law, as in the paper; `FEModel.contact` would take the compliance of the mesh out of the law.

    Parameters
    ----------
    body : FEModel
    point : tuple of float
        Coordinates of a node, m.
    direction : tuple of float
        ± the unit vector of an axis.
    """
    b = np.zeros(body.nodes.shape)
    b[np.linalg.norm(body.nodes - point, axis=1).argmin()] = direction
    return ao.ContactPoint(body, body.on_dofs(b), np.array(direction))


@cache
def sphere() -> ao.ContactPoint:
    """Return the contact point of a sphere of the paper's mesh.

    The target is the projectile's mirror image: one contact point serves both.
    """
    body = ao.FEModel.from_mesh(ao.paper_sphere_mesh(), STEEL)
    return at_one_dof(body, (RADIUS, 0.0, 0.0), (1.0, 0.0, 0.0))


@cache
def one_ao() -> ao.AOModel:
    """Return the model of the sphere with one anti-oscillator (Table 3)."""
    return ao.antioscillators(sphere(), n=1)


@cache
def all_dofs() -> ao.FullModel:
    """Return the full finite-element model of the sphere."""
    return ao.full(sphere())


@cache
def pair(body: ao.AOModel | ao.Body | ao.FullModel, speed: float = VELOCITY) -> ao.Result:
    """Run the impact of two equal bodies; duration and step scale as the contact time, V^(-1/5)."""
    slower = (VELOCITY / speed) ** 0.2
    step = _STAR_STEP if isinstance(body, ao.AOModel) else _STEP
    return ao.simulate(
        projectile=body,
        target=body,
        law=LAW,
        velocity=speed,
        duration=slower * _DURATION,
        solver=ao.Newmark(dt=slower * step),
    )


@cache
def by_modes() -> dict[int, ao.Result]:
    """Run both spheres with their first natural modes, for each number of modes of Fig. 4."""
    modes = ao.modal(sphere(), n=max(MODE_COUNTS))
    return {n: pair(modes.truncated(n)) for n in MODE_COUNTS}


def of_table_3(mass: float) -> ao.Result:
    """Run both spheres with one anti-oscillator each, with the numbers printed in Table 3."""
    return pair(ao.AOModel(m0=0.001 * mass, m=np.array([0.999 * mass]), k=np.array([275.7e6])))


def table_1() -> list[Row]:
    """Table 1, and eq. (13): the sphere and Hertz's stiffness."""
    return beside("table_1", 1e3 * BALL_MASS, 1e3 * one_ao().mass, LAW.k / 1e10)


def table_2() -> list[Row]:
    """Table 2: natural frequencies, six rigid modes first."""
    frequencies = sphere().body.frequencies(24)
    groups = multiplets(frequencies[6:])[:3]
    counts = {f"f{i}": len(group) for i, group in enumerate(groups, 2)}
    rigid_modes = float(np.abs(frequencies[:6]).max())
    return beside("table_2", rigid_modes, *(1e-6 * group.mean() for group in groups), **counts)


def multiplets(frequencies: FloatArray) -> list[FloatArray]:
    """Split ascending frequencies where two neighbours are more than 3 % apart."""
    gaps = np.flatnonzero(np.diff(frequencies) > 0.03 * frequencies[1:])
    return np.split(frequencies, gaps + 1)


def table_3() -> list[Row]:
    """Table 3: the anti-oscillator of the sphere."""
    model, percent = one_ao(), 100.0 / one_ao().mass
    m0, m1 = percent * model.m0, percent * model.m[0]
    return beside("table_3", model.k0, m0, 1e-6 * model.k[0], m1)


def impact() -> list[Row]:
    """Return the rows of Figure 3 and section 3: forces, contact times and their differences."""
    whole, one, hard = map(pair, (all_dofs(), one_ao(), BALL))
    forces = one.peak_force, hard.peak_force
    return beside("impact", *force_and_time(whole), *forces, *excesses(hard, whole))


def force_and_time(hit: ao.Result) -> tuple[float, float]:
    """Return the peak force, N, and the contact duration, µs."""
    return hit.peak_force, 1e6 * hit.contact_duration


def excesses(hit: ao.Result, base: ao.Result) -> tuple[float, float]:
    """Return the excess of peak force and contact duration over another run's values, %."""
    force = hit.peak_force / base.peak_force
    duration = hit.contact_duration / base.contact_duration
    return 100.0 * (force - 1.0), 100.0 * (duration - 1.0)


def method() -> list[Row]:
    """Numbers that follow from the method itself, independent of the mesh."""
    peak, duration = hertz_pair(LAW.k, 0.5 * BALL_MASS, VELOCITY)
    own, light = of_table_3(BALL_MASS), of_table_3(0.03258)
    forces = own.peak_force, light.peak_force, 1e6 * own.contact_duration
    differences = excesses(pair(one_ao()), pair(all_dofs()))
    return beside("method", *differences, *forces, peak, 1e6 * duration)


def modal_series() -> list[Row]:
    """Figure 4: the modal series."""
    differences = {n: excesses(hit, pair(all_dofs())) for n, hit in by_modes().items()}
    return beside("modal", *differences[1000], *(differences[n][0] for n in (50, 200, 500)))


def energy() -> list[Row]:
    """Figures 5 and 7: energies of the target, ratio of local to nonlocal energy."""
    percent = 100.0 / (0.5 * one_ao().mass * VELOCITY**2)
    target = pair(one_ao()).energy.target
    ratios = (local_over_nonlocal(speed) for speed in (1e-4, 1.0, 10.0))
    return beside("energy", percent * target.kinetic[-1], percent * target.elastic[-1], *ratios)


def local_over_nonlocal(speed: float) -> float:
    """Return the ratio of contact to elastic energy of the target, at the largest indentation."""
    energy = pair(one_ao(), speed).energy
    at = int(np.argmax(energy.contact))
    return float(energy.contact[at] / energy.target.elastic[at])


def resolved() -> list[Row]:
    """Forces and contact times of the models, compared with resolved contact mechanics."""
    place = (RADIUS, 0.0, 0.0)
    patch = sphere().body.contact(point=place, direction=(1.0, 0.0, 0.0), radius=PATCH)
    bodies = all_dofs(), BALL, ao.antioscillators(patch, n=1)
    values = [value for body in bodies for value in force_and_time(pair(body))]
    return beside("resolved", *values, 811.5)
