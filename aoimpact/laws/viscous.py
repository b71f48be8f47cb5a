"""Contact laws with a damping force that depends on the rate of indentation.

Unless a law states otherwise, negative forces are set to zero: the law never pulls, and the contact
ends where the force reaches zero. `from_restitution` finds the damping for a given restitution of a
rigid pair.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property

from ..base import choice, nonnegative, positive, within
from .law import ContactLaw, HertzianLaw, parameter
from .rebound import (
    hunt_crossley_restitution,
    kuwabara_kono_restitution,
    oscillator_restitution,
    swing_restitution,
)

# Published formulas for χ V, each a function of the nominal restitution e.
_FORMULAS: dict[str, Callable[[float], float]] = {
    "lankarani-nikravesh": lambda e: 0.75 * (1.0 - e) * (1.0 + e),
    "flores": lambda e: 1.6 * (1.0 - e) / e,
    "gonthier": lambda e: (1.0 - e) * (1.0 + e) / e,
    "herbert-mcwhannell": lambda e: 6.0 * (1.0 - e) / ((2.0 * e - 1.0) ** 2 + 3.0),
    "lee-wang": lambda e: 0.75 * (1.0 - e),
}


@dataclass(frozen=True, repr=False)
class HuntCrossley(HertzianLaw, kind="hunt_crossley", depends_on_rate=True, damped_by="damping"):
    """Contact law F = k δⁿ (1 + χ δ̇).

    K. H. Hunt, F. R. E. Crossley, J. Appl. Mech. 42 (1975) 440-445, with any χ (theirs was
    χ = 3 (1-e)/(2 V), a fit for e near 1).

    Parameters
    ----------
    k : float
        Stiffness, N/mⁿ, positive.
    damping : float
        Damping factor χ, s/m, not negative.
    n : float, optional
        Exponent, at least 1.
    relative_radius : float, optional
        As in `Hertz`.

    Examples
    --------
    >>> law = ao.HuntCrossley.from_restitution(k=1e9, restitution=0.6, velocity=1.0)
    >>> round(ao.restitution(law, mass=0.01, velocity=1.0), 12)
    0.6
    """

    k: float
    damping: float = field(metadata=parameter(nonnegative, "s/m"))
    n: float = field(default=1.5, metadata=parameter(within, low=1.0))

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
        approximate χ V: the restitution that they deliver, which `aoimpact.restitution` computes,
        differs from the nominal e, and more so for smaller e.

        Parameters
        ----------
        k : float
            Stiffness, N/mⁿ.
        restitution : float
            Restitution e, above 0 and at most 1.
        velocity : float
            Approach velocity V, m/s.
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
        published = None
        if formula is not None:
            published = _FORMULAS[choice("formula", formula, tuple(_FORMULAS))]
        law = cls(k, 0.0, n, relative_radius=relative_radius)
        return law._delivering(restitution, 1.0, velocity, published)

    def _closed_form(self, mass: float, velocity: float) -> tuple[Callable[[float], float], float]:
        return hunt_crossley_restitution, velocity


@dataclass(frozen=True, repr=False)
class Tsuji(HertzianLaw, kind="tsuji", depends_on_rate=True, damped_by="alpha"):
    """F = k δ^(3/2) + α √(m k) δ^(1/4) δ̇: a restitution that does not depend on the velocity.

    Y. Tsuji, T. Tanaka, T. Ishida, Powder Technology 71 (1992) 239-250.

    Parameters
    ----------
    k : float
        Stiffness, N/m^1.5, positive.
    alpha : float
        Damping constant α, dimensionless, not negative.
    mass : float
        Reduced mass of the pair m = m₁ m₂ / (m₁ + m₂), kg, positive.
    relative_radius : float, optional
        As in `Hertz`.

    Examples
    --------
    >>> law = ao.Tsuji.from_restitution(k=1e9, restitution=0.6, mass=0.01)
    >>> [round(ao.restitution(law, 0.01, speed), 9) for speed in (0.01, 1.0)]  # at any velocity
    [0.6, 0.6]
    """

    k: float
    alpha: float = field(metadata=parameter(nonnegative))
    mass: float = field(metadata=parameter(positive, "kg"))

    @classmethod
    def from_restitution(
        cls, k: float, restitution: float, mass: float, *, relative_radius: float | None = None
    ) -> Tsuji:
        """Return the law with which a rigid pair of reduced mass `mass` delivers `restitution`.

        With y ∝ δ^(5/4) the trajectory in the phase plane is that of a linear oscillator with the
        damping ratio α/√5.

        Parameters
        ----------
        k : float
            Stiffness, N/m^1.5.
        restitution : float
            Restitution e, above 0 and at most 1.
        mass : float
            Reduced mass, kg.
        relative_radius : float, optional

        Examples
        --------
        >>> law = ao.Tsuji.from_restitution(1e9, 0.5, mass=0.1)
        >>> round(ao.restitution(law, mass=0.1, velocity=2.0), 6)  # at any velocity
        0.5
        """
        law = cls(k, 0.0, mass, relative_radius=relative_radius)
        return law._delivering(restitution, law.mass, 1.0)

    @cached_property
    def _parameters(self) -> tuple[float, ...]:
        return (self.k, self.alpha * math.sqrt(self.mass) * math.sqrt(self.k))

    def _closed_form(self, mass: float, velocity: float) -> tuple[Callable[[float], float], float]:
        return oscillator_restitution, math.sqrt(self.mass / mass / 5.0)


@dataclass(frozen=True, repr=False)
class KuwabaraKono(HertzianLaw, kind="kuwabara_kono", depends_on_rate=True, damped_by="A"):
    """Contact law F = k (δ^(3/2) + 3/2 A δ^(1/2) δ̇) of viscoelastic spheres.

    G. Kuwabara, K. Kono, Jpn. J. Appl. Phys. 26 (1987) 1230-1233; N. V. Brilliantov et al., Phys.
    Rev. E 53 (1996) 5382-5392. The restitution falls with the velocity, 1 - e ∝ A V^(1/5).

    Parameters
    ----------
    k : float
        Stiffness, N/m^1.5, positive.
    A : float
        Dissipation time of the material, s, not negative.
    relative_radius : float, optional
        As in `Hertz`.

    Examples
    --------
    >>> law = ao.KuwabaraKono(k=1e9, A=1e-6)
    >>> ao.restitution(law, 0.01, 0.1) > ao.restitution(law, 0.01, 1.0)
    True
    """

    k: float
    A: float = field(metadata=parameter(nonnegative, "s"))

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
            Stiffness, N/m^1.5.
        restitution : float
            Restitution e, above 0 and at most 1.
        velocity : float
            Approach velocity, m/s.
        mass : float
            Reduced mass, kg.
        relative_radius : float, optional

        Examples
        --------
        >>> law = ao.KuwabaraKono.from_restitution(1e9, 0.8, velocity=1.0, mass=0.1)
        >>> round(ao.restitution(law, mass=0.1, velocity=1.0), 6)
        0.8
        """
        law = cls(k, 0.0, relative_radius=relative_radius)
        return law._delivering(restitution, mass, velocity)

    def _closed_form(self, mass: float, velocity: float) -> tuple[Callable[[float], float], float]:
        # (k/m)^(2/5) V^(1/5), in a form without k/m, which might overflow.
        return kuwabara_kono_restitution, 1.5 * self.k**0.4 * mass**-0.4 * velocity**0.2


