"""Damping of linear bodies: Rayleigh's, and one ratio for all natural modes."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
import numpy.typing as npt

from ..base import HUGE, InputError, InputTypeError, checked, finite_array, nonnegative


def _coefficient(name: str, value: Any, unit: str = "") -> float:
    """Return `value` as a float; refuse it if products with frequencies could overflow."""
    number = nonnegative(name, value, unit=unit)
    if number > HUGE:
        raise InputError(f"{name} must be at most {HUGE:g}{unit and ' ' + unit}, got {number:g}")
    return number


@dataclass(frozen=True, kw_only=True)
class Rayleigh:
    """Damping in proportion to mass and stiffness, C = αM + βK.

    An AO model gets the equivalent dashpots: α m_i from each mass to the ground and β k_i parallel
    to each spring. The residual compliance of a massless contact (m0 = 0) is undamped; runs warn if
    this matters.

    Parameters
    ----------
    alpha : float, optional
        Coefficient α of the mass, 1/s, not negative. Also slows down a free body's rigid motion.
    beta : float, optional
        Coefficient β of the stiffness, s, not negative.

    Examples
    --------
    >>> round(ao.Rayleigh(alpha=10.0, beta=1e-6).decay(1000.0), 6)  # 1/s at 1000 rad/s
    5.5
    """

    alpha: float = 0.0
    beta: float = 0.0

    def __post_init__(self) -> None:
        checked(self, alpha=partial(_coefficient, unit="1/s"), beta=partial(_coefficient, unit="s"))

    def decay(self, omega: npt.ArrayLike) -> Any:
        """Return the decay rate σ = (α + β ω²)/2, 1/s, of modes x'' + 2σx' + ω²x = f.

        Parameters
        ----------
        omega : array_like
            Angular frequencies, rad/s, any shape.

        :meta private:
        """
        frequency = finite_array("omega", omega, unit="rad/s", most=HUGE)
        decay = 0.5 * (self.alpha + self.beta * frequency**2)
        return decay if decay.ndim else float(decay)


@dataclass(frozen=True)
class ModalDamping:
    """The same damping ratio for every elastic mode; rigid motion is not damped.

    Parameters
    ----------
    ratio : float
        Damping ratio ζ (1: critical damping), not negative.

    Examples
    --------
    >>> round(ao.ModalDamping(ratio=0.02).decay(1000.0), 6)  # 1/s at 1000 rad/s
    20.0
    """

    ratio: float

    def __post_init__(self) -> None:
        checked(self, ratio=_coefficient)

    def decay(self, omega: npt.ArrayLike) -> Any:
        """Return the decay rate σ = ζω, 1/s, of modes x'' + 2σx' + ω²x = f.

        :meta private:
        """
        frequency = finite_array("omega", omega, unit="rad/s")
        decay = self.ratio * np.abs(frequency)
        return decay if decay.ndim else float(decay)


Damping = Rayleigh | ModalDamping


def damping_or_none(value: Any) -> Damping | None:
    """Return `value` if it is a damping or None; zero damping gives None.

    Raises
    ------
    InputTypeError
    """
    if value is None:
        return None
    if isinstance(value, (Rayleigh, ModalDamping)):
        return None if value in (Rayleigh(), ModalDamping(0.0)) else value
    raise InputTypeError(f"damping must be Rayleigh(alpha, beta) or ModalDamping, got {value!r}")
