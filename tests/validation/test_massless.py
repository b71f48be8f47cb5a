"""Several contacts on one contact point without mass, against SciPy's integrators.

The point's place follows from the forces on it. Without dashpots they balance; where a dashpot
acts, they give the velocity of the point.
"""

from dataclasses import dataclass, replace

import numpy as np
import pytest
import scipy.integrate
import scipy.linalg
import scipy.optimize
from campaign.case import Body, Case, Contact, Law
from campaign.oracle import Oracle
from rigid_pair import against_a_wall

import aoimpact as ao

RTOL = 1e-8
HERTZ, LINE = Law("Hertz", {"k": 1e10}), Law("Linear", {"k": 1e8})
DAMPED = Law("KelvinVoigt", {"k": 1e8, "c": 1e3, "end": "force"})
TSUJI = Law("Tsuji", {"k": 1e10, "alpha": 0.3, "mass": 1.0})
PAIRS = {
    "two springs": (HERTZ, HERTZ),
    "two dashpots": (DAMPED, replace(DAMPED, arguments=DAMPED.arguments | {"k": 5e7, "c": 3e3})),
    "spring, dashpot": (HERTZ, DAMPED),
    "dashpot, spring": (DAMPED, HERTZ),
    "dashpot without force at first, spring": (TSUJI, LINE),
}


@pytest.mark.slow
@pytest.mark.parametrize("name", PAIRS)
def test_two_contacts_on_a_massless_point(name):
    """Balls of 1 kg at 1 m/s, the second 0.1 mm behind, by the campaign's integration."""
    balls = Body(1.0, velocity=1.0), Body(1.0, velocity=1.0)
    contacts = tuple(Contact(i + 1, 0, law, i * 1e-4) for i, law in enumerate(PAIRS[name]))
    case = Case((Body(0.0, m=(1.0,), k=(1e8,)), *balls), contacts, duration=6e-4)
    known = Oracle(case, rtol=1e-9).run()
    run = case.build().simulate(duration=case.duration, solver=ao.Adaptive(rtol=RTOL))
    assert run.error.energy < 1e-6
    for i, events in enumerate(run.events):
        (touch,) = known.touches[i]
        assert events.peak_force == pytest.approx(known.peaks[i], rel=1e-6)
        assert events.impulse == pytest.approx(known.impulses[i], rel=1e-6)
        assert events.contacts == (pytest.approx((touch.start, touch.end), rel=1e-6),)


@pytest.mark.parametrize("gap", [0.0, 1e-6])
def test_a_constant_load_that_sets_in_on_a_point_held_by_a_dashpot(gap):
    """x' = v, m v' = k (u - x), c u' = k (x - u) + load - k_c (u - gap): linear, from u = gap."""
    m, k, load, stiffness, c = 1.0, 1e6, 100.0, 2e6, 300.0
    body, law = ao.AOModel(m0=0.0, m=[m], k=[k]), ao.KelvinVoigt(stiffness, c)
    scene, _ = against_a_wall(body, law, load, gap=gap, velocity=0.1)
    run = scene.simulate(duration=1e-3, solver=ao.Adaptive(rtol=RTOL))
    matrix = np.zeros((4, 4))
    matrix[0, 1] = 1.0
    matrix[1, :3] = [-k / m, 0.0, k / m]
    matrix[2] = [k / c, 0.0, -(k + stiffness) / c, (load + stiffness * gap) / c]
    start = np.array([0.0, 0.1, gap, 1.0])
    states = np.array([scipy.linalg.expm(matrix * t) @ start for t in run.t[::4]])
    wanted = k * (states[:, 0] - states[:, 2]) + load
    assert wanted.min() > 0.0
    assert run.contacts[0].force[0] == pytest.approx(load - k * gap, rel=1e-9)
    np.testing.assert_allclose(run.contacts[0].force[::4], wanted, rtol=1e-7)


def test_a_dashpot_is_relieved_from_the_touch_of_another_ball_on():
    """Alone it is linear: c (x' - u') + k (x - u) = sum of k_j (u - x_j), the point's place u."""
    mass, k, c, gap = 0.7, 3e4, 1.3e4, 7.6e-5
    masses, springs = [2.0, 1.0], [1.5e4, 3.7e4]
    matrix = np.zeros((7, 7))  # x, x1, x2, their velocities, u
    matrix[:3, 3:6] = np.eye(3)
    matrix[6, :4] = [k / c, springs[0] / c, springs[1] / c, 1.0]
    matrix[6, 6] = -(k + sum(springs)) / c
    for j in range(2):
        matrix[4 + j, [1 + j, 6]] = -springs[j] / masses[j], springs[j] / masses[j]
    pushed = np.array([0.0, springs[0], springs[1], 0.0, 0.0, 0.0, -sum(springs)])  # - force
    matrix[3] = pushed / mass
    scene = ao.Scene()
    point = scene.add(ao.AOModel(m0=0.0, m=masses, k=springs))
    scene.connect(scene.add(ao.rigid(mass=mass), velocity=1.0), point, ao.KelvinVoigt(k, c))
    scene.connect(scene.add(ao.rigid(mass=10.0), velocity=2.0), point, ao.Hertz(6e10), gap=gap)
    run = scene.simulate(duration=3e-3)
    touch = run.events[1].contacts[0][0]
    state = scipy.linalg.expm(matrix * touch) @ np.array([0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0])
    assert 2.0 * touch - state[6] == pytest.approx(gap, rel=1e-9)
    assert run.events[0].peak_time == pytest.approx(touch, rel=1e-9)
    assert run.events[0].peak_force == pytest.approx(-pushed @ state, rel=1e-7)
    then = run.at([touch])
    assert then.contacts[0].force[0] == pytest.approx(-pushed @ state, rel=1e-7)
    assert then.energy.total[0] == pytest.approx(run.energy.total[0], rel=1e-9)


