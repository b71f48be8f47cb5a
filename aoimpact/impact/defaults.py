"""Checks of the arguments of a run, and the law of two bodies where it was left out."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ..base import HUGE, FloatArray, InputError, finite_array, positive, real
from ..contact import ContactPoint
from ..laws import LawFromSurfaces, law_between
from ..reduction import BodyModel
from ..results import warn_of_size

# m/s; squares and energies of speeds beyond these overflow, or vanish. s; their cubes are numbers,
# and so is the distance that the fastest body covers.
SPEEDS, _DURATIONS = (1e-60, 1e60), (1.0 / HUGE, HUGE)


def in_range(name: str, value: float, bounds: tuple[float, float], unit: str = "") -> float:
    """Return a number that is 0, or whose magnitude can be computed with.

    Raises
    ------
    InputError
    """
    low, high = bounds
    if value and not low <= abs(value) <= high:
        raise InputError(
            f"{name}={value:g} {unit} is beyond what can be computed: give 0, or from {low:g} to "
            f"{high:g}"
        )
    return value


def checked_duration(duration: Any) -> float:
    """Return the length of a record, s, over which displacements do not overflow."""
    return in_range("duration", positive("duration", duration, unit="s"), _DURATIONS, "s")


def number_or_vector(
    name: str, value: Any, bounds: tuple[float, float], unit: str
) -> tuple[float, FloatArray | None]:
    """Return a number along the direction of travel, or the length of a vector, and that vector.

    The vector, in three directions, is None of a number.
    """
    if isinstance(value, list | tuple) or (isinstance(value, np.ndarray) and value.ndim):
        vector = finite_array(name, value, shape=(3,), unit=unit)
        return in_range(name, float(np.linalg.norm(vector)), bounds, unit), vector
    return in_range(name, real(name, value, unit=unit), bounds, unit), None


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
    for at, name in enumerate(names):
        if tips[at] is None:
            warn_of_size(abs(surfaces[at].radii[0]), tips[1 - at], name, names[1 - at])
    along = [None if tip is None else tip.direction for tip in tips]
    try:
        return law_between(
            surfaces[0], surfaces[1], projectile_direction=along[0], target_direction=along[1]
        )
    except InputError as error:
        raise InputError(f"law: it was left out, but {error}") from None
