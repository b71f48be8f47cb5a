"""The right-hand side of a scene: where its contacts are, what forces they have, and what these
do.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from . import massless
from .case import Case
from .formulas import Formula, Thornton, formula
from .system import System, system_of

FloatArray = npt.NDArray[np.float64]

# Relaxation of the dashpot that keeps the equation of a massless coordinate regular, as a share of
# the record.
LAG = 1e-12


@dataclass(frozen=True)
class Phase:
    """Which equations hold.

    Attributes
    ----------
    closed : tuple of bool
        Of each contact.
    plastic : tuple of (flows, deepest, rest)
        Of each contact, the memory of a plastic law.
    own : tuple of int
        Massless ports whose deflection is a variable: dashpots act on them.
    solved : tuple of int
        Those whose deflection is in balance with elastic contacts.
    """

    closed: tuple[bool, ...]
    plastic: tuple[tuple[bool, float, float], ...]
    own: tuple[int, ...]
    solved: tuple[int, ...]


@dataclass
class At:
    """The contacts and ports at an instant. flow: rates of the deflections of the phase's own."""

    depth: FloatArray
    rate: FloatArray
    force: FloatArray
    port_force: FloatArray
    flow: FloatArray
    deflection: FloatArray


class Motion:
    """A scene's equations; the state is (q, q', impulses, deflections of the phase's own ports).

    Attributes
    ----------
    case : Case
    laws : list of Formula
    system : System
    count : int
        Of contacts.
    speed, length, push : float
        What is usual in the scene, m/s, m and N: the scales of tolerances.
    warm : ndarray
        Deflections found last, by which the search for the next begins.
    piece : float
        When the loads bent last, s.
    lag : float
        Of the dashpot on what has no mass, as a share of the record.
    """

    def __init__(self, case: Case, lag: float = LAG) -> None:
        self.case, self.lag = case, lag
        self.laws: list[Formula] = [formula(contact.law) for contact in case.contacts]
        self.system: System = system_of(case)
        self.count = len(case.contacts)
        self.ports = len(self.system.residual)
        residual = self.system.residual
        self.spring = np.where(residual > 0.0, 1.0 / np.where(residual > 0.0, residual, 1.0), 0.0)
        self.ends = [
            (int(side.argmax()), int(side.argmin())) for side in self.system.sides
        ]  # the ports of a and b
        self.warm, self.piece = np.zeros(self.ports), 0.0
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
        if not self.case.loads:
            return self._still, self._still
        force, rate = np.zeros(self.ports), np.zeros(self.ports)
        for load in self.case.loads:
            port = self.system.first_port[load.body] + load.at
            times, values = load.times, load.forces
            if self.piece >= times[-1]:
                force[port] += values[-1]
            elif self.piece < times[0]:
                force[port] += values[0]
            else:
                i = int(np.searchsorted(times, self.piece, side="right")) - 1
                slope = (values[i + 1] - values[i]) / (times[i + 1] - times[i])
                force[port] += values[i] + slope * (t - times[i])
                rate[port] += slope
        return force, rate

    def look(self, t: float, y: FloatArray, phase: Phase, *, rates: bool = True) -> At:
        """Return contacts and ports at a state; without `rates` only what the motion needs."""
        system, ports = self.system, self.ports
        load, load_rate = self.loads(t)
        port = system.port @ y[: 2 * system.n]
        place = port[:ports] + system.residual * load + system.port_speed * t
        speed = port[ports:] + system.residual * load_rate + system.port_speed
        w = np.zeros(ports)
        if phase.own:
            w[list(phase.own)] = y[2 * system.n + self.count :]
        closed = [c for c in range(self.count) if phase.closed[c]]
        for c in closed:
            law = self.laws[c]
            if isinstance(law, Thornton):
                law.plastic, law.deepest, law.rest = phase.plastic[c]
        if phase.solved:
            self._balance(place, w, phase.solved, closed)
        depth = system.sides @ (place + w) - system.gaps
        values = {c: self.laws[c].at(float(depth[c])) for c in closed}
        flow = self._still[:0]
        if phase.own:
            lag = self.lag * self.case.duration
            flow = massless.flow(speed, w, phase.own, values, self.ends, self.spring, lag)
            speed[list(phase.own)] += flow
        if phase.solved and rates:
            found = massless.follow(speed, phase.solved, values, self.ends, self.spring)
            speed[list(phase.solved)] += found
        rate = system.sides @ speed
        force = np.zeros(self.count)
        for c, (elastic, _, damper) in values.items():
            force[c] = elastic + damper * rate[c]
        return At(depth, rate, force, load - force @ system.sides, flow, w)

    def _balance(
        self, place: FloatArray, w: FloatArray, ports: tuple[int, ...], closed: list[int]
    ) -> None:
        w[list(ports)] = self.warm[list(ports)]
        touching = {
            c: (self.laws[c], self.case.contacts[c].gap)
            for c in closed
            if self.ends[c][0] in ports or self.ends[c][1] in ports
        }
        sizes = self.length, self.push
        massless.balance(place, w, ports, touching, self.ends, self.spring, sizes)
        self.warm[list(ports)] = w[list(ports)]

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
        """Return what is usual of each entry of a state."""
        n = self.system.n
        sizes = np.full(2 * n + self.count + len(phase.own), self.length)
        own = self.push / self.spring[list(phase.own)]
        sizes[2 * n + self.count :] = np.minimum(own, self.length)
        sizes[n : 2 * n] = self.speed
        sizes[2 * n : 2 * n + self.count] = self.push * self.length / self.speed
        return sizes


def share(law: Formula, depth: float, rate: float) -> float:
    """Force over what it would be if the dashpot pushed: of its sign, with a simple root.

    The force itself has a double root where a contact ends at the touch.
    """
    if depth <= 0.0:
        return 1.0
    elastic, _, damper = law.at(float(depth))
    most = elastic + damper * abs(rate)
    return float((elastic + damper * rate) / most) if most > 0.0 else 1.0


def _stroke(law: Formula, energy: float, load: float) -> float:
    """About how deep an energy and a load on the way bring a contact."""
    low, high = -60.0, 10.0
    for _ in range(60):
        middle = 0.5 * (low + high)
        d = math.exp(middle)
        if 0.4 * law.statically(d)[0] * d < energy + 1e-300 + load * d:
            low = middle
        else:
            high = middle
    return math.exp(low)


Dense = Callable[[float], FloatArray]
