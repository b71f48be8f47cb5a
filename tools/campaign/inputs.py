"""Malformed inputs by the ten thousand: every one is refused by name, or read without a word.

    python -m tools.campaign.inputs --kind mesh --count 50000 --workers 2 --seed 1

Inputs are made and tried in child processes that hold at most 2 GiB beyond what they import; a
child that crashes, or computes for more than 10 s for one, is replaced. What counts as a failure: a
crash, an exception that is no AOImpactError, a MemoryError, a warning that is no AOImpactWarning,
and a message that does not name the file or argument. Failures of one signature are shown once,
and one input of each is saved. Input number i of a seed is the same in every run.
"""

from __future__ import annotations

import argparse
import faulthandler
import json
import os
import random
import re
import selectors
import shutil
import subprocess
import sys
import tempfile
import time
import traceback
import warnings
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from importlib import import_module
from pathlib import Path
from typing import Any

from .pool import PATIENCE, processor_time

KINDS = {
    "mesh": "meshes",
    "matrix": "matrices",
    "matrixfile": "matrixfiles",
    "scene": "scenefiles",
}

LIMIT_BYTES = 2**31
LIMIT_SECONDS = 10.0

# A child is replaced after so many inputs, lest memory that libraries keep count against the limit.
_PER_CHILD = 5000


@dataclass
class Tally:
    """What came of the inputs.

    Attributes
    ----------
    outcomes : Counter
        "passed", "refused", and each failure's signature.
    examples : dict
        By signature, the number of its first input and what was said.
    slowest : tuple of float and int
        Seconds, and which input took them.
    most : float
        Largest resident memory of a child, bytes, imports included.
    """

    outcomes: Counter[str] = field(default_factory=Counter)
    examples: dict[str, tuple[int, str]] = field(default_factory=dict)
    slowest: tuple[float, int] = (0.0, -1)
    most: float = 0.0

    def add(self, report: dict[str, Any]) -> None:
        number, signature = report["number"], report["outcome"]
        self.outcomes[signature] += 1
        if signature not in ("passed", "refused"):
            self.examples.setdefault(signature, (number, report["text"]))
        self.slowest = max(self.slowest, (report["seconds"], number))
        self.most = max(self.most, report["memory"])

    @property
    def failures(self) -> dict[str, int]:
        return {k: n for k, n in self.outcomes.items() if k not in ("passed", "refused")}


# ------------------------------------------------------------------------------ in a child


def _signature(error: BaseException) -> str:
    """The exception's type and the package's innermost frames."""
    frames = [
        f"{Path(frame.filename).stem}.{frame.name}"
        for frame in traceback.extract_tb(error.__traceback__)
        if f"{os.sep}aoimpact{os.sep}" in frame.filename
    ]
    return f"{type(error).__name__} in {' < '.join(reversed(frames[-3:]))}"


def _limit_memory() -> None:
    import resource

    pages = int(Path("/proc/self/statm").read_text().split()[0])
    most = pages * resource.getpagesize() + LIMIT_BYTES
    resource.setrlimit(resource.RLIMIT_AS, (most, most))


def tried(run: Callable[[], None], named: Callable[[str], bool]) -> tuple[str, str]:
    """Return how an input ended, "passed", "refused" or a failure's signature, and what was said.

    Parameters
    ----------
    run : callable
        Does with the input whatever a user would.
    named : callable
        Whether a message names what is wrong.
    """
    from aoimpact import AOImpactError, AOImpactWarning

    outcome, text = "passed", ""
    with warnings.catch_warnings(record=True) as seen:
        warnings.simplefilter("always")
        try:
            run()
        except AOImpactError as error:
            outcome, text = "refused", str(error)
            if not named(text):
                outcome = f"unnamed {_signature(error)}"
        except MemoryError as error:
            outcome, text = f"memory: {_signature(error)}", str(error)
        except BaseException as error:
            outcome, text = f"bare {_signature(error)}", f"{type(error).__name__}: {error}"
    for one in seen:
        if not issubclass(one.category, AOImpactWarning) and outcome in ("passed", "refused"):
            place = f"{Path(one.filename).name}:{one.lineno}"
            outcome = f"warning {one.category.__name__} at {place}"
            text = str(one.message)
    return outcome, text


def _child(kind: str, seed: int, numbers: range) -> None:
    import resource

    faulthandler.enable()
    module = import_module(f".{KINDS[kind]}", __package__)
    said = os.fdopen(os.dup(1), "w")  # readers may print
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
    with tempfile.TemporaryDirectory(dir=_fast_folder()) as folder:
        seeds = module.seeds(Path(folder))
        _import_everything()
        _limit_memory()
        print(json.dumps({"ready": True}), file=said, flush=True)
        for number in numbers:
            given = module.make(random.Random(f"{seed} {kind} {number}"), seeds, Path(folder))
            start = time.process_time()
            outcome, text = tried(given.run, given.named)
            report = {
                "number": number,
                "outcome": outcome,
                "text": text[:400],
                "seconds": time.process_time() - start,
                "memory": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024,
            }
            print(json.dumps(report), file=said, flush=True)


def _import_everything() -> None:
    """Now: the first input does not pay for it, in time or memory."""
    import aoimpact

    for name in dir(aoimpact):
        getattr(aoimpact, name)


def _fast_folder() -> str | None:
    return "/dev/shm" if os.access("/dev/shm", os.W_OK) else None


