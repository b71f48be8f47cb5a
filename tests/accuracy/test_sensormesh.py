"""What a mesh makes wrong in a sensor, said beside what a mesh three times as fine shows."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import aoimpact as ao

STEEL = ao.Material(E=210e9, nu=0.3, rho=7800)
ALUMINIUM = ao.Material(E=70e9, nu=0.33, rho=2700)

pytestmark = [
    pytest.mark.filterwarnings("ignore:.*elements of first order"),
    pytest.mark.filterwarnings("ignore:.*the mesh makes an error"),
    pytest.mark.filterwarnings("ignore:.*may be off by"),
    pytest.mark.filterwarnings("ignore:.*elements at the contact are"),
]


def rod(finer: int) -> ao.FEModel:
    mesh = ao.box_mesh((0.3, 0.012, 0.012), (25 * finer, finer, finer), kind="hexahedron")
    return ao.FEModel.from_mesh(mesh, STEEL, fixed=[("xmin", "xyz")])


def sheet() -> ao.FEModel:
    mesh = ao.sheet_mesh((0.2, 0.15), (10, 8))
    ends = [("xmin", "xyz", "xyz"), ("xmax", "xyz", "xyz")]
    return ao.FEModel.from_mesh(mesh, ao.Shell(0.003, ALUMINIUM), fixed=ends)


@pytest.mark.slow
def test_the_error_said_is_one_to_five_times_the_true_one() -> None:
    """And at least half of the largest value where the motion has no relation to the right one."""
    at, length, found = (0.156, 0.0, 0.0), 3e-4, []
    for finer in (1, 3):
        body = rod(finer)
        tip = body.contact(point=(0.3, 0.006, 0.006), direction=(-1.0, 0.0, 0.0), radius=2e-3)
        given: Any = {"law": ao.Linear(5e6), "duration": length, "rtol": 1e-2}
        given["quantity"] = ao.StrainAt(body, at, "xx")
        hit = ao.simulate(ao.rigid(mass=0.02), tip, 1.0, **given)
        strain = hit.target.probe(at, times=np.linspace(0.0, length, 1000)).strain["xx"]
        found.append((hit.error.mesh, strain))
    (said, ours), (_, right) = found
    true = np.nanmax(np.abs(ours - right)) / np.nanmax(np.abs(right))
    assert min(true, 0.5) < said < 5.0 * true


def test_where_nothing_is_known_of_the_mesh_the_error_is_not_0() -> None:
    body = sheet()
    alone = ao.FEModel(K=body.K, M=body.M, nodes=body.nodes, free=body.free)
    middle = int(np.abs(body.nodes - (0.1, 0.075, 0.0)).sum(axis=1).argmin())
    tip = alone.contact(node=middle, direction=(0, 0, -1))
    hit = ao.simulate(
        ao.rigid(mass=0.02), tip, 1.0, law=ao.Linear(5e6), duration=3e-4, quantity=tip, rtol=5e-2
    )
    assert hit.error.mesh is None
    assert math.isnan(hit.error.total)
    assert "not known" in str(hit)
