"""Scenes of the benchmark adaptive.py, and its times, errors and choice of settings."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
from impacts import SCENES
from scipy_solvers import OdeScene, Outcome, ode_scene

import aoimpact as ao
from aoimpact.integrate import rigid_contact_time


@dataclass(frozen=True)
class Run:
    """Time, s, and largest error of the quantities asked for, with one setting of a method."""

    setting: str
    seconds: float
    error: float


@dataclass(frozen=True)
class Case:
    """A scene, the quantities asked for, the error limits, and the desired speed-ups.

    `aims` maps peer and error limit to the desired ratio of the peer's time to aoimpact's.
    """

    title: str
    scene: dict[str, Any]
    asked: tuple[str, ...]
    limits: tuple[float, ...]
    aims: dict[tuple[str, float], float]

    @property
    def stars(self) -> tuple[ao.AOModel, ao.AOModel]:
        return self.scene["projectile"], self.scene["target"]

    @property
    def length(self) -> float:
        """Scale of displacements, m: velocity times the contact time of rigid bodies."""
        inverse = sum(1.0 / star.static_mass for star in self.stars)
        velocity = self.scene["velocity"]
        return velocity * rigid_contact_time(self.scene["law"], 1.0 / inverse, velocity)

    @property
    def ode(self) -> OdeScene:
        """Equations of motion of the scene for SciPy's solvers."""
        scene = self.scene
        return ode_scene(
            self.stars,
            scene["law"],
            velocity=scene["velocity"],
            duration=scene["duration"],
            gap=0.0,
            length=self.length,
        )


def rigid_pair() -> dict[str, Any]:
    scene = SCENES["pair"]()
    ball = ao.rigid(mass=scene["projectile"].static_mass)
    return scene | {"projectile": ball, "target": ball}


CASES = {
    "rigid": Case(
        "Rigid Hertz pair, 200 µs",
        rigid_pair(),
        ("peak_force",),
        (1e-6, 1e-9),
        {("CVODE", 1e-9): 15, ("Newmark", 1e-9): 200},
    ),
    "pair": Case(
        "One-AO pair, 200 µs",
        SCENES["pair"](),
        ("peak_force",),
        (1e-6, 1e-9),
        {
            ("Newmark", 1e-6): 10,
            ("CVODE", 1e-6): 15,
            ("Exudyn", 1e-6): 15,
            ("SciPy", 1e-6): 150,
            ("Newmark", 1e-9): 150,
            ("CVODE", 1e-9): 30,
        },
    ),
    "beam": Case(
        "Rigid sphere on the 28-AO beam, 20 ms",
        SCENES["beam"](),
        ("peak_force", "rebound_velocity"),
        (1e-6,),
        {
            ("Newmark", 1e-6): 100,
            ("Exudyn", 1e-6): 250,
            ("CVODE", 1e-6): 1000,
            ("SciPy", 1e-6): 1000,
        },
    ),
}


# ------------------------------------------------------------------------------------- measuring


def best_time(call: Callable[[], object], most: int = 1000, enough: float = 0.2) -> float:
    """Return the shortest time, s, of a call repeated for `enough` s or at most `most` times."""
    best, spent, done = math.inf, 0.0, 0
    while done == 0 or (done < most and spent < enough):
        start = time.perf_counter()
        call()
        taken = time.perf_counter() - start
        best, spent, done = min(best, taken), spent + taken, done + 1
    return best


def error_of(case: Case, exact: Outcome, found: Any) -> float:
    """Return the largest relative error of the quantities asked for.

    Errors of velocities are relative to the initial velocity.
    """
    scale = {"peak_force": exact.peak_force, "rebound_velocity": case.scene["velocity"]}
    return max(abs(getattr(found, n) - getattr(exact, n)) / abs(scale[n]) for n in case.asked)


def tighten(runs: Iterable[Run | None], least: float) -> list[Run]:
    """Run tighter and tighter settings until the errors of two in a row are at most `least`."""
    done: list[Run] = []
    for run in runs:
        if run is not None:
            done.append(run)
        if len(done) >= 2 and max(done[-1].error, done[-2].error) <= least:
            break
    return done


def fastest(sweeps: list[list[Run]], limit: float) -> Run | None:
    """Return the fastest run that, like all tighter runs, meets the error limit, or None."""
    good = []
    for sweep in sweeps:
        for run in reversed(sweep):
            if not run.error <= limit:
                break
            good.append(run)
    return min(good, key=lambda run: run.seconds, default=None)


def tolerances(first: float, last: float, per_decade: int = 1) -> list[float]:
    count = round(per_decade * math.log10(first / last)) + 1
    return [float(f"{value:.2g}") for value in np.geomspace(first, last, count)]
