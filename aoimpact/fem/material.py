"""Isotropic linear elasticity: what a body is made of."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ..base import FloatArray, InputError, positive, real, unit_vector, warn

# The components of strain and stress: VTK's order of a symmetric tensor.
PAIRS = ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2))

# Six components make a tensor, `components[..., PLACES]`, and come of it, `tensor[..., *SIX]`.
PLACES = np.array([[0, 3, 5], [3, 1, 4], [5, 4, 2]])
SIX = tuple(np.transpose(PAIRS))


# Unit, and range among solids: from the softest rubbers to diamond, from foams to osmium. Then the
# units in which a number below is likely to be: up to which number, its name, its size in SI.
_SOLIDS = {
    "E": ("Pa", 1e6, 1.22e12, ((1.22e3, "GPa", 1e9), (1e6, "MPa", 1e6))),
    "G": ("Pa", 3e5, 6e11, ((600.0, "GPa", 1e9), (3e5, "MPa", 1e6))),
    "rho": (
        "kg/m³",
        25.0,
        25e3,
        ((25e-9, "t/mm³", 1e12), (25e-6, "kg/mm³", 1e9), (25.0, "g/cm³", 1e3)),
    ),
    "yield_strength": ("Pa", 1e4, 1e11, ((1e4, "MPa", 1e6),)),
    "hardness": ("Pa", 1e5, 1.5e11, ((100.0, "GPa", 1e9), (1e5, "MPa", 1e6))),
}


_OPTIONAL = ("yield_strength", "hardness")


@dataclass(frozen=True, repr=False)
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
    yield_strength : float, optional
        Uniaxial yield stress σ_y, Pa. A contact whose largest pressure is beyond 1.6 σ_y warns.
    hardness : float, optional
        Mean pressure under an indenter, Pa, 10.6 MPa times a Vickers number: of `ElasticPlastic`.

    Raises
    ------
    InputError
        If E, rho, yield_strength or hardness is not positive and finite, or nu is outside
        (-1, 1/2): there the elastic energy is no longer positive.

    Warns
    -----
    AOImpactWarning
        If a value is that of no solid, and so probably in other units.

    Examples
    --------
    >>> Material(E=210e9, nu=0.3, rho=7800)
    Material(E=210000000000.0, nu=0.3, rho=7800.0)
    """

    E: float
    nu: float
    rho: float
    yield_strength: float | None = None
    hardness: float | None = None

    def __post_init__(self) -> None:
        given = ["E", "rho"]
        given += [name for name in _OPTIONAL if getattr(self, name) is not None]
        for name in given:
            object.__setattr__(
                self, name, positive(name, getattr(self, name), unit=_SOLIDS[name][0])
            )
        nu = real("nu", self.nu)
        if not -1.0 < nu < 0.5:
            raise InputError(
                f"nu must lie between -1 and 0.5, both excluded, got {nu:g}; "
                "for a nearly incompressible material take 0.499 at most"
            )
        object.__setattr__(self, "nu", nu)
        for name in given:
            warn_of_units(name, getattr(self, name))

    def __repr__(self) -> str:
        given = {name: getattr(self, name) for name in _OPTIONAL}
        strength = "".join(f", {name}={value!r}" for name, value in given.items() if value)
        return f"Material(E={self.E!r}, nu={self.nu!r}, rho={self.rho!r}{strength})"

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
    def stiffness(self) -> FloatArray:
        """Hooke's matrix, Pa, shape (6, 6): stress of strain, both xx, yy, zz, xy, yz, xz.

        Shear strains are the angles γ = 2ε.
        """
        lam, mu = self.lame
        hooke = np.diag([2.0 * mu] * 3 + [mu] * 3)
        hooke[:3, :3] += lam
        return hooke

    @property
    def tensor(self) -> FloatArray:
        """The elastic tensor C_ijkl, Pa, shape (3, 3, 3, 3)."""
        return np.asarray(self.stiffness[PLACES][..., PLACES])

    def half_space(self, normal: npt.ArrayLike) -> Material:
        """Return what a contact on a surface with that normal meets: the material itself.

        Parameters
        ----------
        normal : array_like, shape (3,)
            Any length but zero.

        :meta private:
        """
        unit_vector("normal", normal)
        return self

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


def warn_of_units(name: str, value: float, what: str = "") -> None:
    """Warn of a value that no solid has; `name` is that of a parameter, `what` is said of it."""
    unit, low, high, likely = _SOLIDS[name]
    if low <= value <= high:
        return
    cure = next(
        (
            f"for {value:g} {meant} give {value * size:g}"
            for most, meant, size in likely
            if value < most
        ),
        f"is it in {unit}?",
    )
    warn(f"{what or name}={value:g} {unit} is that of no solid: {cure}")
