"""The stress at a point as quantity of interest, against all oscillators of the bodies."""

from __future__ import annotations

import copy
import math
from typing import Any

import numpy as np
import pytest

import aoimpact as ao

from twelve import ALL_EDGES, ALUMINIUM, STEEL, box, cube

LAW = ao.Hertz.between(STEEL, 0.01, ALUMINIUM, math.inf)
POINT = (0.05, 0.05, 0.0)


@pytest.fixture(scope="module", params=[ALL_EDGES, None], ids=["held", "free"])
def plate(request: Any) -> Any:
    return box(ALUMINIUM, (0.1, 0.1, 0.005), (6, 6, 1), (0.4, 0.5, 1), request.param)


# Of the whole body after the impact, where it is the point that was asked for.
pytestmark = pytest.mark.filterwarnings("ignore:the stress may be wrong")


def strike(target: Any, **options: Any) -> ao.Result:
    given = {"projectile": cube(STEEL, 0.01), "law": LAW, "velocity": 1.0, "duration": 2e-4}
    return ao.simulate(target=target, **(given | options))


@pytest.mark.parametrize("component", ["xx", pytest.param("von_mises", marks=pytest.mark.slow)])
def test_the_true_error_is_within_the_tolerance(plate: Any, component: str) -> None:
    hit = strike(plate, quantity=ao.StressAt(plate, POINT, component), rtol=2e-2)
    full = strike(ao.antioscillators(plate), projectile=ao.antioscillators(cube(STEEL, 0.01)))
    times = np.linspace(0.0, 2e-4, 200)

    def stress(result: ao.Result) -> Any:
        found = result.target.probe(POINT, times=times).stress
        return found.von_mises if component == "von_mises" else found[component]

    right = stress(full)
    assert np.abs(stress(hit) - right).max() <= 2e-2 * np.abs(right).max()
    assert hit.error.quantity == "stress"
    assert hit.error.reduction <= 2e-2
    assert hit.models[1].n < ao.antioscillators(plate).n / 3


def test_in_a_scene(plate: Any) -> None:
    scene = ao.Scene()
    ball = scene.add(ao.rigid(mass=0.01), velocity=1.0)
    target = scene.add(plate)
    scene.connect(ball, target, LAW)
    wanted = ao.StressAt(plate.body, POINT, "xx")
    run = scene.simulate(duration=2e-4, quantity=wanted, rtol=3e-2)
    one = strike(plate, projectile=ao.rigid(mass=0.01), quantity=wanted, rtol=3e-2)
    times = np.linspace(0.0, 2e-4, 50)
    ours, theirs = (
        body.probe(POINT, times=times).stress["xx"] for body in (run[target], one.target)
    )
    np.testing.assert_allclose(ours, theirs, rtol=1e-6, atol=1e-6 * np.abs(theirs).max())


def test_what_makes_no_sense_is_named(plate: Any) -> None:
    with pytest.raises(ao.InputError, match="component must be"):
        ao.StressAt(plate, POINT, "xX")
    with pytest.raises(ao.InputError, match="point"):
        ao.StressAt(plate, (1.0, 0.0, 0.0))
    with pytest.raises(ao.InputTypeError, match="body must be an FEModel"):
        ao.StressAt(ao.rigid(mass=1.0), POINT)
    with pytest.raises(ao.InputError, match="no mesh"):
        ao.StressAt(ao.FEModel(K=np.eye(3), M=np.eye(3), nodes=np.zeros((1, 3))), POINT)
    other = copy.copy(plate.body)
    with pytest.raises(ao.InputError, match="neither projectile nor target"):
        strike(plate, quantity=ao.StressAt(other, POINT))
