"""What ways are compared by."""

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
    accelerations: FloatArray = field(default_factory=lambda: np.zeros(0))
    force_at: Callable[[int, float], float] | None = None
    fastest: float = 0.0
