"""Readings of a load cell against closed forms, a direct solution, and the tup in an impact."""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import aoimpact as ao
from aoimpact import testrig

CELL = testrig.LoadCell(nose=0.4, carriage=5.0, stiffness=3e8, damping_ratio=0.03)
LAW = ao.Hertz(k=2e9)
PLATE = ao.AOModel(m0=0.15, k0=4e6, m=[0.1, 0.05], k=[2e7, 8e7])


def strike(projectile: Any, **given: Any) -> ao.Result:
    return ao.simulate(projectile=projectile, target=PLATE, law=LAW, velocity=2.0, **given)


def test_a_sine_is_read_with_the_gain_of_the_formula() -> None:
    rate = 2e6
    t = np.arange(round(0.05 * rate)) / rate
    for frequency in (200.0, 3000.0, CELL.frequency, 9000.0):
        wave = np.exp(2j * np.pi * frequency * t)
        read = [CELL.read((t, part)).values for part in (wave.real, wave.imag)]
        late = slice(len(t) // 2, None)  # what the start excited has died away
        seen = np.abs(np.mean((read[0] + 1j * read[1])[late] / wave[late]))
        assert seen == pytest.approx(CELL.gain(frequency), rel=2e-3)


def test_a_sudden_force_is_read_almost_twice() -> None:
    """Without damping m_c/(m_n + m_c) (1 - cos ωt)."""
    cell = testrig.LoadCell(nose=0.4, carriage=5.0, stiffness=3e8)
    t = np.arange(20_001) * 1e-7
    read = cell.read((t, np.where(t > 0.0, 1000.0, 0.0)))
    exact = 1000.0 * cell.share * (1.0 - np.cos(2.0 * np.pi * cell.frequency * t))
    np.testing.assert_allclose(read.values, exact, atol=5.0)
    assert cell.share == pytest.approx(5.0 / 5.4)


def test_frequency_and_dashpot_are_those_of_two_masses_on_a_spring() -> None:
    """Eigenvalues of the 2 by 2 pencil with the dashpot that `damping` tells."""
    m = np.diag([CELL.nose, CELL.carriage])
    pair = np.array([[1.0, -1.0], [-1.0, 1.0]])
    state = np.block(
        [
            [np.zeros((2, 2)), np.eye(2)],
            [
                -np.linalg.solve(m, CELL.stiffness * pair),
                -np.linalg.solve(m, CELL.damping * pair),
            ],
        ]
    )
    fastest = max(np.linalg.eigvals(state), key=lambda value: value.imag)
    assert abs(fastest) == pytest.approx(2.0 * np.pi * CELL.frequency, rel=1e-9)
    assert -fastest.real / abs(fastest) == pytest.approx(CELL.damping_ratio, rel=1e-9)


def test_the_tup_in_an_impact_reads_what_moves_its_carriage() -> None:
    """N = -m_c x_c'' by differences, and the contact force through the two masses as well."""
    hit = strike(CELL.tup(), solver=ao.Adaptive(rtol=1e-8))
    read = CELL.read(hit)
    at = hit.at(read.t).projectile
    carriage = (CELL.mass * at.centre_velocity - CELL.nose * at.velocity) / CELL.carriage
    by_motion = -CELL.carriage * np.gradient(carriage, read.t)
    np.testing.assert_allclose(read.values[1:-1], by_motion[1:-1], atol=4e-3 * read.values.max())
    again = CELL.read(testrig.Signal.of(hit, rate=2e6))
    both = np.interp(read.t, again.t, again.values)
    np.testing.assert_allclose(read.values, both, atol=5e-4 * read.values.max())


def test_the_impulse_of_the_cell_stops_the_carriage() -> None:
    hit = strike(CELL.tup())
    read = CELL.read(hit, rate=1e6)
    at = hit.at(read.t).projectile
    carriage = (CELL.mass * at.centre_velocity - CELL.nose * at.velocity) / CELL.carriage
    impulse = np.trapezoid(read.values, read.t)
    assert impulse == pytest.approx(CELL.carriage * (2.0 - carriage[-1]), rel=1e-5)


def test_two_masses_under_a_force_by_a_direct_solution() -> None:
    t = np.linspace(0.0, 4e-3, 4001)
    force = 1e4 * np.sin(np.pi * t / 2e-3) ** 2 * (t < 2e-3)

    def motion(time: float, z: Any) -> list[float]:
        read = CELL.stiffness * (z[1] - z[0]) + CELL.damping * (z[3] - z[2])
        push = np.interp(time, t, force)
        return [z[2], z[3], (read - push) / CELL.nose, -read / CELL.carriage]

    solution = solve_ivp(motion, (0.0, 4e-3), np.zeros(4), t_eval=t, rtol=1e-9, atol=1e-14)
    nose, carriage, v_nose, v_carriage = solution.y
    exact = CELL.stiffness * (carriage - nose) + CELL.damping * (v_carriage - v_nose)
    np.testing.assert_allclose(CELL.read((t, force)).values, exact, atol=1e-4 * force.max())


def test_a_rigid_projectile_reads_nearly_what_the_tup_reads() -> None:
    """The cell is far stiffer than the contact."""
    stiff = testrig.LoadCell(nose=0.4, carriage=5.0, stiffness=3e11, damping_ratio=0.03)
    soft = ao.AOModel(m0=0.0, k0=1e6, m=[0.5], k=[1e6])
    given: dict[str, Any] = {"target": soft, "law": LAW, "velocity": 2.0, "duration": 9e-3}
    tup = ao.simulate(projectile=stiff.tup(), **given)
    rigid = ao.simulate(projectile=ao.rigid(mass=stiff.mass), **given)
    one, other = stiff.read(tup, rate=1e6), stiff.read(rigid, rate=1e6)
    np.testing.assert_allclose(one.values, other.values, atol=1e-2 * other.values.max())


def test_a_tup_on_a_plate_is_recorded_until_the_impact_is_over() -> None:
    """Its own oscillator does not tell how long the plate holds it."""
    steel = ao.Material(E=210e9, nu=0.3, rho=7800)
    mesh = ao.box_mesh((0.15, 0.1, 0.006), (6, 4, 1), kind="hexahedron20")
    sides = [(side, "xyz") for side in ("xmin", "xmax", "ymin", "ymax")]
    plate = ao.FEModel.from_mesh(mesh, steel, fixed=sides)
    target = plate.contact(point=(0.075, 0.05, 0.006))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ao.AOImpactWarning)  # the mesh is coarse
        hit = ao.simulate(projectile=CELL.tup(), target=target, law=LAW, velocity=0.5)
    assert not hit.in_contact_at_end
    assert hit.duration == pytest.approx(2.0 * hit.contacts[-1][1], rel=0.05)


