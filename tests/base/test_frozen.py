"""Arrays of models, bodies and tables cannot be written to, nor can those of their copies."""

from __future__ import annotations

import copy
import pickle
from collections.abc import Iterator
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from rows import each

import aoimpact as ao
from aoimpact.batch import SweepTable

STEEL = ao.Material(E=210e9, nu=0.3, rho=7800)


def body() -> ao.FEModel:
    mesh = ao.box_mesh((0.04, 0.02, 0.02), (4, 2, 2))
    return ao.FEModel.from_mesh(mesh, STEEL, fixed=[("xmin", "xyz")])


def tip(along: float = 0.04) -> ao.ContactPoint:
    return body().contact(point=(along, 0.01, 0.02), direction=(0, 0, -1), radius=0)


def table() -> SweepTable:
    case = {"projectile": ao.rigid(mass=0.03), "target": ao.rigid(mass=0.05), "duration": 1e-4}
    return ao.sweep(case | {"law": ao.Hertz(k=1e10)}, {"velocity": [0.5, 1.0]}, keep="peak_force")


MADE = {
    "star": lambda: ao.AOModel(m0=0.1, m=[1.0, 2.0], k=[1e6, 1e7]),
    "oscillators": lambda: ao.antioscillators(tip(), 3),
    "body": body,
    "mesh": lambda: body().mesh,
    "contact": tip,
    "interface": lambda: ao.interface([tip()], 4, contact_time=1e-4),
    "sweep": table,
}


def arrays(model: Any) -> Iterator[npt.NDArray[Any]]:
    """Those of a model itself, also of its mappings."""
    for value in vars(model).values():
        yield from (
            item
            for item in (value.values() if isinstance(value, dict) else [value])
            if isinstance(item, np.ndarray)
        )


@each("name", MADE)
@each("again", [lambda m: m, copy.deepcopy, lambda m: pickle.loads(pickle.dumps(m))])
def test_arrays_are_read_only(name: str, again: Any) -> None:
    model = MADE[name]()
    found, wanted = list(arrays(again(model))), list(arrays(model))
    assert len(found) == len(wanted) > 0
    for here, there in zip(found, wanted, strict=True):
        np.testing.assert_array_equal(here, there)
        with pytest.raises(ValueError, match="read-only"):
            here[...] = there


def test_the_caller_s_arrays_stay_writable() -> None:
    m, k, point, direction = (
        np.ones(2),
        np.ones(2),
        np.array([0.04, 0.01, 0.02]),
        np.array([0, 0, -1.0]),
    )
    ao.AOModel(m0=0.1, m=m, k=k)
    body().contact(point=point, direction=direction, radius=0)
    nodes, cells = np.array(body().nodes), np.array(body().mesh.cells)
    ao.Mesh(nodes, cells, "hexahedron")
    assert all(array.flags.writeable for array in (m, k, point, direction, nodes, cells))
