"""Adaptive against Newmark, SciPy, CVODE and Exudyn: time at the same true error, in one run.

    python benchmarks/adaptive.py [--scene rigid] [--scene pair] [--scene beam]

For each method the settings are tightened until the error of what is asked for stays under the
limit, and the fastest of those from which on it does is taken: no setting that is right by chance.
CVODE is driven by cvode_pair.c, built here where a C compiler and Debian's libsundials-dev are;
Exudyn by exudyn_pair.py where that package is installed. Takes two or three minutes.

"call" is what a user waits for: ao.simulate with the curves of its result. "core" is the run in C
alone, without the curves. CVODE and Exudyn are timed without Python and without curves.
"""

from __future__ import annotations

import argparse
import json
import math
import os
import subprocess
import sys
import tempfile
import time
import warnings
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np

import aoimpact as ao
from aoimpact import _core
from aoimpact.adaptive import adaptive_run
from aoimpact.newmark import newmark_run
from aoimpact.players import StarPlayer
from aoimpact.relative import relative
from aoimpact.scene import rigid_contact_time
from aoimpact.study_scenes import SCENES
from aoimpact.study_scipy import Outcome, ode_scene
from aoimpact.units import quantity

HERE = Path(__file__).parent


@dataclass(frozen=True)
class Run:
    """One setting of one method; `error` is the worst of what the scene asks for."""

    setting: str
    seconds: float
    error: float


@dataclass(frozen=True)
class Case:
    """A scene, what is asked of it, to what error, and how many times faster one aims to be."""

    title: str
    scene: dict[str, Any]
    asked: tuple[str, ...]
    limits: tuple[float, ...]
    aims: dict[tuple[str, float], float]

    @property
    def stars(self) -> tuple[ao.AOModel, ao.AOModel]:
        return self.scene["projectile"], self.scene["target"]

    @property
    def length(self) -> float:
        """Size of the displacements, m."""
        inverse = sum(1.0 / star.static_mass for star in self.stars)
        velocity = self.scene["velocity"]
        return velocity * rigid_contact_time(self.scene["law"], 1.0 / inverse, velocity)


def rigid_pair() -> dict[str, Any]:
    scene = SCENES["pair"]()
    ball = ao.rigid(mass=scene["projectile"].static_mass)
    return scene | {"projectile": ball, "target": ball}


CASES = {
    "rigid": Case(
        "Rigid Hertz pair, 200 µs",
        rigid_pair(),
        ("peak_force",),
        (1e-6, 1e-9),
        {("CVODE", 1e-9): 15, ("Newmark", 1e-9): 200},
    ),
    "pair": Case(
        "One-AO pair, 200 µs",
        SCENES["pair"](),
        ("peak_force",),
        (1e-6, 1e-9),
        {
            ("Newmark", 1e-6): 10,
            ("CVODE", 1e-6): 15,
            ("Exudyn", 1e-6): 15,
            ("SciPy", 1e-6): 150,
            ("Newmark", 1e-9): 150,
            ("CVODE", 1e-9): 30,
        },
    ),
    "beam": Case(
        "Rigid sphere on the 28-AO beam, 20 ms",
        SCENES["beam"](),
        ("peak_force", "rebound_velocity"),
        (1e-6,),
        {
            ("Newmark", 1e-6): 100,
            ("Exudyn", 1e-6): 250,
            ("CVODE", 1e-6): 1000,
            ("SciPy", 1e-6): 1000,
        },
    ),
}


# ------------------------------------------------------------------------------------- measuring


def best_time(call: Callable[[], object], most: int = 1000, enough: float = 0.2) -> float:
    """Return the shortest of as many calls as fit into `enough` s."""
    best, spent, done = math.inf, 0.0, 0
    while done == 0 or (done < most and spent < enough):
        start = time.perf_counter()
        call()
        taken = time.perf_counter() - start
        best, spent, done = min(best, taken), spent + taken, done + 1
    return best


