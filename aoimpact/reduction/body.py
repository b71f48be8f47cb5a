"""What a caller may write for a body, and the model that it stands for."""

from __future__ import annotations

from typing import Any

from ..base import InputTypeError
from ..fem import ContactPoint, FEModel
from .bodymodel import BodyModel
from .full import FullModel, checked_ports
from .modes import ModalModel

__all__ = ["body_model"]


def body_model(name: str, body: Any) -> BodyModel:
    """Return the model that a caller's body is or stands for.

    A contact point, or a list of them, stands for a full model that may be reduced; a modal model
    is the AO model that it is in other coordinates.

    Raises
    ------
    InputError, InputTypeError
        If it is no model of a body, or the contact points are on different ones.
    """
    if isinstance(body, ModalModel):
        return body.star
    if isinstance(body, BodyModel):
        return body
    if isinstance(body, ContactPoint):
        return FullModel((body,), reducible=True)
    if isinstance(body, list | tuple):
        return FullModel(checked_ports(name, body), reducible=True)
    if isinstance(body, FEModel):
        raise InputTypeError(
            f"{name} is a whole {body!r}: say where it is touched by body.contact(...), such as "
            f"{name}=body.contact(point=(x, y, z))"
        )
    raise InputTypeError(
        f"{name} must be an AOModel (antioscillators, rigid), a modal model, an interface model, "
        "the full model (full(tip)), or a ContactPoint (body.contact(...); a list of them where it "
        f"is touched in several places), got {body!r}"
    )
