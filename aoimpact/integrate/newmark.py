"""Newmark's rule with Newton-Raphson (section 3.1 of the paper): settings and runs of the core."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from typing import NamedTuple

import numpy as np

from .. import _core
from ..base import (
    GIB,
    ROUNDING,
    ConvergenceError,
    FloatArray,
    Frozen,
    InputError,
    boolean,
    checked,
    positive,
    real,
)
from ..scene import Contact, RecordLayout, SteppedBody
from .tolerances import DRAWN

# A record larger than this is a mistake in dt more often than a wish.
_MOST_BYTES = 4 * GIB


@dataclass(frozen=True, kw_only=True)
class Newmark:
    """Newmark β-γ time integration with a fixed step.

    Parameters
    ----------
    dt : float, optional
        Largest time step, s. The step taken is the largest that makes a whole number of steps of
        the record: `dt` itself where it does. If not given, the step is halved until the estimated
        error is below `rtol`.
    beta, gamma : float, optional
        β > 0 and γ ≥ 1/2. The default, β = 1/4 and γ = 1/2 (average acceleration), is of second
        order, keeps the energy of a linear system and is stable for any step, as is every rule
        with 2β ≥ γ.
    rtol : float, optional
        Relative error of peak force and impulse of each contact to aim at when `dt` is not given;
        of a contact with less than a hundredth of the largest, relative to that hundredth.
    estimate : bool, optional
        Whether to run again with twice and four times the step, at three quarters of the cost, to
        estimate that error. The estimate is some three times the error where forces are smooth,
        and no less where touches, jumps and contact points without mass lower the order. Times of
        touch and release are known to within a step's interpolation and are not part of it.

    Raises
    ------
    InputError
        If `dt` ≤ 0, `beta` ≤ 0, `gamma` < 1/2 or `rtol` is not in (0, 1).

    Examples
    --------
    >>> ball = ao.rigid(mass=0.1)
    >>> hit = ao.simulate(projectile=ball, target=ball, law=ao.Hertz(k=1e9), velocity=1.0,
    ...                duration=1e-3, solver=ao.Newmark(dt=1e-6))
    >>> len(hit.t), hit.error.time < 1e-3
    (1001, True)
    """

    dt: float | None = None
    beta: float = 0.25
    gamma: float = 0.5
    rtol: float = 1e-3
    estimate: bool = True

    def __post_init__(self) -> None:
        if self.dt is not None:
            checked(self, dt=partial(positive, unit="s"))
        checked(self, beta=positive, gamma=real, rtol=positive, estimate=boolean)
        if self.gamma < 0.5:
            raise InputError(
                f"gamma must be at least 1/2 (below it energy is fed in), got {self.gamma:g}"
            )
        if self.rtol >= 1.0:
            raise InputError(f"rtol must be below 1, got {self.rtol:g}")


@dataclass(frozen=True, eq=False)
class Record(Frozen):
    """The rows that the core wrote.

    Attributes
    ----------
    t : ndarray, shape (times,)
        s.
    rows : ndarray, shape (rows, times)
        :class:`RecordLayout` tells them apart.
    final : tuple of (x, v)
        Each body's coordinates and rates at the end, as the core steps them.
    dt : float
        s.
    """

    t: FloatArray
    rows: FloatArray
    final: tuple[tuple[FloatArray, FloatArray], ...]
    dt: float


class Start(NamedTuple):
    """The forces between the bodies just after t = 0.

    Attributes
    ----------
    forces, rates : ndarrays, shape (contacts,), or None
        Contact forces, N, and their rates, N/s; None where the laws determine them.
    """

    forces: FloatArray | None = None
    rates: FloatArray | None = None


def newmark_run(
    bodies: Sequence[SteppedBody],
    contacts: Sequence[Contact],
    *,
    rule: Newmark,
    dt: float,
    duration: float,
    energies: bool = True,
    start: Start | None = None,
    precision: float = DRAWN,
) -> Record:
    """Run the core once: the least whole number of steps of `dt` that covers `duration`.

    Parameters
    ----------
    bodies : sequence of SteppedBody
    contacts : sequence of Contact
        Those that share a body are near each other.
    rule : Newmark
    dt, duration : float
        s.
    energies : bool, optional
        Whether to record them.
    start : Start, optional
        By default the contact forces are those that the laws give, which is wrong where a contact
        point without mass meets a law that depends on the rate.
    precision : float, optional
        To which friction draws the stretches of a contact, as a share of the largest.

    Raises
    ------
    InputError
        If the record would not fit in memory.
    ConvergenceError
        If the solution leaves the range of numbers; with the time.
    """
    sliding = tuple(contact.friction is not None for contact in contacts)
    count = RecordLayout(len(contacts), tuple(body.ports for body in bodies), sliding).rows
    steps = steps_of(dt, duration, count, f"dt={dt:g} s", "take a larger dt")
    rows = np.zeros((count, steps + 1))
    x, v = (np.concatenate(parts) for parts in zip(*((b.x, b.v) for b in bodies), strict=True))
    _core.newmark(
        tuple(body.for_core(dt, rule.beta, rule.gamma) for body in bodies),
        tuple(contact.for_core(contact.law.for_core(), precision) for contact in contacts),
        dt,
        rule.beta,
        rule.gamma,
        x,
        v,
        *(start or Start()),
        rows,
        energies,
    )
    if not (np.isfinite(x).all() and np.isfinite(v).all()):
        raise ConvergenceError(
            f"Newmark step: the solution grew without bound (dt={dt:g} s, beta={rule.beta:g}, "
            f"gamma={rule.gamma:g}); take 2 beta >= gamma, or a smaller dt"
        )
    t = dt * np.arange(steps + 1, dtype=np.float64)
    if abs(t[-1] - duration) <= ROUNDING * duration:
        t[-1] = duration
    ends = np.cumsum([len(body.x) for body in bodies])[:-1]
    return Record(t, rows, tuple(zip(np.split(x, ends), np.split(v, ends), strict=True)), dt)


def steps_of(dt: float, duration: float, rows: int, given: str, cure: str) -> int:
    """Return the least number of steps of `dt` that covers `duration`, both in s.

    Parameters
    ----------
    dt, duration : float
        s.
    rows : int
        Of the record.
    given, cure : str
        The caller's argument that led to `dt`, and what to give instead.

    Raises
    ------
    InputError
        If the record would not fit in memory.
    """
    steps = duration / dt * (1.0 - ROUNDING)
    needed = 8.0 * rows * (steps + 1.0)
    if needed > _MOST_BYTES:
        raise InputError(
            f"{given} over duration={duration:g} s makes {steps:.3g} steps and a record of "
            f"{needed / GIB:.3g} GiB: {cure} or a shorter duration"
        )
    return max(1, math.ceil(steps))
