"""Several contacts on one contact point without mass, against SciPy's integrators.

The point's place follows from the forces on it. Without dashpots they balance at a root of one
equation; where a dashpot acts, at a velocity that is a root of one.
"""

import itertools
import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest
import scipy.integrate
import scipy.linalg
import scipy.optimize

import aoimpact as ao

MASS, K = 1.0, 1e8  # of the oscillator behind the point
GAP, END = 1e-4, 6e-4
RTOL = 1e-8


@dataclass(frozen=True)
class Push:
    """A ball of 1 kg at 1 m/s, from a gap on; its force is k dⁿ + c d^p d', cut at zero."""

    law: ao.ContactLaw
    k: float
    n: float = 1.0
    c: float = 0.0
    p: float = 0.0
    gap: float = 0.0

    def force(self, d: float, rate: float) -> float:
        if d < 0.0:
            return 0.0
        return max(self.k * d**self.n + self.c * d**self.p * rate, 0.0)


def hertz(k: float, gap: float = 0.0) -> Push:
    return Push(ao.Hertz(k), k, 1.5, gap=gap)


def linear(k: float, gap: float = 0.0) -> Push:
    return Push(ao.Linear(k), k, gap=gap)


def kelvin_voigt(k: float, c: float, gap: float = 0.0) -> Push:
    return Push(ao.KelvinVoigt(k, c), k, c=c, gap=gap)


def tsuji(k: float, alpha: float, gap: float = 0.0) -> Push:
    return Push(ao.Tsuji(k, alpha, mass=MASS), k, 1.5, alpha * math.sqrt(MASS * k), 0.25, gap)


CASES = {
    "Hertz, Hertz": (hertz(1e10), hertz(1e10, GAP)),
    "Hertz, Kelvin-Voigt": (hertz(1e10), kelvin_voigt(1e8, 1e3, GAP)),
    "Kelvin-Voigt, Hertz": (kelvin_voigt(1e8, 1e3), hertz(1e10, GAP)),
    "Kelvin-Voigt, Kelvin-Voigt": (kelvin_voigt(1e8, 1e3), kelvin_voigt(5e7, 3e3, GAP)),
    "Tsuji, linear": (tsuji(1e10, 0.3), linear(1e8, GAP)),
    "linear, Tsuji": (linear(1e8), tsuji(1e10, 0.3, GAP)),
}


