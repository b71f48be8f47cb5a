"""The plain formulation: SciPy's integrators on the equations of motion, piece by piece.

What it assumes. A massless contact coordinate is at each instant in balance with its springs, its
load and the contact forces on it: an algebraic equation, solved whenever the right-hand side is
asked for. Where a closed contact with a dashpot acts on it, the balance gives its velocity instead,
and its deflection w = u - u_free is a variable; a dashpot that relaxes w in a millionth of a
millionth of the record keeps that equation regular where the contact's own vanishes. A contact
closes at the deflection that the coordinate has; where a load sets in, at the touch. So nothing is
lost when a contact closes on it, or when it lets go at no force. A law that pulls lets go at a
force: then the coordinate springs back at once, and what its springs had stored is lost.

Pieces end where a contact closes, lets go, yields or turns back, and where a load bends. An event
is found on the dense output of a step, from samples no farther apart than a sixth of it, and the
step is then made again up to there.
"""

from __future__ import annotations

import math
import time as clock
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy.integrate import DOP853, Radau
from scipy.optimize import brentq

from . import massless
from .case import Case
from .formulas import Formula, Thornton
from .motion import LAG, At, Dense, Motion, Phase, share
from .outcome import Outcome
from .readout import Mark, Readout, Step
from .rest import rest

FloatArray = npt.NDArray[np.float64]

# Samples within a step for events.
_SAMPLES = 6

# Contacts close, and open, by this share of the depth that is usual after the touch: no rounding
# does it for them.
_HYSTERESIS = 1e-13

# The implicit integrator's order leaves it no tighter tolerance.
_TIGHTEST_IMPLICIT = 1e-10

# Of its first step: its estimate does not show what relaxes within one, such as the coordinate
# after a touch where the law's dashpot has no force yet.
_RELAXING = 1e-4

# Flips of a contact at one instant after which it is left alone for a moment, as a share of the
# record.
_MOST_FLIPS, _MOMENT = 3, 1e-11


class GaveUpError(Exception):
    """The oracle has no answer: too slow, or an equation without a solution."""


