"""Filter of a measuring channel, and filtered accelerations.

SAE J211-1, appendix C: a Butterworth filter of two poles, run forward and backward for zero phase
shift. The acceleration after an impact has no finite bandwidth: it grows with the number of modes
of a model. The filtered acceleration converges as other histories do.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np

from ..base import ArrayPair, FloatArray, InputError, checked, positive, warn, with_unit

# Ratio of the pole, the corner frequency of a single pass, to the frequency of the class (SAE
# J211-1, appendix C). Both passes together attenuate by 3 dB at 1.65 times the class's frequency.
_POLE = 2.0775

# Ratio of the pole to the frequency at which two passes of a Butterworth filter of order 2
# attenuate by 3 dB.
_POLE_OF_CORNER = math.pow(math.sqrt(2.0) - 1.0, -0.25)

# Fraction of a transient at either end that remains after the settling time.
_SETTLED = 1e-4

# Number of samples per period of the pole, and minimum number in a record. For a plate whose
# unfiltered acceleration is 40 times that filtered by CFC 1000, the filtered acceleration has an
# error of 1.5e-3 with 200 samples per period, and of 5e-5 with 1000.
_SAMPLES = 1000

# Largest number of samples of a record; a record that needs more is most likely a mistake.
MOST_SAMPLES = 20_000_000


@dataclass(frozen=True, kw_only=True)
class Channel:
    """A zero-phase low-pass filter: a channel frequency class of SAE J211, or a corner frequency.

    Parameters
    ----------
    cfc : float, optional
        Channel frequency class, Hz: 60, 180, 600 or 1000 in the standard; any other by the same
        formula.
    corner : float, optional
        In place of the class, the frequency at which the filter attenuates by 3 dB, Hz.

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
                f"give either cfc or corner, such as cfc=1000, got cfc={self.cfc!r} and "
                f"corner={self.corner!r}"
            )
        given = "cfc" if self.corner is None else "corner"
        checked(self, **{given: partial(positive, unit="Hz")})

    def __str__(self) -> str:
        return f"cfc={self.cfc:g}" if self.cfc else f"corner={self.corner:g}"

    @property
    def pole(self) -> float:
        """Corner frequency of a single pass, Hz."""
        return _POLE * (self.cfc or 0.0) + _POLE_OF_CORNER * (self.corner or 0.0)  # one is None

    @property
    def passed(self) -> float:
        """Frequency at which two passes attenuate by 3 dB, Hz."""
        return self.pole / _POLE_OF_CORNER

    @property
    def frequency_class(self) -> float:
        """Channel frequency class, Hz, also if a corner was given."""
        return self.pole / _POLE

    @property
    def settling_time(self) -> float:
        """Time in which a transient at either end decays to 1e-4, s: 2.07 periods of the pole.

        The poles of a Butterworth filter of order 2 decay as exp(-ω t/√2).
        """
        return math.sqrt(2.0) * math.log(1.0 / _SETTLED) / (2.0 * math.pi * self.pole)


def zero_phase(values: FloatArray, channel: Channel, rate: float) -> FloatArray:
    """Return evenly sampled values, filtered by a channel, in the shape (n, ...) of `values`.

    Both ends are extended by the settling time, by odd reflection about the end sample, as in
    SciPy's `filtfilt`.

    Parameters
    ----------
    values : ndarray, shape (n, ...)
    channel : Channel
    rate : float
        Sampling rate, Hz.

    Raises
    ------
    InputError
        If the record is shorter than the settling time.
    """
    from scipy.signal import butter, filtfilt  # slow to import

    last = len(values) - 1
    _check_long_enough(channel, last / rate)
    poles, length = butter(2, channel.pole, fs=rate), math.ceil(channel.settling_time * rate)
    return np.asarray(filtfilt(*poles, values, axis=0, padlen=min(length, last)))


def _check_long_enough(channel: Channel, duration: float) -> None:
    if duration < channel.settling_time:
        raise InputError(
            f"{channel}: the record of {with_unit(duration, 's')} is shorter than the settling "
            f"time, {with_unit(channel.settling_time, 's')}; take a longer one or a higher class"
        )


def filtered_acceleration(
    motion: Callable[[FloatArray], ArrayPair],
    duration: float,
    channel: Channel,
    times: FloatArray,
) -> FloatArray:
    """Return the acceleration of a motion, filtered by a channel, m/s², shape (times, ...).

    The input of the filter is second differences of the displacement: means of the acceleration
    with triangular weights, so that there is little aliasing. Before the record the velocity is
    constant. The motion after the record is not known, and the filter also runs backward, so that
    the acceleration is NaN within the settling time of the end.

    Parameters
    ----------
    motion : callable
        Function of times within the record, s, that returns displacement, m, and velocity, m/s, of
        shape (times, ...).
    duration : float
        Length of the record, s.
    channel : Channel
    times : ndarray, shape (times,)
        Times, s.

    Raises
    ------
    InputError
        If the record is shorter than the settling time.

    Warns
    -----
    AOImpactWarning
        If the acceleration is known for less than the settling time.
    """
    _check_long_enough(channel, duration)
    if duration < 2.0 * channel.settling_time:
        warn(
            f"{channel}: only {with_unit(duration - channel.settling_time, 's', 2)} are known; "
            f"take a duration of {with_unit(3.0 * channel.settling_time, 's', 2)} or more"
        )
    if duration * channel.pole * _SAMPLES > MOST_SAMPLES:
        raise InputError(
            f"{channel} takes more than {MOST_SAMPLES} samples of a record of "
            f"{with_unit(duration, 's')}"
        )
    from scipy.interpolate import CubicSpline  # slow to import

    count = math.ceil(_SAMPLES * max(channel.pole * duration, 1.0))
    step = duration / count
    moved, speeds = motion(np.linspace(0.0, duration, count + 1))
    steady = moved[:1] - step * speeds[:1]
    accelerations = np.diff(np.concatenate([steady, moved]), 2, axis=0) / step**2
    before = math.ceil(channel.settling_time / step)
    still = np.zeros((before, *accelerations.shape[1:]))
    smooth = zero_phase(np.concatenate([still, accelerations, still]), channel, 1.0 / step)
    found: FloatArray = CubicSpline((np.arange(len(smooth)) - before) * step, smooth)(times)
    found[times > duration - channel.settling_time] = np.nan
    return found
