"""Isotropic elasticity: the constants hang together as in any textbook."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from aoimpact import AOImpactWarning, Material

moduli = st.floats(1e6, 1.2e12)
ratios = st.floats(-0.99, 0.499)


@given(E=moduli, nu=ratios)
def test_hookes_law_in_a_bar_gives_back_e_and_nu(E: float, nu: float) -> None:
    lam, mu = Material(E=E, nu=nu, rho=1e3).lame
    stiffness = np.full((3, 3), lam) + 2.0 * mu * np.eye(3)
    strain = np.linalg.solve(stiffness / E, [1.0, 0.0, 0.0])
    assert strain == pytest.approx([1.0, -nu, -nu], rel=1e-9, abs=1e-9)


def test_wave_speeds_of_steel() -> None:
    steel = Material(E=210e9, nu=0.3, rho=7800)
    assert steel.bar_speed == pytest.approx(5188.75, abs=0.01)
    ratio = steel.pressure_speed / steel.shear_speed  # √((2 − 2ν)/(1 − 2ν))
    assert ratio == pytest.approx(math.sqrt(1.4 / 0.4), rel=1e-14)
    assert steel.shear_speed == pytest.approx(steel.bar_speed / math.sqrt(2.6), rel=1e-14)


@pytest.mark.parametrize(
    ("changed", "words"),
    [
        ({"E": 210.0}, r"^E"),
        ({"E": 210e3}, r"^E"),
        ({"E": 210e12}, r"^E"),
        ({"rho": 7.8}, r"^rho"),
        ({"rho": 7.8e-9}, r"^rho"),
        ({"rho": 7.8e-6}, r"^rho"),
        ({"rho": 7.8e6}, r"^rho"),
        ({"yield_strength": 250.0}, r"^yield_strength"),
    ],
)
def test_other_units_than_si_are_noticed(changed: dict[str, float], words: str) -> None:
    with pytest.warns(AOImpactWarning, match=words):
        Material(**{"E": 210e9, "nu": 0.3, "rho": 7800.0, **changed})
