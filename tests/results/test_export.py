"""Histories for pandas and xarray: the same numbers, under their names, with units."""

from __future__ import annotations

import sys
from typing import Any

import numpy as np
import pytest
from records import HalfSine

import aoimpact as ao
from aoimpact.base import MissingPackageError
from aoimpact.results import Run


def scene() -> Run:
    scene = ao.Scene()
    first = scene.add(ao.rigid(mass=0.1), velocity=1.0)
    second = scene.add(ao.rigid(mass=0.2))
    third = scene.add(ao.AOModel(m0=0.1, k0=1e5))
    scene.connect(first, second, ao.Hertz(1e9), name="front")
    scene.connect(second, third, ao.Hertz(1e9), gap=1e-5, name="back")
    return scene.simulate(duration=1e-3)


def test_the_dataframe_is_the_csv_file(tmp_path: Any) -> None:
    pandas = pytest.importorskip("pandas")
    hit = HalfSine().result()
    hit.to_csv(tmp_path / "hit.csv")
    frame = hit.to_dataframe().reset_index()
    assert isinstance(frame, pandas.DataFrame)
    head = (tmp_path / "hit.csv").read_text(encoding="utf-8").partition("\n")[0]
    assert list(frame.columns) == head.split(",")
    np.testing.assert_array_equal(
        frame, np.loadtxt(tmp_path / "hit.csv", delimiter=",", skiprows=1)
    )


def test_a_scene_has_contacts_and_bodies_by_name() -> None:
    pytest.importorskip("xarray")
    run = scene()
    data = run.to_xarray()
    assert data.velocity.dims == ("body", "time")
    units = {name: data[name].attrs["units"] for name in ("time", "force", "velocity")}
    assert units == {"time": "s", "force": "N", "velocity": "m/s"}
    for contact in run.contacts:
        np.testing.assert_array_equal(data.force.sel(contact=contact.name), contact.force)
    last = data.displacement.sel(body=run.names[2])
    np.testing.assert_array_equal(last, run.bodies[2].displacement)
    bodies = data.kinetic_energy.sum("body") + data.elastic_energy.sum("body")
    total = bodies + data.contact_energy + data.dissipated_energy
    np.testing.assert_allclose(total, data.total_energy, rtol=1e-12)


@pytest.mark.parametrize(("package", "method"), [("pandas", "frame"), ("xarray", "xarray")])
def test_a_missing_package_is_named(
    package: str, method: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, package, None)
    call = {"frame": HalfSine().result().to_dataframe, "xarray": HalfSine().result().to_xarray}
    with pytest.raises(MissingPackageError, match=package):
        call[method]()
