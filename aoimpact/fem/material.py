"""Linear elastic materials, isotropic and orthotropic."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache, partial
from typing import Any

import numpy as np
import numpy.typing as npt

from ..base import (
    ROUNDING,
    FloatArray,
    InputError,
    checked,
    finite_array,
    held_warnings,
    positive,
    real,
    unit_vector,
    warn,
)
from ..mesh import plane_of

# Indices of the components of strain and stress, in VTK's order for symmetric tensors.
PAIRS = ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2))

# Conversion: six components to a tensor, `components[..., PLACES]`, and back, `tensor[..., *SIX]`.
PLACES = np.array([[0, 3, 5], [3, 1, 4], [5, 4, 2]])
SIX = tuple(np.transpose(PAIRS))


# Unit, lower and upper limit of each property: from the softest rubbers to diamond, density from
# foams to osmium. Last, likely units of a number below the range: largest number to which the unit
# applies, name of the unit, and its value in SI units.
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


_AXES = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))

# Largest difference between components of unit vectors that count as equal, and cosine between axes
# that count as perpendicular: they are printed with few digits.
SAME = 1e-4

# Number of surface directions in a half-space's mean deflection, and of angles in the Barnett-Lothe
# integral. Both integrands are periodic, so that their sums are exact to rounding for E1/E3 up to
# some hundreds.
_ANGLES = 96

# Lower and upper limit to which Poisson's ratio of the isotropic equivalent of an orthotropic
# half-space is clipped.
_NU_LOW, _NU_HIGH = -0.99, 0.499

Triple = tuple[float, float, float]


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
        Uniaxial yield stress σ_y, Pa. A contact pressure above 1.6 σ_y causes a warning.
    hardness : float, optional
        Mean pressure under an indenter, Pa, for `ElasticPlastic`; 10.6 MPa times the Vickers
        number.

    Raises
    ------
    InputError
        If E, rho, yield_strength or hardness is not positive and finite, or nu is outside
        (-1, 1/2), where the elastic energy is not positive.

    Warns
    -----
    AOImpactWarning
        If a value is outside the range of solids, and so probably in other units.

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
        checks = {name: partial(positive, unit=_SOLIDS[name][0]) for name in given}
        checked(self, **checks, nu=real)
        if not -1.0 < self.nu < 0.5:
            raise InputError(f"nu must lie between -1 and 0.5, got {self.nu:g}; take at most 0.499")
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
        """Elasticity matrix, Pa, shape (6, 6), in the order xx, yy, zz, xy, yz, xz.

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
        """Return the isotropic half-space material for a contact: the material itself.

        Parameters
        ----------
        normal : array_like, shape (3,)
            Normal of the surface, of any nonzero length.

        :meta private:
        """
        return self

    @property
    def plane_strain_modulus(self) -> float:
        """Plane-strain modulus E / (1−ν²), Pa: part of Hertz's contact modulus (paper, eq. 17)."""
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
    """Warn of a value outside the range of solids; `what` names it in the message, else `name`."""
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
    warn(f"{what or name}={value:g} {unit} is outside the range of solids: {cure}")


