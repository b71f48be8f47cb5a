"""Contact on a shell: an elastic layer in place of plate elements, against resolved contact."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
import scipy.sparse.linalg as sla
from scipy.special import kei
from thinmeshes import dofs, grid, turned

import aoimpact as ao
from aoimpact import Laminate, Ply, Shell
from aoimpact.fem.layer import (
    layer_compliance,
    layer_compliance_of,
    mesh_compliance,
    plate_compliance,
    plate_motion,
)
from aoimpact.fem.thin import thin_stiffness_mass

FloatArray = npt.NDArray[np.float64]

STEEL = ao.Material(E=210e9, nu=0.3, rho=7800)
KINDS = pytest.mark.parametrize("kind", ["quad", "triangle"])


def test_a_slow_layer_bends_as_a_thin_plate() -> None:
    """1/(8 s √(D m)), an infinite plate's velocity under a force (C. Zener, 1941)."""
    t, s = 1e-3, 100.0
    thin = 1.0 / (8.0 * s * math.sqrt(210e9 * t**3 / (12 * 0.91) * 7800 * t))
    assert layer_compliance(STEEL, t, 3e-4, s) == pytest.approx(thin, rel=1e-3)
    assert plate_compliance(Shell(t, STEEL), 3e-4, s) == pytest.approx(thin, rel=1e-3)


def test_a_thick_layer_is_a_half_space() -> None:
    """Beyond the half-space's own compliance 0.6/(a E*) hardly any is left."""
    left = layer_compliance(STEEL, 0.2, 3e-4, 1e5)
    assert abs(left) < 0.02 * 0.6 / (3e-4 * STEEL.plane_strain_modulus)


def test_the_static_layer_has_the_known_compliance() -> None:
    """H(k) in closed form: less the plate's 1/(D k⁴), it does not depend on s."""
    t, a = 2e-3, 3e-4
    k = np.geomspace(1e-1, 4e5, 4000)
    q = np.minimum(0.5 * k * t, 15.0)
    sinh, cosh = np.sinh(2 * q), np.cosh(2 * q)
    e = 0.91 / 210e9
    whole = e / k * ((cosh - 1) / (sinh + 2 * q) + (cosh + 1) / (sinh - 2 * q))
    bent = 12 * e / (t**3 * k**4)
    x = k * a
    pressure = (3 * (np.sin(x) - x * np.cos(x)) / np.maximum(x, 1e-2) ** 3) ** 2
    pressure[x < 1e-2] = 1.0
    rest = np.where(q < 0.02, 2.4 * e / (t * k**2), whole - bent) - 2 * e / k

    def static(s: float) -> float:
        length = (210e9 * t**3 / (12 * 0.91) / (7800 * t * s * s)) ** 0.25
        slow = 1 / (1 + (k * length) ** -4)
        # Shear and the half-space's share, cut off where bending waves are.
        values = pressure * ((rest + 2 * e / k) * slow - 2 * e / k) * k**2
        return float(np.trapezoid(values, np.log(k)) / (2 * np.pi)) + length**2 / (
            8 / 12 * t**3 / e
        )

    for s in (1e4, 1e5):
        # Inertia's terms of the order of t² are the same for all s.
        shear = 1 / (8 * np.pi * 5 / 6 * STEEL.shear_modulus * t)
        rotary = t**2 / (96 * np.pi * 210e9 * t**3 / (12 * 0.91))
        found = layer_compliance(STEEL, t, a, s)
        assert found == pytest.approx(static(s) - shear - rotary, rel=5e-3)


def test_motion_of_mindlins_plate() -> None:
    """Far off that of a thin plate; near the force its slope is that of shear, -1/(2π S r)."""
    t, s = 2e-3, 1e5
    shell = Shell(t, STEEL)
    D, S, m = shell.stiffness[3, 3], shell.stiffness[6, 6], shell.inertia[0]
    length = (D / (m * s * s)) ** 0.25
    x = np.array([[3 * length, 0.0], [0.0, 3 * length]])
    moved = plate_motion(shell, s, x)[:, 2:]
    assert moved[0, 0] == pytest.approx(-(length**2) / (2 * np.pi * D) * kei(3.0), rel=0.1)
    assert moved[0, 1] == pytest.approx(0.0, abs=1e-20)
    assert moved[1, 1] == pytest.approx(-moved[0, 2])
    near = np.array([[1e-5, 0.0], [1.01e-5, 0.0]])
    slope = np.diff(plate_motion(shell, s, near)[:, 2])[0] / 1e-7
    assert slope == pytest.approx(-1 / (2 * np.pi * S * 1.005e-5), rel=0.01)


