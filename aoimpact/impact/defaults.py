"""Checks of the arguments of a run, and defaults from the bodies for those left out."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any, NamedTuple

from ..accuracy import alike
from ..base import (
    HUGE,
    AOImpactError,
    ConvergenceError,
    InputError,
    nonnegative,
    plain,
    positive,
    real,
)
from ..fem import SHIFT_TIMES_DURATION, ContactPoint, contact_within
from ..integrate import rigid_contact_time
from ..laws import ContactLaw, LawFromSurfaces, law_between, round_contact
from ..linalg import LinearSolver
from ..reduction import BodyModel, FullModel
from ..results import warn_of_size

# m/s; squares and energies of speeds beyond these overflow, or vanish.
_SLOWEST, _FASTEST = 1e-60, 1e60

# s; their cubes are numbers, and so is the distance that the fastest body covers.
_SHORTEST, _LONGEST = 1.0 / HUGE, HUGE

# m/s², the most on a neutron star. Above ten times as much, depths of contacts are no more than the
# rounding of the ways that bodies fall, and drawn scenes were wrong by 1e-7 to 1e-4.
_HEAVIEST = 1e12


def checked_duration(duration: Any) -> float:
    """Return the length of a record, s, over which displacements do not overflow."""
    length = positive("duration", duration, unit="s")
    if not _SHORTEST <= length <= _LONGEST:
        raise InputError(
            f"duration={length:g} s is beyond what can be computed: {_SHORTEST:g} to {_LONGEST:g} s"
        )
    return length


def checked_speed(velocity: Any) -> float:
    """Return a speed, m/s, whose square neither overflows nor vanishes.

    Raises
    ------
    InputError
    """
    speed = real("velocity", velocity, unit="m/s")
    if speed != 0.0 and not _SLOWEST <= abs(speed) <= _FASTEST:
        raise InputError(
            f"velocity={speed:g} m/s: its square is beyond the range of numbers; give a speed from "
            f"{_SLOWEST:g} to {_FASTEST:g} m/s"
        )
    return speed


def checked_gravity(value: Any) -> float:
    """Return an acceleration, m/s², beside which contacts are still resolved.

    Raises
    ------
    InputError
    """
    pull = real("gravity", value, unit="m/s²")
    if abs(pull) > _HEAVIEST:
        raise InputError(
            f"gravity={pull:g} m/s² is beyond what contacts can be resolved beside: give up to "
            f"{_HEAVIEST:g} m/s²"
        )
    return pull


def checked_numbers(velocity: Any, duration: Any, gap: Any) -> tuple[float, float | None, float]:
    """Return velocity, m/s, duration, s, if given, and gap, m, of an impact.

    Raises
    ------
    InputError, InputTypeError
        For an argument that makes no sense.
    """
    speed = checked_speed(velocity)
    if speed == 0.0:
        raise InputError("velocity is 0 m/s: nothing would move; give the projectile a velocity")
    length = None if duration is None else checked_duration(duration)
    return speed, length, nonnegative("gap", gap, unit="m")


def turns(name: str, body: BodyModel, port: int, *, outward: bool, like: bool = False) -> bool:
    """True if the direction at a contact must be turned round, to go out of the body or into it.

    Parameters
    ----------
    name : str
        Name of the body.
    body : model
    port : int
        Which of its places.
    outward : bool
        Whether it must go out of the body, which is then on the projectile's side.
    like : bool, optional
        Whether the same place stands for another body on the other side, so that the direction
        suits one of them.

    Raises
    ------
    InputError
        If it was given the wrong way round.
    """
    tip = body.touched_at(port)
    if tip is None or tip.normal is None or tip.direction is None or tip.point is None:
        return False
    if (float(tip.direction @ tip.normal) > 0.0) == outward:
        return False
    if like:
        return True
    if tip.directed and tip.thin is None:
        way, opposite = ("out of", "into") if outward else ("into", "out of")
        raise InputError(
            f"{name}: direction {plain(tip.direction)} goes {opposite} the body at point "
            f"{plain(tip.point)} m, whose outward normal is {plain(tip.normal)}. It is the "
            "projectile's direction of travel, out of the projectile and into the target, and goes "
            f"{way} this body: leave direction out, turn it round, or swap the two bodies"
        )
    return True


def chosen_law(ends: Sequence[tuple[BodyModel, int]], names: Sequence[str]) -> LawFromSurfaces:
    """Return Hertz's law of two bodies from their surfaces and materials.

    Parameters
    ----------
    ends : sequence of (model, int)
        Projectile and target, and at which of their places they touch.
    names : sequence of str
        Names of both.

    Raises
    ------
    InputError
        If a surface is not known, or they have no Hertz contact.
    """
    surfaces = []
    tips = [body.touched_at(port) for body, port in ends]
    for name, (body, port) in zip(names, ends, strict=True):
        surface = body.surface_at(port)
        if surface is None:
            raise InputError(
                f"law: it was left out, but {name}, {body!r}, does not know its surface and "
                "material; give law=, such as Hertz.between(...), or a body made by "
                "FEModel.from_mesh(...).contact(point=...), or ball(radius, material)"
            )
        surfaces.append(surface)
    for (body, _), surface, tip, name, other in zip(
        ends, surfaces, reversed(tips), names, reversed(names), strict=True
    ):
        if not body.tips:
            warn_of_size(abs(surface.radii[0]), tip, name, other)
    along = [None if tip is None else tip.direction for tip in tips]
    try:
        return law_between(
            surfaces[0], surfaces[1], projectile_direction=along[0], target_direction=along[1]
        )
    except InputError as error:
        raise InputError(f"law: it was left out, but {error}") from None


class Meeting(NamedTuple):
    """The contact of two rigid bodies.

    Attributes
    ----------
    contact_time : float
        s.
    contact_radius : float or None
        At the peak, m; None for a law without one.
    """

    contact_time: float
    contact_radius: float | None


def meeting(
    law: ContactLaw, bodies: Sequence[BodyModel], velocity: float, *, strict: bool = False
) -> Meeting | None:
    """Estimate an impact by rigid bodies, whose indentation is larger than that of elastic ones.

    None where nothing moves, both masses are infinite, or the law never takes the energy.

    Parameters
    ----------
    law : ContactLaw
    bodies : sequence of two models
    velocity : float
        At which they meet, m/s.
    strict : bool, optional
        True to raise the error of a law that gives no number.
    """
    mass, speed = _reduced_mass(bodies), abs(velocity)
    if speed == 0.0 or math.isinf(mass):
        return None
    try:
        duration = rigid_contact_time(law, mass, speed)
    except AOImpactError as error:
        if strict and isinstance(error, ConvergenceError):
            raise
        return None
    return Meeting(duration, contact_width(law, bodies, velocity))


def contact_width(law: ContactLaw, bodies: Sequence[BodyModel], velocity: float) -> float | None:
    """Return the radius of the contact of rigid bodies at their largest force, m.

    None where nothing moves, the law has no surface, or never takes the energy.
    """
    mass, speed = _reduced_mass(bodies), abs(velocity)
    if speed == 0.0 or math.isinf(mass):
        return None
    known = [body.touched_at() or body.surface_at() for body in bodies]
    # A body of unknown material is taken to be rigid.
    found = round_contact(law, [of.material for of in known if of is not None])
    radius = law.relative_radius if found is None else found.radius
    try:
        return None if radius is None else math.sqrt(radius * law.stroke(0.5 * mass * speed**2))
    except AOImpactError:
        return None


def _reduced_mass(bodies: Sequence[BodyModel]) -> float:
    share = math.fsum(1.0 / body.most_mass for body in bodies)
    return 1.0 / share if share > 0.0 else math.inf


def fitted(
    body: BodyModel,
    port: int,
    met: Meeting | None,
    factors: dict[Any, LinearSolver],
    *,
    wider: bool,
) -> BodyModel:
    """Return a body with a patch wide enough for an impact, where its radius was left out.

    Solvers that are set up are put into `factors`, by their finite-element body.
    """
    if not isinstance(body, FullModel) or met is None or met.contact_radius is None:
        return body
    tip = body.tips[port]
    if not tip.automatic:
        return body
    radius, time = alike(met.contact_radius, up=True), alike(met.contact_time)

    def pressed() -> ContactPoint:
        wide = contact_within(tip, radius, wider=wider)
        if tip.body not in factors:
            factors[tip.body] = tip.body.inverse((SHIFT_TIMES_DURATION / time) ** 2)
        return wide.at_impact(radius, factors[tip.body])

    fit = tip.body.kept.get(("patch", tip.key, radius, time, wider), pressed)
    return replace(body, tips=(*body.tips[:port], fit, *body.tips[port + 1 :]))
