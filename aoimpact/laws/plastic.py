"""Contact laws with a residual indentation: for metals, and for laminates under an impactor."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from functools import cached_property

import scipy

from ..base import InputError, positive, real, within
from ..fem import Material
from .curvature import contact_modulus
from .elastic import Hertz
from .law import HertzianLaw, parameter

# Ratio of hardness to yield strength of a fully strain-hardened metal (Tabor).
_CONSTRAINT = 2.8


def yield_force(modulus: float, radius: float, pressure: float) -> float:
    """Return the force, N, at which Hertz's largest pressure is p: π³ R² p³ / (6 E*²).

    Parameters
    ----------
    modulus, radius, pressure : float
        Contact modulus E*, Pa, relative radius R, m, and pressure p, Pa.
    """
    reach = radius * (pressure / modulus)
    return math.pi**3 / 6.0 * pressure * reach * reach


def _spheres(
    material_1: Material, radius_1: float, material_2: Material, radius_2: float
) -> tuple[float, float, float]:
    """Return k, N/m^1.5, R, m, and E*, Pa, of Hertz's contact of two spheres."""
    modulus = contact_modulus(material_1, material_2)
    for name, radius in (("radius_1", radius_1), ("radius_2", radius_2)):
        real(name, radius, unit="m", infinite=True)  # one radius, not two principal radii
    law = Hertz.between(material_1, radius_1, material_2, radius_2)
    assert law.relative_radius is not None
    return law.k, law.relative_radius, modulus


def yield_pressure(material: Material) -> float:
    """Return Hertz's largest pressure p₀, Pa, at which a body begins to yield below the surface.

    Yield begins on the axis at τ = ½ |σ_z - σ_r| = ½ σ_y, by Tresca and von Mises alike (Johnson,
    *Contact Mechanics*, eq. 3.45). The largest τ is 0.31 p₀ at a depth of 0.48 a for ν = 0.3, so
    that p₀ = 1.61 σ_y.

    Parameters
    ----------
    material : Material
        Material with a yield strength.
    """
    assert material.yield_strength is not None

    def shear(depth: float) -> float:
        axial = -1.0 / (1.0 + depth * depth)
        radial = -(1.0 + material.nu) * (1.0 - depth * math.atan2(1.0, depth)) - 0.5 * axial
        return 0.5 * abs(axial - radial)

    deepest = scipy.optimize.minimize_scalar(lambda z: -shear(z), bounds=(0.0, 2.0))
    return 0.5 * material.yield_strength / shear(float(deepest.x))


@dataclass(frozen=True, repr=False)
class _Yielding(HertzianLaw, has_memory=True):
    """A law F = k δ^(3/2) up to a yield force; beyond, a line or a curve of the subclass."""

    k: float
    yield_force: float = field(metadata=parameter(positive, "N"))

    @property
    def yield_indentation(self) -> float:
        """Indentation at which yield begins, δ_y = (F_y/k)^(2/3), m."""
        return float(math.cbrt(self.yield_force / self.k) ** 2)

    @property
    def plastic_indentation(self) -> float:
        """Indentation above which the force is a straight line, m."""
        return self.yield_indentation

    def yield_velocity(self, mass: float) -> float:
        """Return the largest velocity, m/s, at which a rigid pair of reduced mass, kg, is elastic.

        m V_y²/2 = 2/5 k δ_y^(5/2).

        Examples
        --------
        >>> law = ao.Thornton(k=1e9, yield_force=100.0)
        >>> round(law.yield_velocity(0.1), 4)  # m/s
        0.1313
        """
        m = positive("mass", mass, unit="kg")
        return math.sqrt(0.8 * self.yield_force) * math.sqrt(self.yield_indentation / m)

    def _work(self, indentation: float) -> float:
        start, full = self.yield_indentation, self.plastic_indentation
        elastic = min(indentation, start)
        work = 0.4 * self.k * math.pow(elastic, 2.5)
        for low, high in ((start, min(indentation, full)), (max(start, full), indentation)):
            if high > low:  # two-point Gauss rule: exact for cubics
                middle, half = 0.5 * (low + high), 0.5 * (high - low)
                work += half * sum(
                    self.force(middle + side * half / math.sqrt(3.0)) for side in (-1.0, 1.0)
                )
        return work


