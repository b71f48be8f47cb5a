"""The contact law of laminates under a tup."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

from ..base import InputError, positive
from .law import HertzianLaw, parameter


def _share(name: str, value: Any) -> float:
    share = positive(name, value)
    if share > 1.0:
        raise InputError(f"{name} must be from above 0 to 1, got {share:g}")
    return share


@dataclass(frozen=True, repr=False)
class YangSun(HertzianLaw, kind="yang_sun", has_memory=True, unloading_power=2.5):
    """The indentation of a laminate, which leaves a dent beyond a critical one.

    S. H. Yang, C. T. Sun, ASTM STP 787 (1982) 425-449; T. M. Tan, C. T. Sun, J. Appl. Mech. 52
    (1985) 6-12. Loading is F = k δ^(3/2); unloading from the deepest point δ*, F*
    F = F* ((δ - δ_p) / (δ* - δ_p))^(5/2), and once the bodies have parted reloading the same with
    3/2. The permanent indentation δ_p is 0 up to δ* = δ_c; beyond, it is δ* (1 - (δ_c/δ*)^(2/5))
    by Yang and Sun, and β (δ* - δ_c) by Tan and Sun. A contact that is loaded again before the
    bodies have parted goes back as it came; of that the papers say nothing.

    Parameters
    ----------
    k : float
        N/m^1.5, positive: measured, or 4/3 √R / ((1-ν²)/E + 1/E₂) of a ball of radius R, E, ν and
        the modulus E₂ of the plies across their fibres.
    critical_indentation : float
        δ_c, m, positive: 0.080 mm of graphite/epoxy, 0.102 mm of glass/epoxy (Yang and Sun).
    beta : float, optional
        Tan and Sun's β, above 0 and at most 1; without, Yang and Sun's formula holds.
    relative_radius : float, optional
        As of `Hertz`.

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
    beta: float | None = field(default=None, metadata=parameter(_share))

    @cached_property
    def _parameters(self) -> tuple[float, ...]:
        return (self.k, self.critical_indentation, self.beta or 0.0)

    def _work(self, indentation: float) -> float:
        return 0.4 * self.k * math.pow(indentation, 2.5)