class Oracle:
    """One scene.

    Parameters
    ----------
    case : Case
    rtol : float, optional
        Of the integrators, relative to what is usual in the scene.
    longest : float, optional
        s of the processor.
    nudge : ndarray, optional
        Relative change of coordinates and velocities at the start.
    lag : float, optional
        Of the dashpot on what has no mass, as a share of the record.
    """

    def __init__(
        self,
        case: Case,
        rtol: float = 1e-11,
        longest: float = 30.0,
        nudge: FloatArray | None = None,
        lag: float = LAG,
    ) -> None:
        self.case, self.rtol, self.longest, self.nudge = case, rtol, longest, nudge
        self.motion = Motion(case, lag)
        self.laws = self.motion.laws
        self._deadline, self._end = math.inf, case.duration
        self.steps: list[Step] = []
        self.marks: list[Mark] = []
        self._quiet_until: dict[int, float] = {}
        self._flips: dict[int, tuple[float, int]] = {}
        self._held = np.zeros(len(case.contacts))  # by dashpots when a load sets in

    def run(self) -> Outcome:
        """Integrate the record.

        Raises
        ------
        GaveUpError
            If it takes longer than `longest` s of the processor, or an integrator gives up.
        NoRestError
            If a start from rest has none.
        """
        self._deadline = clock.process_time() + self.longest
        case, motion = self.case, self.motion
        with np.errstate(all="ignore"):
            y, closed = self._begin()
            bends = {t for load in case.loads for t in load.times if 0.0 < t < case.duration}
            t = 0.0
            for end in [*sorted(bends), case.duration]:
                motion.piece, self._end = t, end
                t, y = self._piece(t, y, closed, end)
            found = Readout(motion, self.steps, self.marks).outcome(y)
        more = self._held > found.peaks
        deep = motion.length
        vanish = [law.at(1e-30 * deep)[2] < 0.5 * law.at(deep)[2] for law in self.laws]
        # A dashpot that has no force at the touch loses a load within no time that a run resolves.
        first = np.where(vanish, np.nan, self._held)
        return replace(
            found,
            peaks=np.where(more, first, found.peaks),
            peak_times=np.where(more, 0.0, found.peak_times),
        )

    # --------------------------------------------------------------- the start

    def _begin(self) -> tuple[FloatArray, list[bool]]:
        motion, case, n = self.motion, self.case, self.motion.system.n
        y = np.zeros(2 * n + motion.count)
        y[: 2 * n] = motion.system.start
        closed = [False] * motion.count
        if case.preload:
            self._rest(y, closed)
        else:
            self._set_in(y, closed)
        if self.nudge is not None:
            y[: 2 * n] *= 1.0 + self.nudge[: 2 * n]
        self.marks += [Mark(0.0, c, True, 0.0, 0.0) for c in range(motion.count) if closed[c]]
        return y, closed

    def _rest(self, y: FloatArray, closed: list[bool]) -> None:
        """Put the bodies where they rest under the loads of the start."""
        motion, case, system = self.motion, self.case, self.motion.system
        load = motion.loads(0.0)[0]
        places, depth = rest(case, self.laws, load)
        bodies = [
            place[1:] if body.massless else place
            for body, place in zip(case.bodies, places, strict=True)
            if not body.wall
        ]
        y[: system.n] = np.concatenate(bodies)
        for c, law in enumerate(self.laws):
            closed[c] = bool(depth[c] > _HYSTERESIS * motion.length)
            if isinstance(law, Thornton):
                law.remember(float(depth[c]))
        free = system.port[: motion.ports] @ y[: 2 * system.n] + system.residual * load
        for i, body in enumerate(case.bodies):
            port = system.first_port[i]
            if body.massless:
                motion.warm[port] = places[i][0] - free[port]

    def _set_in(self, y: FloatArray, closed: list[bool]) -> None:
        """Loads that set in move what has no mass at once, up to the first dashpot in its way."""
        motion, system = self.motion, self.motion.system
        load = motion.loads(0.0)[0]
        ports = tuple(int(p) for p in np.flatnonzero(system.residual * load))
        if not ports:
            return
        place = system.port[: motion.ports] @ y[: 2 * system.n] + system.residual * load
        w = motion.warm
        elastic = {
            c: (law, self.case.contacts[c].gap)
            for c, law in enumerate(self.laws)
            if not law.viscous and set(motion.ends[c]) & set(ports)
        }
        sizes = motion.length, motion.push
        massless.balance(place, w, ports, elastic, motion.ends, motion.spring, sizes)
        for c, law in enumerate(self.laws):
            met = [end for end in zip(motion.ends[c], (1.0, -1.0), strict=True) if end[0] in ports]
            over = float((system.sides @ (place + w) - system.gaps)[c])
            if law.viscous and met and over > 0.0:
                port, sign = met[0]
                w[port] -= sign * over
                for other in range(motion.count):  # met later
                    closed[other] = closed[other] and port not in motion.ends[other]
                closed[c] = True
        depth = system.sides @ (place + w) - system.gaps
        for c in np.flatnonzero(closed):
            port, sign = next(
                end for end in zip(motion.ends[c], (1.0, -1.0), strict=True) if end[0] in ports
            )
            pushes = np.zeros(motion.count)
            for e, (law, _) in elastic.items():
                pushes[e] = law.at(float(depth[e]))[0]
            self._held[c] = -sign * (motion.spring[port] * w[port] + system.sides[:, port] @ pushes)

    # --------------------------------------------------------------- phases and events

    def _phase(self, closed: list[bool]) -> Phase:
        own, touched = set(), set()
        for c in np.flatnonzero(closed):
            ends = [p for p in self.motion.ends[c] if self.motion.system.residual[p] > 0.0]
            touched.update(ends)
            if self.laws[c].viscous:
                own.update(ends)
        plastic = tuple(
            (law.plastic, law.deepest, law.rest) if isinstance(law, Thornton) else (False, 0.0, 0.0)
            for law in self.laws
        )
        return Phase(tuple(closed), plastic, tuple(sorted(own)), tuple(sorted(touched - own)))

    def _events(self, at: At, phase: Phase) -> FloatArray:
        """Of each contact a number that turns negative where its phase ends."""
        left = np.ones(self.motion.count)
        for c, law in enumerate(self.laws):
            depth, rate = float(at.depth[c]), float(at.rate[c])
            left[c] = (
                self._opening(c, law, depth, rate, phase)
                if phase.closed[c]
                else (self._closing(law, depth, rate))
            )
        return left

    def _closing(self, law: Formula, depth: float, rate: float) -> float:
        above = _HYSTERESIS - (depth - law.rest) / self.motion.length
        if law.viscous and not law.pulls and above < 0.0:
            return max(above, _HYSTERESIS - share(law, depth, rate))
        return above

    def _opening(self, c: int, law: Formula, depth: float, rate: float, phase: Phase) -> float:
        """For a plastic contact also where it yields or turns back."""
        above = (depth - law.rest) / self.motion.length + _HYSTERESIS
        if isinstance(law, Thornton):
            law.plastic, law.deepest, law.rest = phase.plastic[c]
            if law.plastic:
                return rate / self.motion.speed + _HYSTERESIS
            return min(above, (law.limit - depth) / self.motion.length + _HYSTERESIS)
        if law.viscous and not law.pulls:
            return min(above, share(law, depth, rate) + _HYSTERESIS)
        return above

    def _switch(self, c: int, at: At, closed: list[bool]) -> None:
        """Contact c goes into its next phase."""
        law, depth = self.laws[c], float(at.depth[c])
        if isinstance(law, Thornton) and closed[c]:
            if law.plastic:
                law.remember(depth)
                law.plastic = False
                return
            if depth >= law.limit and depth > law.rest:
                law.plastic = True
                return
        closed[c] = not closed[c]

    def _quiet(self, one: At, other: At, h: float, phase: Phase) -> bool:
        """Whether no contact can have had an event between two states a step apart."""
        for c, law in enumerate(self.laws):
            depths = one.depth[c] - law.rest, other.depth[c] - law.rest
            rates = float(one.rate[c]), float(other.rate[c])
            if isinstance(law, Thornton) and phase.closed[c]:
                return False
            reach = 2.0 * h * max(map(abs, rates))
            inside = depths[0] > 0.0
            if inside != (depths[1] > 0.0) or min(map(abs, depths)) <= reach:
                return False
            if inside != phase.closed[c]:  # by less than the hysteresis, until now
                return False
            if law.viscous and not law.pulls and inside:
                shares = [share(law, d, v) for d, v in zip(depths, rates, strict=True)]
                if not phase.closed[c] or min(shares) < 0.5:
                    return False
        return True

    # --------------------------------------------------------------- pieces

    def _piece(
        self, t: float, y: FloatArray, closed: list[bool], end: float
    ) -> tuple[float, FloatArray]:
        """Integrate with smooth loads up to `end`."""
        motion = self.motion
        phase = self._phase(closed)
        y = self._widened(y, phase, motion.warm)
        while t < end:
            t, y, found = self._advance(t, y, phase, end)
            at = motion.look(t, y, phase)
            motion.warm = at.deflection.copy()
            if not found:
                continue
            for c in found:
                before = closed[c]
                self._switch(c, at, closed)
                if closed[c] != before:
                    impulse = float(y[2 * motion.system.n + c])
                    self.marks.append(Mark(t, c, closed[c], impulse, float(at.rate[c])))
                self._count_flip(c, t)
            phase = self._phase(closed)
            y = self._widened(y, phase, at.deflection)
        return t, y

    def _widened(self, y: FloatArray, phase: Phase, deflection: FloatArray) -> FloatArray:
        """The state with the deflections that the phase has of its own."""
        base = y[: 2 * self.motion.system.n + self.motion.count]
        return np.concatenate([base, deflection[list(phase.own)]])

    def _count_flip(self, c: int, t: float) -> None:
        last, many = self._flips.get(c, (-1.0, 0))
        many = many + 1 if t - last <= 1e-13 * self.case.duration else 0
        self._flips[c] = (t, many)
        if many > _MOST_FLIPS:
            self._quiet_until[c] = t + _MOMENT * self.case.duration

    def _rhs(self, phase: Phase) -> Callable[[float, FloatArray], FloatArray]:
        motion = self.motion

        def rhs(t: float, y: FloatArray) -> FloatArray:
            if clock.process_time() > self._deadline:
                raise GaveUpError("too slow")
            return motion.slope(y, motion.look(t, y, phase, rates=False))

        return rhs

    def _integrator(self, t: float, y: FloatArray, phase: Phase, end: float) -> Any:
        motion = self.motion
        # A force that begins like t^1.5 is no polynomial: a long first step would not notice.
        fast = 1e-2 / (motion.system.fastest + 1e-99)
        first = min(end - t, 1e-4 * motion.length / motion.speed, fast)
        rhs, sizes = self._rhs(phase), motion.sizes(phase)
        if phase.own:
            rtol = max(self.rtol, _TIGHTEST_IMPLICIT)
            atol = rtol * sizes
            return Radau(rhs, t, y, end, rtol=rtol, atol=atol, first_step=_RELAXING * first)
        rtol = max(self.rtol, 3e-14)
        return DOP853(rhs, t, y, end, rtol=rtol, atol=rtol * sizes, first_step=first)

    def _advance(
        self, t: float, y: FloatArray, phase: Phase, end: float
    ) -> tuple[float, FloatArray, list[int]]:
        """Go on to the next event, or to `end`."""
        try:
            solver = self._integrator(t, y, phase, end)
            at = self.motion.look(t, y, phase)
            soon = self._happened(self._events(at, phase), t)
            if soon:
                return t, y, soon
            while True:
                start, y_start = solver.t, solver.y.copy()
                message = solver.step()
                if solver.status == "failed":
                    raise GaveUpError(f"integrator: {message}")
                if phase.own:  # its differences by what moves nothing grow until they overflow
                    np.minimum(solver.jac_factor, 1.0, out=solver.jac_factor)
                dense = solver.dense_output()
                before, at = at, self.motion.look(solver.t, solver.y, phase)
                if not self._quiet(before, at, solver.t - start, phase):
                    found = self._first_event(start, solver.t, dense, phase)
                    if found is not None:
                        when, y, which = self._refined(start, y_start, found, dense, phase)
                        self.steps.append(Step(start, when, dense, phase))
                        return when, y, which
                self.steps.append(Step(start, solver.t, dense, phase))
                if solver.status == "finished":
                    return solver.t, solver.y, []
        except (ValueError, np.linalg.LinAlgError, OverflowError) as error:
            raise GaveUpError(f"integrator: {error}") from error

    def _happened(self, left: FloatArray, t: float) -> list[int]:
        return [
            int(c) for c in np.flatnonzero(left < 0.0) if self._quiet_until.get(int(c), -1.0) < t
        ]

    def _first_event(
        self, start: float, end: float, dense: Dense, phase: Phase
    ) -> tuple[float, list[int]] | None:
        """Time of the first event within a step and the contacts that have it."""
        last = start
        for t in np.linspace(start, end, _SAMPLES + 1)[1:]:
            changed = self._happened(self._left(t, dense, phase), float(t))
            if changed:
                times = {c: self._root(c, last, float(t), dense, phase) for c in changed}
                first = min(times.values())
                same = 1e-14 * self.case.duration
                return first, [c for c in changed if times[c] <= first + same]
            last = float(t)
        return None

    def _left(self, t: float, dense: Dense, phase: Phase) -> FloatArray:
        return self._events(self.motion.look(t, dense(t), phase), phase)

    def _root(self, c: int, low: float, high: float, dense: Dense, phase: Phase) -> float:
        def value(t: float) -> float:
            return float(self._left(t, dense, phase)[c])

        if value(low) <= 0.0:
            return low
        return float(brentq(value, low, high, xtol=1e-15 * self.case.duration, rtol=1e-15))

    def _refined(
        self,
        start: float,
        y: FloatArray,
        found: tuple[float, list[int]],
        dense: Dense,
        phase: Phase,
    ) -> tuple[float, FloatArray, list[int]]:
        """The event on the solution itself: the step is made again up to it."""
        (when, which), state, reached = found, y, start
        c, least = which[0], 1e-15 * self.case.duration
        for _ in range(6):
            if when <= start:
                return start, y, which
            solver = self._integrator(start, y, phase, when)
            while solver.status == "running":
                solver.step()
            state, reached = solver.y.copy(), when
            here = float(self._events(self.motion.look(when, state, phase), phase)[c])
            if -1e-12 <= here <= 0.0:
                break
            eta = 1e-4 * (when - start)
            slope = float(
                self._left(when, dense, phase)[c] - self._left(when - eta, dense, phase)[c]
            )
            if not slope < 0.0:
                break
            moved = here * eta / -slope + least
            if abs(moved) <= least:
                break
            when = min(max(when + moved, start), start + 2.0 * (when - start), self._end)
        return reached, state, which