@dataclass(frozen=True)
class Orthotropic:
    """A linear elastic material with three planes of symmetry, in SI units.

    Parameters
    ----------
    E : (float, float, float)
        Young's moduli E1, E2, E3 along the material's axes, Pa.
    G : (float, float, float)
        Shear moduli G12, G13, G23, Pa.
    nu : (float, float, float)
        Poisson's ratios ν12, ν13, ν23: νij = -εj/εi under a stress along i. The other three are
        νji = νij Ej/Ei.
    rho : float
        Density, kg/m³.
    axes : array_like, shape (2, 3) or (3, 3), optional
        Directions of axes 1, 2 and optionally 3 in the body's coordinates, perpendicular and of any
        length. By default x, y and z. See `turned` for the plies of a laminate.

    Raises
    ------
    InputError, InputTypeError
        If a modulus is not positive, some strain has no positive elastic energy, or axes are not
        perpendicular.

    Warns
    -----
    AOImpactWarning
        If a value is outside the range of solids, and so probably in other units.

    Notes
    -----
    The order of the constants is Abaqus' (``TYPE=ENGINEERING CONSTANTS``: E1, E2, E3, ν12, ν13,
    ν23, G12, G13, G23). Contact laws use the contact modulus E* of a half-space of the material
    under a round contact; see `half_space`.

    Examples
    --------
    Carbon fibres along x in epoxy, and the same ply turned by 45° about z:

    >>> ply = Orthotropic(E=(135e9, 9e9, 9e9), G=(5e9, 5e9, 3.2e9), nu=(0.3, 0.3, 0.4), rho=1550)
    >>> ply.turned(math.pi / 4).axes[0]
    (0.7071067811865476, 0.7071067811865475, 0.0)
    """

    E: Triple
    G: Triple
    nu: Triple
    rho: float
    axes: tuple[Triple, Triple, Triple] = _AXES

    def __post_init__(self) -> None:
        checked(self, E=_moduli, G=_moduli, nu=_triple, axes=_axes)
        checked(self, rho=partial(positive, unit="kg/m³"))
        with np.errstate(over="ignore", invalid="ignore"):  # overflow is refused below
            relative = self._compliance[:3, :3] * max(self.E)
        if not np.isfinite(relative).all():
            raise InputError(f"E={self.E} Pa, nu={self.nu}: ratios of these moduli overflow")
        energies = np.linalg.eigvalsh(relative)
        if not energies.min() > ROUNDING * energies.max():
            e1, e2, e3 = self.E
            most = ", ".join(f"{x**0.5:.3g}" for x in (e1 / e2, e1 / e3, e2 / e3))
            why = f"a strain has no positive energy; |nu| must be below ({most}), if combined less"
            raise InputError(f"nu={self.nu}: {why} (νij belongs to a stress along i: is it νji?)")
        for name in ("E", "G"):
            for i, value in enumerate(getattr(self, name)):
                warn_of_units(name, value, f"{name}[{i}]")
        warn_of_units("rho", self.rho)

    @property
    def _compliance(self) -> FloatArray:
        """Compliance in the material's axes, 1/Pa, shape (6, 6), order 11, 22, 33, 12, 23, 13."""
        (e1, e2, e3), (g12, g13, g23), (n12, n13, n23) = self.E, self.G, self.nu
        compliance = np.diag([1 / e1, 1 / e2, 1 / e3, 1 / g12, 1 / g23, 1 / g13])
        for i, j, value in ((0, 1, n12 / e1), (0, 2, n13 / e1), (1, 2, n23 / e2)):
            compliance[i, j] = compliance[j, i] = -value
        return compliance

    @cached_property
    def tensor(self) -> FloatArray:
        """The elastic tensor C_ijkl in the body's coordinates, Pa, shape (3, 3, 3, 3)."""
        own = np.linalg.inv(self._compliance)[PLACES][..., PLACES]
        turn = np.array(self.axes)
        return np.asarray(np.einsum("ai,bj,ck,dm,abcd->ijkm", turn, turn, turn, turn, own))

    @property
    def stiffness(self) -> FloatArray:
        """Elasticity matrix in the body's coordinates, Pa, (6, 6); see `Material.stiffness`."""
        matrix = self.tensor[*SIX][..., *SIX]
        return np.asarray(0.5 * (matrix + matrix.T))

    def turned(self, angle: float, about: npt.ArrayLike = (0.0, 0.0, 1.0)) -> Orthotropic:
        """Return the material with its axes turned by the right-hand rule.

        Parameters
        ----------
        angle : float
            Angle, rad.
        about : array_like, shape (3,), optional
            Axis of the turn in the body's coordinates, of any nonzero length; by default z.

        Examples
        --------
        >>> ply = Orthotropic((135e9, 9e9, 9e9), (5e9, 5e9, 3.2e9), (0.3, 0.3, 0.4), rho=1550)
        >>> np.round(ply.turned(math.pi / 2).axes[0], 6)
        array([0., 1., 0.])
        """
        turn, axis = real("angle", angle, unit="rad"), unit_vector("about", about)
        old, along = np.array(self.axes), np.array(self.axes) @ axis
        new = math.cos(turn) * old + math.sin(turn) * np.cross(axis, old)
        new += (1.0 - math.cos(turn)) * np.outer(along, axis)
        with held_warnings():  # the same values were checked before
            return replace(self, axes=_axes("axes", new))

    def half_space(self, normal: npt.ArrayLike) -> Material:
        """Return the isotropic material of a half-space with the same mean deflection.

        A unit point force displaces the surface by u(r, θ) = L⁻¹(θ)/(2πr), with the Barnett-Lothe
        tensor L. Under an axisymmetric pressure, the force-weighted mean deflection depends only on
        the mean over θ: 1/E* = ⟨nᵀL⁻¹n⟩/2. For a sphere this gives Hertz's law, except that the
        true contact is slightly elliptic. ν is chosen to match the mean deflection under tangential
        forces.

        Parameters
        ----------
        normal : array_like, shape (3,)
            Normal of the surface, of any nonzero length.

        References
        ----------
        J. R. Willis, J. Mech. Phys. Solids 14, 163 (1966); J. J. Vlassak and W. D. Nix, ibid. 42,
        1223 (1994). S. R. Swanson, Int. J. Solids Struct. 42, 1945 (2005), finds the modulus E3
        through the thickness, used instead by T. M. Tan and C. T. Sun, to be a fair estimate.

        Examples
        --------
        >>> ply = Orthotropic((135e9, 9e9, 9e9), (5e9, 5e9, 3.2e9), (0.3, 0.3, 0.4), rho=1550)
        >>> round(ply.half_space((0, 0, 1)).plane_strain_modulus / 1e9, 1)  # E*, GPa
        10.8
        """
        x, y, z = unit_vector("normal", normal).round(12).tolist()
        return _half_space(self, (x, y, z))


