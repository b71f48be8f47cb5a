"""Section 4 of the paper: the sphere on a simply supported beam. Bodies, runs and tables.

Each body and each run is computed when it is first used, and kept.
"""

from __future__ import annotations

import math
from functools import cache
from typing import Literal

import numpy as np

import aoimpact as ao

from ..base import FloatArray
from .sphere import BALL, RADIUS, STEEL, VELOCITY, at_one_dof, excesses, force_and_time, one_ao
from .table import Row, beside

ALUMINIUM = ao.Material(E=70e9, nu=0.3, rho=2400.0)
LENGTH, WIDTH = 1.0, 0.02
BEAM_MASS = ALUMINIUM.rho * LENGTH * WIDTH**2
LAW = ao.Hertz.between(STEEL, RADIUS, ALUMINIUM, math.inf)

COUNT = 28  # number of anti-oscillators of the beam
STEP = 2e-6  # Newmark's step in the paper, s
SHORT, LONG = 200e-6, 20e-3  # length of the records of Figs. 9 and 10, and of Fig. 11, s

PAPER_FREQUENCIES = (58.0, 233.0, 315.0, 520.0, 915.0)  # natural, in Table 5, Hz

# Modes with a larger share of vertical motion in the kinetic energy count as vertical bending.
_VERTICAL = 0.75


def bending_frequency(order: int) -> float:
    """Return natural frequency number j = `order` of the simply supported Euler-Bernoulli beam, Hz.

    f = (jπ)²/(2πL²) √(EI/ρA), with I/A = h²/12.
    """
    speed = math.sqrt(ALUMINIUM.E / ALUMINIUM.rho) * WIDTH / math.sqrt(12.0)
    return (order * math.pi) ** 2 / (2.0 * math.pi * LENGTH**2) * speed


def beam_model(kind: str = "hexahedron", level: float = 0.0) -> ao.FEModel:
    """Return the beam on its supports: one bottom edge pinned, the other on rollers.

    The pinned edge has three nodes held in x, y and z, the other three nodes held in y and z:
    fifteen constraints, as the paper's 1362 dofs imply. z is up, and the beam lies along x; the
    supports are `level` m above its bottom.
    """
    mesh = ao.box_mesh((LENGTH, WIDTH, WIDTH), (50, 2, 2), kind=kind)
    line = np.flatnonzero(np.isclose(mesh.nodes[:, 2], level))
    pinned, rollers = (np.intersect1d(mesh.node_sets[end], line) for end in ("xmin", "xmax"))
    return ao.FEModel.from_mesh(mesh, ALUMINIUM, fixed=[(pinned, "xyz"), (rollers, "yz")])


@cache
def beam() -> ao.ContactPoint:
    """Return the contact point at the centre of the beam's top surface."""
    return at_one_dof(beam_model(), (0.5 * LENGTH, 0.5 * WIDTH, WIDTH), (0.0, 0.0, -1.0))


@cache
def star(order: Literal["mass", "frequency"] = "mass") -> ao.AOModel:
    """Return the AO model of the beam's anti-oscillators of largest mass or lowest frequency."""
    return ao.antioscillators(beam(), n=COUNT, order=order)


@cache
def hit(models: str, duration: float = SHORT, step: float = STEP) -> ao.Result:
    """Run the sphere against the beam.

    Parameters
    ----------
    models : str
        "ao": sphere of one anti-oscillator on the beam's anti-oscillators; "rigid": rigid sphere on
        the beam's anti-oscillators; "full": sphere of one anti-oscillator on the beam's finite
        elements.
    duration, step : float
        Length of the record and Newmark's step, s.
    """
    return ao.simulate(
        projectile=BALL if models == "rigid" else one_ao(),
        target=ao.full(beam()) if models == "full" else star(),
        law=LAW,
        velocity=VELOCITY,
        duration=duration,
        solver=ao.Newmark(dt=step),
    )


def table_4() -> list[Row]:
    """Table 4, and eqs. (16), (17): the beam and Hertz's stiffness."""
    return beside("table_4", beam().body.n_dofs, 1e3 * star().mass, LAW.k / 1e10)


def table_5() -> list[Row]:
    """Table 5: natural frequencies; the lowest also with quadratic elements and by beam theory."""
    body, model = beam().body, ao.modal(beam(), n=7)
    kinetic = model.modes * (body.M @ model.modes)
    vertical = np.sum(kinetic[body.free % 3 == 2], axis=0) > _VERTICAL
    nearest = []
    for paper in PAPER_FREQUENCIES:  # no vertical mode is near 315 Hz
        among = model.frequencies if paper == 315.0 else model.frequencies[vertical]
        nearest.append(among[np.argmin(np.abs(among - paper))])
    quadratic = beam_model("hexahedron20").frequencies(1)[0]
    return beside(
        "table_5",
        *(*nearest, quadratic, bending_frequency(1)),
        listed=", ".join(f"{f:.0f}" for f in model.frequencies),
        raised=beam_model(level=0.5 * WIDTH).frequencies(7)[-1],
    )


def oscillators() -> list[Row]:
    """Figure 8: the masses of the beam's anti-oscillators."""
    fractions, lowest = (100.0 * star(by).mass_fractions for by in ("mass", "frequency"))
    values = 1e3 * star().static_mass, fractions.max(), lowest.sum(), fractions.sum()
    return beside("oscillator", *values, n=COUNT)


def force() -> list[Row]:
    """Figure 9: impact force of the sphere on the beam."""
    one, fine = hit("ao"), hit("ao", step=0.01 * STEP)
    values = *force_and_time(one), *force_and_time(hit("rigid"))
    return beside("force", *values, apart(one.force, hit("full").force), excesses(one, fine)[0])


def displacement() -> list[Row]:
    """Figures 10 and 11: displacements of the beam."""
    one, exact = hit("ao"), hit("full").target.displacement
    pushed = 1e6 * np.trapezoid(one.force * (one.t[-1] - one.t), one.t) / BEAM_MASS
    long, hard, whole = (
        hit(models, LONG).target.centre_displacement for models in ("ao", "rigid", "full")
    )
    return beside(
        "displacement",
        1e6 * np.abs(one.target.centre_displacement).max(),
        1e6 * np.abs(one.target.displacement).max(),
        *(apart(one.target.displacement, exact), apart(long, whole), apart(hard, long)),
        pushed=pushed,
    )


def apart(first: FloatArray, second: FloatArray) -> float:
    """Return the largest difference between two histories, in percent of the largest value."""
    return 100.0 * float(np.abs(first - second).max() / np.abs(second).max())
