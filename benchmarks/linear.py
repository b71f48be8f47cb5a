"""Linear solvers on spheres and long held bars of 2e4 … 1e6 dofs: set-up, one solution, memory.

    python benchmarks/linear.py [--most 2e5] [--solvers multigrid superlu pardiso] [--pipeline]
    python benchmarks/linear.py --direct
    python benchmarks/linear.py --sheet

Each line is from a process of its own, so that the memory is that of its solver. A million dofs
(--most 1.2e6) take some 5 GiB and, with --pipeline (mesh to 8 anti-oscillators), a minute or two.
--direct compares time and entries of factors with their estimates, on balls, blocks, plates, sheets
and bars; --sheet times the natural frequencies and a model of a steel sheet of 300 x 300 x 1 mm.
"""

from __future__ import annotations

import argparse
import json
import resource
import subprocess
import sys
import time
from collections.abc import Callable

import numpy as np

import aoimpact as ao
from aoimpact.linalg import METHODS, Pencil, factorize, pardiso
from aoimpact.linalg.multigrid import Multigrid

STEEL = ao.Material(E=210e9, nu=0.3, rho=7800)

# `SHIFT`: s² for models of few oscillators and a contact time of some 70 µs, (rad/s)². `TOLERANCE`:
# relative residual of solutions.
SHIFT = 1.5e5**2
TOLERANCE = 1e-8

# Meshes by number of dofs. `SPHERES`: edge of elements on a sphere of 10 mm, m. `BARS`: numbers of
# elements along and across a bar of 1 m x 50 mm.
SPHERES = {2e4: 3e-3, 4.5e4: 2e-3, 2.3e5: 1e-3, 1.14e6: 0.55e-3}
BARS = {2.2e4: (60, 3), 4e4: (80, 4), 2.8e5: (160, 8), 1.14e6: (260, 13)}

# Dofs above which a direct solver needs minutes.
DIRECT_MOST = {"superlu": 4.1e4, "pardiso": 1e5}


def body_of(shape: str, dofs: float) -> tuple[ao.FEModel, ao.ContactPoint]:
    if shape == "sphere":
        body = ao.FEModel.from_mesh(ao.sphere_mesh(0.01, SPHERES[dofs]), STEEL)
        return body, body.contact(point=(0.01, 0, 0), direction=(1, 0, 0), radius=0)
    along, across = BARS[dofs]
    mesh = ao.box_mesh((1.0, 0.05, 0.05), (along, across, across), kind="tetra10")
    body = ao.FEModel.from_mesh(mesh, STEEL, fixed=[("xmin", "xyz")])
    return body, body.contact(point=(1.0, 0.0, 0.05), direction=(0, 0, -1), radius=0)


def timed(call: Callable[[], object]) -> tuple[object, float, float]:
    """Return the result, wall time, s, and processor time, s, which agree on an idle machine."""
    start, cpu = time.perf_counter(), time.process_time()
    result = call()
    return result, time.perf_counter() - start, time.process_time() - cpu


def measure(shape: str, dofs: float, solver: str, pipeline: bool) -> dict[str, object]:
    (body, tip), assembly, assembly_cpu = timed(lambda: body_of(shape, dofs))
    found: dict[str, object] = {"dofs": body.n_dofs, "assembly": assembly}
    if pipeline:
        _, *found["model"] = timed(
            lambda: ao.antioscillators(tip, 8, method="krylov", contact_time=7e-5, solver=solver)
        )
        found["model"] += [assembly + found["model"][0], assembly_cpu + found["model"][1]]
    elif solver == "multigrid":
        pencil = Pencil(body.K, body.M, SHIFT, body.nodes, body.free, body.mesh)
        multigrid, *found["setup"] = timed(lambda: Multigrid(pencil))
        (x, found["iterations"]), *found["solve"] = timed(
            lambda: multigrid.iterate(tip.b, TOLERANCE, np.inf)
        )
        found["residual"] = float(np.linalg.norm(tip.b - pencil.matrix() @ x))
    else:
        inverse, *found["setup"] = timed(lambda: body.inverse(SHIFT, solver=solver))
        _, *found["solve"] = timed(lambda: inverse.solve(tip.b))
    found["memory"] = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20
    return found