@dataclass(frozen=True)
class Ball:
    """A mass, kg, that moves at a velocity, m/s, and meets the point under a law across a gap."""

    law: ao.ContactLaw
    mass: float
    velocity: float
    gap: float = 0.0


def crowd(point: ao.AOModel, balls: tuple[Ball, ...]) -> ao.Scene:
    """Balls that move up meet the point from below, others from above."""
    scene = ao.Scene()
    body = scene.add(point)
    for ball in balls:
        other = scene.add(ao.rigid(mass=ball.mass), velocity=ball.velocity)
        pair = (other, body) if ball.velocity > 0.0 else (body, other)
        scene.connect(*pair, ball.law, gap=ball.gap)
    return scene


def held(k0: float) -> ao.AOModel:
    return ao.AOModel(m0=0.0, k0=k0, m=[1.0, 1.0], k=[1e8, 1e8])


LINEAR = ao.Linear(1e8)
DEPTHS = np.linspace(0.0, 3e-3, 200)[1:]
TABLE = ao.Tabulated(DEPTHS, 1e10 * DEPTHS**1.5)


def held_to_its_curve(run) -> None:
    """No peak is above the force at its time, nor below the curve."""
    largest = max(contact.peak_force for contact in run.contacts)
    for i, contact in enumerate(run.contacts):
        beside = np.array([contact.peak_time * (1.0 + shift) for shift in (-1e-12, 0.0, 1e-12)])
        there = run.at(np.unique(beside.clip(0.0, run.duration))).contacts[i].force.max()
        most = max(float(there), float(contact.force.max()))
        assert contact.peak_force == pytest.approx(most, abs=1e-4 * largest)


PULL = ao.KelvinVoigt(3.66e9, 1.1e4, end="indentation")

# Compliance of the point, m/N, and balls; a pull ends beside what presses, or has let go.
SNAPS = {
    "between two that press": (
        7.27e-9,
        (
            Ball(ao.Hertz(8.57e12), 8.57, -1.195),
            Ball(ao.HuntCrossley(3.13e11, 0.5), 0.313, 1.113, 1e-5),
            Ball(PULL, 0.366, 0.655),
        ),
    ),
    "over one that has overlapped and goes on": (
        1.3211e-9,
        (
            Ball(ao.KelvinVoigt(9.843e9, 2.953e4, end="indentation"), 0.9843, 0.57546, 2e-5),
            Ball(ao.Tsuji(2.654e12, 0.3, mass=2.654), 2.654, 0.8405),
            Ball(ao.Hertz(1.735e11), 0.1735, -0.7797, 1e-5),
            Ball(ao.KelvinVoigt(2.575e10, 7.725e4, end="indentation"), 2.575, -0.45276, 1e-5),
        ),
    ),
}


@pytest.mark.parametrize("name", SNAPS)
def test_a_place_that_snaps_back_is_the_limit_of_a_small_mass(name):
    """A place that has let go but still overlaps takes the force of one that comes back at once."""
    compliance, balls = SNAPS[name]
    runs = []
    for m0, rtol in ((1e-8, 1e-7), (0.0, 1e-4), (0.0, 1e-7), (0.0, 1e-9)):
        point = ao.AOModel(m0=m0, m=[1.0], k=[1.0 / compliance])
        runs.append(crowd(point, balls).simulate(duration=1e-4, solver=ao.Adaptive(rtol=rtol)))
    for run in runs[1:]:
        held_to_its_curve(run)
        for one, other in zip(run.events, runs[0].events, strict=True):
            assert one.impulse == pytest.approx(other.impulse, rel=1e-5)


@pytest.mark.parametrize("rtol", [1e-6, 1e-8])
@pytest.mark.parametrize(
    "law",
    [
        ao.HuntCrossley.from_restitution(1e14, 0.77, 7.0, n=2.5, formula="gonthier"),
        ao.Tsuji(1e12, 0.3, mass=1.0),
        ao.KelvinVoigt(1e10, 1e3),
    ],
)
def test_a_point_at_rest_that_is_let_go_has_the_force_of_its_rest_at_first(law, rtol):
    """Its dashpot gives way within less than any other time of the scene."""
    point = ao.AOModel(m0=0.0, m=[2.0], k=[6e13])
    scene, _ = against_a_wall(point, law, ([0.0, 1e-5], [3e5, 0.0]))
    run = scene.simulate(duration=5e-5, preload=True, solver=ao.Adaptive(rtol=rtol))
    assert run.at([0.0]).contacts[0].force[0] == pytest.approx(3e5, rel=3.0 * rtol)


