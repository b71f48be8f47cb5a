"""Random oblique impacts with friction against fixed springs that are marched by themselves.

``python -m tools.campaign.oblique --seeds 0:3000`` draws two rigid bodies of any inertia, touched
at any arm, spin and slide, with a law k δ^n, over decades of mass, speed, friction and slide. The
package runs by Newmark's rule with a step of its own. ``tests/obliqueoracle.py`` shares nothing
with it; its own error is the change to twice the steps and springs. An answer is wrong if it is
farther from the oracle than twice what it claims and the oracle's error.
"""

from __future__ import annotations

import argparse
import sys
import time as clock
import warnings
from collections import Counter
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

import aoimpact as ao

from .pool import each

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "tests"))

from obliqueoracle import Rigid, march

# s of the processor for one impact.
LIMIT = 60.0

# Steps and springs of the oracle, and how much deeper it reaches than bodies without spin go.
_STEPS, _SPRINGS, _REACH = 1500, 150, 1.05

# How many times the oracle's change, and its claim, an answer may be off.
_TIMES = 2.0

_DOWN = np.array([0.0, 0.0, -1.0])
_LIKE = 2.0 * (1.0 - 0.3) / (2.0 - 0.3)  # G*/E* where no material is known


@dataclass(frozen=True)
class Side:
    """A rigid body: kg, kg m², m, m/s and rad/s."""

    mass: float
    moments: np.ndarray
    arm: np.ndarray
    velocity: np.ndarray
    spin: np.ndarray

    @property
    def for_package(self) -> Any:
        if np.isinf(self.mass):
            return ao.rigid(self.mass)
        return ao.rigid(self.mass, inertia=self.moments, arm=self.arm)

    @property
    def for_oracle(self) -> Rigid:
        return Rigid(self.mass, np.diag(self.moments), self.arm, self.velocity, self.spin)

    @property
    def point(self) -> np.ndarray:
        """Velocity of the contact point."""
        return self.velocity + np.cross(self.spin, self.arm)


@dataclass(frozen=True)
class Impact:
    """Two bodies, their law, friction and time."""

    first: Side
    second: Side
    k: float
    power: float
    mu: float
    duration: float
    depth: float


def _decades(rng: np.random.Generator, low: float, high: float) -> float:
    return float(10.0 ** rng.uniform(low, high))


def _side(rng: np.random.Generator, size: float, mass: float, outward: float) -> Side:
    """A body at rest, that is touched on its outward side, mostly beside its centre."""
    shape = rng.uniform(0.5, 1.0, 3)
    moments = 0.4 * mass * size**2 * np.array([*shape[:2], min(shape[2], 0.95 * sum(shape[:2]))])
    arm = size * np.array([*(rng.uniform(-0.7, 0.7, 2) * (rng.random() < 0.7)), outward])
    if rng.random() < 0.3:  # a ball
        moments, arm = np.full(3, 0.4 * mass * size**2), size * np.array([0.0, 0.0, outward])
    return Side(mass, moments, arm, np.zeros(3), np.zeros(3))


def _moving(side: Side, velocity: np.ndarray, spin: np.ndarray) -> Side:
    return Side(side.mass, side.moments, side.arm, velocity, spin)


def impact_of(seed: int) -> Impact:
    """Return the impact of a seed."""
    rng = np.random.default_rng(seed)
    mass, size, speed = _decades(rng, -3, 1), _decades(rng, -3, -1), _decades(rng, -1.5, 1)
    mu, turn = _decades(rng, -2, 0.5), rng.uniform(0.0, 2.0 * np.pi)
    slide = speed * (mu * _decades(rng, -4, 1) if rng.random() < 0.8 else _decades(rng, -1, 0.5))
    velocity = np.array([slide * np.cos(turn), slide * np.sin(turn), -speed])
    first = _side(rng, size, mass, -1.0)
    spin = slide / size * rng.normal(size=3) * (rng.random() < 0.5)
    # A spin about axes in the surface moves the contact point of an arm aside up or down as well.
    first = _moving(first, velocity, 0.5 * spin)
    second = _side(rng, size, np.inf if rng.random() < 0.4 else mass * _decades(rng, -1, 1), 1.0)
    if np.isinf(second.mass):
        second = Side(np.inf, np.ones(3), np.zeros(3), np.zeros(3), np.zeros(3))
    power = float(rng.choice([1.5, 1.5, 1.5, 1.25, 2.0]))
    normal = max(float(_DOWN @ first.point), 0.1 * speed)
    reduced = 1.0 / (1.0 / first.mass + 1.0 / second.mass)
    depth = size * _decades(rng, -5, -3)
    k = 0.5 * (power + 1.0) * reduced * normal**2 / depth ** (power + 1.0)
    duration = 3.0 * depth / normal * float(rng.choice([0.6, 1.1, 1.1, 2.0]))
    return Impact(first, second, k, power, mu, duration, depth)


