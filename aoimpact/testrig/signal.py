"""A signal over time, measured or simulated, and the filter of its channel frequency class."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from ..base import (
    HUGE,
    Curve,
    FloatArray,
    Frozen,
    InputError,
    InputTypeError,
    checked,
    draw_curves,
    finite_array,
    integer,
    nonnegative,
    positive,
    text,
    with_unit,
)
from ..fields import Channel, Probe, zero_phase
from ..integrate import Events
from ..results import Run

if TYPE_CHECKING:
    from matplotlib.axes import Axes


STANDARD_GRAVITY = 9.80665  # m/s², ISO 80000-3

# Samples are evenly spaced if each is within this share of a step of where it should be.
UNEVEN = 0.05

# Samples of a simulated force: in its hardest contact.
_PER_CONTACT = 500

# Samples beyond which a record is taken for a mistake.
_MOST = 20_000_000

# SAE J211-1: samples in a period of the class's frequency, at least.
_SAMPLES_OF_CLASS = 10

# The class's frequency over the rate, below which two poles at 1 are all rounding.
_SLOWEST = 1e-6

# A measured contact begins where the force was last below the first share of its peak before it
# passes the second, and ends where it is below the first again. Noise of the channel, usually 0.4 %
# of the peak rms, passes the first now and then, but not the second.
BEGINS, RISEN = 0.01, 0.1

# Style of a signal behind its filtered self.
UNFILTERED = {"color": "0.7", "linestyle": "-", "lw": 0.8, "label": "unfiltered"}


@dataclass(frozen=True, eq=False, repr=False)
class Signal(Frozen):
    """A quantity over time, as a channel of a test rig delivers it.

    Parameters
    ----------
    t : array_like, shape (n,)
        Times, s, rising; at least two.
    values : array_like, shape (n,)
        In SI units.
    unit : str, optional
        Unit of the values: "N", "m/s²", ….
    name : str, optional
        Name on axes and in messages.
    raw : Signal, optional
        The signal before it was filtered; set by `filtered`.

    Raises
    ------
    InputError
        If times do not rise, or there are not as many values.

    Examples
    --------
    >>> import numpy as np
    >>> t = np.linspace(0.0, 0.02, 2001)
    >>> force = Signal(t, 1000.0 * np.sin(np.pi * t / 0.02))
    >>> force
    Signal(force, 2001 samples at 100 kHz, largest 1000 N)
    >>> smooth = force.filtered(1000)
    >>> smooth.raw is force
    True
    """

    t: FloatArray
    values: FloatArray
    unit: str = "N"
    name: str = "force"
    raw: Signal | None = None

    def __post_init__(self) -> None:
        checked(self, unit=text, name=text, raw=(Signal, type(None)))
        times = finite_array("t", self.t, ndim=1, unit="s", most=HUGE).copy()
        values = finite_array("values", self.values, ndim=1, unit=self.unit, most=HUGE).copy()
        if len(times) < 2 or len(values) != len(times):
            raise InputError(
                "t and values must have the same length, two samples at least, got "
                f"{len(times)} times and {len(values)} values"
            )
        still = np.flatnonzero(np.diff(times) <= 0.0)
        if len(still):
            i = int(still[0])
            raise InputError(
                f"t must rise, but t[{i}] = {times[i]:g} s and t[{i + 1}] = {times[i + 1]:g} s"
            )
        object.__setattr__(self, "t", times)
        object.__setattr__(self, "values", values)
        super().__post_init__()

    def __repr__(self) -> str:
        top = with_unit(float(np.abs(self.values).max()), self.unit)
        spaced = f"at {with_unit(self.mean_rate, 'Hz')}" if self.even else "not evenly spaced"
        return f"Signal({self.name}, {len(self.t)} samples {spaced}, largest {top})"

    @classmethod
    def of(
        cls,
        source: Any,
        *,
        contact: int = 0,
        rate: float | None = None,
        margin: float = 0.0,
    ) -> Signal:
        """Return the signal of a measurement, or of a simulated impact.

        Parameters
        ----------
        source : Signal, (t, values), Result, Run or Probe
            A result gives its contact force; a probe along a direction the acceleration of its
            point, from differences of its velocity: give it times close enough.
        contact : int, optional
            Which contact of a scene's run, in the order of `Scene.connect`.
        rate : float, optional
            Samples a second, Hz, of a result; by itself 500 in the hardest contact, and those of a
            solver of fixed steps, between which lines are straight.
        margin : float, optional
            Length of zero force before and after the record of a result, s: room for a filter.

        Raises
        ------
        InputError
            If an impact lasts beyond its record, or would have more than 20 million samples.

        Examples
        --------
        >>> import aoimpact as ao
        >>> ball = ao.rigid(mass=0.0327)
        >>> hit = ao.simulate(projectile=ball, target=ball, law=ao.Hertz(k=1e10), velocity=1.0)
        >>> Signal.of(hit, rate=1e6)
        Signal(force, 125 samples at 1 MHz, largest 968.8 N)
        """
        space = nonnegative("margin", margin, unit="s")
        wanted = None if rate is None else positive("rate", rate, unit="Hz")
        if isinstance(source, Signal):
            return source if wanted is None else source.resampled(wanted)
        if isinstance(source, Run):
            return _contact_force(source, contact, wanted, space)
        if isinstance(source, Probe):
            return _acceleration(source)
        if isinstance(source, tuple) and len(source) == 2:
            return cls.of(cls(*source), rate=rate)
        raise InputTypeError(
            "source must be a Signal, a pair (t, values), a Result, a Run or a probe, got "
            f"{type(source).__name__}"
        )

    # ------------------------------------------------------------------- its samples

    @property
    def mean_rate(self) -> float:
        """Samples a second on the average, Hz."""
        return float((len(self.t) - 1) / (self.t[-1] - self.t[0]))

    @property
    def even(self) -> bool:
        """True if the samples are evenly spaced, to a twentieth of a step."""
        grid = np.linspace(self.t[0], self.t[-1], len(self.t))
        return bool((np.abs(self.t - grid) * self.mean_rate <= UNEVEN).all())

    @property
    def rate(self) -> float:
        """Samples a second, Hz.

        Raises
        ------
        InputError
            If they are not evenly spaced.
        """
        if not self.even:
            steps = np.diff(self.t)
            raise InputError(
                f"samples of {self.name!r} are not evenly spaced, {with_unit(steps.min(), 's')} to "
                f"{with_unit(steps.max(), 's')} apart; take signal.resampled(rate) first"
            )
        return self.mean_rate

    def resampled(self, rate: float) -> Signal:
        """Return the signal at even steps, by straight lines between its samples.

        Parameters
        ----------
        rate : float
            Samples a second, Hz; not below the mean rate of the signal.

        Raises
        ------
        InputError
            If the rate is lower: what is faster than half of it would appear as something slow.

        Examples
        --------
        >>> time = np.linspace(0.0, 1e-3, 101)
        >>> signal = Signal(time, np.sin(2e3 * np.pi * time))
        >>> len(signal.resampled(200e3).t)
        201
        """
        wanted = positive("rate", rate, unit="Hz")
        if wanted < self.mean_rate * (1.0 - 1e-9):
            raise InputError(
                f"rate = {with_unit(wanted, 'Hz')} is below the {with_unit(self.mean_rate, 'Hz')} "
                "of the signal; filter it, and take every k-th sample"
            )
        times = _times(float(self.t[0]), float(self.t[-1]), wanted)
        return replace(self, t=times, values=np.interp(times, self.t, self.values))

    # ------------------------------------------------------------------- the filter

    def filtered(self, cfc: float | None = None, *, corner: float | None = None) -> Signal:
        """Return the signal by the filter of a channel frequency class; `raw` keeps this one.

        SAE J211-1, appendix C: a Butterworth filter of two poles, forward and backward, so that no
        phase is shifted. It is 3 dB down at 1.65 times the class's frequency. Beyond its ends the
        signal is continued odd about the end sample, as by SciPy's `filtfilt`; so the period of the
        class next to an end is right only if the signal is at rest or straight there.

        Parameters
        ----------
        cfc : float, optional
            The class, Hz: 60, 180, 600 or 1000 in the standard; any other by the same formula.
        corner : float, optional
            In place of the class, the frequency where the signal is 3 dB down, Hz.

        Raises
        ------
        InputError
            If neither or both are given, the samples are not evenly spaced, or fewer than ten in a
            period of the class, as the standard asks for, or the signal is shorter than the
            filter's settling time, the class's period.

        Examples
        --------
        >>> import numpy as np
        >>> t = np.arange(4000) / 100e3
        >>> ringing = Signal(t, np.sin(2 * np.pi * 50 * t) + np.sin(2 * np.pi * 20e3 * t))
        >>> bool(np.abs(ringing.filtered(1000).values).max() < 1.02)
        True
        """
        channel = Channel(cfc=cfc, corner=corner)
        needed = _SAMPLES_OF_CLASS * channel.frequency_class
        if self.rate < needed * (1.0 - 1e-9):
            raise InputError(
                f"{channel} needs {with_unit(needed, 'Hz')} of samples (SAE J211), it has "
                f"{with_unit(self.rate, 'Hz')}; take a lower frequency"
            )
        if channel.frequency_class < _SLOWEST * self.rate:
            raise InputError(
                f"{channel} is too low for {with_unit(self.rate, 'Hz')} of samples; take "
                "every k-th sample first"
            )
        smooth = zero_phase(self.values, channel, self.rate)
        return replace(self, values=smooth, raw=self)

    def plot(self, ax: Axes | None = None, **kwargs: Any) -> Axes:
        """Draw the signal over time, what it was before it was filtered in grey behind it.

        Keywords go to ``Axes.plot``. Returns the axes.

        Examples
        --------
        >>> time = np.linspace(0.0, 1e-3, 101)
        >>> signal = Signal(time, np.sin(2e3 * np.pi * time))
        >>> ax = signal.plot()
        """
        if self.raw is not None:
            grey: list[Curve] = [(self.raw.values, UNFILTERED)]
            ax = draw_curves(ax, (self.raw.t, "time", "s"), self.name, self.unit, grey)
        curves: list[Curve] = [(self.values, {})]
        return draw_curves(ax, (self.t, "time", "s"), self.name, self.unit, curves, kwargs)


def _contact_force(run: Run, contact: int, rate: float | None, margin: float) -> Signal:
    """Return a contact's force, evenly sampled, with zeros before and after the record."""
    number = integer("contact", contact, low=0, high=len(run.events) - 1)
    events = run.events[number]
    if margin > 0.0 and events.last_until(run.duration):
        raise InputError("margin: the record ends in contact; simulate it with a longer duration")
    if rate is None and run.recorder.dense:
        rate = _PER_CONTACT / _hardest(events, run.duration)
    elif rate is None:
        rate = Signal(run.t, run.forces[number]).mean_rate
    times = _times(0.0, run.duration, rate)
    force = force_at(run, number, times)
    if margin * rate > _MOST:
        raise InputError(
            f"margin = {with_unit(margin, 's')} is more than {_MOST} samples; take a shorter one"
        )
    before = round(margin * rate)
    zeros = np.zeros(before)
    all_times = (np.arange(len(times) + 2 * before) - before) / rate
    return Signal(all_times, np.concatenate([zeros, force, zeros]))


