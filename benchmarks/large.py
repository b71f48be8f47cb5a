"""The default call on bodies of 700 000 dofs and more: seconds and memory, from mesh to answer.

    python benchmarks/large.py [plate block ...] [--share 1.0]

A ball of steel at 1 m/s on a clamped plate, a compact block and a free ball; the peak force
to 1 %, by the solver that `simulate` takes. Each is a process of its own, so that its memory is its
own. --share .1 takes about a tenth of the dofs.
"""

from __future__ import annotations

import argparse
import json
import resource
import subprocess
import sys
import time

import aoimpact as ao

STEEL = ao.Material(E=210e9, nu=0.3, rho=7800)
ALUMINIUM = ao.Material(E=70e9, nu=0.33, rho=2700)


def plate(share: float) -> tuple[ao.FEModel, ao.ContactPoint, float]:
    """400 mm x 300 mm x 10 mm, clamped all around, struck off its centre."""
    along, across = (round(n * share**0.5) for n in (130, 98))
    mesh = ao.box_mesh((0.4, 0.3, 0.01), (along, across, 4), kind="hexahedron20")
    edges = [(side, "xyz") for side in ("xmin", "xmax", "ymin", "ymax")]
    body = ao.FEModel.from_mesh(mesh, ALUMINIUM, fixed=edges)
    return body, body.contact(point=(0.18, 0.14, 0.01)), 0.015


def block(share: float) -> tuple[ao.FEModel, ao.ContactPoint, float]:
    """A cube of 100 mm on a rigid floor, struck on its top."""
    count = round(43 * share ** (1 / 3))
    mesh = ao.box_mesh((0.1, 0.1, 0.1), (count,) * 3, kind="hexahedron20")
    body = ao.FEModel.from_mesh(mesh, ALUMINIUM, fixed=[("zmin", "xyz")])
    return body, body.contact(point=(0.05, 0.05, 0.1)), 0.01


def sphere(share: float) -> tuple[ao.FEModel, ao.ContactPoint, float]:
    """A free ball of 20 mm."""
    body = ao.FEModel.from_mesh(ao.sphere_mesh(0.01, 0.57e-3 * share ** (-1 / 3)), STEEL)
    return body, body.contact(point=(0.01, 0.0, 0.0)), 0.005


BODIES = {made.__name__: made for made in (plate, block, sphere)}


def measure(name: str, share: float) -> str:
    start = time.perf_counter()
    body, tip, radius = BODIES[name](share)
    made = time.perf_counter() - start
    hit = ao.simulate(
        projectile=ao.ball(radius, STEEL),
        target=tip,
        velocity=1.0,
        quantity="peak_force",
        rtol=1e-2,
    )
    seconds = time.perf_counter() - start
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20
    return (
        f"{name:8}{body.n_dofs:9} dofs  body {made:5.1f} s  all {seconds:5.1f} s"
        f"  {memory:4.1f} GiB  {hit.peak_force:.5g} N by {hit.target.label.split(',')[0]}"
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("bodies", nargs="*", default=list(BODIES), help=", ".join(BODIES))
    parser.add_argument("--share", type=float, default=1.0, help="of the dofs (default 1)")
    parser.add_argument("--one", help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.one:
        print(measure(*json.loads(options.one)))
        return
    for name in options.bodies:
        one = json.dumps([name, options.share])
        subprocess.run([sys.executable, __file__, "--one", one], check=True)


if __name__ == "__main__":
    main()
