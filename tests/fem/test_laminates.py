"""Laminates: closed forms of the stiffness, shear correction, stress in plies, plates of them."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from thinmeshes import dofs, frequencies, grid, matrices, pressed, solved

import aoimpact as ao
from aoimpact import Laminate, Ply, Shell

CARBON = ao.Orthotropic(E=(135e9, 9e9, 9e9), G=(5e9, 5e9, 3.2e9), nu=(0.3, 0.3, 0.4), rho=1550)
STEEL = ao.Material(E=210e9, nu=0.3, rho=7800)
SIDES = "bottom", "middle", "top"
FOAM = ao.Material(E=100e6, nu=0.3, rho=100)


def stack(*angles: float, thickness: float = 0.125e-3, offset: float = 0.0) -> Laminate:
    plies = [Ply(thickness, CARBON, angle) for angle in angles]
    return Laminate(plies, fibre_axis=(1, 0, 0), offset=offset)


def stresses(layers: Any, strains: Any) -> Any:
    """Stress at the bottom, the middle and the top of each ply, (..., n_plies, 3, 6)."""
    plies = [
        [layers.stress_at(strains, ply, layers.height(side, ply)) for side in SIDES]
        for ply in range(len(layers.plies))
    ]
    return np.moveaxis(np.array(plies), (0, 1), (-3, -2))


def test_one_isotropic_layer_is_reissners_plate() -> None:
    t = 2e-3
    matrix = Shell(t, STEEL).stiffness
    membrane = 210e9 / 0.91 * np.array([[1, 0.3, 0], [0.3, 1, 0], [0, 0, 0.35]])
    assert matrix[:3, :3] == pytest.approx(membrane * t, rel=1e-12, abs=1.0)
    assert matrix[3:6, 3:6] == pytest.approx(membrane * t**3 / 12, rel=1e-12, abs=1e-6)
    assert matrix[6:, 6:] == pytest.approx(np.eye(2) * 5 / 6 * STEEL.shear_modulus * t, rel=1e-12)
    plies = Laminate([Ply(t / 4, STEEL)] * 4)
    assert plies.stiffness == pytest.approx(matrix, rel=1e-12, abs=1e-6)
    assert plies.inertia == pytest.approx([7800 * t, 0, 7800 * t**3 / 12], rel=1e-12, abs=1e-15)


def test_classical_laminate_theory() -> None:
    """A, B and D of unsymmetric cross-plies in closed form (R. M. Jones, section 4.4)."""
    t, ratio = 2e-3, 9e9 / 135e9
    q11 = 135e9 / (1 - 0.3 * 0.3 * ratio)
    q22 = ratio * q11
    a, b, d = (
        stack(0, 90, thickness=t / 2).stiffness[i : i + 3, j : j + 3]
        for i, j in ((0, 0), (0, 3), (3, 3))
    )
    assert a[0, 0] == pytest.approx((q11 + q22) / 2 * t)
    assert a[0, 1] == pytest.approx(0.3 * q22 * t)
    assert a[2, 2] == pytest.approx(5e9 * t)
    assert b[0, 0] == pytest.approx((q22 - q11) * t**2 / 8)
    assert b[1, 1] == pytest.approx(-b[0, 0])
    assert d[0, 0] == pytest.approx((q11 + q22) / 2 * t**3 / 12)


def test_an_offset_moves_the_surface_of_reference() -> None:
    """B = z A, and D = D0 + z² A for a symmetric laminate."""
    middle, moved = stack(0, 90, 0), stack(0, 90, 0, offset=1e-3)
    a, d = middle.stiffness[:3, :3], middle.stiffness[3:6, 3:6]
    assert moved.stiffness[:3, 3:6] == pytest.approx(1e-3 * a, rel=1e-9, abs=1e-3)
    assert moved.stiffness[3:6, 3:6] == pytest.approx(d + 1e-6 * a, rel=1e-9, abs=1e-6)
    assert moved.stiffness[6:, 6:] == pytest.approx(middle.stiffness[6:, 6:], rel=1e-9, abs=1.0)


def test_shear_stiffness_of_a_sandwich_is_that_of_its_core() -> None:
    """Thin faces bend, the core shears: S = G d²/c, d between the middles of the faces."""
    sandwich = Laminate([Ply(0.5e-3, STEEL), Ply(20e-3, FOAM), Ply(0.5e-3, STEEL)])
    core = FOAM.shear_modulus * 20.5e-3**2 / 20e-3
    assert sandwich.stiffness[6, 6] == pytest.approx(core, rel=5e-3)


def test_shear_correction_of_a_cross_ply() -> None:
    """k² of J. M. Whitney (J. Appl. Mech. 40, 302, 1973), by integrals of the shear stress."""
    plies = stack(0, 90, 90, 0, thickness=1e-3)
    z = np.linspace(-2e-3, 2e-3, 40001)
    middle = 0.5 * (z[1:] + z[:-1])
    outer = abs(middle) > 1e-3
    ratio = 9e9 / 135e9
    modulus = np.where(outer, 135e9, 9e9) / (1 - 0.09 * ratio)
    shear = np.where(outer, 5e9, 3.2e9)
    step = z[1] - z[0]
    bending = (modulus * middle**2).sum() * step
    stress = -(np.cumsum(modulus * middle) - 0.5 * modulus * middle) * step / bending
    exact = 1.0 / ((stress**2 / shear).sum() * step)
    assert plies.stiffness[6, 6] == pytest.approx(exact, rel=2e-3)  # ν12: bending across is free


def test_stress_in_plies_gives_the_forces_back() -> None:
    """N, M and Q are integrals of the plies' stresses; shear vanishes on both faces."""
    laminate = stack(30, -45, 90, 0, 15)
    strains = np.array([1e-3, -2e-4, 5e-4, 0.8, -0.3, 0.5, 1e-4, -2e-4])
    stress = stresses(laminate, strains)[:, ::2]
    t, z = 0.125e-3, laminate.interfaces
    plane = [0, 1, 3]
    forces = 0.5 * t * (stress[:, 0] + stress[:, 1]).sum(axis=0)[plane]
    # Of two linear functions of z, by Simpson's rule.
    low, high = stress[:, 0][:, plane], stress[:, 1][:, plane]
    zl, zh = z[:-1, None], z[1:, None]
    moments = (t / 6 * (2 * zl * low + 2 * zh * high + zl * high + zh * low)).sum(axis=0)
    wanted = laminate.stiffness @ strains
    assert forces == pytest.approx(wanted[:3])
    assert moments == pytest.approx(wanted[3:6])
    assert stress[0, 0, 4:] == pytest.approx([0, 0], abs=1e-6)
    assert stress[-1, 1, 4:] == pytest.approx([0, 0], abs=1e-6 * abs(stress[..., 4:]).max())
    assert stress[:-1, 1, 4:] == pytest.approx(stress[1:, 0, 4:])  # continuous


