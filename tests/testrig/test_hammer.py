"""Hammer tests against a free mass, an oscillator in closed form, noise, and a body's own FRF."""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np
import pytest
from scipy.signal import lsim

import aoimpact as ao

RATE = 50e3
M, K, C = 2.0, 8e6, 80.0  # 318 Hz, damping ratio 0.01


def pulse(n: int = 25_000, start: float = 1e-3, width: float = 1e-3) -> Any:
    t = np.arange(n) / RATE
    inside = (t > start) & (t < start + width)
    return t, np.where(inside, 500.0 * np.sin(np.pi * (t - start) / width) ** 2, 0.0)


def answer(t: Any, force: Any) -> Any:
    """Velocity and acceleration of m x'' + c x' + k x = F, straight between samples."""
    motion = lsim(([1.0, 0.0], [M, C, K]), force, t)[1]
    return motion, lsim(([1.0, 0.0, 0.0], [M, C, K]), force, t)[1]


def velocity(t: Any, values: Any) -> ao.testrig.Signal:
    return ao.testrig.Signal(t, values, unit="m/s", name="velocity")


def test_a_free_mass_has_its_inverse_as_accelerance() -> None:
    """It moves on when the record ends; A/F = 1/m at all frequencies."""
    hit = ao.simulate(
        ao.rigid(mass=0.1), ao.rigid(mass=M), 1.0, law=ao.Linear(k=1e6), duration=0.05
    )
    t = np.linspace(0.0, 0.05, 20_001)
    found = ao.testrig.frf(hit, velocity(t, hit.at(t).target.velocity))
    struck = found.force > 0.1 * found.force.max()
    np.testing.assert_allclose(found.values[struck], 1.0 / M, rtol=1e-4)
    drawn = np.asarray(found.plot().get_lines()[0].get_ydata())
    np.testing.assert_allclose(drawn[struck], 1.0 / M, rtol=1e-4)


@pytest.mark.parametrize(
    ("kind", "power", "estimator"),
    [("receptance", 0, "H1"), ("mobility", 1, "H2"), ("accelerance", 2, "H1")],
)
@pytest.mark.parametrize("measured", [0, 1])
def test_an_oscillator_is_its_closed_form(
    kind: str, power: int, estimator: str, measured: int
) -> None:
    t, force = pulse()
    unit = ("m/s", "m/s²")[measured]
    motion = ao.testrig.Signal(t, answer(t, force)[measured], unit=unit, name="motion")
    found = ao.testrig.frf(ao.testrig.Signal(t, force), motion, kind=kind, estimator=estimator)
    s = 2j * np.pi * found.frequencies
    exact = s**power / (M * s**2 + C * s + K)
    struck = found.force > 0.1 * found.force.max()
    off = np.abs(found.values - exact)[struck]
    assert (off <= found.error[struck] + 1e-6 * np.abs(exact).max()).all()
    assert found.error[struck][50:].max() < 0.02 * np.abs(exact).max()  # from 100 Hz on
    np.testing.assert_allclose(found.coherence, 1.0, rtol=1e-9)


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:velocity may be off by")  # of elements that both share
def test_a_free_beam_agrees_with_the_response_of_its_finite_elements() -> None:
    """Most of all at the first resonance, where the ringing at the end of the record is missed."""
    alu = ao.Material(E=70e9, nu=0.33, rho=2700)
    mesh = ao.box_mesh((0.6, 0.03, 0.01), (20, 1, 1), kind="hexahedron20")
    beam = ao.FEModel.from_mesh(mesh, alu, damping=ao.ModalDamping(0.01))
    near, far = (
        beam.contact(point=(x, 0.015, 0.01), direction=(0, 0, -1), radius=0) for x in (0.0, 0.6)
    )
    hit = ao.simulate(
        ao.rigid(mass=0.02), ao.modal(near, 40), 0.5, law=ao.Linear(k=3e6), duration=0.5
    )
    probe = hit.target.probe((0.6, 0.015, 0.01), (0, 0, -1), dt=1e-5)
    found = ao.testrig.frf(hit, probe)
    band = (found.frequencies > 20) & (found.frequencies < 2000)
    own = beam.frf(
        excitation=near, response=far, frequencies=found.frequencies[band], kind="accelerance"
    )
    off, top = np.abs(found.values[band] - own.values), np.abs(own.values).max()
    assert off.max() < 0.01 * top + np.exp(-2 * np.pi * 145 * 0.01 * 0.5) * top
    assert (off <= found.error[band] + own.error + 1e-4 * top).all()


