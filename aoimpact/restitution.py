"""The restitution that a contact law really delivers, between rigid bodies."""

from __future__ import annotations

from typing import Any

from .checks import positive
from .errors import InputTypeError
from .law import ContactLaw

__all__ = ["restitution"]


def restitution(law: ContactLaw, mass: Any, velocity: Any) -> float:
    """Return what part of its speed a rigid pair gets back after one contact.

    By closed form where there is one, by energy for laws whose loss is plastic, else by integration
    to ten digits; no formula fitted to a nominal restitution takes part.

    Parameters
    ----------
    law : ContactLaw
    mass : float
        Reduced mass of the pair, m1 m2 / (m1 + m2); of one body against a wall its own, kg.
    velocity : float
        Of approach, m/s.

    Returns
    -------
    float
        e, from 0 to 1.

    Raises
    ------
    InputError, InputTypeError
        If `law` is none, or `mass` or `velocity` is not positive.
    """
    if not isinstance(law, ContactLaw):
        raise InputTypeError(f"law must be a contact law such as Hertz(k=...), got {law!r}")
    return law._restitution(
        positive("mass", mass, unit="kg"), positive("velocity", velocity, unit="m/s")
    )
