"""Hertz's law of two bodies from their own surfaces: curvatures and materials at the contact."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ..base import ROUNDING, InputError, unit_vector
from ..contact import ContactSurface
from .elastic import Hertz

# Smallest cosine of the angle between two directions of travel that count as given in one frame:
# 5°.
ONE_FRAME = math.cos(math.radians(5.0))

# Largest relative change of k with the angle between the surfaces for which an unknown angle is
# accepted.
_NO_MATTER = 0.01

_CURE = "give law="

# Relative error of the largest curvature above which the message on a missing law blames the mesh.
_DOUBT = 0.3


@dataclass(frozen=True)
class LawFromSurfaces:
    """Hertz's law of two surfaces, with the error of its stiffness.

    Attributes
    ----------
    law : Hertz
    error : float
        Relative error of the law's k due to the errors of the curvatures.
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

    A curvature smaller than its error counts as zero.

    Parameters
    ----------
    projectile_surface, target_surface : ContactSurface
    projectile_direction, target_direction : array_like, shape (3,), optional
        The projectile's direction of travel in the coordinates of each body. If the two directions
        agree within 5°, the bodies are taken to be given in one frame, and the angle between their
        principal directions is known.

    Raises
    ------
    InputError
        If the surfaces do not touch in a point (flat on flat, along a line, a hollow wider than the
        ball), or the angle between them is needed and not known.

    Examples
    --------
    >>> from aoimpact.fem import Material
    >>> steel = Material(E=210e9, nu=0.3, rho=7800)
    >>> ball, flat = ContactSurface(steel, (100.0, 100.0)), ContactSurface(steel, (0.0, 0.0))
    >>> law_between(ball, flat).law == Hertz.between(steel, 0.01, steel, math.inf)
    True
    """
    one, two = projectile_surface, target_surface
    if any(surface.radii[0] == surface.radii[1] for surface in (one, two)):
        return _at_angle(one, two, 0.0)
    first, second = projectile_direction, target_direction
    if not (first is None or second is None or one.directions is None or two.directions is None):
        along = unit_vector("projectile_direction", first), unit_vector("target_direction", second)
        if along[0] @ along[1] >= ONE_FRAME:
            across, same = np.array(two.directions)[::-1] @ np.array(one.directions[0])
            return _at_angle(one, two, math.atan2(abs(float(across)), abs(float(same))))
    laws = [_at_angle(one, two, turn) for turn in (0.0, 0.5 * math.pi)]
    low, high = sorted(found.law.k for found in laws)
    apart = high / low - 1.0
    if apart > _NO_MATTER:
        raise InputError(
            f"{_said(one, two)}: neither is round, and the angle between their principal "
            "directions is not known unless both have directions and the bodies travel along one "
            f"direction in one frame; {_CURE}"
        )
    middle = _at_angle(one, two, 0.25 * math.pi)
    return LawFromSurfaces(middle.law, apart + max(found.error for found in laws))


def _at_angle(one: ContactSurface, two: ContactSurface, angle: float) -> LawFromSurfaces:
    slack, largest = one.error + two.error, max(map(abs, (*one.curvatures, *two.curvatures)))
    try:
        law, apart = _hertz(one, two, angle), 0.0
        for shift in (-slack, slack) if slack > ROUNDING * largest else ():
            apart = max(apart, abs(_hertz(one, two, angle, shift).k / law.k - 1.0))
    except InputError as error:
        if slack > _DOUBT * largest:
            why = "a curvature below its error counts as flat: refine the mesh about it, or "
        else:
            why = "they do not touch in a point: "
        raise InputError(
            f"{_said(one, two)}: {why}{_CURE}, such as Linear(k=) where they touch along a line or "
            "over a face, or turn one of the bodies"
        ) from error
    return LawFromSurfaces(law, apart)


def _hertz(one: ContactSurface, two: ContactSurface, angle: float, shift: float = 0.0) -> Hertz:
    """Return Hertz's law with `shift`, 1/m, added to the curvatures of one surface."""
    radii = np.array(one.radii)
    if shift:
        with np.errstate(divide="ignore"):  # a flat surface has an infinite radius
            radii = 1.0 / (1.0 / radii + shift)
    return Hertz.between(one.material, radii.tolist(), two.material, two.radii, angle=angle)


def _said(one: ContactSurface, two: ContactSurface) -> str:
    radii = (" and ".join(f"{radius:.3g}" for radius in surface.radii) for surface in (one, two))
    return "surfaces with the principal radii {} m (projectile) and {} m (target)".format(*radii)
