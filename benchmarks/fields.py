"""Time to compute fields of a struck plate, relative to the time to build its model.

    python benchmarks/fields.py [--across 36]

A plate of `across` elements across, 1.5 times as many along and two through its thickness
(hexahedra of 20 nodes; 36: 65 000 dofs), clamped at two edges, is struck by a steel ball. Motion
and stress at 100 times are computed for a point, another point, and all nodes of the lower face.
"""

from __future__ import annotations

import argparse
import os
import time
import warnings

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np
from measuring import Line, print_table

import aoimpact as ao

TIMES = 100


def struck(across: int) -> tuple[ao.Result, float]:
    """Return the impact, and the processor time of building its model, s."""
    alu = ao.Material(E=70e9, nu=0.33, rho=2700)
    steel = ao.Material(E=210e9, nu=0.3, rho=7800)
    mesh = ao.box_mesh((0.3, 0.2, 0.005), (3 * across // 2, across, 2), kind="hexahedron20")
    plate = ao.FEModel.from_mesh(mesh, alu, fixed=[("xmin", "xyz"), ("xmax", "xyz")])
    start = time.process_time()
    tip = plate.contact(point=(0.12, 0.08, 0.005))
    hit = ao.simulate(projectile=ao.ball(radius=0.01, material=steel), target=tip, velocity=1.0)
    return hit, time.process_time() - start


def seconds_of(hit: ao.Result, times: object, **place: object) -> float:
    """Return the processor time, s, to compute motion and stress at a place."""
    start = time.process_time()
    _ = hit.target.probe(**place, times=times).stress.von_mises
    return time.process_time() - start


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--across", type=int, default=36)
    options = parser.parse_args()
    warnings.simplefilter("ignore", ao.AOImpactWarning)
    hit, built = struck(options.across)
    times = np.linspace(0.0, hit.t[-1], TIMES)
    first = seconds_of(hit, times, point=(0.15, 0.1, 0.0))
    second = seconds_of(hit, times, point=(0.15, 0.12, 0.0))
    face = seconds_of(hit, times, nodes="zmin")
    dofs = hit.target._responding.body.n_dofs
    print_table(
        f"Motion and stress at {TIMES} times, {dofs} dofs",
        [
            Line("building the model", built),
            Line("a point (aim .2)", first, "building", built),
            Line("another point", second, "building", built),
            Line("a face", face, "building", built),
        ],
    )


if __name__ == "__main__":
    main()
