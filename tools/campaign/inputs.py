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
import os
import random
import re
import shutil
import sys
import tempfile
import time
import traceback
import warnings
from collections import Counter
from collections.abc import Callable
from functools import cache, partial
from importlib import import_module
from pathlib import Path
from typing import Any

from .pool import each

KINDS = {
    "mesh": "meshes",
    "matrix": "matrices",
    "matrixfile": "matrixfiles",
    "scene": "scenefiles",
}

LIMIT_BYTES = 2**31
LIMIT_SECONDS = 10.0

# A folder in memory, where there is one.
_FAST = "/dev/shm" if os.access("/dev/shm", os.W_OK) else None


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


@cache
def _prepared(kind: str, root: Path) -> tuple[Any, Any, Path]:
    """The module of a kind, what its inputs are made from, and a folder; once in each child."""
    import aoimpact

    faulthandler.enable()
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)  # readers may print
    module, folder = import_module(f".{KINDS[kind]}", __package__), Path(tempfile.mkdtemp(dir=root))
    seeds = module.seeds(folder)
    for name in dir(aoimpact):  # now: the first input does not pay for it, in time or memory
        getattr(aoimpact, name)
    _limit_memory()
    return module, seeds, folder


def _try(kind: str, root: Path, seed: int, number: int) -> tuple[str, str, float, int]:
    """Outcome and text of an input, s that it took, and the most memory, KiB, imports included."""
    import resource

    module, seeds, folder = _prepared(kind, root)
    given = module.make(random.Random(f"{seed} {kind} {number}"), seeds, folder)
    start = time.process_time()
    outcome, text = tried(given.run, given.named)
    used = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return outcome, text[:400], time.process_time() - start, used


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--kind", choices=KINDS, required=True)
    parser.add_argument("--count", type=int, default=1000)
    parser.add_argument("--first", type=int, default=0, help="number of the first input")
    parser.add_argument("--workers", type=int, default=1)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--out", type=Path, help="folder for one input of each failure")
    given = parser.parse_args()
    begin, kind, seed = time.monotonic(), given.kind, given.seed
    outcomes, examples = Counter[str](), dict[str, tuple[int, str]]()
    slowest, most = (0.0, -1), 0
    with tempfile.TemporaryDirectory(dir=_FAST) as root:
        place = kind, Path(root)
        for number, state, result in each(
            partial(_try, *place, seed),
            range(given.first, given.first + given.count),
            workers=given.workers,
            limit=LIMIT_SECONDS,
            begin=partial(_prepared, *place),
        ):
            ended = (f"{state}: {result}", "", 0.0, 0)
            outcome, text, seconds, used = result if state == "done" else ended
            outcomes[outcome] += 1
            examples.setdefault(outcome, (number, text))
            slowest, most = max(slowest, (seconds, number)), max(most, used)
    passed, refused = outcomes.pop("passed", 0), outcomes.pop("refused", 0)
    print(
        f"{kind}: {passed + refused + outcomes.total()} inputs of seed {seed} in "
        f"{time.monotonic() - begin:.0f} s: {passed} passed, {refused} refused, "
        f"{outcomes.total()} failed; slowest {slowest[0]:.2f} s (number {slowest[1]}), most memory "
        f"{most / 2**10:.0f} MiB"
    )
    module = import_module(f".{KINDS[kind]}", __package__)
    for outcome, count in outcomes.items():
        number, text = examples[outcome]
        print(f"\n{count} x {outcome}\n  number {number}: {text}")
        if given.out is not None:
            given.out.mkdir(parents=True, exist_ok=True)
            with tempfile.TemporaryDirectory() as folder:
                rng = random.Random(f"{seed} {kind} {number}")
                file = module.make(rng, module.seeds(Path(folder)), Path(folder)).saved
                name = f"{kind}_{seed}_{number}_" + re.sub(r"\W+", "_", outcome)[:60]
                shutil.copy(file, given.out / f"{name}{file.suffix}")
    return 1 if outcomes else 0


if __name__ == "__main__":
    sys.exit(main())
