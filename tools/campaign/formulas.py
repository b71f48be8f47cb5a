"""Contact laws from their published equations: F = elastic(d) + damper(d) * rate.

Every law that the campaign uses is straight in the rate. A branch goes on smoothly as far as it can
beyond where it holds: whoever integrates stops there.
"""

from __future__ import annotations

import bisect
import math
from dataclasses import dataclass
from typing import Any

import scipy.interpolate

from .case import Law

Value = tuple[float, float, float]  # elastic force, its slope, damper


@dataclass
class Formula:
    """A law at one contact, with that contact's memory.

    Attributes
    ----------
    viscous : bool
        Whether the rate matters.
    pulls : bool
        Whether negative forces are meant, up to where the indentation ends.
    straight : bool
        Whether the elastic force goes on as a straight line below the touch.
    rest : float
        Indentation at which the contact begins, m.
    """

    viscous: bool = False
    pulls: bool = False
    remembers: bool = False
    rest: float = 0.0

    def at(self, d: float) -> Value:
        raise NotImplementedError

    def statically(self, d: float) -> tuple[float, float]:
        """Force and slope on the way in at no rate."""
        if d <= 0.0:
            return 0.0, 0.0
        force, slope, _ = self.at(d)
        return force, slope

    def taken(self, d: float) -> float:
        """Work of that force up to d > 0, J."""
        raise NotImplementedError


@dataclass
class Power(Formula):
    """k d^n (1 + chi rate)."""

    k: float = 0.0
    n: float = 1.5
    chi: float = 0.0

    def at(self, d: float) -> Value:
        if self.n == 1.0 and self.chi == 0.0:
            return self.k * d, self.k, 0.0
        if d <= 0.0:
            return 0.0, 0.0, 0.0
        slope = self.k * d ** (self.n - 1.0)
        force = slope * d
        return force, self.n * slope, self.chi * force

    def taken(self, d: float) -> float:
        return self.k * d ** (self.n + 1.0) / (self.n + 1.0)


@dataclass
class Tsuji(Formula):
    """k d^1.5 + g d^.25 rate."""

    k: float = 0.0
    g: float = 0.0

    def at(self, d: float) -> Value:
        if d <= 0.0:
            return 0.0, 0.0, 0.0
        root = math.sqrt(d)
        return self.k * d * root, 1.5 * self.k * root, self.g * math.sqrt(root)

    def taken(self, d: float) -> float:
        return 0.4 * self.k * d**2.5


@dataclass
class Kuwabara(Formula):
    """k (d^1.5 + 1.5 A d^.5 rate)."""

    k: float = 0.0
    lag: float = 0.0

    def at(self, d: float) -> Value:
        if d <= 0.0:
            return 0.0, 0.0, 0.0
        root = math.sqrt(d)
        return self.k * d * root, 1.5 * self.k * root, 1.5 * self.k * self.lag * root

    def taken(self, d: float) -> float:
        return 0.4 * self.k * d**2.5


@dataclass
class Kelvin(Formula):
    """k d + c rate."""

    k: float = 0.0
    c: float = 0.0

    def at(self, d: float) -> Value:
        return self.k * d, self.k, self.c

    def taken(self, d: float) -> float:
        return 0.5 * self.k * d * d


@dataclass
class Thornton(Formula):
    """Hertz up to the yield force, straight on from there, and Hertz on a flatter radius back."""

    k: float = 0.0
    yield_force: float = 0.0
    deepest: float = 0.0
    plastic: bool = False

    @property
    def limit(self) -> float:
        """Indentation up to which it is elastic."""
        return max(self.deepest, (self.yield_force / self.k) ** (2.0 / 3.0))

    def at(self, d: float) -> Value:
        start = (self.yield_force / self.k) ** (2.0 / 3.0)
        slope = 1.5 * self.k * math.sqrt(start)
        if self.plastic:
            return self.yield_force + slope * (d - start), slope, 0.0
        if self.deepest <= start:
            if d <= 0.0:
                return 0.0, 0.0, 0.0
            return self.k * d**1.5, 1.5 * self.k * math.sqrt(d), 0.0
        top = self.yield_force + slope * (self.deepest - start)
        reach = top / (self.k * math.sqrt(self.deepest))
        share = 1.0 - (self.deepest - d) / reach
        if share <= 0.0:
            return 0.0, 0.0, 0.0
        return top * share**1.5, 1.5 * top * math.sqrt(share) / reach, 0.0

    def statically(self, d: float) -> tuple[float, float]:
        start = (self.yield_force / self.k) ** (2.0 / 3.0)
        if d <= start:
            return (self.k * d**1.5, 1.5 * self.k * math.sqrt(d)) if d > 0.0 else (0.0, 0.0)
        slope = 1.5 * self.k * math.sqrt(start)
        return self.yield_force + slope * (d - start), slope

    def taken(self, d: float) -> float:
        start = (self.yield_force / self.k) ** (2.0 / 3.0)
        if d <= start:
            return 0.4 * self.k * d**2.5
        force, _ = self.statically(d)
        return 0.4 * self.k * start**2.5 + 0.5 * (self.yield_force + force) * (d - start)

    def remember(self, d: float) -> None:
        """The contact turns back at `d`."""
        start = (self.yield_force / self.k) ** (2.0 / 3.0)
        if d > max(start, self.deepest):
            self.deepest = d
            top = self.yield_force + 1.5 * self.k * math.sqrt(start) * (d - start)
            self.rest = d - top / (self.k * math.sqrt(d))


