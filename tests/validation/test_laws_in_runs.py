"""Every law in the solvers, between rigid bodies and ringing ones, over six decades of velocity."""

from __future__ import annotations

import math
from functools import lru_cache
from typing import Any

import numpy as np
import pytest
from every_law import LAWS, MASS, law_of
from rigid_pair import on_a_wall
from rows import each
from scipy.integrate import quad, solve_ivp
from scipy.linalg import expm
from scipy.optimize import brentq

import aoimpact as ao

VELOCITIES = [1e-4, 1e-2, 1.0, 1e2]
WALL = ao.rigid(mass=math.inf)
ADAPTIVE = ao.Adaptive(rtol=1e-8)

# What a step of T/2000 leaves: a force that starts with a jump, or as steeply as d^(1/4), costs
# the rule its second order.
SLACK = {"Tsuji": 5e-5, "pulling KelvinVoigt": 3e-4, "Thornton": 1e-4}


def scene(name: str, velocity: float) -> tuple[ao.ContactLaw, float, dict[str, Any]]:
    """Return the law, about how long it keeps a rigid mass, and what of a run hangs on that."""
    law = law_of(name)
    time = 3.0 * law.stroke(0.5 * MASS * velocity**2) / velocity
    return law, time, {"law": law, "velocity": velocity, "duration": 2.5 * time}


@each("velocity", VELOCITIES)
@each("name", sorted(LAWS))
def test_a_rigid_ball_on_a_wall_gets_its_restitution_back(name: str, velocity: float) -> None:
    law, time, options = scene(name, velocity)
    delivered = ao.restitution(law, MASS, velocity)
    options["duration"] = time * (2.0 + 1.0 / delivered)  # the way out is that much slower
    step = ao.Newmark(dt=time / 2000, estimate=False)
    hit = on_a_wall(mass=MASS, solver=step, **options)
    assert len(hit.contacts) == 1
    assert hit.restitution == pytest.approx(delivered, abs=SLACK.get(name, 1e-5))
    hit = on_a_wall(mass=MASS, solver=ADAPTIVE, **options)
    assert hit.restitution == pytest.approx(delivered, abs=1e-8)


@pytest.mark.filterwarnings("ignore:.*ends in contact")
@each("velocity", VELOCITIES)
@each("name", sorted(LAWS))
def test_bodies_that_ring_lose_what_the_law_takes_and_gain_nothing(
    name: str, velocity: float
) -> None:
    law, time, options = scene(name, velocity)
    w = 2.0 * math.pi / time
    oscillators = np.array([0.7, 0.29]) * MASS
    ball = ao.AOModel(m0=0.01 * MASS, k0=0.0, m=oscillators, k=oscillators * [9 * w**2, 81 * w**2])
    beam = ao.AOModel(m0=MASS, k0=MASS * w**2 / 4, m=[MASS], k=[4 * MASS * w**2])
    step = ao.Newmark(dt=time / 2000, estimate=False)
    hit = ao.simulate(projectile=ball, target=beam, solver=step, **options)
    start = 0.5 * MASS * velocity**2
    energy = hit.energy.kinetic + hit.energy.elastic + hit.energy.contact
    assert np.diff(energy).max() < 1e-6 * start
    assert hit.impulse > 0.5 * MASS * velocity
    if not (law.depends_on_rate or law.has_memory):
        assert energy[-1] == pytest.approx(start, rel=1e-5)
        exact = ao.simulate(projectile=ball, target=beam, solver=ADAPTIVE, **options)
        assert hit.peak_force == pytest.approx(exact.peak_force, rel=1e-4)


@each("law", [ao.Tsuji(k=1e10, alpha=0.3, mass=0.015), ao.KuwabaraKono(k=1e10, A=2e-6)])
def test_a_massless_contact_lets_go_when_the_force_ends(law):
    """Not later, when the bodies part: as the least of masses does, whatever the tolerance."""

    def impact(m0, rtol):
        return {
            "projectile": ao.rigid(mass=0.0327),
            "target": ao.AOModel(m0=m0, m=[0.03], k=[2.757e8]),
            "law": law,
            "velocity": 1.0,
            "duration": 300e-6,
            "solver": ao.Adaptive(rtol=rtol),
        }

    least = ao.simulate(**impact(1e-8, 1e-8)).contact_duration
    cases = [impact(0.0, 10.0**-exponent) for exponent in np.arange(6.0, 12.1, 0.5)]
    found = [ao.simulate(**case).contact_duration for case in cases]
    assert found == pytest.approx([least] * len(cases), rel=2e-6)
    many = ao.simulate_many(cases, keep="contact_duration")
    assert [one["contact_duration"] for one in many] == found


