"""Decks of one body, written in any way that a format allows, read and compared with the body.

    python -m tools.campaign.decks --kind nastran --count 10000 --seed 1

A deck that is refused, read otherwise than it was meant, or warned of for no reason is a failure;
the first of each sort is kept in a folder. Deck number i of a seed is the same in every run.
"""

from __future__ import annotations

import argparse
import shutil
import sys
import tempfile
from collections import Counter
from importlib import import_module
from pathlib import Path

KINDS = {"abaqus": "abaqusdecks", "nastran": "nastrandecks"}


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--kind", choices=KINDS, required=True)
    parser.add_argument("--count", type=int, default=1000)
    parser.add_argument("--first", type=int, default=0, help="number of the first deck")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--out", type=Path, help="folder for one deck of each failure")
    given = parser.parse_args()
    tried = import_module(f".{KINDS[given.kind]}", __package__).tried
    failures: Counter[str] = Counter()
    for number in range(given.first, given.first + given.count):
        with tempfile.TemporaryDirectory() as folder:
            wrong = tried(given.seed, number, Path(folder))
            if wrong:
                signature = wrong[:60]
                failures[signature] += 1
                if failures[signature] == 1:
                    print(f"number {number}: {wrong[:400]}", flush=True)
                    if given.out is not None:
                        shutil.copytree(folder, given.out / str(number), dirs_exist_ok=True)
    print(
        f"{given.kind}: {given.count} decks of seed {given.seed}: {sum(failures.values())} failed"
    )
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
