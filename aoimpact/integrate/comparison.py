"""Comparison of two adaptive runs of one scene, in the quantities that a tolerance bounds.

Touches with at most a hundredth of the largest impulse of their contact do not count: rounding
errors decide whether bodies moving side by side graze each other. Nor do gaps of at most a
hundredth of the duration of the touches before and after them: rounding errors decide whether a
body leaves its support while the force swings between zero and twice the weight.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ..base import FloatArray
from .dense import DenseRecorder
from .events import Events
from .settings import LESSER

# Errors of velocities are relative to at least this share of the velocity that a contact's largest
# impulse would give the lightest body. Bodies that loads hold together move only by rounding
# errors.
_AT_REST = 1e-3


def most_touches(run: DenseRecorder) -> int:
    """Return the number of touches that count, for the contact with most of them.

    Touches that together have at most a hundredth of the impulse of the largest one do not count.
    """
    most = 0
    for of, small in zip(run.events, _least(run), strict=True):
        impulses = _impulses(of)
        largest = impulses.max(initial=0.0)
        several = len(impulses) > 1 and impulses.sum() - largest > LESSER * largest
        counted = max(2, int((impulses >= small).sum())) if several else min(1, len(impulses))
        most = max(most, counted)
    return most


def difference(one: DenseRecorder, other: DenseRecorder, speed: float) -> float:
    """Return the largest relative difference of the quantities that a tolerance bounds.

    These quantities are each contact's peak force and impulse, the start and end of its touches,
    and the velocities of the centres of mass after the last touch. The result is infinite if one
    run has more touches than the other.

    Parameters
    ----------
    one, other : DenseRecorder
    speed : float
        Largest initial speed, m/s.
    """
    runs, apart = (one, other), [0.0]
    sizes = np.array([[(of.peak_force, of.impulse) for of in run.events] for run in runs])
    for ours, theirs in np.moveaxis(sizes, 2, 0):
        scale = np.maximum(np.abs(theirs), LESSER * np.abs(theirs).max(initial=0.0))
        far = scale > 0.0
        apart += (np.abs(ours - theirs)[far] / scale[far]).tolist()
    least = np.maximum(*map(_least, runs))
    touches = [[_touches(*of) for of in zip(run.events, least, strict=True)] for run in runs]
    if any(len(ours.start) != len(theirs.start) for ours, theirs in zip(*touches, strict=True)):
        return math.inf  # even if the motions agree at their ends by chance
    apart += map(_times_apart, *touches)
    velocities = []
    for run, found in zip(runs, touches, strict=True):
        over = [end for of in found for end in of.end.tolist() if end < run.duration]
        record = run.rows(np.array([max(over, default=run.duration)]), energies=False)
        velocities.append(run.plan.layout.centre_velocities(record)[:, 0])
    known = [body.known_mass for body in one.plan.bodies if body.known_mass is not None]
    rest = _AT_REST * float(sizes[0, :, 1].max(initial=0.0)) / min(known, default=np.inf)
    fastest = max(speed, rest, float(np.abs(velocities).max(initial=0.0)))
    if fastest > 0.0:
        apart.append(float(np.abs(np.subtract(*velocities)).max(initial=0.0)) / fastest)
    return max(apart)


def touch_alike(one: Events, other: Events) -> bool:
    """Return whether two runs have as many touches that count; with fixed steps, all count."""
    if not (one.touches and other.touches):
        return one.contact_count == other.contact_count
    least = LESSER * max(impulse for of in (one, other) for impulse, _ in of.touches)
    return _touches(one, least).start.size == _touches(other, least).start.size


def _impulses(of: Events) -> FloatArray:
    """Return the impulse of each touch of a contact, N s."""
    return np.array([impulse for impulse, _ in of.touches])


def _least(run: DenseRecorder) -> FloatArray:
    """Return the least impulse of a touch that counts, for each contact, N s."""
    largest = np.array([_impulses(of).max(initial=0.0) for of in run.events])
    least: FloatArray = LESSER * np.maximum(largest, LESSER * largest.max(initial=0.0))
    return least


class _Touches(NamedTuple):
    """The touches of a contact that count, arrays of shape (touches,).

    Attributes
    ----------
    start, end : ndarray
        Start and end of each touch, s.
    pace : ndarray
        Relative rate at which each touch begins; see `Events.touches`.
    apart : ndarray
        Sum of the gaps within each touch that do not count, s.
    """

    start: FloatArray
    end: FloatArray
    pace: FloatArray
    apart: FloatArray


def _touches(of: Events, least: float) -> _Touches:
    impulses, pace = np.array(of.touches[: len(of.contacts)]).reshape(-1, 2).T
    start, end = np.array(of.contacts).reshape(-1, 2).T
    start, end, pace = (column[impulses >= least] for column in (start, end, pace))
    gap, length = start[1:] - end[:-1], end - start
    parted = gap > LESSER * np.minimum(length[1:], length[:-1])
    first, last = np.append(True, parted)[: len(start)], np.append(parted, True)[: len(start)]
    apart = np.zeros(int(first.sum()))
    np.add.at(apart, np.cumsum(first)[1:][~parted] - 1, gap[~parted])
    return _Touches(start[first], end[last], pace[first], apart)


def _times_apart(ones: _Touches, others: _Touches) -> float:
    """Return the largest difference in a touch's start, end or gaps, relative to its end."""
    if not ones.start.size:
        return 0.0
    latest = np.maximum(ones.end, others.end)
    starts = np.abs(ones.start - others.start) / latest
    # Bodies at rest side by side that a wave reaches, at a small pace, touch at no definite time.
    sudden = np.minimum(ones.pace, others.pace) >= LESSER
    ends = np.abs(ones.end - others.end) / latest
    gaps = np.abs(ones.apart - others.apart) / latest
    return float(max(starts[sudden].max(initial=0.0), ends.max(), gaps.max()))