def test_motion_of_a_laminates_plate() -> None:
    """Plane waves in all directions: of one material, twice, they are Mindlin's closed form."""
    plies = Laminate([Ply(1e-3, STEEL), Ply(1e-3, STEEL)])
    x = np.array([[0.006, 0.0], [0.003, 0.0055], [-0.0055, 0.0062]])
    moved, closed = (plate_motion(each, 3e5, x) for each in (plies, Shell(2e-3, STEEL)))
    assert moved == pytest.approx(closed, rel=1e-3, abs=1e-3 * np.abs(closed[:, 2]).max())


def sheet(t: float, n: int, kind: str, size: float = 0.15) -> tuple[Any, Any, Any, FloatArray, int]:
    """Bending of a free square sheet: K, M, elements, nodes and the node in the middle."""
    nodes, cells, r, s = grid(n, n, lambda r, s: (size * (r - 0.5), size * (s - 0.5), 0 * r), kind)
    K, M = thin_stiffness_mass(nodes, [(cells, Shell(t, STEEL))])
    bent = dofs(r >= 0, [2, 3, 4])
    middle = int(np.flatnonzero((abs(r - 0.5) < 1e-9) & (abs(s - 0.5) < 1e-9))[0])
    return K[bent][:, bent], M[bent][:, bent], cells, nodes, middle


def excess_compliance(
    nodes: FloatArray,
    cells: list[Any],
    layers: Any,
    forces: FloatArray,
    point: FloatArray,
    normal: FloatArray,
    radius: float,
    s: float,
) -> float:
    """G - R, the compliance that shell elements have in excess of a layer's, m/N."""
    of_mesh = mesh_compliance(nodes, cells, layers, forces, point, normal, s)
    return float(of_mesh[0]) - layer_compliance_of(layers, radius, s)


def excess(t: float, cells: Any, nodes: FloatArray, node: int, s: float, tilt: Any = None) -> float:
    turn = np.eye(3) if tilt is None else tilt
    forces = np.zeros(len(nodes))
    forces[node] = 1.0
    return excess_compliance(
        nodes @ turn.T, [cells], Shell(t, STEEL), forces, turn @ nodes[node], turn[:, 2], 3e-4, s
    )


@KINDS
@pytest.mark.parametrize(
    ("t", "n"), [(2e-3, 30), pytest.param(2e-3, 60, marks=pytest.mark.slow), (1e-3, 30), (8e-3, 30)]
)
def test_the_mesh_about_a_contact_gives_its_excess(kind: str, t: float, n: int) -> None:
    """G of a sheet in which no wave comes back, less the layer's R: c, from the mesh nearby."""
    s = 3e5
    K, M, cells, nodes, node = sheet(t, n, kind)
    b = np.zeros(K.shape[0])
    b[3 * node] = 1.0
    of_mesh = float(b @ sla.spsolve((K + s * s * M).tocsc(), b))
    c = of_mesh - layer_compliance(STEEL, t, 3e-4, s)
    assert excess(t, cells, nodes, node, s) == pytest.approx(c, rel=0.01, abs=8e-11)


def test_excess_does_not_depend_on_place_in_space() -> None:
    _, _, cells, nodes, node = sheet(2e-3, 20, "quad")
    flat, tilted = (excess(2e-3, cells, nodes, node, 3e5, tilt) for tilt in (None, turned()))
    assert tilted == pytest.approx(flat, rel=1e-8)


def test_an_offset_is_no_part_of_the_excess() -> None:
    _, _, cells, nodes, node = sheet(2e-3, 20, "quad")
    forces = np.zeros(len(nodes))
    forces[node] = 1.0
    up = np.array([0.0, 0.0, 1.0])
    middle, face = (
        excess_compliance(nodes, [cells], Shell(2e-3, STEEL, z), forces, nodes[node], up, 3e-4, 3e5)
        for z in (0.0, 1e-3)
    )
    assert face == pytest.approx(middle, rel=1e-6)


def excess_of(layers: Any, a: float = 5e-4, s: float = 2e5) -> float:
    nodes, cells, r, t = grid(12, 12, lambda r, s: (0.06 * (r - 0.5), 0.06 * (s - 0.5), 0 * r))
    forces = ((abs(r - 0.5) < 1e-9) & (abs(t - 0.5) < 1e-9)).astype(np.float64)
    return excess_compliance(nodes, [cells], layers, forces, np.zeros(3), np.eye(3)[2], a, s)


