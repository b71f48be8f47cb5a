"""Test the constants that share out a tolerance: three times smaller or larger must be worse.

    python shares.py [FILE:NAME[:VALUE:VALUE] ...]

Each constant of `CONSTANTS`, or those named, is replaced by two other values. Errors are measured
over impacts and scenes whose answer is known by other means, closed forms and the oracle of
tools/campaign; and work, by basic blocks of the core. It needs the package's dependencies, GCC or
Clang, and some minutes.
"""

from __future__ import annotations

import ctypes
import json
import math
import os
import pickle
import re
import shutil
import subprocess
import sys
import sysconfig
import tempfile
from dataclasses import replace
from pathlib import Path
from typing import Any

from mutants import CORE, compile_file, compiled

ROOT = CORE.parent

# Of each run its error over its tolerance, and its work.
Runs = list[tuple[float, int]]

# The constants of the table in csrc/README.md: file, and the values to try where thrice makes no
# sense. Others are measured when named as FILE:NAME[:VALUE:VALUE].
CONSTANTS = [
    "adaptive/step_error.c:TAIL_SHARE",
    "adaptive/step_error.c:STEP_SHARE",
    "adaptive/step_error.c:END_SHARE",
    "adaptive/state.c:EVENT_SHARE",
    "adaptive/step_error.c:CAUTION:0.7:1.0",
    "adaptive/step_error.c:BLIND_GROWTH:1.0:6.0",
    "adaptive/closing.c:MOST_START",
]

# Of the campaign's first scenes those that err by a hundredth of a tolerance or more, never by all
# of it, and take the oracle less than 2 s.
SEEDS = [3, 6, 12, 14, 20, 26, 28, 31, 32, 34, 36, 37, 39, 43, 57, 65, 66, 71, 73, 77, 101]
SEEDS += [105, 106, 112, 114, 119, 122, 123, 127, 129, 130, 133, 135, 141, 144, 145, 149, 152, 154]
SEEDS += [156]

# The tolerances of all runs; only closed forms are right to the last.
TOLERANCES = (1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-12)

# More work than this, relative, and errors larger by this factor are worse; below this share of the
# tolerance errors are alike.
MORE, LARGER, LITTLE = 0.01, 1.05, 1e-3

# Below this share work is the same: a run is cut into pieces by the clock. Measured: 4e-7.
BY_CLOCK = 1e-5

COUNTER = """
unsigned long long aoi_blocks;
void __sanitizer_cov_trace_pc(void) { aoi_blocks++; }
"""
FLAGS = ["-fPIC", "-DPy_LIMITED_API=0x030B0000", f"-I{sysconfig.get_path('include')}"]
COUNTED = [*FLAGS, "-fsanitize-coverage=trace-pc"]


def closed_forms() -> list[tuple[Any, Any]]:
    """A ball against a wall under F = k d^n, as a case and its outcome."""
    import numpy as np

    from tools.campaign import case as plain
    from tools.campaign.outcome import Outcome, Touch

    mass, speed, found = 0.1, 2.0, []
    for n in (1.0, 1.5, 2.5):
        p, k = n + 1.0, 1e3 * 1e6**n
        deep = (0.5 * p * mass * speed**2 / k) ** (1.0 / p)
        rise = deep / speed * math.sqrt(math.pi) * math.gamma(1 + 1 / p) / math.gamma(0.5 + 1 / p)
        law = plain.Law("PowerLaw", {"k": k, "n": n})
        bodies = (plain.Body(mass, velocity=speed), plain.Body(math.inf))
        case = plain.Case(bodies, (plain.Contact(0, 1, law),), duration=3.0 * rise)
        touch = Touch(0.0, 2.0 * rise, 2.0 * mass * speed, 1.0, deep)
        one = np.array([k * deep**n]), np.array([rise]), np.array([2.0 * mass * speed])
        found.append((case, Outcome(*one, ((touch,),), np.array([-speed, 0.0]))))
    return found


def by_oracle() -> list[tuple[Any, Any]]:
    from tools.campaign.generate import case_of
    from tools.campaign.oracle import Oracle

    cases = [case_of(seed) for seed in SEEDS]
    return [(case, replace(Oracle(case).run(), force_at=None)) for case in cases]


def measure(known: Path) -> None:
    """In a process of its own: print errors over tolerances, and work, of every known case."""
    import aoimpact._core
    from aoimpact.integrate import to_tolerance
    from tools.campaign.compare import apart, largest_apart
    from tools.campaign.package import run

    blocks = ctypes.c_ulonglong.in_dll(ctypes.CDLL(aoimpact._core.__file__), "aoi_blocks")
    work = 0

    def counted(*given: Any, before: Any = to_tolerance.adaptive_run, **named: Any) -> Any:
        nonlocal work
        first = blocks.value
        try:
            return before(*given, **named)
        finally:
            work = blocks.value - first

    # One run, not two that confirm each other.
    to_tolerance.adaptive_run = counted
    to_tolerance._confirmed = lambda plan, run, rtol, touches: (run, rtol)
    found = []
    for case, true in pickle.loads(known.read_bytes()):
        for rtol in TOLERANCES if not case.family else TOLERANCES[:-1]:
            answer = run(case.with_tolerance(rtol))
            off = math.inf
            if answer.outcome is not None:
                off = largest_apart(apart(case, answer.outcome, true, rtol)).off / rtol
            found.append((off, work))
    print(json.dumps(found))


