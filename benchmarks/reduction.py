"""What building scene-fitted anti-oscillators costs, as ratios to factorising and solving alone.

    python benchmarks/reduction.py [size of the sphere's elements in mm, 2.5]

The yardstick: one factorisation of K + s²M by the same solver, and n + 2 solutions with it.
Machines differ and are shared: the ratios are what to read.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Callable
from functools import partial

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np
from measuring import Line, best_times, print_table

import aoimpact as ao
from aoimpact.paper_sphere import RADIUS, STEEL

CONTACT_TIME = 70e-6


def yardstick(tip: ao.ContactPoint, solves: int) -> None:
    inverse = tip.body.inverse((10.0 / CONTACT_TIME) ** 2)
    load = tip.b
    for _ in range(solves):
        load = tip.body.M @ inverse.solve(load)
        load /= np.linalg.norm(load)


def main() -> None:
    size = 1e-3 * float(sys.argv[1]) if len(sys.argv) > 1 else 2.5e-3
    body = ao.FEModel.from_mesh(ao.sphere_mesh(RADIUS, size), STEEL)
    tip = body.contact(point=(RADIUS, 0, 0), direction=(1, 0, 0))
    body.rigid_modes  # noqa: B018 - they are the body's, not the model's
    krylov = partial(ao.antioscillators, tip, method="krylov", contact_time=CONTACT_TIME)
    lines = []
    for n in (1, 3, 8, 20):
        calls: list[Callable[[], object]] = [partial(krylov, n), partial(yardstick, tip, n + 2)]
        built, alone = best_times(*calls, enough=3.0)
        lines.append(Line(f"{n} AOs", built, f"a factorisation and {n + 2} solves", alone))
    print_table(f"Sphere, {body.n_dofs} dofs, {krylov(1).origin.solver}", lines)


if __name__ == "__main__":
    main()
