"""Impact of two rigid bodies with a linear spring between them, in closed form.

With μ = m_p m_t / (m_p + m_t) and ω = √(k/μ) the indentation is (V/ω) sin ωt: a half sine of
duration π/ω, with peak force kV/ω and impulse 2μV.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import aoimpact as ao


@dataclass(frozen=True)
class HalfSine:
    """Mass `projectile` at speed V against mass `target` with spring k; contact at t = gap/V."""

    projectile: float = 2.0
    target: float = 3.0
    k: float = 1.2e4
    velocity: float = 0.5
    gap: float = 0.0

    @property
    def mass(self) -> float:
        return 1.0 / (1.0 / self.projectile + 1.0 / self.target)

    @property
    def omega(self) -> float:
        return math.sqrt(self.k / self.mass)

    @property
    def start(self) -> float:
        return self.gap / self.velocity

    @property
    def duration(self) -> float:
        return math.pi / self.omega

    @property
    def peak(self) -> float:
        return self.k * self.velocity / self.omega

    @property
    def impulse(self) -> float:
        return 2.0 * self.mass * self.velocity

    def result(self, end: float = 1.3, **given: Any) -> ao.Result:
        """Simulate the impact until `end` contact durations after the start of contact."""
        bodies = ao.rigid(self.projectile), ao.rigid(self.target)
        law, duration = ao.Linear(self.k), self.start + end * self.duration
        settings = {"gap": self.gap, "duration": duration, "solver": ao.Adaptive(rtol=1e-9)}
        return ao.simulate(*bodies, self.velocity, law=law, **settings | given)
