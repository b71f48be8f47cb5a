"""Time of an impact to a tolerance, relative to building models of the order that it returns.

    python benchmarks/choice.py [--size 1.0] [--rtol 1e-1 1e-2 1e-3] [--quantity force]
    python benchmarks/choice.py beam plate --size 2 --full

The time of the whole call `simulate(quantity=, rtol=)` is compared with that of building Krylov
models of 2 n + 8 oscillators by the quickest linear solver, where n is the number of oscillators of
the returned models. The true error, printed in multiples of the tolerance, is the difference from
models of 150 oscillators or more. Bodies have 10 000 to 180 000 dofs at --size 1 (elements half as
large at .5); six of them are meshed by gmsh. Times are processor times with one thread, of the
first call of each: nothing is kept from one call to the other. --full also times Newmark's rule on
the full model, with the largest step for which its error is not above that of the returned models.
The quantity of --quantity stress is von Mises' equivalent stress 20 mm from the contact, and times
include its history.
"""

from __future__ import annotations

import argparse
import math
import os
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, partial
from pathlib import Path
from typing import Any

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
os.environ.setdefault("MKL_NUM_THREADS", "1")

import numpy as np

import aoimpact as ao
from aoimpact.base import choice, held_warnings
from aoimpact.linalg import METHODS, Pencil
from aoimpact.reduction import KrylovSpace
from aoimpact.results import QUANTITIES

STEEL = ao.Material(E=210e9, nu=0.3, rho=7800)
ALUMINIUM = ao.Material(E=70e9, nu=0.3, rho=2700)
BALL = ao.rigid(mass=4 / 3 * math.pi * 0.01**3 * STEEL.rho)
ON_ALUMINIUM = ao.Hertz.between(STEEL, 0.01, ALUMINIUM, math.inf)

# Oscillators of the models to which true errors are relative: at least REFERENCE, and TIMES_AS_MANY
# times the number at the strictest tolerance.
REFERENCE, TIMES_AS_MANY = 150, 3

# FROM_CONTACT: distance from the contact at which stress is computed, m. TIMES: number of times.
FROM_CONTACT, TIMES = 0.02, 400

# A linear solver is timed if its estimated time is at most this multiple of the quickest solver's.
SLOWER = 2.0


def disc(size: float) -> tuple[Any, ...]:
    """A ball on a free lens, a flattened sphere of 100 mm times 20 mm."""
    round_mesh = ao.sphere_mesh(0.05, 0.016 * size)
    flat = round_mesh.nodes * np.array([1.0, 1.0, 0.2])
    body = ao.FEModel.from_mesh(ao.Mesh(flat, round_mesh.cells, round_mesh.kind), ALUMINIUM)
    tip = body.contact(point=(0.0, 0.0, 0.01), direction=(0, 0, -1), radius=0.004)
    return BALL, tip, ON_ALUMINIUM, 2e-4


def box(lengths: Any, divisions: Any, size: float, place: Any, fixed: Any) -> ao.ContactPoint:
    counts = [max(1, round(count / size)) for count in divisions]
    mesh = ao.box_mesh(lengths, counts, kind="hexahedron20")
    body = ao.FEModel.from_mesh(mesh, ALUMINIUM, fixed=fixed)
    return body.contact(point=place, direction=(0, 0, -1), radius=0.004)


def plate(size: float) -> tuple[Any, ...]:
    """A ball on a plate of 300 x 200 x 6 mm held at its edges, struck off its centre."""
    edges = [(side, "xyz") for side in ("xmin", "xmax", "ymin", "ymax")]
    tip = box((0.3, 0.2, 0.006), (36, 24, 1), size, (0.12, 0.07, 0.006), edges)
    return BALL, tip, ON_ALUMINIUM, 3e-4


def beam(size: float) -> tuple[Any, ...]:
    """A ball on a beam of 500 x 20 x 20 mm held at its ends, struck at midspan."""
    ends = [(side, "xyz") for side in ("xmin", "xmax")]
    tip = box((0.5, 0.02, 0.02), (60, 3, 3), size, (0.25, 0.01, 0.02), ends)
    return BALL, tip, ON_ALUMINIUM, 1e-3


