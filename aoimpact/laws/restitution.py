"""The restitution that a contact law really delivers, between rigid bodies."""

from __future__ import annotations

import math
from contextlib import suppress
from typing import Any

from ..base import PRINTED, InputError, instance, positive
from .law import ContactLaw

# Energies, J, from which powers of all quantities are still numbers.
_LEAST = 1e-250


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
        If `law` is none, or `mass` or `velocity` is not positive, or numbers end on the way, or a
        user's law gives more energy than it takes.

    Examples
    --------
    >>> published = ao.HuntCrossley.from_restitution(1e9, 0.5, velocity=1.0, formula="flores")
    >>> round(ao.restitution(published, mass=0.01, velocity=1.0), 4)
    0.4704
    >>> law = ao.HuntCrossley.from_restitution(k=1e9, restitution=0.5, velocity=1.0)
    >>> round(ao.restitution(law, mass=0.01, velocity=1.0), 12)
    0.5
    """
    instance("law", law, ContactLaw)
    m, v = positive("mass", mass, unit="kg"), positive("velocity", velocity, unit="m/s")
    delivered = math.nan
    if _LEAST < 0.5 * m * v * v < 1.0 / _LEAST:
        with suppress(ArithmeticError):
            delivered = law.rigid_restitution(m, v)
    if 1.0 + PRINTED < delivered < math.inf:
        raise InputError(
            f"law={law!r} gives more energy than it takes: at mass={m:g} kg and velocity={v:g} m/s "
            f"rigid bodies would part {delivered:g} times as fast as they meet; let its force be "
            "no larger on the way out than on the way in"
        )
    if not 0.0 <= delivered < math.inf:
        raise InputError(
            f"mass={m:g} kg and velocity={v:g} m/s on {law!r}: some power of them is beyond the "
            "range of numbers; give values nearer to 1 (kg, m/s, N/m^n)"
        )
    return min(delivered, 1.0)
