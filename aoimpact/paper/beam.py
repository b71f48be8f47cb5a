"""Section 4 of the paper: the sphere on a simply supported beam. Bodies, runs and tables.

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
from ..integrate import Newmark, find_impulse
from ..laws import Hertz
from ..mesh import box_mesh
from ..reduction import AOModel, ModalModel, antioscillators, full, modal, rigid
from ..results import Result
from .sphere import BALL_MASS, RADIUS, STEEL, VELOCITY, SphereStudy, at_one_dof
from .table import Table, printed

ALUMINIUM = Material(E=70e9, nu=0.3, rho=2400.0)
LENGTH, WIDTH = 1.0, 0.02
BEAM_MASS = ALUMINIUM.rho * LENGTH * WIDTH**2
LAW = Hertz.between(STEEL, RADIUS, ALUMINIUM, math.inf)

PAPER_FREQUENCIES = (58.0, 233.0, 315.0, 520.0, 915.0)  # Hz

# A mode whose kinetic energy is to more than this share vertical is one of vertical bending.
_VERTICAL = 0.75


def bending_frequency(order: int) -> float:
    """Return a natural frequency of the simply supported Euler-Bernoulli beam, Hz.

    f = (jπ)²/(2πL²) √(EI/ρA), with I/A = h²/12.
    """
    speed = math.sqrt(ALUMINIUM.E / ALUMINIUM.rho) * WIDTH / math.sqrt(12.0)
    return (order * math.pi) ** 2 / (2.0 * math.pi * LENGTH**2) * speed


def beam_model(kind: str = "hexahedron", level: float = 0.0) -> FEModel:
    """Return the beam on its supports: one bottom edge pinned, the other on rollers.

    Three nodes each, constrained in x, y and z and in y and z: fifteen constraints, as the paper's
    1362 dofs imply. z is up, the beam lies along x; the supports are `level` m above its bottom.
    """
    mesh = box_mesh((LENGTH, WIDTH, WIDTH), (50, 2, 2), kind=kind)
    line = np.flatnonzero(np.isclose(mesh.nodes[:, 2], level))
    pinned, rollers = (np.intersect1d(mesh.node_sets[end], line) for end in ("xmin", "xmax"))
    return FEModel.from_mesh(mesh, ALUMINIUM, fixed=[(pinned, "xyz"), (rollers, "yz")])


@dataclass(frozen=True, eq=False)
class BeamStudy:
    """The sphere on the beam of section 4.

    Parameters
    ----------
    spheres : SphereStudy
        Source of the projectile's anti-oscillator.
    dt : float
        Newmark's step, s; the paper's.
    short, long : float
        Lengths of the records, s: those of Figs. 9 and 10, and of Fig. 11.
    count : int
        Number of the beam's anti-oscillators.
    """

    spheres: SphereStudy
    dt: float = 2e-6
    short: float = 200e-6
    long: float = 20e-3
    count: int = 28

    @cached_property
    def body(self) -> FEModel:
        """The beam's finite elements."""
        return beam_model()

    @cached_property
    def tip(self) -> ContactPoint:
        """The centre of the top surface."""
        top = (0.5 * LENGTH, 0.5 * WIDTH, WIDTH)
        return at_one_dof(self.body, top, -3)

    @cached_property
    def modes(self) -> ModalModel:
        """The beam's natural modes below 1 kHz."""
        return modal(self.tip, n=7)

    @cached_property
    def vertical(self) -> FloatArray:
        """Which share of each mode's kinetic energy is vertical."""
        assert self.body.free is not None
        up = self.body.free % 3 == 2
        shapes = self.modes.modes
        share: FloatArray = np.sum((shapes * (self.body.M @ shapes))[up], axis=0)
        return share

    @cached_property
    def locking_free(self) -> FloatArray:
        """The lowest natural frequencies with quadratic elements, Hz."""
        return beam_model("hexahedron20").frequencies(1)

    @cached_property
    def raised(self) -> FloatArray:
        """The lowest natural frequencies with the supports at half the beam's height, Hz."""
        return beam_model(level=0.5 * WIDTH).frequencies(7)

    @cached_property
    def star(self) -> AOModel:
        """The beam by its anti-oscillators of largest mass."""
        return antioscillators(self.tip, n=self.count)

    @cached_property
    def lowest(self) -> AOModel:
        """The beam by its anti-oscillators of lowest frequency."""
        return antioscillators(self.tip, n=self.count, order="frequency")

    @cached_property
    def _hits(self) -> dict[tuple[str, float, float], Result]:
        return {}

    def hit(self, models: str, duration: float, dt: float | None = None) -> Result:
        """Run the sphere against the beam, once.

        Parameters
        ----------
        models : str
            "ao", one anti-oscillator on the beam's; "rigid", a rigid sphere on these; "full", one
            anti-oscillator on the beam's finite elements.
        duration : float
            s.
        dt : float, optional
            Newmark's step, s; the paper's if left out.
        """
        key = models, duration, dt or self.dt
        if key not in self._hits:
            self._hits[key] = simulate(
                projectile=rigid(mass=BALL_MASS) if models == "rigid" else self.spheres.oscillator,
                target=full(self.tip) if models == "full" else self.star,
                law=LAW,
                velocity=VELOCITY,
                duration=duration,
                solver=Newmark(dt=key[-1]),
            )
        return self._hits[key]


