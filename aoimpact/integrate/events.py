"""The events of a recorded contact: its intervals, its peak force, its impulse.

A solver with fixed steps gives force and indentation only at its steps. Events between the steps
are interpolated here, with at least the solver's order of accuracy (Newmark's second). The adaptive
solver locates its events itself and makes :class:`Events` from them.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import scipy
from numpy.typing import NDArray

from ..base import ROUNDING, ArrayPair, FloatArray

# A parabola is fitted to a peak if the curvature at a neighbouring sample, relative to that at the
# peak, is at least this. If both ratios are smaller, the force jumps or is not resolved. A jump
# changes the curvature only at the samples next to the jump. Half a sine of N steps has the ratio
# cos(π/N), so that four steps suffice.
_LEAST_CURVATURE = 0.5


class Events(NamedTuple):
    """The events of one contact over a record.

    Attributes
    ----------
    peak_force, peak_time : float
        Largest force [N] and its time [s]; 0.0 and the first time without any contact.
    contacts : tuple of (float, float)
        Start and end [s] of each contact, in order. A contact that the record cuts off ends where
        the record does.
    impulse : float
        Integral of the force over the record [N s].
    slips : tuple of (float, float), or None
        Start and end [s] of every interval of full slip; None for a contact without friction, or
        of coefficient 0.
    touches : sequence of (float, float)
        Impulse [N s] and pace of each contact of an adaptive run. The pace is the initial rate of
        indentation times the contact's duration, relative to the largest indentation.
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
        """Return whether the last contact lasts until `end` [s], the end of the record."""
        return bool(self.contacts) and self.contacts[-1][1] >= end * (1.0 - ROUNDING)


def find_peak(t: FloatArray, force: FloatArray) -> tuple[float, float]:
    """Return the largest force and its time, both to at least second order in the step.

    Each local maximum is the top of the parabola through its sample and the two next to it; the
    error is then O(dt²) in the time and O(dt³) in the force. If the curvature at both neighbours is
    less than half that at the maximum, the force has a jump or kink, whose height a parabola does
    not show, and the sample itself is taken. The curvature at one of the neighbours may be that
    small, as a law may be stiffer in unloading than in loading.
    """
    best = int(np.argmax(force))
    if force[best] <= 0.0:
        return 0.0, float(t[0])
    here, bend = force[1:-1], np.diff(force, 2)
    beside = np.pad(bend, 1, constant_values=np.inf)  # curvature unknown at both ends
    beside = np.minimum(beside[:-2], beside[2:])  # the stronger: curvatures are negative
    peaks = (here >= force[:-2]) & (here >= force[2:]) & (beside <= _LEAST_CURVATURE * bend)
    middle = 1 + np.flatnonzero(peaks)
    top, shift = parabola_tops(force, middle)
    # A parabola's top is never below its sample, so that the larger of the two is the peak.
    winner = int(np.argmax(top)) if top.size else 0
    if top.size and top[winner] >= force[best]:
        at = middle[winner]
        return float(top[winner]), float(t[at] + shift[winner] * (t[at] - t[at - 1]))
    return float(force[best]), float(t[best])


def parabola_tops(values: FloatArray, middle: NDArray[np.intp]) -> ArrayPair:
    """Return heights and offsets, in steps, of the tops of parabolas around samples `middle`."""
    before, here, after = values[middle - 1], values[middle], values[middle + 1]
    slope, bend = 0.5 * (after - before), 2.0 * here - before - after
    shift = np.divide(slope, bend, out=np.zeros(len(middle)), where=bend != 0.0)
    return here + 0.5 * slope * shift, shift


