"""Contact laws that keep a residual indentation."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import scipy

from ..base import InputError, positive
from ..fem import Material
from .curvature import contact_modulus, relative_radius
from .law import MOST_SHARE, HertzianLaw

__all__ = ["Thornton", "yield_force", "yield_pressure"]


def yield_force(modulus: float, radius: float, pressure: float) -> float:
    """Return the force, N, at which Hertz's largest pressure is a given one: π³ R² p³ / (6 E*²).

    Parameters
    ----------
    modulus, radius, pressure : float
        E*, Pa, R, m, and p, Pa.
    """
    if modulus == 0.0:
        raise InputError("E is too small to compute with: its modulus E* is 0 Pa")
    reach = radius * (pressure / modulus)
    return math.pi**3 / 6.0 * pressure * reach * reach


def yield_pressure(material: Material) -> float:
    """Return Hertz's largest pressure at which a body begins to yield below the surface, Pa.

    On the axis the largest shear is τ = ½ |σ_z - σ_r|, by Tresca and von Mises alike (Johnson,
    *Contact Mechanics*, eq. 3.45): 0.31 p₀ at a depth of 0.48 a for ν = 0.3, so that
    p₀ = 1.61 σ_y.

    Parameters
    ----------
    material : Material
        With a yield strength.
    """
    assert material.yield_strength is not None

    def shear(depth: float) -> float:
        axial = -1.0 / (1.0 + depth * depth)
        radial = -(1.0 + material.nu) * (1.0 - depth * math.atan2(1.0, depth)) - 0.5 * axial
        return 0.5 * abs(axial - radial)

    deepest = scipy.optimize.minimize_scalar(lambda z: -shear(z), bounds=(0.0, 2.0))
    return 0.5 * material.yield_strength / shear(float(deepest.x))


@dataclass(frozen=True, repr=False)
class Thornton(HertzianLaw):
    """An elastic-plastic contact by Thornton's law.

    C. Thornton, J. Appl. Mech. 64 (1997) 383-386.

    F = k δ^(3/2) up to the yield force F_y at δ_y; then F = F_y + 3/2 k √δ_y (δ - δ_y); unloading
    and reloading from the deepest point δ*, F* as Hertz on the flattened radius,
    F = F* ((δ - δ_p) / (δ* - δ_p))^(3/2) with δ* - δ_p = F* / (k √δ*).

    Parameters
    ----------
    k : float
        N/m^1.5, positive.
    yield_force : float
        F_y, N, positive.
    relative_radius : float, optional
        As of `Hertz`.

    Examples
    --------
    >>> law = ao.Thornton(k=1e9, yield_force=10.0)
    >>> slow = 0.5 * law.yield_velocity(mass=0.01)
    >>> ao.restitution(law, 0.01, slow), ao.restitution(law, 0.01, 20 * slow) < 1.0
    (1.0, True)
    """

    k: float
    yield_force: float
    _units: ClassVar[dict[str, str]] = HertzianLaw._units | {"yield_force": "N"}
    _name = "thornton"
    _has_memory = True

    def __post_init__(self) -> None:
        super().__post_init__()
        object.__setattr__(self, "k", positive("k", self.k, unit="N/m^1.5"))
        force = positive("yield_force", self.yield_force, unit="N", infinite=False)
        object.__setattr__(self, "yield_force", force)
        if not 0.0 < self.yield_indentation < math.inf:
            raise InputError(
                f"k={self.k:g} N/m^1.5 and yield_force={force:g} N: the indentation of yield, "
                "(F_y/k)^(2/3) m, is beyond the range of numbers"
            )

    @classmethod
    def between(
        cls,
        material_1: Material,
        radius_1: float,
        material_2: Material,
        radius_2: float,
        *,
        yield_pressure: float,
    ) -> Thornton:
        """Return the law of two spheres, or of a sphere and a flat or a cup.

        k as :meth:`Hertz.between`; F_y = π³ R² p_y³ / (6 E*²), at which Hertz's largest pressure
        is p_y.

        Parameters
        ----------
        material_1, material_2 : Material
        radius_1, radius_2 : float
            m; ``math.inf`` is flat, a negative radius hollow.
        yield_pressure : float
            p_y, Pa: 1.6 times the yield stress of the softer body where it begins to yield
            (Johnson, *Contact Mechanics*, section 6.1), more for the mean of a plastic contact.

        Examples
        --------
        >>> steel = ao.Material(E=210e9, nu=0.3, rho=7800)
        >>> law = ao.Thornton.between(steel, 0.01, steel, 0.01, yield_pressure=800e6)
        >>> round(law.yield_force, 2)  # N
        4.97
        """
        modulus = contact_modulus(material_1, material_2)
        radius = relative_radius(radius_1, radius_2)
        pressure = positive("yield_pressure", yield_pressure, unit="Pa")
        force = yield_force(modulus, radius, pressure)
        k = 4.0 / 3.0 * modulus * math.sqrt(radius)
        return cls(k, force, relative_radius=radius)

    @property
    def yield_indentation(self) -> float:
        """δ_y = (F_y/k)^(2/3), m."""
        return float(math.cbrt(self.yield_force / self.k) ** 2)

    def yield_velocity(self, mass: float) -> float:
        """Return the velocity, m/s, up to which a rigid pair of that reduced mass, kg, is elastic.

        m V_y²/2 = 2/5 k δ_y^(5/2).

        Examples
        --------
        >>> law = ao.Thornton(k=1e9, yield_force=100.0)
        >>> round(law.yield_velocity(0.1), 4)  # m/s
        0.1313
        """
        m = positive("mass", mass, unit="kg")
        return math.sqrt(0.8 * self.yield_force) * math.sqrt(self.yield_indentation / m)

    def _parameters(self) -> tuple[float, ...]:
        return (self.k, self.yield_force)

    def _steepest(self, compliance: float) -> float:
        # Unloading from δ starts with Hertz's slope there, 3/2 k √δ, steeper than loading.
        root = MOST_SHARE / (1.5 * self.k) / compliance
        return root * root  # a power that overflows would raise OverflowError

    def _work(self, indentation: float) -> float:
        start = self.yield_indentation
        past = indentation - start
        if past <= 0.0:
            return 0.4 * self.k * math.pow(indentation, 2.5)
        slope = 1.5 * self.k * math.sqrt(start)
        return 0.4 * self.yield_force * start + past * (self.yield_force + 0.5 * slope * past)
