"""The plain formulation: SciPy's integrators on the equations of motion, piece by piece.

What it assumes. A massless contact coordinate is at each instant in balance with its springs, its
load and the contact forces on it: an algebraic equation, solved whenever the right-hand side is
asked for. Where a closed contact with a dashpot acts on it, the balance gives its velocity
instead, and its deflection w = u - u_free is a variable; a dashpot that relaxes w in a millionth
of a millionth of the record keeps that equation regular where the contact's own vanishes. It
closes at the deflection that it has. So nothing is lost when a contact closes on it, or when it
lets go at no force. A law that pulls lets go at a force: then the coordinate springs back at once,
and what its springs had stored is lost.

Pieces end where a contact closes, lets go, yields or turns back, and where a load bends. An event
is found on the dense output of a step, from samples no farther apart than a sixth of it, and the
step is then made again up to there.
"""

from __future__ import annotations

import math
import time as clock
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy.integrate import DOP853, Radau
from scipy.optimize import brentq

from .case import Case
from .formulas import Formula, Thornton, formula
from .outcome import Outcome, Touch
from .rest import rest
from .system import System, system_of

FloatArray = npt.NDArray[np.float64]

# Samples within a step for events and peaks.
_SAMPLES = 6

# Relaxation of the regular dashpot, as a share of the record.
_LAG = 1e-12

# Contacts close this much, as a share of the depth that is usual, after they touch: no rounding
# does.
_HYSTERESIS = 1e-13


class GaveUpError(Exception):
    """The oracle has no answer: too slow, or an equation without a solution."""


@dataclass
class _Step:
    """A step that was accepted: dense output from start to end in one phase."""

    start: float
    end: float
    dense: Callable[[float], FloatArray]
    phase: _Phase


@dataclass(frozen=True)
class _Phase:
    """Which contacts are closed, which of them flow, and which ports have a deflection of their
    own.
    """

    closed: tuple[bool, ...]
    plastic: tuple[tuple[bool, float, float], ...]
    own: tuple[int, ...]
    solved: tuple[int, ...]


@dataclass
class _At:
    """The state of all contacts at an instant."""

    depth: FloatArray
    rate: FloatArray
    force: FloatArray
    port_force: FloatArray
    flow: FloatArray  # rates of the deflections of the phase's own ports
    deflection: FloatArray


