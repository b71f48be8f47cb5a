"""The surface that a contact law meets: material, and curvatures where the body is touched."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from ..mesh import SurfaceShape
from .material import Material


@dataclass(frozen=True)
class ContactSurface:
    """The surface of a body at its contact.

    Attributes
    ----------
    material : Material
    curvatures : (float, float)
        Principal curvatures, 1/m; positive where the body is convex.
    directions : pair of unit vectors, or None
        Along which the surface bends so, in the body's coordinates; None where any will do.
    error : float
        How wrong each curvature may be, 1/m.

    Examples
    --------
    >>> ContactSurface(Material(E=210e9, nu=0.3, rho=7800), (100.0, 0.0)).radii
    (0.01, inf)
    """

    material: Material
    curvatures: tuple[float, float]
    directions: tuple[tuple[float, ...], tuple[float, ...]] | None = None
    error: float = 0.0

    @property
    def radii(self) -> tuple[float, float]:
        """Principal radii, m; infinite where the curvature is less than its error."""
        first, second = (
            math.inf if abs(kappa) <= self.error else 1.0 / kappa for kappa in self.curvatures
        )
        return first, second


def contact_surface(shape: SurfaceShape, material: Material) -> ContactSurface:
    """Return what a law needs to know of a surface of that shape."""
    first, second = shape.curvatures.tolist()
    along: Any = shape.directions
    return ContactSurface(material, (first, second), along, shape.error)
