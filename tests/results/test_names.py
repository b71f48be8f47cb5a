"""What a user calls bodies and contacts, in everything that is shown or written of them."""

from __future__ import annotations

import copy
import json
import math
import pickle
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import aoimpact as ao
from aoimpact.cli import main
from aoimpact.results import Run

ALU = ao.Material(E=70e9, nu=0.3, rho=2700)
LAW = ao.Hertz(k=1e9)
BALL = ao.rigid(mass=0.01, name="ball")


def bar(name: str = "bar") -> ao.FEModel:
    mesh = ao.box_mesh((0.1, 0.02, 0.02), (5, 1, 1))
    return ao.FEModel.from_mesh(mesh, ALU, fixed=[("xmin", "xyz")], name=name)


def tip(name: str = "bar") -> ao.ContactPoint:
    return bar(name).contact(point=(0.1, 0.02, 0.02), direction=(0, 0, -1), radius=0)


def strike(projectile: Any = BALL, target: Any = None) -> ao.Result:
    return ao.simulate(
        projectile=projectile,
        target=ao.antioscillators(tip(), 3) if target is None else target,
        law=LAW,
        velocity=1.0,
        duration=1e-3,
    )


def headings(path: Path) -> list[str]:
    return path.read_text(encoding="utf-8").splitlines()[0].split(",")


def test_models_are_called_as_their_body() -> None:
    contact = tip()
    assert contact.name == "bar"
    star = ao.antioscillators(contact, 3)
    several = ao.interface([contact], 4, contact_time=1e-4)
    models = (star, star.truncated(2), ao.modal(contact, 4), ao.modal(contact, 4).star, several)
    assert {model.name for model in models} == {"bar"}
    for again in (pickle.loads(pickle.dumps(star)), copy.copy(star)):
        assert again.name == "bar"
    springs = np.array([[2.0, -1.0], [-1.0, 2.0]])
    matrices = ao.FEModel(K=springs, M=np.eye(2), name="two springs")
    assert ao.antioscillators(matrices.contact(dof=0), 1).name == "two springs"
    assert ao.AOModel(m0=1.0, name="mass").name == "mass"


def test_models_say_in_a_line_what_they_are() -> None:
    star = ao.antioscillators(tip(""), 3)
    assert repr(star) == "AOModel(3 oscillators, 0.108 kg, constrained)"
    assert repr(ao.modal(tip(), 4)) == "Body('bar', modal(4), 0.108 kg, constrained)"
    assert repr(BALL) == "AOModel('ball', no oscillators, 0.01 kg, free)"
    assert repr(ao.rigid(mass=float("inf"), name="floor")) == "AOModel('floor', wall)"
    assert repr(bar()).startswith("FEModel('bar', 60 dofs, 24 nodes, ")
    assert repr(tip()).endswith(" at (0.1, 0.02, 0.02) m along (0, 0, -1) of 'bar')")


def test_an_impact_shows_the_names(tmp_path: Path) -> None:
    hit = strike()
    assert (hit.projectile.name, hit.target.name) == ("ball", "bar")
    assert "projectile         ball: rigid, 10 g\n" in repr(hit)
    assert repr(hit.target) == "BodyResult(bar: AO(3), 0.108 kg, constrained)"
    assert "target             bar: AO(3), 108 g, constrained, node 23 at (0.1, " in repr(hit)
    labels = [text.get_text() for text in hit.plot_displacement().get_legend().get_texts()]
    assert labels == ["ball", "bar, contact point", "bar, centre of mass"]
    hit.to_csv(tmp_path / "hit.csv")
    assert "bar displacement [m]" in headings(tmp_path / "hit.csv")


def test_without_names_they_are_projectile_and_target(tmp_path: Path) -> None:
    hit = strike(ao.rigid(mass=0.01), ao.antioscillators(tip(""), 3))
    assert (hit.projectile.name, hit.target.name) == ("projectile", "target")
    assert "projectile         rigid, 10 g\n" in repr(hit)
    hit.to_csv(tmp_path / "hit.csv")
    assert "projectile displacement [m]" in headings(tmp_path / "hit.csv")


def test_bodies_of_one_name_are_told_apart() -> None:
    hit = strike(BALL, ao.rigid(mass=0.02, name="ball"))
    assert hit.names == ("ball (projectile)", "ball (target)")


def row() -> Run:
    scene = ao.Scene()
    first = scene.add(BALL, velocity=1.0, name="striker")
    second, third = scene.add(BALL), scene.add(ao.rigid(mass=0.05))
    scene.connect(first, second, LAW, name="first hit")
    scene.connect(second, third, LAW)
    return scene.simulate(duration=1e-3)


