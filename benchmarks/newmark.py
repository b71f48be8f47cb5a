"""Newmark's rule in the C core: time of a step, relative to other times of the same run.

    python benchmarks/newmark.py

A step of an AO model is compared with a plain C loop (newmark_star.c, built here if there is a C
compiler) and with a copy of the record. A step of the full model of the paper's beam is compared
with its back-substitution and product with K, and with a plain loop on SciPy. Assembly is compared
with sorting, and two threads with one. Takes about half a minute. Only the ratios are meaningful:
machines differ and are shared.
"""

from __future__ import annotations

import ctypes
import os
import subprocess
import tempfile
import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np
import scipy.sparse.linalg as spla
from impacts import beam_star
from measuring import Line, best_times, print_table

import aoimpact as ao
from aoimpact import _core
from aoimpact.fem import stiffness_mass
from aoimpact.linalg import factorize
from aoimpact.paper.beam import ALUMINIUM, beam_model
from aoimpact.scene import stepped

MASS, HERTZ, VELOCITY = 0.0326725636, 1e10, 1.0
DT, STEPS = 2e-6, 10_000
ROWS = 4 + 2 * 8  # rows of the record of a contact and two bodies with a port each


def core_run(target: Any, steps: int, energies: bool) -> Callable[[], np.ndarray]:
    """Return a function that runs a rigid sphere against `target` in the C core alone."""
    bodies = stepped(ao.rigid(mass=MASS), VELOCITY), stepped(target)
    described = tuple(body.for_core(DT, 0.25, 0.5) for body in bodies)
    x, v = (np.concatenate(parts) for parts in zip(*((b.x, b.v) for b in bodies), strict=True))
    contacts = ((0, 0, 1, 0, 0.0, ao.Hertz(k=HERTZ).for_core()),)
    record = np.zeros((ROWS, steps + 1))

    def run() -> np.ndarray:
        start = x.copy(), v.copy(), None, None
        _core.newmark(described, contacts, DT, 0.25, 0.5, *start, record, energies)
        return record

    return run


# ---------------------------------------------------------------------------------------- star


def plain_c_run(star: ao.AOModel, folder: str) -> Callable[[], np.ndarray] | None:
    """Return a function that runs newmark_star.c, or None if there is no C compiler."""
    library = Path(folder, "newmark_star.so")
    source = Path(__file__).with_name("newmark_star.c")
    compiler = os.environ.get("CC", "cc")
    command = [compiler, "-std=c99", "-O3", "-shared", "-fPIC", source, "-o", library, "-lm"]
    try:
        subprocess.run(command, check=True)
    except (OSError, subprocess.CalledProcessError):
        return None
    function = ctypes.CDLL(str(library)).newmark_star
    work, record = np.zeros(4 * star.n), np.zeros((4, STEPS + 1))
    pointers = [ctypes.c_void_p(array.ctypes.data) for array in (star.m, star.k, work, record)]
    numbers = [ctypes.c_double(x) for x in (star.m0, star.k0, MASS, VELOCITY, HERTZ, DT)]
    m, k, work_at, record_at = pointers
    m0, k0, *rest = numbers

    def run() -> np.ndarray:
        steps = ctypes.c_size_t(STEPS)
        function(ctypes.c_size_t(star.n), m0, k0, m, k, *rest, steps, work_at, record_at)
        return record

    return run


def call_run(star: ao.AOModel) -> Callable[[], ao.Result]:
    """Return a function that runs the impact by `simulate`, without its error estimate."""
    solver = ao.Newmark(dt=DT, estimate=False)
    scene = {"projectile": ao.rigid(mass=MASS), "target": star, "law": ao.Hertz(k=HERTZ)}
    scene |= {"velocity": VELOCITY, "duration": STEPS * DT, "solver": solver}
    return lambda: ao.simulate(**scene, energies=False)


def measure_star(folder: str) -> list[Line]:
    star = beam_star(28)
    lean, rich = (core_run(star, STEPS, energies) for energies in (False, True))
    few, many = (core_run(beam_star(n), STEPS, False) for n in (8, 48))
    plain = plain_c_run(star, folder)
    record = rich()
    other = np.empty_like(record)
    runs = [lean, rich, few, many, call_run(star), lambda: np.copyto(other, record)]
    lean_time, rich_time, few_time, many_time, call, copy, *rest = best_times(
        *runs, *([plain] if plain else []), enough=3.0
    )
    lines = [
        Line("core, 10 rows of record", lean_time, "a copy of the record", copy),
        Line("core, 20 rows with energies", rich_time, "without them", lean_time),
        Line("ao.simulate, without energies", call, "the core", lean_time),
        Line("a step", lean_time / STEPS),
        Line("a step, for each further oscillator", (many_time - few_time) / 40 / STEPS),
    ]
    if plain is not None:
        difference = np.abs(plain()[0] - record[0]).max() / record[0].max()
        assert difference < 1e-9, f"the two forces differ by {difference:g} of the peak"
        lines.insert(1, Line("core, 10 rows of record", lean_time, "a plain C loop", rest[0]))
    return lines


