"""The filter of a measuring channel, and accelerations behind it.

SAE J211-1, appendix C: a Butterworth filter of two poles, forward and backward, so that no phase is
shifted. An acceleration after an impact has no finite bandwidth: the more modes a model has, the
larger it is at any moment. Behind a filter it converges as other histories do.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ..base import FloatArray, InputError, checked, positive, with_unit

__all__ = ["Channel", "filtered_rate", "zero_phase"]

# SAE J211-1, appendix C: each of two poles over the class's frequency. The two passes are together
# 3 dB down at 1.65 times the class.
_POLE = 2.0775

# Pole over the frequency of -3 dB of two passes of a Butterworth filter of order 2.
_POLE_OF_CORNER = math.pow(math.sqrt(2.0) - 1.0, -0.25)

# A record is continued by its mirror image through its end, as long as in ISO 6487: 10 ms, and 100
# samples at least.
_CONTINUED, _CONTINUED_SAMPLES = 0.01, 100

# Samples in a period of the pole: means over an interval are 0.07 % low there.
_SAMPLES, _LEAST_SAMPLES = 50, 100

# Samples beyond which a filter is taken for a mistake.
_MOST = 20_000_000

# Before the record: how many periods of the pole of steady motion the filter is given.
_BEFORE = 4


@dataclass(frozen=True, kw_only=True)
class Channel:
    """A zero-phase low-pass filter: a channel frequency class of SAE J211, or a corner frequency.

    Parameters
    ----------
    cfc : float, optional
        The class, Hz: 60, 180, 600 or 1000 in the standard; any other by the same formula.
    corner : float, optional
        In place of the class, the frequency where the signal is 3 dB down, Hz.

    Raises
    ------
    InputError
        If neither is given, or both are.
    """

    cfc: float | None = None
    corner: float | None = None

    def __post_init__(self) -> None:
        if (self.cfc is None) == (self.corner is None):
            raise InputError(
                f"give either cfc or corner, got cfc={self.cfc!r} and corner={self.corner!r}: an "
                "acceleration after an impact has no finite bandwidth, and converges only behind a "
                "filter such as cfc=1000"
            )
        if self.cfc is None:
            checked(self, corner=lambda name, value: positive(name, value, unit="Hz"))
        else:
            checked(self, cfc=lambda name, value: positive(name, value, unit="Hz"))

    def __str__(self) -> str:
        return f"cfc={self.cfc:g}" if self.corner is None else f"corner={self.corner:g}"

    @property
    def pole(self) -> float:
        """Corner frequency of a single pass, Hz."""
        if self.cfc is not None:
            return _POLE * self.cfc
        assert self.corner is not None
        return _POLE_OF_CORNER * self.corner


def zero_phase(
    values: FloatArray, channel: Channel, rate: float, *, mirror: str = "odd"
) -> FloatArray:
    """Return evenly sampled values behind a channel's filter, in the shape (n, ...) of `values`.

    Parameters
    ----------
    values : ndarray, shape (n, ...)
    channel : Channel
    rate : float
        Samples a second, Hz.
    mirror : {"odd", "even"}, optional
        How the record is continued: through its last sample, or as in a mirror.
    """
    from scipy.signal import butter, filtfilt  # slow to import

    ends = max(_CONTINUED_SAMPLES, math.ceil(_CONTINUED * rate))
    poles = butter(2, channel.pole, fs=rate)
    length = min(ends, len(values) - 1)
    found: FloatArray = filtfilt(*poles, values, axis=0, padtype=mirror, padlen=length)
    return found


def filtered_rate(
    history: Callable[[FloatArray], FloatArray],
    duration: float,
    channel: Channel,
    times: FloatArray,
) -> FloatArray:
    """Return the rate of a history behind a channel's filter, shape (times, ...).

    It is sampled by its means over short intervals, the differences of the history, so that nothing
    aliases. Before the record the history is constant; after it, its
    rate is mirrored.

    Parameters
    ----------
    history : callable
        Times, s, within the record, to values of shape (times, ...).
    duration : float
        Length of the record, s.
    channel : Channel
    times : ndarray, shape (times,)
        s.

    Raises
    ------
    InputError
        If the record is shorter than a period of the filter's pole.
    """
    if duration * channel.pole < 1.0:
        raise InputError(
            f"{channel}: the record of {with_unit(duration, 's')} is shorter than a period of the "
            f"filter, 1/({channel.pole:.4g} Hz); give a longer duration"
        )
    if duration * channel.pole * _SAMPLES > _MOST:
        raise InputError(
            f"{channel} takes more than {_MOST} samples of a record of {with_unit(duration, 's')}"
        )
    from scipy.interpolate import CubicSpline  # slow to import

    count = max(_LEAST_SAMPLES, math.ceil(_SAMPLES * channel.pole * duration))
    step = duration / count
    edges = np.linspace(0.0, duration, count + 1)
    rates = np.diff(history(edges), axis=0) / step
    before = math.ceil(_BEFORE / (channel.pole * step))
    still = np.zeros((before, *rates.shape[1:]))
    smooth = zero_phase(np.concatenate([still, rates]), channel, 1.0 / step, mirror="even")
    middles = (np.arange(len(smooth)) - before + 0.5) * step
    found: FloatArray = CubicSpline(middles, smooth)(times)
    return found
