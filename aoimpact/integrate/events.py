"""The events of a recorded contact: its intervals, its peak, its impulse.

A solver with fixed steps knows the force and the indentation at its steps only; what lies between
them is found here by interpolation of an order at least that of the solver (Newmark's second). A
solver that locates its events itself hands them over as an :class:`Events` instead.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import scipy
from numpy.typing import NDArray

from ..base import ROUNDING, FloatArray

# Least curvature at both samples beside a peak, over that at the peak. With less, the force has
# jumped or is not resolved. A jump bends the curve up on one side of it, down on the other, and no
# further out. Half a sine of N steps has cos(π/N) there, so that four steps are enough.
_LEAST_CURVATURE = 0.5


class Events(NamedTuple):
    """The events of one contact over a record.

    Attributes
    ----------
    peak_force, peak_time : float
        The largest force [N] and when it acts [s]; 0.0 and the first time without any contact.
    contacts : tuple of (float, float)
        Start and end [s] of each contact, in order. A contact that the record cuts off ends where
        the record does.
    impulse : float
        Integral of the force over the record [N s].
    slips : tuple of (float, float), or None
        Start and end [s] of every interval in which all of the contact slips; None of a contact
        without friction, or of coefficient 0.
    touches : sequence of (float, float)
        Of each contact in an adaptive run its impulse [N s], and the rate at which it begins, times
        its length, relative to how deep it goes.
    """

    peak_force: float
    peak_time: float
    contacts: tuple[tuple[float, float], ...]
    impulse: float
    slips: tuple[tuple[float, float], ...] | None = None
    touches: Sequence[tuple[float, float]] = ()

    @property
    def contact_duration(self) -> float:
        """Duration of the first contact [s]; 0.0 without contact."""
        if not self.contacts:
            return 0.0
        start, end = self.contacts[0]
        return end - start

    @property
    def contact_count(self) -> int:
        """Number of contacts."""
        return len(self.contacts)

    @property
    def peak_contact(self) -> tuple[float, float] | None:
        """Start and end [s] of the contact with the largest force; None without contact."""
        spans = (span for span in self.contacts if self.peak_time <= span[1])
        return next(spans, self.contacts[-1]) if self.contacts else None

    def last_until(self, end: float) -> bool:
        """Return whether the last contact lasts until the record's end [s], which cuts it off."""
        return bool(self.contacts) and self.contacts[-1][1] >= end * (1.0 - ROUNDING)


def find_events(
    t: FloatArray, force: FloatArray, indentation: FloatArray, rate: FloatArray
) -> Events:
    """Return the events of a record sampled at `t`.

    Parameters
    ----------
    t : (n,) array
        Times, increasing [s].
    force, indentation, rate : (n,) arrays
        Contact force [N], indentation [m] and its time derivative [m/s].
    """
    peak_force, peak_time = find_peak(t, force)
    contacts = find_contacts(t, force, indentation, rate)
    return Events(peak_force, peak_time, contacts, find_impulse(t, force))


def find_peak(t: FloatArray, force: FloatArray) -> tuple[float, float]:
    """Return the largest force and its time, to second order in the step.

    Each local maximum is the top of the parabola through its sample and the two beside it (the
    time is then right to O(dt²), the force to O(dt³)). Where the parabolas around both of
    those are less than half as curved, the sample itself is taken: the force has jumped or bent
    there, and no parabola tells how far it rose. One of the two may be so where a law unloads
    stiffer than it loads.
    """
    best = int(np.argmax(force))
    if force[best] <= 0.0:
        return 0.0, float(t[0])
    before, here, after = force[:-2], force[1:-1], force[2:]
    # Half the curvature of the parabolas around all samples; not known beyond the record.
    curvatures = np.diff(np.diff(force) / np.diff(t)) / (t[2:] - t[:-2])
    bend = np.pad(curvatures, 1, constant_values=np.inf)
    beside = np.minimum(bend[:-2], bend[2:])  # negative, as all are at a peak
    smooth = (here >= before) & (here >= after) & (beside <= _LEAST_CURVATURE * bend[1:-1])
    top, shift = parabola_tops(t, force, np.flatnonzero(smooth) + 1)
    # A parabola's top is never below its sample: if the largest sample has one, it is among these.
    winner = int(np.argmax(top)) if top.size else 0
    if top.size and top[winner] >= force[best]:
        return float(top[winner]), float(shift[winner])
    return float(force[best]), float(t[best])


def parabola_tops(
    t: FloatArray, force: FloatArray, middle: NDArray[np.intp]
) -> tuple[FloatArray, FloatArray]:
    """Return heights and times of the tops of the parabolas around the samples `middle`."""
    left, right = t[middle] - t[middle - 1], t[middle + 1] - t[middle]
    rise = (force[middle] - force[middle - 1]) / left
    fall = (force[middle + 1] - force[middle]) / right
    curvature = (fall - rise) / (left + right)
    slope = rise + curvature * left
    flat = curvature == 0.0
    offset = np.where(flat, 0.0, -slope / (2.0 * np.where(flat, 1.0, curvature)))
    return force[middle] + 0.5 * slope * offset, t[middle] + offset