class Table(Formula):
    """SciPy's PCHIP through points."""

    def __init__(self, indentation: list[float], force: list[float]) -> None:
        super().__init__()
        knots, values = list(indentation), list(force)
        if knots[0] > 0.0:
            knots, values = [0.0, *knots], [0.0, *values]
        self.knots = knots
        curve = scipy.interpolate.PchipInterpolator(knots, values)
        self.pieces, self.work = curve.c.T.tolist(), curve.antiderivative()

    def at(self, d: float) -> Value:
        if d <= 0.0:
            return 0.0, 0.0, 0.0
        i = min(bisect.bisect_right(self.knots, d) - 1, len(self.pieces) - 1)
        a, b, c, e = self.pieces[i]
        x = min(d, self.knots[-1]) - self.knots[i]
        slope = (3.0 * a * x + 2.0 * b) * x + c
        past = max(d - self.knots[-1], 0.0)
        return ((a * x + b) * x + c) * x + e + slope * past, slope, 0.0

    def taken(self, d: float) -> float:
        return float(self.work(d))


@dataclass
class Patched(Formula):
    """F = k D^1.5 with D = d + c F: Hertz's law without what a patch shows.

    Beyond where it holds, it goes on straight.
    """

    k: float = 0.0
    compliance: float = 0.0
    deepest: float = 0.0

    @property
    def _reach(self) -> float:
        return self.deepest - self.compliance * self.k * self.deepest**1.5

    def _own(self, d: float) -> float:
        """The law's own indentation at d > 0: d = D - c k D^1.5, by Newton's method from below."""
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


def formula(law: Law) -> Formula:
    """Return the law as the oracle takes it; new for every contact, since some remember."""
    of: dict[str, Any] = law.arguments
    if law.kind == "Hertz" and law.removed is not None:
        # A little beyond the limit it is still the law: a peak there is found as it is.
        return Patched(k=of["k"], compliance=law.removed, deepest=1.05 * law.deepest)
    if law.kind == "Hertz":
        return Power(k=of["k"])
    if law.kind == "Linear":
        return Power(k=of["k"], n=1.0)
    if law.kind == "PowerLaw":
        return Power(k=of["k"], n=of["n"])
    if law.kind == "UserLaw":
        return Power(viscous=of["c"] > 0.0, k=of["k"], n=of["n"], chi=of["c"])
    if law.kind == "HuntCrossley":
        return Power(viscous=of["damping"] > 0.0, k=of["k"], n=of["n"], chi=of["damping"])
    if law.kind == "Tsuji":
        g = of["alpha"] * math.sqrt(of["mass"] * of["k"])
        return Tsuji(viscous=g > 0.0, k=of["k"], g=g)
    if law.kind == "KuwabaraKono":
        return Kuwabara(viscous=of["A"] > 0.0, k=of["k"], lag=of["A"])
    if law.kind == "KelvinVoigt":
        pulls = of["end"] == "indentation"
        return Kelvin(viscous=of["c"] > 0.0, pulls=pulls, k=of["k"], c=of["c"])
    if law.kind == "Thornton":
        return Thornton(remembers=True, k=of["k"], yield_force=of["yield_force"])
    assert law.kind == "Tabulated"
    return Table(of["indentation"], of["force"])
