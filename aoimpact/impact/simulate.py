"""An impact of two bodies: the scene of a moving projectile and a target at rest."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import partial
from time import perf_counter
from typing import Any, NamedTuple

from ..accuracy import StressAt, checked_linear_solver, checked_rtol, impact_quantity
from ..base import InputError, InputTypeError, boolean, nonnegative, warn
from ..fem import ContactPoint
from ..laws import ContactLaw, LawFromSurfaces
from ..linalg import LinearSolver, Solver
from ..reduction import BodyModel, FullModel, body_model
from ..results import RecordLength, Result, TimeSolver, warn_of_exchange
from ..scene import Contact, Plan, law_of_models, normal_gap
from .checks import checked_duration, checked_speed
from .defaults import Meeting, chosen_law, contact_width, fitted_pair, meeting, turns
from .run import RunOptions, run_models

__all__ = [
    "Impact",
    "checked_numbers",
    "complete_impact",
    "left_out_law",
    "plan_impact",
    "simulate",
]

_NAMES = "projectile", "target"


class ImpactNumbers(NamedTuple):
    """Velocity, m/s, duration, s, if given, and gap, m, of an impact."""

    velocity: float
    duration: float | None
    gap: float


def simulate(
    projectile: Any,
    target: Any,
    velocity: float,
    *,
    law: ContactLaw | None = None,
    duration: float | None = None,
    solver: TimeSolver | None = None,
    gap: float = 0.0,
    energies: bool = True,
    quantity: str | ContactPoint | StressAt | None = None,
    rtol: float | None = None,
    linear_solver: Solver | None = None,
) -> Result:
    """Simulate the impact of a moving projectile on a target at rest.

    Both bodies are undeformed at t = 0, the projectile moving with `velocity` towards the target.
    Arguments left out are determined from the bodies and reported in the result.

    Parameters
    ----------
    projectile, target : ContactPoint, AOModel, ModalModel or FullModel
        A contact point (``body.contact(...)``) is reduced as far as the quantity of interest
        allows; ``full(tip)`` is the full finite-element model. A model of a given number of
        oscillators is best made by ``antioscillators(tip, n, method="krylov", contact_time=)``. A
        patch whose radius was left out is 1.4 times as wide as the contact of rigid bodies.
    velocity : float
        Of the projectile along the direction of travel, m/s, not zero; negative only if the
        projectile is constrained, so that it swings back.
    law : ContactLaw, optional
        Force of the indentation δ = x_projectile - x_target - gap. If left out, Hertz's, from the
        materials of both bodies and the curvatures of their surfaces at the contact. The compliance
        that a mesh has in place of the law's half-space is taken out (`ContactPoint.extraction`).
    duration : float, optional
        Length of the record, s. If left out, until the impact is over and as long again.
    solver : Adaptive or Newmark, optional
        ``Adaptive(rtol=...)`` for a tolerance, ``Newmark(dt=...)`` for a given step. By default
        ``Adaptive()``; with a full finite-element model, whose modes would have to be computed
        first, ``Newmark()`` with a step of its own choice.
    gap : float, optional
        Distance to go before the bodies touch, m, not negative.
    energies : bool, optional
        Whether to record energies as well.
    quantity : str, ContactPoint or StressAt, optional
        The quantity of interest: "force" (over the record; the default), "peak_force", "peak_time",
        "impulse", "contact_duration" (of the first contact), "contact_count" (how often they
        touch), "rebound_velocity", "restitution", "projectile_displacement" or
        "target_displacement" (of the contact point, over the record); or a point of a body, for its
        displacement over the record, or a `StressAt`, for its stress. Contact points are reduced as
        far as the tolerance allows, and AO models truncated if this or `rtol` is given;
        `Result.models` are those taken. Only this quantity is right to `rtol`:
        `Result.error` estimates the errors of the others by name.
    rtol : float, optional
        Its relative error by reduction and time integration. If left out, 2e-3, or up to 1e-2
        where 2e-3 takes a third more oscillators. That of a history is its largest over the record,
        relative to the largest value. A solver that does not keep it is refused;
        where no models tried meet it, so is the tolerance if it was given, and else the best of
        them are taken, with a warning. `Result.error` has the errors of mesh and contact as well.
    linear_solver : {"auto", "superlu", "pardiso", "multigrid"} or callable, optional
        What solves for these reduced models, as `solver` of `antioscillators`; named in the result.

    Returns
    -------
    Result

    Raises
    ------
    InputError, InputTypeError
        For an argument that makes no sense, or a law that is left out and not known.
    ConvergenceError
        If the step cannot be solved or the error estimate cannot be brought down to `rtol`.

    Warns
    -----
    AOImpactWarning
        If no models tried meet the tolerance that was left out, the record ends in contact, the
        step is too large for any digit to be right, a body's centre of mass is not known, or its
        model was fitted to another contact time.

    Examples
    --------
    >>> ball = ao.ball(0.01, ao.Material(E=210e9, nu=0.3, rho=7800))
    >>> hit = ao.simulate(projectile=ball, target=ball, velocity=1.0)
    >>> round(hit.peak_force, 1), round(hit.law.k / 1e9, 2)  # N, GN/m^1.5
    (1001.5, 10.88)
    """
    began = perf_counter()
    numbers = checked_numbers(velocity, duration, gap, energies)
    options = RunOptions(quantity, rtol, solver, energies, linear_solver)
    bodies = body_model("projectile", projectile), body_model("target", target)
    warn_of_exchange(*_pair(*bodies, numbers.velocity))
    interest = partial(impact_quantity, quantity, *bodies)
    # Bad input is refused before any work is done.
    checked_linear_solver(linear_solver, chosen=options.chooses(bodies))
    if options.controlled:
        checked_rtol(rtol)
        interest()
    impact = complete_impact(*bodies, law, numbers)
    result = run_models(
        impact.plan,
        impact.bodies,
        options,
        record=impact.record,
        names=_called(bodies),
        interest=interest,
        law_errors=(impact.law_error,),
        began=began,
        factors=impact.factors,
    )
    assert isinstance(result, Result)
    if result.in_contact_at_end and duration is not None:
        warn(
            f"the record of {result.duration:.4g} s ends in contact: impulse and the last "
            "contact's end are those so far, and there is no rebound (NaN); take a longer duration"
        )
    return result


class Impact(NamedTuple):
    """An impact with defaults for all that its caller left out.

    Attributes
    ----------
    bodies : tuple
        With patches fitted to the impact.
    turns : tuple of bool
        Whether the direction of travel of each body must be reversed.
    law : ContactLaw
    law_error : float
        Relative error of its stiffness, where it was found from the surfaces.
    numbers : ImpactNumbers
    record : RecordLength
    met : Meeting or None
        What is foreseen of the contact, where something was left to foresee.
    width : float or None
        Radius of the contact, m.
    factors : dict of body to LinearSolver
        Those that have been set up for the defaults.
    """

    bodies: tuple[BodyModel, BodyModel]
    turns: tuple[bool, bool]
    law: ContactLaw
    law_error: float
    numbers: ImpactNumbers
    record: RecordLength
    met: Meeting | None
    width: float | None
    factors: dict[Any, LinearSolver]

    def plan(self, models: Sequence[Any], energies: bool) -> Plan:
        """Return the plan of its bodies, or of models in their place."""
        first, second = (
            model.turned((0,)) if turn else model
            for model, turn in zip(models, self.turns, strict=True)
        )
        pair = _pair(first, second, self.numbers.velocity)
        length, gap = self.record.length, self.numbers.gap
        return _planned(pair, self.law, self.width, self.numbers.velocity, length, gap, energies)


def complete_impact(
    projectile: BodyModel, target: BodyModel, law: ContactLaw | None, numbers: ImpactNumbers
) -> Impact:
    """Return an impact with defaults for all that was left out.

    Raises
    ------
    InputError, InputTypeError
        If a law or a duration that was left out is not known, or a direction is wrong.
    """
    bodies, factors = (projectile, target), dict[Any, LinearSolver]()
    around = _turns(*bodies)
    error, met = 0.0, None
    if law is None:
        found = _law_of_surfaces(bodies, around)
        law, error = found.law, found.error
    _check_law(law)
    length = numbers.duration
    if length is None or any(isinstance(body, FullModel) for body in bodies):
        met = meeting(law, bodies, numbers.velocity)
        bodies = fitted_pair(*bodies, met, factors)
        if length is None:
            if met is None:
                raise InputError("duration was left out, and cannot be foreseen here; give it")
            record = RecordLength(
                numbers.gap / abs(numbers.velocity) + met.contact_time, given=False
            )
    if length is not None:
        record = RecordLength(length, given=True)
    width = _width(law, (projectile, target), numbers.velocity)
    return Impact(bodies, around, law, error, numbers, record, met, width, factors)


def _width(law: ContactLaw, bodies: Sequence[BodyModel], velocity: float) -> float | None:
    """The radius of the contact, m, where a body is known by its mesh; see `law_of_models`."""
    meshed = any(body.contact_points for body in bodies)
    return contact_width(law, bodies, velocity) if meshed else None


def _law_of_surfaces(bodies: Sequence[BodyModel], turned: Sequence[bool]) -> LawFromSurfaces:
    ends = [
        (body.turned((0,)) if turn else body, 0) for body, turn in zip(bodies, turned, strict=True)
    ]
    return chosen_law(ends, _called(bodies))


def left_out_law(projectile: Any, target: Any, law: ContactLaw | None) -> ContactLaw:
    """Return the law of an impact: as given, or that which `simulate` takes where it is left out.

    Raises
    ------
    InputError, InputTypeError
        If it is none, or was left out and is not known.
    """
    if law is not None:
        _check_law(law)
        return law
    bodies = body_model("projectile", projectile), body_model("target", target)
    return _law_of_surfaces(bodies, _turns(*bodies)).law


def _turns(projectile: BodyModel, target: BodyModel) -> tuple[bool, bool]:
    """Whether the direction of travel of each body must be reversed; see `turns`."""
    tip = projectile.touched_at()
    like = tip is not None and tip is target.touched_at()
    return (
        turns("projectile", projectile, 0, outward=True, like=like),
        turns("target", target, 0, outward=False, like=like),
    )


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
    _check_law(law)
    numbers = checked_numbers(velocity, duration, gap, energies)
    pair = _pair(projectile, target, numbers.velocity)
    width = _width(law, pair, numbers.velocity)
    length = checked_duration(duration)
    return _planned(pair, law, width, numbers.velocity, length, numbers.gap, energies)


def _planned(
    bodies: tuple[BodyModel, BodyModel],
    law: ContactLaw,
    width: float | None,
    velocity: float,
    length: float,
    distance: float,
    energies: bool,
) -> Plan:
    if math.isinf(bodies[0].static_mass) and math.isinf(bodies[1].static_mass):
        raise InputError(
            "projectile and target are both of infinite mass: there is no motion between them"
        )
    between = law_of_models(law, [(body, 0) for body in bodies], width)
    contact = Contact(0, 0, 1, 0, between, normal_gap(distance))
    return Plan(bodies, (velocity, 0.0), (contact,), (), 0.0, length, energies)


def _pair(projectile: Any, target: Any, speed: float) -> tuple[BodyModel, BodyModel]:
    """The bodies of an impact, refused where they cannot meet in one."""
    bodies = body_model("projectile", projectile), body_model("target", target)
    for name, body in zip(_NAMES, bodies, strict=True):
        if body.ports > 1:
            raise InputTypeError(
                f"{name} is touched in several places: build a Scene, and connect its ports"
            )
    if speed < 0.0 and not bodies[0].constrained:
        raise InputError(
            f"velocity={speed:g} m/s: the projectile flies away from the target, and nothing "
            "turns it round; give the speed at which it comes, or build a Scene with what brings "
            "it back (gravity, a load, a body behind it)"
        )
    return bodies


def _called(bodies: Sequence[BodyModel]) -> list[str]:
    """Names of the bodies in messages: their role, and their own name."""
    return [
        f"{role} ({body.name})" if body.name else role
        for role, body in zip(_NAMES, bodies, strict=True)
    ]


def _check_law(law: Any) -> None:
    if not isinstance(law, ContactLaw):
        raise InputTypeError(f"law must be a contact law such as Hertz(k=...), got {law!r}")


def checked_numbers(velocity: Any, duration: Any, gap: Any, energies: Any) -> ImpactNumbers:
    """Check what `simulate` is given beside its bodies.

    Raises
    ------
    InputError, InputTypeError
        For an argument that makes no sense.
    """
    speed = checked_speed("velocity", velocity)
    if speed == 0.0:
        raise InputError("velocity is 0 m/s: nothing would move; give the projectile a velocity")
    length = None if duration is None else checked_duration(duration)
    distance = nonnegative("gap", gap, unit="m")
    boolean("energies", energies)
    return ImpactNumbers(speed, length, distance)