class Package:
    """The package in a folder of its own, to change its core."""

    def __init__(self, compiler: str, folder: Path) -> None:
        self.compiler, self.folder, self.core = compiler, folder, folder / "csrc"
        shutil.copytree(CORE, self.core)
        ignored = shutil.ignore_patterns("*.so", "__pycache__")
        shutil.copytree(ROOT / "aoimpact", folder / "aoimpact", ignore=ignored)
        (folder / "counter.c").write_text(COUNTER)
        (folder / "build").mkdir()
        counter = folder / "build" / "counter.o"
        compile_file(compiler, folder / "counter.c", self.core, counter, FLAGS)
        self.build(list(self.core.glob("*/*.c")))

    def build(self, sources: list[Path]) -> None:
        out, library = self.folder / "build", self.folder / "aoimpact" / "_core.abi3.so"
        for source in sources:
            compile_file(self.compiler, source, self.core, compiled(source, out), COUNTED)
        library.unlink(missing_ok=True)
        command = [self.compiler, "-shared", *sorted(out.glob("**/*.o")), "-lm", "-o", library]
        subprocess.run(command, check=True)

    def measured(self, known: Path) -> Runs:
        paths = {"PYTHONPATH": f"{self.folder}{os.pathsep}{ROOT}", "OPENBLAS_NUM_THREADS": "1"}
        command = [sys.executable, __file__, "--measure", str(known)]
        return json.loads(subprocess.check_output(command, env=os.environ | paths))

    def measured_with(self, file: str, name: str, value: str, known: Path) -> Runs:
        """The same with another value of a constant, which is set back."""
        path = self.core / file
        sources = list(self.core.glob("*/*.c")) if path.suffix == ".h" else [path]
        before = path.read_text()
        path.write_text(re.sub(pattern(name), rf"\g<1>{value}", before, count=1))
        self.build(sources)
        found = self.measured(known)
        path.write_text(before)
        self.build(sources)
        return found


def pattern(name: str) -> str:
    return rf"(\b{name} = )([^,;]+)"


def trials(of: str) -> tuple[str, str, str, list[str]]:
    """File, name, the value now and those to try, from FILE:NAME[:VALUE:VALUE]."""
    file, name, *others = of.split(":")
    found = re.search(pattern(name), (CORE / file).read_text())
    if found is None:
        raise SystemExit(f"{file}: {name} is not there any more")
    now = found.group(2)
    return file, name, now, others or [f"{float(now) * factor:.4g}" for factor in (1 / 3, 3)]


def compared(now: Runs, then: Runs) -> tuple[bool, str]:
    """Return whether runs got worse, and by how much, in the mean of all."""
    pairs = [(*one, *other) for one, other in zip(now, then, strict=True)]
    beyond = sum(after > 1.0 >= before for before, _, after, _ in pairs)
    larger = [max(after, LITTLE) / max(before, LITTLE) for before, _, after, _ in pairs]
    error = math.exp(math.fsum(map(math.log, larger)) / len(pairs))
    work = math.fsum(after / before for _, before, _, after in pairs) / len(pairs) - 1.0
    changed = sum(
        error != other or abs(after / before - 1.0) > BY_CLOCK
        for error, before, other, after in pairs
    )
    return beyond > 0 or error > LARGER or work > MORE, (
        f"errors x{error:.2f}, largest {max(off for off, _ in then):.2g} rtol, {beyond} beyond it;"
        f" work {work:+.1%}; {changed} of {len(pairs)} runs changed"
    )


def main(arguments: list[str]) -> int:
    if arguments[:1] == ["--measure"]:
        measure(Path(arguments[1]))
        return 0
    named, failed = arguments or CONSTANTS, 0
    with tempfile.TemporaryDirectory() as folder:
        package, known = Package(os.environ.get("CC", "cc"), Path(folder)), Path(folder, "known")
        sys.path[:0] = [folder, str(ROOT)]
        known.write_bytes(pickle.dumps([*closed_forms(), *by_oracle()]))
        before = package.measured(known)
        print("as it is:", compared(before, before)[1], flush=True)
        for of in named:
            file, name, value, others = trials(of)
            for other in others:
                after = package.measured_with(file, name, other, known)
                worse, said = compared(before, after)
                failed += not worse
                word = "worse" if worse else "NOT WORSE"
                print(f"{name} {value} -> {other}: {word}: {said}", flush=True)
    print(f"shares: {len(named)} constants, {failed} times not worse")
    return failed != 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