# ---------------------------------------------------------------------------------------- full


def scipy_loop(model: ao.FEModel, b: np.ndarray, steps: int) -> float:
    """Run Newmark's rule in a plain loop on SciPy's factors; return the peak force, N."""
    K, M, dof = model.K, model.M, int(np.argmax(np.abs(b)))
    sign, reach = b[dof], 0.25 * DT**2
    solve = spla.splu((M + reach * K).tocsc()).solve
    unit = solve(b)
    compliance = reach * (sign * unit[dof] + 1.0 / MASS)
    u, v, a = (np.zeros(len(b)) for _ in range(3))
    x, speed, pull, peak = 0.0, VELOCITY, 0.0, 0.0
    for _ in range(steps):
        u += DT * v + reach * a
        v += 0.5 * DT * a
        x += DT * speed - reach * pull / MASS
        speed -= 0.5 * DT * pull / MASS
        a = solve(-(K @ u))
        free = x - sign * (u[dof] + reach * a[dof])
        pull = contact_force(free, compliance)
        a += pull * unit
        u += reach * a
        v += 0.5 * DT * a
        x -= reach * pull / MASS
        speed -= 0.5 * DT * pull / MASS
        peak = max(peak, pull)
    return peak


def contact_force(free: float, compliance: float) -> float:
    """Return F = k (free - compliance F)^1.5, N, by Newton's method for the indentation."""
    if free <= 0.0:
        return 0.0
    depth = free
    for _ in range(50):
        root = depth**0.5
        change = (depth - free + compliance * HERTZ * root * depth) / (
            1.0 + 1.5 * compliance * HERTZ * root
        )
        depth -= change
        if abs(change) < 1e-15 * depth:
            break
    return HERTZ * depth**1.5


def measure_full() -> list[Line]:
    model = beam_model()
    tip = model.contact(point=(0.5, 0.01, 0.02), direction=(0.0, 0.0, -1.0), radius=0)
    steps = 200
    lean, rich = (core_run(ao.full(tip), steps, energies) for energies in (False, True))
    factors = factorize(model.M + 0.25 * DT**2 * model.K).for_core()
    work, x = np.empty(model.n_dofs), np.ones(model.n_dofs)
    u = np.random.default_rng(0).standard_normal(model.n_dofs)

    def parts() -> None:
        for _ in range(steps):
            x[:] = u  # reset: repeated solves would make x underflow
            _core.factors_solve(factors, work, x)
            model.K @ u

    solve = spla.splu((model.M + 0.25 * DT**2 * model.K).tocsc()).solve

    def scipy_parts() -> None:
        for _ in range(steps):
            solve(u)
            model.K @ u

    peak = scipy_loop(model, tip.b, steps)
    assert abs(peak / lean()[0].max() - 1.0) < 1e-8, "the two peak forces differ"
    calls = lean, rich, parts, scipy_parts, lambda: scipy_loop(model, tip.b, steps)
    times = [taken / steps for taken in best_times(*calls, enough=6.0)]
    step, rich_step, parts_time, superlu, loop = times
    return [
        Line("a step", step, "its back-substitution (and check) and K u", parts_time),
        Line("a step", step, "SuperLU's back-substitution and K u", superlu),
        Line("a step", step, "a step of the SciPy loop", loop),
        Line("a step with energies", rich_step, "without them", step),
    ]


# ------------------------------------------------------------------------- assembly and threads


def measure_assembly() -> list[Line]:
    lines = []
    for divisions in ((50, 2, 2), (100, 16, 16)):
        mesh = ao.box_mesh((1.0, 0.02, 0.02), divisions)
        entries = mesh.cells.shape[0] * (3 * mesh.cells.shape[1]) ** 2
        keys = np.random.default_rng(0).integers(0, 2**40, entries)
        taken, sort = best_times(
            lambda mesh=mesh: stiffness_mass(mesh, ALUMINIUM),
            lambda keys=keys: np.sort(keys),
            enough=2.0,
        )
        what = f"K and M, {3 * len(mesh.nodes)} dofs, hex8, {entries} entries"
        lines.append(Line(what, taken, "a sort of as many numbers", sort))
    return lines


def measure_threads() -> list[Line]:
    star = beam_star(28)
    runs = [core_run(star, 20 * STEPS, False) for _ in range(2)]

    def one_after_the_other() -> None:
        for run in runs:
            run()

    def both_at_once() -> None:
        threads = [threading.Thread(target=run) for run in runs]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()

    alone, together = best_times(one_after_the_other, both_at_once, enough=3.0)
    return [Line("two runs at once", together, "one after the other", alone)]


def main() -> None:
    with tempfile.TemporaryDirectory() as folder:
        print_table(f"Star: rigid sphere on 28 AOs, {STEPS} steps", measure_star(folder))
    print_table("Full model: the paper's beam, 1362 dofs", measure_full())
    print_table("Assembly", measure_assembly())
    print_table(f"Threads ({os.cpu_count()} cores)", measure_threads())


if __name__ == "__main__":
    main()
