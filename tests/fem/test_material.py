"""Isotropic elasticity: the constants hang together as in any textbook."""

from __future__ import annotations

import math
import pickle
from dataclasses import FrozenInstanceError

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from aoimpact.base.errors import AOImpactError, InputError, InputTypeError
from aoimpact.fem.material import Material

moduli = st.floats(1e3, 1e13)
ratios = st.floats(-0.99, 0.499)


@given(E=moduli, nu=ratios)
def test_hookes_law_in_a_bar_gives_back_e_and_nu(E: float, nu: float) -> None:
    lam, mu = Material(E=E, nu=nu, rho=1.0).lame
    stiffness = np.full((3, 3), lam) + 2.0 * mu * np.eye(3)
    strain = np.linalg.solve(stiffness / E, [1.0, 0.0, 0.0])
    assert strain == pytest.approx([1.0, -nu, -nu], rel=1e-9, abs=1e-9)


@given(E=moduli, nu=ratios)
def test_shear_modulus_is_lames_second_constant(E: float, nu: float) -> None:
    material = Material(E=E, nu=nu, rho=1.0)
    assert material.shear_modulus == material.lame[1] == pytest.approx(E / (2.0 * (1.0 + nu)))


def test_plane_strain_modulus_is_the_bodys_part_of_hertz_s_modulus() -> None:
    # Paper, eq. (13): k_H = 1.088e10 for two steel spheres of 10 mm (design's value of eq. 13).
    steel = Material(E=210e9, nu=0.3, rho=7800)
    k_hertz = 4.0 / 3.0 * steel.plane_strain_modulus / 2.0 * math.sqrt(0.01 / 2.0)
    assert k_hertz == pytest.approx(1.0878566e10, rel=1e-7)


def test_wave_speeds_of_steel() -> None:
    steel = Material(E=210e9, nu=0.3, rho=7800)
    assert steel.bar_speed == pytest.approx(5188.75, abs=0.01)
    ratio = steel.pressure_speed / steel.shear_speed  # √((2 − 2ν)/(1 − 2ν))
    assert ratio == pytest.approx(math.sqrt(1.4 / 0.4), rel=1e-14)
    assert steel.shear_speed == pytest.approx(steel.bar_speed / math.sqrt(2.6), rel=1e-14)


@pytest.mark.parametrize(
    ("changed", "words"),
    [
        ({"E": 0.0}, "E must be positive, got 0 Pa"),
        ({"E": -1.0}, "E must be positive"),
        ({"E": math.nan}, "E must be a number, got nan"),
        ({"E": math.inf}, "E must be finite"),
        ({"rho": 0.0}, "rho must be positive"),
        ({"rho": -7800.0}, "rho must be positive"),
        ({"nu": 0.5}, r"nu must lie between -1 and 0\.5"),
        ({"nu": 0.7}, "got 0.7"),
        ({"nu": -1.0}, "nu must lie"),
        ({"nu": math.nan}, "nu must be a number"),
    ],
)
def test_impossible_constants_are_refused(changed: dict[str, float], words: str) -> None:
    with pytest.raises(InputError, match=words):
        Material(**{"E": 210e9, "nu": 0.3, "rho": 7800.0, **changed})


@pytest.mark.parametrize("value", ["210e9", None, 1j, True, [1.0], np.array([1.0])])
def test_what_is_no_number_is_refused(value: object) -> None:
    with pytest.raises(InputTypeError, match="E must be a real number"):
        Material(E=value, nu=0.3, rho=7800)  # type: ignore[arg-type]


def test_errors_are_also_the_built_in_kinds() -> None:
    with pytest.raises(ValueError, match="nu"):
        Material(E=1, nu=2, rho=1)
    with pytest.raises(TypeError, match="E"):
        Material(E="1", nu=0.3, rho=1)  # type: ignore[arg-type]
    with pytest.raises(AOImpactError):
        Material(E=0, nu=0.3, rho=1)


def test_material_is_a_value() -> None:
    steel = Material(E=np.float32(210e9), nu=np.array(0.3), rho=7800)
    assert steel == Material(E=float(np.float32(210e9)), nu=0.3, rho=7800.0)
    assert pickle.loads(pickle.dumps(steel)) == steel
    assert hash(steel) == hash(pickle.loads(pickle.dumps(steel)))
    with pytest.raises(FrozenInstanceError):
        steel.E = 1.0  # type: ignore[misc]
