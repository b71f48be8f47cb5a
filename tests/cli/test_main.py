"""The command line: help, exit codes, and no traceback for what a user gets wrong."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from pathlib import Path

import meshio
import numpy as np
import pytest

import aoimpact as ao
from aoimpact import paper
from aoimpact.cli import main

from scenes import BAR, ROW


def test_help_and_version(capsys: pytest.CaptureFixture[str]) -> None:
    for arguments, word in (
        (["--help"], "compare"),
        (["paper", "--help"], "paper-results"),
        (["run", "--help"], "--checkpoint"),
        (["--version"], ao.__version__),
    ):
        with pytest.raises(SystemExit) as stop:
            main(arguments)
        assert stop.value.code == 0
        assert word in capsys.readouterr().out


@pytest.mark.parametrize("arguments", [[], ["papr"], ["paper", "--outt", "x"], ["paper", "x"]])
def test_wrong_usage_ends_with_two(
    arguments: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit) as stop:
        main(arguments)
    assert stop.value.code == 2
    assert "usage:" in capsys.readouterr().err


def test_run_as_a_module_has_no_traceback(tmp_path: Path) -> None:
    file = tmp_path / "taken"
    file.touch()
    command = [sys.executable, "-m", "aoimpact", "paper", "--out", str(file)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode == 2
    assert done.stderr.startswith("aoimpact: error: folder=")
    assert "Traceback" not in done.stderr


@pytest.mark.parametrize(
    ("error", "code"),
    [
        (ao.InputError("no such thing"), 2),
        (ao.ConvergenceError("it grew"), 1),
        (OSError("disk full"), 1),
        (KeyboardInterrupt(), 130),
    ],
)
def test_failures_have_codes_and_one_line(
    error: BaseException,
    code: int,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    def fail(_: object) -> None:
        raise error

    monkeypatch.setattr(paper, "reproduce", fail)
    assert main(["paper"]) == code
    lines = capsys.readouterr().err.splitlines()
    assert len(lines) == 1
    assert str(error) in lines[0]


# ----------------------------------------------------------------------------------------- run

SCENE = """\
title = "Two balls"
[bodies.ball]
mass = 0.03
[impact]
projectile = "ball"
target = "ball"
velocity = 1.0
duration = 1e-4
law = { type = "Hertz", k = 1e10 }
"""


@pytest.fixture
def scene(tmp_path: Path) -> Path:
    path = tmp_path / "scene.toml"
    path.write_text(SCENE, encoding="utf-8")
    return path


@pytest.mark.filterwarnings("ignore:displacement may be off by")  # of four bricks that lock
def test_run_writes_histories_probes_figures_and_fields(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path, out = tmp_path / "bar.toml", tmp_path / "out"
    probe = (
        '[impact.probes]\nmoved = { body = "bar", point = [0.1, 0, 0], direction = [0, 0, 1] }\n'
    )
    path.write_text(BAR + probe, encoding="utf-8")
    assert main(["run", str(path), "--out", str(out)]) == 0
    told = capsys.readouterr().out
    figures = {f"{name}.png" for name in ("force", "indentation", "displacement", "energy")}
    files = {"histories.csv", "probes.csv", "bar.pvd"} | figures
    assert files == {file.name for file in out.iterdir() if file.suffix != ".vtu"}
    assert all(name in told for name in files)
    hit = ao.read_scene(path).simulate()
    table = np.genfromtxt(out / "histories.csv", delimiter=",", names=True)
    assert table["force_N"].max() == pytest.approx(hit.peak_force)
    moved = np.genfromtxt(out / "probes.csv", delimiter=",", names=True)["moved"]
    expected = hit.target.probe((0.1, 0, 0), (0, 0, 1), times=hit.t).displacement
    np.testing.assert_allclose(moved, expected, atol=1e-12 * np.abs(expected).max())
    listing = (out / "bar.pvd").read_text()
    assert f'timestep="{hit.peak_time!r}"' in listing
    last = meshio.read(out / re.findall(r'file="(.*?)"', listing)[-1]).point_data["displacement"]
    field = hit.target.field(hit.t[-1]).displacement[0]
    np.testing.assert_allclose(last, field, rtol=1e-9, atol=1e-15)


def test_run_of_a_scene_of_several_bodies(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path, out = tmp_path / "row.toml", tmp_path / "out"
    path.write_text(ROW, encoding="utf-8")
    assert main(["run", str(path), "--out", str(out), "--json"]) == 0
    report = json.loads(capsys.readouterr().out)
    run = ao.read_scene(path).simulate()
    assert report["quantities"]["contacts.1.peak_force"] == run.contacts[1].peak_force
    assert report["contacts"][0][0] == list(run.contacts[0].intervals[0])
    head = (out / "histories.csv").read_text().partition("\n")[0]
    assert "contact 1 force [N],contact 1 indentation [m],first displacement [m]" in head
    assert {"force.png", "displacement.png", "energy.png"} <= {f.name for f in out.iterdir()}


def test_run_for_machines(scene: Path, capsys: pytest.CaptureFixture[str]) -> None:
    scene.write_text(scene.read_text().replace("duration = 1e-4", "duration = 1e-5"))
    assert main(["run", str(scene), "--json"]) == 0
    captured = capsys.readouterr()
    report = json.loads(captured.out)
    hit = report["quantities"]
    assert hit["impulse"] > 0.0
    assert report["in_contact_at_end"] is True
    assert "ends in contact" in report["warnings"][0]
    assert "warning: the record" in captured.err
    assert report["relative_errors"]["model"] is None
    assert report["files"] == []
    assert main(["run", str(scene)]) == 0
    text = capsys.readouterr().out
    assert all(part in text for part in ("Two balls", "peak force", "restitution"))
    assert list(scene.parent.iterdir()) == [scene]


OBLIQUE = """
[materials.steel]
E = 210e9
nu = 0.3
rho = 7800