@dataclass(frozen=True, repr=False)
class Thornton(_Yielding, kind="thornton"):
    """An elastic-plastic contact by Thornton's law.

    C. Thornton, J. Appl. Mech. 64 (1997) 383-386.

    F = k δ^(3/2) up to the yield force F_y at δ_y; then F = F_y + 3/2 k √δ_y (δ - δ_y). Unloading
    and reloading from the deepest point δ*, F* follow Hertz's law with the flattened radius,
    F = F* ((δ - δ_p) / (δ* - δ_p))^(3/2) with δ* - δ_p = F* / (k √δ*).

    The law is for indentations of a few times δ_y. Its line has the slope π R p_y, whereas a fully
    plastic contact has 2 π R p₀ with the hardness p₀ ≈ 2.8 σ_y: the force measured on spheres
    pressed together by 0.1 to 0.3 mm in a Hopkinson bar was 3.4 to 4.6 times that of the law with
    p_y = 1.6 σ_y. For such indentations take `ElasticPlastic`.

    Parameters
    ----------
    k : float
        Stiffness, N/m^1.5, positive.
    yield_force : float
        Yield force F_y, N, positive.
    relative_radius : float, optional
        As in `Hertz`.

    Examples
    --------
    >>> law = ao.Thornton(k=1e9, yield_force=10.0)
    >>> slow = 0.5 * law.yield_velocity(mass=0.01)
    >>> ao.restitution(law, 0.01, slow), ao.restitution(law, 0.01, 20 * slow) < 1.0
    (1.0, True)
    """

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

        k is that of :meth:`Hertz.between`. Hertz's largest pressure reaches p_y at the force
        F_y = π³ R² p_y³ / (6 E*²).

        Parameters
        ----------
        material_1, material_2 : Material
        radius_1, radius_2 : float
            Radius of the surface, m; ``math.inf`` means flat, a negative radius hollow.
        yield_pressure : float
            Largest pressure at yield p_y, Pa: yield begins at 1.6 times the yield stress of the
            softer body (Johnson, *Contact Mechanics*, section 6.1); a larger p_y delays yield.

        Examples
        --------
        >>> steel = ao.Material(E=210e9, nu=0.3, rho=7800)
        >>> law = ao.Thornton.between(steel, 0.01, steel, 0.01, yield_pressure=800e6)
        >>> round(law.yield_force, 2)  # N
        4.97
        """
        k, radius, modulus = _spheres(material_1, radius_1, material_2, radius_2)
        pressure = positive("yield_pressure", yield_pressure, unit="Pa")
        return cls(k, yield_force(modulus, radius, pressure), relative_radius=radius)


@dataclass(frozen=True, repr=False)
class ElasticPlastic(_Yielding, kind="elastic_plastic"):
    """An elastic-plastic contact up to full plasticity, where the mean pressure is the hardness.

    Loading by M. R. Brake, Int. J. Solids Struct. 49 (2012) 3129-3141: Hertz's F = k δ^(3/2) up to
    the yield force F_y at δ_y; fully plastic from δ_f on, where Hertz's mean pressure is the
    hardness p₀, on the line F = π p₀ R (2 δ - δ_f); between δ_y and δ_f Hermite's cubic, so that
    force and slope are continuous. With s = 2 π R p₀, δ_f = (s/(2 k))².

    Unloading and reloading from the deepest point δ*, F* follow Hertz's law with the flattened
    radius, F = F* ((δ - δ_p) / (δ* - δ_p))^(3/2). The residual indentation is that of I. Etsion,
    Y. Kligerman, Y. Kadin, Int. J. Solids Struct. 42 (2005) 3716-3729, found by finite elements:
    δ_p = δ* (1 - w^(-0.28)) (1 - w^(-0.69)), w = δ*/δ_y. From about 1.6 δ_f on, where both formulas
    have equal slopes, the recovery δ* - δ_p goes as √F*, like that of a flattened sphere with
    F* = π p₀ a² (K. L. Johnson, *Contact Mechanics*, section 11.5); far past yield, the restitution
    thus goes as V^(-1/4). If the hardness is less than 1.7 times the yield pressure, the
    restitution rises by up to 0.007 just before δ_f; with Tabor's hardness the restitution only
    falls.

    The papers were not at hand: the formulas and the powers 0.28 and 0.69 are those commonly
    cited, and the transition at 1.6 δ_f is this package's. The measured spheres and Leeb's rebound
    (validation pages) test the law as a whole.

    Parameters
    ----------
    k : float
        Stiffness, N/m^1.5, positive.
    yield_force : float
        Yield force F_y, N, positive.
    hardness : float
        Hardness p₀, Pa, at least 1.25 times Hertz's largest pressure at yield. A Vickers number HV
        means a hardness of 10.6 MPa HV.
    relative_radius : float
        Relative radius of curvature R, m.

    Examples
    --------
    >>> steel = ao.Material(E=210e9, nu=0.3, rho=7800, yield_strength=600e6)
    >>> law = ao.ElasticPlastic.between(steel, 0.005, steel, float("inf"))
    >>> round(law.hardness / 1e9, 2), round(law.yield_force, 1)  # GPa, N
    (1.68, 8.8)
    >>> slow, fast = (ao.restitution(law, mass=0.004, velocity=v) for v in (10.0, 160.0))
    >>> round(fast / slow, 2)  # fully plastic: 16^(-1/4)
    0.5
    """

    hardness: float = field(metadata=parameter(positive, "Pa"))
    relative_radius: float = field(kw_only=True, metadata=parameter(positive, "m"))

    def _refused(self) -> str:
        # Hertz's largest pressure is 3 F/(2 π R δ).
        pressure = 1.5 / math.pi * self.k * math.sqrt(self.yield_indentation) / self.relative_radius
        return (
            f"hardness={self.hardness:g} Pa is too low for {self!r}, which yields at "
            f"{pressure:.3g} Pa. Give 1.25 times that or more, or a lower yield_force"
        )

    @classmethod
    def between(
        cls,
        material_1: Material,
        radius_1: float,
        material_2: Material,
        radius_2: float,
        *,
        hardness: float | None = None,
    ) -> ElasticPlastic:
        """Return the law of two spheres, or of a sphere and a flat or a cup.

        Both bodies are under the same pressure: yield begins at the lower of their yield pressures,
        1.6 yield strengths, and the contact becomes fully plastic at the lower hardness. A hardness
        that is not given is 2.8 yield strengths (Tabor), and a yield strength that is not given is
        the hardness divided by 2.8. For metals that harden with strain or strain rate the ratio
        exceeds 2.8: give their hardness.

        Parameters
        ----------
        material_1, material_2 : Material
            One of them with a yield strength or a hardness, unless `hardness` is given.
        radius_1, radius_2 : float
            Radius of the surface, m; ``math.inf`` means flat, a negative radius hollow.
        hardness : float, optional
            Hardness p₀, Pa, in place of that of the materials.

        Raises
        ------
        InputError
            If no hardness is known, or it is less than 1.25 times the pressure of yield.

        Examples
        --------
        >>> steel = ao.Material(E=210e9, nu=0.3, rho=7800, hardness=3e9)
        >>> law = ao.ElasticPlastic.between(steel, 0.01, steel, 0.01)
        >>> round(law.plastic_indentation * 1e6, 1)  # µm
        18.8
        """
        k, radius, modulus = _spheres(material_1, radius_1, material_2, radius_2)
        softer = min(material_1, material_2, key=_hardness)
        pressure = _hardness(softer)
        if hardness is not None:
            pressure = positive("hardness", hardness, unit="Pa")
        if pressure == math.inf:
            raise InputError(
                "hardness is not known: give hardness=, or one of the materials a hardness or a "
                "yield_strength"
            )
        yielding = []
        for material in (material_1, material_2):
            own = pressure if material == softer else _hardness(material)
            strength = material.yield_strength or own / _CONSTRAINT
            if strength < math.inf:
                yielding.append(yield_pressure(replace(material, yield_strength=strength)))
        force = yield_force(modulus, radius, min(yielding))
        return cls(k, force, pressure, relative_radius=radius)

    @property
    def plastic_indentation(self) -> float:
        """Indentation δ_f from which on the contact is fully plastic, m."""
        root = 0.5 * self._slope / self.k
        return root * root

    @property
    def _slope(self) -> float:
        """Slope of the force in the fully plastic range, N/m."""
        return 2.0 * math.pi * self.relative_radius * self.hardness

    @cached_property
    def _parameters(self) -> tuple[float, ...]:
        return (self.k, self.yield_force, self._slope)

    def _contact_radius(self, indentation: float) -> float:
        past = max(indentation, 2.0 * indentation - self.plastic_indentation)
        return math.sqrt(self.relative_radius * past)


def _hardness(material: Material) -> float:
    """Return the hardness of a material, Pa; infinity if it is not known."""
    return material.hardness or _CONSTRAINT * (material.yield_strength or math.inf)


@dataclass(frozen=True, repr=False)
class YangSun(HertzianLaw, kind="yang_sun", has_memory=True, unloading_power=2.5):
    """Indentation of a laminate, which leaves a dent if it exceeds a critical indentation.

    S. H. Yang, C. T. Sun, ASTM STP 787 (1982) 425-449; T. M. Tan, C. T. Sun, J. Appl. Mech. 52
    (1985) 6-12. Loading follows F = k δ^(3/2), and unloading from the deepest point δ*, F* follows
    F = F* ((δ - δ_p) / (δ* - δ_p))^(5/2); reloading after the bodies have parted follows the same
    curve with the exponent 3/2. The permanent indentation δ_p is 0 up to δ* = δ_c; beyond, it is
    δ* (1 - (δ_c/δ*)^(2/5)) by Yang and Sun, and β (δ* - δ_c) by Tan and Sun. Reloading before the
    bodies have parted, which the papers leave open, retraces the unloading curve.

    Parameters
    ----------
    k : float
        Stiffness, N/m^1.5, positive: measured, or 4/3 √R / ((1-ν²)/E + 1/E₂) with R, E and ν of the
        ball and the modulus E₂ of the plies across their fibres.
    critical_indentation : float
        Largest indentation δ_c without a dent, m, positive: 0.080 mm for graphite/epoxy, 0.102 mm
        for glass/epoxy (Yang and Sun).
    beta : float, optional
        Tan and Sun's β, above 0 and at most 1; without it, Yang and Sun's formula is used.
    relative_radius : float, optional
        As in `Hertz`.

    Examples
    --------
    A steel ball of 12.7 mm on graphite/epoxy (Tan and Sun):

    >>> law = ao.YangSun(k=1.413e9, critical_indentation=0.1667e-3, beta=0.094)
    >>> round(1e6 * law.dent(0.3e-3).depth, 2)  # µm
    12.53
    >>> round(ao.restitution(law, mass=0.0084, velocity=1.0), 3)
    0.845
    """

    k: float
    critical_indentation: float = field(metadata=parameter(positive, "m"))
    beta: float | None = field(default=None, metadata=parameter(within, low=math.ulp(1), high=1.0))

    @cached_property
    def _parameters(self) -> tuple[float, ...]:
        return (self.k, self.critical_indentation, self.beta or 0.0)

    def _work(self, indentation: float) -> float:
        return 0.4 * self.k * math.pow(indentation, 2.5)
