"""Sweeps: every combination once, in order, and a table that says what failed."""

from __future__ import annotations

import csv
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import aoimpact as ao
from aoimpact.base import MemoryLimitError, SceneFileError

from scenes import BAR

BASE = {
    "projectile": ao.rigid(mass=0.03),
    "target": ao.rigid(mass=math.inf),
    "law": ao.Hertz(k=1e10),
    "velocity": 1.0,
    "duration": 1e-3,
}


def drop(height: float, mass: float) -> dict[str, Any]:
    """A ball that falls on a floor."""
    return BASE | {
        "projectile": ao.rigid(mass=mass),
        "velocity": math.sqrt(2.0 * 9.81 * height),
    }


def test_hertz_s_law_of_the_drop_height() -> None:
    """Peak (5/4 m v²)^(3/5) k^(2/5): K. L. Johnson, eq. (11.22), by F = k δ^(3/2)."""
    table = ao.sweep(drop, {"height": [0.1, 0.4, 1.6], "mass": [0.01, 0.02]})
    speed2 = 2.0 * 9.81 * table["height"]
    expected = (1.25 * table["mass"] * speed2) ** 0.6 * 1e10**0.4
    np.testing.assert_allclose(table["peak_force"], expected, rtol=1e-7)
    momentum = 2.0 * table["mass"] * np.sqrt(speed2)
    np.testing.assert_allclose(table["impulse"], momentum, rtol=1e-7)


def test_the_last_parameter_varies_fastest() -> None:
    table = ao.sweep(drop, {"height": [1.0, 2.0, 3.0], "mass": [0.01, 0.02]}, keep="impulse")
    assert table.shape == (3, 2)
    assert len(table) == 6
    assert table["mass"].tolist() == [0.01, 0.02] * 3
    assert table["height"].reshape(table.shape)[:, 0].tolist() == [1.0, 2.0, 3.0]
    assert table.columns == ("height", "mass", "impulse")
    assert table.data.dtype.names == table.columns
    assert not table.data.flags.writeable


def test_any_keyword_of_simulate_is_a_parameter() -> None:
    laws = [ao.Hertz(k=1e10), ao.Linear(k=1e7)]
    table = ao.sweep(BASE, {"law": laws, "gap": [0, 1e-6]}, workers=2)
    assert table["law"].tolist() == [laws[0], laws[0], laws[1], laws[1]]
    assert table["gap"].dtype.kind in "if"
    # A linear spring's half swing: π √(m/k).
    swing = math.pi * math.sqrt(0.03 / 1e7)
    assert table["contact_duration"][2] == pytest.approx(swing, rel=1e-7)


def test_a_scene_file_s_places_are_parameters(tmp_path: Path) -> None:
    path = tmp_path / "bar.toml"
    path.write_text(BAR, encoding="utf-8")
    grid = {"impact.velocity": [0.5, 1.0], "bodies.bar.model.n": np.array([1, 3])}
    table = ao.sweep(path, grid, keep=("peak_force", "restitution"))
    alone = ao.read_scene(path).replaced({"impact.velocity": 0.5, "bodies.bar.model.n": 3})
    assert table["peak_force"][1] == alone.simulate().peak_force
    assert table["bodies.bar.model.n"].dtype.kind == "i"


@pytest.mark.parametrize(
    ("grid", "text"),
    [
        ({"impact.velocty": [1.0]}, "velocty"),
        ({"impct.velocity": [1.0]}, "impct"),
        ({"impact.velocity": ["fast"]}, "number"),
    ],
)
def test_a_scene_file_knows_its_places(grid: Any, text: str, tmp_path: Path) -> None:
    path = tmp_path / "bar.toml"
    path.write_text(BAR, encoding="utf-8")
    with pytest.raises(SceneFileError, match=text):
        ao.sweep(path, grid)


def test_a_scene_is_given_what_its_run_takes() -> None:
    scene = ao.Scene()
    ball = scene.add(ao.rigid(mass=0.03), velocity=1.0)
    scene.connect(ball, scene.add(ao.rigid(mass=math.inf)), ao.Hertz(k=1e10), gap=1e-3)
    grid = {"duration": [0.5e-3, 2e-3], "solver": [ao.Adaptive(), ao.Adaptive(rtol=1e-5)]}
    with pytest.warns(ao.AOImpactWarning, match=r"^case"):
        table = ao.sweep(scene, grid, keep="contacts.0.peak_force")
    assert table["contacts.0.peak_force"][:2].tolist() == [0.0, 0.0]
    assert table["contacts.0.peak_force"][2] == pytest.approx((1.25 * 0.03) ** 0.6 * 1e10**0.4)
    with pytest.raises(ao.InputTypeError, match=r"^grid"):
        ao.sweep(scene, {"duratio": [1.0]})
    whole = ao.sweep(scene, {"energies": [False, True]}, keep="contacts.0.impulse")
    np.testing.assert_allclose(whole["contacts.0.impulse"], 2.0 * 0.03, rtol=1e-6)


def test_a_function_names_its_own_columns() -> None:
    def keep(result: ao.Result) -> dict[str, float]:
        return {"ratio": result.peak_force / result.impulse, "contacts": len(result.contacts)}

    table = ao.sweep(BASE, {"velocity": [1.0, 2.0]}, keep=keep)
    assert table.quantities == ("ratio", "contacts")
    assert table["contacts"].tolist() == [1.0, 1.0]
    one = ao.sweep(BASE, {"velocity": [1.0]}, keep=lambda result: result.impulse)
    assert one["value"][0] == pytest.approx(0.06)


