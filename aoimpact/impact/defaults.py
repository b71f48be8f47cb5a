"""Checks of the arguments of a run, and the law of two bodies where it was left out."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from ..base import FloatArray, InputError, finite_array, real
from ..contact import ContactPoint
from ..laws import LawFromSurfaces, law_between
from ..reduction import BodyModel

# Squares and energies of lower speeds, m/s, vanish, and of those above the reciprocal overflow.
LEAST_SPEED = 1e-60


def number_or_vector(name: str, value: Any, unit: str) -> tuple[float, FloatArray | None]:
    """Return a number along the direction of travel, or the length of a vector, and that vector.

    The vector, in three directions, is None of a number.
    """
    number, vector = value, None
    if isinstance(value, list | tuple) or (isinstance(value, np.ndarray) and value.ndim):
        vector = finite_array(name, value, shape=(3,), unit=unit)
        number = math.hypot(*vector)
    number = real(name, number, unit=unit)
    if number and not LEAST_SPEED <= abs(number) <= 1.0 / LEAST_SPEED:
        raise InputError(f"{name}={number:g} {unit} is beyond what can be computed with")
    return number, vector


def goes_against(tip: ContactPoint | None, *, outward: bool) -> bool:
    """True if a contact point's direction goes into the body and not out of it, or the reverse."""
    if tip is None or tip.normal is None or tip.direction is None:
        return False
    return (float(tip.direction @ tip.normal) > 0.0) != outward


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
    surfaces, tips = [], []
    for name, (body, port), outward in zip(names, ends, (True, False), strict=True):
        tip = body.touched_at(port)
        body = body.turned((port,) if goes_against(tip, outward=outward) else ())
        surface = body.surface_at(port)
        if surface is None:
            raise InputError(
                f"law: it was left out, but {name}, {body!r}, does not know its surface and "
                "material; give law=, such as Hertz.between(...), or a body made by "
                "FEModel.from_mesh(...).contact(point=...), or ball(radius, material)"
            )
        surfaces.append(surface)
        tips.append(body.touched_at(port))
    along = [None if tip is None else tip.direction for tip in tips]
    try:
        return law_between(
            surfaces[0], surfaces[1], projectile_direction=along[0], target_direction=along[1]
        )
    except InputError as error:
        raise InputError(f"law: it was left out, but {error}") from None
