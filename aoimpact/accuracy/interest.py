"""What a caller's ``quantity=`` means: a name, a body of a scene, or a point of a body."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from ..base import FloatArray, InputError, choice
from ..fem import ContactPoint
from ..reduction import BodyModel, FullModel
from ..results import (
    IMPACT_CHOICES,
    QUANTITIES,
    SCENE_CHOICES,
    Handle,
    Quantity,
    Run,
    recorded,
)
from .stressat import StressAt, stress_quantity

__all__ = ["impact_quantity", "scene_quantity"]

_DEFAULT = "force"


def impact_quantity(quantity: Any, projectile: BodyModel, target: BodyModel) -> Quantity:
    """Return the quantity of interest of an impact of two bodies; the force by default.

    Raises
    ------
    InputError, InputTypeError
        If there is no such quantity, or the point is on neither body, or on both.
    """
    if isinstance(quantity, ContactPoint | StressAt):
        return _of_point(
            quantity,
            (projectile, target),
            none="neither projectile nor target",
            several="both projectile and target",
            contact="the contact's own are 'projectile_displacement' and 'target_displacement'",
        )
    return QUANTITIES[
        choice("quantity", _DEFAULT if quantity is None else quantity, IMPACT_CHOICES)
    ]


def scene_quantity(quantity: Any, bodies: Sequence[BodyModel]) -> Quantity:
    """Return the quantity of interest of a scene; of all contacts, the force by default.

    Handles are checked before.

    Raises
    ------
    InputError, InputTypeError
        If there is no such quantity, or the point is on none of the bodies, or on several.
    """
    if isinstance(quantity, Handle):

        def place(run: Run) -> FloatArray:
            return run[quantity].port_displacements[[quantity.at]]

        return Quantity("displacement", "m", history=recorded(place), each="bodies", lasting=True)
    if isinstance(quantity, ContactPoint | StressAt):
        return _of_point(
            quantity,
            bodies,
            none="none of the scene's bodies",
            several="several of the scene's bodies",
            contact="for a contact's own displacement give its handle",
        )
    return _named(quantity, SCENE_CHOICES)


def _named(quantity: Any, choices: Sequence[str]) -> Quantity:
    return QUANTITIES[choice("quantity", _DEFAULT if quantity is None else quantity, choices)]


def _of_point(
    point: ContactPoint | StressAt,
    bodies: Sequence[BodyModel],
    *,
    none: str,
    several: str,
    contact: str,
) -> Quantity:
    """The displacement, or the stress, of a point of the one body that has it."""
    meshed = ((i, body) for i, body in enumerate(bodies) if isinstance(body, FullModel))
    on = [i for i, body in meshed if body.body is point.body]
    if not on:
        raise InputError(
            f"quantity={point!r} is a point on {none}: give a point of a finite-element body that "
            "takes part as one"
        )
    if len(on) > 1:
        raise InputError(
            f"quantity={point!r} is a point of {several}, which are one FEModel: give one of them "
            f"a model of its own, copy.copy(model), and take the point from that; {contact}"
        )

    if isinstance(point, StressAt):
        return stress_quantity(point, on[0])

    def displacement(run: Run, times: FloatArray) -> FloatArray:
        return run.bodies[on[0]].displacement_of(point.b, times)[None]

    return Quantity("displacement", "m", history=displacement, each="bodies", lasting=True)