class Reference:
    """Balls a and b push the massless point of an oscillator: x, v of a, b and it, impulses, place.

    Contacts act from their touch to where their force vanishes; in these scenes none comes back.
    While a dashpot acts, the state has y = d^(p+1) of its contact: smooth where it begins.
    """

    def __init__(self, pushes: tuple[Push, Push]) -> None:
        self.pushes = pushes
        self.state = np.array([0.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 0.0])
        self.on: list[int] = []
        self.over: list[int] = []
        self.peak, self.touch, self.end = [0.0, 0.0], [0.0, 0.0], [0.0, 0.0]

    def damped(self) -> int | None:
        return next((i for i in self.on if self.pushes[i].c > 0.0), None)

    def springs(self, u: float, x: np.ndarray) -> float:
        there = [(self.pushes[i], x[i] - self.pushes[i].gap - u) for i in self.on]
        return sum(push.k * max(d, 0.0) ** push.n for push, d in there)

    def place(self, x: np.ndarray, y: float | None) -> float:
        first = self.damped()
        if first is not None and y is not None:
            push = self.pushes[first]
            return x[first] - push.gap - max(y, 0.0) ** (1.0 / (push.p + 1.0))
        high = max((x[i] - self.pushes[i].gap for i in self.on), default=x[2])
        if high <= x[2]:
            return x[2]
        return scipy.optimize.brentq(
            lambda u: self.springs(u, x) - K * (u - x[2]), x[2], high, xtol=1e-20, rtol=1e-15
        )

    def forces(self, state: np.ndarray) -> tuple[float, float, list[float]]:
        """The point's place, dy/dt and the forces."""
        x, v, y = state[:3], state[3:6], state[8] if len(state) > 8 else None
        u, first = self.place(x, y), self.damped()
        d = [x[i] - push.gap - u for i, push in enumerate(self.pushes)]
        left = K * (u - x[2]) - self.springs(u, x)  # for the dashpots
        dash = {i: self.pushes[i].c * max(d[i], 0.0) ** self.pushes[i].p for i in self.on}
        dash = {i: c for i, c in dash.items() if self.pushes[i].c > 0.0}
        share = dict.fromkeys(dash, left)
        if len(dash) > 1:
            w = (sum(c * v[i] for i, c in dash.items()) - left) / sum(dash.values())
            share = {i: c * (v[i] - w) for i, c in dash.items()}
        force = [0.0, 0.0]
        for i in self.on:
            force[i] = self.pushes[i].k * max(d[i], 0.0) ** self.pushes[i].n + share.get(i, 0.0)
        if first is None:
            return u, 0.0, force
        push = self.pushes[first]
        return u, (push.p + 1.0) * share[first] / push.c, force

    def slope(self, t: float, state: np.ndarray) -> np.ndarray:
        u, rise, force = self.forces(state)
        pulled = K * (u - state[2]) / MASS
        slope = [*state[3:6], -force[0], -force[1], pulled, *force, rise]
        return np.array(slope[: len(state)])

    def depth(self, i: int, state: np.ndarray) -> float:
        return state[i] - self.pushes[i].gap - self.forces(state)[0]

    def left(self, i: int, state: np.ndarray) -> float:
        """Positive while a contact acts, or does not yet."""
        if i not in self.on:
            return -self.depth(i, state)
        return self.forces(state)[2][i] if self.pushes[i].c > 0.0 else self.depth(i, state)

    def event(self, i: int, start: float) -> Any:
        def event(t: float, state: np.ndarray) -> float:
            return self.left(i, state) + (i in self.on and t < start + 1e-9)

        event.terminal, event.direction, event.contact = True, -1, i  # type: ignore[attr-defined]
        return event

    def run(self) -> "Reference":
        time, self.on = 0.0, [0]
        while self.on and time < END:
            state = self.state[:8]
            if (first := self.damped()) is not None:
                u = self.place(state[:3], None) if time == 0.0 else self.u
                d = max(state[first] - self.pushes[first].gap - u, 0.0)
                state = np.append(state, d ** (self.pushes[first].p + 1.0))
            events = [self.event(i, time) for i in (0, 1) if i not in self.over]
            found = scipy.integrate.solve_ivp(
                self.slope, (time, END), state, "DOP853", events=events,
                t_eval=np.linspace(time, END, 5001), rtol=1e-11, atol=1e-16, max_step=2e-6,
            )  # fmt: skip
            ends = [
                (at[-1], y[-1])
                for at, y in zip(found.t_events, found.y_events, strict=True)
                if len(at)
            ]
            time, self.state = max(ends, key=lambda end: end[0]) if ends else (END, found.y[:, -1])
            for state in (*found.y.T, self.state):
                force = self.forces(state)[2]
                self.peak = [max(*both) for both in zip(self.peak, force, strict=True)]
            self.u = self.forces(self.state)[0]
            for event, at in zip(events, found.t_events, strict=True):
                if len(at) and event.contact in self.on:
                    self.on.remove(event.contact)
                    self.over.append(event.contact)
                    self.end[event.contact] = time
                elif len(at):
                    self.on.append(event.contact)
                    self.touch[event.contact] = time
        return self


def struck(pushes, m0=0.0, rtol=RTOL, end=END):
    scene = ao.Scene()
    point = scene.add(ao.AOModel(m0=m0, m=[MASS], k=[K]))
    for push in pushes:
        ball = scene.add(ao.rigid(mass=1.0), velocity=1.0)
        scene.connect(ball, point, push.law, gap=push.gap)
    return scene.simulate(duration=end, solver=ao.Adaptive(rtol=rtol))


