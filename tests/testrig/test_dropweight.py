"""Drop-weight energies against closed forms, and against what the simulation itself knows."""

from __future__ import annotations

import re
import warnings
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import pytest

import aoimpact as ao
from aoimpact import testrig
from aoimpact.base import AOImpactWarning

M, V, F0, T = 5.0, 2.0, 7000.0, 4e-3


def sine(gravity: float = 0.0, before: float = 0.0, rate: float = 1e6) -> testrig.DropWeight:
    t = np.arange(round((T + 2.0 * before) * rate) + 1) / rate - before
    force = np.where((t > 0.0) & (t < T), F0 * np.sin(np.pi * t / T), 0.0)
    return testrig.drop_weight((t, force), mass=M, velocity=V, gravity=gravity, start=0.0)


@pytest.mark.parametrize("gravity", [0.0, 9.80665])
def test_a_half_sine_is_integrated(gravity: float) -> None:
    test = sine(gravity)
    t, w = test.t, np.pi / T
    v = V + gravity * t - F0 / (M * w) * (1.0 - np.cos(w * t))
    way = V * t + 0.5 * gravity * t**2 - F0 / (M * w) * (t - np.sin(w * t) / w)
    np.testing.assert_allclose(test.velocity, v, atol=1e-6)
    np.testing.assert_allclose(test.deflection, way, atol=1e-9)


def test_the_energy_is_the_work_of_the_force() -> None:
    test = sine(9.80665)
    work = np.concatenate(
        [[0.0], np.cumsum(0.5 * (test.force[1:] + test.force[:-1]) * np.diff(test.deflection))]
    )
    np.testing.assert_allclose(test.energy, work, atol=1e-5 * test.impact_energy)


def test_its_points() -> None:
    test = sine()
    w = np.pi / T
    assert test.peak.time == pytest.approx(T / 2.0)
    assert test.peak.force == pytest.approx(F0)
    assert test.peak.deflection == pytest.approx(V * T / 2.0 - F0 / (M * w) * (T / 2.0 - 1.0 / w))
    assert test.impact_energy == 0.5 * M * V**2
    assert test.rebound_velocity == pytest.approx(V - 2.0 * F0 / (M * w), rel=1e-4)
    kept = 0.5 * M * (V**2 - (V - 2.0 * F0 / (M * w)) ** 2)
    assert test.absorbed_energy == pytest.approx(kept, rel=1e-3)
    assert test.turn is not None
    assert test.turn.deflection == test.deflection.max()
    assert test.puncture is None


def test_the_weight_falls_freely_before_it_touches() -> None:
    test = sine(gravity=9.80665, before=0.01)
    assert test.velocity[0] == pytest.approx(V - 9.80665 * 0.01)
    at = int(np.searchsorted(test.t, 0.0))
    assert test.velocity[at] == pytest.approx(V, rel=1e-6)
    assert test.deflection[at] == pytest.approx(0.0, abs=3e-6)


def test_the_start_of_a_measured_force_is_found() -> None:
    rate = 100e3
    t = np.arange(2000) / rate
    begin = 5e-3
    force = np.where((t > begin) & (t < begin + T), F0 * np.sin(np.pi * (t - begin) / T), 0.0)
    test = testrig.drop_weight((t, force), mass=M, velocity=V)
    assert test.start == pytest.approx(begin, abs=3e-5)
    assert test.end == pytest.approx(begin + T, abs=3e-5)
    assert test.gravity == 9.80665