# Material of a solid element or of a ply.
Solid = Material | Orthotropic


@lru_cache(maxsize=256)
def _half_space(material: Orthotropic, normal: Triple) -> Material:
    n, surface = np.array(normal), np.zeros((3, 3))
    first, second = plane_of(n)
    for turn in np.pi / _ANGLES * np.arange(_ANGLES):
        along = math.cos(turn) * first + math.sin(turn) * second
        surface += np.linalg.inv(_barnett_lothe(material.tensor, n, np.cross(n, along)))
    surface /= _ANGLES
    modulus = 2.0 / float(n @ surface @ n)
    ratio = 0.25 * float(np.trace(surface) - n @ surface @ n) * modulus  # = (2 - ν) E*/(4 G)
    nu = (2.0 * ratio - 2.0) / (2.0 * ratio - 1.0) if ratio > 0.5 else _NU_LOW
    nu = min(max(nu, _NU_LOW), _NU_HIGH)
    return Material(E=modulus * (1.0 - nu**2), nu=nu, rho=material.rho)


def _barnett_lothe(tensor: FloatArray, one: FloatArray, other: FloatArray) -> FloatArray:
    """Return the Barnett-Lothe tensor L = ⟨(mm) - (mn)(nn)⁻¹(nm)⟩, shape (3, 3).

    The mean is over perpendicular unit vectors m, n turning in the plane of `one` and `other`, with
    (ab)_jk = a_i C_ijkl b_l (T. C. T. Ting, Anisotropic Elasticity, 1996, section 7.2).
    """
    angles = np.pi / _ANGLES * np.arange(_ANGLES)[:, None]
    c, s = np.cos(angles), np.sin(angles)
    m, n = c * one + s * other, c * other - s * one
    mm, mn, nn = (np.einsum("aj,jklm,am->akl", a, tensor, b) for a, b in ((m, m), (m, n), (n, n)))
    return np.asarray(np.mean(mm - mn @ np.linalg.solve(nn, mn.swapaxes(1, 2)), axis=0))


def _triple(name: str, value: Any) -> Triple:
    one, two, three = finite_array(name, value, shape=(3,)).tolist()
    return one, two, three


def _moduli(name: str, value: Any) -> Triple:
    numbers = _triple(name, value)
    for i, number in enumerate(numbers):
        positive(f"{name}[{i}]", number, unit="Pa")
    return numbers


def _axes(name: str, value: Any) -> tuple[Triple, Triple, Triple]:
    given = finite_array(name, value, shape=(None, 3))
    if len(given) not in (2, 3):
        raise InputError(f"{name} must be two directions or three, got {len(given)}")
    units = [unit_vector(f"{name}[{i}]", row) for i, row in enumerate(given)]
    first = units[0]
    skew = max(abs(float(units[i] @ units[j])) for i in range(len(units)) for j in range(i))
    if skew > SAME:
        raise InputError(f"{name} must be at right angles, got {given.tolist()}")
    second = units[1] - (units[1] @ first) * first
    second /= np.linalg.norm(second)
    rows = (first, second, np.cross(first, second))
    one, two, three = ((float(x), float(y), float(z)) for x, y, z in rows)
    return one, two, three
