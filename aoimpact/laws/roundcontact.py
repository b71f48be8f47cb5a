"""Hertz's contact: the radius and the pressure that belong to a force."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
import scipy

from ..base import FloatArray
from ..fem import Material
from .law import ContactLaw, HertzianLaw

# The power of the indentation in Hertz's law.
_POWER = 1.5


class RoundContact(NamedTuple):
    """A contact under k δ^(3/2), k = 4/3 E* √R (Johnson, *Contact Mechanics*, section 4.2).

    Attributes
    ----------
    k : float
        N/m^1.5.
    modulus : float
        E* of the pair, Pa.
    radius : float
        R, relative radius of curvature, m; of an elliptic contact that of spheres with the same k.
    eccentricity : float
        √(1 - b²/a²) of an elliptic contact.
    """

    k: float
    modulus: float
    radius: float
    eccentricity: float = 0.0

    @property
    def narrowing(self) -> float:
        """√(a b) of an elliptic contact over the radius of a circle of the same force and approach.

        Its semi-axes are 2 K(e)/π times that radius (Johnson, eq. 4.26), and √(1 - e²) times this.
        """
        square = self.eccentricity**2
        wider = float(scipy.special.ellipk(square)) / (0.5 * math.pi)
        return wider * math.sqrt(math.sqrt(1.0 - square))

    def width(self, force: npt.ArrayLike) -> FloatArray:
        """Return the radius of the contact, m: a³ = 3 F R/(4 E*); √(a b) of an ellipse."""
        radius = np.cbrt(0.75 * np.asarray(force) * self.radius / self.modulus)
        return np.asarray(self.narrowing * radius)

    def pressure(self, force: float) -> float:
        """Return the largest pressure, Pa: 3 F/(2 π a²)."""
        width = float(self.width(force))
        return 1.5 * force / (math.pi * width * width) if force > 0.0 else 0.0


def round_contact(law: ContactLaw, materials: Sequence[Material | None]) -> RoundContact | None:
    """Return the contact of a law that begins as Hertz's; None where it is not known.

    Parameters
    ----------
    law : ContactLaw
        Between the bodies.
    materials : sequence of Material or None
        Materials of the bodies that deform; R follows from k and these. None for an unknown one.
    """
    if not isinstance(law, HertzianLaw) or getattr(law, "n", _POWER) != _POWER:
        return None
    k: Any = law.k  # type: ignore[attr-defined]
    radius = law.relative_radius
    if radius is None:
        if not materials or any(of is None for of in materials):
            return None
        root = 0.75 * k * math.fsum(1.0 / of.plane_strain_modulus for of in materials if of)
        radius = root * root  # ** raises where this overflows
    modulus = 0.75 * k / math.sqrt(radius)
    return RoundContact(k, modulus, radius, getattr(law, "eccentricity", 0.0))
