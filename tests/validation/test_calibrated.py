"""Estimated errors of default impacts, against the truths of docs/calibration.csv.

The truths are of graded meshes of tetrahedra; tools/calibration.py made them. These are a few of
the setups, with meshes that need no gmsh.
"""

from __future__ import annotations

import csv
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import aoimpact as ao

pytestmark = [pytest.mark.slow, pytest.mark.filterwarnings("ignore:target")]  # coarse meshes

STEEL = ao.Material(E=210e9, nu=0.3, rho=7800)
ALU = ao.Material(E=70e9, nu=0.33, rho=2700)

ENDS = [("xmin", "xyz"), ("xmax", "xyz")]

# Lengths, material, supports, place, radius of the rigid ball and speed.
SETUPS: dict[str, tuple[Any, ...]] = {
    "clamped plate, off centre": (
        *((0.1, 0.08, 0.006), ALU, ENDS, (0.03, 0.02, 0.006)),
        *(0.005, 2.0),
    ),
    "thin plate, near its edge": (
        *((0.12, 0.12, 0.0025), STEEL, None, (0.012, 0.06, 0.0025)),
        *(0.005, 1.0),
    ),
    "block, near its edge": (
        *((0.04, 0.04, 0.03), STEEL, None, (0.007, 0.02, 0.03)),
        *(0.005, 2.0),
    ),
    "cantilever": ((0.15, 0.015, 0.01), ALU, ENDS[:1], (0.14, 0.0075, 0.01), 0.005, 0.5),
}

# Kind and number of elements along the longest side.
MESHES = (
    *(("hexahedron", 20), ("hexahedron", 36), ("hexahedron20", 16)),
    *(("tetra10", 14), ("tetra", 24)),
)


def truth(name: str) -> float:
    """The peak force, N."""
    page = Path(__file__).parents[2] / "docs" / "calibration.csv"
    with page.open() as file:
        return next(float(row["truth"]) for row in csv.DictReader(file) if row["body"] == name)


def strike(name: str, kind: str, along: int) -> ao.Result:
    lengths, material, fixed, point, radius, velocity = SETUPS[name]
    size = max(lengths) / along
    divisions = tuple(max(1, round(length / size)) for length in lengths)
    body = ao.FEModel.from_mesh(ao.box_mesh(lengths, divisions, kind=kind), material, fixed=fixed)
    return ao.simulate(ao.ball(radius, STEEL), body.contact(point=point), velocity)


def test_true_errors_of_peak_forces_are_within_their_estimates() -> None:
    ratios = []
    for name in SETUPS:
        right = truth(name)
        for kind, along in MESHES:
            hit = strike(name, kind, along)
            estimate = hit.error["peak_force"].total
            ratios.append(estimate / abs(hit.peak_force / right - 1.0))
    found = np.array(ratios)
    print(found.reshape(len(SETUPS), -1).round(2))
    assert (found > 1.0).mean() >= 0.95
    assert np.median(found) < 4.0