@dataclass
class Oracle:
    """One scene; `run` gives the outcome."""

    case: Case
    rtol: float = 1e-11
    longest: float = 30.0
    nudge: FloatArray | None = None
    laws: list[Formula] = field(init=False)
    system: System = field(init=False)

    def __post_init__(self) -> None:
        case = self.case
        self.laws = [formula(contact.law) for contact in case.contacts]
        self.system = system_of(case)
        self._bodies, self._count = len(case.bodies), len(case.contacts)
        residual = self.system.residual
        self._massless = [i for i in range(self._bodies) if residual[i] > 0.0]
        self._spring = np.where(residual > 0.0, 1.0 / np.where(residual > 0.0, residual, 1.0), 0.0)
        self._ends = [(contact.a, contact.b) for contact in case.contacts]
        self._warm = np.zeros(self._bodies)
        self._deadline = math.inf
        self._speed, self._length, self._push = self._scales()

    # --------------------------------------------------------------- scales and loads

    def _scales(self) -> tuple[float, float, float]:
        """Speed, m/s, indentation, m, and force, N, that are usual in the scene."""
        case = self.case
        speed = max(abs(body.velocity) for body in case.bodies)
        masses = [body.mass for body in case.bodies if not body.wall]
        load = max(
            [abs(f) for one in case.loads for f in one.forces] + [case.gravity * max(masses)]
        )
        speed = max(speed, load / max(masses) * case.duration * 0.1, 1e-12)
        depths, forces = [], [load]
        for law in self.laws:
            energy = 0.5 * min(masses) * speed**2 + 1e-300
            low, high = -60.0, 10.0
            for _ in range(60):
                middle = 0.5 * (low + high)
                d = math.exp(middle)
                if 0.4 * law.statically(d)[0] * d < energy + load * d:
                    low = middle
                else:
                    high = middle
            depths.append(math.exp(low))
            forces.append(law.statically(depths[-1])[0])
        return speed, min(depths), max(forces)

    def _loads(self, t: float) -> tuple[FloatArray, FloatArray]:
        """Forces on the bodies' contact coordinates and their rates, within the current piece."""
        force, rate = np.zeros(self._bodies), np.zeros(self._bodies)
        for load in self.case.loads:
            times, values = load.times, load.forces
            if t < times[0] or len(times) == 1 or self._piece_start >= times[-1]:
                force[load.body] += values[0] if t < times[0] else values[-1]
                continue
            i = max(int(np.searchsorted(times, self._piece_start, side="right")) - 1, 0)
            if self._piece_start < times[0]:
                force[load.body] += values[0]
                continue
            slope = (values[i + 1] - values[i]) / (times[i + 1] - times[i])
            force[load.body] += values[i] + slope * (t - times[i])
            rate[load.body] += slope
        return force, rate

    # --------------------------------------------------------------- right-hand side

    def _look(self, t: float, y: FloatArray, phase: _Phase) -> _At:
        """Contacts and ports at a state."""
        system, bodies = self.system, self._bodies
        load, load_rate = self._loads(t) if self.case.loads else (self._none, self._none)
        port = system.port @ y[: 2 * system.n]
        place = port[:bodies] + system.residual * load + system.wall_speed * t
        speed = port[bodies:] + system.residual * load_rate + system.wall_speed
        w, flow = np.zeros(bodies), np.zeros(bodies)
        first = 2 * system.n + self._count
        for j, p in enumerate(phase.own):
            w[p] = y[first + j]
        closed = [c for c in range(self._count) if phase.closed[c]]
        for c in closed:
            law = self.laws[c]
            if isinstance(law, Thornton):
                law.plastic, law.deepest, law.rest = phase.plastic[c]
        if phase.solved:
            self._solve(place, w, phase.solved, closed)
        sides, gaps = system.sides, system.gaps
        depth = sides @ (place + w) - gaps
        values = {c: self.laws[c].at(float(depth[c])) for c in closed}
        if phase.solved:
            self._follow(speed, flow, phase.solved, values)
        if phase.own:
            self._flow(speed, flow, w, phase.own, values)
        rate = sides @ (speed + flow)
        force = np.zeros(self._count)
        for c, (elastic, _, damper) in values.items():
            force[c] = elastic + damper * rate[c]
        port_force = load - sides.T @ force
        return _At(depth, rate, force, port_force, flow[list(phase.own)], w)

    def _solve(
        self, place: FloatArray, w: FloatArray, ports: tuple[int, ...], closed: list[int]
    ) -> None:
        """Deflections of massless ports in balance with elastic forces: a convex problem."""
        touching = [c for c in closed if any(p in ports for p in self._ends[c])]
        index = {p: i for i, p in enumerate(ports)}
        for p in ports:
            w[p] = self._warm[p]

        def left() -> tuple[FloatArray, FloatArray]:
            over = np.array([-self._spring[p] * w[p] for p in ports])
            slope = np.diag([self._spring[p] for p in ports])
            for c in touching:
                a, b = self._ends[c]
                force, stiffness, _ = self.laws[c].at(
                    float(place[a] + w[a] - place[b] - w[b] - self.system.gaps[c])
                )
                signs = [(index[p], s) for p, s in ((a, 1.0), (b, -1.0)) if p in index]
                for i, s in signs:
                    over[i] -= s * force
                    for j, r in signs:
                        slope[i, j] += s * r * stiffness
            return over, slope

        over, slope = left()
        error = float(np.abs(over).max())
        for _ in range(200):
            if error <= 1e-15 * self._push:
                break
            step = np.linalg.solve(slope, over) if len(ports) > 1 else over / slope[0, 0]
            before, share = w[list(ports)], 1.0
            while True:
                for i, p in enumerate(ports):
                    w[p] = before[i] + share * step[i]
                trial, trial_slope = left()
                new = float(np.abs(trial).max())
                if new < error or share < 1e-6:
                    break
                share *= 0.5
            small = float(np.abs(step).max()) <= 1e-15 * float(np.abs(w).max() + self._length)
            if new >= error and small:
                break
            over, slope, error = trial, trial_slope, new
        for p in ports:
            self._warm[p] = w[p]

    def _follow(
        self, speed: FloatArray, flow: FloatArray, ports: tuple[int, ...], values: dict[int, Any]
    ) -> None:
        """Rates of those deflections."""
        index = {p: i for i, p in enumerate(ports)}
        matrix = np.diag([self._spring[p] for p in ports])
        over = np.zeros(len(ports))
        for c, (_, stiffness, _) in values.items():
            a, b = self._ends[c]
            signs = [(index[p], s) for p, s in ((a, 1.0), (b, -1.0)) if p in index]
            for i, s in signs:
                over[i] -= s * stiffness * (speed[a] - speed[b])
                for j, r in signs:
                    matrix[i, j] += s * r * stiffness
        found = np.linalg.solve(matrix, over)
        for i, p in enumerate(ports):
            flow[p] = found[i]

    def _flow(
        self,
        speed: FloatArray,
        flow: FloatArray,
        w: FloatArray,
        ports: tuple[int, ...],
        values: dict[int, Any],
    ) -> None:
        """Rates of the deflections that dashpots rule."""
        index = {p: i for i, p in enumerate(ports)}
        lag = _LAG * self.case.duration
        matrix = np.diag([lag * self._spring[p] for p in ports])
        over = np.array([-self._spring[p] * w[p] for p in ports])
        for c, (elastic, _, damper) in values.items():
            a, b = self._ends[c]
            signs = [(index[p], s) for p, s in ((a, 1.0), (b, -1.0)) if p in index]
            for i, s in signs:
                over[i] -= s * (elastic + damper * (speed[a] - speed[b]))
                for j, r in signs:
                    matrix[i, j] += s * r * damper
        found = np.linalg.solve(matrix, over)
        for i, p in enumerate(ports):
            flow[p] = found[i]

    def _rhs(self, phase: _Phase) -> Callable[[float, FloatArray], FloatArray]:
        system, n = self.system, self.system.n

        def rhs(t: float, y: FloatArray) -> FloatArray:
            if clock.monotonic() > self._deadline:
                raise GaveUpError("too slow")
            at = self._look(t, y, phase)
            slope = np.empty(len(y))
            slope[:n] = y[n : 2 * n]
            slope[n : 2 * n] = (
                system.matrix @ y[: 2 * n] + system.pull + system.push @ at.port_force
            )
            slope[2 * n : 2 * n + self._count] = at.force
            slope[2 * n + self._count :] = at.flow
            return slope

        return rhs

    # --------------------------------------------------------------- phases and events

    def _phase(self, closed: list[bool]) -> _Phase:
        own = set()
        touched = set()
        for c in range(self._count):
            if closed[c]:
                ends = [p for p in self._ends[c] if self.system.residual[p] > 0.0]
                touched.update(ends)
                if self.laws[c].viscous:
                    own.update(ends)
        plastic = tuple(
            (law.plastic, law.deepest, law.rest) if isinstance(law, Thornton) else (False, 0.0, 0.0)
            for law in self.laws
        )
        return _Phase(tuple(closed), plastic, tuple(sorted(own)), tuple(sorted(touched - own)))

    def _events(self, at: _At, phase: _Phase) -> FloatArray:
        """Of each contact a number that turns negative where its phase ends."""
        left = np.ones(self._count)
        for c, law in enumerate(self.laws):
            above = (at.depth[c] - law.rest) / self._length
            if not phase.closed[c]:
                left[c] = _HYSTERESIS - above
                if law.viscous and not law.pulls:
                    left[c] = max(left[c], _HYSTERESIS - _share(law, at.depth[c], at.rate[c]))
                continue
            left[c] = above
            if law.viscous and not law.pulls:
                left[c] = min(above, _share(law, at.depth[c], at.rate[c]) + _HYSTERESIS)
            if isinstance(law, Thornton):
                if phase.plastic[c][0]:
                    left[c] = at.rate[c] / self._speed + _HYSTERESIS
                else:
                    law.plastic, law.deepest, law.rest = phase.plastic[c]
                    left[c] = min(above, (law.limit - at.depth[c]) / self._length + _HYSTERESIS)
        return left

    def _switch(self, c: int, at: _At, closed: list[bool]) -> None:
        """Contact c goes into its next phase."""
        law = self.laws[c]
        if isinstance(law, Thornton) and closed[c]:
            if law.plastic:
                law.remember(float(at.depth[c]))
                law.plastic = False
                return
            if at.depth[c] >= law.limit and at.depth[c] - law.rest > 0.0:
                law.plastic = True
                return
        closed[c] = not closed[c]

    # --------------------------------------------------------------- the run

    def run(self) -> Outcome:
        """Integrate the record.

        Raises
        ------
        GaveUpError
            If it takes longer than `longest` s, or an integrator gives up.
        NoRestError
        """
        self._deadline = clock.monotonic() + self.longest
        self._none = np.zeros(self._bodies)
        self._piece_start = 0.0
        self._steps: list[_Step] = []
        self._marks: list[tuple[float, int, bool, float, float]] = []
        y, closed = self._begin()
        bends = sorted(
            {t for load in self.case.loads for t in load.times if 0.0 < t < self.case.duration}
        )
        t = 0.0
        for end in [*bends, self.case.duration]:
            self._piece_start = t
            t, y = self._piece(t, y, closed, end)
        return self._outcome(y, closed)

    def _begin(self) -> tuple[FloatArray, list[bool]]:
        system, case = self.system, self.case
        y = np.concatenate([np.zeros(2 * system.n + self._count)])
        y[: 2 * system.n] = system.start
        if self.nudge is not None:
            y[: 2 * system.n] *= 1.0 + self.nudge[: 2 * system.n]
        closed = [False] * self._count
        if case.preload:
            self._piece_start = 0.0
            places, depth = rest(case, self.laws, self._loads(0.0)[0])
            own = [
                place[1:] if body.massless else place
                for body, place in zip(case.bodies, places, strict=True)
                if not body.wall
            ]
            if own:
                y[: system.n] = np.concatenate(own)
            if self.nudge is not None:
                y[: system.n] *= 1.0 + self.nudge[: system.n]
            for c, law in enumerate(self.laws):
                closed[c] = bool(depth[c] > _HYSTERESIS * self._length)
                if isinstance(law, Thornton) and closed[c] and depth[c] > law.limit:
                    law.remember(float(depth[c]))
            for i, body in enumerate(case.bodies):
                if body.massless:
                    free = float(system.port[i] @ y[: 2 * system.n])
                    free += system.residual[i] * self._loads(0.0)[0][i]
                    self._warm[i] = places[i][0] - free
        for c in range(self._count):
            if closed[c]:
                self._marks.append((0.0, c, True, 0.0, 0.0))
        return y, closed

    def _widen(self, y: FloatArray, old: _Phase | None, new: _Phase, w: FloatArray) -> FloatArray:
        """The state with the deflections that the new phase has of its own."""
        base = y[: 2 * self.system.n + self._count]
        return np.concatenate([base, w[list(new.own)]])

    def _piece(
        self, t: float, y: FloatArray, closed: list[bool], end: float
    ) -> tuple[float, FloatArray]:
        """Integrate with smooth loads up to `end`."""
        phase = self._phase(closed)
        w = self._warm.copy()
        y = self._widen(y, None, phase, w)
        guard: dict[int, float] = {}
        flips: dict[int, tuple[float, int]] = {}
        while t < end:
            t_new, y_new, found = self._advance(t, y, phase, end, guard)
            t, y = t_new, y_new
            if not found:
                at = self._look(t, y, phase)
                self._warm = at.deflection.copy()
                continue
            at = self._look(t, y, phase)
            for c in found:
                before = closed[c]
                self._switch(c, at, closed)
                if closed[c] != before:
                    impulse = float(y[2 * self.system.n + c])
                    self._marks.append((t, c, closed[c], impulse, float(at.rate[c])))
                last, many = flips.get(c, (-1.0, 0))
                many = many + 1 if t - last <= 1e-13 * self.case.duration else 0
                flips[c] = (t, many)
                if many > 3:
                    guard[c] = t + 1e-11 * self.case.duration
            phase = self._phase(closed)
            y = self._widen(y, phase, phase, at.deflection)
            self._warm = at.deflection.copy()
        return t, y

    def _integrator(self, t: float, y: FloatArray, phase: _Phase, end: float) -> Any:
        n = self.system.n
        scale = np.empty(len(y))
        scale[:n] = self._length
        scale[n : 2 * n] = self._speed
        scale[2 * n : 2 * n + self._count] = self._push * self._length / self._speed
        scale[2 * n + self._count :] = self._length
        rhs = self._rhs(phase)
        # A force that begins like t^1.5 is no polynomial: a long first step would not notice.
        first = min(
            end - t, 1e-4 * self._length / self._speed, 1e-2 / (self.system.fastest + 1e-99)
        )
        if phase.own:
            rtol = max(self.rtol, 1e-10)
            return Radau(rhs, t, y, end, rtol=rtol, atol=rtol * scale, first_step=first)
        rtol = max(self.rtol, 3e-14)
        return DOP853(rhs, t, y, end, rtol=rtol, atol=rtol * scale, first_step=first)

    def _advance(
        self, t: float, y: FloatArray, phase: _Phase, end: float, guard: dict[int, float]
    ) -> tuple[float, FloatArray, list[int]]:
        """Go on to the next event, or to `end`."""
        solver = self._integrator(t, y, phase, end)
        at = self._look(t, y, phase)
        before = self._events(at, phase)
        soon = [c for c in np.flatnonzero(before < 0.0) if guard.get(c, -1.0) < t]
        if soon:
            return t, y, soon
        while True:
            start, y_start = solver.t, solver.y.copy()
            message = solver.step()
            if solver.status == "failed":
                raise GaveUpError(f"integrator: {message}")
            dense = solver.dense_output()
            found = self._first_event(start, solver.t, dense, phase, before, guard)
            if found is not None:
                when, y_event, which = self._refined(start, y_start, found, dense, phase)
                self._steps.append(_Step(start, when, dense, phase))
                return when, y_event, which
            self._steps.append(_Step(start, solver.t, dense, phase))
            if solver.status == "finished":
                return solver.t, solver.y, []
            before = self._events(self._look(solver.t, solver.y, phase), phase)

    def _first_event(
        self,
        start: float,
        end: float,
        dense: Callable[[float], FloatArray],
        phase: _Phase,
        before: FloatArray,
        guard: dict[int, float],
    ) -> tuple[float, list[int]] | None:
        """Time of the first event within a step and the contacts that have it."""
        last = start
        for t in np.linspace(start, end, _SAMPLES + 1)[1:]:
            left = self._events(self._look(t, dense(t), phase), phase)
            changed = [c for c in np.flatnonzero(left < 0.0) if guard.get(c, -1.0) < t]
            if changed:
                times = {c: self._root(c, last, t, dense, phase) for c in changed}
                first = min(times.values())
                same = 1e-14 * self.case.duration
                return first, [c for c in changed if times[c] <= first + same]
            last = t
        return None

    def _root(
        self,
        c: int,
        low: float,
        high: float,
        dense: Callable[[float], FloatArray],
        phase: _Phase,
    ) -> float:
        def value(t: float) -> float:
            return float(self._events(self._look(t, dense(t), phase), phase)[c])

        if value(low) <= 0.0:
            return low
        return float(brentq(value, low, high, xtol=1e-15 * self.case.duration, rtol=1e-15))

    def _refined(
        self,
        start: float,
        y: FloatArray,
        found: tuple[float, list[int]],
        dense: Callable[[float], FloatArray],
        phase: _Phase,
    ) -> tuple[float, FloatArray, list[int]]:
        """The event on the solution itself: the step is made again up to it."""
        when, which = found
        c = which[0]
        state = y
        for _ in range(4):
            if when <= start:
                return start, y, which
            solver = self._integrator(start, y, phase, when)
            while solver.status == "running":
                solver.step()
            state = solver.y.copy()
            here = float(self._events(self._look(when, state, phase), phase)[c])
            if -1e-12 <= here <= 0.0:
                break
            eta = 1e-4 * (when - start)
            ahead = float(self._events(self._look(when, dense(when), phase), phase)[c])
            behind = float(self._events(self._look(when - eta, dense(when - eta), phase), phase)[c])
            slope = (ahead - behind) / eta
            if not slope < 0.0:
                break
            moved = here / -slope + 1e-15 * self.case.duration
            if abs(moved) <= 1e-15 * self.case.duration:
                break
            when = min(max(when + moved, start), start + 2.0 * (when - start))
        return when, state, which

    # --------------------------------------------------------------- what came of it

    def force_at(self, c: int, t: float) -> float:
        """Force of a contact at a time, N."""
        starts = self._starts
        i = min(max(int(np.searchsorted(starts, t, side="right")) - 1, 0), len(starts) - 1)
        return self._force(self._steps[i], c, min(max(t, 0.0), self.case.duration))

    def _force(self, step: _Step, c: int, t: float) -> float:
        return float(self._look_past(step, t).force[c])

    def _look_past(self, step: _Step, t: float) -> _At:
        bends = [0.0, *(x for load in self.case.loads for x in load.times if x <= step.start)]
        self._piece_start = max(bends)
        return self._look(t, step.dense(t), step.phase)

    def _outcome(self, y: FloatArray, closed: list[bool]) -> Outcome:
        self._starts = np.array([step.start for step in self._steps])
        n = self.system.n
        last = self._steps[-1]
        at = self._look_past(last, self.case.duration)
        rates = (
            self.system.matrix @ y[: 2 * n] + self.system.pull + self.system.push @ at.port_force
        )
        velocities = self.system.centre @ y[n : 2 * n] + self.system.wall_speed
        peaks, times = self._peaks()
        return Outcome(
            peaks,
            times,
            y[2 * n : 2 * n + self._count].copy(),
            self._touches(y),
            velocities,
            self.system.centre @ rates,
            self.force_at,
            self.system.fastest,
        )

    def _peaks(self) -> tuple[FloatArray, FloatArray]:
        """Largest force of each contact, and when."""
        peaks, times = np.zeros(self._count), np.zeros(self._count)
        grid = np.linspace(0.0, 1.0, _SAMPLES + 1)
        around = np.zeros(self._count)
        for step in self._steps:
            if not any(step.phase.closed):
                continue
            h = step.end - step.start
            forces = np.array([self._look_past(step, step.start + g * h).force for g in grid])
            for c in range(self._count):
                i = int(forces[:, c].argmax())
                if forces[i, c] > peaks[c]:
                    peaks[c], times[c] = forces[i, c], step.start + grid[i] * h
                    around[c] = h / _SAMPLES
        for c in np.flatnonzero(peaks > 0.0):
            low = max(times[c] - 2.0 * around[c], 0.0)
            high = min(times[c] + 2.0 * around[c], self.case.duration)
            when, top = _largest(lambda t, i=int(c): self.force_at(i, t), low, high)
            if top > peaks[c]:
                peaks[c], times[c] = top, when
        return peaks, times

    def _touches(self, y: FloatArray) -> tuple[tuple[Touch, ...], ...]:
        found: list[list[Touch]] = [[] for _ in range(self._count)]
        open_: dict[int, tuple[float, float, float]] = {}
        for t, c, closes, impulse, rate in self._marks:
            if closes:
                open_[c] = (t, impulse, rate)
            elif c in open_:
                start, before, speed = open_.pop(c)
                found[c].append(self._touch(c, start, t, impulse - before, speed))
        for c, (start, before, speed) in open_.items():
            impulse = float(y[2 * self.system.n + c])
            found[c].append(self._touch(c, start, self.case.duration, impulse - before, speed))
        for c, of in enumerate(found):
            ends = [*(touch.start for touch in of[1:]), self.case.duration][: len(of)]
            found[c] = [
                replace(touch, apart=-self._depths(c, touch.end, end, min))
                for touch, end in zip(of, ends, strict=True)
            ]
        return tuple(tuple(of) for of in found)

    def _touch(self, c: int, start: float, end: float, impulse: float, rate: float) -> Touch:
        deep = self._depths(c, start, end, max)
        pace = abs(rate) * (end - start) / deep if deep > 0.0 else 0.0
        return Touch(float(start), float(end), impulse, float(pace), deep)

    def _depths(self, c: int, start: float, end: float, which: Callable[..., float]) -> float:
        """The largest or least indentation between two times, by the middles of steps."""
        first = int(np.searchsorted(self._starts, start, side="left"))
        last = max(int(np.searchsorted(self._starts, end, side="left")), first + 1)
        steps = self._steps[first:last][:2000]
        return which(
            (float(self._look_past(s, 0.5 * (s.start + s.end)).depth[c]) for s in steps),
            default=0.0,
        )


def _share(law: Formula, depth: float, rate: float) -> float:
    """Force over what it would be if the dashpot pushed: of its sign, and no double root at the
    touch.
    """
    elastic, _, damper = law.at(float(depth))
    most = elastic + damper * abs(rate)
    return (elastic + damper * float(rate)) / most if depth > 0.0 and most > 0.0 else 1.0


def _largest(value: Callable[[float], float], low: float, high: float) -> tuple[float, float]:
    """Where a function with one top between two ends is largest: golden section, then a
    parabola.
    """
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
    ends = [(value(low), low), (value(high), high), (at_a, a), (at_b, b)]
    top, when = max(ends)
    return when, top