@pytest.mark.parametrize("name", CASES)
def test_two_contacts_on_a_massless_point(name):
    run, other = struck(CASES[name]), Reference(CASES[name]).run()
    assert run.error.energy < 1e-6
    for i, events in enumerate(run.events):
        assert events.peak_force == pytest.approx(other.peak[i], rel=1e-6)
        assert events.impulse == pytest.approx(other.state[6 + i], rel=1e-6)
        assert events.contacts == (pytest.approx((other.touch[i], other.end[i]), rel=1e-6),)


@pytest.mark.parametrize("gap", [0.0, 1e-6])
def test_a_constant_load_that_sets_in_on_a_point_held_by_a_dashpot(gap):
    """x' = v, m v' = k (u - x), c u' = k (x - u) + load - k_c (u - gap): linear, from u = gap."""
    m, k, load, stiffness, c = 1.0, 1e6, 100.0, 2e6, 300.0
    scene = ao.Scene()
    body = scene.add(ao.AOModel(m0=0.0, m=[m], k=[k]), velocity=0.1)
    wall = scene.add(ao.rigid(mass=math.inf))
    scene.connect(body, wall, ao.KelvinVoigt(stiffness, c), gap=gap)
    scene.apply(body, force=load)
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


@pytest.mark.parametrize("first", [0, 1])
@pytest.mark.parametrize(
    "law", [ao.Hertz(8e8), ao.HuntCrossley(8e8, 0.5), ao.KelvinVoigt(8.73e6, 1090.0)]
)
def test_a_dashpot_under_a_sudden_load_keeps_its_place_from_another_contact(law, first):
    """k (x - u) + load = c u' + k_c u, of whose place u the other one is a gap away."""
    k, load, stiffness, c, gap = 5000.0, 2000.0, 8.73e6, 1090.0, 5e-7
    scene = ao.Scene()
    body, wall = scene.add(ao.AOModel(m0=0.0, m=[1.0], k=[k])), scene.add(ao.rigid(mass=math.inf))
    ball = scene.add(ao.rigid(mass=2.0))
    pairs = [(wall, ao.KelvinVoigt(stiffness, c), 0.0), (ball, law, gap)]
    for other, of, across in pairs if first == 0 else pairs[::-1]:
        scene.connect(body, other, of, gap=across)
    scene.apply(body, force=load)
    run = scene.simulate(duration=1e-4, solver=ao.Adaptive(rtol=RTOL))
    pressed, struck = run.events[first], run.events[1 - first]
    assert pressed.peak_force == pytest.approx(load, rel=1e-9)
    rate = (k + stiffness) / c  # x has not moved by then
    touch = -math.log1p(-gap * rate * c / load) / rate
    assert struck.contacts[0][0] == pytest.approx(touch, rel=1e-9)


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


@pytest.mark.slow
def test_a_pull_that_ends_beside_a_contact():
    """A dashpot that pulls lets go of a point without mass on which a ball still presses."""
    beside = linear(1e6), Push(ao.KelvinVoigt(1e8, 3e3, end="indentation"), 1e8)
    runs = [struck(beside, m0, rtol=1e-9, end=1.2e-3) for m0 in (0.0, 1e-7)]
    pull = runs[0].events[1].contacts[0]
    assert runs[0].contacts[1].force.min() < -100.0
    assert runs[0].at([pull[1] * (1 + 1e-6)]).contacts[0].force[0] > 100.0
    assert [run.error.energy < 1e-7 for run in runs] == [True, True]
    for one, other in zip(runs[0].events, runs[1].events, strict=True):
        assert one.impulse == pytest.approx(other.impulse, rel=1e-5)


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


# Two balls, the point's masses and springs, tolerance.
SHARED = {
    "a strong dashpot": (
        Ball(ao.KelvinVoigt(8.5e6, 2270.0), 0.456, 2.604),
        Ball(ao.KelvinVoigt(5.4e5, 2.86e5), 0.749, 2.788, 3.39e-6),
        ([1.06, 3.61], [252123.0, 188046.0]),
        2.5e-8,
    ),
    "one that lets go": (
        Ball(ao.HuntCrossley(3.49e8, 3.09), 0.358, 0.5985),
        Ball(ao.KelvinVoigt(67280.0, 52370.0), 0.2958, 1.0518, 1.149e-5),
        ([0.591, 4.185], [2142374.0, 1186918.0]),
        2.3e-9,
    ),
}