def test_another_mass_warns() -> None:
    with pytest.warns(ao.AOImpactWarning, match=r"mass, 2 kg, is not 5\.4 kg"):
        CELL.read(strike(ao.rigid(mass=2.0)))


def test_newmark_steps_are_read_too() -> None:
    hit = strike(CELL.tup(), duration=0.02, solver=ao.Newmark(dt=1e-6))
    exact = CELL.read(strike(CELL.tup(), duration=0.02), rate=1e6)
    read = CELL.read(hit)
    peak = exact.values.max()
    np.testing.assert_allclose(
        np.interp(exact.t, read.t, read.values), exact.values, atol=0.01 * peak
    )


def test_a_round_nose_brings_its_law() -> None:
    steel = ao.Material(E=210e9, nu=0.3, rho=7800)
    wall = ao.ball(1.0, steel)
    hit = ao.simulate(projectile=CELL.tup(radius=0.008, material=steel), target=wall, velocity=1.0)
    assert hit.law.k == pytest.approx(ao.Hertz.between(steel, 0.008, steel, 1.0).k)


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"damping_ratio": 1.0}, "damping_ratio must be below 1"),
    ],
)
def test_what_is_no_cell_is_refused(given: dict[str, float], words: str) -> None:
    with pytest.raises(ao.InputError, match=words):
        testrig.LoadCell(**{"nose": 0.1, "carriage": 1.0, "stiffness": 1e8} | given)
    with pytest.raises(ao.InputError, match="both radius and material"):
        CELL.tup(radius=0.01)
