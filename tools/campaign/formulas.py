"""Contact laws from their published equations: F = elastic(d) + damper(d) * rate.

Every law of the campaign is linear in the rate. Each branch of a law continues smoothly beyond its
validity, where the integrator stops.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import scipy.interpolate

from .case import Law

Value = tuple[float, float, float]  # elastic force, its slope, damper


class Formula:
    """A law at one contact, with that contact's memory.

    Attributes
    ----------
    viscous : bool
        Whether the force depends on the rate.
    pulls : bool
        Whether negative forces are meant, until the indentation ends.
    rest : float
        Indentation at which the contact begins, m.
    """

    viscous, pulls, rest = False, False, 0.0

    def at(self, d: float) -> Value:
        raise NotImplementedError

    def statically(self, d: float) -> tuple[float, float]:
        """Return force and slope on loading at zero rate."""
        return self.at(d)[:2] if d > 0.0 else (0.0, 0.0)

    def taken(self, d: float) -> float:
        """Return the work of loading at zero rate up to d > 0, J."""
        raise NotImplementedError


class Power(Formula):
    """k d^n + g d^q rate; if linear, it continues below d = 0 without a kink."""

    def __init__(
        self, k: float, n: float = 1.5, g: float = 0.0, q: float = 0.0, *, pulls: bool = False
    ) -> None:
        self.k, self.n, self.g, self.q, self.pulls, self.viscous = k, n, g, q, pulls, g > 0.0
        self.straight = n == 1.0 and (q == 0.0 or g == 0.0)

    def at(self, d: float) -> Value:
        if self.straight:
            return self.k * d, self.k, self.g
        if d <= 0.0:
            return 0.0, 0.0, 0.0
        slope = self.k * d ** (self.n - 1.0)
        return slope * d, self.n * slope, self.g * d**self.q

    def taken(self, d: float) -> float:
        return self.k * d ** (self.n + 1.0) / (self.n + 1.0)


class Thornton(Formula):
    """Hertz up to the yield force, a line beyond; unloading as Hertz on a flattened radius."""

    def __init__(self, k: float, yield_force: float) -> None:
        self.elastic, self.k, self.yield_force = Power(k), k, yield_force
        self.start = (yield_force / k) ** (2.0 / 3.0)
        self.deepest, self.plastic = 0.0, False

    @property
    def limit(self) -> float:
        """Indentation up to which the law is elastic, m."""
        return max(self.deepest, self.start)

    def _plastic(self, d: float) -> Value:
        slope = 1.5 * self.k * math.sqrt(self.start)
        return self.yield_force + slope * (d - self.start), slope, 0.0

    def at(self, d: float) -> Value:
        if self.plastic:
            return self._plastic(d)
        if self.deepest <= self.start:
            return self.elastic.at(d)
        top = self._plastic(self.deepest)[0]
        reach = top / (self.k * math.sqrt(self.deepest))
        share = 1.0 - (self.deepest - d) / reach
        if share <= 0.0:
            return 0.0, 0.0, 0.0
        return top * share**1.5, 1.5 * top * math.sqrt(share) / reach, 0.0

    def statically(self, d: float) -> tuple[float, float]:
        return (self.elastic.at(d) if d <= self.start else self._plastic(d))[:2]

    def taken(self, d: float) -> float:
        before, past = min(d, self.start), max(d - self.start, 0.0)
        return self.elastic.taken(before) + 0.5 * (self.yield_force + self._plastic(d)[0]) * past

    def remember(self, d: float) -> None:
        """Store the deepest indentation `d`, at which the contact turns back."""
        if d > self.limit:
            self.deepest = d
            self.rest = d - self._plastic(d)[0] / (self.k * math.sqrt(d))


class Table(Formula):
    """Law through points by SciPy's PCHIP."""

    def __init__(self, indentation: list[float], force: list[float]) -> None:
        knots, values = list(indentation), list(force)
        if knots[0] > 0.0:
            knots, values = [0.0, *knots], [0.0, *values]
        self.last, self.curve = knots[-1], scipy.interpolate.PchipInterpolator(knots, values)
        self.slope, self.work = self.curve.derivative(), self.curve.antiderivative()

    def at(self, d: float) -> Value:
        if d <= 0.0:
            return 0.0, 0.0, 0.0
        x = min(d, self.last)
        slope = float(self.slope(x))
        return float(self.curve(x)) + slope * (d - x), slope, 0.0

    def taken(self, d: float) -> float:
        return float(self.work(d))


@dataclass
class Patched(Formula):
    """F = k D^1.5 with D = d + c F: Hertz's law without the compliance c of a patch.

    Beyond `deepest` it continues as a line.
    """

    k: float
    compliance: float
    deepest: float

    @property
    def _reach(self) -> float:
        return self.deepest - self.compliance * self.k * self.deepest**1.5

    def _own(self, d: float) -> float:
        """Return D at d > 0 from d = D - c k D^1.5, by Newton's method from below."""
        own = d
        for _ in range(60):
            root = math.sqrt(own)
            left = d - own * (1.0 - self.compliance * self.k * root)
            step = left / (1.0 - 1.5 * self.compliance * self.k * root)
            own += step
            if step <= 1e-16 * own:
                break
        return own

    def at(self, d: float) -> Value:
        if d <= 0.0:
            return 0.0, 0.0, 0.0
        own = self._own(min(d, self._reach))
        force, slope = self.k * own**1.5, 1.5 * self.k * math.sqrt(own)
        slope /= 1.0 - self.compliance * slope
        return force + slope * max(d - self._reach, 0.0), slope, 0.0

    def taken(self, d: float) -> float:
        own, past = self._own(min(d, self._reach)), max(d - self._reach, 0.0)
        within = 0.4 * self.k * own**2.5 - 0.5 * self.compliance * (self.k * own**1.5) ** 2
        force, slope, _ = self.at(self._reach)
        return within + (force + 0.5 * slope * past) * past


_FORMULAS = {
    "Hertz": Power,
    "PowerLaw": Power,
    "Linear": lambda k: Power(k, 1.0),
    "UserLaw": lambda k, n, c: Power(k, n, c * k, n),
    "HuntCrossley": lambda k, damping, n: Power(k, n, damping * k, n),
    "Tsuji": lambda k, alpha, mass: Power(k, 1.5, alpha * math.sqrt(mass * k), 0.25),
    "KuwabaraKono": lambda k, A: Power(k, 1.5, 1.5 * A * k, 0.5),
    "KelvinVoigt": lambda k, c, end: Power(k, 1.0, c, pulls=end == "indentation"),
    "Thornton": Thornton,
    "Tabulated": Table,
}


def formula(law: Law) -> Formula:
    """Return the law in the form of the oracle, anew for each contact: some laws have memory."""
    if law.removed is not None:
        # Valid slightly beyond the limit, so that peaks there are exact.
        return Patched(law.arguments["k"], law.removed, 1.05 * law.deepest)
    return _FORMULAS[law.kind](**law.arguments)
