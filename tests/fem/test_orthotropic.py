"""Orthotropic materials: constants, turning, half-spaces, and laminates against plate theory."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
import scipy.sparse.linalg as sla

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


# ------------------------------------------------------------------- laminates

LENGTHS, PLY_THICKNESS = (0.2, 0.15), 0.25e-3


def laminate(angles: tuple[float, ...], counts: tuple[int, int], **more: Any) -> ao.FEModel:
    """A plate of plies, hexahedron20, one element through each."""
    thickness = len(angles) * PLY_THICKNESS
    box = ao.box_mesh((*LENGTHS, thickness), (*counts, len(angles)), kind="hexahedron20")
    layer = (box.nodes[box.cells].mean(axis=1)[:, 2] / PLY_THICKNESS).astype(int)
    groups = {f"ply {i}": np.flatnonzero(layer == i) for i in range(len(angles))}
    mesh = ao.Mesh(box.nodes, box.cells, box.kind, box.node_sets, groups)
    material = {f"ply {i}": PLY.turned(angle) for i, angle in enumerate(angles)}
    return ao.FEModel.from_mesh(mesh, material, **more)


def bending_stiffness(angles: tuple[float, ...]) -> FloatArray:
    """D of classical lamination theory, N m, shape (3, 3): Σ Q̄ (z₂³ - z₁³)/3."""
    e1, e2, g, nu = 135e9, 9e9, 5e9, 0.3
    share = 1.0 - nu**2 * e2 / e1
    Q = np.array([[e1, nu * e2, 0.0], [nu * e2, e2, 0.0], [0.0, 0.0, g * share]]) / share
    D, z = np.zeros((3, 3)), -0.5 * len(angles) * PLY_THICKNESS
    for angle in angles:
        c, s = math.cos(angle), math.sin(angle)
        T = np.array(
            [[c * c, s * s, c * s], [s * s, c * c, -c * s], [-2 * c * s, 2 * c * s, c * c - s * s]]
        )
        D += T.T @ Q @ T * ((z + PLY_THICKNESS) ** 3 - z**3) / 3.0
        z += PLY_THICKNESS
    return D


def test_the_bending_of_an_angle_ply_plate() -> None:
    """A strip of ±45° plies, free to twist: κ = D⁻¹ M, in a field that is exact everywhere.

    By energy: the curvatures of classical lamination, with each ply's plane stress, hold no more.
    """
    angles = tuple(math.radians(angle) for angle in (45.0, -45.0, -45.0, 45.0))
    body = laminate(angles, (6, 5))
    D = bending_stiffness(angles)
    assert body.mesh is not None
    kappa = np.array([1.0, -0.4, 0.3])
    x, y, z = body.mesh.nodes.T
    x, y, z = x - x.mean(), y - y.mean(), z - z.mean()
    # u = -z ∇w, w = ½(κx x² + κy y² + κxy x y), with ε = z κ: signs do not matter to the energy
    moved = np.column_stack(
        [
            z * (kappa[0] * x + 0.5 * kappa[2] * y),
            z * (kappa[1] * y + 0.5 * kappa[2] * x),
            -0.5 * (kappa[0] * x**2 + kappa[1] * y**2 + kappa[2] * x * y),
        ]
    )
    # The thickness adjusts so that σzz = 0 in each ply: found by letting it, all else held.
    K, n = body.K, body.n_dofs
    through = np.flatnonzero(np.arange(n) % 3 == 2)
    flat = moved.reshape(-1)
    held = through[np.abs(z[through // 3]) < 1e-9]
    let = np.setdiff1d(through, held)
    flat[let] -= sla.spsolve(K[let][:, let].tocsc(), (K @ flat)[let])
    energy = flat @ (K @ flat) / (LENGTHS[0] * LENGTHS[1])
    assert energy == pytest.approx(kappa @ D @ kappa, rel=0.01)


def test_values_in_other_units_are_said() -> None:
    with pytest.warns(AOImpactWarning, match=r"^E"):
        ao.Orthotropic((135.0, 9e9, 9e9), PLY.G, (0.0, 0.0, 0.0), PLY.rho)
    with pytest.warns(AOImpactWarning, match=r"^G"):
        ao.Orthotropic(PLY.E, (5e9, 5e3, 3.2e9), PLY.nu, PLY.rho)
