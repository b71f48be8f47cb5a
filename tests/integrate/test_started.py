"""How runs begin: pressed contacts that are let go, and bodies at rest that a load pulls apart."""

import math

import numpy as np
import pytest
from rigid_pair import against_a_wall
from rows import each

import aoimpact as ao

WALL = ao.rigid(mass=math.inf)
LOAD = 100.0
BODIES = {
    "rigid": ao.rigid(mass=1.0),
    "star": ao.AOModel(m0=1.0, m=[1.0], k=[1e5]),
    "massless": ao.AOModel(m0=0.0, m=[1.0], k=[1e5]),
}


@each("rtol", [1e-3, 1e-6, 1e-8])
@each("law", [ao.Hertz(1e8), ao.Linear(1e6), ao.KelvinVoigt(1e6, 10.0)])
@each("body", BODIES)
def test_a_pressed_contact_that_is_let_go_has_its_peak_at_the_start(body, law, rtol):
    scene, _ = against_a_wall(BODIES[body], law, ([0.0, 1e-3], [LOAD, 0.0]))
    run = scene.simulate(duration=2e-3, solver=ao.Adaptive(rtol=rtol), preload=True)
    assert run.events[0].peak_force == pytest.approx(LOAD, rel=1e-9)
    assert run.events[0].peak_time < 1e-11
    assert run.contacts[0].force[0] == pytest.approx(LOAD, rel=rtol)


M, K = 1.0, 1e5
FREE, SPRUNG = ao.rigid(mass=M), ao.AOModel(m0=M, k0=K)
RATE, RISE, END = 100.0, 1e-2, 2e-2


def cubic(t, mass):
    return np.where(t > 0.0, RATE * np.maximum(t, 0.0) ** 3 / (6.0 * mass), 0.0)


def swing(t, mass, k):
    omega = math.sqrt(k / mass)
    return np.where(t > 0.0, RATE / k * (t - np.sin(omega * t) / omega), 0.0)


# Of a load RATE t for all times; what ends the rise is the same, later and the other way.
PARTED = {
    "rigid | sprung": (FREE, SPRUNG, lambda t: swing(t, M, K)),
    "wall | sprung": (WALL, SPRUNG, lambda t: swing(t, M, K)),
    "rigid | rigid": (FREE, FREE, lambda t: cubic(t, M)),
    "sprung | sprung": (SPRUNG, SPRUNG, lambda t: swing(t, M, K)),
    "rigid | free star": (
        FREE,
        ao.AOModel(m0=M, m=[M], k=[K]),
        lambda t: cubic(t, 2 * M) + 0.5 * swing(t, M, 2 * K),
    ),
}


@pytest.mark.filterwarnings("ignore:.*no contact")
@each("name", PARTED)
def test_a_load_that_rises_from_nothing_pulls_touching_bodies_apart(name):
    one, other, moved = PARTED[name]
    scene = ao.Scene()
    left, right = scene.add(one), scene.add(other)
    scene.connect(left, right, ao.Hertz(1e9), gap=0.0)
    scene.apply(right, force=([0.0, RISE], [0.0, RATE * RISE]))
    run = scene.simulate(duration=END)
    assert run.events[0].contacts == ()
    assert run.events[0].peak_force == 0.0
    assert len(run.t) < 1000
    wanted = moved(run.t) - moved(run.t - RISE)
    np.testing.assert_allclose(run[right].displacement, wanted, atol=1e-11 * wanted.max())
    np.testing.assert_array_equal(run[left].displacement, 0.0)
