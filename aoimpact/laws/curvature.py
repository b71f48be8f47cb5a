"""Hertz's contact of curved surfaces: from radii of curvature to the stiffness of F = k δ^(3/2).

K. L. Johnson, *Contact Mechanics* (1985), sections 4.1 and 4.2.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Sequence
from typing import Any

import numpy as np
import scipy

from ..base import InputError, instance, real
from ..fem import Laminate, Material, Orthotropic, Shell


def half_space(name: str, of: Any) -> Material:
    """Return what a contact meets on the top of a shell, or of a body of that material.

    The third axis of an orthotropic material is the surface's normal.
    """
    if isinstance(of, (Shell, Laminate)):
        return of.half_space(top=True)
    body: Material | Orthotropic = instance(name, of, Material, Orthotropic, Shell, Laminate)
    return body.half_space((0.0, 0.0, 1.0))


def contact_modulus(material_1: Material, material_2: Material) -> float:
    """Return E*, Pa: 1/E* = (1-ν₁²)/E₁ + (1-ν₂²)/E₂, eq. (16)."""
    instance("material_1", material_1, Material)
    instance("material_2", material_2, Material)
    return 1.0 / (1.0 / material_1.plane_strain_modulus + 1.0 / material_2.plane_strain_modulus)


def _curvature(name: str, radius: Any) -> float:
    number = real(name, radius, unit="m", infinite=True)
    if abs(number) < sys.float_info.min:  # whose curvature overflows
        raise InputError(
            f"{name} must not be {number:g} m; math.inf is flat, a negative radius is hollow"
        )
    return 1.0 / number


def relative_radius(radius_1: Any, radius_2: Any) -> float:
    """Return R, m, of two spheres: 1/R = 1/R₁ + 1/R₂, eq. (17); a hollow one has R < 0.

    Raises
    ------
    InputError
        If the surfaces do not touch in a point: two flats, or a ball not smaller than its cup.
    """
    curvature = _curvature("radius_1", radius_1) + _curvature("radius_2", radius_2)
    if math.isinf(float(radius_1)) and math.isinf(float(radius_2)):
        raise InputError(
            "radius_1 and radius_2 are both infinite: two flats have no Hertz contact; "
            "give at least one finite radius"
        )
    if curvature <= 0.0:
        raise InputError(
            f"radius_1={float(radius_1):g} m and radius_2={float(radius_2):g} m do not touch in a "
            "point: a hollow radius is negative and must be larger in magnitude than the other one"
        )
    return 1.0 / curvature


def is_pair(radii: Any) -> bool:
    """True if an argument is meant as principal radii, and not as one radius."""
    if isinstance(radii, np.ndarray):
        return radii.ndim > 0
    return isinstance(radii, Sequence) and not isinstance(radii, (str, bytes))


def _pair(name: str, radii: Any) -> tuple[float, float]:
    if is_pair(radii):
        if len(radii) != 2:
            raise InputError(f"{name} must be one radius or two principal ones, got {radii!r}")
        return _curvature(f"{name}[0]", radii[0]), _curvature(f"{name}[1]", radii[1])
    curvature = _curvature(name, radii)
    return curvature, curvature


def relative_curvatures(radii_1: Any, radii_2: Any, angle: Any) -> tuple[float, float]:
    """Return A ≤ B, 1/m, with which the surfaces part: h = A x² + B y², eq. (4.3).

    Parameters
    ----------
    radii_1, radii_2 : float or pair of float
        Radius of a sphere, or principal radii of curvature R', R'', m.
    angle : float
        Between the normal planes of the two R', rad.

    Raises
    ------
    InputError
        If the surfaces do not touch in a point.
    """
    (first, second), (third, fourth) = _pair("radius_1", radii_1), _pair("radius_2", radii_2)
    turn = real("angle", angle, unit="rad")
    cosine, sine = math.cos(turn), math.sin(turn)
    one, other = first - second, third - fourth
    total = first + second + third + fourth
    # |A - B| from eq. (4.4), written as a sum of squares
    apart = math.hypot(one + other * (cosine - sine) * (cosine + sine), 2.0 * other * cosine * sine)
    low, high = (total - apart) / 4.0, (total + apart) / 4.0
    if low <= 4.0 * np.finfo(float).eps * high or high <= 0.0:
        raise InputError(
            f"radius_1={radii_1!r} and radius_2={radii_2!r} at angle={float(angle):g} rad do not "
            "touch in a point but along a line or over an area; hollow radii are negative"
        )
    return low, high


def elliptic_contact(modulus: float, low: float, high: float) -> tuple[float, float]:
    """Return k, N/m^1.5, and the ellipse's eccentricity, of surfaces that part as A x² + B y².

    With m = 1 - (b/a)² of the ellipse of contact and D(m) = (K - E)/m,
    B/A = (K - D) / ((1-m) D) fixes m, and k² = (2π E*)² D / (9 K³ A): Johnson's eqs. (4.25) to
    (4.27) with F for p₀. For A = B it is k = 4/3 E* √R.

    Parameters
    ----------
    modulus : float
        E*, Pa.
    low, high : float
        A ≤ B, 1/m.
    """

    def integrals(complement: float) -> tuple[float, float]:
        complete = float(scipy.special.ellipkm1(complement))
        return complete, float(scipy.special.elliprd(0.0, complement, 1.0)) / 3.0

    def excess(log_complement: float) -> float:
        complement = math.exp(log_complement)
        complete, d = integrals(complement)
        return math.log((complete - d) / (complement * d)) - math.log(high / low)

    # (b/a)² falls a little slower than (A/B)^(4/3), and is 1 for A = B.
    bottom = 2.0 * math.log(low / high) - 1.0
    root = scipy.optimize.brentq(excess, bottom, 1e-3, xtol=1e-15) if high > low else 0.0
    complement = min(1.0, math.exp(root))
    complete, d = integrals(complement)
    k = 2.0 * math.pi * modulus / 3.0 * math.sqrt(d / (complete**3 * low))
    return k, math.sqrt(1.0 - complement)