@pytest.mark.parametrize("name", SHARED)
def test_what_touches_or_leaves_a_massless_point_only_shares_out_the_force_on_it(name):
    """The point's own springs take the sum of the forces, by its place, which does not jump."""
    first, second, (masses, springs), rtol = SHARED[name]
    run = crowd(ao.AOModel(m0=0.0, m=masses, k=springs), (first, second)).simulate(
        duration=6e-3, solver=ao.Adaptive(rtol=rtol)
    )
    ends = {when for events in run.events for touch in events.contacts for when in touch}
    times = np.array(sorted(ends - {0.0, 6e-3}))
    before, then = (
        sum(contact.force for contact in run.at(at).contacts) for at in (times * (1 - 1e-13), times)
    )
    largest = max(events.peak_force for events in run.events)
    np.testing.assert_allclose(then, before, rtol=0.0, atol=3.0 * rtol * largest)


def held(k0: float) -> ao.AOModel:
    return ao.AOModel(m0=0.0, k0=k0, m=[1.0, 1.0], k=[1e8, 1e8])


HERTZ, TSUJI = ao.Hertz(1e10), ao.Tsuji(1e10, 0.3, mass=1.0)
FLORES = ao.HuntCrossley.from_restitution(1e10, 0.6, 1.0, formula="flores")
LINEAR = ao.Linear(1e8)
DEPTHS = np.linspace(0.0, 3e-3, 200)[1:]
TABLE = ao.Tabulated(DEPTHS, 1e10 * DEPTHS**1.5)

# Point, balls, duration, tolerances.
CROWDS = {
    "a damped and an elastic law, one on each side": (
        held(2269774.351382341),
        (
            Ball(TSUJI, 0.39928371894592163, -1.2931889285004041, 1e-4),
            Ball(HERTZ, 1.3498766285874342, 0.9149725886995592, 1e-4),
        ),
        6e-4,
        (1e-9, 1e-7, 1e-4),
    ),
    "three laws": (
        held(36062434.05447693),
        (
            Ball(TABLE, 1.3793786351804636, 1.1092453238815896, 1e-5),
            Ball(LINEAR, 2.7482138175573816, 0.9644442683614951, 1e-4),
            Ball(FLORES, 0.9293363888563042, -1.0520741333905, 3e-4),
        ),
        6e-4,
        (1e-9, 3e-9, 1e-6),
    ),
    "a run that did not end": (
        held(1891000.0),
        (Ball(FLORES, 0.6791, 1.438), Ball(LINEAR, 0.5878, 1.45, 1e-4)),
        6e-4,
        (1e-9, 1e-8),
    ),
    "light and quick": (
        held(1137000.0),
        (Ball(TSUJI, 0.1543, 0.9564, 1e-5), Ball(HERTZ, 0.1165, -1.312, 1e-5)),
        6e-4,
        (1e-9, 1e-10, 1e-5),
    ),
    "a turn that is noted while another touches": (
        ao.AOModel(m0=0.0, k0=37985.0548392012, m=[0.6857587936900075], k=[12590.532762472649]),
        (
            Ball(
                ao.Thornton(20326531.56824582, 320.30619617593436),
                0.88475799634,
                2.749467887294,
                0.0015981912,
            ),
            Ball(ao.Linear(5071719.278567715), 0.5564037266511, 1.60544027840929, 0.0015981912),
            Ball(
                ao.HuntCrossley.from_restitution(
                    3349439314.5724, 0.2294882987614, 2.87151831455697, n=2.0, formula="lee-wang"
                ),
                1.139244596,
                -0.65863088530773,
                0.00479457360580,
            ),
        ),
        0.010018198905,
        (1e-6, 1e-4),
    ),
}


