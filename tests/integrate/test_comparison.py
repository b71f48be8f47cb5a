"""The tolerance over many contacts: kept where numbers carry it, and said where not."""

import math
import warnings

import numpy as np
import pytest

import aoimpact as ao

MASS, STIFFNESS, GRAVITY = 0.0327, 1e10, 9.81
WALL = ao.rigid(mass=math.inf)


def bounce(stiffness=STIFFNESS):
    """Peak force, time in contact and in free motion of a ball that meets the floor at 1 m/s."""

    def surplus(depth):
        return 0.4 * stiffness * depth**2.5 - 0.5 * MASS - MASS * GRAVITY * depth

    depth = (1.25 * MASS / stiffness) ** 0.4
    for _ in range(20):  # Newton
        depth -= surplus(depth) / (stiffness * depth**1.5 - MASS * GRAVITY)
    fall, press = 2.0 * GRAVITY * depth, 0.8 * stiffness / MASS * depth**2.5

    # Over δ = depth cos² θ the energy gives dt as a smooth function of θ.
    nodes, weights = np.polynomial.legendre.leggauss(60)
    cos = np.cos(0.25 * math.pi * (1.0 + nodes))
    root = np.sqrt(press * (1.0 + cos + cos**2 + cos**3 + cos**4) / (1.0 + cos) - fall)
    time = 0.25 * math.pi * float(weights @ (4.0 * depth * cos / root))
    return stiffness * depth**1.5, time, 2.0 / GRAVITY


def bouncing(count, rtol, stiffness=STIFFNESS):
    scene = ao.Scene(gravity=GRAVITY)
    ball, floor = scene.add(ao.rigid(mass=MASS), velocity=1.0), scene.add(WALL)
    scene.connect(ball, floor, ao.Hertz(k=stiffness))
    _, touch, free_time = bounce(stiffness)
    duration = (count - 0.5) * (touch + free_time)
    run = scene.simulate(duration=duration, solver=ao.Adaptive(rtol=rtol), energies=False)
    return run, ball


def largest_error(run, ball, stiffness=STIFFNESS):
    """The largest error of peak force, times, impulse and rebound, by the closed form."""
    peak, touch, free_time = bounce(stiffness)
    spans = np.array(run.contacts[0].intervals)
    starts = (touch + free_time) * np.arange(len(spans))
    impulse = len(spans) * MASS * (2.0 + GRAVITY * touch)
    rebound = run.at([spans[-1, 1]])[ball].velocity[0]
    return max(
        abs(run.contacts[0].peak_force / peak - 1.0),
        abs(spans[1:, 0] / starts[1:] - 1.0).max(),
        abs(spans[:, 1] / (starts + touch) - 1.0).max(),
        abs(run.contacts[0].impulse / impulse - 1.0),
        abs(rebound + 1.0),
    )


@pytest.mark.parametrize("count", [2, 10, 100])
@pytest.mark.parametrize("rtol", [1e-3, 1e-6, 1e-9, 1e-12])
def test_every_bounce_of_a_ball_is_within_the_tolerance(count, rtol):
    run, ball = bouncing(count, rtol)
    assert len(run.contacts[0].intervals) == count
    assert run.error.time == rtol
    assert largest_error(run, ball) <= rtol


@pytest.mark.slow
@pytest.mark.parametrize(("count", "rtol"), [(1000, 1e-12), (10_000, 1e-11), (10_000, 1e-12)])
def test_what_rounding_does_to_many_bounces_is_said(count, rtol):
    """Each bounce is rounded as the one before: doubles have no more digits to give."""
    with pytest.warns(ao.AOImpactWarning, match=r"^rtol"):
        run, ball = bouncing(count, rtol)
    assert largest_error(run, ball) <= run.error.time < 1e-14 * count


def test_balls_between_walls_exchange_what_momentum_and_energy_say():
    """Two balls between two walls: a chain of elastic collisions, each in closed form."""
    masses, speeds, gap = np.array([0.03, 0.05]), np.array([1.0, -0.3]), 0.01
    scene = ao.Scene()
    left, right = scene.add(WALL), scene.add(WALL)
    balls = [scene.add(ao.rigid(mass=m), velocity=v) for m, v in zip(masses, speeds, strict=True)]
    law = ao.Hertz(k=1e9)
    scene.connect(left, balls[0], law, gap=gap)
    scene.connect(balls[0], balls[1], law, gap=gap)
    scene.connect(balls[1], right, law, gap=gap)
    run = scene.simulate(duration=0.3, solver=ao.Adaptive(rtol=1e-9), energies=False)
    order = sorted((start, i) for i, of in enumerate(run.contacts) for start, _ in of.intervals)
    assert len(order) > 20
    v = speeds.copy()
    for _, contact in order:
        if contact == 1:
            v = 2.0 * (masses @ v) / masses.sum() - v
        else:
            v[contact // 2] *= -1.0
    ends = [run[ball].velocity[-1] for ball in balls]
    np.testing.assert_allclose(ends, v, atol=1e-9)
    assert run.error.time == 1e-9


def swinging_table():
    """Holmes (1982): each bounce multiplies what is wrong with the table's place by far more."""
    scene = ao.Scene(gravity=GRAVITY)
    ball = scene.add(ao.rigid(mass=MASS), velocity=1.0)
    table = scene.add(ao.AOModel(m0=1.0, k0=1e4))
    scene.connect(ball, table, ao.Hertz(k=1e9))
    return scene, ball


def test_a_ball_on_a_swinging_table_is_chaos_and_called_so():
    """Whether or not two runs end near each other by chance."""
    scene, ball = swinging_table()
    runs, called = [], 0
    for rtol in (1e-4, 3e-5, 2e-5, 1e-5, 8e-6):
        with warnings.catch_warnings(record=True) as said:
            warnings.simplefilter("always")
            runs.append(scene.simulate(duration=8.0, solver=ao.Adaptive(rtol=rtol), energies=False))
        told = any(f"rtol={rtol:g} cannot be met over" in str(w.message) for w in said)
        called += told and runs[-1].error.time > 0.01
    assert called == 5
    one, other = (run.at(np.linspace(6.0, 8.0, 200))[ball].velocity for run in runs[:2])
    assert np.abs(one - other).max() > 0.1  # at a single time they may be near by chance