def test_stress_of_one_layer_is_a_parabola_of_shear() -> None:
    """At the bottom, the middle and the top: ± 6 M/t², and 3 Q/(2 t) in the middle."""
    t = 2e-3
    shell = Shell(t, STEEL)
    strains = np.linalg.solve(shell.stiffness, [0, 0, 0, 1.0, 0, 0, 1.0, 0])
    stress = stresses(shell, strains)[0]
    assert stress[:, 0] == pytest.approx([-6 / t**2, 0, 6 / t**2], abs=1e-6)
    assert stress[:, 5] == pytest.approx([0, 1.5 / t, 0], abs=1e-6)


@pytest.mark.parametrize("kind", ["quad", "triangle"])
def test_cross_ply_plate_under_a_sine_of_pressure(kind: str) -> None:
    """Pagano's plate (0/90/0, a/t = 100) by classical theory: w = q/(D π⁴/a⁴ …), within 1 %."""
    a, n = 0.2, 16
    laminate = stack(0, 90, 0, thickness=a / 300)
    nodes, cells, r, s = grid(n, n, lambda r, s: (a * r, a * s, 0 * r), kind)
    K, _ = matrices(nodes, (cells, laminate))
    area = pressed(nodes, cells, laminate, (0, 0, 1)).reshape(-1, 6)
    force = area * (np.sin(np.pi * r) * np.sin(np.pi * s))[:, None]
    ends, sides = (r == 0) | (r == 1), (s == 0) | (s == 1)
    x = solved(K, force.ravel(), dofs(ends, [1, 2, 3]), dofs(sides, [0, 2, 4]), dofs(r >= 0, [5]))
    d = laminate.stiffness[3:6, 3:6]
    exact = (a / np.pi) ** 4 / (d[0, 0] + 2 * (d[0, 1] + 2 * d[2, 2]) + d[1, 1])
    middle = (abs(r - 0.5) < 1e-9) & (abs(s - 0.5) < 1e-9)
    assert x[middle, 2][0] == pytest.approx(exact, rel=0.01)


def test_the_fibre_axis_turns_with_the_mesh() -> None:
    """Frequencies depend on the angle between fibres and body, however the elements are made."""

    def lowest(body: float, fibre: float, ply: float, roll: int) -> Any:
        c, s = math.cos(body), math.sin(body)
        nodes, cells, _, _ = grid(
            8, 4, lambda x, y: (0.3 * x * c - 0.1 * y * s, 0.3 * x * s + 0.1 * y * c, 0 * x)
        )
        axis = (math.cos(fibre), math.sin(fibre), 0.0)
        sheet = Laminate([Ply(1e-3, CARBON, ply), Ply(1e-3, CARBON, ply + 90)], fibre_axis=axis)
        K, M = matrices(nodes, (np.roll(cells, roll, axis=1), sheet))
        return frequencies(K, M, 9)[6:]

    plain = lowest(0.0, 0.0, 30.0, 0)
    assert lowest(0.7, 0.7, 30.0, 0) == pytest.approx(plain, rel=1e-6)
    # Bent about other axes, the plies' shear stresses and so their shear stiffness are others.
    assert lowest(0.0, math.radians(30), 0.0, 1) == pytest.approx(plain, rel=2e-4)
    assert lowest(0.0, 0.0, 0.0, 0)[0] != pytest.approx(plain[0], rel=0.05)


def test_an_orthotropic_shell_is_a_laminate_of_one_ply() -> None:
    nodes, cells, _, _ = grid(3, 3, lambda r, s: (0.1 * r, 0.1 * s, 0.01 * r * s))
    shell = Shell(1e-3, CARBON.turned(0.5))
    laminate = Laminate([Ply(1e-3, CARBON)], fibre_axis=(math.cos(0.5), math.sin(0.5), 0))
    one, other = (matrices(nodes, (cells, part))[0] for part in (shell, laminate))
    assert abs(one - other).max() < 1e-9 * abs(one).max()
