"""Files for ParaView: what meshio reads back is what was there, to the last bit."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from pathlib import Path

import meshio
import numpy as np
import pytest
from bodies import distorted_box

import aoimpact as ao
from aoimpact.fields import write_series
from aoimpact.mesh import KINDS


@pytest.mark.parametrize("kind", KINDS)
def test_numbers_come_back_as_they_were(kind: str, tmp_path: Path) -> None:
    mesh = distorted_box(kind)
    rng = np.random.default_rng(0)
    data = {
        "displacement": rng.standard_normal((2, mesh.n_nodes, 3)),
        "stress": rng.standard_normal((2, mesh.n_nodes, 6)),
        "von_mises": rng.standard_normal((2, mesh.n_nodes)),
    }
    write_series(tmp_path / "box", mesh, np.array([0.0, 1e-5]), data)
    for i in range(2):
        read = meshio.read(tmp_path / f"box_{i}.vtu")
        np.testing.assert_array_equal(read.points, mesh.nodes)
        (cells,) = read.cells
        assert cells.type == kind
        np.testing.assert_array_equal(cells.data, mesh.cells)
        assert set(read.point_data) == set(data)
        for name, values in data.items():
            np.testing.assert_array_equal(read.point_data[name], values[i])


@pytest.mark.parametrize("name", ["beam", "beam.vtu", "beam.pvd", "beam.v2"])
def test_the_collection_lists_every_file_with_its_time(name: str, tmp_path: Path) -> None:
    times = np.linspace(0.0, 1.0, 11) / 3.0
    mesh = ao.box_mesh((1.0, 1.0, 1.0), (1, 1, 1))
    listing = write_series(tmp_path / name, mesh, times, {"x": np.zeros((11, 8))})
    stem = "beam.v2" if name == "beam.v2" else "beam"
    assert listing == tmp_path / f"{stem}.pvd"
    root = ET.parse(listing).getroot()
    assert (root.tag, root.get("type")) == ("VTKFile", "Collection")
    entries = root.findall("Collection/DataSet")
    assert [float(entry.get("timestep", "")) for entry in entries] == list(times)
    files = [entry.get("file", "") for entry in entries]
    assert files == [f"{stem}_{i:02d}.vtu" for i in range(11)]
    assert sorted(path.name for path in tmp_path.glob("*.vtu")) == files


def test_a_missing_folder_is_named(tmp_path: Path) -> None:
    mesh = ao.box_mesh((1.0, 1.0, 1.0), (1, 1, 1))
    with pytest.raises(ao.InputError, match=r"^path"):
        write_series(tmp_path / "nowhere" / "beam", mesh, np.zeros(1), {})
