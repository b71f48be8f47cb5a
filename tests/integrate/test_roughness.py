"""Laws of the user's own that are not smooth: by how much, and what a tolerance makes of them."""

import math
import re

import numpy as np
import pytest

import aoimpact as ao

K, MASS = 1e10, 0.0327
# m v² / 2 = 2/5 k δ^2.5 at 1 m/s.
PEAK = K * (1.25 * MASS / K) ** 0.6


def hertz(indentation, rate):
    return K * indentation**1.5


def noisy(share):
    random = np.random.default_rng(3)
    return lambda d, rate: hertz(d, rate) * (1.0 + share * random.standard_normal())


def rippled(share):
    """A force with a fast wave on it: the same each time it is asked, as of an inner iteration."""
    return lambda d, rate: hertz(d, rate) * (1.0 + share * math.sin(1e12 * d))


def hit(law, rtol):
    """A ball against a wall, under a law or a function of indentation and rate."""
    if not isinstance(law, ao.ContactLaw):
        law = ao.UserLaw(law, depends_on_rate=False)
    return ao.simulate(
        projectile=ao.rigid(mass=MASS),
        target=ao.rigid(mass=math.inf),
        law=law,
        velocity=1.0,
        duration=200e-6,
        solver=ao.Adaptive(rtol=rtol),
    )


@pytest.mark.parametrize(
    ("function", "rtol"), [(noisy(1e-6), 1e-8), (noisy(1e-3), 1e-3), (rippled(1e-6), 1e-8)]
)
def test_a_law_that_scatters_by_more_than_the_tolerance_is_refused_soon(function, rtol):
    with pytest.raises(ao.ConvergenceError, match=r"^contact"):
        hit(function, rtol)


def test_a_patch_hides_nothing_of_a_rough_law():
    law = ao.UserLaw(noisy(1e-6), depends_on_rate=False).within_patch(1e-10)
    with pytest.raises(ao.ConvergenceError, match=r"^contact"):
        hit(law, 1e-8)


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


@pytest.mark.parametrize("rtol", [1e-5, 1e-6, 1e-7, 1e-8, 1e-11])
def test_a_law_takes_few_steps_or_is_refused_with_a_tolerance_that_serves(rtol):
    """A wave that is resolved where it is as large as the tolerance takes a million steps."""
    asked = 0

    def rippled(d, rate):
        nonlocal asked
        asked += 1
        return hertz(d, rate) * (1.0 + share * math.sin(1e12 * d))

    for share in (0.05 * rtol, 0.3 * rtol, rtol):
        asked, refused = 0, share > 0.2 * rtol
        if refused:
            with pytest.raises(ao.ConvergenceError, match=r"^contact") as said:
                hit(rippled, rtol)
            served = float(re.search(r"take rtol=([^,]*),", str(said.value))[1])
        else:
            served = rtol
        assert hit(rippled, served).peak_force == pytest.approx(PEAK, rel=served)
        assert asked < 300_000


@pytest.mark.parametrize(("share", "refused"), [(5e-6, False), (2e-5, True)])
def test_a_law_too_rough_for_any_tolerance_is_refused(share, refused):
    """Steps grow with the root of the scatter, however loose the tolerance is."""
    law = rippled(share)
    if refused:
        with pytest.raises(ao.ConvergenceError, match=r"^contact"):
            hit(law, 1e-2)
    else:
        assert hit(law, 1e-2).peak_force == pytest.approx(PEAK, rel=1e-2)
