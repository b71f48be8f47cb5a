"""Contact on a shell: an elastic layer in place of plate elements, against resolved contact."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
import scipy.sparse.linalg as sla
from thinmeshes import dofs, grid, matrices

import aoimpact as ao
from aoimpact import Laminate, Ply, Shell
from aoimpact.contact import layer_compliance, layer_compliance_of, mesh_compliance

STEEL = ao.Material(E=210e9, nu=0.3, rho=7800)
KINDS = pytest.mark.parametrize("kind", ["quad", "triangle"])


def test_a_slow_layer_bends_as_a_thin_plate() -> None:
    """1/(8 s √(D m)), an infinite plate's velocity under a force (C. Zener, 1941)."""
    t, s = 1e-3, 100.0
    thin = 1.0 / (8.0 * s * math.sqrt(210e9 * t**3 / (12 * 0.91) * 7800 * t))
    assert layer_compliance(STEEL, t, 3e-4, s) == pytest.approx(thin, rel=1e-3)


def test_a_thick_layer_is_a_half_space() -> None:
    """Beyond the half-space's own compliance 0.6/(a E*) hardly any is left."""
    half_space = 0.6 / (3e-4 * STEEL.plane_strain_modulus)
    assert abs(layer_compliance(STEEL, 0.2, 3e-4, 1e5)) < 0.02 * half_space


def sheet(t: float, n: int, kind: str, size: float = 0.15) -> tuple[Any, Any, Any, Any, int]:
    """Bending of a free square sheet: K, M, elements, nodes and the node in the middle."""
    nodes, cells, r, s = grid(n, n, lambda r, s: (size * (r - 0.5), size * (s - 0.5), 0 * r), kind)
    K, M = matrices(nodes, (cells, Shell(t, STEEL)))
    bent = dofs(r >= 0, [2, 3, 4])
    middle = int(np.flatnonzero((abs(r - 0.5) < 1e-9) & (abs(s - 0.5) < 1e-9))[0])
    return K[bent][:, bent], M[bent][:, bent], cells, nodes, middle


@KINDS
@pytest.mark.parametrize(
    ("t", "n"),
    [
        (2e-3, 30),
        (8e-3, 30),
        *(pytest.param(*of, marks=pytest.mark.slow) for of in ((2e-3, 60), (1e-3, 30))),
    ],
)
def test_the_mesh_about_a_contact_gives_its_excess(kind: str, t: float, n: int) -> None:
    """G of a sheet in which no wave comes back, less the layer's R: c, from the mesh nearby.

    Two plies bend as one layer does, whose motion has a closed form, if bending waves are long.
    """
    s = 3e5
    K, M, cells, nodes, node = sheet(t, n, kind)
    b = np.eye(1, K.shape[0], 3 * node)[0]
    c = float(b @ sla.spsolve((K + s * s * M).tocsc(), b)) - layer_compliance(STEEL, t, 3e-4, s)
    force, up = np.eye(len(nodes))[node], np.array([0.0, 0.0, 1.0])
    layer, plies = Shell(t, STEEL), Laminate([Ply(t / 2, STEEL)] * 2)
    found, one, two = (
        mesh_compliance(nodes, [cells], of, force, nodes[node], up, at)
        for of, at in ((layer, s), (layer, 1.0), (plies, 1.0))
    )
    assert found - layer_compliance(STEEL, t, 3e-4, s) == pytest.approx(c, rel=0.01, abs=8e-11)
    assert two == pytest.approx(one, rel=2e-6)


UNIDIRECTIONAL = ao.Orthotropic((135e9, 9e9, 9e9), (5e9, 5e9, 3.2e9), (0.3, 0.3, 0.4), rho=1550)


@KINDS
@pytest.mark.slow
@pytest.mark.parametrize("angles", [(0.0,), (30.0,), (0.0, 90.0)])
def test_a_laminate_is_meshed_as_it_is(kind: str, angles: tuple[float, ...]) -> None:
    """A wide sheet in which no wave comes back yields as its mesh about the force, from any side.

    The plies at 0 and 90 degrees stretch as they bend.
    """
    stack = Laminate([Ply(2e-3 / len(angles), UNIDIRECTIONAL, x) for x in angles], (1, 0, 0))
    nodes, cells, r, q = grid(40, 40, lambda r, s: (0.2 * (r - 0.5), 0.2 * (s - 0.5), 0 * r), kind)
    K, M = matrices(nodes, (cells, stack))
    force = ((abs(r - 0.5) < 1e-9) & (abs(q - 0.5) < 1e-9)).astype(np.float64)
    load, s = np.kron(force, np.eye(6)[2]), 2e5
    whole = float(load @ sla.spsolve((K + s * s * M).tocsc(), load))
    up = np.array([0.0, 0.0, 1.0])
    above = mesh_compliance(nodes, [cells], stack, force, np.zeros(3), up, s)
    under = mesh_compliance(nodes, [cells], stack.seen_from(top=False), force, np.zeros(3), -up, s)
    assert (above, under) == pytest.approx((whole, whole), rel=3e-3)


def test_a_laminate_of_one_material_is_a_layer_of_it() -> None:
    """Elements through the thickness against Rayleigh and Lamb, for ever narrower contacts."""
    plies = Laminate([Ply(1e-3, STEEL), Ply(1e-3, STEEL)])
    for radius in (4e-3, 5e-4, 2e-5, 2e-6):
        layer = layer_compliance(STEEL, 2e-3, radius, 2e5)
        assert layer_compliance_of(plies, radius, 2e5) == pytest.approx(layer, abs=1.5e-15 / radius)