def test_puncture_is_where_the_force_has_halved_on_the_way_in() -> None:
    """A triangle that falls to nothing while the impactor goes on (ISO 6603-2)."""
    t = np.linspace(0.0, 6e-3, 6001)
    force = np.interp(t, [0.0, 3e-3, 5e-3, 6e-3], [0.0, 2000.0, 0.0, 0.0])
    test = testrig.drop_weight((t, force), mass=20.0, velocity=4.0)
    assert test.puncture is not None
    assert test.puncture.time == pytest.approx(4e-3)
    assert test.puncture.force == pytest.approx(1000.0)
    between = (test.t >= 0.0) & (test.t <= 4e-3)
    work = np.trapezoid(test.force[between], test.deflection[between])
    assert test.puncture.energy == pytest.approx(work, rel=1e-4)
    assert "puncture           1000 N" in repr(test)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda f: 1.0 * f, ""),
        (lambda f: 1.2 * f, "the absorbed energy is -.* force too large"),
        (lambda f: f + 600.0, "is the force too large"),
        (lambda f: 1e-3 * f, "still goes on at 1.996 of 2 m/s .* in N .not kN"),
        (lambda f: f[:2000], "the record ends at a force of 7.*N: rebound and absorbed"),
    ],
)
def test_what_no_test_can_be_is_said(change: Any, words: str) -> None:
    """The impulse of a half sine, 2 F T/π, turns 5 kg from 2 to -1.56 m/s, less gravity."""
    t = np.arange(6000) * 1e-6
    force = change(np.where(t < T, F0 * np.sin(np.pi * t / T), 0.0))
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        testrig.drop_weight((t[: len(force)], force), mass=M, velocity=V, gravity=0.0, start=0.0)
    said = "\n".join(str(one.message) for one in caught)
    assert re.search(words, said) if words else not said


def test_noise_before_the_touch_is_no_touch() -> None:
    """Noise of 0.4 % of the peak, rms, which passes 1 % of it now and then."""
    t = np.arange(15_000) * 1e-6 - 5e-3
    force = np.where((t > 0.0) & (t < T), F0 * np.sin(np.pi * t / T), 0.0)
    noise = 30.0 * np.random.default_rng(7).normal(size=len(t))
    test = testrig.drop_weight((t, force + noise), mass=M, velocity=V, gravity=0.0)
    quiet = sine()
    assert abs(test.start) < 0.02 * T
    assert test.end == pytest.approx(T, rel=0.02)
    assert test.turn is not None
    assert quiet.turn is not None
    assert test.turn.deflection == pytest.approx(quiet.turn.deflection, rel=0.02)
    assert test.absorbed_energy == pytest.approx(quiet.absorbed_energy, rel=0.02)


@pytest.mark.parametrize("noise", [0.0, 360.0])  # does not make the contact longer
def test_a_class_that_takes_out_the_contact_is_said(noise: float) -> None:
    t = np.arange(20_000) * 1e-6 - 5e-3
    force = np.where((t > 0.0) & (t < 1e-4), 9e4 * np.sin(np.pi * t / 1e-4), 0.0)
    force += noise * np.random.default_rng(7).normal(size=len(t))
    with pytest.warns(AOImpactWarning, match="which"):
        testrig.drop_weight((t, force), mass=M, velocity=V, gravity=0.0, cfc=1000)


def test_an_impactor_that_goes_on_does_not_turn() -> None:
    """A weight of 5 kg that drives 0.1 kg away goes on faster than half of its velocity."""
    hit = ao.simulate(ao.rigid(mass=M), ao.rigid(mass=0.1), V, law=LAW, duration=1e-3)
    test = testrig.drop_weight(hit)
    assert test.rebound_velocity > 0.9 * V
    assert test.turn is None
    assert "turn               none" in repr(test)


# ------------------------------------------------------------------------- simulated


TUP = ao.rigid(mass=5.4)
PLATE = ao.AOModel(m0=0.1, k0=5e6, m=[0.2, 0.1], k=[4e7, 9e7])
LAW = ao.Hertz(k=1e9)


def strike(**given: Any) -> ao.Result:
    return ao.simulate(
        **{"projectile": TUP, "target": PLATE, "law": LAW, "velocity": 2.0, "gap": 1e-3} | given
    )


