"""Orthotropic materials: constants, turning, half-spaces."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt
import pytest

import aoimpact as ao
from aoimpact import AOImpactWarning
from aoimpact.fem import nodal_stress, stiffness_mass

FloatArray = npt.NDArray[np.float64]

# Carbon fibres in epoxy, T300/934 as in studies of impact on laminates.
PLY = ao.Orthotropic(E=(135e9, 9e9, 9e9), G=(5e9, 5e9, 3.2e9), nu=(0.3, 0.3, 0.4), rho=1550)
STEEL = ao.Material(E=210e9, nu=0.3, rho=7800)


def as_orthotropic(material: ao.Material) -> ao.Orthotropic:
    e, g, nu = material.E, material.shear_modulus, material.nu
    return ao.Orthotropic(E=(e, e, e), G=(g, g, g), nu=(nu, nu, nu), rho=material.rho)


def test_an_isotropic_one_is_a_material() -> None:
    same = as_orthotropic(STEEL).turned(0.7, about=(1, 2, 3))
    assert same.stiffness == pytest.approx(STEEL.stiffness, rel=1e-12, abs=1e-3)
    mesh = ao.box_mesh((0.1, 0.05, 0.02), (2, 2, 1), kind="hexahedron20")
    for one, other in zip(stiffness_mass(mesh, same), stiffness_mass(mesh, STEEL), strict=True):
        assert abs(one - other).max() < 1e-12 * abs(other).max()
    stand_in = same.half_space((0.3, -0.5, 1.0))
    assert stand_in.plane_strain_modulus == pytest.approx(STEEL.plane_strain_modulus, rel=1e-10)
    assert stand_in.nu == pytest.approx(0.3, rel=1e-8)


def test_engineering_constants_are_what_tensile_tests_measure() -> None:
    compliance = np.linalg.inv(PLY.stiffness)
    assert np.diag(compliance) == pytest.approx(
        [1 / 135e9, 1 / 9e9, 1 / 9e9, 1 / 5e9, 1 / 3.2e9, 1 / 5e9]
    )
    assert -compliance[1, 0] / compliance[0, 0] == pytest.approx(0.3)  # ν12
    assert -compliance[2, 0] / compliance[0, 0] == pytest.approx(0.3)  # ν13
    assert -compliance[2, 1] / compliance[1, 1] == pytest.approx(0.4)  # ν23


@pytest.mark.parametrize("angle", [0.0, 0.3, math.pi / 4, 1.2, math.pi / 2])
def test_modulus_off_the_axes(angle: float) -> None:
    """1/E_x = c⁴/E1 + (1/G12 - 2ν12/E1) c²s² + s⁴/E2 (R. M. Jones, eq. 2.97)."""
    c, s = math.cos(angle), math.sin(angle)
    exact = c**4 / 135e9 + (1 / 5e9 - 2 * 0.3 / 135e9) * (c * s) ** 2 + s**4 / 9e9
    compliance = np.linalg.inv(PLY.turned(angle).stiffness)
    assert compliance[0, 0] == pytest.approx(exact, rel=1e-12)
    by_axes = ao.Orthotropic(PLY.E, PLY.G, PLY.nu, PLY.rho, ((c, s, 0), (-s, c, 0)))
    assert by_axes.stiffness == pytest.approx(PLY.turned(angle).stiffness, rel=1e-9, abs=1.0)


def test_the_half_space_of_a_transversely_isotropic_solid() -> None:
    """M = 2 √((C11 C33 - C13²)/C11 / (1/C44 + 2/(√(C11 C33) + C13))).

    Along the axis of symmetry (A. Delafargue and F.-J. Ulm, Int. J. Solids Struct. 41, 7351, 2004).
    """
    e, along, g, nu, across = 9e9, 30e9, 4e9, 0.35, 0.1
    solid = ao.Orthotropic((e, e, along), (e / (2 + 2 * nu), g, g), (nu, across, across), 1500)
    C = solid.stiffness
    root = math.sqrt(C[0, 0] * C[2, 2])
    square = (C[0, 0] * C[2, 2] - C[0, 2] ** 2) / C[0, 0]
    exact = 2.0 * math.sqrt(square / (1.0 / C[4, 4] + 2.0 / (root + C[0, 2])))
    assert solid.half_space((0, 0, -2)).plane_strain_modulus == pytest.approx(exact, rel=1e-10)
    turned = solid.turned(0.5 * math.pi, about=(0, 1, 0))
    assert turned.half_space((1, 0, 0)).plane_strain_modulus == pytest.approx(exact, rel=1e-10)


def test_stress_and_energy_of_a_uniform_strain() -> None:
    mesh = ao.box_mesh((0.1, 0.05, 0.02), (3, 2, 2), kind="tetra10")
    ply = PLY.turned(0.4)
    gradient = 1e-3 * np.random.default_rng(3).standard_normal((3, 3))
    moved = mesh.nodes @ gradient.T
    strain = 0.5 * (gradient + gradient.T)
    exact = np.einsum("ijkl,kl->ij", ply.tensor, strain)
    found = nodal_stress(mesh, ply, moved).tensor
    assert found == pytest.approx(np.tile(exact, (mesh.n_nodes, 1, 1)), rel=1e-9, abs=1.0)
    body = ao.FEModel.from_mesh(mesh, ply)
    energy = moved.reshape(-1) @ (body.K @ moved.reshape(-1))
    assert energy == pytest.approx(np.sum(exact * strain) * 1e-4, rel=1e-12)


def test_values_in_other_units_are_said() -> None:
    with pytest.warns(AOImpactWarning, match=r"^E"):
        ao.Orthotropic((135.0, 9e9, 9e9), PLY.G, (0.0, 0.0, 0.0), PLY.rho)
    with pytest.warns(AOImpactWarning, match=r"^G"):
        ao.Orthotropic(PLY.E, (5e9, 5e3, 3.2e9), PLY.nu, PLY.rho)
