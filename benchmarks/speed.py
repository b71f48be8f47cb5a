"""Times of calls and of factorisations: medians of runs, each in a process of its own.

    python benchmarks/speed.py [ROW ...] [--runs 5]

Times are processor times with one thread; for meshed bodies they include all from the mesh to the
summary, and the peak memory is given. In the same process, the same matrices K + s²M, with s = 2
divided by the contact time, are analysed and factorised by pypardiso, if that is installed, and for
small bodies by SuperLU, and `eigsh` computes 18 modes. "plate", "block" and "sphere", which are run
only if they are named, have 10⁶ dofs, and compute the peak force to 1 %.
"""

from __future__ import annotations

import argparse
import importlib.util
import json
import os
import resource
import subprocess
import sys
from collections.abc import Callable
from functools import partial
from statistics import median
from typing import Any

import numpy as np
from cases import CASES
from scipy.sparse import triu
from scipy.sparse.linalg import eigsh, splu

import aoimpact as ao
from aoimpact.base import with_unit

STEEL, ALUMINIUM = ao.Material(E=210e9, nu=0.3, rho=7800), ao.Material(E=70e9, nu=0.33, rho=2700)
BALL, DOWN = ao.ball(0.01, STEEL), (0.0, 0.3, -1.0)
FIRST = "import aoimpact as ao; b = ao.ball(.01, ao.Material(2e11, .3, 7800)); ao.simulate(b, b, 1)"

# Dofs up to which SuperLU and eigsh are timed; larger bodies take them minutes.
MOST = 20_000

Found = tuple[float, dict[str, float]]


def seconds(call: Callable[..., object], *given: Any, of: int = resource.RUSAGE_SELF) -> float:
    """Return the processor time of a call, s, of this process or of its children."""
    before = resource.getrusage(of)
    call(*given)
    after = resource.getrusage(of)
    return after.ru_utime - before.ru_utime + after.ru_stime - before.ru_stime


def block(size: tuple[float, ...], n: tuple[int, ...], *held: str) -> ao.ContactPoint:
    """Return the contact at the middle of the upper side of a block held at some of its sides."""
    mesh = ao.box_mesh(size, n, kind="hexahedron20")
    body = ao.FEModel.from_mesh(mesh, ALUMINIUM, fixed=[(side, "xyz") for side in held])
    return body.contact(point=(0.5 * size[0], 0.5 * size[1], size[2]))


def plate(*n: int) -> ao.ContactPoint:
    """Return the contact point on the plate of the README's example."""
    return block((0.1, 0.08, 0.01), n, "xmin", "xmax")


def ball(size: float = 0.003) -> ao.ContactPoint:
    """Return the contact point on the ball of the README's example."""
    mesh = ao.sphere_mesh(radius=0.01, size=size)
    return ao.FEModel.from_mesh(mesh, STEEL).contact(point=(0, 0, -0.01))


def struck(
    target: Callable[[], Any], projectile: Callable[[], Any] = lambda: BALL, **how: Any
) -> Found:
    """Return the time of a call, s, its memory, KiB, and peers' times on its matrices, s."""
    bodies: list[Any] = []
    hits: list[ao.Result] = []

    def call() -> None:
        bodies[:] = target(), projectile()
        hits.append(ao.simulate(bodies[1], bodies[0], 1.0, **how))
        str(hits[0])

    taken, peers = seconds(call), {"KiB": float(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)}
    for body in [one.body for one in bodies if isinstance(one, ao.ContactPoint)]:
        A = (body.K + (2.0 / hits[0].contact_duration) ** 2 * body.M).tocsc()
        ways: list[tuple[Any, ...]] = []
        if importlib.util.find_spec("pypardiso"):
            from pypardiso import PyPardisoSolver

            ways += [("pypardiso", PyPardisoSolver(2).factorize, triu(A, format="csr"))]
        if body.n_dofs < MOST:
            ways += [
                ("SuperLU", splu, A, "MMD_AT_PLUS_A", 0.0, None, None, {"SymmetricMode": True})
            ]
            ways += [("eigsh", eigsh, body.K, 18, body.M, -1e6)]
        for name, *way in ways:
            peers[name] = peers.get(name, 0.0) + seconds(*way)
    return taken, peers


