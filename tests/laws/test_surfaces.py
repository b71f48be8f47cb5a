"""Hertz's law from the surfaces of two bodies."""

from __future__ import annotations

import copy
import math
import pickle

import pytest

import aoimpact as ao
from aoimpact.laws import law_between

STEEL = ao.Material(E=210e9, nu=0.3, rho=7800)
ALUMINIUM = ao.Material(E=70e9, nu=0.33, rho=2700)


def test_rigid_balls() -> None:
    one, two = ao.ball(0.01, STEEL), ao.ball(0.03, ALUMINIUM)
    assert one.mass == pytest.approx(4 / 3 * math.pi * 0.01**3 * 7800, rel=1e-14)
    assert one.contact_surface is not None
    assert two.contact_surface is not None
    found = law_between(one.contact_surface, two.contact_surface)
    expected = ao.Hertz.between(STEEL, 0.01, ALUMINIUM, 0.03)
    assert found.law.k == pytest.approx(expected.k, rel=1e-14)
    assert found.law.relative_radius == pytest.approx(0.0075, rel=1e-14)
    assert found.error == 0.0


@pytest.mark.parametrize(
    "remade", [copy.copy, copy.deepcopy, lambda x: pickle.loads(pickle.dumps(x))]
)
def test_copies_keep_the_surface(remade) -> None:  # type: ignore[no-untyped-def]
    ball = ao.ball(0.01, STEEL)
    assert remade(ball).contact_surface == ball.contact_surface
    assert ball.truncated(0).contact_surface == ball.contact_surface


def test_meshed_ball_on_a_plate() -> None:
    ball = ao.FEModel.from_mesh(ao.sphere_mesh(0.01, 0.003), STEEL)
    plate = ao.FEModel.from_mesh(ao.box_mesh((0.1, 0.1, 0.01), (8, 8, 2)), ALUMINIUM)
    one = ball.contact(point=(0.0, 0.0, -0.01), direction=(0, 0, -1)).contact_surface
    two = plate.contact(point=(0.05, 0.05, 0.01)).contact_surface
    assert one is not None
    assert two is not None
    found = law_between(one, two)
    expected = ao.Hertz.between(STEEL, 0.01, ALUMINIUM, math.inf)
    assert found.law.k == pytest.approx(expected.k, rel=found.error)
    assert found.error < 0.01


def test_flat_on_flat() -> None:
    plate = ao.FEModel.from_mesh(ao.box_mesh((0.1, 0.1, 0.01), (8, 8, 2)), ALUMINIUM)
    surface = plate.contact(point=(0.05, 0.05, 0.01)).contact_surface
    assert surface is not None
    with pytest.raises(ao.InputError, match=r"radii inf/inf m .* give law="):
        law_between(surface, surface)
