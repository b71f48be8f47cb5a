"""Speed against error: the errors are true ones, the methods agree, and the table says it."""

import math

import numpy as np
import pytest
from impacts import beam_star
from scipy_solvers import Outcome, ode_scene
from work_precision import Reference, work_precision

import aoimpact as ao

MASS = 0.1
WALL = ao.rigid(mass=math.inf)
LINEAR = ao.Linear(k=4e6)
OMEGA = math.sqrt(LINEAR.k / MASS)
HALF_SINE = Outcome(math.sqrt(LINEAR.k * MASS), math.pi / OMEGA, -1.0)
SCENE = {
    "projectile": ao.rigid(mass=MASS),
    "target": WALL,
    "law": LINEAR,
    "velocity": 1.0,
    "duration": 1e-3,
}


def study(**changes):
    settings = {"newmark": (), "adaptive": (), "repeats": 1}
    return work_precision(**(SCENE | settings | changes))


def run_scipy(rtol=1e-12, method="DOP853", **changes):
    scene = SCENE | {"gap": 0.0} | changes
    stars = scene.pop("projectile"), scene.pop("target")
    return ode_scene(stars, scene.pop("law"), **scene, length=1e-4).run(method, rtol)


# --------------------------------------------------------------------------- the second method


@pytest.mark.parametrize("method", ["RK45", "DOP853", "Radau", "BDF", "LSODA"])
def test_scipy_gives_the_half_sine_of_a_linear_contact(method):
    found = run_scipy(1e-9, method)
    assert found.peak_force == pytest.approx(HALF_SINE.peak_force, rel=1e-5)
    assert found.contact_duration == pytest.approx(HALF_SINE.contact_duration, rel=1e-5)
    assert found.rebound_velocity == pytest.approx(-1.0, abs=1e-5)


def test_scipy_tightens_to_ten_digits_whatever_the_gap():
    for gap in (0.0, 1e-4):
        found = run_scipy(1e-13, gap=gap)
        assert found.peak_force == pytest.approx(HALF_SINE.peak_force, rel=1e-11)
        assert found.contact_duration == pytest.approx(HALF_SINE.contact_duration, rel=1e-10)


def test_scipy_of_a_massless_contact_is_springs_in_series():
    k1, k2, m = 3e6, 5e6, 0.2
    series = 1 / (1 / k1 + 1 / k2)
    star = ao.AOModel(m0=0.0, m=[m], k=[k1])
    found = run_scipy(projectile=star, law=ao.Linear(k=k2), duration=2e-3)
    assert found.peak_force == pytest.approx(math.sqrt(series * m), rel=1e-10)
    assert found.contact_duration == pytest.approx(math.pi * math.sqrt(m / series), rel=1e-10)
    assert found.rebound_velocity == pytest.approx(-1.0, abs=1e-10)


@pytest.mark.parametrize("m0", [0.0, pytest.param(1e-3, marks=pytest.mark.slow)])
def test_two_methods_of_nothing_in_common_agree(m0):
    """Modes and closed forms here, star coordinates and Runge-Kutta there; several contacts."""
    star = ao.AOModel(m0=m0, k0=2e6, m=[0.02, 0.004], k=[5e7, 3e8])
    table = study(
        projectile=ao.rigid(mass=0.03),
        target=star,
        law=ao.Hertz(k=1e9),
        scipy=["DOP853"],
        adaptive=(1e-8,),
    )
    assert table.reference.independent < 1e-9
    assert table.reference.uncertainty >= table.reference.independent
    assert table.fastest("Adaptive", 1e-8) is not None


# ------------------------------------------------------------------------------------ the table


def test_errors_against_a_given_truth_are_the_true_ones():
    """Newmark's error of the half sine falls with dt², and Adaptive keeps its tolerance."""
    steps = (2e-6, 1e-6, 5e-7)
    truth = Reference(HALF_SINE, "half sine")
    table = study(newmark=steps, adaptive=(1e-4, 1e-9), reference=truth)
    durations = np.array([row.contact_duration for row in table.rows[:3]])
    orders = np.log2(durations[:-1] / durations[1:])
    np.testing.assert_allclose(orders, 2.0, atol=0.1)
    assert all(row.error <= rtol for row, rtol in zip(table.rows[3:], (1e-4, 1e-9), strict=True))
    assert all(row.seconds > 0.0 for row in table.rows)


# ---------------------------------------------------------------------- the scenes, the command


def test_the_beam_s_star_is_the_beam():
    """Its lowest natural frequencies are those that are symmetric: (iπ)² √(EI/μL⁴), i = 1, 3, 5."""
    beam = beam_star(200)
    bending = 70e9 * 0.02**4 / 12
    i = np.array([1, 3, 5])
    exact = (i * math.pi) ** 2 * math.sqrt(bending / (2400 * 0.02**2)) / (2 * math.pi)
    np.testing.assert_allclose(beam.natural_frequencies[:3], exact, rtol=1e-6)
    assert beam.static_mass == pytest.approx(17 / 35 * 0.96, rel=1e-14)
