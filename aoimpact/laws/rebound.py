"""How much of its speed a damped rigid mass gets back: closed forms, and an integration without.

All of it is about one mass m on one law, m δ'' = -F(δ, δ'), from δ = 0 at the speed V until the
force ends. Restitution is the speed then, over V.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import lru_cache

import numpy as np
import scipy

from ..base import FloatArray

_RTOL = 3e-14  # the tightest that the integrator takes
_RTOL_ROOT = 4.0 * np.finfo(float).eps  # and the root finder
_SMALL = 0.1  # below, x - log(1+x) is a series


def oscillator_restitution(ratio: float) -> float:
    """Return e of x'' + 2 ζ x' + x = 0 from x = 0 to where x'' = 0: the force ends.

    e = exp(-2 ζ arccos ζ / √(1-ζ²)), with arcosh and √(ζ²-1) where ζ > 1: from T. Schwager,
    T. Pöschel, Granular Matter 9 (2007) 465-469, with its branches joined.
    """
    return math.exp(-_loss(ratio))


def _loss(ratio: float) -> float:
    if ratio < 1.0:
        # arccos ζ / √(1-ζ²) without loss of digits near 1
        sine = math.sqrt((1.0 - ratio) * (1.0 + ratio))
        return 2.0 * ratio * math.atan2(sine, ratio) / sine
    if ratio == 1.0:
        return 2.0
    root = math.sqrt((ratio - 1.0) * (ratio + 1.0))
    return 2.0 * ratio * math.asinh(root) / root


def oscillator_damping(restitution: float) -> float:
    """Return the ζ with which `oscillator_restitution` is e, 0 < e ≤ 1."""
    wanted = -math.log(restitution)
    if wanted == 0.0:
        return 0.0
    # The loss lies between 2 ζ (0.6 π/2 at ζ = 0.3, say) and π ζ, or grows like 2 log 2 ζ.
    high = 1.0 + math.exp(wanted)
    return float(scipy.optimize.brentq(lambda z: _loss(z) - wanted, wanted / 4.0, high, xtol=1e-16))


def swing_restitution(ratio: float) -> float:
    """Return e of x'' + 2 ζ x' + x = 0 from x = 0 to x = 0: exp(-π ζ / √(1-ζ²)), 0 where ζ ≥ 1."""
    if ratio >= 1.0:
        return 0.0
    return math.exp(-math.pi * ratio / math.sqrt((1.0 - ratio) * (1.0 + ratio)))


def swing_damping(restitution: float) -> float:
    """Return the ζ with which `swing_restitution` is e, 0 < e ≤ 1."""
    loss = -math.log(restitution)
    return loss / math.hypot(math.pi, loss)


def _lead(x: float) -> float:
    """x - log(1+x) for x > -1, with all its digits near 0."""
    if abs(x) > _SMALL:
        return x - math.log1p(x)
    # Σ (-1)^k x^k / k, k ≥ 2
    return x * x * math.fsum((-x) ** k / (k + 2.0) for k in range(20))


def _kept_and_lead(logit: float) -> tuple[float, float]:
    """Return p = 1/(1 + exp(-logit)) and -log(1-p) - p, with 1 - p not lost where p is near 1."""
    kept = float(scipy.special.expit(logit))
    return kept, _lead(-kept) if kept < _SMALL else float(np.logaddexp(0.0, logit)) - kept


def hunt_crossley_restitution(damping: float) -> float:
    """Return e of F = k δⁿ (1 + χ δ') for χ V = `damping`, whatever k, n and the mass.

    u - log(1+u) = -u e - log(1 - u e), u = χ V: from the energy in the phase plane; the Lambert W
    form of it is e = (1 + W(-(1+u) exp(-(1+u)))) / u.
    """
    if damping < 1e-17:  # e = 1 - 2/3 χ V to first order
        return 1.0
    wanted = _lead(damping)

    def excess(logit: float) -> float:
        return _kept_and_lead(logit)[1] / wanted - 1.0

    # -u e - log(1 - u e) is at least (u e)²/2 and, for its u e ≤ 1, at least logit - 1.
    high = 2.0 + wanted
    low = min(0.0, math.log(damping)) - 2.0
    while excess(low) > 0.0:
        low -= 2.0
    logit = scipy.optimize.brentq(excess, low, high, xtol=1e-15, rtol=_RTOL_ROOT)
    kept, lead = _kept_and_lead(logit)
    if kept < _SMALL:  # the logit has its last digits in the exponent: one step of Newton
        kept -= (lead - wanted) * (1.0 - kept) / kept
    return kept / damping