def spheres(size: float) -> tuple[Any, ...]:
    """Two steel spheres of radii 10 and 12 mm."""
    tips = []
    for radius, place in ((0.01, 0.01), (0.012, -0.012)):
        body = ao.FEModel.from_mesh(ao.sphere_mesh(radius, 0.17 * radius * size), STEEL)
        tips.append(body.contact(point=(place, 0, 0), direction=(1, 0, 0), radius=0.003))
    return *tips, ao.Hertz.between(STEEL, 0.01, STEEL, 0.012), 1.5e-4


@dataclass(frozen=True, eq=False)
class Part:
    """A body meshed by gmsh with ten-node tetrahedra, finer around the contact.

    Attributes
    ----------
    solids, holes : sequence of tuple
        Solids that are joined, and solids that are cut out: a "Box", "Cylinder" or "Sphere" and the
        arguments of gmsh's function for it, m.
    size : float
        Size of elements away from the contact, m.
    place : tuple
        Place that is struck along -z, m.
    duration : float
        Length of the record, s.
    clamped : tuple of str and float, optional
        The plane, such as ("x", 0), whose nodes do not move.
    """

    solids: Any
    holes: Any
    size: float
    place: tuple[float, float, float]
    duration: float
    clamped: tuple[str, float] | None = None

    def __call__(self, size: float) -> tuple[Any, ...]:
        fixed = []
        if self.clamped is not None:
            axis, there = "xyz".index(self.clamped[0]), self.clamped[1]
            fixed = [(lambda nodes: abs(nodes[:, axis] - there) < 1e-7, "xyz")]
        body = ao.FEModel.from_mesh(self.mesh(size), ALUMINIUM, fixed=fixed)
        tip = body.contact(point=self.place, direction=(0, 0, -1), radius=0.004)
        return BALL, tip, ON_ALUMINIUM, self.duration

    @cache  # noqa: B019 - a few parts, for as long as the program runs
    def mesh(self, size: float) -> ao.Mesh:
        try:
            import gmsh
        except (ImportError, OSError) as error:
            raise SystemExit(f"this case is meshed by gmsh: pip install gmsh ({error})") from None
        gmsh.initialize()
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.option.setNumber("Mesh.ElementOrder", 2)
        gmsh.option.setNumber("Mesh.MeshSizeExtendFromBoundary", 0)
        gmsh.option.setNumber("Mesh.HighOrderOptimize", 1)  # curved sides may invert elements
        occ, field = gmsh.model.occ, gmsh.model.mesh.field
        first, *others = [
            (3, getattr(occ, f"add{kind}")(*numbers)) for kind, *numbers in self.solids
        ]
        joined = occ.fuse([first], others)[0] if others else [first]
        holes = [(3, getattr(occ, f"add{kind}")(*numbers)) for kind, *numbers in self.holes]
        if holes:
            occ.cut(joined, holes)
        occ.synchronize()
        around = field.add("Ball")
        numbers = {"Radius": 0.006, "Thickness": 0.03, "VIn": 0.003, "VOut": self.size}
        for name, value in numbers.items():
            field.setNumber(
                around, name, value if name in ("Radius", "Thickness") else size * value
            )
        for name, value in zip("XYZ", self.place, strict=True):
            field.setNumber(around, f"{name}Center", value)
        field.setAsBackgroundMesh(around)
        gmsh.model.mesh.generate(3)
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder) / "part.msh"
            gmsh.write(str(file))
            gmsh.finalize()
            return ao.read_mesh(file)


