"""Several contacts on one contact point without mass, against SciPy's integrators.

The point's place follows from the forces on it. Without dashpots they balance at a root of one
equation; where a dashpot acts, at a velocity that is a root of one.
"""

import math
from dataclasses import dataclass

import aoimpact as ao

MASS, K = 1.0, 1e8  # of the oscillator behind the point
GAP, END = 1e-4, 6e-4
RTOL = 1e-8


@dataclass(frozen=True)
class Push:
    """A ball of 1 kg at 1 m/s, from a gap on; its force is k dⁿ + c d^p d', cut at zero."""

    law: ao.ContactLaw
    k: float
    n: float = 1.0
    c: float = 0.0
    p: float = 0.0
    gap: float = 0.0

    def force(self, d: float, rate: float) -> float:
        if d < 0.0:
            return 0.0
        return max(self.k * d**self.n + self.c * d**self.p * rate, 0.0)


def hertz(k: float, gap: float = 0.0) -> Push:
    return Push(ao.Hertz(k), k, 1.5, gap=gap)


def linear(k: float, gap: float = 0.0) -> Push:
    return Push(ao.Linear(k), k, gap=gap)


def kelvin_voigt(k: float, c: float, gap: float = 0.0) -> Push:
    return Push(ao.KelvinVoigt(k, c), k, c=c, gap=gap)


def tsuji(k: float, alpha: float, gap: float = 0.0) -> Push:
    return Push(ao.Tsuji(k, alpha, mass=MASS), k, 1.5, alpha * math.sqrt(MASS * k), 0.25, gap)


CASES = {
    "Hertz, Hertz": (hertz(1e10), hertz(1e10, GAP)),
    "Hertz, Kelvin-Voigt": (hertz(1e10), kelvin_voigt(1e8, 1e3, GAP)),
    "Kelvin-Voigt, Hertz": (kelvin_voigt(1e8, 1e3), hertz(1e10, GAP)),
    "Kelvin-Voigt, Kelvin-Voigt": (kelvin_voigt(1e8, 1e3), kelvin_voigt(5e7, 3e3, GAP)),
    "Tsuji, linear": (tsuji(1e10, 0.3), linear(1e8, GAP)),
    "linear, Tsuji": (linear(1e8), tsuji(1e10, 0.3, GAP)),
}