def find_contacts(
    t: FloatArray, force: FloatArray, indentation: FloatArray, rate: FloatArray
) -> tuple[tuple[float, float], ...]:
    """Return start and end of every interval in which the force acts.

    A contact starts and ends at a zero of the indentation, located between two samples by cubic
    Hermite interpolation. If the force of a law vanishes at a positive indentation, the contact
    ends where the falling force, extrapolated linearly, is zero. Contacts or gaps shorter than a
    step are not detected.
    """
    closed = force != 0.0  # laws that pull have negative forces
    change = np.diff(closed.astype(np.int8))
    first, last = np.flatnonzero(change == 1), np.flatnonzero(change == -1)
    zeros = np.append(_zeros(t, indentation, rate, np.append(first, last)), t[[0, -1]])
    starts, ends, (begin, end) = zeros[: len(first)], zeros[len(first) : -2], zeros[-2:]
    fall = force[np.maximum(last - 1, 0)] - force[last]
    left = np.divide(force[last], fall, out=np.ones(len(last)), where=fall > 0.0)  # in steps
    drawn = t[last] + np.minimum(left, 1.0) * (t[last + 1] - t[last])
    ends = np.where(indentation[last + 1] > 0.0, drawn, ends)
    starts = np.append([begin] * int(closed[0]), starts)
    ends = np.append(ends, [end] * int(closed[-1]))
    return tuple(zip(starts.tolist(), ends.tolist(), strict=True))


def _zeros(
    t: FloatArray, indentation: FloatArray, rate: FloatArray, steps: NDArray[np.intp]
) -> FloatArray:
    """Return the time in each step [t_i, t_(i+1)] at which the indentation crosses zero, or t_i.

    It does not cross zero if it is zero at t_i, as for bodies that touch from the start, or if the
    force begins or ends at a positive indentation, as under a law that gives no force at small
    indentations.
    """
    before, after = indentation[steps], indentation[steps + 1]
    found = t[steps].copy()
    for at in np.flatnonzero((before != 0.0) & (before * after <= 0.0)):
        two = slice(steps[at], steps[at] + 2)
        cubic = scipy.interpolate.CubicHermiteSpline(t[two], indentation[two], rate[two])
        roots = cubic.roots(extrapolate=False)
        rounded = t[two][np.abs(indentation[two]).argmin()]  # rounding hides a root at an end
        found[at] = roots[0] if len(roots) else rounded
    return found


def find_slips(
    t: FloatArray,
    contacts: tuple[tuple[float, float], ...],
    stuck: FloatArray,
    left: FloatArray,
    ahead: FloatArray,
) -> tuple[tuple[float, float], ...]:
    """Return start and end of every interval of full slip within `contacts`.

    Full slip begins where `stuck` or, after full stick, `left` falls to zero, extrapolated linearly
    from earlier steps. Full slip ends at a zero of `ahead`.

    Parameters
    ----------
    t : (n,) array
        Ascending times [s].
    contacts : tuple of (float, float)
        Start and end of each contact [s].
    stuck : (n,) array
        Area of the stick zone relative to the area of the contact, from 0 to 1.
    left : (n,) array
        Bound of the friction force minus its magnitude [N].
    ahead : (n,) array
        Sliding velocity along the friction force minus the rate of the largest stretch without
        slip, which is μ/(G*/E*) times the rate of the indentation [m/s].
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
                # `share` is negative if `ahead` has changed its sign before the step.
                share = before / (before - after) if after < before else 0.0
                step = float(t[i] - t[i - 1])
                turns.append(float(t[i - 1]) + step * max(-1.0, min(share, 1.0)))
        turns += [end] if len(turns) % 2 else []
        found += [(a, b) for a, b in zip(turns[::2], turns[1::2], strict=True) if b > a]
    return tuple(found)


def _drawn_on(t: FloatArray, values: FloatArray, i: int) -> float:
    """Return the time in [t_(i-1), t_i] at which a linear extrapolation of earlier values is 0."""
    before, last = float(values[i - 2]) if i > 1 else 0.0, float(values[i - 1])
    if last >= before:
        return float(t[i])
    step = float(t[i - 1] - t[i - 2]) * last / (before - last)
    return float(min(t[i - 1] + step, t[i]))