@pytest.mark.parametrize("dt", [1e-6, 5e-8])
def test_newmark_lets_a_pull_on_a_massless_point_end(dt):
    point = ao.AOModel(m0=0.0, m=[1.0, 0.1], k=[3e7, 1e7])
    balls = (
        Ball(ao.KelvinVoigt(1e8, 3e2, end="indentation"), 0.5, 0.9),
        Ball(LINEAR, 1.2, 0.6, 1e-5),
        Ball(TABLE, 0.4, -0.8, 1e-5),
    )
    runs = [
        crowd(point, balls).simulate(duration=6e-4, solver=solver)
        for solver in (ao.Adaptive(rtol=1e-7), ao.Newmark(dt=dt, estimate=False))
    ]
    for one, other in zip(runs[0].contacts, runs[1].contacts, strict=True):
        assert other.peak_force == pytest.approx(one.peak_force, rel=max(5e-3, 3e4 * dt))


@pytest.mark.parametrize("soft", [10.0, pytest.param(100.0, marks=pytest.mark.slow), 1000.0])
@pytest.mark.parametrize("chi", [1.0, pytest.param(2.4, marks=pytest.mark.slow)])
def test_a_ball_that_a_dashpot_lets_go_of_on_a_soft_massless_point(soft, chi):
    """It flies away from where the point's own spring balances the other contact."""
    pushed, held, mass, speed = 500.0, 3000.0, 2e-3, -1.5

    def on_point(t, place):
        return pushed * max(t - place, 0.0) ** 1.5 - place / soft

    def slope(t, y):
        force, depth = max(on_point(t, y[0]), 0.0), y[0] - y[1]
        return [y[2] + (force / (held * depth**1.5) - 1.0) / chi, y[2], force / mass]

    def leaves(t, y):
        return on_point(t, y[0]) if t > 1e-6 else 1.0

    leaves.terminal, leaves.direction = True, -1.0
    closing, first = 1.0 - speed, 1e-9

    def unshared(share):
        damped = 1.0 + chi * closing * share
        return pushed * (1.0 - share) ** 1.5 - held * share**1.5 * damped

    deep = scipy.optimize.brentq(unshared, 0.0, 1.0) * closing * first
    start = [speed * first + deep, speed * first, speed]
    exact = scipy.integrate.solve_ivp(
        slope, (first, 1.0), start, method="Radau", rtol=1e-10, atol=1e-16, events=leaves
    )
    for rtol in (1e-3, 1e-4, 1e-5, 1e-6, 1e-8):
        scene = ao.Scene()
        point = scene.add(ao.AOModel(m0=0.0, m=[1e12], k=[1.0 / soft]))
        plunger = scene.add(ao.rigid(mass=1e12), velocity=1.0)
        ball = scene.add(ao.rigid(mass=mass), velocity=speed)
        scene.connect(plunger, point, ao.Hertz(k=pushed))
        scene.connect(point, ball, ao.HuntCrossley(held, chi))
        run = scene.simulate(duration=1.5 * exact.t[-1], solver=ao.Adaptive(rtol=rtol))
        (interval,) = run.events[1].contacts
        assert interval[1] == pytest.approx(exact.t[-1], rel=max(10.0 * rtol, 1e-7))
        assert run[ball].velocity[-1] == pytest.approx(exact.y[2, -1], rel=max(rtol, 1e-7))


@pytest.mark.parametrize("rtol", [1e-4, 1e-6, 1e-8, 1e-10])
@pytest.mark.parametrize(
    "law",
    [ao.HuntCrossley(1e9, 0.3), ao.HuntCrossley.from_restitution(1e9, 0.5, 1.0, formula="flores")],
    ids=type,
)
def test_a_load_presses_bodies_together_from_rest(law: ao.ContactLaw, rtol: float) -> None:
    """The force begins like t^(9/2), with the same relative error in a step of any length."""
    scene = ao.Scene()
    ball = scene.add(ao.rigid(mass=1.0))
    star = scene.add(ao.AOModel(m0=0.0, k0=1e5, m=[1.0], k=[1e6]))
    scene.connect(ball, star, law)
    scene.apply(ball, force=([0.0, 1e-4], [0.0, 100.0]))
    run = scene.simulate(duration=2e-3, solver=ao.Adaptive(rtol=rtol))
    coarse, fine = (
        scene.simulate(duration=2e-3, solver=ao.Newmark(dt=dt, estimate=False)).contacts[0]
        for dt in (4e-7, 2e-7)
    )
    error = abs(fine.peak_force - coarse.peak_force)
    assert abs(run.contacts[0].peak_force - fine.peak_force) <= error + rtol * fine.peak_force
