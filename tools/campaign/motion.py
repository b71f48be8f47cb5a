"""Equations of motion of a scene: indentations, contact forces, and rates of the state.

A massless contact coordinate has the deflection w = u - u_free of its residual compliance R under
the contact forces: w / R + the sum of the contact forces on the coordinate = 0.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.optimize import bisect

from .case import Case
from .formulas import Formula, Thornton, formula
from .outcome import FloatArray
from .system import system_of

# Relaxation time of the dashpot that keeps the equation of a massless coordinate regular, over the
# record.
LAG = 1e-12

# Maximum number of Newton's steps for a massless coordinate's balance, and smallest damping factor
# of a step.
_MOST, _SHORTEST = 200, 1e-6


Memory = tuple[bool, float, float]


@dataclass(frozen=True)
class Phase:
    """Set of equations that hold between two events.

    Attributes
    ----------
    closed : tuple of bool
        Whether each contact is closed.
    plastic : tuple of (flows, deepest, rest)
        Memory of the plastic law at each contact.
    own : tuple of int
        Massless ports whose deflection is a state variable, since dashpots act on them.
    solved : tuple of int
        Massless ports whose deflection follows from the balance with elastic contacts.
    """

    closed: tuple[bool, ...]
    plastic: tuple[Memory, ...]
    own: tuple[int, ...]
    solved: tuple[int, ...]


@dataclass
class At:
    """Contacts and ports at an instant; `flow`: rates of the deflections that are variables."""

    depth: FloatArray
    rate: FloatArray
    force: FloatArray
    port_force: FloatArray
    flow: FloatArray
    deflection: FloatArray


class Motion:
    """A scene's equations; the state is (q, q', impulses, deflections of `Phase.own`).

    Attributes
    ----------
    case : Case
    laws : list of Formula
    system : System
    count : int
        Number of contacts.
    speed, length, push : float
        Typical speed, m/s, indentation, m, and force, N, of the scene: scales of tolerances.
    warm : ndarray
        Last deflections, from which the next solution starts, m.
    piece : (float, float)
        Start and end of the current piece, in which loads are linear in time, s.
    lag : float
        Relaxation time of the dashpot on massless coordinates, over the record.
    """

    def __init__(self, case: Case, lag: float = LAG) -> None:
        self.case, self.lag = case, lag
        self.laws = [formula(contact.law) for contact in case.contacts]
        self.system = system_of(case)
        self.count = len(case.contacts)
        self.ports = len(self.system.residual)
        residual = self.system.residual
        self.spring = np.where(residual > 0.0, 1.0 / np.where(residual > 0.0, residual, 1.0), 0.0)
        self.warm, self.piece = np.zeros(self.ports), (0.0, case.duration)
        self._still = np.zeros(self.ports)
        self.speed, self.length, self.push = self._scales()

    def _scales(self) -> tuple[float, float, float]:
        case = self.case
        masses = [body.mass for body in case.bodies if not body.wall]
        loads = [abs(force) for load in case.loads for force in load.forces]
        load = max([*loads, abs(case.gravity) * max(masses)])
        speed = max(abs(body.velocity) for body in case.bodies)
        speed = max(speed, load / max(masses) * case.duration * 0.1, 1e-12)
        depths = [_stroke(law, 0.5 * min(masses) * speed**2, load) for law in self.laws]
        forces = [law.statically(d)[0] for law, d in zip(self.laws, depths, strict=True)]
        return speed, min(depths), max([load, *forces])

    def loads(self, t: float) -> tuple[FloatArray, FloatArray]:
        """Return forces on the ports, N, and their rates, within the current piece."""
        force, rate = np.zeros(self.ports), np.zeros(self.ports)
        for load in self.case.loads:
            port = self.system.first_port[load.body] + load.at
            now, first, last = np.interp([t, *self.piece], load.times, load.forces)
            force[port] += now
            rate[port] += (last - first) / (self.piece[1] - self.piece[0])
        return force, rate

    def look(self, t: float, y: FloatArray, phase: Phase, *, rates: bool = True) -> At:
        """Return contacts and ports at a state; without `rates`, some rates are left out."""
        system, ports = self.system, self.ports
        load, load_rate = self.loads(t)
        port = system.port @ y[: 2 * system.n]
        place = port[:ports] + system.residual * load + system.port_speed * t
        speed = port[ports:] + system.residual * load_rate + system.port_speed
        w, own, solved = np.zeros(ports), list(phase.own), list(phase.solved)
        w[own] = y[2 * system.n + self.count :]
        closed = [c for c in range(self.count) if phase.closed[c]]
        for c in closed:
            law = self.laws[c]
            if isinstance(law, Thornton):
                law.plastic, law.deepest, law.rest = phase.plastic[c]
        if solved:
            w[solved] = self.warm[solved]
            self.balance(place, w, solved, closed)
            self.warm[solved] = w[solved]
        depth = system.sides @ (place + w) - system.gaps
        elastic, stiffness, damper = self._values(depth, closed)
        sides, flow = system.sides[closed], self._still[:0]
        if own:
            here, spring = sides[:, own], self.spring[own]
            over = -spring * w[own] - here.T @ (elastic + damper * (sides @ speed))
            lag = self.lag * self.case.duration
            flow = np.linalg.solve(np.diag(lag * spring) + (here.T * damper) @ here, over)
            speed[own] += flow
        if solved and rates:
            here = sides[:, solved]
            over = -here.T @ (stiffness * (sides @ speed))
            tangent = np.diag(self.spring[solved]) + (here.T * stiffness) @ here
            speed[solved] += np.linalg.solve(tangent, over)
        rate, force = system.sides @ speed, np.zeros(self.count)
        force[closed] = elastic + damper * rate[closed]
        return At(depth, rate, force, load - force @ system.sides, flow, w)

    def _values(self, depth: FloatArray, contacts: list[int]) -> FloatArray:
        """Return rows of elastic forces, their slopes, and damping coefficients of contacts."""
        return np.array([self.laws[c].at(float(depth[c])) for c in contacts]).reshape(-1, 3).T

    def balance(
        self, place: FloatArray, w: FloatArray, ports: list[int], contacts: list[int]
    ) -> None:
        """Find the deflections of `ports` in balance with elastic forces: a convex problem.

        Parameters
        ----------
        place : ndarray
            Positions of all ports without their deflections, m.
        w : ndarray
            Guess of the deflections, overwritten by the solution, m.
        ports : list of int
        contacts : list of int
            Contacts that may press on the ports.
        """
        sides, spring = self.system.sides[contacts][:, ports], self.spring[ports]

        def left() -> tuple[FloatArray, FloatArray]:
            depth = self.system.sides @ (place + w) - self.system.gaps
            push, stiffness, _ = self._values(depth, contacts)
            tangent = np.diag(spring) + (sides.T * stiffness) @ sides
            return -spring * w[ports] - sides.T @ push, tangent

        over, tangent = left()
        error = np.abs(over).max()
        for _ in range(_MOST):
            if error <= 1e-15 * self.push:
                return
            step, before, share = np.linalg.solve(tangent, over), w[ports], 1.0
            while True:
                w[ports] = before + share * step
                over, tangent = left()
                new = np.abs(over).max()
                if new < error or share < _SHORTEST:
                    break
                share *= 0.5
            size = np.abs(w[ports]).max() + self.length
            if new >= error and np.abs(step).max() <= 1e-15 * size:
                return
            error = new

    def slope(self, y: FloatArray, at: At) -> FloatArray:
        """Return the rates of the state."""
        n, system = self.system.n, self.system
        slope = np.empty(len(y))
        slope[:n] = y[n : 2 * n]
        slope[n : 2 * n] = system.matrix @ y[: 2 * n] + system.pull + system.push @ at.port_force
        slope[2 * n : 2 * n + self.count] = at.force
        slope[2 * n + self.count :] = at.flow
        return slope

    def sizes(self, phase: Phase) -> FloatArray:
        """Return the typical size of each entry of a state."""
        n = self.system.n
        sizes = np.full(2 * n + self.count + len(phase.own), self.length)
        own = self.push / self.spring[list(phase.own)]
        sizes[2 * n + self.count :] = np.minimum(own, self.length)
        sizes[n : 2 * n] = self.speed
        sizes[2 * n : 2 * n + self.count] = self.push * self.length / self.speed
        return sizes


def share(law: Formula, depth: float, rate: float) -> float:
    """Return the force over elastic force plus magnitude of damping force.

    It has the force's sign and a simple root, also where a contact ends at zero indentation and the
    force has a double root.
    """
    if depth <= 0.0:
        return 1.0
    elastic, _, damper = law.at(float(depth))
    most = elastic + damper * abs(rate)
    return float((elastic + damper * rate) / most) if most > 0.0 else 1.0


def _stroke(law: Formula, energy: float, load: float) -> float:
    """Return the approximate indentation, m, by an energy, J, and a constant load, N."""

    def over(x: float) -> float:
        d = math.exp(x)
        return 0.4 * law.statically(d)[0] * d - energy - 1e-300 - load * d

    return math.exp(bisect(over, -60.0, 10.0)) if over(10.0) > 0.0 else math.exp(10.0)


Dense = Callable[[float], FloatArray]