def find_contacts(
    t: FloatArray, force: FloatArray, indentation: FloatArray, rate: FloatArray
) -> tuple[tuple[float, float], ...]:
    """Return start and end of every interval in which the force acts.

    A contact starts and ends at a zero of the indentation, found between two samples by Hermite's
    cubic through values and rates (straight line where the cubic is not monotone). Where a law's
    force vanishes while there is still indentation, the end is where the falling force,
    extrapolated, reaches zero. Contacts or gaps shorter than a step cannot be seen.
    """
    closed = force != 0.0  # a law that pulls is in contact while it does
    change = np.diff(closed.astype(np.int8))
    starts = [_crossing(t, indentation, rate, int(i)) for i in np.flatnonzero(change == 1)]
    ends = [_release(t, force, indentation, rate, int(i)) for i in np.flatnonzero(change == -1)]
    if closed[0]:
        starts.insert(0, float(t[0]))
    if closed[-1]:
        ends.append(float(t[-1]))
    return tuple(zip(starts, ends, strict=True))


def find_slips(
    t: FloatArray,
    contacts: tuple[tuple[float, float], ...],
    stuck: FloatArray,
    left: FloatArray,
    ahead: FloatArray,
) -> tuple[tuple[float, float], ...]:
    """Return start and end of every interval in which all of a contact slips, within `contacts`.

    Where slip of all begins, the share that sticks goes to zero as before, on a straight line; or,
    where all of it has stuck until then, `left` does. Where it ends, `ahead` goes through zero.

    Parameters
    ----------
    t : (n,) array
        Times, increasing [s].
    contacts : tuple of (float, float)
    stuck : (n,) array
        Share of the contact within which it sticks.
    left : (n,) array
        Bound of friction less friction itself [N].
    ahead : (n,) array
        Rate of the slide along friction less that of the largest stretch before slip, μ/(G*/E*)
        times that of the indentation [m/s].
    """
    found: list[tuple[float, float]] = []
    for start, end in contacts:
        within = np.flatnonzero((t > start) & (t < end))
        slips = stuck[within] <= 0.0
        turns = [start] if len(within) and slips[0] else []
        for i in within[1:][slips[1:] != slips[:-1]].tolist():
            if stuck[i] <= 0.0:
                turns.append(_drawn_on(t, stuck if stuck[i - 1] < 1.0 else left, i))
            else:
                before, after = float(ahead[i - 1]), float(ahead[i])
                share = before / (before - after) if after < before else 0.0  # < 0 by the steps
                step = float(t[i] - t[i - 1])
                turns.append(float(t[i - 1]) + step * max(-1.0, min(share, 1.0)))
        turns += [end] if len(turns) % 2 else []
        found += [(a, b) for a, b in zip(turns[::2], turns[1::2], strict=True) if b > a]
    return tuple(found)


def _drawn_on(t: FloatArray, values: FloatArray, i: int) -> float:
    """Where in [t_(i-1), t_i] values before it reach zero, on a straight line."""
    before, last = float(values[i - 2]) if i > 1 else 0.0, float(values[i - 1])
    if last >= before:
        return float(t[i])
    step = float(t[i - 1] - t[i - 2]) * last / (before - last)
    return float(min(t[i - 1] + step, t[i]))


def find_impulse(t: FloatArray, force: FloatArray) -> float:
    """Return the integral of the force by the trapezium rule.

    This is the momentum that Newmark's average-acceleration rule itself transfers, exactly: on a
    free body it changes the momentum by dt (F_n + F_{n+1}) / 2 in each step.
    """
    return float(np.trapezoid(force, t))


def _crossing(t: FloatArray, indentation: FloatArray, rate: FloatArray, i: int) -> float:
    """Return the time in [t_i, t_{i+1}] at which the indentation is zero."""
    step = float(t[i + 1] - t[i])
    before, after = float(indentation[i]), float(indentation[i + 1])
    if before == 0.0 or before * after > 0.0:
        # Touching from the start; or indented already, with a law that takes hold only now.
        return float(t[i])
    slopes = step * float(rate[i]), step * float(rate[i + 1])
    return float(t[i]) + step * _hermite_root(before, after, *slopes)


def _release(
    t: FloatArray, force: FloatArray, indentation: FloatArray, rate: FloatArray, i: int
) -> float:
    """Return the time in [t_i, t_{i+1}] at which the force, positive at t_i, ends."""
    if indentation[i + 1] <= 0.0:
        return _crossing(t, indentation, rate, i)
    step = float(t[i + 1] - t[i])
    if i == 0 or force[i - 1] <= force[i]:
        return float(t[i + 1])
    slope = float(force[i - 1] - force[i]) / float(t[i] - t[i - 1])
    return float(t[i]) + min(float(force[i]) / slope, step)


def _hermite_root(before: float, after: float, slope_before: float, slope_after: float) -> float:
    """Return s in [0, 1] where the cubic with these end values and slopes is zero.

    `before` and `after` have opposite signs, or `after` is zero.
    """
    rise = after - before
    # Fritsch and Carlson (1980): such slopes make the cubic monotone, hence its root unique.
    if not (0.0 <= slope_before / rise <= 3.0 and 0.0 <= slope_after / rise <= 3.0):
        return -before / rise
    cubic = slope_before + slope_after - 2.0 * rise
    square = 3.0 * rise - 2.0 * slope_before - slope_after

    def value(s: float) -> float:
        return before + s * (slope_before + s * (square + s * cubic))

    if (value(1.0) > 0.0) == (before > 0.0):  # by rounding
        return 1.0
    return float(scipy.optimize.brentq(value, 0.0, 1.0, xtol=1e-16))
