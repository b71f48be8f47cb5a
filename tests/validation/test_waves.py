"""Blows that pass through bodies in touch, under laws of the rate, by SciPy on plain equations."""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

import aoimpact as ao
from aoimpact.results import Run

HERTZ = 1e9


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
