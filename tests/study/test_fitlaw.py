"""Laws fitted to measurements that are made of known laws."""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import aoimpact as ao
from aoimpact.testrig import Signal

WALL = ao.rigid(mass=math.inf)
RADIUS = 0.01


def history(law: ao.ContactLaw, mass: float, speed: float) -> tuple[Signal, float, float]:
    """Force without noise on a clock of its own, when contact begins on it, and the peak."""
    exact = ao.Adaptive(rtol=1e-9)
    case = {"projectile": ao.rigid(mass=mass), "target": WALL, "law": law, "velocity": speed}
    length = ao.simulate(**case, solver=exact).contact_duration
    begin, t = 0.37 * length, np.linspace(0.0, 2.0 * length, 211)
    hit = ao.simulate(**case, duration=2.0 * length, solver=exact)
    force = np.zeros(len(t))
    force[t > begin] = hit.at(t[t > begin] - begin).force
    return Signal(t, force), begin, hit.peak_force


def noisy(signal: Signal, size: float, rng: np.random.Generator) -> Signal:
    return Signal(signal.t, signal.values + size * rng.normal(size=len(signal.t)))


# ------------------------------------------------------------------- true parameters and errors


def of_history(
    make: Callable[[np.random.Generator, float, float, float, float], ao.ContactLaw],
) -> Callable[[np.random.Generator], tuple[ao.ContactLaw, dict[str, Any], float]]:
    def case(rng: np.random.Generator) -> tuple[ao.ContactLaw, dict[str, Any], float]:
        k, mass = 10.0 ** rng.uniform(8.5, 10.0), 10.0 ** rng.uniform(-2.0, 0.0)
        speed = 10.0 ** rng.uniform(-0.3, 0.7)
        depth = ao.Hertz(k).stroke(0.5 * mass * speed**2)
        law = make(rng, k, mass, speed, depth)
        signal, begin, peak = history(law, mass, speed)
        given = noisy(signal, peak * 10.0 ** rng.uniform(-2.3, -1.0), rng)
        return law, {"law": type(law), "signal": given, "mass": mass, "velocity": speed}, begin

    return case


def plastic(rng: np.random.Generator) -> ao.ElasticPlastic:
    k, force = 10.0 ** rng.uniform(8.5, 10.0), 10.0 ** rng.uniform(1.0, 2.0)
    pressure = 1.5 / math.pi * k * (force / k) ** (1.0 / 3.0) / RADIUS
    return ao.ElasticPlastic(k, force, pressure * rng.uniform(1.5, 2.5), relative_radius=RADIUS)


def off(law: ao.ElasticPlastic, *names: str) -> ao.ElasticPlastic:
    factor = {name: getattr(law, name) * 1.15 for name in names}
    own = {"k": law.k, "yield_force": law.yield_force, "hardness": law.hardness}
    return ao.ElasticPlastic(**{**own, **factor}, relative_radius=RADIUS)


def of_curve(rng: np.random.Generator) -> tuple[ao.ContactLaw, dict[str, Any], float]:
    law = plastic(rng)
    up = np.linspace(0.0, 4.0 * law.plastic_indentation, 120)
    path = np.concatenate([up, up[::-1][1:], 1.2 * up[1:]])
    force = law.force(path, along=True)
    force = force + force.max() * 10.0 ** rng.uniform(-2.3, -1.0) * rng.normal(size=force.shape)
    given = {"law": off(law, "k", "hardness"), "free": ["k", "hardness"]}
    return law, given | {"indentation": path, "force": force}, 0.0


def of_dents(rng: np.random.Generator) -> tuple[ao.ContactLaw, dict[str, Any], float]:
    law, mass = plastic(rng), 0.1
    least = math.sqrt(2.0 * law._work(2.0 * law.plastic_indentation) / mass)
    speeds = least * np.linspace(1.0, 4.0, 20)
    wide = np.array([law.dent(law.stroke(0.5 * mass * v**2)).diameter for v in speeds])
    wide = wide + wide.mean() * 10.0 ** rng.uniform(-2.3, -1.3) * rng.normal(size=wide.shape)
    given = {"law": off(law, "hardness"), "free": "hardness"}
    return law, given | {"dent": wide, "mass": mass, "velocity": speeds}, 0.0


CASES = [
    of_history(lambda rng, k, m, v, d: ao.HuntCrossley(k, rng.uniform(0.1, 0.5) / v)),
    of_history(lambda rng, k, m, v, d: ao.Thornton(k, k * d**1.5 * rng.uniform(0.05, 0.5))),
    of_history(lambda rng, k, m, v, d: ao.YangSun(k, d * rng.uniform(0.1, 0.6))),
    of_history(lambda rng, k, m, v, d: ao.Tsuji.from_restitution(k, rng.uniform(0.5, 0.9), m)),
    of_history(
        lambda rng, k, m, v, d: ao.KelvinVoigt.from_restitution(
            k * math.sqrt(d), rng.uniform(0.5, 0.9), m
        )
    ),
    of_curve,
    of_dents,
]


def deviations(count: int) -> np.ndarray:
    """Of every parameter from the true one, in its standard errors."""
    found = []
    for seed in range(count):
        law, given, begin = CASES[seed % len(CASES)](np.random.default_rng([3, seed]))
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            fit = ao.fit_law(**given)
        for name, error in fit.standard_errors.items():
            timed = name == "start_time"
            true = begin if timed else getattr(law, name)
            fitted = fit.start_time if timed else getattr(fit.law, name)
            if name not in fit.undetermined:
                found.append((fitted - true) / error)
    return np.abs(found)


