"""How far two outcomes are apart in what a tolerance promises, as `Adaptive` documents it.

Peak force and impulse are those of each contact over the record, of one that has less than a
hundredth of the largest contact's relative to that hundredth; a peak that no run resolves (NaN) is
left out. Touches start and end at times that are right relative to the end's own time; those that
have less than a hundredth of their contact's largest impulse do not count, nor do starts at no
certain time, of bodies side by side that are hardly pressed, nor a parting of less than the
tolerance. Velocities are those of the centres of mass, relative to the largest.
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

# A parting of less than so many tolerances of the depth counts as none.
_HARDLY = 100.0


@dataclass(frozen=True)
class Apart:
    """One quantity: by how much it is off, relative, and the two values."""

    what: str
    off: float
    found: float
    true: float

    def __str__(self) -> str:
        return f"{self.what}: {self.found:.8g} for {self.true:.8g} ({self.off:.2g})"


def largest_apart(apart: list[Apart]) -> Apart:
    """The worst of them."""
    return max(apart, key=lambda one: one.off if one.off == one.off else math.inf)


def apart(case: Case, found: Outcome, true: Outcome, limit: float) -> list[Apart]:
    """Return all quantities of two outcomes; `limit` is what is looked for."""
    return [
        *_lesser("peak force", found.peaks, true.peaks),
        *_lesser("impulse", found.impulses, true.impulses),
        *_velocities(case, found.velocities, true),
        *_peak_times(case, found, true, limit),
        *(one for c in range(len(case.contacts)) for one in _times(case, found, true, c, limit)),
    ]


def from_newmark(case: Case, found: Outcome, true: Outcome) -> float:
    """How far peaks, impulses and velocities are apart, of two ways of which one is Newmark's."""
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
    """Relative to the largest; of bodies that rest, to a share of what contacts would give them."""
    mass = min(body.mass for body in case.bodies if not body.wall)
    rest = _AT_REST * np.abs(true.impulses).max(initial=0.0) / mass
    starts = np.array([body.velocity for body in case.bodies])
    speed = max(rest, np.abs([starts, true.velocities]).max())
    # At a given time velocities suffer from the error of when the last touch was as well.
    last = max((touch.end for touches in true.touches for touch in touches), default=0.0)
    moved = np.abs(true.accelerations) * last if len(true.accelerations) else 0.0 * starts
    return [
        Apart(f"velocity {i}", abs(f - t) / size if size > 0.0 else 0.0, f, t)
        for i, (f, t, size) in enumerate(zip(found, true.velocities, speed + moved, strict=True))
    ]


def _peak_times(case: Case, found: Outcome, true: Outcome, limit: float) -> list[Apart]:
    """A peak may be flat: what counts is that the force at that time is the peak."""
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
    """Starts and ends of the touches of a contact that count."""
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
    """Whether a touch and the next are parted by less than the tolerance."""
    if not 0 <= before < len(touches) - 1:
        return False
    one, other = touches[before], touches[before + 1]
    deep = max(one.deep, other.deep)
    return one.apart < _HARDLY * limit * deep or other.start - one.end < limit * other.end


def _side_by_side(case: Case, c: int, first: Touch, limit: float) -> bool:
    """Whether a contact that begins with no gap opens by less than the tolerance before it touches.

    By at most its rate at the touch times the time until then, unless it was faster before.
    """
    share = first.pace * first.start / (first.end - first.start)
    return case.contacts[c].gap == 0.0 and share < _HARDLY * limit


def _nearest(what: str, times: FloatArray, true: float, size: float) -> Apart:
    found = float(times[np.abs(times - true).argmin()])
    return Apart(what, abs(found - true) / size, found, true)
