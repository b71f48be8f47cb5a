"""The same impact by SciPy's solvers: an independent check, and the cost of a user's own script.

The equations of motion (section 3.1 of the paper) are integrated in the coordinates of the AO
models, without the core: no modes or formulas are shared with the solvers that are compared.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy.integrate

from aoimpact import AOModel, ContactLaw, ConvergenceError, Hertz, InputError, Linear, PowerLaw
from aoimpact.base import FloatArray
from aoimpact.laws import PatchLaw, own_law

Slope = Callable[[float, FloatArray], FloatArray]
Event = Callable[[float, FloatArray], float]
ForceLaw = Callable[[float], tuple[float, float]]

METHODS = ("RK23", "RK45", "DOP853", "Radau", "BDF", "LSODA")

# SciPy's methods that use no Jacobian.
_EXPLICIT = ("RK23", "RK45", "DOP853")

# Maximum number of contacts: a ball that comes to rest on a floor has infinitely many.
_MOST_CONTACTS = 100_000


@dataclass(frozen=True)
class Outcome:
    """Peak force, N, duration of the first contact, s, and rebound of the centre of mass, m/s."""

    peak_force: float
    contact_duration: float
    rebound_velocity: float


@dataclass(frozen=True, eq=False)
class _Half:
    """AO model M u'' + K u = -contact F, with contact displacement contact·u - compliance F."""

    mass: FloatArray
    stiffness: FloatArray
    contact: FloatArray
    compliance: float
    centre: FloatArray


def centre_weights(star: AOModel) -> FloatArray:
    """Return the weights of a star's coordinates in the displacement of its centre of mass."""
    if star.origin is None:
        return np.concatenate([[star.m0], star.m]) / star.static_mass
    return np.asarray(star.origin.centre_of_mass[0] @ star.expand(np.eye(star.n + 1)))


def _half(star: AOModel) -> _Half:
    if math.isinf(star.m0):
        return _Half(np.zeros(0), np.zeros((0, 0)), np.zeros(0), 0.0, np.zeros(0))
    sum_k = star.k0 + star.k.sum()
    weights = centre_weights(star)
    if star.m0 > 0.0:
        stiffness = np.diag(np.concatenate([[sum_k], star.k]))
        stiffness[0, 1:] = stiffness[1:, 0] = -star.k
        contact = np.eye(star.n + 1)[0]
        return _Half(np.concatenate([[star.m0], star.m]), stiffness, contact, 0.0, weights)
    # Equilibrium of a contact without mass: u0 = (Σ k_i u_i - F) / (k0 + Σ k_i).
    contact = star.k / sum_k
    stiffness = np.diag(star.k) - np.outer(star.k, contact)
    centre = weights[1:] + weights[0] * contact
    return _Half(star.m, stiffness, contact, 1.0 / sum_k, centre)


@dataclass(frozen=True, eq=False)
class OdeScene:
    """y' = matrix y - push F(δ), with y displacements then velocities and δ = depth y - gap - c F.

    Attributes
    ----------
    matrix, push, depth : ndarrays
        Coefficients of the equations above.
    centre, start : ndarrays
        `centre` y is the velocity of the projectile's centre of mass, `start` is y at t = 0.
    compliance, gap : float
        c, the compliance of massless contacts minus that of the patches, m/N, and the gap, m.
    force : callable
        δ > 0 ↦ F and dF/dδ.
    scale : ndarray
        Sizes of the components of y, to which SciPy's absolute tolerances are proportional.
    """

    matrix: FloatArray
    push: FloatArray
    depth: FloatArray
    centre: FloatArray
    start: FloatArray
    compliance: float
    gap: float
    force: ForceLaw
    scale: FloatArray
    duration: float

    def indentation(self, y: FloatArray) -> float:
        """Return δ without the compliance c: depth y - gap."""
        return float(self.depth @ y) - self.gap

    def contact_force(self, free: float) -> tuple[float, float]:
        """Return the force F at the indentation `free` - c F, N, and dF/d(free), N/m."""
        force, stiffness = self.force(free)
        if self.compliance == 0.0:
            return force, stiffness
        delta = free
        for _ in range(200):  # Newton's method, which converges monotonically
            step = (delta - free + self.compliance * force) / (1.0 + self.compliance * stiffness)
            delta -= step
            force, stiffness = self.force(delta)
            if abs(step) <= 1e-15 * free:
                break
        return force, stiffness / (1.0 + self.compliance * stiffness)

    def run(self, method: str, rtol: float, longest: float = math.inf) -> Outcome:
        """Integrate piece by piece; every touch and every release ends a piece.

        Raises
        ------
        ConvergenceError
            If SciPy gives up, or after `longest` s of computing.
        """
        deadline = time.perf_counter() + longest
        t, y = 0.0, self.start
        # The bodies touch if the gap is 0 and they approach each other.
        touching = bool(self.gap == 0.0 and self.depth @ self.matrix @ y > 0.0)
        peak, begin, first, rebound = 0.0, 0.0, math.nan, math.nan
        for _ in range(2 * _MOST_CONTACTS):
            run = self._piece(method, rtol, (t, y, touching), deadline)
            t, y = float(run.t[-1]), run.y[:, -1]
            if touching:
                states = [*run.y_events[1], y]
                peak = max(
                    [peak, *(self.contact_force(max(self.indentation(s), 0.0))[0] for s in states)]
                )
                rebound = float(self.centre @ y)
                first = t - begin if math.isnan(first) else first
            if run.status == 0:
                break
            touching = not touching
            begin = t if touching else begin
        if math.isnan(first):
            first, rebound = 0.0, float(self.centre @ y)
        return Outcome(peak, first, rebound)

    def _piece(
        self, method: str, rtol: float, begin: tuple[float, FloatArray, bool], deadline: float
    ) -> Any:
        t, y, touching = begin
        slope = self._in_contact(deadline) if touching else self._in_free_motion(deadline)
        options = {} if method in _EXPLICIT else {"jac": self._jacobian(touching)}
        run = scipy.integrate.solve_ivp(
            slope,
            (t, self.duration),
            y,
            method=method,
            rtol=rtol,
            atol=rtol * self.scale,
            events=self._events(touching),
            **options,
        )
        if run.status < 0:
            raise ConvergenceError(f"SciPy's {method} at t = {run.t[-1]:.6g} s: {run.message}")
        return run

    def _in_contact(self, deadline: float) -> Slope:
        matrix, push, depth, gap, force = (
            self.matrix,
            self.push,
            self.depth,
            self.gap,
            self.contact_force if self.compliance else self.force,
        )

        def slope(t: float, y: FloatArray) -> FloatArray:
            free = float(depth @ y) - gap
            rate: FloatArray = matrix @ y
            if free > 0.0:
                rate -= force(free)[0] * push
                if time.perf_counter() > deadline:
                    raise ConvergenceError(f"SciPy took too long and was stopped at t = {t:.6g} s")
            return rate

        return slope

    def _in_free_motion(self, deadline: float) -> Slope:
        matrix = self.matrix

        def slope(t: float, y: FloatArray) -> FloatArray:
            if time.perf_counter() > deadline:
                raise ConvergenceError(f"SciPy took too long and was stopped at t = {t:.6g} s")
            rate: FloatArray = matrix @ y
            return rate

        return slope

    def _jacobian(self, touching: bool) -> Callable[[float, FloatArray], FloatArray]:
        along = np.outer(self.push, self.depth)

        def jacobian(t: float, y: FloatArray) -> FloatArray:
            free = self.indentation(y)
            if not touching or free <= 0.0:
                return self.matrix
            return self.matrix - self.contact_force(free)[1] * along

        return jacobian

    def _events(self, touching: bool) -> list[Event]:
        depth, gap = self.depth, self.gap
        rate = depth @ self.matrix  # δ' = depth y', and depth·push = 0: the force only accelerates

        def ends(t: float, y: FloatArray) -> float:
            return float(depth @ y) - gap

        def deepest(t: float, y: FloatArray) -> float:
            return float(rate @ y)

        ends.terminal = True  # type: ignore[attr-defined]
        ends.direction = -1 if touching else 1  # type: ignore[attr-defined]
        deepest.direction = -1  # type: ignore[attr-defined]
        return [ends, deepest] if touching else [ends]


