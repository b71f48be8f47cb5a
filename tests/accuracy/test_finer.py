"""Histories of a model that was made for the force say how wrong they are afterwards."""

from __future__ import annotations

import pickle
import warnings
from functools import cache
from typing import Any

import numpy as np
import pytest

import aoimpact as ao
from aoimpact.base import held_warnings

HISTORIES = ("displacement", "velocity", "centre_displacement", "centre_velocity")
LONG, CONTACT = 8e-4, 7e-5
ALUMINIUM = ao.Material(E=70e9, nu=0.3, rho=2400)
BALL = ao.ball(0.01, ao.Material(E=210e9, nu=0.3, rho=7800))

BEAM, PLATE = (0.3, 0.02, 0.02), (0.2, 0.2, 0.02)
EDGES = [(name, "xyz") for name in ("xmin", "xmax", "ymin", "ymax")]
# Name: size, place in shares of it, supports, elements, and elements of the truth.
BODIES: dict[str, Any] = {
    "cantilever": (BEAM, (0.9, 0.5, 1.0), EDGES[:1], (16, 1, 1), (32, 2, 2)),
    "held plate": (PLATE, (0.5, 0.5, 1.0), EDGES, (10, 10, 1), (14, 14, 2)),
}


@cache
def tip(name: str, *, fine: bool = False) -> ao.ContactPoint:
    size, place, fixed, *cells = BODIES[name]
    mesh = ao.box_mesh(size, cells[fine], kind="hexahedron20")
    body = ao.FEModel.from_mesh(mesh, ALUMINIUM, fixed=fixed)
    return body.contact(point=np.multiply(place, size), direction=(0, 0, -1))


@cache
def right(name: str) -> ao.Result:
    """With smaller elements and many oscillators."""
    return struck(name, 60, fine=True, duration=LONG)


@cache
def struck(name: str, n: int, *, fine: bool = False, **fit: Any) -> ao.Result:
    struck_at = tip(name, fine=fine)
    model = ao.antioscillators(struck_at, n, method="krylov", contact_time=CONTACT, **fit)
    with held_warnings():
        return ao.simulate(BALL, model, 1.0, duration=LONG)


def off(body: Any, exact: Any, name: str) -> float:
    """Return the true error of a history, relative to the largest value."""
    with held_warnings():
        mine, true = (getattr(one, name) for one in (body, exact))
    return float(np.abs(mine - true).max() / np.abs(true).max())


@pytest.mark.parametrize("name", ["cantilever", pytest.param("held plate", marks=pytest.mark.slow)])
@pytest.mark.parametrize("fit", [{}, {"duration": LONG}], ids=["short", "long"])
@pytest.mark.parametrize("n", [3, pytest.param(8, marks=pytest.mark.slow), 16])
def test_the_error_said_of_every_history_is_about_twice_the_true_one(
    name: str, n: int, fit: dict[str, float]
) -> None:
    body = struck(name, n, **fit).at(np.linspace(0.0, LONG, 300)).target
    exact = right(name).at(np.linspace(0.0, LONG, 300)).target
    for history in HISTORIES:
        error = off(body, exact, history)
        assert 0.8 * error < body.error[history].max() < 5.0 * error + 2e-3, history


def test_models_for_the_force_warn_where_the_motion_is_wrong_and_only_there() -> None:
    name = "cantilever"
    hit = struck(name, 3)
    for history in HISTORIES[1::2]:
        what = history.replace("_", " ")
        with pytest.warns(ao.AOImpactWarning, match=rf"^{what}"):
            getattr(hit.target, history)
    early = hit.at(np.linspace(0.0, 0.5 * hit.contact_duration, 20))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for body in (early.target, right(name).target):
            for history in HISTORIES:
                getattr(body, history)


def test_a_body_without_a_mesh_says_what_its_model_leaves_out() -> None:
    """Its own matrices have no other elements, so that all anti-oscillators are the truth."""
    body = tip("cantilever").body
    bare = ao.FEModel(K=body.K, M=body.M, nodes=body.nodes, free=body.free)
    end = bare.contact(point=(0.2625, 0.01, 0.02), direction=(0, 0, -1), radius=0)
    times = np.linspace(0.0, LONG, 300)
    with held_warnings():
        mine, exact = (
            ao.simulate(BALL, of, 1.0, law=ao.Hertz(k=5e9), duration=LONG).at(times).target
            for of in (end, ao.antioscillators(end))
        )
    for name in ("displacement", "velocity"):
        error = off(mine, exact, name)
        assert error < mine.error[name].max() < 5.0 * error, name


def test_a_body_given_by_numbers_has_nothing_to_be_compared_with() -> None:
    hit = ao.simulate(
        ao.rigid(mass=1.0), ao.rigid(mass=2.0), 1.0, law=ao.Hertz(k=1e9), duration=1e-3
    )
    assert not hit.target.error


def test_errors_of_histories_travel() -> None:
    hit = struck("cantilever", 3)
    again = pickle.loads(pickle.dumps(hit))
    for history in HISTORIES:
        np.testing.assert_allclose(again.target.error[history], hit.target.error[history])
