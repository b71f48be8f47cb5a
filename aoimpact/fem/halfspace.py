"""Whether a body around a patch deforms like a half-space: how its compliance varies with r."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

from ..base import FloatArray, InputError, InputTypeError, checked, finite_array, positive, real
from .contact import ContactPoint, contact_at
from .patch import circle_means, half_space_compliance, half_space_deflection
from .statics import elastic_compliance
from .touch import normal_at

__all__ = ["PatchCheck", "check_patch", "image_field"]

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

    Examples
    --------
    >>> steel = ao.Material(E=210e9, nu=0.3, rho=7800)
    >>> ball = ao.FEModel.from_mesh(ao.paper_sphere_mesh(), steel)
    >>> check = ao.check_patch(ball.contact(point=(0.01, 0, 0), radius=0.004))
    >>> check.share < 0.02
    True
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

    Examples
    --------
    >>> steel = ao.Material(E=210e9, nu=0.3, rho=7800)
    >>> ball = ao.FEModel.from_mesh(ao.paper_sphere_mesh(), steel)
    >>> check = ao.check_patch(ball.contact(point=(0.01, 0, 0), radius=0.004))
    >>> check.share < 0.02  # of what the body adds, 2 % move with the radius
    True
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


def image_field(
    tip: ContactPoint, displacement: FloatArray, radii: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return what a body adds around its contact to the deflection of a half-space.

    On a half-space it is zero, and in any body smooth: forces beyond its bounds make it.

    Parameters
    ----------
    tip : ContactPoint
        On the surface of a mesh, inside a smooth side.
    displacement : ndarray, shape (n_dofs,)
        Under a unit force on the contact, m.
    radii : ndarray, shape (n,)
        Of circles about the point, ascending, m.

    Returns
    -------
    radii, field : ndarrays, shape (m,)
        Of the circles that lie on the surface, and the field's mean around each along the
        direction of the contact, m.
    """
    body = tip.body
    assert body.surface is not None
    assert tip.material is not None
    assert tip.point is not None
    assert tip.direction is not None
    normal = normal_at(body.surface, tip.point)
    means = circle_means(body.surface, tip.point, normal, radii)
    moved = np.zeros(means.shape[1] * 3)
    moved[body.free] = displacement
    radius = 0.0 if tip.patch is None else tip.patch.radius
    cosine = min(1.0, abs(float(tip.direction @ normal)))
    compliance = half_space_compliance(tip.material, radius or 1.0, cosine)
    there = radii[: len(means)]
    deflection = means @ (moved.reshape(-1, 3) @ tip.direction)
    return there, deflection - compliance * half_space_deflection(there, radius)
