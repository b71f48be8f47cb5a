"""Verdict on a scene: the package's answer compared with the oracle and with Newmark's rule."""

from __future__ import annotations

from argparse import Namespace
from functools import partial
from pathlib import Path

import numpy as np

import aoimpact as ao

from . import cures
from .case import Case
from .compare import Apart, apart, from_newmark, largest_apart
from .generate import case_of
from .motion import LAG
from .oracle import GaveUpError, Oracle
from .outcome import Outcome, Trial, Verdict
from .package import Answer, in_time, run
from .rest import NoRestError

TIMES = cures.TIMES

# Share of a difference by which a tighter or a nudged run of the oracle may move: if it moves by
# more, the difference is due to the oracle's error or to a chaotic scene.
_SHARE = 0.2

# Relaxation of the oracle's own dashpot in the tighter run, over that of other runs.
_LESS_LAG = 0.1

# Relative change of all initial coordinates and velocities in the nudged run.
_NUDGE = 1e-12

# If answer and oracle agree: maximum time of a run by Newmark's rule, s, the difference from the
# oracle that is reported, and this difference over the tolerance of the run.
_CHEAP, _FAR, _SURE = 0.5, 1e-3, 30.0


def oracle_tolerance(case: Case) -> float:
    """Return the oracle's tolerance, far below that of the scene."""
    return float(np.clip(1e-3 * case.rtol, 1e-12, 1e-9))


def judge(case: Case, *, longest: float = 20.0, way: str = "adaptive") -> Verdict:
    """Judge the package's answer to a scene."""
    if way == "newmark":
        case = case.with_tolerance(max(case.rtol, 1e-5))
    answer = run(case, ao.Newmark(rtol=case.rtol) if way == "newmark" else None)
    return _judged(case, answer, longest, way)


def _judged(case: Case, answer: Answer, longest: float, way: str) -> Verdict:
    if answer.outcome is None:
        return Verdict("bare", answer.error) if answer.bare else _refused(case, answer, longest)
    if way == "adaptive" and answer.faults and not answer.warned:
        return Verdict("faulty", "; ".join(answer.faults))
    tolerance = oracle_tolerance(case)
    try:
        true = Oracle(case, rtol=tolerance, longest=longest).run()
    except (GaveUpError, NoRestError) as error:
        second = _newmark(case, TIMES * case.rtol)
        off = np.inf if second is None else from_newmark(case, answer.outcome, second)
        kind = "ok" if off <= TIMES * case.rtol else "undecided"
        return Verdict(kind, f"oracle: {error}; {off:.2g} from Newmark", off)
    limit = TIMES * case.rtol
    if (over := _beyond_patch(case, true)) > limit:
        return Verdict("wrong", f"patch: the force exceeds it by {over:.2g}", over)
    found = _worst(case, answer.outcome, true, way)
    if found.off <= limit:
        # Answer and oracle agree: compare with Newmark's rule, if that converges quickly.
        second = _newmark(case, _FAR / _SURE, _CHEAP)
        off = 0.0 if second is None else from_newmark(case, second, true)
        agree = Verdict("ok", str(found), found.off)
        return Verdict("apart", f"Newmark by {off:.2g}") if off > _FAR else agree
    # The estimated error that comes with a warning must hold; without one (NaN) any error passes.
    if answer.warned and not found.off > TIMES * max(answer.claimed, case.rtol):
        return Verdict("warned", f"{found}; {answer.warned[0]}", found.off)
    return _suspected(case, answer.outcome, true, longest, way)


def _refused(case: Case, answer: Answer, longest: float) -> Verdict:
    """Return the verdict on a refusal: whether one of the cures that it names works."""
    try:
        true = Oracle(case, rtol=oracle_tolerance(case), longest=longest).run()
    except (GaveUpError, NoRestError):
        true = None
    said = answer.error
    if said.startswith("LawLimitError"):  # due to the scene: no other run helps
        if true is None:
            return Verdict("undecided", f"the oracle gave up; {said}")
        over = _beyond_patch(case, true)
        rightly = over > -TIMES * case.rtol
        return Verdict("ok" if rightly else "wrong", f"patch: by {over:.2g}; {said}", abs(over))
    failing = cures.tried(case, said, true)
    works = [name for name, failure in failing.items() if not failure]
    details = {f"cure: {name}": failure or "works" for name, failure in failing.items()}
    return Verdict("refused" if works else "helpless", said, 0.0, details)


def _beyond_patch(case: Case, true: Outcome) -> float:
    """Return the largest force over that up to which the law holds, minus 1."""
    laws = [contact.law for contact in case.contacts]
    most = [law.arguments["k"] * law.deepest**1.5 if law.removed else np.inf for law in laws]
    return float(np.nanmax(true.peaks / np.array(most), initial=0.0)) - 1.0


def _newmark(case: Case, wanted: float, longest: float = 2.0) -> Outcome | None:
    """Return the outcome by Newmark's rule to a tolerance; None if it takes too long or warns."""
    rule = ao.Newmark(rtol=min(max(wanted, 1e-9), 0.1))
    answer = in_time(partial(run, case, rule), longest)
    return None if answer is None or answer.warned else answer.outcome


def _worst(case: Case, outcome: Outcome, true: Outcome, way: str) -> Apart:
    every = apart(case, outcome, true, TIMES * case.rtol)
    if way == "newmark":  # its tolerance applies to these quantities only
        every = [one for one in every if one.what.startswith(("peak force", "impulse"))]
    return largest_apart(every)


def _suspected(case: Case, outcome: Outcome, true: Outcome, longest: float, way: str) -> Verdict:
    """Return the verdict on a difference: whether it is the package's error."""
    found = _worst(case, outcome, true, way)
    tolerance, longest = oracle_tolerance(case), 3.0 * longest
    nudge = _NUDGE * np.random.default_rng(1).uniform(-1.0, 1.0, 1000)
    try:
        tight = Oracle(case, rtol=0.03 * tolerance, longest=longest, lag=_LESS_LAG * LAG).run()
        nudged = Oracle(case, rtol=tolerance, longest=longest, nudge=nudge).run()
    except (GaveUpError, NoRestError) as error:
        return Verdict("undecided", f"{found}; oracle again: {error}", found.off)
    found = _worst(case, outcome, tight, way)
    if found.off <= TIMES * case.rtol:
        return Verdict("ok", str(found), found.off)
    own, moved = _worst(case, true, tight, way).off, _worst(case, nudged, true, way).off
    details = {"oracle moves by": f"{own:.2g} (tighter), {moved:.2g} (nudged)"}
    second = _newmark(case, 0.1 * found.off)
    its = 0.0 if second is None else from_newmark(case, tight, second)
    if second is not None:
        ours = from_newmark(case, outcome, second)
        details["newmark"] = f"{ours:.2g} from the answer, {its:.2g} from the oracle"
    if moved > _SHARE * found.off:
        return Verdict("chaotic", str(found), found.off, details)
    # The oracle counts only if it has converged and Newmark's rule does not contradict it.
    sure = own <= _SHARE * found.off and its <= 0.5 * found.off
    return Verdict("wrong" if sure else "undecided", str(found), found.off, details)


def trial(options: Namespace, folder: Path) -> Trial:
    """Return the function that judges the scene of a number and leaves its script in the folder."""

    def one(number: int) -> Verdict:
        case = case_of(number)
        (folder / "scene.py").write_text(case.script())
        return judge(case, way=options.way)

    return one
