"""Times of Adaptive, Newmark, SciPy, CVODE and Exudyn at the same true error, in one run.

    python benchmarks/adaptive.py [--scene rigid] [--scene pair] [--scene beam]

The settings of each method are made tighter and tighter. A setting counts only if the errors with
it and with all tighter settings are below the limit, so that none is right by chance. The fastest
is reported. CVODE is driven by cvode_pair.c, which is built here if there are a C compiler and
Debian's libsundials-dev; Exudyn by exudyn_pair.py if that package is installed. Takes two or three
minutes.

"call" is the time that a user waits for: ao.simulate with the curves of its result. "core" is the
run in C alone, without the curves. CVODE and Exudyn are timed without Python and without curves. A
curve of the beam at 400 even times, with energies, takes 0.9 of the time of its run at rtol 1e-6.
"""

from __future__ import annotations

import argparse
import os
import sys
import tempfile
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import Any

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import math

import numpy as np
from cases import CASES, Case, Run, best_time, error_of, fastest, rigid_pair, tighten, tolerances
from peers import (
    CVODE_METHODS,
    EXUDYN_METHODS,
    build_cvode,
    cvode_runs,
    exudyn_runs,
    has_exudyn,
    scipy_runs,
)
from scipy_solvers import Outcome

import aoimpact as ao
from aoimpact import _core
from aoimpact.base import with_unit
from aoimpact.integrate.dense import adaptive_run
from aoimpact.integrate.fixed_steps import newmark_run
from aoimpact.reduction import body_model
from aoimpact.scene import Contact, Scenario


def adaptive_call(case: Case, exact: Outcome) -> Iterator[Run]:
    for rtol in tolerances(1e-2, 1e-12, 2):
        solver = ao.Adaptive(rtol=rtol)
        found = ao.simulate(**case.scene, solver=solver)
        seconds = best_time(lambda s=solver: ao.simulate(**case.scene, solver=s).peak_force)
        yield Run(f"rtol={rtol:g}", seconds, error_of(case, exact, found))


def plan_of(scene: dict[str, Any]) -> Scenario:
    """Return the checked scenario that `simulate` makes from the arguments `scene`."""
    bodies = body_model("projectile", scene["projectile"]), body_model("target", scene["target"])
    contact = Contact(0, 0, 1, 0, scene["law"], scene.get("gap", 0.0))
    speeds = scene["velocity"], 0.0
    return Scenario(bodies, speeds, (contact,), (), 0.0, scene["duration"], True)


def core_arguments(plan: Scenario) -> tuple[Any, Any, Any, Any]:
    """Return bodies, contacts and the bodies' initial motion in the form that the core takes."""
    bodies = tuple(body.for_core() for body in plan.modal)
    (contact,) = plan.contacts
    moving = tuple(body.whole.moving for body in plan.modal)
    return bodies, ((0, 0, 1, 0, contact.gap, contact.law.for_core()),), moving, plan.velocities


def adaptive_core(case: Case, exact: Outcome) -> Iterator[Run]:
    scene = case.scene
    bodies, contacts, *start = core_arguments(plan_of(scene))
    for rtol in tolerances(1e-2, 1e-12, 2):
        found = ao.simulate(**scene, solver=ao.Adaptive(rtol=rtol))
        seconds = best_time(
            lambda r=rtol: _core.adaptive(
                bodies, contacts, r, scene["duration"], None, *start, sys.maxsize
            )
        )
        yield Run(f"rtol={rtol:g}", seconds, error_of(case, exact, found))


def newmark_steps(case: Case) -> list[float]:
    longest = case.length / case.scene["velocity"] / 100.0
    return tolerances(longest, max(1e-10, case.scene["duration"] / 2e6), 4)


def newmark_call(case: Case, exact: Outcome) -> Iterator[Run]:
    for dt in newmark_steps(case):
        solver = ao.Newmark(dt=dt, estimate=False)

        def run(solver: ao.Newmark = solver) -> ao.Result:
            result = ao.simulate(**case.scene, solver=solver, energies=False)
            _ = result.peak_force
            return result

        error = error_of(case, exact, run())
        yield Run(f"dt={dt:.2g} s", best_time(run, 20), error)


def newmark_core(case: Case, exact: Outcome) -> Iterator[Run]:
    scene, plan = case.scene, plan_of(case.scene)
    for dt in newmark_steps(case):
        rule = ao.Newmark(dt=dt, estimate=False)

        def run(dt: float = dt, rule: ao.Newmark = rule) -> None:
            newmark_run(plan, rule, dt)

        error = error_of(case, exact, ao.simulate(**scene, solver=rule, energies=False))
        yield Run(f"dt={dt:.2g} s", best_time(run, 20), error)


# ---------------------------------------------------------------------------------------- report


def truth(case: Case) -> tuple[Outcome, str]:
    """Return the reference and its source: a closed form, or Adaptive at rtol 1e-12."""
    scene = case.scene
    if all(star.n == 0 and star.k0 == 0.0 for star in case.stars):
        mass = 1.0 / sum(1.0 / star.m0 for star in case.stars)
        k = scene["law"].k
        deepest = (1.25 * mass * scene["velocity"] ** 2 / k) ** 0.4
        return Outcome(k * deepest**1.5, math.nan, math.nan), "exact: closed form"
    found = ao.simulate(**scene, solver=ao.Adaptive(rtol=1e-12))
    exact = Outcome(found.peak_force, found.contact_duration, found.rebound_velocity)
    distance = error_of(case, exact, case.ode.run("DOP853", 3e-14))
    return exact, f"reference: Adaptive(rtol=1e-12), {distance:.0e} from DOP853 at 3e-14"