@pytest.mark.filterwarnings("ignore:.*ends in contact")  # the force falls for ever
@each("rtol", [1e-2, 1e-4, 1e-6, 1e-9])
@each("lag", [0.01, 0.07, 0.15])
def test_a_massless_contact_follows_a_damper_within_its_own_time(lag, rtol):
    """The force peaks within a thousandth of the record, while the indentation is smooth.

    A ball on a spring k1 and a damper in series: F'' + F' k1/c + F k1/m = 0 from F = 0, k1 v.
    """
    mass, k1, velocity = 1.0, 1e6, 0.5
    damping = 2.0 * lag * math.sqrt(k1 * mass)
    decay = 0.5 * k1 / damping
    root = math.sqrt(decay**2 - k1 / mass)
    time = math.atanh(root / decay) / root
    peak = k1 * velocity * math.exp(-decay * time) * math.sinh(root * time) / root
    result = ao.simulate(
        projectile=ao.rigid(mass=mass),
        target=ao.AOModel(m0=0.0, k0=0.0, m=[1e12], k=[k1]),
        law=ao.KelvinVoigt(k=1e-6, c=damping),
        velocity=velocity,
        duration=1e3 * time,
        solver=ao.Adaptive(rtol=rtol),
    )
    assert result.peak_force == pytest.approx(peak, rel=rtol)


@lru_cache
def damped_peak(law: ao.ContactLaw, mass: float, velocity: float, deep: float) -> float:
    """Rigid mass and wall, DOP853: v dv/dd = -F(d, v)/m, smooth in w = d^(1/4)."""

    def slope(w, v):
        return -4.0 * w**3 * law.force(w**4, v) / (mass * v)

    def still(w, v):
        return v[0] - 1e-3 * velocity

    still.terminal = True
    options = {"rtol": 1e-11, "atol": 1e-13, "events": still, "dense_output": True}
    way = solve_ivp(slope, (0.0, deep**0.25), [velocity], "DOP853", **options)
    places = np.linspace(0.0, way.t[-1], 20001)
    peak: float = law.force(places**4, way.sol(places)[0]).max()
    return peak


@each("damping", [0.7, 0.7354597560950398, 1.1, 7.0, 10.7, 30.0])
@each("kind", [ao.KuwabaraKono, ao.Tsuji])
@each("rtol", [1e-3, 1e-4, 1e-5, 1e-6, 1e-8])
def test_a_damped_force_that_is_largest_right_after_the_touch_is_found(kind, damping, rtol):
    mass, k, velocity = 1e-3, 1e6, 1.0
    time = (mass**2 / (k**2 * velocity)) ** 0.2
    law = ao.Tsuji(k, damping, mass) if kind is ao.Tsuji else kind(k, 3.0 * damping * time)
    result = on_a_wall(law, mass, velocity, ao.Adaptive(rtol=rtol), duration=15.0 * time)
    peak = damped_peak(law, mass, velocity, 3.0 * velocity * time)
    assert result.peak_force == pytest.approx(peak, rel=rtol)


@each("rtol", [1e-4, 1e-7, 1e-10])
def test_a_spring_without_mass_that_a_pull_lets_go_of_loses_what_it_held(rtol):
    """A ball on a spring in series with a spring and a damper that pulls until its depth is zero.

    c x' + k x = s (y - x), m y'' = -s (y - x): linear, so that a matrix exponential has the moment
    of x = 0. The ball's energy goes into the damper, c x'^2, and what the first spring still holds
    then, that nothing takes over.
    """
    mass, spring, k, c, velocity = 1.0, 1e4, 1e4, 30.0, 1.0
    rates = np.array(
        [
            [-(k + spring) / c, spring / c, 0.0],
            [0.0, 0.0, 1.0],
            [spring / mass, -spring / mass, 0.0],
        ]
    )

    def state(time):
        return expm(rates * time) @ [0.0, 0.0, velocity]

    end = brentq(lambda time: state(time)[0], 0.02, 0.06, xtol=1e-16)
    depth, place, left = state(end)
    held = 0.5 * spring * (place - depth) ** 2

    def heat(time):
        return c * (rates[0] @ state(time)) ** 2

    lost = quad(heat, 0.0, end, epsabs=0.0, epsrel=1e-11)[0] + held
    result = ao.simulate(
        projectile=ao.AOModel(m0=0.0, k0=0.0, m=[mass], k=[spring]),
        target=WALL,
        law=ao.KelvinVoigt(k, c, end="indentation"),
        velocity=velocity,
        duration=0.1,
        solver=ao.Adaptive(rtol=rtol),
    )
    assert held > 0.01 * lost
    assert result.contacts[0][1] == pytest.approx(end, rel=rtol)
    assert result.rebound_velocity == pytest.approx(left, rel=rtol)
    assert result.energy.dissipated[-1] == pytest.approx(lost, rel=rtol)
    assert result.error.energy < rtol
