"""A tolerance instead of a step: contact by collocation on the force, flight in closed form.

The force over a step is a polynomial through eight Radau nodes. What it does to the bodies is exact
in modes, so only the force has to be resolved; between contacts nothing is stepped at all.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from . import _core
from .checks import positive
from .errors import InputError
from .events import Events
from .laws import ContactLaw
from .relative import Relative

__all__ = ["TIGHTEST", "Adaptive", "Track", "adaptive_run"]

FloatArray = npt.NDArray[np.float64]

# Double precision carries no more digits.
TIGHTEST = 1e-13

# Columns of a row of the track (enum aoi_track), before the modes.
_START, _LENGTH, _CONTACT, _RELEASE, _FIXED = 0, 1, 2, 3, 21

# Samples for curves: within each step of contact, and in flight over the whole record.
_PER_STEP = 8
_IN_FLIGHT = 240


@dataclass(frozen=True, kw_only=True)
class Adaptive:
    """Integrate to a tolerance.

    Parameters
    ----------
    rtol : float, optional
        Relative error of peak force, contact times and impulse, and of velocities relative to the
        largest initial one; from 1e-13 up to, not including, 1.

    Raises
    ------
    InputError
        If `rtol` is out of range.
    """

    rtol: float = 1e-8

    def __post_init__(self) -> None:
        object.__setattr__(self, "rtol", positive("rtol", self.rtol))
        if not TIGHTEST <= self.rtol < 1.0:
            raise InputError(
                f"rtol must be from {TIGHTEST:g} to below 1, got {self.rtol:g}: double precision "
                "carries no more digits"
            )


@dataclass(frozen=True, eq=False)
class Track:
    """The dense record of an adaptive run: exact between its rows at any time.

    Attributes
    ----------
    relative : Relative
    law : ContactLaw
    duration : float
        s.
    table : ndarray, shape (rows, 21 + 2 n)
        As ``enum aoi_track``.
    events : Events
    steps, rejected : int
        Steps of contact taken, and tried in vain.
    x, v : ndarrays, shape (n,)
        The modes where the last row ends.
    """

    relative: Relative
    law: ContactLaw
    duration: float
    table: FloatArray
    events: Events
    steps: int
    rejected: int
    x: FloatArray = field(repr=False)
    v: FloatArray = field(repr=False)

    @property
    def times(self) -> FloatArray:
        """Times that draw smooth curves and hold the peak and the ends of contacts."""
        start, length = self.table[:, _START], self.table[:, _LENGTH]
        touching = self.table[:, _CONTACT] == 1.0
        fractions = np.arange(_PER_STEP) / _PER_STEP
        inside = start[touching][:, None] + np.outer(length[touching], fractions)
        parts = [np.array([0.0, self.duration, self.events.peak_time]), inside.ravel()]
        parts.append(np.array(self.events.contacts).ravel())
        for begin, time in zip(start[~touching], length[~touching], strict=True):
            count = max(2, round(_IN_FLIGHT * time / self.duration))
            parts.append(np.linspace(begin, begin + time, count))
        times = np.unique(np.concatenate(parts))
        return times[times <= self.duration]

    def sample(self, times: FloatArray) -> FloatArray:
        """Return the rows of ``enum aoi_row``, shape (15, len(times)), at ascending times, s."""
        record = np.empty((_core.record_rows(), len(times)))
        centre, residual = self.relative.centre
        _core.track_sample(
            self.relative.for_core(),
            *self.law.for_core(),
            centre,
            residual,
            self.table,
            np.ascontiguousarray(times),
            record,
        )
        return record


def adaptive_run(
    relative: Relative, law: ContactLaw, *, rtol: float, velocity: float, duration: float
) -> Track:
    """Run the core to a tolerance.

    Raises
    ------
    ConvergenceError
        If the tolerance cannot be met; with the time.
    """
    x, v = relative.start(velocity)
    raw, rows, peak_force, peak_time, impulse, steps, rejected = _core.adaptive(
        relative.for_core(), *law.for_core(), rtol, duration, x, v
    )
    table = np.frombuffer(raw).reshape(rows, _FIXED + 2 * len(x))
    events = Events(peak_force, peak_time, _contacts(table, duration), impulse)
    return Track(relative, law, duration, table, events, steps, rejected, x, v)


def _contacts(table: FloatArray, duration: float) -> tuple[tuple[float, float], ...]:
    """Start and end of each contact; one that the record cuts off ends with it."""
    touching = table[:, _CONTACT] == 1.0
    release = table[:, _RELEASE]
    released = touching & (release >= 0.0)
    # A contact starts with a step that follows a flight, a release, or nothing.
    follows = np.concatenate([[True], ~touching[:-1] | released[:-1]])
    starts = table[touching & follows, _START]
    ends = np.minimum(release[released], duration)
    if len(ends) < len(starts):
        ends = np.append(ends, duration)
    return tuple(
        (float(start), float(end))
        for start, end in zip(starts, ends, strict=True)
        if start < duration
    )
