"""The full finite-element model by name; contact points stand for what is left to be chosen."""

from __future__ import annotations

import numpy as np
import pytest

import aoimpact as ao
from aoimpact.results import QUANTITIES

STEEL = ao.Material(E=210e9, nu=0.3, rho=7800)
HERTZ = ao.Hertz(k=1e9)
DOWN = (0.0, 0.0, -1.0)


def bar() -> ao.FEModel:
    mesh = ao.box_mesh((0.3, 0.02, 0.02), (6, 1, 1))
    return ao.FEModel.from_mesh(mesh, STEEL, fixed=[("xmin", "xyz"), ("xmax", "xyz")])


def tip_of(body: ao.FEModel, x: float) -> ao.ContactPoint:
    return body.contact(point=(x, 0.01, 0.02), direction=DOWN)


BODY = bar()
TIP, OTHER = tip_of(BODY, 0.15), tip_of(BODY, 0.1)


def struck(body: object, **options: object) -> ao.Result:
    return ao.simulate(ao.rigid(mass=0.02), body, 1.0, law=HERTZ, duration=2e-4, **options)


@pytest.mark.parametrize("options", [{}, {"rtol": 1e-2}, {"quantity": "peak_force", "rtol": 0.1}])
def test_it_is_never_reduced(options: dict[str, object]) -> None:
    hit = struck(ao.full(TIP), **options)
    assert hit.target.label == f"full({BODY.n_dofs})"


@pytest.mark.filterwarnings("ignore:.*elements of first order")  # models are compared, not meshes
def test_a_contact_point_stands_for_a_model_that_gives_the_force_to_a_percent() -> None:
    """The full model is what its force is right to; the tolerance is that asked for by name."""
    whole, by_point = struck(ao.full(TIP), rtol=1e-3), struck(TIP)
    meshed = by_point.beside
    assert meshed is not None
    model = meshed.plan.bodies[1]
    assert model.label.startswith("AO(")
    assert model.n < BODY.n_dofs / 4
    assert QUANTITIES["force"].difference(meshed, whole) <= 1e-2
    assert by_point.error.model is not None
    assert by_point.error.model + by_point.error.time <= 1e-2
    asked = struck(TIP, quantity="force", rtol=by_point.error.rtol)
    np.testing.assert_array_equal(asked.force, by_point.force)


@pytest.mark.filterwarnings("ignore:.*elements of first order")  # models are compared, not meshes
def test_of_several_places_a_list_stands_for_a_model_as_good_as_that() -> None:
    runs = []
    for body in (ao.full([TIP, OTHER]), [TIP, OTHER]):
        scene = ao.Scene()
        beam = scene.add(body)
        for i, speed in enumerate((1.0, 0.5)):
            ball = scene.add(ao.rigid(mass=0.02), velocity=speed)
            scene.connect(ball, beam.port(i), HERTZ)
        runs.append(scene.simulate(duration=2e-4))
    whole, by_list = runs[0], runs[1].beside
    assert whole[0].label == f"full({BODY.n_dofs})"
    assert by_list.plan.bodies[0].label.startswith("interface(")
    times = np.linspace(0.0, 2e-4, 801)
    right, found = (
        np.stack([np.interp(times, run.t, contact.force) for contact in run.contacts])
        for run in (whole, by_list)
    )
    # What is not reduced is right by its step.
    assert np.abs(found - right).max() <= (1e-2 + whole.error.time) * right.max()


def test_a_body_added_twice_is_reduced_once() -> None:
    """Two like bodies that meet: of one model, turned round for the target."""
    free = ao.FEModel.from_mesh(ao.box_mesh((0.1, 0.02, 0.02), (4, 1, 1)), STEEL)
    tip = free.contact(point=(0.1, 0.01, 0.01), direction=(1, 0, 0))
    scene = ao.Scene()
    scene.connect(scene.add(tip, velocity=3.0), scene.add(tip), ao.Hertz(k=1e10))
    run = scene.simulate(duration=2e-4)
    assert run.models[0].n > 0
    assert run.models[1] is run.models[0].turned((0,))
