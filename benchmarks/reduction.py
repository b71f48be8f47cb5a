"""Time to build scene-fitted anti-oscillators, relative to the alternatives.

    python benchmarks/reduction.py [--size 2.5]
    python benchmarks/reduction.py --constrained
    python benchmarks/reduction.py --arpack [--size 1.9] [--along 100]
    python benchmarks/reduction.py --patch
    python benchmarks/reduction.py --eigen

The first call compares with one factorisation of K + s²M by the same solver and n + 2 solutions
with it, for a sphere with elements of `size` mm. --constrained does so for slender, thin and
compact bodies clamped at their ends, which also need their static mode. --arpack compares with the
lowest constraint modes by ARPACK, with factors by the same solver, at equal force error: for the
sphere on an equal one, and for a rigid ball on a slender bar clamped at both ends (4 x 4 elements
across, `along` along). --patch compares 28 constraint modes by mass for a patch and for a node,
which should take equal times, on a beam of hex20 clamped at both ends. --eigen compares 5
anti-oscillators by either method with all of them, on clamped plates. All but the first measure
processor time. Only the ratios are meaningful: machines differ and are shared.
"""

from __future__ import annotations

import argparse
import os
import time
from collections.abc import Callable
from functools import partial
from typing import Any

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np
from measuring import Line, best_times, print_table

import aoimpact as ao
from aoimpact.base import held_warnings
from aoimpact.linalg import Pencil, factorize, pardiso
from aoimpact.paper.beam import ALUMINIUM
from aoimpact.paper.sphere import BALL_MASS, LAW, RADIUS, STEEL
from aoimpact.reduction import KrylovSpace
from aoimpact.results import QUANTITIES

CONTACT_TIME = 80e-6

# `REFERENCE`: oscillators of the model to which errors are relative. `MOST`: maximum number of
# constraint modes.
REFERENCE, MOST = 80, 48


def yardstick(tip: ao.ContactPoint, solves: int, solver: str = "auto") -> None:
    inverse = tip.body.inverse((10.0 / CONTACT_TIME) ** 2, solver=solver)
    load = tip.b
    for _ in range(solves):
        load = tip.body.M @ inverse.solve(load)
        load /= np.linalg.norm(load)


def sphere(size: float) -> ao.ContactPoint:
    body = ao.FEModel.from_mesh(ao.sphere_mesh(RADIUS, size), STEEL)
    return body.contact(point=(RADIUS, 0, 0), direction=(1, 0, 0), radius=0)


def bar(along: int) -> ao.ContactPoint:
    mesh = ao.box_mesh((1.0, 0.05, 0.05), (along, 4, 4), kind="tetra10")
    body = ao.FEModel.from_mesh(mesh, ALUMINIUM, fixed=[("xmin", "xyz"), ("xmax", "xyz")])
    return body.contact(point=(0.5, 0.025, 0.05), direction=(0, 0, -1), radius=0)


def against_solutions(tip: ao.ContactPoint) -> None:
    krylov = partial(ao.antioscillators, tip, method="krylov", contact_time=CONTACT_TIME)
    lines = []
    for n in (1, 3, 8, 20):
        calls: list[Callable[[], object]] = [partial(krylov, n), partial(yardstick, tip, n + 2)]
        built, alone = best_times(*calls, enough=3.0)
        lines.append(Line(f"{n} AOs", built, f"a factorisation and {n + 2} solves", alone))
    print_table(f"Sphere, {tip.body.n_dofs} dofs, {krylov(1).origin.linear_solver}", lines)


def clamped(
    size: tuple[float, float, float], divisions: tuple[int, int, int], kind: str = "hexahedron20"
) -> ao.ContactPoint:
    mesh = ao.box_mesh(size, divisions, kind=kind)
    body = ao.FEModel.from_mesh(mesh, ALUMINIUM, fixed=[("xmin", "xyz"), ("xmax", "xyz")])
    return body.contact(point=(size[0] / 2, size[1] / 2, size[2]), direction=(0, 0, -1), radius=0)


def without_mesh(tip: ao.ContactPoint) -> ao.ContactPoint:
    """Return a contact at the main dof of `tip`, on its body given by K and M alone."""
    body = ao.FEModel(K=tip.body.K, M=tip.body.M)
    return body.contact(dof=int(np.argmax(np.abs(tip.b))))


