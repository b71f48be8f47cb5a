"""The verdict on a scene: the package's answer against the plain formulation and Newmark's rule."""

from __future__ import annotations

import time as clock
from dataclasses import dataclass, field, replace

import numpy as np

import aoimpact as ao

from . import cures
from .case import Case
from .compare import Apart, apart, from_newmark, largest_apart
from .generate import case_of
from .motion import LAG
from .oracle import GaveUpError, Oracle
from .outcome import Outcome
from .package import Answer, as_settled, newmark, run
from .rest import NoRestError

TIMES = cures.TIMES

# A difference is the oracle's own, or the scene's, if a tighter or a nudged run of it moves by
# that share.
_SHARE = 0.2

# Of the oracle's own dashpot, where it runs tighter.
_LESS_LAG = 0.1

# Relative nudge of all coordinates and velocities at the start.
_NUDGE = 1e-12

# s for Newmark's rule where answer and oracle agree, and the difference from both that is noted: if
# its own estimate is that many times smaller.
_CHEAP, _FAR, _SURE = 0.5, 1e-3, 30.0

CLASSES = (
    "ok", "warned", "refused", "apart", "wrong", "faulty", "helpless", "chaotic", "undecided",
    "bare", "hangs",
)  # fmt: skip


@dataclass(frozen=True)
class Verdict:
    """What came of a scene.

    kind: one of CLASSES; "apart": Newmark's rule is far from answer and oracle, which agree;
    "helpless": refused, and no cure that the message names works. why: what was off, or the
    message. off: the largest relative error.
    """

    kind: str
    why: str = ""
    off: float = 0.0
    seconds: float = 0.0
    details: dict[str, str] = field(default_factory=dict)

    @property
    def failed(self) -> bool:
        return self.kind in ("wrong", "faulty", "helpless", "bare", "hangs")


def oracle_tolerance(case: Case) -> float:
    """Far enough below the tolerance of the scene."""
    return float(np.clip(1e-3 * case.rtol, 1e-12, 1e-9))


def judge(case: Case, *, longest: float = 20.0, way: str = "adaptive") -> Verdict:
    """Judge the package's answer to a scene."""
    begin = clock.perf_counter()
    if way == "newmark":
        case = case.with_tolerance(max(case.rtol, 1e-5))
    answer = run(case, ao.Newmark(rtol=case.rtol) if way == "newmark" else None)
    verdict = _judged(case, answer, longest, way)
    return Verdict(
        verdict.kind, verdict.why, verdict.off, clock.perf_counter() - begin, verdict.details
    )


def _judged(case: Case, answer: Answer, longest: float, way: str) -> Verdict:
    if answer.outcome is None:
        return Verdict("bare", answer.error) if answer.bare else _refused(case, answer, longest)
    if way == "adaptive" and answer.faults and not answer.warned:
        return Verdict("faulty", "; ".join(answer.faults))
    tolerance = oracle_tolerance(case)
    try:
        true = Oracle(case, rtol=tolerance, longest=longest).run()
    except (GaveUpError, NoRestError) as error:
        return _by_newmark(case, answer.outcome, f"oracle: {error}")
    limit = TIMES * case.rtol
    if (over := _beyond_patch(case, true)) > limit:
        return Verdict("wrong", f"patch: the force exceeds it by {over:.2g}", over)
    found = _worst(case, answer.outcome, true, way)
    if found.off <= limit:
        return _third(case, true, Verdict("ok", str(found), found.off))
    if answer.warned:
        return _warned(case, answer, true, found, longest, way)
    return _suspected(case, answer.outcome, true, longest, way)


def _refused(case: Case, answer: Answer, longest: float) -> Verdict:
    """Whether one of the cures that a refusal names works."""
    try:
        true = Oracle(case, rtol=oracle_tolerance(case), longest=longest).run()
    except (GaveUpError, NoRestError):
        true = None
    said = answer.error
    if said.startswith("LawLimitError"):  # of the scene: no other run of it helps
        if true is None:
            return Verdict("undecided", f"the oracle gave up; {said}")
        over = _beyond_patch(case, true)
        rightly = over > -TIMES * case.rtol
        return Verdict("ok" if rightly else "wrong", f"patch: by {over:.2g}; {said}", abs(over))
    failing = cures.tried(case, said, true)
    works = [name for name, failure in failing.items() if not failure]
    details = {f"cure: {name}": failure or "works" for name, failure in failing.items()}
    return Verdict("refused" if works else "helpless", said, 0.0, 0.0, details)


def _beyond_patch(case: Case, true: Outcome) -> float:
    """By how much the largest force exceeds that up to which the law holds, relative."""
    laws = [contact.law for contact in case.contacts]
    most = [law.arguments["k"] * law.deepest**1.5 if law.removed else np.inf for law in laws]
    return float(np.nanmax(true.peaks / np.array(most), initial=0.0)) - 1.0