def test_a_simulated_impact_agrees_with_its_own_motion_and_energies() -> None:
    hit = strike()
    test = testrig.drop_weight(hit)
    at = hit.at(test.t)
    np.testing.assert_allclose(test.velocity, at.projectile.centre_velocity, atol=1e-4)
    way = at.projectile.centre_displacement - 1e-3
    np.testing.assert_allclose(test.deflection, way, atol=1e-6)
    taken = at.energy.target.kinetic + at.energy.target.elastic + at.energy.contact
    np.testing.assert_allclose(test.energy, taken, atol=2e-4 * test.impact_energy)
    assert test.start == pytest.approx(hit.contacts[0][0])
    assert test.rebound_velocity == pytest.approx(hit.rebound_velocity, rel=1e-3)
    assert test.peak.force == pytest.approx(hit.peak_force, rel=1e-3)


@pytest.mark.filterwarnings("ignore:the record ends at a force")
def test_a_drop_under_gravity_is_evaluated_from_its_scene() -> None:
    """Against the motion and the energies of the scene, which has the weight's work in it."""
    scene = ao.Scene(gravity=9.81)
    tup = scene.add(TUP, velocity=0.1)
    scene.connect(tup, scene.add(ao.rigid(mass=np.inf)), ao.Linear(2e5))
    run = scene.simulate(duration=0.05)
    signal = testrig.Signal.of(run, contact=0, rate=200e3)
    test = testrig.drop_weight(signal, mass=5.4, velocity=0.1, gravity=9.81, start=0.0)
    at = run.at(test.t)
    np.testing.assert_allclose(test.velocity, at[tup].centre_velocity, atol=1e-5)
    np.testing.assert_allclose(test.deflection, at[tup].centre_displacement, atol=1e-7)
    lost = 0.5 * 5.4 * (0.1**2 - at[tup].velocity ** 2) + 5.4 * 9.81 * at[tup].displacement
    np.testing.assert_allclose(test.energy, lost, atol=1e-4 * lost.max())
    with pytest.raises(ao.InputError, match=r"^contact"):
        testrig.Signal.of(run, contact=1)


def test_a_simulated_plate_is_never_punctured() -> None:
    """A light plate's force falls by half while a heavy impactor goes on: a vibration."""
    light = ao.AOModel(m0=0.5, k0=1e5)
    hit = strike(projectile=ao.rigid(mass=50.0), target=light, duration=0.05, gap=0.0)
    test = testrig.drop_weight(hit)
    top = int(np.argmax(test.force))
    falls = np.flatnonzero(test.force[top:] <= 0.5 * test.force[top])
    assert test.velocity[top + falls[0]] > 0.0
    assert test.puncture is None


def test_bodies_that_do_not_meet_are_said() -> None:
    with pytest.warns(ao.AOImpactWarning), pytest.raises(ao.InputError, match="bodies"):
        testrig.drop_weight(strike(gap=1.0, duration=1e-3))


def test_curves_and_files(tmp_path: Path) -> None:
    test = testrig.drop_weight(strike(), cfc=1000)
    assert len(test.plot_force().get_lines()) == 2
    ax = test.plot_energy(label="one")
    assert ax.get_xlabel() == "time (ms)"
    test.plot_energy(ax, label="two")
    one, two = ax.get_lines()
    assert (one.get_color(), one.get_linestyle()) != (two.get_color(), two.get_linestyle())
    assert test.plot_deflection().get_xlabel() == "deflection (mm)"
    over = test.plot_energy(over="deflection")
    assert over.get_xlabel() == "deflection (mm)"
    x, y = (np.asarray(part, dtype=float) for part in over.get_lines()[0].get_data())
    assert test.turn is not None
    assert y[x.argmax()] == pytest.approx(test.turn.energy, rel=1e-6)  # in J, at the turn
    with pytest.raises(ao.InputError, match=r"^over"):
        test.plot_energy(over="force")
    plt.close("all")
    test.to_csv(tmp_path / "test.csv")
    signal = testrig.read_signal(tmp_path / "test.csv", values="force")
    np.testing.assert_array_equal(signal.values, test.force)
    assert "absorbed energy" in repr(test)
