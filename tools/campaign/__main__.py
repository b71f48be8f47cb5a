"""Random scenes, decks and malformed inputs, each kind drawn by number; run from tools/.

    python -m campaign scene --count 3000 --workers 2 --out failures
    python -m campaign mesh --count 50000 --seed 1

`scene` and `oblique` are impacts whose results are compared with those of independent solutions by
SciPy, Newmark's rule or fixed springs. `abaqus` and `nastran` are decks of a body, written in any
way that the format allows; the mesh read is compared with the body. The other kinds are malformed
inputs, which must be refused by a message that names the file or argument, or be read in silence.

Number i of a seed is the same in every run. The numbers are tried in child processes that hold at
most 2 GiB beyond what they import; one that crashes, or computes for too long, is replaced. The
first of each failure is saved.
"""

from __future__ import annotations

import argparse
import os
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path

from .pool import KINDS, each

# Largest share of scenes that may be refused, each with a cure that works; and maximum number of
# printed verdicts of each kind.
MOST_REFUSED, MOST_SHOWN = 0.01, 20


def main(arguments: list[str] | None = None) -> int:
    """Run the campaign; return 1 if anything failed, or more than a hundredth was refused."""
    parser = argparse.ArgumentParser(
        prog="python -m campaign",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("kind", choices=KINDS)
    parser.add_argument("--first", type=int, default=0, help="the first number")
    parser.add_argument("--count", type=int, default=100)
    parser.add_argument("--seed", type=int, default=0, help="of all but scenes and impacts")
    parser.add_argument("--workers", type=int, default=1)
    parser.add_argument("--out", type=Path, help="folder for one of each failure")
    parser.add_argument("--way", choices=("adaptive", "newmark"), default="adaptive")
    options = parser.parse_args(arguments)
    kinds, slowest, begin = Counter[str](), (0.0, -1), time.monotonic()
    failed = False
    fast = "/dev/shm" if os.access("/dev/shm", os.W_OK) else None  # a folder in memory
    with tempfile.TemporaryDirectory(dir=fast) as root:
        for number, verdict, seconds in each(options, root):
            kinds[verdict.kind] += 1
            slowest, failed = max(slowest, (seconds, number)), failed or verdict.failed
            if not verdict.passed and kinds[verdict.kind] <= MOST_SHOWN:
                print(f"{number:7} {verdict}", flush=True)
    print(
        f"{options.kind}: {options.count} of seed {options.seed} in "
        f"{time.monotonic() - begin:.0f} s: {dict(kinds)}; "
        f"slowest {slowest[0]:.2f} s (number {slowest[1]})"
    )
    return int(failed or kinds["refused"] > MOST_REFUSED * options.count)


if __name__ == "__main__":
    sys.exit(main())
