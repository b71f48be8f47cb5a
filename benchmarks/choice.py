"""What an impact to a tolerance costs, against building models of the order that it returns.

    python benchmarks/choice.py [--size 1.0] [--rtol 1e-1 1e-2 1e-3] [--quantity force]

The whole of `simulate(quantity=, rtol=)`, for bodies of some 10 000 dofs at --size 1 (half as large
elements at .5), against the quickest linear solver building Krylov models of 2 n + 8 oscillators,
where n are returned; and its true error over the tolerance, against models of 150. Times are the
processor's, with one thread, of the first call of each: nothing is kept from one to the other.
"""

from __future__ import annotations

import argparse
import math
import os
import time
from collections.abc import Callable
from typing import Any

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
os.environ.setdefault("MKL_NUM_THREADS", "1")

import numpy as np

import aoimpact as ao
from aoimpact.base.errors import held_warnings
from aoimpact.linalg.solvers import METHODS
from aoimpact.reduction import KrylovSpace
from aoimpact.results import QUANTITIES

STEEL = ao.Material(E=210e9, nu=0.3, rho=7800)
ALUMINIUM = ao.Material(E=70e9, nu=0.3, rho=2700)
BALL = ao.rigid(mass=4 / 3 * math.pi * 0.01**3 * STEEL.rho)
ON_ALUMINIUM = ao.Hertz.between(STEEL, 0.01, ALUMINIUM, math.inf)

# Oscillators of the models that true errors are relative to.
REFERENCE = 150


def disc(size: float) -> tuple[Any, ...]:
    """A ball on a lens, a flattened sphere of 100 mm times 20 mm, free."""
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
    """A ball on a plate of 300 x 200 x 6 mm held at its edges, off its centre."""
    edges = [(side, "xyz") for side in ("xmin", "xmax", "ymin", "ymax")]
    tip = box((0.3, 0.2, 0.006), (36, 24, 1), size, (0.12, 0.07, 0.006), edges)
    return BALL, tip, ON_ALUMINIUM, 3e-4


def beam(size: float) -> tuple[Any, ...]:
    """A ball on a beam of 500 x 20 x 20 mm held at its ends, at midspan."""
    ends = [(side, "xyz") for side in ("xmin", "xmax")]
    tip = box((0.5, 0.02, 0.02), (60, 3, 3), size, (0.25, 0.01, 0.02), ends)
    return BALL, tip, ON_ALUMINIUM, 1e-3


def spheres(size: float) -> tuple[Any, ...]:
    """Two steel spheres of radii 10 and 12 mm."""
    tips = []
    for radius in (0.01, 0.012):
        body = ao.FEModel.from_mesh(ao.sphere_mesh(radius, 0.17 * radius * size), STEEL)
        tips.append(body.contact(point=(radius, 0, 0), direction=(1, 0, 0), radius=0.003))
    return *tips, ao.Hertz.between(STEEL, 0.01, STEEL, 0.012), 1.5e-4


CASES: dict[str, Callable[[float], tuple[Any, ...]]] = {
    case.__name__: case for case in (disc, plate, beam, spheres)
}


def timed(call: Callable[[], Any]) -> tuple[float, Any]:
    start = time.process_time()
    done = call()
    return time.process_time() - start, done


def fresh(case: str, size: float) -> tuple[Any, ...]:
    """The case with nothing known of its bodies but their rigid motions."""
    *bodies, law, duration = CASES[case](size)
    for body in bodies:
        if isinstance(body, ao.ContactPoint):
            body.body.rigid_modes  # noqa: B018 - of the body, not of its model
    return *bodies, law, duration


def building(case: str, size: float, solver: str, orders: list[int], contact_time: float) -> float:
    """The time to build Krylov models of such orders with a linear solver, s."""
    seconds = 0.0
    for body, n in zip(fresh(case, size)[:2], orders, strict=True):
        if isinstance(body, ao.ContactPoint):
            space = KrylovSpace(body, contact_time=contact_time, solver=solver)
            seconds += timed(lambda space=space, n=n: space.of_vectors(2 * n + 8))[0]
    return seconds


def exact_model(tip: ao.ContactPoint, contact_time: float) -> ao.AOModel:
    solver = "pardiso" if METHODS["pardiso"].is_installed() else "superlu"
    space = KrylovSpace(tip, contact_time=contact_time, sharpened=True, solver=solver)
    return space.factored(REFERENCE)


def true_error(case: str, size: float, quantity: str, hit: ao.Result) -> float:
    *bodies, law, duration = fresh(case, size)
    models = [
        exact_model(body, hit.contact_duration) if isinstance(body, ao.ContactPoint) else body
        for body in bodies
    ]
    exact = ao.simulate(
        projectile=models[0],
        target=models[1],
        law=law,
        velocity=1.0,
        duration=duration,
        solver=ao.Adaptive(rtol=1e-7),
    )
    return QUANTITIES[quantity].difference(hit, exact)


def simulated(case: str, size: float, quantity: str, rtol: float) -> tuple[float, ao.Result]:
    """The time of a whole call, s, and what it returns."""
    projectile, target, law, duration = fresh(case, size)
    return timed(
        lambda: ao.simulate(
            projectile=projectile,
            target=target,
            law=law,
            velocity=1.0,
            duration=duration,
            quantity=quantity,
            rtol=rtol,
        )
    )


def measure(case: str, size: float, quantity: str, rtol: float) -> None:
    seconds, hit = simulated(case, size, quantity, rtol)
    target = fresh(case, size)[1]
    orders = [model.n for model in hit.models]
    taken = {model.origin.solver for model in hit.models if model.origin} - {""}
    times = {
        name: building(case, size, name, orders, hit.contact_duration)
        for name in ("superlu", "pardiso", "multigrid")
        if METHODS[name].is_installed() and not (name == "superlu" and too_many(target))
    }
    quickest = min(times, key=lambda name: times[name])
    error = true_error(case, size, quantity, hit)
    print(
        f"{case:8s} {target.body.n_dofs:7d} dofs  rtol {rtol:.0e}  n = {orders}  {seconds:6.2f} s "
        f"({', '.join(taken)}) = {seconds / times[quickest]:4.2f} x building 2 n + 8 ({quickest})  "
        f"error {error / rtol:.2g} rtol, estimated {hit.error.reduction / rtol:.2g}",
        flush=True,
    )


def too_many(tip: ao.ContactPoint) -> bool:
    """Whether a factorisation by SuperLU takes minutes."""
    return tip.body.n_dofs > 30_000


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("cases", nargs="*", default=list(CASES), help=", ".join(CASES))
    parser.add_argument("--size", type=float, default=1.0, help="of elements, relative")
    parser.add_argument("--rtol", type=float, nargs="+", default=[1e-1, 1e-2, 1e-3])
    parser.add_argument("--quantity", default="force")
    options = parser.parse_args()
    with held_warnings():
        building("beam", 4.0, "superlu", [0, 4], 1e-4)  # what is imported when it is first used
        simulated("beam", 4.0, "force", 1e-1)
        for case in options.cases:
            for rtol in options.rtol:
                measure(case, options.size, options.quantity, rtol)


if __name__ == "__main__":
    main()