BODIES = {
    "ball": lambda: ao.sphere_mesh(0.01, 2.5e-3),
    "block": lambda: ao.box_mesh((0.1, 0.1, 0.1), (12, 12, 12), kind="hexahedron20"),
    "block, linear": lambda: ao.box_mesh((0.1, 0.1, 0.1), (20, 20, 20), kind="hexahedron"),
    "plate": lambda: ao.box_mesh((0.3, 0.3, 0.05), (24, 24, 4), kind="hexahedron20"),
    "plate, tetra10": lambda: ao.box_mesh((0.3, 0.3, 0.01), (30, 30, 1), kind="tetra10"),
    "sheet": lambda: ao.box_mesh((0.3, 0.3, 1e-3), (60, 60, 1), kind="hexahedron20"),
    "bar": lambda: ao.box_mesh((1.0, 0.05, 0.05), (200, 4, 4), kind="hexahedron20"),
}


def direct() -> None:
    """Print entries and times of factors with their estimates, and times with minimum degree."""
    methods = [METHODS[name] for name in ("superlu", "pardiso") if METHODS[name].is_installed()]
    print(f"{'':16}{'dofs':>8}  entries/foretold  seconds of the processor (foretold)")
    for name, mesh in BODIES.items():
        pencil = ao.FEModel.from_mesh(mesh(), STEEL)._pencil.at(SHIFT)
        order, _, ordering = timed(lambda pencil=pencil: pencil.order)
        A = pencil.matrix()
        factors = factorize(A, order=order)
        line = f"{name:16}{pencil.n:8}{factors._lu.L.nnz / pencil.fill.entries:10.2f}"
        line += f"{'':8}dissection {ordering:.2f}"
        for method in methods:
            _, _, seconds = timed(lambda set_up=method.set_up, pencil=pencil: set_up(pencil))
            line += f"  {method.name} {seconds:.2f} ({method.seconds(pencil, 0):.2f})"
        _, _, by_degree = timed(lambda A=A: factorize(A))
        print(f"{line}  superlu by minimum degree {by_degree:.2f}", flush=True)


def sheet() -> None:
    """Time a clamped sheet of one layer of flat elements, on which iterations may take minutes."""
    mesh = BODIES["sheet"]()
    for what, call in (
        ("frequencies(3)", lambda body: body.frequencies(3)),
        (
            "8 anti-oscillators",
            lambda body: ao.antioscillators(
                body.contact(point=(0.15, 0.15, 1e-3), radius=0), 8, method="krylov"
            ),
        ),
    ):
        body = ao.FEModel.from_mesh(mesh, STEEL, fixed=[("xmin", "xyz")])
        _, wall, cpu = timed(lambda call=call, body=body: call(body))
        print(f"sheet, {body.n_dofs} dofs: {what:20}{wall:8.2f} s ({cpu:.2f} of the processor)")


def in_a_process(*arguments: object) -> dict[str, object]:
    command = [sys.executable, __file__, "--one", json.dumps(arguments)]
    done = subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True)
    result: dict[str, object] = json.loads(done.stdout)
    return result


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--most", type=float, default=3e5, help="dofs (default 3e5)")
    parser.add_argument("--solvers", nargs="+", default=["multigrid", "superlu", "pardiso"])
    parser.add_argument("--pipeline", action="store_true", help="mesh to 8 anti-oscillators")
    parser.add_argument("--direct", action="store_true", help="factors against their estimates")
    parser.add_argument("--sheet", action="store_true", help="a sheet of 300 x 300 x 1 mm")
    parser.add_argument("--one", help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.direct or options.sheet:
        (direct if options.direct else sheet)()
        return
    if options.one:
        print(json.dumps(measure(*json.loads(options.one))))
        return
    columns = (
        "dofs → 8 AOs" if options.pipeline else "assembly    set-up          solve           its"
    )
    print(f"seconds by the clock (of the processor)\n{'':28}{columns}  GiB")
    for solver in options.solvers:
        if solver == "pardiso" and not pardiso.is_installed():
            continue
        for shape, sizes in (("sphere", SPHERES), ("held bar", BARS)):
            for dofs in sizes:
                if dofs > min(options.most, DIRECT_MOST.get(solver, np.inf)):
                    continue
                one = in_a_process(shape, dofs, solver, options.pipeline)
                line = f"{solver:10}{shape:9}{one['dofs']:9}"
                if options.pipeline:
                    wall, cpu, total, total_cpu = one["model"]
                    line += f"  matrices to AOs {wall:7.2f} ({cpu:.2f})"
                    line += f"  with assembly {total:7.2f} ({total_cpu:.2f})"
                else:
                    line += f"{one['assembly']:9.2f}"
                    line += "".join(
                        f"{one[k][0]:8.2f} ({one[k][1]:.2f})" for k in ("setup", "solve")
                    )
                    line += f"{one.get('iterations', ''):>5}"
                print(f"{line}{one['memory']:8.2f}", flush=True)


if __name__ == "__main__":
    main()
