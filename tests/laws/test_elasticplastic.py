"""Yield to full plasticity: closed forms, and what was measured on spheres and by Leeb's device."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import pytest
import scipy.integrate
import scipy.optimize
from hypothesis import given
from hypothesis import strategies as st
from rigid_pair import on_a_wall

import aoimpact as ao

STEEL = ao.Material(E=210e9, nu=0.3, rho=7800, yield_strength=600e6)
LAW = ao.ElasticPlastic.between(STEEL, 0.005, STEEL, math.inf)
MASS = 0.004


# ------------------------------------------------------------------- closed forms


def test_fully_plastic_the_mean_pressure_is_the_hardness():
    start, d = LAW.plastic_indentation, 30 * LAW.plastic_indentation
    modulus = 210e9 / (2 * (1 - 0.3**2))
    # Hertz's mean pressure at the start: 4 E* √(δ/R) / (3 π).
    mean = 4 * modulus * math.sqrt(start / 0.005) / (3 * math.pi)
    assert mean == pytest.approx(LAW.hardness, rel=1e-12)
    assert pytest.approx(2.8 * 600e6) == LAW.hardness
    area = math.pi * 0.005 * (2 * d - start)
    assert LAW.force(d) == pytest.approx(LAW.hardness * area, rel=1e-12)
    assert LAW.dent(d).diameter == pytest.approx(2 * math.sqrt(area / math.pi), rel=1e-12)


def test_yield_is_thorntons_with_the_pressure_of_first_yield():
    thornton = ao.Thornton.between(STEEL, 0.005, STEEL, math.inf, yield_pressure=1.61 * 600e6)
    assert LAW.yield_force == pytest.approx(thornton.yield_force, rel=0.01)
    assert LAW.k == thornton.k


@given(st.floats(1.0001, 1.5 * LAW.plastic_indentation / LAW.yield_indentation))
def test_the_residual_indentation_is_that_of_etsion_kligerman_and_kadin(w):
    depth = LAW.dent(w * LAW.yield_indentation).depth / LAW.yield_indentation
    assert depth == pytest.approx(w * (1 - w**-0.28) * (1 - w**-0.69), rel=1e-5, abs=1e-9)


def test_the_recovery_of_full_plasticity_is_about_that_of_johnson():
    """δ'² = 9 π F p₀/(16 E*²), of a sphere that yields all at once: half as much again."""
    modulus = 210e9 / (2 * (1 - 0.3**2))
    for d in LAW.plastic_indentation * np.array([2.0, 30.0, 1e3]):
        johnson = math.sqrt(9 * math.pi * LAW.force(d) * LAW.hardness) / (4 * modulus)
        assert 0.6 < (d - LAW.dent(d).depth) / johnson < 0.75


@pytest.mark.parametrize("hardness", [1.75, 2.5, 4.0])
def test_a_deeper_dent_gives_back_a_smaller_share_of_the_work(hardness):
    """Also where full plasticity begins; from a hardness of 1.7 pressures of yield on."""
    pressure = 1.5 / math.pi * 1e10 * math.sqrt(1e-6) / 0.01
    law = ao.ElasticPlastic(1e10, 10.0, hardness * pressure, relative_radius=0.01)
    depths = np.geomspace(law.yield_indentation, 30.0 * law.plastic_indentation, 2000)
    share = [law.potential(d) / law._work(d) for d in depths]
    assert np.diff(share).max() <= 1e-12


# ------------------------------------------------------------------- memory


def test_forces_along_a_path_unload_and_reload_from_the_deepest_point():
    deepest = 4 * LAW.plastic_indentation
    rest = LAW.dent(deepest).depth
    shares = np.array([1.0, 0.7, 0.2, 0.0, 0.2, 0.7])
    path = np.concatenate([[0.5 * deepest], rest + shares * (deepest - rest), [1.2 * deepest]])
    force = LAW.force(path, along=True)
    assert force[1:-1] == pytest.approx(LAW.force(deepest) * shares**1.5, abs=1e-6)
    assert force[0] == LAW.force(path[0])
    assert force[-1] == LAW.force(path[-1])


@pytest.mark.parametrize("solver", [ao.Adaptive(rtol=1e-8), ao.Newmark(dt=1e-8)], ids=str)
def test_a_run_leaves_the_dent_of_its_deepest_indentation(solver):
    hit = on_a_wall(LAW, MASS, 2.0, solver, duration=3e-4)
    assert hit.restitution == pytest.approx(ao.restitution(LAW, MASS, 2.0), abs=1e-6)
    assert hit.dent == LAW.dent(hit.indentation.max())
    assert hit.contact_radius == pytest.approx(0.5 * hit.dent.diameter)
    last = hit.indentation[np.flatnonzero(hit.force > 0.0)[-1]]
    assert last == pytest.approx(hit.dent.depth, rel=1e-2)


