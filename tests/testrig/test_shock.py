"""Shock response spectra against closed forms, the standard's own filters and a direct solution."""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np
import pytest
from scipy.signal import lfilter, lsim

import aoimpact as ao
from aoimpact import testrig

A, TAU = 500.0, 0.01


def half_sine(rate: float = 1e6, tail: float = 0.0) -> testrig.Signal:
    t = np.arange(round((TAU + tail) * rate) + 1) / rate
    values = np.where(t <= TAU, A * np.sin(np.pi * t / TAU), 0.0)
    return testrig.Signal(t, values, unit="m/s²", name="acceleration")


FREQUENCIES = np.array([3.0, 20.0, 45.0, 62.0, 80.0, 130.0, 240.0, 900.0])


def test_half_sine_without_damping_is_its_closed_form() -> None:
    """x'' = A/(1 - β²) (sin Ωt - β sin ωt) in the pulse; 2Aβ cos(π/2β)/(1 - β²) after it."""
    spectrum = testrig.shock_spectrum(half_sine(), FREQUENCIES, damping_ratio=0.0)
    t = np.linspace(0.0, TAU, 200_001)
    for i, f in enumerate(FREQUENCIES):
        beta = 1.0 / (2.0 * f * TAU)
        inside = np.sin(np.pi * t / TAU) - beta * np.sin(2.0 * np.pi * f * t)
        primary = A * np.abs(inside / (1.0 - beta**2)).max()
        residual = A * abs(2.0 * beta * np.cos(np.pi / (2.0 * beta)) / (1.0 - beta**2))
        assert spectrum.primary[i] == pytest.approx(primary, rel=3e-3)
        assert spectrum.residual[i] == pytest.approx(residual, rel=1e-5, abs=1e-4 * A)


def test_the_largest_amplification_of_a_half_sine() -> None:
    """1.768 at fτ = 0.81: Harris' Shock and Vibration Handbook, chapter on shock spectra."""
    f = np.geomspace(40.0, 200.0, 161)
    spectrum = testrig.shock_spectrum(half_sine(), f, damping_ratio=0.0)
    assert spectrum.maximax.max() / A == pytest.approx(1.768, abs=2e-3)
    assert f[spectrum.maximax.argmax()] * TAU == pytest.approx(0.81, abs=0.02)


def test_a_very_soft_oscillator_feels_the_change_of_velocity() -> None:
    soft = np.array([1e-3, 1e-2, 0.1])
    kind = "pseudo-velocity"
    spectrum = testrig.shock_spectrum(half_sine(), soft, damping_ratio=0.0, kind=kind)
    np.testing.assert_allclose(spectrum.maximax, A * 2.0 * TAU / np.pi, rtol=1e-4)


def test_a_very_stiff_oscillator_follows_its_base() -> None:
    spectrum = testrig.shock_spectrum(half_sine(), [20e3], damping_ratio=0.05)
    assert spectrum.positive[0] == pytest.approx(A, rel=1e-3)


def noise(n: int = 400, rate: float = 10e3) -> testrig.Signal:
    values = np.random.default_rng(7).normal(size=n)
    return testrig.Signal(np.arange(n) / rate, values, unit="m/s²", name="acceleration")


@pytest.mark.parametrize("zeta", [0.0, 0.05, 0.5, 0.95])
@pytest.mark.parametrize("f", [15.0, 100.0, 250.0])
def test_responses_are_those_of_the_filters_that_the_standard_prints(zeta: float, f: float) -> None:
    """ISO 18431-4, absolute acceleration, in closed form; relative displacement by scipy."""
    signal = noise()
    step = 1.0 / signal.rate
    omega = 2.0 * np.pi * f
    a = zeta * omega * step
    b = omega * step * np.sqrt(1.0 - zeta**2)
    e, s = np.exp(-a), np.exp(-a) * np.sin(b) / b
    zeros, poles = [1.0 - s, 2.0 * (s - e * np.cos(b)), e**2 - s], [1.0, -2.0 * e * np.cos(b), e**2]
    padded, t = np.insert(signal.values, 0, 0.0), np.arange(len(signal.t) + 1) * step
    system = ([-1.0], [1.0, 2.0 * zeta * omega, omega**2])
    for kind, theirs in (
        ("absolute acceleration", lfilter(zeros, poles, signal.values)),
        ("relative displacement", lsim(system, padded, t)[1][1:]),
    ):
        spectrum = testrig.shock_spectrum(signal, [f], damping_ratio=zeta, kind=kind)
        assert spectrum.primary[0] == pytest.approx(np.abs(theirs).max(), rel=1e-9)


def test_peaks_between_samples_are_found() -> None:
    """A step seen by four samples a period: the largest response is twice the step."""
    rate = 1e4
    step = testrig.Signal(np.arange(400) / rate, np.ones(400))
    with pytest.warns(ao.AOImpactWarning, match=r"^frequencies"):
        spectrum = testrig.shock_spectrum(step, [rate / 4.0], damping_ratio=0.0)
    # A ramp up over a quarter of a period: 1 + sinc(1/4).
    assert spectrum.primary[0] == pytest.approx(1.0 + np.sinc(0.25), rel=4e-3)


def test_very_low_frequencies_lose_no_digits() -> None:
    """Displacement of the base itself, by its double integral, ω/rate = 6e-9."""
    signal = half_sine(rate=1e6)
    found = testrig.shock_spectrum(signal, [1e-3], damping_ratio=0.0, kind="relative displacement")
    assert found.primary[0] == pytest.approx(A * TAU**2 / np.pi, rel=1e-6)


def test_an_impact_is_the_deceleration_of_its_projectile() -> None:
    law = ao.Linear(1e6)
    hit = ao.simulate(ao.rigid(mass=2.0), ao.rigid(mass=1e9), 1.0, law=law)
    peak, tau = hit.peak_force / 2.0, hit.contact_duration
    spectrum = testrig.shock_spectrum(hit, np.geomspace(0.5, 1.2, 60) / tau, damping_ratio=0.0)
    assert spectrum.maximax.max() / peak == pytest.approx(1.768, abs=2e-3)


def test_it_is_drawn_with_its_parts() -> None:
    ax = testrig.shock_spectrum(half_sine()).plot(parts=True)
    assert [line.get_label() for line in ax.get_lines()] == [
        "maximax, 5 % damping",
        "primary",
        "residual",
    ]
    assert ax.get_ylabel() == "absolute acceleration (m/s²)"
    plt.close("all")
