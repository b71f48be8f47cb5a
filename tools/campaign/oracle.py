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
is found on the dense output of a step.
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

# The longest step, as a share of the record: events are looked for at the ends of steps.
_LONGEST = 0.01

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
        self._deadline = math.inf
        self.steps = list[Step]()
        self.marks = list[Mark]()
        self._quiet_until = np.full(len(case.contacts), -1.0)
        self._flips = {}
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
                motion.piece = t, end
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
        self.marks += [Mark(0.0, c, 0.0, 0.0) for c in range(motion.count) if closed[c]]
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
        ports = np.flatnonzero(system.residual * load).tolist()
        if not ports:
            return
        place = system.port[: motion.ports] @ y[: 2 * system.n] + system.residual * load
        w, met = motion.warm, system.sides[:, ports].any(axis=1)
        elastic = [c for c, law in enumerate(self.laws) if met[c] and not law.viscous]
        motion.balance(place, w, ports, elastic)
        hit = {}  # contacts by the ports that they take hold of, the last met
        for c, law in enumerate(self.laws):
            over = float((system.sides @ (place + w) - system.gaps)[c])
            if law.viscous and met[c] and over > 0.0:
                port = max(ports, key=lambda p: system.sides[c, p] or -2.0)  # of its first body
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
        """Of each contact a number that turns negative where its phase ends."""
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
                    self.marks.append(Mark(t, c, impulse, float(at.rate[c])))
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

    def _advance(
        self, t: float, y: FloatArray, phase: Phase, end: float
    ) -> tuple[float, FloatArray, list[int]]:
        """Go on to the next event, or to `end`."""
        motion = self.motion

        def rhs(t: float, y: FloatArray) -> FloatArray:
            if clock.process_time() > self._deadline:
                raise GaveUpError("too slow")
            return motion.slope(y, motion.look(t, y, phase, rates=False))

        def left(t: float, y: FloatArray) -> FloatArray:
            return self._events(t, motion.look(t, y, phase), phase)

        if (before := left(t, y)).min() < 0.0:
            return t, y, np.flatnonzero(before < 0.0).tolist()
        # A force that begins like t^1.5 is no polynomial: a long first step would not notice.
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
                if phase.own:  # its differences by what moves nothing grow until they overflow
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
