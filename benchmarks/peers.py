"""Runs of SciPy's solvers, CVODE and Exudyn, each at tighter and tighter settings."""

from __future__ import annotations

import json
import math
import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from cases import Case, Run, best_time, error_of, tolerances
from scipy_solvers import Outcome

import aoimpact as ao

HERE = Path(__file__).parent


def scipy_runs(case: Case, exact: Outcome, method: str) -> Iterator[Run | None]:
    ode = case.ode
    for rtol in tolerances(1e-3, 1e-13):
        try:
            found = ode.run(method, rtol, 20.0)
        except ao.AOImpactError:
            return
        seconds = best_time(lambda r=rtol: ode.run(method, r), 5, 1.0)
        yield Run(f"{method} rtol={rtol:g}", seconds, error_of(case, exact, found))


class Peer:
    """Another program: it reads a scene and then settings, and prints a line for each setting."""

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
    """Return the program that runs CVODE, or None if there is no C compiler or no CVODE."""
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
    """Return pairs (number of steps, tolerance); the tolerance is 0 for fixed steps."""
    if name == "DOPRI5":
        return [(1000, rtol) for rtol in tolerances(1e-3, 1e-12)]
    most = 5e5 if case.scene["duration"] < 1e-3 else 2e5
    count = round(4 * math.log10(most / 500))
    return [(round(steps), 0.0) for steps in np.geomspace(500, most, count)]


def has_exudyn() -> bool:
    command = [sys.executable, "-c", "import exudyn"]
    return subprocess.run(command, capture_output=True, check=False).returncode == 0
