"""The oracle: SciPy's integrators on the plain equations of motion, piece by piece.

Assumptions: a massless contact coordinate is at each instant in balance with its springs, its load
and the contact forces on it. This algebraic equation is solved at each evaluation of the right-hand
side. If a closed contact with a dashpot acts on the coordinate, the balance gives its velocity, and
its deflection w = u - u_free is a state variable; another dashpot, with a relaxation time of 1e-12
of the record, keeps this equation regular where the contact's dashpot vanishes. A contact closes at
the current deflection of the coordinate, or at the touch when a load sets in, so that no energy is
lost when it closes, or opens at zero force. A law that pulls opens at a force: the coordinate then
springs back at once, and the energy of its springs is lost.

Pieces end where a contact closes, opens, yields or turns back, and where the slope of a load
changes. An event is found on the dense output of a step.
"""

from __future__ import annotations

import math
import time as clock
from collections.abc import Callable
from dataclasses import replace

import numpy as np
from scipy.integrate import DOP853, Radau
from scipy.optimize import brentq

from .case import Case
from .formulas import Thornton
from .motion import LAG, At, Motion, Phase, share
from .outcome import FloatArray, Outcome
from .readout import Mark, Readout, Step
from .rest import rest

# Longest step over the record: events are looked for at the ends of steps.
_LONGEST = 0.01

# Distance past the touch, over the typical depth, at which contacts close or open, so that rounding
# does not switch them.
_HYSTERESIS = 1e-13

# Tightest tolerance of the implicit integrator, whose order is low.
_TIGHTEST_IMPLICIT = 1e-10

# Factor on the first step of the implicit integrator: its error estimate misses what relaxes within
# a step, such as the coordinate after a touch, where the law's dashpot has no force yet.
_RELAXING = 1e-4

# Number of flips of a contact at one instant after which it may not flip, and the time for which it
# may not, over the record.
_MOST_FLIPS, _MOMENT = 3, 1e-11


class GaveUpError(Exception):
    """The oracle has no answer: too slow, or an equation without a solution."""


