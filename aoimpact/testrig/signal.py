"""A signal over time, measured or simulated, and the filter of its channel frequency class."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from ..base import (
    HUGE,
    FloatArray,
    Frozen,
    InputError,
    checked,
    draw_curves,
    finite_array,
    instance,
    integer,
    nonnegative,
    positive,
    text,
    with_unit,
)
from ..fields import Channel, Probe, zero_phase
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

# Samples in a period of the class's frequency: of SAE J211-1, and above which two poles at 1 are
# all rounding.
_SAMPLES_OF_CLASS = 10.0, 1e6

# A measured contact begins where the force was last below the first share of its peak before it
# passes the second, and ends where it is below the first again. Noise of the channel, usually 0.4 %
# of the peak rms, passes the first now and then, but not the second.
BEGINS, RISEN = 0.01, 0.1

# Line of a signal before it was filtered.
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
        times = finite_array("t", self.t, shape=(None,), unit="s", most=HUGE)
        values = finite_array("values", self.values, shape=times.shape, unit=self.unit, most=HUGE)
        still = np.flatnonzero(np.diff(times) <= 0.0)
        if len(times) < 2 or len(still):
            first = still[0] if len(still) else 0
            raise InputError(f"t must be two times or more that rise, got {times[first:][:2]} s")
        object.__setattr__(self, "t", times.copy())
        object.__setattr__(self, "values", values.copy())
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
        if isinstance(source, tuple) and len(source) == 2:
            source = cls(*source)
        instance("source", source, Signal, tuple, Run, Probe)
        if isinstance(source, Signal):
            return source if wanted is None else source.resampled(wanted)
        if isinstance(source, Run):
            number = integer("contact", contact, low=0, high=len(source.events) - 1)
            events, end = source.events[number], source.duration
            if space > 0.0 and events.last_until(end):
                raise InputError("margin: the record ends in contact; simulate it for longer")
            if wanted is None and source.recorder.dense:
                touch, parting = events.peak_contact or (0.0, end)
                wanted = _PER_CONTACT / ((parting - touch) or end)
            elif wanted is None:
                wanted = (len(source.t) - 1) / float(source.t[-1])
            _steps(end + 2.0 * space, wanted)
            times = np.minimum(np.arange(_steps(end, wanted) + 1) / wanted, end)
            before = round(space * wanted)
            force = np.pad(force_at(source, number, times), before)
            return cls((np.arange(len(force)) - before) / wanted, force)
        if isinstance(source, tuple) or source.velocity.ndim != 1:
            raise InputError(
                "source must be a pair (t, values) or a motion along one direction: "
                "probe(..., direction=...)"
            )
        values = np.gradient(source.velocity, source.t)
        return cls(source.t, values, unit="m/s²", name="acceleration")

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
        steps = np.arange(_steps(float(self.t[-1] - self.t[0]), wanted) + 1)
        times = np.minimum(self.t[0] + steps / wanted, self.t[-1])
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
        least, most = (samples * channel.frequency_class for samples in _SAMPLES_OF_CLASS)
        if not least * (1.0 - 1e-9) <= self.rate <= most:
            raise InputError(
                f"{channel} needs {with_unit(least, 'Hz')} of samples or more (SAE J211), and at "
                f"most {with_unit(most, 'Hz')}; it has {with_unit(self.rate, 'Hz')}"
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
        curves = [] if self.raw is None else [(self.raw.values, UNFILTERED)]
        curves.append((self.values, kwargs))
        return draw_curves(ax, (self.t, "time", "s"), self.name, self.unit, curves)


def force_at(run: Run, contact: int, times: FloatArray) -> FloatArray:
    """Force of a contact at times within the record, N; straight between fixed steps."""
    if run.recorder.dense:
        return np.asarray(run.at(times).forces[contact])
    return np.asarray(np.interp(times, run.t, run.forces[contact]))


def contacts(force: Signal, name: str) -> list[tuple[int, int]]:
    """First and last sample of each contact in a measured force.

    name: of the force, for the message where it is never positive.
    """
    from scipy.ndimage import find_objects, label  # slow to import

    if force.values.max() <= 0.0:
        raise InputError(f"{name} is never positive: change its sign")
    share = force.values / force.values.max()
    pressed = [of for (of,) in find_objects(label(share > BEGINS)[0]) if share[of].max() > RISEN]
    return [(max(of.start - 1, 0), min(of.stop, len(share) - 1)) for of in pressed]


def _steps(length: float, rate: float) -> int:
    """Return the number of whole steps in a length of time, s."""
    count = length * rate * (1.0 + 1e-12)
    if not 1.0 <= count <= _MOST:
        raise InputError(
            f"rate = {with_unit(rate, 'Hz')} over {with_unit(length, 's')}, with any margin, makes "
            f"{count:.3g} samples: it must be from 2 to {_MOST}"
        )
    return int(count)
