"""Contact laws: the force between two bodies as a function of their indentation."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
import numpy.typing as npt

from . import _core
from .checks import finite_array, positive, real
from .errors import InputError, InputTypeError
from .material import Material

__all__ = ["ContactLaw", "Hertz", "Linear", "PowerLaw"]

FloatArray = npt.NDArray[np.float64]


class ContactLaw:
    """What every contact law does; the formulas themselves are the core's (law.c)."""

    _name: ClassVar[str]

    def _parameters(self) -> tuple[float, ...]:
        raise NotImplementedError

    def for_core(self) -> tuple[str, FloatArray]:
        """Return the core's name of the law and its parameters."""
        return self._name, np.array(self._parameters(), dtype=np.float64)

    def force(self, indentation: npt.ArrayLike, rate: npt.ArrayLike = 0.0) -> Any:
        """Return the contact force.

        Parameters
        ----------
        indentation : array_like
            δ, m; the force is zero where δ ≤ 0.
        rate : array_like, optional
            dδ/dt, m/s; broadcast against `indentation`.

        Returns
        -------
        float or ndarray
            Force, N, in the broadcast shape.
        """
        delta, delta_rate = np.broadcast_arrays(
            finite_array("indentation", indentation, unit="m"),
            finite_array("rate", rate, unit="m/s"),
        )
        force, stiffness, damping = (np.empty(delta.shape) for _ in range(3))
        _core.law_force(
            *self.for_core(),
            np.ascontiguousarray(delta),
            np.ascontiguousarray(delta_rate),
            force,
            stiffness,
            damping,
        )
        return force if force.ndim else float(force)

    def potential(self, indentation: npt.ArrayLike) -> Any:
        """Return the elastic energy ∫ F dδ stored at an indentation, J (0 where δ ≤ 0)."""
        delta = finite_array("indentation", indentation, unit="m")
        energy = np.empty(delta.shape)
        _core.law_potential(*self.for_core(), delta, energy)
        return energy if energy.ndim else float(energy)


@dataclass(frozen=True)
class Hertz(ContactLaw):
    """Hertz's law F = k δ^(3/2), eqs. (13)-(15) of the paper.

    Parameters
    ----------
    k : float
        N/m^1.5, positive.
    """

    k: float
    _name = "hertz"

    def __post_init__(self) -> None:
        object.__setattr__(self, "k", positive("k", self.k, unit="N/m^1.5"))

    def _parameters(self) -> tuple[float, ...]:
        return (self.k,)

    @classmethod
    def between(
        cls, material_1: Material, radius_1: float, material_2: Material, radius_2: float
    ) -> Hertz:
        """Return Hertz's law of two spheres, or of a sphere and a flat (radius infinite).

        k = 4/3 E* √R with 1/E* = (1-ν₁²)/E₁ + (1-ν₂²)/E₂ and 1/R = 1/R₁ + 1/R₂: eqs. (13), (16)
        and (17); K. L. Johnson, *Contact Mechanics*, eq. (4.23).

        Parameters
        ----------
        material_1, material_2 : Material
        radius_1, radius_2 : float
            Radii of curvature, m; ``math.inf`` is flat.

        Raises
        ------
        InputError
            If a radius is not positive, or both are infinite.
        """
        for name, material in (("material_1", material_1), ("material_2", material_2)):
            if not isinstance(material, Material):
                raise InputTypeError(f"{name} must be a Material, got {material!r}")
        curvature = 0.0
        for name, radius in (("radius_1", radius_1), ("radius_2", radius_2)):
            curvature += 1.0 / positive(name, radius, unit="m", infinite=True)
        if curvature == 0.0:
            raise InputError(
                "radius_1 and radius_2 are both infinite: two flats have no Hertz contact; "
                "give at least one finite radius"
            )
        compliance = 1.0 / material_1.plane_strain_modulus + 1.0 / material_2.plane_strain_modulus
        return cls(4.0 / 3.0 / compliance / math.sqrt(curvature))


@dataclass(frozen=True)
class PowerLaw(ContactLaw):
    """F = k δⁿ.

    Parameters
    ----------
    k : float
        N/mⁿ, positive.
    n : float
        Exponent, at least 1.
    """

    k: float
    n: float
    _name = "power"

    def __post_init__(self) -> None:
        object.__setattr__(self, "k", positive("k", self.k, unit="N/m^n"))
        object.__setattr__(self, "n", real("n", self.n))
        if self.n < 1.0:
            raise InputError(f"n must be at least 1 (F would start with a jump), got {self.n:g}")

    def _parameters(self) -> tuple[float, ...]:
        return (self.k, self.n)


@dataclass(frozen=True)
class Linear(ContactLaw):
    """F = k δ: a linear spring that only pushes.

    Parameters
    ----------
    k : float
        N/m, positive.
    """

    k: float
    _name = "linear"

    def __post_init__(self) -> None:
        object.__setattr__(self, "k", positive("k", self.k, unit="N/m"))

    def _parameters(self) -> tuple[float, ...]:
        return (self.k,)
