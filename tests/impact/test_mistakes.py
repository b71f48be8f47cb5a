"""Mistakes of the first hour: each is answered by what to change.

A steel ball of 10 mm strikes an aluminium plate of 100 × 80 × 6 mm at 1 m/s.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import aoimpact as ao
from aoimpact.contact import ContactSurface
from aoimpact.laws import law_between

STEEL = ao.Material(E=210e9, nu=0.3, rho=7800)
ALU = ao.Material(E=70e9, nu=0.3, rho=2700)
ENDS = [("xmin", "xyz"), ("xmax", "xyz")]
SIZE = (0.1, 0.08, 0.006)
MIDDLE = (0.05, 0.04, 0.006)
DOWN = (0, 0, -1)
BALL = ao.rigid(mass=0.0327)
# Of the compliance of a node, which the coarse plates are touched at, no part.
LAW = ao.PowerLaw(ao.Hertz.between(STEEL, 0.01, ALU, math.inf).k, 1.5)


def plate(size: Any = SIZE, fixed: Any = ENDS) -> ao.FEModel:
    return ao.FEModel.from_mesh(ao.box_mesh(size, (6, 4, 1)), ALU, fixed=fixed)


def star(body: ao.FEModel) -> ao.AOModel:
    tip = body.contact(point=MIDDLE, direction=DOWN, radius=0)
    return ao.antioscillators(tip, 6, method="krylov", contact_time=1e-4)


def strike(target: Any, **changes: Any) -> ao.Result:
    given = {"projectile": BALL, "target": target, "law": LAW, "velocity": 1.0, "duration": 3e-4}
    return ao.simulate(**given | changes)


def test_done_right_nothing_is_said() -> None:
    assert strike(star(plate())).peak_force > 100.0


WARNED: dict[str, tuple[Callable[[], Any], str]] = {
    "a mesh in millimetres": (lambda: plate((100.0, 80.0, 6.0)), "scale"),
    # A chip of 4 × 4 × 2 mm weighs 86 t then, as some machines do; but its elements are large.
    "a small part in millimetres": (
        lambda: ao.FEModel.from_mesh(ao.box_mesh((4, 4, 2), (2, 2, 1)), ALU),
        "elements",
    ),
    "a modulus in gigapascals": (lambda: ao.Material(E=70, nu=0.3, rho=2700), r"^E"),
    "a record that is too short": (lambda: strike(star(plate()), duration=3e-5), "contact"),
    "a gap that is not closed": (lambda: strike(star(plate()), gap=1e-3), r"^projectile"),
    "too fast for the method": (lambda: strike(star(plate()), velocity=100.0), r"^projectile"),
    "an oblique direction": (
        lambda: strike(plate().contact(point=MIDDLE, direction=(1, 0, -1))),
        r"^target",
    ),
}


@pytest.mark.filterwarnings("ignore:.*elements of first order")
@pytest.mark.parametrize("mistake", WARNED)
def test_it_is_warned_of(mistake: str) -> None:
    call, words = WARNED[mistake]
    with pytest.warns(ao.AOImpactWarning, match=words):
        call()


REFUSED: dict[str, tuple[Callable[[], Any], str]] = {
    "a point in millimetres": (lambda: plate().contact(point=(50, 40, 6)), r"^point"),
    "a point on a support": (lambda: plate().contact(point=(0, 0.04, 0.006), radius=0), r"^point"),
    "a whole body in place of a contact": (lambda: strike(plate()), r"^target"),
    "a whole body in a scene": (lambda: ao.Scene().add(plate()), r"^body"),
    "a whole body first": (lambda: ao.simulate(plate(), plate(), 1.0), r"^projectile"),
    "a direction the wrong way round": (
        lambda: strike(plate().contact(point=MIDDLE, direction=(0, 0, 1))),
        r"^target",
    ),
    "a ball of a metre": (
        lambda: ao.simulate(ao.ball(1, STEEL), plate().contact(point=MIDDLE), 1.0),
        r"^contact",
    ),
}


@pytest.mark.parametrize("mistake", REFUSED)
def test_it_is_refused(mistake: str) -> None:
    call, words = REFUSED[mistake]
    with pytest.raises((ao.InputError, ao.InputTypeError), match=words):
        call()


def test_a_contact_of_a_scene_the_wrong_way_round() -> None:
    scene = ao.Scene()
    ball, target = scene.add(BALL, velocity=1.0), scene.add(star(plate()))
    scene.connect(target, ball, LAW)
    with pytest.raises(ao.InputError, match=r"^body"):
        scene.simulate(duration=3e-4)


def test_bodies_that_would_be_inside_each_other() -> None:
    """Both in the coordinates of the plate, on whose top the ball lies with its own top."""
    mesh = ao.sphere_mesh(0.01, 0.01)
    moved = ao.Mesh(mesh.nodes + np.array([0.05, 0.04, -0.004]), mesh.cells, mesh.kind)
    ball = ao.FEModel.from_mesh(moved, STEEL)
    tip = ball.contact(point=MIDDLE, radius=0)
    flying = ao.antioscillators(tip, 4, method="krylov", contact_time=1e-4)
    with pytest.warns(ao.AOImpactWarning, match=r"^projectile"):
        strike(star(plate()), projectile=flying)


def test_a_projectile_that_flies_away_is_refused_before_any_model_is_made(own_solver: Any) -> None:
    ball = ao.FEModel.from_mesh(ao.sphere_mesh(0.01, 0.01), STEEL).contact(point=(0, 0, -0.01))
    target = plate().contact(point=MIDDLE)
    with pytest.raises(ao.InputError, match=r"^velocity"):
        ao.simulate(ball, target, -1.0, linear_solver=own_solver)
    assert own_solver.calls == []


def test_cylinders_that_touch_along_a_line() -> None:
    along = ((0.0, 1.0, 0.0), (1.0, 0.0, 0.0))
    roller = ContactSurface(STEEL, (100.0, 1e-5), along, error=0.1)
    askew = ContactSurface(STEEL, (100.0, 1e-5), ((1e-5, 1.0, 0.0), (1.0, -1e-5, 0.0)), error=0.1)
    for other in (roller, askew):
        with pytest.raises(ao.InputError, match=r"^surfaces"):
            law_between(roller, other, projectile_direction=DOWN, target_direction=DOWN)


def test_a_held_body_that_flies_is_asked_about() -> None:
    """The likeliest cause is that the two bodies were exchanged."""
    tip = plate().contact(point=MIDDLE)
    ball = ao.ball(0.01, STEEL)
    with pytest.warns(ao.AOImpactWarning, match=r"^projectile"):
        ao.simulate(projectile=tip, target=ball, velocity=1.0)
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        ao.simulate(projectile=ball, target=tip, velocity=1.0)
    assert not any("exchange projectile" in str(one.message) for one in said)
