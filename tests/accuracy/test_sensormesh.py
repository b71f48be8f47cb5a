"""What a mesh makes wrong in a sensor, said beside what a mesh three times as fine shows."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import aoimpact as ao

STEEL = ao.Material(E=210e9, nu=0.3, rho=7800)
ALUMINIUM = ao.Material(E=70e9, nu=0.33, rho=2700)
UP = (0.0, 0.0, 1.0)
LAWS: dict[str, Any] = {
    "Hertz": None,
    "Linear": ao.Linear(5e6),
}

pytestmark = [
    pytest.mark.filterwarnings("ignore:.*elements of first order"),
    pytest.mark.filterwarnings("ignore:.*the mesh makes an error"),
    pytest.mark.filterwarnings("ignore:.*may be off by"),
    pytest.mark.filterwarnings("ignore:.*elements at the contact are"),
]


def solid(
    size: tuple[float, ...], n: tuple[int, int, int], kind: str, material: ao.Material
) -> Callable[[int], ao.FEModel]:
    def body(finer: int) -> ao.FEModel:
        mesh = ao.box_mesh(size, (finer * n[0], finer * n[1], finer * n[2]), kind=kind)
        return ao.FEModel.from_mesh(mesh, material, fixed=[("xmin", "xyz")])

    return body


def sheet(finer: int) -> ao.FEModel:
    mesh = ao.sheet_mesh((0.2, 0.15), (10 * finer, 8 * finer))
    ends = [("xmin", "xyz", "xyz"), ("xmax", "xyz", "xyz")]
    return ao.FEModel.from_mesh(mesh, ao.Shell(0.003, ALUMINIUM), fixed=ends)


# The body, where it is struck and where the sensors are, and the records' length, s.
BODIES: dict[str, tuple[Callable[[int], ao.FEModel], Any, Any, float]] = {
    "rod": (
        solid((0.3, 0.012, 0.012), (25, 1, 1), "hexahedron", STEEL),
        (0.3, 0.006, 0.006),
        (0.156, 0.0, 0.0),
        3e-4,
    ),
}


def sensors(body: ao.FEModel, name: str) -> dict[str, tuple[Any, Callable[[Any, Any], Any], float]]:
    """Quantities, how each is read of a result, and the share of the record."""
    _, _, at, _ = BODIES[name]
    layer = {"layer": "top"} if name == "sheet" else {}
    axis = (1.0, 0.0, 0.0) if name == "rod" else UP

    def acceleration(hit: Any, t: Any) -> Any:
        return hit.target.probe(at, axis, times=t).filtered(cfc=1000).acceleration

    return {
        "acceleration": (ao.AccelerationAt(at, axis, cfc=1000, body=body), acceleration, 2e-3),
        "strain": (
            ao.StrainAt(body, at, "xx", **layer),
            lambda hit, t: hit.target.probe(at, times=t, **layer).strain["xx"],
            0.0,
        ),
        "reaction": (
            ao.ReactionAt("xmin", axis, body=body),
            lambda hit, t: hit.target.reaction("xmin", times=t).force @ np.array(axis),
            0.0,
        ),
    }


def said_and_true(name: str, law: str, sensor: str) -> tuple[float, float]:
    make, point, _, length = BODIES[name]
    found = []
    for finer in (1, 3):
        body = make(finer)
        along = (-1.0, 0.0, 0.0) if name == "rod" else (0.0, 0.0, -1.0)
        node = {} if LAWS[law] is None else {"radius": 2e-3}
        tip = body.contact(point=point, direction=along, **node)
        quantity, read, more = sensors(body, name)[sensor]
        ball = ao.ball(0.008, STEEL) if LAWS[law] is None else ao.rigid(mass=0.02)
        given = {"law": LAWS[law], "duration": length + more, "quantity": quantity, "rtol": 1e-2}
        hit = ao.simulate(ball, tip, 1.0, **given)
        times = np.linspace(0.0, length + more, 1000)
        found.append((hit, read(hit, times)))
    (hit, ours), (_, right) = found
    assert hit.error.mesh is not None
    return hit.error.mesh, float(np.nanmax(np.abs(ours - right)) / np.nanmax(np.abs(right)))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("body", "law", "sensor"),
    [
        ("rod", "Linear", "strain"),
    ],
)
def test_the_error_said_is_one_to_five_times_the_true_one(body: str, law: str, sensor: str) -> None:
    """And at least half of the largest value where the motion has no relation to the right one."""
    said, true = said_and_true(body, law, sensor)
    assert min(true, 0.5) < said < 5.0 * true


def test_where_nothing_is_known_of_the_mesh_the_error_is_not_0() -> None:
    body = sheet(1)
    alone = ao.FEModel(K=body.K, M=body.M, nodes=body.nodes, free=body.free)
    middle = int(np.abs(body.nodes - (0.1, 0.075, 0.0)).sum(axis=1).argmin())
    tip = alone.contact(node=middle, direction=(0, 0, -1))
    hit = ao.simulate(
        ao.rigid(mass=0.02), tip, 1.0, law=ao.Linear(5e6), duration=3e-4, quantity=tip, rtol=5e-2
    )
    assert hit.error.mesh is None
    assert math.isnan(hit.error.total)
    assert "not known" in str(hit)
