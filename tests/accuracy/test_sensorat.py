"""Stress, strain, filtered acceleration and reactions as quantities, against all oscillators."""

from __future__ import annotations

import copy
import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import aoimpact as ao

from twelve import ALL_EDGES, ALUMINIUM, STEEL, as_meshed, box

LAW = ao.PowerLaw(ao.Hertz.between(STEEL, 0.01, ALUMINIUM, math.inf).k, 1.5)
POINT, DOWN = (0.065, 0.05, 0.0), (0.0, 0.0, -1.0)

pytestmark = [
    pytest.mark.filterwarnings("ignore:.*elements of first order"),
    pytest.mark.filterwarnings("ignore:.*may be off by"),
    pytest.mark.filterwarnings("ignore:.*the mesh makes an error"),
]


def made(fixed: Any) -> Any:
    return box(ALUMINIUM, (0.1, 0.1, 0.005), (6, 6, 1), (0.4, 0.5, 1), fixed)


@pytest.fixture(scope="module")
def plate() -> Any:
    return made(ALL_EDGES)


def strike(target: Any, **options: Any) -> ao.Result:
    given = {"projectile": ao.rigid(mass=0.01), "law": LAW, "velocity": 1.0}
    return ao.simulate(target=target, **(given | options))


# Each with how it is read of a result, and the record's length, s.
WANTED: dict[str, tuple[Callable[[Any], Any], Callable[[Any, Any], Any], float | None]] = {
    "stress": (
        lambda tip: ao.StressAt(tip, POINT, "xx"),
        lambda of, t: of.probe(POINT, times=t).stress["xx"],
        2e-4,
    ),
    "stress in a free plate": (
        lambda tip: ao.StressAt(tip, POINT),
        lambda of, t: of.probe(POINT, times=t).stress.von_mises,
        2e-4,
    ),
    "strain": (
        lambda tip: ao.StrainAt(tip, POINT, "xx"),
        lambda of, t: of.probe(POINT, times=t).strain["xx"],
        2e-4,
    ),
    "strain of a gauge": (
        lambda tip: ao.StrainAt(tip, POINT, (1, 1, 0), length=4e-3),
        lambda of, t: of.gauge(POINT, (1, 1, 0), 4e-3, times=t).strain,
        2e-4,
    ),
    "acceleration": (
        lambda tip: ao.AccelerationAt(POINT, DOWN, cfc=1000),
        lambda of, t: of.probe(POINT, DOWN, times=t).filtered(cfc=1000).acceleration,
        None,
    ),
    "reaction": (
        lambda tip: ao.ReactionAt("xmin", DOWN),
        lambda of, t: of.reaction("xmin", times=t).force @ DOWN,
        2e-4,
    ),
}


TOGETHER = ("reaction", "strain", "strain of a gauge", "acceleration")


@pytest.mark.parametrize(
    "names",
    [
        TOGETHER,
        ("stress",),
        *(pytest.param((name,), marks=pytest.mark.slow) for name in WANTED if name != "stress"),
    ],
)
def test_the_true_error_of_each_is_within_the_tolerance(plate: Any, names: Any) -> None:
    plate = made(None) if "free" in names[0] else plate
    quantities = [WANTED[name][0](plate) for name in names]
    hit = strike(plate, quantity=quantities, rtol=2e-2, duration=WANTED[names[-1]][2])
    whole = ao.antioscillators(plate)
    right = strike(whole, duration=hit.duration).target
    times = np.linspace(0.0, hit.duration, 300)
    for name, called in zip(names, [*hit.error][-len(names) :], strict=True):
        mine, known = (WANTED[name][1](of, times) for of in (as_meshed(hit).target, right))
        assert np.nanmax(np.abs(mine - known)) <= 2e-2 * np.nanmax(np.abs(known))
        assert hit.error[called].model <= 2e-2
        assert name.startswith(called.removesuffix("_2"))
    assert as_meshed(hit).models[1].n < whole.n / 2


def test_a_record_is_long_enough_for_the_filter(plate: Any) -> None:
    hit = strike(plate, quantity=ao.AccelerationAt(POINT, DOWN, cfc=1000), rtol=5e-2)
    assert hit.duration > hit.contacts[-1][1] + 4.0 / 2077.5


def test_without_a_filter_a_warning_says_why(plate: Any) -> None:
    with pytest.warns(ao.AOImpactWarning, match="cfc="):
        assert ao.AccelerationAt(POINT, DOWN).cfc == 1000.0


@pytest.mark.parametrize("name", [pytest.param("reaction", marks=pytest.mark.slow), "stress"])
def test_in_a_scene_the_body_is_found(plate: Any, name: str) -> None:
    quantity, read, duration = WANTED[name]
    scene = ao.Scene()
    ball = scene.add(ao.rigid(mass=0.01), velocity=1.0)
    target = scene.add(plate)
    scene.connect(ball, target, LAW)
    given = {"duration": duration, "quantity": quantity(plate), "rtol": 5e-2}
    run, one = scene.simulate(**given), strike(plate, **given)
    ours, theirs = (read(of, np.linspace(0.0, 2e-4, 50)) for of in (run[target], one.target))
    np.testing.assert_allclose(ours, theirs, atol=1e-6 * np.abs(theirs).max())


def test_a_place_of_another_body_is_refused(plate: Any) -> None:
    with pytest.raises(ao.InputError, match=r"^quantity"):
        strike(plate, quantity=ao.StressAt(copy.copy(plate.body), POINT))


BAR = ao.FEModel.from_mesh(
    ao.box_mesh((0.1, 0.01, 0.01), (5, 1, 1)), ALUMINIUM, fixed=[("xmin", "xyz")]
)


@pytest.mark.parametrize(
    ("sensor", "named"),
    [
        (ao.AccelerationAt((0.05, 0, 0), DOWN, cfc=1e6), r"^cfc"),
        (ao.ReactionAt("xmax", DOWN), "fixed="),
    ],
)
def test_what_a_sensor_lacks_is_named_where_its_body_is_found(sensor: Any, named: str) -> None:
    with pytest.raises(ao.InputError, match=named):
        strike(BAR.contact(dof=2), quantity=sensor)
