"""Beams: closed forms of sections, static loads, waves and frequencies, and the paper's beam."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
import scipy.optimize
from thinmeshes import dofs, frequencies, grid, line, matrices, rigid_motions, solved

import aoimpact as ao
from aoimpact import (
    Beam,
    BeamSection,
    CircularSection,
    RectangularSection,
    Shell,
    TubularSection,
)

STEEL = ao.Material(E=210e9, nu=0.3, rho=7800)
BAR = Beam(RectangularSection(width=0.02, height=0.05), STEEL, orientation=(0, 0, 1))


def test_an_element_resists_all_but_rigid_motion() -> None:
    ends = np.array([[0, 0, 0], [0.3, 0.4, 0.2]])
    K, M = (A.toarray() for A in matrices(ends, (np.array([[0, 1]]), BAR)))
    assert abs(K @ rigid_motions(ends)).max() < 1e-13 * abs(K).max()
    assert (np.linalg.eigvalsh(K) < 1e-9 * abs(K).max()).sum() == 6
    mass = rigid_motions(ends).T @ M @ rigid_motions(ends)
    assert np.diag(mass)[:3] == pytest.approx(7800 * 0.02 * 0.05 * np.linalg.norm(ends[1]))
    assert np.array_equal(M, M.T)


@pytest.mark.parametrize("direction", [(1, 0, 0), (0.3, -0.5, 0.8)])
def test_one_element_is_exact_under_loads_at_nodes(direction: Any) -> None:
    """A cantilever under all six loads at its tip: stretched, bent twice with shear, twisted."""
    x = np.array(direction) / np.linalg.norm(direction)
    y = np.cross([0, 0, 1.0], x)
    y /= np.linalg.norm(y)
    axes = np.array([x, y, np.cross(x, y)])
    L, E, G = 0.4, 210e9, STEEL.shear_modulus
    K, _ = matrices(np.array([0 * x, L * x]), (np.array([[0, 1]]), BAR))
    area, iy, iz = 1e-3, 0.02 * 0.05**3 / 12, 0.05 * 0.02**3 / 12
    kappa = 10 * 1.3 / (12 + 11 * 0.3)
    j = BAR.numbers.J
    exact = np.diag([L / (E * area), 0, 0, L / (G * j), L / (E * iy), L / (E * iz)])
    exact[1, 1] = L**3 / (3 * E * iz) + L / (kappa * G * area)
    exact[2, 2] = L**3 / (3 * E * iy) + L / (kappa * G * area)
    exact[1, 5] = exact[5, 1] = L**2 / (2 * E * iz)
    exact[2, 4] = exact[4, 2] = -(L**2) / (2 * E * iy)
    turn = np.kron(np.eye(2), axes)
    tip = [solved(K, np.concatenate([np.zeros(6), load]), np.arange(6))[1] for load in turn]
    assert turn @ np.array(tip).T == pytest.approx(exact, rel=1e-9, abs=1e-16)


def test_torsion_of_a_rectangle() -> None:
    """J/(a b³) of S. P. Timoshenko and J. N. Goodier, section 109."""
    for ratio, wanted in ((1, 0.1406), (2, 0.229), (5, 0.291), (10, 0.312)):
        section = RectangularSection(ratio * 0.01, 0.01).with_nu(0.3)
        assert section.J / (ratio * 0.01**4) == pytest.approx(wanted, abs=6e-4)
        turned = RectangularSection(0.01, ratio * 0.01).with_nu(0.3)
        assert abs(turned.J - section.J) < 1e-12 * section.J


def test_shear_factors_are_cowpers() -> None:
    assert RectangularSection(1, 2).with_nu(0.0).shear_factors[0] == pytest.approx(5 / 6)
    assert CircularSection(1.0).with_nu(0.3).shear_factors[1] == pytest.approx(7.8 / 8.8)
    thin = TubularSection(1.0, 1e-6).with_nu(0.3).shear_factors[0]
    assert thin == pytest.approx(2 * 1.3 / (4 + 3 * 0.3), rel=1e-5)


def test_tubes_and_circles() -> None:
    tube, circle = TubularSection(0.02, 0.002).with_nu(0.3), CircularSection(0.02).with_nu(0.3)
    assert tube.area == pytest.approx(math.pi * (0.02**2 - 0.018**2))
    assert tube.Iy == pytest.approx(math.pi / 4 * (0.02**4 - 0.018**4))
    assert circle.J / (math.pi / 2 * 0.02**4) == pytest.approx(1.0)


@pytest.mark.parametrize("wall", [0.02, 0.008, 1e-3])
def test_shear_stress_of_circles_and_tubes(wall: float) -> None:
    """Equilibrium with σ = M z/I, no traction on either surface, and the force as resultant."""
    section = CircularSection(0.02) if wall == 0.02 else TubularSection(0.02, wall)
    beam = Beam(section, STEEL)
    numbers = beam.numbers
    force = np.array([300.0, -500.0])
    strains = np.array([0, 0, 0, 0, *(force / beam.stiffness[4:])])

    def shear(y: float, z: float) -> Any:
        return beam.stress(strains, (y, z))[1:]

    step, inside = 1e-6, 0.02 - 0.5 * wall
    for turn in (0.3, 1.2, 4.0):
        n = np.array([math.cos(turn), math.sin(turn)])
        for R in {0.02, 0.02 - wall} - {0.0}:
            assert abs(shear(*(R * n)) @ n) < 1e-5 * np.linalg.norm(force) / numbers.area
        y, z = inside * n
        change = (shear(y + step, z) - shear(y - step, z))[0] / (2 * step)
        change += (shear(y, z + step) - shear(y, z - step))[1] / (2 * step)
        assert change == pytest.approx(-force @ (y, z) / numbers.Iy, rel=1e-6)
    at, weights = np.polynomial.legendre.leggauss(8)
    radii, turns = 0.02 - 0.5 * wall * (1 - at), 2 * np.pi * np.arange(12) / 12
    total = sum(
        w * r * shear(r * math.cos(turn), r * math.sin(turn))
        for r, w in zip(radii, weights, strict=True)
        for turn in turns
    )
    assert total * 0.5 * wall * 2 * np.pi / 12 == pytest.approx(force, rel=1e-9)


def test_shear_of_a_full_circle_is_timoshenkos() -> None:
    """1.38 V/A in the middle and 1.23 V/A at the ends of the neutral axis (section 122)."""
    beam = Beam(CircularSection(0.02), STEEL)
    strains = np.array([0, 0, 0, 0, 0, 1.0 / beam.stiffness[5]])
    for place, wanted in (((0.0, 0.0), 1.38), ((0.02, 0.0), 1.23), (None, 1.38)):
        found = beam.stress(strains, place)[2] * beam.numbers.area
        assert abs(found) == pytest.approx(wanted, abs=0.006)


def test_waves_along_a_bar_and_about_it() -> None:
    """Free: longitudinal f = c/(2 L) and torsional f = √(G J/(ρ Ip))/(2 L)."""
    mesh = line(1.0, 40)
    nodes, cells = mesh.nodes, mesh.cells
    K, M = matrices(nodes, (cells, BAR))
    along, about = (
        frequencies(K, M, 2, dofs(nodes[:, 0] >= 0, [d for d in range(6) if d != free]))[1]
        for free in (0, 3)
    )
    of = BAR.numbers
    assert along == pytest.approx(STEEL.bar_speed / 2, rel=1e-3)
    twisted = math.sqrt(STEEL.shear_modulus * of.J / (7800 * (of.Iy + of.Iz)))
    assert about == pytest.approx(twisted / 2, rel=1e-3)


def test_an_eccentric_stiffener_makes_one_section_with_its_plate() -> None:
    """E I of both about their common axis: I1 + I2 + A1 A2/(A1 + A2) d²."""
    t, width, height = 2e-3, 0.04, 0.02
    nodes, cells, r, s = grid(32, 2, lambda r, s: (0.8 * r, width * (s - 0.5), 0 * r))
    middle = np.flatnonzero(abs(s - 0.5) < 1e-9)
    spine = np.column_stack([middle[:-1], middle[1:]])
    d = (t + height) / 2
    metal = ao.Material(210e9, 0.0, 7800)
    rib = Beam(RectangularSection(5e-3, height), metal, (0, 0, 1), offset=(0, -d))
    K, M = matrices(nodes, (cells, Shell(t, metal)), (spine, rib))
    force = np.zeros((len(nodes), 6))
    force[middle[-1], 2] = 1.0
    x = solved(K, force.ravel(), dofs(r == 0, range(6)))
    plate, web = width * t, 5e-3 * height
    second = (plate * t**2 + web * height**2) / 12 + plate * web / (plate + web) * d**2
    assert x[middle[-1], 2] == pytest.approx(0.8**3 / (3 * 210e9 * second), rel=0.015)
    motions = rigid_motions(nodes)
    assert abs(K @ motions).max() < 1e-9 * abs(K).max()
    about = (motions.T @ M @ motions)[4, 0]  # of x by rotation about y: ∫ρ z dV
    assert about == pytest.approx(-7800 * web * 0.8 * d)


def test_a_section_that_is_rigid_in_shear_is_eulers_with_rotary_inertia() -> None:
    """A thick cantilever: its deflection is FL³/(3EI), its frequencies Rayleigh's.

    EI w_xxxx + ρI ω² w_xx = ρA ω² w, with w_xx = 0 and EI w_xxx + ρI ω² w_x = 0 at its free end.
    """
    b, h, L, E, rho = 0.3, 0.2, 0.8, 210e9, 7800
    second = b * h**3 / 12
    section = BeamSection(b * h, second, b**3 * h / 12, second, (math.inf, math.inf))
    mesh = line(L, 16)
    nodes, cells = mesh.nodes, mesh.cells
    K, M = matrices(nodes, (cells, Beam(section, STEEL, orientation=(0, 0, 1))))
    force = np.zeros(6 * len(nodes))
    force[dofs(16, (2,))] = 1.0
    tip = solved(K, force, np.arange(6))[16, 2]
    assert tip == pytest.approx(L**3 / (3 * E * second), rel=1e-9)

    def unbalanced(f: float) -> float:
        turning, moving = (rho * (2 * np.pi * f) ** 2 / E * of for of in (1, 12 / h**2))
        r = np.roots([1, 0, turning, 0, -moving])
        rows = [r**0, r, r**2 * np.exp(r * L), (r**3 + turning * r) * np.exp(r * L)]
        return float(np.real(np.linalg.det(rows) / np.linalg.det(np.vander(r))))

    eulers = 1.8751040687**2 / (2 * np.pi * L**2) * math.sqrt(E * second / (rho * b * h))
    exact = scipy.optimize.brentq(unbalanced, 0.95 * eulers, eulers)
    assert frequencies(K, M, 1, np.arange(6)) == pytest.approx(exact, rel=1e-5)
