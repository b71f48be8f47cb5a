"""Contact laws without loss: the force is a power of the indentation."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

from ..base import within
from ..fem import Laminate, Material, Orthotropic, Shell
from .curvature import contact_modulus, elliptic_contact, half_space, relative_curvatures
from .law import ContactLaw, HertzianLaw, parameter


@dataclass(frozen=True, repr=False)
class Hertz(HertzianLaw, kind="hertz"):
    """Hertz's law F = k δ^(3/2): equations (13) to (15) of the paper.

    Parameters
    ----------
    k : float
        Stiffness, N/m^1.5, positive.
    relative_radius : float, optional
        Relative radius of curvature R, m: the contact radius is √(R δ), from which patches get
        their radius; k and R give E*.
    eccentricity : float, optional
        Eccentricity √(1 - b²/a²) of an elliptic contact, from 0 to below 1, for its pressure.

    Examples
    --------
    >>> steel = ao.Material(E=210e9, nu=0.3, rho=7800)
    >>> law = ao.Hertz.between(steel, 0.01, steel, float("inf"))  # a ball on a plane
    >>> round(law.k / 1e9, 2)  # GN/m^1.5
    15.38
    >>> law.force([0.0, 1e-5]).round(1)  # N
    array([  0. , 486.5])
    """

    k: float
    eccentricity: float = field(
        default=0.0, kw_only=True, metadata=parameter(within, low=0.0, high=1.0, below=True)
    )

    @classmethod
    def between(
        cls,
        material_1: Material | Orthotropic | Shell | Laminate,
        radius_1: float | Sequence[float],
        material_2: Material | Orthotropic | Shell | Laminate,
        radius_2: float | Sequence[float],
        *,
        angle: float = 0.0,
    ) -> Hertz:
        """Return Hertz's law of two spheres, a sphere and a flat or a cup, or any curved surfaces.

        k = 4/3 E* √R with 1/E* = (1-ν₁²)/E₁ + (1-ν₂²)/E₂ and 1/R = 1/R₁ + 1/R₂: eqs. (13), (16)
        and (17); K. L. Johnson, *Contact Mechanics*, eq. (4.23). Where a surface has two principal
        radii, the contact is an ellipse and k follows from elliptic integrals (section 4.2).

        Parameters
        ----------
        material_1, material_2 : Material, Orthotropic, Shell or Laminate
            The contact is on the top of a shell or laminate, and on the surface normal to the third
            axis of an orthotropic material; see `Orthotropic.half_space`, as in the default law.
        radius_1, radius_2 : float or (float, float)
            Radius of curvature, m, or the two principal radii R', R''. ``math.inf`` means flat,
            negative means hollow: a cup's radius is larger in magnitude than its ball's. A cylinder
            is ``(R, math.inf)``.
        angle : float, optional
            Angle between the planes of the two R', rad: π/2 for cylinders crossing at right angles.

        Raises
        ------
        InputError
            If a radius is 0, or the surfaces do not touch in a point.

        Examples
        --------
        >>> steel = ao.Material(E=210e9, nu=0.3, rho=7800)
        >>> law = ao.Hertz.between(steel, 0.01, steel, math.inf)  # a ball on a flat
        >>> round(law.k / 1e9, 2)  # GN/m^1.5
        15.38
        """
        modulus = contact_modulus(
            half_space("material_1", material_1), half_space("material_2", material_2)
        )
        k, eccentricity = elliptic_contact(modulus, *relative_curvatures(radius_1, radius_2, angle))
        radius = (0.75 * k / modulus) ** 2  # that of two spheres with the same k
        return cls(k, relative_radius=radius, eccentricity=eccentricity)


@dataclass(frozen=True, repr=False)
class PowerLaw(ContactLaw, kind="power"):
    """Contact law F = k δⁿ.

    Parameters
    ----------
    k : float
        Stiffness, N/mⁿ, positive.
    n : float
        Exponent, at least 1.

    Examples
    --------
    >>> round(float(ao.PowerLaw(k=1e6, n=1.2).force(1e-3)), 3)
    251.189
    """

    k: float
    n: float = field(metadata=parameter(within, low=1.0))  # below 1 the stiffness at 0 is infinite


@dataclass(frozen=True, repr=False)
class Linear(ContactLaw, kind="linear", power=1.0):
    """Contact law F = k δ: a linear spring that only pushes.

    Parameters
    ----------
    k : float
        Stiffness, N/m, positive.

    Examples
    --------
    >>> float(ao.Linear(k=1e6).force(-1e-3)), float(ao.Linear(k=1e6).force(1e-3))
    (0.0, 1000.0)
    """

    k: float
