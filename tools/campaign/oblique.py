"""Random oblique impacts with friction, compared with an independent oracle of fixed springs.

Two rigid bodies of any inertia, touched at any arm, spin and slide, with a law k δ^n, over decades
of mass, speed, friction and slide. The package runs by Newmark's rule with its default step. The
oracle, ``tests/obliqueoracle.py``, shares no code with the package; its own error is the change to
twice the steps and springs. An answer is wrong if its difference from the oracle exceeds twice the
sum of its estimated error and the oracle's error.
"""

from __future__ import annotations

import sys
import warnings
from argparse import Namespace
from dataclasses import dataclass, replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np

import aoimpact as ao

from .outcome import Trial, Verdict

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "tests"))

from obliqueoracle import Motion, Rigid, march

# Steps and springs of the oracle, and indentation that the springs reach, over the largest
# indentation without spin.
_STEPS, _SPRINGS, _REACH = 1500, 150, 1.05

# Largest error of an answer over the sum of its estimate and the oracle's error.
_TIMES = 2.0

_DOWN = np.array([0.0, 0.0, -1.0])
_LIKE = 2.0 * (1.0 - 0.3) / (2.0 - 0.3)  # G*/E* of bodies without a material


@dataclass(frozen=True)
class Impact:
    """Two bodies, their law, coefficient of friction, and length of the record."""

    first: Rigid
    second: Rigid
    k: float
    power: float
    mu: float
    duration: float
    depth: float


def _decades(rng: np.random.Generator, low: float, high: float) -> float:
    return float(10.0 ** rng.uniform(low, high))


def _side(rng: np.random.Generator, size: float, mass: float, outward: float) -> Rigid:
    """Return a body at rest that is touched on its outward side, mostly beside its centre."""
    shape = rng.uniform(0.5, 1.0, 3)
    moments = 0.4 * mass * size**2 * np.array([*shape[:2], min(shape[2], 0.95 * sum(shape[:2]))])
    arm = size * np.array([*(rng.uniform(-0.7, 0.7, 2) * (rng.random() < 0.7)), outward])
    if rng.random() < 0.3:  # a ball
        moments, arm = np.full(3, 0.4 * mass * size**2), size * np.array([0.0, 0.0, outward])
    return (
        Rigid(mass, np.diag(moments), arm)
        if np.isfinite(mass)
        else Rigid(mass, np.eye(3), np.zeros(3))
    )


def _approach(first: Rigid) -> float:
    """Return the downward velocity of a body's contact point, m/s."""
    return float(_DOWN @ (first.velocity + np.cross(first.spin, first.arm)))


def impact_of(seed: int) -> Impact:
    """Return the impact of a seed."""
    rng = np.random.default_rng(seed)
    mass, size, speed = _decades(rng, -3, 1), _decades(rng, -3, -1), _decades(rng, -1.5, 1)
    mu, turn = _decades(rng, -2, 0.5), rng.uniform(0.0, 2.0 * np.pi)
    slide = speed * (mu * _decades(rng, -4, 1) if rng.random() < 0.8 else _decades(rng, -1, 0.5))
    velocity = np.array([slide * np.cos(turn), slide * np.sin(turn), -speed])
    first = _side(rng, size, mass, -1.0)
    spin = slide / size * rng.normal(size=3) * (rng.random() < 0.5)
    # With an arm beside the centre, spin about axes in the surface moves the contact point up or
    # down as well.
    first = replace(first, velocity=velocity, spin=0.5 * spin)
    second = _side(rng, size, np.inf if rng.random() < 0.4 else mass * _decades(rng, -1, 1), 1.0)
    power = float(rng.choice([1.5, 1.5, 1.5, 1.25, 2.0]))
    normal = max(_approach(first), 0.1 * speed)
    reduced = 1.0 / (1.0 / first.mass + 1.0 / second.mass)
    depth = size * _decades(rng, -5, -3)
    k = 0.5 * (power + 1.0) * reduced * normal**2 / depth ** (power + 1.0)
    duration = 3.0 * depth / normal * float(rng.choice([0.6, 1.1, 1.1, 2.0]))
    return Impact(first, second, k, power, mu, duration, depth)