# A bracket with a hole, clamped at its back; a plate with three ribs, clamped at one end; a tube,
# and a dome, clamped at their rims; a T-joint, clamped at its foot; a flange, free.
PARTS = {
    "bracket": Part(
        [("Box", 0, 0, 0, 0.1, 0.06, 0.008), ("Box", 0, 0, 0, 0.008, 0.06, 0.08)],
        [("Cylinder", 0.05, 0.03, 0, 0, 0, 0.008, 0.012)],
        size=0.005,
        place=(0.085, 0.02, 0.008),
        duration=5e-4,
        clamped=("x", 0.0),
    ),
    "ribs": Part(
        [
            ("Box", 0, 0, 0, 0.25, 0.2, 0.004),
            *(("Box", 0, y, -0.02, 0.25, 0.004, 0.02) for y in (0.04, 0.098, 0.156)),
        ],
        [],
        size=0.008,
        place=(0.12, 0.07, 0.004),
        duration=3e-4,
        clamped=("x", 0.0),
    ),
    "tube": Part(
        [("Cylinder", 0, 0, 0, 0.2, 0, 0, 0.05)],
        [("Cylinder", 0, 0, 0, 0.2, 0, 0, 0.045)],
        size=0.009,
        place=(0.12, 0.0, 0.05),
        duration=3e-4,
        clamped=("x", 0.0),
    ),
    "dome": Part(
        [("Sphere", 0, 0, 0, 0.06)],
        [("Sphere", 0, 0, 0, 0.056), ("Box", -0.1, -0.1, -0.1, 0.2, 0.2, 0.1)],
        size=0.004,
        place=(0.0, 0.0, 0.06),
        duration=3e-4,
        clamped=("z", 0.0),
    ),
    "tee": Part(
        [("Box", -0.1, 0, 0, 0.2, 0.03, 0.02), ("Box", -0.01, 0, -0.12, 0.02, 0.03, 0.12)],
        [],
        size=0.006,
        place=(0.08, 0.015, 0.02),
        duration=5e-4,
        clamped=("z", -0.12),
    ),
    "flange": Part(
        [("Cylinder", 0, 0, 0, 0, 0, 0.025, 0.08)],
        [
            ("Cylinder", 0, 0, 0, 0, 0, 0.025, 0.02),
            *(
                ("Cylinder", 0.06 * math.cos(t), 0.06 * math.sin(t), 0, 0, 0, 0.025, 0.006)
                for t in np.pi / 6 + np.arange(6) * np.pi / 3
            ),
        ],
        size=0.006,
        place=(0.05, 0.0, 0.025),
        duration=2e-4,
    ),
}

CASES: dict[str, Callable[[float], tuple[Any, ...]]] = {
    **{case.__name__: case for case in (disc, plate, beam, spheres)},
    **PARTS,
}


def timed(call: Callable[[], Any]) -> tuple[float, Any]:
    start = time.process_time()
    done = call()
    return time.process_time() - start, done


def fresh(case: str, size: float) -> tuple[Any, ...]:
    """Return newly made bodies of a case, with no cached results but their rigid motions."""
    *bodies, law, duration = CASES[case](size)
    for body in bodies:
        if isinstance(body, ao.ContactPoint):
            body.body.rigid_modes  # noqa: B018 - a property of the body, no part of its model
    return *bodies, law, duration


def building(case: str, size: float, solver: str, orders: list[int], contact_time: float) -> float:
    """Return the time, s, to build Krylov models of 2 n + 8 oscillators for n in `orders`."""
    seconds = 0.0
    for body, n in zip(fresh(case, size)[:2], orders, strict=True):
        if isinstance(body, ao.ContactPoint):
            space = KrylovSpace(body, contact_time=contact_time, solver=solver)
            seconds += timed(lambda space=space, n=n: space.of_vectors(2 * n + 8))[0]
    return seconds


def stress_at(tip: ao.ContactPoint) -> ao.StressAt:
    """Return the sensor of stress at the node whose distance is nearest to FROM_CONTACT."""
    nodes = tip.body.mesh.nodes
    away = np.linalg.norm(nodes - tip.point, axis=1)
    return ao.StressAt(tip.body, nodes[np.abs(away - FROM_CONTACT).argmin()])


def stress_history(hit: ao.Result, tip: ao.ContactPoint) -> np.ndarray:
    times = np.linspace(0.0, hit.t[-1], TIMES)
    return hit.target.probe(stress_at(tip).point, times=times).stress.von_mises


def difference(one: ao.Result, exact: ao.Result, quantity: str, tip: ao.ContactPoint) -> float:
    """Return the largest difference of a quantity between two results, as a relative error."""
    if quantity != "stress":
        return QUANTITIES[quantity].difference(exact, one)  # at the times of `one`
    right = stress_history(exact, tip)
    return float(np.abs(stress_history(one, tip) - right).max() / right.max())


def exact_run(case: str, size: float, hit: ao.Result) -> ao.Result:
    """Run the impact with models much larger than those of a result."""
    *bodies, law, duration = fresh(case, size)
    models = []
    for body, model in zip(bodies, hit.models, strict=True):
        if isinstance(body, ao.ContactPoint):
            space = KrylovSpace(body, contact_time=hit.contact_duration, sharpened=True)
            body = space.of_vectors(max(REFERENCE, TIMES_AS_MANY * model.n))
        models.append(body)
    return ao.simulate(
        projectile=models[0],
        target=models[1],
        law=law,
        velocity=1.0,
        duration=duration,
        solver=ao.Adaptive(rtol=1e-7),
    )


