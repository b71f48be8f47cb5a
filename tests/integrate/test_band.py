"""Contacts are solved in an order of the package's own, and read in that of `connect`."""

import math

import numpy as np
import pytest

import aoimpact as ao


def stack(order):
    """A stack of balls on a floor, its contacts connected in that order, pushed at the top."""
    scene = ao.Scene(gravity=9.81)
    balls = [scene.add(ao.rigid(mass=1.0)) for _ in order]
    balls.append(scene.add(ao.rigid(mass=math.inf)))
    for lower in order:
        scene.connect(balls[lower], balls[lower + 1], ao.Hertz(k=1e10))
    scene.apply(balls[0], force=([0.0, 1e-5, 1e-3], [0.0, 100.0, 0.0]))
    return scene, balls


def test_contacts_are_read_in_the_order_in_which_they_were_connected():
    mixed = np.random.default_rng(7).permutation(12)
    times = np.linspace(0.0, 5e-4, 101)
    runs = []
    for order in (range(12), mixed):
        scene, balls = stack(order)
        run = scene.simulate(duration=5e-4, preload=True)
        runs.append((run, run.at(times), run[balls[4]].velocity[-1]))
    (run, at, speed), (other, other_at, other_speed) = runs
    assert other_speed == pytest.approx(speed, rel=1e-8)
    for place, which in enumerate(mixed):
        one, two = run.contacts[which], other.contacts[place]
        assert two.force[0] == pytest.approx(9.81 * (which + 1), rel=1e-9)  # what lies on it
        assert two.peak_force == pytest.approx(one.peak_force, rel=1e-8)
        assert two.impulse == pytest.approx(one.impulse, rel=1e-8)
        assert len(two.intervals) == len(one.intervals)
        scale = one.peak_force
        expected = at.contacts[which].force
        assert other_at.contacts[place].force == pytest.approx(expected, abs=1e-8 * scale)
        depth = np.cbrt(other_at.contacts[place].force / 1e10) ** 2  # of the same contact
        assert other_at.contacts[place].indentation == pytest.approx(depth, rel=1e-6)
    assert np.ptp(other.energy.total) <= 1e-8 * np.ptp(other.energy.contact)
