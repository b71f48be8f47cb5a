"""Measured and simulated signals, their filters (channel frequency classes) and text files."""

from __future__ import annotations

import csv
import re
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from ..base import (
    HUGE,
    FilePath,
    FloatArray,
    Frozen,
    InputError,
    checked,
    choice,
    decoded,
    draw_curves,
    file_path,
    finite_array,
    instance,
    integer,
    nearest,
    nonnegative,
    positive,
    text,
    with_unit,
)
from ..fields import MOST_SAMPLES, Channel, Probe, zero_phase
from ..results import Run

if TYPE_CHECKING:
    from matplotlib.axes import Axes


STANDARD_GRAVITY = 9.80665  # m/s², ISO 80000-3

# Largest distance of a sample's time from an even grid, in steps, for samples to count as even.
UNEVEN = 0.05

# Default number of samples of a simulated force during the contact with the largest force.
_PER_CONTACT = 500

# Minimum (SAE J211-1) and maximum of the ratio of the sampling rate to the frequency class. Above
# the maximum, the poles of the digital filter differ from 1 only by rounding errors.
_SAMPLES_OF_CLASS = 10.0, 1e6

# Shares of the peak force. A measured contact begins where the force is last below BEGINS before it
# exceeds RISEN, and ends where the force is below BEGINS again. Channel noise, usually 0.4 % rms of
# the peak, sometimes exceeds BEGINS, but not RISEN.
BEGINS, RISEN = 0.01, 0.1

# Line style of an unfiltered signal in figures.
UNFILTERED = {"color": "0.7", "linestyle": "-", "lw": 0.8, "label": "unfiltered"}


@dataclass(frozen=True, eq=False, repr=False)
class Signal(Frozen):
    """A quantity over time, as a channel of a test rig delivers it.

    Parameters
    ----------
    t : array_like, shape (n,)
        Times, s, rising; at least two.
    values : array_like, shape (n,)
        Values in SI units.
    unit : str, optional
        Unit of the values: "N", "m/s²", ….
    name : str, optional
        Name on axes and in messages.
    raw : Signal, optional
        The signal before it was filtered; set by `filtered`.

    Raises
    ------
    InputError
        If the times do not rise, or if there are more or fewer values than times.

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
            A result gives its contact force. A probe along a direction gives the acceleration of
            its point from differences of the velocity, which needs closely spaced times.
        contact : int, optional
            Number of the contact in a scene's run, in the order of `Scene.connect`.
        rate : float, optional
            Sampling rate of a result, Hz. Default: 500 samples during the contact with the largest
            force; for a run with fixed steps, one sample per step.
        margin : float, optional
            Length of zero force to add before and after the record of a result, s, for a filter.

        Raises
        ------
        InputError
            If `margin` is given and the record ends in contact, or if there would be more than
            20 million samples.

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

    # ----------------------------------------------------------------------- samples

    @property
    def mean_rate(self) -> float:
        """Mean sampling rate, Hz."""
        return float((len(self.t) - 1) / (self.t[-1] - self.t[0]))

    @property
    def even(self) -> bool:
        """True if samples deviate from even spacing by at most a twentieth of a step."""
        grid = np.linspace(self.t[0], self.t[-1], len(self.t))
        return bool((np.abs(self.t - grid) * self.mean_rate <= UNEVEN).all())

    @property
    def rate(self) -> float:
        """Sampling rate, Hz.

        Raises
        ------
        InputError
            If the samples are not evenly spaced.
        """
        if not self.even:
            steps = np.diff(self.t)
            raise InputError(
                f"samples of {self.name!r} are not evenly spaced, {with_unit(steps.min(), 's')} to "
                f"{with_unit(steps.max(), 's')} apart; take signal.resampled(rate) first"
            )
        return self.mean_rate

    def resampled(self, rate: float) -> Signal:
        """Return the signal at even steps, linearly interpolated between its samples.

        Parameters
        ----------
        rate : float
            Sampling rate, Hz; not below the mean rate of the signal.

        Raises
        ------
        InputError
            If the rate is lower: frequencies above half of it would be aliased.

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

    # ----------------------------------------------------------------------- filter

    def filtered(self, cfc: float | None = None, *, corner: float | None = None) -> Signal:
        """Return the signal filtered by a channel frequency class; its `raw` is this signal.

        SAE J211-1, appendix C: a Butterworth filter of two poles, run forward and backward for zero
        phase shift, is 3 dB down at 1.65 times the class's frequency. Both ends are extended by odd
        reflection about the end sample, as in SciPy's `filtfilt`. Within one period 1/CFC of an
        end, the result is therefore right only if the signal is at rest or linear there.

        Parameters
        ----------
        cfc : float, optional
            Channel frequency class, Hz: 60, 180, 600 or 1000 in the standard; any other by the same
            formula.
        corner : float, optional
            In place of the class, the frequency where the signal is 3 dB down, Hz.

        Raises
        ------
        InputError
            If neither or both of `cfc` and `corner` are given; if the samples are not evenly spaced
            or fewer than ten per period 1/CFC, the standard's minimum; or if the signal is shorter
            than the filter's settling time 1/CFC.

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
                f"most {with_unit(most, 'Hz')}; the signal has {with_unit(self.rate, 'Hz')}"
            )
        smooth = zero_phase(self.values, channel, self.rate)
        return replace(self, values=smooth, raw=self)

    def plot(self, ax: Axes | None = None, **kwargs: Any) -> Axes:
        """Draw the signal against time, with the unfiltered signal in grey behind it.

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
    """Return the force of a contact, N, at times in the record; fixed steps are interpolated."""
    return np.asarray(run.recorder.pushes(times)[run.plan.layout.normal][contact])


