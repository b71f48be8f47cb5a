"""The command line of the campaign."""

from __future__ import annotations

import argparse
import sys
import time as clock
from collections import Counter
from functools import partial

from .generate import case_of
from .judge import Verdict, judged
from .pool import each

# s for one scene: the package's answer may not take longer, nor the oracle on top of it.
LIMIT = 60.0

# Share of the scenes that may be refused, each with a cure that works.
MOST_REFUSED = 0.01


def main(arguments: list[str] | None = None) -> int:
    """Run the campaign; return 1 if anything failed, or more than a hundredth was refused."""
    parser = argparse.ArgumentParser(prog="python -m tools.campaign", description=__doc__)
    commands = parser.add_subparsers(dest="command", required=True)
    scenes = commands.add_parser("scenes", help="random scenes against the oracle")
    scenes.add_argument("--seeds", default="0:100", help="from:to, or a list with commas")
    scenes.add_argument("--workers", type=int, default=2)
    scenes.add_argument("--way", choices=("adaptive", "newmark"), default="adaptive")
    scenes.add_argument("--rtol", type=float, help="of all scenes, in place of their own")
    show = commands.add_parser("show", help="the script of a seed, and its verdict")
    show.add_argument("seed", type=int)
    show.add_argument("--way", choices=("adaptive", "newmark"), default="adaptive")
    options = parser.parse_args(arguments)
    if options.command == "show":
        print(case_of(options.seed).script())
        print(judged(options.seed, options.way))
        return 0
    return _scenes(options)


def _seeds(text: str) -> list[int]:
    if ":" in text:
        first, last = map(int, text.split(":"))
        return list(range(first, last))
    return [int(one) for one in text.split(",")]


def _scenes(options: argparse.Namespace) -> int:
    found: dict[int, Verdict] = {}
    seeds, begin = _seeds(options.seeds), clock.monotonic()
    work = partial(judged, way=options.way, rtol=options.rtol)
    for seed, state, result in each(work, seeds, workers=options.workers, limit=LIMIT):
        if state == "done":
            verdict = result
        elif state == "failed":  # of the oracle: a mistake of the campaign's own
            verdict = Verdict("undecided", f"the campaign failed: {result}")
        else:
            verdict = Verdict("hangs", f"{state}: {result}")
        found[seed] = verdict
        if verdict.kind not in ("ok", "warned"):
            print(f"{seed:7} {verdict.kind:9} {verdict.why[:200]}", flush=True)
            for name, text in verdict.details.items():
                print(f"{'':18}{name}: {text}")
        if len(found) % 100 == 0:
            print(
                f"... {len(found)} of {len(seeds)}, {clock.monotonic() - begin:.0f} s",
                file=sys.stderr,
            )
    kinds = Counter(verdict.kind for verdict in found.values())
    print(
        f"{len(found)} scenes, {clock.monotonic() - begin:.0f} s, way {options.way}: {dict(kinds)}"
    )
    failed = any(verdict.failed for verdict in found.values())
    return int(failed or kinds["refused"] > MOST_REFUSED * len(found))


if __name__ == "__main__":
    sys.exit(main())
