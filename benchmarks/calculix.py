"""Time from mesh to peak force, and its true error: default call, and CalculiX's penalty contact.

    python benchmarks/calculix.py            # needs ccx on the path, and gmsh

Two steel spheres of 10 mm radius at 1 m/s, with a true peak force of 1014.7 N (tests/resolved.py).
CalculiX runs half of the impact: one sphere against a rigid plane at half the speed, which gives
the same force. Times are processor times of all threads.
"""

from __future__ import annotations

import os
import resource
import shutil
import subprocess
import tempfile
import time
from pathlib import Path

import gmsh
import meshio
import numpy as np

import aoimpact as ao
from aoimpact.paper.sphere import RADIUS, STEEL

# `GRADED`: element sizes at the contact (radius 0.31 mm) and far from it, m. `EVEN`: uniform sizes,
# m.
GRADED = ((0.3e-3, 6e-3), (0.2e-3, 5e-3), (0.12e-3, 4e-3))
EVEN = (8e-3, 5e-3, 3e-3)

# Stiffness of the penalty, Pa/m: the contact pressure of 5 GPa causes a penetration of 50 nm, 1 %
# of the indentation of each sphere.
PENALTY = 1e17

STEP, STEPS = 1e-6, 62  # time step, s, and number of steps; the contact lasts 59 µs

# Corners of the faces that CalculiX numbers from 1 to 4.
FACES = ((0, 1, 2), (0, 3, 1), (1, 3, 2), (2, 3, 0))


def graded_sphere(fine: float, coarse: float, path: Path) -> meshio.Mesh:
    """Return a sphere of quadratic tetrahedra, which are small around (RADIUS, 0, 0)."""
    gmsh.initialize(interruptible=False)
    for name, value in (
        ("General.Terminal", 0),
        ("Mesh.MeshSizeExtendFromBoundary", 0),
        ("Mesh.MeshSizeFromPoints", 0),
        ("Mesh.ElementOrder", 2),
    ):
        gmsh.option.setNumber(name, value)
    gmsh.model.occ.addSphere(0, 0, 0, RADIUS)
    gmsh.model.occ.synchronize()
    field = gmsh.model.mesh.field
    away = f"Sqrt((x-{RADIUS})^2+y^2+z^2)"
    field.add("MathEval", 1)
    field.setString(1, "F", f"Min({coarse},{fine}+0.45*Max(0,{away}-{1.2 * 0.31e-3}))")
    field.setAsBackgroundMesh(1)
    gmsh.model.mesh.generate(3)
    gmsh.write(str(path))
    gmsh.finalize()
    return meshio.read(path)


STEPS_AND_MATERIAL = f"""
*MATERIAL, NAME=STEEL
*ELASTIC
{STEEL.E}, {STEEL.nu}
*DENSITY
{STEEL.rho}
*SOLID SECTION, ELSET=BALL, MATERIAL=STEEL
*SOLID SECTION, ELSET=WALL, MATERIAL=STEEL
*SURFACE INTERACTION, NAME=TOUCH
*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=LINEAR
{PENALTY:g}, 0.
*CONTACT PAIR, INTERACTION=TOUCH, TYPE=SURFACE TO SURFACE
SLAVE, MASTER
*BOUNDARY
FIXED, 1, 3
*INITIAL CONDITIONS, TYPE=VELOCITY
SPHERE, 1, 0.5
*STEP, NLGEOM, INC=10000
*DYNAMIC, DIRECT
{STEP:g}, {STEP * STEPS:g}
*NODE PRINT, NSET=FIXED, TOTALS=ONLY
RF
*END STEP
"""


