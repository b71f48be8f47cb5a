"""Types of arrays, and arrays that cannot be written to."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]


def read_only(array: FloatArray) -> FloatArray:
    """Return an array after making it read-only."""
    array.flags.writeable = False
    return array
