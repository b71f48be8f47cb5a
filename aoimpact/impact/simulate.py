"""An impact of two bodies: the scene of a moving projectile and a target at rest."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import partial
from typing import Any, NamedTuple

from ..accuracy import StressAt, TimeSolver, impact_quantity
from ..base import InputError, InputTypeError, boolean, nonnegative, warn
from ..fem import ContactPoint
from ..laws import ContactLaw, effective_law
from ..linalg import Solver
from ..reduction import InterfaceModel
from ..results import Result, Run
from ..scene import Joint, Plan, normal_gap, scene_body
from .checks import checked_duration, checked_speed
from .run import RunOptions, run_models

__all__ = ["checked_numbers", "plan_impact", "simulate"]

_NAMES = "projectile", "target"


def simulate(
    *,
    projectile: Any,
    target: Any,
    law: ContactLaw,
    velocity: float,
    duration: float,
    solver: TimeSolver | None = None,
    gap: float = 0.0,
    energies: bool = True,
    quantity: str | ContactPoint | StressAt | None = None,
    rtol: float | None = None,
    linear_solver: Solver | None = None,
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
        Of the projectile along the direction of travel, m/s, not zero; negative only if the
        projectile is constrained, so that it swings back.
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
    quantity : str, ContactPoint or StressAt, optional
        The quantity of interest: "force" (over the record), "peak_force", "peak_time", "impulse",
        "contact_duration" (of the first contact), "contact_count" (how often they touch),
        "rebound_velocity", "restitution", "projectile_displacement" or "target_displacement" (of
        the contact point, over the record); or a point of a body, for its displacement over the
        record, or a `StressAt`, for its stress. Given this or `rtol`, finite-element bodies are
        reduced, and AO models truncated, as far as the tolerance allows; `Result.models` are those
        taken. Only this quantity is right to `rtol`: `Result.error.numbers` estimates the errors of
        the others.
    rtol : float, optional
        Its relative error, 1e-2 if left out; that of a history is its largest over the record,
        relative to the largest value. A solver that does not keep it is refused.
    linear_solver : {"auto", "banded", "superlu", "pardiso", "multigrid"} or callable, optional
        What solves for these reduced models, as `solver` of `antioscillators`; named in the result.

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
        If the record ends in contact, the step is too large for any digit to be right, a body's
        centre of mass is not known, or its model was fitted to another contact time.
    """
    options = RunOptions(quantity, rtol, solver, energies, linear_solver)
    if options.chooses:  # before any model is made
        checked_numbers(law, velocity, duration, gap, energies)

    def plan_of(models: Sequence[Any], energies: bool) -> Plan:
        first, second = models
        return plan_impact(
            first, second, law, velocity=velocity, duration=duration, gap=gap, energies=energies
        )

    result = run_models(
        plan_of,
        (projectile, target),
        options,
        names=_NAMES,
        interest=partial(impact_quantity, quantity, projectile, target),
        view=_result,
    )
    if result.in_contact_at_end:
        warn(
            f"the record of {result.duration:.4g} s ends in contact: impulse and the last "
            "contact's end are those so far, and there is no rebound (NaN); take a longer duration"
        )
    return result


def _result(run: Run) -> Result:
    joint = run.plan.joints[0]
    return Result(run=run, velocity=run.plan.velocities[0], gap=joint.gap, law=joint.law)


def plan_impact(
    projectile: Any,
    target: Any,
    law: ContactLaw,
    *,
    velocity: float,
    duration: float,
    gap: float = 0.0,
    energies: bool = True,
) -> Plan:
    """Check what `simulate` is given, and return it as the solvers take it.

    Raises
    ------
    InputError, InputTypeError
        For an argument that makes no sense.
    """
    speed, length, distance = checked_numbers(law, velocity, duration, gap, energies)
    bodies = scene_body("projectile", projectile, speed), scene_body("target", target, 0.0)
    for name, body in zip(_NAMES, bodies, strict=True):
        if body.ports > 1 or isinstance(body.model, InterfaceModel):
            raise InputTypeError(
                f"{name} is touched in several places: build a Scene, and connect its ports"
            )
    if speed < 0.0 and not bodies[0].constrained:
        raise InputError(
            f"velocity={speed:g} m/s: the projectile flies away from the target, and nothing turns "
            "it round; give the speed at which it comes, or build a Scene with what brings it back "
            "(gravity, a load, a body behind it)"
        )
    if math.isinf(bodies[0].static_mass) and math.isinf(bodies[1].static_mass):
        raise InputError(
            "projectile and target are both of infinite mass: there is no motion between them"
        )
    ends = projectile, target
    joint = Joint(0, 0, 1, 0, effective_law(law, ends), normal_gap(distance), ends)
    return Plan(bodies, (speed, 0.0), (joint,), (), 0.0, length, energies)


class ImpactNumbers(NamedTuple):
    """Velocity, m/s, duration, s, and gap, m, of an impact."""

    velocity: float
    duration: float
    gap: float


def checked_numbers(
    law: Any, velocity: Any, duration: Any, gap: Any, energies: Any
) -> ImpactNumbers:
    """Check what `simulate` is given beside its bodies.

    Raises
    ------
    InputError, InputTypeError
        For an argument that makes no sense.
    """
    speed = checked_speed("velocity", velocity)
    if speed == 0.0:
        raise InputError("velocity is 0 m/s: nothing would move; give the projectile a velocity")
    length = checked_duration(duration)
    distance = nonnegative("gap", gap, unit="m")
    boolean("energies", energies)
    if not isinstance(law, ContactLaw):
        raise InputTypeError(f"law must be a contact law such as Hertz(k=...), got {law!r}")
    return ImpactNumbers(speed, length, distance)
