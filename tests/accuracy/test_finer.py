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

from twelve import IMPACTS

HISTORIES = ("displacement", "velocity", "centre_displacement", "centre_velocity")
LONG = 2e-3


@cache
def impact(name: str) -> dict[str, Any]:
    projectile, target, law, velocity, _ = IMPACTS[name]()
    return {"projectile": projectile, "target": target, "law": law, "velocity": velocity}


@cache
def right(name: str) -> ao.Result:
    """With all oscillators."""
    with held_warnings():
        return ao.simulate(
            **(impact(name) | {"target": ao.antioscillators(impact(name)["target"])}), duration=LONG
        )


def struck(name: str, n: int, **fit: Any) -> ao.Result:
    tip, time = impact(name)["target"], right(name).contact_duration
    model = ao.antioscillators(tip, n, method="krylov", contact_time=time, **fit)
    with held_warnings():
        return ao.simulate(**(impact(name) | {"target": model}), duration=LONG)


def read(body: Any, name: str) -> np.ndarray:
    with held_warnings():
        history: np.ndarray = getattr(body, name)
    return history


@pytest.mark.parametrize("name", ["tip of a cantilever, for long", "held plate"])
@pytest.mark.parametrize("fit", [{}, {"duration": LONG}], ids=["short", "long"])
@pytest.mark.parametrize("n", [3, 8, 16])
def test_the_error_said_of_every_history_is_about_twice_the_true_one(
    name: str, n: int, fit: dict[str, float]
) -> None:
    body = struck(name, n, **fit).at(np.linspace(0.0, LONG, 300)).target
    exact = right(name).at(np.linspace(0.0, LONG, 300)).target
    for history in HISTORIES:
        mine, true = read(body, history), read(exact, history)
        error = np.abs(mine - true).max() / np.abs(true).max()
        assert 0.8 * error < body.error[history].max() < 5.0 * error + 2e-3, history


def test_a_probe_away_from_the_contact_says_so_too() -> None:
    name = "held plate"
    place = {"point": impact(name)["target"].point + np.array([5e-3, 0.0, 0.0])}
    times = np.linspace(0.0, LONG, 200)
    probe, exact = (
        hit.target.probe(**place, direction=(0, 0, -1), times=times)
        for hit in (struck(name, 3), right(name))
    )
    for history in ("displacement", "velocity"):
        mine, true = read(probe, history), read(exact, history)
        error = np.abs(mine - true).max() / np.abs(true).max()
        assert 0.8 * error < probe.error[history].max() < 5.0 * error
    with pytest.warns(ao.AOImpactWarning, match=r"^velocity"):
        _ = probe.velocity


def test_models_for_the_force_warn_where_the_motion_is_wrong_and_only_there() -> None:
    name = "tip of a cantilever, for long"
    hit = struck(name, 5)
    for history in HISTORIES:
        what = history.replace("_", " ")
        with pytest.warns(ao.AOImpactWarning, match=rf"^{what}"):
            getattr(hit.target, history)
    early = hit.at(np.linspace(0.0, 0.5 * hit.contact_duration, 20))
    cured = struck(name, 30, duration=LONG)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for body in (early.target, cured.target):
            for history in HISTORIES:
                getattr(body, history)


def test_a_body_given_by_numbers_has_nothing_to_be_compared_with() -> None:
    hit = ao.simulate(
        ao.rigid(mass=1.0), ao.rigid(mass=2.0), 1.0, law=ao.Hertz(k=1e9), duration=1e-3
    )
    assert not hit.target.error


def test_errors_of_histories_travel() -> None:
    hit = struck("held plate", 3)
    again = pickle.loads(pickle.dumps(hit))
    for history in HISTORIES:
        np.testing.assert_allclose(again.target.error[history], hit.target.error[history])
