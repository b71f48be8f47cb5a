"""The models of a body of rising order: nested, from rigid to the whole."""

import pytest

import aoimpact as ao
from aoimpact.accuracy import model_hierarchy
from aoimpact.base import held_warnings

from slender import rod


def test_a_rigid_body_does_not_give_way_under_its_patch():
    """So that nothing of the law is taken out for it."""
    ball = ao.FEModel.from_mesh(ao.sphere_mesh(0.01, 0.008), ao.Material(E=210e9, nu=0.3, rho=7800))
    with held_warnings():
        tip = ball.contact(point=(0.01, 0, 0), direction=(1, 0, 0), radius=0.004)
    hierarchy = model_hierarchy(ao.full(tip), 7e-5, None)
    assert hierarchy.model(1).touched_at().patch is tip.patch is not None
    assert hierarchy.model(1).extraction_at() is not None
    assert hierarchy.model(0).extraction_at() is None
    assert hierarchy.model(0).static_mass == pytest.approx(ball.mass, rel=1e-6)


def test_hierarchy_of_a_body_is_nested_and_ends():
    K, M = rod(30, fixed=[0])
    hierarchy = model_hierarchy(ao.full(ao.FEModel(K=K, M=M).contact(dof=29)), 0.3, None)
    assert hierarchy.model(0).label == "wall"
    assert hierarchy.model(4).label == "AO(3)"
    assert hierarchy.model(4) is hierarchy.model(4)
    assert hierarchy.most <= 30
    assert hierarchy.model(30).n == hierarchy.model(10**6).n == 29


def test_slow_motion_is_fitted_where_the_body_has_any():
    """A constrained rod's second natural mode, 3/4 Hz, after an impact of 1/40 period."""
    K, M = rod(200, fixed=[0])
    tip = ao.FEModel(K=K, M=M).contact(dof=199)
    for duration, near in ((None, False), (1e3, True)):
        model = model_hierarchy(ao.full(tip), 0.03, duration).model(14)
        assert (abs(model.frequencies[1] / 0.75 - 1) < 1e-3) == near