def hunt_crossley_damping(restitution: float) -> float:
    """Return the χ V with which `hunt_crossley_restitution` is e, 0 < e ≤ 1."""
    e = restitution
    if e == 1.0:
        return 0.0

    def excess(logit: float) -> float:
        kept, lead = _kept_and_lead(logit)
        return lead / _lead(kept / e) - 1.0

    # At small u the ratio is e² < 1; it is infinite at u e = 1.
    low, high = -40.0, 1.0
    while excess(high) < 0.0:
        high *= 2.0
    logit = scipy.optimize.brentq(excess, low, high, xtol=1e-15, rtol=_RTOL_ROOT)
    return _kept_and_lead(logit)[0] / e


def kuwabara_kono_restitution(lag: float) -> float:
    """Return e of x'' = -(x^1.5 + a √x x') from x = 0 at x' = 1, a = `lag`.

    With z = √x and a clock τ, dt = 2 z dτ, the motion is polynomial, without a singular start:
    dz/dτ = v, dv/dτ = -2 z² (z² + a v); the force ends where z² + a v = 0.
    """
    if lag == 0.0:
        return 1.0

    def motion(_: float, state: FloatArray) -> list[float]:
        z, v = state
        return [v, -2.0 * z * z * (z * z + lag * v)]

    def released(_: float, state: FloatArray) -> float:
        z, v = state  # as z, not z²: a step may reach far beyond the end
        return float(z - math.sqrt(-lag * v)) if v < 0.0 else 1.0

    released.terminal = True  # type: ignore[attr-defined]
    with np.errstate(all="ignore"):  # the caller checks whether e is a number
        run = scipy.integrate.solve_ivp(
            motion, (0.0, 1e6), [0.0, 1.0], method="DOP853", rtol=_RTOL, atol=1e-18, events=released
        )
    return float(-run.y[1, -1]) if run.t_events[0].size else math.nan


@lru_cache(maxsize=16)  # some 20 integrations
def kuwabara_kono_lag(restitution: float) -> float:
    """Return the a with which `kuwabara_kono_restitution` is e, 0 < e ≤ 1."""
    if restitution == 1.0:
        return 0.0
    wanted = math.log(restitution)

    def excess(log_lag: float) -> float:
        return math.log(kuwabara_kono_restitution(math.exp(log_lag))) / wanted - 1.0

    # 1 - e is a to first order, within a factor of a few
    low = math.log1p(-restitution) - 2.0
    high = low + 1.0
    while excess(high) < 0.0:
        high += 1.0
    return math.exp(scipy.optimize.brentq(excess, low, high, xtol=1e-13))


def integrated_restitution(
    force: Callable[[float, float], float], mass: float, velocity: float, stroke: float
) -> float:
    """Return e of m δ'' = -F(δ, δ') by integration, for any force that is 0 where it has ended.

    As in `kuwabara_kono_restitution` the clock is dt = 2 z dτ with δ = z²: a force that starts like
    a power n/2 of the indentation is smooth in z. `stroke`, m: about how deep it goes.
    """
    scale = stroke / (mass * velocity**2)

    def motion(_: float, state: FloatArray) -> list[float]:
        z, v = state
        push = force(stroke * z * z, velocity * v) * scale if z > 0.0 else 0.0
        return [v, -2.0 * z * push]

    def parted(_: float, state: FloatArray) -> float:
        return float(state[0])

    parted.terminal = True  # type: ignore[attr-defined]
    parted.direction = -1.0  # type: ignore[attr-defined]
    run = scipy.integrate.solve_ivp(
        motion, (0.0, 1e4), [0.0, 1.0], method="DOP853", rtol=_RTOL, atol=1e-18, events=parted
    )
    return max(0.0, float(-run.y[1, -1])) if run.t_events[0].size else 0.0
