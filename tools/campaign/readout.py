"""Peaks, impulses and touches of a run of the oracle, from its steps and its events."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.polynomial import Chebyshev

from .motion import At, Dense, Motion, Phase
from .outcome import FloatArray, Outcome, Touch

# Share of the largest force at its start, middle or end, from which a step is searched for a peak.
_LOOKED_INTO = 0.5

# Degree of the polynomial of the force within a step, in which no event happens; its largest
# relative error, above which the step is halved; and the smallest part of a step.
_DEGREE, _EXACT, _SHORTEST = 12, 1e-9, 1.0 / 64.0


# Time after the start of a touch, over its duration, at which its rate is taken a second time: at
# the start the rate of a massless coordinate jumps.
_SOON = 1e-3


@dataclass
class Step:
    """An accepted step: its dense output from `start` to `end`, in one phase."""

    start: float
    end: float
    dense: Dense
    phase: Phase


@dataclass(frozen=True)
class Mark:
    """Closing or opening of a contact: time, contact, impulse so far and rate."""

    time: float
    contact: int
    impulse: float
    rate: float


class Readout:
    """Results of a run of the oracle."""

    def __init__(self, motion: Motion, steps: Sequence[Step], marks: Sequence[Mark]) -> None:
        self.motion, self.steps, self.marks = motion, steps, marks
        bends = {t for load in motion.case.loads for t in load.times}
        self.bends = np.array(sorted({0.0, motion.case.duration, *bends}))
        self.starts = np.array([step.start for step in steps])
        self.middles = [self.look(step, 0.5 * (step.start + step.end)) for step in steps]

    def look(self, step: Step, t: float) -> At:
        """Return the contacts at a time within a step."""
        i = min(np.searchsorted(self.bends, step.start, side="right"), len(self.bends) - 1)
        self.motion.piece = self.bends[i - 1], self.bends[i]
        return self.motion.look(t, step.dense(t), step.phase)

    def force_at(self, c: int, t: float) -> float:
        """Return the force of a contact at a time, N."""
        t = min(max(t, 0.0), self.motion.case.duration)
        i = max(int(np.searchsorted(self.starts, t, side="right")) - 1, 0)
        return float(self.look(self.steps[i], t).force[c])

    def outcome(self, y: FloatArray) -> Outcome:
        """Return the outcome of the run; `y`: the state at the end of the record."""
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
            tuple(
                self._touches(c, Mark(motion.case.duration, c, float(y[2 * n + c]), 0.0))
                for c in range(motion.count)
            ),
            system.centre @ y[n : 2 * n] + system.wall_speed,
            np.zeros(len(system.wall_speed)) if rates is None else system.centre @ rates,
            self.force_at,
        )

    def _peaks(self) -> tuple[FloatArray, FloatArray]:
        """Return the peak force and its time of each contact, by ends and maxima of all steps."""
        count = self.motion.count
        rough = np.array([self._rough(i) for i in range(len(self.steps))]).reshape(-1, count)
        least = _LOOKED_INTO * rough.max(axis=0, initial=0.0)
        peaks, times = np.zeros(count), np.zeros(count)
        for i, step in enumerate(self.steps):
            looked = [
                c
                for c in range(count)
                if step.phase.closed[c] and (rough[i, c] >= least[c] or self._at_edge(i, c))
            ]
            for t in self._tops(step, looked) if looked and step.end > step.start else ():
                force = self.look(step, t).force
                for c in np.flatnonzero(force > peaks):
                    peaks[c], times[c] = force[c], t
        return peaks, times

    def _rough(self, i: int) -> FloatArray:
        step = self.steps[i]
        ends = [self.look(step, t).force for t in (step.start, step.end)]
        return np.maximum(self.middles[i].force, np.maximum(*ends))

    def _tops(self, step: Step, looked: list[int]) -> list[float]:
        """Return the times of the ends of a step, and of extrema of forces within it."""
        times, parts = [step.start, step.end], [(step.start, step.end)]
        while parts:
            low, high = parts.pop()
            for c in looked:
                of = Chebyshev.interpolate(
                    lambda x, c=c: [self.look(step, float(t)).force[c] for t in x],
                    _DEGREE,
                    domain=[low, high],
                )
                smooth = np.abs(of.coef[-2:]).max() <= _EXACT * np.abs(of.coef).max()
                if not smooth and high - low > _SHORTEST * (step.end - step.start):
                    parts += [(low, 0.5 * (low + high)), (0.5 * (low + high), high)]
                    break
                tops = of.deriv().roots()
                times += [t.real for t in tops if t.imag == 0.0 and low < t.real < high]
            times.append(high)
        return times

    def _at_edge(self, i: int, c: int) -> bool:
        """Return whether a touch begins or ends at a step's start or end."""
        neighbours = [j for j in (i - 1, i + 1) if 0 <= j < len(self.steps)]
        return len(neighbours) < 2 or any(not self.steps[j].phase.closed[c] for j in neighbours)

    def _touches(self, c: int, end: Mark) -> tuple[Touch, ...]:
        """Return the touches of a contact, whose marks alternate; `end`: that of the record."""
        marks = [*(mark for mark in self.marks if mark.contact == c), end, end]
        return tuple(self._touch(*marks[i : i + 3]) for i in range(0, len(marks) - 2, 2))

    def _touch(self, start: Mark, end: Mark, following: Mark) -> Touch:
        """Return the touch between two marks; `following`: the end of the bodies' separation."""
        c, length = start.contact, end.time - start.time
        deep = max(self._depths(c, start.time, end.time), default=0.0)
        apart = -min(self._depths(c, end.time, following.time), default=0.0)
        soon = min(start.time + _SOON * length, end.time)
        i = max(int(np.searchsorted(self.starts, soon, side="right")) - 1, 0)
        after = float(self.look(self.steps[i], soon).depth[c])
        pace = min(abs(start.rate) * length, abs(after) / _SOON) / deep if deep > 0.0 else 0.0
        return Touch(start.time, end.time, end.impulse - start.impulse, pace, deep, apart)

    def _depths(self, c: int, start: float, end: float) -> list[float]:
        """Return the indentations in the middles of the steps between two times."""
        first = int(np.searchsorted(self.starts, start, side="left"))
        last = max(int(np.searchsorted(self.starts, end, side="left")), first + 1)
        return [float(at.depth[c]) for at in self.middles[first:last]]