def contacts(force: Signal, name: str) -> list[tuple[int, int]]:
    """Return the indices of the first and last sample of each contact in a measured force.

    `name`: name of the force in messages.
    """
    from scipy.ndimage import find_objects, label  # slow to import

    if force.values.max() <= 0.0:
        raise InputError(f"{name} is never positive: change its sign")
    share = force.values / force.values.max()
    pressed = [of for (of,) in find_objects(label(share > BEGINS)[0]) if share[of].max() > RISEN]
    return [(max(of.start - 1, 0), min(of.stop, len(share) - 1)) for of in pressed]


def _steps(length: float, rate: float) -> int:
    """Return the number of whole steps in a time of the given length, s."""
    count = length * rate * (1.0 + 1e-12)
    if not 1.0 <= count <= MOST_SAMPLES:
        raise InputError(
            f"rate = {with_unit(rate, 'Hz')} over {with_unit(length, 's')}, with any margin, makes "
            f"{count:.3g} samples: it must be from 2 to {MOST_SAMPLES}"
        )
    return int(count)


# _BASES: SI unit for each spelling of a unit that takes prefixes. _UNITS: for each name of a unit,
# the factor to the SI unit, and the SI unit.
_BASES = {of: of for of in ("N", "s", "m", "V", "m/s", "m/s²")} | {"m/s2": "m/s²", "m/s^2": "m/s²"}
_PREFIXES = {"n": 1e-9, "u": 1e-6, "µ": 1e-6, "μ": 1e-6, "m": 1e-3, "": 1.0, "k": 1e3, "M": 1e6}
_UNITS = {
    prefix + written: (factor, base)
    for written, base in _BASES.items()
    for prefix, factor in _PREFIXES.items()
} | {"g": (STANDARD_GRAVITY, "m/s²"), "lbf": (4.4482216152605, "N")}

_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?", re.ASCII)