@dataclass(frozen=True, repr=False)
class KelvinVoigt(ContactLaw, kind="kelvin_voigt", depends_on_rate=True, damped_by="c", power=1.0):
    """F = k δ + c δ̇: a spring and a dashpot in parallel. The force starts with a jump, c V.

    With ``end="force"`` negative forces are cut to 0: the contact ends where the force reaches 0,
    with some indentation left. ``end="indentation"`` is the model of the textbooks, whose negative
    force PULLS the bodies together on the way out, until δ = 0.

    Parameters
    ----------
    k : float
        Stiffness, N/m, positive.
    c : float
        Damping coefficient, N s/m, not negative.
    end : {"force", "indentation"}, optional
        Quantity that reaches zero at the end of the contact.

    Examples
    --------
    >>> law = ao.KelvinVoigt.from_restitution(k=1e7, restitution=0.6, mass=0.01)
    >>> [round(ao.restitution(law, 0.01, speed), 9) for speed in (0.01, 1.0)]  # at any velocity
    [0.6, 0.6]
    """

    k: float
    c: float = field(metadata=parameter(nonnegative, "N s/m"))
    end: str = field(default="force", metadata=parameter(choice, options=("force", "indentation")))

    def __post_init__(self) -> None:
        if isinstance(self.end, str) and self.end == "indentation":
            object.__setattr__(self, "pulls", True)
            object.__setattr__(self, "kind", "kelvin_voigt_pulling")
        super().__post_init__()

    @classmethod
    def from_restitution(
        cls, k: float, restitution: float, mass: float, end: str = "force"
    ) -> KelvinVoigt:
        """Return the law with which a rigid pair of reduced mass `mass` delivers `restitution`.

        Parameters
        ----------
        k : float
            Stiffness, N/m.
        restitution : float
            Restitution e, above 0 and at most 1.
        mass : float
            Reduced mass, kg.
        end : {"force", "indentation"}, optional

        Examples
        --------
        >>> law = ao.KelvinVoigt.from_restitution(1e7, 0.5, mass=0.1)
        >>> round(ao.restitution(law, mass=0.1, velocity=1.0), 6)
        0.5
        """
        return cls(k, 0.0, end)._delivering(restitution, mass, 1.0)

    def _closed_form(self, mass: float, velocity: float) -> tuple[Callable[[float], float], float]:
        restitution = swing_restitution if self.pulls else oscillator_restitution
        return restitution, 0.5 / (math.sqrt(self.k) * math.sqrt(mass))
