"""Newmark's rule with Newton-Raphson (section 3.1 of the paper): settings and runs of the core."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from . import _core
from .checks import boolean, positive, real
from .errors import ConvergenceError, InputError
from .laws import ContactLaw

__all__ = ["Newmark", "Stepped", "newmark_run"]

FloatArray = npt.NDArray[np.float64]

# A record larger than this is a mistake in dt more often than a wish.
_MOST_BYTES = 4 * 2**30


@dataclass(frozen=True, kw_only=True)
class Newmark:
    """Newmark β-γ time integration with a fixed step.

    Parameters
    ----------
    dt : float, optional
        Time step, s. If not given, the step is halved until the estimated error of the peak force
        is below `rtol`.
    beta, gamma : float, optional
        β > 0 and γ ≥ 1/2. The default, β = 1/4 and γ = 1/2 (average acceleration), is of second
        order, keeps the energy of a linear system and is stable for any step, as is every rule
        with 2β ≥ γ.
    rtol : float, optional
        Relative error of the peak force to aim at when `dt` is not given.
    estimate : bool, optional
        Whether to run once more with twice the step, at half the cost again, to estimate the error.

    Raises
    ------
    InputError
        If `dt` ≤ 0, `beta` ≤ 0, `gamma` < 1/2 or `rtol` is not in (0, 1).
    """

    dt: float | None = None
    beta: float = 0.25
    gamma: float = 0.5
    rtol: float = 1e-3
    estimate: bool = True

    def __post_init__(self) -> None:
        if self.dt is not None:
            object.__setattr__(self, "dt", positive("dt", self.dt, unit="s"))
        object.__setattr__(self, "beta", positive("beta", self.beta))
        object.__setattr__(self, "gamma", real("gamma", self.gamma))
        object.__setattr__(self, "rtol", positive("rtol", self.rtol))
        boolean("estimate", self.estimate)
        if self.gamma < 0.5:
            raise InputError(
                f"gamma must be at least 1/2 (below it energy is fed in), got {self.gamma:g}"
            )
        if self.rtol >= 1.0:
            raise InputError(f"rtol must be below 1, got {self.rtol:g}")


class Stepped(Protocol):
    """A body that can be handed to the core for a step of a given size."""

    def for_core(self, rule: Newmark, dt: float) -> tuple[Any, ...]:
        """Return the core's tuple; its last two arrays are u and v, overwritten by the run."""
        ...


@dataclass(frozen=True, eq=False)
class Record:
    """What the core wrote: times, rows of ``enum aoi_row``, each body's final (u, v)."""

    t: FloatArray
    rows: FloatArray
    final: tuple[tuple[FloatArray, FloatArray], tuple[FloatArray, FloatArray]]
    dt: float


def newmark_run(
    projectile: Stepped,
    target: Stepped,
    law: ContactLaw,
    *,
    rule: Newmark,
    dt: float,
    duration: float,
    gap: float,
    energies: bool,
) -> Record:
    """Run the core once: the least whole number of steps of `dt` that covers `duration`.

    Raises
    ------
    InputError
        If the record would not fit in memory.
    ConvergenceError
        If the solution leaves the range of numbers; with the time.
    """
    steps = max(1, math.ceil(duration / dt * (1.0 - 1e-12)))
    needed = 8.0 * _core.record_rows() * (steps + 1.0)
    if needed > _MOST_BYTES:
        raise InputError(
            f"dt={dt:g} s over duration={duration:g} s makes {steps:.3g} steps and a record of "
            f"{needed / 2**30:.3g} GiB: take a larger dt or a shorter duration"
        )
    rows = np.zeros((_core.record_rows(), steps + 1))
    first, second = projectile.for_core(rule, dt), target.for_core(rule, dt)
    name, parameters = law.for_core()
    _core.impact(first, second, name, parameters, gap, dt, rule.beta, rule.gamma, rows, energies)
    final = ((first[-2], first[-1]), (second[-2], second[-1]))
    if not all(np.isfinite(values).all() for pair in final for values in pair):
        raise ConvergenceError(
            f"Newmark step: the solution grew without bound (dt={dt:g} s, beta={rule.beta:g}, "
            f"gamma={rule.gamma:g}); take 2 beta >= gamma, or a smaller dt"
        )
    return Record(dt * np.arange(steps + 1, dtype=np.float64), rows, final, dt)
