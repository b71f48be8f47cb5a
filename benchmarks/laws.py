"""Time of the solvers with each contact law, relative to Hertz's law in the same scene.

    python benchmarks/laws.py

Two bodies of one anti-oscillator each are in contact for the whole record. Newmark's rule has the
same steps with all laws; Adaptive is timed with the laws that it takes. A law as a C function,
compiled here if there is a compiler, is compared with the built-in law of the same form. Takes half
a minute.
"""

from __future__ import annotations

import ctypes
import os
import subprocess
import tempfile
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np
from measuring import Line, best_times, print_table
from scipy import LowLevelCallable

import aoimpact as ao

K, MASS, VELOCITY = 1e10, 0.016, 1.0
BALL = ao.AOModel(m0=0.1 * MASS, k0=0.0, m=[0.9 * MASS], k=[2e9])
SCENE: dict[str, Any] = {
    "projectile": BALL,
    "target": BALL,
    "velocity": VELOCITY,
    "duration": 45e-6,
    "energies": False,
}
STEPS = 40_000
NEWMARK = ao.Newmark(dt=45e-6 / STEPS, estimate=False)

SOURCE = """
#include <math.h>
double force(double d, double v) { return 1e10 * d * sqrt(d) + 0.0 * v; }
double stiffness(double d, double v) { return 1.5e10 * sqrt(d) + 0.0 * v; }
double damped(double d, double v) { return 1e10 * d * sqrt(d) * (1.0 + 0.2 * v); }
double damped_stiffness(double d, double v) { return 1.5e10 * sqrt(d) * (1.0 + 0.2 * v); }
double damped_damping(double d, double v) { return 0.2e10 * d * sqrt(d) + 0.0 * v; }
"""


def library() -> dict[str, ao.ContactLaw]:
    """Return one of every law, about as stiff as Hertz's at the depth of the impact."""
    depth = np.linspace(0.0, 1.0, 50) ** 1.5 * 1e-4
    return {
        "PowerLaw n=1.5": ao.PowerLaw(K, 1.5),
        "PowerLaw n=1.7": ao.PowerLaw(7e10, 1.7),
        "Linear": ao.Linear(3e7),
        "HuntCrossley": ao.HuntCrossley(K, 0.2),
        "HuntCrossley n=1.7": ao.HuntCrossley(7e10, 0.2, 1.7),
        "Tsuji": ao.Tsuji.from_restitution(K, 0.8, MASS / 2),
        "KuwabaraKono": ao.KuwabaraKono.from_restitution(K, 0.8, VELOCITY, MASS / 2),
        "KelvinVoigt": ao.KelvinVoigt.from_restitution(3e7, 0.8, MASS / 2),
        "Thornton": ao.Thornton(K, 100.0),
        "Tabulated, 50 points": ao.Tabulated(depth, K * depth**1.5),
        "Hertz within a patch": ao.Hertz(K).within_patch(3e-10),
    }


def c_functions(folder: str) -> dict[str, Any] | None:
    """Return the functions of SOURCE, or None where there is no C compiler."""
    source, built = Path(folder, "law.c"), Path(folder, "law.so")
    source.write_text(SOURCE)
    command = [os.environ.get("CC", "cc"), "-O3", "-shared", "-fPIC", source, "-o", built, "-lm"]
    try:
        subprocess.run(command, check=True)
    except (OSError, subprocess.CalledProcessError):
        return None
    loaded = ctypes.CDLL(str(built))
    functions = {}
    for name in ("force", "stiffness", "damped", "damped_stiffness", "damped_damping"):
        function = getattr(loaded, name)
        function.argtypes, function.restype = [ctypes.c_double] * 2, ctypes.c_double
        functions[name] = LowLevelCallable(function)
    return functions


def run(law: ao.ContactLaw, solver: Any) -> Callable[[], object]:
    return lambda: ao.simulate(law=law, solver=solver, **SCENE)


def compare(title: str, laws: dict[str, ao.ContactLaw], yardstick: str, solver: Any) -> None:
    """Print the time with each law, and its ratio to the time with the law `yardstick`."""
    calls = [run(law, solver) for law in laws.values()]
    times = dict(zip(laws, best_times(*calls, enough=5.0), strict=True))
    lines = [Line(yardstick, times[yardstick])]
    lines += [
        Line(name, time, yardstick, times[yardstick])
        for name, time in times.items()
        if name != yardstick
    ]
    print_table(title, lines)


def main() -> None:
    warnings.simplefilter("ignore", ao.AOImpactWarning)  # records end in contact on purpose
    hertz = ao.Hertz(K)
    everything = {"Hertz": hertz} | library()
    compare(f"Newmark, {STEPS} steps in contact", everything, "Hertz", NEWMARK)
    solver = ao.Adaptive(rtol=1e-8)
    taken = {}
    for name, law in everything.items():
        try:
            run(law, solver)()
        except ao.InputError:
            continue
        taken[name] = law
    compare("Adaptive, rtol 1e-8", taken, "Hertz", solver)

    with tempfile.TemporaryDirectory() as folder:
        functions = c_functions(folder)
        if functions is None:
            print("no C compiler: laws as C functions are left out")
            return
        f = functions
        elastic: dict[str, ao.ContactLaw] = {
            "Hertz": hertz,
            "C, with its derivative": ao.UserLaw(
                f["force"], stiffness=f["stiffness"], depends_on_rate=False
            ),
            "C, by differences": ao.UserLaw(f["force"], depends_on_rate=False),
        }
        damped: dict[str, ao.ContactLaw] = {
            "HuntCrossley": ao.HuntCrossley(K, 0.2),
            "C, with its derivatives": ao.UserLaw(
                f["damped"], stiffness=f["damped_stiffness"], damping=f["damped_damping"]
            ),
            "C, by differences": ao.UserLaw(f["damped"]),
        }
        compare("Laws as C functions, Newmark", elastic, "Hertz", NEWMARK)
        compare("Damped laws as C functions, Newmark", damped, "HuntCrossley", NEWMARK)
        python = {"Hertz": hertz, "Python": ao.UserLaw(lambda d, v: K * d**1.5)}
        compare("A law in Python, Newmark", python, "Hertz", NEWMARK)


if __name__ == "__main__":
    main()
