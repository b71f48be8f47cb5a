"""Probes of scene files: each reads what the same sensor reads in Python."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest

import aoimpact as ao
from aoimpact.cli.main import main

from scenes import BAR

pytestmark = [
    pytest.mark.filterwarnings("ignore:.*may be off by"),
    pytest.mark.filterwarnings("ignore:.*known behind the filter"),
]

AT = (0.05, 0.005, 0.0)
PROBES = """
[{kind}.probes]
moved = {{ body = "bar", point = [0.05, 0.005, 0], direction = [0, 0, 1] }}
gauge = {{ type = "StrainAt", body = "bar", point = [0.05, 0.005, 0], component = [1, 0, 0], length = 3e-3 }}
strain = {{ type = "StrainAt", body = "bar", point = [0.05, 0.005, 0], component = "xx" }}
stress = {{ type = "StressAt", body = "bar", point = [0.05, 0.005, 0] }}
shock = {{ type = "AccelerationAt", body = "bar", point = [0.05, 0.005, 0], direction = [0, 0, 2], cfc = 4000 }}
held = {{ type = "ReactionAt", body = "bar", nodes = [0, 1, 2], direction = [0, 0, 1] }}
"""  # noqa: E501

SCENE = (
    BAR[: BAR.index("[impact]")]
    + """
[scene]
duration = 1e-3
bodies = [{ body = "ball", velocity = 1.0 }, { body = "bar" }]
[[scene.contacts]]
between = ["ball", "bar"]
law = { type = "ElasticPlastic", k = 1e9, yield_force = 1.0, hardness = 4e8, relative_radius = 1e-2}
"""
)


def written(folder: Path, text: str) -> Path:
    path = folder / "scene.toml"
    path.write_text(text, encoding="utf-8")
    return path


@pytest.mark.parametrize(("kind", "text"), [("impact", BAR), ("scene", SCENE)])
def test_probes_read_what_the_sensors_of_a_result_read(
    kind: str, text: str, tmp_path: Path
) -> None:
    file = ao.read_scene(written(tmp_path, text + PROBES.format(kind=kind)))
    run = file.simulate()
    bar, t = run.bodies[1], run.t
    probe = bar.probe(AT, (0, 0, 1), times=t)
    known = {
        "moved": probe.displacement,
        "gauge": bar.gauge(AT, (1, 0, 0), 3e-3, times=t).strain,
        "strain": probe.strain["xx"],
        "stress": probe.stress.von_mises,
        "shock": probe.filtered(cfc=4000).acceleration,
        "held": bar.reaction([0, 1, 2], times=t).force[:, 2],
    }
    found = file.probes(run)
    assert list(found) == list(known)
    for name, values in known.items():
        np.testing.assert_array_equal(found[name], values)


def test_probes_are_written_beside_the_histories(tmp_path: Path) -> None:
    path = written(tmp_path, BAR + PROBES.format(kind="impact"))
    assert main(["run", str(path), "--out", str(tmp_path / "out")]) == 0
    with (tmp_path / "out" / "probes.csv").open() as table:
        head, *rows = csv.reader(table)
    assert head == ["time [s]", "moved", "gauge", "strain", "stress", "shock", "held"]
    assert np.isfinite(np.array(rows, dtype=float)[:, :5]).all()


def test_dents_of_a_scene_are_reported(tmp_path: Path) -> None:
    report = 'report = ["contacts.0.dent.depth", "contacts.0.dent.diameter"]\n'
    text = SCENE.replace("duration = 1e-3\n", "duration = 1e-3\n" + report)
    file = ao.read_scene(written(tmp_path, text))
    run = file.simulate()
    contact = run.contacts[0]
    assert contact.dent == contact.law.dent(contact.indentation.max())
    assert contact.dent.depth > 0.0
    assert "dent of " in str(run)
    assert run.value("contacts.0.dent.depth") == contact.dent.depth


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (('"bar", point', '"beam", point'), "has no 'beam'"),
        (('"bar", point', '"ball", point'), "no finite elements"),
        (("point = [0.05, 0.005, 0]", "point = [0.5, 0.005, 0]"), "off the body"),
        (("nodes = [0, 1, 2]", "nodes = [8]"), "is held"),
        (("nodes = [0, 1, 2]", "nodes = [0.5]"), "a whole number"),
        (('component = "xx"', 'component = "xz", length = 1e-3'), "measures along a direction"),
        (('"StrainAt"', '"StrainOf"'), "StrainAt"),
    ],
)
def test_probes_that_make_no_sense_are_named_by_line(
    change: tuple[str, str], message: str, tmp_path: Path
) -> None:
    path = written(tmp_path, BAR + PROBES.format(kind="impact").replace(*change, 1))

    with pytest.raises(ao.SceneFileError, match=rf"scene\.toml:\d+: .*{message}"):
        ao.read_scene(path).case()
