"""Differences of two outcomes in the quantities to which a tolerance applies; see `Adaptive`.

Errors of peak force and impulse are relative to the contact's own, but at least to a hundredth of
the largest contact's; a peak that no run resolves (NaN) is left out. Errors of the start and end of
a touch are relative to the time of its end. Touches of less than a hundredth of their contact's
largest impulse do not count, nor do partings of less than the tolerance, nor starts whose time is
uncertain, as of adjacent bodies that are hardly pressed together. Velocities are those of the
centres of mass, relative to the largest.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from .case import Case
from .outcome import FloatArray, Outcome, Touch

_LESSER = 0.01
_SUDDEN = 0.01
_AT_REST = 1e-3

# Smallest parting that counts, over the tolerance times the depth.
_HARDLY = 100.0


@dataclass(frozen=True)
class Apart:
    """Relative difference of one quantity, and its two values."""

    what: str
    off: float
    found: float
    true: float

    def __str__(self) -> str:
        return f"{self.what}: {self.found:.8g} for {self.true:.8g} ({self.off:.2g})"


def largest_apart(apart: list[Apart]) -> Apart:
    """Return the largest of the differences."""
    return max(apart, key=lambda one: one.off if one.off == one.off else math.inf)


def apart(case: Case, found: Outcome, true: Outcome, limit: float) -> list[Apart]:
    """Return the differences of all quantities of two outcomes; `limit`: relative tolerance."""
    return [
        *_lesser("peak force", found.peaks, true.peaks),
        *_lesser("impulse", found.impulses, true.impulses),
        *_velocities(case, found.velocities, true),
        *_peak_times(case, found, true, limit),
        *(one for c in range(len(case.contacts)) for one in _times(case, found, true, c, limit)),
    ]


def from_newmark(case: Case, found: Outcome, true: Outcome) -> float:
    """Return the largest difference in peaks, impulses and velocities from Newmark's rule."""
    every = [
        *_lesser("peak force", found.peaks, true.peaks),
        *_lesser("impulse", found.impulses, true.impulses),
        *_velocities(case, found.velocities, true),
    ]
    return max((one.off for one in every), default=0.0)


def _lesser(what: str, found: FloatArray, true: FloatArray) -> list[Apart]:
    known = ~(np.isnan(found) | np.isnan(true))
    size = np.maximum(np.abs(true), _LESSER * np.abs(true[known]).max(initial=0.0))
    return [
        Apart(f"{what} {c}", abs(f - t) / s if s > 0.0 else (math.inf if f else 0.0), f, t)
        for c, (f, t, s) in enumerate(zip(found, true, size, strict=True))
        if known[c]
    ]


def _velocities(case: Case, found: FloatArray, true: Outcome) -> list[Apart]:
    """Return differences of velocities, over the largest or a share of largest impulse/mass."""
    mass = min(body.mass for body in case.bodies if not body.wall)
    rest = _AT_REST * np.abs(true.impulses).max(initial=0.0) / mass
    starts = np.array([body.velocity for body in case.bodies])
    speed = max(rest, np.abs([starts, true.velocities]).max())
    # Velocities at a given time also suffer from the error of the time of the last touch.
    last = max((touch.end for touches in true.touches for touch in touches), default=0.0)
    moved = np.abs(true.accelerations) * last if len(true.accelerations) else 0.0 * starts
    return [
        Apart(f"velocity {i}", abs(f - t) / size if size > 0.0 else 0.0, f, t)
        for i, (f, t, size) in enumerate(zip(found, true.velocities, speed + moved, strict=True))
    ]


def _peak_times(case: Case, found: Outcome, true: Outcome, limit: float) -> list[Apart]:
    """Return differences of peak times; a flat peak is judged by the true force at the time."""
    if true.force_at is None:
        return []
    result = []
    least = _LESSER * float(np.nanmax(true.peaks, initial=0.0))
    for c, (when, peak) in enumerate(zip(found.peak_times, true.peaks, strict=True)):
        if not peak > least:
            continue
        reach = limit * max(case.duration * 0.01, true.peak_times[c])
        there = max(true.force_at(c, when + shift) for shift in (-reach, 0.0, reach))
        late = abs(when - true.peak_times[c]) / max(true.peak_times[c], case.duration * 0.01)
        off = min(max(0.0, float((peak - there) / peak)), float(late))
        result.append(Apart(f"peak time {c}", off, float(when), float(true.peak_times[c])))
    return result


def _times(case: Case, found: Outcome, true: Outcome, c: int, limit: float) -> list[Apart]:
    """Return differences of the start and end of each touch of a contact that counts."""
    touches = true.touches[c]
    largest = max((t.impulse for of in true.touches for t in of), default=0.0)
    own = max((t.impulse for t in touches), default=0.0)
    starts, ends = np.array([(t.start, t.end) for t in found.touches[c]]).reshape(-1, 2).T
    result = []
    for i, touch in enumerate(touches):
        if touch.impulse < _LESSER * max(own, _LESSER * largest) or touch.impulse == 0.0:
            continue
        if not len(starts):
            result.append(Apart(f"touch {c}.{i}", math.inf, math.nan, touch.start))
            continue
        joined = _joined(touches, i - 1, limit) if i else _side_by_side(case, c, touch, limit)
        if touch.pace >= _SUDDEN and touch.start > 0.0 and not joined:
            result.append(_nearest(f"start {c}.{i}", starts, touch.start, touch.end))
        if touch.end < case.duration * (1.0 - limit) and not _joined(touches, i, limit):
            result.append(_nearest(f"end {c}.{i}", ends, touch.end, touch.end))
    return result


def _joined(touches: tuple[Touch, ...], before: int, limit: float) -> bool:
    """Return whether a touch and the next are parted by less than the tolerance."""
    if not 0 <= before < len(touches) - 1:
        return False
    one, other = touches[before], touches[before + 1]
    deep = max(one.deep, other.deep)
    return one.apart < _HARDLY * limit * deep or other.start - one.end < limit * other.end


def _side_by_side(case: Case, c: int, first: Touch, limit: float) -> bool:
    """Return whether a contact without a gap opens by less than the tolerance before it touches.

    The opening is estimated as the rate at the touch times the time until the touch.
    """
    share = first.pace * first.start / (first.end - first.start)
    return case.contacts[c].gap == 0.0 and share < _HARDLY * limit


def _nearest(what: str, times: FloatArray, true: float, size: float) -> Apart:
    found = float(times[np.abs(times - true).argmin()])
    return Apart(what, abs(found - true) / size, found, true)
