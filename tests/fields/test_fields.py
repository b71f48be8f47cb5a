"""Fields at chosen times: the stress they have, the files they write, the pictures they draw."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace

import matplotlib as mpl
import meshio
import numpy as np
import pytest

import aoimpact as ao
from aoimpact.fields import Field

mpl.use("Agg")

STEEL = ao.Material(E=200e9, nu=0.25, rho=7800)
TIMES = np.array([0.0, 1e-5, 2e-5])
# A bar stretched along x, twice as much at each time: σxx = E ε, freely thinning.
STRAIN = 1e-4 * np.array([0.0, 1.0, 2.0])


def stretched(*, held: bool = False) -> Field:
    mesh = ao.box_mesh((2.0, 1.0, 1.0), (2, 1, 1), kind="tetra10")
    body = ao.FEModel.from_mesh(mesh, STEEL, fixed=[("xmin", "x")] if held else None)
    shape = mesh.nodes * [1.0, -STEEL.nu, -STEEL.nu]
    displacement = STRAIN[:, None, None] * shape
    still = np.zeros_like(displacement)
    dofs = np.hstack([displacement, still]).reshape(3, -1)
    response = SimpleNamespace(
        body=body,
        half_space=lambda x, times, rates: (0.0, 0.0, np.zeros((3, len(x), 6))),
        field_error=lambda times: None,
    )
    return Field(body, TIMES, displacement, displacement / 1e-5, still, response, dofs)


def test_files_hold_the_field(tmp_path: Path) -> None:
    field = stretched()
    listing = field.to_vtu(tmp_path / "bar.pvd")
    assert listing == tmp_path / "bar.pvd"
    stress = field.stress()
    for i in range(3):
        read = meshio.read(tmp_path / f"bar_{i}.vtu").point_data
        for name, values in (
            ("displacement", field.displacement),
            ("velocity", field.velocity),
            ("stress", stress.components),
            ("von_mises", stress.von_mises),
            ("principal", stress.principal),
        ):
            np.testing.assert_array_equal(read[name], values[i])


def test_nonsense_is_refused() -> None:
    field = stretched()
    with pytest.raises(ao.InputError, match=r"^at"):
        field.stress("node")
    with pytest.raises(ao.InputError, match=r"^which"):
        field.plot(which=3)
    with pytest.raises(ao.InputError, match="scale"):
        field.plot(scale=-1.0)
    assert "t = 0, 1e-05, 2e-05 s of FEModel(" in repr(field)
