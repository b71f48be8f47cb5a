"""What a run of the campaign found: counts by class, and the failures."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable

from .generate import case_of
from .judge import CLASSES, Verdict


def _reason(message: str) -> str:
    """A message without its numbers, to count messages by."""
    return re.sub(r"[-+]?\d[\d.e+-]*", "#", message)[:110]


def counts(found: dict[int, Verdict]) -> str:
    """Return the table of classes: all scenes, and those with two contacts or more on a body."""
    total = max(len(found), 1)
    cases = {seed: case_of(seed) for seed in found}
    groups = {
        "all": list(found),
        "crowded": [seed for seed in found if cases[seed].crowded],
        "crowded, m0 = 0": [seed for seed in found if cases[seed].crowded_massless],
    }
    lines = [f"{'':18}{'scenes':>8}" + "".join(f"{kind:>11}" for kind in CLASSES)]
    for name, seeds in groups.items():
        count = Counter(found[seed].kind for seed in seeds)
        lines.append(f"{name:18}{len(seeds):8}" + "".join(f"{count[kind]:11}" for kind in CLASSES))
    share = Counter(verdict.kind for verdict in found.values())
    lines.append(
        "share of all, %   " + " " * 8 + "".join(f"{100 * share[k] / total:11.2f}" for k in CLASSES)
    )
    return "\n".join(lines)


def table(found: dict[int, Verdict], kinds: Iterable[str]) -> str:
    """Return a line for each scene of these classes."""
    lines = []
    for seed in sorted(found):
        verdict = found[seed]
        if verdict.kind in kinds:
            case = case_of(seed)
            what = f"{verdict.kind:9} {case.family:8} rtol {case.rtol:.1e}"
            lines.append(f"{seed:7} {what} {verdict.why[:200]}")
            lines += [f"{'':18}{name}: {text}" for name, text in verdict.details.items()]
    return "\n".join(lines)


def reasons(found: dict[int, Verdict]) -> str:
    """Return why scenes were refused, with how often and the first seeds."""
    seeds: dict[str, list[int]] = {}
    for seed, verdict in sorted(found.items()):
        if verdict.kind in ("refused", "helpless", "bare", "hangs"):
            seeds.setdefault(f"{verdict.kind}: {_reason(verdict.why)}", []).append(seed)
    ordered = sorted(seeds.items(), key=lambda one: -len(one[1]))
    return "\n".join(f"{len(of):5} {text} e.g. {of[:5]}" for text, of in ordered)