def sweeps_of(case: Case, exact: Outcome, cvode: Path | None, exudyn: bool) -> dict[str, Any]:
    least = min(case.limits)
    made = {
        "Adaptive, call": [adaptive_call(case, exact)],
        "Adaptive, core": [adaptive_core(case, exact)],
        "Newmark, call": [newmark_call(case, exact)],
        "Newmark, core": [newmark_core(case, exact)],
        "SciPy": [scipy_runs(case, exact, name) for name in ("DOP853", "LSODA", "RK45")],
    }
    if cvode is not None:
        made["CVODE"] = [cvode_runs(case, exact, cvode, name) for name in CVODE_METHODS]
    if exudyn:
        made["Exudyn"] = [exudyn_runs(case, exact, name) for name in EXUDYN_METHODS]
    return {name: [tighten(runs, least) for runs in sweeps] for name, sweeps in made.items()}


def print_case(case: Case, cvode: Path | None, exudyn: bool) -> None:
    exact, source = truth(case)
    sweeps = sweeps_of(case, exact, cvode, exudyn)
    for limit in case.limits:
        best = {name: fastest(runs, limit) for name, runs in sweeps.items()}
        what = " and ".join(name.replace("_", " ") for name in case.asked)
        print(f"\n{case.title}: {what} within {limit:.0e} ({source})")
        print(f"  {'':<15}{'setting':<34}{'time':>9}  {'error':>7}{'/ call':>9}{'/ core':>9}  aim")
        for name, run in best.items():
            print_run(case, name, run, best, limit)


def print_run(
    case: Case, name: str, run: Run | None, best: dict[str, Run | None], limit: float
) -> None:
    if run is None:
        print(f"  {name:<15}no setting tried is as good")
        return
    call, core = best["Adaptive, call"], best["Adaptive, core"]
    assert call is not None
    assert core is not None
    ratios = run.seconds / call.seconds, run.seconds / core.seconds
    aim = case.aims.get((name.partition(",")[0], limit))
    words = ""
    if aim is not None:
        reached = ("reached" if ratio >= aim else "short" for ratio in ratios)
        words = f"{aim:g}: " + ", ".join(
            f"{which} {verdict}" for which, verdict in zip(("call", "core"), reached, strict=True)
        )
    time_taken = with_unit(run.seconds, "s", 3)
    print(
        f"  {name:<15}{run.setting:<34}{time_taken:>9}  {run.error:7.1e}"
        f"{ratio_text(ratios[0]):>9}{ratio_text(ratios[1]):>9}  {words}".rstrip()
    )


def ratio_text(ratio: float) -> str:
    return f"{float(f'{ratio:.3g}'):g}"


def print_fixed_cost() -> None:
    """Print the time of a call for two rigid bodies minus the time of its integration."""
    scene, solver = rigid_pair(), ao.Adaptive(rtol=1e-6)
    plan = plan_of(scene)
    whole = best_time(lambda: ao.simulate(**scene, solver=solver).peak_force)
    run = best_time(lambda: adaptive_run(plan, rtol=solver.rtol))
    print("\nA call for two rigid bodies, beside its run")
    print(f"  {with_unit(whole - run, 's', 3)} of {with_unit(whole, 's', 3)}; aim: 30 µs")


def print_parts(case: Case) -> None:
    """Print the times of a call, of its run and of sampling its curves, for three tolerances."""
    scene, plan = case.scene, plan_of(case.scene)
    for rtol in (1e-3, 1e-6, 1e-9):
        solver = ao.Adaptive(rtol=rtol)
        whole = best_time(lambda s=solver: ao.simulate(**scene, solver=s).peak_force)
        run = adaptive_run(plan, rtol=rtol)
        times, even = run.times, np.linspace(0.0, run.duration, 400)
        parts = {
            "run": best_time(lambda r=rtol: adaptive_run(plan, rtol=r)),
            f"if asked for, {len(times)} samples": best_time(
                lambda r=run, t=times: r.rows(t, True)
            ),
            f"{len(even)} even samples": best_time(lambda r=run, t=even: r.rows(t, True)),
        }
        words = ", ".join(f"{name} {with_unit(value, 's', 3)}" for name, value in parts.items())
        steps = f"{run.steps} steps and {run.rejected} in vain"
        print(f"  rtol={rtol:g}: call {with_unit(whole, 's', 3)}, of which {words}; {steps}")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--scene", action="append", choices=tuple(CASES), help="default: all")
    options = parser.parse_args()
    warnings.simplefilter("ignore", ao.AOImpactWarning)
    with tempfile.TemporaryDirectory() as folder:
        cvode, exudyn = build_cvode(Path(folder)), has_exudyn()
        if cvode is None:
            print("CVODE is not measured: it takes a C compiler and libsundials-dev")
        if not exudyn:
            print("Exudyn is not measured: pip install exudyn")
        for name in options.scene or CASES:
            print_case(CASES[name], cvode, exudyn)
            print("  Adaptive:")
            print_parts(CASES[name])
    print_fixed_cost()


if __name__ == "__main__":
    main()
