"""Contact laws whose loss is a force that goes with the rate of the indentation.

Unless a law states otherwise, its force is cut at zero: it never pulls, and the contact ends where
the force does. `from_restitution` finds the damping for which a rigid pair has a restitution.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, ClassVar

from ..base import InputError, choice, nonnegative, positive
from .elastic import exponent
from .law import ContactLaw, HertzianLaw
from .rebound import (
    hunt_crossley_damping,
    hunt_crossley_restitution,
    kuwabara_kono_lag,
    kuwabara_kono_restitution,
    oscillator_damping,
    oscillator_restitution,
    swing_damping,
    swing_restitution,
)

# Smallest restitution: below it, a rebound velocity in double precision has less than four digits.
_LEAST_RESTITUTION = 1e-12


def _restitution_of(value: Any) -> float:
    """Return e as a float in (0, 1]."""
    e = positive("restitution", value)
    if e > 1.0:
        raise InputError(f"restitution must be from above 0 to 1, got {e:g}")
    if e < _LEAST_RESTITUTION:
        raise InputError(
            f"restitution={e:g} is nothing beside the rounding of a run; give "
            f"{_LEAST_RESTITUTION:g} or more"
        )
    return e


# χ V of a nominal restitution e by published formulas.
_FORMULAS: dict[str, Callable[[float], float]] = {
    "lankarani-nikravesh": lambda e: 0.75 * (1.0 - e) * (1.0 + e),
    "flores": lambda e: 1.6 * (1.0 - e) / e,
    "gonthier": lambda e: (1.0 - e) * (1.0 + e) / e,
    "herbert-mcwhannell": lambda e: 6.0 * (1.0 - e) / ((2.0 * e - 1.0) ** 2 + 3.0),
    "lee-wang": lambda e: 0.75 * (1.0 - e),
}


@dataclass(frozen=True, repr=False)
class HuntCrossley(HertzianLaw):
    """F = k δⁿ (1 + χ δ̇).

    K. H. Hunt, F. R. E. Crossley, J. Appl. Mech. 42 (1975) 440-445, with any χ (theirs was
    χ = 3 (1-e)/(2 V), a fit for e near 1).

    Parameters
    ----------
    k : float
        N/mⁿ, positive.
    damping : float
        χ, s/m, not negative.
    n : float, optional
        Exponent, at least 1.
    relative_radius : float, optional
        As of `Hertz`.

    Examples
    --------
    >>> law = ao.HuntCrossley.from_restitution(k=1e9, restitution=0.6, velocity=1.0)
    >>> round(ao.restitution(law, mass=0.01, velocity=1.0), 12)
    0.6
    """

    k: float
    damping: float
    n: float = 1.5
    _units: ClassVar[dict[str, str]] = HertzianLaw._units | {"n": "", "damping": "s/m"}
    _checks: ClassVar[dict[str, Any]] = HertzianLaw._checks | {
        "n": exponent,
        "damping": nonnegative,
    }
    _name = "hunt_crossley"
    _depends_on_rate = True

    @classmethod
    def from_restitution(
        cls,
        k: float,
        restitution: float,
        velocity: float,
        n: float = 1.5,
        *,
        formula: str | None = None,
        relative_radius: float | None = None,
    ) -> HuntCrossley:
        """Return the law with which a rigid pair at `velocity` delivers `restitution`.

        χ V (1 + e) = log((1 + χ V) / (1 - χ V e)), whatever the masses, k and n. Published formulas
        approximate χ V. With them a rigid pair delivers another restitution than the nominal e,
        the further from it the smaller it is; `aoimpact.restitution` computes it.

        Parameters
        ----------
        k : float
            N/mⁿ.
        restitution : float
            e, above 0 and at most 1.
        velocity : float
            Of approach, V, m/s.
        n, relative_radius : float, optional
        formula : str, optional
            "lankarani-nikravesh": χ V = 3 (1 - e²)/4 (J. Mech. Des. 112 (1990) 369-376);
            "flores": 8 (1 - e)/(5 e) (Multibody Syst. Dyn. 25 (2011) 357-375); "gonthier":
            (1 - e²)/e (Multibody Syst. Dyn. 11 (2004) 209-233); "herbert-mcwhannell":
            6 (1 - e)/((2e - 1)² + 3) (J. Eng. Ind. 99 (1977) 270-275); "lee-wang": 3 (1 - e)/4
            (J. Mech. Transm. Autom. Des. 105 (1983) 534-543).

        Examples
        --------
        >>> law = ao.HuntCrossley.from_restitution(1e9, 0.5, velocity=1.0)
        >>> round(ao.restitution(law, mass=0.1, velocity=1.0), 6)
        0.5
        >>> law = ao.HuntCrossley.from_restitution(1e9, 0.5, velocity=1.0, formula="flores")
        >>> round(ao.restitution(law, mass=0.1, velocity=1.0), 2)
        0.47
        """
        e, speed = _restitution_of(restitution), positive("velocity", velocity, unit="m/s")
        if formula is None:
            product = hunt_crossley_damping(e)
        else:
            product = _FORMULAS[choice("formula", formula, tuple(_FORMULAS))](e)
        return cls(k, product / speed, n, relative_radius=relative_radius)

    def _parameters(self) -> tuple[float, ...]:
        return (self.k, self.damping, self.n)

    def rigid_restitution(self, mass: float, velocity: float) -> float:
        return hunt_crossley_restitution(self.damping * positive("velocity", velocity, unit="m/s"))


@dataclass(frozen=True, repr=False)
class Tsuji(HertzianLaw):
    """F = k δ^(3/2) + α √(m k) δ^(1/4) δ̇: a restitution that does not depend on the velocity.

    Y. Tsuji, T. Tanaka, T. Ishida, Powder Technology 71 (1992) 239-250.

    Parameters
    ----------
    k : float
        N/m^1.5, positive.
    alpha : float
        α, dimensionless, not negative.
    mass : float
        m, kg, positive: the reduced mass of the pair, m₁ m₂ / (m₁ + m₂).
    relative_radius : float, optional
        As of `Hertz`.

    Examples
    --------
    >>> law = ao.Tsuji.from_restitution(k=1e9, restitution=0.6, mass=0.01)
    >>> [round(ao.restitution(law, 0.01, speed), 9) for speed in (0.01, 1.0)]  # at any velocity
    [0.6, 0.6]
    """

    k: float
    alpha: float
    mass: float
    _units: ClassVar[dict[str, str]] = HertzianLaw._units | {"alpha": "", "mass": "kg"}
    _checks: ClassVar[dict[str, Any]] = HertzianLaw._checks | {
        "alpha": nonnegative,
        "mass": positive,
    }
    _name: ClassVar[str] = "tsuji"
    _depends_on_rate: ClassVar[bool] = True

    @classmethod
    def from_restitution(
        cls, k: float, restitution: float, mass: float, *, relative_radius: float | None = None
    ) -> Tsuji:
        """Return the law with which a rigid pair of that reduced mass delivers `restitution`.

        With y ∝ δ^(5/4) the phase plane is a linear oscillator's of damping ratio α/√5.

        Parameters
        ----------
        k : float
            N/m^1.5.
        restitution : float
            Above 0 and at most 1.
        mass : float
            Reduced mass, kg.
        relative_radius : float, optional

        Examples
        --------
        >>> law = ao.Tsuji.from_restitution(1e9, 0.5, mass=0.1)
        >>> round(ao.restitution(law, mass=0.1, velocity=2.0), 6)  # at any velocity
        0.5
        """
        alpha = math.sqrt(5.0) * oscillator_damping(_restitution_of(restitution))
        return cls(k, alpha, mass, relative_radius=relative_radius)

    def _parameters(self) -> tuple[float, ...]:
        return (self.k, self.alpha * math.sqrt(self.mass) * math.sqrt(self.k))

    def rigid_restitution(self, mass: float, velocity: float) -> float:
        ratio = math.sqrt(self.mass / positive("mass", mass, unit="kg"))
        return oscillator_restitution(self.alpha / math.sqrt(5.0) * ratio)


@dataclass(frozen=True, repr=False)
class KuwabaraKono(HertzianLaw):
    """F = k (δ^(3/2) + 3/2 A δ^(1/2) δ̇): viscoelastic spheres.

    G. Kuwabara, K. Kono, Jpn. J. Appl. Phys. 26 (1987) 1230-1233; N. V. Brilliantov et al., Phys.
    Rev. E 53 (1996) 5382-5392. The restitution falls with the velocity, 1 - e ∝ A V^(1/5).

    Parameters
    ----------
    k : float
        N/m^1.5, positive.
    A : float
        s, not negative: a time of the material.
    relative_radius : float, optional
        As of `Hertz`.

    Examples
    --------
    >>> law = ao.KuwabaraKono(k=1e9, A=1e-6)
    >>> ao.restitution(law, 0.01, 0.1) > ao.restitution(law, 0.01, 1.0)
    True
    """

    k: float
    A: float
    _units: ClassVar[dict[str, str]] = HertzianLaw._units | {"A": "s"}
    _checks: ClassVar[dict[str, Any]] = HertzianLaw._checks | {"A": nonnegative}
    _name: ClassVar[str] = "kuwabara_kono"
    _depends_on_rate: ClassVar[bool] = True

    @classmethod
    def from_restitution(
        cls,
        k: float,
        restitution: float,
        velocity: float,
        mass: float,
        *,
        relative_radius: float | None = None,
    ) -> KuwabaraKono:
        """Return the law with which a rigid pair delivers `restitution` at `velocity`.

        Parameters
        ----------
        k : float
            N/m^1.5.
        restitution : float
            Above 0 and at most 1.
        velocity : float
            Of approach, m/s.
        mass : float
            Reduced mass, kg.
        relative_radius : float, optional

        Examples
        --------
        >>> law = ao.KuwabaraKono.from_restitution(1e9, 0.8, velocity=1.0, mass=0.1)
        >>> round(ao.restitution(law, mass=0.1, velocity=1.0), 6)
        0.8
        """
        e, stiffness = _restitution_of(restitution), positive("k", k, unit="N/m^1.5")
        unit = _kuwabara_kono_time(stiffness, mass, velocity)
        time = kuwabara_kono_lag(e) / 1.5 * unit
        return cls(stiffness, time, relative_radius=relative_radius)

    def _parameters(self) -> tuple[float, ...]:
        return (self.k, self.A)

    def rigid_restitution(self, mass: float, velocity: float) -> float:
        return kuwabara_kono_restitution(1.5 * self.A / _kuwabara_kono_time(self.k, mass, velocity))


def _kuwabara_kono_time(k: float, mass: float, velocity: float) -> float:
    """Return (m V²/k)^(2/5) / V, s."""
    m, speed = positive("mass", mass, unit="kg"), positive("velocity", velocity, unit="m/s")
    return float(m**0.4 * k**-0.4 * speed**-0.2)  # m/k might be no number any more


@dataclass(frozen=True)
class KelvinVoigt(ContactLaw):
    """F = k δ + c δ̇: a spring and a dashpot side by side. The force starts with a jump, c V.

    With ``end="force"`` it is cut at 0: the contact ends where the force does, with some
    indentation left. With ``end="indentation"`` it is the model of the textbooks, which PULLS the
    bodies together on the way out, until δ = 0: its force is negative then, and meant to be.

    Parameters
    ----------
    k : float
        N/m, positive.
    c : float
        N s/m, not negative.
    end : {"force", "indentation"}, optional
        What goes to zero where the contact ends.

    Examples
    --------
    >>> law = ao.KelvinVoigt.from_restitution(k=1e7, restitution=0.6, mass=0.01)
    >>> [round(ao.restitution(law, 0.01, speed), 9) for speed in (0.01, 1.0)]  # at any velocity
    [0.6, 0.6]
    """

    k: float
    c: float
    end: str = "force"
    _units: ClassVar[dict[str, str]] = {"c": "N s/m", "end": ""}
    _checks: ClassVar[dict[str, Any]] = {"c": nonnegative}
    _power = 1.0
    _depends_on_rate: ClassVar[bool] = True

    def __post_init__(self) -> None:
        super().__post_init__()
        choice("end", self.end, ("force", "indentation"))

    @classmethod
    def from_restitution(
        cls, k: float, restitution: float, mass: float, end: str = "force"
    ) -> KelvinVoigt:
        """Return the law with which a rigid pair of that reduced mass delivers `restitution`.

        Parameters
        ----------
        k : float
            N/m.
        restitution : float
            Above 0 and at most 1.
        mass : float
            Reduced mass, kg.
        end : {"force", "indentation"}, optional

        Examples
        --------
        >>> law = ao.KelvinVoigt.from_restitution(1e7, 0.5, mass=0.1)
        >>> round(ao.restitution(law, mass=0.1, velocity=1.0), 6)
        0.5
        """
        e = _restitution_of(restitution)
        pulls = choice("end", end, ("force", "indentation")) == "indentation"
        ratio = swing_damping(e) if pulls else oscillator_damping(e)
        stiffness, m = positive("k", k, unit="N/m"), positive("mass", mass, unit="kg")
        return cls(stiffness, 2.0 * ratio * math.sqrt(stiffness) * math.sqrt(m), end)

    @property
    def pulls(self) -> bool:
        return self.end == "indentation"

    def _kind(self) -> str:
        return "kelvin_voigt_pulling" if self.pulls else "kelvin_voigt"

    def _parameters(self) -> tuple[float, ...]:
        return (self.k, self.c)

    def rigid_restitution(self, mass: float, velocity: float) -> float:
        m = positive("mass", mass, unit="kg")
        ratio = 0.5 * self.c / (math.sqrt(self.k) * math.sqrt(m))
        return oscillator_restitution(ratio) if self.end == "force" else swing_restitution(ratio)
