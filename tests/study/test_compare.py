"""The paper's question for any impact: which model gives what, and at what price."""

import csv
import math

import pytest

import aoimpact as ao
from aoimpact.cli import main

from scenes import BAR
from twelve import ALUMINIUM, ENDS, STEEL, beam, cube, law


@pytest.fixture(scope="module")
def table():
    return ao.compare(
        projectile=cube(STEEL, 0.02),
        target=beam(ENDS),
        law=law(STEEL, 0.01, ALUMINIUM),
        velocity=1.0,
        duration=2e-4,
        oscillators=(1, 3, 8),
        modes=(20,),
    )


@pytest.mark.slow
def test_every_model_has_its_row_relative_to_the_full_one(table):
    assert [row.model for row in table.rows] == [
        "rigid", "AO(1)", "AO(3)", "AO(8)", "modal(20)", "full",
    ]  # fmt: skip
    assert [row.dofs for row in table.rows] == [1, 4, 8, 18, 40, 375 + 513]
    assert table.exact == "full"
    assert table["full"].force == table["full"].displacement == 0.0
    assert all(row.build >= 0.0 and row.run > 0.0 for row in table.rows)


def test_more_oscillators_are_nearer_to_the_full_model(table):
    force = [table[model].force for model in ("rigid", "AO(1)", "AO(3)", "AO(8)")]
    assert force == sorted(force, reverse=True)
    assert table["AO(8)"].force < 0.01 + table.exact_error
    assert table["AO(8)"].impulse < 0.01
    assert table["AO(8)"].contact_duration < 0.01


def test_modes_need_more(table):
    """Modes converge slowly where bodies are touched: the paper's Figure 4."""
    assert table["modal(20)"].force > 5 * table["AO(8)"].force


def test_law_and_duration_may_be_left_out_as_of_simulate():
    steel = ao.Material(E=210e9, nu=0.3, rho=7800)
    ball = ao.ball(radius=0.01, material=steel)
    mesh = ao.box_mesh((0.06, 0.06, 0.02), (4, 4, 2))
    tip = ao.FEModel.from_mesh(mesh, steel).contact(point=(0.03, 0.03, 0.02))
    hit = ao.simulate(ball, tip, 1.0)
    law = ao.Hertz.between(steel, 0.01, steel, math.inf)
    only = {"oscillators": (2, 6), "modes": (), "full": False}
    found = ao.compare(ball, tip, 1.0, **only)
    same = ao.compare(ball, tip, 1.0, law=law, duration=hit.duration, **only)
    for one, other in zip(found.rows, same.rows, strict=True):
        assert one.force == pytest.approx(other.force, rel=1e-6, abs=1e-9)


def test_models_of_a_shell_converge_to_the_full_shell():
    steel, rims = ao.Material(E=210e9, nu=0.3, rho=7800), [("xmin", "xyz", "xyz")]
    mesh = ao.sheet_mesh((0.05, 0.05), (8, 8))
    shell = ao.FEModel.from_mesh(mesh, ao.Shell(0.002, steel), rims)
    tip = shell.contact(point=(0.025, 0.025, 0.0))
    table = ao.compare(
        ao.ball(0.005, steel), tip, 1.0, duration=1e-4, oscillators=(5, 20), modes=(20,)
    )
    assert [row.failure for row in table.rows] == [""] * 5
    assert table["AO(20)"].force < 0.01 < table["AO(5)"].force


def test_without_the_full_model_the_largest_star_is():
    reduced = ao.antioscillators(beam(ENDS), 2)
    table = ao.compare(
        projectile=ao.rigid(mass=0.06),
        target=reduced,
        law=law(STEEL, 0.01, ALUMINIUM),
        velocity=1.0,
        duration=2e-4,
        oscillators=(1, 6),
        modes=(),
        full=False,
    )
    assert table.exact == "AO(6)"
    assert [row.dofs for row in table.rows] == [1, 3, 8]


def test_what_cannot_be_run_says_why():
    """Two bodies that are held: as rigid ones, two walls."""
    table = ao.compare(
        projectile=ao.AOModel(m0=1.0, k0=1e6),
        target=ao.AOModel(m0=1.0, k0=1e6, m=[1.0], k=[1e6]),
        law=ao.Hertz(1e9),
        velocity=1.0,
        duration=5e-3,
        oscillators=(0, 1),
        modes=(),
    )
    assert "infinite mass" in table["rigid"].failure
    assert math.isnan(table["rigid"].force)
    assert table["AO(1)"].force == 0.0


def test_text_figure_and_file(table, tmp_path):
    assert "AO(3)" in repr(table)
    assert repr(table).count("\n") == 8
    axes = table.plot(error="impulse")
    assert axes.get_ylabel() == "relative error of the impulse"
    assert len(axes.lines) == 3
    table.to_csv(tmp_path / "table.csv")
    with open(tmp_path / "table.csv", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert [float(row["force"]) for row in rows] == [row.force for row in table.rows]


def test_command(tmp_path, capsys):
    scene = tmp_path / "scene.toml"
    scene.write_text(BAR, encoding="utf-8")
    assert main(["compare", str(scene), "--no-full", "--out", str(tmp_path / "out")]) == 0
    printed = capsys.readouterr().out
    assert "AO(12)" in printed
    assert (tmp_path / "out" / "comparison.csv").exists()
    assert (tmp_path / "out" / "comparison.png").exists()