def error_of(case: Case, exact: Outcome, found: Any) -> float:
    """Velocities relative to the initial one."""
    scale = {"peak_force": exact.peak_force, "rebound_velocity": case.scene["velocity"]}
    return max(abs(getattr(found, n) - getattr(exact, n)) / abs(scale[n]) for n in case.asked)


def tighten(runs: Iterable[Run | None], least: float) -> list[Run]:
    """Run until two settings in a row are below the least error."""
    done: list[Run] = []
    for run in runs:
        if run is not None:
            done.append(run)
        if len(done) >= 2 and max(done[-1].error, done[-2].error) <= least:
            break
    return done


def fastest(sweeps: list[list[Run]], limit: float) -> Run | None:
    """The fastest of those settings that are good and no tighter one of which is bad."""
    good = []
    for sweep in sweeps:
        for run in reversed(sweep):
            if not run.error <= limit:
                break
            good.append(run)
    return min(good, key=lambda run: run.seconds, default=None)


# ----------------------------------------------------------------------------------- own methods


def tolerances(first: float, last: float, per_decade: int = 1) -> list[float]:
    count = round(per_decade * math.log10(first / last)) + 1
    return [float(f"{value:.2g}") for value in np.geomspace(first, last, count)]


def adaptive_call(case: Case, exact: Outcome) -> Iterator[Run]:
    for rtol in tolerances(1e-2, 1e-12, 2):
        solver = ao.Adaptive(rtol=rtol)
        found = ao.simulate(**case.scene, solver=solver)
        seconds = best_time(lambda s=solver: ao.simulate(**case.scene, solver=s).peak_force)
        yield Run(f"rtol={rtol:g}", seconds, error_of(case, exact, found))


def adaptive_core(case: Case, exact: Outcome) -> Iterator[Run]:
    scene = case.scene
    modes = relative(*case.stars, 0.0)
    bodies, law, duration = modes.for_core(), scene["law"].for_core(), scene["duration"]
    x, v = modes.start(scene["velocity"])

    def start() -> tuple[np.ndarray, np.ndarray]:
        return x.copy(), v.copy()

    for rtol in tolerances(1e-2, 1e-12, 2):
        found = ao.simulate(**scene, solver=ao.Adaptive(rtol=rtol))
        seconds = best_time(lambda r=rtol: _core.adaptive(bodies, *law, r, duration, *start()))
        yield Run(f"rtol={rtol:g}", seconds - best_time(start), error_of(case, exact, found))


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
    scene = case.scene
    players = StarPlayer(case.stars[0], scene["velocity"]), StarPlayer(case.stars[1], 0.0)
    for dt in newmark_steps(case):
        rule = ao.Newmark(dt=dt, estimate=False)

        def run(dt: float = dt, rule: ao.Newmark = rule) -> None:
            newmark_run(
                *players,
                scene["law"],
                rule=rule,
                dt=dt,
                duration=scene["duration"],
                gap=0.0,
                energies=False,
            )

        error = error_of(case, exact, ao.simulate(**scene, solver=rule, energies=False))
        yield Run(f"dt={dt:.2g} s", best_time(run, 20), error)


# ---------------------------------------------------------------------------------------- others


def scipy_runs(case: Case, exact: Outcome, method: str) -> Iterator[Run | None]:
    scene = case.scene
    ode = ode_scene(
        case.stars,
        scene["law"],
        velocity=scene["velocity"],
        duration=scene["duration"],
        gap=0.0,
        length=case.length,
    )
    for rtol in tolerances(1e-3, 1e-13):
        try:
            found = ode.run(method, rtol, 20.0)
        except ao.AOImpactError:
            return
        seconds = best_time(lambda r=rtol: ode.run(method, r), 5, 1.0)
        yield Run(f"{method} rtol={rtol:g}", seconds, error_of(case, exact, found))


