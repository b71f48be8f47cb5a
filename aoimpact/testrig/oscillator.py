"""An oscillator on a base that moves, exactly for what is straight between samples.

ISO 18431-4 calls its filters ramp-invariant: the base's acceleration u runs straight from sample to
sample, and the oscillator z'' + 2ζω z' + ω² z = -u is solved exactly. Here that is done for its
complex eigenvalue λ, q' = λq + u, from which every response is 2 Re(r q). The filters of the
standard are the same formulas multiplied out; these lose no digits where ω is far below the rate.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..base import FloatArray

ComplexArray = NDArray[np.complex128]

# Below this |z| the series of (e^z - 1 - z)/z² to this order is exact to rounding.
_SMALL, _TERMS = 0.5, 14


@dataclass(frozen=True)
class Oscillator:
    """A mass on a spring and a dashpot, whose base is moved.

    Attributes
    ----------
    omega : float
        Undamped angular frequency, rad/s.
    damping_ratio : float
        ζ, below 1.
    """

    omega: float
    damping_ratio: float

    @property
    def eigenvalue(self) -> complex:
        """λ, 1/s, that of positive frequency."""
        zeta = self.damping_ratio
        return self.omega * complex(-zeta, math.sqrt(1.0 - zeta * zeta))

    @property
    def acceleration_share(self) -> complex:
        """r of the absolute acceleration, and of the force between mass and base over its mass."""
        lam = self.eigenvalue
        rate = 2.0 * self.damping_ratio * self.omega
        return (rate * lam + self.omega**2) / (2j * lam.imag)

    @property
    def displacement_share(self) -> complex:
        """r of the displacement of the mass relative to its base."""
        return -1.0 / (2j * self.eigenvalue.imag)

    def states(self, values: FloatArray, step: float, parts: int = 1) -> ComplexArray:
        """Return q, from rest, shape (parts, n): at the samples, and between them and the next.

        Parameters
        ----------
        values : ndarray, shape (n,)
            u at even steps; straight between them, and 0 before the first.
        step : float
            s.
        parts : int, optional
            Into how many parts each step is divided: row j is at (i + j/parts) steps, and holds at
            its last place, beyond the signal, what follows if u is 0 from one step later on.
        """
        from scipy.signal import lfilter  # slow to import

        z = self.eigenvalue * step
        first, second = _ramp(z)
        after = np.append(values, 0.0)
        start = step * second * values[0]  # a ramp up to the first value
        forced = step * (first * values[:-1] + second * values[1:])
        at = lfilter([1.0], [1.0, -np.exp(z)], np.concatenate([[start], forced]))
        rows = [at]
        for j in range(1, parts):
            share = j / parts
            first, second = _ramp(share * z)
            bent = share * step * ((first + (1.0 - share) * second) * after[:-1])
            bent = bent + share * step * share * second * after[1:]
            rows.append(np.exp(share * z) * at + bent)
        found: ComplexArray = np.array(rows)
        return found

    def free_extremes(self, state: complex, share: complex) -> tuple[float, float]:
        """Return the largest and the least of 2 Re(r q) in free motion from a state on."""
        lam = self.eigenvalue
        # Its derivative 2 Re(r λ q e^{λτ}) vanishes where the phase is a right angle.
        phase = math.pi / 2.0 - np.angle(share * lam * state)
        first = float(phase % math.pi) / lam.imag
        times = np.array([0.0, first, first + math.pi / lam.imag])
        values = 2.0 * np.real(share * state * np.exp(lam * times))
        return float(values.max()), float(values.min())


def _ramp(z: complex) -> tuple[complex, complex]:
    """Weights of u at the begin and the end of a step: φ1 - φ2 and φ2 of λ times the step."""
    if abs(z) < _SMALL:
        terms = [1.0 / math.factorial(k) for k in range(_TERMS + 3)]
        one = sum(terms[k + 1] * z**k for k in range(_TERMS))
        two = sum(terms[k + 2] * z**k for k in range(_TERMS))
    else:
        one = (np.exp(z) - 1.0) / z
        two = (one - 1.0) / z
    return complex(one - two), complex(two)