def test_a_softer_blow_into_the_same_dent_is_elastic():
    """A spring throws the ball back, again and again: each blow begins at the dent's bottom."""
    swing = ao.AOModel(m0=MASS, k0=MASS * 2e3**2, m=[], k=[])
    hit = ao.simulate(
        projectile=ao.rigid(mass=100 * MASS),
        target=swing,
        law=LAW,
        velocity=0.5,
        duration=1.5e-2,
        solver=ao.Adaptive(rtol=1e-8),
    )
    assert len(hit.contacts) >= 2
    total = hit.energy.total
    assert total == pytest.approx(total[0], rel=1e-7)
    assert np.diff(hit.energy.dissipated).min() > -1e-9 * total[0]


# ------------------------------------------------------------------- what is refused


def test_the_softer_body_yields():
    hard = ao.Material(E=210e9, nu=0.3, rho=7800, hardness=8e9)
    law = ao.ElasticPlastic.between(hard, 0.005, STEEL, math.inf)
    assert law == LAW
    assert ao.ElasticPlastic.between(hard, 0.005, hard, math.inf).hardness == 8e9
    # The body that yields first need not be the one of the lower hardness.
    brittle = ao.Material(E=210e9, nu=0.3, rho=7800, yield_strength=700e6, hardness=1.5e9)
    both = ao.ElasticPlastic.between(brittle, 0.005, STEEL, math.inf)
    assert (both.hardness, both.yield_force) == (1.5e9, LAW.yield_force)
    named = ao.ElasticPlastic.between(STEEL, 0.005, STEEL, math.inf, hardness=2e9)
    assert (named.hardness, named.yield_force) == (2e9, LAW.yield_force)


# ------------------------------------------------------------------- two spheres in a Hopkinson bar
#
# Burgoyne and Daraio, Phys. Rev. E 89 (2014) 032203, with the data published with the paper
# (Daraio-lab/Burgoyne_PRE_2014, CC BY 4.0): spheres of 3.175 mm, pressed together at 2.7 to
# 5.6 m/s between steel bars. Repeats scatter by about 10 %. Approaches in µm, forces in N.

APPROACH = 1e-6 * np.array([20, 40, 60, 80, 100, 120, 150, 180, 200, 230])
BAR_AREA = math.pi * 9.525e-3**2
BAR_IMPEDANCE = 192e9 * BAR_AREA / 4865.5  # of one bar, N s/m


class Spheres(NamedTuple):
    """E and σ_y, Pa; slope of the measured forces from 60 µm on, N/m; forces; the largest, where
    and how much; and of another run the stress that arrives, Pa, each 5 µs, and the largest force.
    """

    E: float
    strength: float
    slope: float
    force: list[float]
    largest: tuple[float, float]
    stress: list[float]
    run_largest: float

    def law(self, hardness: float | None = None) -> ao.ElasticPlastic:
        metal = ao.Material(E=self.E, nu=0.3, rho=7800, yield_strength=self.strength)
        return ao.ElasticPlastic.between(metal, 3.175e-3, metal, 3.175e-3, hardness=hardness)

    @property
    def measured_hardness(self) -> float:
        """p₀, Pa, of the slope 2 π R p₀, R half of the spheres' radius."""
        return self.slope / (math.pi * 3.175e-3)

    def deviations(self, law: ao.ContactLaw) -> np.ndarray:
        approach = np.append(APPROACH, 1e-6 * self.largest[0])
        return law.force(approach) / np.append(self.force, self.largest[1]) - 1.0

    def run(self, law: ao.ContactLaw) -> float:
        """The largest force of dδ/dt = 2 (σ A - F)/Z, at which the approach turns."""
        times = 5e-6 * np.arange(len(self.stress))

        def rate(t: float, delta: np.ndarray) -> list[float]:
            stress = np.interp(t, times, self.stress)
            return [2.0 * (stress * BAR_AREA - law.force(delta[0])) / BAR_IMPEDANCE]

        def turned(t: float, delta: np.ndarray) -> float:
            return rate(t, delta)[0] if t > 2e-5 else 1.0

        turned.terminal = True
        run = scipy.integrate.solve_ivp(
            rate, times[[0, -1]], [0.0], events=turned, rtol=1e-6, max_step=2e-6
        )
        return law.force(run.y[0, -1])


def mega(text: str) -> list[float]:
    return [1e6 * float(word) for word in text.split()]


