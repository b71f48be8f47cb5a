"""How often parameters of laws fitted to noisy data are within two standard errors of the truth.

    python benchmarks/law_coverage.py 10000 --workers 2 --out docs/law-coverage.csv

Laws of random parameters are measured with independent noise of 0.5 to 10 % of the peak: force
histories whose contact starts at an unknown time, curves of loading, unloading and reloading, and
dents. Normally distributed errors are within two standard errors in 95.4 of 100 cases. Parameters
that a fit names as undetermined do not count. 10 000 fits take half an hour on two cores.
"""

from __future__ import annotations

import argparse
import csv
import math
import time
import warnings
from collections import defaultdict
from collections.abc import Iterator
from multiprocessing import Pool
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

import aoimpact as ao
from aoimpact.testrig import Signal

RADIUS, WALL = 0.01, ao.rigid(mass=math.inf)
EXACT = ao.Adaptive(rtol=1e-9)
KINDS = (
    *("HuntCrossley", "Thornton", "ElasticPlastic", "KelvinVoigt", "Tsuji", "YangSun"),
    *("curve of ElasticPlastic", "curve of YangSun", "curve of PowerLaw", "dents"),
)


class Test(NamedTuple):
    """A law to be recovered, the start of its contact, s, and the arguments of `fit_law`."""

    law: Any
    begin: float
    given: dict[str, Any]


def true_law(kind: str, rng: np.random.Generator, mass: float, speed: float) -> Any:
    """Return a law whose random parameters all affect the measurement noticeably."""
    k = 10.0 ** rng.uniform(8.5, 10.0)
    depth = ao.Hertz(k).stroke(0.5 * mass * speed**2)
    peak = k * depth**1.5
    match kind.rpartition(" ")[2]:
        case "HuntCrossley":
            return ao.HuntCrossley(k, rng.uniform(0.1, 0.5) / speed)
        case "Thornton":
            return ao.Thornton(k, peak * rng.uniform(0.05, 0.5))
        case "KelvinVoigt":
            return ao.KelvinVoigt.from_restitution(peak / depth, rng.uniform(0.5, 0.9), mass)
        case "Tsuji":
            return ao.Tsuji.from_restitution(k, rng.uniform(0.5, 0.9), mass)
        case "YangSun":
            return ao.YangSun(k, depth * rng.uniform(0.1, 0.6))
        case "PowerLaw":
            return ao.PowerLaw(k * depth**0.2, 1.3 * rng.uniform(0.9, 1.5))
        case _:
            force = peak * rng.uniform(0.005, 0.05)
            pressure = 1.5 / math.pi * k * (force / k) ** (1.0 / 3.0) / RADIUS
            hardness = pressure * rng.uniform(1.5, 2.5)
            return ao.ElasticPlastic(k, force, hardness, relative_radius=RADIUS)


def start_of(law: Any, free: list[str], rng: np.random.Generator) -> dict[str, Any]:
    """Return the arguments of `fit_law` that give the initial law.

    The initial law is a class or, for plastic laws, an object with wrong values of the parameters.
    """
    if not isinstance(law, ao.ElasticPlastic):
        return {"law": type(law)}
    off = {name: getattr(law, name) * rng.uniform(1.0, 1.2) for name in free}
    own = {"k": law.k, "yield_force": law.yield_force, "hardness": law.hardness}
    return {"law": ao.ElasticPlastic(**(own | off), relative_radius=RADIUS), "free": free}


