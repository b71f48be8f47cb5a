"""A load cell between the nose of a tup and its carriage: what it reads of the contact force."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
import numpy.typing as npt

from ..base import (
    HUGE,
    FloatArray,
    InputError,
    checked,
    finite_array,
    nonnegative,
    positive,
    text,
    warn,
)
from ..fem import Material, Rayleigh
from ..reduction import AOModel, ball
from ..results import Result
from .oscillator import Oscillator
from .signal import Signal

# A period of the cell is sampled so often.
_PER_PERIOD = 40

# Masses of a tup and of a cell's that differ by more are not the same body.
_SAME_MASS = 0.01


@dataclass(frozen=True, kw_only=True)
class LoadCell:
    """A spring and a dashpot between the nose, which touches, and the carriage, which pushes.

    The cell reads the force in them, N = k d + c d' with d = x_carriage - x_nose. Under a contact
    force F, with m_n and m_c the masses and μ = m_n m_c/(m_n + m_c),

        d'' + 2ζω d' + ω² d = F/m_n,  ω² = k/μ,  2ζω = c/μ:

    of a slow force the cell reads m_c/(m_n + m_c), since the nose's own inertia lies before it;
    near its frequency it rings.

    Parameters
    ----------
    nose, carriage : float
        Masses before and behind the cell, its own halved between them, kg.
    stiffness : float
        k, N/m.
    damping_ratio : float, optional
        ζ of the two masses on the cell, below 1.

    Examples
    --------
    >>> cell = LoadCell(nose=0.3, carriage=5.0, stiffness=5e8, damping_ratio=0.02)
    >>> f"{cell.frequency:.0f} Hz"
    '6690 Hz'
    >>> f"{cell.gain(0.0):.3f}, {cell.gain(1000.0):.3f}"
    '0.943, 0.965'
    """

    nose: float
    carriage: float
    stiffness: float
    damping_ratio: float = 0.0

    def __post_init__(self) -> None:
        mass = partial(positive, unit="kg")
        checked(self, nose=mass, carriage=mass, stiffness=partial(positive, unit="N/m"))
        checked(self, damping_ratio=nonnegative)
        if self.damping_ratio >= 1.0:
            raise InputError(
                f"damping_ratio must be below 1, got {self.damping_ratio:g}; cells have some 0.01"
            )

    @property
    def mass(self) -> float:
        """Mass of nose and carriage, kg."""
        return self.nose + self.carriage

    @property
    def share(self) -> float:
        """Reading over a slow contact force: the carriage's share of the mass."""
        return self.carriage / self.mass

    @property
    def omega(self) -> float:
        """Undamped angular frequency of the two masses on the cell, rad/s."""
        return math.sqrt(self.stiffness / self.nose / self.share)

    @property
    def frequency(self) -> float:
        """Undamped natural frequency of the two masses on the cell, Hz."""
        return self.omega / (2.0 * math.pi)

    @property
    def damping(self) -> float:
        """Constant of the dashpot, c = 2ζω μ, N s/m."""
        return 2.0 * self.damping_ratio * self.omega * self.nose * self.share

    def gain(self, frequency: npt.ArrayLike) -> Any:
        """Return the amplitude of the reading over that of the contact force.

        Parameters
        ----------
        frequency : array_like
            Frequency of the force, Hz, any shape.

        Examples
        --------
        >>> cell = LoadCell(nose=0.2, carriage=2.2, stiffness=6e8)
        >>> round(float(cell.gain(0.0)), 4) == round(cell.share, 4)
        True
        """
        f = finite_array("frequency", frequency, unit="Hz", most=HUGE)
        s = 2j * math.pi * f
        slow = 2.0 * self.damping_ratio * self.omega * s + self.omega**2
        found: FloatArray = self.share * np.abs(slow / (s * s + slow))
        return found[()]

    def tup(
        self, radius: float | None = None, material: Material | None = None, *, name: str = "tup"
    ) -> AOModel:
        """Return nose, cell and carriage as a model that strikes: m0, k1, m1 of a star.

        Parameters
        ----------
        radius : float, optional
            Radius of the nose's round end, m, which with its material gives a contact law; without
            them give the law to `simulate`.
        material : Material, optional
        name : str, optional

        Examples
        --------
        >>> import aoimpact as ao
        >>> cell = LoadCell(nose=0.3, carriage=5.0, stiffness=5e8, damping_ratio=0.02)
        >>> steel = ao.Material(E=210e9, nu=0.3, rho=7800)
        >>> cell.tup(radius=0.008, material=steel)
        AOModel('tup', 1 oscillators, 5.3 kg, free)
        """
        if (radius is None) != (material is None):
            raise InputError("tup needs both radius and material of the nose, or neither")
        surface = None
        if radius is not None and material is not None:
            surface = ball(radius, material).surface
        return AOModel(
            m0=self.nose,
            m=np.array([self.carriage]),
            k=np.array([self.stiffness]),
            damping=Rayleigh(beta=self.damping / self.stiffness) if self.damping_ratio else None,
            surface=surface,
            name=text("name", name),
        )

    def read(self, source: Any, *, rate: float | None = None) -> Signal:
        """Return the reading of the cell.

        Parameters
        ----------
        source : Result, Signal or (t, force)
            An impact by `tup()`: the force in the cell, exactly, and what the cell does to the
            contact with it. Of any other, the contact force is taken for the same with a cell
            behind the nose: right where the cell is much stiffer than the contact.
        rate : float, optional
            Samples a second of a result, Hz; by itself 40 in a period of the cell, and 500 in the
            hardest contact.

        Returns
        -------
        Signal

        Warns
        -----
        AOImpactWarning
            If the mass of the projectile is not that of nose and carriage.

        Examples
        --------
        >>> import aoimpact as ao
        >>> cell = LoadCell(nose=0.3, carriage=5.0, stiffness=5e8, damping_ratio=0.02)
        >>> plate = ao.AOModel(m0=0.1, k0=5e6)
        >>> law = ao.Hertz(k=1e10)
        >>> hit = ao.simulate(projectile=cell.tup(), target=plate, law=law, velocity=2.0)
        >>> cell.read(hit)
        Signal(load cell, 1771 samples at 267.6 kHz, largest 17.65 kN)
        """
        if isinstance(source, Result):
            return self._of_result(source, None if rate is None else positive("rate", rate))
        force = Signal.of(source, rate=rate)
        oscillator = Oscillator(self.omega, self.damping_ratio)
        states = oscillator.states(force.values, 1.0 / force.rate)[0]
        response = 2.0 * np.real(oscillator.acceleration_share * states)
        return Signal(force.t, self.share * response, unit=force.unit, name="load cell")

    def _of_result(self, hit: Result, rate: float | None) -> Signal:
        force = Signal.of(hit, rate=rate)
        if rate is None and hit.recorder.dense:
            force = Signal.of(hit, rate=max(force.rate, _PER_PERIOD * self.frequency))
        if not self._strikes(hit):
            self._compare_mass(hit)
            return self.read(force)
        body = hit.at(force.t).projectile if hit.recorder.dense else hit.projectile
        spread = (body.centre_displacement - body.displacement) / self.share
        rate_of = (body.centre_velocity - body.velocity) / self.share
        values = self.stiffness * spread + self.damping * rate_of
        times = force.t if hit.recorder.dense else hit.t
        return Signal(times, values, name="load cell")

    def _strikes(self, hit: Result) -> bool:
        """True if the projectile is this cell's tup."""
        model, own = hit.plan.bodies[0], self.tup()
        return (
            isinstance(model, AOModel)
            and (model.m0, model.k0, model.damping) == (own.m0, 0.0, own.damping)
            and np.array_equal(model.m, own.m)
            and np.array_equal(model.k, own.k)
        )

    def _compare_mass(self, hit: Result) -> None:
        mass = hit.projectile.mass
        if mass is None or abs(mass - self.mass) > _SAME_MASS * self.mass:
            given = "not known" if mass is None else f"{mass:g} kg"
            warn(
                f"the projectile's mass, {given}, is not {self.mass:g} kg, nose and carriage; "
                "strike with cell.tup()"
            )
