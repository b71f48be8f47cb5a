"""Is the body about a patch as good as a half-space? How its compliance moves when r does."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Any

from ..base import InputError, InputTypeError, checked, finite_array, positive, real
from .contact import ContactPoint, contact_at
from .statics import elastic_compliance

__all__ = ["PatchCheck", "check_patch"]

# A patch is compared with one so much larger, or smaller if the surface has no room for it.
_LARGER = 1.25


@dataclass(frozen=True)
class PatchCheck:
    """What a contact point's compliance does when its patch grows.

    Attributes
    ----------
    radii : tuple of float
        r, and another, m.
    remaining : tuple of float
        What is left of the compliance at each when the half-space's part is taken out, m/N: equal
        where the body about the patch is like a half-space and the mesh resolves the patch. The
        rigid motion of a free body does not count.
    share : float
        Their difference over 3/(4 E* a), the deflection of the body in Hertz's contact of radius a:
        about how much of the body's part of the indentation is uncertain. The force is less so, by
        half and more.
    """

    radii: tuple[float, float]
    remaining: tuple[float, float]
    share: float

    def __post_init__(self) -> None:
        checked(self, radii=_pair, remaining=_pair, share=real)


def _pair(name: str, value: Any) -> tuple[float, float]:
    one, other = finite_array(name, value, shape=(2,)).tolist()
    return one, other


def check_patch(tip: ContactPoint, *, expected: float | None = None) -> PatchCheck:
    """Return how the compliance of a patch, less the half-space's part, moves with its radius.

    Two static solutions; see `FEModel.contact`.

    Parameters
    ----------
    tip : ContactPoint
        With a patch.
    expected : float, optional
        Radius a of the contact itself, m; half the patch's if left out.

    Raises
    ------
    InputError
        If the contact point has no patch.

    References
    ----------
    K. L. Johnson, *Contact Mechanics*, eqs. (4.22), (4.23): δ/F = 3/(4 E* a).
    """
    if not isinstance(tip, ContactPoint):
        raise InputTypeError(f"tip must come from FEModel.contact(...), got {tip!r}")
    if tip.patch is None:
        raise InputError(f"{tip!r} has no patch; make it with radius=... or radius='auto'")
    patch = tip.patch
    contact = 0.5 * patch.radius if expected is None else positive("expected", expected, unit="m")
    try:
        other = contact_at(tip, _LARGER * patch.radius)
    except InputError:  # no room
        other = contact_at(tip, patch.radius / _LARGER)
    assert other.patch is not None
    invert = cache(tip.body.inverse)  # one factorisation for both
    here = elastic_compliance(tip, invert=invert) - patch.compliance
    there = elastic_compliance(other, invert=invert) - other.patch.compliance
    share = abs(there - here) * 4.0 * patch.modulus * contact / 3.0
    return PatchCheck((patch.radius, other.patch.radius), (here, there), share)