def test_of(kind: str, rng: np.random.Generator) -> Test:
    """Return a simulated noisy measurement of a random law of the given kind."""
    mass, speed = 10.0 ** rng.uniform(-2.0, 0.0), 10.0 ** rng.uniform(-0.3, 0.7)
    law, noise = true_law(kind, rng, mass, speed), 10.0 ** rng.uniform(-2.3, -1.0)
    if kind.startswith("curve"):
        up = np.linspace(0.0, law.stroke(0.5 * mass * speed**2), 120)
        path = np.concatenate([up, up[::-1][1:], 1.2 * up[1:]])
        force = law.force(path, along=True)
        force = force + noise * force.max() * rng.normal(size=force.shape)
        given = start_of(law, ["k", "hardness"], rng)
        return Test(law, 0.0, given | {"indentation": path, "force": force})
    if kind == "dents":
        fully = math.sqrt(2.0 * law._work(3.0 * law.plastic_indentation) / mass)
        speeds = max(speed, fully) * np.linspace(0.5, 2.0, 12)
        wide = np.array([law.dent(law.stroke(0.5 * mass * v**2)).diameter for v in speeds])
        wide = wide + noise * wide.mean() * rng.normal(size=wide.shape)
        given = start_of(law, ["hardness"], rng)
        return Test(law, 0.0, given | {"dent": wide, "mass": mass, "velocity": speeds})
    blow = {"projectile": ao.rigid(mass=mass), "target": WALL, "law": law, "velocity": speed}
    length = ao.simulate(**blow, solver=EXACT).contact_duration
    hit = ao.simulate(**blow, duration=2.0 * length, solver=EXACT)
    begin = length * rng.uniform(0.1, 0.6)
    t = np.linspace(0.0, 2.0 * length, int(rng.integers(100, 400)))
    force = np.zeros(len(t))
    force[t > begin] = hit.at(t[t > begin] - begin).force
    force = force + noise * hit.peak_force * rng.normal(size=force.shape)
    given = start_of(law, ["hardness"], rng) | {"signal": Signal(t, force)}
    return Test(law, begin, given | {"mass": mass, "velocity": speed})


def fitted(number: int) -> list[tuple[str, str, float]]:
    """Return kind, parameter and error/standard error of each fitted parameter; NaN: fit failed."""
    rng, kind = np.random.default_rng([7, number]), KINDS[number % len(KINDS)]
    test = test_of(kind, rng)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            fit = ao.fit_law(**test.given)
        except ao.AOImpactError:
            return [(kind, "", math.nan)]
    found = []
    for name, error in fit.standard_errors.items():
        if name in fit.undetermined:
            continue
        true = test.begin if name == "start_time" else getattr(test.law, name)
        value = fit.start_time if name == "start_time" else getattr(fit.law, name)
        found.append((kind, name, (value - true) / error))
    return found


def table(scores: dict[tuple[str, str], list[float]]) -> Iterator[tuple[Any, ...]]:
    """Return rows: kind, parameter, fits, percent of fits within 1, 2 and 3 standard errors."""
    every = [z for of in scores.values() for z in of]
    for (kind, name), of in [*sorted(scores.items()), (("all", ""), every)]:
        away = np.abs(of)
        shares = [round(100.0 * float(np.mean(away < size)), 1) for size in (1.0, 2.0, 3.0)]
        yield kind, name, len(of), *shares


def main() -> None:
    """Fit the laws, print the table of coverage, and write it to a file."""
    arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    arguments.add_argument("fits", type=int, nargs="?", default=200)
    arguments.add_argument("--workers", type=int, default=1)
    arguments.add_argument("--out", type=Path)
    given = arguments.parse_args()
    began, failed = time.perf_counter(), 0
    scores: dict[tuple[str, str], list[float]] = defaultdict(list)
    with Pool(given.workers) as pool:
        for fit in pool.imap_unordered(fitted, range(given.fits), chunksize=10):
            for kind, name, score in fit:
                if math.isnan(score):
                    failed += 1
                else:
                    scores[kind, name].append(score)
    head = "measurement", "parameter", "fits", "within 1 (%)", "within 2 (%)", "within 3 (%)"
    rows = list(table(scores))
    for row in (head, *rows):
        print("  ".join(f"{value!s:>24}" for value in row))
    print(f"{given.fits} fits, {failed} failed, {time.perf_counter() - began:.0f} s")
    if given.out:
        with given.out.open("w", newline="", encoding="utf-8") as file:
            csv.writer(file, lineterminator="\n").writerows([head, *rows])


if __name__ == "__main__":
    main()