def test_a_laminate_of_one_material_is_a_layer_of_it() -> None:
    """Elements through the thickness against Rayleigh and Lamb."""
    layer, plies = Shell(2e-3, STEEL), Laminate([Ply(1e-3, STEEL), Ply(1e-3, STEEL)])
    assert excess_of(plies) == pytest.approx(excess_of(layer), abs=2e-11)


UNIDIRECTIONAL = ao.Orthotropic((135e9, 9e9, 9e9), (5e9, 5e9, 3.2e9), (0.3, 0.3, 0.4), rho=1550)


@KINDS
@pytest.mark.parametrize(
    "angles", [*(pytest.param(of, marks=pytest.mark.slow) for of in ((0.0,), (30.0,))), (0.0, 90.0)]
)
def test_a_laminate_is_meshed_as_it_is(kind: str, angles: tuple[float, ...]) -> None:
    """A wide sheet in which no wave comes back yields as its mesh about the force, from any side.

    The plies at 0 and 90 degrees stretch as they bend.
    """
    stack = Laminate([Ply(2e-3 / len(angles), UNIDIRECTIONAL, x) for x in angles], (1, 0, 0))
    nodes, cells, r, q = grid(40, 40, lambda r, s: (0.2 * (r - 0.5), 0.2 * (s - 0.5), 0 * r), kind)
    K, M = thin_stiffness_mass(nodes, [(cells, stack)])
    force = ((abs(r - 0.5) < 1e-9) & (abs(q - 0.5) < 1e-9)).astype(np.float64)
    load, s = np.kron(force, np.eye(6)[2]), 2e5
    whole = float(load @ sla.spsolve((K + s * s * M).tocsc(), load))
    up = np.array([0.0, 0.0, 1.0])
    above = mesh_compliance(nodes, [cells], stack, force, np.zeros(3), up, s)
    below = stack.seen_from(top=False)
    under = mesh_compliance(nodes, [cells], below, force, np.zeros(3), -up, s)
    assert above[0] == pytest.approx(whole, rel=3e-3)
    assert under[0] == pytest.approx(whole, rel=3e-3)


def test_excess_of_a_laminate() -> None:
    """It does not depend on how the body lies, and hardly on how fine plies are stacked."""

    def stack(*angles: float) -> Laminate:
        return Laminate([Ply(2e-3 / len(angles), UNIDIRECTIONAL, x) for x in angles], (1, 0, 0))

    one = excess_of(stack(0, 45, 90, -45, -45, 90, 45, 0))
    assert excess_of(stack(90, 135, 180, 45, 45, 180, 135, 90)) == pytest.approx(one, rel=1e-6)
    assert excess_of(stack(45, 0, -45, 90, 90, -45, 0, 45)) == pytest.approx(one, rel=0.1)


@KINDS
def test_excess_near_an_edge_is_that_of_the_mesh_alone(kind: str) -> None:
    """The body's bounds are no part of it: they are in the body's own G."""
    _, _, cells, nodes, node = sheet(2e-3, 20, kind)
    in_the_middle = excess(2e-3, cells, nodes, node, 3e5)
    for off in (3, 2):  # elements from the edge
        near = excess(2e-3, cells, nodes, 21 * off + 10, 3e5)
        assert near == pytest.approx(in_the_middle, abs=0.1 * abs(in_the_middle) + 2e-10)


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:.*with_mesh:aoimpact.AOImpactWarning")  # c is taken out here
@pytest.mark.parametrize(
    ("t", "rigid", "peak"),
    [(2e-3, True, 241.7), (2e-3, False, 215.1), (4e-3, False, 347.7)],
)
def test_a_ball_on_a_sheet(t: float, rigid: bool, peak: float) -> None:
    """R 5 mm at 1 m/s: resolved contact (241.7 N), and Zener's thin plates, by any elements."""
    duration, radius = 40e-6, 5e-3
    law = (
        ao.Hertz(k=4 / 3 * STEEL.plane_strain_modulus * math.sqrt(radius))
        if rigid
        else ao.Hertz.between(STEEL, radius, STEEL, math.inf)
    )
    found = []
    for n in (20, 40):
        K, M, cells, nodes, node = sheet(t, n, "quad", 0.1)
        b = np.zeros(K.shape[0])
        b[3 * node] = 1.0
        c = excess(t, cells, nodes, node, 10 / duration)
        tip = ao.FEModel(K, M).contact(b=b)
        hit = ao.simulate(ao.ball(radius, STEEL), tip, 1.0, law=law.within_patch(c), duration=60e-6)
        found.append(hit.peak_force)
    assert found == pytest.approx([peak, peak], rel=0.015)
    assert found[1] == pytest.approx(found[0], rel=0.01)