class Peer:
    """Another program that is given a scene and then runs, and answers each with a line."""

    def __init__(self, command: list[str], scene: str) -> None:
        pipe = subprocess.PIPE
        self.process = subprocess.Popen(
            command, stdin=pipe, stdout=pipe, stderr=subprocess.DEVNULL, text=True
        )
        self._say(scene)

    def _say(self, line: str) -> None:
        assert self.process.stdin is not None
        self.process.stdin.write(line + "\n")
        self.process.stdin.flush()

    def ask(self, line: str) -> str:
        assert self.process.stdout is not None
        self._say(line)
        for answer in self.process.stdout:
            if answer.startswith("result "):
                return answer.removeprefix("result ").strip()
        return "failed"

    def close(self) -> None:
        assert self.process.stdin is not None
        self.process.stdin.close()
        self.process.wait()


def build_cvode(folder: Path) -> Path | None:
    """Return the program, or None where there is no C compiler or no CVODE."""
    program = folder / "cvode_pair"
    libraries = ["-lsundials_cvode", "-lsundials_nvecserial", "-lm"]
    command = [os.environ.get("CC", "cc"), "-O3", str(HERE / "cvode_pair.c"), "-o", str(program)]
    try:
        done = subprocess.run([*command, *libraries], capture_output=True, check=False)
    except OSError:
        return None
    return program if done.returncode == 0 else None


def scene_text(case: Case) -> str:
    scene = case.scene
    head = (scene["velocity"], 0.0, scene["duration"], case.length, scene["law"].k, 1.5)
    lines = [" ".join(map(repr, map(float, head)))]
    for star in case.stars:
        pairs = np.column_stack([star.m, star.k]).ravel().tolist()
        lines.append(" ".join(map(repr, [star.n, star.m0, star.k0, *pairs])))
    return "\n".join(lines)


CVODE_METHODS = {
    "Adams, fixed point": "0 0",
    "Adams, Newton": "0 1",
    "BDF, Newton": "1 1",
}


def cvode_runs(case: Case, exact: Outcome, program: Path, name: str) -> Iterator[Run | None]:
    peer = Peer([str(program)], scene_text(case))
    try:
        for rtol in tolerances(1e-3, 1e-13, 2):
            answer = peer.ask(f"{CVODE_METHODS[name]} {rtol!r} 20 20.0")
            if answer == "failed":
                return
            seconds, *found = (float(value) for value in answer.split()[:4])
            yield Run(f"{name}, rtol={rtol:g}", seconds, error_of(case, exact, Outcome(*found)))
    finally:
        peer.close()


EXUDYN_METHODS = ("VelocityVerlet", "ExplicitMidpoint", "RK44", "RK67", "DOPRI5")


def exudyn_runs(case: Case, exact: Outcome, name: str) -> Iterator[Run | None]:
    scene = case.scene
    bodies = [
        {"m0": star.m0, "k0": star.k0, "m": star.m.tolist(), "k": star.k.tolist()}
        for star in case.stars
    ]
    given = {
        "velocity": scene["velocity"],
        "duration": scene["duration"],
        "length": case.length,
        "k": scene["law"].k,
        "exponent": 1.5,
        "bodies": bodies,
    }
    peer = Peer([sys.executable, str(HERE / "exudyn_pair.py")], json.dumps(given))
    try:
        for setting in exudyn_settings(case, name):
            answer = peer.ask(json.dumps([name, *setting]))
            if answer == "failed":
                return
            found = json.loads(answer)
            if "failure" in found:
                yield None
                continue
            outcome = Outcome(found["peak_force"], math.nan, found["rebound_velocity"])
            label = f"rtol={setting[1]:g}" if setting[1] else f"{setting[0]} steps"
            yield Run(f"{name}, {label}", found["seconds"], error_of(case, exact, outcome))
    finally:
        peer.close()


def exudyn_settings(case: Case, name: str) -> list[tuple[int, float]]:
    """DOPRI5 to a tolerance, the others with fixed steps."""
    if name == "DOPRI5":
        return [(1000, rtol) for rtol in tolerances(1e-3, 1e-12)]
    most = 5e5 if case.scene["duration"] < 1e-3 else 2e5
    count = round(4 * math.log10(most / 500))
    return [(round(steps), 0.0) for steps in np.geomspace(500, most, count)]