BEAM, PLATE, BLOCK = (1.0, 0.02, 0.02), (0.3, 0.3, 0.005), (0.05, 0.05, 0.05)

CONSTRAINED: dict[str, Callable[[], ao.ContactPoint]] = {
    "Beam": partial(clamped, BEAM, (60, 3, 3)),
    "Beam, finer": partial(clamped, BEAM, (200, 4, 4)),
    "Beam of hexahedra, coarse": partial(clamped, BEAM, (50, 2, 2), "hexahedron"),
    "Beam of hexahedra": partial(clamped, BEAM, (120, 6, 6), "hexahedron"),
    "Bar of tetrahedra": partial(clamped, (1.0, 0.05, 0.05), (100, 4, 4), "tetra10"),
    "Beam without its mesh": lambda: without_mesh(clamped(BEAM, (60, 3, 3))),
    "Plate": partial(clamped, PLATE, (18, 18, 2)),
    "Plate, finer": partial(clamped, PLATE, (40, 40, 2)),
    "Block": partial(clamped, BLOCK, (9, 9, 9)),
    "Block, finer": partial(clamped, BLOCK, (15, 15, 15)),
}

# Dofs beyond which SuperLU is left out: a factorisation by it takes minutes.
SUPERLU_MOST = 20_000


def constrained_against_solutions() -> None:
    solvers = ("pardiso", "superlu") if pardiso.is_installed() else ("superlu",)
    for name, make in CONSTRAINED.items():
        tip = make()
        tip.body.rigid_modes  # noqa: B018 - a property of the body, no part of its model
        for solver in solvers if tip.body.n_dofs <= SUPERLU_MOST else solvers[:1]:
            build = partial(ao.antioscillators, tip, 8, method="krylov", solver=solver)
            calls = (partial(build, contact_time=CONTACT_TIME), partial(yardstick, tip, 10, solver))
            times = best_times(*calls, enough=5.0, clock=time.process_time)
            line = Line("8 AOs", times[0], "a factorisation and 10 solves", times[1])
            print_table(f"{name}, {tip.body.n_dofs} dofs, {solver}", [line])


class Factors:
    """A solver that factorises each matrix once for all callers, and adds up the time, s."""

    def __init__(self) -> None:
        self.seconds = 0.0
        self._kept: dict[float, Callable[[Any], Any]] = {}

    @property
    def name(self) -> str:
        return "pardiso" if pardiso.is_installed() else "superlu"

    def __call__(self, matrix: Any) -> Callable[[Any], Any]:
        trace = float(matrix.diagonal().sum())
        if trace not in self._kept:
            start = time.process_time()
            if pardiso.is_installed():
                self._kept[trace] = pardiso.PARDISO.set_up(Pencil(matrix.T, 0.0 * matrix.T)).solve
            else:
                self._kept[trace] = factorize(matrix).solve
            self.seconds += time.process_time() - start
        return self._kept[trace]


def force_errors(stars: list[ao.AOModel], exact: ao.AOModel, projectile: Any) -> list[float]:
    def run(star: ao.AOModel) -> ao.Result:
        with held_warnings():
            return ao.simulate(
                projectile=projectile or star,
                target=star,
                law=LAW,
                velocity=1.0,
                duration=3 * CONTACT_TIME,
                solver=ao.Adaptive(rtol=1e-6),
            )

    reference = run(exact)
    return [QUANTITIES["force"].difference(run(star), reference) for star in stars]