def first_impact() -> Found:
    """Time a process that makes one impact of rigid bodies, and one that imports SciPy's arrays."""
    codes = FIRST, FIRST, "import scipy.sparse"  # the first run compiles bytecode
    _, taken, theirs = (
        seconds(subprocess.run, [sys.executable, "-c", code], of=resource.RUSAGE_CHILDREN)
        for code in codes
    )
    return taken, {"import scipy.sparse": theirs}


def rigid_pair() -> Found:
    """Time one of 4000 impacts of a rigid pair, and SciPy's DOP853 at the same tolerance."""
    case, rule = CASES["rigid"], ao.Adaptive(rtol=1e-6)
    speeds = np.linspace(0.5, 1.5, 4000).tolist()
    cases = [case.scene | {"velocity": speed, "solver": rule} for speed in speeds]
    keep = ("peak_force", "contact_duration", "rebound_velocity")
    taken = seconds(lambda: ao.simulate_many(cases, keep=keep)) / len(cases)
    return taken, {"DOP853": seconds(case.ode.run, "DOP853", 1e-6)}


def monte_carlo(spread: float, count: int = 300) -> Found:
    """Time one of many impacts with error estimates, of random radii and speeds, and the first."""
    draws, tip = np.random.default_rng(1).uniform(-1.0, 1.0, (count, 2)), plate(20, 16, 3)
    cases = [
        {"projectile": ao.ball(0.01 * spread**r, STEEL), "target": tip, "velocity": spread**v}
        for r, v in draws.tolist()
    ]
    keep = ("peak_force", "contact_duration", "restitution")
    first, others = (
        seconds(lambda some=some: ao.simulate_many(some, keep=keep)) / len(some)
        for some in (cases[:1], cases[1:])
    )
    return others, {"the first": first}


def oblique(target: Any, count: int = 10) -> Found:
    """Time an impact with friction, with a model made beforehand."""
    body = ao.simulate(BALL, target, DOWN, friction=0.2).models[1]

    def calls() -> None:
        for _ in range(count):
            _ = ao.simulate(BALL, body, DOWN, friction=0.2, duration=2e-4).peak_force

    return seconds(calls) / count, {}


ROWS: dict[str, Callable[[], Found]] = {
    "readme": partial(struck, partial(plate, 20, 16, 3), ball),
    "58k": partial(struck, partial(plate, 40, 32, 3)),
    "224k": partial(struck, partial(plate, 79, 63, 3)),
    "first": first_impact,
    "rigid": rigid_pair,
    "alike": partial(monte_carlo, 1.05),
    "wide": partial(monte_carlo, 3.0**0.5),
    "wall": lambda: oblique(ao.wall(STEEL)),
    "friction": lambda: oblique(plate(20, 16, 3)),
}
TO_A_PERCENT: dict[str, Any] = {"quantity": "peak_force", "rtol": 1e-2}
EDGES = ("xmin", "xmax", "ymin", "ymax")
LARGE: dict[str, Callable[[], Any]] = {
    "plate": lambda: block((0.4, 0.3, 0.01), (130, 98, 4), *EDGES),
    "block": lambda: block((0.1, 0.1, 0.1), (43, 43, 43), "zmin"),
    "sphere": lambda: ball(0.57e-3),
}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("rows", nargs="*", default=list(ROWS), help=", ".join(ROWS | LARGE))
    parser.add_argument("--runs", type=int, default=5)
    parser.add_argument("--one", action="store_true", help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.one:
        large = {name: partial(struck, of, **TO_A_PERCENT) for name, of in LARGE.items()}
        print(json.dumps((ROWS | large)[options.rows[0]]()))
        return
    threads = {f"{library}_NUM_THREADS": "1" for library in ("OMP", "MKL", "OPENBLAS")}
    for row in options.rows:
        command = [sys.executable, __file__, row, "--one"]
        answers = [
            subprocess.run(command, check=True, capture_output=True, env=os.environ | threads)
            for _ in range(options.runs)
        ]
        times, peers = zip(*(json.loads(answer.stdout) for answer in answers), strict=True)
        taken, line = median(times), f"{row:9}{with_unit(median(times), 's', 3):>9}"
        for name, value in ((name, median(of[name] for of in peers)) for name in peers[0]):
            peer = f"{taken / value:.3g} x {name} ({with_unit(value, 's', 3)})"
            line += "  " + (f"{value / 2**20:.2f} GiB" if name == "KiB" else peer)
        print(line, flush=True)


if __name__ == "__main__":
    main()