def _numbers(of: Impact, found: Any, first: Any) -> dict[str, Any]:
    """Return peaks, impulses and changes of the first body's motion, with scales of errors."""
    size = np.linalg.norm(found.friction, axis=1)
    pressed = np.trapezoid(found.force, found.t)
    dragged = np.trapezoid(found.friction, found.t, axis=0)
    least = max(float(np.linalg.norm(dragged)), 0.1 * float(np.trapezoid(size, found.t)))
    gained, spun = first.velocity - of.first.velocity, first.spin - of.first.spin
    return {
        "peak force": (found.force.max(), found.force.max()),
        "peak friction": (size.max(), size.max()),
        "impulse": (pressed, pressed),
        "impulse of friction": (dragged, least),
        "velocity gained of the first": (gained, np.linalg.norm(gained)),
        "spin gained of the first": (spun, np.linalg.norm(spun)),
    }


def _answer(of: Impact) -> tuple[dict[str, Any], float]:
    bodies = [
        ao.rigid(side.mass)
        if np.isinf(side.mass)
        else ao.rigid(side.mass, inertia=np.diag(side.inertia), arm=side.arm)
        for side in (of.first, of.second)
    ]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ao.AOImpactWarning)  # records may end in contact
        hit = ao.simulate(
            *bodies,
            of.first.velocity,
            spin=None if np.isinf(of.first.mass) else of.first.spin,
            law=ao.PowerLaw(k=of.k, n=of.power),
            friction=of.mu,
            duration=of.duration,
            solver=ao.Newmark(),
        )
    end = SimpleNamespace(velocity=hit.projectile.final_velocity, spin=hit.projectile.final_spin)
    found = _numbers(of, Motion(hit.t, hit.force, hit.friction_force), end)
    if hit.in_contact_at_end:
        found = {name: pair for name, pair in found.items() if "gained" not in name}
    return found, hit.error.time


def _true(of: Impact, finer: int) -> dict[str, Any]:
    first, second = replace(of.first), replace(of.second)  # copies, which `march` changes
    found = march(
        first,
        second,
        _DOWN,
        k=of.k,
        mu=of.mu,
        ratio=_LIKE,
        depth=_REACH * of.depth,
        duration=of.duration,
        steps=finer * _STEPS,
        power=of.power,
        springs=finer * _SPRINGS,
    )
    return _numbers(of, found, first)


def judged(seed: int) -> Verdict:
    """Return the verdict on a seed; its `off` is the largest error over the allowed one."""
    of = impact_of(seed)
    if _approach(of.first) <= 0.0:
        return Verdict("none", "the contact points do not approach")
    try:
        coarse, true = _true(of, 1), _true(of, 2)
    except ValueError as error:  # spin makes the indentation deeper than the row of springs
        return Verdict("undecided", str(error))
    try:
        answer, claimed = _answer(of)
    except ao.AOImpactError as error:
        return Verdict("helpless", f"{type(error).__name__}: {error}")
    worst, why = 0.0, ""
    for name, (value, _) in answer.items():
        right, scale = true[name]
        off, own = (
            float(np.linalg.norm(other - right)) / max(scale, 1e-300)
            for other in (value, coarse[name][0])
        )
        if own > 0.02:
            return Verdict("undecided", f"{name}: the oracle moves by {own:.2g}")
        share = off / (_TIMES * (claimed + own))
        if share > worst:
            worst, why = share, f"{name} off by {off:.2g}, claimed {claimed:.2g}, oracle {own:.2g}"
    return Verdict("ok" if worst <= 1.0 else "wrong", why, worst)


def trial(options: Namespace, folder: Path) -> Trial:
    """Return the function that judges the impact of a number."""
    return judged
