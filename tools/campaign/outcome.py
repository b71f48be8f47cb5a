"""What ways are compared by, and the verdict on what was drawn."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

FloatArray = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Touch:
    """A contact from start to end, s. impulse, N s; pace: rate at the start times the length over
    the depth.

    deep: its largest indentation, m. apart: by how far the bodies part after it, m.
    """

    start: float
    end: float
    impulse: float = np.nan
    pace: float = np.nan
    deep: float = np.nan
    apart: float = np.nan


@dataclass(frozen=True)
class Outcome:
    """Of each contact its peak force and time, impulse and touches; of each body the velocity of
    its centre of mass at the end of the record, and the acceleration then.
    """

    peaks: FloatArray
    peak_times: FloatArray
    impulses: FloatArray
    touches: tuple[tuple[Touch, ...], ...]
    velocities: FloatArray
    accelerations: FloatArray | tuple[()] = ()
    force_at: Callable[[int, float], float] | None = None


@dataclass(frozen=True)
class Verdict:
    """What came of a scene, a deck or an input.

    kind: "ok", "warned" or "named" (refused by name) pass. "refused" (with a cure that works),
    "apart" (Newmark's rule is far from answer and oracle, which agree), "chaotic", "undecided" and
    "none" are no failures. All others fail. why: what was off, or the message. off: the largest
    relative error.
    """

    kind: str
    why: str = ""
    off: float = 0.0
    details: dict[str, str] = field(default_factory=dict)

    @property
    def passed(self) -> bool:
        return self.kind in ("ok", "warned", "named", "none")

    @property
    def failed(self) -> bool:
        return not self.passed and self.kind not in ("refused", "apart", "chaotic", "undecided")

    def __str__(self) -> str:
        told = [f"{self.kind:9} {self.why[:400]}"]
        return "\n".join(told + [f"{'':18}{name}: {of}" for name, of in self.details.items()])


Trial = Callable[[int], Verdict]  # of a number
