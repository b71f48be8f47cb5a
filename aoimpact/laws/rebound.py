"""Restitution e of a rigid mass on a damped contact law: closed forms, else by integration.

A mass m moves according to m δ'' = -F(δ, δ'), from δ = 0 with the speed V until the force ends; e
is the ratio of its final speed to V.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import lru_cache

import numpy as np
import scipy

from ..base import ROUNDING, FloatArray

_SMALL = 0.1  # |x| up to which x - log(1+x) is summed as a series


def oscillator_restitution(ratio: float) -> float:
    """Return e of x'' + 2 ζ x' + x = 0 from x = 0 to x'' = 0, where the force ends; ζ is `ratio`.

    e = exp(-2 ζ arccos ζ / √(1-ζ²)), with arcosh and √(ζ²-1) where ζ > 1: from T. Schwager,
    T. Pöschel, Granular Matter 9 (2007) 465-469, with its branches joined.
    """
    sine = math.sqrt(abs((1.0 - ratio) * (1.0 + ratio)))  # accurate in all digits near ratio = 1
    angle = math.atan2(sine, ratio) if ratio < 1.0 else math.asinh(sine)
    return math.exp(-2.0 * ratio * (angle / sine if sine else 1.0))


def swing_restitution(ratio: float) -> float:
    """Return e of x'' + 2 ζ x' + x = 0 from x = 0 to x = 0: exp(-π ζ / √(1-ζ²)), 0 where ζ ≥ 1."""
    if ratio >= 1.0:
        return 0.0
    return math.exp(-math.pi * ratio / math.sqrt((1.0 - ratio) * (1.0 + ratio)))


def _lead(x: float) -> float:
    """Return x - log(1+x) for x > -1, with all its digits near 0."""
    if abs(x) > _SMALL:
        return x - math.log1p(x)
    # Σ (-1)^k x^k / k, k ≥ 2
    return x * x * math.fsum((-x) ** k / (k + 2.0) for k in range(20))


def hunt_crossley_restitution(damping: float) -> float:
    """Return e of F = k δⁿ (1 + χ δ') for χ V = `damping`, whatever k, n and the mass.

    u - log(1+u) = -u e - log(1 - u e), u = χ V: from the energy in the phase plane. In terms of the
    Lambert W function, e = (1 + W(-(1+u) exp(-(1+u)))) / u.
    """
    if damping < 1e-17:  # e = 1 - 2/3 χ V to first order
        return 1.0
    wanted = _lead(damping)
    kept = damping * (1.0 - 2.0 / 3.0 * damping)  # u e to second order
    if damping > _SMALL:
        kept = 1.0 + float(scipy.special.lambertw(-math.exp(-1.0 - wanted)).real)
    # Newton steps restore the digits that W loses near its branch point, kept = 0. Near kept = 1,
    # where 1 - kept consists of rounding errors, a step might exceed 1.
    for _ in range(3 if kept < 0.5 else 0):
        kept -= (_lead(-kept) - wanted) * (1.0 - kept) / kept
    return kept / damping


def kuwabara_kono_restitution(lag: float) -> float:
    """Return e of x'' = -(x^1.5 + a √x x') from x = 0 at x' = 1, a = `lag`."""

    def push(z: float, v: float) -> float:
        return z * (z * z + lag * v)

    def released(z: float, v: float) -> float:
        # z, not z², is compared: a step far beyond the end has z < 0, whose square may exceed -a v.
        return z - math.sqrt(-lag * v) if v < 0.0 else 1.0

    return _integrated(push, released) if lag > 0.0 else 1.0


def integrated_restitution(
    force: Callable[[float, float], float], mass: float, velocity: float, stroke: float
) -> float:
    """Return e of m δ'' = -F(δ, δ') by integration, for any force that stays 0 after the contact.

    `stroke`, m: approximate largest indentation.
    """
    scale = stroke / (mass * velocity**2)

    def push(z: float, v: float) -> float:
        return force(stroke * z * z, velocity * v) * scale if z > 0.0 else 0.0

    return max(0.0, _integrated(push, lambda z, v: z))


def _integrated(
    push: Callable[[float, float], float], ended: Callable[[float, float], float]
) -> float:
    """Return e of x'' = -push(√x, x'), x' = 1 at x = 0, to where `ended` falls to 0; 0 if never.

    With z = √x and the scaled time τ, dt = 2 z dτ, the equations are dz/dτ = v and
    dv/dτ = -2 z push(z, v). Their solution is smooth from the start for forces like x^(n/2).
    """

    def motion(_: float, state: FloatArray) -> list[float]:
        z, v = state
        return [v, -2.0 * z * push(z, v)]

    def event(_: float, state: FloatArray) -> float:
        return float(ended(*state))

    event.terminal = True  # type: ignore[attr-defined]
    event.direction = -1.0  # type: ignore[attr-defined]
    with np.errstate(all="ignore"):  # the caller checks whether e is a number
        run = scipy.integrate.solve_ivp(
            motion, (0.0, 1e6), [0.0, 1.0], method="DOP853", rtol=ROUNDING, atol=1e-18, events=event
        )
    return float(-run.y[1, -1]) if run.t_events[0].size else 0.0


@lru_cache(maxsize=16)  # without a closed form, a call takes some 20 integrations
def damping_for(restitution: Callable[[float], float], wanted: float) -> float:
    """Return the damping number x at which `restitution` gives the `wanted` e, 0 < e ≤ 1.

    The restitution falls from 1 at x = 0, by at most 4 x.
    """
    if wanted == 1.0:
        return 0.0

    def excess(log_x: float) -> float:
        return restitution(math.exp(log_x)) - wanted

    low = math.log(0.25 * (1.0 - wanted))
    high = low + 1.0
    while excess(high) > 0.0:
        low, high = high, high + 1.0
    return math.exp(scipy.optimize.brentq(excess, low, high, xtol=1e-15))