def held_to_its_curve(run) -> None:
    """No peak is above the force at its time, nor below the curve."""
    largest = max(contact.peak_force for contact in run.contacts)
    for i, contact in enumerate(run.contacts):
        beside = np.array([contact.peak_time * (1.0 + shift) for shift in (-1e-12, 0.0, 1e-12)])
        there = run.at(np.unique(beside.clip(0.0, run.duration))).contacts[i].force.max()
        most = max(float(there), float(contact.force.max()))
        assert contact.peak_force == pytest.approx(most, abs=1e-4 * largest)


def all_alike(runs) -> None:
    """Peaks and impulses, relative to the largest."""
    for what in ("peak_force", "impulse"):
        rows = np.array([[getattr(contact, what) for contact in run.contacts] for run in runs])
        np.testing.assert_allclose(
            rows[1:], rows[:1].repeat(len(rows) - 1, 0), atol=3e-4 * rows.max()
        )


@pytest.mark.parametrize("name", CROWDS)
def test_contacts_on_one_massless_point_at_any_tolerance(name):
    point, balls, duration, tolerances = CROWDS[name]
    runs = []
    for rtol in tolerances:
        run = crowd(point, balls).simulate(duration=duration, solver=ao.Adaptive(rtol=rtol))
        held_to_its_curve(run)
        assert run.error.energy < max(1e-4, 100.0 * rtol)
        runs.append(run)
    all_alike(runs)


def drawn(seed: int) -> ao.Scene:
    """Four balls of .1 to 10 kg under laws that take them some ten microns deep."""
    rng = np.random.default_rng(seed)
    point = ao.AOModel(m0=0.0, m=[1.0], k=[1e10 * 10.0 ** -rng.uniform(0.0, 2.0)])
    balls = []
    for _ in range(4):
        mass = 10.0 ** rng.uniform(-1.0, 1.0)
        k, hertz, c = 1e10 * mass, 1e12 * mass, 0.3e5 * mass
        laws = [
            ao.Hertz(hertz),
            ao.Linear(k),
            ao.HuntCrossley(hertz, 0.5),
            ao.HuntCrossley.from_restitution(hertz, 0.6, 1.0, formula="flores"),
            ao.Tsuji(hertz, 0.3, mass=mass),
            ao.KelvinVoigt(k, c),
            ao.KelvinVoigt(k, c, end="indentation"),
        ]
        velocity = rng.uniform(0.3, 1.3) * rng.choice([-1.0, 1.0])
        balls.append(Ball(laws[rng.integers(7)], mass, velocity, 1e-5 * rng.integers(3)))
    return crowd(point, tuple(balls))


@pytest.mark.parametrize("seed", range(30))
def test_drawn_contacts_on_one_massless_point(seed):
    runs = [
        drawn(seed).simulate(duration=1e-4, solver=ao.Adaptive(rtol=rtol))
        for rtol in (1e-9, 1e-6, 1e-4)
    ]
    for run in runs:
        held_to_its_curve(run)
    all_alike(runs)


