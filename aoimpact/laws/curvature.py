"""Hertz contact of curved surfaces: stiffness k of F = k δ^(3/2), contact radius and pressure.

K. L. Johnson, *Contact Mechanics* (1985), sections 4.1 and 4.2.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
import scipy

from ..base import FloatArray, InputError, instance, real
from ..fem import Laminate, Material, Orthotropic, Shell
from .law import ContactLaw, HertzianLaw


def half_space(name: str, of: Any) -> Material:
    """Return the isotropic half-space that stands for a body's surface or the top of a shell.

    The third axis of an orthotropic material is the surface's normal.
    """
    body = instance(name, of, Material, Orthotropic, Shell, Laminate)
    met: Material = body.half_space((0.0, 0.0, 1.0))
    return met


def contact_modulus(material_1: Material, material_2: Material) -> float:
    """Return the contact modulus E*, Pa: 1/E* = (1-ν₁²)/E₁ + (1-ν₂²)/E₂, eq. (16)."""
    instance("material_1", material_1, Material)
    instance("material_2", material_2, Material)
    modulus = 1.0 / (1.0 / material_1.plane_strain_modulus + 1.0 / material_2.plane_strain_modulus)
    if modulus == 0.0:
        raise InputError("E is too small: the contact modulus E* underflows to 0 Pa")
    return modulus


def _curvature(name: str, radius: Any) -> float:
    number = real(name, radius, unit="m", infinite=True)
    if abs(number) < sys.float_info.min:  # its curvature would overflow
        raise InputError(
            f"{name} must not be {number:g} m; math.inf is flat, a negative radius is hollow"
        )
    return 1.0 / number


def _curvatures(name: str, radii: Any) -> list[float]:
    """Return both principal curvatures, 1/m, for one radius or two principal radii."""
    pair = isinstance(radii, (list, tuple)) or (isinstance(radii, np.ndarray) and radii.ndim > 0)
    if not pair:
        return [_curvature(name, radii)] * 2
    if len(radii) != 2:
        raise InputError(f"{name} must be one radius or two principal ones, got {radii!r}")
    return [_curvature(f"{name}[{i}]", radius) for i, radius in enumerate(radii)]


def relative_curvatures(radii_1: Any, radii_2: Any, angle: Any) -> tuple[float, float]:
    """Return A ≤ B, 1/m, of the gap h = A x² + B y² between the unloaded surfaces, eq. (4.3).

    Parameters
    ----------
    radii_1, radii_2 : float or pair of float
        Radius of a sphere, or principal radii of curvature R', R'', m.
    angle : float
        Angle between the normal planes of the two R', rad.

    Raises
    ------
    InputError
        If the surfaces do not touch in a point.
    """
    first, second = _curvatures("radius_1", radii_1), _curvatures("radius_2", radii_2)
    turn = real("angle", angle, unit="rad")
    cosine, sine = math.cos(turn), math.sin(turn)
    one, other, total = first[0] - first[1], second[0] - second[1], sum(first) + sum(second)
    # |A - B| of eq. (4.4), written as a sum of squares
    apart = math.hypot(one + other * (cosine - sine) * (cosine + sine), 2.0 * other * cosine * sine)
    low, high = (total - apart) / 4.0, (total + apart) / 4.0
    if low <= 4.0 * np.finfo(float).eps * high or high <= 0.0:
        raise InputError(
            f"radius_1={radii_1!r} and radius_2={radii_2!r} at angle={float(angle):g} rad do not "
            "touch in a point but along a line or over an area. Give a finite radius; a hollow one "
            "is negative, and larger in magnitude than the other"
        )
    return low, high


def elliptic_contact(modulus: float, low: float, high: float) -> tuple[float, float]:
    """Return k, N/m^1.5, and the contact ellipse's eccentricity for a gap A x² + B y².

    With m = 1 - (b/a)² of the ellipse, complete elliptic integrals K and E of m, and D = (K - E)/m,
    m follows from B/A = (K - D) / ((1-m) D), and k² = (2π E*)² D / (9 K³ A): Johnson's eqs. (4.25)
    to (4.27) with the force F in place of p₀. For A = B, k = 4/3 E* √R.

    Parameters
    ----------
    modulus : float
        Contact modulus E*, Pa.
    low, high : float
        Coefficients A ≤ B of the gap, 1/m.
    """

    if low == high:
        return 4.0 / 3.0 * modulus / math.sqrt(2.0 * low), 0.0

    def integrals(complement: float) -> tuple[float, float]:
        complete = float(scipy.special.ellipkm1(complement))
        return complete, float(scipy.special.elliprd(0.0, complement, 1.0)) / 3.0

    def excess(log_complement: float) -> float:
        complement = math.exp(log_complement)
        complete, d = integrals(complement)
        return math.log((complete - d) / (complement * d)) - math.log(high / low)

    # The ratio (b/a)² falls a little more slowly than (A/B)^(4/3), and is 1 for A = B.
    bottom = 2.0 * math.log(low / high) - 1.0
    complement = min(1.0, math.exp(scipy.optimize.brentq(excess, bottom, 1e-3, xtol=1e-15)))
    complete, d = integrals(complement)
    k = 2.0 * math.pi * modulus / 3.0 * math.sqrt(d / (complete**3 * low))
    return k, math.sqrt(1.0 - complement)


class RoundContact(NamedTuple):
    """Hertz contact F = k δ^(3/2), k = 4/3 E* √R (Johnson, *Contact Mechanics*, section 4.2).

    Attributes
    ----------
    k : float
        Stiffness, N/m^1.5.
    modulus : float
        Contact modulus E* of the pair, Pa.
    radius : float
        Relative radius of curvature R, m; for an elliptic contact, R of spheres with the same k.
    eccentricity : float
        Eccentricity √(1 - b²/a²) of an elliptic contact.
    """

    k: float
    modulus: float
    radius: float
    eccentricity: float = 0.0

    @property
    def narrowing(self) -> float:
        """Ratio of √(a b) of an elliptic contact to the radius of a circle of equal F and δ.

        The semi-axes are a = 2 K(e)/π circle radii (Johnson, eq. 4.26), and b = a √(1 - e²).
        """
        square = self.eccentricity**2
        wider = float(scipy.special.ellipk(square)) / (0.5 * math.pi)
        return wider * math.sqrt(math.sqrt(1.0 - square))

    def width(self, force: npt.ArrayLike) -> FloatArray:
        """Return the contact radius, m, from a³ = 3 F R/(4 E*); for an ellipse √(a b)."""
        radius = np.cbrt(0.75 * np.asarray(force) * self.radius / self.modulus)
        return self.narrowing * radius


def round_contact(law: ContactLaw, materials: Sequence[Material | None]) -> RoundContact | None:
    """Return the Hertz contact k δ^(3/2) that a law starts with; None if it is not known.

    Parameters
    ----------
    law : ContactLaw
        Law between the bodies.
    materials : sequence of Material or None
        Materials of the deformable bodies, None if unknown. If the law has no R, R follows from k
        and these materials.
    """
    if not isinstance(law, HertzianLaw) or getattr(law, "n", law.power) != law.power:
        return None
    k: Any = law.k  # type: ignore[attr-defined]
    radius = law.relative_radius
    if radius is None:
        if not materials or None in materials:
            return None
        root = 0.75 * k * math.fsum(1.0 / of.plane_strain_modulus for of in materials if of)
        radius = root * root  # `**` would raise OverflowError
    modulus = 0.75 * k / math.sqrt(radius)
    return RoundContact(k, modulus, radius, getattr(law, "eccentricity", 0.0))
