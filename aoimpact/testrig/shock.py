"""The shock response spectrum: largest responses of oscillators of all frequencies to a shock."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from ..base import (
    FloatArray,
    Frozen,
    InputError,
    choice,
    error_axes,
    finite_array,
    given_axes,
    label,
    nonnegative,
    warn,
)
from ..results import Result
from .signal import Signal

if TYPE_CHECKING:
    from matplotlib.axes import Axes


# Default frequencies. _PER_OCTAVE: number per octave. _SHARE: product of the lowest frequency and
# the signal's duration, and ratio of the highest frequency to the sampling rate.
_PER_OCTAVE, _SHARE = 12, 0.1

# Number of points per period of an oscillator: the largest response at these points is too low by
# 0.3 % at most.
_PER_PERIOD = 40

_KINDS = {
    "absolute acceleration": "m/s²",
    "relative displacement": "m",
    "pseudo-velocity": "m/s",
}


@dataclass(frozen=True, eq=False, repr=False)
class ShockSpectrum(Frozen):
    """The largest responses of oscillators to a shock as a function of their frequencies.

    Attributes
    ----------
    frequencies : ndarray, shape (n,)
        Undamped natural frequencies, Hz.
    positive, negative : ndarrays, shape (n,)
        Largest response in the positive and in the negative direction, as a number ≥ 0.
    primary, residual : ndarrays, shape (n,)
        Largest magnitude of the response during the signal, and after the signal.
    kind, unit : str
        Kind of response, as in `shock_spectrum`, and its unit.
    damping_ratio : float
        Damping ratio of all oscillators.

    Examples
    --------
    >>> tup, plate = ao.rigid(mass=5.0), ao.AOModel(m0=0.1, k0=5e6, m=[0.2], k=[4e7])
    >>> hit = ao.simulate(projectile=tup, target=plate, law=ao.Hertz(k=1e9), velocity=2.0)
    >>> spectrum = shock_spectrum(hit, frequencies=[100.0, 1000.0])
    >>> spectrum.frequencies
    array([ 100., 1000.])
    """

    frequencies: FloatArray
    positive: FloatArray
    negative: FloatArray
    primary: FloatArray
    residual: FloatArray
    kind: str
    unit: str
    damping_ratio: float

    @property
    def maximax(self) -> FloatArray:
        """The largest magnitude of the response at any time, shape (n,)."""
        return np.maximum(self.primary, self.residual)

    def plot(self, ax: Axes | None = None, *, parts: bool = False, **kwargs: Any) -> Axes:
        """Draw the spectrum against the frequency, both logarithmic; keywords go to ``Axes.plot``.

        Parameters
        ----------
        ax : Axes, optional
        parts : bool, optional
            Draw the primary and the residual spectrum as well.

        Returns
        -------
        Axes

        Examples
        --------
        >>> time = np.linspace(0.0, 1e-3, 101)
        >>> signal = Signal(time, np.sin(2e3 * np.pi * time))
        >>> ax = shock_spectrum(signal, np.geomspace(100, 5e3, 9)).plot(parts=True)
        """
        style: dict[str, Any] = {"label": f"maximax, {100.0 * self.damping_ratio:.3g} % damping"}
        if parts:
            style |= {"color": "0.8", "lw": 5.0, "linestyle": "-"}
        ax = given_axes(ax)
        ax.plot(self.frequencies, self.maximax, **style | kwargs)
        for name in ("primary", "residual") if parts else ():
            ax.plot(self.frequencies, getattr(self, name), label=name, lw=1.2)
        return error_axes(ax, "natural frequency (Hz)", label(self.kind, self.unit))

    def __repr__(self) -> str:
        low, high = self.frequencies[[0, -1]]
        top = int(np.argmax(self.maximax))
        return (
            f"ShockSpectrum({self.kind}, {len(self.frequencies)} frequencies from {low:.4g} to "
            f"{high:.4g} Hz, largest {self.maximax[top]:.4g} {self.unit} at "
            f"{self.frequencies[top]:.4g} Hz)"
        )


def shock_spectrum(
    source: Any,
    frequencies: npt.ArrayLike | None = None,
    *,
    damping_ratio: float = 0.05,
    kind: str = "absolute acceleration",
) -> ShockSpectrum:
    """Return the shock response spectrum of an acceleration, ISO 18431-4.

    Oscillators of one degree of freedom, at rest before the signal, stand on a base with the
    signal's acceleration. Their response is exact for straight lines between the samples
    (ramp-invariant filters), and in closed form for the free vibration after the last sample.

    Parameters
    ----------
    source : Signal, (t, values), Probe or Result
        Acceleration of the base, m/s². A probe of a body along a direction gives that of its point;
        a result gives that of the projectile, the ratio of its contact force to its mass, positive
        in the direction in which it is decelerated.
    frequencies : array_like, shape (n,), optional
        Undamped natural frequencies of the oscillators, Hz, up to half of the sampling rate; by
        default twelve per octave, from 0.1 / (the signal's length) to a tenth of its sampling rate.
    damping_ratio : float, optional
        Damping ratio ζ, below 1; 0.05 is Q = 10.
    kind : {"absolute acceleration", "relative displacement", "pseudo-velocity"}, optional
        Pseudo-velocity is relative displacement times angular frequency.

    Returns
    -------
    ShockSpectrum

    Raises
    ------
    InputError
        If the samples are not evenly spaced, or a frequency is above half of their rate.

    Warns
    -----
    AOImpactWarning
        If a frequency is above a tenth of the rate: straight lines between samples then lack part
        of the excitation, 3 % at a tenth and 9 % at a sixth.

    Examples
    --------
    A half sine of 500 m/s² and 10 ms, without damping, is amplified 1.77 times at most:

    >>> import numpy as np
    >>> t = np.arange(1001) / 100e3
    >>> shock = Signal(t, 500.0 * np.sin(np.pi * t / 0.01), unit="m/s²", name="acceleration")
    >>> spectrum = shock_spectrum(shock, damping_ratio=0.0)
    >>> f"{spectrum.maximax.max() / 500.0:.2f}"
    '1.77'
    """
    damping = nonnegative("damping_ratio", damping_ratio)
    if damping >= 1.0:
        raise InputError(f"damping_ratio must be below 1, got {damping:g}; 0.05 is Q = 10")
    named = choice("kind", kind, tuple(_KINDS))
    signal = Signal.of(source)
    if isinstance(source, Result):
        mass = source.projectile.mass
        if mass is None or not math.isfinite(mass):
            raise InputError(
                "source: the projectile's mass is not known; give a probe of one of its points, or "
                "(t, values)"
            )
        signal = Signal(signal.t, signal.values / mass, unit="m/s²", name="acceleration")
    rate = signal.rate
    if frequencies is None:
        low, high = _SHARE / float(signal.t[-1] - signal.t[0]), _SHARE * rate
        octaves = max(math.log2(high / low), 1.0)
        frequencies = np.geomspace(low, high, 1 + math.ceil(_PER_OCTAVE * octaves))
    wanted = np.atleast_1d(finite_array("frequencies", frequencies, unit="Hz"))
    top = float(wanted.max(initial=0.0))
    if wanted.ndim != 1 or not (wanted > 0.0).all() or not 0.0 < top <= 0.5 * rate:
        raise InputError(
            "frequencies must be a list of positive numbers, none above half of the rate "
            f"{rate:g} Hz, got {frequencies!r}"
        )
    if top > _SHARE * rate * (1.0 + 1e-9):
        lost = 1.0 - float(np.sinc(top / rate)) ** 2
        warn(
            f"frequencies exceed a tenth of the rate {rate:g} Hz: at {top:g} Hz the result may be "
            f"{100.0 * lost:.0f} % too low; sample faster"
        )
    unit = _KINDS[named]
    rows = [_largest(signal, f, damping, unit) for f in wanted.tolist()]
    above, below, primary, residual = np.transpose(rows)
    return ShockSpectrum(wanted, above, below, primary, residual, named, unit, damping)


def _largest(signal: Signal, frequency: float, damping: float, unit: str) -> tuple[float, ...]:
    """Return the largest positive and negative response, and magnitudes during and after `signal`.

    The oscillator z'' + 2ζω z' + ω² z = -u is solved exactly by means of its eigenvalue λ and the
    residue r of its transfer function: q' = λq + u, z = 2 Re(r q). For the absolute acceleration
    z'' + u, λ² r replaces r; for the pseudo-velocity, ω r. The signal u is linear between samples,
    and interpolated to smaller steps.
    """
    from scipy.signal import cont2discrete, lfilter  # slow to import

    omega = 2.0 * math.pi * frequency
    root = complex(-damping, math.sqrt(1.0 - damping * damping))  # eigenvalue λ in units of ω
    factor = {"m/s²": omega * root**2, "m": 1.0 / omega, "m/s": 1.0}[unit]
    share = 0.5j / root.imag * factor
    parts = max(1, math.ceil(_PER_PERIOD * frequency / signal.rate))
    values = np.pad(signal.values, 1)
    samples = np.arange(parts * (len(values) - 1) + 1) / parts
    forced = np.interp(samples, np.arange(len(values)), values)
    one, step = np.ones((1, 1)), 1.0 / (parts * signal.rate)
    system = omega * root * one, one, one, 0.0 * one
    a, b, c, d = (of.item() for of in cont2discrete(system, step, "foh")[:4])
    states = lfilter([d, b * c - d * a], [1.0, -a], forced)
    response = 2.0 * np.real(share * states[parts : len(states) - parts])
    last = share * states[-1]  # later, the response is largest at its end or where its rate is 0
    phase = np.append(0.0, (0.5 * math.pi - np.angle(last * root)) % math.pi + [0.0, math.pi])
    later = 2.0 * np.real(last * np.exp(root / root.imag * phase))
    either = np.concatenate([[0.0], response, later])
    return either.max(), -either.min(), np.abs(response).max(), np.abs(later).max()