@pytest.mark.slow
def test_true_parameters_are_within_two_standard_errors() -> None:
    assert 0.9 <= (deviations(21) < 2.0).mean() <= 0.99


@pytest.mark.slow
def test_true_parameters_are_within_two_standard_errors_of_a_thousand_fits() -> None:
    found = deviations(1000)
    assert 0.93 <= (found < 2.0).mean() <= 0.97
    assert (found > 5.0).mean() < 0.005


# ------------------------------------------------------------------- what it says


def test_a_signal_without_noise_gives_the_law_back() -> None:
    law = ao.HuntCrossley(1e9, 0.2)
    signal, begin, _ = history(law, 0.1, 1.0)
    fit = ao.fit_law(ao.HuntCrossley, signal, mass=0.1, velocity=1.0)
    assert fit.law.k == pytest.approx(1e9, rel=1e-6)
    assert fit.law.damping == pytest.approx(0.2, rel=1e-6)
    assert fit.start_time == pytest.approx(begin, rel=1e-6)
    assert list(fit.standard_errors) == ["k", "damping", "start_time"]
    assert fit.correlation == pytest.approx(fit.correlation.T)
    assert np.diag(fit.correlation) == pytest.approx(1.0)
    assert "damping = 200 ms/m ± " in str(fit)


def test_residual_is_the_noise_and_errors_shrink_with_it() -> None:
    signal, _, peak = history(ao.Hertz(1e9), 0.1, 1.0)
    rng = np.random.default_rng(1)
    loud, quiet = (
        ao.fit_law(ao.Hertz, noisy(signal, share * peak, rng), mass=0.1, velocity=1.0)
        for share in (0.05, 0.005)
    )
    assert loud.residual == pytest.approx(0.05 * peak, rel=0.2)
    ratio = loud.standard_errors["k"] / quiet.standard_errors["k"]
    assert ratio == pytest.approx(10.0, rel=0.3)


def test_what_the_data_do_not_determine_is_said() -> None:
    signal, _, peak = history(ao.Hertz(1e9), 0.1, 1.0)
    given = noisy(signal, 0.01 * peak, np.random.default_rng(2))
    with pytest.warns(ao.AOImpactWarning, match="yield_force"):
        fit = ao.fit_law(ao.Thornton(9e8, 5e3), given, mass=0.1, velocity=1.0)
    assert fit.undetermined == ("yield_force",)
    assert fit.law.k == pytest.approx(1e9, rel=0.05)


def test_what_the_law_does_not_describe_is_said() -> None:
    signal, _, peak = history(ao.HuntCrossley(1e9, 0.6), 0.1, 1.0)
    given = noisy(signal, 0.005 * peak, np.random.default_rng(3))
    with pytest.warns(ao.AOImpactWarning, match="velocity"):
        ao.fit_law(ao.Hertz, given, mass=0.1, velocity=1.0)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        ao.fit_law(ao.HuntCrossley, given, mass=0.1, velocity=1.0)


@pytest.mark.filterwarnings("ignore:.*data do not determine", "ignore:.*at the bound")
@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("law", [ao.Hertz, ao.HuntCrossley])
def test_noise_alone_is_said_to_be_that(law: type[ao.ContactLaw], seed: int) -> None:
    noise = Signal(np.linspace(0.0, 1e-3, 300), np.random.default_rng(seed).normal(size=300))
    with pytest.warns(ao.AOImpactWarning, match="start"):
        ao.fit_law(law, noise, mass=0.1, velocity=1.0)


@pytest.mark.filterwarnings("ignore:.*data do not determine", "ignore:PowerLaw is")
def test_a_parameter_at_its_bound_is_said() -> None:
    depth = np.linspace(0.0, 1e-4, 40)
    with pytest.warns(ao.AOImpactWarning, match=r"^n"):
        ao.fit_law(ao.PowerLaw(1e6, 1.5), indentation=depth, force=1e4 * np.sqrt(depth))


def test_parameters_that_are_not_free_are_kept() -> None:
    signal, _, _ = history(ao.HuntCrossley(1e9, 0.2), 0.1, 1.0)
    fit = ao.fit_law(
        ao.HuntCrossley(9e8, 0.1, relative_radius=0.01), signal, mass=0.1, velocity=1.0, free=["k"]
    )
    assert (fit.law.damping, fit.law.relative_radius) == (0.1, 0.01)
    assert list(fit.standard_errors) == ["k", "start_time"]


def test_bodies_that_ring_are_taken_as_they_are() -> None:
    law, exact = ao.HuntCrossley(1e9, 0.2), ao.Adaptive(rtol=1e-9)
    ball = ao.AOModel(m0=0.05, k0=0.0, m=[0.05], k=[5e7])
    hit = ao.simulate(ball, WALL, 1.0, law=law, duration=1e-3, solver=exact)
    signal = Signal.of(hit, rate=5e5)
    fit = ao.fit_law(ao.HuntCrossley, signal, projectile=ball, target=WALL, velocity=1.0)
    assert fit.law.k == pytest.approx(1e9, rel=1e-5)
    alone = ao.fit_law(ao.HuntCrossley, signal, mass=0.1, velocity=1.0)
    assert alone.residual > 100.0 * fit.residual