def has_exudyn() -> bool:
    command = [sys.executable, "-c", "import exudyn"]
    return subprocess.run(command, capture_output=True, check=False).returncode == 0


# ---------------------------------------------------------------------------------------- report


def truth(case: Case) -> tuple[Outcome, str]:
    """The closed form, or Adaptive at 1e-12 beside SciPy's DOP853 at its tightest."""
    scene = case.scene
    if all(star.n == 0 and star.k0 == 0.0 for star in case.stars):
        mass = 1.0 / sum(1.0 / star.m0 for star in case.stars)
        k = scene["law"].k
        deepest = (1.25 * mass * scene["velocity"] ** 2 / k) ** 0.4
        return Outcome(k * deepest**1.5, math.nan, math.nan), "exact: closed form"
    found = ao.simulate(**scene, solver=ao.Adaptive(rtol=1e-12))
    exact = Outcome(found.peak_force, found.contact_duration, found.rebound_velocity)
    ode = ode_scene(
        case.stars,
        scene["law"],
        velocity=scene["velocity"],
        duration=scene["duration"],
        gap=0.0,
        length=case.length,
    )
    distance = error_of(case, exact, ode.run("DOP853", 3e-14))
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
    time_taken = quantity(run.seconds, "s", 3)
    print(
        f"  {name:<15}{run.setting:<34}{time_taken:>9}  {run.error:7.1e}"
        f"{_times(ratios[0]):>9}{_times(ratios[1]):>9}  {words}".rstrip()
    )


def _times(ratio: float) -> str:
    return f"{float(f'{ratio:.3g}'):g}"


def print_fixed_cost() -> None:
    """What a call costs when nothing happens, and where that goes."""
    scene = rigid_pair() | {"duration": 1e-5, "gap": 1.0}
    whole = best_time(lambda: ao.simulate(**scene).t)
    modes = relative(scene["projectile"], scene["target"], 1.0)
    options = {"rtol": 1e-8, "velocity": 1.0, "duration": 1e-5}
    track = adaptive_run(modes, scene["law"], **options)
    times = track.times
    parts = {
        "modes": best_time(lambda: relative(scene["projectile"], scene["target"], 1.0)),
        "run": best_time(lambda: adaptive_run(modes, scene["law"], **options)),
        "times of the curves": best_time(lambda: track.times),
        f"{len(times)} samples": best_time(lambda: track.sample(times)),
    }
    words = ", ".join(f"{name} {quantity(seconds, 's', 2)}" for name, seconds in parts.items())
    verdict = "reached" if whole <= 30e-6 else "short"
    print("\nA call without contact (two rigid bodies, a gap too wide)")
    print(f"  {quantity(whole, 's', 3)}, of which {words}; aim: 30 µs, {verdict}")


def print_parts(case: Case) -> None:
    """Where the time of one call goes."""
    scene = case.scene
    for rtol in (1e-3, 1e-6, 1e-9):
        whole = best_time(lambda r=rtol: ao.simulate(**scene, solver=ao.Adaptive(rtol=r)))
        modes = relative(*case.stars, 0.0)
        options = {"rtol": rtol, "velocity": scene["velocity"], "duration": scene["duration"]}
        track = adaptive_run(modes, scene["law"], **options)
        times = track.times
        parts = {
            "modes": best_time(lambda: relative(*case.stars, 0.0)),
            "run": best_time(lambda m=modes, o=options: adaptive_run(m, scene["law"], **o)),
            f"{len(times)} samples": best_time(lambda t=track, s=times: t.sample(s)),
        }
        words = ", ".join(f"{name} {quantity(value, 's', 3)}" for name, value in parts.items())
        steps = f"{track.steps} steps and {track.rejected} in vain"
        print(f"  rtol={rtol:g}: call {quantity(whole, 's', 3)}, of which {words}; {steps}")


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