def read_signal(
    path: FilePath,
    *,
    time: int | str = 0,
    values: int | str = 1,
    time_unit: str = "s",
    unit: str = "N",
    decimal: str = ".",
    name: str = "force",
) -> Signal:
    """Read a signal from a text file of columns, as data loggers write it.

    The separator of columns is the first of semicolon, tab, comma (unless it is the decimal mark)
    and space that occurs in the last line. Cells may be quoted. Lines before the first line with
    numbers in both columns are headings. Other columns may hold anything.

    Parameters
    ----------
    path : path
    time, values : int or str, optional
        Columns, by number from 0 or by the heading, with or without its unit.
    time_unit : str, optional
        Unit of the times in the file: "s", "ms", "µs" (or "us").
    unit : str, optional
        Unit of the values in the file: "N", "kN", "lbf", "m/s", "m/s²", "g", "mm", ….
    decimal : {".", ","}, optional
        Decimal mark of the numbers, which have no separators of thousands.
    name : str, optional
        Name on axes and in messages.

    Returns
    -------
    Signal
        In SI units.

    Raises
    ------
    InputError
        If the file cannot be read; if a line after the first row has no number in one of the
        columns, or more or fewer cells than that row; or if times do not rise. The message has the
        line.

    Examples
    --------
    >>> from pathlib import Path
    >>> from tempfile import TemporaryDirectory
    >>> text = "time [ms];force [kN]\\n0,0;0,0\\n0,1;1,5\\n0,2;0,3\\n"
    >>> with TemporaryDirectory() as folder:
    ...     file = Path(folder) / "drop.csv"
    ...     _ = file.write_text(text)
    ...     signal = read_signal(file, time_unit="ms", unit="kN", decimal=",")
    >>> signal
    Signal(force, 3 samples at 10 kHz, largest 1500 N)
    """
    of_time, _ = _UNITS[choice("time_unit", time_unit, [f"{of}s" for of in _PREFIXES])]
    if text("unit", unit) not in _UNITS:
        choice("unit", unit, ["N", "kN", "lbf", "m/s", "m/s²", "g", "mm", "V"])
    factor, base = _UNITS[unit]
    mark = choice("decimal", decimal, (".", ","))
    file = file_path("path", path)
    try:
        content = decoded(file.read_bytes())
    except OSError as error:
        raise InputError(f"cannot read {str(file)!r}: {error.strerror or error}") from None
    if content is None:
        raise InputError(f"{file} is binary; export it as text")
    lines = [line.strip(" ") for line in content.split("\n")]
    last = next((line for line in reversed(lines) if line), "")
    bare = re.sub('"[^"]*"', "", last)
    present = (sep for sep in ";\t," if sep in bare and (sep != mark or bare != last))
    split = csv.reader(lines, delimiter=next(present, " "), skipinitialspace=True)
    try:
        table = [(split.line_num, [cell.strip() for cell in row]) for row in split if any(row)]
    except csv.Error as error:
        raise InputError(f"{file}, line {split.line_num}: {error}") from None
    columns = [_column("time", time, table), _column("values", values, table)]

    found: list[tuple[float, float]] = []
    point = str.maketrans({mark: ".", ".": mark})
    heading = width = 0
    for at, cells in table:
        wanted = [cells[i].translate(point) if i < len(cells) else "" for i in columns]
        bad = [cell for cell in wanted if not _NUMBER.fullmatch(cell)]
        if bad and not found:
            heading = len(cells)
            continue
        width, told = width or len(cells), ""
        if bad:
            told = f"{bad[0]!r} is no number"
        elif len(cells) != width:
            told = f"{len(cells)} cells, not {width}"
        elif not found and 1 < heading < sum(map(bool, cells)):
            told = f"{width} cells under {heading} headings"
        elif found and float(wanted[0]) <= found[-1][0]:
            told = "the time does not rise"
        if told:
            raise InputError(f"{file}, line {at}: {told}; are columns and decimal={mark!r} right?")
        found.append((float(wanted[0]), float(wanted[1])))
    if len(found) < 2:
        raise InputError(
            f"{file}: no two lines have numbers in time={time!r} and values={values!r}; are these "
            f"columns, and is decimal={mark!r} right?"
        )
    times, numbers = np.array(found).T
    return Signal(of_time * times, factor * numbers, unit=base, name=text("name", name))


def _column(name: str, given: int | str, table: list[tuple[int, list[str]]]) -> int:
    """Return the index of the column that the user gives by number or heading."""
    if not isinstance(given, str):
        return integer(name, given, low=0)
    for _, row in table:
        for options in (row, [re.sub(r"\s*[\[(].*$", "", cell) for cell in row]):
            if options.count(given) > 1:
                raise InputError(f"{name}: {options.count(given)} columns are called {given!r}")
            if given in options:
                return options.index(given)
    heading = next((row for _, row in table if len(row) > 1), [])
    raise InputError(
        f"{name}: no column is called {given!r}{nearest(given, heading)}; there are "
        + ", ".join(map(repr, heading))
    )
