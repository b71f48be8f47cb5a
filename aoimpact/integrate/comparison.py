"""Comparison of two adaptive runs of one scene: their difference in what a tolerance bounds.

A touch with a hundredth of the impulse of the largest one of its contact, or less, does not count:
whether bodies that move on side by side graze each other is rounding. Nor does a gap that lasts a
hundredth of the touches beside it, or less: whether a body that is put on another, and swings there
between no force and twice its weight, leaves it is rounding, too.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from ..base import FloatArray
from .dense import DenseRecorder
from .tolerances import AT_REST, LESSER, SUDDEN


def most_touches(run: DenseRecorder) -> int:
    """Return how often the contact that counts most often touches.

    One touch with any number of lesser ones beside it, that together are a hundredth of it at most,
    is one.
    """
    most = max((len(of.touches) for of in run.events), default=0)
    if most <= 1:
        return most
    most = 1
    for contact, small in enumerate(_least(run)):
        of = _impulses(run, contact)
        largest = of.max(initial=0.0)
        if len(of) > 1 and of.sum() - largest > LESSER * largest:
            most = max(most, 2, int((of >= small).sum()))
    return most


def difference(one: DenseRecorder, other: DenseRecorder, speed: float) -> float:
    """Return the largest relative difference of what a tolerance bounds.

    These are each contact's peak force and impulse, when its touches start and end, and the
    velocities of the centres of mass after the last touch.

    Parameters
    ----------
    one, other : DenseRecorder
    speed : float
        The largest initial one, m/s.
    """
    apart = [_lesser_apart(_peaks(one), _peaks(other)), _lesser_apart(_sums(one), _sums(other))]
    least = np.maximum(_least(one), _least(other))
    touches = [
        [_touches(run, contact, small) for contact, small in enumerate(least)]
        for run in (one, other)
    ]
    apart += map(_times_apart, *touches)
    ours, theirs = map(_velocities, (one, other), touches)
    fastest = max(speed, _at_rest(one), float(np.abs(np.append(ours, theirs)).max(initial=0.0)))
    if fastest > 0.0:
        apart.append(float(np.abs(ours - theirs).max(initial=0.0)) / fastest)
    return max(apart)


def _peaks(run: DenseRecorder) -> FloatArray:
    return np.array([event.peak_force for event in run.events])


def _sums(run: DenseRecorder) -> FloatArray:
    return np.array([event.impulse for event in run.events])


def _lesser_apart(ones: FloatArray, others: FloatArray) -> float:
    scale = np.maximum(np.abs(others), LESSER * np.abs(others).max(initial=0.0))
    apart = np.divide(np.abs(ones - others), scale, out=np.zeros(len(ones)), where=scale > 0.0)
    return float(apart.max(initial=0.0))


def _impulses(run: DenseRecorder, contact: int) -> FloatArray:
    """Impulse of each touch of a contact, N s."""
    return np.array([impulse for impulse, _ in run.events[contact].touches])


def _least(run: DenseRecorder) -> FloatArray:
    """The impulse of the least touch that matters, of each contact, N s."""
    contacts = range(len(run.events))
    largest = np.array([_impulses(run, contact).max(initial=0.0) for contact in contacts])
    least: FloatArray = LESSER * np.maximum(largest, LESSER * largest.max(initial=0.0))
    return least


class _Touches(NamedTuple):
    """The touches of a contact that matter, arrays of shape (touches,).

    Attributes
    ----------
    start, end : ndarray
        s.
    before, after : ndarray
        The contact's impulse until then, N s.
    pace : ndarray
        See `Events.touches`.
    apart : ndarray
        Length of the gaps within each that do not count, s.
    """

    start: FloatArray
    end: FloatArray
    before: FloatArray
    after: FloatArray
    pace: FloatArray
    apart: FloatArray

    def chosen(self, which: Any) -> _Touches:
        """Return those of an index or a mask."""
        return _Touches(*(column[which] for column in self))


def _touches(run: DenseRecorder, contact: int, least: float) -> _Touches:
    impulses, pace = np.array(run.events[contact].touches).reshape(-1, 2).T
    after = np.cumsum(impulses)
    start, end = np.array(run.events[contact].contacts).reshape(-1, 2).T
    large = impulses >= least
    columns = (start, end, after - impulses, after, pace)
    start, end, before, after, pace = (column[large] for column in columns)
    gap, length = start[1:] - end[:-1], end - start
    parted = gap > LESSER * np.minimum(length[1:], length[:-1])
    first, last = np.append(True, parted)[: len(start)], np.append(parted, True)[: len(start)]
    apart = np.zeros(int(first.sum()))
    np.add.at(apart, np.cumsum(first)[1:][~parted] - 1, gap[~parted])
    return _Touches(start[first], end[last], before[first], after[last], pace[first], apart)


def _times_apart(ones: _Touches, others: _Touches) -> float:
    """The largest difference of start or end, relative to the time itself.

    Where one run has more touches than the other, those belong together at which as much impulse
    has been passed on.
    """
    if min(ones.start.size, others.start.size) == 0:
        return 0.0  # the impulses differ by as much
    if ones.start.size > others.start.size:
        ones, others = others, ones
    if ones.start.size < others.start.size:
        at = np.searchsorted(others.after, 0.5 * (ones.before + ones.after))
        others = others.chosen(np.minimum(at, others.start.size - 1))
    latest = np.maximum(ones.end, others.end)
    starts = np.abs(ones.start - others.start) / latest
    sudden = np.minimum(ones.pace, others.pace) >= SUDDEN
    ends = np.abs(ones.end - others.end) / latest
    gaps = np.abs(ones.apart - others.apart) / latest
    return float(max(starts[sudden].max(initial=0.0), ends.max(), gaps.max()))


def _at_rest(run: DenseRecorder) -> float:
    """The velocity below which bodies that loads press together are at rest, m/s."""
    known = [body.known_mass for body in run.plan.bodies if body.known_mass is not None]
    return AT_REST * float(_sums(run).max(initial=0.0)) / min(known, default=np.inf)


def _velocities(run: DenseRecorder, touches: Sequence[_Touches]) -> FloatArray:
    """Velocities of the centres of mass after the last touch that matters and is over, m/s."""
    over = [end for of in touches for end in of.end.tolist() if end < run.duration]
    record = run.rows(np.array([max(over, default=run.duration)]), energies=False)
    return run.plan.layout.centre_velocities(record)[:, 0]
