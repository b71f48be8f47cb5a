"""What child processes are asked to do."""

from __future__ import annotations

from functools import partial

from .case import Case
from .generate import case_of
from .judge import Verdict, judge
from .shrink import shrink


def judged(seed: int, way: str = "adaptive", rtol: float | None = None) -> Verdict:
    """The verdict on a seed, in a child process."""
    case = case_of(seed)
    return judge(case if rtol is None else case.with_tolerance(rtol), way=way)


def shrunk(text: str, kind: str = "wrong", way: str = "adaptive", longest: float = 60.0) -> str:
    """The smallest scene that gets the same verdict, in a child process."""
    fails = partial(_fails, kind=kind, way=way)
    return shrink(Case.from_json(text), fails, longest=longest).to_json()


def _fails(case: Case, kind: str, way: str) -> bool:
    try:
        return judge(case, longest=5.0, way=way).kind == kind
    except Exception:
        return False
