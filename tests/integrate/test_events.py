"""Events found between the steps, against contacts known in closed form."""

from __future__ import annotations

import numpy as np
import pytest
from records import FloatArray, HalfSine

from aoimpact.integrate import find_impulse
from aoimpact.integrate.events import find_contacts, find_events, find_peak


def observed_order(errors: list[float], refinement: float) -> float:
    """The mean order of convergence over a sequence of refinements."""
    return float(np.log(errors[0] / errors[-1]) / np.log(refinement) / (len(errors) - 1))


def test_half_sine_is_recovered_from_its_samples() -> None:
    hit = HalfSine(gap=1e-3)
    t = hit.times(1501, 1.4)
    events = find_events(t, *hit.motion(t))
    assert events.peak_force == pytest.approx(hit.peak, rel=1e-9)
    assert events.peak_time == pytest.approx(hit.start + 0.5 * hit.duration, rel=1e-6)
    assert events.impulse == pytest.approx(hit.impulse, rel=1e-5)
    ((start, end),) = events.contacts
    assert start == pytest.approx(hit.start, rel=1e-7)
    assert end == pytest.approx(hit.start + hit.duration, rel=1e-7)


def test_peak_between_steps_is_at_least_of_second_order() -> None:
    """An asymmetric bump t² (1 - t): peak 4/27 at 2/3, never on a sample."""
    heights, times = [], []
    for steps in (50, 100, 200, 400):
        t = np.linspace(0.0, 1.0, steps + 1)
        height, time = find_peak(t, t**2 * (1.0 - t))
        heights.append(abs(height - 4.0 / 27.0))
        times.append(abs(time - 2.0 / 3.0))
    assert observed_order(heights, 2.0) > 2.5
    assert observed_order(times, 2.0) > 1.8


def test_peak_of_a_parabola_is_exact_on_uneven_steps() -> None:
    t = np.array([0.0, 0.1, 0.35, 0.5, 0.9, 1.0])
    assert find_peak(t, 3.0 - (t - 0.42) ** 2) == pytest.approx((3.0, 0.42), rel=1e-14)


def test_peak_does_not_overshoot_a_force_that_jumps() -> None:
    """A damper grips at once: the force starts at its peak, and no parabola may top it."""
    t = np.linspace(0.0, 1.0, 11)
    for before in (0.0, 1e-9):  # a touch at a sample has the force of its rounding there
        force = np.where(t > 0.25, np.exp(-t), before)
        height, time = find_peak(t, force)
        assert (height, time) == (force[3], t[3])


@pytest.mark.parametrize("share", [0.01, 0.1, 0.4, 0.6, 1.0])
@pytest.mark.parametrize("steps", [101, 1001, 10001])
@pytest.mark.parametrize("backwards", [False, True])
def test_no_jump_is_topped(share: float, steps: int, backwards: bool) -> None:
    """However little of the force it is, and whether the force jumps up to the peak or down."""
    t = np.linspace(0.0, 1.0, steps)
    force = 2.0 - t - np.where(t > 0.3003, 0.0, 0.3 + share)
    height, _ = find_peak(t, force[::-1] if backwards else force)
    assert height == force.max()


def test_largest_of_several_contacts_is_the_peak() -> None:
    t = np.linspace(0.0, 4.0, 4001)
    force = np.maximum(np.sin(np.pi * t), 0.0) * np.where(t > 2.0, 2.0, 1.0)
    assert find_peak(t, force) == pytest.approx((2.0, 2.5), rel=1e-9)


def test_constant_force_is_its_own_peak() -> None:
    t = np.linspace(0.0, 1.0, 6)
    assert find_peak(t, np.full(6, 2.0))[0] == 2.0


@pytest.mark.parametrize(("rates_known", "order"), [(True, 4.0), (False, 2.0)])
def test_contact_times_converge(rates_known: bool, order: float) -> None:
    """Through values and rates to fourth order, through values alone to second.

    δ = eᵗ - a starts a contact at ln a; the worst of many a, for the error depends on where
    between two steps the zero lies.
    """
    errors = []
    for steps in (10, 20, 40):
        t = np.linspace(0.0, 1.0, steps + 1)
        worst = 0.0
        for a in np.linspace(1.1, 2.6, 200):
            depth, rate = np.exp(t) - a, np.exp(t)
            # Rates of the wrong sign cannot belong to the crossing, and are not used.
            found = find_contacts(t, np.maximum(depth, 0.0), depth, rate if rates_known else -rate)
            worst = max(worst, abs(found[0][0] - np.log(a)))
        errors.append(worst)
    assert observed_order(errors, 2.0) == pytest.approx(order, abs=0.2)


