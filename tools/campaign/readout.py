"""Peaks, impulses and touches of a run of the oracle, from its steps and what happened between
them.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from .motion import At, Dense, Motion, Phase
from .outcome import Outcome, Touch

FloatArray = npt.NDArray[np.float64]

# Samples of the force within a step, and the share of the largest at the ends of steps from which a
# step is looked into.
_SAMPLES, _LOOKED_INTO = 6, 0.5


@dataclass
class Step:
    """A step that was accepted: dense output from start to end in one phase."""

    start: float
    end: float
    dense: Dense
    phase: Phase


@dataclass(frozen=True)
class Mark:
    """A contact closes or opens: when, which, the impulse so far and the rate."""

    time: float
    contact: int
    closes: bool
    impulse: float
    rate: float


class Readout:
    """What a run gives."""

    def __init__(self, motion: Motion, steps: Sequence[Step], marks: Sequence[Mark]) -> None:
        self.motion, self.steps, self.marks = motion, steps, marks
        self.bends = sorted({0.0, *(t for load in motion.case.loads for t in load.times)})
        self.starts = np.array([step.start for step in steps])
        self.middles = [self.look(step, 0.5 * (step.start + step.end)) for step in steps]

    def look(self, step: Step, t: float) -> At:
        """The contacts at a time within a step."""
        self.motion.piece = max(bend for bend in self.bends if bend <= step.start)
        return self.motion.look(t, step.dense(t), step.phase, rates=bool(step.phase.own) or True)

    def force_at(self, c: int, t: float) -> float:
        """Force of a contact at a time, N."""
        t = min(max(t, 0.0), self.motion.case.duration)
        i = max(int(np.searchsorted(self.starts, t, side="right")) - 1, 0)
        return float(self.look(self.steps[i], t).force[c])

    def outcome(self, y: FloatArray) -> Outcome:
        """All of it; y: the state at the end of the record."""
        motion, system = self.motion, self.motion.system
        n, last = system.n, self.steps[-1]
        at = self.look(last, motion.case.duration)
        rates = (
            motion.slope(y, at)[n : 2 * n]
            if len(at.flow) == len(y) - 2 * n - motion.count
            else None
        )
        peaks, times = self._peaks()
        return Outcome(
            peaks,
            times,
            y[2 * n : 2 * n + motion.count].copy(),
            self._touches(y),
            system.centre @ y[n : 2 * n] + system.wall_speed,
            np.zeros(len(system.wall_speed)) if rates is None else system.centre @ rates,
            self.force_at,
            system.fastest,
        )

    def _peaks(self) -> tuple[FloatArray, FloatArray]:
        """Largest force of each contact, and when."""
        count = self.motion.count
        middle = np.array([at.force for at in self.middles]).reshape(-1, count)
        largest = middle.max(axis=0, initial=0.0)
        peaks, times, around = np.zeros(count), np.zeros(count), np.zeros(count)
        for i, step in enumerate(self.steps):
            wanted = [
                c
                for c in range(count)
                if step.phase.closed[c] and middle[i, c] >= _LOOKED_INTO * largest[c]
            ]
            # The first and last step of a touch may have its peak at one end.
            edge = [c for c in range(count) if step.phase.closed[c] and self._at_edge(i, c)]
            if not wanted and not edge:
                continue
            h = step.end - step.start
            for share in np.linspace(0.0, 1.0, _SAMPLES + 1):
                t = step.start + share * h
                force = self.look(step, t).force
                for c in np.flatnonzero(force > peaks):
                    peaks[c], times[c], around[c] = force[c], t, h / _SAMPLES
        for c in np.flatnonzero(peaks > 0.0):
            low = max(times[c] - 2.0 * around[c], 0.0)
            high = min(times[c] + 2.0 * around[c], self.motion.case.duration)
            when, top = _largest(lambda t, i=int(c): self.force_at(i, t), low, high)
            if top > peaks[c]:
                peaks[c], times[c] = top, when
        return peaks, times

    def _at_edge(self, i: int, c: int) -> bool:
        neighbours = [j for j in (i - 1, i + 1) if 0 <= j < len(self.steps)]
        return len(neighbours) < 2 or any(not self.steps[j].phase.closed[c] for j in neighbours)

    def _touches(self, y: FloatArray) -> tuple[tuple[Touch, ...], ...]:
        motion = self.motion
        found: list[list[Touch]] = [[] for _ in range(motion.count)]
        open_: dict[int, Mark] = {}
        first = 2 * motion.system.n
        ends = [
            Mark(motion.case.duration, c, False, float(y[first + c]), 0.0)
            for c in range(motion.count)
        ]
        for mark in [*self.marks, *ends]:
            if mark.closes:
                open_[mark.contact] = mark
            elif mark.contact in open_:
                found[mark.contact].append(self._touch(open_.pop(mark.contact), mark))
        return tuple(self._parted(c, of) for c, of in enumerate(found))

    def _touch(self, start: Mark, end: Mark) -> Touch:
        deep = max(self._depths(start.contact, start.time, end.time), default=0.0)
        length = end.time - start.time
        pace = abs(start.rate) * length / deep if deep > 0.0 else 0.0
        return Touch(start.time, end.time, end.impulse - start.impulse, pace, deep)

    def _parted(self, c: int, touches: list[Touch]) -> tuple[Touch, ...]:
        """The touches with how far the bodies part after each."""
        starts = [*(touch.start for touch in touches[1:]), self.motion.case.duration]
        parted = []
        for touch, start in zip(touches, starts, strict=False):
            apart = -min(self._depths(c, touch.end, start), default=0.0)
            of = (touch.start, touch.end, touch.impulse, touch.pace, touch.deep)
            parted.append(Touch(*of, apart))
        return tuple(parted)

    def _depths(self, c: int, start: float, end: float) -> list[float]:
        """Indentations in the middles of the steps between two times."""
        first = int(np.searchsorted(self.starts, start, side="left"))
        last = max(int(np.searchsorted(self.starts, end, side="left")), first + 1)
        return [float(at.depth[c]) for at in self.middles[first:last]]


def _largest(value: Callable[[float], float], low: float, high: float) -> tuple[float, float]:
    """Where a function with one top between two ends is largest, and how large: golden section."""
    share = 0.5 * (math.sqrt(5.0) - 1.0)
    a, b = high - share * (high - low), low + share * (high - low)
    at_a, at_b = value(a), value(b)
    for _ in range(40):
        if at_a > at_b:
            high, b, at_b = b, a, at_a
            a = high - share * (high - low)
            at_a = value(a)
        else:
            low, a, at_a = a, b, at_b
            b = low + share * (high - low)
            at_b = value(b)
    top, when = max((value(low), low), (value(high), high), (at_a, a), (at_b, b))
    return when, top
