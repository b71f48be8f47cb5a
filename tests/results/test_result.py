"""Results against a contact known in closed form: two rigid bodies and a linear spring."""

from __future__ import annotations

import copy
import csv
import dataclasses
import pickle
from pathlib import Path

import numpy as np
import pytest
from records import HalfSine

import aoimpact as ao
from aoimpact.results import Run


def arrays_of(result: ao.Result) -> list[np.ndarray]:
    """All of its histories."""
    histories = "displacement", "velocity", "centre_displacement", "centre_velocity"
    bodies = [getattr(of, name) for of in (result.projectile, result.target) for name in histories]
    energy = result.energy
    return [result.t, result.force, result.indentation, energy.contact, energy.total, *bodies]


def test_numbers_of_a_half_sine() -> None:
    hit = HalfSine(gap=1e-3)
    result = hit.result()
    assert result.peak_force == pytest.approx(hit.peak, rel=1e-6)
    assert result.peak_time == pytest.approx(hit.start + 0.5 * hit.duration, rel=1e-6)
    assert result.contact_duration == pytest.approx(hit.duration, rel=1e-7)
    assert result.contacts == [pytest.approx((hit.start, hit.start + hit.duration), rel=1e-7)]
    assert result.impulse == pytest.approx(hit.impulse, rel=1e-5)
    assert not result.in_contact_at_end


def test_rebound_is_that_of_two_elastic_bodies() -> None:
    hit = HalfSine()
    result = hit.result()
    ratio = (hit.projectile - hit.target) / (hit.projectile + hit.target)
    assert result.rebound_velocity == pytest.approx(ratio * hit.velocity, rel=1e-8)
    assert result.restitution == pytest.approx(1.0, rel=1e-8)


def test_held_target_counts_the_projectile_alone() -> None:
    """Its own velocity is vibration, not recoil."""
    target, law = ao.AOModel(m0=3.0, k0=1.0), ao.Linear(1.2e4)
    result = ao.simulate(ao.rigid(2.0), target, 0.5, law=law, duration=0.05)
    assert result.target.constrained
    assert result.restitution == pytest.approx(-result.rebound_velocity / 0.5, rel=1e-15)


@pytest.mark.filterwarnings("ignore:the record of")
def test_contact_cut_off_gives_the_values_at_the_end() -> None:
    hit = HalfSine()
    result = hit.result(end=0.75)
    assert result.in_contact_at_end
    assert result.contacts == [(0.0, result.t[-1])]
    assert result.contact_duration == pytest.approx(0.75 * hit.duration)
    assert np.isnan(result.rebound_velocity)  # it has not rebounded
    assert np.isnan(result.restitution)
    assert "restitution        none" in repr(result)
    # Three quarters of a half sine carry (1 + cos 45°)/2 of its impulse.
    assert result.impulse == pytest.approx(0.5 * (1 + np.sqrt(0.5)) * hit.impulse, rel=1e-6)


@pytest.mark.filterwarnings("ignore:.*no contact")
def test_without_contact_there_are_zeros_and_no_rebound() -> None:
    hit = HalfSine(gap=1.0)
    result = hit.result(end=-1.0)
    assert result.contacts == []
    numbers = (result.peak_force, result.peak_time, result.contact_duration, result.impulse)
    assert numbers == (0.0, 0.0, 0.0, 0.0)
    assert np.isnan(result.rebound_velocity)
    assert np.isnan(result.restitution)
    assert not result.in_contact_at_end
    assert all(np.isfinite(array).all() for array in arrays_of(result))
    assert "none" in repr(result)
    result.plot_force()
    result.plot_interaction()


def test_energy_of_a_linear_spring_goes_through_it_and_back() -> None:
    hit = HalfSine()
    energy = hit.result().energy
    first = 0.5 * hit.projectile * hit.velocity**2
    np.testing.assert_allclose(energy.total, first, rtol=1e-9)
    assert energy.contact.max() == pytest.approx(0.5 * hit.mass * hit.velocity**2, rel=1e-6)
    np.testing.assert_array_equal(energy.kinetic, energy.projectile.kinetic + energy.target.kinetic)
    np.testing.assert_allclose(energy.dissipated, 0.0, atol=1e-9 * first)


