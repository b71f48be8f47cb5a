"""Signals, and their filter against formulas, the corridor of the standard and scipy."""

from __future__ import annotations

import math
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import pytest
from rows import each

import aoimpact as ao
from aoimpact import testrig

CLASSES = (60, 180, 600, 1000)


def pulse(rate: float = 100e3, length: float = 0.2, seed: int = 3) -> testrig.Signal:
    """Noise under a smooth window, so that nothing is at its ends."""
    t = np.arange(round(rate * length)) / rate
    noise = np.random.default_rng(seed).normal(size=len(t))
    return testrig.Signal(t, noise * np.hanning(len(t)) ** 2)


def gain(cfc: float, frequency: float, rate: float = 50e3) -> float:
    """Amplitude of a sine after the filter, away from its ends."""
    t = np.arange(round(40 * rate / min(frequency, 50.0))) / rate
    wave = np.exp(2j * np.pi * frequency * t)
    kept = [testrig.Signal(t, part).filtered(cfc).values for part in (wave.real, wave.imag)]
    middle = slice(len(t) // 3, 2 * len(t) // 3)
    found: float = np.abs(np.mean((kept[0] + 1j * kept[1])[middle] / wave[middle]))
    return found


@each("cfc", CLASSES)
@each("share", [0.02, 0.5, 1.0, 1.65, 2.0775, 4.0])
def test_gain_is_that_of_two_butterworth_passes(cfc: float, share: float) -> None:
    rate = 50e3
    w, corner = np.tan(np.pi * np.array([share, 2.0775]) * cfc / rate)
    assert gain(cfc, share * cfc, rate) == pytest.approx(1.0 / (1.0 + (w / corner) ** 4), rel=1e-9)


@each("cfc", CLASSES)
def test_it_stays_in_the_corridor_of_the_standard(cfc: float) -> None:
    """J211-1, figure 1: ±0.5 dB, then to +0.5 and -1 dB at F_H = CFC and -4 dB at F_N = 1.65 CFC.

    From F_N on between -9 and -24 dB an octave.
    """
    at: dict[float, float] = {
        share: 20.0 * np.log10(gain(cfc, share * cfc)) for share in (0.1, 0.5, 1.0, 1.65, 3.3, 4.95)
    }
    assert abs(at[0.1]) < 0.5
    assert abs(at[0.5]) < 0.5
    assert -1.0 < at[1.0] < 0.5
    assert -4.0 < at[1.65] < 0.5
    for share in (3.3, 4.95):
        octaves = np.log2(share / 1.65)
        assert -4.0 - 24.0 * octaves < at[share] < 0.5 - 9.0 * octaves


@each("cfc", CLASSES)
def test_it_is_the_recursion_that_the_standard_prints(cfc: float) -> None:
    raw = pulse(length=0.03)
    x, step = raw.values, 1.0 / raw.rate
    wd = 2.0 * np.pi * cfc * 2.0775
    wa = np.sin(wd * step / 2.0) / np.cos(wd * step / 2.0)
    below = 1.0 + np.sqrt(2.0) * wa + wa**2
    a = np.array([wa**2, 2.0 * wa**2, wa**2]) / below
    b = np.array([-2.0 * (wa**2 - 1.0), -1.0 + np.sqrt(2.0) * wa - wa**2]) / below
    # Silence at both ends, so that neither way of starting matters.
    padded = np.concatenate([np.zeros(20_000), x, np.zeros(20_000)])
    (a0, a1, a2), (b1, b2), values = a.tolist(), b.tolist(), padded.tolist()
    for _ in range(2):
        y = [0.0, 0.0]
        for x2, x1, x0 in zip(values, values[1:], values[2:], strict=False):
            y.append(a0 * x0 + a1 * x1 + a2 * x2 + b1 * y[-1] + b2 * y[-2])
        values = y[::-1]
    ours = testrig.Signal(np.arange(len(padded)) * step, padded).filtered(cfc)
    np.testing.assert_allclose(ours.values, values, atol=1e-12 * np.abs(x).max())


def test_it_shifts_nothing_and_keeps_the_impulse() -> None:
    t = np.linspace(-0.05, 0.05, 10001)
    hill = testrig.Signal(t, np.where(np.abs(t) < 1e-3, np.cos(500 * np.pi * t), 0.0))
    smooth = hill.filtered(180)
    np.testing.assert_allclose(smooth.values, smooth.values[::-1], atol=1e-9)
    assert np.trapezoid(smooth.values, t) == pytest.approx(np.trapezoid(hill.values, t), rel=1e-9)
    assert smooth.raw is hill


@each("values", [lambda t: 0.0 * t + 7.0, lambda t: 3.0 + 100.0 * t])
def test_a_line_passes_up_to_its_ends(values: Any) -> None:
    t = np.arange(2000) / 20e3
    line = testrig.Signal(t, values(t))
    np.testing.assert_allclose(line.filtered(180).values, line.values, rtol=1e-6)


def test_a_corner_is_a_class_by_another_name() -> None:
    raw = pulse()
    corner = 1000.0 * 2.0775 / (math.sqrt(2.0) - 1.0) ** -0.25
    np.testing.assert_allclose(
        raw.filtered(corner=corner).values, raw.filtered(1000).values, atol=1e-12
    )


def test_uneven_samples_are_refused_and_resampled() -> None:
    t = np.sort(np.random.default_rng(1).uniform(0.0, 0.1, 5001))
    uneven = testrig.Signal(t, np.sin(2 * np.pi * 30 * t))
    with pytest.raises(ao.InputError, match="force"):
        uneven.filtered(60)
    even = uneven.resampled(200e3)
    assert even.rate == pytest.approx(200e3)
    np.testing.assert_allclose(even.values, np.sin(2 * np.pi * 30 * even.t), atol=2e-4)
    with pytest.raises(ao.InputError, match=r"^rate"):
        uneven.resampled(1e3)


def test_times_written_with_few_digits_are_even() -> None:
    t = np.round(np.arange(1000) * 1e-5, 7)
    assert testrig.Signal(t, t).rate == pytest.approx(1e5)


def strike(duration: float | None = None, solver: Any = None) -> ao.Result:
    plate = ao.AOModel(m0=0.1, k0=5e6)
    return ao.simulate(
        ao.rigid(mass=2.0), plate, 1.0, law=ao.Hertz(k=1e9), duration=duration, solver=solver
    )


def test_an_impact_is_sampled_evenly_and_exactly() -> None:
    hit = strike()
    signal = testrig.Signal.of(hit, rate=1e6, margin=1e-3)
    inside = (signal.t >= 0.0) & (signal.t <= hit.duration)
    np.testing.assert_array_equal(signal.values[inside], hit.at(signal.t[inside]).force)
    assert not signal.values[~inside].any()
    assert signal.t[0] == pytest.approx(-1e-3)
    assert testrig.Signal.of(hit).values.max() == pytest.approx(hit.peak_force, rel=1e-4)


def test_a_record_that_ends_in_contact_gets_no_silence() -> None:
    with pytest.warns(ao.AOImpactWarning, match="contact"):
        hit = strike(duration=1e-3)
    with pytest.raises(ao.InputError, match=r"^margin"):
        testrig.Signal.of(hit, margin=1e-3)


def test_steps_of_newmark_are_taken_as_they_are() -> None:
    hit = strike(duration=5e-3, solver=ao.Newmark(dt=1e-5))
    signal = testrig.Signal.of(hit)
    np.testing.assert_allclose(signal.values, hit.force, atol=1e-9 * hit.peak_force)


def test_a_probe_gives_the_acceleration_of_its_point() -> None:
    steel = ao.Material(E=210e9, nu=0.3, rho=7800)
    bar = ao.FEModel.from_mesh(ao.box_mesh((0.1, 0.02, 0.02), (4, 1, 1)), steel)
    tip = bar.contact(point=(0.1, 0.0, 0.0), direction=(-1.0, 0.0, 0.0), radius=0)
    hit = ao.simulate(
        ao.rigid(mass=0.05), ao.antioscillators(tip, 2), 1.0, law=ao.Linear(1e6), duration=1e-3
    )
    times = np.linspace(0.0, 1e-3, 4001)
    probe = hit.target.probe((0.0, 0.01, 0.01), direction=(1, 0, 0), times=times)
    signal = testrig.Signal.of(probe)
    assert (signal.unit, signal.name) == ("m/s²", "acceleration")
    gained = np.trapezoid(signal.values, times)
    assert gained == pytest.approx(probe.velocity[-1] - probe.velocity[0], rel=1e-3)
    with pytest.raises(ao.InputError, match=r"^source"):
        testrig.Signal.of(hit.target.probe((0.0, 0.01, 0.01), times=times))


def test_the_raw_signal_is_drawn_behind_the_filtered_one() -> None:
    raw = pulse()
    ax = raw.filtered(600).plot()
    behind, before = ax.get_lines()
    assert len(np.asarray(behind.get_ydata())) == len(raw.t)
    assert (behind.get_color(), behind.get_label()) == ("0.7", "unfiltered")
    assert ax.get_xlabel() == "time (ms)"
    assert np.ptp(np.asarray(before.get_ydata())) < np.ptp(np.asarray(behind.get_ydata()))
    plt.close("all")