def test_a_failed_case_is_a_row_of_nan() -> None:
    table = ao.sweep(BASE, {"velocity": [1.0, 0.0, 2.0]})
    assert np.isnan(table["peak_force"]).tolist() == [False, True, False]
    assert list(table.errors) == [1]
    assert "velocity is 0" in str(table.errors[1])
    assert "3 cases, 1 failed; row 1: velocity is 0" in repr(table)
    fails = ao.sweep(drop, {"height": [-1.0], "mass": [1.0]})
    assert isinstance(fails.errors[0], ValueError)
    assert np.isnan(fails["peak_force"]).all()


def test_csv_reads_back_bit_for_bit(tmp_path: Path) -> None:
    table = ao.sweep(BASE, {"velocity": [0.1, 0.0, 0.3]})
    table.to_csv(tmp_path / "sweep.csv")
    with open(tmp_path / "sweep.csv", newline="", encoding="utf-8") as file:
        head, *rows = csv.reader(file)
    assert head[:3] == ["velocity", "peak_force [N]", "peak_time [s]"]
    assert head[-1] == "error"
    for name, column in zip(table.columns, zip(*rows, strict=True), strict=False):
        np.testing.assert_array_equal(np.array(column, float), table[name])
    assert "velocity is 0" in rows[1][-1]


def test_data_frames() -> None:
    pandas = pytest.importorskip("pandas")
    table = ao.sweep(BASE, {"velocity": [1.0, 0.0], "law": [ao.Hertz(k=1e10)]})
    frame = table.to_pandas()
    assert isinstance(frame, pandas.DataFrame)
    assert list(frame.columns) == [*table.columns, "error"]
    assert frame["peak_force"][0] == table["peak_force"][0]
    assert frame["law"][0] == ao.Hertz(k=1e10)


def test_arrays_over_the_parameters() -> None:
    """Johnson's power of the mass along one dimension of the other."""
    pytest.importorskip("xarray")
    table = ao.sweep(drop, {"height": [0.1, 0.4, -1.0], "mass": [0.01, 0.02]})
    data = table.to_xarray()
    assert data["peak_force"].dims == ("height", "mass")
    assert data["peak_force"].attrs["units"] == "N"
    ratio = data["peak_force"].sel(mass=0.02) / data["peak_force"].sel(mass=0.01)
    np.testing.assert_allclose(ratio.sel(height=[0.1, 0.4]), 2.0**0.6, rtol=1e-7)
    assert data["error"].values[2, 0]
    assert not data["error"].values[1, 1]


def test_a_sweep_over_vectors(tmp_path: Path) -> None:
    """Without friction the tangential velocity stays, and so does the spin."""
    wall = ao.wall(ao.Material(E=70e9, nu=0.33, rho=2700.0))
    ball = ao.ball(0.01, ao.Material(E=210e9, nu=0.3, rho=7800.0))
    case = {"projectile": ball, "target": wall, "spin": (0.0, 5.0, 3.0), "friction": 0.0}
    keep = ["peak_force", "bodies.0.final_spin.1", "bodies.0.final_velocity.0"]
    velocities = [[0.3, 0.0, -1.0], [0.5, 0.0, -1.0]]
    table = ao.sweep(case, {"gap": [0.0, 1e-4], "velocity": velocities}, keep=keep)
    np.testing.assert_allclose(table["bodies.0.final_spin.1"], 5.0)
    np.testing.assert_allclose(table["bodies.0.final_velocity.0"], [0.3, 0.5, 0.3, 0.5])
    table.to_csv(tmp_path / "sweep.csv")
    heading = (tmp_path / "sweep.csv").read_text().splitlines()[0]
    units = "peak_force [N],bodies.0.final_spin.1 [rad/s],bodies.0.final_velocity.0 [m/s]"
    assert heading == f"gap,velocity,{units}"


def test_a_table_that_memory_cannot_hold_is_refused_at_once() -> None:
    many = [1.0] * 1_000_000
    with pytest.raises(MemoryLimitError, match="cases"):
        ao.sweep(BASE, {"velocity": many, "duration": many})


def test_an_unknown_column_is_refused() -> None:
    with pytest.raises(ao.InputError, match="column"):
        ao.sweep(BASE, {"velocity": [1.0]})["forc"]


def test_places_are_columns_that_can_be_read():
    mesh = ao.box_mesh((0.1, 0.02, 0.02), (5, 1, 1))
    alu = ao.Material(E=70e9, nu=0.3, rho=2700)
    bar = ao.FEModel.from_mesh(mesh, alu, fixed=[("xmin", "xyz")], name="bar")
    places = [
        bar.contact(point=(x, 0.02, 0.02), direction=(0, 0, -1), radius=0) for x in (0.06, 0.1)
    ]
    base = {"projectile": ao.rigid(mass=0.01), "law": ao.Hertz(k=1e8), "velocity": 0.1}
    table = ao.sweep(base, {"target": places}, keep="peak_force")
    assert "bar at (0.06, 0.02, 0.02) m" in repr(table)
    assert "ContactPoint" not in repr(table)
