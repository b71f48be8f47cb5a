"""Orders that meet a tolerance, for a quantity that is a known function of the orders."""

import math
import re
from types import SimpleNamespace

import numpy as np
import pytest

import aoimpact as ao
from aoimpact.accuracy import Hierarchy
from aoimpact.accuracy import order as orders_of
from aoimpact.accuracy.order import Search

ROUNDING = 1e-12


def many(n=200):
    return ao.AOModel(m0=1.0, m=np.ones(n), k=np.arange(1.0, n + 1.0)).modal


class Vectors(Hierarchy):
    """Models of a body that is never known whole; it counts the vectors that were made."""

    def __init__(self):
        super().__init__(0, 10**9, self.count)
        self.made = 0

    def count(self, order):
        self.made = max(self.made, order)
        return SimpleNamespace(n=order, alone=None)


@pytest.fixture
def endless(monkeypatch):
    """Bodies whose models take a linear solution for each order."""

    made = orders_of.model_hierarchy
    monkeypatch.setattr(
        orders_of,
        "model_hierarchy",
        lambda body, *fitted: body if isinstance(body, Vectors) else made(body, *fitted),
    )
    return lambda count: tuple(Vectors() for _ in range(count))


def search(answer, rtol, bodies=None, contact_time=1e-4, **given_more):
    """Search with runs whose answer is that function of the orders; and how many runs."""
    runs = []

    def run(models):
        runs.append(models)
        return SimpleNamespace(value=answer(*(model.n for model in models)))

    quantity = SimpleNamespace(
        is_history=False,
        difference=lambda one, other: np.abs(one.value - other.value).max() / abs(other.value),
        span=lambda _: contact_time,
        contact_time=lambda _: contact_time,
    )
    given = (many(), many()) if bodies is None else bodies
    found = Search(given, run=run, quantity=quantity, rtol=rtol, **given_more).proven()
    return found, len(runs)


def two_exponentials(n, m):
    return 1.0 + np.exp(-n) + np.exp(-2.0 * m)


@pytest.mark.parametrize("rtol", [1e-1, 1e-2, 1e-3, 1e-6])
def test_exponential_convergence(rtol):
    """Errors e^-n and e^-2m of AO models given by numbers: orders grow by half at most."""
    found, runs = search(two_exponentials, rtol)
    n, m = found.orders
    error = np.exp(-n) + np.exp(-2.0 * m)
    assert error <= rtol
    assert error - ROUNDING <= found.error <= rtol
    assert max(n, m) <= 1.5 * math.ceil(-math.log(rtol)) + 1
    assert runs < 40


@pytest.mark.parametrize("rtol", [1e-1, 1e-2, 1e-3, 1e-6])
def test_bodies_that_are_never_known_whole_take_few_vectors_more(endless, rtol):
    """The same; at most 2 n + 8 vectors for n oscillators, and the slow body takes more of them."""
    bodies = endless(2)
    found, runs = search(two_exponentials, rtol, bodies)
    n, m = found.orders
    assert np.exp(-n) + np.exp(-2.0 * m) <= found.error <= rtol
    assert bodies[0].made <= 2 * n + 8
    assert n > m
    assert runs < 40


def test_any_number_of_bodies():
    """Errors e^-n, e^-2m and e^-3k of three bodies: the slow one has most oscillators."""
    found, _ = search(
        lambda n, m, k: 1.0 + np.exp(-n) + np.exp(-2.0 * m) + np.exp(-3.0 * k),
        1e-3,
        bodies=(many(), many(), many()),
    )
    error = sum(np.exp(-rate * n) for rate, n in zip((1, 2, 3), found.orders, strict=True))
    assert error - ROUNDING <= found.error <= 1e-3
    assert found.orders[0] >= found.orders[1] >= found.orders[2] > 1


def test_equal_bodies_have_equal_models():
    """A thousand balls are one body to find the order of."""
    ball = many()
    found, runs = search(
        lambda *orders: 1.0 + sum(np.exp(-n) for n in orders) / 1000, 1e-2, bodies=(ball,) * 1000
    )
    assert len(set(found.orders)) == 1
    assert np.exp(-found.orders[0]) <= 1e-2
    assert runs < 20