def _warned(
    case: Case, answer: Answer, true: Outcome, found: Apart, longest: float, way: str
) -> Verdict:
    """Whether what a warning says of the error is true: of first contacts it says nothing."""
    said = answer.warned[0]
    if answer.claimed is not None and found.off > TIMES * max(answer.claimed, case.rtol):
        return _suspected(case, answer.outcome, true, longest, way)
    return Verdict("warned", f"{found}; {said}", found.off)


def _third(case: Case, true: Outcome, verdict: Verdict) -> Verdict:
    """Newmark's rule beside an answer and an oracle that agree, where it settles at once."""
    second = newmark(case, _FAR / _SURE, _CHEAP)
    if second is None or not second.error < _FAR / _SURE:
        return verdict
    # As small as its lesser contacts may be off, or what moves where nothing does.
    off = min(as_settled(second, true), from_newmark(case, second, true))
    return replace(verdict, kind="apart", why=f"Newmark by {off:.2g}") if off > _FAR else verdict


def _worst(case: Case, outcome: Outcome, true: Outcome, way: str):
    every = apart(case, outcome, true, TIMES * case.rtol)
    if way == "newmark":  # which promises these
        every = [one for one in every if one.what.startswith(("peak force", "impulse"))]
    return largest_apart(every)


def _by_newmark(case: Case, outcome: Outcome, why: str) -> Verdict:
    """Where there is no oracle, two ways have to do."""
    second = newmark(case, TIMES * case.rtol)
    if second is not None:
        off = from_newmark(case, outcome, second)
        if off <= TIMES * case.rtol:
            return Verdict("ok", f"by Newmark alone; {why}", off)
        why += f"; {off:.2g} from Newmark, which settled to {second.error:.2g}"
    return Verdict("undecided", why)


def _newmark_is_elsewhere(
    case: Case, outcome: Outcome, true: Outcome, settled: float, details: dict[str, str]
) -> bool:
    """Whether the second method contradicts the oracle; what it finds goes into the details."""
    second = newmark(case, settled)
    if second is None:
        details["newmark"] = "none"
        return False
    ours, its = from_newmark(case, outcome, second), from_newmark(case, true, second)
    details["newmark"] = (
        f"{ours:.2g} from the answer, {its:.2g} from the oracle, settled to {second.error:.2g}"
    )
    between = from_newmark(case, outcome, true)
    return between > TIMES * case.rtol and its > 0.5 * between and its > 3.0 * second.error


def _suspected(case: Case, outcome: Outcome, true: Outcome, longest: float, way: str) -> Verdict:
    """Whether a difference is the package's fault."""
    found = _worst(case, outcome, true, way)
    details: dict[str, str] = {}
    tolerance = oracle_tolerance(case)
    rng = np.random.default_rng(1)
    try:
        tight = Oracle(
            case, rtol=0.03 * tolerance, longest=3.0 * longest, lag=_LESS_LAG * LAG
        ).run()
        nudge = _NUDGE * rng.uniform(-1.0, 1.0, 1000)
        nudged = Oracle(case, rtol=tolerance, longest=3.0 * longest, nudge=nudge).run()
    except (GaveUpError, NoRestError) as error:
        return Verdict("undecided", f"{found}; oracle again: {error}", found.off)
    found = _worst(case, outcome, tight, way)
    if found.off <= TIMES * case.rtol:
        return Verdict("ok", str(found), found.off)
    own = _worst(case, true, tight, way).off
    moved = _worst(case, nudged, true, way).off
    details["oracle moves by"] = f"{own:.2g} (tighter), {moved:.2g} (nudged)"
    if moved > _SHARE * found.off:
        return Verdict(
            "chaotic", f"{found}; nudged by {_NUDGE:g}: {moved:.2g}", found.off, 0, details
        )
    if own > _SHARE * found.off:
        return Verdict("undecided", f"{found}; oracle tighter: {own:.2g}", found.off, 0, details)
    if _newmark_is_elsewhere(case, outcome, tight, 0.1 * found.off, details):
        return Verdict(
            "undecided", f"{found}; Newmark is not with the oracle", found.off, 0, details
        )
    tighter = run(case.with_tolerance(max(1e-12, 1e-3 * case.rtol)))
    if way == "adaptive" and tighter.outcome is not None:
        off = _worst(case, tighter.outcome, tight, way).off
        details["package at 1e-3 rtol"] = f"off by {off:.2g}"
    return Verdict("wrong", str(found), found.off, 0, details)


def judged(seed: int, way: str = "adaptive", rtol: float | None = None) -> Verdict:
    """Judge the scene of a seed."""
    case = case_of(seed)
    return judge(case if rtol is None else case.with_tolerance(rtol), way=way)
