"""What child processes are asked to do."""

from __future__ import annotations

import re
from functools import partial

from .case import Case
from .generate import case_of
from .judge import Verdict, judge
from .shrink import shrink


def judged(seed: int, way: str = "adaptive", rtol: float | None = None) -> Verdict:
    """The verdict on a seed, in a child process."""
    case = case_of(seed)
    return judge(case if rtol is None else case.with_tolerance(rtol), way=way)


def shrunk(text: str, kind: str, why: str, way: str = "adaptive", longest: float = 60.0) -> str:
    """The smallest scene that gets the same verdict, in a child process."""
    fails = partial(_fails, like=(kind, theme(why)), way=way)
    return shrink(Case.from_json(text), fails, longest=longest).to_json()


def _fails(case: Case, like: tuple[str, str], way: str) -> bool:
    try:
        verdict = judge(case, longest=5.0, way=way)
    except Exception:
        return False
    return (verdict.kind, theme(verdict.why)) == like


def theme(why: str) -> str:
    """What a verdict is about, without numbers: a fault or a message; nothing for a quantity."""
    if ":" not in why:
        return ""
    words = re.sub(r"[-+]?\d[\d.e+-]*", "#", why).split(":")
    first = words[0]
    quantity = len(first.split()) > 1 and first.split()[0] in _QUANTITIES
    return "" if quantity else ":".join(words[:3])[:60].split(" has ")[0]


# Of a touch that is missing the time is wrong; of a quantity that is off, another will do as well.
_QUANTITIES = ("peak", "impulse", "velocity", "start", "end", "touch")
