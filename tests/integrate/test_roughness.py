"""Laws of the user's own that are not smooth, and what a tolerance makes of them."""

import math

import numpy as np
import pytest
from rigid_pair import on_a_wall

import aoimpact as ao

K, MASS = 1e10, 0.0327
# m v² / 2 = 2/5 k δ^2.5 at 1 m/s.
PEAK = K * (1.25 * MASS / K) ** 0.6


def hertz(indentation, rate):
    return K * indentation**1.5


def noisy(share):
    random = np.random.default_rng(3)
    return lambda d, rate: hertz(d, rate) * (1.0 + share * random.standard_normal())


def hit(law, rtol):
    """A ball against a wall, under a law or a function of indentation and rate."""
    if not isinstance(law, ao.ContactLaw):
        law = ao.UserLaw(law, depends_on_rate=False)
    return on_a_wall(law, MASS, 1.0, ao.Adaptive(rtol=rtol), duration=200e-6)


@pytest.mark.slow
def test_a_law_that_scatters_by_the_tolerance_is_given_up():
    """Each step is as wrong as the one before, however short it is."""
    with pytest.raises(ao.ConvergenceError, match="law"):
        hit(noisy(1e-3), 1e-3)


@pytest.mark.parametrize("compliance", [0.0, 1e-12])
def test_a_law_that_is_meant_to_give_energy_may(compliance):
    """Between two walls a ball gets faster with every touch of F = k d (1 - rate)."""
    law = ao.UserLaw(lambda d, rate: 1e8 * d * (1.0 - min(max(rate, -0.9), 0.9)))
    law = law.within_patch(compliance) if compliance else law
    scene = ao.Scene()
    ball = scene.add(ao.rigid(mass=MASS), velocity=1.0)
    left, right = (scene.add(ao.rigid(mass=math.inf)) for _ in range(2))
    scene.connect(ball, right, law, gap=1e-4)
    scene.connect(left, ball, law, gap=1e-4)
    run = scene.simulate(duration=1e-3, solver=ao.Adaptive(rtol=1e-6))
    assert min(len(contact.intervals) for contact in run.contacts) > 1
    assert run.energy.kinetic[-1] > 2.0 * run.energy.kinetic[0]


@pytest.mark.parametrize("rtol", [1e-2, 1e-5, 1e-8, 1e-11])
def test_a_wave_on_the_force_takes_few_steps_and_errs_by_its_size(rtol):
    asked = 0

    def rippled(d, rate):
        """As of an inner iteration: the same each time it is asked."""
        nonlocal asked
        asked += 1
        return hertz(d, rate) * (1.0 + share * math.sin(1e12 * d))

    for share in (0.05 * rtol, 0.3 * rtol, rtol, 10.0 * rtol):
        asked = 0
        assert hit(rippled, rtol).peak_force == pytest.approx(PEAK, rel=rtol + 1.1 * share)
        assert asked < 200_000
