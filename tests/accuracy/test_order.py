"""The least orders, for a quantity that is a known function of the orders."""

import re
from types import SimpleNamespace

import numpy as np
import pytest

import aoimpact as ao
from aoimpact.accuracy.order import least_orders

MANY = ao.AOModel(m0=1.0, m=np.ones(200), k=np.arange(1.0, 201.0))


def search(answer, rtol, bodies=(MANY, MANY), contact_time=1e-4):
    """Search with runs whose answer is that function of the orders; and how many runs."""
    runs = []

    def run(models):
        runs.append(models)
        return SimpleNamespace(value=answer(*(model.n for model in models)))

    quantity = SimpleNamespace(
        is_history=False,
        deviation=lambda one, other: np.array([one.value - other.value]) / abs(other.value),
        span=lambda _: contact_time,
        contact_time=lambda _: contact_time,
    )
    found = least_orders(bodies, run=run, quantity=quantity, rtol=rtol)
    return found, len(runs)


@pytest.mark.parametrize("rtol", [1e-1, 1e-2, 1e-3, 1e-6])
def test_exponential_convergence(rtol):
    """Errors e^-n and e^-2m: the least that adds up to the tolerance."""
    found, runs = search(lambda n, m: 1.0 + np.exp(-n) + np.exp(-2.0 * m), rtol)
    n, m = found.orders
    error = np.exp(-n) + np.exp(-2.0 * m)
    assert error <= rtol
    assert error <= found.error <= rtol
    least = min(
        i + j for i in range(40) for j in range(40) if np.exp(-i) + np.exp(-2.0 * j) <= rtol
    )
    assert n + m <= least + 1
    assert runs < 120


def test_any_number_of_bodies():
    """Errors e^-n, e^-2m and e^-3k of three bodies."""
    found, _ = search(
        lambda n, m, k: 1.0 + np.exp(-n) + np.exp(-2.0 * m) + np.exp(-3.0 * k),
        1e-3,
        bodies=(MANY, MANY, MANY),
    )
    error = sum(np.exp(-rate * n) for rate, n in zip((1, 2, 3), found.orders, strict=True))
    assert error <= found.error <= 1e-3
    assert found.orders[0] >= found.orders[1] >= found.orders[2] > 1
    assert sum(found.orders) <= 15


@pytest.mark.parametrize(("rigid", "orders"), [(0.0055, (0, 25)), (0.009, (1, 21))])
def test_a_body_is_rigid_if_a_little_more_of_the_other_makes_up_for_it(rigid, orders):
    """What it leaves of the tolerance takes four orders more of the other, or ten: 0.8^m."""
    found, _ = search(lambda n, m: 1.0 + (rigid if n == 0 else 0.0) + 0.8**m, 1e-2)
    assert found.orders == orders
    assert found.error <= 1e-2


def test_errors_of_waves_that_have_nothing_to_do_with_each_other_do_not_add_up():
    """A history that errs by 0.03 n^-0.7 with phases of its own at each order.

    The changes from one order to the next fall so slowly that their sum is ten times the last.
    """
    times = np.linspace(0.0, 1.0, 2000)

    def wave(n):
        # What a model gives wrong are waves of frequencies about its order.
        random = np.random.default_rng(n)
        phases = random.uniform(0.0, 2.0 * np.pi, 20)
        waves = np.cos(np.multiply.outer(times, np.linspace(5 * n, 10 * n + 5, 20)) + phases)
        return 0.03 * max(n, 1) ** -0.7 * waves.sum(axis=1) / np.sqrt(20)

    quantity = SimpleNamespace(
        is_history=True,
        deviation=lambda one, other: one - other,
        span=lambda _: 1e-4,
        contact_time=lambda _: 1e-4,
    )
    many = ao.AOModel(m0=1.0, m=np.ones(1000), k=np.arange(1.0, 1001.0))
    found = least_orders(
        (many, ao.rigid(mass=1.0)),
        run=lambda models: wave(models[0].n),
        quantity=quantity,
        rtol=3e-3,
    )
    least = next(n for n in range(1, 1000) if np.abs(wave(n)).max() <= 3e-3)
    assert np.abs(wave(found.orders[0])).max() <= 3e-3
    assert found.orders[0] <= 1.5 * least


def test_slow_convergence_is_seen_through():
    """Successive orders 50 and 51 of a sequence 1 + 1/n differ by 4e-4, but err by 2e-2."""
    found, _ = search(lambda n, m: 1.0 + 1.0 / (n + 1), 1e-1)
    assert 1 / (found.orders[0] + 1) <= 1e-1
    assert found.orders[0] <= 11
    assert found.orders[1] == 0


def test_a_pause_does_not_deceive():
    """Orders 6 to 13 give the same answer, as a body does whose next motion is far off."""
    found, _ = search(lambda n, m: 1.0 + (0.2 if n < 14 else 0.0), 1e-2)
    assert found.orders == (14, 0)


def test_what_does_not_converge_is_refused():
    endless = ao.AOModel(m0=1.0, m=np.ones(1000), k=np.arange(1.0, 1001.0))
    with pytest.raises(ao.ConvergenceError, match="the quantity still changes"):
        search(lambda n, m: 1.0 + 0.1 * np.sin(n), 1e-3, bodies=(endless, ao.rigid(mass=1.0)))


def test_a_refusal_names_the_tolerance_that_can_be_had():
    """Errors 0.99^n: the last enlargement still changes 4e-3, the one before changed 2e-2."""
    endless = ao.AOModel(m0=1.0, m=np.ones(2000), k=np.arange(1.0, 2001.0))
    bodies = endless, ao.rigid(mass=1.0)
    with pytest.raises(ao.ConvergenceError, match="take rtol=") as refused:
        search(lambda n, m: 1.0 + 0.99**n, 1e-4, bodies=bodies)
    enough = float(re.search(r"rtol=(\S+) or more", str(refused.value)).group(1))
    assert enough < 0.03
    found, _ = search(lambda n, m: 1.0 + 0.99**n, enough, bodies=bodies)
    assert 0.99 ** found.orders[0] <= enough


def test_a_whole_star_is_the_truth_itself():
    """All of its oscillators are needed, and there is nothing beyond to compare with."""
    small = ao.AOModel(m0=1.0, m=np.ones(8), k=np.arange(1.0, 9.0))
    found, _ = search(lambda n, m: 2.0**n, 1e-6, bodies=(small, ao.rigid(mass=1.0)))
    assert found.orders == (8, 0)
    assert found.error == 0.0
