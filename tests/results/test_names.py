"""What a user calls bodies and contacts, in everything that is shown or written of them."""

from __future__ import annotations

import copy
import pickle
from pathlib import Path
from typing import Any

import numpy as np

import aoimpact as ao
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
