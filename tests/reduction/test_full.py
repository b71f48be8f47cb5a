"""The full finite-element model by name: it is what contact points stand for."""

from __future__ import annotations

import math
import pickle

import numpy as np
import pytest

import aoimpact as ao

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
    return ao.simulate(
        projectile=ao.rigid(mass=0.02),
        target=body,
        law=HERTZ,
        velocity=1.0,
        duration=2e-4,
        **options,
    )


@pytest.mark.parametrize("options", [{}, {"rtol": 1e-2}, {"quantity": TIP}])
def test_it_is_what_a_contact_point_stands_for(options: dict[str, object]) -> None:
    by_name, by_point = struck(ao.full(TIP), **options), struck(TIP, **options)
    assert by_name.target.label == by_point.target.label
    np.testing.assert_array_equal(by_name.force, by_point.force)


def test_of_several_places_it_is_what_a_list_stands_for() -> None:
    runs = []
    for body in (ao.full(TIP, OTHER), [TIP, OTHER]):
        scene = ao.Scene()
        beam = scene.add(body)
        for i, speed in enumerate((1.0, 0.5)):
            ball = scene.add(ao.rigid(mass=0.02), velocity=speed)
            scene.connect(ball, beam.port(i), HERTZ)
        runs.append(scene.simulate(duration=2e-4))
    assert runs[0][0].label == f"full({BODY.n_dofs})"
    for one, other in zip(runs[0].contacts, runs[1].contacts, strict=True):
        np.testing.assert_array_equal(one.force, other.force)


def test_a_body_added_twice_is_reduced_once_by_whatever_name() -> None:
    """Two like bodies that meet."""
    free = ao.FEModel.from_mesh(ao.box_mesh((0.1, 0.02, 0.02), (4, 1, 1)), STEEL)
    tip = free.contact(point=(0.1, 0.01, 0.01), direction=(1, 0, 0))
    scene = ao.Scene()
    scene.connect(scene.add(tip, velocity=1.0), scene.add(ao.full(tip)), HERTZ)
    run = scene.simulate(duration=2e-4, rtol=1e-1)
    assert run.models[0] is run.models[1]


def test_it_says_what_it_is() -> None:
    model = ao.full(TIP, OTHER)
    assert model == ao.full(TIP, OTHER) != ao.full(OTHER, TIP)
    assert model.body is BODY
    assert model.contact_points == model.tips == (TIP, OTHER)
    assert repr(model) == f"full({TIP!r}, {OTHER!r})"
    assert pickle.loads(pickle.dumps(model)).label == model.label == f"full({BODY.n_dofs})"


@pytest.mark.parametrize(
    ("tips", "error", "words"),
    [
        ((), ao.InputError, "tips is empty"),
        (([TIP],), ao.InputTypeError, "tips must come from"),
        ((ao.rigid(mass=1.0),), ao.InputTypeError, "tips must come from"),
        ((TIP, tip_of(bar(), 0.15)), ao.InputError, "tips has contact points on different bodies"),
    ],
)
def test_what_is_no_place_on_one_body_is_refused(
    tips: tuple[object, ...], error: type[Exception], words: str
) -> None:
    with pytest.raises(error, match=words):
        ao.full(*tips)


def test_models_are_compared_with_it() -> None:
    wall = ao.rigid(mass=math.inf)
    free = ao.FEModel.from_mesh(ao.box_mesh((0.1, 0.02, 0.02), (4, 1, 1)), STEEL)
    tip = free.contact(point=(0.1, 0.01, 0.01), direction=(1, 0, 0))
    first, second = (
        ao.compare(
            projectile=body, target=wall, law=HERTZ, velocity=1.0, duration=6e-4, oscillators=(3,),
            modes=(),
        )
        for body in (tip, ao.full(tip))
    )  # fmt: skip
    assert [row.force for row in first.rows] == [row.force for row in second.rows]