[bodies]
ball = { ball = 0.01, material = "steel" }
floor = { wall = "steel" }

[impact]
projectile = "ball"
target = "floor"
velocity = [0.5, 0.0, -1.0]
friction = 0.1
"""


def test_vectors_of_an_oblique_impact_for_machines(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "oblique.toml"
    path.write_text(OBLIQUE)
    assert main(["run", str(path), "--json"]) == 0
    report = json.loads(capsys.readouterr().out)
    (x, y, z), held = report["final_velocity"]
    # About the contact point momentum is kept: the spin takes 5/2 of the change along the wall.
    spin = 2.5 * (0.5 - x) / 0.01
    assert report["final_spin"][0] == pytest.approx([0.0, spin, 0.0], abs=1e-6 * spin)
    assert (y, z) == (pytest.approx(0.0, abs=1e-9), pytest.approx(1.0, abs=1e-6))
    assert held == [0.0, 0.0, 0.0]
    ((start, end),) = report["contacts"]
    assert (report["slip_intervals"][0][0], report["slip_intervals"][-1][1]) == (start, end)


SWEEP = """
[sweep]
keep = ["impulse"]

[sweep.over]
velocity = { from = 0.5, to = 1.5, count = 3 }
"""


def test_run_of_a_sweep(scene: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out, store = tmp_path / "out", tmp_path / "cases"
    scene.write_text(scene.read_text() + SWEEP)
    keep = ["--workers", "2", "--checkpoint", str(store)]
    assert main(["run", str(scene), "--out", str(out), *keep]) == 0
    assert store.exists()
    assert "3 cases" in capsys.readouterr().out
    heading, *rows = (out / "sweep.csv").read_text().splitlines()
    assert heading.startswith("velocity,impulse")
    assert [float(row.split(",")[0]) for row in rows] == [0.5, 1.0, 1.5]
    assert main(["run", str(scene), "--json"]) == 0
    report = json.loads(capsys.readouterr().out)
    assert report["parameters"] == ["velocity"]
    assert [row["impulse"] for row in report["rows"]] == [float(r.split(",")[1]) for r in rows]


def test_a_sweep_of_which_nothing_works(scene: Path, capsys: pytest.CaptureFixture[str]) -> None:
    scene.write_text(scene.read_text() + SWEEP.replace("velocity", "duration").replace("0.5", "-2"))
    assert main(["run", str(scene), "--json"]) == 0  # one of three does
    report = json.loads(capsys.readouterr().out)
    assert ["error" in row for row in report["rows"]] == [True, True, False]
    assert report["rows"][0]["impulse"] is None
    scene.write_text(scene.read_text().replace("1.5", "-1"))
    assert main(["run", str(scene)]) == 2
    assert "every case of the sweep failed" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["run", "{scene}", "--workers", "2"], "need a [sweep]"),
        (["run", "{wrong}"], "wrong.toml:7: impact.velocty: unknown name"),
        (["run", "{wrong}.none"], "cannot be read"),
        (["compare", "{row}"], "needs an [impact] of two bodies"),
        (["paper", "--out", "{scene}"], "scene.toml"),
        (["paper", "--out", "{scene}/below"], "below"),
    ],
)
def test_what_is_wrong_is_said(
    arguments: list[str], said: str, scene: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    files = {"scene": SCENE, "row": ROW, "wrong": SCENE.replace("velocity", "velocty")}
    paths = {name: scene.with_stem(name) for name in files}
    for name, path in paths.items():
        path.write_text(files[name], encoding="utf-8")
    assert main([one.format(**paths) for one in arguments]) == 2
    assert said in capsys.readouterr().err
    assert scene.read_text(encoding="utf-8") == SCENE