def test_touch_at_the_outset_starts_at_zero_exactly() -> None:
    hit = HalfSine(gap=0.0)
    t = hit.times(101, 1.2)
    assert find_contacts(t, *hit.motion(t))[0][0] == 0.0


def test_contact_cut_off_by_the_record_ends_with_it() -> None:
    hit = HalfSine()
    t = hit.times(101, 0.7)
    ((start, end),) = find_contacts(t, *hit.motion(t))
    assert (start, end) == (0.0, t[-1])


def test_preloaded_contact_starts_with_the_record() -> None:
    t = np.linspace(0.0, 1.0, 101)
    depth = 0.505 - t
    ((start, end),) = find_contacts(t, np.maximum(depth, 0.0), depth, -np.ones_like(t))
    assert start == 0.0
    assert end == pytest.approx(0.505, rel=1e-12)


def test_every_contact_of_a_bouncing_ball_is_found() -> None:
    """δ = sin t: in contact on (0, π), (2π, 3π), ..."""
    t = np.linspace(0.0, 20.0 * np.pi - 1.0, 5003)
    depth = np.sin(t)
    contacts = find_contacts(t, np.maximum(depth, 0.0), depth, np.cos(t))
    expected = [(2.0 * np.pi * j, 2.0 * np.pi * j + np.pi) for j in range(10)]
    np.testing.assert_allclose(contacts, expected, atol=1e-9)


def test_force_that_lets_go_before_the_indentation_does() -> None:
    """A damped law is cut where it would pull: here F = 1 - t/0.503 at a constant indentation."""
    t = np.linspace(0.0, 1.0, 101)
    force = np.maximum(1.0 - t / 0.503, 0.0)
    ((_, end),) = find_contacts(t, force, np.ones_like(t), np.zeros_like(t))
    assert end == pytest.approx(0.503, rel=1e-12)


@pytest.mark.parametrize("depth", [-1.0, 0.0], ids=["apart", "just touching"])
def test_no_contact_has_no_events(depth: float) -> None:
    t = np.linspace(0.0, 1.0, 11)
    events = find_events(t, 0.0 * t, depth + 0.0 * t, 0.0 * t)
    assert events.contacts == ()
    assert (events.peak_force, events.impulse) == (0.0, 0.0)


def newmark_pair(m: tuple[float, float], k: float, velocity: float, dt: float) -> list[FloatArray]:
    """Average acceleration for two masses and a Hertz spring, in a few plain lines."""
    u, v, a, f = np.zeros(2), np.array([velocity, 0.0]), np.zeros(2), 0.0
    force, speed = [0.0], [v.copy()]
    sign = np.array([-1.0, 1.0]) / np.array(m)
    for _ in range(400):
        u_free = u + dt * v + 0.25 * dt**2 * a
        low, high = 0.0, k * max(u_free[0] - u_free[1], 0.0) ** 1.5
        for _ in range(200):  # bisection on the force: the residual rises with it
            f = 0.5 * (low + high)
            step = u_free + 0.25 * dt**2 * sign * f
            low, high = (f, high) if f < k * max(step[0] - step[1], 0.0) ** 1.5 else (low, f)
        u = u_free + 0.25 * dt**2 * sign * f
        v = v + 0.5 * dt * (a + sign * f)
        a = sign * f
        force.append(f)
        speed.append(v.copy())
    return [np.array(force), np.array(speed)]


def test_trapezium_impulse_is_the_momentum_newmark_transfers() -> None:
    """However coarse the step: about fifteen of them here are one contact."""
    masses, dt = (2.0, 3.0), 4e-3
    force, speed = newmark_pair(masses, k=1e5, velocity=0.5, dt=dt)
    impulse = find_impulse(dt * np.arange(len(force), dtype=np.float64), force)
    assert np.count_nonzero(force) < 20
    assert impulse == pytest.approx(masses[1] * speed[-1, 1], rel=1e-13)
    assert impulse == pytest.approx(masses[0] * (0.5 - speed[-1, 0]), rel=1e-13)