def deck(mesh: meshio.Mesh) -> str:
    """Return the input deck of the sphere against a fixed brick, in m, kg, s."""
    cells = mesh.cells_dict["tetra10"]
    x = mesh.points
    n = len(x)
    near = np.linalg.norm(x - (RADIUS, 0, 0), axis=1) < 1.5e-3
    outside = np.abs(np.linalg.norm(x, axis=1) - RADIUS) < 1e-6 * RADIUS
    contact = [
        (e + 1, side + 1)
        for e, cell in enumerate(cells)
        for side, corners in enumerate(FACES)
        if (near & outside)[cell[list(corners)]].all()
    ]
    low, high, far = RADIUS, RADIUS + 2e-3, 3e-3
    brick = [
        (a, b, c)
        for a in (low, high)
        for b, c in ((-far, -far), (far, -far), (far, far), (-far, far))
    ]
    lines = ["*NODE, NSET=ALL"]
    lines += [f"{i + 1}, {a:.12e}, {b:.12e}, {c:.12e}" for i, (a, b, c) in enumerate([*x, *brick])]
    lines += ["*ELEMENT, TYPE=C3D10, ELSET=BALL"]
    lines += [f"{e + 1}, " + ", ".join(str(i + 1) for i in cell) for e, cell in enumerate(cells)]
    fixed = range(n + 1, n + 9)
    lines += ["*ELEMENT, TYPE=C3D8, ELSET=WALL", f"{len(cells) + 1}, " + ", ".join(map(str, fixed))]
    lines += [
        "*NSET, NSET=SPHERE, GENERATE",
        f"1, {n}",
        "*NSET, NSET=FIXED, GENERATE",
        f"{n + 1}, {n + 8}",
    ]
    lines += ["*SURFACE, NAME=SLAVE, TYPE=ELEMENT", *(f"{e}, S{side}" for e, side in contact)]
    lines += ["*SURFACE, NAME=MASTER, TYPE=ELEMENT", f"{len(cells) + 1}, S1"]
    return "\n".join(lines) + STEPS_AND_MATERIAL


def by_calculix(mesh: meshio.Mesh, folder: Path) -> tuple[float, float]:
    """Return the peak force, N, and the processor time, s, of CalculiX."""
    folder.joinpath("ball.inp").write_text(deck(mesh))
    two = os.environ | {"OMP_NUM_THREADS": "2"}
    began = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run(["ccx", "ball"], cwd=folder, check=True, capture_output=True, env=two)
    ended = resource.getrusage(resource.RUSAGE_CHILDREN)
    rows = [line.split() for line in folder.joinpath("ball.dat").read_text().splitlines()]
    force = max(abs(float(row[0])) for row in rows if len(row) == 3)
    return force, ended.ru_utime + ended.ru_stime - began.ru_utime - began.ru_stime


def by_default(name: str, mesh: Path | ao.Mesh) -> None:
    began = time.process_time()
    ball = ao.FEModel.from_mesh(mesh, STEEL)
    tip = ball.contact(point=(RADIUS, 0, 0))
    hit = ao.simulate(tip, tip, 1.0)
    total = hit.error["peak_force"].total
    row(name, ball.n_dofs, hit.peak_force, time.process_time() - began, total)


def row(name: str, dofs: int, force: float, seconds: float, estimate: float | None = None) -> None:
    off = 100.0 * (force / 1014.7 - 1.0)  # the true peak force, N
    said = "" if estimate is None else f"{100.0 * estimate:7.2f} %"
    print(
        f"{name:28s} {dofs:7d} {force:9.2f} N {off:+7.2f} % {said:10s} {seconds:8.2f} s", flush=True
    )


def main() -> None:
    print(f"{'':28s} {'dofs':>7} {'peak':>11} {'off':>9} {'estimate':>9} {'mesh to answer':>14}")
    for size in EVEN:
        by_default(f"even, {1e3 * size:g} mm", ao.sphere_mesh(RADIUS, size))
    for fine, coarse in GRADED:
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name)
            mesh = graded_sphere(fine, coarse, folder / "ball.msh")
            label = f"graded to {1e3 * fine:g} mm"
            by_default(label, folder / "ball.msh")
            if shutil.which("ccx"):
                row(f"{label}, CalculiX", 3 * len(mesh.points), *by_calculix(mesh, folder))


if __name__ == "__main__":
    main()