def force_at(run: Run, contact: int, times: FloatArray) -> FloatArray:
    """Force of a contact at times within the record, N; straight between fixed steps."""
    dense = run.recorder.dense
    force: FloatArray = (
        run.at(times).forces[contact] if dense else np.interp(times, run.t, run.forces[contact])
    )
    return force


def contacts(force: FloatArray) -> list[tuple[int, int]]:
    """First and last sample of each contact in a measured force that is positive somewhere."""
    share = force / force.max()
    telling = np.flatnonzero((share <= BEGINS) | (share > RISEN))
    acts = np.concatenate([[False], share[telling] > RISEN, [False]])
    at = np.concatenate([[0], telling, [len(force) - 1]])
    turns = np.flatnonzero(np.diff(acts))
    return list(zip(at[turns[::2]].tolist(), at[turns[1::2] + 1].tolist(), strict=True))


def _hardest(events: Events, duration: float) -> float:
    """Length of the contact in which the force is largest, s; of the record without one."""
    start, end = events.peak_contact or (0.0, duration)
    return end - start if end > start else duration


def _times(start: float, end: float, rate: float) -> FloatArray:
    count = (end - start) * rate * (1.0 + 1e-12)
    if not 1.0 <= count <= _MOST:
        raise InputError(
            f"rate = {with_unit(rate, 'Hz')} over {with_unit(end - start, 's')} makes {count:.3g} "
            f"samples: it must be from 2 to {_MOST}"
        )
    return np.minimum(start + np.arange(math.floor(count) + 1) / rate, end)


def _acceleration(probe: Probe) -> Signal:
    if probe.velocity.ndim != 1:
        raise InputError(
            "source must be one point's motion along one direction: probe(..., direction=...)"
        )
    values = np.gradient(probe.velocity, probe.t)
    return Signal(probe.t, values, unit="m/s²", name="acceleration")