def simulated(case: str, size: float, quantity: str, rtol: float) -> tuple[float, ao.Result]:
    """Return the time of a whole call, s, and its result."""
    projectile, target, law, duration = fresh(case, size)

    def call() -> ao.Result:
        hit = ao.simulate(
            projectile=projectile,
            target=target,
            law=law,
            velocity=1.0,
            duration=duration,
            quantity=stress_at(target) if quantity == "stress" else quantity,
            rtol=rtol,
        )
        if quantity == "stress":
            stress_history(hit, target)
        return hit

    return timed(call)


def full_run(case: str, size: float, quantity: str, error: float, exact: ao.Result) -> float:
    """Return the time, s, of Newmark's rule on the full models with an error of at most `error`."""
    dt = exact.contact_duration / 25
    while True:
        *bodies, law, duration = fresh(case, size)
        models = [ao.full(tip) if isinstance(tip, ao.ContactPoint) else tip for tip in bodies]
        solver = ao.Newmark(dt=dt, estimate=False)
        strike = partial(ao.simulate, *models, 1.0, law=law, duration=duration, solver=solver)
        seconds, hit = timed(strike)
        if quantity == "stress":
            seconds += timed(partial(stress_history, hit, bodies[1]))[0]
        left = difference(hit, exact, quantity, bodies[1])
        if left <= error:
            return seconds
        dt *= min(0.8, 0.95 * math.sqrt(error / left))


def measure(
    case: str, size: float, quantity: str, tolerances: list[float], full: bool = False
) -> None:
    target, exact = fresh(case, size)[1], None
    for rtol in sorted(tolerances):  # the strictest first: its contact time is the most accurate
        seconds, hit = simulated(case, size, quantity, rtol)
        orders = [model.n for model in hit.models]
        taken = {model.linear_solver for model in hit.models} - {""}
        times = {
            name: building(case, size, name, orders, hit.contact_duration)
            for name in worth_timing(target, max(orders))
        }
        quickest = min(times, key=lambda name: times[name])
        exact = exact or exact_run(case, size, hit)
        error = difference(hit, exact, quantity, target)
        print(
            f"{case:8s} {target.body.n_dofs:7d} dofs  rtol {rtol:.0e}  n = {orders}  "
            f"{seconds:6.2f} s ({', '.join(taken)}) = {seconds / times[quickest]:4.2f} x building "
            f"2 n + 8 ({quickest})  error {error / rtol:.2g} rtol, "
            f"estimated {hit.error.model / rtol:.2g}",
            flush=True,
        )
        if full:
            by_steps = full_run(case, size, quantity, error, exact)
            print(f"{'':8s} the full model to that error: {by_steps:.2f} s", flush=True)


def worth_timing(tip: ao.ContactPoint, order: int) -> list[str]:
    body = tip.body
    pencil = Pencil(body.K, body.M, 0.0, body.nodes, body.free, body.mesh)
    methods = [method for method in METHODS.values() if method.is_installed()]
    seconds = {method.name: method.seconds(pencil, 2 * order + 8) for method in methods}
    return [name for name in seconds if seconds[name] <= SLOWER * min(seconds.values())]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("cases", nargs="*", default=list(CASES), help=", ".join(CASES))
    parser.add_argument("--size", type=float, default=1.0, help="of elements, relative")
    parser.add_argument("--rtol", type=float, nargs="+", default=[1e-1, 1e-2, 1e-3])
    parser.add_argument("--quantity", default="force")
    parser.add_argument("--full", action="store_true", help="compare with the full model")
    options = parser.parse_args()
    choice("--quantity", options.quantity, [*QUANTITIES, "stress"])
    with held_warnings():
        building("beam", 4.0, "superlu", [0, 4], 1e-4)  # imports modules that are used first here
        simulated("beam", 4.0, "force", 1e-1)
        for case in options.cases:
            measure(case, options.size, options.quantity, options.rtol, options.full)


if __name__ == "__main__":
    main()