# --------------------------------------------------------------------------------- tables


def table_4(study: BeamStudy) -> Table:
    """Table 4, and eqs. (16), (17): the beam and Hertz's stiffness."""
    assert study.body.mass is not None
    return printed("table_4", study.body.n_dofs, 1e3 * study.body.mass, LAW.k / 1e10)


def table_5(study: BeamStudy) -> Table:
    """Table 5: natural frequencies, and what they should be."""
    frequencies = study.modes.frequencies
    vertical = frequencies[study.vertical > _VERTICAL]
    nearest = []
    for paper in PAPER_FREQUENCIES:  # 315 Hz is near no vertical one
        among = frequencies if paper == 315.0 else vertical
        nearest.append(float(among[np.argmin(np.abs(among - paper))]))
    return printed(
        "table_5",
        *(*nearest, float(study.locking_free[0]), bending_frequency(1)),
        listed=", ".join(f"{f:.0f}" for f in frequencies),
        raised=study.raised[-1],
    )


def oscillator_table(study: BeamStudy) -> Table:
    """Figure 8: the masses of the beam's anti-oscillators."""
    star = study.star
    fractions, lowest = 100.0 * star.mass_fractions, 100.0 * study.lowest.mass_fractions
    values = 1e3 * star.static_mass, fractions.max(), lowest.sum(), fractions.sum()
    return printed("oscillator", *values, n=star.n)


def force_table(study: BeamStudy) -> Table:
    """Figure 9: the force."""
    ao, hard, exact = (study.hit(models, study.short) for models in ("ao", "rigid", "full"))
    fine = study.hit("ao", study.short, 0.01 * study.dt)
    return printed(
        "force",
        *(ao.peak_force, 1e6 * ao.contact_duration),
        *(hard.peak_force, 1e6 * hard.contact_duration),
        apart(ao.force, exact.force),
        100.0 * (ao.peak_force / fine.peak_force - 1.0),
    )


def displacement_table(study: BeamStudy) -> Table:
    """Figures 10 and 11: how far the beam goes."""
    hit, exact = study.hit("ao", study.short), study.hit("full", study.short).target.displacement
    pushed = 1e6 * find_impulse(hit.t, hit.force * (hit.t[-1] - hit.t)) / BEAM_MASS
    long, hard, full = (
        study.hit(models, study.long).target.centre_displacement
        for models in ("ao", "rigid", "full")
    )
    return printed(
        "displacement",
        1e6 * float(np.abs(hit.target.centre_displacement).max()),
        1e6 * float(np.abs(hit.target.displacement).max()),
        *(apart(hit.target.displacement, exact), apart(long, full), apart(hard, long)),
        pushed=pushed,
    )


def apart(first: FloatArray, second: FloatArray) -> float:
    """Return the largest difference of two histories over the largest value, in percent."""
    return 100.0 * float(np.abs(first - second).max() / np.abs(second).max())


BEAM_TABLES = (table_4, table_5, oscillator_table, force_table, displacement_table)
