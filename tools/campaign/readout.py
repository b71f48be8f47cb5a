"""Peaks, impulses and touches of a run of the oracle, from its steps and what happened between
them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from numpy.polynomial import chebyshev

from .motion import At, Dense, Motion, Phase
from .outcome import Outcome, Touch

FloatArray = npt.NDArray[np.float64]

# A step is looked into if its start, middle or end has this share of the largest force.
_LOOKED_INTO = 0.5

# Within a step nothing begins or ends, so the force is smooth: its polynomial of one of these
# degrees is it but for this share, or that of a part of the step of at least that share.
_DEGREES, _EXACT, _SHORTEST = (8, 16), 1e-9, 1.0 / 64.0


# When a touch's rate is looked at again, as a share of its length: at its start the rate of a
# massless coordinate jumps.
_SOON = 1e-3


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
        """Largest force of each contact, and when: of every step's ends and tops within it."""
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
            for t in self._tops(step, looked) if looked else ():
                force = self.look(step, t).force
                for c in np.flatnonzero(force > peaks):
                    peaks[c], times[c] = force[c], t
        return peaks, times

    def _rough(self, i: int) -> FloatArray:
        step = self.steps[i]
        ends = [self.look(step, t).force for t in (step.start, step.end)]
        return np.maximum(self.middles[i].force, np.maximum(*ends))

    def _tops(self, step: Step, looked: list[int]) -> list[float]:
        """Times of the ends of a step, and of where a force is largest within it."""
        times, parts = [step.start, step.end], [(step.start, step.end)]
        while parts:
            low, high = parts.pop()
            middle, half = 0.5 * (low + high), 0.5 * (high - low)
            for degree in _DEGREES:
                x = np.cos(np.pi * np.arange(degree + 1) / degree)
                force = np.array([self.look(step, middle + half * one).force[looked] for one in x])
                of = chebyshev.chebfit(x, force, degree)
                smooth = np.abs(of[-2:]).max(axis=0) <= _EXACT * np.abs(force).max(axis=0)
                if smooth.all():
                    break
            else:
                if high - low > _SHORTEST * (step.end - step.start):
                    parts += [(low, middle), (middle, high)]
                    continue
            for column in of.T:
                roots = chebyshev.chebroots(chebyshev.chebder(column))
                inside = roots.real[(np.abs(roots.imag) < 1e-6) & (np.abs(roots.real) < 1.0)]
                times += list(middle + half * inside)
            times.append(high)
        return times

    def _at_edge(self, i: int, c: int) -> bool:
        """Whether a touch begins or ends beside a step."""
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
        soon = min(start.time + _SOON * length, end.time)
        i = max(int(np.searchsorted(self.starts, soon, side="right")) - 1, 0)
        after = float(self.look(self.steps[i], soon).depth[start.contact])
        pace = min(abs(start.rate) * length, abs(after) / _SOON) / deep if deep > 0.0 else 0.0
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
