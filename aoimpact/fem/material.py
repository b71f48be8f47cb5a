"""Isotropic linear elasticity: what a body is made of."""

from __future__ import annotations

import math
from dataclasses import dataclass

from ..base import InputError, positive, real

__all__ = ["Material"]


@dataclass(frozen=True)
class Material:
    """An isotropic, linear elastic material in SI units.

    Parameters
    ----------
    E : float
        Young's modulus, Pa.
    nu : float
        Poisson's ratio, -1 < nu < 1/2.
    rho : float
        Density, kg/m³.

    Raises
    ------
    InputError
        If E or rho is not positive and finite, or nu is outside (-1, 1/2): there the elastic
        energy is no longer positive.

    Examples
    --------
    >>> Material(E=210e9, nu=0.3, rho=7800)
    Material(E=210000000000.0, nu=0.3, rho=7800.0)
    """

    E: float
    nu: float
    rho: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "E", positive("E", self.E, unit="Pa"))
        object.__setattr__(self, "rho", positive("rho", self.rho, unit="kg/m³"))
        nu = real("nu", self.nu)
        if not -1.0 < nu < 0.5:
            raise InputError(
                f"nu must lie between -1 and 0.5, both excluded, got {nu:g}; "
                "for a nearly incompressible material take 0.499 at most"
            )
        object.__setattr__(self, "nu", nu)

    @property
    def shear_modulus(self) -> float:
        """Shear modulus μ = E / (2(1+ν)), Pa."""
        return self.E / (2.0 * (1.0 + self.nu))

    @property
    def lame(self) -> tuple[float, float]:
        """Lamé's constants (λ, μ), Pa; λ = E ν / ((1+ν)(1−2ν))."""
        lam = self.E * self.nu / ((1.0 + self.nu) * (1.0 - 2.0 * self.nu))
        return lam, self.shear_modulus

    @property
    def plane_strain_modulus(self) -> float:
        """E / (1−ν²), Pa: the body's part of Hertz's contact modulus (paper, eq. 17)."""
        return self.E / (1.0 - self.nu * self.nu)

    @property
    def shear_speed(self) -> float:
        """Speed of shear waves, √(μ/ρ), m/s."""
        return math.sqrt(self.shear_modulus / self.rho)

    @property
    def pressure_speed(self) -> float:
        """Speed of pressure waves, √((λ+2μ)/ρ), m/s."""
        lam, mu = self.lame
        return math.sqrt((lam + 2.0 * mu) / self.rho)

    @property
    def bar_speed(self) -> float:
        """Speed of longitudinal waves in a thin bar, √(E/ρ), m/s."""
        return math.sqrt(self.E / self.rho)