def ode_scene(
    stars: tuple[AOModel, AOModel],
    law: ContactLaw,
    *,
    velocity: float,
    duration: float,
    gap: float,
    length: float,
) -> OdeScene:
    """Return the equations of motion of two AO models.

    Parameters
    ----------
    law : ContactLaw
        Law without the compliance of meshes; see `effective_law`.
    length : float
        Size of the displacements, m, for absolute tolerances.

    Raises
    ------
    InputError
        If the law is not Hertz, PowerLaw or Linear.
    """
    halves = _half(stars[0]), _half(stars[1])
    mass = np.concatenate([half.mass for half in halves])
    n, ours = len(mass), len(halves[0].mass)
    stiffness = np.zeros((n, n))
    stiffness[:ours, :ours], stiffness[ours:, ours:] = (half.stiffness for half in halves)
    contact = np.concatenate([halves[0].contact, -halves[1].contact])
    compliance, force = halves[0].compliance + halves[1].compliance, _force(own_law(law))
    if isinstance(law, PatchLaw):
        # F = law(δ + c F): removing the patches' compliance c from the law puts -c in series.
        compliance -= law.compliance
        if math.isfinite(law.limit):
            force = _straight_beyond(force, law.limit + law.compliance * law.force(law.limit))
    matrix = np.zeros((2 * n, 2 * n))
    matrix[:n, n:] = np.eye(n)
    matrix[n:, :n] = -stiffness / mass[:, None]
    start, centre = np.zeros(2 * n), np.zeros(2 * n)
    start[n : n + ours] = velocity
    centre[n : n + ours] = halves[0].centre
    return OdeScene(
        matrix=matrix,
        push=np.concatenate([np.zeros(n), contact / mass]),
        depth=np.concatenate([contact, np.zeros(n)]),
        centre=centre,
        start=start,
        compliance=compliance,
        gap=gap,
        force=force,
        scale=np.concatenate([np.full(n, length), np.full(n, abs(velocity))]),
        duration=duration,
    )


def _force(law: ContactLaw) -> ForceLaw:
    if isinstance(law, Hertz):
        k, n = law.k, 1.5
    elif isinstance(law, PowerLaw):
        k, n = law.k, law.n
    elif isinstance(law, Linear):
        k, n = law.k, 1.0
    else:
        raise InputError(
            f"scipy: law={law!r} is not written out for SciPy; take Hertz, PowerLaw or Linear, or "
            "leave scipy empty"
        )

    def force(delta: float) -> tuple[float, float]:
        if delta <= 0.0:
            return 0.0, 0.0
        slope = k * delta ** (n - 1.0)
        return slope * delta, n * slope

    return force


def _straight_beyond(force: ForceLaw, deepest: float) -> ForceLaw:
    """Return a law continued by a straight line, since SciPy tries steps that it then rejects."""
    most, stiffness = force(deepest)

    def straight(delta: float) -> tuple[float, float]:
        if delta <= deepest:
            return force(delta)
        return most + stiffness * (delta - deepest), stiffness

    return straight