SPHERES = {
    "440C steel": Spheres(
        200e9,
        1896e6,
        55.7e6,
        [542, 1538, 2599, 3743, 4509, 5779, 7484, 9158, 10495, 11927],
        (233, 12280),
        mega(
            "0.5 3.8 9.6 15.6 23.8 33.8 47.1 63 77 90.9 100.4 106.1 109.3 110 112.2 112.3 111.7 "
            "110.9 108.7 103.2 97.7 90.8 79.8 69.4 56 41.6 30.8 22.1 17.3 12.6"
        ),
        15223,
    ),
    "302 steel": Spheres(
        200e9,
        600e6,
        24.0e6,
        [323, 851, 979, 1777, 2133, 2615, 3307, 4128, 4512, 5139],
        (260, 5735),
        mega(
            "0.4 4.1 10.5 17.1 21.8 30.4 39.8 54.6 68.2 80.7 87.1 90.4 91.9 93.6 94.9 95.1 94.2 "
            "94.5 92 87.4 80.9 75.1 67.9 57.2 43.4 32.7 24.4 18 13.6 10.9 9 7.7 6.5 5.8"
        ),
        7034,
    ),
    "aluminium": Spheres(
        76e9,
        276e6,
        9.6e6,
        [72, 394, 505, 754, 976, 1204, 1522, 1561, 1833, 2274],
        (320, 3086),
        mega(
            "0.5 3.5 8.8 15.1 18.6 24.9 30.2 38.8 47 57.5 65.8 72.4 76.4 78.4 79.6 80.2 81.4 80.2 "
            "78.2 74.2 69.5 64.4 59.7 53.8 45 38.5 30.4 24.2 18.4 14"
        ),
        2821,
    ),
}


@pytest.mark.parametrize("metal", SPHERES.values(), ids=list(SPHERES))
def test_with_the_measured_hardness_forces_are_within_the_scatter(metal):
    """2.9, 4.0 and 3.5 yield strengths: the softer metals harden by strain and its rate."""
    law = metal.law(metal.measured_hardness)
    assert np.abs(metal.deviations(law)[3:]).max() < 0.11
    assert metal.run(law) == pytest.approx(metal.run_largest, rel=0.11)


# ------------------------------------------------------------------- Leeb's rebound hardness
#
# Device D, by the manufacturers' data: 5.45 g at 2.05 m/s, ball of 3 mm, E* of the pair 169 GPa.

LEEB_MASS, LEEB_VELOCITY = 5.45e-3, 2.05


def leeb(vickers: float) -> ao.ElasticPlastic:
    carbide = ao.Material(E=600e9, nu=0.22, rho=15600)
    elastic = 1.0 / (1.0 / 169e9 - 1.0 / carbide.plane_strain_modulus) * (1 - 0.3**2)
    block = ao.Material(E=elastic, nu=0.3, rho=7800, hardness=9.81e6 * vickers / 0.927)
    return ao.ElasticPlastic.between(carbide, 1.5e-3, block, math.inf)


def test_leebs_restitution():
    assert ao.restitution(leeb(955), LEEB_MASS, LEEB_VELOCITY) == pytest.approx(0.890, abs=0.05)


@pytest.mark.parametrize(("vickers", "diameter"), [(300, 0.54e-3), (600, 0.45e-3)])
def test_leebs_dents(vickers, diameter):
    law = leeb(vickers)
    deepest = law.stroke(0.5 * LEEB_MASS * LEEB_VELOCITY**2)
    assert law.dent(deepest).diameter == pytest.approx(diameter, rel=0.08)


@pytest.mark.parametrize(("E", "strength"), [(200e9, 600e6), (76e9, 276e6)])  # steel, aluminium
def test_restitution_is_elastic_then_falls_with_a_quarter_power_of_the_velocity(E, strength):
    """From 1 mm/s to 10 m/s and beyond; Johnson, *Contact Mechanics*, eq. (11.46)."""
    metal = ao.Material(E=E, nu=0.3, rho=7800, yield_strength=strength)
    law = ao.ElasticPlastic.between(metal, 0.005, metal, math.inf)
    velocities = np.geomspace(1e-3, 100.0, 31)
    e = np.array([ao.restitution(law, mass=0.004, velocity=v) for v in velocities])
    np.testing.assert_allclose(e[velocities < law.yield_velocity(0.004)], 1.0, rtol=1e-12)
    assert (np.diff(e) <= 1e-12).all()
    powers = np.diff(np.log(e)) / np.diff(np.log(velocities))
    np.testing.assert_allclose(powers[velocities[1:] > 2.0], -0.25, atol=0.02)
