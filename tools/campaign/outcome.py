"""Outcomes by which solutions are compared, and verdicts on scenes, decks and inputs."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

FloatArray = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Touch:
    """A contact from `start` to `end`, s, with its impulse, N s.

    `pace`: initial rate times duration over `deep`. `deep`: largest indentation, m. `apart`:
    largest distance of the bodies after the contact, m.
    """

    start: float
    end: float
    impulse: float = np.nan
    pace: float = np.nan
    deep: float = np.nan
    apart: float = np.nan


@dataclass(frozen=True)
class Outcome:
    """Peak force, its time, impulse and touches of each contact; final motion of each body.

    The motion is velocity and acceleration of the centre of mass at the end of the record.
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
    """Verdict on a scene, a deck or an input.

    `kind`: "ok", "warned", "named" (refused by name) and "none" pass. "refused" (with a cure that
    works), "apart" (Newmark's rule is far from answer and oracle, which agree), "chaotic" and
    "undecided" are no failures. All others fail. `why`: the worst quantity, or the message. `off`:
    the largest relative error.
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


Trial = Callable[[int], Verdict]  # number ↦ verdict