def against_arpack(name: str, tip: ao.ContactPoint, projectile: Any) -> None:
    start = time.perf_counter()
    # Scene-fitted models factorise K + s²M and, for a slender body, K. ARPACK factorises K or a
    # shifted K.
    mine, theirs = Factors(), Factors()
    krylov = partial(ao.antioscillators, tip, method="krylov", contact_time=CONTACT_TIME)
    eigen = partial(ao.antioscillators, tip, order="frequency")
    space = KrylovSpace(tip, contact_time=CONTACT_TIME, solver=mine)
    exact, *fitted = map(space.antioscillators, (REFERENCE, *range(1, 25)))
    modes = eigen(MOST, solver=theirs)
    lowest = [modes.truncated(n) for n in range(1, modes.n + 1)]
    print(
        f"\n{name}, {tip.body.n_dofs} dofs, {mine.name}: factors for scene-fitted oscillators take "
        f"{mine.seconds:.3g} s, for constraint modes {theirs.seconds:.3g} s"
    )
    errors = force_errors(fitted, exact, projectile), force_errors(lowest, exact, projectile)
    for allowed in (1e-2, 5e-3, 2e-3, 1e-3):
        few, many = (next((n for n, e in enumerate(each, 1) if e <= allowed), 0) for each in errors)
        if not few:
            print(f"  error {allowed:g}: more than {len(fitted)} scene-fitted oscillators")
            continue
        beyond = "" if many else "more than "
        (quick,), (slow,), (whole,), (other,) = (
            best_times(partial(make, n, solver=solver), enough=0.0, clock=time.process_time)
            for make, n, solver in (
                (krylov, few, mine),
                (eigen, many or MOST, theirs),
                (krylov, few, mine.name),
                (eigen, many or MOST, mine.name),
            )
        )
        print(
            f"  error {allowed:g}: {few} AOs in {quick:.3g} s, {beyond}{many or MOST} constraint "
            f"modes in {slow:.3g} s: ratio {slow / quick:.3g}; all told, each with its own "
            f"factors: {whole:.3g} s and {other:.3g} s, ratio {other / whole:.3g}",
            flush=True,
        )
    print(f"  (took {time.perf_counter() - start:.0f} s)")


def patch_against_node() -> None:
    """Time the constraint modes of largest mass for a patch and for a node on a clamped beam."""
    mesh = ao.box_mesh((1.0, 0.05, 0.05), (40, 4, 4), kind="hexahedron20")
    beam = ao.FEModel.from_mesh(mesh, ALUMINIUM, fixed=[("xmin", "xyz"), ("xmax", "xyz")])
    node, patch = (beam.contact(point=(0.37, 0.02, 0.05), radius=r) for r in (0.0, 0.014))
    with held_warnings():
        one, many = best_times(
            *(partial(ao.antioscillators, tip, 28, method="eigen") for tip in (node, patch)),
            enough=0.0,
            clock=time.process_time,
        )
    print_table(
        f"Slender beam, {beam.n_dofs} dofs",
        [Line("28 by mass, a node", one), Line("a patch", many, "a node", one)],
    )


def few_against_all() -> None:
    """Compare the times of a few anti-oscillators and of all, which must be longer."""
    for cells in ((10, 5, 2), (16, 8, 2)):
        mesh = ao.box_mesh((0.2, 0.1, 0.01), cells, kind="hexahedron20")
        plate = ao.FEModel.from_mesh(mesh, ALUMINIUM, fixed=[("xmin", "xyz")])
        tip = plate.contact(point=(0.1, 0.05, 0.01), radius=0)
        (every,), (heaviest,), (fitted,) = (
            best_times(partial(ao.antioscillators, tip, **how), enough=0.0, clock=time.process_time)
            for how in ({}, {"n": 5, "method": "eigen"}, {"n": 5, "method": "krylov"})
        )
        print(
            f"Plate, {plate.n_dofs} dofs: all anti-oscillators {every:.3g} s, the 5 heaviest "
            f"{heaviest:.3g} s (1/{every / heaviest:.0f}), 5 by krylov {fitted:.3g} s",
            flush=True,
        )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--arpack", action="store_true", help="against constraint modes by ARPACK")
    parser.add_argument("--constrained", action="store_true", help="bodies with supports")
    parser.add_argument("--patch", action="store_true", help="a patch against a node")
    parser.add_argument("--eigen", action="store_true", help="a few anti-oscillators against all")
    parser.add_argument("--size", type=float, help="of the sphere's elements, mm")
    parser.add_argument("--along", type=int, default=100, help="elements along the bar")
    options = parser.parse_args()
    if options.eigen:
        few_against_all()
        return
    if options.patch:
        patch_against_node()
        return
    if options.constrained:
        constrained_against_solutions()
        return
    ball = sphere(1e-3 * (options.size or (1.9 if options.arpack else 2.5)))
    ball.body.rigid_modes  # noqa: B018 - a property of the body, no part of its model
    if not options.arpack:
        against_solutions(ball)
        return
    against_arpack("Slender clamped bar", bar(options.along), ao.rigid(mass=BALL_MASS))
    against_arpack("Sphere on its like", ball, None)


if __name__ == "__main__":
    main()