@pytest.mark.parametrize("law", [ao.HuntCrossley(1e10, 0.5), ao.KelvinVoigt(1e8, 1e3)])
def test_a_place_that_snaps_back_meets_what_lies_in_its_way(law):
    """A dashpot that pulls lets go of a point, which comes back to a wall."""
    runs = []
    for m0, rtol in ((1e-8, 1e-7), (0.0, 1e-4), (0.0, 1e-9)):
        scene = ao.Scene()
        point = scene.add(ao.AOModel(m0=m0, k0=1e8, m=[1.0], k=[1e6]))
        ball = scene.add(ao.rigid(mass=1.0), velocity=-1.0)
        scene.connect(point, ball, ao.KelvinVoigt(1e8, 2e4, end="indentation"))
        scene.connect(scene.add(ao.rigid(mass=math.inf)), point, law, gap=5e-6)
        runs.append(scene.simulate(duration=6e-4, solver=ao.Adaptive(rtol=rtol)))
    for run in runs[1:]:
        held_to_its_curve(run)
        for one, other in zip(run.events, runs[0].events, strict=True):
            assert one.impulse == pytest.approx(other.impulse, rel=3e-4)


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
    "onto one that pulls too": (
        9.75e-9,
        (
            Ball(ao.KelvinVoigt(2.849e9, 8.547e3, end="indentation"), 0.2849, -0.79675, 1e-5),
            Ball(ao.Linear(8.5276e9), 0.85276, 1.2218),
            Ball(ao.KelvinVoigt(2.214e9, 6.642e3, end="indentation"), 0.2214, 1.0574, 1e-5),
        ),
    ),
    "over one that overlaps": (
        8.658e-9,
        (
            Ball(ao.Tsuji(5.27e12, 0.3, mass=5.27), 5.27, 1.137, 2e-5),
            Ball(ao.KelvinVoigt(7.88e9, 2.364e4, end="indentation"), 0.788, -0.461, 1e-5),
            Ball(ao.Hertz(2.46e11), 0.246, -1.012, 1e-5),
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
    scene = ao.Scene()
    point = scene.add(ao.AOModel(m0=0.0, m=[2.0], k=[6e13]))
    scene.connect(point, scene.add(ao.rigid(mass=math.inf)), law)
    scene.apply(point, force=([0.0, 1e-5], [3e5, 0.0]))
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


STEEP = (0.0145, 7.7e7, 0.0244, 1e6, -6.6, (1.6e-4, 2.6e-4, 8.8e-4))


def impulse_after(edge: float, gap: float) -> float:
    """The impulse on a ball beside a massless point on which a load sets in within `edge` s."""
    mass, stiffness, ball, law, force, (begin, over, end) = STEEP
    times = begin, begin + edge, over

    def slope(t, y):
        load = np.interp(t, times, (0.0, force, 0.0))
        place, there = y[0] + load / stiffness, y[1] - gap
        if there > place:
            place = (stiffness * y[0] + load + law * there) / (stiffness + law)
        push = law * max(there - place, 0.0)
        return [y[2], y[3], stiffness * (place - y[0]) / mass, -push / ball, push]

    state = np.zeros(5)
    for span in itertools.pairwise((0.0, *times, end)):
        most = (span[1] - span[0]) / 50.0
        done = scipy.integrate.solve_ivp(
            slope, span, state, method="DOP853", rtol=1e-10, atol=1e-18, max_step=most
        )
        state = done.y[:, -1]
    return float(state[4])


@pytest.mark.parametrize("gap", [0.0, 5e-8])
@pytest.mark.parametrize("edge", [1e-13, 1e-12, 1e-10])
def test_a_load_that_all_but_jumps_on_a_massless_point(edge, gap):
    """The point follows it at once: its rate at the touch is no measure of the contact's depth."""
    mass, stiffness, ball, law, force, (begin, over, end) = STEEP
    exact = impulse_after(edge, gap)
    for rtol in (1e-3, 1e-4, 1e-5, 1e-6):
        scene = ao.Scene()
        point = scene.add(ao.AOModel(m0=0.0, m=[mass], k=[stiffness]))
        beside = scene.add(ao.rigid(mass=ball))
        scene.connect(beside, point, ao.Linear(law), gap=gap)
        scene.apply(point, force=([begin, begin + edge, over], [0.0, force, 0.0]))
        run = scene.simulate(duration=end, solver=ao.Adaptive(rtol=rtol))
        assert run.contacts[0].impulse == pytest.approx(exact, rel=max(rtol, 1e-8))


@pytest.mark.parametrize(
    "soft", [10.0, *(pytest.param(soft, marks=pytest.mark.slow) for soft in (40.0, 100.0)), 1000.0]
)
@pytest.mark.parametrize("chi", [1.0, 2.4])
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


@pytest.mark.parametrize("rtol", [1e-4, 1e-6, 1e-8])
def test_the_impulse_of_a_touch_that_loads_end_is_the_integral_of_its_force(rtol: float) -> None:
    """The massless point follows its load at once, and the loads soon part the bodies again."""
    scene = ao.Scene()
    ball = scene.add(ao.rigid(mass=0.0809))
    star = scene.add(ao.AOModel(m0=0.0, m=[0.0951, 0.5468, 0.0743], k=[384332, 72031867, 569727]))
    scene.connect(ball, star, ao.Hertz(16526316.0))
    scene.apply(ball, force=([0.0, 1.8156e-3], [0.0, -920.1]))
    scene.apply(star, force=([0.0, 1.83377e-3], [0.0, -276.03]))
    run = scene.simulate(duration=3.6e-3, solver=ao.Adaptive(rtol=rtol))
    ((start, end),) = run.contacts[0].intervals
    # Even in the angle, and smooth at both ends: the trapezoidal rule has all digits.
    angle = np.linspace(0.0, np.pi, 1001)
    times = start + 0.5 * (end - start) * (1.0 - np.cos(angle))
    force = run.at(times).contacts[0].force * 0.5 * (end - start) * np.sin(angle)
    impulse = scipy.integrate.trapezoid(force, angle)
    assert run.contacts[0].impulse == pytest.approx(impulse, rel=rtol)


@pytest.mark.filterwarnings("ignore::aoimpact.AOImpactWarning")
def test_a_load_that_reverses_at_once_cuts_a_dashpot_and_the_run_goes_on() -> None:
    """The massless point flies at 6 km/s while the load falls: steps of 1e-14 s hold its rounding.

    Where they were not lengthened again, the default tolerance took hours.
    """
    scene, duration = ao.Scene(), 1.85e-3
    ball = scene.add(ao.rigid(mass=1.28), velocity=1.5)
    star = scene.add(ao.AOModel(m0=0.0, m=[0.065, 0.019, 0.039], k=[6.3e5, 4e4, 2e4]))
    scene.connect(ball, star, ao.Hertz(1e9), gap=1e-7)
    scene.connect(star, scene.add(ao.rigid(mass=np.inf)), ao.Tsuji(k=1.2e7, alpha=0.3, mass=1.0))
    falls = duration / 3.0 * np.array([0.0, 1.0, 1.0001, 3.0])
    scene.apply(star, force=(falls, [0.0, 1e3, -1e3, 0.0]))
    run = scene.simulate(duration=duration, solver=ao.Adaptive())
    coarse, fine = (
        scene.simulate(duration=duration, solver=ao.Newmark(dt=dt, estimate=False))
        for dt in (4e-8, 2e-8)
    )
    for mine, one, other in zip(run.contacts, fine.contacts, coarse.contacts, strict=True):
        change = abs(one.peak_force - other.peak_force)
        assert abs(mine.peak_force - one.peak_force) <= change + 1e-5 * one.peak_force


@pytest.mark.parametrize("rtol", [1e-8, 1e-10])
def test_a_preloaded_body_that_another_strikes_at_the_start(rtol: float) -> None:
    """Dashpots take up the blow within a time far shorter than any step."""
    scene = ao.Scene()
    pressed = scene.add(ao.AOModel(m0=0.0, m=[0.02, 0.86], k=[5.4e3, 2.1e8]))
    flying = scene.add(
        ao.AOModel(m0=0.0, k0=3.6e5, m=[1.88, 0.179, 0.152], k=[3.15e8, 2.7e5, 1.22e7]),
        velocity=0.66,
    )
    scene.connect(
        pressed,
        scene.add(ao.rigid(mass=np.inf)),
        ao.HuntCrossley.from_restitution(3.5e9, 0.5, 1.0, formula="flores"),
    )
    blow = ao.KelvinVoigt(2.27e8, 33.0, end="indentation")
    scene.connect(flying, pressed, blow, gap=3e-6)
    scene.apply(pressed, force=([0.0, 8e-5], [3456.0, 1728.0]))
    scene.apply(flying, force=([0.0, 1.26e-5], [1485.0, 0.0]))
    given = {"duration": 2.4e-4, "preload": True}
    run = scene.simulate(**given, solver=ao.Adaptive(rtol=rtol))
    coarse, fine = (
        scene.simulate(**given, solver=ao.Newmark(dt=dt, estimate=False)) for dt in (1e-8, 5e-9)
    )
    for mine, one, other in zip(run.contacts, fine.contacts, coarse.contacts, strict=True):
        change = abs(one.peak_force - other.peak_force)
        assert abs(mine.peak_force - one.peak_force) <= change + 1e-6 * one.peak_force
