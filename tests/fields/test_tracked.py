"""Bodies at any times of an adaptive run: against the record, and against SciPy."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.sparse as sp
from scipy.integrate import solve_ivp

import aoimpact as ao
from aoimpact.fields.tracked import Tracked
from aoimpact.integrate.to_tolerance import Sampled, solve_adaptive
from aoimpact.scene.bodies import player
from aoimpact.scene.plan import Joint, Load, Plan

BALL = ao.AOModel(m0=0.02, m=[0.4], k=[5e7])
HELD = ao.AOModel(m0=0.01, k0=1e5, m=[0.1, 0.2], k=[1e6, 1e7])
MASSLESS = ao.AOModel(m0=0.0, k0=1e5, m=[0.1, 0.2], k=[1e6, 1e7])
LAW = ao.Hertz(k=1e8)
DURATION = 4e-3
TIMES = np.linspace(0.0, DURATION, 41)
PULSE = np.array([0.0, 1e-3, 3e-3]), np.array([20.0, -50.0, 10.0])


def track_of(target: ao.AOModel, *, loaded: bool = False) -> tuple[Tracked, Tracked]:
    """The ball and the target of an impact at 1 m/s, the target pushed about as well."""
    loads = (Load(1, 0, *PULSE),) if loaded else ()
    players = player("ball", BALL, 1.0), player("target", target, 0.0)
    plan = Plan(players, (1.0, 0.0), (Joint(0, 0, 1, 0, LAW, 0.0),), loads, 0.0, DURATION, True)
    sampled = solve_adaptive(plan, ao.Adaptive(rtol=1e-10))[0]
    assert isinstance(sampled, Sampled)
    return Tracked(sampled.track, plan, 0), Tracked(sampled.track, plan, 1)


# Rows of the record: four of the contact, then six and two of each body.
PORTS = (10, 18)


@pytest.mark.parametrize("target", [HELD, MASSLESS])
def test_the_contact_coordinates_are_those_of_the_record(target: ao.AOModel) -> None:
    times = TIMES[1:]  # when they touch, the force bends
    for tracked, first in zip(track_of(target), PORTS, strict=True):
        rows = tracked.track.sample(times)
        u, v = tracked.observed(None, times)
        size, speed = np.abs(rows[first]).max(), np.abs(rows[first + 1]).max()
        np.testing.assert_allclose(u[0], rows[first], atol=1e-12 * size)
        np.testing.assert_allclose(v[0], rows[first + 1], atol=1e-5 * speed)


def test_all_coordinates_follow_the_equations_of_motion() -> None:
    sizes = (BALL.n + 1, HELD.n + 1)
    parts = [player("body", one, 0.0).stepped().equations for one in (BALL, HELD)]
    K = sp.block_diag([part.K for part in parts]).toarray()
    inverse = 1.0 / np.concatenate([part.M.diagonal() for part in parts])
    n = sum(sizes)
    press, push = np.zeros(n), np.zeros(n)
    press[0], press[sizes[0]], push[sizes[0]] = -1.0, 1.0, 1.0

    def rates(t: float, y: np.ndarray) -> np.ndarray:
        force = 1e8 * max(-press @ y[:n], 0.0) ** 1.5
        forces = press * force + push * np.interp(t, *PULSE)
        return np.concatenate([y[n:], inverse * (forces - K @ y[:n])])

    start = np.concatenate([np.zeros(n), np.ones(sizes[0]), np.zeros(sizes[1])])
    exact = solve_ivp(
        rates, (0.0, DURATION), start, "DOP853", TIMES, rtol=1e-11, atol=1e-14, max_step=1e-5
    ).y
    seen = [tracked.observed(None, TIMES) for tracked in track_of(HELD, loaded=True)]
    places, speeds = (np.concatenate(values) for values in zip(*seen, strict=True))
    np.testing.assert_allclose(places, exact[:n], atol=1e-8 * np.abs(exact[:n]).max())
    np.testing.assert_allclose(speeds, exact[n:], atol=1e-6)


def test_the_force_presses_the_bodies_apart_and_its_rate_is_its_slope() -> None:
    projectile, target = track_of(HELD)
    track = target.track
    np.testing.assert_array_equal(target.force(TIMES)[0], track.sample(TIMES)[0])
    np.testing.assert_array_equal(projectile.force(TIMES), -target.force(TIMES))
    peak, largest = track.events[0].peak_time, track.events[0].peak_force
    around = np.array([0.5 * peak, peak])
    step = 1e-4 * peak
    slope = (target.force(around + step) - target.force(around - step))[0] / (2.0 * step)
    scale = largest / peak
    np.testing.assert_allclose(target.force_rate(around)[0], slope, atol=1e-5 * scale)
    assert abs(target.force_rate(around)[0, 1]) < 1e-4 * scale


def test_loads_are_forces_too() -> None:
    (_, loaded) = track_of(HELD, loaded=True)
    force = loaded.force(TIMES)[0] - loaded.track.sample(TIMES)[0]
    np.testing.assert_allclose(force, np.interp(TIMES, *PULSE), atol=1e-12)


def test_rows_are_products_with_the_coordinates() -> None:
    (_, tracked) = track_of(HELD)
    rows = np.array([[1.0, -2.0, 0.5]])
    for seen, whole in zip(
        tracked.observed(rows, TIMES), tracked.observed(None, TIMES), strict=True
    ):
        np.testing.assert_allclose(seen, rows @ whole)
