"""Blows that pass through bodies in touch, under laws of the rate, by SciPy on plain equations."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from functools import cache

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

import aoimpact as ao
from aoimpact.results import Run

Force = Callable[[float, float], float]  # of indentation and its rate, in contact

HERTZ, LINEAR, END = 1e9, 4e7, 1.2e-4
FIRST: tuple[ao.ContactLaw, Force] = (ao.Hertz(HERTZ), lambda d, rate: HERTZ * d**1.5)
SECOND: tuple[ao.ContactLaw, Force] = (ao.Linear(LINEAR), lambda d, rate: LINEAR * d)

DAMPED: dict[str, tuple[ao.ContactLaw, Force]] = {
    "KelvinVoigt": (ao.KelvinVoigt(5e7, 50.0, end="force"), lambda d, rate: 5e7 * d + 50.0 * rate),
    "HuntCrossley": (
        ao.HuntCrossley(2e9, damping=0.4),
        lambda d, rate: 2e9 * d**1.5 * (1.0 + 0.4 * rate),
    ),
    "Tsuji": (
        ao.Tsuji(2e9, alpha=0.1, mass=0.04),
        lambda d, rate: 2e9 * d**1.5 + 0.1 * np.sqrt(0.04 * 2e9) * d**0.25 * rate,
    ),
    "KuwabaraKono": (
        ao.KuwabaraKono(1.5e9, A=1e-6),
        lambda d, rate: 1.5e9 * (d**1.5 + 1.5e-6 * d**0.5 * rate),
    ),
}


def scene_of(
    bodies: Sequence[ao.AOModel], laws: Sequence[ao.ContactLaw], speed: float, pull: float = 0.0
) -> ao.Scene:
    """A row of bodies in touch whose first has the speed; a force pulls the last one away."""
    scene = ao.Scene()
    row = [scene.add(body, velocity=0.0 if i else speed) for i, body in enumerate(bodies)]
    for (one, other), law in zip(itertools.pairwise(row), laws, strict=True):
        scene.connect(one, other, law)
    scene.apply(row[-1], force=pull)
    return scene


def forces_of(run: Run, times: np.ndarray) -> np.ndarray:
    few = run.at(times)
    return np.array([contact.force for contact in few.contacts])


@cache
def rigid_row(
    masses: tuple[float, ...], forces: tuple[Force, ...], speed: float, pull: float = 0.0
) -> tuple[np.ndarray, np.ndarray]:
    """Times, and the forces between rigid bodies, the last of which something pulls away."""
    count, times = len(masses), np.linspace(0.0, END, 301)

    def contact_forces(y: np.ndarray) -> np.ndarray:
        depth, rate = -np.diff(y[:count]), -np.diff(y[count:])
        of = zip(forces, depth, rate, strict=True)
        return np.array([max(force(d, r), 0.0) if d > 0.0 else 0.0 for force, d, r in of])

    def motion(_: float, y: np.ndarray) -> np.ndarray:
        pushed = np.diff(np.concatenate([[0.0], -contact_forces(y), [pull]]))
        return np.concatenate([y[count:], pushed / masses])

    start = np.zeros(2 * count)
    start[count] = speed
    found = solve_ivp(
        motion, (0.0, times[-1]), start, "DOP853", times, rtol=1e-12, atol=1e-16, max_step=1e-6
    )
    return times, np.array([contact_forces(y) for y in found.y.T]).T


@pytest.mark.parametrize("rtol", [1e-4, 1e-7, 1e-10])
@pytest.mark.parametrize("name", sorted(DAMPED))
def test_a_wave_reaches_a_damped_contact(name: str, rtol: float) -> None:
    """There it begins like a high power of time, which no step, however short, makes simpler."""
    masses, laws = (0.15, 0.12, 0.2, 0.17), [FIRST[0], SECOND[0], DAMPED[name][0]]
    scene = scene_of([ao.rigid(mass=mass) for mass in masses], laws, 2.0)
    run = scene.simulate(duration=END, solver=ao.Adaptive(rtol=rtol))
    times, exact = rigid_row(masses, (FIRST[1], SECOND[1], DAMPED[name][1]), 2.0)
    np.testing.assert_allclose(forces_of(run, times), exact, rtol=0, atol=rtol * exact.max())


@pytest.mark.parametrize("rtol", [1e-4, 1e-7, 1e-10])
@pytest.mark.parametrize("name", sorted(DAMPED))
@pytest.mark.parametrize("pull", [0.7, 10.0])
def test_a_wave_catches_up_with_a_body_that_is_pulled_away(
    pull: float, name: str, rtol: float
) -> None:
    """It parts from the one before it, by less than rounding of its place, until the wave comes."""
    masses = (0.2, 1e-3, 0.07)
    bodies = [ao.rigid(mass=mass) for mass in masses]
    scene = scene_of(bodies, [FIRST[0], DAMPED[name][0]], 2.0, pull)
    run = scene.simulate(duration=END, solver=ao.Adaptive(rtol=rtol))
    times, exact = rigid_row(masses, (FIRST[1], DAMPED[name][1]), 2.0, pull)
    np.testing.assert_allclose(forces_of(run, times), exact, rtol=0, atol=rtol * exact.max())


# A body without mass where it is touched, a mass on a spring: what its spring does not take of a
# ball's push passes to the target, whose law says at what rate its place goes.
MASS, SPRING, BALL, TARGET, SPEED = 0.04, 1.3e6, 0.057, 0.24, 1.2
EARLY = 1e-9
STRUCK = HERTZ * SPEED**1.5  # the ball's push is this times t^(3/2) at first

# The law, the rate at which it gives a force at an indentation, and where the place is at first: on
# its spring, or, where a damper of d^(1/2) holds it more, by that.
MASSLESS: dict[str, tuple[ao.ContactLaw, Force, float]] = {
    "HuntCrossley": (
        ao.HuntCrossley(1.17e9, damping=0.5),
        lambda force, d: (force / (1.17e9 * d**1.5) - 1.0) / 0.5,
        STRUCK * EARLY**1.5 / SPRING,
    ),
    "KuwabaraKono": (
        ao.KuwabaraKono(2.4e9, A=1e-6),
        lambda force, d: (force / 2.4e9 - d**1.5) / (1.5e-6 * d**0.5),
        (STRUCK * EARLY**2.5 / 2.5 / (2.4e9 * 1e-6)) ** (2.0 / 3.0),
    ),
}


@cache
def massless_row(rate_of: Force, place: float) -> tuple[np.ndarray, np.ndarray]:
    """Times, and the forces of both contacts, from a place at an early time."""
    times = np.linspace(0.0, 1e-4, 201)[1:]

    def forces(y: np.ndarray) -> tuple[float, float]:
        ball, mass, _, place = y[:4]
        push = HERTZ * max(ball - place, 0.0) ** 1.5
        return push, push - SPRING * (place - mass)

    def motion(_: float, y: np.ndarray) -> np.ndarray:
        push, passed = forces(y)
        rate = y[6] + rate_of(passed, y[3] - y[2])
        pull = push - passed
        return np.array([*y[4:], rate, -push / BALL, pull / MASS, passed / TARGET])

    start = np.array([SPEED * EARLY, 0.0, 0.0, place, SPEED, 0.0, 0.0])
    scale = 1e-15 * np.array([1e-6] * 4 + [1.0] * 3)
    found = solve_ivp(
        motion, (EARLY, times[-1]), start, "Radau", times, rtol=1e-11, atol=scale, max_step=1e-6
    )
    return times, np.array([forces(y) for y in found.y.T]).T


@pytest.mark.parametrize("rtol", [1e-4, 1e-6, 1e-9])
@pytest.mark.parametrize("name", sorted(MASSLESS))
def test_a_massless_body_passes_a_blow_on_to_a_damper(name: str, rtol: float) -> None:
    law, rate_of, place = MASSLESS[name]
    times, exact = massless_row(rate_of, place)
    bodies = [ao.rigid(mass=BALL), ao.AOModel(m0=0.0, m=[MASS], k=[SPRING]), ao.rigid(mass=TARGET)]
    scene = scene_of(bodies, [ao.Hertz(HERTZ), law], SPEED)
    run = scene.simulate(duration=times[-1], solver=ao.Adaptive(rtol=rtol))
    np.testing.assert_allclose(forces_of(run, times), exact, rtol=0, atol=rtol * exact.max())


@pytest.mark.parametrize("rtol", [1e-5, 1e-6, 1e-8])
def test_a_massless_body_lets_go_of_one_side_before_the_other(rtol: float) -> None:
    ball, mass, spring, target, beyond, end = 0.097, 0.096, 2.0e6, 0.15, 8.3e8, 4.5e-4

    def place(y: np.ndarray) -> float:
        def lack(u: float) -> float:
            push = HERTZ * max(y[0] - u, 0.0) ** 1.5 - beyond * max(u - y[2], 0.0) ** 1.5
            return float(push - spring * (u - y[1]))

        return float(brentq(lack, min(y[:3]) - 1e-9, max(y[:3]) + 1e-9, xtol=1e-18))

    def forces(y: np.ndarray) -> tuple[float, float]:
        u = place(y)
        return HERTZ * max(y[0] - u, 0.0) ** 1.5, beyond * max(u - y[2], 0.0) ** 1.5

    def motion(_: float, y: np.ndarray) -> np.ndarray:
        push, passed = forces(y)
        return np.array([*y[3:], -push / ball, (push - passed) / mass, passed / target])

    times, start = np.linspace(0.0, end, 91), [0.0, 0.0, 0.0, 1.7, 0.0, 0.0]
    found = solve_ivp(motion, (0.0, end), start, "DOP853", times, rtol=1e-10, atol=1e-15)
    exact = np.array([forces(y) for y in found.y.T]).T
    assert exact[1, -1] == 0.0 < exact[0, -10]
    bodies = [ao.rigid(mass=ball), ao.AOModel(m0=0.0, m=[mass], k=[spring]), ao.rigid(mass=target)]
    scene = scene_of(bodies, [ao.Hertz(HERTZ), ao.Hertz(beyond)], 1.7)
    run = scene.simulate(duration=end, solver=ao.Adaptive(rtol=rtol))
    np.testing.assert_allclose(forces_of(run, times), exact, rtol=0, atol=rtol * exact.max())


def test_a_pull_that_ends_at_a_massless_place_on_which_others_press_runs() -> None:
    """It is the limit of places that are light."""
    pull = ao.KelvinVoigt(4.6e7, 50.0, end="indentation")
    soft = ao.KelvinVoigt(8.4e6, 19.0, end="indentation")

    def impulses(m0: float) -> list[float]:
        bodies = [ao.rigid(mass=0.22), ao.AOModel(m0=m0, m=[0.05], k=[2e8]), ao.rigid(mass=0.11)]
        run = scene_of(bodies, [pull, soft], 1.0).simulate(duration=5e-4)
        assert run.error.energy < 1e-8
        return [contact.impulse for contact in run.contacts]

    massless = impulses(0.0)
    for m0 in (1e-5, 1e-6):  # the impulses differ by 3 per kg of it
        np.testing.assert_allclose(massless, impulses(m0), rtol=5.0 * m0)