def test_energies_not_recorded_are_asked_for_in_vain() -> None:
    result = HalfSine().result(energies=False)
    with pytest.raises(ao.InputError, match="energies=True"):
        _ = result.energy
    with pytest.raises(ValueError, match="energies=True"):
        result.plot_energy()
    assert result.projectile.energy is None
    assert result.peak_force > 0.0


def test_results_are_frozen() -> None:
    result = HalfSine().result()
    with pytest.raises(dataclasses.FrozenInstanceError):
        result.velocity = 2.0  # type: ignore[misc]
    arrays = arrays_of(result)
    assert not any(array.flags.writeable for array in arrays)


@pytest.mark.parametrize("again", [lambda r: pickle.loads(pickle.dumps(r)), copy.deepcopy])
def test_results_travel(again) -> None:  # type: ignore[no-untyped-def]
    result = HalfSine().result()
    other = again(result)
    assert repr(other) == repr(result)
    for here, there in zip(arrays_of(result), arrays_of(other), strict=True):
        np.testing.assert_array_equal(here, there)
        assert not there.flags.writeable


@pytest.mark.parametrize("energies", [True, False])
def test_csv_reads_back_bit_for_bit(tmp_path: Path, energies: bool) -> None:
    result = HalfSine().result(energies=energies)
    path = tmp_path / "hit.csv"
    result.to_csv(path)
    with path.open(encoding="utf-8", newline="") as file:
        header, *lines = csv.reader(file)
    assert header[:3] == ["t [s]", "force [N]", "indentation [m]"]
    table = dict(zip(header, np.array(lines, dtype=float).T, strict=True))
    np.testing.assert_array_equal(table["t [s]"], result.t)
    np.testing.assert_array_equal(table["force [N]"], result.force)
    name = "target centre velocity [m/s]"
    np.testing.assert_array_equal(table[name], result.target.centre_velocity)
    assert ("total energy [J]" in table) is energies
    assert all(np.isfinite(column).all() for column in table.values())


def test_a_rebound_that_is_all_but_none_has_its_error_in_its_own_unit() -> None:
    """Percent of a tenth of the velocity would read as percent of the number beside it.

    A ball of two thirds of a block's mass, linear law: e = 1, v = (m1 - m2)/(m1 + m2) V.
    """
    heavy = ao.AOModel(m0=0.999, k0=0.0, m=[0.005], k=[1e9])
    light = ao.AOModel(m0=0.99, k0=0.0, m=[0.01], k=[1e9])
    hit = ao.simulate(
        heavy, light, 1.0, law=ao.Linear(k=1e6), duration=0.01, quantity="peak_force", rtol=1e-2
    )
    assert abs(hit.rebound_velocity) < 0.1
    absolute = 0.1 * hit.error["rebound_velocity"].total
    assert f"{hit.rebound_velocity:.5g} m/s ± {absolute:.2g} m/s" in repr(hit)
    share = 100.0 * hit.error["restitution"].total
    assert f"{hit.restitution:.5g} ± {share:.2g} %" in repr(hit)


def test_contacts_of_a_scene_have_the_law_of_the_bodies() -> None:
    """Also where it was found from the surfaces: connecting with it again changes nothing."""
    steel = ao.Material(E=210e9, nu=0.3, rho=7800)
    block = ao.FEModel.from_mesh(ao.box_mesh((0.05, 0.05, 0.05), (3, 3, 3)), steel, order=2)

    def run(law: ao.ContactLaw | None) -> Run:
        scene = ao.Scene()
        ball = scene.add(ao.ball(0.01, steel), velocity=1.0)
        target = scene.add(block.contact(point=(0.025, 0.025, 0.05)))
        scene.connect(ball, target, law)
        return scene.simulate(duration=1e-4)

    first = run(None)
    law = first.contacts[0].law
    assert law.k == pytest.approx(ao.Hertz.between(steel, 0.01, steel, float("inf")).k)
    np.testing.assert_array_equal(run(law).contacts[0].force, first.contacts[0].force)