# ----------------------------------------------------------------------------- their parent


class _Child:
    """A process that tries some inputs one after the other, and which it is at."""

    def __init__(self, kind: str, seed: int, numbers: range) -> None:
        arguments = [kind, seed, numbers.start, numbers.stop, numbers.step]
        command = [sys.executable, "-m", __spec__.name, "--child", *map(str, arguments)]
        self.log = tempfile.TemporaryFile()  # noqa: SIM115  (as long as the process)
        self.process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=self.log)
        self.left = numbers
        self.since: float | None = None  # it begins with what all inputs are made from
        self.used = 0.0

    def received(self) -> dict[str, Any] | None:
        """What it says next; None at its end."""
        assert self.process.stdout is not None
        line = self.process.stdout.readline()
        if not line.endswith(b"\n"):
            return None
        self.since, self.used = time.monotonic(), self._used()
        report: dict[str, Any] = json.loads(line)
        if "number" in report:
            self.left = self.left[1:]
        return report

    def overdue(self) -> bool:
        """By the processor's time: others may have it for long."""
        if self.since is None or (waited := time.monotonic() - self.since) < LIMIT_SECONDS:
            return False
        return waited > PATIENCE * LIMIT_SECONDS or self._used() - self.used > LIMIT_SECONDS

    def _used(self) -> float:
        return processor_time(self.process.pid)

    def ended(self) -> dict[str, Any]:
        """A report of the input that it did not survive."""
        late = self.overdue()
        self.process.kill()
        code = self.process.wait()
        self.log.seek(0)
        said = self.log.read().decode(errors="replace")[-4000:]
        if self.since is None:
            raise RuntimeError(f"a child did not begin:\n{said}")
        number, self.left = self.left[0], self.left[1:]
        outcome = "longer than 10 s" if late else f"crash ({code})"
        seconds = LIMIT_SECONDS if late else 0.0
        text = said[said.rfind("Fatal Python error") :].strip() if "Fatal" in said else ""
        return {
            "number": number,
            "outcome": outcome,
            "text": text,
            "seconds": seconds,
            "memory": 0.0,
        }


def reports(kind: str, seed: int, numbers: range, workers: int) -> Iterator[dict[str, Any]]:
    """Try inputs in child processes, and yield a report of each as it ends."""
    step = _PER_CHILD * workers
    parts = [
        numbers[start + i : start + step : workers]
        for start in range(0, len(numbers), step)
        for i in range(workers)
    ]
    waiting = [part for part in parts if len(part)]
    with selectors.DefaultSelector() as selector:

        def start(part: range) -> None:
            child = _Child(kind, seed, part)
            selector.register(child.process.stdout, selectors.EVENT_READ, child)  # type: ignore[arg-type]

        for _ in range(min(workers, len(waiting))):
            start(waiting.pop(0))
        while selector.get_map():
            ready = {key.data for key, _ in selector.select(timeout=0.5)}
            for child in [key.data for key in selector.get_map().values()]:
                report = child.received() if child in ready else None
                if report is not None and "number" in report:
                    yield report
                if child.overdue() or (child in ready and report is None):
                    selector.unregister(child.process.stdout)
                    if len(child.left):
                        yield child.ended()
                    child.process.kill()
                    child.process.wait()
                    if len(child.left):
                        waiting.insert(0, child.left)
                    if waiting:
                        start(waiting.pop(0))


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--kind", choices=KINDS, required=True)
    parser.add_argument("--count", type=int, default=1000)
    parser.add_argument("--first", type=int, default=0, help="number of the first input")
    parser.add_argument("--workers", type=int, default=1)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--out", type=Path, help="folder for one input of each failure")
    given = parser.parse_args()
    tally = Tally()
    begin = time.monotonic()
    numbers = range(given.first, given.first + given.count)
    for report in reports(given.kind, given.seed, numbers, given.workers):
        tally.add(report)
    print(
        f"{given.kind}: {sum(tally.outcomes.values())} inputs of seed {given.seed} in "
        f"{time.monotonic() - begin:.0f} s: {tally.outcomes['passed']} passed, "
        f"{tally.outcomes['refused']} refused, {sum(tally.failures.values())} failed; slowest "
        f"{tally.slowest[0]:.2f} s (number {tally.slowest[1]}), most memory "
        f"{tally.most / 2**20:.0f} MiB"
    )
    module = import_module(f".{KINDS[given.kind]}", __package__)
    for signature, (number, text) in tally.examples.items():
        print(f"\n{tally.outcomes[signature]} x {signature}\n  number {number}: {text}")
    if given.out is not None and tally.examples:
        given.out.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory() as folder:
            seeds = module.seeds(Path(folder))
            for signature, (number, _) in tally.examples.items():
                rng = random.Random(f"{given.seed} {given.kind} {number}")
                file = module.make(rng, seeds, Path(folder)).saved
                name = re.sub(r"\W+", "_", signature)[:60]
                shutil.copy(
                    file, given.out / f"{given.kind}_{given.seed}_{number}_{name}{file.suffix}"
                )
    return 1 if tally.failures else 0


if __name__ == "__main__":
    if sys.argv[1:2] == ["--child"]:
        _child(sys.argv[2], int(sys.argv[3]), range(*map(int, sys.argv[4:7])))
    else:
        sys.exit(main())
