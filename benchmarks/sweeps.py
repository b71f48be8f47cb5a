"""Sweeps: impacts per second, what threads add, and what a million cases leave in memory.

    python benchmarks/sweeps.py [--million]

Two spheres of one anti-oscillator each, and two rigid ones, over their velocity, at rtol 1e-6:
made together by the core, by `simulate` one after the other, and by two threads. Then a Monte Carlo
study: random balls at random speeds on one meshed plate, each number with its error. With
--million, a stream of a million rigid impacts, and the most memory that the process has held (half
a minute).
"""

from __future__ import annotations

import os
import resource
import sys
import time
from collections.abc import Callable, Iterator
from typing import Any

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np
from impacts import pair
from measuring import Line, best_times, print_table

import aoimpact as ao

NAMES = ("peak_force", "contact_duration", "rebound_velocity")
CASES, FEW, BALLS = 4000, 100, 10_000

BALL = ao.rigid(mass=0.0327)
RIGID = pair() | {"projectile": BALL, "target": BALL, "duration": 1e-4}


def cases(base: dict[str, Any], count: int) -> Iterator[dict[str, Any]]:
    """The impact at `count` velocities."""
    rule = ao.Adaptive(rtol=1e-6)
    for velocity in np.linspace(0.5, 1.5, count).tolist():
        yield base | {"velocity": velocity, "solver": rule}


def sweep(base: dict[str, Any], workers: int) -> Callable[[], object]:
    """A sweep that keeps numbers."""
    return lambda: ao.simulate_many(list(cases(base, CASES)), workers, keep=NAMES)


def loop(base: dict[str, Any]) -> Callable[[], object]:
    """The loop that one would write."""

    def run() -> None:
        for case in cases(base, FEW):
            hit = ao.simulate(**case)
            _ = [getattr(hit, name) for name in NAMES]

    return run


def report(name: str, base: dict[str, Any]) -> None:
    """Print what an impact takes, s, and the rates that follow."""
    alone, two, by_hand = best_times(sweep(base, 1), sweep(base, 2), loop(base), enough=6.0)
    each, shared, slow = alone / CASES, two / CASES, by_hand / FEW
    print_table(
        f"{name}, an impact",
        [
            Line("simulate in a loop", slow),
            Line("simulate_many", each, "simulate", slow),
            Line("with two threads", shared, "one thread", each),
        ],
    )
    print(f"  {1.0 / each:.3g} a second on one core, {1.0 / shared:.3g} on two")


def plate_cases(count: int) -> list[dict[str, Any]]:
    """Random balls at random speeds on a plate of 14 175 dofs."""
    steel = ao.Material(E=210e9, nu=0.3, rho=7800)
    mesh = ao.box_mesh((0.2, 0.2, 0.01), (20, 20, 2), kind="hexahedron20")
    tip = ao.FEModel.from_mesh(mesh, steel).contact(point=(0.11, 0.09, 0.01))
    draws = np.random.default_rng(1).uniform((0.004, 0.3), (0.012, 3.0), (count, 2)).tolist()
    return [
        {"projectile": ao.ball(radius, steel), "target": tip, "velocity": velocity}
        for radius, velocity in draws
    ]


def monte_carlo() -> None:
    """Many impacts on one plate that is reduced once, against a loop that reduces it each time."""
    keep = ("peak_force", "contact_duration", "restitution")
    every = plate_cases(BALLS)

    def loop() -> None:
        for case in every[:3]:
            hit = ao.simulate(**case)
            _ = [(getattr(hit, name), hit.error[name].total) for name in keep]

    start, used = time.perf_counter(), time.process_time()
    kept = ao.simulate_many(every, keep=keep)
    seconds, used = time.perf_counter() - start, time.process_time() - used
    (slow,) = best_times(loop)
    print_table(
        f"{BALLS} random balls on one plate, an impact with its errors",
        [
            Line("simulate in a loop", slow / 3),
            Line("simulate_many", seconds / BALLS, "simulate", slow / 3),
            Line("by the processor's clock", used / BALLS, "simulate", slow / 3),
        ],
    )
    errors = np.array([numbers["peak_force_error"] for numbers in kept])
    print(f"  {seconds:.3g} s in all; errors of the peak force up to {100.0 * errors.max():.2g} %")


def million() -> None:
    """A stream of a million cases."""
    start = time.perf_counter()
    total = sum(kept["peak_force"] for kept in ao.simulate_many(cases(RIGID, 10**6), keep=NAMES))
    unit = 1 if sys.platform == "darwin" else 1024
    most = unit * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    seconds = time.perf_counter() - start
    print(f"\na million rigid impacts: {seconds:.1f} s, mean peak {total / 1e6:.1f} N")
    print(f"  the process has held {most / 2**20:.0f} MiB at most")


if __name__ == "__main__":
    if "--million" in sys.argv[1:]:
        million()
    else:
        report("Two spheres of one anti-oscillator", pair())
        report("Two rigid spheres", RIGID)
        monte_carlo()
