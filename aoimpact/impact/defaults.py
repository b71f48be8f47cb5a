"""What a caller leaves out, from what the bodies themselves know: direction, law, patches, time."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import cache
from typing import Any, NamedTuple

import numpy as np

from ..accuracy import best_radius
from ..base import AOImpactError, InputError, plain
from ..fem import ContactPoint, contact_at
from ..laws import ContactLaw, LawFromSurfaces, law_between
from ..linalg import LinearSolver
from ..reduction import AOModel, InterfaceModel

__all__ = ["Meeting", "chosen_law", "fitted_patch", "meeting", "points_of", "turned", "turns"]

# A contact of Hertz's law lasts 2.94 times its depth over the speed (Johnson, eq. 11.25).
_DURATION_OVER_DEPTH = 2.94

# Logarithms of depth, m, between which that of an impact lies, and to which it is found.
_SHALLOWEST, _DEEPEST, _EXACT = math.log(1e-15), math.log(1e3), 1e-3


def points_of(body: Any) -> tuple[ContactPoint, ...]:
    """Return the contact points of a body, or of what its model was made from."""
    if isinstance(body, ContactPoint):
        return (body,)
    if isinstance(body, tuple):
        return body
    return getattr(body, "contact_points", ())


def turns(name: str, body: Any, port: int, *, outward: bool) -> bool:
    """Whether the direction at a contact must be turned round, to go out of the body or into it.

    Raises
    ------
    InputError
        If it was given the wrong way round.
    """
    points = points_of(body)
    if not points:
        return False
    tip = points[port]
    if tip.normal is None or tip.direction is None or tip.point is None:
        return False
    if (float(tip.direction @ tip.normal) > 0.0) == outward:
        return False
    if tip.directed or isinstance(body, InterfaceModel):
        way, opposite = ("out of", "into") if outward else ("into", "out of")
        raise InputError(
            f"{name}: direction {plain(tip.direction)} goes {opposite} the body at point "
            f"{plain(tip.point)} m, whose outward normal is {plain(tip.normal)}. It is the "
            "projectile's direction of travel, out of the projectile and into the target, and goes "
            f"{way} this body: leave direction out, turn it round, or swap the two bodies"
        )
    return True


def turned(body: Any, ports: Sequence[int]) -> Any:
    """Return a body or its model with the directions of some contacts turned round."""
    if not ports:
        return body
    if isinstance(body, tuple):
        return tuple(tip.reversed() if i in ports else tip for i, tip in enumerate(body))
    return body.reversed()


def chosen_law(bodies: Sequence[Any], names: Sequence[str]) -> LawFromSurfaces:
    """Return Hertz's law of two bodies from their surfaces and materials.

    Parameters
    ----------
    bodies : sequence
        The contact points or models of projectile and target.
    names : sequence of str
        What to call them.

    Raises
    ------
    InputError
        If a surface is not known, or they have no Hertz contact.
    """
    surfaces = []
    for name, body in zip(names, bodies, strict=True):
        surface = getattr(body, "contact_surface", None)
        if surface is None:
            raise InputError(
                f"law: it was left out, but {name}, {body!r}, does not know its surface and "
                "material; give law=, such as Hertz.between(...), or a body made by "
                "FEModel.from_mesh(...).contact(point=...), or ball(radius, material)"
            )
        surfaces.append(surface)
    points = [points_of(body) for body in bodies]
    along = [tips[0].direction if tips else None for tips in points]
    try:
        return law_between(
            surfaces[0], surfaces[1], projectile_direction=along[0], target_direction=along[1]
        )
    except InputError as error:
        raise InputError(f"law: it was left out, but {error}") from None


class Meeting(NamedTuple):
    """What two rigid bodies would do.

    Attributes
    ----------
    contact_time : float
        s.
    contact_radius : float or None
        At the peak, m; None of a law that does not know it.
    """

    contact_time: float
    contact_radius: float | None


def meeting(law: ContactLaw, bodies: Sequence[Any], velocity: float) -> Meeting | None:
    """Estimate an impact by rigid bodies, which go deeper than elastic ones.

    None where the law ends before, or nothing is known of the masses.
    """
    masses = [_mass(body) for body in bodies]
    if velocity == 0.0 or all(math.isinf(mass) for mass in masses):
        return None
    energy = 0.5 * velocity**2 / math.fsum(1.0 / mass for mass in masses)
    low, high = _SHALLOWEST, _DEEPEST
    try:
        while high - low > _EXACT:
            middle = 0.5 * (low + high)
            deep = law.potential(math.exp(middle)) >= energy
            low, high = (low, middle) if deep else (middle, high)
    except AOImpactError:
        return None
    depth = math.exp(high)
    wide = None if law.relative_radius is None else math.sqrt(law.relative_radius * depth)
    return Meeting(_DURATION_OVER_DEPTH * depth / abs(velocity), wide)


def _mass(body: Any) -> float:
    """What moves at least as much as the static mass, kg; infinite of what is held."""
    if isinstance(body, AOModel):
        return math.inf if body.constrained else body.static_mass
    of = points_of(body)[0].body
    if of.rigid_modes.shape[1] == 0:
        return math.inf
    return float(of.M.diagonal().sum()) if of.mass is None else of.mass


def fitted_patch(tip: ContactPoint, met: Meeting | None) -> ContactPoint:
    """Return a contact point with the patch that suits an impact, if it was left to be chosen."""
    if tip.patch is None or not tip.automatic or met is None or met.contact_radius is None:
        return tip
    invert: Callable[[float], LinearSolver] = cache(tip.body.inverse)
    radius = best_radius(
        tip, contact_time=met.contact_time, contact_radius=met.contact_radius, invert=invert
    )
    return tip if np.isclose(radius, tip.patch.radius) else contact_at(tip, radius)
