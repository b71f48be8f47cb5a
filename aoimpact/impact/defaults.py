"""Checks of the arguments of a run, and defaults from the bodies for those left out."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from ..base import HUGE, InputError, nonnegative, plain, positive, real
from ..laws import LawFromSurfaces, law_between
from ..reduction import BodyModel
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
