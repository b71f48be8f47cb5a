"""The contact law between models of bodies: without the compliance of their meshes at the contact.

The finite elements of each body have some compliance c in place of the half-space's indentation,
which the law contains (`contact/extraction.py`). It is taken out of the law, F = law(δ + c F).
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from ..base import FloatArray, InputError, LawLimitError
from .law import MOST_SHARE, ContactLaw, PatchLaw


@lru_cache(maxsize=256)  # many models of the same bodies have the same law
def effective_law(law: ContactLaw, compliance: float) -> ContactLaw:
    """Return a law with a compliance, m/N, taken out, unless that has been done.

    Raises
    ------
    InputError
        If the law is stiffer than that from the first touch on.
    """
    if compliance == 0.0 or isinstance(law, PatchLaw):
        return law
    try:
        return law.within_patch(compliance)
    except InputError:
        raise InputError(
            f"law={law!r} is stiffer than the meshes at the contact ({compliance:.3g} m/N) from "
            "the first touch on. Give the contact points a larger radius, or none."
        ) from None


def own_law(law: ContactLaw) -> ContactLaw:
    """Return the law that the caller gave."""
    return law.law if isinstance(law, PatchLaw) else law


def check_width(law: ContactLaw, indentation: FloatArray, contact: int) -> None:
    """Refuse a record in which the contact of that number is stiffer than the meshes."""
    if isinstance(law, PatchLaw) and float(indentation.max(initial=0.0)) > law.limit:
        raise LawLimitError("the contact is stiffer than the meshes there", contact)


def wider(law: PatchLaw, mass: float, velocity: float) -> float | None:
    """Return by which factor patches must be wider for an impact; None if that is not the cause.

    Parameters
    ----------
    law : PatchLaw
        With a compliance taken out, which is in inverse proportion to the radius of the patches.
    mass : float
        Effective mass of the two bodies, kg.
    velocity : float
        At which they meet, m/s; rigid bodies at that velocity go deeper than elastic ones.
    """
    try:
        depth = law.law.stroke(0.5 * mass * velocity**2)
        # A damped law is steepest at the rate at which the bodies meet.
        low, high = (law.law.force(share * depth, velocity) for share in (0.99, 1.0))
    except LawLimitError:  # the law's own table ends
        return None
    share = law.compliance * float(np.subtract(high, low)) / (0.01 * depth)
    return max(share / MOST_SHARE, 1.0) * 1.2