def _package(of: Impact) -> Any:
    return ao.simulate(
        of.first.for_package,
        of.second.for_package,
        of.first.velocity,
        spin=None if np.isinf(of.first.mass) else of.first.spin,
        law=ao.PowerLaw(k=of.k, n=of.power),
        friction=of.mu,
        duration=of.duration,
        solver=ao.Newmark(),
    )


def _oracle(of: Impact, finer: int) -> tuple[Any, list[Rigid]]:
    sides = [of.first.for_oracle, of.second.for_oracle]
    found = march(
        *sides,
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
    return found, sides


def _numbers(t: Any, force: Any, friction: Any, gains: list[np.ndarray]) -> dict[str, Any]:
    """What is compared: peaks, and what the first body gained, with the scales of errors."""
    size = np.linalg.norm(friction, axis=1)
    pressed, dragged = np.trapezoid(force, t), np.trapezoid(friction, t, axis=0)
    least = max(float(np.linalg.norm(dragged)), 0.1 * float(np.trapezoid(size, t)))
    return {
        "peak force": (force.max(), force.max()),
        "peak friction": (size.max(), size.max()),
        "impulse": (pressed, pressed),
        "impulse of friction": (dragged, least),
        **{f"{name} of the first": (gain, np.linalg.norm(gain)) for name, gain in gains},
    }


def _answer(of: Impact) -> tuple[dict[str, Any], float]:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ao.AOImpactWarning)  # of records that end in contact
        hit = _package(of)
    body = hit.projectile
    gains = [
        ("velocity gained", body.final_velocity - of.first.velocity),
        ("spin gained", body.final_spin - of.first.spin),
    ]
    if hit.in_contact_at_end:
        gains = []
    return _numbers(hit.t, hit.force, hit.friction_force, gains), hit.error.time


def _true(of: Impact, finer: int) -> dict[str, Any]:
    found, (first, _) = _oracle(of, finer)
    gains = [
        ("velocity gained", first.velocity - of.first.velocity),
        ("spin gained", first.spin - of.first.spin),
    ]
    return _numbers(found.t, found.force, found.friction, gains)


@dataclass(frozen=True)
class Verdict:
    """kind: ok, wrong, refused, undecided; off: the largest error over what it may be."""

    kind: str
    why: str = ""
    off: float = 0.0
    claimed: float = 0.0


def judged(seed: int) -> Verdict:
    """Return the verdict on a seed, in a child process."""
    of = impact_of(seed)
    if float(_DOWN @ of.first.point) <= 0.0:
        return Verdict("none", "the contact points do not approach")
    try:
        coarse, true = _true(of, 1), _true(of, 2)
    except ValueError as error:  # spin presses deeper than the row of springs
        return Verdict("undecided", str(error))
    try:
        answer, claimed = _answer(of)
    except ao.AOImpactError as error:
        return Verdict("refused", f"{type(error).__name__}: {error}")
    worst, why = 0.0, ""
    for name, (value, _) in answer.items():
        right, scale = true[name]
        off, own = (
            float(np.linalg.norm(value - right)) / max(scale, 1e-300),
            float(np.linalg.norm(coarse[name][0] - right)) / max(scale, 1e-300),
        )
        if own > 0.02:
            return Verdict("undecided", f"{name}: the oracle moves by {own:.2g}")
        share = off / (_TIMES * (claimed + own))
        if share > worst:
            worst, why = share, f"{name} off by {off:.2g}, claimed {claimed:.2g}, oracle {own:.2g}"
    return Verdict("ok" if worst <= 1.0 else "wrong", why, worst, claimed)


def main(arguments: list[str] | None = None) -> int:
    """Run the campaign; return 1 if an answer was wrong or did not come."""
    parser = argparse.ArgumentParser(prog="python -m tools.campaign.oblique", description=__doc__)
    parser.add_argument("--seeds", default="0:100", help="from:to")
    parser.add_argument("--workers", type=int, default=2)
    options = parser.parse_args(arguments)
    seeds, begin = range(*map(int, options.seeds.split(":"))), clock.monotonic()
    found: dict[int, Verdict] = {}
    for seed, state, result in each(judged, seeds, workers=options.workers, limit=LIMIT):
        verdict = result if state == "done" else Verdict("hangs", f"{state}: {result}")
        found[seed] = verdict
        if verdict.kind not in ("ok", "none"):
            print(f"{seed:7} {verdict.kind:9} {verdict.why[:150]}", flush=True)
    offs = np.array([of.off * _TIMES for of in found.values() if of.kind == "ok"])
    claims = np.array([of.claimed for of in found.values() if of.kind == "ok"])
    kinds = dict(Counter(of.kind for of in found.values()))
    print(f"{len(found)} impacts, {clock.monotonic() - begin:.0f} s: {kinds}")
    if len(offs):
        print(
            "error over what is claimed and the oracle's: "
            f"largest {offs.max():.2g}, median {np.median(offs):.2g}"
        )
        print(f"claimed: median {np.median(claims):.2g}, largest {claims.max():.2g}")
    return int(any(of.kind in ("wrong", "refused", "hangs") for of in found.values()))


if __name__ == "__main__":
    sys.exit(main())
