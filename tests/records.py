"""A contact in closed form, for the tests: two rigid bodies and a linear spring between them.

With μ = m_p m_t / (m_p + m_t) and ω = √(k/μ) the indentation is (V/ω) sin ωt: a half sine of
duration π/ω, with peak force kV/ω and impulse 2μV.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

import aoimpact as ao
from aoimpact import Result
from aoimpact.impact import plan_impact
from aoimpact.integrate import SteppedRecorder

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class HalfSine:
    """A mass `projectile` at speed V against a mass `target`, spring k; they touch at gap/V."""

    projectile: float = 2.0
    target: float = 3.0
    k: float = 1.2e4
    velocity: float = 0.5
    gap: float = 0.0
    held: bool = False
    law: Any = field(default_factory=lambda: ao.Linear(1.2e4))

    @property
    def mass(self) -> float:
        if np.isinf(self.target):
            return self.projectile
        return self.projectile * self.target / (self.projectile + self.target)

    @property
    def omega(self) -> float:
        return float(np.sqrt(self.k / self.mass))

    @property
    def start(self) -> float:
        return self.gap / self.velocity

    @property
    def duration(self) -> float:
        return float(np.pi / self.omega)

    @property
    def peak(self) -> float:
        return self.k * self.velocity / self.omega

    @property
    def impulse(self) -> float:
        return 2.0 * self.mass * self.velocity

    def times(self, samples: int, end: float) -> FloatArray:
        """`samples` times from 0 to `end`, in units of the contact's duration after its start."""
        return np.linspace(0.0, self.start + end * self.duration, samples)

    def motion(self, t: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Force, indentation and its rate at the times `t`."""
        since = t - self.start
        angle = self.omega * np.clip(since, 0.0, self.duration)
        depth = self.velocity / self.omega * np.sin(angle)
        depth += self.velocity * np.minimum(since, 0.0)
        depth -= self.velocity * np.maximum(since - self.duration, 0.0)
        rate = self.velocity * np.cos(angle)
        inside = (since > 0.0) & (since < self.duration)
        return np.where(inside, self.k * depth, 0.0), depth, rate

    def record(self, t: FloatArray) -> FloatArray:
        """The record as the C core lays it out."""
        force, depth, rate = self.motion(t)
        share = 0.0 if np.isinf(self.target) else self.mass / self.target
        v_target = share * (self.velocity - rate)
        u_target = share * (self.velocity * t - depth - self.gap)
        u_projectile = u_target + depth + self.gap
        v_projectile = v_target + rate
        record = np.zeros((20, len(t)))
        record[:3] = force, depth, 0.5 * force**2 / self.k
        for row, mass, u, v in (
            (4, self.projectile, u_projectile, v_projectile),
            (12, self.target, u_target, v_target),
        ):
            kinetic = 0.5 * mass * v**2 if np.isfinite(mass) else 0.0 * v
            record[row : row + 3] = u, v, kinetic
            record[row + 6 : row + 8] = u, v
        return record

    def result(self, samples: int = 2001, end: float = 1.3, energies: bool = True) -> Result:
        t = self.times(samples, end)
        record = self.record(t)
        if not energies:
            record[[2, 3, 6, 7, 8, 9, 14, 15, 16, 17]] = np.nan
        return self.of(t, record, energies)

    def of(self, t: FloatArray, record: FloatArray, energies: bool = True) -> Result:
        """The result of a record, as a solver with fixed steps leaves it."""
        plan = plan_impact(
            ao.rigid(mass=self.projectile),
            ao.AOModel(m0=self.target, k0=1.0 if self.held else 0.0),
            self.law,
            velocity=self.velocity,
            duration=float(t[-1]),
            gap=self.gap,
            energies=energies,
        )
        at_rest = np.zeros(1), np.zeros(1)
        ends = at_rest, at_rest
        recorder = SteppedRecorder(plan, ao.Newmark(), float(t[1]), t, record, ends)
        return Result(plan, recorder, time_error=1e-3)