def test_a_scene_shows_the_names(tmp_path: Path) -> None:
    run = row()
    assert run.names == ("striker", "ball", "body 2")
    assert [of.name for of in run.contacts] == ["first hit", "contact 1"]
    lines = [line.split("  ")[1].strip() for line in repr(run).splitlines()[1:]]
    assert lines == ["striker", "ball", "body 2", "first hit", "contact 1", "solver", "cost"]
    run.to_csv(tmp_path / "run.csv")
    assert {"first hit force [N]", "striker velocity [m/s]"} < set(headings(tmp_path / "run.csv"))
    legends = (run.plot_force(), run.plot_displacement())
    shown = [[text.get_text() for text in ax.get_legend().get_texts()] for ax in legends]
    assert shown == [["first hit", "contact 1"], ["striker", "ball", "body 2"]]


def test_the_legend_names_the_bodies_of_a_contact_without_a_name() -> None:
    scene = ao.Scene()
    first, second = scene.add(BALL, velocity=1.0, name="striker"), scene.add(BALL, name="plate")
    scene.connect(first, second, LAW)
    scene.connect(second, scene.add(ao.rigid(mass=math.inf, name="floor")), LAW)
    ax = scene.simulate(duration=1e-3).plot_force()
    shown = [text.get_text() for text in ax.get_legend().get_texts()]
    assert shown == ["contact 0: striker on plate", "contact 1: plate on floor"]


def test_warnings_call_bodies_and_contacts_by_name() -> None:
    with pytest.warns(ao.AOImpactWarning, match="contact"):
        ao.simulate(BALL, ao.antioscillators(tip(), 3), 1.0, law=LAW, duration=1e-6, gap=1.0)
    scene = ao.Scene()
    scene.connect(scene.add(BALL), scene.add(BALL), LAW, gap=1.0, name="landing")
    with pytest.warns(ao.AOImpactWarning, match="contact"):
        scene.simulate(duration=1e-3)


def test_names_are_text() -> None:
    with pytest.raises(ao.InputTypeError, match=r"^name"):
        ao.rigid(mass=1.0, name=3)  # type: ignore[arg-type]
    with pytest.raises(ao.InputTypeError, match=r"^name"):
        bar(name=None)  # type: ignore[arg-type]
    scene = ao.Scene()
    with pytest.raises(ao.InputTypeError, match=r"^name"):
        scene.connect(scene.add(BALL), scene.add(BALL), LAW, name=b"x")  # type: ignore[arg-type]


SCENE = """\
[bodies.ball]
mass = 0.03

[scene]
duration = 1e-3
[[scene.bodies]]
name = "striker"
body = "ball"
velocity = 1.0
[[scene.bodies]]
body = "ball"
[[scene.contacts]]
name = "first hit"
between = ["striker", "ball"]
law = { type = "Hertz", k = 1e9 }
"""


def test_json_of_a_scene_file_has_the_names(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "scene.toml"
    path.write_text(SCENE, encoding="utf-8")
    assert main(["run", str(path), "--json"]) == 0
    report = json.loads(capsys.readouterr().out)
    assert (report["bodies"], report["contact_names"]) == (["striker", "ball"], ["first hit"])


@pytest.mark.parametrize(
    ("law", "title"),
    [
        (ao.Hertz(k=10.9e9), "Hertz, k = 10.9 GN/m^1.5"),
        (ao.Hertz(k=10.9e9, relative_radius=0.005), "Hertz, k = 10.9 GN/m^1.5, R = 5 mm"),
        (ao.Linear(k=2e6), "Linear, k = 2 MN/m"),
        (ao.PowerLaw(k=2e6, n=2.2), "PowerLaw, k = 2 MN/m^2.2, n = 2.2"),
        (ao.KelvinVoigt(k=2e6, c=30.0), "KelvinVoigt, k = 2 MN/m, c = 30 N s/m, end = force"),
        (
            ao.Hertz(k=10.9e9).within_patch(1e-9),
            "Hertz, k = 10.9 GN/m^1.5 (compliance of the mesh removed: 1 nm/N)",
        ),
    ],
)
def test_laws_have_titles_with_units(law: ao.ContactLaw, title: str) -> None:
    assert str(law).startswith(title)


def test_a_body_whose_model_is_chosen_keeps_its_name() -> None:
    """A soft ball on a held steel block."""
    steel, soft = ao.Material(E=210e9, nu=0.3, rho=7800), ao.Material(E=5e6, nu=0.3, rho=1100)
    block = ao.box_mesh((0.04, 0.04, 0.04), (3, 3, 3), kind="hexahedron20")
    target = ao.FEModel.from_mesh(block, steel, fixed=[("zmin", "xyz")], name="anvil")
    ball = ao.FEModel.from_mesh(ao.sphere_mesh(0.01, 0.01), soft, name="puck")
    hit = ao.simulate(
        ball.contact(point=(0, 0, -0.01)), target.contact(point=(0.02, 0.02, 0.04)), 0.05, rtol=0.05
    )
    assert f"target             anvil: {hit.target.label}" in repr(hit)
