"""Hertz's law of two bodies from their own surfaces: curvatures and materials at the contact."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ..base import InputError, instance, unit_vector
from ..fem import ContactSurface
from .elastic import Hertz

__all__ = ["LawFromSurfaces", "law_between"]


# Directions of travel within 5° are one direction in one frame.
_ONE_FRAME = math.cos(math.radians(5.0))

# Where turning one surface against the other changes k by less than this share, any angle will do.
_NO_MATTER = 0.01

_CURE = "give law="


@dataclass(frozen=True)
class LawFromSurfaces:
    """Hertz's law of two surfaces.

    Attributes
    ----------
    law : Hertz
    error : float
        Relative error of its k that the errors of the curvatures make.
    """

    law: Hertz
    error: float


def law_between(
    projectile_surface: ContactSurface,
    target_surface: ContactSurface,
    *,
    projectile_direction: npt.ArrayLike | None = None,
    target_direction: npt.ArrayLike | None = None,
) -> LawFromSurfaces:
    """Return Hertz's law of two bodies from their surfaces; `Hertz.between` has the equations.

    A curvature less than its error counts as flat.

    Parameters
    ----------
    projectile_surface, target_surface : ContactSurface
    projectile_direction, target_direction : array_like, shape (3,), optional
        The projectile's direction of travel in the coordinates of each body. Where they agree
        within 5°, both bodies lie in one frame, and the angle between their principal directions
        is known.

    Raises
    ------
    InputError
        If the surfaces do not touch in a point (flat on flat, a hollow wider than the ball), or
        the angle between them is needed and not known.

    Examples
    --------
    >>> from aoimpact.fem import Material
    >>> steel = Material(E=210e9, nu=0.3, rho=7800)
    >>> ball, flat = ContactSurface(steel, (100.0, 100.0)), ContactSurface(steel, (0.0, 0.0))
    >>> law_between(ball, flat).law == Hertz.between(steel, 0.01, steel, math.inf)
    True
    """
    one = instance("projectile_surface", projectile_surface, ContactSurface)
    two = instance("target_surface", target_surface, ContactSurface)
    angle = _angle(one, two, projectile_direction, target_direction)
    if angle is not None:
        return _at_angle(one, two, angle)
    laws = [_at_angle(one, two, turn) for turn in (0.0, 0.5 * math.pi)]
    low, high = sorted(found.law.k for found in laws)
    apart = 0.5 * (high - low) / low
    if apart > _NO_MATTER:
        raise InputError(
            f"{_said(one, two)}: neither is round, and the angle between their principal "
            f"directions is not known, since the bodies are not in one frame; {_CURE}"
        )
    middle = _at_angle(one, two, 0.25 * math.pi)
    return LawFromSurfaces(middle.law, apart + max(found.error for found in laws))


def _angle(
    one: ContactSurface,
    two: ContactSurface,
    first: npt.ArrayLike | None,
    second: npt.ArrayLike | None,
) -> float | None:
    """Angle between the first principal directions, rad; None where it is not known."""
    if any(_same(*surface.radii) for surface in (one, two)):
        return 0.0
    if first is None or second is None or one.directions is None or two.directions is None:
        return None
    along = unit_vector("projectile_direction", first), unit_vector("target_direction", second)
    if along[0] @ along[1] < _ONE_FRAME:
        return None
    axes = np.array(two.directions) @ np.array(one.directions[0])
    return math.atan2(abs(float(axes[1])), abs(float(axes[0])))


def _same(first: float, second: float) -> bool:
    return first == second


def _at_angle(one: ContactSurface, two: ContactSurface, angle: float) -> LawFromSurfaces:
    law = _hertz(one, two, one.radii, two.radii, angle)
    slack = one.error + two.error
    # Of round surfaces k is 4/3 E* √R with 1/R the sum of the curvatures.
    relative = 1.0 / law.relative_radius if law.relative_radius else math.inf
    return LawFromSurfaces(law, 0.5 * slack / relative)


def _hertz(
    one: ContactSurface,
    two: ContactSurface,
    first: tuple[float, float],
    second: tuple[float, float],
    angle: float,
) -> Hertz:
    try:
        return Hertz.between(
            one.material, _radius(first), two.material, _radius(second), angle=angle
        )
    except InputError as error:
        raise InputError(f"{_said(one, two)} do not touch in a point: {_CURE}") from error


def _radius(radii: tuple[float, float]) -> float | tuple[float, float]:
    return radii[0] if _same(*radii) else radii


def _said(one: ContactSurface, two: ContactSurface) -> str:
    first, second = (
        "/".join(f"{radius:.3g}" for radius in surface.radii) for surface in (one, two)
    )
    return f"surfaces with the principal radii {first} m (projectile) and {second} m (target)"