def noisy(hits: int, of_force: float, of_response: float) -> Any:
    """Records with white noise, and the exact accelerance."""
    rng = np.random.default_rng(5)
    t, force = pulse()
    motion = answer(t, force)[1]
    sizes = rng.uniform(0.5, 1.5, hits)
    signals = [
        (
            ao.testrig.Signal(t, size * force + of_force * rng.normal(size=len(t))),
            ao.testrig.Signal(
                t, size * motion + of_response * rng.normal(size=len(t)), unit="m/s²"
            ),
        )
        for size in sizes
    ]
    return [list(each) for each in zip(*signals, strict=True)]


def exact(frequencies: Any) -> Any:
    s = 2j * np.pi * frequencies
    return s**2 / (M * s**2 + C * s + K)


@pytest.mark.parametrize("hits", [2, 5, 20])
def test_the_scatter_of_hits_tells_the_error_by_noise(hits: int) -> None:
    found = ao.testrig.frf(*noisy(hits, 0.0, 2.0))
    band = (found.frequencies > 100.0) & (found.frequencies < 1200.0)
    off = np.abs(found.values - exact(found.frequencies))[band]
    assert (off <= found.error[band]).mean() > 0.95
    assert hits < 20 or np.median(found.error[band]) < 0.1 / M


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::aoimpact.AOImpactWarning")  # of noise, 3 % of the peak
def test_each_estimator_averages_the_noise_of_one_signal() -> None:
    """H1 is lower by S/(S + N) under noise of the force, H2 higher by (S + N)/S of the response."""
    for of_force, of_response, good, bad in ((15.0, 0.0, "H2", "H1"), (0.0, 8.0, "H1", "H2")):
        hits = noisy(60, of_force, of_response)
        band = slice(400, 500)  # 800 to 1000 Hz: the accelerance is nearly 1/m
        one, other = (ao.testrig.frf(*hits, estimator=each) for each in (good, bad))
        right = np.abs(exact(one.frequencies[band]))
        assert np.mean(np.abs(one.values[band]) / right) == pytest.approx(1.0, abs=0.01)
        share = np.mean(np.abs(other.values[band]) / right)
        coherence = float(np.mean(one.coherence[band]))
        assert share == pytest.approx(coherence if bad == "H1" else 1.0 / coherence, rel=0.02)
        assert coherence < 0.97


def test_a_hammer_that_strikes_twice_is_said() -> None:
    t, force = pulse()
    twice = force + 0.3 * np.roll(force, 200)
    with pytest.warns(ao.AOImpactWarning, match=r"^hit"):
        ao.testrig.frf(ao.testrig.Signal(t, twice), velocity(t, answer(t, twice)[0]))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        noise = 2.0 * np.random.default_rng(1).normal(size=len(t))
        ao.testrig.frf(ao.testrig.Signal(t, force + noise), velocity(t, answer(t, force)[0]))


def test_a_record_that_is_too_short_for_the_damping_is_said() -> None:
    t, force = pulse(n=3000)  # 60 ms, in which the vibration falls to exp(-1.2)
    with pytest.warns(ao.AOImpactWarning, match="second"):
        ao.testrig.frf(ao.testrig.Signal(t, force), velocity(t, answer(t, force)[0]))


T, F = pulse(n=500)


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:velocity may be off")
def test_what_the_model_of_a_probe_leaves_out_is_claimed() -> None:
    """A free bar struck on its end, by a model for the force: a finer mesh has the rest."""
    alu, damped = ao.Material(E=70e9, nu=0.33, rho=2700), ao.ModalDamping(0.005)
    meshes = (
        ao.box_mesh((0.5, 0.01, 0.02), counts, kind="hexahedron20")
        for counts in ((20, 1, 2), (40, 2, 4))
    )
    bar, right = (ao.FEModel.from_mesh(mesh, alu, damping=damped) for mesh in meshes)
    struck = bar.contact(point=(0.1, 0.005, 0.02))
    hit = ao.simulate(
        ao.rigid(mass=0.02),
        struck,
        0.5,
        law=ao.Linear(k=1e6),
        duration=0.6,
        rtol=0.1,
        quantity="peak_force",
    )
    probe = hit.target.probe((0.49, 0.005, 0.02), (0, 0, -1), dt=4e-5)
    found = ao.testrig.frf(hit, probe)
    seen = (found.frequencies > 50.0) & (found.frequencies < 2000.0)
    f = found.frequencies[seen]
    here, far = (right.contact(point=(x, 0.005, 0.02)) for x in (0.1, 0.49))
    exact = right.frf(excitation=here, response=far, frequencies=f, kind="accelerance").values
    off = np.abs(found.values[seen] - exact)
    assert off.max() > 1e-3 * np.abs(exact).max()
    assert (off < found.error[seen]).mean() > 0.9
    assert off.max() < found.error[seen][off.argmax()]
