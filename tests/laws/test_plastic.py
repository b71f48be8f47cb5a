"""Thornton's elastic-plastic contact: its restitution in closed form, and its memory."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

import aoimpact as ao

K, FORCE, MASS = 1e10, 100.0, 0.016
LAW = ao.Thornton(K, FORCE)


def thornton(ratio):
    """e(V_y/V) of Thornton (1997), eq. (18)."""
    return (
        math.sqrt(6 * math.sqrt(3) / 5)
        * math.sqrt(1 - ratio**2 / 6)
        * (ratio / (ratio + 2 * math.sqrt(6 / 5 - ratio**2 / 5))) ** 0.25
    )


@given(st.floats(1.0, 1e6))
def test_restitution_is_thorntons(times):
    found = ao.restitution(LAW, MASS, times * LAW.yield_velocity(MASS))
    assert found == pytest.approx(thornton(1 / times), rel=1e-10)


def test_yield_of_spheres_is_johnsons():
    """F_y = π³R²p³/(6E*²), and m V_y²/2 ≈ 53 R³ Y⁵/E*⁴ for p = 1.6 Y: his (4.24) and (11.20)."""
    steel = ao.Material(E=210e9, nu=0.3, rho=7800)
    modulus, radius, pressure = 210e9 / (2 * (1 - 0.3**2)), 0.005, 1.6 * 500e6
    law = ao.Thornton.between(steel, 0.01, steel, 0.01, yield_pressure=pressure)
    # Hertz's largest pressure under that force: (6 F E*²/(π³ R²))^(1/3)
    under = (6 * law.yield_force * modulus**2 / (math.pi**3 * radius**2)) ** (1 / 3)
    assert under == pytest.approx(pressure, rel=1e-12)
    assert law.k == ao.Hertz.between(steel, 0.01, steel, 0.01).k
    energy = MASS * law.yield_velocity(MASS) ** 2 / 2
    assert energy == pytest.approx(53.0 * radius**3 * 500e6**5 / modulus**4, rel=1e-2)