def test_only_the_body_that_errs_grows(endless):
    bodies = endless(2)
    found, _ = search(lambda n, m: 1.0 + 0.8**n + 0.1**m, 1e-4, bodies)
    assert 0.8 ** found.orders[0] <= 1e-4
    assert bodies[0].made > 2 * bodies[1].made


def wave(n):
    """A history that errs by 0.03 n^-0.7 with phases of its own at each order.

    What a model gives wrong are waves of frequencies about its order.
    """
    times = np.linspace(0.0, 1.0, 2000)
    random = np.random.default_rng(n)
    phases = random.uniform(0.0, 2.0 * np.pi, 20)
    waves = np.cos(np.multiply.outer(times, np.linspace(5 * n, 10 * n + 5, 20)) + phases)
    return 0.03 * max(n, 1) ** -0.7 * waves.sum(axis=1) / np.sqrt(20)


@pytest.mark.parametrize("rtol", [3e-2, 1e-2, 5e-3])
def test_errors_of_waves(endless, rtol):
    """The changes fall so slowly that their sum is ten times the last: they do not add up."""
    quantity = SimpleNamespace(
        is_history=True,
        difference=lambda one, other: np.abs(one - other).max(),
        span=lambda _: 1e-4,
        contact_time=lambda _: 1e-4,
    )
    found = Search(
        endless(1), run=lambda models: wave(models[0].n), quantity=quantity, rtol=rtol
    ).proven()
    true = np.abs(wave(found.orders[0])).max()
    assert true <= found.error <= rtol
    assert found.error <= 5.0 * true


def test_slow_convergence_is_seen_through(endless):
    """Successive orders 50 and 51 of a sequence 1 + 1/n differ by 4e-4, but err by 2e-2."""
    for rtol in (1e-1, 1e-2):
        found, _ = search(lambda n: 1.0 + 1.0 / (n + 1), rtol, endless(1))
        assert 1 / (found.orders[0] + 1) <= rtol
    found, _ = search(lambda n, m: 1.0 + 1.0 / (n + 1), 1e-1)
    assert 1 / (found.orders[0] + 1) <= 1e-1


def test_a_pause_does_not_deceive():
    """Orders 6 to 13 give the same answer, as a body does whose next motion is far off."""
    found, _ = search(lambda n, m: 1.0 + (0.2 if n < 14 else 0.0), 1e-2)
    assert found.orders[0] >= 14


def test_what_does_not_converge_is_refused(endless):
    with pytest.raises(ao.ConvergenceError, match="quantity"):
        search(lambda n: 1.0 + 0.1 * np.sin(n), 1e-3, endless(1))


def test_a_refusal_names_the_tolerance_that_can_be_had(endless):
    """Errors 0.99^n: the last models still differ by 5e-3."""
    with pytest.raises(ao.ConvergenceError, match="rtol") as refused:
        search(lambda n: 1.0 + 0.99**n, 1e-4, endless(1))
    enough = float(re.search(r"rtol=(\S+) or more", str(refused.value)).group(1))
    assert enough < 0.03
    found, _ = search(lambda n: 1.0 + 0.99**n, enough, endless(1))
    assert 0.99 ** found.orders[0] <= enough


def test_the_best_that_there_is_comes_with_its_error(endless):
    """Errors 1/(n + 1): 1e-4 would take 10 000."""
    found, _ = search(lambda n: 1.0 + 1.0 / (n + 1), 1e-4, endless(1), best=True)
    assert found.orders[0] > 80  # where a default search ends
    assert 0.99 / (found.orders[0] + 1) <= found.error < 2e-2
    with pytest.raises(ao.ConvergenceError):  # of what does not settle at all there is no answer
        search(lambda n: 1.0 + 2.0 * np.sin(n), 1e-2, endless(1), best=True)


def test_a_whole_star_is_the_truth_itself():
    """All of its oscillators are needed, and there is nothing beyond to compare with."""
    found, _ = search(lambda n, m: 2.0**n, 1e-6, bodies=(many(8), ao.rigid(mass=1.0).modal))
    assert found.orders == (8, 0)
    assert found.error == 0.0
