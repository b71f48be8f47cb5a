"""Claims of a few impacts against the truths of docs/calibration-truths.csv.

tools/calibration.py made the truths, by much finer meshes, and compares many more impacts. These
need no gmsh.
"""

from __future__ import annotations

import sys
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).parents[2] / "tools"))

from calibration import compared, known, setups

pytestmark = pytest.mark.slow

BODIES = (
    *("clamped plate, off centre", "thin plate, near its edge", "block, near its edge"),
    *("cantilever", "corner"),
)


@cache
def impacts() -> list[dict[str, Any]]:
    """Of bricks of first and second order, and of other kinds where bricks are cut into them."""
    return [
        compared(setup, kind, sizes)
        for setup in setups()
        for kind, sizes in setup.tests()
        if setup.name in BODIES and (setup.sizes or not kind.startswith("tetra"))
    ]


def test_true_errors_are_within_their_claims() -> None:
    rows, own = impacts(), known("own_error")
    true, claim = (np.array([row[f"peak_force_{of}"] for row in rows]) for of in ("error", "claim"))
    told = np.isfinite(claim)
    assert told.mean() > 0.9
    truths = np.array([own[row["body"], "peak_force"] for row in rows])
    assert (true <= claim + truths)[told].mean() >= 0.95
    large = told & (true > 1e-3)
    assert np.median(claim[large] / true[large]) < 4.0
