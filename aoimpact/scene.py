"""An impact of two bodies: `simulate`."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
import scipy.optimize

from .adaptive import TIGHTEST, Adaptive, Track, adaptive_run
from .checks import boolean, nonnegative, positive, real
from .errors import ConvergenceError, InputError, InputTypeError, warn
from .events import Events, find_peak
from .laws import ContactLaw
from .newmark import Newmark, Record, newmark_run
from .players import Player, StarPlayer, player
from .relative import relative
from .result import BodyInfo, ErrorEstimate, Result, result_from_record

__all__ = ["simulate"]

FloatArray = npt.NDArray[np.float64]

# One contact keeps its tolerance; from the second on the run is asked twice.
_CONTACTS_TRUSTED = 1

# Squares and energies of speeds beyond these overflow, or vanish.
_SLOWEST, _FASTEST = 1e-60, 1e60

# The steps of a first attempt within a contact, when the caller leaves dt to us.
_FIRST_STEPS = 100

# Above this relative change between two steps, second order is not in sight yet.
_NOT_ASYMPTOTIC = 0.2

# Share of the peak force above which the force is compared between two steps.
_AROUND_PEAK = 0.9


def simulate(
    *,
    projectile: Any,
    target: Any,
    law: ContactLaw,
    velocity: float,
    duration: float,
    solver: Adaptive | Newmark | None = None,
    gap: float = 0.0,
    energies: bool = True,
) -> Result:
    """Simulate the impact of a moving projectile on a target at rest.

    Both bodies are undeformed at t = 0, the projectile moving with `velocity` towards the target.

    Parameters
    ----------
    projectile, target : AOModel, ModalModel or ContactPoint
        A ContactPoint (``body.contact(...)``) stands for the full finite-element model.
    law : ContactLaw
        Force of the indentation δ = x_projectile - x_target - gap.
    velocity : float
        Of the projectile along the direction of travel, m/s, not zero.
    duration : float
        Length of the record, s.
    solver : Adaptive or Newmark, optional
        ``Adaptive(rtol=...)`` for a tolerance, ``Newmark(dt=...)`` for a given step. By default
        ``Adaptive()``; with a full finite-element model, whose modes would have to be computed
        first, ``Newmark()`` with a step of its own choice.
    gap : float, optional
        Distance to go before the bodies touch, m, not negative.
    energies : bool, optional
        Whether to record energies as well.

    Returns
    -------
    Result

    Raises
    ------
    InputError, InputTypeError
        For an argument that makes no sense.
    ConvergenceError
        If the step cannot be solved or the error estimate cannot be brought down to `rtol`.

    Warns
    -----
    AOImpactWarning
        If the record ends in contact, or the step is too large for any digit to be right.
    """
    speed = real("velocity", velocity, unit="m/s")
    if speed == 0.0:
        raise InputError("velocity is 0 m/s: nothing would move; give the projectile a velocity")
    if not _SLOWEST <= abs(speed) <= _FASTEST:
        raise InputError(
            f"velocity={speed:g} m/s: its square is beyond the range of numbers; give a speed from "
            f"{_SLOWEST:g} to {_FASTEST:g} m/s"
        )
    length = positive("duration", duration, unit="s")
    distance = nonnegative("gap", gap, unit="m")
    boolean("energies", energies)
    if not isinstance(law, ContactLaw):
        raise InputTypeError(f"law must be a contact law such as Hertz(k=...), got {law!r}")
    bodies = player("projectile", projectile, speed), player("target", target, 0.0)
    rule = default_solver(bodies) if solver is None else solver
    if not isinstance(rule, (Newmark, Adaptive)):
        raise InputTypeError(f"solver must be Adaptive(...) or Newmark(...), got {solver!r}")
    if all(math.isinf(body.static_mass) for body in bodies):
        raise InputError("projectile and target are both of infinite mass: nothing can give way")
    if isinstance(rule, Adaptive):
        return _adaptive(bodies, law, rule, speed, length, distance, energies)
    run = _Run(bodies, law, speed, rule, length, distance, energies)
    record, error = run.with_step(rule.dt) if rule.dt is not None else run.with_tolerance()
    return _finish(run, record, error)


def default_solver(bodies: tuple[Player, Player]) -> Adaptive | Newmark:
    """Return Adaptive where the bodies are stars already."""
    return Adaptive() if all(isinstance(body, StarPlayer) for body in bodies) else Newmark()


@dataclass(frozen=True, eq=False)
class _Sampled:
    """An adaptive run, to be seen at any times."""

    track: Track
    bodies: tuple[BodyInfo, BodyInfo]
    unseen: tuple[float, float]
    rtol: float
    time_error: float
    velocity: float
    energies: bool

    def __call__(self, times: FloatArray) -> Result:
        rows = self.track.sample(times)
        _add_unseen(rows, times, self.unseen, self.velocity)
        energy = _energy_range(rows) if self.energies else None
        return result_from_record(
            t=times,
            record=rows,
            projectile=self.bodies[0],
            target=self.bodies[1],
            law=self.track.law,
            velocity=self.velocity,
            gap=self.track.relative.gap,
            solver=f"Adaptive(rtol={self.rtol:g}), {self.track.steps} steps in contact",
            error=ErrorEstimate(time=self.time_error, energy=energy),
            energies=self.energies,
            events=self.track.events,
            dense=self,
        )


def _adaptive(
    bodies: tuple[Player, Player],
    law: ContactLaw,
    rule: Adaptive,
    velocity: float,
    duration: float,
    gap: float,
    energies: bool,
) -> Result:
    modes = relative(bodies[0].star, bodies[1].star, gap)
    track = adaptive_run(modes, law, rtol=rule.rtol, velocity=velocity, duration=duration)
    error = rule.rtol
    if len(track.events.contacts) > _CONTACTS_TRUSTED and rule.rtol > 10.0 * TIGHTEST:
        # Errors grow from contact to contact, in a chattering scene without bound: look how far.
        first, tighter = track, 0.1 * rule.rtol
        track = adaptive_run(modes, law, rtol=tighter, velocity=velocity, duration=duration)
        error = max(error, _difference(first.events, track.events))
        if error > rule.rtol:
            warn(
                f"rtol={rule.rtol:g} is not kept over {len(track.events.contacts)} contacts, each "
                f"of which enlarges the errors before: with rtol={tighter:g} the run differs "
                f"by {error:.2g}; take a smaller rtol, or trust the first contacts only"
            )
    coordinates, rates = modes.coordinates(track.x), modes.coordinates(track.v)
    projectile, target = (
        BodyInfo(body.label, body.mass, body.held, coordinates[i], rates[i])
        for i, body in enumerate(bodies)
    )
    seen = _Sampled(
        track, (projectile, target), bodies[0].unseen, rule.rtol, error, velocity, energies
    )
    result = seen(track.times)
    _warn(result, None)
    return result


def _difference(one: Events, other: Events) -> float:
    """Relative difference of peak force and impulse; 1 where the number of contacts differs."""
    if len(one.contacts) != len(other.contacts):
        return 1.0
    return max(abs(one.peak_force / other.peak_force - 1.0), abs(one.impulse / other.impulse - 1.0))


def _energy_range(rows: FloatArray) -> float | None:
    """Range of the total energy relative to the initial one; None where a wall brings it all."""
    total = rows[2] + rows[7] + rows[8] + rows[13] + rows[14]
    return float(np.ptp(total) / total[0]) if total[0] > 0.0 else None


def _add_unseen(rows: FloatArray, t: FloatArray, unseen: tuple[float, float], speed: float) -> None:
    """What a star leaves out moves on with the initial velocity, untouched (a target's is zero)."""
    share, mass = unseen
    rows[5] += share * speed * t
    rows[6] += share * speed
    rows[7] += 0.5 * mass * speed**2


class _Run:
    """One impact, to be run with different steps."""

    def __init__(
        self,
        bodies: tuple[Player, Player],
        law: ContactLaw,
        velocity: float,
        rule: Newmark,
        duration: float,
        gap: float,
        energies: bool,
    ) -> None:
        self.bodies, self.law, self.velocity, self.rule = bodies, law, velocity, rule
        self.duration, self.gap, self.energies = duration, gap, energies

    def once(self, dt: float, *, energies: bool) -> Record:
        return newmark_run(
            *self.bodies,
            self.law,
            rule=self.rule,
            dt=dt,
            duration=self.duration,
            gap=self.gap,
            energies=energies,
        )

    def with_step(self, dt: float) -> tuple[Record, float | None]:
        """Run with a given step, and with twice that step for the error estimate."""
        record = self.once(dt, energies=self.energies)
        if not self.rule.estimate:
            return record, None
        return record, step_error(record, self.once(2.0 * dt, energies=False))

    def with_tolerance(self) -> tuple[Record, float]:
        """Halve the step until two successive ones agree."""
        dt = self.first_step()
        coarse = self.once(dt, energies=False)
        for _ in range(16):
            dt *= 0.5
            fine = self.once(dt, energies=self.energies)
            error = step_error(fine, coarse)
            if error <= self.rule.rtol:
                return fine, error
            coarse = fine
        raise ConvergenceError(
            f"Newmark: with dt={dt:.3g} s the estimated error of the peak force is still "
            f"{error:.2g}, above rtol={self.rule.rtol:g}; give dt, or a larger rtol"
        )

    def first_step(self) -> float:
        """A hundredth of the contact time that rigid bodies would have."""
        inverse = sum(1.0 / body.static_mass for body in self.bodies)
        time = rigid_contact_time(self.law, 1.0 / inverse, abs(self.velocity))
        return min(time / _FIRST_STEPS, self.duration / 20.0)


def rigid_contact_time(law: ContactLaw, mass: float, velocity: float) -> float:
    """Estimate how long a contact of a rigid `mass`, kg, at `velocity`, m/s, lasts, s.

    Three times the largest indentation over the velocity: 2.94 for Hertz, π for a linear law.
    """
    energy = 0.5 * mass * velocity**2

    def excess(log_indentation: float) -> float:
        return math.log(max(law.potential(math.exp(log_indentation)), 1e-300) / energy)

    low, high = -70.0, 10.0
    if not excess(low) < 0.0 < excess(high):
        raise InputError(
            f"law={law!r} with velocity={velocity:g} m/s: no contact time can be estimated; give dt"
        )
    return 3.0 * math.exp(scipy.optimize.brentq(excess, low, high, xtol=1e-6)) / velocity


def step_error(fine: Record, coarse: Record) -> float:
    """Richardson's estimate of the relative error of the peak force from steps dt and 2dt.

    A third of the largest change of the force around its peak, not only of the peak itself: where
    light masses ring, two peaks may agree by chance. Where the change is more than a fifth, second
    order is not in sight, and no digit is claimed.
    """
    shared = min(len(coarse.t), (len(fine.t) + 1) // 2)
    ours, theirs = fine.rows[0][: 2 * shared : 2], coarse.rows[0][:shared]
    (peak, _), (coarse_peak, _) = find_peak(fine.t, fine.rows[0]), find_peak(coarse.t, theirs)
    largest = max(peak, coarse_peak)
    if largest == 0.0:
        return 0.0
    around = np.maximum(ours, theirs) >= _AROUND_PEAK * largest
    change = float(np.abs(ours - theirs)[around].max(initial=abs(peak - coarse_peak))) / largest
    return change / 3.0 if change <= _NOT_ASYMPTOTIC else 1.0


def _finish(run: _Run, record: Record, error: float | None) -> Result:
    rows, speed = record.rows, run.velocity
    _add_unseen(rows, record.t, run.bodies[0].unseen, speed)
    infos = [
        BodyInfo(body.label, body.mass, body.held, *final)
        for body, final in zip(run.bodies, record.final, strict=True)
    ]
    result = result_from_record(
        t=record.t,
        record=rows,
        projectile=infos[0],
        target=infos[1],
        law=run.law,
        velocity=speed,
        gap=run.gap,
        solver=f"Newmark(dt={record.dt:.6g}, beta={run.rule.beta:g}, gamma={run.rule.gamma:g})",
        error=ErrorEstimate(time=error, energy=_energy_range(rows) if run.energies else None),
        energies=run.energies,
    )
    _warn(result, record.dt)
    return result


def _warn(result: Result, dt: float | None) -> None:
    if result.in_contact_at_end:
        warn(
            f"the record of {result.t[-1]:.4g} s ends in contact: rebound, impulse and the last "
            "contact's end are those so far; take a longer duration"
        )
    if dt is not None and result.error.time == 1.0:
        warn(
            f"dt={dt:g} s is far too large: with 2dt the peak force changes by more than a fifth; "
            "take a smaller dt"
        )