class Oracle:
    """Independent solution of one scene.

    Parameters
    ----------
    case : Case
    rtol : float, optional
        Tolerance of the integrators, relative to the typical sizes of the scene.
    longest : float, optional
        Maximum processor time, s.
    nudge : ndarray, optional
        Relative change of the initial coordinates and velocities.
    lag : float, optional
        Relaxation time of the dashpot on massless coordinates, over the record.
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
        self._deadline = math.inf
        self.steps = list[Step]()
        self.marks = list[Mark]()
        self._quiet_until = np.full(len(case.contacts), -1.0)
        self._flips = {}
        self._held = np.zeros(len(case.contacts))  # dashpot forces as a load sets in at t = 0, N

    def run(self) -> Outcome:
        """Integrate the record.

        Raises
        ------
        GaveUpError
            If it takes more processor time than `longest`, or an integrator gives up.
        NoRestError
            If there is no state of rest to start from.
        """
        self._deadline = clock.process_time() + self.longest
        case, motion = self.case, self.motion
        with np.errstate(all="ignore"):
            y, closed = self._begin()
            bends = {t for load in case.loads for t in load.times if 0.0 < t < case.duration}
            t = 0.0
            for end in [*sorted(bends), case.duration]:
                motion.piece = t, end
                t, y = self._piece(t, y, closed, end)
            found = Readout(motion, self.steps, self.marks).outcome(y)
        more = self._held > found.peaks
        deep = motion.length
        vanish = [law.at(1e-30 * deep)[2] < 0.5 * law.at(deep)[2] for law in self.laws]
        # A damping coefficient that vanishes at indentation 0 lets this force decay faster than any
        # run resolves: no peak is compared.
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
        self.marks += [Mark(0.0, c, 0.0, 0.0) for c in range(motion.count) if closed[c]]
        return y, closed

    def _rest(self, y: FloatArray, closed: list[bool]) -> None:
        """Set the state of rest under the initial loads, in place."""
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
        """Move massless coordinates at once under initial loads, up to the first dashpot."""
        motion, system = self.motion, self.motion.system
        load = motion.loads(0.0)[0]
        ports = np.flatnonzero(system.residual * load).tolist()
        if not ports:
            return
        place = system.port[: motion.ports] @ y[: 2 * system.n] + system.residual * load
        w, met = motion.warm, system.sides[:, ports].any(axis=1)
        elastic = [c for c, law in enumerate(self.laws) if met[c] and not law.viscous]
        motion.balance(place, w, ports, elastic)
        hit = {}  # the last contact that stops each port
        for c, law in enumerate(self.laws):
            over = float((system.sides @ (place + w) - system.gaps)[c])
            if law.viscous and met[c] and over > 0.0:
                port = max(ports, key=lambda p: system.sides[c, p] or -2.0)  # the first body's
                w[port] -= system.sides[c, port] * over
                hit = {p: e for p, e in hit.items() if not system.sides[e, port]}
                hit[int(port)] = c
        depth = system.sides @ (place + w) - system.gaps
        pushes = np.zeros(motion.count)
        for c in elastic:
            pushes[c] = self.laws[c].at(float(depth[c]))[0]
        for port, c in hit.items():
            closed[c] = True
            held = motion.spring[port] * w[port] + system.sides[:, port] @ pushes
            self._held[c] = -system.sides[c, port] * held

    # --------------------------------------------------------------- phases and events

    def _phase(self, closed: list[bool]) -> Phase:
        own, touched = set(), set()
        for c in np.flatnonzero(closed):
            system = self.motion.system
            ends = np.flatnonzero(system.sides[c] * system.residual).tolist()
            touched.update(ends)
            if self.laws[c].viscous:
                own.update(ends)
        plastic = tuple(
            (law.plastic, law.deepest, law.rest) if isinstance(law, Thornton) else (False, 0.0, 0.0)
            for law in self.laws
        )
        return Phase(tuple(closed), plastic, tuple(sorted(own)), tuple(sorted(touched - own)))

    def _events(self, t: float, at: At, phase: Phase) -> FloatArray:
        """Return a number for each contact, which turns negative where its phase ends."""
        left = np.ones(self.motion.count)
        for c in np.flatnonzero(self._quiet_until < t):
            law, closed, rate = self.laws[c], phase.closed[c], float(at.rate[c])
            if isinstance(law, Thornton) and closed:
                law.plastic, law.deepest, law.rest = phase.plastic[c]
            depth, length = float(at.depth[c]), self.motion.length
            sense = 1.0 if closed else -1.0
            left[c] = sense * (depth - law.rest) / length + _HYSTERESIS
            if law.viscous and not law.pulls and (closed or left[c] < 0.0):
                pushes = sense * share(law, depth, rate) + _HYSTERESIS
                left[c] = min(left[c], pushes) if closed else max(left[c], pushes)
            if isinstance(law, Thornton) and closed:  # it also yields or turns back
                left[c] = min(left[c], (law.limit - depth) / length + _HYSTERESIS)
                if law.plastic:
                    left[c] = rate / self.motion.speed + _HYSTERESIS
        return left

    def _switch(self, c: int, at: At, closed: list[bool]) -> None:
        """Put contact `c` into its next phase."""
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

    # --------------------------------------------------------------- pieces

    def _piece(
        self, t: float, y: FloatArray, closed: list[bool], end: float
    ) -> tuple[float, FloatArray]:
        """Integrate up to `end`, with loads that are linear in time."""
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
                    self.marks.append(Mark(t, c, impulse, float(at.rate[c])))
                self._count_flip(c, t)
            phase = self._phase(closed)
            y = self._widened(y, phase, at.deflection)
        return t, y

    def _widened(self, y: FloatArray, phase: Phase, deflection: FloatArray) -> FloatArray:
        """Return the state with the deflections that are variables in the phase."""
        base = y[: 2 * self.motion.system.n + self.motion.count]
        return np.concatenate([base, deflection[list(phase.own)]])

    def _count_flip(self, c: int, t: float) -> None:
        last, many = self._flips.get(c, (-1.0, 0))
        many = many + 1 if t - last <= 1e-13 * self.case.duration else 0
        self._flips[c] = (t, many)
        if many > _MOST_FLIPS:
            self._quiet_until[c] = t + _MOMENT * self.case.duration

    def _advance(
        self, t: float, y: FloatArray, phase: Phase, end: float
    ) -> tuple[float, FloatArray, list[int]]:
        """Integrate to the next event, or to `end`; return time, state and switching contacts."""
        motion = self.motion

        def rhs(t: float, y: FloatArray) -> FloatArray:
            if clock.process_time() > self._deadline:
                raise GaveUpError("too slow")
            return motion.slope(y, motion.look(t, y, phase, rates=False))

        def left(t: float, y: FloatArray) -> FloatArray:
            return self._events(t, motion.look(t, y, phase), phase)

        if (before := left(t, y)).min() < 0.0:
            return t, y, np.flatnonzero(before < 0.0).tolist()
        # A force that begins like t^1.5 is no polynomial, which the error estimate of a long first
        # step would miss.
        fast = 1e-2 / (motion.system.fastest + 1e-99)
        first = min(end - t, 1e-4 * motion.length / motion.speed, fast)
        rtol = max(self.rtol, _TIGHTEST_IMPLICIT if phase.own else 3e-14)
        try:
            solver = (Radau if phase.own else DOP853)(
                rhs,
                t,
                y,
                end,
                rtol=rtol,
                atol=rtol * motion.sizes(phase),
                first_step=_RELAXING * first if phase.own else first,
                max_step=_LONGEST * self.case.duration,
            )
            while solver.status == "running":
                start, message = solver.t, solver.step()
                if solver.status == "failed":
                    raise GaveUpError(f"integrator: {message}")
                if phase.own:  # steps of differences in variables without effect grow to overflow
                    np.minimum(solver.jac_factor, 1.0, out=solver.jac_factor)
                dense = solver.dense_output()
                self.steps.append(Step(start, solver.t, dense, phase))
                if left(solver.t, solver.y).min() < 0.0:
                    when = self._root(
                        lambda t, at=dense: float(left(t, at(t)).min()), start, solver.t
                    )
                    self.steps[-1].end, y = when, dense(when)
                    over = left(when, y)
                    return when, y, np.flatnonzero(over <= max(over.min(), 0.0)).tolist()
        except (ValueError, np.linalg.LinAlgError, OverflowError) as error:
            raise GaveUpError(f"integrator: {error}") from error
        return solver.t, solver.y, []

    def _root(self, value: Callable[[float], float], low: float, high: float) -> float:
        if value(low) <= 0.0:
            return low
        return float(brentq(value, low, high, xtol=1e-15 * self.case.duration, rtol=1e-15))
