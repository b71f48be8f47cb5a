"""The quantities that ``quantity=`` and ``keep=`` name: numbers, histories, points, sensors."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from ..base import FloatArray, InputError, InputTypeError, choice, nearest, sequence
from ..contact import ContactPoint
from ..reduction import BodyModel
from ..results import (
    IMPACT_CHOICES,
    QUANTITIES,
    SCENE_CHOICES,
    ErrorEstimate,
    Handle,
    Quantity,
    Result,
    Run,
    look_up,
    recorded,
)
from .sensor import Sensor
from .sensorat import AccelerationAt, ReactionAt, StrainAt, StressAt

# Forms in which a caller gives a quantity of interest: a name, a point of a body, a sensor.
Interest = str | ContactPoint | Sensor

_DEFAULT = "force"


def quantity_of(quantity: Any, bodies: Sequence[BodyModel], *, pair: bool) -> Quantity:
    """Return the quantity of interest; by default the contact force, in a scene of all contacts.

    Parameters
    ----------
    quantity : str, Handle, ContactPoint, sensor or None
        Handles must have been checked.
    bodies : sequence of BodyModel
    pair : bool
        True for an impact of two bodies, the projectile first.

    Raises
    ------
    InputError, InputTypeError
        If there is no such quantity, or the point is on none of the bodies, or on several.
    """
    if isinstance(quantity, Handle) and not pair:

        def place(run: Run) -> FloatArray:
            return run[quantity].port_displacements[[quantity.at]]

        return Quantity("displacement", "m", history=recorded(place), each="bodies", lasting=True)
    if not isinstance(quantity, ContactPoint | Sensor):
        choices = IMPACT_CHOICES if pair else SCENE_CHOICES
        return QUANTITIES[choice("quantity", _DEFAULT if quantity is None else quantity, choices)]
    meshed = {i: body.body for i, body in enumerate(bodies) if body.tips}
    if pair and quantity.body is None and 1 in meshed:
        meshed.pop(0, None)  # a point given without body is on the target
    on = [i for i, body in meshed.items() if quantity.body is None or body is quantity.body]
    if len(on) > 1 and quantity.body is None:
        raise InputError(f"quantity={quantity!r}: give body=, one of {len(on)} such bodies")
    if not on:
        none = "neither projectile nor target" if pair else "none of the scene's bodies"
        raise InputError(
            f"quantity={quantity!r} is a point on {none}: give a point of a body that takes part "
            "as a finite-element body"
        )
    if len(on) > 1:
        several, contact = "several of the scene's bodies", "for a contact's own give its handle"
        if pair:
            several = "both projectile and target"
            contact = "the contact's own are 'projectile_displacement' and 'target_displacement'"
        raise InputError(
            f"quantity={quantity!r} is a point of {several}, which are one FEModel: give one of "
            f"them a model of its own, copy.copy(model), and take the point from that; {contact}"
        )
    if isinstance(quantity, Sensor):
        quantity.check(meshed[on[0]])
        return quantity.quantity(meshed[on[0]], on[0])

    def displacement(run: Run, times: FloatArray) -> FloatArray:
        return run.bodies[on[0]].displacement_of(quantity.b, times)[None]

    return Quantity("displacement", "m", history=displacement, each="bodies", lasting=True)


# Suffix of the columns that are 1 if the models' error of a number is within the tolerance, else 0.
CONTROLLED = "_controlled"

_NAME = re.compile(r"[A-Za-z_]\w*(\.\w+)*")


@dataclass(frozen=True)
class Named:
    """Reads numbers of a result by name: quantities, or dotted attributes and indices.

    In a scene, the name of a quantity stands for the numbers of all contacts or bodies. A quantity
    without numbers is NaN.
    """

    names: tuple[str, ...]

    def __call__(self, result: Any) -> dict[str, float]:
        """Return the numbers by name and, if the models were chosen, two more values for each.

        The two values are name + "_error", which is `ErrorParts.total`, and name + "_controlled",
        which is 1 if the error of the models is within the tolerance, else 0.
        """
        kept = dict[str, float]()
        chosen = isinstance(result, Run) and result.chosen is not None
        error: Any = result.error if chosen else ErrorEstimate()
        for asked in self.names:
            of = QUANTITIES.get(asked) if isinstance(result, Run) and result.plan.scene else None
            names = [asked] if of is None or of.is_history else of.names(result)
            kept |= {name: look_up(result, name, "keep") for name in names} or {asked: math.nan}
            for name in filter(error.parts.__contains__, names):
                kept[f"{name}_error"] = error[name].total
                kept[f"{name}{CONTROLLED}"] = float(error[name].model <= error.rtol)
        return kept


Keep = Named | Callable[[Any], Any]


def keeper(keep: Any) -> Keep | None:
    """Return the function that reads what to keep of a result; None if whole results are kept.

    Raises
    ------
    InputError, InputTypeError
        If `keep` is neither a function nor names, or a name is misspelt.
    """
    if keep is None or callable(keep):
        return keep  # type: ignore[no-any-return]
    names = (keep,) if isinstance(keep, str) else keep
    try:
        names = tuple(sequence("keep", names))
    except InputTypeError:
        raise InputTypeError(
            f"keep must be names such as ('peak_force', 'impulse') or a function, got {keep!r}"
        ) from None
    if not names:
        raise InputError("keep has no names: give some, such as ('peak_force', 'impulse')")
    known = _KNOWN.union(one.name for one in QUANTITIES.values() if not one.is_history)
    for name in names:
        if not isinstance(name, str):
            raise InputTypeError(f"keep must hold names, got {name!r}")
        if not _NAME.fullmatch(name):
            raise InputError(f"keep: {name!r} is no name of a quantity, such as 'peak_force'")
        first = name.partition(".")[0]
        if re.sub(r"_\d+$", "", first) not in known:  # "stress_2": one of several stresses
            raise InputError(f"keep: results have no {first!r}{nearest(first, known)}")
    return Named(names)


def _public(thing: Any) -> list[str]:
    fields = getattr(thing, "__dataclass_fields__", {})
    return [name for name in {*dir(thing), *fields} if not name.startswith("_")]


# _SENSED: names of sensors' quantities. _KNOWN: names that ``keep=`` accepts in addition to
# `QUANTITIES`.
_SENSED = [of.named for of in (AccelerationAt, ReactionAt, StrainAt, StressAt)]
_KNOWN = frozenset((*_public(Result), *_public(Run), *_SENSED))
